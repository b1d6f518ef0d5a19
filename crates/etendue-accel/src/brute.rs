//! The reference: every primitive of every instance, without any box.

use crate::geometry::{Geometry, World};
use crate::ray::{PrimitiveId, Ray};
use crate::search::Search;

/// Searches all of the world. With `ANY`, stops at the first hit.
#[inline(always)]
pub(crate) fn search<const ANY: bool>(world: &World, ray: &Ray) -> Option<Search> {
    let (mut search, ray_in_world) = Search::start(ray)?;
    for (index, instance) in world.instances.iter().enumerate() {
        if instance.mask & search.mask == 0 {
            continue;
        }
        let Some(local) = ray_in_world.inside(&instance.place, search.time) else { continue };
        let id = |primitive: usize| PrimitiveId { instance: index as u32, primitive: primitive as u32 };
        match &world.geometries[instance.geometry as usize] {
            Geometry::Triangles(mesh) => {
                for face in 0..mesh.indices.len() {
                    if search.triangle(&local, &mesh.corners(face), id(face)) && ANY {
                        return Some(search);
                    }
                }
            }
            Geometry::Spheres(spheres) => {
                for (i, sphere) in spheres.iter().enumerate() {
                    if search.sphere(&local, sphere, id(i)) && ANY {
                        return Some(search);
                    }
                }
            }
        }
    }
    Some(search)
}
