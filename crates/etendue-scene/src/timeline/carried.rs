//! Ways of lights without extent.

use etendue::{
    math::{DQuat, DVec3},
    motion::{Motion, Pose},
    scene::DeltaLight,
};

/// The motion that takes `light` along where it is at shares of the shutter's time, and the light where that begins: all but its place and
/// direction stays. `None` if it rests where it is.
pub fn carry(light: &mut DeltaLight, ways: impl Iterator<Item = (f64, DeltaLight)>) -> Option<Motion> {
    let (position, direction) = place(light);
    let ways: Vec<(f64, (DVec3, DVec3))> = ways.map(|(share, light)| (share, place(&light))).collect();
    let (_, (_, mut heading)) = *ways.first()?;
    if ways.iter().all(|(_, place)| *place == (position, direction)) {
        return None;
    }
    set_place(light, DVec3::ZERO, heading);
    let mut rotation = DQuat::IDENTITY;
    let keys = ways.into_iter().map(|(share, (translation, next))| {
        rotation = (arc(heading, next) * rotation).normalize();
        heading = next;
        (share, Pose { rotation, translation })
    });
    Some(Motion { keys: keys.collect() })
}

/// Position and unit direction; what has none of them does not change it.
fn place(light: &DeltaLight) -> (DVec3, DVec3) {
    match *light {
        DeltaLight::Point { position, .. } => (position, DVec3::Y),
        DeltaLight::Spot { position, direction, .. } => (position, direction.normalize_or_zero()),
        DeltaLight::Directional { direction, .. } => (DVec3::ZERO, direction.normalize_or_zero()),
    }
}

fn set_place(light: &mut DeltaLight, to: DVec3, heading: DVec3) {
    if let DeltaLight::Point { position, .. } | DeltaLight::Spot { position, .. } = light {
        *position = to;
    }
    if let DeltaLight::Spot { direction, .. } | DeltaLight::Directional { direction, .. } = light {
        *direction = heading;
    }
}

/// The shortest turn from one unit vector to another.
fn arc(from: DVec3, to: DVec3) -> DQuat {
    let (axis, cosine) = (from.cross(to), from.dot(to));
    if from == to {
        return DQuat::IDENTITY;
    }
    let turn = DQuat::from_xyzw(axis.x, axis.y, axis.z, 1.0 + cosine);
    match turn.length_squared() > 1e-20 {
        true => turn.normalize(),
        false => {
            let side = from.any_orthonormal_vector();
            DQuat::from_xyzw(side.x, side.y, side.z, 0.0)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::spectrum::Spectrum;

    #[test]
    fn places_are_met() {
        let spot = |position, direction: DVec3| DeltaLight::Spot {
            position,
            direction,
            half_angle: 0.5,
            blend: 0.1,
            intensity: Spectrum::ONE,
        };
        let at = |share: f64| {
            let (sin, cos) = libm::sincos(3.0 * share);
            spot(DVec3::new(100.0, 3.0 * share, -share * share), DVec3::new(cos, 0.3, sin))
        };
        let mut light = at(0.7);
        let motion = carry(&mut light, [0.0, 0.3, 0.6, 1.0].map(|share| (share, at(share))).into_iter()).unwrap();
        let (start, heading) = place(&light);
        for (share, pose) in motion.keys.iter() {
            let (position, direction) = place(&at(*share));
            assert!((pose.rotation * start + pose.translation - position).length() < 1e-12, "{share}");
            assert!((pose.rotation * heading - direction).length() < 1e-12, "{share}");
        }
        // Straight between them, although it turns.
        let between = motion.at(0.8);
        let expected = DVec3::new(100.0, 2.4, -0.5 * (0.36 + 1.0));
        assert!((between.rotation * start + between.translation - expected).length() < 1e-12);
        let mut still = at(0.5);
        assert_eq!(carry(&mut still, [(0.0, at(0.5)), (1.0, at(0.5))].into_iter()), None);
        assert!((arc(DVec3::X, -DVec3::X) * DVec3::X + DVec3::X).length() < 1e-15);
    }
}
