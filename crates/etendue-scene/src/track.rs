//! Poses over time: what moves an object, whoever wrote it down.

mod cubic;

use etendue::{
    math::{DQuat, DVec3},
    motion::{Motion, Pose},
};
use std::sync::Arc;

/// How poses between keys are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Positions on straight lines, rotations along the chord.
    Linear,
    /// Positions on straight lines, rotations at constant speed.
    #[default]
    Slerp,
    /// Smooth curves through the keys: positions as parabolas have it, rotations after Kim, Kim and Shin 1995.
    Cubic,
}

impl Interpolation {
    /// All ways.
    pub const ALL: [Self; 3] = [Self::Linear, Self::Slerp, Self::Cubic];

    /// The name in files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Linear => "linear",
            Self::Slerp => "slerp",
            Self::Cubic => "cubic",
        }
    }
}

/// Poses of one object: `world = pose(t) * (the object's own transform)`.
#[derive(Clone, Debug, PartialEq)]
pub struct PoseTrack {
    /// Seconds of scene time, strictly ascending, finite; at least one. Shared by objects that were recorded together.
    pub times: Arc<[f64]>,
    /// One a time. Before the first and after the last the object rests there.
    pub poses: Arc<[Pose]>,
    /// What is between.
    pub interpolation: Interpolation,
    /// The point of the object, in the world as the scene file places it, that goes the straight or smooth way between keys and
    /// about which the object turns meanwhile: of a body its centre of mass, of a door its hinge. Metres.
    pub pivot: DVec3,
}

/// Largest turn between two keys of a [`Motion`] that is made of a track, radians: with keys so close together, the way of a pivot
/// at distance r from the world's origin is straight to within 8e-6 r.
const FINEST_TURN: f64 = 0.008;
/// Most keys of a motion between two keys of a track.
const MOST_BETWEEN: usize = 512;
/// Steps from key to key along what is neither straight nor a turn at constant speed.
const CURVED_STEPS: usize = 16;

impl PoseTrack {
    /// A track whose pivot is the world's origin.
    pub fn new(times: Arc<[f64]>, poses: Arc<[Pose]>, interpolation: Interpolation) -> Self {
        Self { times, poses, interpolation, pivot: DVec3::ZERO }
    }

    /// The pose at a time, seconds.
    pub fn at(&self, time: f64) -> Pose {
        let next = self.times.partition_point(|t| *t <= time);
        let (Some(before), true) = (next.checked_sub(1), next < self.times.len()) else {
            let end = if next == 0 { self.poses.first() } else { self.poses.last() };
            return end.copied().unwrap_or(Pose::IDENTITY);
        };
        let (t0, t1) = (self.times[before], self.times[next]);
        let share = (time - t0) / (t1 - t0);
        if share <= 0.0 || self.poses[before] == self.poses[next] && self.interpolation != Interpolation::Cubic {
            return self.poses[before];
        }
        let [from, to] = [before, next].map(|key| self.about_pivot(key));
        let moved = match self.interpolation {
            Interpolation::Slerp => from.between(to, share),
            Interpolation::Linear => {
                let near = if from.rotation.dot(to.rotation) < 0.0 { -to.rotation } else { to.rotation };
                let rotation = (from.rotation * (1.0 - share) + near * share).normalize();
                Pose { rotation, ..from.between(to, share) }
            }
            Interpolation::Cubic => cubic::between(self, before, time),
        };
        self.of_pivot(moved)
    }

    /// Where the pivot is at a key, as the translation.
    fn about_pivot(&self, key: usize) -> Pose {
        let Pose { rotation, translation } = self.poses[key];
        Pose { rotation, translation: self.pivot + (rotation * self.pivot - self.pivot) + translation }
    }

    /// The pose that turns the object like `moved`, and brings the pivot to its translation.
    fn of_pivot(&self, moved: Pose) -> Pose {
        let turned = moved.rotation * self.pivot - self.pivot;
        Pose { rotation: moved.rotation, translation: moved.translation - self.pivot - turned }
    }

    /// True if the object is at the same place at all times.
    pub fn is_still(&self) -> bool {
        self.poses.windows(2).all(|pair| pair[0] == pair[1])
    }

    /// The way from time `open` to time `close`, seconds, `open` <= `close`: every key between is a key of it, and more where
    /// straight lines and turns at constant speed between poses would not follow the track.
    pub fn motion(&self, open: f64, close: f64) -> Motion {
        let length = close - open;
        if length <= 0.0 {
            let pose = self.at(open);
            return Motion { keys: [(0.0, pose), (1.0, pose)].into() };
        }
        let first = self.times.partition_point(|t| *t <= open);
        let last = self.times.partition_point(|t| *t < close).max(first);
        let mut stops = Vec::with_capacity(last - first + 2);
        stops.push(open);
        stops.extend_from_slice(&self.times[first..last]);
        stops.push(close);
        let mut keys: Vec<(f64, Pose)> = vec![(0.0, self.at(open))];
        for pair in stops.windows(2) {
            let steps = self.steps(pair[0], pair[1]);
            for step in 1..=steps {
                let time =
                    if step == steps { pair[1] } else { pair[0] + (pair[1] - pair[0]) * step as f64 / steps as f64 };
                let shutter = if time >= close { 1.0 } else { (time - open) / length };
                // Keys closer than numbers can tell are one.
                if keys.last().is_some_and(|(before, _)| shutter > *before) {
                    keys.push((shutter, self.at(time)));
                }
            }
        }
        if let Some(end) = keys.last_mut() {
            end.0 = 1.0;
        }
        Motion { keys: keys.into() }
    }

    /// Into how many parts the way between two times is cut that have no key between them.
    fn steps(&self, from: f64, to: f64) -> usize {
        let (a, b) = (self.at(from), self.at(to));
        if a == b && self.interpolation != Interpolation::Cubic {
            return 1;
        }
        let curved = if self.interpolation == Interpolation::Slerp { 1 } else { CURVED_STEPS };
        if self.pivot == DVec3::ZERO {
            return curved;
        }
        let turn = turn_between(a.rotation, b.rotation);
        ((turn / FINEST_TURN) as usize + 1).clamp(curved, MOST_BETWEEN)
    }
}

/// The angle from one rotation to another, radians, in [0, pi].
pub(crate) fn turn_between(from: DQuat, to: DQuat) -> f64 {
    let to = if from.dot(to) < 0.0 { -to } else { to };
    4.0 * libm::atan2((to - from).length(), (to + from).length())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn turned(axis: DVec3, angle: f64) -> DQuat {
        let v = axis.normalize() * libm::sin(0.5 * angle);
        DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(0.5 * angle))
    }

    /// Keys of a smooth motion: a turn whose axis wanders while the pivot flies a parabola.
    fn track(interpolation: Interpolation, keys: usize) -> PoseTrack {
        let times: Vec<f64> = (0..keys).map(|i| 0.25 * i as f64).collect();
        let pose = |t: &f64| Pose {
            rotation: turned(DVec3::new(1.0, 0.3 * t, -0.2), 1.3 * t),
            translation: DVec3::new(2.0 * t, 1.0 + 3.0 * t - 4.905 * t * t, 0.0),
        };
        let poses = times.iter().map(pose).collect();
        PoseTrack { times: times.into(), poses, interpolation, pivot: DVec3::ZERO }
    }

    fn near(a: Pose, b: Pose, tolerance: f64) -> bool {
        (a.translation - b.translation).length() < tolerance && turn_between(a.rotation, b.rotation) < tolerance
    }

    #[test]
    fn keys_are_met_and_ends_rest() {
        for interpolation in Interpolation::ALL {
            let track = track(interpolation, 6);
            for (time, pose) in track.times.iter().zip(track.poses.iter()) {
                assert!(near(track.at(*time), *pose, 1e-12), "{interpolation:?} {time}");
            }
            assert_eq!(track.at(-3.0), track.poses[0]);
            assert_eq!(track.at(99.0), track.poses[5]);
            assert!(!track.is_still());
        }
    }

    #[test]
    fn a_pivot_goes_straight_while_the_object_turns_about_it() {
        let pivot = DVec3::new(10.0, -4.0, 3.0);
        let to = DVec3::new(1.0, 2.0, 3.0);
        let rotation = turned(DVec3::Z, 2.0);
        let end = Pose { rotation, translation: pivot + to - rotation * pivot };
        for interpolation in [Interpolation::Linear, Interpolation::Slerp] {
            let track =
                PoseTrack { times: [0.0, 1.0].into(), poses: [Pose::IDENTITY, end].into(), interpolation, pivot };
            let motion = track.motion(0.1, 0.9);
            for i in 0..=40 {
                let s = f64::from(i) / 40.0;
                let time = 0.1 + 0.8 * s;
                let exact = track.at(time);
                let moved = exact.rotation * pivot + exact.translation;
                assert!((moved - (pivot + to * time)).length() < 1e-13, "{interpolation:?} {time}");
                assert!(near(motion.at(s), exact, 1.2e-4), "{interpolation:?} {time}");
            }
        }
    }

    /// C1: slopes from both sides of a key agree, and a parabola is followed exactly.
    #[test]
    fn cubic_tracks_are_smooth() {
        let track = track(Interpolation::Cubic, 7);
        const H: f64 = 1e-5;
        for key in &track.times[1..6] {
            let [a, b, c] = [-H, 0.0, H].map(|d| track.at(key + d));
            let (left, right) = ((b.translation - a.translation) / H, (c.translation - b.translation) / H);
            assert!((left - right).length() < 1e-3, "{key}: {left} {right}");
            let spin = |from: Pose, to: Pose| (from.rotation.conjugate() * to.rotation).xyz() * (2.0 / H);
            assert!((spin(a, b) - spin(b, c)).length() < 1e-3, "{key}");
        }
        for i in 0..150 {
            let t = 0.01 * f64::from(i);
            let exact = DVec3::new(2.0 * t, 1.0 + 3.0 * t - 4.905 * t * t, 0.0);
            assert!((track.at(t).translation - exact).length() < 1e-12, "{t}");
            let spun = turned(DVec3::new(1.0, 0.3 * t, -0.2), 1.3 * t);
            assert!(turn_between(track.at(t).rotation, spun) < 3e-3, "{t}");
        }
    }

    #[test]
    fn motions_follow_their_track() {
        for interpolation in Interpolation::ALL {
            let track = track(interpolation, 7);
            for (open, close) in [(0.1, 1.3), (0.25, 0.5), (-1.0, 0.3), (1.4, 9.0), (0.3, 0.3)] {
                let motion = track.motion(open, close);
                let times: Vec<f64> = motion.keys.iter().map(|(t, _)| *t).collect();
                assert!(times[0] == 0.0 && *times.last().unwrap() == 1.0, "{times:?}");
                assert!(times.windows(2).all(|pair| pair[0] < pair[1]), "{times:?}");
                for i in 0..=100 {
                    let s = f64::from(i) / 100.0;
                    let exact = track.at(open + (close - open) * s);
                    let close_enough = if interpolation == Interpolation::Slerp { 1e-9 } else { 4e-4 };
                    assert!(near(motion.at(s), exact, close_enough), "{interpolation:?} {open} {close} {s}");
                }
            }
        }
    }
}
