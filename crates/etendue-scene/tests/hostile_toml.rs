//! Damaged and random scene files: no panic, no exhaustion, and always either a description or an error.

use etendue_scene::{
    Severity, SourceMap,
    read::keys::{SECTIONS, Section},
    read_toml,
};
use proptest::{collection::vec, prelude::*, sample::select};
use std::path::Path;

/// Reads anything; every finding must have a place that can be shown.
fn read(bytes: &[u8]) -> bool {
    let mut sources = SourceMap::new();
    let file = sources.insert("x.toml", bytes.to_vec()).unwrap();
    let (description, diagnostics) = read_toml(file, bytes, Path::new(""));
    for diagnostic in &diagnostics {
        assert!(diagnostic.place(&sources).is_some(), "{diagnostic:?}");
        assert!(diagnostic.one_line(&sources).len() < 10_000);
    }
    assert_eq!(description.is_none(), diagnostics.count(Severity::Error) > 0);
    description.is_some()
}

const SCENE: &str = "\
[camera]\ntype = \"perspective\"\nposition = [0, 1.5, 4e0]\nlook_at = [0, 0.5, 0]\nfov = 40\nlens_radius = 0.01\n\n\
[film]\nsize = [64, 48]\nfilter = { type = \"gaussian\", sigma = 0.5 }\naovs = [\"albedo\", \"depth\"]\ncrop = [0, 0, 32, 32]\n\n\
[sampler]\nspp = 16 # few\nseed = 1_000\n\n[integrator]\ntype = \"path\"\ndepth = 0x8\n\n\
[environment]\nradiance = \"#80a0ff\"\n\n\
[materials.\"red é\"]\ntype = \"diffuse\"\nreflectance = [0.6, 0.1, 0.1]\n\n\
[materials.lamp]\ntype = \"black\"\nemission = { radiance = [1, 2, 3], two_sided = true }\n\n\
[materials.gold]\ntype = \"rough-metal\"\nmetal = 'gold'\nalpha = 0.2\n\n\
[meshes.tri]\npositions = [[0, 0, 0], [1, 0, 0],\n  [0, 1, 0], # third\n]\nindices = [[0, 1, 2]]\n\n\
[[objects]]\nname = \"\"\"a\nb\"\"\"\nmesh = \"tri\"\nmaterial = \"red é\"\n\
transform = [{ scale = 2 }, { rotate = { axis = \"y\", angle = 30 } }, { relocate = [0, 0, 0] }]\n\n\
[[objects]]\nshape = \"sphere\"\ncenter = [0, 0, 0]\nradius = 0.5\nmaterial = \"gold\"\n\n\
[[objects]]\nshape = \"disk\"\nmaterial = \"lamp\"\n\n[[lights]]\nposition = [0, 1, 0]\nintensity = 3\n";

#[test]
fn the_scene_itself_is_good() {
    assert!(read(SCENE.as_bytes()));
}

#[test]
fn every_truncation() {
    for end in 0..SCENE.len() {
        read(&SCENE.as_bytes()[..end]);
    }
}

#[test]
fn every_line_left_out_or_doubled() {
    let lines: Vec<&str> = SCENE.split_inclusive('\n').collect();
    for i in 0..lines.len() {
        read([&lines[..i], &lines[i + 1..]].concat().concat().as_bytes());
        read([&lines[..=i], &lines[i..]].concat().concat().as_bytes());
    }
}

/// A value as an author, or an enemy, might write it.
fn value() -> impl Strategy<Value = String> {
    let leaf = prop_oneof![
        any::<i64>().prop_map(|x| x.to_string()),
        (-10i32..10).prop_map(|x| x.to_string()),
        any::<f64>().prop_map(|x| format!("{x:?}")),
        (0.0..1.0f64).prop_map(|x| format!("{x}")),
        select(vec![
            "nan",
            "-inf",
            "1e999",
            "-0.0",
            "true",
            "1979-05-27",
            "0xff",
            "9223372036854775808",
            "''",
            "\"\"",
            "[]",
            "{}"
        ])
        .prop_map(str::to_owned),
        select(vec![
            "path",
            "sphere",
            "mesh",
            "box",
            "diffuse",
            "glass",
            "rough-metal",
            "gold",
            "m",
            "x",
            "#ffffff",
            "a.obj"
        ])
        .prop_map(|s| format!("\"{s}\"")),
        "[a-z\\\\\"'\\[\\]{}=,.# \u{e9}]{0,8}".prop_map(|s| s),
        vec(-3.0..3.0f64, 0..5).prop_map(|v| format!("{v:?}")),
    ];
    leaf.prop_recursive(3, 24, 5, |inner| {
        prop_oneof![
            vec(inner.clone(), 0..5).prop_map(|v| format!("[{}]", v.join(", "))),
            vec((key(), inner), 0..4).prop_map(|v| format!(
                "{{ {} }}",
                v.iter().map(|(k, v)| format!("{k} = {v}")).collect::<Vec<_>>().join(", ")
            )),
        ]
    })
}

fn key_names() -> Vec<&'static str> {
    let of = |section: &&'static Section| section.keys.iter().map(|k| k.name).collect::<Vec<_>>();
    SECTIONS.iter().flat_map(of).collect()
}

fn key() -> impl Strategy<Value = String> {
    prop_oneof![
        9 => select(key_names()).prop_map(str::to_owned),
        1 => "[a-z_\"'. -]{0,6}".prop_map(|s| s),
    ]
}

fn header() -> impl Strategy<Value = String> {
    let known = ["[camera]", "[film]", "[sampler]", "[integrator]", "[accelerator]", "[environment]", "[materials.m]"];
    let more = [
        "[materials.n]",
        "[meshes.m]",
        "[[objects]]",
        "[[objects]]",
        "[[lights]]",
        "[[camera]]",
        "[objects]",
        "[x",
        "[]",
    ];
    select([&known[..], &more].concat()).prop_map(str::to_owned)
}

fn document() -> impl Strategy<Value = String> {
    let section = (header(), vec((key(), value()), 0..6));
    vec(section, 0..8).prop_map(|sections| {
        let lines = |keys: &[(String, String)]| keys.iter().map(|(k, v)| format!("{k} = {v}\n")).collect::<String>();
        sections.iter().map(|(header, keys)| format!("{header}\n{}", lines(keys))).collect()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn random_bytes(bytes in vec(any::<u8>(), 0..400)) {
        read(&bytes);
    }

    #[test]
    fn random_text(text in "[a-z0-9=\\[\\]{}\"'.,#\\\\\\n\\r\\t \u{e9}_-]{0,300}") {
        read(text.as_bytes());
    }

    #[test]
    fn bit_flips(flips in vec((0..SCENE.len(), 0u8..8), 1..6)) {
        let mut bytes = SCENE.as_bytes().to_vec();
        for (at, bit) in flips {
            bytes[at] ^= 1 << bit;
        }
        read(&bytes);
    }

    #[test]
    fn spliced(a in 0..SCENE.len(), b in 0..SCENE.len(), rubbish in vec(any::<u8>(), 0..8)) {
        let bytes = SCENE.as_bytes();
        read(&[&bytes[..a], &rubbish, &bytes[b..]].concat());
    }

    #[test]
    fn random_scenes(text in document()) {
        read(text.as_bytes());
    }

    #[test]
    fn a_value_replaced(line in 0..SCENE.lines().count(), value in value()) {
        let replaced = SCENE.lines().enumerate().map(|(i, l)| match l.split_once(" = ") {
            Some((key, _)) if i == line => format!("{key} = {value}\n"),
            _ => format!("{l}\n"),
        });
        read(replaced.collect::<String>().as_bytes());
    }
}

#[test]
fn long_lines_and_many_tables() {
    read(format!("x = \"{}\"", "a".repeat(1 << 20)).as_bytes());
    read(format!("x = [{}]", "1,".repeat(1 << 18)).as_bytes());
    read("[a]\n".repeat(1 << 14).as_bytes());
    read("=\n".repeat(1 << 14).as_bytes());
    read("[[objects]]\n".repeat(1 << 16).as_bytes());
    read("\"".repeat(1 << 16).as_bytes());
    read("\u{e9}".repeat(1 << 16).as_bytes());
    read(&[0xff; 1 << 16]);
    read("[".repeat(1 << 16).as_bytes());
}
