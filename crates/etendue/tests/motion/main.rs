//! Things that move while the shutter is open, and from frame to frame.
#![allow(clippy::disallowed_methods)]

#[path = "../common/mod.rs"]
mod common;

mod bodies;
mod exposure;
mod frames;
mod lights;

use common::*;
use etendue::{
    camera::{CameraSettings, Projection},
    math::{DAffine3, DQuat, DVec3},
    motion::{Motion, Pose},
};

/// A turn of so many radians about an axis through a point, then a shift.
fn pose(axis: DVec3, angle: f64, about: DVec3, shift: DVec3) -> Pose {
    let rotation = DQuat::from_axis_angle(axis.normalize(), angle);
    Pose { rotation, translation: about - rotation * about + shift }
}

/// A straight way without turning.
fn straight(from: DVec3, to: DVec3) -> Motion {
    let at = |translation| Pose { rotation: DQuat::IDENTITY, translation };
    Motion { keys: [(0.0, at(from)), (1.0, at(to))].into() }
}

/// From one pose to another.
fn between(from: Pose, to: Pose) -> Motion {
    Motion { keys: [(0.0, from), (1.0, to)].into() }
}

impl Parts {
    /// As [`Parts::place`], with a motion.
    fn place_moving(&mut self, shape: usize, transform: DAffine3, material: usize, motion: Motion) {
        self.place(shape, transform, material);
        self.0.objects.last_mut().expect("the one placed").motion = Some(motion);
    }
}

/// Parallel rays along -z through a rectangle of this height about the origin of x and y.
fn downwards(height: f64) -> CameraSettings {
    let view = camera(DVec3::Z * 3.0, DVec3::ZERO);
    CameraSettings { up: DVec3::Y, projection: Projection::Orthographic { height }, ..view }
}

/// The bits of a picture.
fn bits(image: &etendue::image::Image) -> Vec<u32> {
    interleaved(image).iter().map(|v| v.to_bits()).collect()
}
