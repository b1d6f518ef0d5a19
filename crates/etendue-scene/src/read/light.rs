//! `[environment]` and `[[lights]]`.

use super::{
    fields::{Fields, Item},
    keys, settings,
    sky::sky,
    values::Bounds,
};
use crate::description::{EnvironmentRecord, Located, UpAxis};
use etendue::{math::DVec3, scene::DeltaLight, spectrum::Spectrum};
use std::path::PathBuf;

/// Degrees.
pub(super) const TURN: Bounds = Bounds::within(-1e6, 1e6);
/// Degrees of the whole cone, and the share of it that fades, of spots that do not say.
const SPOT: (f64, f64) = (60.0, 0.2);

#[derive(Clone, Copy)]
enum Kind {
    Constant,
    Image,
    Gradient,
    Sky,
}

/// `[environment]`.
pub fn environment(file: &Fields) -> Option<EnvironmentRecord> {
    const KINDS: [(&str, Kind); 4] =
        [("constant", Kind::Constant), ("image", Kind::Image), ("gradient", Kind::Gradient), ("sky", Kind::Sky)];
    let mut fields = settings::section(file, "environment", &keys::ENVIRONMENT)?;
    let has = |key| fields.key_origin(key).is_some();
    let default = match () {
        () if has("image") => "image",
        () if has("top") => "gradient",
        () => "constant",
    };
    let kind = fields.variant("type", &KINDS, Some(default));
    let colour = |i: Item| i.colour(Bounds::LIGHT);
    let record = kind.and_then(|kind| match kind {
        Kind::Constant => fields.need("radiance", colour).map(EnvironmentRecord::Constant),
        Kind::Image => {
            let file = fields.need("image", |i| {
                Some(Located { value: PathBuf::from(i.name_text()?), origin: i.value.origin.clone() })
            });
            let strength = fields.read("strength", colour).unwrap_or(Spectrum::ONE);
            let rotation = fields.read("rotation", |i| i.number(TURN)).unwrap_or(0.0);
            let up = up(&fields);
            Some(EnvironmentRecord::Image { file: file?, strength, rotation, up })
        }
        Kind::Gradient => {
            let top = fields.need("top", colour);
            let (horizon, bottom, up) = (fields.read("horizon", colour), fields.read("bottom", colour), up(&fields));
            let top = top?;
            let horizon = horizon.unwrap_or(top);
            Some(EnvironmentRecord::Gradient { top, horizon, bottom: bottom.unwrap_or(horizon), up })
        }
        Kind::Sky => sky(&fields),
    });
    fields.finish();
    record
}

/// The axis that points up.
pub(super) fn up(fields: &Fields) -> UpAxis {
    fields.read("up", |i| i.choice(&UpAxis::ALL.map(|axis| (axis.name(), axis)))).unwrap_or_default()
}

#[derive(Clone, Copy)]
enum LightKind {
    Point,
    Spot,
    Directional,
}

/// One of `[[lights]]`.
pub fn light(item: Item) -> Option<Located<DeltaLight>> {
    const KINDS: [(&str, LightKind); 3] =
        [("point", LightKind::Point), ("spot", LightKind::Spot), ("directional", LightKind::Directional)];
    let mut fields = item.table(&keys::LIGHT, "[[lights]]")?;
    let light = match fields.variant("type", &KINDS, Some("point")) {
        Some(LightKind::Point) => {
            let (position, intensity) = place(&fields);
            position.zip(intensity).map(|(position, intensity)| DeltaLight::Point { position, intensity })
        }
        Some(LightKind::Spot) => spot(&fields),
        Some(LightKind::Directional) => {
            let direction = fields.need("direction", |i| i.direction());
            let irradiance = fields.need("irradiance", |i| i.colour(Bounds::LIGHT));
            direction.zip(irradiance).map(|(direction, irradiance)| DeltaLight::Directional { direction, irradiance })
        }
        None => None,
    };
    let origin = fields.origin.clone();
    fields.finish();
    Some(Located { value: light?, origin })
}

fn place(fields: &Fields) -> (Option<DVec3>, Option<Spectrum>) {
    (fields.need("position", |i| i.point()), fields.need("intensity", |i| i.colour(Bounds::LIGHT)))
}

fn spot(fields: &Fields) -> Option<DeltaLight> {
    let (position, intensity) = place(fields);
    fields.exclusive("target", "direction");
    let direction = match fields.get("target") {
        None => match fields.get("direction") {
            None => {
                fields.lacks("`target` or `direction`");
                None
            }
            Some(item) => item.direction(),
        },
        Some(item) => item.point().and_then(|target| match position {
            Some(position) if target == position => {
                item.error("`target` is the light's own position", "expected another point")
            }
            position => Some(target - position?),
        }),
    };
    let angle = fields.read("angle", |i| i.number(Bounds::within(0.0, 360.0).above())).unwrap_or(SPOT.0);
    let blend = fields.read("blend", |i| i.number(Bounds::UNIT)).unwrap_or(SPOT.1);
    let (position, direction, intensity) = (position?, direction?, intensity?);
    Some(DeltaLight::Spot { position, direction, half_angle: (0.5 * angle).to_radians(), blend, intensity })
}
