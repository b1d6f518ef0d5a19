//! Where the primitives of a level come from, in whichever form a structure stores them.

use crate::geometry::{Geometry, Sphere, World};
use crate::ray::PrimitiveId;

/// Where the primitives of a level come from.
#[derive(Clone, Copy)]
pub(crate) enum Source<'a> {
    Top(&'a World),
    Geometry(&'a Geometry),
}

impl<'a> Source<'a> {
    fn geometry(self, id: PrimitiveId) -> &'a Geometry {
        match self {
            Self::Top(world) => &world.geometries[world.instances[id.instance as usize].geometry as usize],
            Self::Geometry(geometry) => geometry,
        }
    }

    pub fn mask(self, id: PrimitiveId) -> u32 {
        match self {
            Self::Top(world) => world.instances[id.instance as usize].mask,
            Self::Geometry(_) => u32::MAX,
        }
    }

    /// The corners of a triangle item; `None` for other items.
    pub fn triangle(self, id: PrimitiveId) -> Option<[[f32; 3]; 3]> {
        match self.geometry(id) {
            Geometry::Triangles(mesh) => Some(mesh.corners(id.primitive as usize)),
            Geometry::Spheres(_) => None,
        }
    }

    /// A sphere item; `None` for other items.
    pub fn sphere(self, id: PrimitiveId) -> Option<Sphere> {
        match self.geometry(id) {
            Geometry::Triangles(_) => None,
            Geometry::Spheres(spheres) => spheres.get(id.primitive as usize).copied(),
        }
    }

    /// Index of the geometry of an instance item.
    pub fn geometry_index(self, id: PrimitiveId) -> u32 {
        match self {
            Self::Top(world) => world.instances[id.instance as usize].geometry,
            Self::Geometry(_) => 0,
        }
    }
}
