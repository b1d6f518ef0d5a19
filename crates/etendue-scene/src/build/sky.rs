//! From a sky of `[environment]` to the sun's direction.

use crate::{
    Diagnostic, Diagnostics,
    description::{SkyRecord, SunRecord, UpAxis},
    read::sin_cos_degrees,
    sun_position::sun_position,
};
use etendue::{light::atmosphere::Atmosphere, math::DVec3, scene::Environment};

/// Elevation of the sun's middle, degrees, when nothing of it is left, and when twilight ends.
const SUNSET: f64 = -0.2666;
const NIGHT: f64 = -18.0;

pub fn sky(record: &SkyRecord, findings: &mut Diagnostics) -> Environment {
    let up = record.up.direction();
    let sun = direction(record);
    let elevation = libm::asin(sun.dot(up).clamp(-1.0, 1.0)).to_degrees();
    if elevation < NIGHT {
        let message = format!("the sun is {:.1} degrees below the horizon: the sky is dark", -elevation);
        findings.push(Diagnostic::warning(message).at(record.origin.clone()));
    } else if elevation < SUNSET {
        let message = format!("the sun is {:.1} degrees below the horizon: the only light is twilight", -elevation);
        findings.push(Diagnostic::note(message).at(record.origin.clone()));
    }
    Environment::Sky {
        sun,
        up,
        atmosphere: Atmosphere { turbidity: record.turbidity, ground: record.ground },
        strength: record.strength,
        sun_radius: record.sun_size.to_radians(),
        sun_disk: record.sun_disk,
    }
}

/// Towards the sun, unit length.
fn direction(record: &SkyRecord) -> DVec3 {
    let (elevation, azimuth) = match record.sun {
        SunRecord::Direction(direction) => return direction.normalize(),
        SunRecord::Angles { elevation, azimuth } => (elevation, azimuth),
        SunRecord::Moment { moment, latitude, longitude } => sun_position(moment, latitude, longitude),
    };
    let up = record.up.direction();
    let north = record.north.unwrap_or(match record.up {
        UpAxis::Y => DVec3::NEG_Z,
        UpAxis::Z => DVec3::Y,
    });
    let north = north.normalize();
    let north = (north - up * north.dot(up)).normalize();
    let east = north.cross(up);
    let ((sin_elevation, cos_elevation), (sin, cos)) = (sin_cos_degrees(elevation), sin_cos_degrees(azimuth));
    up * sin_elevation + (north * cos + east * sin) * cos_elevation
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SourceMap, Span};
    use etendue::spectrum::Spectrum;

    fn record(sun: SunRecord, up: UpAxis, north: Option<DVec3>) -> SkyRecord {
        let file = SourceMap::new().insert("s.toml", Vec::new()).unwrap();
        let (ground, strength, origin) = (Spectrum::ONE, Spectrum::ONE, Span::new(file, 0..0).into());
        SkyRecord { sun, up, north, turbidity: 2.0, ground, strength, sun_size: 0.3, sun_disk: true, origin }
    }

    #[test]
    fn compass() {
        let at = |azimuth, up, north| {
            direction(&record(SunRecord::Angles { elevation: 0.0, azimuth }, up, north)) + DVec3::ZERO
        };
        assert_eq!([0.0, 90.0, 180.0].map(|a| at(a, UpAxis::Y, None)), [DVec3::NEG_Z, DVec3::X, DVec3::Z]);
        assert_eq!([0.0, 90.0, 270.0].map(|a| at(a, UpAxis::Z, None)), [DVec3::Y, DVec3::X, DVec3::NEG_X]);
        // North is laid into the plane.
        let north = Some(DVec3::new(3.0, 7.0, 0.0));
        assert_eq!([0.0, 90.0].map(|a| at(a, UpAxis::Y, north)), [DVec3::X, DVec3::Z]);
        let high = direction(&record(SunRecord::Angles { elevation: 90.0, azimuth: 33.0 }, UpAxis::Z, None));
        assert_eq!(high + DVec3::ZERO, DVec3::Z);
    }

    #[test]
    fn a_sun_below_the_horizon_is_said() {
        for (elevation, said) in [(0.0, 0), (-5.0, 1), (-40.0, 1)] {
            let mut findings = Diagnostics::default();
            sky(&record(SunRecord::Angles { elevation, azimuth: 0.0 }, UpAxis::Y, None), &mut findings);
            assert_eq!(findings.iter().count(), said, "{elevation}");
        }
    }
}
