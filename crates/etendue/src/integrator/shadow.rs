//! Shadow rays: light that arrives at a path's vertex if nothing is in between.

use super::{
    attenuated::{Traveller, attenuation},
    paths::Paths,
};
use crate::{math::Vec3, scene::Scene, spectrum::Spectrum, surface::SurfacePoint};
use etendue_accel::{Hit, PrimitiveId, Ray};

/// Light on its way to a path.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shadow {
    /// Index of the path.
    pub path: u32,
    /// Added to the path's radiance if it arrives.
    pub contribution: Spectrum,
    /// The end of the segment; absent: infinitely far.
    pub target: Option<Vec3>,
}

/// The shadow rays of a wave, any number a path, in the order of paths.
pub(super) struct ShadowQueue {
    rays: Vec<Ray>,
    shadows: Vec<Shadow>,
    /// One a shadow in scenes with media, else none.
    pub(super) travellers: Vec<Traveller>,
    occluded: Vec<bool>,
    hits: Vec<Hit>,
    /// The shadows whose rays are still on their way.
    open: Vec<u32>,
}

/// A ray from `origin` to the target, or in direction `wi` for ever, at time 0.
pub(super) fn segment(origin: Vec3, wi: Vec3, target: Option<Vec3>, skip: PrimitiveId) -> Ray {
    let (direction, t_max) = target.map_or((wi, f32::INFINITY), |target| (target - origin, 1.0));
    let (origin, direction) = (origin.into(), direction.into());
    Ray { origin, t_min: 0.0, direction, t_max, time: 0.0, mask: u32::MAX, skip }
}

impl ShadowQueue {
    pub fn with_capacity(n: usize) -> Self {
        Self {
            rays: Vec::with_capacity(n),
            shadows: Vec::with_capacity(n),
            travellers: Vec::new(),
            occluded: Vec::with_capacity(n),
            hits: Vec::new(),
            open: Vec::new(),
        }
    }

    /// Queues light from `target`, or from infinity along the unit vector `wi`, to a place, without meeting a primitive.
    #[inline]
    pub fn push(
        &mut self,
        path: usize,
        (origin, skip): (Vec3, PrimitiveId),
        wi: Vec3,
        target: Option<Vec3>,
        contribution: Spectrum,
    ) {
        self.push_ray(path, segment(origin, wi, target, skip), target, contribution);
    }

    /// As [`Self::push`], where the ray's origin and direction, all the way to a target, are known.
    #[inline]
    pub fn push_segment(
        &mut self,
        path: usize,
        (origin, direction): (Vec3, Vec3),
        skip: PrimitiveId,
        target: Option<Vec3>,
        contribution: Spectrum,
    ) {
        let t_max = if target.is_some() { 1.0 } else { f32::INFINITY };
        let (origin, direction) = (origin.into(), direction.into());
        let ray = Ray { origin, t_min: 0.0, direction, t_max, time: 0.0, mask: u32::MAX, skip };
        self.push_ray(path, ray, target, contribution);
    }

    #[inline]
    pub(super) fn push_ray(&mut self, path: usize, ray: Ray, target: Option<Vec3>, contribution: Spectrum) {
        self.rays.push(ray);
        self.shadows.push(Shadow { path: path as u32, contribution, target });
    }

    /// Queues a ray of limited length.
    pub fn push_up_to(&mut self, path: usize, point: &SurfacePoint, wi: Vec3, t_max: f32, contribution: Spectrum) {
        self.push(path, (point.leave(wi), point.id), wi, None, contribution);
        if let Some(ray) = self.rays.last_mut() {
            ray.t_max = t_max;
        }
    }

    /// Traces the queue, adds what arrives to the paths' radiance, and empties it. Returns the number of rays traced.
    pub fn trace(&mut self, scene: &Scene, paths: &mut Paths) -> u64 {
        if scene.is_moving() {
            let times = self.shadows.iter().map(|shadow| paths.rays[shadow.path as usize].time);
            self.rays.iter_mut().zip(times).for_each(|(ray, time)| ray.time = time);
        }
        let hides = !self.travellers.is_empty() && scene.interiors().may_hide();
        let rays = if scene.is_opaque() && !hides { self.trace_unbroken(scene) } else { self.trace_through(scene) };
        // In queue order, so that a path's terms are always summed alike.
        for (at, shadow) in self.shadows.iter().enumerate() {
            let path = shadow.path as usize;
            paths.radiance[path] += shadow.contribution;
            if self.travellers.get(at).is_some_and(|traveller| traveller.direct) {
                paths.direct[path] += shadow.contribution;
            }
        }
        self.rays.clear();
        self.shadows.clear();
        self.travellers.clear();
        rays
    }

    /// Where every surface stops light, so that each ray stays in one medium.
    fn trace_unbroken(&mut self, scene: &Scene) -> u64 {
        self.occluded.clear();
        self.occluded.resize(self.rays.len(), false);
        scene.accelerator().any_hits(&self.rays, &mut self.occluded);
        for (at, occluded) in self.occluded.iter().enumerate() {
            let contribution = &mut self.shadows[at].contribution;
            if *occluded {
                *contribution = Spectrum::BLACK;
            } else if let Some(traveller) = self.travellers.get_mut(at) {
                *contribution *= attenuation(scene, traveller, &self.rays[at], &Hit::MISS);
            }
        }
        self.rays.len() as u64
    }

    /// Where surfaces let a part of the light pass straight on, or only bound a medium.
    fn trace_through(&mut self, scene: &Scene) -> u64 {
        let mut traced = 0;
        self.open.clear();
        self.open.extend(0..self.rays.len() as u32);
        while !self.open.is_empty() {
            self.hits.clear();
            self.hits.resize(self.rays.len(), Hit::MISS);
            scene.accelerator().closest_hits(&self.rays, &mut self.hits);
            traced += self.rays.len() as u64;
            let mut kept = 0;
            for i in 0..self.open.len() {
                let (at, ray, hit) = (self.open[i], self.rays[i], self.hits[i]);
                if let Some(onward) = self.pass(scene, at as usize, &ray, &hit) {
                    self.rays[kept] = onward;
                    self.open[kept] = at;
                    kept += 1;
                }
            }
            self.rays.truncate(kept);
            self.open.truncate(kept);
        }
        traced
    }

    /// Takes shadow `at` to what its ray hits; the rest of its way if there is one.
    fn pass(&mut self, scene: &Scene, at: usize, ray: &Ray, hit: &Hit) -> Option<Ray> {
        let (shadow, mut traveller) = (&mut self.shadows[at], self.travellers.get_mut(at));
        if !hit.is_hit() {
            if let Some(traveller) = traveller {
                shadow.contribution *= attenuation(scene, traveller, ray, hit);
            }
            return None;
        }
        let (point, direction) = (scene.surface_point(ray, hit), Vec3::from(ray.direction));
        let meets = |traveller: &mut Traveller| scene.interiors().meet(&traveller.bodies, &point, direction).hidden;
        if !traveller.as_deref_mut().is_some_and(meets) {
            shadow.contribution *= 1.0 - scene.opacity(&point, hit);
        }
        if shadow.contribution.is_black() {
            return None;
        }
        if let Some(traveller) = traveller {
            shadow.contribution *= attenuation(scene, traveller, ray, hit);
            scene.interiors().cross(&mut traveller.bodies, &point, direction);
        }
        let onward = segment(point.leave(direction), direction, shadow.target, hit.id);
        let mut onward = Ray { time: ray.time, ..onward };
        if shadow.target.is_none() {
            onward.t_max = ray.t_max - hit.t;
        }
        (!shadow.contribution.is_black()).then_some(onward)
    }
}
