//! Wood: rings about an axis, bent by noise, with fibres along it.

use super::{
    Function, Place,
    lattice::{kept, noise},
    periodic,
};
use crate::math::{Frame, Vec3};

/// Rings of growth, 1 cell wide on average: each slowly turns from light to dark and then quickly back (Perlin, "An
/// Image Synthesizer", 1985, made wood of noisy cylinders).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wood {
    /// Direction of the trunk, unit length.
    pub axis: Vec3,
    /// How far rings stray from circles, cells.
    pub distortion: f32,
    /// Other numbers, another tree.
    pub seed: u32,
}

impl Wood {
    /// An upright trunk with rings that stray by about a third of a ring.
    pub const DEFAULT: Self = Self { axis: Vec3::Y, distortion: 1.0, seed: 0 };
}

/// Share of a ring over which it darkens.
const RISE: f32 = 0.88;

/// Darkness from a ring's beginning to its end, and its integral: x^3 up to the late wood, then back to 0.
fn ring(x: f32) -> f32 {
    if x < RISE {
        let t = x / RISE;
        t * t * t
    } else {
        let t = (1.0 - x) / (1.0 - RISE);
        t * t * (3.0 - 2.0 * t)
    }
}

fn ring_integral(x: f32) -> f32 {
    if x < RISE {
        let t = x / RISE;
        0.25 * RISE * t * t * t * t
    } else {
        let t = (1.0 - x) / (1.0 - RISE);
        // The whole falling part has the area (1 - RISE) / 2.
        0.25 * RISE + (1.0 - RISE) * (0.5 - t * t * t * (1.0 - 0.5 * t))
    }
}

impl Function for Wood {
    fn value(&self, place: &Place) -> f32 {
        let Self { axis, distortion, seed } = *self;
        let frame = Frame::from_normal(axis);
        let local = frame.to_local(place.point);
        // Trunks change slowly along their axis.
        let slow = Vec3::new(local.x, local.y, local.z * 0.15);
        let across = Vec3::new(local.x, local.y, 0.0);
        let bend = noise(slow * 0.22, seed) * 1.3 + noise(slow * 0.9, seed.wrapping_add(1)) * 0.3;
        let radius = across.length();
        let x = radius + distortion * bend;
        let outward = if radius > 0.0 { frame.to_world(across / radius) } else { Vec3::ZERO };
        // Noise makes rings denser in places.
        let width = place.extent(outward) * (1.0 + 0.3 * distortion);
        let rings = periodic::mean(x, width, ring, ring_integral);
        // Years differ.
        let year = 0.75 + 0.5 * noise(Vec3::new(x * 0.43, 0.5, 0.5), seed.wrapping_add(2)) * kept(0.43 * width);
        let [wide, narrow] = place.widths();
        let fibre = noise(Vec3::new(local.x * 9.0, local.y * 9.0, local.z * 0.6), seed.wrapping_add(3));
        let fibre = fibre * kept(9.0 * wide.min(narrow)) * kept(3.0 * wide.max(narrow));
        0.08 + 0.85 * rings * year + 0.22 * fibre
    }

    fn finest(&self) -> f32 {
        1.0 / 128.0
    }
}
