//! Where the primitives of a level come from, in whichever form a structure stores them.

use crate::geometry::{Geometry, Instance, Sphere, World};
use crate::items::ItemKind;
use crate::ray::PrimitiveId;

/// Where the primitives of a level come from.
#[derive(Clone, Copy)]
pub(crate) enum Source<'a> {
    Top(&'a World),
    Geometry(&'a Geometry),
}

impl<'a> Source<'a> {
    #[inline(always)]
    fn geometry(self, id: PrimitiveId) -> &'a Geometry {
        match self {
            Self::Top(world) => &world.geometries[world.instances[id.instance as usize].geometry as usize],
            Self::Geometry(geometry) => geometry,
        }
    }

    /// The mask of the instance of an item; all ones below an instance, whose own mask is checked when it is entered.
    pub fn mask(self, id: PrimitiveId) -> u32 {
        match self {
            Self::Top(world) => world.instances[id.instance as usize].mask,
            Self::Geometry(_) => u32::MAX,
        }
    }

    /// What an item is.
    pub fn kind(self, id: PrimitiveId) -> ItemKind {
        match self {
            Self::Top(world) => kind_of(world, &world.instances[id.instance as usize]),
            Self::Geometry(geometry) => kind_of_primitives(geometry),
        }
    }

    /// What all items are, `None` if there are several kinds.
    pub fn sole_kind(self) -> Option<ItemKind> {
        match self {
            Self::Top(world) => {
                let mut kinds = world.instances.iter().map(|instance| kind_of(world, instance));
                let first = kinds.next()?;
                kinds.all(|kind| kind == first).then_some(first)
            }
            Self::Geometry(geometry) => Some(kind_of_primitives(geometry)),
        }
    }

    /// The corners of a triangle item; `None` for other items.
    #[inline(always)]
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

fn kind_of(world: &World, instance: &Instance) -> ItemKind {
    match instance.place.is_transformed() {
        false => kind_of_primitives(&world.geometries[instance.geometry as usize]),
        true => ItemKind::Instance,
    }
}

fn kind_of_primitives(geometry: &Geometry) -> ItemKind {
    match geometry {
        Geometry::Triangles(_) => ItemKind::Triangle,
        Geometry::Spheres(_) => ItemKind::Sphere,
    }
}
