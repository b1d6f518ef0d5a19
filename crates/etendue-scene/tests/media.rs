//! `[media.NAME]` and `[world]`: what they mean, what is said of mistakes, and how volumes become grids.
#![allow(clippy::disallowed_methods)]

use etendue::{
    math::{DVec3, vec3},
    medium::{Medium, PhaseKind, presets},
    spectrum::Spectrum,
};
use etendue_scene::{
    Diagnostics, Input, Limits, SourceMap, build,
    description::{MediumRecord, SceneDescription},
    read_scene, read_toml,
    volume_file::{Axes, ByteOrder, RawLayout, SampleType},
};
use std::{fs, path::Path};

const CAMERA: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n";

fn read(text: &str) -> (Option<SceneDescription>, Vec<String>) {
    let text = format!("{CAMERA}{text}");
    let mut sources = SourceMap::new();
    let file = sources.insert("s.toml", text.clone().into_bytes()).unwrap();
    let (description, found) = read_toml(file, text.as_bytes(), Path::new(""));
    (description, found.iter().map(|d| d.one_line(&sources)).collect())
}

#[track_caller]
fn medium_record(lines: &str) -> MediumRecord {
    let (description, found) = read(&format!("[media.m]\n{lines}"));
    assert!(found.is_empty(), "{}", found.join("\n"));
    description.unwrap().media.remove(0)
}

#[track_caller]
fn medium(lines: &str) -> Medium {
    medium_record(lines).medium
}

#[track_caller]
fn says(text: &str, expected: &[&str]) {
    let (_, found) = read(text);
    assert_eq!(found, expected, "\n{}", found.join("\n"));
}

fn near(a: Spectrum, b: [f32; 3]) {
    assert!(a.0.iter().zip(b).all(|(a, b)| (a - b).abs() <= 1e-5 * b.abs()), "{a:?} {b:?}");
}

#[test]
fn coefficients_in_four_ways() {
    let plain = medium("absorption = [0.1, 0, 2]\nscattering = 3\nemission = [1, 2, 3]");
    assert_eq!(plain.name, "m");
    assert_eq!(
        (plain.absorption.0, plain.scattering.0, plain.emission.0),
        ([0.1, 0.0, 2.0], [3.0; 3], [1.0, 2.0, 3.0])
    );
    let extinct = medium("extinction = 4\nalbedo = [1, 0.75, 0]");
    near(extinct.scattering, [4.0, 3.0, 0.0]);
    near(extinct.absorption, [0.0, 1.0, 4.0]);
    let path = medium("mean_free_path = [0.5, 2, 1e-3]\nalbedo = 0.5");
    near(path.extinction(), [2.0, 0.5, 1000.0]);
    near(path.scattering, [1.0, 0.25, 500.0]);
    near(medium("mean_free_path = 2").scattering, [0.5; 3]);
    // After the distance the light has the colour.
    let glass = medium("color = [0.9, 0.5, 1]\nat_distance = 0.02\nscattering = 1");
    let passed = glass.absorption.map(|k| (-k * 0.02).exp());
    near(passed, [0.9, 0.5, 1.0]);
    near(glass.scattering, [1.0; 3]);
    let milk = medium("preset = \"skim-milk\"");
    assert_eq!((milk.scattering.0, milk.absorption.0), ([700.0, 1220.0, 1900.0], [1.4, 2.5, 14.2]));
    assert!(medium("").is_vacuum());
    for name in presets::names() {
        assert!(medium(&format!("preset = \"{name}\"")).validate().is_ok());
    }
}

#[test]
fn phases() {
    let kinds = |lines: &str| -> Vec<(PhaseKind, f32)> {
        let medium = medium(lines);
        medium.phase.components().iter().map(|c| (c.kind, c.weight)).collect()
    };
    assert_eq!(kinds(""), [(PhaseKind::Isotropic, 1.0)]);
    for kind in PhaseKind::ALL {
        if !matches!(kind, PhaseKind::HenyeyGreenstein { .. }) {
            assert_eq!(kinds(&format!("phase = \"{}\"", kind.name())), [(kind, 1.0)]);
            assert_eq!(kinds(&format!("phase = {{ type = \"{}\", weight = 3 }}", kind.name())), [(kind, 1.0)]);
        }
    }
    let lobe = |g| PhaseKind::HenyeyGreenstein { g };
    assert_eq!(kinds("phase = { type = \"henyey-greenstein\", g = -0.5 }"), [(lobe(-0.5), 1.0)]);
    let mixed = "phase = [{ type = \"henyey-greenstein\", g = 0.5, weight = 6 }, { type = \"rayleigh\", weight = 2 }]";
    assert_eq!(kinds(mixed), [(lobe(0.5), 0.75), (PhaseKind::Rayleigh, 0.25)]);
    // As near to 1 as single precision goes.
    let narrow = kinds("phase = { type = \"henyey-greenstein\", g = 0.9999999999 }");
    assert_eq!(narrow, [(lobe(1.0 - f32::EPSILON / 2.0), 1.0)]);
}

#[test]
fn the_world_and_its_medium() {
    let (description, found) = read("[world]\nmedium = \"fog\"\n[media.fog]\nscattering = 1");
    assert!(found.is_empty());
    assert_eq!(description.unwrap().world_medium.unwrap().value, "fog");
    says(
        "[world]\nmedium = \"fgo\"\n[media.fog]\nscattering = 1",
        &["s.toml:3:10: error: no medium is called `fgo`; did you mean `fog`?"],
    );
    says("[world]\nmedium = \"fog\"", &["s.toml:3:10: error: no medium is called `fog`; define it in [media.NAME]"]);
    says("[world]", &["s.toml:2:1: error: [world] needs `medium`"]);
}

#[test]
fn mistakes() {
    let mut wrong = Vec::new();
    for (lines, expected) in [
        ("absorption = -1", "2:14: error: `absorption` is out of range: -1"),
        ("scattering = 1e16", "2:14: error: `scattering` is out of range: 10000000000000000"),
        ("mean_free_path = 0", "2:18: error: `mean_free_path` is out of range: 0"),
        (
            "extinction = 1\nmean_free_path = 1",
            "3:1: error: `extinction` and `mean_free_path` exclude each other; keep one of them",
        ),
        (
            "extinction = 1\nscattering = 1",
            "3:1: error: `extinction` and `scattering` exclude each other; keep one of them",
        ),
        (
            "mean_free_path = 1\nabsorption = 1",
            "3:1: error: `mean_free_path` and `absorption` exclude each other; keep one of them",
        ),
        (
            "absorption = 1\ncolor = 0.5\nat_distance = 1",
            "3:1: error: `absorption` and `color` exclude each other; keep one of them",
        ),
        (
            "preset = \"cream\"\nalbedo = 1\nextinction = 1",
            "3:1: error: `preset` and `albedo` exclude each other; keep one of them",
        ),
        (
            "scattering = 1\nalbedo = 0.5",
            "1:1: error: [media.NAME] needs `extinction` or `mean_free_path` for its `albedo`",
        ),
        ("color = 0.5", "1:1: error: [media.NAME] needs `at_distance` for its `color`"),
        ("at_distance = 1", "1:1: error: [media.NAME] needs `color` for its `at_distance`"),
        ("color = \"#ff0000\"\nat_distance = 1", "2:9: error: `color` has a channel that is 0"),
        ("preset = \"kechup\"", "2:10: error: no preset is called `kechup` (expected one of `apple`, "),
        ("phase = \"raleigh\"", "2:9: error: `phase` has no `raleigh` (expected one of `isotropic`, "),
        ("phase = []", "2:9: error: `phase` mixes 1 to 16 shapes, not 0"),
        (
            "phase = [{ weight = 0 }]",
            "2:9: error: all weights of a phase function are 0 (give one of them a weight above 0)",
        ),
        ("phase = { type = \"henyey-greenstein\" }", "2:9: error: phase of type `henyey-greenstein` needs `g`"),
        ("phase = { type = \"henyey-greenstein\", g = 1 }", "2:43: error: `g` is out of range: 1"),
        (
            "phase = { type = \"rayleigh\", g = 0 }",
            "2:30: error: `g` is not a key of type `rayleigh`; it belongs to `henyey-greenstein`",
        ),
        (
            "density = { file = \"a\", min = [0, 0, 0], max = [1, 0, 1] }",
            "2:48: error: `max` must be above `min` on every axis",
        ),
        ("density = { file = \"a\", min = [0, 0, 0] }", "2:11: error: density needs `max`"),
        (
            "density = { file = \"a\", min = [0, 0, 0], max = [1, 1, 1], size = [1, 2, 3] }",
            "2:11: error: density needs `sample`, since it describes a raw file",
        ),
        (
            "density = { file = \"a\", min = [0, 0, 0], max = [1, 1, 1], transform = { relocate = [0, 0, 0] } }",
            "2:71: error: a `density` cannot be relocated; `min` is the lowest corner of its box: set that instead",
        ),
        ("colour = 1", "2:1: error: unknown key `colour` in [media.NAME]; did you mean `color`?"),
    ] {
        let (_, found) = read(&format!("[media.m]\n{lines}"));
        let found: Vec<String> = found.iter().map(|line| line.replace("s.toml:", "")).collect();
        // The first line is the camera's.
        let (line, rest) = expected.split_once(':').unwrap();
        let expected = format!("{}:{rest}", line.parse::<usize>().unwrap() + 1);
        if !found.iter().any(|f| f.starts_with(&expected)) {
            wrong.push(format!("{lines}: {found:#?}\n{expected}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn every_key_of_a_density() {
    let lines = "density = { file = \"v.raw\", min = [-1, 0, -1], max = [1, 2, 3], scale = 2.5, axes = \"yzx\", size = [2, 3, 4], \
                 sample = \"u16\", byte_order = \"big\", transform = { translate = [1, 0, 0] } }";
    let density = medium_record(lines).density.unwrap();
    assert_eq!(
        (density.min, density.max, density.scale),
        (DVec3::new(-1.0, 0.0, -1.0), DVec3::new(1.0, 2.0, 3.0), 2.5)
    );
    assert_eq!((density.axes.unwrap().name(), density.transform.len()), ("yzx", 1));
    let layout = RawLayout { size: [2, 3, 4], sample: SampleType::U16, byte_order: ByteOrder::Big };
    assert_eq!(density.layout, Some(layout));
    let plain = medium_record("density = { file = \"v.npy\", min = [0, 0, 0], max = [1, 1, 1] }").density.unwrap();
    assert_eq!((plain.scale, plain.axes, plain.layout), (1.0, None, None));
    assert_eq!(Axes::ALL.map(Axes::name).len(), 6);
}

/// Builds a scene in a folder with some files.
fn run(text: &str, files: &[(&str, &[u8])], limits: &Limits) -> Result<(Input, Vec<String>), Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let path = folder.path().join("s.toml");
    fs::write(&path, format!("{CAMERA}{text}")).unwrap();
    let mut sources = SourceMap::new();
    let prefix = format!("{}/", folder.path().display());
    let lines = |found: &Diagnostics, sources: &SourceMap| -> Vec<String> {
        found.iter().map(|d| d.one_line(sources).replace(&prefix, "")).collect()
    };
    let (description, found) = read_scene(&path, &mut sources, limits).unwrap();
    let Some(description) = description else { return Err(lines(&found, &sources)) };
    match build(&description, &mut sources, limits) {
        Ok(input) => {
            let found = lines(&input.findings, &sources);
            Ok((input, found))
        }
        Err(found) => Err(lines(&found, &sources)),
    }
}

/// 2 x 3 x 4 values: 0, 1, .. with x fastest, in units of 0.1.
fn raw() -> Vec<u8> {
    (0..24).flat_map(|i| (i as f32 * 0.1).to_le_bytes()).collect()
}

const RAW: &str = "file = \"v.raw\", min = [0, 0, 0], max = [2, 3, 4], size = [2, 3, 4], sample = \"f32\"";

#[test]
fn volumes_become_grids() {
    let text = format!(
        "[world]\nmedium = \"b\"\n[media.a]\nscattering = 1\n[media.b]\nabsorption = 2\ndensity = {{ {RAW}, scale = 10 }}\n\
         [media.c]\nabsorption = 1\ndensity = {{ {RAW}, transform = [{{ rotate = {{ axis = \"z\", angle = 90 }} }}, {{ translate = [5, 0, 0] }}] }}\n"
    );
    let (input, found) = run(&text, &[("v.raw", &raw())], &Limits::default()).unwrap();
    assert!(found.is_empty(), "{found:?}");
    assert_eq!((input.parts.world_medium.as_deref(), input.files.len()), (Some("b"), 2));
    let [a, b, c] = &input.parts.media[..] else { panic!() };
    assert!(a.density.is_none() && (a.name.as_str(), b.name.as_str()) == ("a", "b"));
    let density = b.density.as_ref().unwrap();
    // Voxel (1, 2, 3) is the last.
    assert!((density.at(vec3(1.5, 2.5, 3.5)) - 23.0).abs() < 1e-4);
    assert!((density.at(vec3(1.5, 0.5, 0.5)) - 1.0).abs() < 1e-5);
    assert!((b.scattering_at(vec3(0.5, 0.5, 0.5)).0[0]).abs() < 1e-6);
    let turned = c.density.as_ref().unwrap();
    // x became y, y became -x.
    assert!((turned.at(vec3(5.0 - 2.5, 1.5, 3.5)) - 2.3).abs() < 1e-5);
    // Read once.
    assert!(std::sync::Arc::ptr_eq(density.grid(), turned.grid()));
}

#[test]
fn what_is_wrong_with_volumes() {
    let with = |density: &str, bytes: &[u8], limits: &Limits| {
        let text = format!("[media.a]\nscattering = 1\ndensity = {{ {density} }}\n");
        run(&text, &[("v.raw", bytes), ("v.npy", bytes)], limits)
    };
    let plain = Limits::default();
    let error = |density: &str, bytes: &[u8], limits: &Limits| with(density, bytes, limits).unwrap_err().join("\n");
    let short = error(RAW, &raw()[..95], &plain);
    assert!(short.contains("`v.raw`: the file has 95 bytes, not the 96 of 2 x 3 x 4 samples of f32"), "{short}");
    assert!(short.starts_with("s.toml:4:20: error:"), "{short}");
    let missing = error("file = \"w.npy\", min = [0, 0, 0], max = [1, 1, 1]", &[], &plain);
    assert!(missing.contains("no such file: w.npy"), "{missing}");
    let none = error("file = \"v.npy\", min = [0, 0, 0], max = [1, 1, 1]", b"PNG", &plain);
    assert!(none.contains("no NPY file") && none.contains("describe a raw file"), "{none}");
    let mut limits = plain;
    limits.volumes.voxels = 23;
    assert!(error(RAW, &raw(), &limits).contains("too large: 2 x 3 x 4 voxels; the limit is 23"));
    limits.volumes.file = 95;
    assert!(error(RAW, &raw(), &limits).contains("larger than the limit of 95 bytes"));
    let flat = format!("{RAW}, transform = [{{ scale = 1e10 }}, {{ scale = 1e10 }}]");
    assert!(error(&flat, &raw(), &plain).contains("the transform is too large, or flattens the box"));
    let huge = format!("{RAW}, scale = 1e15");
    assert!(error(&huge, &raw(), &plain).contains("makes densities above 1e15"), "{}", error(&huge, &raw(), &plain));
    let mut negative = raw();
    negative[4..8].copy_from_slice(&(-1f32).to_le_bytes());
    negative[8..12].copy_from_slice(&f32::NAN.to_le_bytes());
    let (_, found) = with(RAW, &negative, &plain).unwrap();
    assert_eq!(found, ["s.toml:4:20: warning: 2 values of the volume are negative or not finite (they count as 0)"]);
}

#[test]
fn a_world_without_end() {
    let found = |text: &str| run(text, &[], &Limits::default()).unwrap().1;
    let sky = "[environment]\nradiance = 1\n[world]\nmedium = \"a\"\n[media.a]\n";
    let lost = found(&format!("{sky}scattering = 0.1"));
    assert!(lost.len() == 1 && lost[0].contains("light from infinity never arrives"), "{lost:?}");
    assert!(found(&format!("{sky}scattering = [0.1, 0.1, 0]")).is_empty());
    let glow = found("[world]\nmedium = \"a\"\n[media.a]\nemission = 1\n");
    assert!(glow.len() == 1 && glow[0].contains("fills a world without end"), "{glow:?}");
    assert!(found("[world]\nmedium = \"a\"\n[media.a]\nemission = 1\nabsorption = 1").is_empty());
}
