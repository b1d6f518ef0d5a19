//! Rigid motion within the time that a shutter is open.

use crate::math::{DAffine3, DQuat, DVec3};
use std::sync::Arc;

/// A rotation about the origin, then a shift.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// A unit quaternion.
    pub rotation: DQuat,
    /// Metres.
    pub translation: DVec3,
}

impl Pose {
    /// No motion.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// The map of points.
    pub fn to_affine(self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.rotation, self.translation)
    }

    /// The pose at share `s` of the way from `self` to `to`: the shift straight, the rotation at constant speed about one axis
    /// by at most half a turn (Shoemake, "Animating rotation with quaternion curves", 1985). At 0 and 1 the ends themselves.
    pub fn between(self, to: Self, s: f64) -> Self {
        match s {
            ..=0.0 => self,
            1.0.. => to,
            s => Self {
                rotation: slerp(self.rotation, to.rotation, s),
                translation: self.translation + (to.translation - self.translation) * s,
            },
        }
    }
}

/// The shorter way along the great circle. Halves of the angle are taken from chords, which have it precisely where it is small.
fn slerp(from: DQuat, to: DQuat, s: f64) -> DQuat {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    let angle = 2.0 * libm::atan2((to - from).length(), (to + from).length());
    let sin = libm::sin(angle);
    if sin <= 0.0 {
        return from;
    }
    let mixed = from * (libm::sin((1.0 - s) * angle) / sin) + to * (libm::sin(s * angle) / sin);
    mixed.normalize()
}

/// Poses of something while the shutter is open: `world = pose(time) * placed`, where `placed` is where it would be without motion.
#[derive(Clone, Debug, PartialEq)]
pub struct Motion {
    /// Shutter times in [0, 1], strictly ascending, the first 0 and the last 1, each with its pose; [`Pose::between`] joins them.
    pub keys: Arc<[(f64, Pose)]>,
}

impl Motion {
    /// The pose at a shutter time in [0, 1].
    pub fn at(&self, time: f64) -> Pose {
        let next = self.keys.partition_point(|(t, _)| *t <= time);
        match (next.checked_sub(1).and_then(|i| self.keys.get(i)), self.keys.get(next)) {
            (Some(&(t0, a)), Some(&(t1, b))) => a.between(b, (time - t0) / (t1 - t0)),
            (Some(&(_, pose)), None) | (None, Some(&(_, pose))) => pose,
            (None, None) => Pose::IDENTITY,
        }
    }

    /// True if all poses are equal.
    pub fn is_still(&self) -> bool {
        self.keys.windows(2).all(|pair| pair[0].1 == pair[1].1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn turns_at_constant_speed() {
        let turned = |angle: f64| DQuat::from_xyzw(0.0, 0.0, libm::sin(0.5 * angle), libm::cos(0.5 * angle));
        let end = Pose { rotation: turned(3.0), translation: DVec3::new(2.0, 0.0, -4.0) };
        let motion = Motion { keys: [(0.0, Pose::IDENTITY), (0.5, end), (1.0, end)].into() };
        for time in [0.0, 0.1, 0.25, 0.4, 0.5, 0.7, 1.0] {
            let (pose, s) = (motion.at(time), f64::min(2.0 * time, 1.0));
            assert!((pose.rotation - turned(3.0 * s)).length() < 1e-15, "{time}");
            assert!((pose.translation - end.translation * s).length() < 1e-15, "{time}");
        }
        assert!(!motion.is_still());
        assert!(Motion { keys: [(0.0, end), (1.0, end)].into() }.is_still());
    }

    #[test]
    fn the_shorter_way_and_no_way() {
        let q = DQuat::from_xyzw(0.0, 0.6, 0.0, 0.8);
        let pose = |rotation| Pose { rotation, translation: DVec3::ZERO };
        assert_eq!(pose(q).between(pose(-q), 0.5).rotation, q);
        assert_eq!(pose(q).between(pose(q), 0.3).rotation, q);
    }
}
