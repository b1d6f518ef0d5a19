//! Physically based Monte Carlo light transport: an immutable [`Scene`](scene::Scene), rays that flow through it in
//! waves, and a film whose sums are exact.

#![forbid(unsafe_code)]

pub mod bsdf;
pub mod camera;
pub mod film;
pub mod image;
pub mod integrator;
pub mod labels;
pub mod light;
pub mod material;
pub mod math;
pub mod medium;
pub mod motion;
mod parallel;
pub mod render;
pub mod sampling;
pub mod scene;
pub mod spectrum;
pub mod surface;
pub mod texture;
pub mod tonemap;
