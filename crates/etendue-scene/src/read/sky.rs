//! `[environment]` of type `sky`.

use super::{
    fields::{Fields, Item},
    light::{TURN, up},
    values::Bounds,
};
use crate::{
    description::{EnvironmentRecord, SkyRecord, SunRecord, UpAxis},
    sun_position::{Moment, YEARS},
    value::Data,
};
use etendue::{light::atmosphere::TURBIDITY, math::DVec3, spectrum::Spectrum};

/// Latitudes and elevations, longitudes, time zones, the sun's radius.
pub const LATITUDES: Bounds = Bounds::within(-90.0, 90.0);
pub const LONGITUDES: Bounds = Bounds::within(-180.0, 180.0);
pub const ZONES: Bounds = Bounds::within(-24.0, 24.0);
pub const SUN_SIZES: Bounds = Bounds::within(0.01, 90.0);
pub const TURBIDITIES: Bounds = Bounds::within(*TURBIDITY.start(), *TURBIDITY.end());
/// What skies that do not say have.
const ELEVATION: f64 = 45.0;
const AZIMUTH: f64 = 180.0;
const CLEAR: f64 = 3.0;
const SUN_SIZE: f64 = 0.2666;
const GROUND: f32 = 0.2;

/// The keys of each way to place the sun, the first of which chooses it.
const WAYS: [&[&str]; 3] =
    [&["sun"], &["elevation", "azimuth"], &["date", "time", "utc_offset", "latitude", "longitude"]];

pub fn sky(fields: &Fields) -> Option<EnvironmentRecord> {
    let up = up(fields);
    let north = fields.read("north", |i| north(i, up));
    let turbidity = fields.read("turbidity", |i| i.number(TURBIDITIES)).unwrap_or(CLEAR);
    let ground = fields.read("ground", |i| i.colour(Bounds::UNIT)).unwrap_or(Spectrum::splat(GROUND));
    let strength = fields.read("strength", |i| i.colour(Bounds::LIGHT)).unwrap_or(Spectrum::ONE);
    let sun_size = fields.read("sun_size", |i| i.number(SUN_SIZES)).unwrap_or(SUN_SIZE);
    let sun_disk = fields.read("sun_disk", |i| i.boolean()).unwrap_or(true);
    let sun = sun(fields)?;
    let origin = fields.origin.clone();
    Some(EnvironmentRecord::Sky(SkyRecord { sun, up, north, turbidity, ground, strength, sun_size, sun_disk, origin }))
}

fn north(item: Item, up: UpAxis) -> Option<DVec3> {
    let north = item.direction()?;
    if up.direction().cross(north.normalize()).length() < 1e-6 {
        return item.error("`north` points up or down", format!("expected a direction across {}", up.name()));
    }
    Some(north)
}

fn sun(fields: &Fields) -> Option<SunRecord> {
    for (i, way) in WAYS.iter().enumerate() {
        WAYS[i + 1..].iter().for_each(|other| fields.exclusive(way[0], other[0]));
    }
    let direction = fields.read("sun", |i| i.direction());
    let elevation = fields.read("elevation", |i| i.number(LATITUDES));
    let azimuth = fields.read("azimuth", |i| i.number(TURN)).unwrap_or(AZIMUTH);
    let moment = moment(fields);
    let has = |key| fields.key_origin(key).is_some();
    if let Some(key) = WAYS[2][1..].iter().find(|key| has(key) && !has("date")) {
        fields.lacks(&format!("`date` for its `{key}`"));
    }
    match () {
        () if has("date") => moment,
        () if has("sun") => direction.map(SunRecord::Direction),
        () if has("elevation") => elevation.map(|elevation| SunRecord::Angles { elevation, azimuth }),
        () => Some(SunRecord::Angles { elevation: ELEVATION, azimuth }),
    }
}

fn moment(fields: &Fields) -> Option<SunRecord> {
    let offset = fields.read("utc_offset", |i| i.number(ZONES));
    let latitude = fields.read("latitude", |i| i.number(LATITUDES));
    let longitude = fields.read("longitude", |i| i.number(LONGITUDES));
    let time = fields.read("time", |i| {
        let seconds = written(i, "\"14:30\"")?.parse_time();
        seconds.or_else(|| i.error("`time` is not a time of day", "expected hours and minutes such as \"14:30\""))
    });
    let item = fields.get("date")?;
    for (key, value) in [("latitude", latitude), ("longitude", longitude)] {
        if value.is_none() && fields.key_origin(key).is_none() {
            fields.lacks(&format!("`{key}` for its `date`"));
        }
    }
    let date = written(item, "\"2024-06-21\"")?;
    let Some(date) = date.parse_date() else {
        return item.error("`date` is not a date", "expected year, month and day such as \"2024-06-21\"");
    };
    let noon = 43_200.0;
    let seconds = if fields.key_origin("time").is_some() { time? } else { noon } - 3600.0 * offset.unwrap_or(0.0);
    let Some(moment) = Moment::new(date, seconds) else {
        let years = format!("expected a day of the years {} to {}", YEARS.start(), YEARS.end());
        return item.error("`date` is not in the calendar", years);
    };
    Some(SunRecord::Moment { moment, latitude: latitude?, longitude: longitude? })
}

/// The text of a date or a time, with or without quotation marks.
struct Written<'a>(&'a str);

fn written<'a>(item: Item<'a>, example: &str) -> Option<Written<'a>> {
    match &item.value.data {
        Data::String(text) | Data::Moment(text) => Some(Written(text)),
        _ => item.wrong_kind_help("a date or time", example),
    }
}

impl Written<'_> {
    fn parse_date(&self) -> Option<[i32; 3]> {
        let parts: Vec<i32> = self.0.split('-').map(digits).collect::<Option<_>>()?;
        parts.try_into().ok()
    }

    /// Seconds since midnight.
    fn parse_time(&self) -> Option<f64> {
        let parts: Vec<&str> = self.0.split(':').collect();
        let (whole, fraction) = parts.get(2).map_or(("0", "0"), |s| s.split_once('.').unwrap_or((s, "0")));
        let (hour, minute, second) = (digits(parts.first()?)?, digits(parts.get(1)?)?, digits(whole)?);
        digits(fraction.get(..fraction.len().min(6))?)?;
        let fraction: f64 = format!("0.{fraction}").parse().ok()?;
        let is_time = parts.len() <= 3 && hour <= 24 && minute <= 59 && second <= 60;
        is_time.then(|| f64::from(hour * 3600 + minute * 60 + second) + fraction)
    }
}

/// A number of at most six digits.
fn digits(text: &str) -> Option<i32> {
    let good = (1..=6).contains(&text.len()) && text.bytes().all(|b| b.is_ascii_digit());
    if good { text.parse().ok() } else { None }
}
