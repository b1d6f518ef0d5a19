//! The kd-tree: space is cut in two by planes, and primitives are listed in every cell that their boxes meet.

mod build;
mod traverse;

use crate::accelerator::KdTreeSplit;
use crate::bounds::Bounds;
use crate::error::{BuildError, room};
use crate::geometry::{Sphere, World};
use crate::items::{self, Item, ItemKind};
use crate::levels;
use crate::padding::Padding;
use crate::ray::PrimitiveId;
use crate::source::Source;

pub(crate) use traverse::Trace;

/// Most nodes on a way down: the length of the traversal's stack.
const DEPTH_LIMIT: usize = 60;

/// A node of a level, in order of depth first: an inner node's lower child follows it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Node {
    /// Cut at a coordinate of an axis; the upper child is at an index.
    Inner { axis: u8, at: f32, upper: u32 },
    /// A range of the level's references.
    Leaf { first: u32, count: u32 },
}

/// What a reference leads to.
#[derive(Clone, Copy, Debug)]
enum Primitive {
    Triangle { corners: [[f32; 3]; 3], id: PrimitiveId, mask: u32 },
    Sphere { sphere: Sphere, id: PrimitiveId, mask: u32 },
    Instance { instance: u32, geometry: u32, mask: u32 },
}

impl Primitive {
    fn of(item: &Item, source: Source<'_>) -> Option<Self> {
        let (id, mask) = (item.id(), source.mask(item.id()));
        Some(match source.kind(id) {
            ItemKind::Triangle => Self::Triangle { corners: source.triangle(id)?, id, mask },
            ItemKind::Sphere => Self::Sphere { sphere: source.sphere(id)?, id, mask },
            ItemKind::Instance => Self::Instance { instance: id.instance, geometry: source.geometry_index(id), mask },
        })
    }
}

/// One level: the top, or a geometry that instances share.
#[derive(Debug)]
struct Level {
    bounds: Bounds,
    padding: Padding,
    nodes: Vec<Node>,
    /// Indices of primitives, by leaf.
    references: Vec<u32>,
    primitives: Vec<Primitive>,
    depth: usize,
}

impl Level {
    fn build(items: &[Item], source: Source<'_>, padding: Padding, split: KdTreeSplit) -> Result<Self, BuildError> {
        let bounds = items::bounds_of(items);
        let mut primitives = room("primitives", items.len())?;
        primitives.extend(items.iter().filter_map(|item| Primitive::of(item, source)));
        let subtree = build::build(items, &bounds, split)?;
        Ok(Self {
            bounds,
            padding,
            nodes: subtree.nodes,
            references: subtree.references,
            primitives,
            depth: subtree.depth,
        })
    }

    fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..]) + size_of_val(&self.references[..]) + size_of_val(&self.primitives[..])
    }
}

/// A level over the world and one for each geometry that transformed instances use.
#[derive(Debug)]
pub(crate) struct KdTree {
    top: Level,
    /// By geometry.
    objects: Vec<Option<Level>>,
    split: KdTreeSplit,
}

impl KdTree {
    pub fn build(world: &World, split: KdTreeSplit) -> Result<Self, BuildError> {
        let bounds = items::object_bounds(world);
        let build = |items: Vec<Item>, source: Source<'_>, padding| Level::build(&items, source, padding, split);
        let objects = levels::objects(world, &bounds, build, Ok)?;
        Ok(Self { top: Self::top(world, &bounds, split)?, objects, split })
    }

    fn top(world: &World, objects: &[Option<Bounds>], split: KdTreeSplit) -> Result<Level, BuildError> {
        let (items, padding) = levels::top(world, objects)?;
        Level::build(&items, Source::Top(world), padding, split)
    }

    /// Adapts to a world of which nothing has changed but the transforms of instances that had one and still have one.
    pub fn move_instances(&mut self, world: &World) -> Result<(), BuildError> {
        let objects: Vec<Option<Bounds>> =
            self.objects.iter().map(|level| level.as_ref().map(|level| level.bounds)).collect();
        self.top = Self::top(world, &objects, self.split)?;
        Ok(())
    }

    pub fn bounds(&self) -> Bounds {
        self.top.bounds
    }

    pub fn nodes(&self) -> usize {
        self.levels().map(|level| level.nodes.len()).sum()
    }

    pub fn bytes(&self) -> usize {
        self.levels().map(Level::bytes).sum()
    }

    pub fn depth(&self) -> usize {
        self.top.depth + self.objects.iter().flatten().map(|level| level.depth).max().unwrap_or(0)
    }

    fn levels(&self) -> impl Iterator<Item = &Level> {
        std::iter::once(&self.top).chain(self.objects.iter().flatten())
    }
}
