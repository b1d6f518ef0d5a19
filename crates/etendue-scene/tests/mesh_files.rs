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

/// Vertices go by the numbers that their files give them, whatever is left out or split.
#[test]
fn vertices_are_numbered_as_in_their_files() {
    use etendue_scene::mesh_file::Numbering;
    let read = |name: &str, text: &str| {
        let mut sources = SourceMap::new();
        let file = sources.insert(name, text.as_bytes().to_vec()).unwrap();
        mesh_file::read(&mut sources, file, &MeshLimits::default()).unwrap().numbering
    };
    let obj = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nvt 0 0\nvt 1 1\n";
    let split = read("a.obj", &format!("{obj}f 4/1 2/1 3/1\nf 3/2 5/1 4/1\n"));
    assert_eq!(split, Numbering { count: 5, of_vertices: Some(vec![3, 1, 2, 2, 4]) });
    assert_eq!(split.vertices(&[2, 0, 4]), [2, 3, 4]);
    assert_eq!(read("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"), Numbering::same(3));
    let ply = |faces: &str, kind: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex 4\nproperty {kind} x\nproperty {kind} y\nproperty {kind} z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n5 5 5\n0 1 0\n{faces}\n"
        )
    };
    assert_eq!(read("a.ply", &ply("3 0 1 3", "float")), Numbering { count: 4, of_vertices: Some(vec![0, 1, 3]) });
    assert_eq!(read("a.ply", &ply("4 0 1 2 3", "float")), Numbering::same(4));
    let off = "OFF 4 1 0\n0 0 0\n5 5 5\n1 0 0\n0 1 0\n3 0 2 3\n";
    assert_eq!(read("a.off", off), Numbering { count: 4, of_vertices: Some(vec![0, 2, 3]) });
    let facet = |corners: [&str; 3]| {
        format!("facet normal 0 0 0\nouter loop\nvertex {}\nendloop\nendfacet\n", corners.join("\nvertex "))
    };
    let stl = ["0 0 0", "1 0 0", "0 1 0", "1 1 0"];
    let text = format!("solid\n{}{}endsolid\n", facet([stl[0], stl[1], stl[2]]), facet([stl[2], stl[1], stl[3]]));
    assert_eq!(read("a.stl", &text), Numbering::same(4));
}
