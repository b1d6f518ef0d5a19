//! Errors of pictures, and how sure they are.

use crate::gallery::inputs::Random;
use libm::{exp, hypot, log, pow};

/// Keeps the relative error of dark pixels finite.
const FLOOR: f64 = 0.01;
/// Share of the worst terms that the trimmed error leaves out.
const TRIM: f64 = 0.001;
/// Resamplings of the bootstrap.
const RESAMPLINGS: usize = 4000;
/// Tiles along each side of a picture when means are compared.
const TILES: usize = 16;

/// Fewest pictures whose spread tells standard errors.
const ENOUGH: usize = 8;

/// Relative mean squared error, the mean over pixels and channels of (x - ref)^2 / (ref^2 + 0.01): plain, and without the worst
/// 0.1 % of the terms.
pub fn rel_mse(picture: &[f32], reference: &[f32]) -> [f64; 2] {
    let term = |(&x, &r): (&f32, &f32)| square(f64::from(x) - f64::from(r)) / (square(f64::from(r)) + FLOOR);
    let mut terms: Vec<f64> = picture.iter().zip(reference).map(term).collect();
    let plain = terms.iter().sum::<f64>() / terms.len() as f64;
    let kept = terms.len() - (terms.len() as f64 * TRIM).ceil() as usize;
    terms.select_nth_unstable_by(kept, f64::total_cmp);
    [plain, terms[..kept].iter().sum::<f64>() / kept as f64]
}

/// Of independent pictures, what each adds to the estimated variance of one: the mean over pixels and channels of
/// n/(n - 1) (x - mean)^2 / (ref^2 + 0.01), whose mean over the pictures is the relative variance, free of bias.
pub fn spread(pictures: &[&[f32]], reference: &[f32]) -> Vec<f64> {
    let n = pictures.len() as f64;
    let mut sums = vec![0.0; pictures.len()];
    for (i, &r) in reference.iter().enumerate() {
        let mean = pictures.iter().map(|p| f64::from(p[i])).sum::<f64>() / n;
        let weight = 1.0 / (square(f64::from(r)) + FLOOR);
        for (sum, picture) in sums.iter_mut().zip(pictures) {
            *sum += square(f64::from(picture[i]) - mean) * weight;
        }
    }
    sums.iter().map(|sum| sum * n / (n - 1.0) / reference.len() as f64).collect()
}

fn square(x: f64) -> f64 {
    x * x
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let half = sorted.len() / 2;
    if sorted.len() % 2 == 1 { sorted[half] } else { (sorted[half - 1] + sorted[half]) / 2.0 }
}

/// What a line through (log n, log error) of two pilots says of the samples that reach `target`; the slope is kept within what
/// Monte Carlo and good point sets do.
pub fn samples_for(target: f64, pilots: [(f64, f64); 2]) -> f64 {
    let [(n0, e0), (n1, e1)] = pilots;
    let slope = (log(e0 / e1) / log(n1 / n0)).clamp(0.9, 1.5);
    let slope = if slope.is_nan() { 1.0 } else { slope };
    n1 * pow(e1 / target, 1.0 / slope)
}

/// One renderer's runs of one scene: the seconds and the error of each seed.
pub struct Runs<'a> {
    /// Before rendering, once.
    pub build: f64,
    pub render: &'a [f64],
    pub error: &'a [f64],
}

impl Runs<'_> {
    /// Seconds until the error is `target`, of the runs with these indices: error falls as one over the rendering time.
    fn seconds_to(&self, target: f64, chosen: &[usize]) -> f64 {
        let of = |values: &[f64]| chosen.iter().map(|&i| values[i]).collect::<Vec<_>>();
        self.build + median(&of(self.render)) * mean(&of(self.error)) / target
    }
}

/// A number with its 95 % interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    pub value: f64,
    pub low: f64,
    pub high: f64,
}

impl Estimate {
    /// The value and the middle 95 % of resamplings.
    fn new(value: f64, mut resampled: Vec<f64>) -> Self {
        resampled.sort_by(f64::total_cmp);
        let at = |q: f64| resampled[((resampled.len() - 1) as f64 * q).round() as usize];
        Self { value, low: at(0.025), high: at(0.975) }
    }
}

/// Resampled seconds to `target`, the first without resampling. All renderers of a scene took turns, so resampling with the same
/// `seed` draws the same turns for each.
pub fn resampled_seconds(runs: &Runs<'_>, target: f64, seed: u64) -> Vec<f64> {
    let n = runs.error.len();
    let mut random = Random::new(seed);
    let mut chosen: Vec<usize> = (0..n).collect();
    let mut found = vec![runs.seconds_to(target, &chosen)];
    for _ in 0..RESAMPLINGS {
        chosen.iter_mut().for_each(|i| *i = (random.unit() * n as f64) as usize);
        found.push(runs.seconds_to(target, &chosen));
    }
    found
}

/// The estimate of what `resampled_seconds` returned.
pub fn estimate(resampled: &[f64]) -> Estimate {
    Estimate::new(resampled[0], resampled[1..].to_vec())
}

/// The ratio of two, turn by turn.
pub fn ratio(ours: &[f64], theirs: &[f64]) -> Vec<f64> {
    ours.iter().zip(theirs).map(|(a, b)| a / b).collect()
}

/// The geometric mean over scenes.
pub fn geometric_mean(ratios: &[Vec<f64>]) -> Vec<f64> {
    let Some(first) = ratios.first() else { return Vec::new() };
    let of = |i: usize| exp(ratios.iter().map(|r: &Vec<f64>| log(r[i])).sum::<f64>() / ratios.len() as f64);
    (0..first.len()).map(of).collect()
}

/// How far the mean of pictures is from that of others.
#[derive(Debug)]
pub struct Agreement {
    /// Whether there are enough pictures for their spread to tell the errors of tiles.
    pub judged: bool,
    /// Tiles times channels.
    pub tiles: usize,
    /// Tiles and channels farther apart than 1 % of the larger of the reference and 5 % of its image mean, plus 3 standard errors of both.
    pub disagreeing: usize,
    /// The largest difference over what is allowed.
    pub worst: f64,
    /// Relative difference of the image's mean, the worst channel.
    pub image_off: f64,
    /// It over 0.1 % plus 3 standard errors of both.
    pub image_excess: f64,
}

/// Compares means over tiles and over the whole; errors from the spread of the pictures.
pub fn agreement(ours: &[&[f32]], theirs: &[&[f32]], width: usize) -> Agreement {
    let (a, b) = (tile_moments(ours, width, TILES), tile_moments(theirs, width, TILES));
    let (whole_a, whole_b) = (tile_moments(ours, width, 1), tile_moments(theirs, width, 1));
    let excess = |i: usize, share: f64, a: &[[f64; 2]], b: &[[f64; 2]]| {
        let base = b[i][0].abs().max(0.05 * whole_b[i % 3][0].abs());
        (a[i][0] - b[i][0]).abs() / (share * base + 3.0 * hypot(a[i][1], b[i][1])).max(f64::MIN_POSITIVE)
    };
    let all: Vec<f64> = (0..a.len()).map(|i| excess(i, 0.01, &a, &b)).collect();
    let off = |i: usize| (whole_a[i][0] / whole_b[i][0] - 1.0).abs();
    Agreement {
        judged: ours.len().min(theirs.len()) >= ENOUGH,
        tiles: a.len(),
        disagreeing: all.iter().filter(|&&e| e > 1.0).count(),
        worst: all.into_iter().fold(0.0, f64::max),
        image_off: (0..3).map(off).fold(0.0, f64::max),
        image_excess: (0..3).map(|i| excess(i, 0.001, &whole_a, &whole_b)).fold(0.0, f64::max),
    }
}

/// Mean and standard error of each tile and channel over the pictures.
fn tile_moments(pictures: &[&[f32]], width: usize, tiles: usize) -> Vec<[f64; 2]> {
    let height = pictures.first().map_or(0, |p| p.len() / 3 / width.max(1));
    let mut of_each = vec![Vec::new(); tiles * tiles * 3];
    for picture in pictures {
        let mut sums = vec![[0.0, 0.0]; of_each.len()];
        for (i, &v) in picture.iter().enumerate() {
            let [x, y] = [i / 3 % width, i / 3 / width];
            let tile = y * tiles / height * tiles + x * tiles / width;
            sums[tile * 3 + i % 3][0] += f64::from(v);
            sums[tile * 3 + i % 3][1] += 1.0;
        }
        of_each.iter_mut().zip(sums).for_each(|(each, [sum, n])| each.push(sum / n));
    }
    let moments = |values: &Vec<f64>| {
        let (m, n) = (mean(values), values.len() as f64);
        [m, (values.iter().map(|v| square(v - m)).sum::<f64>() / (n - 1.0).max(1.0) / n).sqrt()]
    };
    of_each.iter().map(moments).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Pictures of the reference and uniform noise of standard deviation `sigma`.
    fn noisy(reference: &[f32], sigma: f64, count: u64, seed: u64) -> Vec<Vec<f32>> {
        let picture = |k| {
            let mut random = Random::new(seed + k);
            reference.iter().map(|&r| (f64::from(r) + sigma * 3f64.sqrt() * random.signed()) as f32).collect()
        };
        (0..count).map(picture).collect()
    }

    fn slices(pictures: &[Vec<f32>]) -> Vec<&[f32]> {
        pictures.iter().map(Vec::as_slice).collect()
    }

    #[test]
    fn errors_are_what_was_added() {
        let reference = vec![0.3f32; 3 * 64 * 64];
        let pictures = noisy(&reference, 0.03, 4, 1);
        let expected = 0.0009 / 0.1;
        let [plain, trimmed] = rel_mse(&pictures[0], &reference);
        assert!((plain / expected - 1.0).abs() < 0.03 && trimmed < plain, "{plain} {trimmed}");
        let spread = mean(&spread(&slices(&pictures), &reference));
        assert!((spread / expected - 1.0).abs() < 0.02, "{spread}");
        // An offset is an error, and no spread.
        let moved: Vec<Vec<f32>> = pictures.iter().map(|p| p.iter().map(|v| v + 0.1).collect()).collect();
        assert!(rel_mse(&moved[0], &reference)[0] > 0.1);
        assert!((mean(&super::spread(&slices(&moved), &reference)) / spread - 1.0).abs() < 1e-3);
        // One bright pixel of a thousand is in the plain error alone.
        let mut firefly = pictures[0].clone();
        firefly[5] = 100.0;
        let [with, without] = rel_mse(&firefly, &reference);
        assert!(with > 5.0 && (without / trimmed - 1.0).abs() < 0.01);
    }

    #[test]
    fn pilots_are_extrapolated() {
        assert!((samples_for(1e-3, [(16.0, 0.04), (64.0, 0.01)]) - 640.0).abs() < 1e-6);
        let faster = samples_for(1e-3, [(16.0, 0.08), (64.0, 0.01)]);
        assert!((faster - 64.0 * pow(10.0, 1.0 / 1.5)).abs() < 1e-6);
        assert!(samples_for(1e-3, [(16.0, 0.0), (64.0, 0.0)]) == 0.0);
    }

    #[test]
    fn intervals_hold_the_truth_as_often_as_they_say() {
        let mut held = 0;
        for trial in 0..100 {
            let mut random = Random::new(1000 + trial);
            let mut draw = || (0..16).map(|_| 1.0 + 0.2 * random.signed()).collect::<Vec<f64>>();
            let (render, error) = (draw(), draw());
            let runs = Runs { build: 0.5, render: &render, error: &error };
            let e = estimate(&resampled_seconds(&runs, 0.5, 7));
            held += usize::from(e.low <= 2.5 && 2.5 <= e.high);
        }
        assert!((85..=100).contains(&held), "{held}");
    }

    #[test]
    fn common_turns_make_ratios_sharper() {
        let mut random = Random::new(3);
        let load: Vec<f64> = (0..16).map(|_| 1.0 + 0.5 * random.unit()).collect();
        let twice: Vec<f64> = load.iter().map(|t| 2.0 * t).collect();
        let error = vec![1.0; 16];
        let of = |render| resampled_seconds(&Runs { build: 0.0, render, error: &error }, 1.0, 5);
        let found = estimate(&ratio(&of(&load), &of(&twice)));
        assert_eq!(found, Estimate { value: 0.5, low: 0.5, high: 0.5 });
        let both = geometric_mean(&[vec![0.5, 0.5], vec![2.0, 0.125]]);
        assert!((both[0] - 1.0).abs() < 1e-12 && (both[1] - 0.25).abs() < 1e-12);
    }

    #[test]
    fn wrong_means_are_seen_and_noise_is_not() {
        let reference: Vec<f32> = (0..3 * 64 * 64).map(|i| 0.2 + (i % 97) as f32 / 97.0).collect();
        let ours = noisy(&reference, 0.1, 8, 10);
        let theirs = noisy(&reference, 0.1, 8, 30);
        let same = agreement(&slices(&ours), &slices(&theirs), 64);
        assert!(same.disagreeing == 0 && same.image_excess < 1.0, "{same:?}");
        let brighter: Vec<Vec<f32>> = theirs.iter().map(|p| p.iter().map(|v| v * 1.05).collect()).collect();
        let other = agreement(&slices(&brighter), &slices(&ours), 64);
        assert!(other.disagreeing > 0 && other.image_excess > 1.0 && other.image_off > 0.04, "{other:?}");
    }
}
