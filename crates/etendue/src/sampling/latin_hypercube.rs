//! Latin hypercubes: each axis has its own strata, which are paired at random.

use super::hash::{join, mix, to_unit};
use super::strata::{jitter, stratum};
use super::{Points, SampleKey};

/// One point in each of 4, 16, 64 and 256 columns, and one in each of as many rows, for blocks of so many samples (McKay,
/// Beckman and Conover, "A Comparison of Three Methods for Selecting Values of Input Variables", 1979).
pub(super) struct LatinHypercube;

impl Points for LatinHypercube {
    #[inline]
    fn one_d(key: SampleKey, dimension: [u32; 2]) -> f32 {
        let dimension = join(dimension);
        to_unit(stratum(key.index, dimension) << 24 | (jitter(key.index, dimension) >> 40) as u32)
    }

    #[inline]
    fn two_d(key: SampleKey, dimension: [u32; 2]) -> [f32; 2] {
        let dimension = join(dimension);
        let inside = jitter(key.index, dimension);
        let x = stratum(key.index, dimension) << 24 | (inside >> 40) as u32;
        let y = stratum(key.index, mix(!dimension)) << 24 | inside as u32 >> 8;
        [to_unit(x), to_unit(y)]
    }
}
