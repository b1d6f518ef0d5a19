//! Clouds: octaves of gradient noise.

use super::{
    Function, Place,
    lattice::{DEVIATION, Octaves},
};
use crate::math::Vec3;

/// Most octaves: beyond, single precision has no digits left.
pub const MAX_OCTAVES: u32 = 16;

/// Fractal noise, about 0.5 on average; or turbulence, of the sizes of its octaves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Noise {
    /// 1 to [`MAX_OCTAVES`], each twice as fine as the one before.
    pub octaves: u32,
    /// Strength of an octave over that of the one before, in [0, 1].
    pub roughness: f32,
    /// Sizes instead of values: creases where they are 0.
    pub turbulence: bool,
    /// Other numbers, another pattern.
    pub seed: u32,
}

impl Noise {
    /// Four octaves, each half as strong as the one before.
    pub const DEFAULT: Self = Self { octaves: 4, roughness: 0.5, turbulence: false, seed: 0 };
}

impl Function for Noise {
    fn value(&self, place: &Place) -> f32 {
        let Self { octaves, roughness, turbulence, seed } = *self;
        // Off the lattice's planes, which have less to show.
        let point = if place.is_solid { place.point } else { place.point + Vec3::new(0.0, 0.0, 0.5) };
        let sum = Octaves { count: octaves, roughness, seed, absolute: turbulence }.sum(point, place.widths());
        if turbulence {
            return sum * 2.0;
        }
        // Sums of octaves vary less than their strengths add up to.
        let squares = |n: u32| (0..n).fold((0.0, 0.0, 1.0), |(s, q, a), _| (s + a, q + a * a, a * roughness));
        let (strengths, squared, _) = squares(octaves);
        0.5 + sum * strengths / squared.sqrt() * (0.2 / DEVIATION)
    }

    fn finest(&self) -> f32 {
        0.05 / (1 << (self.octaves - 1).min(MAX_OCTAVES)) as f32
    }
}
