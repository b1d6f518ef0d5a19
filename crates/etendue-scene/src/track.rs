//! Poses over time: what moves an object, whoever wrote it down.

use etendue::motion::Pose;
use std::sync::Arc;

/// How poses between keys are made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Interpolation {
    /// Positions on straight lines, rotations along the chord.
    Linear,
    /// Positions on straight lines, rotations at constant speed.
    #[default]
    Slerp,
    /// Smooth curves through the keys.
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
}
