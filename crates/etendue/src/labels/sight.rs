//! Rays of labels, many at a time: they stop at the first surface that is at least half there.

use crate::{math::Vec3, scene::Scene};
use etendue_accel::{Accelerator, Hit, PrimitiveId, Ray, Transform};

/// Least opacity of a surface that is seen.
pub const OPAQUE: f32 = 0.5;
/// Surfaces that a ray passes before it is given up.
const MOST_PASSED: usize = 1 << 12;

/// A ray from `origin` to where `direction` is `t_max` times as long.
pub fn ray(origin: Vec3, direction: Vec3, t_max: f32, skip: PrimitiveId) -> Ray {
    Ray { origin: origin.into(), t_min: 0.0, direction: direction.into(), t_max, time: 0.0, mask: u32::MAX, skip }
}

/// What rays meet, an instance of the scene at a time or all of it.
#[derive(Clone, Copy)]
pub enum Target<'a> {
    /// All of the scene.
    All,
    /// One instance alone, by the structure of its geometry in the geometry's own space.
    One { instance: u32, structure: &'a Accelerator, transform: Option<&'a Transform> },
}

impl Target<'_> {
    fn closest_hits(&self, scene: &Scene, rays: &[Ray], hits: &mut [Hit]) {
        let Self::One { instance, structure, transform } = *self else {
            return scene.accelerator().closest_hits(rays, hits);
        };
        structure.closest_hits(&own(transform, rays), hits);
        for hit in hits.iter_mut().filter(|hit| hit.is_hit()) {
            hit.id.instance = instance;
        }
    }

    fn any_hits(&self, scene: &Scene, rays: &[Ray], met: &mut [bool]) {
        match *self {
            Self::All => scene.accelerator().any_hits(rays, met),
            Self::One { structure, transform, .. } => structure.any_hits(&own(transform, rays), met),
        }
    }
}

/// Rays in a geometry's space, as the scene's accelerator takes them there: with the same hits, to the bit.
fn own(transform: Option<&Transform>, rays: &[Ray]) -> Vec<Ray> {
    let own = |ray: &Ray| {
        let instance = if ray.skip == PrimitiveId::NONE { u32::MAX } else { 0 };
        let ray = Ray { skip: PrimitiveId { instance, ..ray.skip }, ..*ray };
        match transform {
            None => ray,
            Some(t) => {
                let (origin, direction) = (t.point_to_object(ray.origin), t.vector_to_object(ray.direction));
                Ray { origin, direction, ..ray }
            }
        }
    };
    rays.iter().map(own).collect()
}

/// The first surface that each ray meets which is at least half there. A ray that passes others goes on from there: `rays` are
/// then what is left of them.
pub fn first_surfaces(scene: &Scene, target: Target<'_>, rays: &mut [Ray], hits: &mut [Hit]) {
    target.closest_hits(scene, rays, hits);
    if scene.is_opaque() {
        return;
    }
    let passed = |ray: &Ray, hit: &Hit| hit.is_hit() && scene.opacity(&scene.surface_point(ray, hit), hit) < OPAQUE;
    let mut open: Vec<usize> = (0..rays.len()).filter(|&i| passed(&rays[i], &hits[i])).collect();
    for _ in 0..MOST_PASSED {
        if open.is_empty() {
            return;
        }
        let mut onward: Vec<Ray> = open.iter().map(|&i| beyond(scene, &rays[i], &hits[i])).collect();
        let mut found = vec![Hit::MISS; open.len()];
        target.closest_hits(scene, &onward, &mut found);
        for ((&i, ray), hit) in open.iter().zip(onward.drain(..)).zip(found) {
            (rays[i], hits[i]) = (ray, hit);
        }
        open.retain(|&i| passed(&rays[i], &hits[i]));
    }
    open.into_iter().for_each(|i| hits[i] = Hit::MISS);
}

/// The rest of a ray behind a hit.
fn beyond(scene: &Scene, from: &Ray, hit: &Hit) -> Ray {
    let direction = Vec3::from(from.direction);
    let origin = scene.surface_point(from, hit).leave(direction);
    ray(origin, direction, from.t_max - hit.t, hit.id)
}

/// Whether each ray meets a surface that is at least half there.
pub fn met(scene: &Scene, target: Target<'_>, rays: &mut [Ray]) -> Vec<bool> {
    let mut met = vec![false; rays.len()];
    target.any_hits(scene, rays, &mut met);
    if scene.is_opaque() {
        return met;
    }
    let mut open: Vec<usize> = (0..rays.len()).filter(|&i| met[i]).collect();
    let mut left: Vec<Ray> = open.iter().map(|&i| rays[i]).collect();
    let mut hits = vec![Hit::MISS; left.len()];
    first_surfaces(scene, target, &mut left, &mut hits);
    open.drain(..).zip(hits).for_each(|(i, hit)| met[i] = hit.is_hit());
    met
}

/// Does `work` on each item, on `threads` threads.
pub fn on_threads<T: Send>(threads: usize, items: Vec<T>, work: impl Fn(T) + Sync) {
    let threads = threads.clamp(1, items.len().max(1));
    let queue = std::sync::Mutex::new(items.into_iter());
    // A worker that panicked takes all down when the scope ends.
    let next = || queue.lock().unwrap_or_else(std::sync::PoisonError::into_inner).next();
    let worker = || std::iter::from_fn(next).for_each(&work);
    std::thread::scope(|scope| {
        for _ in 1..threads {
            scope.spawn(worker);
        }
        worker();
    });
}
