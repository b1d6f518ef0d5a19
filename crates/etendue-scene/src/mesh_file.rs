//! What a mesh file holds, whatever its format.

use crate::{Diagnostics, FileId, Origin, SourceError};
use etendue::{
    material::{Material, Scattering},
    scene::Mesh,
    spectrum::Spectrum,
};
use std::{ops::Range, sync::Arc};

/// A mesh file that was read.
#[derive(Clone, Debug)]
pub struct MeshFile {
    /// One mesh with only finite positions and only valid indices. [`Mesh::face_materials`] indexes `materials`; it is
    /// absent if all faces have material 0, or the file names none.
    ///
    /// [`Mesh::origin`] is exactly zero, except on axes where the mesh lies many times its own size away from the file's
    /// origin, so that `f32` keeps its detail there.
    pub mesh: Mesh,
    /// The materials that faces use, in the order of first use; empty if the file names none.
    pub materials: Vec<NamedMaterial>,
    /// Named runs of faces, in the order of the file.
    pub groups: Vec<Group>,
    /// What was approximated, skipped or ignored: no errors.
    pub notes: Diagnostics,
}

/// A material that a mesh file names.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedMaterial {
    /// As in the file; empty for faces that name none in a file where others do.
    pub name: String,
    /// What it means here. A name that nothing defines gets [`MeshFile::default_material`].
    pub material: Material,
    /// Where it is defined; if it is not, where it is first used.
    pub origin: Option<Origin>,
}

/// A run of faces with one name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Group {
    /// Name of the object (OBJ `o`), if there is one.
    pub object: Option<String>,
    /// Names of the group (OBJ `g`) as written, if there are any.
    pub group: Option<String>,
    /// Its faces (triangles) in [`MeshFile::mesh`].
    pub faces: Range<usize>,
}

/// Finds a material library by the name that a mesh file gives: its bytes, or why not.
pub type OpenLibrary<'a> = &'a mut dyn FnMut(&str) -> Result<(FileId, Arc<Vec<u8>>), SourceError>;

impl MeshFile {
    /// What faces without a (known) material are made of: grey, half of the light reflected.
    pub fn default_material(name: &str) -> Material {
        Material {
            name: name.to_owned(),
            scattering: Scattering::Diffuse { reflectance: Spectrum::splat(0.5), transmittance: Spectrum::BLACK },
            emission: None,
            opacity: 1.0,
        }
    }
}
