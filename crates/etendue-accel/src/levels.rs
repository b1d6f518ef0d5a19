//! The levels of a structure: one tree over the world, and one for each geometry that instances place with a transform.

use crate::bounds::Bounds;
use crate::error::BuildError;
use crate::geometry::World;
use crate::items::{self, Item};
use crate::padding::Padding;
use crate::source::Source;

/// Builds the levels of geometries that have a box, `None` for the others.
pub(crate) fn objects<L>(
    world: &World,
    object_bounds: &[Option<Bounds>],
    mut build: impl FnMut(Vec<Item>, Source<'_>, Padding) -> Result<L, BuildError>,
) -> Result<Vec<Option<L>>, BuildError> {
    let mut objects = Vec::with_capacity(world.geometries.len());
    for (geometry, bounds) in world.geometries.iter().zip(object_bounds) {
        objects.push(match bounds {
            Some(bounds) => {
                let padding = Padding::new(bounds, []);
                Some(build(items::of_geometry(geometry)?, Source::Geometry(geometry), padding)?)
            }
            None => None,
        });
    }
    Ok(objects)
}

/// What the tree over the world is built of.
pub(crate) fn top(world: &World, object_bounds: &[Option<Bounds>]) -> Result<(Vec<Item>, Padding), BuildError> {
    let items = items::of_top(world, object_bounds)?;
    let padding = items::top_padding(world, &items::bounds_of(&items), object_bounds);
    Ok((items, padding))
}
