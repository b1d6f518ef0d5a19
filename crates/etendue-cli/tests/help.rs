//! Help leads with examples, and messages come with hints.

mod common;

use common::{Folder, SCENE};

const SUBCOMMANDS: [&str; 10] =
    ["render", "animate", "scene", "info", "convert", "simplify", "simulate", "diff", "completions", "man"];

#[test]
fn help_leads_with_examples() {
    let folder = Folder::new();
    for words in std::iter::once("--help".to_owned()).chain(SUBCOMMANDS.map(|name| format!("{name} --help"))) {
        let help = folder.run(&words).with_code(0).stdout;
        let mut lines = help.lines();
        assert_eq!(lines.next(), Some("Examples:"), "{words}");
        assert!(lines.next().unwrap().starts_with("  etendue "), "{words}");
        assert!(help.contains("Usage: etendue"), "{words}");
        assert!(help.lines().all(|line| line.chars().count() <= 140), "{words}");
    }
    let help = folder.run("--help").stdout;
    assert!(SUBCOMMANDS.iter().all(|name| help.contains(&format!("\n  {name} "))), "{help}");
}

/// A folder with every file that an example names.
fn folder_of_examples() -> Folder {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("scenes")).unwrap();
    folder.put("scenes/cornell-box.toml", SCENE);
    folder.put("marbles.toml", format!("{SCENE}\n[[objects]]\nshape = \"sphere\"\nbody = \"dynamic\"\n"));
    let motion = "motion = { translate = { keys = [[0, [0, 0, 0]], [1, [0, 1, 0]]] } }";
    folder.put("moving.toml", format!("{SCENE}\n[[objects]]\nshape = \"sphere\"\n{motion}\n"));
    for name in ["bunny.obj", "cow.obj"] {
        folder.put(name, "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n");
    }
    for words in [
        "render scene.toml -o reference.exr --quiet",
        "render scene.toml -o render.exr --aov albedo --quiet",
        "convert render.exr sky.exr",
        "convert render.exr sky.hdr",
        "convert render.exr cow.png",
        "convert render.exr a.png",
        "convert render.exr reference.png",
        "convert bunny.obj part.stl",
        "convert bunny.obj scan.stl",
        "convert cow.obj cow.ply",
    ] {
        folder.run(words).with_code(0);
    }
    std::fs::rename(folder.path("cow.ply"), folder.path("cow.ply.gz")).unwrap();
    folder
}

#[test]
fn the_examples_in_the_help_run() {
    let folder = folder_of_examples();
    let mut count = 0;
    for words in std::iter::once("--help".to_owned()).chain(SUBCOMMANDS.map(|name| format!("{name} --help"))) {
        let help = folder.run(&words).with_code(0).stdout;
        for example in help.lines().filter_map(|line| line.strip_prefix("  etendue ")) {
            // What follows two blanks is a comment; what follows a bar or an arrow is for the shell.
            let words = example.split("  ").next().unwrap().split(" | ").next().unwrap().split(" > ").next().unwrap();
            // The limit in the example of a comparison is one that holds.
            std::fs::copy(folder.path("reference.exr"), folder.path("a.exr")).unwrap();
            let is_model = words.contains(".obj") || words.contains(".stl");
            let quick = match words.split(' ').next() {
                Some("render") if is_model => " --size 8x8 --spp 1".to_owned(),
                Some("render") => " --threads 2".to_owned(),
                Some("animate") => {
                    let options = [("--size", "8x8"), ("--spp", "1"), ("--frames", "0-1")];
                    let missing = options.iter().filter(|(name, _)| !words.contains(name));
                    missing.map(|(name, value)| format!(" {name} {value}")).collect()
                }
                _ => String::new(),
            };
            let ended = folder.command(&format!("{words}{quick}")).output().unwrap();
            assert!(ended.status.success(), "{words}{quick}: {}", String::from_utf8_lossy(&ended.stderr));
            count += 1;
        }
    }
    assert!(count > 25, "{count}");
}

#[test]
fn messages_have_hints() {
    let folder = Folder::new();
    folder.put("words.txt", "words");
    folder.put("scene.toml", SCENE);
    folder.put("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    for (words, code) in [
        ("render none.toml", 2),
        ("render words.txt", 3),
        ("render scene.toml --view front", 1),
        ("scene words.txt", 2),
        ("scene a.obj -o a.png", 1),
        ("info words.txt", 2),
        ("info a.glb", 3),
        ("convert scene.toml a.png", 1),
        ("convert a.obj a.png", 1),
        ("convert a.obj a.off", 1),
        ("man paint", 1),
    ] {
        folder.run(words).with_code(code).saying(&["help: "]);
    }
}

#[test]
fn no_colours_where_they_are_not_wanted() {
    let folder = Folder::new();
    let output = folder.command("render none.toml").env("NO_COLOR", "1").env("CLICOLOR_FORCE", "1").output().unwrap();
    assert!(!output.stderr.contains(&0x1b), "{output:?}");
}

const MANUAL: &str = include_str!("../../../docs/command-line.md");

#[test]
fn the_manual_names_every_material_view_code_and_subcommand() {
    use etendue_scene::model_scene::{ModelMaterial, ModelView};
    let materials = ModelMaterial::all().map(ModelMaterial::name);
    let views = ModelView::ALL.map(ModelView::name);
    for name in materials.chain(views).chain(SUBCOMMANDS) {
        assert!(MANUAL.contains(&format!("`{name}`")), "{name} is not in the manual");
    }
    for code in [0, 1, 2, 3, 4, 5, 130] {
        assert!(MANUAL.contains(&format!("\n| {code} | ")), "{code} is not in the manual");
    }
}
