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

/// Two words as one; the first is low.
#[inline(always)]
pub(super) fn join([low, high]: [u32; 2]) -> u64 {
    u64::from(high) << 32 | u64::from(low)
}

/// The two words of a number, the low one first.
#[inline(always)]
pub(super) fn words(z: u64) -> [u32; 2] {
    [z as u32, (z >> 32) as u32]
}

/// A permutation of pairs of words as random as [`mix`] is of numbers, of products of words alone: those of 64 bits have no
/// instruction below AVX-512. Steps are those of hashes of one word (multipliers by Wellons, "Prospecting for Hash Functions", 2018),
/// each added to the other word; three of them already flip every bit for every bit with probability 1/2.
#[inline(always)]
pub(super) fn mix_words([mut a, mut b]: [u32; 2]) -> [u32; 2] {
    a = (a ^ a >> 16).wrapping_mul(0x21f0_aaad);
    b ^= a;
    b = (b ^ b >> 15).wrapping_mul(0xd35a_2d97);
    a ^= b;
    a = (a ^ a >> 16).wrapping_mul(0x7feb_352d);
    b ^= a;
    b = (b ^ b >> 15).wrapping_mul(0x846c_a68b);
    a ^= b;
    [a ^ a >> 16, b ^ b >> 15]
}

/// The top 24 bits as a number in [0, 1): at most 1 - 2^-24.
#[inline(always)]
pub(super) fn to_unit(bits: u32) -> f32 {
    // The signed conversion has an instruction in every vector set; the value fits.
    (bits >> 8) as i32 as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Standard deviations from one half of `trials`.
    fn sigma(count: u32, trials: u32) -> f64 {
        (f64::from(count) - 0.5 * f64::from(trials)) / (0.25 * f64::from(trials)).sqrt()
    }

    /// The inverse of `x ^ x >> shift`, and of a product with an odd number.
    fn unshift(x: u32, shift: u32) -> u32 {
        (0..32 / shift + 1).fold(x, |y, _| x ^ y >> shift)
    }

    fn undo_product(x: u32, odd: u32) -> u32 {
        // Newton's iteration, from an inverse modulo 8.
        let inverse = (0..4).fold(odd, |i, _| i.wrapping_mul(2u32.wrapping_sub(odd.wrapping_mul(i))));
        x.wrapping_mul(inverse)
    }

    #[test]
    fn mixed_words_can_be_told_back() {
        for i in 0..100_000 {
            let from = words(if i < 1000 { i } else { mix(i) });
            let [mut a, mut b] = mix_words(from);
            (a, b) = (unshift(a, 16), unshift(b, 15));
            for [first, second] in [[0x7feb_352d, 0x846c_a68b], [0x21f0_aaad, 0xd35a_2d97]] {
                a ^= b;
                b = unshift(undo_product(b, second), 15);
                b ^= a;
                a = unshift(undo_product(a, first), 16);
            }
            assert_eq!([a, b], from);
        }
    }

    /// Each bit of the result flips for each bit of the argument as a fair coin, for any argument and for those that differ in few bits.
    #[test]
    fn every_bit_of_mixed_words_flips_for_every_bit() {
        let trials = 1 << 14;
        for apart in [false, true] {
            for from in 0..64 {
                let mut flips = [0u32; 64];
                for i in 0..u64::from(trials) {
                    let z = if apart { mix(i) } else { i << 50 | i };
                    let flipped = join(mix_words(words(z))) ^ join(mix_words(words(z ^ 1 << from)));
                    for (to, flips) in flips.iter_mut().enumerate() {
                        *flips += (flipped >> to & 1) as u32;
                    }
                }
                for (to, flips) in flips.into_iter().enumerate() {
                    let sigma = sigma(flips, trials);
                    assert!(sigma.abs() < 5.5, "bit {from} to bit {to}, {apart}: {sigma}");
                }
            }
        }
    }
}
