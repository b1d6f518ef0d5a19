//! Owen-scrambled Sobol points, padded: every dimension has its own scrambled two-dimensional sequence, read in its own
//! shuffled order (Burley, "Practical Hash-based Owen Scrambling", 2020). Any 2^m consecutive points that start at a
//! multiple of 2^m are a (0, m, 2)-net in base 2; different dimensions are as good as independent.
//!
//! All pixels of a block share the scrambling, and each shifts the digits of its points by its place on a shuffled Z-shaped curve, so that
//! the points of squares of pixels are well spread together, whatever the number of samples. What a pixel has by itself is as with
//! a scrambling of its own.

use super::hash::to_unit;
use super::{Points, SampleKey};

/// The points. All arithmetic is on 32-bit integers without branches.
pub(super) struct Sobol;

impl Points for Sobol {
    #[inline(always)]
    fn one_d(key: SampleKey, dimension: [u32; 2]) -> f32 {
        let [order, x_seed] = dimension;
        let [x_shift, _] = shifts(key.cell, dimension);
        to_unit(scramble_reversed(shuffle(key.index, order) ^ x_shift, x_seed).reverse_bits())
    }

    #[inline(always)]
    fn two_d(key: SampleKey, dimension: [u32; 2]) -> [f32; 2] {
        let [order, x_seed] = dimension;
        let index = shuffle(key.index, order);
        let [x_shift, y_shift] = shifts(key.cell, dimension);
        let x = scramble_reversed(index ^ x_shift, x_seed);
        let y = scramble_reversed(pascal(index) ^ y_shift, more(dimension, Y_SEED));
        [to_unit(x.reverse_bits()), to_unit(y.reverse_bits())]
    }
}

/// Odd multipliers for [`more`], with good spectra (Steele and Vigna, "Computationally Easy, Spectrally Good Multipliers", 2022).
const Y_SEED: u32 = 0xadb4_a92d;
const CELL_SEED: u32 = 0xe817_fb2d;

/// A word more of a dimension: uniform and independent of each of its words, for either alone.
#[inline(always)]
fn more([a, b]: [u32; 2], multiplier: u32) -> u32 {
    let word = a.wrapping_mul(multiplier) ^ b;
    word ^ word >> 15
}

/// Bits of a pixel's coordinate inside its block.
const BLOCK_BITS: u32 = 4;

/// The block of a pixel, and the pixel's place on the Z-shaped curve through it, its bits reversed.
#[inline(always)]
pub(super) fn block_of([x, y]: [u32; 2]) -> ([u32; 2], u32) {
    let cell = (0..BLOCK_BITS).fold(0, |cell, bit| {
        let at = 2 * (BLOCK_BITS - 1 - bit);
        cell | (y >> bit & 1) << at | (x >> bit & 1) << (at + 1)
    });
    ([x >> BLOCK_BITS, y >> BLOCK_BITS], cell)
}

/// By what the digits of both coordinates are shifted for each bit of the place on the curve, the highest first: the first digit
/// lowest. Found by a search for the least variance of means over squares of 2 x 2 to 16 x 16 pixels with 1 to 128 samples each, as
/// gain coefficients have it (Owen 1997). Perfect nets for all of these at once, (0, m, 4)-nets, do not exist in base 2.
const SHIFTS: [[u32; 2]; 2 * BLOCK_BITS as usize] = [
    [0x91c1, 0xb986],
    [0x676a, 0x74d8],
    [0x2820, 0xfefa],
    [0x18e2, 0x859f],
    [0x42a8, 0x330b],
    [0x36cc, 0x84cd],
    [0x55ea, 0x5295],
    [0x1cff, 0x8beb],
];

/// What is added to both coordinates of a pixel's points, digit by digit, before they are scrambled as one set with all of its block.
///
/// The four parts of each square along the curve change places for each dimension apart (Ahmed and Wonka, "Screen-Space Blue-Noise
/// Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of Pixels", 2020): with one axis always in the lead,
/// what two dimensions bring together would be alike in neighbours.
#[inline(always)]
fn shifts(cell: u32, dimension: [u32; 2]) -> [u32; 2] {
    let hash = more(dimension, CELL_SEED);
    let cell = scramble_reversed(turned(cell, hash), hash);
    let mut both = 0;
    for (bit, [x, y]) in SHIFTS.into_iter().enumerate() {
        let mask = (cell << (31 - bit)) as i32 >> 31;
        both ^= (y << 16 | x) & mask as u32;
    }
    [both & 0xffff, both >> 16]
}

/// Of each pair of bits an invertible linear map, by bits of the hash.
#[inline(always)]
fn turned(cell: u32, hash: u32) -> u32 {
    const FIRST: u32 = 0x55;
    let (even, odd) = (cell & FIRST, cell >> 1 & FIRST);
    let even = even ^ (odd & hash >> 8);
    let odd = odd ^ (even & hash >> 16);
    let even = even ^ (odd & hash >> 24);
    even | odd << 1
}

/// A nested uniform shuffle: aligned blocks of 2^m indices stay together, for every m.
#[inline(always)]
fn shuffle(index: u32, seed: u32) -> u32 {
    scramble_reversed(index.reverse_bits(), seed).reverse_bits()
}

/// Owen scrambling of a number whose bits are reversed: the flip of each bit is a hash of the seed and of the bits below.
/// Construction of Laine and Karras ("Stratified Sampling for Stochastic Transparency", 2011); these operations and
/// constants by Vegdahl ("Building a Better LK Hash", psychopath.io, 2021).
#[inline(always)]
fn scramble_reversed(mut x: u32, seed: u32) -> u32 {
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(seed);
    x = x.wrapping_mul((seed >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^ x.wrapping_mul(0x53a2_2864)
}

/// The second Sobol dimension with its bits reversed: the product with Pascal's triangle modulo 2, which factors into
/// five steps, being a Kronecker power (Ahmed, "An Implementation Algorithm of 2D Sobol Sequence Fast, Elegant, and
/// Compact", 2024). The first dimension reversed is the index itself.
#[inline(always)]
fn pascal(mut x: u32) -> u32 {
    x ^= x >> 16;
    x ^= (x & 0xff00_ff00) >> 8;
    x ^= (x & 0xf0f0_f0f0) >> 4;
    x ^= (x & 0xcccc_cccc) >> 2;
    x ^ (x & 0xaaaa_aaaa) >> 1
}

#[cfg(test)]
mod tests {
    use super::super::hash::{join, mix, mix_words, words};
    use super::*;

    /// Direction numbers of the polynomial x + 1 (Sobol 1967), one index bit at a time.
    #[test]
    fn second_dimension_from_direction_numbers() {
        let mut direction = [1u32 << 31; 32];
        for i in 1..32 {
            direction[i] = direction[i - 1] ^ (direction[i - 1] >> 1);
        }
        for i in 0..10_000u64 {
            let index = mix(i) as u32 >> (i % 32);
            let expected = (0..32).filter(|bit| index >> bit & 1 == 1).fold(0, |sum, bit| sum ^ direction[bit]);
            assert_eq!(pascal(index).reverse_bits(), expected);
        }
    }

    /// A nested scramble keeps the first bit where two numbers differ, and so is a permutation.
    #[test]
    fn scrambling_is_nested() {
        for i in 0..100_000 {
            let h = mix(i);
            let (a, seed) = ((h >> 32) as u32, h as u32);
            // Equal in the first `i % 32` bits, different in the next.
            let shared = (i % 32) as u32;
            let b = a ^ (1 << (31 - shared)) ^ (mix(h) as u32).checked_shr(shared + 1).unwrap_or(0);
            let scramble = |x: u32| scramble_reversed(x.reverse_bits(), seed).reverse_bits();
            assert_eq!((scramble(a) ^ scramble(b)).leading_zeros(), shared, "{a:032b} {b:032b}");
        }
    }

    /// Over the seeds, the flip of a bit is a fair coin at each node of the tree, and independent of the flip at any node
    /// whose path differs in one digit.
    #[test]
    fn flips_are_fair() {
        let trials = 1 << 14;
        let sigma = |count: u32| (f64::from(count) - 0.5 * trials as f64) / (0.25 * trials as f64).sqrt();
        for node in 0..24 {
            let a = if node < 8 { node } else { mix(u64::from(node)) as u32 };
            for bit in 1..24u32 {
                let mut same = vec![0u32; bit as usize];
                let mut ones = 0;
                for i in 0..trials {
                    let seed = mix(i ^ u64::from(bit) << 32 ^ u64::from(node) << 40) as u32;
                    let flip = |x: u32| (scramble_reversed(x, seed) ^ x) >> bit & 1;
                    ones += flip(a);
                    for (other, same) in same.iter_mut().enumerate() {
                        *same += u32::from(flip(a) == flip(a ^ 1 << other));
                    }
                }
                assert!(sigma(ones).abs() < 5.0, "node {a:x} bit {bit}: {}", sigma(ones));
                for (other, &same) in same.iter().enumerate() {
                    assert!(sigma(same).abs() < 5.0, "node {a:x} bit {bit} after {other}: {}", sigma(same));
                }
            }
        }
    }

    /// What orders and scrambles a dimension's points tells nothing of another dimension of the same stream, nor of another stream
    /// or of another of its own words: over streams, any bit of one and any of the other are equal as often as not.
    #[test]
    fn seeds_of_neighbours_are_independent() {
        let seeds = |dimension: [u32; 2]| {
            let [order, x_seed] = dimension;
            [order, x_seed, more(dimension, Y_SEED), more(dimension, CELL_SEED)]
        };
        let trials = 1u32 << 12;
        // (stream, vertex, slot), and another.
        let pairs = [
            ([0, 0, 0], [0, 0, 0]),
            ([0, 1, 5], [0, 1, 7]),
            ([0, 1, 5], [0, 2, 5]),
            ([0, 3, 10], [0, 4, 10]),
            ([0, 7, 5], [0, 8, 7]),
            ([0, 2, 1], [0, 1, 2]),
            ([0, 1, 7], [1, 1, 7]),
            ([0, 1, 7], [1 << 32, 1, 7]),
        ];
        for (one, other) in pairs {
            let mut same = vec![0u32; 128 * 128];
            for i in 0..u64::from(trials) {
                let [one, other] = [one, other].map(|[stream, vertex, slot]| {
                    let [a, b] = words(mix(i).wrapping_add(stream));
                    let seeds = seeds(mix_words([a ^ vertex as u32, b ^ slot as u32]));
                    u128::from(join([seeds[2], seeds[3]])) << 64 | u128::from(join([seeds[0], seeds[1]]))
                });
                for (bit, same) in same.chunks_exact_mut(128).enumerate() {
                    let equal = !(other ^ (one >> bit & 1).wrapping_neg());
                    same.iter_mut().enumerate().for_each(|(bit, same)| *same += (equal >> bit & 1) as u32);
                }
            }
            for (at, same) in same.into_iter().enumerate() {
                let (bit, with) = (at / 128, at % 128);
                let sigma = (f64::from(same) - 0.5 * f64::from(trials)) / (0.25 * f64::from(trials)).sqrt();
                let is_itself = one == other && bit == with;
                assert!(is_itself || sigma.abs() < 6.0, "{one:?} {bit}, {other:?} {with}: {sigma}");
            }
        }
    }
}
