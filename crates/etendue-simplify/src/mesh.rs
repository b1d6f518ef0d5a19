//! Triangle meshes as flat arrays.

/// A triangle mesh, borrowed. Arrays of vertices have one length; those that are not there are `None`.
#[derive(Clone, Copy, Debug)]
pub struct MeshRef<'a> {
    /// Vertex positions, in any unit.
    pub positions: &'a [[f32; 3]],
    /// Three vertex indices a face, counter-clockwise seen from outside.
    pub faces: &'a [[u32; 3]],
    /// Unit normals, one a vertex.
    pub normals: Option<&'a [[f32; 3]]>,
    /// Texture coordinates, one a vertex.
    pub uvs: Option<&'a [[f32; 2]]>,
    /// Linear colours with opacity, each in \[0, 1\], one a vertex.
    pub colors: Option<&'a [[f32; 4]]>,
    /// Material, one a face.
    pub materials: Option<&'a [u32]>,
}

/// A triangle mesh, owned; see [`MeshRef`].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Three vertex indices a face.
    pub faces: Vec<[u32; 3]>,
    /// Unit normals, one a vertex.
    pub normals: Option<Vec<[f32; 3]>>,
    /// Texture coordinates, one a vertex.
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Colours, one a vertex.
    pub colors: Option<Vec<[f32; 4]>>,
    /// Material, one a face.
    pub materials: Option<Vec<u32>>,
}

impl Mesh {
    /// Borrows all arrays.
    pub fn as_ref(&self) -> MeshRef<'_> {
        MeshRef {
            positions: &self.positions,
            faces: &self.faces,
            normals: self.normals.as_deref(),
            uvs: self.uvs.as_deref(),
            colors: self.colors.as_deref(),
            materials: self.materials.as_deref(),
        }
    }
}
