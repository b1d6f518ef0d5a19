//! How many parts a sample is worth being split into, and whether its light samples are worth being resampled, from few samples all
//! over the picture.
//!
//! With c0 the cost of a sample before it is split and V0 the variance that comes of it, c and V those of a part, a picture in n parts a
//! sample has r = (c0 + n c) / (c0 + c) times fewer samples in the same time than one of whole samples (Arvo and Kirk, "Particle
//! Transport and Image Synthesis", 1990). Where samples are stratified its variance is V0 r^(3/2) + V r / n then: what comes before the
//! split are edges in the pixel, which strata resolve, what follows are many dimensions, for which they do little. Costs are counted in
//! rays, so that the choice is the same on every machine; it depends neither on crop, seed, nor number of samples.

use super::{
    Integrator, MAX_PARTS, Splitting,
    resampling::CANDIDATES,
    wave::{Context, Counters, Wave},
};
use crate::{parallel, render::RenderSettings};

/// Most pixels on a side.
const SIDE: u32 = 32;
/// Least of them where resampling alone is open, with which it is found where it is worth much, and pixels of the picture to one of
/// these on a side: less than 1 % of 16 samples then, but in pictures below 384 x 384.
const LEAST_SIDE: u32 = 12;
const APART: f64 = 32.0;
/// Samples of each in each of the two halves.
const SAMPLES: u32 = 4;
/// Parts of each sample.
const PARTS: u32 = 4;
const SEED: u64 = 0x7069_6c6f_7400;
/// Paths of the wave.
const WAVE: usize = 256;
/// Added to the square of a pixel's mean, as in the relative error of pictures.
const DARK: f64 = 0.01;
/// Radiance that no pixel has.
const TOO_LARGE: f32 = 1e11;
/// Samples of a half in a picture that the choice is made for.
const TYPICAL: f64 = 32.0;
/// More parts must bring the error below this times what fewer bring: finer steps in the number of samples have their worth too.
const WORTH: f64 = 0.97;

/// A candidate for a light sample costs so many rays, in about: among 10 lamps, 1,000 and 100,000.
const COST: f64 = 0.6;
/// Resampling must bring the error below this times what it is without: so few samples cannot tell better.
const WORTH_RESAMPLING: f64 = 0.9;

/// What parts share is not taken to be less than this times what they do not: so few samples cannot tell.
const LEAST_SHARED: f64 = 0.01;

/// Means of a pixel's two halves, over each of the parts, by colour.
type Means = [[[f64; 3]; PARTS as usize]; 2];

/// Choices that a scene is rendered with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Worthwhile {
    /// Parts of a sample, from 1 to [`MAX_PARTS`].
    pub parts: u32,
    /// True if first vertices resample light.
    pub resamples: bool,
}

/// The choices with the least error for their time in a picture of `resolution` pixels, but for those that `settings` make.
/// Once `is_cancelled` they may be any.
pub(crate) fn worthwhile(
    context: &Context,
    resolution: [u32; 2],
    settings: &RenderSettings,
    is_cancelled: impl Fn() -> bool + Sync,
) -> Worthwhile {
    let RenderSettings { splitting, resampling, .. } = *settings;
    let is_path = context.integrator.is_solver() && context.max_depth >= 2;
    let samples_light = is_path && context.integrator != Integrator::Brute;
    // Few lights are chosen by what each may bring.
    let is_open = resampling.is_none() && samples_light && context.scene.lights().has_clusters();
    let plain = resampling.unwrap_or(false);
    if !is_path || (splitting.is_some() && !is_open) {
        return Worthwhile { parts: splitting.unwrap_or(1), resamples: plain };
    }
    // Numbers of parts differ by less.
    let side = if splitting.is_some() { side(resolution) } else { SIDE };
    let look = |resamples: bool| {
        let (rays, variance) = look(&Context { resamples, ..context.clone() }, resolution, side, &is_cancelled);
        let more = if resamples { COST * f64::from(CANDIDATES - 1) } else { 0.0 };
        best(Costs { before: 1.0, after: (rays - 1.0) / f64::from(PARTS) + more }, &variance, splitting)
    };
    let (error, parts) = look(plain);
    if is_open {
        let (resampled_error, parts) = look(true);
        if resampled_error < error * WORTH_RESAMPLING {
            return Worthwhile { parts, resamples: true };
        }
    }
    Worthwhile { parts, resamples: plain }
}

/// Pixels on a side for a decision that many pixels agree on, few in small pictures.
fn side([width, height]: [u32; 2]) -> u32 {
    let side = (f64::from(width) * f64::from(height)).sqrt() / APART;
    (side as u32).clamp(LEAST_SIDE, SIDE)
}

/// Rays a sample, and variances, all over the picture, from at most `side`^2 of its pixels.
fn look(
    context: &Context,
    resolution: [u32; 2],
    side: u32,
    is_cancelled: &(impl Fn() -> bool + Sync),
) -> (f64, Variance) {
    let splitting = Splitting { parts: PARTS, apart: true };
    let context = Context { seed: SEED, splitting, wants_layers: false, wants_direct: false, ..context.clone() };
    let [across, down] = resolution.map(|pixels| middles(pixels, side));
    let rows = parallel::map(down.len(), |row| {
        if is_cancelled() { Default::default() } else { measure(&context, &across, down[row]) }
    });
    let mut variance = Variance::default();
    let (mut rays, mut paths) = (0, 0);
    for (row, counters) in rows {
        variance.shared += row.shared;
        variance.own += row.own;
        (rays, paths) = (rays + counters.rays, paths + counters.paths);
    }
    (rays as f64 / paths.max(1) as f64, variance)
}

/// The variances in the pixels of a row at these columns, in order, and what they took.
fn measure(context: &Context, columns: &[u32], row: u32) -> (Variance, Counters) {
    let mut means = [Means::default(); SIDE as usize];
    let mut samples = columns.iter().flat_map(|&x| (0..2 * SAMPLES).map(move |index| ([x, row], index)));
    let counters = Wave::new(WAVE).run(context, &mut samples, &mut |[x, _], index, sample| {
        let Ok(column) = columns.binary_search(&x) else { return };
        let mean = &mut means[column][(index & 1) as usize][sample.part as usize];
        for (mean, value) in mean.iter_mut().zip(sample.radiance.0) {
            // What is too large counts as nothing, as on the film.
            let value = if value.abs() < TOO_LARGE { f64::from(value) } else { 0.0 };
            *mean += value * f64::from(PARTS) / f64::from(SAMPLES);
        }
    });
    let mut variance = Variance::default();
    means[..columns.len()].iter().for_each(|means| variance.add(means));
    (variance, counters)
}

/// The pixels in the middle of equal parts of so many, in order.
fn middles(pixels: u32, side: u32) -> Vec<u32> {
    let middle = |part: u32| (u64::from(2 * part + 1) * u64::from(pixels) / u64::from(2 * side)) as u32;
    let mut middles: Vec<u32> = (0..side).map(middle).collect();
    middles.dedup();
    middles
}

/// Relative variances of a half's mean, summed over pixels.
#[derive(Clone, Copy, Debug, Default)]
struct Variance {
    /// What all parts of a sample have in common.
    shared: f64,
    /// What each has by itself.
    own: f64,
}

impl Variance {
    /// Twice each, from the difference of two halves: its square over a part is both, its product over two parts what they share.
    fn add(&mut self, halves: &Means) {
        let [even, odd] = halves;
        for channel in 0..3 {
            let (mut total, mut sum, mut mean) = (0.0, 0.0, 0.0);
            for (even, odd) in even.iter().zip(odd) {
                let difference = even[channel] - odd[channel];
                total += difference * difference;
                sum += difference;
                mean += even[channel] + odd[channel];
            }
            let n = f64::from(PARTS);
            let shared = (sum * sum - total) / (n * (n - 1.0));
            mean /= 2.0 * n;
            let scale = 1.0 / (mean * mean + DARK);
            self.shared += shared * scale;
            self.own += (total / n - shared) * scale;
        }
    }
}

/// What a sample costs before it is split, and each of its parts, in rays.
#[derive(Clone, Copy, Debug)]
struct Costs {
    before: f64,
    after: f64,
}

/// The least variance times time, and for how many parts it is: a power of two, or `given`.
fn best(Costs { before, after }: Costs, variance: &Variance, given: Option<u32>) -> (f64, u32) {
    // In a picture of some samples more than the pilot has.
    let shared = variance.shared.max(LEAST_SHARED * variance.own) * (f64::from(SAMPLES) / TYPICAL).sqrt();
    let error = |parts: u32| {
        let n = f64::from(parts);
        let fewer = (before + n * after) / (before + after);
        (shared * fewer * fewer.sqrt() + variance.own * fewer / n) * (before + after)
    };
    if let Some(parts) = given {
        return (error(parts), parts);
    }
    let mut best = 1;
    for more in (1..=MAX_PARTS.ilog2()).map(|log| 1 << log) {
        if error(more) < error(best) * WORTH {
            best = more;
        }
    }
    (error(best), best)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_error_is_found() {
        let best_of = |after, shared, own| best(Costs { before: 1.0, after }, &Variance { shared, own }, None).1;
        assert_eq!(best_of(2.0, 1.0, 0.0), 1, "nothing comes of parts");
        assert_eq!(best_of(2.0, 1.0, 1.0), 1);
        // 1, 5/3 and 3 times fewer samples: 0.071 + 1, 0.071 * 2.15 + 5/6, 0.071 * 5.20 + 3/4.
        assert_eq!(best_of(2.0, 0.2, 1.0), 2);
        assert_eq!(best_of(2.0, 0.05, 1.0), 4);
        assert_eq!(best_of(2.0, -0.5, 1.0), best_of(2.0, 0.01, 1.0), "too few samples to tell");
        assert!(best_of(0.01, 0.0, 1.0) == MAX_PARTS && best_of(2.0, f64::NAN, f64::NAN) == 1);
    }

    /// Of numbers whose variances are known.
    #[test]
    fn variances_are_told_apart() {
        let mut stream =
            crate::sampling::Sampler::Independent.stream(Default::default(), 0, crate::sampling::Slot::Time);
        let mut draw = |deviation: f64| deviation * 12f64.sqrt() * (f64::from(stream.next_f32()) - 0.5);
        let mut variance = Variance::default();
        let pixels = 20_000;
        for _ in 0..pixels {
            let mut means = Means::default();
            for half in &mut means {
                let shared = draw(0.03);
                for part in half {
                    *part = [1.0 + shared + draw(0.05); 3];
                }
            }
            variance.add(&means);
        }
        let each = |sum: f64| (sum / (2.0 * 3.0 * f64::from(pixels)) * (1.0 + DARK)).sqrt();
        let (shared, own) = (each(variance.shared), each(variance.own));
        assert!((shared - 0.03).abs() < 1e-3 && (own - 0.05).abs() < 1e-3, "{shared} {own}");
    }
}
