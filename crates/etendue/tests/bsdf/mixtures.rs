//! Phong's family and the principled surface against closed forms and integrals in f64.

use crate::{
    cases::{PLASTIC, direction, draw, random_direction},
    reference::{dot, f64s, reflection},
};
use etendue::{
    bsdf::{Bsdf, PhongLobes, PrincipledParameters, directional_albedo, directional_albedo::Width},
    material::Scattering,
    math::Vec3,
    spectrum::Spectrum,
};
use etendue_testkit::{Rng, integrate_2d};
use std::f64::consts::PI;

const NOTHING: PhongLobes = PhongLobes {
    diffuse: Spectrum::BLACK,
    specular: Spectrum::BLACK,
    exponent: 0.0,
    diffuse_transmission: Spectrum::BLACK,
    transmission: Spectrum::BLACK,
    transmission_exponent: 0.0,
    ior: 1.0,
};

/// f of a Phong lobe of albedo 1.
fn lobe(cos_a: f64, exponent: f64) -> f64 {
    (exponent + 2.0) / (2.0 * PI) * cos_a.max(0.0).powf(exponent)
}

#[test]
fn phong_is_the_sum_of_its_lobes() {
    let (kd, ks, td, ts) = (0.2, 0.3, 0.15, 0.25);
    let lobes = PhongLobes {
        diffuse: Spectrum::splat(kd),
        specular: Spectrum::splat(ks),
        exponent: 25.0,
        diffuse_transmission: Spectrum::splat(td),
        transmission: Spectrum::splat(ts),
        transmission_exponent: 60.0,
        ior: 1.0,
    };
    let bsdf = Scattering::Phong(lobes).bsdf();
    let [kd, ks, td, ts] = [kd, ks, td, ts].map(f64::from);
    let mut rng = Rng::new(30);
    for i in 0..6000 {
        let wo = random_direction(&mut rng);
        let wi = if i % 2 == 0 { random_direction(&mut rng) } else { draw(&bsdf, wo, &mut rng).map_or(wo, |s| s.wi) };
        let [o, i] = [wo, wi].map(f64s);
        let expected = if (wo.z > 0.0) == (wi.z > 0.0) {
            kd / PI + ks * lobe(dot([-o[0], -o[1], o[2]], i), 25.0)
        } else {
            td / PI + ts * lobe(-dot(o, i), 60.0)
        } * i[2].abs();
        let ours = f64::from(bsdf.eval(wo, wi).value[1]);
        assert!((ours - expected).abs() < 1e-4 * expected + 1e-7, "{wo} {wi}: {ours} {expected}");
    }
}

/// f / n_o^2 = Ts (k + 2) / (2 pi) cos^k a / n_thin^2, a between the direction on the thinner side and the one into which
/// the direction on the denser side is refracted.
#[test]
fn phong_refracts_about_the_refracted_direction() {
    for ior in [1.5f32, 0.6] {
        let lobes = PhongLobes { transmission: Spectrum::ONE, transmission_exponent: 12.0, ior, ..NOTHING };
        let bsdf = Scattering::Phong(lobes).bsdf();
        let index = |w: [f64; 3]| if w[2] > 0.0 { 1.0 } else { f64::from(ior) };
        let mut rng = Rng::new(31);
        let mut compared = 0;
        for _ in 0..10_000 {
            let wo = random_direction(&mut rng);
            let Some(sample) = draw(&bsdf, wo, &mut rng).filter(|sample| sample.transmitted) else { continue };
            let [o, i] = [wo, sample.wi].map(f64s);
            let (thin, dense) = if index(o) < index(i) { (o, i) } else { (i, o) };
            let ratio = index(dense) / index(thin);
            let tangential = [-dense[0] * ratio, -dense[1] * ratio];
            let cos2 = 1.0 - tangential[0].powi(2) - tangential[1].powi(2);
            if cos2 < 1e-3 {
                continue;
            }
            let refracted = [tangential[0], tangential[1], cos2.sqrt().copysign(-dense[2])];
            let expected = lobe(dot(refracted, thin), 12.0) * (index(o) / index(thin)).powi(2) * i[2].abs();
            let ours = f64::from(bsdf.eval(wo, sample.wi).value[0]);
            assert!((ours - expected).abs() < 2e-3 * expected + 1e-5, "{ior}: {wo} {sample:?}: {ours} {expected}");
            compared += 1;
        }
        assert!(compared > 3000);
    }
}

/// Beyond the critical angle a refracting lobe is a reflecting one.
#[test]
fn phong_reflects_totally() {
    let lobes = PhongLobes { transmission: Spectrum::ONE, transmission_exponent: 300.0, ior: 1.5, ..NOTHING };
    let glossy = Scattering::Phong(lobes).bsdf();
    let clear = Scattering::Phong(PhongLobes { transmission_exponent: 1e4, ..lobes }).bsdf();
    let mut rng = Rng::new(32);
    for theta in [50.0, 70.0] {
        let wo = direction(theta, 10.0, -1.0);
        for _ in 0..200 {
            let sample = draw(&clear, wo, &mut rng).unwrap();
            assert!(!sample.transmitted && sample.weight == Spectrum::ONE);
            assert!(draw(&glossy, wo, &mut rng).is_none_or(|sample| !sample.transmitted && sample.wi.z < -0.0));
        }
    }
}

/// The tables of directional albedo against integrals of the formula as the papers have it.
#[test]
fn directional_albedo_is_the_integral() {
    for alpha in [0.08, 0.3, 1.0] {
        for theta in [5.0f64, 45.0, 70.0, 85.0] {
            let wo = f64s(direction(theta, 0.0, 1.0));
            for f0 in [0.0, 0.04, 1.0] {
                let schlick = |cos: f64| f0 + (1.0 - f0) * (1.0 - cos).powi(5);
                let integral = integrate_2d(
                    |[t, phi]: [f64; 2]| {
                        let wi = [t.sin() * phi.cos(), t.sin() * phi.sin(), t.cos()];
                        reflection(alpha, wo, wi, schlick) * t.sin()
                    },
                    [0.0, 0.0],
                    [0.5 * PI, 2.0 * PI],
                    24,
                    1e-4,
                );
                let facets = Width::of_alpha(alpha as f32).facets(theta.to_radians().cos() as f32);
                let ours = f64::from(facets.at(f0 as f32));
                assert!((ours - integral).abs() < 4e-3, "alpha {alpha}, {theta} degrees, {f0}: {ours} {integral}");
            }
        }
    }
}

/// Estevez and Kulla's lobe with Neubelt and Pettineo's shadowing.
#[test]
fn directional_albedo_of_sheen_is_the_integral() {
    for alpha in [0.06f64, 0.25, 1.0] {
        for theta in [0.0f64, 40.0, 75.0, 87.0] {
            let o = f64s(direction(theta, 0.0, 1.0));
            let integral = integrate_2d(
                |[t, phi]: [f64; 2]| {
                    let i = [t.sin() * phi.cos(), t.sin() * phi.sin(), t.cos()];
                    let sum = [0, 1, 2].map(|c| o[c] + i[c]);
                    let cos2 = sum[2] * sum[2] / dot(sum, sum);
                    let d = (2.0 + 1.0 / alpha) * (1.0 - cos2).max(0.0).powf(0.5 / alpha) / (2.0 * PI);
                    d / (4.0 * (o[2] + i[2] - o[2] * i[2])) * i[2] * t.sin()
                },
                [0.0, 0.0],
                [0.5 * PI, 2.0 * PI],
                16,
                1e-4,
            );
            let ours = f64::from(directional_albedo::sheen(theta.to_radians().cos() as f32, alpha as f32));
            assert!((ours - integral).abs() < 0.01 * integral.max(0.4), "{alpha}, {theta} degrees: {ours} {integral}");
        }
    }
}

/// The mean weight over a grid of random numbers.
fn albedo(bsdf: &Bsdf, wo: Vec3) -> f64 {
    const LOBES: usize = 41;
    const SIDE: usize = 48;
    let at = |i: usize, n: usize| (i as f32 + 0.5) / n as f32;
    let mut sum = 0.0;
    for i in 0..LOBES {
        for j in 0..SIDE {
            for k in 0..SIDE {
                let sample = bsdf.sample(wo, at(i, LOBES), [at(j, SIDE), at(k, SIDE)]);
                sum += sample.map_or(0.0, |s| f64::from(s.weight.max_component() * s.eta * s.eta));
            }
        }
    }
    sum / (LOBES * SIDE * SIDE) as f64
}

/// White plastic loses nothing, since its body gets all that its facets do not reflect; with more layers, nothing is gained.
#[test]
fn principled_layers_are_safe_in_energy() {
    let (one, rough) = (Spectrum::ONE, [0.1f32, 0.3, 0.6, 1.0]);
    let surfaces = rough.into_iter().flat_map(|roughness| {
        let plain = PrincipledParameters { roughness, ..PLASTIC };
        [
            (plain, true),
            (PrincipledParameters { ior: 2.5, ..plain }, true),
            (PrincipledParameters { anisotropic: 0.9, ..plain }, false),
            (PrincipledParameters { coat: 1.0, coat_roughness: 0.3, ..plain }, false),
            (PrincipledParameters { sheen: one, sheen_roughness: roughness, ..plain }, false),
            (PrincipledParameters { sheen: one, coat: 1.0, metallic: 0.5, ..plain }, false),
        ]
    });
    for (parameters, lossless) in surfaces {
        let bsdf = Scattering::Principled(parameters).bsdf();
        for theta in [0.0, 45.0, 75.0, 87.0] {
            let albedo = albedo(&bsdf, direction(theta, 25.0, 1.0));
            assert!(albedo < 1.008, "{theta} degrees: {albedo}, {parameters:?}");
            assert!(!lossless || albedo > 0.992, "{theta} degrees: {albedo}, {parameters:?}");
        }
    }
}
