//! Marble: veins across an axis, bent by turbulence.

use super::{
    Function, Place,
    lattice::{Octaves, kept, noise},
    periodic,
};
use crate::math::Vec3;

/// Veins 1 cell apart on average, dark and thin in a cloudy ground (Perlin, "An Image Synthesizer", 1985, bent bands by
/// turbulence).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Marble {
    /// Across the veins, unit length.
    pub axis: Vec3,
    /// How far veins are bent, cells.
    pub distortion: f32,
    /// Other numbers, another stone.
    pub seed: u32,
}

impl Marble {
    /// Veins about an upright axis.
    pub const DEFAULT: Self = Self { axis: Vec3::X, distortion: 3.0, seed: 0 };
}

/// Darkness across a vein, which is about the whole numbers: |2x - 1|^10, and its integral.
fn vein(x: f32) -> f32 {
    let t = 2.0 * x - 1.0;
    let t2 = t * t;
    let t4 = t2 * t2;
    t4 * t4 * t2
}

fn vein_integral(x: f32) -> f32 {
    let t = 2.0 * x - 1.0;
    (vein(x) * t + 1.0) / 22.0
}

impl Function for Marble {
    fn value(&self, place: &Place) -> f32 {
        let Self { axis, distortion, seed } = *self;
        let widths = place.widths();
        let point = if place.is_solid { place.point } else { place.point + Vec3::new(0.0, 0.0, 0.5) };
        let bent = |frequency: f32, seed: u32| {
            let octaves = Octaves { count: 6, roughness: 0.5, seed, absolute: true };
            octaves.sum(point * frequency, widths.map(|width| width * frequency))
        };
        let veins = |frequency: f32, seed: u32| {
            let x = point.dot(axis) * frequency + distortion * bent(0.6 * frequency, seed);
            // Turbulence makes veins denser in places.
            let width = place.extent(axis) * frequency * (1.0 + 0.5 * distortion);
            periodic::mean(x, width, vein, vein_integral)
        };
        let cloud = Octaves { count: 4, roughness: 0.6, seed: seed.wrapping_add(11), absolute: false };
        let cloud = cloud.sum(point * 0.8, widths.map(|width| 0.8 * width));
        // Veins fade in and out along their way.
        let presence =
            0.65 + 0.9 * noise(point * 0.7, seed.wrapping_add(7)) * kept(0.7 * widths[0]) * kept(0.7 * widths[1]);
        let fine = 0.35 * veins(2.3, seed.wrapping_add(17));
        0.10 + 0.35 * cloud + (veins(1.0, seed) + fine) * presence.clamp(0.0, 1.0)
    }

    fn finest(&self) -> f32 {
        1.0 / 256.0
    }
}
