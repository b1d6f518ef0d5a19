//! Gradient noise (Perlin, "Improving Noise", 2002) on an integer lattice, with a hash of its own.

use crate::math::Vec3;

/// A hash of a lattice point. Its bits are part of the picture.
#[inline]
fn hash(x: u32, y: u32, z: u32, seed: u32) -> u32 {
    let mut h = seed.wrapping_mul(0x9e37_79b9) ^ x.wrapping_mul(0x8da6_b343);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d) ^ y.wrapping_mul(0xd816_3841);
    h = (h ^ (h >> 13)).wrapping_mul(0x297a_2d39) ^ z.wrapping_mul(0xcb1a_b31f);
    h = (h ^ (h >> 16)).wrapping_mul(0x7feb_352d);
    h = (h ^ (h >> 15)).wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// The product of `offset` with one of the twelve directions to the edges of a cube.
#[inline]
fn slope(hash: u32, offset: Vec3) -> f32 {
    let Vec3 { x, y, z } = offset;
    let (a, b) = match hash % 12 / 4 {
        0 => (x, y),
        1 => (x, z),
        _ => (y, z),
    };
    (if hash & 0x100 == 0 { a } else { -a }) + (if hash & 0x200 == 0 { b } else { -b })
}

/// Noise in [-1, 1] with mean 0, twice differentiable; features are about 1 wide.
pub(super) fn noise(point: Vec3, seed: u32) -> f32 {
    if !point.is_finite() {
        return 0.0;
    }
    let cell = point.floor();
    let offset = point - cell;
    // Far out, where single precision has no fraction left, the casts saturate.
    let corner = [cell.x, cell.y, cell.z].map(|c| c as i64 as u32);
    let fade = offset * offset * offset * (offset * (offset * 6.0 - Vec3::splat(15.0)) + Vec3::splat(10.0));
    let at = |dx: u32, dy: u32, dz: u32| {
        let h = hash(corner[0].wrapping_add(dx), corner[1].wrapping_add(dy), corner[2].wrapping_add(dz), seed);
        slope(h, offset - Vec3::new(dx as f32, dy as f32, dz as f32))
    };
    let mix = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let edge = |dy, dz| mix(at(0, dy, dz), at(1, dy, dz), fade.x);
    mix(mix(edge(0, 0), edge(1, 0), fade.y), mix(edge(0, 1), edge(1, 1), fade.y), fade.z)
}

/// How much of the noise is left in its mean over an interval of `width` cells: the factor that brings a value nearest to
/// the mean, as measured, within 0.03.
#[inline]
pub(super) fn kept(width: f32) -> f32 {
    1.0 / (1.0 + 0.28 * width * width)
}

/// The same of the noise's size, less its mean.
#[inline]
fn kept_of_size(width: f32) -> f32 {
    1.0 / (1.0 + 0.72 * width * width)
}

/// A sum of octaves of noise, each twice as fine as the one before and `roughness` times as strong.
#[derive(Clone, Copy, Debug)]
pub(super) struct Octaves {
    pub count: u32,
    pub roughness: f32,
    pub seed: u32,
    /// What the size of the noise is on average.
    pub absolute: bool,
}

/// Standard deviation of the noise.
pub(super) const DEVIATION: f32 = 0.27;
/// Mean of its size.
pub(super) const MEAN_SIZE: f32 = 0.22;

impl Octaves {
    /// The sum over the sum of the strengths, at `point`; octaves fade as they get finer than the footprint, which has axes
    /// of these lengths.
    pub fn sum(&self, mut point: Vec3, mut widths: [f32; 2]) -> f32 {
        let (mut strength, mut sum, mut total) = (1.0, 0.0, 0.0);
        for octave in 0..self.count {
            let part = if self.absolute { kept_of_size } else { kept };
            let left = part(widths[0]) * part(widths[1]);
            if left > 1e-3 {
                let value = noise(point, self.seed.wrapping_add(octave));
                sum +=
                    strength * if self.absolute { MEAN_SIZE + (value.abs() - MEAN_SIZE) * left } else { value * left };
            } else if self.absolute {
                sum += strength * MEAN_SIZE;
            }
            total += strength;
            strength *= self.roughness;
            // Moved as well, or all octaves would be 0 at the same lattice points.
            point = point * 2.0 + Vec3::new(0.37, 0.71, 0.13);
            widths = widths.map(|width| 2.0 * width);
        }
        sum / total
    }
}
