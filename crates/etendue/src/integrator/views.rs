//! Views of the geometry: what the first surface is, without light.

use super::{Integrator, paths::Paths, shade::first_hit_at, shadow::ShadowQueue, wave::Context};
use crate::{
    math::{Frame, Vec3},
    sampling::{Slot, warp},
    spectrum::Spectrum,
    surface::SurfacePoint,
};

/// Ends path `path` at the surface that its ray has reached.
pub(super) fn shade(context: &Context, view: Integrator, paths: &mut Paths, path: usize, shadows: &mut ShadowQueue) {
    paths.progress[path].alive = false;
    let hit = paths.hits[path];
    if !hit.is_hit() {
        return;
    }
    let ray = paths.rays[path];
    let point = context.scene.surface_point(&ray, &hit);
    if context.wants_layers {
        paths.first[path] =
            first_hit_at(context, point, &hit, -Vec3::from(ray.direction), paths.cones[path].advanced(hit.t).width);
    }
    let normal = point.shading_normal;
    paths.radiance[path] = match view {
        Integrator::Normal => Spectrum((normal * 0.5 + Vec3::splat(0.5)).to_array()),
        Integrator::Uv => {
            let uv = context.scene.texture_coordinates(&point, &hit);
            Spectrum([uv.x, uv.y, 0.0])
        }
        Integrator::Depth => Spectrum::splat(context.camera.view(point.time).depth(point.position)),
        Integrator::Ids => id_colour(point.id.instance, point.material),
        Integrator::Ao { distance } => {
            let key = paths.samples[path].key;
            let u = context.sampler.two_d(key, paths.progress[path].vertex, Slot::BsdfDirection);
            occlusion_ray(&point, -Vec3::from(ray.direction), u, distance, path, shadows);
            Spectrum::BLACK
        }
        Integrator::Path | Integrator::LightSplit | Integrator::Brute => Spectrum::BLACK,
    };
}

fn occlusion_ray(
    point: &SurfacePoint,
    wo: Vec3,
    u: [f32; 2],
    distance: Option<f32>,
    path: usize,
    shadows: &mut ShadowQueue,
) {
    let side = 1.0f32.copysign(point.geometric_normal.dot(wo));
    let wi = Frame::from_normal(point.shading_normal * side).to_world(warp::cosine_hemisphere(u));
    if wi.dot(point.geometric_normal) * side > 0.0 {
        shadows.push_up_to(path, point, wi, distance.unwrap_or(f32::INFINITY), Spectrum::ONE);
    }
}

/// A colour that differs clearly between neighbouring ids.
fn id_colour(object: u32, material: u32) -> Spectrum {
    let mut h = (object ^ material.rotate_left(16)).wrapping_add(1).wrapping_mul(0x9e37_79b9);
    h = (h ^ h >> 15).wrapping_mul(0x2c1b_3c6d);
    h ^= h >> 12;
    let channel = |shift: u32| 0.1 + 0.8 * ((h >> shift & 0xff) as f32 / 255.0);
    Spectrum([channel(0), channel(8), channel(16)])
}
