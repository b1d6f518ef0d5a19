//! New places for instances: the levels of geometries stay; the top gets new boxes, or is built anew.

use super::Bvh;
use super::node::{Child, Node, WIDTH};
use crate::bounds::Bounds;
use crate::error::BuildError;
use crate::geometry::World;
use crate::items;
use crate::levels;

/// Tops of at most this many primitives and instances are always built anew, which takes about a millisecond.
const FEW_ITEMS: usize = 4096;

/// A top whose boxes have grown by this factor since it was built, in area, is built anew.
const MOST_GROWTH: f64 = 1.3;

impl Bvh {
    /// Adapts to a world of which nothing has changed but the transforms of instances that had one and still have one.
    pub fn move_instances(&mut self, world: &World) -> Result<(), BuildError> {
        let objects = self.object_bounds();
        if items::count_of_top(world) > FEW_ITEMS {
            let boxes = items::instance_bounds(world, &objects)?;
            self.refit(&boxes);
            self.top.padding = items::top_padding(world, &self.top.bounds, &objects);
            if self.top_area() <= MOST_GROWTH * self.built_area {
                return Ok(());
            }
        }
        let (items, padding) = levels::top(world, &objects)?;
        self.arrays.truncate(&self.top_start);
        self.add_top(items, world, padding)
    }

    /// Sets the boxes of the top from those of instances (by instance). Children come after their parents.
    fn refit(&mut self, boxes: &[Option<Bounds>]) {
        let (nodes, instances) = (&mut self.arrays.nodes, &self.arrays.instances);
        for index in (self.top_start.nodes..nodes.len()).rev() {
            let old: Vec<(Bounds, u32)> = nodes[index].used().collect();
            let moved = |&(bounds, word): &(Bounds, u32)| {
                let bounds = match Child::of(word) {
                    Child::Node(child) => nodes[child as usize].bounds(),
                    Child::Instance(place) => boxes[instances[place as usize] as usize].unwrap_or(bounds),
                    Child::Packs { .. } | Child::Spheres { .. } => bounds,
                };
                (bounds, word)
            };
            let new: Vec<(Bounds, u32)> = old.iter().map(moved).collect();
            if new != old {
                nodes[index] = Node::new(&new);
            }
        }
        if let Some(root) = nodes.get(self.top_start.nodes) {
            self.top.bounds = root.bounds();
        }
        let others = self.bounds_of_others();
        if let (Some(large), Some(bounds)) = (&mut self.large, others) {
            large.bounds = bounds;
        }
    }

    /// The half areas of all boxes of the top together.
    pub(super) fn top_area(&self) -> f64 {
        let nodes = &self.arrays.nodes[self.top_start.nodes..];
        nodes.iter().flat_map(Node::used).map(|(bounds, _)| f64::from(bounds.half_area())).sum()
    }
}

impl Node {
    /// The children that there are: boxes and words.
    fn used(&self) -> impl Iterator<Item = (Bounds, u32)> {
        let row = |row: usize, i: usize| self.rows[row][i];
        (0..WIDTH)
            .map(move |i| {
                (Bounds { min: [row(0, i), row(2, i), row(4, i)], max: [row(1, i), row(3, i), row(5, i)] }, i)
            })
            .filter(|(bounds, _)| !bounds.is_empty())
            .map(|(bounds, i)| (bounds, self.children[i]))
    }

    /// The box around all children.
    fn bounds(&self) -> Bounds {
        self.used().fold(Bounds::EMPTY, |all, (bounds, _)| all.join(&bounds))
    }
}
