//! What came of a mesh file: counts, and what became of its keys.

use crate::mesh_file::{KeyStatus, KeyUse, MeshFile};
use etendue::{material::Scattering, scene::Mesh, texture::TextureImage};
use std::{
    collections::BTreeSet,
    fmt,
    path::{Path, PathBuf},
    sync::Arc,
};

/// A mesh file that became part of a scene.
#[derive(Clone, Debug)]
pub struct Import {
    /// Its path.
    pub path: PathBuf,
    /// Triangles that the scene has; larger faces have been cut.
    pub triangles: usize,
    /// Triangles in the file, where the scene has fewer.
    pub simplified_from: Option<usize>,
    /// Vertices; a vertex with several normals or texture coordinates counts once for each.
    pub vertices: usize,
    /// Spheres.
    pub spheres: usize,
    /// Materials that it uses.
    pub materials: usize,
    /// Image files that its materials name.
    pub textures: usize,
    /// What became of its keys and statements.
    pub keys: Vec<KeyUse>,
}

/// An image file that became a texture.
#[derive(Clone, Debug)]
pub struct LoadedTexture {
    /// Its path.
    pub path: PathBuf,
    /// The image.
    pub image: Arc<TextureImage>,
}

impl Import {
    /// What came of `file`.
    pub fn new(path: &Path, file: &MeshFile) -> Self {
        let mut textures = BTreeSet::new();
        for named in &file.materials {
            named.material.map_textures(&mut |record, _| -> Option<()> {
                let mut images = Vec::new();
                record.images(&mut images);
                textures.extend(images.iter().map(|image| image.file.value.clone()));
                None
            });
        }
        Self {
            path: path.to_owned(),
            triangles: file.mesh.indices.len(),
            simplified_from: None,
            vertices: file.mesh.positions.len(),
            spheres: file.spheres.len(),
            materials: file.materials.len(),
            textures: textures.len(),
            keys: file.keys.clone(),
        }
    }

    /// What the scene has of the file's mesh.
    pub fn use_mesh(&mut self, mesh: &Mesh) {
        let before = std::mem::replace(&mut self.triangles, mesh.indices.len());
        self.simplified_from = (before != self.triangles).then_some(before);
        self.vertices = mesh.positions.len();
    }

    /// Keys that count, but not as they are meant.
    pub fn approximated(&self) -> usize {
        self.keys.iter().filter(|entry| is_key(entry) && matches!(entry.status, KeyStatus::Approximated(_))).count()
    }

    /// Keys that do not count.
    pub fn ignored(&self) -> usize {
        self.keys.iter().filter(|entry| is_key(entry) && matches!(entry.status, KeyStatus::Ignored(_))).count()
    }

    /// What was found besides: repaired faces, vertices that nothing uses.
    pub fn other_findings(&self) -> usize {
        self.keys.iter().filter(|entry| !is_key(entry) && entry.status != KeyStatus::Used).count()
    }
}

/// Some are of no one word of the file.
fn is_key(entry: &KeyUse) -> bool {
    !entry.key.is_empty()
}

/// One line: counts, and what there is to tell of keys.
impl fmt::Display for Import {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}: {}", self.path.display(), counted(self.triangles, "triangle"))?;
        if let Some(before) = self.simplified_from {
            write!(f, " of {}", grouped(before as u64))?;
        }
        for (count, noun) in [(self.spheres, "sphere"), (self.materials, "material"), (self.textures, "texture")] {
            if count > 0 {
                write!(f, ", {}", counted(count, noun))?;
            }
        }
        let mut separator = "; ";
        for (count, noun, what) in [
            (self.approximated(), "key", " approximated"),
            (self.ignored(), "key", " ignored"),
            (self.other_findings(), "other finding", ""),
        ] {
            if count > 0 {
                write!(f, "{separator}{}{what}", counted(count, noun))?;
                separator = ", ";
            }
        }
        Ok(())
    }
}

/// What a scene file calls the type of a material.
pub fn type_name<C, N>(scattering: &Scattering<C, N>) -> &'static str {
    match scattering {
        Scattering::Diffuse { .. } => "diffuse",
        Scattering::Mirror { .. } => "mirror",
        Scattering::Glass { .. } => "glass",
        Scattering::RoughMetal { .. } => "rough-metal",
        Scattering::RoughGlass { .. } => "rough-glass",
        Scattering::BrushedMetal { .. } => "brushed-metal",
        Scattering::Mtl { .. } => "mtl",
        Scattering::Phong(_) => "phong",
        Scattering::Principled(_) => "principled",
        Scattering::Black => "black",
    }
}

/// A number and a noun: `1 face`, `5,856 faces`.
pub fn counted(count: usize, noun: &str) -> String {
    format!("{} {noun}{}", grouped(count as u64), if count == 1 { "" } else { "s" })
}

/// A number with a comma between each three digits.
pub fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (i, digit) in digits.chars().enumerate() {
        if i > 0 && (digits.len() - i).is_multiple_of(3) {
            text.push(',');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_in_threes() {
        for (number, text) in [(0, "0"), (999, "999"), (1000, "1,000"), (1_234_567, "1,234,567")] {
            assert_eq!(grouped(number), text);
        }
        assert_eq!((counted(1, "face"), counted(5856, "face")), ("1 face".to_owned(), "5,856 faces".to_owned()));
    }
}
