//! What a scene file says about time.

use crate::{
    Origin,
    curve::Curve,
    description::Located,
    read::Part,
    track::{Interpolation, PoseTrack},
    value::Entry,
};
use etendue::{
    math::{DMat3, DQuat, DVec3},
    motion::{Pose, Shutter},
};
use std::{collections::BTreeMap, fmt, path::PathBuf, str::FromStr, sync::Arc};

/// `[animation]`.
#[derive(Clone, Debug, PartialEq)]
pub struct AnimationRecord {
    /// Scene time of frame 0, seconds.
    pub start: f64,
    /// Scene seconds for each second of film; above 0.
    pub speed: f64,
    /// Frames of a second of film.
    pub fps: FrameRate,
    /// How long it is.
    pub length: Option<LengthRecord>,
    /// Opening and closing of the shutter, fractions of the frame interval from the frame's time.
    pub shutter: [f64; 2],
    /// How much light passes while the shutter is open.
    pub curve: Shutter,
    /// Poses from a file.
    pub keyframes: Option<KeyframesRecord>,
}

impl Default for AnimationRecord {
    fn default() -> Self {
        Self {
            start: 0.0,
            speed: 1.0,
            fps: FrameRate::default(),
            length: None,
            shutter: [0.0; 2],
            curve: Shutter::Box,
            keyframes: None,
        }
    }
}

/// How long an animation is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LengthRecord {
    /// Frames, at least 1.
    Frames(u32),
    /// Seconds of scene time, above 0.
    Duration(f64),
}

/// Frames of a second, a fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRate {
    /// Above 0.
    pub numerator: u32,
    /// Above 0.
    pub denominator: u32,
}

impl FrameRate {
    /// Fewest and most frames a second.
    pub const RANGE: (f64, f64) = (0.01, 10_000.0);

    /// Frames a second.
    pub fn per_second(self) -> f64 {
        f64::from(self.numerator) / f64::from(self.denominator)
    }

    /// The rate that a number means, to a thousandth.
    pub fn of_number(fps: f64) -> Option<Self> {
        let is_rate = fps >= Self::RANGE.0 && fps <= Self::RANGE.1;
        is_rate.then(|| Self { numerator: libm::round(fps * 1000.0) as u32, denominator: 1000 }.reduced())
    }

    fn reduced(self) -> Self {
        let (mut a, mut b) = (self.numerator, self.denominator);
        while b != 0 {
            (a, b) = (b, a % b);
        }
        Self { numerator: self.numerator / a.max(1), denominator: self.denominator / a.max(1) }
    }
}

impl Default for FrameRate {
    fn default() -> Self {
        Self { numerator: 25, denominator: 1 }
    }
}

impl FromStr for FrameRate {
    type Err = String;

    /// `25`, `29.97`, `30000/1001`.
    fn from_str(text: &str) -> Result<Self, String> {
        let rate = match text.split_once('/') {
            None => text.trim().parse().ok().and_then(Self::of_number),
            Some((numerator, denominator)) => match (numerator.trim().parse(), denominator.trim().parse()) {
                (Ok(numerator), Ok(denominator)) if denominator > 0 => Some(Self { numerator, denominator }.reduced()),
                _ => None,
            },
        };
        let (low, high) = Self::RANGE;
        rate.filter(|rate| (low..=high).contains(&rate.per_second()))
            .ok_or_else(|| format!("expected frames a second from {low} to {high}, such as 25, 29.97 or 30000/1001"))
    }
}

impl fmt::Display for FrameRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.denominator {
            1 => write!(f, "{}", self.numerator),
            denominator => write!(f, "{}/{denominator}", self.numerator),
        }
    }
}

/// A file of poses.
#[derive(Clone, Debug, PartialEq)]
pub struct KeyframesRecord {
    /// The file; relative to [`SceneDescription::folder`](crate::description::SceneDescription::folder).
    pub file: Located<PathBuf>,
    /// What the file's objects are called here, in its order; absent: as the file calls them.
    pub objects: Option<Located<Vec<Located<String>>>>,
    /// Times of the rows; absent: as the file has them.
    pub times: Option<KeyframeTimes>,
    /// What is between; absent: as the file says, else [`Interpolation::Slerp`].
    pub interpolation: Option<Interpolation>,
    /// True if poses move objects from where the scene puts them, false if they are where objects are; absent: as is usual for the
    /// file's format.
    pub relative: Option<bool>,
}

/// When the rows of a file of poses are.
#[derive(Clone, Debug, PartialEq)]
pub enum KeyframeTimes {
    /// Each by itself, seconds, strictly ascending.
    Each(Located<Vec<f64>>),
    /// In equal steps.
    Steps {
        /// Of the first row, seconds; absent: the animation's start.
        start: Option<f64>,
        /// Rows a second of scene time, above 0; absent: the animation's.
        fps: Option<f64>,
    },
}

/// How an object moves from where its transform puts it.
#[derive(Clone, Debug, PartialEq)]
pub struct MotionRecord {
    /// Where it is shifted to, metres.
    pub translate: Curve<DVec3>,
    /// How it is turned.
    pub rotate: RotationRecord,
    /// The point that it turns about, in the world as the transform places it; absent: where that puts the object's own origin.
    pub pivot: Option<DVec3>,
    /// Where it is written.
    pub origin: Origin,
}

/// A rotation over time.
#[derive(Clone, Debug, PartialEq)]
pub enum RotationRecord {
    /// About one axis.
    About {
        /// Unit length.
        axis: DVec3,
        /// Degrees.
        angle: Curve<f64>,
    },
    /// From key to key.
    Keys(PoseTrack),
}

/// Most keys of the track that a [`MotionRecord`] becomes.
const MOST_KEYS: usize = 1 << 20;
/// Largest turn from key to key of such a track, degrees.
const TURN: f64 = 60.0;
/// Keys between two keys of a smooth curve.
const SMOOTH_STEPS: usize = 32;

impl MotionRecord {
    /// The poses of an object that turns about `pivot`; `None` if they would be too many.
    pub fn track(&self, pivot: DVec3) -> Option<PoseTrack> {
        let times = self.times()?;
        let pose = |time: &f64| {
            let rotation = self.rotate.at(*time);
            let shift = self.translate.at(*time);
            Pose { rotation, translation: pivot - rotation * pivot + shift }
        };
        let poses = times.iter().map(pose).collect();
        Some(PoseTrack { poses, times: times.into(), interpolation: Interpolation::Slerp, pivot })
    }

    /// Times of keys, close enough for straight lines and short turns between them.
    fn times(&self) -> Option<Vec<f64>> {
        let mut keys: Vec<f64> = self.translate.keys.iter().map(|(time, _)| *time).collect();
        keys.extend(self.rotate.times());
        keys.sort_by(f64::total_cmp);
        keys.dedup();
        let straight = self.translate.is_straight() && self.rotate.is_straight();
        let mut times: Vec<f64> = Vec::with_capacity(keys.len());
        for pair in keys.windows(2) {
            let turns = (self.rotate.turn(pair[0], pair[1]) / TURN) as usize + 1;
            let steps = if straight { turns } else { turns.max(SMOOTH_STEPS) };
            if steps > MOST_KEYS - times.len() {
                return None;
            }
            times.extend((0..steps).map(|step| pair[0] + (pair[1] - pair[0]) * step as f64 / steps as f64));
        }
        times.extend(keys.last());
        times.dedup();
        Some(times)
    }
}

impl RotationRecord {
    /// No rotation.
    pub fn none() -> Self {
        Self::About { axis: DVec3::Y, angle: Curve::constant(0.0) }
    }

    fn at(&self, time: f64) -> DQuat {
        match self {
            Self::About { axis, angle } => rotation_about(*axis, angle.at(time)),
            Self::Keys(track) => track.at(time).rotation,
        }
    }

    fn times(&self) -> Vec<f64> {
        match self {
            Self::About { angle, .. } => angle.keys.iter().map(|(time, _)| *time).collect(),
            Self::Keys(track) => track.times.to_vec(),
        }
    }

    fn is_straight(&self) -> bool {
        match self {
            Self::About { angle, .. } => angle.is_straight(),
            Self::Keys(track) => track.interpolation == Interpolation::Slerp || track.times.len() == 1,
        }
    }

    /// Degrees between two times.
    fn turn(&self, from: f64, to: f64) -> f64 {
        match self {
            Self::About { angle, .. } => (angle.at(to) - angle.at(from)).abs(),
            Self::Keys(_) => 0.0,
        }
    }
}

/// The rotation by an angle, degrees, about a unit vector.
pub fn rotation_about(axis: DVec3, angle: f64) -> DQuat {
    // Whole turns are none, so that what comes round comes back exactly.
    let angle = angle % 360.0;
    if angle == 0.0 {
        return DQuat::IDENTITY;
    }
    let (sin, cos) = libm::sincos(0.5 * angle.to_radians());
    let v = axis * sin;
    DQuat::from_xyzw(v.x, v.y, v.z, cos).normalize()
}

/// The orthogonal part of a map without mirroring (a mirrored one is taken as minus itself), by Newton's iteration (Higham,
/// "Computing the polar decomposition", 1986). `None` if the map flattens.
pub(crate) fn rotation_of(map: DMat3) -> Option<DMat3> {
    let mut turned = if map.determinant() < 0.0 { map * -1.0 } else { map };
    for _ in 0..100 {
        let determinant = turned.determinant();
        if !determinant.is_finite() || determinant <= 0.0 {
            return None;
        }
        let next = (turned + turned.inverse().transpose()) * 0.5;
        let change = (next - turned).to_cols_array().iter().fold(0.0f64, |most, x| most.max(x.abs()));
        turned = next;
        if change < 1e-15 {
            break;
        }
    }
    turned.is_finite().then_some(turned)
}

/// Parts of the scene file that have keys.
#[derive(Clone, Debug, Default)]
pub struct Varying {
    /// Which parts, with the times of their keys.
    pub(crate) parts: BTreeMap<Part, Vec<f64>>,
    /// What the file says of them.
    pub(crate) entries: Arc<[Entry]>,
    /// The file.
    pub(crate) origin: Option<Origin>,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frame_rates() {
        for (text, numerator, denominator) in
            [("25", 25, 1), ("12.5", 25, 2), ("29.97", 2997, 100), ("30000/1001", 30_000, 1001), ("50/2", 25, 1)]
        {
            assert_eq!(text.parse(), Ok(FrameRate { numerator, denominator }), "{text}");
        }
        for bad in ["", "0", "-25", "nan", "inf", "1/0", "0/5", "99999", "1/2/3", "25 fps", "99999999999/1"] {
            assert!(bad.parse::<FrameRate>().is_err(), "{bad}");
        }
        assert_eq!(FrameRate { numerator: 30_000, denominator: 1001 }.to_string(), "30000/1001");
    }

    #[test]
    fn rotations_of_maps() {
        let turn = DMat3::from_quat(rotation_about(DVec3::new(0.6, 0.0, 0.8), 77.0));
        let stretched = turn * DMat3::from_diagonal(DVec3::new(2.0, 0.5, 3.0));
        let apart = |a: DMat3, b: DMat3| (a - b).to_cols_array().iter().fold(0.0f64, |m, x| m.max(x.abs()));
        assert!(apart(rotation_of(stretched).unwrap(), turn) < 1e-14);
        assert!(apart(rotation_of(stretched * -1.0).unwrap(), turn) < 1e-14, "mirrored");
        assert!(rotation_of(DMat3::from_diagonal(DVec3::new(1.0, 0.0, 1.0))).is_none());
        assert!(rotation_of(DMat3::from_diagonal(DVec3::splat(f64::NAN))).is_none());
    }

    fn motion(translate: Curve<DVec3>, angle: Curve<f64>) -> MotionRecord {
        let rotate = RotationRecord::About { axis: DVec3::Y, angle };
        let origin = crate::Span::new(crate::SourceMap::new().insert("x", Vec::new()).unwrap(), 0..0).into();
        MotionRecord { translate, rotate, pivot: None, origin }
    }

    #[test]
    fn turns_of_more_than_half_a_round_are_not_lost() {
        let angle = Curve { keys: vec![(0.0, 0.0), (2.0, 720.0)], blend: Default::default() };
        let shift = Curve { keys: vec![(0.5, DVec3::ZERO), (1.0, DVec3::X)], blend: Default::default() };
        let pivot = DVec3::new(3.0, 0.0, -1.0);
        let track = motion(shift.clone(), angle).track(pivot).unwrap();
        for i in 0..=100 {
            let time = 0.02 * f64::from(i);
            let (pose, turn) = (track.at(time), rotation_about(DVec3::Y, 360.0 * time));
            assert!(crate::track::turn_between(pose.rotation, turn) < 1e-7, "{time}");
            let moved = pose.rotation * pivot + pose.translation;
            assert!((moved - pivot - shift.at(time)).length() < 1e-12, "{time}");
        }
        assert_eq!(track.at(2.0).rotation, DQuat::IDENTITY, "what comes round comes back");
        let endless = Curve {
            keys: (0..1000).map(|i| (f64::from(i), f64::from(i % 2) * 1e6)).collect(),
            blend: Default::default(),
        };
        assert!(motion(Curve::constant(DVec3::ZERO), endless).track(pivot).is_none());
    }
}
