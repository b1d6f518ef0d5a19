//! `etendue info`: stable keys, counts that are right.

mod common;

use common::{Folder, SCENE};
use serde_json::{Value, json};

const MTL: &str = "newmtl red\nKd 0.8 0.1 0.1\nKa 0.2 0.2 0.2\nmap_Kd red.pfm\nfancy 1 2 3\nnewmtl lamp\nKe 5 5 5\n";
const OBJ: &str = "mtllib m.mtl\no first\ng left right\nusemtl red\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0\n\
                   vt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\nf 1/1 2/2 3/3 4/4\no second\nusemtl lamp\nv 0 0 -3\nf 1 2 5\nl 1 2\n";

fn folder() -> Folder {
    let folder = Folder::new();
    folder.put("m.obj", OBJ);
    folder.put("m.mtl", MTL);
    let mut picture = b"PF\n2 1\n-1.0\n".to_vec();
    [1.0f32, 0.5, 0.25, 0.0, 0.5, f32::NAN].iter().for_each(|v| picture.extend(v.to_le_bytes()));
    folder.put("bad.pfm", &picture);
    picture.truncate(picture.len() - 4);
    picture.extend(0.75f32.to_le_bytes());
    folder.put("red.pfm", &picture);
    folder
}

/// The keys of an object, sorted; all are in the manual.
fn keys(value: &Value) -> Vec<&str> {
    let manual = include_str!("../../../docs/command-line.md");
    let keys: Vec<&str> = value.as_object().unwrap().keys().map(String::as_str).collect();
    assert!(keys.iter().all(|key| *key == "kind" || manual.contains(&format!("`{key}`"))), "{keys:?}");
    keys
}

#[test]
fn of_a_model() {
    let info = folder().run("info m.obj --json").with_code(0).json();
    let expected = [
        "bounds",
        "file",
        "file_bytes",
        "findings",
        "format",
        "groups",
        "keys",
        "kind",
        "materials",
        "memory",
        "normals",
        "objects",
        "spheres",
        "textures",
        "triangles",
        "uvs",
        "vertex_colors",
        "vertices",
    ];
    assert_eq!(keys(&info), expected);
    assert_eq!((&info["kind"], &info["format"]), (&json!("mesh"), &json!("obj")));
    assert_eq!((&info["triangles"], &info["spheres"]), (&json!(3), &json!(0)));
    assert_eq!((&info["uvs"], &info["normals"]), (&json!(true), &json!(false)));
    assert_eq!(info["objects"], json!(["first", "second"]));
    assert_eq!(info["bounds"], json!({ "min": [0.0, 0.0, -3.0], "max": [2.0, 1.0, 0.0] }));
    assert_eq!(info["file_bytes"], OBJ.len());
    let materials = info["materials"].as_array().unwrap();
    assert_eq!(materials.len(), 2);
    assert_eq!(keys(&materials[0]), ["emits", "name", "opaque", "type"]);
    assert_eq!((&materials[0]["name"], &materials[0]["emits"]), (&json!("red"), &json!(false)));
    assert_eq!((&materials[1]["name"], &materials[1]["emits"]), (&json!("lamp"), &json!(true)));
    let textures = info["textures"].as_array().unwrap();
    assert_eq!(keys(&textures[0]), ["alpha", "bytes", "channels", "encoding", "file", "height", "width"]);
    assert_eq!((&textures[0]["file"], &textures[0]["width"]), (&json!("red.pfm"), &json!(2)));
    assert_eq!(info["memory"]["textures"], textures[0]["bytes"]);
}

#[test]
fn of_every_key_of_a_model_with_its_line() {
    let info = folder().run("info m.obj --json").with_code(0).json();
    let all = info["keys"].as_array().unwrap();
    assert!(all.iter().all(|key| keys(key) == ["count", "file", "key", "line", "status", "why"]));
    let find = |name: &str| all.iter().find(|key| key["key"] == name).unwrap_or_else(|| panic!("{name} in {all:#?}"));
    for (name, status, line) in [("Kd", "used", 2), ("map_Kd", "used", 4), ("Ke", "used", 7)] {
        let key = find(name);
        assert_eq!((&key["status"], &key["line"]), (&json!(status), &json!(line)), "{key}");
        assert_eq!((&key["file"], &key["why"]), (&json!("m.mtl"), &Value::Null));
    }
    for (name, line) in [("Ka", 3), ("fancy", 5)] {
        let key = find(name);
        assert_eq!((&key["status"], &key["line"]), (&json!("ignored"), &json!(line)), "{key}");
        assert!(key["why"].as_str().is_some_and(|why| !why.is_empty()), "{key}");
    }
    assert!(all.iter().any(|key| key["file"] == "m.obj" && key["status"] == "ignored"), "the line `l`: {all:#?}");
}

#[test]
fn of_a_model_for_people() {
    let text = folder().run("info m.obj").with_code(0).stdout;
    for part in
        ["m.obj: obj model", "triangles      3\n", "red: ", "lamp: ", ", emits", "red.pfm: 2 x 1", "ignored", "m.mtl:5"]
    {
        assert!(text.contains(part), "{part} in\n{text}");
    }
}

#[test]
fn of_a_scene() {
    let folder = folder();
    folder.put("s.toml", format!("{SCENE}\n[environment]\nradiance = 1\n[[objects]]\nfile = \"m.obj\"\n\
        [[objects]]\nfile = \"m.obj\"\ntransform = {{ translate = [10, 0, 0] }}\n[[lights]]\nposition = [0, 9, 0]\nintensity = 1\n"));
    let info = folder.run("info s.toml --json").with_code(0).json();
    let expected = [
        "bounds",
        "delta_lights",
        "emitting_objects",
        "environment",
        "file",
        "files",
        "findings",
        "imports",
        "integrator",
        "kind",
        "materials",
        "media",
        "memory",
        "objects",
        "placed_triangles",
        "shapes",
        "size",
        "spheres",
        "spp",
        "textures",
        "triangles",
    ];
    assert_eq!(keys(&info), expected);
    assert_eq!((&info["objects"], &info["triangles"], &info["placed_triangles"]), (&json!(4), &json!(3), &json!(6)));
    assert_eq!((&info["emitting_objects"], &info["delta_lights"]), (&json!(3), &json!(1)));
    assert_eq!((&info["environment"], &info["spp"]), (&json!("constant"), &json!(4)));
    assert_eq!(info["bounds"]["max"], json!([12.0, 3.0, 1.0]));
    assert_eq!(info["imports"][0]["file"], "m.obj");
    assert!(info["imports"][0]["keys"].as_array().unwrap().iter().any(|key| key["key"] == "fancy"));
    assert_eq!(info["files"], json!(["s.toml", "m.obj", "m.mtl", "red.pfm"]));
    let text = folder.run("info s.toml").with_code(0).stdout;
    for part in ["s.toml: scene", "3, 6 with instances", "m.obj: 3 triangles, 2 materials, 1 texture"] {
        assert!(text.contains(part), "{part} in\n{text}");
    }
}

#[test]
fn of_a_picture() {
    let folder = folder();
    let info = folder.run("info bad.pfm --json").with_code(0).json();
    let expected =
        ["bytes", "channels", "encoding", "file", "file_bytes", "format", "height", "kind", "samples", "width"];
    assert_eq!(keys(&info), expected);
    assert_eq!((&info["kind"], &info["format"], &info["width"]), (&json!("image"), &json!("PFM"), &json!(2)));
    assert_eq!((&info["samples"], &info["encoding"]), (&json!("f32"), &json!("linear")));
    assert_eq!(info["channels"][0], json!({ "name": "R", "min": 0.0, "max": 1.0, "mean": 0.5, "nonfinite": 0 }));
    assert_eq!(info["channels"][2]["nonfinite"], 1);
    let text = folder.run("info bad.pfm").with_code(0).stdout;
    assert!(text.contains("2 x 1") && text.contains("1 not finite"), "{text}");
}

#[test]
fn of_a_volume() {
    let folder = folder();
    let mut npy = b"\x93NUMPY\x01\x00".to_vec();
    let header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 1, 3)}";
    npy.extend((header.len() as u16).to_le_bytes());
    npy.extend(header.as_bytes());
    [0.5f32, 1.0, -1.0, 0.0, f32::NAN, 2.5].iter().for_each(|v| npy.extend(v.to_le_bytes()));
    folder.put("v.npy", &npy);
    let info = folder.run("info v.npy --json").with_code(0).json();
    let grid = ["bytes", "max", "mean", "min", "repaired", "samples", "size"];
    let mut expected = [&grid[..], &["file", "file_bytes", "format", "kind"]].concat();
    expected.sort();
    assert_eq!(keys(&info), expected);
    assert_eq!((&info["kind"], &info["size"], &info["samples"]), (&json!("volume"), &json!([2, 1, 3]), &json!("f32")));
    assert_eq!((&info["min"], &info["max"], &info["repaired"]), (&json!(0.0), &json!(2.5), &json!(2)));
    assert!((info["mean"].as_f64().unwrap() - 4.0 / 6.0).abs() < 1e-9);
    let text = folder.run("info v.npy").with_code(0).stdout;
    assert!(text.contains("2 x 1 x 3") && text.contains("2 negative or not finite"), "{text}");
    let medium =
        "[media.m]\nscattering = [1, 2, 3]\ndensity = { file = \"v.npy\", min = [0, 0, 0], max = [1, 1, 1] }\n";
    folder.put("s.toml", format!("{SCENE}\n{medium}"));
    let info = folder.run("info s.toml --json").with_code(0).json();
    let media = info["media"].as_array().unwrap();
    assert_eq!((media.len(), keys(&media[0])), (1, vec!["absorption", "emits", "grid", "name", "scattering"]));
    assert_eq!((keys(&media[0]["grid"]), &media[0]["scattering"]), (grid.to_vec(), &json!([1.0, 2.0, 3.0])));
    let text = folder.run("info s.toml").with_code(0).stdout;
    assert!(text.contains("m: absorption 0 0 0, scattering 1 2 3, times 2 x 1 x 3 voxels of 0 to 2.5"), "{text}");
    folder.put("w.npy", &npy[..20]);
    folder.run("info w.npy").with_code(2).saying(&["w.npy", "at byte 20"]);
}

#[test]
fn of_nothing_that_is_read() {
    let folder = folder();
    folder.put("words.txt", "words");
    folder.put("bad.toml", "camera = 1");
    folder.put("bad.obj", "f 1 2 3\n");
    for (words, code, part) in [
        ("info none.obj", 2, "none.obj"),
        ("info none.png", 2, "none.png"),
        ("info words.txt", 2, "words.txt"),
        ("info bad.toml", 2, "bad.toml:1:10"),
        ("info bad.obj", 2, "bad.obj:1"),
        ("info a.usdz", 3, "USD files are not read yet"),
    ] {
        let ended = folder.run(words).with_code(code).saying(&[part]);
        assert_eq!(ended.stdout, "", "{words}");
    }
}
