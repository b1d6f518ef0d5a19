//! Integer hashes behind the random numbers. Their bits are part of the picture: a change here changes every image.

/// 2^64 over the golden ratio, odd.
pub(super) const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Finaliser of SplitMix64 (Steele, Lea and Flood 2014; constants by Stafford). A permutation.
#[inline(always)]
pub(super) fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The top 24 bits as a number in [0, 1): at most 1 - 2^-24.
#[inline(always)]
pub(super) fn to_unit(bits: u32) -> f32 {
    // The signed conversion has an instruction in every vector set; the value fits.
    (bits >> 8) as i32 as f32 * (1.0 / 16_777_216.0)
}
