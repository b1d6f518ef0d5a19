//! `--labels`: files beside a picture, and what is in them.

mod common;

use common::*;
use etendue::image::{ChannelData, Image};
use serde_json::Value;
use std::{fs, path::Path, process::Command};

/// A red ball that is half hidden by a card, a cut-out that is not there, on a floor.
const SCENE: &str = r#"
[camera]
position = [0, 1, 8]
look_at = [0, 0.5, 0]
fov = 40
lens_radius = 0.2
focus_distance = 8

[film]
size = [48, 36]

[sampler]
spp = 1

[materials.red]
type = "diffuse"
reflectance = [0.8, 0.1, 0.1]

[materials.grey]
type = "diffuse"
reflectance = 0.5

[materials.veil]
type = "diffuse"
reflectance = 0.5
opacity = 0.3

[[objects]]
name = "floor"
shape = "rectangle"
corner = [-4, -0.5, -4]
u = [0, 0, 8]
v = [8, 0, 0]
material = "grey"

[[objects]]
name = "ball"
shape = "sphere"
radius = 1
material = "red"
transform = [{ translate = [0, 0.5, 0] }]

[[objects]]
name = "card"
shape = "box"
min = [0, -0.5, 1.25]
max = [2, 3, 1.5]
material = "grey"

[[objects]]
name = "veil"
shape = "rectangle"
corner = [-2, -0.5, 3]
u = [4, 0, 0]
v = [0, 3, 0]
material = "veil"
"#;

fn json(path: &Path) -> Value {
    serde_json::from_slice(&fs::read(path).unwrap()).unwrap()
}

/// The elements of an NPY file and its shape; of 4 bytes each, or 1.
fn npy(path: &Path) -> (String, Vec<usize>, Vec<u8>) {
    let bytes = fs::read(path).unwrap();
    assert!(bytes.starts_with(b"\x93NUMPY\x01\x00"));
    let start = 10 + usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
    assert_eq!(start % 64, 0);
    let header = String::from_utf8(bytes[10..start].to_vec()).unwrap();
    let kind = header.split('\'').nth(3).unwrap().to_owned();
    let (_, sides) = header.split_once('(').unwrap();
    let sides = sides.split(')').next().unwrap().split(',').filter_map(|side| side.trim().parse().ok());
    (kind, sides.collect(), bytes[start..].to_vec())
}

fn words(bytes: &[u8]) -> Vec<u32> {
    bytes.chunks(4).map(|b| u32::from_le_bytes(b.try_into().unwrap())).collect()
}

fn bits(image: &Image, name: &str) -> Vec<u32> {
    let channel = image.channels.iter().find(|c| c.name == name).unwrap_or_else(|| panic!("no channel {name}"));
    match &channel.data {
        ChannelData::F32(data) => data.iter().map(|x| x.to_bits()).collect(),
        ChannelData::U32(data) => data.clone(),
    }
}

#[test]
fn both_kinds_of_files_hold_the_same() {
    let folder = Folder::new();
    folder.put("scene.toml", SCENE);
    let summary =
        folder.run("render scene.toml -o a.b.png --labels all --labels-format both --json").with_code(0).json();
    let image = folder.image("a.b.labels.exr");
    assert_eq!((image.width, image.height), (48, 36));
    let files: [(&str, &str, &[&str]); 7] = [
        ("object", "<u4", &["Id.Object"]),
        ("material", "<u4", &["Id.Material"]),
        ("face", "<u4", &["Id.Face"]),
        ("depth", "<f4", &["Depth.Z"]),
        ("normal", "<f4", &["N.X", "N.Y", "N.Z"]),
        ("position", "<f4", &["P.X", "P.Y", "P.Z"]),
        ("albedo", "<f4", &["Albedo.R", "Albedo.G", "Albedo.B"]),
    ];
    for (name, expected, channels) in files {
        let (kind, shape, bytes) = npy(&folder.path(&format!("a.b.{name}.npy")));
        assert_eq!(kind, expected);
        assert_eq!((&shape[..2], shape.get(2).copied().unwrap_or(1)), (&[36, 48][..], channels.len()), "{name}");
        for (axis, channel) in channels.iter().enumerate() {
            let own: Vec<u32> = words(&bytes).into_iter().skip(axis).step_by(channels.len()).collect();
            assert_eq!(own, bits(&image, channel), "{channel}");
        }
    }
    let count: usize = files.iter().map(|(_, _, channels)| channels.len()).sum();
    assert_eq!(image.channels.len(), count, "there is no flow in a still");
    let record = json(&folder.path("a.b.labels.json"));
    assert_eq!(summary["labels"].as_array().unwrap().len(), files.len() + 2);
    assert_eq!(record["files"].as_array().unwrap().len(), files.len() + 1);
    assert_eq!((&record["size"], &record["frame"]), (&serde_json::json!([48, 36]), &Value::Null));
    let object = bits(&image, "Id.Object");
    let [floor, ball, card, veil] = [0, 1, 2, 3].map(|i| record["objects"][i].clone());
    for (id, thing) in [(1, &floor), (2, &ball), (3, &card), (4, &veil)] {
        assert_eq!(thing["id"], id);
        let pixels = object.iter().filter(|seen| **seen == id).count();
        assert_eq!(thing["visible_pixels"], pixels, "{thing}");
    }
    let fraction = ball["visible_fraction"].as_f64().unwrap();
    assert!((0.4..0.6).contains(&fraction), "{fraction}");
    assert_eq!((&card["visible_fraction"], &veil["visible_fraction"]), (&serde_json::json!(1.0), &Value::Null));
    assert_eq!(ball["object_to_world"][1], serde_json::json!([0.0, 1.0, 0.0, 0.5]));
    assert_eq!(ball["box"]["center"], serde_json::json!([0.0, 0.5, 0.0]));
    assert_eq!(card["bounds"], serde_json::json!([[0.0, -0.5, 1.25], [2.0, 3.0, 1.5]]));
}

#[test]
fn labels_do_not_change_the_picture_nor_it_them() {
    let folder = Folder::new();
    folder.put("scene.toml", SCENE);
    let hash = |more: &str| {
        folder.run(&format!("render scene.toml -o a.png --json {more}")).with_code(0).json()["film_hash"].clone()
    };
    let plain = hash("");
    assert!(!folder.path("a.labels.json").exists());
    assert_eq!(hash("--labels depth,visibility"), plain);
    let first = fs::read(folder.path("a.labels.exr")).unwrap();
    assert!(!folder.path("a.depth.npy").exists());
    hash("--labels visibility,depth --spp 3 --seed 9 --threads 1 --accel kdtree");
    assert!(fs::read(folder.path("a.labels.exr")).unwrap() == first);
    hash("--labels depth --crop 10,5,30,25");
    let image = folder.image("a.labels.exr");
    assert_eq!((image.width, image.height), (20, 20));
    assert_eq!(json(&folder.path("a.labels.json"))["area"], serde_json::json!([10, 5, 30, 25]));
}

#[test]
fn what_cannot_be_is_said() {
    let folder = Folder::new();
    let run = |args: &str| folder.run(&format!("render scene.toml {args}"));
    run("--labels flow").with_code(1).saying(&["flow"]);
    run("--labels depht").with_code(1).saying(&["depht", "depth"]);
    run("--labels-format npy").with_code(1).saying(&["--labels"]);
    run("--labels all -o nowhere/a.png").with_code(4).saying(&["nowhere"]);
    fs::create_dir(folder.path("a.labels.json")).unwrap();
    run("-o a.png --labels all").with_code(4).saying(&["a.labels.json"]);
    assert!(!folder.path("a.png").exists(), "it is found out before the work");
}

/// Runs the program of the manual where there is a Python with NumPy.
#[test]
fn the_manuals_python_reads_the_files() {
    let manual = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs/labels.md");
    let text = fs::read_to_string(manual).unwrap();
    let program = text.split("```python\n").nth(1).and_then(|rest| rest.split("```").next()).unwrap();
    let folder = Folder::new();
    folder.put("scene.toml", SCENE);
    folder.put("read.py", program);
    folder.run("render scene.toml -o out.png --labels all --labels-format npy").with_code(0);
    let python = |args: &[&str]| Command::new("python3").args(args).current_dir(folder.path("")).output();
    if !python(&["-c", "import numpy"]).is_ok_and(|output| output.status.success()) {
        println!("no Python with NumPy: skipped");
        return;
    }
    let output = python(&["read.py", "out"]).unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let error = said.lines().next().and_then(|line| line.rsplit(' ').next()).unwrap();
    assert!(error.parse::<f64>().unwrap() < 1e-5, "{said}");
    let record = json(&folder.path("out.labels.json"));
    let line = format!("ball {} {}", record["objects"][1]["visible_pixels"], record["objects"][1]["visible_fraction"]);
    assert!(said.contains(&line), "{said}\n{line}");
}

/// The scene with a ball that goes to the right, from second 0 to second 2.
fn moving() -> String {
    let moves = "motion = { translate = { keys = [[0, [0, 0, 0]], [2, [1, 0, 0]]] } }";
    SCENE.replace(
        "transform = [{ translate = [0, 0.5, 0] }]",
        &format!("transform = [{{ translate = [0, 0.5, 0] }}]\n{moves}"),
    )
}

#[test]
fn frames_have_flow_alone_and_in_sequence() {
    let folder = Folder::new();
    folder.put("scene.toml", moving());
    let run = |more: &str| {
        let words =
            format!("animate scene.toml --fps 1 --labels depth,flow,visibility --labels-format both --json {more}");
        folder.run(&words).with_code(0)
    };
    let said = run("--frames 0-1 --shutter 0.2,0.7 -o a.%02d.png");
    assert_eq!(said.stdout.lines().count(), 2);
    assert!(said.stdout.contains("a.01.labels.json"), "{said:?}");
    for (frame, backward) in [(0, 0.0), (1, 0.5)] {
        let image = folder.image(&format!("a.0{frame}.labels.exr"));
        let record = json(&folder.path(&format!("a.0{frame}.labels.json")));
        assert_eq!((&record["frame"], record["time"].as_f64()), (&serde_json::json!(frame), Some(f64::from(frame))));
        assert_eq!(record["objects"][1]["object_to_world"][0][3].as_f64(), Some(0.5 * f64::from(frame)));
        let focal = record["camera"]["fx"].as_f64().unwrap();
        let floats = |name: &str| image.f32_channel(name).unwrap().iter().map(|x| f64::from(*x)).collect::<Vec<_>>();
        let depth = floats("Depth.Z");
        let mut balls = 0;
        for (way, shift) in [("Forward", 0.5), ("Backward", -backward)] {
            let flow = [floats(&format!("Flow.{way}.X")), floats(&format!("Flow.{way}.Y"))];
            for (i, id) in bits(&image, "Id.Object").into_iter().enumerate() {
                let expected = if id == 2 { focal * shift / depth[i] } else { 0.0 };
                assert!((flow[0][i] - expected).abs() < 1e-3 && flow[1][i].abs() < 1e-3, "{way} {i} {id}");
                balls += u32::from(id == 2);
            }
            let (kind, shape, bytes) = npy(&folder.path(&format!("a.0{frame}.occluded_{}.npy", way.to_lowercase())));
            assert_eq!((kind.as_str(), &shape[..]), ("|u1", &[36, 48][..]));
            let mask: Vec<u32> = bytes.into_iter().map(u32::from).collect();
            assert_eq!(mask, bits(&image, &format!("Occluded.{way}")));
            assert_eq!(mask.contains(&1), shift != 0.0, "{frame} {way}");
        }
        assert!(balls > 60, "{balls}");
    }
    let read = |name: &str| fs::read(folder.path(name)).unwrap();
    let before = [read("a.01.flow_backward.npy"), read("a.01.labels.json"), read("a.01.png")];
    run("--frames 1 --shutter 0.2,0.7 -o b.%02d.png --threads 1");
    assert!(read("b.01.flow_backward.npy") == before[0], "alone as in sequence");
    // Pictures that are there are left alone, and labels that are not are made again.
    let resumed = |more: &str| run(&format!("--frames 0-1 --shutter 0.2,0.7 -o a.%02d.png --resume {more}")).stdout;
    assert_eq!(resumed("").matches("\"resumed\":true").count(), 2);
    fs::remove_file(folder.path("a.01.labels.json")).unwrap();
    let again = resumed("");
    assert_eq!((again.matches("\"resumed\":true").count(), again.matches("labels.json").count()), (2, 1), "{again}");
    assert!(read("a.01.labels.json") == before[1]);
    // The picture is that without labels.
    folder.run("animate scene.toml --fps 1 --frames 1 --shutter 0.2,0.7 -o c.%02d.png").with_code(0);
    let pixels = |name: &str| folder.image(name).channels;
    assert_eq!(pixels("c.01.png"), pixels("a.01.png"));
}

#[test]
fn labels_of_a_film_lie_in_a_folder_beside_it() {
    let folder = Folder::new();
    folder.put("scene.toml", moving());
    folder.run("animate scene.toml --fps 1 --frames 0-1 -o film.gif --labels object").with_code(0);
    for frame in ["000000", "000001"] {
        assert!(folder.path(&format!("film.gif.labels/frame.{frame}.labels.exr")).exists());
    }
    folder.run("animate scene.toml --fps 1 --frames 0-1 -o - --labels object").with_code(1).saying(&["labels"]);
}
