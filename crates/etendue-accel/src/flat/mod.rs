//! Worlds of few primitives, without a tree, and the few large ones of others: sixteen rays at a time meet one primitive
//! after the other.
//!
//! Rays fill the lanes of vectors as they come, whether they are near one another or not. A first
//! pass in f32 tests the planes and edges of all triangles and lists the pairs of ray and triangle that may be hits; the exact test decides the
//! listed pairs in full vectors. Nothing depends on where rays go, so there is nothing to mispredict.

mod facet;
mod scan;
mod settle;
mod sphere;
mod trace;

use crate::bounds::Bounds;
use crate::error::{BuildError, room};
use crate::geometry::{Geometry, Sphere, World};
use crate::isa::Isa;
use crate::items::{self, Item};
use crate::ray::PrimitiveId;
use crate::source::Source;

pub(crate) use facet::{Facet, Facets};
pub(crate) use scan::{Columns, Group, LANES, Pairs, scan};
pub(crate) use settle::{Sheared, shear};
pub(crate) use trace::{Beyond, Flight, Trace};

/// Most triangles of a flat world, with any instruction set.
pub(crate) const LIMIT: usize = 192;

/// A sphere costs as much as this many triangles.
const SPHERE_COST: usize = 4;

/// The place of a primitive in the order of ids, from 1; 0 is none.
pub(crate) type Order = u32;

/// A triangle.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(crate) struct FlatTriangle {
    /// By vertex and axis.
    pub corners: [[f32; 3]; 3],
    /// Of the instance.
    pub mask: u32,
    pub order: Order,
}

/// A sphere.
#[derive(Clone, Copy, Debug)]
struct FlatSphere {
    sphere: Sphere,
    mask: u32,
    order: Order,
}

/// Primitives of a world in the order of their ids: all of them, or some of the triangles.
#[derive(Debug)]
pub(crate) struct Flat {
    triangles: Vec<FlatTriangle>,
    facets: Facets,
    spheres: Vec<FlatSphere>,
    /// By order less one.
    ids: Vec<PrimitiveId>,
    /// The order of the first primitive of each instance, and one more.
    starts: Vec<Order>,
    bounds: Bounds,
}

/// The most triangles for which no tree is faster, or the number of instances: measured on incoherent rays by
/// `examples/small_worlds.rs`.
pub(crate) fn most(isa: Isa) -> usize {
    match isa {
        Isa::Portable => 48,
        Isa::Avx2 => 128,
        Isa::Avx512 => LIMIT,
    }
}

impl Flat {
    /// The world as a list; `None` if it has too many primitives, or transformed instances. The world has been checked.
    pub fn build(world: &World, isa: Isa) -> Result<Option<Self>, BuildError> {
        let limit = most(isa);
        let cost = |geometry: &Geometry| match geometry {
            Geometry::Triangles(mesh) => mesh.indices.len(),
            Geometry::Spheres(spheres) => spheres.len().saturating_mul(SPHERE_COST),
        };
        let costs = world.instances.iter().map(|instance| cost(&world.geometries[instance.geometry as usize]));
        let simple = world.instances.len() <= limit
            && world.instances.iter().all(|instance| !instance.place.is_transformed())
            && costs.fold(0, usize::saturating_add) <= limit;
        if !simple {
            return Ok(None);
        }
        let bounds = items::world_bounds(world)?;
        let mut flat = Self {
            triangles: room("triangles", limit)?,
            facets: Facets::default(),
            spheres: room("spheres", limit)?,
            ids: room("primitives", limit)?,
            starts: room("instances", limit + 1)?,
            bounds,
        };
        for (index, instance) in world.instances.iter().enumerate() {
            let geometry = &world.geometries[instance.geometry as usize];
            let (first, mask) = (flat.ids.len() as Order + 1, instance.mask);
            flat.starts.push(first);
            let numbered = 0..geometry.len() as u32;
            flat.ids.extend(numbered.map(|primitive| PrimitiveId { instance: index as u32, primitive }));
            match geometry {
                Geometry::Triangles(mesh) => flat.triangles.extend((0..mesh.indices.len()).map(|face| FlatTriangle {
                    corners: mesh.corners(face),
                    mask,
                    order: first + face as Order,
                })),
                Geometry::Spheres(spheres) => {
                    flat.spheres.extend(spheres.iter().enumerate().map(|(i, &sphere)| FlatSphere {
                        sphere,
                        mask,
                        order: first + i as Order,
                    }))
                }
            }
        }
        flat.starts.push(flat.ids.len() as Order + 1);
        flat.facets = Facets::new(&flat.triangles);
        Ok(Some(flat))
    }

    /// The corners of the triangle at a place in the list, see [`crate::search::Found`].
    #[inline(always)]
    pub fn corners(&self, place: u32) -> Option<[[f32; 3]; 3]> {
        // Where there are spheres, places differ.
        let triangle = self.triangles.get(place as usize)?;
        (triangle.order == place + 1).then_some(triangle.corners)
    }

    /// Triangle items of the top level of a world, not more than [`LIMIT`].
    pub fn of_triangles(world: &World, items: &[Item]) -> Result<Self, BuildError> {
        let source = Source::Top(world);
        let mut ids = room("primitives", items.len())?;
        ids.extend(items.iter().map(Item::id));
        ids.sort_unstable();
        let triangle = |(place, &id): (usize, &PrimitiveId)| {
            let (corners, mask) = (source.triangle(id)?, source.mask(id));
            Some(FlatTriangle { corners, mask, order: place as Order + 1 })
        };
        let mut triangles = room("triangles", ids.len())?;
        triangles.extend(ids.iter().enumerate().filter_map(triangle));
        let last = ids.last().map_or(0, |id| id.instance + 1);
        let mut starts = room("instances", last as usize + 1)?;
        starts.extend((0..=last).map(|instance| ids.partition_point(|id| id.instance < instance) as Order + 1));
        let facets = Facets::new(&triangles);
        Ok(Self { triangles, facets, spheres: Vec::new(), ids, starts, bounds: items::bounds_of(items) })
    }

    pub fn bounds(&self) -> Bounds {
        self.bounds
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.triangles[..])
            + self.facets.bytes()
            + size_of_val(&self.spheres[..])
            + size_of_val(&self.ids[..])
            + size_of_val(&self.starts[..])
    }

    /// Where an id stands; 0 if it names nothing here.
    #[inline(always)]
    fn order_of(&self, id: PrimitiveId) -> Order {
        let Some(&[first, next]) = self.starts.get(id.instance as usize..).and_then(|rest| rest.first_chunk()) else {
            return 0;
        };
        let ids = &self.ids[first as usize - 1..next as usize - 1];
        // All of an instance, or at least the first ones, as a rule.
        if ids.get(id.primitive as usize) == Some(&id) {
            return first + id.primitive;
        }
        ids.binary_search(&id).map_or(0, |place| first + place as Order)
    }
}
