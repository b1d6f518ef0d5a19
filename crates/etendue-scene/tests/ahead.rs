//! Small mesh files and images, which are read side by side, against the same files one after the other.
#![allow(clippy::disallowed_methods)]

use etendue_scene::{
    Diagnostics, Input, Limits, SourceMap, build, build_with,
    mesh_file::{self, MeshLimits},
    read_scene,
};
use std::{collections::BTreeMap, fs, path::Path};
use tempfile::TempDir;

const CAMERA: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n";
const OBJ: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 2\nf 1 2 3\nf 2 4 3\n";
const PLY: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                   element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n2 0 0\n0 2 0\n3 0 1 2\n";
const OFF: &str = "OFF\n3 1 0\n0 0 0\n3 0 0\n0 3 0\n3 0 1 2\n";
const STL: &str = "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n";

/// A folder with a scene of objects of these files, in this order, and the files that are there.
fn folder(objects: &[&str], files: &[(&str, &str)]) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, text)| fs::write(folder.path().join(name), text).unwrap());
    let objects = objects.iter().map(|name| format!("[[objects]]\nfile = \"{name}\"\n"));
    fs::write(folder.path().join("scene.toml"), CAMERA.to_owned() + &objects.collect::<String>()).unwrap();
    folder
}

type Built = (Result<Input, Diagnostics>, SourceMap);

/// Reads and builds the scene of a folder; with `first`, mesh files are read before, one after the other.
fn built(folder: &Path, first: &[&str]) -> Built {
    let (mut sources, limits) = (SourceMap::new(), Limits::default());
    let (description, _) = read_scene(&folder.join("scene.toml"), &mut sources, &limits).unwrap();
    let description = description.unwrap();
    if first.is_empty() {
        return (build(&description, &mut sources, &limits), sources);
    }
    let of_meshes = MeshLimits::default();
    let read = |name: &&str| {
        let path = folder.join(name);
        let file = mesh_file::open(&mut sources, &path, &of_meshes).unwrap();
        let mesh = mesh_file::read(&mut sources, file, &of_meshes).unwrap();
        (path, mesh)
    };
    let loaded: BTreeMap<_, _> = first.iter().map(read).collect();
    (build_with(&description, &mut sources, &limits, loaded), sources)
}

fn messages((result, sources): &Built, folder: &Path) -> Vec<String> {
    let prefix = format!("{}/", folder.display());
    let found = result.as_ref().map_or_else(|found| found, |input| &input.findings);
    found.iter().map(|finding| finding.one_line(sources).replace(&prefix, "")).collect()
}

#[test]
fn the_order_of_reading_leaves_no_trace_but_that_of_files() {
    let named = OBJ.to_owned() + "usemtl nothing\nf 1 2 4\n";
    let with_library = format!("mtllib a.mtl\n{OBJ}");
    let late_library = format!("{OBJ}{}mtllib a.mtl\nusemtl red\nf 1 2 4\n", "# filling\n".repeat(4000));
    let files = [
        ("1.obj", OBJ),
        ("2.ply", PLY),
        ("3.off", OFF),
        ("4.stl", STL),
        ("5.obj", named.as_str()),
        ("6.obj", with_library.as_str()),
        ("7.obj", late_library.as_str()),
        ("a.mtl", "newmtl red\nKd 1 0 0\n"),
    ];
    let names = ["7.obj", "4.stl", "1.obj", "2.ply", "1.obj", "6.obj", "3.off", "5.obj"];
    let folder = folder(&names, &files);
    let (ahead, before) = (built(folder.path(), &[]), built(folder.path(), &names));
    assert_eq!(messages(&ahead, folder.path()), messages(&before, folder.path()));
    let (ahead, before) = (ahead.0.unwrap(), before.0.unwrap());
    assert_eq!(format!("{:?}", ahead.parts.shapes), format!("{:?}", before.parts.shapes));
    assert_eq!(format!("{:?}", ahead.parts.objects), format!("{:?}", before.parts.objects));
    assert_eq!(ahead.parts.materials.len(), before.parts.materials.len());
    assert!(
        ahead.parts.materials.iter().any(|material| material.name == "red"),
        "a library that is named late is read"
    );
    let sorted = |input: &Input| {
        let mut files = input.files.clone();
        files.sort();
        files
    };
    assert_eq!(sorted(&ahead), sorted(&before), "each file once");
    assert_eq!(ahead.scene_hash, built(folder.path(), &[]).0.unwrap().scene_hash);
}

#[test]
fn what_cannot_be_read_is_told_once_and_in_the_order_of_objects() {
    let files = [
        ("1.obj", OBJ),
        ("2.ply", "ply\nformat ascii 1.0\nno"),
        ("3.off", OFF),
        ("4.stl", ""),
        ("5.off", "OFF\n3 1 0\n0 0\n"),
    ];
    let folder = folder(&["3.off", "2.ply", "5.off", "4.stl", "1.obj", "2.ply"], &files);
    let found = messages(&built(folder.path(), &[]), folder.path());
    let about = |name: &str| found.iter().filter(|line| line.contains(name)).count();
    assert!(found.len() == 3 && ["2.ply", "5.off", "4.stl"].map(about) == [1; 3], "{found:#?}");
}

/// A scene of materials with one image each.
fn pictured(images: &[&str], files: &[(&str, &str)]) -> TempDir {
    let folder = folder(&[], files);
    let material = |(i, image): (usize, &&str)| {
        format!(
            "[textures.t{i}]\nfile = \"{image}\"\n[materials.m{i}]\ntype = \"diffuse\"\nreflectance = {{ texture = \"t{i}\" }}\n"
        )
    };
    let materials: String = images.iter().enumerate().map(material).collect();
    fs::write(folder.path().join("scene.toml"), CAMERA.to_owned() + &materials).unwrap();
    folder
}

#[test]
fn images_come_in_the_order_of_materials_and_faults_too() {
    let files = [
        ("grey.pfm", "Pf\n1 1\n-1.0\n\0\0\0?"),
        ("wide.pfm", "Pf\n2 1\n-1.0\n\0\0\0?\0\0\0?"),
        ("bad.pfm", "Pf\n1 1\n-1.0\n"),
        ("none.png", ""),
    ];
    let good = pictured(&["wide.pfm", "grey.pfm", "wide.pfm", "grey.pfm"], &files);
    let input = built(good.path(), &[]).0.unwrap();
    let names: Vec<_> = input.files.iter().map(|path| path.file_name().unwrap()).collect();
    assert_eq!(names, ["scene.toml", "wide.pfm", "grey.pfm"]);
    let sizes: Vec<_> = input.textures.iter().map(|t| (t.path.file_name().unwrap(), t.image.size())).collect();
    assert_eq!(sizes, [("grey.pfm".as_ref(), [1, 1]), ("wide.pfm".as_ref(), [2, 1])]);
    let bad = pictured(&["wide.pfm", "none.png", "missing.pfm", "bad.pfm", "grey.pfm"], &files);
    let found = messages(&built(bad.path(), &[]), bad.path());
    let about: Vec<_> = ["none.png", "missing.pfm", "bad.pfm"].into_iter().zip(&found).collect();
    assert!(found.len() == 3 && about.iter().all(|(name, line)| line.contains(name)), "{found:#?}");
}
