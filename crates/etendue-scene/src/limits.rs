//! Bounds on what one scene may take, checked before memory is.

use crate::{image_file, volume_file};

/// Bounds on the input.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of a scene file. Its tree takes up to eighty times its size in memory.
    pub scene_bytes: u64,
    /// Bytes of one mesh file, compressed or not.
    pub file_bytes: u64,
    /// Bytes of one material library.
    pub library_bytes: u64,
    /// Of one image file.
    pub images: image_file::Limits,
    /// Of one volume file.
    pub volumes: volume_file::Limits,
    /// Triangles in all meshes together, and spheres in mesh files, each counted once however many objects share it.
    pub triangles: usize,
    /// Shapes that objects place; an object of a mesh file with spheres places several.
    pub placed: usize,
    /// Vertices of which boxes are taken for `relocate`, in all objects together.
    pub relocated_vertices: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            scene_bytes: 16 << 20,
            file_bytes: 8 << 30,
            library_bytes: 64 << 20,
            images: image_file::Limits::default(),
            volumes: volume_file::Limits::default(),
            triangles: 1 << 28,
            placed: 1 << 24,
            relocated_vertices: 1 << 32,
        }
    }
}
