//! Images, physically based materials, the old renderer's dialect, and the record of what became of every key.

use etendue::{
    bsdf::{PhongLobes, PrincipledParameters},
    material::{Color, Emission, Material, Number, Parameter, Relief, Scattering},
    spectrum::Spectrum,
    texture::{Channel, Filtering, Mapping, Transfer, UvTransform, Wrap},
};
use etendue_scene::{
    Severity, SourceMap,
    description::TextureRecord,
    mesh_file::{KeyStatus, KeyUse},
    mtl::{self, MaterialLibrary},
};
use std::{f32::consts::TAU, path::Path};

const BLACK: Spectrum = Spectrum::BLACK;
const ONE: Spectrum = Spectrum::ONE;

fn library(text: &str) -> (MaterialLibrary, SourceMap) {
    let mut sources = SourceMap::new();
    let file = sources.insert("m.mtl", text.as_bytes().to_vec()).unwrap();
    let library = mtl::read(&sources.bytes(file), file);
    assert_eq!(library.findings.count(Severity::Error), 0, "{text}: {:?}", library.findings);
    (library, sources)
}

/// The material of `newmtl m` with these keys.
fn material(keys: &str) -> Material<TextureRecord> {
    named("m", keys)
}

fn named(name: &str, keys: &str) -> Material<TextureRecord> {
    let (library, _) = library(&format!("newmtl {name}\n{}\n", keys.replace("; ", "\n")));
    assert_eq!(library.materials.len(), 1, "{keys}");
    (*library.materials[0].material).clone()
}

/// What a parameter must be: its factor, and the file of its texture.
fn is<V: PartialEq + std::fmt::Debug>(
    parameter: &Parameter<V, TextureRecord>,
    factor: V,
    file: Option<&str>,
    keys: &str,
) {
    assert_eq!(parameter.factor, factor, "{keys}");
    let found = parameter.texture.as_ref().map(|texture| texture.first_image().unwrap().file.value.as_path());
    assert_eq!(found, file.map(Path::new), "{keys}");
}

fn diffuse_map(keys: &str) -> TextureRecord {
    let Scattering::Diffuse { reflectance, .. } = material(keys).scattering else { panic!("{keys}") };
    reflectance.texture.unwrap()
}

#[test]
fn options() {
    let plain = Mapping::default();
    let uv = |scale, offset| Mapping { transform: UvTransform::new(scale, 0.0, offset), ..plain };
    for (statement, mapping, file) in [
        ("a.png", plain, "a.png"),
        ("-s 2 3 1 a.png", uv([2.0, 3.0], [0.0; 2]), "a.png"),
        ("-s 2 a.png", uv([2.0, 1.0], [0.0; 2]), "a.png"),
        ("-o 0.5 -0.25 a.png", uv([1.0; 2], [0.5, -0.25]), "a.png"),
        ("-o 1 -s 4 4 a.png", uv([4.0, 4.0], [1.0, 0.0]), "a.png"),
        ("-clamp on a.png", Mapping { wrap: [Wrap::Clamp; 2], ..plain }, "a.png"),
        ("-clamp off a.png", plain, "a.png"),
        ("-mm 0.25 2 a.png", Mapping { base: 0.25, gain: 2.0, ..plain }, "a.png"),
        ("-blendu off -blendv off a.png", Mapping { filtering: Filtering::Nearest, ..plain }, "a.png"),
        ("-blendu off a.png", plain, "a.png"),
        ("-imfchan r a.png", Mapping { channel: Channel::Red, ..plain }, "a.png"),
        ("-imfchan m a.png", Mapping { channel: Channel::Alpha, ..plain }, "a.png"),
        ("-imfchan z a.png", plain, "a.png"),
        ("-t 1 1 1 -boost 2 -texres 512 -type sphere -cc on a.png", plain, "a.png"),
        ("a.png -s 2 2 2 -clamp on", Mapping { wrap: [Wrap::Clamp; 2], ..uv([2.0; 2], [0.0; 2]) }, "a.png"),
        ("-S 2 2 A.png", uv([2.0; 2], [0.0; 2]), "A.png"),
        // Names that look like something else.
        ("my  old wood.png", plain, "my  old wood.png"),
        ("textures\\wood -s.png", plain, "textures\\wood -s.png"),
        ("a -s b.png", plain, "a -s b.png"),
        ("-s 1 2 3", uv([1.0, 2.0], [0.0; 2]), "3"),
        ("-s 1 1 1 3 d.png", plain, "3 d.png"),
        ("\"quoted name.png\"", plain, "quoted name.png"),
        ("-s 2 2 \\\n my \\\n wood.png", uv([2.0; 2], [0.0; 2]), "my wood.png"),
        ("#1.png", plain, "#1.png"),
        ("a.png # the wood", plain, "a.png"),
        ("-unknown.png", plain, "-unknown.png"),
    ] {
        let texture = diffuse_map(&format!("map_Kd {statement}"));
        assert_eq!(texture.first_image().unwrap().file.value, Path::new(file), "{statement}");
        assert_eq!(texture.mapping, mapping, "{statement}");
        assert_eq!(texture.first_image().unwrap().transfer, None);
    }
}

#[test]
fn colours_times_images() {
    for (keys, factor) in [
        ("map_Kd a.png", ONE),
        ("Kd 0.5 0.25 1; map_Kd a.png", Spectrum([0.5, 0.25, 1.0])),
        ("map_Kd b.png; map_Kd a.png; Kd 0 0 0", ONE),
        ("MAP_KD a.png", ONE),
    ] {
        let Scattering::Diffuse { reflectance, .. } = material(keys).scattering else { panic!("{keys}") };
        is(&reflectance, factor, Some("a.png"), keys);
    }
    let keys = "Kd 0.5; Ks 0.25; Ns 48; map_Ks s.png";
    let Scattering::Mtl { diffuse, specular, .. } = material(keys).scattering else { panic!() };
    is(&diffuse, Spectrum::splat(0.5), None, keys);
    is(&specular, Spectrum::splat(0.25), Some("s.png"), keys);
    let keys = "Kd 0.5; Ks 0.25; Ns 200; map_Ns n.png";
    let Scattering::Phong(lobes) = material(keys).scattering else { panic!() };
    is(&lobes.exponent, 200.0, Some("n.png"), keys);
    is(&lobes.specular, Spectrum::splat(0.25), None, keys);
    for (keys, factor) in [("Ke 0 0 0; map_Ke e.png", ONE), ("Ke 7; map_Ke e.png", Spectrum::splat(7.0))] {
        let Some(Emission { radiance, two_sided: true }) = material(keys).emission else { panic!("{keys}") };
        is(&radiance, factor, Some("e.png"), keys);
    }
    let keys = "Kd 0.5; map_Kd k.png; illum 7; d 0.25; map_d d.png";
    let glass = material(keys);
    let Scattering::Mtl { diffuse, .. } = &glass.scattering else { panic!() };
    is(diffuse, Spectrum::splat(0.125), Some("k.png"), keys);
    is(&glass.opacity, 1.0, Some("d.png"), keys);
}

#[test]
fn opacity() {
    for (keys, factor, file, channel) in [
        ("map_d m.png", 1.0, "m.png", Channel::Luminance),
        ("d 0.5; map_d m.png", 0.5, "m.png", Channel::Luminance),
        ("d 0; map_d m.png", 1.0, "m.png", Channel::Luminance),
        ("map_Kd k.png; map_d k.png", 1.0, "k.png", Channel::Alpha),
        ("map_Kd k.png; map_d -imfchan g k.png", 1.0, "k.png", Channel::Green),
        ("map_Kd k.png; map_d -imfchan m m.png", 1.0, "m.png", Channel::Alpha),
    ] {
        let opacity = material(keys).opacity;
        is(&opacity, factor, Some(file), keys);
        assert_eq!(opacity.texture.unwrap().mapping.channel, channel, "{keys}");
    }
    assert_eq!(material("map_Kd with-alpha.png").opacity, 1.0.into());
}

#[test]
fn relief() {
    for key in ["bump", "map_bump", "map_Bump"] {
        let Some(Relief::Bump { height }) = material(&format!("{key} -bm 3 h.png")).relief else { panic!("{key}") };
        is(&height, 0.03, Some("h.png"), key);
    }
    for keys in [
        "norm -bm 0.5 x.png",
        "map_Kn -bm 0.5 x.png",
        "map_Bump -bm 0.5 Wood_Normal.PNG",
        "bump -bm 0.5 t\\wood_n.png",
        "norm -bm 0.5 a.png; bump h.png",
    ] {
        let Some(Relief::Normals { map, scale: [0.5, 0.5] }) = material(keys).relief else { panic!("{keys}") };
        assert_eq!(map.first_image().unwrap().transfer, Some(Transfer::Linear));
    }
}

#[test]
fn physically_based() {
    let parameters = PrincipledParameters {
        base_color: Spectrum([0.5, 0.25, 1.0]),
        metallic: 0.3,
        roughness: 0.2,
        anisotropic: 0.7,
        rotation: 0.25 * TAU,
        ior: 1.4,
        specular: 1.0,
        transmission: 0.0,
        coat: 0.5,
        coat_roughness: 0.6,
        sheen: Spectrum::splat(0.4),
        sheen_roughness: 0.5,
    };
    let all = "Kd 0.5 0.25 1; Pr 0.2; Pm 0.3; Ps 0.4; Pc 0.5; Pcr 0.6; aniso 0.7; anisor 0.25; Ni 1.4; Ks 0.5; Ns 10";
    assert_eq!(material(all).scattering, Scattering::Principled(parameters).into());
    let plain = PrincipledParameters {
        base_color: Spectrum::splat(0.8),
        metallic: 0.0,
        roughness: 0.5,
        anisotropic: 0.0,
        rotation: 0.0,
        ior: 1.5,
        coat: 0.0,
        coat_roughness: 0.0,
        sheen: BLACK,
        ..parameters
    };
    for (keys, expected) in [
        ("Pm 1", PrincipledParameters { metallic: 1.0, ..plain }),
        ("Pm 0; Ns 6", PrincipledParameters { roughness: 0.5f32.sqrt(), ..plain }),
        ("Pc 7", PrincipledParameters { coat: 1.0, ..plain }),
        ("Pr 0.1; Ni 1", PrincipledParameters { roughness: 0.1, ..plain }),
        ("Pr 0.1; illum 7", PrincipledParameters { roughness: 0.1, transmission: 1.0, ..plain }),
        ("Pr 0.1; illum 9; d 0.25", PrincipledParameters { roughness: 0.1, transmission: 0.75, ..plain }),
        ("Pr 0.1; illum 4; Tf 0.5", PrincipledParameters { roughness: 0.1, transmission: 0.5, ..plain }),
    ] {
        assert_eq!(material(keys).scattering, Scattering::Principled(expected).into(), "{keys}");
    }
    let keys = "Kd 0.5; map_Kd k.png; map_Pr r.png; Pm 0.5; map_Pm m.png; map_Ps s.png; Pc 1; map_Pc c.png; map_Pcr q.png; \
                d 0.5; map_d d.png";
    let mapped = material(keys);
    let Scattering::Principled(p) = &mapped.scattering else { panic!() };
    is(&p.base_color, Spectrum::splat(0.5), Some("k.png"), keys);
    is(&p.roughness, 1.0, Some("r.png"), keys);
    is(&p.metallic, 0.5, Some("m.png"), keys);
    is(&p.sheen, ONE, Some("s.png"), keys);
    assert_eq!(p.sheen.texture.as_ref().unwrap().first_image().unwrap().transfer, Some(Transfer::Linear));
    is(&p.coat, 1.0, Some("c.png"), keys);
    is(&p.coat_roughness, 1.0, Some("q.png"), keys);
    is(&mapped.opacity, 0.5, Some("d.png"), keys);
}

type Lobes = PhongLobes<Color<TextureRecord>, Number<TextureRecord>>;

fn phong(keys: &str) -> Lobes {
    let Scattering::Phong(lobes) = material(keys).scattering else { panic!("{keys}") };
    lobes
}

#[test]
fn the_dialect() {
    let glass = PhongLobes {
        diffuse: Spectrum::splat(0.1),
        specular: BLACK,
        exponent: 1000.0,
        diffuse_transmission: BLACK,
        transmission: Spectrum::splat(0.9),
        transmission_exponent: 1000.0,
        ior: 1.5,
    };
    let dragon = "Kd 0.1 0.1 0.1; Ks 0 0 0; Ns 1000; Tr 1; Td 0 0 0; Ts 0.9 0.9 0.9; Nst 1000; n 1.5";
    assert_eq!(material(dragon).scattering, Scattering::Phong(glass).into());
    assert_eq!(material(dragon).opacity, 1.0.into());
    let Scattering::Phong(off) = material(&dragon.replace("Tr 1", "Tr 0")).scattering else { panic!() };
    assert_eq!(off.transmission, BLACK.into());
    let plain = PhongLobes { diffuse: ONE, transmission: BLACK, exponent: 10.0, ior: 1.0, ..glass };
    for (keys, lobes) in [
        ("Kd 1; n 1", plain),
        ("Kd 1; Ks 0.2; Ns 20; BRDF", PhongLobes { specular: Spectrum::splat(0.2), exponent: 20.0, ..plain }),
        ("Kd 1; Td 0.5", PhongLobes { diffuse_transmission: Spectrum::splat(0.5), ..plain }),
        ("Kd 1; Nst 30; Ns 1e20", PhongLobes { transmission_exponent: 30.0, exponent: 1e9, ..plain }),
        ("Kd 1; n 99", PhongLobes { ior: 1.5, ..plain }),
    ] {
        assert_eq!(material(keys).scattering, Scattering::Phong(lobes).into(), "{keys}");
    }
    for (words, diffuse, specular, through) in [
        ("a b.jpg", Some("a b.jpg"), None, None),
        ("a b.jpg Kd", Some("a b.jpg"), None, None),
        ("a.jpg Ks Ts", None, Some("a.jpg"), Some("a.jpg")),
    ] {
        let keys = format!("Kd 1; Ks 1; Ts 1; texture {words}");
        let lobes = phong(&keys);
        is(&lobes.diffuse, ONE, diffuse, &keys);
        is(&lobes.specular, ONE, specular, &keys);
        is(&lobes.transmission, ONE, through, &keys);
    }
    let Some(Relief::Bump { height }) = material("n 1; bump folder/f2.png Kd").relief else { panic!() };
    is(&height, 0.01, Some("folder/f2.png"), "bump");
    // One key makes the whole file the dialect.
    let (library, _) = library("newmtl a\nKd 0.5\nNs 1000\nKs 0.1\nnewmtl b\nTs 1\n");
    assert!(library.materials.iter().all(|m| matches!(m.material.scattering, Scattering::Phong(_))));
}

#[test]
fn names_with_a_meaning() {
    let lamp = named("AreaLightSource", "Kd 1 1 0.85; Ks 0 0 0");
    let radiance = Spectrum([1.0, 1.0, 0.85]).into();
    assert_eq!((lamp.emission, lamp.scattering), (Some(Emission { radiance, two_sided: true }), Scattering::Black));
    assert_eq!(named("AreaLightSource", "Kd 0 0 0; Ka 1 1 0.7").emission, None);
    let textured = named("AreaLightSource", "Kd 0.5; texture sky.jpg Kd").emission.unwrap();
    is(&textured.radiance, Spectrum::splat(0.5), Some("sky.jpg"), "lamp");
    let stated = named("AreaLightSource", "Kd 0.5; Ke 3");
    assert_eq!(stated.emission.unwrap().radiance, Spectrum::splat(3.0).into());
    assert!(matches!(stated.scattering, Scattering::Diffuse { .. }));
    let (library, sources) = library("newmtl GlobalScatter\nKd 1\nn 0.5\n");
    let said: Vec<_> = library.findings.iter().map(|d| d.one_line(&sources)).collect();
    let expected =
        "m.mtl:1:1: note: `GlobalScatter` stands for a medium, which scripts fill the world with (1 material)";
    assert_eq!(said, [expected]);
}

#[test]
fn there_is_an_end_to_materials() {
    let text: String = (0..20_000).map(|i| format!("newmtl {i}\nKd 0.{i}\n")).collect();
    let (library, _) = library(&text);
    let last = library.materials.last().unwrap();
    assert_eq!((library.materials.len(), last.name.as_str()), (16384, "16383"));
    let Scattering::Diffuse { reflectance, .. } = &last.material.scattering else { panic!() };
    assert_eq!(reflectance.factor, Spectrum::splat(0.16383));
    assert_eq!(library.findings.count(Severity::Warning), 1);
}

/// As "KEY STATUS COUNT LINE".
fn uses(text: &str) -> Vec<String> {
    let (library, sources) = library(text);
    let one = |used: &KeyUse| {
        let status = match &used.status {
            KeyStatus::Used => "used",
            KeyStatus::Approximated(why) | KeyStatus::Ignored(why) if why.is_empty() => panic!("{used:?}"),
            KeyStatus::Approximated(_) => "approximated",
            KeyStatus::Ignored(_) => "ignored",
        };
        let line = sources.position(used.first.span().unwrap()).line;
        format!("{} {status} {} {line}", used.key, used.count)
    };
    let mut uses: Vec<String> = library.keys.iter().map(one).collect();
    uses.sort();
    uses
}

#[test]
fn every_key_is_accounted_for() {
    let text = "Ns 3\nnewmtl a\nKd 1\nKd 0.5\nKa 1\nmap_Kd -t 1 a.png\nmap_Ks -s 2 2 b.png\nwhat 1\nillum 7\n\
                newmtl b\nKd 1\nKs 0.5\nillum 1\nmap_Ka c.png\nmap_Ka d.png\n";
    assert_eq!(
        uses(text),
        [
            "Ka ignored 1 5",
            "Kd used 3 3",
            "Ks ignored 1 12",
            "Ns ignored 1 1",
            "illum used 2 9",
            "map_Ka ignored 2 14",
            "map_Kd -t ignored 1 6",
            "map_Ks used 1 7",
            "what ignored 1 8",
        ]
    );
    assert_eq!(
        uses("newmtl a\nKd 5\ntexture a.png Kd Ks\nbump b.png\nTs 0.5\nTr 0\n"),
        ["Kd approximated 1 2", "Tr used 1 6", "Ts ignored 1 5", "bump approximated 1 4", "texture used 1 3"]
    );
}
