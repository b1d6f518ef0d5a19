//! Where the sun is seen from a place on Earth: Meeus, "Astronomical Algorithms", 1998, chapters 7, 12, 13 and 25 (low
//! accuracy, 0.01 degrees between the years 1800 and 2200), and refraction as in the solar calculator of NOAA.

use crate::read::sin_cos_degrees;

/// Years of the Gregorian calendar that a [`Moment`] may have.
pub const YEARS: std::ops::RangeInclusive<i32> = 1600..=2400;

/// A moment in universal time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Days and their fractions since noon of the first of January 4713 before Christ.
    julian_day: f64,
}

impl Moment {
    /// A date of the Gregorian calendar (year within [`YEARS`], month and day from 1) and `seconds` since midnight
    /// of universal time, any number. `None` if there is no such date.
    pub fn new([year, month, day]: [i32; 3], seconds: f64) -> Option<Self> {
        let leap = (year % 4 == 0 && year % 100 != 0) || year % 400 == 0;
        let days = match month {
            2 => 28 + i32::from(leap),
            4 | 6 | 9 | 11 => 30,
            1..=12 => 31,
            _ => return None,
        };
        if !YEARS.contains(&year) || !(1..=days).contains(&day) {
            return None;
        }
        // The year begins in March.
        let (y, m) = if month > 2 { (year, month) } else { (year - 1, month + 12) };
        let gregorian = 2 - y / 100 + y / 400;
        let whole = 1461 * (y + 4716) / 4 + 153 * (m + 1) / 5 + day + gregorian;
        Some(Self { julian_day: f64::from(whole) - 1524.5 + seconds / 86_400.0 })
    }
}

/// Elevation above the horizon, raised by refraction, and azimuth clockwise from north, degrees, at a latitude (north) and
/// longitude (east) in degrees.
pub fn sun_position(moment: Moment, latitude: f64, longitude: f64) -> (f64, f64) {
    let days = moment.julian_day - 2_451_545.0;
    let centuries = days / 36_525.0;
    let (right_ascension, declination) = sun(centuries);
    let sidereal = 280.460_618_37 + 360.985_647_366_29 * days + 0.000_387_933 * centuries * centuries;
    let hour_angle = (sidereal + longitude - right_ascension) % 360.0;
    let (sin_hour, cos_hour) = sin_cos_degrees(hour_angle);
    let (sin_latitude, cos_latitude) = sin_cos_degrees(latitude);
    let (sin_declination, cos_declination) = sin_cos_degrees(declination);
    let height = sin_latitude * sin_declination + cos_latitude * cos_declination * cos_hour;
    let east = -cos_declination * sin_hour;
    let north = sin_declination * cos_latitude - cos_declination * sin_latitude * cos_hour;
    let elevation = libm::asin(height.clamp(-1.0, 1.0)).to_degrees();
    let azimuth = libm::atan2(east, north).to_degrees();
    (elevation + refraction(elevation), if azimuth < 0.0 { azimuth + 360.0 } else { azimuth })
}

/// Apparent right ascension and declination, degrees, at julian centuries since the year 2000.
fn sun(t: f64) -> (f64, f64) {
    let mean_longitude = 280.466_46 + 36_000.769_83 * t + 0.000_303_2 * t * t;
    let anomaly = 357.529_11 + 35_999.050_29 * t - 0.000_153_7 * t * t;
    let sine = |angle: f64| sin_cos_degrees(angle).0;
    let center = (1.914_602 - 0.004_817 * t - 0.000_014 * t * t) * sine(anomaly)
        + (0.019_993 - 0.000_101 * t) * sine(2.0 * anomaly)
        + 0.000_289 * sine(3.0 * anomaly);
    let node = 125.04 - 1934.136 * t;
    let longitude = mean_longitude + center - 0.005_69 - 0.004_78 * sine(node);
    let mean_obliquity = 23.439_291_1 - 0.013_004_17 * t - 1.64e-7 * t * t + 5.04e-7 * t * t * t;
    let obliquity = mean_obliquity + 0.002_56 * sin_cos_degrees(node).1;
    let (sin_longitude, cos_longitude) = sin_cos_degrees(longitude);
    let (sin_obliquity, cos_obliquity) = sin_cos_degrees(obliquity);
    let right_ascension = libm::atan2(cos_obliquity * sin_longitude, cos_longitude).to_degrees();
    (right_ascension, libm::asin(sin_obliquity * sin_longitude).to_degrees())
}

/// By how much the air raises what is at a true elevation, degrees.
fn refraction(elevation: f64) -> f64 {
    let tangent = || {
        let (sin, cos) = sin_cos_degrees(elevation);
        sin / cos
    };
    let seconds = match elevation {
        e if e > 85.0 => 0.0,
        e if e > 5.0 => {
            let cotangent = 1.0 / tangent();
            let cube = cotangent * cotangent * cotangent;
            58.1 * cotangent - 0.07 * cube + 0.000_086 * cube * cotangent * cotangent
        }
        e if e > -0.575 => 1735.0 + e * (-518.2 + e * (103.4 + e * (-12.79 + e * 0.711))),
        e if e > -89.0 => -20.774 / tangent(),
        _ => 0.0,
    };
    seconds / 3600.0
}

#[cfg(test)]
mod tests {
    use super::*;

    fn moment(date: [i32; 3], [hour, minute, second]: [f64; 3]) -> Moment {
        Moment::new(date, hour * 3600.0 + minute * 60.0 + second).unwrap()
    }

    /// Meeus, examples 7.a and table in chapter 7.
    #[test]
    fn julian_days() {
        for (date, hours, expected) in [
            ([1957, 10, 4], 0.81 * 24.0, 2_436_116.31),
            ([2000, 1, 1], 12.0, 2_451_545.0),
            ([1999, 1, 1], 0.0, 2_451_179.5),
            ([1987, 6, 19], 12.0, 2_446_966.0),
            ([1988, 1, 27], 0.0, 2_447_187.5),
            ([1900, 1, 1], 0.0, 2_415_020.5),
            ([1600, 12, 31], 0.0, 2_305_812.5),
        ] {
            assert!((moment(date, [hours, 0.0, 0.0]).julian_day - expected).abs() < 1e-6, "{date:?}");
        }
        for no_date in
            [[2023, 2, 29], [1900, 2, 29], [2024, 4, 31], [2024, 13, 1], [2024, 0, 1], [2024, 1, 0], [99999, 1, 1]]
        {
            assert_eq!(Moment::new(no_date, 0.0), None, "{no_date:?}");
        }
        assert!(Moment::new([2000, 2, 29], 0.0).is_some() && Moment::new([i32::MIN, i32::MAX, 1], 0.0).is_none());
    }

    /// Meeus, example 25.a: 1992 October 13, 0 h.
    #[test]
    fn the_sun_among_the_stars() {
        let t = (moment([1992, 10, 13], [0.0; 3]).julian_day - 2_451_545.0) / 36_525.0;
        let (right_ascension, declination) = sun(t);
        assert!((right_ascension.rem_euclid(360.0) - 198.380_83).abs() < 1e-3, "{right_ascension}");
        assert!((declination + 7.785_07).abs() < 1e-3, "{declination}");
    }

    /// Reda and Andreas, "Solar Position Algorithm for Solar Radiation Applications", NREL 2003, example in appendix A.5:
    /// 17 October 2003, 12:30:30 in the zone UTC-7, 39.742476 N 105.1786 W: zenith angle 50.11162, azimuth 194.34024.
    #[test]
    fn the_example_of_nrel() {
        let (elevation, azimuth) = sun_position(moment([2003, 10, 17], [19.0, 30.0, 30.0]), 39.742_476, -105.1786);
        assert!((elevation - (90.0 - 50.111_62)).abs() < 0.02, "{elevation}");
        assert!((azimuth - 194.340_24).abs() < 0.02, "{azimuth}");
    }

    /// Solstices and equinoxes (Astronomical Almanac): 20 June 2024, 20:51 and 20 March 2024, 03:06 universal time.
    #[test]
    fn solstice_and_equinox() {
        // Straight above the tropic at noon: the longitude where the sun culminates.
        let solstice = moment([2024, 6, 20], [20.0, 51.0, 0.0]);
        let culmination = (-180..180).map(f64::from).map(|l| sun_position(solstice, 23.44, l).0).fold(-90.0, f64::max);
        assert!((culmination - 90.0).abs() < 0.5, "{culmination}");
        let (elevation, _) = sun_position(moment([2024, 3, 20], [3.0, 6.0, 0.0]), 90.0, 0.0);
        // At the pole on the horizon, but for refraction, 0.48 degrees.
        assert!((elevation - 0.48).abs() < 0.02, "{elevation}");
        let (elevation, azimuth) = sun_position(moment([2024, 3, 20], [12.0, 7.5, 0.0]), 51.5, 0.0);
        assert!((azimuth - 180.0).abs() < 0.2 && (elevation - 38.64).abs() < 0.1, "{elevation} {azimuth}");
        assert!(sun_position(moment([2024, 3, 20], [8.0, 0.0, 0.0]), 51.5, 0.0).1 < 180.0);
    }

    #[test]
    fn refraction_is_continuous_and_finite() {
        for degrees in -900..=900 {
            let e = f64::from(degrees) * 0.1;
            let (below, above) = (refraction(e - 1e-6), refraction(e + 1e-6));
            assert!((below - above).abs() < 0.02, "{e}: {below} {above}");
        }
        assert!((refraction(0.0) - 0.48).abs() < 0.01);
    }
}
