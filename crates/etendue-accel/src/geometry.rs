//! What rays can hit: flat arrays of triangles and spheres, placed by instances.

use std::sync::Arc;

use crate::motion::Motion;

/// An indexed triangle mesh in its own space.
#[derive(Clone, Debug)]
pub struct TriangleMesh {
    /// Vertex positions, finite.
    pub positions: Arc<[[f32; 3]]>,
    /// Three vertex indices a face, each below `positions.len()`.
    pub indices: Arc<[[u32; 3]]>,
}

/// A sphere in its instance's space.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Centre, finite.
    pub center: [f32; 3],
    /// Radius, finite and above 0.
    pub radius: f32,
}

/// A set of primitives of one kind; primitive i of an instance is triangle or sphere i of its geometry.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Triangles.
    Triangles(TriangleMesh),
    /// Analytic spheres.
    Spheres(Arc<[Sphere]>),
}

/// An affine map and its inverse, rows of 3x4 matrices.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transform {
    /// Object to world.
    pub to_world: [[f32; 4]; 3],
    /// World to object, computed in f64 from the rounded `to_world` and rounded once.
    pub to_object: [[f32; 4]; 3],
}

/// Where an instance is.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Place {
    /// As the geometry says: such instances share one flat structure and cost nothing to enter.
    #[default]
    World,
    /// Always the same.
    Fixed(Transform),
    /// At a ray's time.
    Moving(Arc<Motion>),
}

impl Place {
    /// True unless the geometry is in the world's space.
    #[inline(always)]
    pub fn is_transformed(&self) -> bool {
        !matches!(self, Self::World)
    }

    /// The map to the world at a shutter time; `None` for [`Self::World`].
    #[inline(always)]
    pub fn at(&self, time: f32) -> Option<Transform> {
        match self {
            Self::World => None,
            Self::Fixed(transform) => Some(*transform),
            Self::Moving(motion) => Some(motion.at(time)),
        }
    }
}

/// One placement of a geometry.
#[derive(Clone, Debug)]
pub struct Instance {
    /// Index into [`World::geometries`].
    pub geometry: u32,
    /// Where it is.
    pub place: Place,
    /// Seen by rays with a common bit.
    pub mask: u32,
}

/// Everything that rays can hit.
#[derive(Clone, Debug, Default)]
pub struct World {
    /// Geometries, shared by instances.
    pub geometries: Vec<Geometry>,
    /// Placements; the order gives the instance ids.
    pub instances: Vec<Instance>,
}
