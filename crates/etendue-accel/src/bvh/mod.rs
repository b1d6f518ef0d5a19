//! The 8-wide bounding volume hierarchy.

mod build;
mod collapse;
pub(crate) mod node;
mod traverse;

use crate::bounds::Bounds;
use crate::error::BuildError;
use crate::geometry::World;
use crate::items;
use crate::padding::Padding;
use crate::source::Source;

use collapse::Level;
pub(crate) use traverse::Trace;

/// A level over the world and one for each geometry that transformed instances use.
#[derive(Debug)]
pub(crate) struct Bvh {
    top: Level,
    /// By geometry.
    objects: Vec<Option<Level>>,
    /// Entries that a traversal's stack may need.
    stack_len: usize,
}

impl Bvh {
    pub fn build(world: &World) -> Result<Self, BuildError> {
        let object_bounds = items::object_bounds(world);
        let mut objects = Vec::with_capacity(world.geometries.len());
        for (geometry, bounds) in world.geometries.iter().zip(&object_bounds) {
            objects.push(match bounds {
                Some(bounds) => {
                    let mut items = items::of_geometry(geometry)?;
                    Some(Level::build(&mut items, Source::Geometry(geometry), Padding::new(bounds, []))?)
                }
                None => None,
            });
        }
        let mut items = items::of_top(world, &object_bounds)?;
        let padding = items::top_padding(world, &items, &object_bounds);
        let top = Level::build(&mut items, Source::Top(world), padding)?;
        let deepest = objects.iter().flatten().map(|level| level.depth).max().unwrap_or(0);
        // Each node on the way replaces one entry by at most eight; vectors are stored whole.
        let stack_len = (node::WIDTH - 1) * (top.depth + deepest) + 2 + node::WIDTH;
        Ok(Self { top, objects, stack_len })
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
