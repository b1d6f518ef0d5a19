//! What `etendue render` leaves behind.

mod common;

use common::{Ended, Folder, SCENE};
use etendue::image::{ChannelData, Image};
use etendue_scene::{
    image_file::{Limits, exr},
    output::{Metadata, hash::film_hash},
};
use std::fs;

fn exr(folder: &Folder, name: &str) -> (Image, Metadata) {
    let path = folder.path(name);
    exr::read(&path, &fs::read(&path).unwrap(), &Limits::default()).unwrap()
}

fn names(image: &Image) -> Vec<&str> {
    image.channels.iter().map(|c| &c.name[..]).collect()
}

#[test]
fn default_outputs_are_named_after_the_scene_in_the_working_directory() {
    let folder = Folder::new();
    fs::create_dir(folder.path("deep")).unwrap();
    fs::rename(folder.path("scene.toml"), folder.path("deep/my.scene.toml")).unwrap();
    folder.put("my.scene.png", "replaced");
    let ended = folder.run("render deep/my.scene.toml").with_code(0).saying(&["4 samples per pixel", "my.scene.png"]);
    assert_eq!(ended.stdout, "");
    assert_eq!(folder.files(), ["deep", "my.scene.exr", "my.scene.png"]);
    let (png, exr) = (folder.image("my.scene.png"), folder.image("my.scene.exr"));
    assert_eq!((png.width, png.height, exr.width, exr.height), (16, 12, 16, 12));
    let brightest = exr.f32_channel("G").unwrap().iter().fold(0.0_f32, |a, &b| a.max(b));
    assert!(brightest > 0.01, "something is to be seen: {brightest}");
}

#[test]
fn json_holds_every_field_and_nothing_else_is_on_standard_output() {
    let folder = Folder::new();
    let ended = folder.run("render scene.toml -o a.exr -o b.png --json --quiet").with_code(0);
    assert_eq!(ended.stderr, "");
    let json = ended.json();
    assert_eq!(json["outputs"], serde_json::json!(["a.exr", "b.png"]));
    assert_eq!((&json["width"], &json["height"]), (&16.into(), &12.into()));
    assert_eq!(json["spp"], 4.0);
    for part in ["load", "build", "render", "write"] {
        assert!(json["seconds"][part].as_f64().unwrap() >= 0.0, "{part}");
    }
    assert_eq!(json["paths"], 16 * 12 * 4);
    assert!(json["rays"].as_u64() > json["paths"].as_u64());
    assert_eq!(json["nonfinite"], 0);
    assert_eq!(json["interrupted"], false);
    let (image, _) = exr(&folder, "a.exr");
    assert_eq!(json["film_hash"], film_hash(&image), "the hash is of what the linear file holds");
}

#[test]
fn exr_files_hold_the_layers_and_tell_how_they_were_made() {
    let folder = Folder::new();
    folder
        .run("render scene.toml -o a.exr --aov variance,albedo,normal,depth,ids --seed 7 --spp 8 --crop 2,3,10,9")
        .with_code(0);
    let (image, metadata) = exr(&folder, "a.exr");
    let expected = [
        "R",
        "G",
        "B",
        "Albedo.B",
        "Albedo.G",
        "Albedo.R",
        "Depth.Z",
        "Id.Material",
        "Id.Object",
        "N.X",
        "N.Y",
        "N.Z",
        "Variance.B",
        "Variance.G",
        "Variance.R",
    ];
    let mut found = names(&image);
    found.retain(|&name| name != "A");
    assert_eq!(found, expected);
    let ids = image.channels.iter().find(|c| c.name == "Id.Object").unwrap();
    assert!(matches!(&ids.data, ChannelData::U32(ids) if ids.contains(&1)));
    assert!(metadata.software.starts_with("Etendue "));
    assert_eq!((metadata.get("seed"), metadata.get("spp")), (Some("7"), Some("8")));
    assert!(metadata.get("commandLine").unwrap().ends_with("--seed 7 --spp 8 --crop 2,3,10,9"));
    assert_eq!(metadata.get("sceneHash").unwrap().len(), 64);
    assert!(metadata.get("seconds").unwrap().parse::<f64>().unwrap() >= 0.0);
    let window = metadata.window.unwrap();
    assert_eq!((window.origin, window.whole, image.width, image.height), ([2, 3], [16, 12], 8, 6));
}

#[test]
fn the_command_line_overrides_the_file() {
    let folder = Folder::new();
    let run =
        |words: &str| folder.run(&format!("render scene.toml --json --quiet -o a.exr -o a.png {words}")).with_code(0);
    let hash = |words: &str| run(words).json()["film_hash"].clone();
    let base = hash("");
    for words in [
        "--seed 1",
        "--spp 5",
        "--size 17x12",
        "--depth 1",
        "--sampler independent",
        "--integrator normal",
        "--filter box",
        "--crop 0,0,8,8",
        "--aov depth",
        "--transparent",
    ] {
        assert_ne!(hash(words), base, "{words}");
    }
    for words in ["--seed 0", "--spp 4", "--size 16x12", "--sampler sobol", "--filter gaussian", "--integrator path"] {
        assert_eq!(hash(words), base, "{words}");
    }
    // Exposure and tone curve change what is seen, not what is measured.
    run("");
    let seen = fs::read(folder.path("a.png")).unwrap();
    for words in ["--exposure -2", "--tonemap reinhard"] {
        assert_eq!(hash(words), base, "{words}");
        assert_ne!(fs::read(folder.path("a.png")).unwrap(), seen, "{words}");
    }
}

#[test]
fn statistics_and_messages_go_to_standard_error() {
    let folder = Folder::new();
    let ended = folder.run("render scene.toml --stats --aov depth -o a.png").with_code(0).saying(&[
        "triangles",
        "spheres        1",
        "rays",
        "accelerator    bvh",
        "only .exr files hold them",
    ]);
    assert!(ended.stdout.is_empty() && !ended.stderr.contains('\r') && !ended.stderr.contains('\u{1b}'), "{ended:#?}");
}

#[test]
fn brute_says_that_it_does_not_see_lights_without_extent() {
    let folder = Folder::new();
    let lit = format!("{SCENE}\n[[lights]]\ntype = \"point\"\nposition = [1, 2, 1]\nintensity = 1\n");
    folder.put("lit.toml", lit);
    folder
        .run("render lit.toml --integrator brute -o a.png")
        .with_code(0)
        .saying(&["`brute` does not see point, spot and directional lights"]);
    assert!(!folder.run("render lit.toml -o a.png").with_code(0).stderr.contains("brute"));
    assert!(!folder.run("render scene.toml --integrator brute -o a.png").with_code(0).stderr.contains("directional"));
}

#[test]
fn a_scene_without_light_is_said_to_be_black() {
    let folder = Folder::new();
    folder.put("dark.toml", SCENE.replace("emission", "# emission"));
    let words = "nothing in the scene emits light";
    folder.run("render dark.toml -o a.png").with_code(0).saying(&[words]);
    assert!(!folder.run("render dark.toml --integrator normal -o a.png").with_code(0).stderr.contains(words));
    assert!(!folder.run("render scene.toml -o a.png").with_code(0).stderr.contains(words));
}

#[test]
fn command_lines_in_files_can_be_read_by_a_shell() {
    let folder = Folder::new();
    fs::rename(folder.path("scene.toml"), folder.path("it's a scene.toml")).unwrap();
    let mut command = folder.command("render -o a.exr");
    let output = command.arg("it's a scene.toml").output().unwrap();
    Ended::from(output, "odd name").with_code(0);
    let (_, metadata) = exr(&folder, "a.exr");
    assert!(metadata.get("commandLine").unwrap().ends_with(r"render -o a.exr 'it'\''s a scene.toml'"));
}
