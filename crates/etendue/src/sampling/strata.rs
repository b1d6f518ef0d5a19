//! Nested strata: blocks of 4, 16, 64 and 256 consecutive sample indices fill 4, 16, 64 and 256 strata exactly once each.
//!
//! Blocks are fixed, so samples can be added later without end; they are nested, so that a picture of few samples is
//! stratified as finely as it can be, and one of many as finely as 256 strata allow. Beyond that, blocks are independent of
//! each other. Latin hypercubes nested so are those of Qian, "Nested Latin Hypercube Designs" (2009).

use super::hash::{GOLDEN, mix};

/// Levels of nesting; each divides a stratum into four.
pub(super) const LEVELS: u32 = 4;

/// One of four parts of a stratum, on every level from the coarsest: two bits each, the coarsest highest; below
/// 4^[`LEVELS`].
///
/// On each level, every node of the tree of strata visits its four children in an order of its own, drawn anew for every
/// block. A sample alone is uniform over the strata; two are independent, but that those of one block share no stratum.
#[inline]
pub(super) fn stratum(index: u32, dimension: u64) -> u32 {
    let mut path = 0;
    for level in 0..LEVELS {
        let digit = index >> (2 * level) & 3;
        // Blocks of the next coarser level shuffle apart; the shift by 2 and more is below 32.
        let block = index >> (2 * level + 2);
        let order = node_hash(dimension, block, level + 1, path);
        path = path << 2 | permute4(digit, order);
    }
    path
}

/// Where the samples lie inside of their strata: uniform bits, independent of each other and of the orders.
#[inline]
pub(super) fn jitter(index: u32, dimension: u64) -> u64 {
    node_hash(dimension, index, 0, 0)
}

/// A hash of a node in the tree of strata (`path`, below 4^[`LEVELS`]) in one block of one level.
#[inline]
fn node_hash(dimension: u64, block: u32, level: u32, path: u32) -> u64 {
    let node = u64::from(block) << 12 | u64::from(path << 4 | level);
    mix(dimension.wrapping_add(node.wrapping_mul(GOLDEN)))
}

/// One of the 24 permutations of 0..4, all equally likely: every one is affine over pairs of bits, so it is the images of
/// 1 and 2 under an invertible linear map (six of them) and the image of 0.
#[inline]
fn permute4(digit: u32, hash: u64) -> u32 {
    let pick = |bits: u64, count: u64| (((bits & 0xffff_ffff) * count) >> 32) as u32;
    let zero = (hash & 3) as u32;
    let map = pick(hash >> 32, 6);
    let one = map % 3 + 1;
    let two = (map % 3 + 1 + map / 3) % 3 + 1;
    zero ^ ((digit & 1) * one) ^ ((digit >> 1) * two)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::disallowed_methods)]
    use super::*;
    use std::collections::BTreeMap;

    /// Every permutation occurs, equally often.
    #[test]
    fn permutations_are_uniform() {
        let draws = 24_000;
        let mut counts = BTreeMap::new();
        for i in 0..draws {
            let hash = mix(i);
            let images = [0, 1, 2, 3].map(|digit| permute4(digit, hash));
            assert_eq!(images.iter().fold(0, |seen, image| seen | 1 << image), 0b1111, "{images:?}");
            *counts.entry(images).or_insert(0u32) += 1;
        }
        assert_eq!(counts.len(), 24);
        let statistic: f64 = counts.values().map(|n| (f64::from(*n) - 1000.0).powi(2) / 1000.0).sum();
        assert!(statistic < 49.7, "{statistic} of 23 degrees of freedom"); // 0.1 %
    }

    #[test]
    fn blocks_fill_their_strata() {
        for (dimension, first) in [(1, 0u32), (2, 256), (u64::MAX, 512), (77, u32::MAX / 512 * 256)] {
            for level in 0..=LEVELS {
                let (length, unused) = (1u32 << (2 * level), 2 * (LEVELS - level));
                for block in 0..256 / length {
                    let mut seen = vec![false; length as usize];
                    for i in 0..length {
                        seen[(stratum(first + block * length + i, dimension) >> unused) as usize] = true;
                    }
                    assert!(seen.into_iter().all(|s| s), "block {block} of {length}");
                }
            }
        }
    }
}
