//! Why directions are drawn afresh: a pool that is filled once and handed out in turn repeats itself and ties pixels together.

use etendue::{
    math::Vec3,
    sampling::{Sampler, Slot, warp},
};

/// Directions of a pool.
const POOL: usize = 1024;
/// Pools, or sets of pixels, that errors are taken over.
const TRIALS: u64 = 256;
/// Numbers of a pixel.
const SAMPLES: usize = 8 * POOL;

/// What is gathered: a strip of light low in the sky, as seen by a diffuse surface. Its mean over cosine-distributed directions is
/// the measure of the azimuths times that of the elevations, 1/4 * (0.4^2 - 0.2^2).
fn strip(direction: Vec3) -> f64 {
    let inside = direction.x > 0.0 && direction.y > 0.0 && (0.2..0.4).contains(&direction.z);
    f64::from(u8::from(inside))
}

fn exact() -> f64 {
    0.25 * (0.4f64 * 0.4 - 0.2 * 0.2)
}

/// A direction that is a function of the pixel and the sample alone.
fn drawn(seed: u64, pixel: u32, sample: usize) -> Vec3 {
    let key = Sampler::Independent.key(seed, [pixel, 0], sample as u32);
    warp::cosine_hemisphere(Sampler::Independent.two_d(key, 1, Slot::BsdfDirection))
}

/// Errors of two pixels, for many fillings of the pool.
fn errors(direction: impl Fn(u64, u32, usize) -> Vec3) -> Vec<[f64; 2]> {
    let pixel = |seed, pixel| {
        let sum: f64 = (0..SAMPLES).map(|sample| strip(direction(seed, pixel, sample))).sum();
        sum / SAMPLES as f64 - exact()
    };
    (0..TRIALS).map(|seed| [pixel(seed, 0), pixel(seed, 1)]).collect()
}

fn mean_square(errors: &[[f64; 2]]) -> f64 {
    errors.iter().map(|[a, b]| a * a + b * b).sum::<f64>() / (2 * errors.len()) as f64
}

fn correlation(errors: &[[f64; 2]]) -> f64 {
    errors.iter().map(|[a, b]| a * b).sum::<f64>() / errors.len() as f64 / mean_square(errors)
}

#[test]
fn presampled_direction_pools_repeat_and_correlate() {
    let from_pool = errors(|seed, pixel, sample| {
        // Pixel after pixel goes round the pool, wherever the one before it stopped.
        let next = (pixel as usize * SAMPLES + sample) % POOL;
        drawn(seed, 0, next)
    });
    let fresh = errors(drawn);
    // One sample's variance is p (1 - p): the pool's error stays that of its own size, however many samples are taken.
    let variance = exact() * (1.0 - exact());
    let (pool_samples, fresh_samples) = (variance / mean_square(&from_pool), variance / mean_square(&fresh));
    assert!((pool_samples / POOL as f64 - 1.0).abs() < 0.3, "{SAMPLES} samples are worth {pool_samples}");
    assert!((fresh_samples / SAMPLES as f64 - 1.0).abs() < 0.3, "{SAMPLES} samples are worth {fresh_samples}");
    // And both pixels have the same error, so that it is no noise but a wrong picture.
    assert!(correlation(&from_pool) > 0.999, "{}", correlation(&from_pool));
    assert!(correlation(&fresh).abs() < 0.25, "{}", correlation(&fresh));
}
