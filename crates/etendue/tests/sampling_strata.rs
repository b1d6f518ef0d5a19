//! The stratified and the Latin hypercube sampler: their strata are exact in every block, and pay.
#![allow(clippy::disallowed_methods)]

use etendue::sampling::{SampleKey, Sampler, Slot};
use etendue_testkit::chi2::ChiSquare;
use etendue_testkit::{Moments, Rng};

const STRATA: [Sampler; 2] = [Sampler::Stratified, Sampler::LatinHypercube];
const SLOT: Slot = Slot::LightPosition;

fn half_key(sampler: Sampler, seed: u64, half: u32, i: u32) -> SampleKey {
    sampler.key(seed, [3, 4], 2 * i + half)
}

/// Asserts that `cells` holds each of `0..count` once.
#[track_caller]
fn assert_all(cells: impl Iterator<Item = usize>, count: usize, what: &str) {
    let mut seen = vec![false; count];
    for cell in cells {
        assert!(!seen[cell], "{what}: two in cell {cell}");
        seen[cell] = true;
    }
    assert!(seen.into_iter().all(|s| s), "{what}: a cell is empty");
}

/// Blocks of 4, 16, 64 and 256 samples that start at a multiple of their length fill their strata, in any half.
#[test]
fn every_block_fills_its_strata() {
    let mut rng = Rng::new(1);
    for trial in 0..64u32 {
        let (seed, half, vertex) = (rng.u64(), trial % 2, rng.u32() % 9);
        for side in [2u32, 4, 8, 16] {
            let count = side * side;
            let first = (rng.u32() % (1 << 20)) * count;
            let at = |sampler| move |i| half_key(sampler, seed, half, first + i);
            for sampler in STRATA {
                let interval = |key| (sampler.one_d(key, vertex, SLOT) * count as f32) as usize;
                let what = format!("{sampler}, {count} numbers from {first}");
                assert_all((0..count).map(at(sampler)).map(interval), count as usize, &what);
            }
            let in_grid = |key| {
                let [x, y] = Sampler::Stratified.two_d(key, vertex, SLOT).map(|u| (u * side as f32) as usize);
                x + side as usize * y
            };
            assert_all((0..count).map(at(Sampler::Stratified)).map(in_grid), count as usize, "grid");
            for axis in 0..2 {
                let line = |key| (Sampler::LatinHypercube.two_d(key, vertex, SLOT)[axis] * count as f32) as usize;
                assert_all((0..count).map(at(Sampler::LatinHypercube)).map(line), count as usize, "column or row");
            }
        }
    }
}

/// Inside of its stratum a point is anywhere, whatever the stratum, and two dimensions pair their strata at random.
#[test]
fn points_are_uniform_inside_of_their_strata() {
    for (i, sampler) in STRATA.into_iter().enumerate() {
        let key = |rng: &mut Rng| sampler.key(rng.u64(), [rng.u32() % 64, 0], rng.u32() % 512);
        let inside = |rng: &mut Rng| {
            let p = sampler.two_d(key(rng), 1, SLOT);
            Some(p.map(|u| f64::from((u * 256.0).fract())))
        };
        let test = ChiSquare::new(300_000).seed(20 + i as u64);
        test.square(inside, |_| 1.0).assert(0.01, 4, &format!("{sampler}: inside"));
        let paired = |rng: &mut Rng| {
            let key = key(rng);
            Some([sampler.two_d(key, 1, SLOT)[0], sampler.two_d(key, 2, SLOT)[0]].map(f64::from))
        };
        test.square(paired, |_| 1.0).assert(0.01, 4, &format!("{sampler}: paired"));
    }
}

/// Two samples of one block share no stratum, and are independent otherwise: incomplete blocks are no worse than independent
/// samples.
#[test]
fn pairs_of_a_block_are_independent_but_for_their_strata() {
    for (case, (i, j)) in [(0, 1), (2, 7), (3, 15)].into_iter().enumerate() {
        let pair = |rng: &mut Rng| {
            let seed = rng.u64();
            let cell =
                |i| (Sampler::Stratified.one_d(half_key(Sampler::Stratified, seed, 0, i), 1, SLOT) * 16.0) as usize;
            let (a, b) = (cell(i), cell(j));
            Some(a * 16 + b)
        };
        // Samples of one four are in different quarters; others may share a quarter, never a sixteenth.
        let together = i / 4 == j / 4;
        let probability = |a: usize, b: usize| match (a / 4 == b / 4, together) {
            (true, true) => 0.0,
            (false, true) => 1.0 / (16.0 * 12.0),
            (true, false) if a == b => 0.0,
            (true, false) => 1.0 / (16.0 * 4.0 * 3.0),
            (false, false) => 1.0 / (16.0 * 16.0),
        };
        let expected: Vec<f64> = (0..256).map(|cell| probability(cell / 16, cell % 16)).collect();
        let test = ChiSquare::new(200_000).seed(40 + case as u64);
        test.indices(&expected, pair).assert(0.01, 3, &format!("samples {i} and {j}"));
    }
}

type Integrand = fn([f32; 2]) -> f64;

fn variance(sampler: Sampler, count: u32, f: Integrand) -> f64 {
    let estimate = |r: u64| {
        let points = (0..count).map(|i| sampler.two_d(half_key(sampler, r, r as u32 % 2, i), 1, SLOT));
        points.map(f).sum::<f64>() / f64::from(count)
    };
    (0..3000).map(estimate).collect::<Moments>().variance()
}

/// Strata in two dimensions pay for anything smooth; columns and rows for sums of functions of one coordinate. In complete
/// blocks: as the square of the number for a smooth integrand in cells (Mitchell 1996), as its cube for such sums in
/// columns and rows. Any number of samples does no harm; a Latin hypercube of n is no worse than n - 1 independent samples
/// (Owen, "Monte Carlo Variance of Scrambled Net Quadrature", 1997), and the smallest here has 4.
#[test]
fn strata_lower_the_variance() {
    let smooth: Integrand = |[x, y]| f64::from(x * y + 0.3 * x * x);
    let sum: Integrand = |[x, y]| f64::from(x * x + y);
    let product: Integrand = |[x, y]| f64::from((x - 0.5) * (y - 0.5));
    let gain = |sampler, count, f| variance(Sampler::Independent, count, f) / variance(sampler, count, f);
    for count in [16, 64, 256] {
        let n = f64::from(count);
        let [cells, lines] = STRATA.map(|s| gain(s, count, smooth));
        assert!(cells > 0.8 * n && cells < 2.0 * n, "{count}: {cells}");
        assert!(lines > 3.0, "{count}: {lines}");
        let lines = gain(Sampler::LatinHypercube, count, sum);
        assert!(lines > 0.8 * n * n, "{count}: {lines}");
    }
    for (sampler, least) in STRATA.into_iter().zip([0.9, 0.75]) {
        for count in [2, 3, 5, 11, 23, 300] {
            for f in [smooth, sum, product] {
                let gain = gain(sampler, count, f);
                assert!(gain > least, "{sampler}, {count} samples: {gain}");
            }
        }
    }
}

/// Frozen bits: every picture depends on them.
#[test]
fn numbers_never_change() {
    let samples =
        [(0, [0, 0], 0), (0, [0, 0], 1), (1, [17, 4], 6), (u64::MAX, [1920, 1080], 4095), (42, [3, 3], u32::MAX)];
    let words = |sampler: Sampler| -> Vec<u32> {
        let words = samples.iter().flat_map(|&(seed, pixel, index)| {
            let key = sampler.key(seed, pixel, index);
            let [x, y] = sampler.two_d(key, 2, Slot::BsdfDirection);
            [x, y, sampler.one_d(key, 0, Slot::Time)].map(|u| (u * 16_777_216.0) as u32)
        });
        words.collect()
    };
    let stratified = [
        3680058, 3567095, 11353852, 3128596, 6799934, 4319931, 7769676, 12559450, 5779595, 8171454, 11018871, 9671406,
        9049272, 1146484, 6990546,
    ];
    let latin_hypercube = [
        1016435, 2123487, 11353852, 2948049, 9927715, 4319931, 10447076, 14940741, 5779595, 10341115, 13206055,
        9671406, 4366667, 3807207, 6990546,
    ];
    assert_eq!(words(Sampler::Stratified), stratified);
    assert_eq!(words(Sampler::LatinHypercube), latin_hypercube);
}
