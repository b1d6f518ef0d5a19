//! Warps, filters and distributions follow their densities.
#![allow(clippy::disallowed_methods)]

use etendue::math::Vec3;
use etendue::sampling::{Distribution1D, DistributionError, Filter, FilterSampler, warp};
use etendue_testkit::Rng;
use etendue_testkit::chi2::ChiSquare;

const TESTS: usize = 24;

fn direction(w: Vec3) -> Option<[f64; 3]> {
    assert!((w.length_squared() - 1.0).abs() < 4e-7, "{w} is not of unit length");
    Some(w.to_array().map(f64::from))
}

fn chi2(seed: u64) -> ChiSquare {
    ChiSquare::new(1_000_000).cells(150).seed(seed)
}

#[test]
fn hemispheres_and_spheres() {
    let cosine = |w: [f64; 3]| f64::from(warp::cosine_hemisphere_pdf(w[2] as f32));
    chi2(1).sphere(|rng| direction(warp::cosine_hemisphere(rng.f32x2())), cosine).assert(0.01, TESTS, "cosine");
    let uniform = |_: [f64; 3]| f64::from(warp::UNIFORM_HEMISPHERE_PDF);
    chi2(2).hemisphere(|rng| direction(warp::uniform_hemisphere(rng.f32x2())), uniform).assert(
        0.01,
        TESTS,
        "hemisphere",
    );
    let uniform = |_: [f64; 3]| f64::from(warp::UNIFORM_SPHERE_PDF);
    chi2(3).sphere(|rng| direction(warp::uniform_sphere(rng.f32x2())), uniform).assert(0.01, TESTS, "sphere");
}

#[test]
fn cosine_powers() {
    for (i, exponent) in [0.0f32, 1.0, 7.5, 300.0, 1e5].into_iter().enumerate() {
        // Resolved below the last place of an f32 cosine: the density's formula in f64.
        let pdf = |w: [f64; 3]| {
            let (sin, e) = (w[0].hypot(w[1]), f64::from(exponent));
            if w[2] > 0.0 { (e + 1.0) / std::f64::consts::TAU * (0.5 * e * (-sin * sin).ln_1p()).exp() } else { 0.0 }
        };
        let sample = |rng: &mut Rng| direction(warp::cosine_power_hemisphere(rng.f32x2(), exponent));
        chi2(10 + i as u64).sphere(sample, pdf).assert(0.01, TESTS, &format!("exponent {exponent}"));
        for k in 0..=100 {
            let cos = (1.0 - f64::from(k) * 0.02 / f64::from(exponent + 1.0)) as f32;
            let sin = (1.0 - f64::from(cos).powi(2)).max(0.0).sqrt();
            let (own, exact) =
                (f64::from(warp::cosine_power_hemisphere_pdf(cos, exponent)), pdf([sin, 0.0, cos.into()]));
            assert!((own - exact).abs() <= 1e-6 * exact, "exponent {exponent}, cosine {cos}: {own}, {exact}");
        }
    }
    assert_eq!(warp::cosine_power_hemisphere_pdf(-0.5, 2.0), 0.0);
}

#[test]
fn cones_however_narrow() {
    for (i, height) in [2.0f32, 0.5, 1e-4, 1e-9, 1e-14].into_iter().enumerate() {
        // The disk that the cone's directions span, scaled up: for narrow ones sin^2 = 2 h is uniform.
        let scale = 1.0 / f64::from(height);
        let sample = |rng: &mut Rng| {
            let w = direction(warp::uniform_cone(rng.f32x2(), height))?;
            let sin2 = w[0] * w[0] + w[1] * w[1];
            let h = if w[2] > 0.0 { sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt()) } else { 1.0 - w[2] };
            Some([h * scale, w[1].atan2(w[0])])
        };
        let pi = std::f64::consts::PI;
        let density = |_: [f64; 2]| f64::from(warp::uniform_cone_pdf(height)) * f64::from(height);
        // Rounding may pass the border by a unit of the last place.
        chi2(20 + i as u64).rectangle([0.0, 1.0 + 1e-6], [-pi, pi + 1e-6], sample, density).assert(
            0.01,
            TESTS,
            &format!("cone {height}"),
        );
    }
}

#[test]
fn disks_and_triangles() {
    let on_disk = |[x, y]: [f64; 2]| if x * x + y * y <= 1.0 { f64::from(warp::DISK_PDF) } else { 0.0 };
    let sample = |rng: &mut Rng| Some(warp::disk(rng.f32x2()).to_array().map(f64::from));
    chi2(30).rectangle([-1.0, 1.0], [-1.0, 1.0], sample, on_disk).assert(0.01, TESTS, "disk");
    let sample = |rng: &mut Rng| {
        let weights = warp::triangle(rng.f32x2());
        assert!(weights.iter().all(|&b| b >= 0.0) && (weights.iter().sum::<f32>() - 1.0).abs() < 2e-7, "{weights:?}");
        Some([f64::from(weights[0]), f64::from(weights[1])])
    };
    let on_triangle = |[x, y]: [f64; 2]| if x + y <= 1.0 { 2.0 } else { 0.0 };
    chi2(31).square(sample, on_triangle).assert(0.01, TESTS, "triangle");
}

/// Corners of the unit square and its centre give finite results.
#[test]
fn extreme_numbers() {
    let last = 1.0 - 1.0 / 16_777_216.0;
    for u in [0.0, 0.5, last] {
        for v in [0.0, 0.5, last] {
            let square = [u, v];
            for w in [
                warp::cosine_hemisphere(square),
                warp::cosine_power_hemisphere(square, 20.0),
                warp::cosine_power_hemisphere(square, 1e30),
                warp::uniform_hemisphere(square),
                warp::uniform_sphere(square),
                warp::uniform_cone(square, 1e-30),
            ] {
                direction(w);
            }
            assert!(warp::disk(square).length() <= 1.0 + 1e-6);
            for filter in Filter::ALL {
                let (p, _) = FilterSampler::new(filter).sample(square);
                assert!(p.is_finite() && p.abs().max_element() <= 3.0, "{filter}: {p}");
            }
        }
    }
}

#[test]
fn filters() {
    let boxed = FilterSampler::new(Filter::Box { radius: 0.5 });
    let sample = |rng: &mut Rng| Some(boxed.sample(rng.f32x2()).0.to_array().map(f64::from));
    chi2(40).rectangle([-0.5, 0.5], [-0.5, 0.5], sample, |_| 1.0).assert(0.01, TESTS, "box");
    for (i, (sigma, radius)) in [(0.5f64, 1.5f64), (0.3, 2.0), (2.0, 1.0)].into_iter().enumerate() {
        let filter = FilterSampler::new(Filter::Gaussian { sigma: sigma as f32, radius: radius as f32 });
        let one = |x: f64| (-0.5 * (x / sigma).powi(2)).exp();
        let whole = etendue_testkit::integrate_1d(one, [-radius, radius], 8, 1e-12);
        let sample = |rng: &mut Rng| Some(filter.sample(rng.f32x2()).0.to_array().map(f64::from));
        let r = radius + 1e-6;
        chi2(41 + i as u64).rectangle([-r, r], [-r, r], sample, |[x, y]| one(x) * one(y) / (whole * whole)).assert(
            0.01,
            TESTS,
            &format!("gaussian {sigma} {radius}"),
        );
        // The inverse of the distribution function, point by point and symmetric.
        for k in 0..1000u32 {
            let u = (k as f32 + 0.25) / 1000.0;
            let x = f64::from(filter.sample([u, 0.0]).0.x);
            let below = etendue_testkit::integrate_1d(one, [-radius, x], 8, 1e-12) / whole;
            assert!((below - f64::from(u)).abs() < 3e-7, "{u}: {below}");
        }
    }
    let filter = FilterSampler::new(Filter::default());
    let last = 1.0 - 1.0 / 16_777_216.0;
    assert_eq!(filter.sample([0.25, 0.0]).0, -filter.sample([last - 0.25, last]).0);
}

#[test]
fn distributions() {
    let weights = [0.0, 3.0, 1e-12, 0.0, 5.0, 0.5, 0.0];
    let distribution = Distribution1D::new(&weights).unwrap();
    let probabilities: Vec<f64> = (0..weights.len()).map(|i| f64::from(distribution.probability(i))).collect();
    let total: f64 = weights.iter().sum();
    for (p, w) in probabilities.iter().zip(weights) {
        assert!((p - w / total).abs() < 3e-7 && (*p > 0.0) == (w > 0.0), "{p} for weight {w}");
    }
    assert_eq!(probabilities.iter().sum::<f64>(), 1.0);
    let index = |rng: &mut Rng| {
        let choice = distribution.choose(rng.f32())?;
        assert_eq!(choice.probability, distribution.probability(choice.index));
        Some(choice.index)
    };
    chi2(50).indices(&probabilities, index).assert(0.01, TESTS, "indices");
    // The number that is left is uniform, and independent of the choice.
    let left = |rng: &mut Rng| {
        let choice = distribution.choose(rng.f32())?;
        Some([(choice.index as f64 + rng.f64()) / weights.len() as f64, f64::from(choice.remapped)])
    };
    let density = |[x, _]: [f64; 2]| f64::from(distribution.pdf(x as f32));
    chi2(51).square(left, density).assert(0.01, TESTS, "remapped");
    let number = |rng: &mut Rng| {
        let (x, pdf) = distribution.sample(rng.f32())?;
        assert_eq!(pdf, distribution.pdf(x), "at {x}");
        Some(f64::from(x))
    };
    let density = |x: f64| f64::from(distribution.pdf(x as f32));
    chi2(52).interval([0.0, 1.0], number, density).assert(0.01, TESTS, "numbers");
}

#[test]
fn distributions_at_the_limits() {
    for empty in [&[][..], &[0.0], &[0.0; 5]] {
        let distribution = Distribution1D::new(empty).unwrap();
        assert!(distribution.is_empty() && distribution.choose(0.3).is_none() && distribution.sample(0.3).is_none());
        assert_eq!([distribution.pdf(0.5), distribution.probability(0)], [0.0; 2]);
    }
    for (bad, at) in [([1.0, -1.0], 1), ([f64::NAN, 1.0], 0), ([1.0, f64::INFINITY], 1)] {
        assert_eq!(Distribution1D::new(&bad), Err(DistributionError::Invalid(at)));
    }
    let many = Distribution1D::MAX_LEN;
    assert_eq!(Distribution1D::new(&vec![1.0; many + 1]), Err(DistributionError::TooMany(many + 1)));
    // One giant among many dwarfs, and sums beyond the range.
    let mut weights = vec![f64::MAX; 3];
    weights.extend(vec![f64::MIN_POSITIVE; 100_000]);
    let distribution = Distribution1D::new(&weights).unwrap();
    let total: f64 = (0..weights.len()).map(|i| f64::from(distribution.probability(i))).sum();
    assert_eq!(total, 1.0);
    assert!((0..weights.len()).all(|i| distribution.probability(i) > 0.0));
    assert!((distribution.probability(1) - 1.0 / 3.0).abs() < 0.01);
    let last = distribution.choose(1.0 - 1.0 / 16_777_216.0).unwrap();
    assert_eq!(last.index, weights.len() - 1);
    assert_eq!(distribution.choose(0.0).unwrap().index, 0);
    assert_eq!(distribution.probability(usize::MAX), 0.0);
}
