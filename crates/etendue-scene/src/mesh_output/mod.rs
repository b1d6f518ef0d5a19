//! Meshes out: OBJ with a material library, PLY and STL files, written whole or not at all.

mod mtl;
mod obj;
mod ply;
mod stl;

use crate::{
    mesh_file::MeshFile,
    output::{EncodeError, WriteError, atomic},
};
use etendue::{math::DVec3, scene::Mesh};
use std::{
    io::{BufWriter, Write},
    path::Path,
};

/// The formats that meshes are written in.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MeshOutputFormat {
    /// Wavefront OBJ: everything; materials by the nearest keys in an MTL file of the same name beside it.
    Obj,
    /// Binary little-endian PLY: positions, normals, texture coordinates, colours, faces.
    Ply,
    /// Binary STL: the faces' corners, in 32 bit floats.
    Stl,
}

impl MeshOutputFormat {
    /// Every format.
    pub const ALL: [Self; 3] = [Self::Obj, Self::Ply, Self::Stl];

    /// The ending of its files, without the dot.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Stl => "stl",
        }
    }

    /// The format that the ending of `path` names, in upper or lower case.
    pub fn of_path(path: &Path) -> Option<Self> {
        let ending = path.extension()?.to_string_lossy().to_ascii_lowercase();
        Self::ALL.into_iter().find(|format| format.ending() == ending)
    }

    /// True if the format holds materials.
    pub const fn keeps_materials(self) -> bool {
        matches!(self, Self::Obj)
    }
}

/// Writes a mesh to `path`, whole or not at all (see [`atomic::write`]). Relative names of its textures start in
/// `texture_folder`, and are made relative to the new library's place.
///
/// What comes back from [`Obj`](MeshOutputFormat::Obj) and [`Ply`](MeshOutputFormat::Ply) is the same to the bit: positions,
/// normals, texture coordinates, colours of 8 bits (others within rounding) and faces, in OBJ also groups and spheres. OBJ numbers vertices by their first use, and leaves
/// out those without one. A mesh with an [origin](Mesh::origin) of its own is written in 64 bits.
///
/// # Errors
/// What keeps a file from being written, and indices, counts or lengths of arrays that contradict each other.
pub fn write_mesh(
    path: &Path,
    format: MeshOutputFormat,
    file: &MeshFile,
    texture_folder: &Path,
) -> Result<(), WriteError> {
    check(file).map_err(|source| WriteError::Encode { path: path.to_owned(), source })?;
    if format == MeshOutputFormat::Obj && !file.materials.is_empty() {
        // First, so that no mesh names a library that is not there.
        let library = path.with_extension("mtl");
        let folder = path.parent().unwrap_or(Path::new(""));
        let textures = mtl::Folders { from: texture_folder, to: folder };
        write(&library, |out| mtl::write(out, &file.materials, &textures))?;
    }
    write(path, |out| match format {
        MeshOutputFormat::Obj => obj::write(out, path, file),
        MeshOutputFormat::Ply => ply::write(out, &file.mesh),
        MeshOutputFormat::Stl => stl::write(out, &file.mesh),
    })
}

fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&mut std::fs::File>) -> Result<(), EncodeError>,
) -> Result<(), WriteError> {
    atomic::write(path, |file| {
        let mut out = BufWriter::with_capacity(1 << 18, file);
        fill(&mut out)?;
        Ok(out.flush()?)
    })
}

/// Refuses what the writers could not index.
fn check(file: &MeshFile) -> Result<(), EncodeError> {
    let mesh = &file.mesh;
    let vertices = mesh.positions.len();
    let malformed = |what: &str| Err(EncodeError::Malformed(format!("a mesh with {what}")));
    let lengths = [
        mesh.normals.as_ref().map(|n| n.len()),
        mesh.uvs.as_ref().map(|t| t.len()),
        mesh.colors.as_ref().map(|c| c.len()),
    ];
    if lengths.iter().flatten().any(|&length| length != vertices) {
        return malformed("another number of normals, texture coordinates or colours than vertices");
    }
    if mesh.indices.iter().flatten().any(|&i| i as usize >= vertices) {
        return malformed("an index of no vertex");
    }
    let materials = file.materials.len().max(1);
    let of_faces = mesh.face_materials.as_deref().unwrap_or_default();
    if of_faces.len() > mesh.indices.len() || of_faces.iter().any(|&m| m as usize >= materials) {
        return malformed("a material of no face, or an index of no material");
    }
    if u32::try_from(mesh.indices.len()).is_err() {
        return malformed("more than 2^32 faces");
    }
    Ok(())
}

/// Position of a vertex in the coordinates of files.
fn position(mesh: &Mesh, vertex: usize) -> DVec3 {
    mesh.origin + DVec3::from_array(mesh.positions[vertex].map(f64::from))
}

/// The numbers of a file are those of the mesh, in 32 bits.
fn is_single(mesh: &Mesh) -> bool {
    mesh.origin == DVec3::ZERO
}
