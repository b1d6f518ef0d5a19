//! Vectors, frames, and transcendental functions with the same bits on every machine.

mod frame;
mod functions;

pub use frame::Frame;
pub use functions::*;
pub(crate) use functions::{atan2_wide, exp_short, exp_wide, ln_wide, sin_cos_wide};
pub use glam::{DAffine3, DMat3, DQuat, DVec3, Vec2, Vec3, dvec3, vec2, vec3};
pub(crate) use glam::{DVec2, dvec2};
