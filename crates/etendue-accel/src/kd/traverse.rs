//! Walks a kd-tree from the near cells to the far ones.
//!
//! Every cell has an interval of t, with its planes moved outward by the pad of `padding.rs`. An accepted hit at t lies
//! within the pad of its primitive's box. Going down: where the hit's point is on the side of a plane where the primitive
//! is not listed, the primitive's box, and so the moved plane, is within the pad of the point, and the other cell's
//! interval holds t. So t is in the interval of some leaf that lists the primitive. A cell is left out only if its interval
//! starts beyond the best t; that a point lies in a cell is never asked.

use super::{DEPTH_LIMIT, KdTree, Level, Node, Primitive};
use crate::geometry::World;
use crate::isa::Kernel;
use crate::local_ray::LocalRay;
use crate::padding::SlabRay;
use crate::ray::{Hit, PrimitiveId, Ray};
use crate::search::Search;

/// Searches for a slice of rays; `finish` gets the index of each ray and what was found.
pub(crate) struct Trace<'a, F, const ANY: bool> {
    pub world: &'a World,
    pub tree: &'a KdTree,
    pub rays: &'a [Ray],
    pub finish: F,
}

impl<F: FnMut(usize, Hit), const ANY: bool> Kernel for Trace<'_, F, ANY> {
    type Output = ();

    #[inline(always)]
    fn run(mut self) {
        for (index, ray) in self.rays.iter().enumerate() {
            let mut hit = Hit::MISS;
            if let Some((mut search, local)) = Search::start(ray) {
                let walk = Walk::<ANY> { world: self.world, tree: self.tree, instance: None };
                walk.level(&self.tree.top, &local, &mut search);
                hit = search.hit();
            }
            (self.finish)(index, hit);
        }
    }
}

struct Walk<'a, const ANY: bool> {
    world: &'a World,
    tree: &'a KdTree,
    /// The instance that was entered.
    instance: Option<u32>,
}

impl<const ANY: bool> Walk<'_, ANY> {
    /// True if the search is over.
    fn level(&self, level: &Level, local: &LocalRay, search: &mut Search) -> bool {
        let slab = SlabRay::new(local, &level.padding);
        let mut stack = [(0_u32, 0.0_f32, 0.0_f32); DEPTH_LIMIT];
        let mut waiting = 0;
        let (mut enter, mut exit) = slab.interval(&level.bounds, search.t_min, search.best.t);
        let mut index = 0;
        loop {
            if enter <= exit && enter <= search.best.t {
                match level.nodes[index as usize] {
                    Node::Inner { axis, at, upper } => {
                        let axis = axis as usize;
                        let (far_enter, near_exit) = slab.planes(axis, at, at);
                        let upward = slab.octant >> axis & 1 == 0;
                        let (near, far) = if upward { (index + 1, upper) } else { (upper, index + 1) };
                        stack[waiting] = (far, far_enter.max(enter), exit);
                        waiting += 1;
                        (index, exit) = (near, near_exit.min(exit));
                        continue;
                    }
                    Node::Leaf { first, count } => {
                        for &reference in &level.references[first as usize..(first + count) as usize] {
                            if self.primitive(&level.primitives[reference as usize], local, search) && ANY {
                                return true;
                            }
                        }
                    }
                }
            }
            if waiting == 0 {
                return false;
            }
            waiting -= 1;
            (index, enter, exit) = stack[waiting];
        }
    }

    /// True if it is hit within the range, best or not.
    fn primitive(&self, primitive: &Primitive, local: &LocalRay, search: &mut Search) -> bool {
        let named = |id: PrimitiveId| PrimitiveId { instance: self.instance.unwrap_or(id.instance), ..id };
        match *primitive {
            Primitive::Triangle { ref corners, id, mask } => {
                mask & search.mask != 0 && search.triangle(local, corners, named(id))
            }
            Primitive::Sphere { ref sphere, id, mask } => {
                mask & search.mask != 0 && search.sphere(local, sphere, named(id))
            }
            Primitive::Instance { instance, geometry, mask } => {
                mask & search.mask != 0 && self.enter(instance, geometry, local, search)
            }
        }
    }

    fn enter(&self, instance: u32, geometry: u32, local: &LocalRay, search: &mut Search) -> bool {
        let Some(level) = &self.tree.objects[geometry as usize] else { return false };
        let place = &self.world.instances[instance as usize].place;
        let Some(local) = local.inside(place, search.time) else { return false };
        Walk { instance: Some(instance), ..*self }.level(level, &local, search)
    }
}
