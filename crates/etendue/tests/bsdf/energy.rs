//! No surface gives more light than it gets; those that should give all do.

use crate::cases::{Case, cases, draw, outgoing, random_direction};
use etendue::{bsdf::Bsdf, math::Vec3, spectrum::Spectrum};
use etendue_testkit::{Moments, Rng, sidak, ttest};

/// What `wo` sees in a furnace, over what it would see without the surface. A furnace is radiance proportional to the
/// square of the index of refraction, the equilibrium of radiation.
fn seen_in_furnace(case: &Case, wo: Vec3, samples: usize, rng: &mut Rng) -> [Moments; 3] {
    let mut seen = [Moments::new(), Moments::new(), Moments::new()];
    for _ in 0..samples {
        let radiance = draw(&case.bsdf, wo, rng).map_or(Spectrum::BLACK, |s| s.weight * (s.eta * s.eta));
        for (moments, value) in seen.iter_mut().zip(radiance.0) {
            moments.push(f64::from(value));
        }
    }
    seen
}

/// Mean weight <= 1 from all angles, and = 1 where nothing is lost.
#[test]
fn white_furnace() {
    let mut rng = Rng::new(4);
    for case in cases() {
        let mut tried = outgoing();
        tried.extend((0..10).map(|_| random_direction(&mut rng)));
        for wo in tried {
            for seen in seen_in_furnace(&case, wo, 2000, &mut rng) {
                let error = 5.0 * seen.standard_error() + 2e-6;
                assert!(seen.mean() <= 1.0 + error, "{} from {wo}: {}", case.name, seen.mean());
                if case.lossless {
                    assert!((seen.mean() - 1.0).abs() <= error, "{} from {wo}: {}", case.name, seen.mean());
                }
            }
        }
    }
}

/// Sampling and eval agree in how much is scattered: light gathered with uniform directions is the same on average.
#[test]
fn albedo_by_uniform_directions_equals_albedo_by_sampling() {
    let samples = 20_000;
    let cases: Vec<_> = cases().into_iter().filter(|case| !case.bsdf.is_delta() && !narrow(case)).collect();
    let outgoing = outgoing();
    let level = sidak(0.01, cases.len() * outgoing.len());
    for (i, case) in cases.iter().enumerate() {
        for (j, &wo) in outgoing.iter().enumerate() {
            let mut rng = Rng::new((1000 + i * 100 + j) as u64);
            let (mut uniform, mut sampled) = (Moments::new(), Moments::new());
            for _ in 0..samples {
                let wi = random_direction(&mut rng);
                uniform.push(f64::from(case.bsdf.eval(wo, wi).value.mean()) * 4.0 * std::f64::consts::PI);
                sampled.push(draw(&case.bsdf, wo, &mut rng).map_or(0.0, |s| match s.density {
                    etendue::bsdf::Density::SolidAngle(_) => f64::from(s.weight.mean()),
                    _ => 0.0,
                }));
            }
            ttest::welch(&uniform, &sampled).assert(level, &format!("{} from {wo}", case.name));
        }
    }
}

/// Lobes that uniform directions hardly find.
fn narrow(case: &Case) -> bool {
    ["alpha 0.02", "0.05", "0.01", "ior 1.1 "].iter().any(|part| case.name.contains(part))
}

/// The albedo image's value: in [0, 1], and exact where albedo does not depend on the angle.
#[test]
fn albedo_is_what_is_scattered_along_the_normal() {
    for case in cases() {
        let albedo = case.bsdf.albedo();
        assert!(albedo.min_component() >= 0.0 && albedo.max_component() <= 1.0 + 1e-6, "{}: {albedo:?}", case.name);
        let exact = !matches!(
            case.bsdf,
            Bsdf::RoughGlass(_) | Bsdf::RoughMetal(_) | Bsdf::BrushedMetal(_) | Bsdf::Mtl(_) | Bsdf::Principled(_)
        );
        let mut rng = Rng::new(6);
        let seen = seen_in_furnace(&case, Vec3::Z, 10_000, &mut rng);
        for (c, seen) in seen.iter().enumerate() {
            let (mean, error) = (seen.mean(), 5.0 * seen.standard_error() + 1e-5);
            assert!(mean <= f64::from(albedo[c]) + error + if exact { 0.0 } else { 0.02 }, "{}", case.name);
            assert!(!exact || mean >= f64::from(albedo[c]) - error, "{}: {mean} {albedo:?}", case.name);
        }
    }
}
