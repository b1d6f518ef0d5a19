//! Every file in `tests/data/meshes`, most of them nasty, gives exactly what `expected.txt` there says.

use etendue_scene::{
    Diagnostics, SourceMap,
    mesh_file::{self, MeshFile, MeshLimits},
};
use std::{fmt::Write, path::Path};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/meshes");

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
    if let Some(materials) = &mesh.face_materials {
        writeln!(text, "  face materials {materials:?}").unwrap();
    }
    for named in &file.materials {
        writeln!(text, "  material {:?}: {:?}", named.name, named.material.scattering).unwrap();
    }
    for group in &file.groups {
        writeln!(text, "  group {:?} {:?} {:?}", group.object, group.group, group.faces).unwrap();
    }
}

fn findings(text: &mut String, found: &Diagnostics, sources: &SourceMap) {
    for diagnostic in found {
        // Paths differ between machines.
        let line = diagnostic.one_line(sources).replace(&format!("{FOLDER}/"), "");
        writeln!(text, "  {line}").unwrap();
    }
}

#[test]
fn every_file_gives_what_is_expected() {
    let mut names: Vec<String> = std::fs::read_dir(FOLDER)
        .unwrap()
        .map(|entry| entry.unwrap().file_name().into_string().unwrap())
        .filter(|name| !name.ends_with(".txt") && !name.ends_with(".mtl") && !name.starts_with('.'))
        .collect();
    names.sort();
    assert!(names.len() > 50);
    let mut actual = String::new();
    for name in &names {
        let mut sources = SourceMap::new();
        let id = sources.read(&Path::new(FOLDER).join(name), 1 << 20).unwrap();
        writeln!(actual, "{name}").unwrap();
        match mesh_file::read(&mut sources, id, &MeshLimits::default()) {
            Ok(file) => {
                assert!(!file.notes.has_errors());
                describe(&mut actual, &file);
                findings(&mut actual, &file.notes, &sources);
            }
            Err(found) => {
                assert!(found.has_errors(), "{name} refused without a reason");
                findings(&mut actual, &found, &sources);
            }
        }
    }
    let expected = std::fs::read_to_string(Path::new(FOLDER).join("expected.txt")).unwrap_or_default();
    for (i, (a, e)) in actual.lines().zip(expected.lines()).enumerate() {
        assert_eq!(a, e, "expected.txt line {}", i + 1);
    }
    assert!(actual == expected, "the ends differ; all that was found:\n{actual}");
}
