//! The result: poses over time.

use etendue::{math::DVec3, motion::Pose};
use etendue_scene::track::{Interpolation, PoseTrack};
use std::sync::Arc;

/// What bodies did.
#[derive(Clone, Debug, PartialEq)]
pub struct Bake {
    /// Seconds of scene time, one for each step and one for the start.
    pub times: Arc<[f64]>,
    /// Seconds from one of them to the next, as the settings have it.
    pub step: f64,
    /// The dynamic bodies, in the order of the scene.
    pub bodies: Vec<BakedBody>,
    /// See [`motion_hash`](crate::motion_hash).
    pub hash: [u8; 32],
}

/// What one body did.
#[derive(Clone, Debug, PartialEq)]
pub struct BakedBody {
    /// Index into [`SceneDescription::objects`](etendue_scene::description::SceneDescription::objects).
    pub object: usize,
    /// The object's name.
    pub name: String,
    /// Its centre of mass in the world as the scene file places it, metres: that is what flies straight, and turns about itself.
    pub center: DVec3,
    /// One for each of [`Bake::times`]: `world = pose * (where the scene file puts the object)`.
    pub poses: Arc<[Pose]>,
}

impl Bake {
    /// A track for each body: the object's index and its poses.
    pub fn tracks(&self) -> Vec<(usize, PoseTrack)> {
        let track = |body: &BakedBody| PoseTrack {
            times: self.times.clone(),
            poses: body.poses.clone(),
            interpolation: Interpolation::Slerp,
            pivot: body.center,
        };
        self.bodies.iter().map(|body| (body.object, track(body))).collect()
    }
}
