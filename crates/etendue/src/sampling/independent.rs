//! Independent uniform numbers: a hash of everything they depend on.

use super::hash::{GOLDEN, join, mix, to_unit};
use super::{Points, SampleKey};

/// Hashed uniform numbers, the plain Monte Carlo method. Its samples are independent of each other, as tests of means
/// require.
pub(super) struct Independent;

impl Independent {
    #[inline]
    fn bits(index: u32, dimension: u64) -> u64 {
        mix(dimension.wrapping_add(u64::from(index).wrapping_mul(GOLDEN)))
    }
}

impl Points for Independent {
    #[inline]
    fn one_d(key: SampleKey, dimension: [u32; 2]) -> f32 {
        let dimension = join(dimension);
        to_unit((Self::bits(key.index, dimension) >> 32) as u32)
    }

    #[inline]
    fn two_d(key: SampleKey, dimension: [u32; 2]) -> [f32; 2] {
        let dimension = join(dimension);
        let h = Self::bits(key.index, dimension);
        [to_unit((h >> 32) as u32), to_unit(h as u32)]
    }
}
