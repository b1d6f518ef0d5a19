//! `etendue convert`: models and pictures come out in other formats with all that those can hold.

mod common;

use common::Folder;
use etendue::image::{Channel, ChannelData, Image};
use etendue_scene::output::{Format, Metadata, write_image};
use serde_json::json;

const OBJ: &str = "mtllib m.mtl\nusemtl red\nv 0 0 0\nv 2 0 0\nv 2 1 0\nv 0 1 0.5\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                   f 1/1 2/2 3/3\nf 1/1 3/3 4/4\n";

fn info(folder: &Folder, name: &str) -> serde_json::Value {
    folder.run(&format!("info {name} --json")).with_code(0).json()
}

#[test]
fn models() {
    let folder = Folder::new();
    folder.put("m.obj", OBJ);
    folder.put("m.mtl", "newmtl red\nKd 0.8 0.1 0.1\n");
    folder.run("convert m.obj a.ply").with_code(0).saying(&["hold no materials", "a.ply: 2 triangles"]);
    folder.run("convert a.ply a.stl").with_code(0).saying(&["no texture coordinates"]);
    folder.run("convert a.stl b.obj").with_code(0);
    folder.run("convert m.obj c.obj").with_code(0);
    let original = info(&folder, "m.obj");
    for name in ["a.ply", "a.stl", "b.obj", "c.obj"] {
        let info = info(&folder, name);
        for key in ["triangles", "vertices", "bounds"] {
            assert_eq!(info[key], original[key], "{key} of {name}");
        }
    }
    assert_eq!(info(&folder, "a.ply")["uvs"], json!(true));
    assert_eq!(info(&folder, "c.obj")["materials"][0]["name"], "red");
    let (a, b) = (
        folder.run("render m.obj --size 8x8 --spp 1 --json -o a.exr"),
        folder.run("render c.obj --size 8x8 --spp 1 --json -o b.exr"),
    );
    assert_eq!(a.json()["film_hash"], b.json()["film_hash"]);
}

fn picture(folder: &Folder) -> [Vec<f32>; 3] {
    let colour = [[0.1, 0.2], [0.4, 0.5], [0.7, 2.0]].map(|c| c.to_vec());
    let channel = |name: &str, data: &[f32]| Channel { name: name.to_owned(), data: ChannelData::F32(data.to_vec()) };
    let mut channels: Vec<Channel> = ["R", "G", "B"].into_iter().zip(&colour).map(|(n, d)| channel(n, d)).collect();
    channels.extend([channel("N.X", &[0.25, 0.5]), channel("N.Y", &[0.75, 0.0]), channel("N.Z", &[1.0, 0.125])]);
    channels.push(channel("Depth.Z", &[3.0, 4.0]));
    let image = Image { width: 2, height: 1, channels };
    write_image(&folder.path("p.exr"), Format::Exr, &image, &Metadata::default(), &|_| [0; 3]).unwrap();
    colour
}

fn channels(image: &Image) -> [Vec<f32>; 3] {
    ["R", "G", "B"].map(|name| image.f32_channel(name).unwrap().to_vec())
}

#[test]
fn pictures() {
    let folder = Folder::new();
    let colour = picture(&folder);
    folder.run("convert p.exr p.pfm").with_code(0).saying(&["p.pfm: 2 x 1"]);
    assert_eq!(channels(&folder.image("p.pfm")), colour);
    folder.run("convert p.exr p.hdr").with_code(0);
    for (read, written) in channels(&folder.image("p.hdr")).iter().flatten().zip(colour.iter().flatten()) {
        assert!((read - written).abs() < 0.01, "{read} {written}");
    }
    folder.run("convert p.exr all.exr").with_code(0);
    assert_eq!(folder.image("all.exr"), folder.image("p.exr"), "every layer is kept");
    folder.run("convert p.pfm p.png").with_code(0);
    folder.run("convert p.pfm bright.png --exposure 1").with_code(0);
    let (plain, bright) = (channels(&folder.image("p.png")), channels(&folder.image("bright.png")));
    for i in 0..2 {
        assert!((plain[0][i] - colour[0][i]).abs() < 0.01 && (bright[0][i] - 2.0 * colour[0][i]).abs() < 0.01);
    }
    assert_eq!(plain[2][1], 1.0, "clipped");
    folder.run("convert p.pfm soft.png --tonemap reinhard").with_code(0);
    assert!(channels(&folder.image("soft.png"))[1][1] < 0.9 * plain[1][1]);
}

#[test]
fn layers() {
    let folder = Folder::new();
    picture(&folder);
    folder.run("convert p.exr n.pfm --layer N").with_code(0);
    assert_eq!(channels(&folder.image("n.pfm")), [vec![0.25, 0.5], vec![0.75, 0.0], vec![1.0, 0.125]]);
    for layer in ["Depth", "Depth.Z"] {
        folder.run(&format!("convert p.exr d.exr --layer {layer}")).with_code(0);
        assert_eq!(channels(&folder.image("d.exr")), [[3.0, 4.0], [3.0, 4.0], [3.0, 4.0]].map(|c| c.to_vec()));
    }
    folder.run("convert p.exr x.png --layer Albedo").with_code(2).saying(&["no layer `Albedo`", "Depth, N"]);
}

#[test]
fn what_does_not_go_is_told() {
    let folder = Folder::new();
    picture(&folder);
    folder.put("m.obj", OBJ);
    folder.put("words.txt", "words");
    for (words, code, part) in [
        ("convert m.obj a.png", 1, ".ply"),
        ("convert m.obj a.off", 1, ".stl"),
        ("convert m.obj a.ply --exposure 1", 1, "--exposure is for pictures"),
        ("convert p.exr a.obj", 1, "models are read"),
        ("convert p.exr a.jpg", 1, ".png"),
        ("convert p.exr a.hdr --tonemap aces", 1, "linear"),
        ("convert p.exr no/a.png", 4, "no/a.png"),
        ("convert none.exr a.png", 2, "none.exr"),
        ("convert words.txt a.png", 2, "words.txt"),
        ("convert a.gltf a.obj", 3, "not read yet"),
        ("convert scene.toml a.png", 1, "render"),
    ] {
        folder.run(words).with_code(code).saying(&[part]);
    }
    assert_eq!(folder.files(), ["m.obj", "p.exr", "words.txt"]);
}
