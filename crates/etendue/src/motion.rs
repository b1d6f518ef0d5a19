//! Rigid motion within the time that a shutter is open.

use crate::math::{DAffine3, DQuat, DVec3};
use etendue_accel::RigidKey;
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

    /// A rest at one pose.
    pub fn resting(pose: Pose) -> Self {
        Self { keys: [(0.0, pose), (1.0, pose)].into() }
    }

    /// True if all poses are equal.
    pub fn is_still(&self) -> bool {
        self.keys.windows(2).all(|pair| pair[0].1 == pair[1].1)
    }

    /// What is wrong with the keys.
    pub(crate) fn check(&self) -> Result<(), &'static str> {
        let (first, last) = match &*self.keys {
            [] => return Err("has no keys"),
            [only] => (only.0, only.0),
            [first, .., last] => (first.0, last.0),
        };
        let ascending = self.keys.windows(2).all(|pair| pair[0].0 < pair[1].0);
        if !(first == 0.0 && (last == 1.0 || self.keys.len() == 1) && ascending) {
            return Err("has times that do not ascend from 0 to 1");
        }
        let fine = |(_, pose): &(f64, Pose)| {
            pose.translation.is_finite() && (pose.rotation.length_squared() - 1.0).abs() < 1e-6
        };
        if self.keys.iter().all(fine) {
            Ok(())
        } else {
            Err("has a pose that is not finite, or a rotation that is no unit")
        }
    }

    /// The pose of what does not move.
    pub(crate) fn rest(&self) -> Option<Pose> {
        self.keys.first().filter(|_| self.is_still()).map(|(_, pose)| *pose)
    }

    /// What rays follow: `world - center = pose(time) * base - center`. `None` where numbers are out of range.
    pub(crate) fn about(&self, base: DAffine3, center: DVec3) -> Option<etendue_accel::Motion> {
        let key = |(time, pose): &(f64, Pose)| RigidKey {
            time: *time,
            rotation: pose.rotation.to_array(),
            translation: (pose.translation - center).to_array(),
        };
        let [x, y, z] = [base.matrix3.x_axis, base.matrix3.y_axis, base.matrix3.z_axis];
        let rows = [0, 1, 2].map(|r| [x[r], y[r], z[r], base.translation[r]]);
        etendue_accel::Motion::new(rows, &self.keys.iter().map(key).collect::<Vec<_>>())
    }
}

/// How far the shutter is open while it is: paths' times are drawn in proportion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Shutter {
    /// Open all the while.
    #[default]
    Box,
    /// Opens until the middle, then closes.
    Triangle,
    /// Opens at even speed for a share of the time and closes for another; together at most 1.
    Trapezoid {
        /// Share of the time in which it opens, in [0, 1].
        rise: f64,
        /// Share of the time in which it closes, in [0, 1].
        fall: f64,
    },
}

impl Shutter {
    /// Shares in which it opens and closes.
    pub fn shares(self) -> [f64; 2] {
        match self {
            Self::Box => [0.0; 2],
            Self::Triangle => [0.5; 2],
            Self::Trapezoid { rise, fall } => [rise, fall],
        }
    }

    /// True if the shares are such.
    pub fn is_possible(self) -> bool {
        let [rise, fall] = self.shares();
        rise >= 0.0 && fall >= 0.0 && rise + fall <= 1.0
    }

    /// The time in [0, 1] up to which share `u` in [0, 1) of the light comes in.
    #[inline]
    pub fn time(self, u: f32) -> f32 {
        if self == Self::Box {
            return u;
        }
        let [rise, fall] = self.shares().map(|share| share as f32);
        let all = 1.0 - 0.5 * (rise + fall);
        let light = u * all;
        let left = all - light;
        let time = if light < 0.5 * rise {
            (2.0 * rise * light).sqrt()
        } else if left < 0.5 * fall {
            1.0 - (2.0 * fall * left).sqrt()
        } else {
            0.5 * rise + light
        };
        time.clamp(0.0, 1.0)
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
    fn shutters_let_in_light_in_proportion() {
        for shutter in [
            Shutter::Box,
            Shutter::Triangle,
            Shutter::Trapezoid { rise: 0.2, fall: 0.5 },
            Shutter::Trapezoid { rise: 0.0, fall: 1.0 },
            Shutter::Trapezoid { rise: 0.25, fall: 0.0 },
        ] {
            let [rise, fall] = shutter.shares();
            let open = |t: f64| f64::min(1.0, f64::min(t / rise.max(1e-30), (1.0 - t) / fall.max(1e-30)));
            let steps = 200_000;
            let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
            let all: f64 = (0..steps).map(|i| open(middle(i))).sum();
            let (mut sum, mut i) = (0.0, 0);
            for k in 0..=100_u32 {
                let time = f64::from(shutter.time(k as f32 / 100.0));
                while i < steps && middle(i) < time {
                    sum += open(middle(i));
                    i += 1;
                }
                assert!((sum / all - f64::from(k) / 100.0).abs() < 1e-4, "{shutter:?} {k}: {time}");
            }
            assert!(shutter.is_possible());
        }
        assert!(!Shutter::Trapezoid { rise: 0.6, fall: 0.6 }.is_possible());
        assert!(!Shutter::Trapezoid { rise: f64::NAN, fall: 0.0 }.is_possible());
    }

    #[test]
    fn the_shorter_way_and_no_way() {
        let q = DQuat::from_xyzw(0.0, 0.6, 0.0, 0.8);
        let pose = |rotation| Pose { rotation, translation: DVec3::ZERO };
        assert_eq!(pose(q).between(pose(-q), 0.5).rotation, q);
        assert_eq!(pose(q).between(pose(q), 0.3).rotation, q);
    }
}
