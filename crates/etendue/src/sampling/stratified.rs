//! Jittered strata: a square of cells for pairs of numbers, intervals for single ones.

use super::hash::{join, to_unit};
use super::strata::{jitter, stratum};
use super::{Points, SampleKey};

/// One point in each cell of a grid of 2 x 2, 4 x 4, 8 x 8 and 16 x 16 for blocks of so many samples, anywhere inside of its
/// cell (Mitchell, "Consequences of Stratified Sampling in Graphics", 1996).
pub(super) struct Stratified;

impl Points for Stratified {
    #[inline]
    fn one_d(key: SampleKey, dimension: [u32; 2]) -> f32 {
        let dimension = join(dimension);
        to_unit(stratum(key.index, dimension) << 24 | (jitter(key.index, dimension) >> 40) as u32)
    }

    #[inline]
    fn two_d(key: SampleKey, dimension: [u32; 2]) -> [f32; 2] {
        let dimension = join(dimension);
        let cell = stratum(key.index, dimension);
        let inside = jitter(key.index, dimension);
        let x = even_bits(cell) << 28 | (inside >> 36) as u32;
        let y = even_bits(cell >> 1) << 28 | inside as u32 >> 4;
        [to_unit(x), to_unit(y)]
    }
}

/// The bits 0, 2, 4, 6 as a number of four bits: one coordinate of a cell in the quadtree.
#[inline]
fn even_bits(x: u32) -> u32 {
    let pairs = x & 0x55;
    let nibbles = (pairs | pairs >> 1) & 0x33;
    (nibbles | nibbles >> 2) & 0x0f
}
