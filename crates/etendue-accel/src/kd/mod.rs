//! The kd-tree: space is cut in two by planes, and primitives are in every leaf in whose cell a part of them is, triangles in packs of four.

mod arrays;
mod build;
mod node;
mod plane;
mod reference;
mod rounds;
mod traverse;

use crate::accelerator::KdTreeSplit;
use crate::bounds::Bounds;
use crate::error::BuildError;
use crate::geometry::World;
use crate::items;
use crate::levels;
use crate::source::Source;

use arrays::{Arrays, Lengths, Level, Root};
pub(crate) use traverse::Trace;

/// Most nodes on a way down a level.
const DEPTH_LIMIT: usize = 60;

/// A level over the world and one for each geometry that transformed instances use.
#[derive(Debug)]
pub(crate) struct KdTree {
    arrays: Arrays,
    top: Root,
    /// By geometry.
    objects: Vec<Option<Root>>,
    /// Where the top begins in the arrays.
    top_start: Lengths,
    split: KdTreeSplit,
}

impl KdTree {
    pub fn build(world: &World, split: KdTreeSplit) -> Result<Self, BuildError> {
        let mut arrays = Arrays::new();
        let bounds = items::object_bounds(world);
        let prepare = |items, source, padding| Level::new(items, source, padding, split);
        let objects = levels::objects(world, &bounds, prepare, |level| arrays.append(level))?;
        let top_start = arrays.lengths();
        let top = Self::top(&mut arrays, world, &bounds, split)?;
        Ok(Self { arrays, top, objects, top_start, split })
    }

    fn top(
        arrays: &mut Arrays,
        world: &World,
        objects: &[Option<Bounds>],
        split: KdTreeSplit,
    ) -> Result<Root, BuildError> {
        let (items, padding) = levels::top(world, objects)?;
        arrays.append(Level::new(items, Source::Top(world), padding, split)?)
    }

    /// Adapts to a world of which nothing has changed but the transforms of instances that had one and still have one.
    pub fn move_instances(&mut self, world: &World) -> Result<(), BuildError> {
        let objects: Vec<Option<Bounds>> =
            self.objects.iter().map(|root| root.as_ref().map(|root| root.bounds)).collect();
        self.arrays.truncate(&self.top_start);
        self.top = Self::top(&mut self.arrays, world, &objects, self.split)?;
        Ok(())
    }

    pub fn bounds(&self) -> Bounds {
        self.top.bounds
    }

    pub fn nodes(&self) -> usize {
        self.arrays.nodes().len()
    }

    pub fn bytes(&self) -> usize {
        self.arrays.bytes()
    }

    pub fn depth(&self) -> usize {
        self.top.depth + self.objects.iter().flatten().map(|root| root.depth).max().unwrap_or(0)
    }
}
