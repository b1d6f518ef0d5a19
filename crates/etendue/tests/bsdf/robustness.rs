//! No direction and no parameter in range gives NaN, infinity or a negative number.

use crate::cases::{cases, random_direction};
use etendue::{
    bsdf::{Bsdf, BsdfEval, Density, GrooveForm, PhongLobes, PrincipledParameters},
    material::{Material, Scattering},
    math::{Vec3, vec3},
    spectrum::Spectrum,
};
use etendue_testkit::Rng;

/// Unit vectors at the edges of the number range as often as ordinary ones.
pub fn extreme_direction(rng: &mut Rng) -> Vec3 {
    const Z: [f32; 14] =
        [0.0, -0.0, 1e-45, 1e-40, 1e-38, 1e-30, 1e-20, 1e-12, 1e-7, 1e-4, 1e-2, 0.999_999_94, 1.0, 0.5];
    if rng.f32() < 0.3 {
        return random_direction(rng);
    }
    let z = Z[rng.u32() as usize % Z.len()];
    let radius = (1.0 - z * z).max(0.0).sqrt();
    let [x, y] = match rng.u32() % 4 {
        0 => [radius, 0.0],
        1 => [0.0, -radius],
        2 => [radius * 0.6, radius * 0.8],
        _ => [-radius, 1e-40],
    };
    vec3(x, y, if rng.u32().is_multiple_of(2) { z } else { -z })
}

pub fn extreme_number(rng: &mut Rng) -> f32 {
    [0.0, 1.0 - f32::EPSILON / 2.0, 0.5, f32::MIN_POSITIVE, rng.f32(), rng.f32()][rng.u32() as usize % 6]
}

fn extreme_color(rng: &mut Rng) -> Spectrum {
    let mut channel = || [0.0, 1.0, 1e-38, 1e-10, rng.f32()][rng.u32() as usize % 5];
    Spectrum([channel(), channel(), channel()])
}

fn extreme_index(rng: &mut Rng) -> f32 {
    const INDICES: [f32; 10] = [1e-3, 1e3, 1.0, 1.0 + f32::EPSILON, 1.0 - f32::EPSILON, 1.001, 0.999, 1.5, 0.5, 10.0];
    INDICES[rng.u32() as usize % INDICES.len()]
}

fn extreme_alpha(rng: &mut Rng) -> f32 {
    [0.0, 9.9e-4, 1e-3, 1.1e-3, 0.01, 0.3, 1.0][rng.u32() as usize % 7]
}

fn extreme_exponent(rng: &mut Rng) -> f32 {
    [0.0, 1e-30, 1.0, 30.0, 999.0, 1000.0, 1e9][rng.u32() as usize % 7]
}

pub fn extreme_material(rng: &mut Rng) -> Scattering {
    let alpha = extreme_alpha(rng);
    let ior = extreme_index(rng);
    let (a, b, c) = (extreme_color(rng), extreme_color(rng), extreme_color(rng));
    let thin = rng.u32().is_multiple_of(2);
    match rng.u32() % 8 {
        0 => Scattering::Diffuse { reflectance: a, transmittance: (Spectrum::ONE - a) * b },
        1 => Scattering::Mirror { reflectance: a },
        2 => Scattering::Glass { ior, reflection_tint: a, transmission_tint: b, thin },
        3 => {
            let eta = Spectrum([ior, extreme_index(rng), extreme_index(rng)]);
            Scattering::RoughMetal { eta, k: a * extreme_index(rng), alpha: [alpha, extreme_alpha(rng)], tint: b }
        }
        4 => Scattering::RoughGlass { ior, alpha, reflection_tint: a, transmission_tint: b },
        5 => Scattering::Mtl { diffuse: a, specular: b, alpha, transmission: c, ior },
        6 => Scattering::Phong(PhongLobes {
            diffuse: a,
            specular: b,
            exponent: extreme_exponent(rng),
            diffuse_transmission: a * b,
            transmission: c,
            transmission_exponent: extreme_exponent(rng),
            ior,
        }),
        _ => {
            let mut unit = || [0.0, 1.0, 1e-38, 1e-10, 1e-2, rng.f32(), rng.f32()][rng.u32() as usize % 7];
            Scattering::Principled(PrincipledParameters {
                base_color: a,
                metallic: unit(),
                roughness: unit(),
                anisotropic: unit(),
                rotation: 4.0 * unit() - 2.0,
                ior,
                specular: unit(),
                transmission: unit(),
                coat: unit(),
                coat_roughness: unit(),
                sheen: b,
                sheen_roughness: unit(),
            })
        }
    }
}

#[test]
fn nothing_breaks_in_extreme_grooves() {
    let mut rng = Rng::new(15);
    for _ in 0..100_000 {
        let form = GrooveForm::ALL[rng.u32() as usize % 2];
        let (reflectance, exponent) = (extreme_color(&mut rng), extreme_exponent(&mut rng));
        let scattering = Scattering::BrushedMetal { reflectance, exponent, form };
        let (wo, wi) = (extreme_direction(&mut rng), extreme_direction(&mut rng));
        let u = [extreme_number(&mut rng), extreme_number(&mut rng)];
        check(&scattering.bsdf(), wo, wi, extreme_number(&mut rng), u, &scattering);
        let Some(circle) = scattering.bsdf().circle(wo) else { continue };
        let BsdfEval { value, pdf } = circle.eval(f64::from(extreme_number(&mut rng)) * 4.0);
        assert!(value.is_finite() && value.min_component() >= 0.0 && pdf.is_finite() && pdf >= 0.0, "{circle:?}");
    }
}

fn check(bsdf: &Bsdf, wo: Vec3, wi: Vec3, u_lobe: f32, u: [f32; 2], what: &dyn std::fmt::Debug) {
    let sound = |s: Spectrum| s.is_finite() && s.min_component() >= 0.0;
    let BsdfEval { value, pdf } = bsdf.eval(wo, wi);
    assert!(sound(value) && pdf.is_finite() && pdf >= 0.0, "{what:?}: {wo} {wi}: {value:?} {pdf}");
    let flat = wo.z == 0.0 || wi.z == 0.0;
    assert!(!flat || value.is_black(), "{what:?}: {wo} {wi}: {value:?}");
    let Some(sample) = bsdf.sample(wo, u_lobe, u) else { return };
    assert!(wo.z != 0.0, "{what:?}: {wo} scatters");
    let density = sample.density.value();
    assert!(sound(sample.weight) && density.is_finite() && density > 0.0, "{what:?}: {wo}: {sample:?}");
    assert!((sample.wi.length() - 1.0).abs() < 1e-5, "{what:?}: {wo}: {sample:?}");
    let crossed = sample.wi.z.is_sign_positive() != wo.z.is_sign_positive();
    assert_eq!(sample.transmitted, crossed, "{what:?}: {wo}: {sample:?}");
    let (Density::SolidAngle(_), true) = (sample.density, !matches!(bsdf, Bsdf::Diffuse(_))) else { return };
    let BsdfEval { value, pdf } = bsdf.eval(wo, sample.wi);
    assert!(sound(value) && (pdf - density).abs() <= 1e-4 * density, "{what:?}: {wo}: {sample:?}, pdf {pdf}");
}

#[test]
fn nothing_breaks_at_extreme_directions() {
    let mut rng = Rng::new(13);
    for case in cases() {
        for _ in 0..4000 {
            let (wo, wi) = (extreme_direction(&mut rng), extreme_direction(&mut rng));
            let u = [extreme_number(&mut rng), extreme_number(&mut rng)];
            check(&case.bsdf, wo, wi, extreme_number(&mut rng), u, &case.name);
        }
    }
}

#[test]
fn nothing_breaks_with_extreme_parameters() {
    let mut rng = Rng::new(14);
    for _ in 0..200_000 {
        let scattering = extreme_material(&mut rng);
        let material: Material = Material::new("", scattering);
        if material.validate().is_err() {
            continue;
        }
        let bsdf = scattering.bsdf();
        for _ in 0..4 {
            let (wo, wi) = (extreme_direction(&mut rng), extreme_direction(&mut rng));
            let u = [extreme_number(&mut rng), extreme_number(&mut rng)];
            check(&bsdf, wo, wi, extreme_number(&mut rng), u, &scattering);
        }
    }
}
