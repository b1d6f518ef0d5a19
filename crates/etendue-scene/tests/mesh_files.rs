//! Every file in the folders of `tests/data`, most of them nasty, gives exactly what `expected.txt` there says. With
//! `ETENDUE_WRITE_EXPECTED` set, that is written anew, to be read through before it is kept.

use etendue_scene::{
    Diagnostics, SourceMap,
    mesh_file::{self, MeshFile, MeshLimits},
};
use std::{fmt::Write, path::Path};

const DATA: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data");

fn describe(text: &mut String, file: &MeshFile) {
    let mesh = &file.mesh;
    let (vertices, faces) = (mesh.positions.len(), mesh.indices.len());
    writeln!(text, "  {vertices} vertices, {faces} faces, origin {:?}", mesh.origin.to_array()).unwrap();
    writeln!(text, "  positions {:?}", mesh.positions).unwrap();
    writeln!(text, "  faces {:?}", mesh.indices).unwrap();
    if let Some(normals) = &mesh.normals {
        let rounded: Vec<_> = normals.iter().map(|n| n.map(|c| (c * 1000.0).round() / 1000.0 + 0.0)).collect();
        writeln!(text, "  normals {rounded:?}").unwrap();
    }
    if let Some(uvs) = &mesh.uvs {
        writeln!(text, "  uvs {uvs:?}").unwrap();
    }
    if let Some(colors) = &mesh.colors {
        writeln!(text, "  colors {colors:?}").unwrap();
    }
    if let Some(materials) = &mesh.face_materials {
        writeln!(text, "  face materials {materials:?}").unwrap();
    }
    for sphere in &file.spheres {
        writeln!(text, "  sphere {:?} {:?} {}", sphere.center.to_array(), sphere.radius, sphere.material).unwrap();
    }
    for named in &file.materials {
        let defined = *named.material != MeshFile::default_material(&named.name);
        writeln!(text, "  material {:?}{}", named.name, if defined { "" } else { ", grey" }).unwrap();
    }
    for group in &file.groups {
        writeln!(text, "  group {:?} {:?} {:?}", group.object, group.group, group.faces).unwrap();
    }
}

fn findings(text: &mut String, found: &Diagnostics, sources: &SourceMap, folder: &Path) {
    for diagnostic in found {
        // Paths differ between machines.
        let line = diagnostic.one_line(sources).replace(&format!("{}/", folder.display()), "");
        writeln!(text, "  {line}").unwrap();
    }
}

fn check_folder(name: &str, least: usize) {
    let folder = Path::new(DATA).join(name);
    let mut names: Vec<String> = std::fs::read_dir(&folder)
        .unwrap()
        .map(|entry| entry.unwrap())
        .filter(|entry| entry.file_type().unwrap().is_file())
        .map(|entry| entry.file_name().into_string().unwrap())
        .filter(|name| !name.ends_with(".txt") && !name.ends_with(".mtl") && !name.starts_with('.'))
        .collect();
    names.sort();
    assert!(names.len() >= least);
    let mut actual = String::new();
    for name in &names {
        let mut sources = SourceMap::new();
        let id = sources.read(&folder.join(name), 1 << 20).unwrap();
        writeln!(actual, "{name}").unwrap();
        match mesh_file::read(&mut sources, id, &MeshLimits::default()) {
            Ok(file) => {
                assert!(!file.notes.has_errors());
                describe(&mut actual, &file);
                findings(&mut actual, &file.notes, &sources, &folder);
            }
            Err(found) => {
                assert!(found.has_errors(), "{name} refused without a reason");
                findings(&mut actual, &found, &sources, &folder);
            }
        }
    }
    let path = folder.join("expected.txt");
    if std::env::var_os("ETENDUE_WRITE_EXPECTED").is_some() {
        std::fs::write(&path, &actual).unwrap();
    }
    let expected = std::fs::read_to_string(&path).unwrap_or_default();
    for (i, (a, e)) in actual.lines().zip(expected.lines()).enumerate() {
        assert_eq!(a, e, "{} line {}", path.display(), i + 1);
    }
    assert!(actual == expected, "the ends differ; all that was found:\n{actual}");
}

#[test]
fn every_mesh_gives_what_is_expected() {
    check_folder("meshes", 50);
}

/// One file for each thing that an OBJ file may do.
#[test]
fn every_obj_feature_gives_what_is_expected() {
    check_folder("obj", 45);
}
