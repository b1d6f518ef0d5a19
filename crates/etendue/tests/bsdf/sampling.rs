//! `sample` and `eval` tell the same story.

use crate::cases::{cases, draw, outgoing, random_direction};
use etendue::{
    bsdf::{Bsdf, BsdfEval, Density},
    math::{Vec3, vec3},
};
use etendue_testkit::{
    Rng,
    chi2::{ChiSquare, Drawn},
};

/// The probabilities of the discrete outcomes, [reflected, transmitted], as the samples state them.
fn discrete_probabilities(bsdf: &Bsdf, wo: Vec3) -> [f64; 2] {
    let mut probabilities = [0.0; 2];
    let mut rng = Rng::new(11);
    for _ in 0..2000 {
        if let Some(sample) = draw(bsdf, wo, &mut rng)
            && let Density::Discrete(p) = sample.density
        {
            probabilities[usize::from(sample.transmitted)] = f64::from(p);
        }
    }
    probabilities
}

/// Directions are distributed as `eval` says, discrete ones as often as they say, and what is missing to 1 is lost.
#[test]
fn samples_follow_their_density() {
    let cases = cases();
    let outgoing = outgoing();
    let prove = std::env::var("ETENDUE_PROVE").is_ok_and(|v| v == "1");
    let (samples, cells) = if prove { (500_000, 400) } else { (40_000, 200) };
    let tests = cases.len() * outgoing.len();
    for (i, case) in cases.iter().enumerate() {
        for (j, &wo) in outgoing.iter().enumerate() {
            // All angles, but at each only one side, in turn: what is behind is compared with the front elsewhere.
            if !prove && (i + j / 2 + j) % 2 == 1 {
                continue;
            }
            let sample = |rng: &mut Rng| match draw(&case.bsdf, wo, rng) {
                None => Drawn::Nothing,
                Some(sample) => match sample.density {
                    Density::SolidAngle(_) => Drawn::Point(sample.wi.to_array().map(f64::from)),
                    // Tested in its own measure in brushed_metal.rs.
                    Density::Arc(_) => Drawn::Nothing,
                    Density::Discrete(_) => Drawn::Discrete(usize::from(sample.transmitted)),
                },
            };
            let pdf = |w: [f64; 3]| f64::from(case.bsdf.eval(wo, vec3(w[0] as f32, w[1] as f32, w[2] as f32)).pdf);
            // Where frosted glass is entered along its surface, the density beyond is infinite at the critical angle and
            // zero behind it: the rounding of directions takes some across.
            let has_pole = matches!(case.bsdf, Bsdf::Phong(_)) && case.index != 1.0;
            ChiSquare::new(samples)
                .stray_fraction(if has_pole { 5e-4 } else { 1e-5 })
                .cells(cells)
                .seed((i * 100 + j) as u64)
                .discrete(&discrete_probabilities(&case.bsdf, wo))
                .sphere(sample, pdf)
                .assert(0.01, tests, &format!("{} from {wo}", case.name));
        }
    }
}

/// In one call: weight times density is the value that `eval` gives for the direction, at the same density.
#[test]
fn weights_are_value_over_density() {
    let mut rng = Rng::new(1);
    for case in cases() {
        for wo in outgoing() {
            for _ in 0..300 {
                let Some(sample) = draw(&case.bsdf, wo, &mut rng) else { continue };
                let Density::SolidAngle(density) = sample.density else { continue };
                let BsdfEval { value, pdf } = case.bsdf.eval(wo, sample.wi);
                assert!((pdf - density).abs() <= 1e-5 * density, "{}: pdf {pdf}, density {density}", case.name);
                for c in 0..3 {
                    let expected = sample.weight[c] * density;
                    // The weight of a refraction uses the sampled facet, eval the half vector; near grazing facets
                    // Fresnel's formulas are steep.
                    let tolerance = 2e-3 * expected + 1e-6 * density;
                    assert!((value[c] - expected).abs() <= tolerance, "{} from {wo}: {sample:?}, {value:?}", case.name);
                }
            }
        }
    }
}

/// Unit vectors, on the side that is claimed, with the index that belongs to that side.
#[test]
fn directions_are_on_the_side_they_claim() {
    let mut rng = Rng::new(2);
    for case in cases() {
        let mut tried = outgoing();
        tried.extend((0..20).map(|_| random_direction(&mut rng)));
        for wo in tried {
            for _ in 0..200 {
                let Some(sample) = draw(&case.bsdf, wo, &mut rng) else { continue };
                assert!((sample.wi.length() - 1.0).abs() < 1e-6, "{}: {sample:?}", case.name);
                assert!(sample.wi.z != 0.0);
                assert_eq!(sample.transmitted, (sample.wi.z > 0.0) != (wo.z > 0.0), "{}: {sample:?}", case.name);
                let eta = if matches!(case.bsdf, Bsdf::Diffuse(_)) {
                    1.0
                } else {
                    case.index_at(sample.wi) / case.index_at(wo)
                };
                assert!((sample.eta - eta).abs() < 1e-6 * eta, "{}: {sample:?}", case.name);
                assert!(!sample.weight.is_black() && sample.weight.is_finite(), "{}: {sample:?}", case.name);
            }
        }
    }
}

/// `is_delta` and `transmits` are what samples and values show.
#[test]
fn flags_are_right() {
    for case in cases() {
        let mut rng = Rng::new(3);
        let (mut continuous, mut through) = (false, false);
        for wo in outgoing() {
            for _ in 0..500 {
                if let Some(sample) = draw(&case.bsdf, wo, &mut rng)
                    && matches!(sample.density, Density::SolidAngle(_))
                {
                    continuous = true;
                    through |= sample.transmitted;
                }
                let wi = random_direction(&mut rng);
                let BsdfEval { value, pdf } = case.bsdf.eval(wo, wi);
                let scattered = pdf > 0.0 || !value.is_black();
                assert!(!(scattered && case.bsdf.is_delta()), "{}", case.name);
                let crosses = (wo.z > 0.0) != (wi.z > 0.0);
                assert!(!(scattered && crosses && !case.bsdf.transmits()), "{}", case.name);
            }
        }
        assert_eq!(case.bsdf.is_delta(), !continuous, "{}", case.name);
        assert_eq!(case.bsdf.transmits(), through, "{}", case.name);
    }
}
