//! What the keys of MTL files become.

use etendue::{
    material::{Emission, Material, Scattering},
    spectrum::Spectrum,
};
use etendue_scene::{Severity, SourceMap, description::TextureRecord, mtl};

/// The material of `newmtl m` with these keys, and what was said about it.
fn read(keys: &str) -> (Material<TextureRecord>, Vec<String>) {
    let text = format!("newmtl m\n{}\n", keys.replace("; ", "\n"));
    let mut sources = SourceMap::new();
    let file = sources.insert("m.mtl", text.into_bytes()).unwrap();
    let mtl::MaterialLibrary { materials, findings, .. } = mtl::read(&sources.bytes(file), file);
    assert_eq!(materials.len(), 1, "{keys}");
    assert_eq!(findings.count(Severity::Error), 0, "{keys}: {findings:?}");
    ((*materials[0].material).clone(), findings.iter().map(|d| d.one_line(&sources)).collect())
}

const BLACK: Spectrum = Spectrum::BLACK;
const ONE: Spectrum = Spectrum::ONE;

fn grey(value: f32) -> Spectrum {
    Spectrum::splat(value)
}

fn diffuse(value: f32) -> Scattering {
    Scattering::Diffuse { reflectance: grey(value), transmittance: BLACK }
}

fn glass(ior: f32, tint: Spectrum) -> Scattering {
    Scattering::Glass { ior, reflection_tint: ONE, transmission_tint: tint, thin: false }
}

fn mixture(kd: f32, ks: f32, alpha: f32, tf: f32, ior: f32) -> Scattering {
    Scattering::Mtl { diffuse: grey(kd), specular: grey(ks), alpha, transmission: grey(tf), ior }
}

#[test]
fn scattering() {
    let alpha_of = |ns: f32| (2.0 / (ns + 2.0)).sqrt();
    for (keys, expected) in [
        ("", diffuse(0.5)),
        ("Kd 0.25", diffuse(0.25)),
        ("Kd 0.25 0.25 0.25; Ks 0 0 0; Ns 100", diffuse(0.25)),
        ("Kd 0 0 0; Ks 0 0 0", Scattering::Black),
        ("Kd 0.5; Kd 0.25", diffuse(0.25)),
        ("Ks 1; Ns 1000", Scattering::Mirror { reflectance: ONE }),
        ("Kd 0; Ks 1; illum 3", Scattering::Mirror { reflectance: ONE }),
        ("Kd 0; Ks 1; illum 3; Ns 98", mixture(0.0, 1.0, alpha_of(98.0), 0.0, 1.5)),
        ("Kd 0.5; Ks 0.25; Ns 48", mixture(0.5, 0.25, 0.2, 0.0, 1.5)),
        ("Kd 0.5; Ks 0.25", mixture(0.5, 0.25, alpha_of(10.0), 0.0, 1.5)),
        ("Kd 0.5; Ks 0.25; Ns 0", mixture(0.5, 0.25, 1.0, 0.0, 1.5)),
        ("Kd 0.5; Ks 0.25; illum 5", mixture(0.5, 0.25, 0.0, 0.0, 1.5)),
        ("Kd 0.5; Ks 0.25; illum 1", diffuse(0.5)),
        ("illum 7; Ni 1.33", glass(1.33, ONE)),
        ("illum 4; Tf 0.9 0.9 0.9; Kd 0", glass(1.5, grey(0.9))),
        ("illum 9; d 0; Ni 2; Ns 50", glass(2.0, ONE)),
        ("illum 6; Kd 0.5; d 0.25; Ni 1.2", mixture(0.125, 0.0, 0.0, 0.75, 1.2)),
        ("illum 7; Ni 0", glass(1.5, ONE)),
        ("illum 7; Tf 0 0 0; Kd 0.25", diffuse(0.25)),
        ("illum 4; Kd 0.25; Tf 1 1 1; Ni 1; d 1", diffuse(0.25)),
        ("illum 4; Kd 0; Tf 0.5; Ni 1", glass(1.0, grey(0.5))),
        ("Kd 2 2 2", diffuse(1.0)),
        ("Kd -1; Ks 0", Scattering::Black),
    ] {
        assert_eq!(read(keys).0.scattering, expected.into(), "{keys}");
    }
}

#[test]
fn opacity_and_emission() {
    for (keys, expected) in [
        ("", 1.0),
        ("d 0.25", 0.25),
        ("d -halo 0.25", 0.25),
        ("Tr 0.25", 0.75),
        ("d 0.25; Tr 0.75", 0.25),
        ("d 0.25; Tr 0.25", 0.25),
        ("d 7", 1.0),
        ("d 0.25; illum 7", 1.0),
    ] {
        assert_eq!(read(keys).0.opacity, expected.into(), "{keys}");
    }
    let emits = |r, g, b| Some(Emission { radiance: Spectrum([r, g, b]).into(), two_sided: true });
    for (keys, expected) in [
        ("Kd 1", None),
        ("Ke 0 0 0", None),
        ("Ke 1 2 300", emits(1.0, 2.0, 300.0)),
        ("Ke 4", emits(4.0, 4.0, 4.0)),
        ("Ka 1 1 1", None),
        ("Ka 20 10 5", emits(20.0, 10.0, 5.0)),
        ("Ka 20 10 5; Ke 0 0 0", None),
    ] {
        assert_eq!(read(keys).0.emission, expected, "{keys}");
    }
    assert_eq!(read("Ke 1").0.scattering, Scattering::Black);
    assert_eq!(read("Ke 1; Kd 0.25").0.scattering, diffuse(0.25).into());
}

#[test]
fn what_is_approximated_is_said() {
    for (keys, said) in [
        ("Ka 1", "m.mtl:2:1: note: `Ka` ignored: ambient light is computed"),
        ("Ka 2", "m.mtl:2:1: note: `Ka` above 1 counts as emission `Ke`"),
        ("Kd 2", "m.mtl:2:4: warning: `Kd` out of range, clamped"),
        ("kd 1", "m.mtl:2:1: note: `kd` is not in the usual case, but read all the same"),
        ("kx 1; kx 2", "m.mtl:2:1: warning: unknown key `kx` ignored (2 times)"),
        ("Ks 1; illum 1", "m.mtl:2:1: note: `Ks` ignored, as illum 0 and 1 ask (1 material)"),
        ("illum 7; Kd 0; Ks 0.5", "m.mtl:4:1: note: glass reflects by Fresnel's equations, not by `Ks` (1 material)"),
        ("illum 7; Ni 0", "m.mtl:3:1: warning: `Ni` out of range: 1 material with 1.5 instead (expected 0.1 to 10)"),
        ("Tf 0.5", "m.mtl:2:1: note: `Tf` ignored: illum asks for no refraction (1 material)"),
        ("illum 99", "m.mtl:2:7: warning: `illum 99` counts as 2 (expected 0 to 10)"),
        ("d 1; Tr 1", "m.mtl:3:1: warning: `Tr` is not 1 - `d`: `d` counts (1 material)"),
        ("refl -type sphere sky.png", "m.mtl:2:1: note: `refl` ignored: reflections are computed"),
        ("disp d.png; disp e.png", "m.mtl:2:1: warning: `disp` ignored: surfaces are not displaced (2 times)"),
        ("decal d.png", "m.mtl:2:1: warning: `decal` ignored: one image a colour is read"),
        ("map_Ka a.png", "m.mtl:2:1: note: `map_Ka` ignored: ambient light is computed"),
        ("map_aat on", "m.mtl:2:1: note: `map_aat` has no meaning here and is ignored"),
        ("map_Kd -t 1 2 3 a.png", "m.mtl:2:8: note: `map_Kd -t` ignored"),
        ("map_Kd", "m.mtl:2:1: warning: `map_Kd` without a file name ignored"),
        ("map_Kd -clamp on", "m.mtl:2:1: warning: `map_Kd` without a file name ignored"),
        ("Kd 0; map_Kd a.png", "m.mtl:2:1: note: `Kd` 0 with a map, which it would blacken, counts as 1 (1 material)"),
        ("scatter", "m.mtl:2:1: note: `scatter` has no meaning here and is ignored: the medium is `GlobalScatter`"),
    ] {
        assert_eq!(read(keys).1, [said], "{keys}");
    }
    for silent in [
        "Kd 0.5; Ks 0.5; Ns 10; Ka 0; d 1; Tr 0; Tf 1 1 1; Ni 0; illum 2; Ke 0",
        "illum 7; Ni 1.5; Ks 1",
        "Kd 0.5; map_Kd a.png; map_d a.png; norm n.png; Ke 1; map_Ke -o 1 -s 2 2 -mm 0 1 -clamp on e.png",
        "Kd 0.5; Pr 0.5; map_Pr a.png; Pm 1; Ps 0.5; Pc 1; Pcr 0.1; aniso 0.5; anisor 0.25; Ks 0; Ni 1.4",
        "Kd 0.1; Ks 0; Ns 1000; Tr 1; Td 0; Ts 0.9; Nst 1000; n 1.5; texture a.png Kd Ts",
    ] {
        assert!(read(silent).1.is_empty(), "{silent}: {:?}", read(silent).1);
    }
}
