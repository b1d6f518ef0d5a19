//! Materials that make no sense are refused, by name.

use crate::cases::PLASTIC;
use etendue::{
    bsdf::{Bsdf, PhongLobes, PrincipledParameters},
    material::{Emission, Material, MaterialError, Scattering},
    spectrum::Spectrum,
};

fn material(scattering: Scattering) -> Material {
    Material::new("thing", scattering)
}

const GREY: Spectrum = Spectrum::splat(0.5);

/// Every way to spoil one parameter: what it is called, and the material with that value in it.
fn spoilt(color: Spectrum, number: f32) -> Vec<(&'static str, Scattering)> {
    let one = Spectrum::ONE;
    vec![
        ("reflectance", Scattering::Diffuse { reflectance: color, transmittance: Spectrum::BLACK }),
        ("transmittance", Scattering::Diffuse { reflectance: Spectrum::BLACK, transmittance: color }),
        ("reflectance", Scattering::Mirror { reflectance: color }),
        ("ior", Scattering::Glass { ior: number, reflection_tint: one, transmission_tint: one, thin: false }),
        ("reflection_tint", Scattering::Glass { ior: 1.5, reflection_tint: color, transmission_tint: one, thin: true }),
        (
            "transmission_tint",
            Scattering::Glass { ior: 1.5, reflection_tint: one, transmission_tint: color, thin: true },
        ),
        ("alpha", Scattering::RoughMetal { eta: GREY, k: one, alpha: [number, 0.1], tint: one }),
        ("alpha", Scattering::RoughMetal { eta: GREY, k: one, alpha: [0.1, number], tint: one }),
        ("tint", Scattering::RoughMetal { eta: GREY, k: one, alpha: [0.1; 2], tint: color }),
        ("ior", Scattering::RoughGlass { ior: number, alpha: 0.1, reflection_tint: one, transmission_tint: one }),
        ("alpha", Scattering::RoughGlass { ior: 1.5, alpha: number, reflection_tint: one, transmission_tint: one }),
        (
            "reflection_tint",
            Scattering::RoughGlass { ior: 1.5, alpha: 0.1, reflection_tint: color, transmission_tint: one },
        ),
        (
            "transmission_tint",
            Scattering::RoughGlass { ior: 1.5, alpha: 0.1, reflection_tint: one, transmission_tint: color },
        ),
        ("diffuse", Scattering::Mtl { diffuse: color, specular: GREY, alpha: 0.0, transmission: GREY, ior: 1.5 }),
        ("specular", Scattering::Mtl { diffuse: GREY, specular: color, alpha: 0.0, transmission: GREY, ior: 1.5 }),
        ("alpha", Scattering::Mtl { diffuse: GREY, specular: GREY, alpha: number, transmission: GREY, ior: 1.5 }),
        ("transmission", Scattering::Mtl { diffuse: GREY, specular: GREY, alpha: 0.0, transmission: color, ior: 1.5 }),
        ("ior", Scattering::Mtl { diffuse: GREY, specular: GREY, alpha: 0.0, transmission: GREY, ior: number }),
    ]
    .into_iter()
    .chain(spoilt_phong(color, number))
    .chain(spoilt_principled(color, number))
    .collect()
}

fn spoilt_phong(color: Spectrum, number: f32) -> impl Iterator<Item = (&'static str, Scattering)> {
    let good = PhongLobes {
        diffuse: GREY,
        specular: GREY,
        exponent: 1.0,
        diffuse_transmission: GREY,
        transmission: GREY,
        transmission_exponent: 1.0,
        ior: 1.0,
    };
    // Any finite number may be an exponent, but for negative ones.
    let exponent = if number == 1e9 { f32::INFINITY } else { number };
    [
        ("diffuse", PhongLobes { diffuse: color, ..good }),
        ("specular", PhongLobes { specular: color, ..good }),
        ("exponent", PhongLobes { exponent, ..good }),
        ("diffuse_transmission", PhongLobes { diffuse_transmission: color, ..good }),
        ("transmission", PhongLobes { transmission: color, ..good }),
        ("transmission_exponent", PhongLobes { transmission_exponent: exponent, ..good }),
        ("ior", PhongLobes { ior: number, ..good }),
    ]
    .into_iter()
    .map(|(name, lobes)| (name, Scattering::Phong(lobes)))
}

fn spoilt_principled(color: Spectrum, number: f32) -> impl Iterator<Item = (&'static str, Scattering)> {
    let good = PLASTIC;
    // Small negative angles are good ones.
    let rotation = if number == -0.1 { -1e9 } else { number };
    [
        ("base_color", PrincipledParameters { base_color: color, ..good }),
        ("metallic", PrincipledParameters { metallic: number, ..good }),
        ("roughness", PrincipledParameters { roughness: number, ..good }),
        ("anisotropic", PrincipledParameters { anisotropic: number, ..good }),
        ("rotation", PrincipledParameters { rotation, ..good }),
        ("ior", PrincipledParameters { ior: number, ..good }),
        ("specular", PrincipledParameters { specular: number, ..good }),
        ("transmission", PrincipledParameters { transmission: number, ..good }),
        ("coat", PrincipledParameters { coat: number, ..good }),
        ("coat_roughness", PrincipledParameters { coat_roughness: number, ..good }),
        ("sheen", PrincipledParameters { sheen: color, ..good }),
        ("sheen_roughness", PrincipledParameters { sheen_roughness: number, ..good }),
    ]
    .into_iter()
    .map(|(name, parameters)| (name, Scattering::Principled(parameters)))
}

#[test]
fn numbers_out_of_range_are_named() {
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.1, 1e9] {
        for (name, scattering) in spoilt(Spectrum([0.5, bad, 0.5]), bad) {
            let error = material(scattering).validate().unwrap_err();
            assert_eq!(error.parameter(), name, "{scattering:?}");
            assert!(error.to_string().contains("thing"), "{error}");
        }
    }
    for (_, scattering) in spoilt(GREY, 1.0) {
        assert_eq!(material(scattering).validate(), Ok(()));
    }
}

#[test]
fn metals_need_an_index() {
    let metal = |eta, k| material(Scattering::RoughMetal { eta, k, alpha: [0.1; 2], tint: Spectrum::ONE });
    assert_eq!(metal(Spectrum::BLACK, Spectrum::ONE).validate(), Ok(()));
    assert_eq!(metal(Spectrum::ONE, Spectrum::BLACK).validate(), Ok(()));
    for (eta, k, name) in [
        (Spectrum::BLACK, Spectrum::BLACK, "eta"),
        (Spectrum::splat(f32::NAN), Spectrum::ONE, "eta"),
        (Spectrum::ONE, Spectrum([1.0, 1.0, f32::NAN]), "k"),
        (Spectrum::ONE, Spectrum::splat(-1.0), "k"),
    ] {
        assert_eq!(metal(eta, k).validate().unwrap_err().parameter(), name);
    }
}

#[test]
fn albedos_that_sum_above_one_are_refused() {
    let diffuse = |r, t| {
        material(Scattering::Diffuse { reflectance: Spectrum::splat(r), transmittance: Spectrum([0.1, t, 0.1]) })
    };
    assert_eq!(diffuse(0.7, 0.3).validate(), Ok(()));
    let error = diffuse(0.7, 0.31).validate().unwrap_err();
    assert!(matches!(&error, MaterialError::CreatesEnergy { sum, .. } if (sum - 1.01).abs() < 1e-5), "{error}");
    assert_eq!(error.parameter(), "reflectance");
}

#[test]
fn emission_and_opacity_are_checked() {
    for (radiance, ok) in [(0.0, true), (1e30, true), (-1.0, false), (f32::NAN, false), (f32::INFINITY, false)] {
        let mut lamp = material(Scattering::Black);
        lamp.emission = Some(Emission { radiance: Spectrum([1.0, radiance, 1.0]).into(), two_sided: false });
        assert_eq!(lamp.validate().map_err(|e| e.parameter()), if ok { Ok(()) } else { Err("radiance") });
    }
    for (opacity, ok) in [(0.0, true), (1.0, true), (1.1, false), (-0.1, false), (f32::NAN, false)] {
        let mut veil = material(Scattering::Black);
        veil.opacity = opacity.into();
        assert_eq!(veil.validate().map_err(|e| e.parameter()), if ok { Ok(()) } else { Err("opacity") });
    }
}

/// Facets too narrow, or an index too near 1, make smooth glass; `Kd + Ks + Tf` above 1 are scaled down together.
#[test]
fn limits_of_the_models() {
    let rough = |ior, alpha| {
        let one = Spectrum::ONE;
        Scattering::RoughGlass { ior, alpha, reflection_tint: one, transmission_tint: one }.bsdf()
    };
    assert!(matches!(rough(1.5, 1e-3), Bsdf::RoughGlass(_)));
    assert!(matches!(rough(1.5, 0.9e-3), Bsdf::Glass(_)));
    assert!(matches!(rough(1.0, 0.5), Bsdf::Glass(_)));
    assert!(matches!(rough(1.000_1, 0.5), Bsdf::Glass(_)));
    assert!(matches!(rough(1.001, 0.5), Bsdf::RoughGlass(_)));
    let mtl = Scattering::Mtl {
        diffuse: Spectrum([0.8, 0.5, 0.1]),
        specular: Spectrum([0.8, 0.5, 0.1]),
        alpha: 0.0,
        transmission: Spectrum([0.4, 0.0, 0.1]),
        ior: 1.0,
    }
    .bsdf();
    let [r, g, b] = mtl.albedo().0;
    assert!((r - 1.0).abs() < 1e-6 && (g - 1.0).abs() < 1e-6 && (b - 0.3).abs() < 1e-6);
    assert!(!mtl.is_delta() && !mtl.transmits());
}
