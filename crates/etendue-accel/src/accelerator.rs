//! The interface: slices of rays in, slices of hits out.

use std::fmt;
use std::str::FromStr;

use crate::bounds::Bounds;
use crate::brute;
use crate::bvh::{self, Bvh};
use crate::error::BuildError;
use crate::flat::{self, Flat};
use crate::geometry::{Place, World};
use crate::isa::{Isa, Kernel, dispatch, run};
use crate::items;
use crate::kd::{self, KdTree};
use crate::ray::{Hit, Ray};
use crate::search::Found;
use crate::source::Source;
use crate::threads;

/// How the kd-tree chooses its planes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum KdTreeSplit {
    /// The cheapest plane by the surface-area heuristic.
    SurfaceArea,
    /// The middle of the longest axis.
    Midpoint,
}

/// The kinds of accelerator. All give the same hits, bit for bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AcceleratorKind {
    /// Tests every primitive: the reference for the others.
    Brute,
    /// Splits space.
    KdTree(KdTreeSplit),
    /// Boxes in boxes, eight at a time: the fastest. A world of few primitives is traced without any box.
    Bvh,
}

impl AcceleratorKind {
    /// All kinds.
    pub const ALL: [Self; 4] =
        [Self::Brute, Self::KdTree(KdTreeSplit::SurfaceArea), Self::KdTree(KdTreeSplit::Midpoint), Self::Bvh];

    /// The name as `Display` writes it and `FromStr` reads it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Brute => "brute",
            Self::KdTree(KdTreeSplit::SurfaceArea) => "kdtree",
            Self::KdTree(KdTreeSplit::Midpoint) => "kdtree-midpoint",
            Self::Bvh => "bvh",
        }
    }
}

impl fmt::Display for AcceleratorKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.pad(self.name())
    }
}

/// The name is none of an accelerator.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown accelerator `{0}`: expected `brute`, `kdtree`, `kdtree-midpoint` or `bvh`")]
pub struct UnknownAccelerator(pub String);

impl FromStr for AcceleratorKind {
    type Err = UnknownAccelerator;

    fn from_str(name: &str) -> Result<Self, UnknownAccelerator> {
        Self::ALL.into_iter().find(|kind| kind.name() == name).ok_or_else(|| UnknownAccelerator(name.to_owned()))
    }
}

/// The size of an accelerator.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stats {
    /// Nodes of all trees, inner and (kd-tree) leaves.
    pub nodes: usize,
    /// Primitives of all instances, shared ones counted each time.
    pub primitives: usize,
    /// Bytes of the trees, without the world itself.
    pub bytes: usize,
    /// Nodes on the longest way down, through an instance.
    pub depth: usize,
}

#[derive(Debug)]
enum Structure {
    Brute,
    KdTree(KdTree),
    Bvh(Box<Bvh>),
    /// Instead of a tree that would be no faster.
    Flat(Flat),
}

/// A world ready for rays. Immutable; any number of threads may use it at once.
#[derive(Debug)]
pub struct Accelerator {
    world: World,
    structure: Structure,
    bounds: Bounds,
    kind: AcceleratorKind,
    isa: Isa,
}

impl Accelerator {
    /// Checks the world and builds the structure on `threads` threads (0: as many as there are processors). The
    /// structure does not depend on their number. The world's arrays are shared, not copied. The threads are kept for the next
    /// build; asleep, they cost nothing.
    pub fn build(world: &World, kind: AcceleratorKind, isa: Isa, threads: usize) -> Result<Self, BuildError> {
        let (structure, bounds) =
            threads::on(threads, || items::check(world).and_then(|()| Self::structure(world, kind, isa)))?;
        Ok(Self { world: world.clone(), structure, bounds, kind, isa })
    }

    /// The same world with other places, one for each instance: rays find what they would find in a fresh build.
    /// The structures of geometries are kept. In the BVH the tree over the world gets new boxes, or is built anew if it is
    /// small or its boxes have grown too large; the kd-tree's is always built anew. Where an instance comes to be
    /// transformed that was not, or the reverse, everything is built anew. A failed call loses the accelerator.
    pub fn with_places(mut self, places: Vec<Place>, threads: usize) -> Result<Self, BuildError> {
        let instances = &mut self.world.instances;
        if places.len() != instances.len() {
            return Err(BuildError::Places { places: places.len(), instances: instances.len() });
        }
        let mut as_before = true;
        for (instance, place) in instances.iter_mut().zip(places) {
            as_before &= instance.place.is_transformed() == place.is_transformed();
            instance.place = place;
        }
        let Self { world, structure, bounds, kind, isa } = &mut self;
        if !as_before {
            return Self::build(world, *kind, *isa, threads);
        }
        items::check_places(world)?;
        *bounds = match structure {
            Structure::Brute => items::world_bounds(world)?,
            Structure::KdTree(tree) => {
                threads::on(threads, || tree.move_instances(world))?;
                tree.bounds()
            }
            Structure::Bvh(bvh) => {
                threads::on(threads, || bvh.move_instances(world))?;
                bvh.bounds()
            }
            Structure::Flat(flat) => flat.bounds(),
        };
        Ok(self)
    }

    fn structure(world: &World, kind: AcceleratorKind, isa: Isa) -> Result<(Structure, Bounds), BuildError> {
        Ok(match kind {
            AcceleratorKind::Brute => (Structure::Brute, items::world_bounds(world)?),
            AcceleratorKind::KdTree(split) => {
                let tree = KdTree::build(world, split)?;
                let bounds = tree.bounds();
                (Structure::KdTree(tree), bounds)
            }
            AcceleratorKind::Bvh => {
                if let Some(flat) = Flat::build(world, isa.usable())? {
                    let bounds = flat.bounds();
                    return Ok((Structure::Flat(flat), bounds));
                }
                let bvh = Bvh::build(world, isa.usable())?;
                let bounds = bvh.bounds();
                (Structure::Bvh(Box::new(bvh)), bounds)
            }
        })
    }

    /// The closest hit of each ray, or [`Hit::MISS`]. Rays with numbers that are not finite, origins beyond 2^50, a
    /// largest direction component outside 2^-40 to 2^40, or an empty range miss.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_hits(&self, rays: &[Ray], hits: &mut [Hit]) {
        self.closest(rays, hits, None);
    }

    /// As [`Self::closest_hits`], with the corners of the triangles that are hit, in the space of their geometry: the very numbers of
    /// its mesh, mostly from memory that the search has just read. Zeros for spheres and misses.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn closest_facets(&self, rays: &[Ray], hits: &mut [Hit], corners: &mut [[[f32; 3]; 3]]) {
        assert_eq!(rays.len(), corners.len(), "as many facets as rays");
        self.closest(rays, hits, Some(corners));
    }

    // One for both: what searches is compiled many times over as it is.
    fn closest(&self, rays: &[Ray], hits: &mut [Hit], mut corners: Option<&mut [[[f32; 3]; 3]]>) {
        assert_eq!(rays.len(), hits.len(), "as many hits as rays");
        self.trace::<false>(rays, |index, found| {
            hits[index] = found.hit;
            if let Some(corners) = &mut corners {
                corners[index] = self.corners(&found);
            }
        });
    }

    #[inline(always)]
    fn corners(&self, found: &Found) -> [[f32; 3]; 3] {
        let corners = match &self.structure {
            Structure::Bvh(bvh) => bvh.corners(found.place),
            Structure::KdTree(tree) => tree.corners(found.place),
            Structure::Flat(flat) => flat.corners(found.place),
            Structure::Brute => None,
        };
        match corners {
            Some(corners) => corners,
            None if found.hit.is_hit() => Source::Top(&self.world).triangle(found.hit.id).unwrap_or_default(),
            None => Default::default(),
        }
    }

    /// For each ray, whether anything is hit: the same as `is_hit` of the closest hit, but faster.
    ///
    /// # Panics
    /// If the slices differ in length.
    pub fn any_hits(&self, rays: &[Ray], occluded: &mut [bool]) {
        assert_eq!(rays.len(), occluded.len(), "as many results as rays");
        self.trace::<true>(rays, |index, found| occluded[index] = found.hit.is_hit());
    }

    fn trace<const ANY: bool>(&self, rays: &[Ray], finish: impl FnMut(usize, Found)) {
        let world = &self.world;
        match &self.structure {
            Structure::Brute => run(self.isa, BruteTrace::<_, ANY> { world, rays, finish }),
            Structure::KdTree(tree) => dispatch(self.isa, kd::Trace::<_, ANY> { world, tree, rays, finish }),
            Structure::Bvh(bvh) if bvh.is_few(rays.len()) => bvh::few::<ANY>(self.isa, (world, bvh), rays, finish),
            Structure::Bvh(bvh) => dispatch(self.isa, bvh::Trace::<_, ANY> { world, bvh, rays, finish }),
            Structure::Flat(flat) => dispatch(self.isa, flat::Trace::<_, ANY> { flat, rays, finish }),
        }
    }

    /// The box around everything, `None` if there is nothing. Transformed instances count by the boxes of their boxes.
    pub fn bounds(&self) -> Option<Bounds> {
        (!self.bounds.is_empty()).then_some(self.bounds)
    }

    /// The instruction set in use.
    pub fn isa(&self) -> Isa {
        self.isa
    }

    /// The size of the structure.
    pub fn stats(&self) -> Stats {
        let sizes = |instance: &crate::Instance| self.world.geometries[instance.geometry as usize].len();
        let primitives = self.world.instances.iter().map(sizes).fold(0, usize::saturating_add);
        let (nodes, bytes, depth) = match &self.structure {
            Structure::Brute => (0, 0, 0),
            Structure::KdTree(tree) => (tree.nodes(), tree.bytes(), tree.depth()),
            Structure::Bvh(bvh) => (bvh.nodes(), bvh.bytes(), bvh.depth()),
            Structure::Flat(flat) => (0, flat.bytes(), 0),
        };
        Stats { nodes, primitives, bytes, depth }
    }
}

struct BruteTrace<'a, F, const ANY: bool> {
    world: &'a World,
    rays: &'a [Ray],
    finish: F,
}

impl<F: FnMut(usize, Found), const ANY: bool> Kernel for BruteTrace<'_, F, ANY> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        for (index, ray) in self.rays.iter().enumerate() {
            let found = brute::search::<ANY>(self.world, ray).map_or(Found::MISS, |search| search.found());
            (self.finish)(index, found);
        }
    }
}
