//! Filters: where samples go, what they weigh, and that both together are the filter.
#![allow(clippy::disallowed_methods)]

mod common;

use common::{Parts, camera, interleaved, picture, statistics};
use etendue::{
    integrator::Integrator,
    math::dvec3,
    render::RenderSettings,
    sampling::{Filter, FilterSampler},
    spectrum::Spectrum,
};
use etendue_testkit::{Moments, Rng, chi2::ChiSquare, integrate_1d, sidak, ttest::t_test};
use std::f64::consts::PI;

const FILTERS: [Filter; 10] = [
    Filter::Box { radius: 0.75 },
    Filter::Tent { radius: 1.0 },
    Filter::Tent { radius: 2.5 },
    Filter::Gaussian { sigma: 0.5, radius: 1.5 },
    Filter::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0, radius: 2.0 },
    Filter::Mitchell { b: 0.0, c: 0.5, radius: 1.7 },
    Filter::Mitchell { b: 1.0, c: 0.0, radius: 3.0 },
    Filter::Lanczos { radius: 2.0 },
    Filter::Lanczos { radius: 3.0 },
    Filter::Lanczos { radius: 3.6 },
];

fn radius(filter: Filter) -> f64 {
    let (Filter::Box { radius }
    | Filter::Tent { radius }
    | Filter::Gaussian { radius, .. }
    | Filter::Mitchell { radius, .. }
    | Filter::Lanczos { radius }) = filter;
    f64::from(radius)
}

/// The filters as they are published, not normalised.
fn reference(filter: Filter, x: f64) -> f64 {
    let sinc = |x: f64| if x == 0.0 { 1.0 } else { (PI * x).sin() / (PI * x) };
    match filter {
        Filter::Box { .. } => 1.0,
        Filter::Tent { radius } => 1.0 - x.abs() / f64::from(radius),
        Filter::Gaussian { sigma, .. } => (-0.5 * (x / f64::from(sigma)).powi(2)).exp(),
        Filter::Mitchell { b, c, radius } => {
            let (b, c, t) = (f64::from(b), f64::from(c), x.abs() * 2.0 / f64::from(radius));
            let near = (12.0 - 9.0 * b - 6.0 * c) * t.powi(3) + (-18.0 + 12.0 * b + 6.0 * c) * t * t + 6.0 - 2.0 * b;
            let far = (-b - 6.0 * c) * t.powi(3) + (6.0 * b + 30.0 * c) * t * t + (-12.0 * b - 48.0 * c) * t;
            if t < 1.0 { near } else { far + 8.0 * b + 24.0 * c }
        }
        Filter::Lanczos { radius } => sinc(x) * sinc(x / f64::from(radius)),
    }
}

/// The integral of the filter's shape times `f`.
fn integral(filter: Filter, f: impl Fn(f64) -> f64) -> f64 {
    let r = radius(filter);
    integrate_1d(|x| reference(filter, x) * f(x), [-r, r], 64, 1e-10)
}

/// The size that a signed filter's weights have along one axis: the integral of its magnitude over its own.
fn magnitude(filter: Filter) -> f64 {
    let r = radius(filter);
    integrate_1d(|x| reference(filter, x).abs(), [-r, r], 64, 1e-10) / integral(filter, |_| 1.0)
}

#[test]
fn places_follow_the_magnitude() {
    for (i, filter) in FILTERS.into_iter().enumerate() {
        let sampler = FilterSampler::new(filter);
        let r = radius(filter);
        let total = magnitude(filter) * integral(filter, |_| 1.0);
        let density = |x: f64| reference(filter, x).abs() / total;
        let place = |rng: &mut Rng| Some(f64::from(sampler.sample(rng.f32x2()).0.y));
        let test = ChiSquare::new(400_000).seed(i as u64).cells(48);
        test.interval([-r, r], place, density).assert(0.01, FILTERS.len(), &format!("{filter:?}"));
    }
}

/// Weights have one size and the sign of the lobe; without negative lobes they are exactly 1.
#[test]
fn weights_have_one_size_and_the_sign_of_the_lobe() {
    let mut rng = Rng::new(9);
    for filter in FILTERS {
        let (sampler, size) = (FilterSampler::new(filter), magnitude(filter).powi(2));
        let (mut negative, mut close) = (0, 0);
        for _ in 0..20_000 {
            let (p, weight) = sampler.sample(rng.f32x2());
            // Where a filter is all but 0 its places are drawn a little more often, and weigh less.
            let ratio = f64::from(weight.abs()) / size;
            assert!(ratio < 1.001, "{filter:?} at {p}: {weight}, not {size}");
            close += u32::from(ratio > 0.999);
            let value = reference(filter, p.x.into()) * reference(filter, p.y.into());
            assert!(value * f64::from(weight) > 0.0 || value.abs() < 1e-2, "{filter:?} at {p}: {weight}");
            negative += u32::from(weight < 0.0);
        }
        assert_eq!(negative > 0, size > 1.0 + 1e-9, "{filter:?}");
        assert!(close > 19_000, "{filter:?}: {close} of 20000");
    }
    for filter in [Filter::Box { radius: 0.5 }, Filter::Tent { radius: 1.0 }, Filter::default()] {
        let sampler = FilterSampler::new(filter);
        assert!((0..1000).all(|_| sampler.sample(rng.f32x2()).1 == 1.0), "{filter:?}");
    }
}

/// Weighted means over the places are integrals against the filter: of 1, of moments, of waves.
#[test]
fn weighted_means_are_filtered_values() {
    type Value = (&'static str, fn(f64, f64) -> f64);
    let values: [Value; 4] = [
        ("1", |_, _| 1.0),
        ("x^2", |x, _| x * x),
        ("x^2 y^2", |x, y| x * x * y * y),
        ("wave", |x, y| (2.0 * x).cos() * (1.1 * y).cos() + x - 3.0 * y),
    ];
    let level = sidak(0.01, FILTERS.len() * values.len());
    for filter in FILTERS {
        let sampler = FilterSampler::new(filter);
        let unit = integral(filter, |_| 1.0);
        let second = integral(filter, |x| x * x) / unit;
        let wave = |f: f64| integral(filter, |x| (f * x).cos()) / unit;
        let exact = [1.0, second, second * second, wave(2.0) * wave(1.1)];
        for ((name, f), exact) in values.into_iter().zip(exact) {
            let mut rng = Rng::new(77);
            let estimates: Moments = (0..200_000)
                .map(|_| {
                    let (p, weight) = sampler.sample(rng.f32x2());
                    f64::from(weight) * f(p.x.into(), p.y.into())
                })
                .collect();
            if estimates.variance() > 1e-9 {
                t_test(&estimates, exact).assert(level, &format!("{filter:?}: {name}"));
            }
        }
    }
}

/// The mean weight over all numbers that a sampler can give is 1 but for rounding: a constant image stays what it is.
#[test]
fn a_constant_is_kept() {
    for filter in FILTERS {
        let sampler = FilterSampler::new(filter);
        let steps = 1 << 20;
        let along = |u: f32| f64::from(sampler.sample([u, 0.5]).1 / sampler.sample([0.5, 0.5]).1);
        let mean = (0..steps).map(|i| along(i as f32 / steps as f32)).sum::<f64>() / f64::from(steps);
        assert!((mean * magnitude(filter) - 1.0).abs() < 2e-4, "{filter:?}: {}", mean * magnitude(filter));
    }
    let mut parts = Parts::default();
    parts.0.environment = Some(Spectrum([0.5, 1.0, 2.0]).into());
    let scene = parts.build();
    let view = camera(dvec3(0.0, 0.0, 3.0), dvec3(0.0, 0.0, 0.0));
    for filter in Filter::ALL {
        let settings = RenderSettings { filter, ..statistics(Integrator::Path, 64) };
        let image = interleaved(&picture(&scene, &view, [64, 64], &settings));
        let means: Moments = image.chunks(3).map(|p| f64::from(p[1])).collect();
        if means.variance() > 0.0 {
            t_test(&means, 1.0).assert(0.001, filter.name());
        } else {
            assert!(image.chunks(3).all(|p| p == [0.5, 1.0, 2.0]), "{filter}");
        }
    }
}

/// A step edge, rendered: the profile that the filter's integral gives, over- and undershoot included.
#[test]
fn an_edge_rings_as_the_filter_says() {
    let mut parts = Parts::default();
    let glow = parts.emitter([1.0; 3], true);
    // The right half of the picture, far beyond its borders.
    parts.rectangle(dvec3(0.0, -50.0, 0.0), dvec3(50.0, 0.0, 0.0), dvec3(0.0, 100.0, 0.0), glow);
    let scene = parts.build();
    let view = camera(dvec3(0.0, 0.0, 10.0), dvec3(0.0, 0.0, 0.0));
    for filter in [Filter::Lanczos { radius: 3.0 }, Filter::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0, radius: 2.0 }] {
        let settings = RenderSettings { filter, ..statistics(Integrator::Path, 256) };
        let image = interleaved(&picture(&scene, &view, [16, 64], &settings));
        let unit = integral(filter, |_| 1.0);
        for x in 0..16u32 {
            let offset = f64::from(x) + 0.5 - 8.0;
            let exact = integrate_1d(
                |t| if t > -offset { reference(filter, t) / unit } else { 0.0 },
                [-radius(filter), radius(filter)],
                512,
                1e-7,
            );
            let column: Moments = (0..64).map(|y| f64::from(image[(y * 16 + x as usize) * 3])).collect();
            if column.variance() > 1e-12 {
                t_test(&column, exact).assert(sidak(0.01, 32), &format!("{filter} at {offset}"));
            } else {
                assert!((column.mean() - exact).abs() < 1e-3, "{filter} at {offset}: {}", column.mean());
            }
        }
    }
}
