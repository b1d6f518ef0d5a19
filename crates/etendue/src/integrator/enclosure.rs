//! The bodies that the camera lies in.

use crate::{
    math::{Vec3, vec3},
    scene::{BodyStack, Scene, is_entering},
    surface::SurfacePoint,
};
use etendue_accel::{Hit, PrimitiveId, Ray};

/// Surfaces that are followed at most.
const MOST_SURFACES: u32 = 1 << 16;

/// A body (of a material of an instance) that a probe left without having entered it.
#[derive(Clone, Copy, Debug)]
struct Left {
    body: (u32, u32),
    instance: u32,
    material: u32,
}

/// The bodies that `point` lies in at a shutter time: a probe that goes out from there leaves them one by one, the innermost first. Bodies that are
/// not closed may be told wrongly; by two probes of three.
pub(crate) fn bodies_about(scene: &Scene, point: Vec3, time: f32) -> BodyStack {
    let interiors = scene.interiors();
    let mut stack = interiors.outside();
    if !interiors.has_bodies() {
        return stack;
    }
    // Any directions will do that are not along axes and diagonals, where meshes have their edges.
    let probes = [vec3(0.267, 0.802, 0.534), vec3(-0.741, 0.193, -0.643), vec3(0.371, -0.512, 0.775)];
    let [first, second, third] = probes.map(|direction| left_along(scene, point, direction.normalize(), time));
    let bodies = |left: &[Left]| {
        let mut bodies: Vec<_> = left.iter().map(|l| l.body).collect();
        bodies.sort_unstable();
        bodies
    };
    let agreed = if bodies(&second) == bodies(&third) { second } else { first };
    for Left { instance, material, .. } in agreed.into_iter().rev() {
        interiors.enter(&mut stack, instance, material);
    }
    stack
}

/// The bodies that a probe leaves on its way to infinity without having entered them, in that order.
fn left_along(scene: &Scene, point: Vec3, direction: Vec3, time: f32) -> Vec<Left> {
    let mut entered = Vec::new();
    let mut left = Vec::new();
    follow(scene, (point, time), direction, f32::INFINITY, |point| {
        let (instance, material) = (point.id.instance, point.material);
        let Some(body) = scene.interiors().body(instance, material) else { return };
        if is_entering(point, direction) {
            entered.push(body);
        } else if let Some(at) = entered.iter().rposition(|e| *e == body) {
            entered.remove(at);
        } else {
            left.push(Left { body, instance, material });
        }
    });
    left
}

/// The bodies at `to`, those at `from` being known, at a shutter time.
pub(super) fn bodies_along(scene: &Scene, bodies: &BodyStack, from: Vec3, to: Vec3, time: f32) -> BodyStack {
    let mut stack = *bodies;
    let direction = to - from;
    if scene.interiors().has_bodies() && direction != Vec3::ZERO {
        follow(scene, (from, time), direction, 1.0, |point| scene.interiors().cross(&mut stack, point, direction));
    }
    stack
}

/// Every surface on a straight way from a point at a time.
fn follow(scene: &Scene, (from, time): (Vec3, f32), direction: Vec3, t_max: f32, mut meet: impl FnMut(&SurfacePoint)) {
    let mut ray = Ray {
        origin: from.into(),
        t_min: 0.0,
        direction: direction.into(),
        t_max,
        time,
        mask: u32::MAX,
        skip: PrimitiveId::NONE,
    };
    for _ in 0..MOST_SURFACES {
        let mut hits = [Hit::MISS];
        scene.accelerator().closest_hits(std::slice::from_ref(&ray), &mut hits);
        let [hit] = hits;
        if !hit.is_hit() {
            return;
        }
        let point = scene.surface_point(&ray, &hit);
        meet(&point);
        ray.origin = point.leave(direction).into();
        ray.skip = hit.id;
        ray.t_max -= hit.t;
    }
}
