//! The levels of a structure: one tree over the world, and one for each geometry that instances place with a transform.

use std::ops::Range;

use rayon::prelude::*;

use crate::bounds::Bounds;
use crate::error::BuildError;
use crate::geometry::World;
use crate::items::{self, Item};
use crate::padding::Padding;
use crate::source::Source;

/// Primitives of geometries whose levels are built side by side, as far as several geometries have no more. Small ones would
/// leave most threads idle one by one; all at once would need the memory for all that a build needs on the way.
const TOGETHER: usize = 1 << 18;

/// Builds the levels of geometries that have a box, `None` for the others, and keeps them in the order of the geometries.
pub(crate) fn objects<'a, L: Send, K>(
    world: &'a World,
    object_bounds: &[Option<Bounds>],
    build: impl Fn(Vec<Item>, Source<'a>, Padding) -> Result<L, BuildError> + Sync,
    mut keep: impl FnMut(L) -> Result<K, BuildError>,
) -> Result<Vec<Option<K>>, BuildError> {
    let build = |index: usize| -> Result<Option<L>, BuildError> {
        let (geometry, bounds) = (&world.geometries[index], &object_bounds[index]);
        let Some(bounds) = bounds else { return Ok(None) };
        let padding = Padding::new(bounds, []);
        Ok(Some(build(items::of_geometry(geometry)?, Source::Geometry(geometry), padding)?))
    };
    let mut objects = Vec::with_capacity(world.geometries.len());
    for part in parts(world, object_bounds) {
        let built: Vec<Result<Option<L>, BuildError>> = part.into_par_iter().map(build).collect();
        for level in built {
            objects.push(level?.map(&mut keep).transpose()?);
        }
    }
    Ok(objects)
}

/// The geometries in runs that are built side by side.
fn parts(world: &World, object_bounds: &[Option<Bounds>]) -> Vec<Range<usize>> {
    let mut parts: Vec<Range<usize>> = Vec::new();
    let mut primitives = 0_usize;
    for (index, (geometry, bounds)) in world.geometries.iter().zip(object_bounds).enumerate() {
        let own = if bounds.is_some() { geometry.len() } else { 0 };
        primitives = primitives.saturating_add(own);
        match parts.last_mut() {
            Some(part) if primitives <= TOGETHER => part.end = index + 1,
            _ => {
                parts.push(index..index + 1);
                primitives = own;
            }
        }
    }
    parts
}

/// What the tree over the world is built of.
pub(crate) fn top(world: &World, object_bounds: &[Option<Bounds>]) -> Result<(Vec<Item>, Padding), BuildError> {
    let items = items::of_top(world, object_bounds)?;
    let padding = items::top_padding(world, &items::bounds_of(&items), object_bounds);
    Ok((items, padding))
}
