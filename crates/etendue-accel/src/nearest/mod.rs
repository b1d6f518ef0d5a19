//! The closest point of a triangle mesh to each of many points.

mod search;
mod triangle;

use rayon::prelude::*;

use crate::bvh::Bvh;
use crate::error::BuildError;
use crate::geometry::{Geometry, Instance, Place, TriangleMesh, World};
use crate::isa::{Isa, dispatch};
use crate::items;

use search::Search;
pub use triangle::closest_on_triangle;

/// The closest point of a mesh to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClosestPoint {
    /// Square of the distance; infinite if there is none.
    pub distance_squared: f64,
    /// Weights of the second and the third corner, each at least 0, together at most 1.
    pub weights: [f64; 2],
    /// The face; `u32::MAX` if there is none.
    pub face: u32,
}

impl ClosestPoint {
    /// There is none.
    pub const NONE: Self = Self { distance_squared: f64::INFINITY, weights: [0.0; 2], face: u32::MAX };

    /// True if there is one.
    #[inline(always)]
    pub fn is_found(&self) -> bool {
        self.face != u32::MAX
    }

    /// Weights of the three corners.
    #[inline(always)]
    pub fn corner_weights(&self) -> [f64; 3] {
        let [v, w] = self.weights;
        [1.0 - v - w, v, w]
    }

    /// True if a search prefers this one: by distance, then by face.
    #[inline(always)]
    fn is_before(&self, other: &Self) -> bool {
        self.distance_squared < other.distance_squared
            || (self.distance_squared == other.distance_squared && self.face < other.face)
    }
}

/// A mesh ready for closest points: an 8-wide BVH. Immutable; any number of threads may use it at once.
#[derive(Debug)]
pub struct ClosestPoints {
    mesh: TriangleMesh,
    bvh: Bvh,
    isa: Isa,
}

/// Points that a thread takes at once.
const SLICE: usize = 512;

impl ClosestPoints {
    /// Checks the mesh and builds the structure on the threads of the current pool. The mesh's arrays are shared, not copied.
    pub fn build(mesh: &TriangleMesh, isa: Isa) -> Result<Self, BuildError> {
        let instances = vec![Instance { geometry: 0, place: Place::World, mask: u32::MAX }];
        let world = World { geometries: vec![Geometry::Triangles(mesh.clone())], instances };
        items::check(&world)?;
        Ok(Self { mesh: mesh.clone(), bvh: Bvh::build(&world, isa)?, isa })
    }

    /// The mesh.
    pub fn mesh(&self) -> &TriangleMesh {
        &self.mesh
    }

    /// Bytes of the structure, without the mesh.
    pub fn bytes(&self) -> usize {
        self.bvh.bytes()
    }

    /// For each point the closest of the mesh, as far as it is at most `within` away (infinite: however far), on the threads of
    /// the current pool. Where faces are equally far to the last bit, as computed in f64 by [`closest_on_triangle`], the one
    /// with the smallest index is given. Points with a coordinate that is not finite or beyond 2^50 have none.
    ///
    /// Points that follow each other in the slice had better be near each other: each search starts with the answer of the
    /// one before.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest(&self, points: &[[f64; 3]], within: f64, found: &mut [ClosestPoint]) {
        assert_eq!(points.len(), found.len(), "as many answers as points");
        found.par_chunks_mut(SLICE).zip(points.par_chunks(SLICE)).for_each(|(found, points)| {
            dispatch(self.isa, Search { mesh: &self.mesh, bvh: &self.bvh, points, hints: &[], within, found });
        });
    }

    /// The same answers as those of [`Self::closest`], found sooner if `hints`, a face for each point, are near them. Hints
    /// that are no face are passed over.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_from(&self, points: &[[f64; 3]], hints: &[u32], within: f64, found: &mut [ClosestPoint]) {
        assert!(points.len() == found.len() && hints.len() == points.len(), "as many answers and hints as points");
        let slices = points.par_chunks(SLICE).zip(hints.par_chunks(SLICE));
        found.par_chunks_mut(SLICE).zip(slices).for_each(|(found, (points, hints))| {
            dispatch(self.isa, Search { mesh: &self.mesh, bvh: &self.bvh, points, hints, within, found });
        });
    }
}
