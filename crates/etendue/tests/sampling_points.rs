//! The random numbers: stratified as promised, unbiased, independent across dimensions, and frozen.
#![allow(clippy::disallowed_methods)]

use std::f64::consts::TAU;

use etendue::sampling::{SampleKey, Sampler, Slot};
use etendue_testkit::chi2::ChiSquare;
use etendue_testkit::{Moments, Rng, sidak, ttest};

const SLOTS: [Slot; 12] = [
    Slot::Pixel,
    Slot::Lens,
    Slot::Time,
    Slot::Wavelength,
    Slot::LightSelect,
    Slot::LightPosition,
    Slot::BsdfLobe,
    Slot::BsdfDirection,
    Slot::FreeFlight,
    Slot::Opacity,
    Slot::Roulette,
    Slot::Phase,
];

/// Side of the blocks of pixels that Sobol points are spread over.
const BLOCK: u32 = 16;

/// Key of sample `i` of one half.
fn half_key(sampler: Sampler, seed: u64, pixel: [u32; 2], half: u32, i: u32) -> SampleKey {
    sampler.key(seed, pixel, 2 * i + half)
}

/// Any seed, any pixel, any sample.
fn any_key(sampler: Sampler, rng: &mut Rng) -> SampleKey {
    sampler.key(rng.u64(), [rng.u32() % 4096, rng.u32() % 4096], rng.u32() % 65_536)
}

fn any_dimension(rng: &mut Rng) -> (u32, Slot) {
    (rng.u32() % 64, SLOTS[rng.u32() as usize % SLOTS.len()])
}

/// Every elementary interval of area 2^-m holds exactly one of any 2^m points that start at a multiple of 2^m.
#[test]
fn sobol_points_are_nets() {
    let mut rng = Rng::new(1);
    for trial in 0..64u32 {
        let (seed, pixel, half) = (rng.u64(), [rng.u32(), rng.u32()], trial % 2);
        let (vertex, slot) = any_dimension(&mut rng);
        for m in 0..=10u32 {
            let first = (rng.u32() % (1 << 20)) << m;
            let keys: Vec<_> = (0..1 << m).map(|i| half_key(Sampler::Sobol, seed, pixel, half, first + i)).collect();
            let points: Vec<_> = keys.iter().map(|&key| Sampler::Sobol.two_d(key, vertex, slot)).collect();
            for columns in 0..=m {
                let mut seen = vec![false; 1 << m];
                for p in &points {
                    let column = (p[0] * (1 << columns) as f32) as usize;
                    let row = (p[1] * (1 << (m - columns)) as f32) as usize;
                    let cell = &mut seen[(column << (m - columns)) + row];
                    assert!(!*cell, "two of 2^{m} points in one interval, 2^{columns} columns");
                    *cell = true;
                }
            }
            let mut strata = vec![false; 1 << m];
            for &key in &keys {
                strata[(Sampler::Sobol.one_d(key, vertex, slot) * (1 << m) as f32) as usize] = true;
            }
            assert!(strata.into_iter().all(|s| s));
        }
    }
}

#[test]
fn numbers_are_uniform() {
    for (i, sampler) in Sampler::ALL.into_iter().enumerate() {
        let test = ChiSquare::new(500_000).seed(10 + i as u64);
        let point = |rng: &mut Rng| {
            let (vertex, slot) = any_dimension(rng);
            Some(sampler.two_d(any_key(sampler, rng), vertex, slot).map(f64::from))
        };
        test.square(point, |_| 1.0).assert(0.01, 12, "points");
        let number = |rng: &mut Rng| {
            let (vertex, slot) = any_dimension(rng);
            Some(f64::from(sampler.one_d(any_key(sampler, rng), vertex, slot)))
        };
        test.interval([0.0, 1.0], number, |_| 1.0).assert(0.01, 12, "numbers");
        let in_stream = |rng: &mut Rng| {
            let mut stream = sampler.stream(any_key(sampler, rng), 3, Slot::FreeFlight);
            for _ in 0..rng.u32() % 20 {
                stream.next_f32();
            }
            Some([stream.next_f32(), stream.next_f32()].map(f64::from))
        };
        test.square(in_stream, |_| 1.0).assert(0.01, 12, "stream");
    }
}

/// Two numbers that differ in one of vertex, slot, pixel, half, seed, or in call, are as good as independent. Pixels of one block
/// share out the square between them, so pixels here are a block apart.
#[test]
fn numbers_of_different_dimensions_are_independent() {
    for sampler in Sampler::ALL {
        for case in 0..7 {
            let pair = |rng: &mut Rng| {
                let (seed, x, y) = (rng.u64() % 4, rng.u32() % 64, rng.u32() % 64);
                let (index, vertex) = (rng.u32() % 256, rng.u32() % 8);
                let key = sampler.key(seed, [x, y], index);
                let first = || sampler.two_d(key, vertex, Slot::LightPosition)[1];
                let at = |key| sampler.two_d(key, vertex, Slot::LightPosition)[1];
                let pair = match case {
                    0 => [first(), sampler.two_d(key, vertex + 1, Slot::LightPosition)[1]],
                    1 => [first(), sampler.two_d(key, vertex, Slot::BsdfDirection)[1]],
                    2 => [first(), at(sampler.key(seed, [x + BLOCK, y], index))],
                    3 => [first(), at(sampler.key(seed, [x, y + BLOCK], index))],
                    4 => [first(), at(sampler.key(seed, [x, y], index ^ 1))],
                    5 => [first(), at(sampler.key(seed + 1, [x, y], index))],
                    _ => [first(), sampler.stream(key, vertex, Slot::LightPosition).next_f32()],
                };
                Some(pair.map(f64::from))
            };
            let outcome = ChiSquare::new(200_000).seed(100 + case).square(pair, |_| 1.0);
            outcome.assert(0.01, 28, &format!("{sampler} case {case}"));
        }
    }
}

/// Over the samples of one pixel, two dimensions share neither order nor scrambling: their correlation is zero on average
/// and scatters as theory says. With strata, two points of a block repel each other in each dimension, so the product of
/// both numbers has a larger variance than independent numbers give. For Sobol points, two consecutive points lie in
/// different halves: the product of the leading bits is the same for both and has twice the variance; for
/// (a - 1/2) (b - 1/2) this is 9/16 of the variance. In strata by four the covariance of two leading bits is -1/3 of their
/// variance, which adds a third to the same part.
#[test]
fn dimensions_of_one_pixel_do_not_correlate() {
    let samples = 64u32;
    let excess = |sampler| match sampler {
        Sampler::Independent => 0.0,
        Sampler::Sobol => 9.0 / 16.0,
        Sampler::Stratified | Sampler::LatinHypercube => 9.0 / 16.0 / 3.0,
    };
    for sampler in Sampler::ALL {
        let (mut correlation, mut square) = (Moments::new(), Moments::new());
        for pixel in 0..4000u32 {
            let (slot, other) =
                (SLOTS[pixel as usize % 12], SLOTS[(pixel as usize + 1 + pixel as usize / 12 % 11) % 12]);
            let mean = (0..samples)
                .map(|i| {
                    let key = half_key(sampler, 7, [pixel, 5], 0, i);
                    let (a, b) = (sampler.two_d(key, 2, slot)[0], sampler.two_d(key, 2, other)[1]);
                    12.0 * (f64::from(a) - 0.5) * (f64::from(b) - 0.5)
                })
                .sum::<f64>()
                / f64::from(samples);
            correlation.push(mean);
            square.push(mean * mean * f64::from(samples));
        }
        ttest::t_test(&correlation, 0.0).assert(sidak(0.01, 4), &format!("{sampler}: correlation"));
        let expected = 1.0 + excess(sampler);
        assert!((square.mean() - expected).abs() < 0.12, "{sampler}: {}, not {expected}", square.mean());
    }
}

/// Smooth, with products of both coordinates, integral 1.
fn smooth([x, y]: [f32; 2]) -> f64 {
    let (x, y) = (f64::from(x), f64::from(y));
    (1.0 + 0.5 * (TAU * x).sin() + x - 0.5) * (1.0 + (y * y - 1.0 / 3.0)) + 0.3 * ((x - 0.5) * (y - 0.5))
}

/// A quarter disk over its area: an edge that no elementary interval follows.
fn edge([x, y]: [f32; 2]) -> f64 {
    if x * x + y * y < 1.0 { 8.0 / TAU } else { 0.0 }
}

fn estimates(sampler: Sampler, count: u32, replicates: u32, f: fn([f32; 2]) -> f64) -> Moments {
    (0..replicates)
        .map(|r| {
            // Pixels of one block are not independent of each other.
            let pixel = [r % 64 * BLOCK, r / 64 * BLOCK];
            let key = |i| half_key(sampler, u64::from(count), pixel, r % 2, i);
            (0..count).map(|i| f(sampler.two_d(key(i), 1, Slot::LightPosition))).sum::<f64>() / f64::from(count)
        })
        .collect()
}

#[test]
fn integrals_are_unbiased() {
    let level = sidak(0.01, 4 * 2 * 5);
    for sampler in Sampler::ALL {
        for f in [smooth as fn([f32; 2]) -> f64, edge] {
            for count in [1, 3, 16, 61, 256] {
                let what = format!("{sampler}, {count} samples");
                ttest::t_test(&estimates(sampler, count, 4000, f), 1.0).assert(level, &what);
            }
        }
    }
}

/// The variance falls as N^-3 for smooth integrands (Owen 1997) and N^-1.5 across an edge, instead of N^-1.
#[test]
fn sobol_converges_faster() {
    let variance = |sampler, count, f| estimates(sampler, count, 1000, f).variance();
    let exponent =
        |sampler, f: fn([f32; 2]) -> f64| (variance(sampler, 16, f) / variance(sampler, 1024, f)).ln() / 64.0f64.ln();
    let sobol = [exponent(Sampler::Sobol, smooth), exponent(Sampler::Sobol, edge)];
    assert!(sobol[0] > 2.6 && sobol[1] > 1.35, "{sobol:?}");
    let independent = exponent(Sampler::Independent, smooth);
    assert!((0.9..1.1).contains(&independent), "{independent}");
    let gain = variance(Sampler::Independent, 64, smooth) / variance(Sampler::Sobol, 64, smooth);
    assert!(gain > 250.0, "{gain}");
}

/// Owen scrambling as it is defined: each node of the binary tree of digits has its own coin.
fn scrambled_by_tree(x: u32, seed: u64) -> u32 {
    (0..32).fold(x, |flipped, bit| {
        let node = (1u64 << bit) | u64::from(x).checked_shr(32 - bit).unwrap_or(0);
        let coin = Rng::new(seed ^ node.wrapping_mul(0x9e37_79b9_7f4a_7c15)).u32() >> 31;
        flipped ^ coin << (31 - bit)
    })
}

/// The hash does as well as true Owen scrambling: the variances are equal within the scatter of 8000 replicates.
#[test]
fn hashed_scrambling_is_as_good_as_true_scrambling() {
    let replicates = 8000u32;
    for f in [smooth as fn([f32; 2]) -> f64, edge] {
        for count in [2u32, 4, 16, 64] {
            let hashed = estimates(Sampler::Sobol, count, replicates, f).variance();
            let mut rng = Rng::new(u64::from(count));
            let tree: Moments = (0..replicates)
                .map(|_| {
                    let seeds = [rng.u64(), rng.u64()];
                    let point = |i: u32| {
                        let x = i.reverse_bits();
                        let y = (0..32).filter(|bit| i >> bit & 1 == 1).fold(0, |y, bit| y ^ sobol_direction(bit));
                        [(x, seeds[0]), (y, seeds[1])]
                            .map(|(x, seed)| (scrambled_by_tree(x, seed) >> 8) as f32 / 16_777_216.0)
                    };
                    (0..count).map(|i| f(point(i))).sum::<f64>() / f64::from(count)
                })
                .collect();
            let ratio = hashed / tree.variance();
            assert!((0.9..1.1).contains(&ratio), "{count} samples: {ratio}");
        }
    }
}

/// Direction number of the second Sobol dimension.
fn sobol_direction(bit: u32) -> u32 {
    (0..bit).fold(1 << 31, |v: u32, _| v ^ v >> 1)
}

/// The two halves of a pixel are independent: the variance of their difference is the sum of theirs.
#[test]
fn halves_are_independent() {
    for sampler in Sampler::ALL {
        let estimate = |pixel: u32, half: u32| {
            let key = |i| half_key(sampler, 3, [pixel, 9], half, i);
            (0..16).map(|i| smooth(sampler.two_d(key(i), 0, Slot::Pixel))).sum::<f64>() / 16.0
        };
        let (mut one, mut difference) = (Moments::new(), Moments::new());
        for pixel in 0..8000 {
            let (a, b) = (estimate(pixel, 0), estimate(pixel, 1));
            one.push(a);
            difference.push(a - b);
        }
        let ratio = difference.variance() / (2.0 * one.variance());
        assert!((0.93..1.07).contains(&ratio), "{sampler}: {ratio}");
    }
}

/// Numbers of samples, and over squares of 2, 4 and 8 pixels a side the variance of an integral's mean over that of independent pixels.
type Cancelling = [(u32, [f64; 3]); 7];

const SMOOTH: Cancelling = [
    (1, [0.304, 0.183, 0.0463]),
    (2, [0.189, 0.0277, 0.0163]),
    (3, [0.265, 0.125, 0.0293]),
    (4, [0.213, 0.0347, 0.00117]),
    (8, [0.858, 0.0090, 0.00298]),
    (16, [0.082, 0.0243, 0.0050]),
    (32, [0.293, 0.0457, 0.00116]),
];

const EDGE: Cancelling = [
    (1, [0.429, 0.339, 0.231]),
    (2, [0.475, 0.261, 0.352]),
    (3, [0.504, 0.353, 0.197]),
    (4, [0.581, 0.363, 0.153]),
    (8, [0.601, 0.268, 0.177]),
    (16, [0.653, 0.374, 0.240]),
    (32, [0.590, 0.416, 0.142]),
];

/// Over a square of pixels the errors of an integral cancel, as much as the order of its pixels lets them: these numbers, the means of
/// 12,000 squares in three dimensions, among which they do not differ, are known to a few percent.
///
/// Were the n points of each of the s^2 pixels of a square one net, it would have n s^2 to the power of -1.5 across an edge, which is
/// 1 / s in these terms: 0.5, 0.25, 0.125. As there is no order with nets for all n and s, some have up to 2.8 times as much.
#[test]
fn errors_of_neighbours_cancel() {
    for (f, expected) in [(smooth as fn([f32; 2]) -> f64, SMOOTH), (edge, EDGE)] {
        for (count, ratios) in expected {
            let alone = estimates(Sampler::Sobol, count, 8000, f).variance();
            for (side, expected) in [2u32, 4, 8].into_iter().zip(ratios) {
                let ratio = squares(count, side, 1600, f).variance() * f64::from(side * side) / alone;
                let off = ratio / expected;
                assert!((0.8..1.2).contains(&off), "{count} samples, {side} x {side}: {ratio}, not {expected}");
            }
        }
    }
}

/// Means over squares of pixels.
fn squares(count: u32, side: u32, replicates: u32, f: fn([f32; 2]) -> f64) -> Moments {
    (0..replicates)
        .map(|trial| {
            let corner = [trial % 20 * side, trial / 20 % 20 * side];
            let pixel = |p: u32| {
                let pixel = [corner[0] + p % side, corner[1] + p / side];
                let key = |i| half_key(Sampler::Sobol, u64::from(trial), pixel, trial % 2, i);
                (0..count).map(|i| f(Sampler::Sobol.two_d(key(i), 1, Slot::LightPosition))).sum::<f64>()
            };
            (0..side * side).map(pixel).sum::<f64>() / f64::from(side * side * count)
        })
        .collect()
}

/// Slices give the numbers of single calls.
#[test]
fn slices_equal_single_calls() {
    for sampler in Sampler::ALL {
        let keys: Vec<_> = (0..100).map(|i| sampler.key(5, [i, 2 * i], 3 * i)).collect();
        let (mut ones, mut twos) = (vec![0.0; 100], vec![[0.0; 2]; 100]);
        sampler.one_d_slice(&keys, 4, Slot::Roulette, &mut ones);
        sampler.two_d_slice(&keys, 4, Slot::Phase, &mut twos);
        for (i, &key) in keys.iter().enumerate() {
            assert_eq!(ones[i], sampler.one_d(key, 4, Slot::Roulette));
            assert_eq!(twos[i], sampler.two_d(key, 4, Slot::Phase));
        }
    }
}

/// No number reaches 1, and only multiples of 2^-24 occur.
#[test]
fn numbers_are_below_one() {
    let mut rng = Rng::new(8);
    for sampler in Sampler::ALL {
        let mut largest = 0.0f32;
        for _ in 0..1_000_000 {
            let p = sampler.two_d(any_key(sampler, &mut rng), 0, Slot::Pixel);
            for u in p {
                assert!((0.0..1.0).contains(&u) && (u * 16_777_216.0).fract() == 0.0);
                largest = largest.max(u);
            }
        }
        assert!(largest > 1.0 - 1e-5);
    }
}

/// Frozen bits: every picture depends on them.
#[test]
fn numbers_never_change() {
    let samples =
        [(0, [0, 0], 0), (0, [0, 0], 1), (1, [17, 4], 6), (u64::MAX, [1920, 1080], 4095), (42, [3, 3], u32::MAX)];
    let words = |sampler: Sampler| {
        let mut words = Vec::new();
        for (seed, pixel, index) in samples {
            let key = sampler.key(seed, pixel, index);
            let [x, y] = sampler.two_d(key, 2, Slot::BsdfDirection);
            let mut stream = sampler.stream(key, 1, Slot::FreeFlight);
            stream.next_f32();
            words.extend(
                [x, y, sampler.one_d(key, 0, Slot::Time), stream.next_f32()].map(|u| (u * 16_777_216.0) as u32),
            );
        }
        words
    };
    let sobol = [
        14066711, 3789451, 7158998, 4405783, 14639757, 76508, 7642227, 13094208, 9799325, 12799495, 3570682, 8330075,
        347823, 15316478, 15431704, 16772659, 1595707, 14088268, 13444300, 8100097,
    ];
    let independent = [
        8549291, 6741874, 4127953, 4405783, 16503115, 8135651, 15383442, 13094208, 11704168, 7857268, 7472940,
        11194960, 14445139, 5620048, 13058187, 2614640, 5081620, 15482292, 2687876, 1614983,
    ];
    assert_eq!(words(Sampler::Sobol), sobol);
    assert_eq!(words(Sampler::Independent), independent);
}

#[test]
fn names() {
    for sampler in Sampler::ALL {
        assert_eq!(sampler.to_string().parse(), Ok(sampler));
    }
    assert!("halton".parse::<Sampler>().is_err_and(|e| e.to_string().contains("sobol, independent")));
    assert_eq!(Sampler::default(), Sampler::Sobol);
}
