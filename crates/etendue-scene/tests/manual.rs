//! docs/scene-format.md against the reader: the same keys, and examples that read.

use etendue_scene::{
    SourceMap,
    read::keys::{SECTIONS, Section},
    read_toml,
};
use std::{collections::BTreeSet, path::Path};

const MANUAL: &str = include_str!("../../../docs/scene-format.md");

/// The chapter under the heading that names a section, up to the next heading.
fn chapter(section: &Section) -> &'static str {
    let is_heading = |line: &str| {
        let heading = line.trim_start_matches('#').trim().replace('`', "");
        line.starts_with('#') && heading.eq_ignore_ascii_case(section.name)
    };
    let mut start = 0;
    for line in MANUAL.split_inclusive('\n') {
        start += line.len();
        if is_heading(line.trim_end()) {
            let rest = &MANUAL[start..];
            return &rest[..rest.find("\n#").unwrap_or(rest.len())];
        }
    }
    panic!("no heading for {}", section.name);
}

/// The keys in the first column of the first table.
fn documented(chapter: &str) -> BTreeSet<&str> {
    let table = chapter.lines().skip_while(|l| !l.starts_with("| key |")).skip(2).take_while(|l| l.starts_with('|'));
    table.map(|row| row[1..].split('|').next().unwrap().trim().trim_matches('`')).collect()
}

#[test]
fn every_key_is_in_the_manual_and_the_other_way_round() {
    for section in SECTIONS {
        let known: BTreeSet<&str> = section.keys.iter().map(|k| k.name).collect();
        assert_eq!(documented(chapter(section)), known, "{}", section.name);
    }
}

#[test]
fn the_manual_says_which_types_use_a_key() {
    for section in SECTIONS {
        for key in section.keys {
            let row = chapter(section).lines().find(|l| l.starts_with(&format!("| `{}` |", key.name))).unwrap();
            for name in key.types {
                // All types, or all but those that the row names.
                let named = row.contains(name) != row.contains("| all but ");
                assert!(named, "{}: the row of `{}` does not name {name}", section.name, key.name);
            }
        }
    }
}

/// The examples of the manual.
fn examples() -> impl Iterator<Item = &'static str> {
    MANUAL.split("```toml\n").skip(1).map(|part| part.split("```").next().unwrap())
}

#[test]
fn the_examples_read() {
    assert!(examples().count() >= 12);
    for example in examples() {
        let camera = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n";
        let text = format!("{}{example}", if example.contains("[camera]") { "" } else { camera });
        let mut sources = SourceMap::new();
        let file = sources.insert("example", text.clone().into_bytes()).unwrap();
        let (description, diagnostics) = read_toml(file, text.as_bytes(), Path::new(""));
        let found: Vec<_> = diagnostics.iter().map(|d| d.one_line(&sources)).collect();
        assert!(description.is_some() && found.is_empty(), "{text}\n{}", found.join("\n"));
    }
}

/// Every value of `type` that the reader knows is in the manual.
#[test]
fn every_choice_is_in_the_manual() {
    let ask = |text: &str| {
        let mut sources = SourceMap::new();
        let file = sources.insert("x", text.as_bytes().to_vec()).unwrap();
        let (_, diagnostics) = read_toml(file, text.as_bytes(), Path::new(""));
        diagnostics.iter().find_map(|d| d.label.clone().filter(|l| l.starts_with("expected one of "))).unwrap()
    };
    let questions = [
        ("[camera]", "[camera]\ntype = \"?\""),
        ("[camera]", "[camera]\nfov_axis = \"?\""),
        ("[camera]", "[camera]\naperture = \"?\""),
        ("[film]", "[film]\nfilter = \"?\""),
        ("[film]", "[film]\ntonemap = \"?\""),
        ("[film]", "[film]\nencoding = \"?\""),
        ("[film]", "[film]\naovs = [\"?\"]"),
        ("[sampler]", "[sampler]\ntype = \"?\""),
        ("[integrator]", "[integrator]\ntype = \"?\""),
        ("[accelerator]", "[accelerator]\ntype = \"?\""),
        ("[media.NAME]", "[media.m]\npreset = \"?\""),
        ("phase", "[media.m]\nphase = \"?\""),
        ("phase", "[media.m]\nphase = { type = \"?\" }"),
        ("density", "[media.m]\ndensity = { axes = \"?\" }"),
        ("density", "[media.m]\ndensity = { sample = \"?\" }"),
        ("density", "[media.m]\ndensity = { byte_order = \"?\" }"),
        ("[textures.NAME]", "[textures.t]\ntype = \"?\""),
        ("[textures.NAME]", "[textures.t]\nfile = \"a\"\nfilter = \"?\""),
        ("[textures.NAME]", "[textures.t]\ntype = \"grid\"\ncoordinates = \"?\""),
        ("[materials.NAME]", "[materials.m]\ntype = \"?\""),
        ("[materials.NAME]", "[materials.m]\ntype = \"rough-metal\"\nmetal = \"?\""),
        ("[[objects]]", "[[objects]]\nshape = \"?\""),
        ("simplify", "[meshes.m]\nfile = \"a.obj\"\nsimplify = { faces = 1, method = \"?\" }"),
        ("simplify", "[meshes.m]\nfile = \"a.obj\"\nsimplify = { faces = 1, placement = \"?\" }"),
        ("[environment]", "[environment]\ntype = \"?\""),
        ("[environment]", "[environment]\ntop = 1\nup = \"?\""),
        ("[[lights]]", "[[lights]]\ntype = \"?\""),
        ("[animation]", "[animation]\nshutter_curve = \"?\""),
        ("keyframes", "[animation]\nkeyframes = { file = \"a.json\", interpolation = \"?\" }"),
        ("a value with keys", "[camera]\nfov = { keys = [[0, 40]], interpolation = \"?\" }"),
        ("body", "[[objects]]\nbody = \"?\""),
        ("body", "[[objects]]\nbody = { shape = \"?\" }"),
        ("[physics]", "[physics]\nfriction_rule = \"?\""),
        ("[physics]", "[physics]\nrestitution_rule = \"?\""),
        ("[[joints]]", "[[joints]]\ntype = \"?\""),
    ];
    for (name, question) in questions {
        let section = SECTIONS.iter().find(|s| s.name == name).unwrap();
        let answer = ask(question);
        for choice in answer.trim_start_matches("expected one of ").split(", ") {
            let quoted = format!("\"{}\"", choice.trim_matches('`'));
            assert!(chapter(section).contains(&quoted), "{name}: {quoted} is not in the manual");
        }
    }
}
