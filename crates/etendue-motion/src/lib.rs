//! Rigid bodies: a scene whose objects have bodies becomes poses over time.
//!
//! The physics is `rapier3d`'s, in f64, single-threaded, with its `enhanced-determinism`: the same scene gives the same poses, bit
//! for bit, on every machine. This crate is the only one that knows of it.

#![forbid(unsafe_code)]

mod bake;
mod bounce;
mod convert;
mod error;
mod frame;
mod hash;
mod joints;
mod mass;
mod mesh;
mod shapes;
mod simulate;
mod solid;
mod world;
mod write;

pub use bake::{Bake, BakedBody};
pub use error::MotionError;
pub use hash::motion_hash;
pub use simulate::{Control, DURATION, MAX_POSES, Options, Progress, simulate};
pub use write::write_json;
