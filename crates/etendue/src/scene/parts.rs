//! All that a scene is built from: plain records with f64 transforms.

use crate::{
    material::Material,
    math::{DAffine3, DVec3},
    spectrum::Spectrum,
};
use std::sync::Arc;

/// A triangle mesh as it was read: flat arrays, shared.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Added in f64 to every position: keeps meshes far from their origin precise.
    pub origin: DVec3,
    /// Vertex positions relative to `origin`.
    pub positions: Arc<[[f32; 3]]>,
    /// Three vertex indices a face.
    pub indices: Arc<[[u32; 3]]>,
    /// Unit normals, one a vertex; absent: flat shading.
    pub normals: Option<Arc<[[f32; 3]]>>,
    /// Texture coordinates, one a vertex.
    pub uvs: Option<Arc<[[f32; 2]]>>,
    /// Index into [`Object::materials`], one a face; absent: all 0.
    pub face_materials: Option<Arc<[u32]>>,
}

/// Geometry that objects place.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Triangles.
    Mesh(Mesh),
    /// An analytic sphere.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius, above 0.
        radius: f64,
    },
    /// A parallelogram `corner + a u + b v`, u, v in [0, 1], with normal along `u` x `v`; sampled by solid angle where
    /// it is a rectangle.
    Rectangle {
        /// The corner with texture coordinates (0, 0).
        corner: DVec3,
        /// Edge to texture coordinates (1, 0).
        u: DVec3,
        /// Edge to texture coordinates (0, 1).
        v: DVec3,
    },
}

/// A shape placed in the world. Objects that share a shape are instances of it.
#[derive(Clone, Debug)]
pub struct Object {
    /// As in the scene file.
    pub name: String,
    /// Index into [`SceneParts::shapes`].
    pub shape: usize,
    /// Object to world, metres.
    pub transform: DAffine3,
    /// Indices into [`SceneParts::materials`], at least one; a face picks by [`Mesh::face_materials`].
    pub materials: Vec<usize>,
}

/// A light without extent.
#[derive(Clone, Copy, Debug)]
pub struct PointLight {
    /// World space, metres.
    pub position: DVec3,
    /// Radiant intensity, W/sr per channel.
    pub intensity: Spectrum,
}

/// All that a scene is built from.
#[derive(Clone, Debug, Default)]
pub struct SceneParts {
    /// Shared geometry.
    pub shapes: Vec<Shape>,
    /// Placements.
    pub objects: Vec<Object>,
    /// Materials.
    pub materials: Vec<Material>,
    /// Point lights.
    pub point_lights: Vec<PointLight>,
    /// Constant radiance from all directions.
    pub environment: Option<Spectrum>,
}
