//! The levels of a structure: one tree over the world, and one for each geometry that instances place with a transform.

use crate::error::BuildError;
use crate::geometry::World;
use crate::items::{self, Item};
use crate::padding::Padding;
use crate::source::Source;

/// Builds each level with `build`: the tree over the world, then those of the geometries (`None` where nothing places one).
pub(crate) fn build<L>(
    world: &World,
    mut build: impl FnMut(Vec<Item>, Source<'_>, Padding) -> Result<L, BuildError>,
) -> Result<(L, Vec<Option<L>>), BuildError> {
    let object_bounds = items::object_bounds(world);
    let mut objects = Vec::with_capacity(world.geometries.len());
    for (geometry, bounds) in world.geometries.iter().zip(&object_bounds) {
        objects.push(match bounds {
            Some(bounds) => {
                let padding = Padding::new(bounds, []);
                Some(build(items::of_geometry(geometry)?, Source::Geometry(geometry), padding)?)
            }
            None => None,
        });
    }
    let items = items::of_top(world, &object_bounds)?;
    let padding = items::top_padding(world, &items, &object_bounds);
    Ok((build(items, Source::Top(world), padding)?, objects))
}
