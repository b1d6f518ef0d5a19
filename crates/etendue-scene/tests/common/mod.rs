//! Shared by the tests of mesh readers.
#![allow(dead_code)]

use etendue_scene::{
    Diagnostics, SourceError, SourceMap,
    mesh_file::{Library, MeshFile},
    obj, off, ply, stl,
};
use std::sync::Arc;

/// Reads OBJ bytes with one library, `m.mtl`.
pub fn read_obj(bytes: &[u8], library: &[u8]) -> Result<MeshFile, Diagnostics> {
    let mut sources = SourceMap::new();
    let file = sources.insert("m.obj", vec![]).unwrap();
    let library_file = sources.insert("m.mtl", vec![]).unwrap();
    obj::read(Arc::new(bytes.to_vec()), file, &mut |name| match name {
        "m.mtl" => Ok(Library { file: library_file, bytes: Arc::new(library.to_vec()), note: None }),
        _ => Err(SourceError::NotFound(name.into())),
    })
}

/// Reads PLY bytes.
pub fn read_ply(bytes: &[u8]) -> Result<MeshFile, Diagnostics> {
    let file = SourceMap::new().insert("m.ply", vec![]).unwrap();
    ply::read(bytes, file)
}

/// Reads STL bytes.
pub fn read_stl(bytes: &[u8]) -> Result<MeshFile, Diagnostics> {
    let file = SourceMap::new().insert("m.stl", vec![]).unwrap();
    stl::read(bytes, file)
}

/// Reads OFF bytes.
pub fn read_off(bytes: &[u8]) -> Result<MeshFile, Diagnostics> {
    let file = SourceMap::new().insert("m.off", vec![]).unwrap();
    off::read(bytes, file)
}

/// What every mesh promises, and that every refusal has a reason.
pub fn check(result: &Result<MeshFile, Diagnostics>) {
    let file = match result {
        Ok(file) => file,
        Err(found) => return assert!(found.has_errors()),
    };
    assert!(!file.notes.has_errors());
    let mesh = &file.mesh;
    let vertices = mesh.positions.len();
    assert!(mesh.origin.is_finite());
    assert!(mesh.positions.iter().flatten().all(|c| c.is_finite()));
    assert!(mesh.indices.iter().flatten().all(|&i| (i as usize) < vertices));
    assert!(mesh.indices.iter().all(|[a, b, c]| a != b && b != c && c != a));
    if let Some(normals) = &mesh.normals {
        assert_eq!(normals.len(), vertices);
        let square = |n: &[f32; 3]| n.iter().map(|&c| f64::from(c) * f64::from(c)).sum::<f64>();
        assert!(normals.iter().all(|n| (square(n) - 1.0).abs() < 1e-6), "{normals:?}");
    }
    if let Some(uvs) = &mesh.uvs {
        assert_eq!(uvs.len(), vertices);
        assert!(uvs.iter().flatten().all(|c| c.is_finite()));
    }
    if let Some(materials) = &mesh.face_materials {
        assert_eq!(materials.len(), mesh.indices.len());
        assert!(materials.iter().all(|&m| (m as usize) < file.materials.len()));
        assert!(file.materials.len() > 1);
    }
    for sphere in &file.spheres {
        assert!(sphere.center.is_finite() && sphere.radius > 0.0 && sphere.radius.is_finite());
        assert!((sphere.material as usize) < file.materials.len().max(1));
    }
    for group in &file.groups {
        assert!(group.faces.start < group.faces.end && group.faces.end <= mesh.indices.len());
    }
    for named in &file.materials {
        let m = &named.material;
        assert!(m.validate().is_ok());
    }
}

/// Reads OBJ text that has nothing wrong.
pub fn obj_with(text: &str) -> MeshFile {
    let result = read_obj(text.as_bytes(), b"");
    check(&result);
    result.unwrap_or_else(|found| panic!("{found:?}"))
}
