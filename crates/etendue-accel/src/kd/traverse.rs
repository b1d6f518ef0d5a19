//! Walks a kd-tree from the near cells to the far ones.
//!
//! # Why no hit is lost
//!
//! Every cell has an interval of t, with its planes moved outward by the pad of `padding.rs`. An accepted hit at t lies, on every axis,
//! within the pad of a point P of its primitive, and P is in a closed leaf that refers to the primitive (`reference.rs`). On the way
//! down to that leaf every plane has P on the side that is gone to, or in it: so t is in the interval of that side, and in the
//! leaf's. A cell is left out only if it is empty, its interval is, or that begins beyond the best t; that a point lies in a cell is never
//! asked. Intervals are cut at the best t, which is in them still: another hit there may have a smaller id.

use std::cell::Cell as Kept;

use super::KdTree;
use super::arrays::Root;
use super::rounds::{Rounds, SLOTS, Slot};
use crate::geometry::World;
use crate::isa::SimdKernel;
use crate::local_ray::LocalRay;
use crate::padding::SlabRay;
use crate::ray::Ray;
use crate::search::Found;
use crate::search::Search;
use crate::simd::Simd;

thread_local! {
    /// The slots of a thread's rays, kept from call to call.
    static KEPT: Kept<Option<Box<[Slot; SLOTS]>>> = const { Kept::new(None) };
}

/// Searches for a slice of rays; `finish` gets the index of each ray and what was found.
pub(crate) struct Trace<'a, F, const ANY: bool> {
    pub world: &'a World,
    pub tree: &'a KdTree,
    pub rays: &'a [Ray],
    pub finish: F,
}

impl<F: FnMut(usize, Found), const ANY: bool> SimdKernel for Trace<'_, F, ANY> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut slots = KEPT.take().unwrap_or_else(|| Box::new([Slot::EMPTY; SLOTS]));
        let scene = Scene { world: self.world, tree: self.tree };
        Rounds::run::<S, ANY>(simd, scene, self.rays, &mut slots, self.finish);
        KEPT.set(Some(slots));
    }
}

/// What rays meet.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub world: &'a World,
    pub tree: &'a KdTree,
}

/// A node that is to be visited, and the interval of its cell.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    pub node: u32,
    pub enter: f32,
    pub exit: f32,
}

impl Cell {
    /// One that is never left out.
    pub const fn kept(node: u32) -> Self {
        Self { node, enter: f32::NEG_INFINITY, exit: f32::INFINITY }
    }
}

/// How a ray crosses planes of one axis: at `at * rate - start`.
#[repr(C, align(16))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Crossing {
    pub rate: f32,
    /// Where it comes to the far side, at the earliest.
    pub near: f32,
    /// Where it has left the near side, at the latest.
    pub far: f32,
    /// Which child is the near one.
    pub first: u32,
}

/// A ray in the space of a level.
#[derive(Clone, Copy)]
pub(super) struct Local {
    /// By axis; the last stands for leaves.
    pub crossings: [Crossing; 4],
    pub ray: LocalRay,
    /// The instance that was entered, [`NO_INSTANCE`] at the top.
    pub instance: u32,
}

const NO_INSTANCE: u32 = u32::MAX;

impl Local {
    /// No ray.
    pub const NONE: Self = {
        let crossing = Crossing { rate: 0.0, near: 0.0, far: 0.0, first: 0 };
        Self { crossings: [crossing; 4], ray: LocalRay::NONE, instance: NO_INSTANCE }
    };

    /// A ray at the root of a level, unless it misses that.
    #[inline(always)]
    fn new(ray: LocalRay, root: &Root, instance: u32, search: &Search) -> Option<(Self, Cell)> {
        let slab = SlabRay::new(&ray, &root.padding);
        let (enter, exit) = slab.interval(&root.bounds, search.t_min, search.best.t);
        let cell = Cell { node: root.node?, enter, exit };
        let mut local = Self { ray, instance, ..Self::NONE };
        for axis in 0..3 {
            let first = slab.octant >> axis & 1;
            local.crossings[axis] =
                Crossing { rate: slab.rate[axis], near: slab.near[axis], far: slab.far[axis], first };
        }
        (enter <= exit).then_some((local, cell))
    }

    pub fn is_inside(&self) -> bool {
        self.instance != NO_INSTANCE
    }
}

impl Scene<'_> {
    /// A ray of the world; `None` if it misses everything.
    #[inline(always)]
    pub fn start(&self, ray: &Ray) -> Option<(Search, Local, Cell)> {
        let (search, ray) = Search::start(ray)?;
        let (local, cell) = Local::new(ray, &self.tree.top, NO_INSTANCE, &search)?;
        Some((search, local, cell))
    }

    /// The ray in an instance's space and where to start there.
    pub fn enter(&self, instance: u32, geometry: u32, ray: &LocalRay, search: &Search) -> Option<(Local, Cell)> {
        if !self.is_seen(instance, search) {
            return None;
        }
        let root = self.tree.objects[geometry as usize].as_ref()?;
        let inside = ray.inside(&self.world.instances[instance as usize].place, search.time)?;
        Local::new(inside, root, instance, search)
    }

    #[inline(always)]
    pub fn is_seen(&self, instance: u32, search: &Search) -> bool {
        self.world.instances[instance as usize].mask & search.mask != 0
    }
}
