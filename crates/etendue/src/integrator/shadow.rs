//! Shadow rays: light that arrives at a path's vertex if nothing is in between.

use super::attenuated::Traveller;
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
    pub(super) rays: Vec<Ray>,
    pub(super) shadows: Vec<Shadow>,
    /// One a shadow in scenes with media, else none.
    pub(super) travellers: Vec<Traveller>,
    pub(super) occluded: Vec<bool>,
    pub(super) hits: Vec<Hit>,
}

/// A ray from `origin` to the target, or in direction `wi` for ever.
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
    pub fn trace(&mut self, scene: &Scene, radiance: &mut [Spectrum]) -> u64 {
        let rays = if scene.is_opaque() {
            self.occluded.clear();
            self.occluded.resize(self.rays.len(), false);
            scene.accelerator().any_hits(&self.rays, &mut self.occluded);
            for (shadow, occluded) in self.shadows.iter().zip(&self.occluded) {
                if !occluded {
                    radiance[shadow.path as usize] += shadow.contribution;
                }
            }
            self.rays.len() as u64
        } else {
            self.trace_through(scene, radiance)
        };
        self.rays.clear();
        self.shadows.clear();
        rays
    }

    /// As [`Self::trace`], where some surfaces let a part of the light pass straight through.
    fn trace_through(&mut self, scene: &Scene, radiance: &mut [Spectrum]) -> u64 {
        let mut traced = 0;
        let mut open: Vec<usize> = (0..self.rays.len()).collect();
        while !open.is_empty() {
            self.hits.clear();
            self.hits.resize(self.rays.len(), Hit::MISS);
            scene.accelerator().closest_hits(&self.rays, &mut self.hits);
            traced += self.rays.len() as u64;
            let (rays, hits) = (std::mem::take(&mut self.rays), std::mem::take(&mut self.hits));
            let mut still_open = Vec::new();
            for ((ray, hit), at) in rays.iter().zip(&hits).zip(open) {
                if !hit.is_hit() {
                    continue;
                }
                let point = scene.surface_point(ray, hit);
                let shadow = &mut self.shadows[at];
                shadow.contribution *= 1.0 - scene.opacity(&point, hit);
                if shadow.contribution.is_black() {
                    continue;
                }
                let direction = Vec3::from(ray.direction);
                let mut onward = segment(point.leave(direction), direction, shadow.target, hit.id);
                if shadow.target.is_none() {
                    onward.t_max = ray.t_max - hit.t;
                }
                self.rays.push(onward);
                still_open.push(at);
            }
            open = still_open;
        }
        // In queue order, so that a path's terms are always summed alike.
        for shadow in &self.shadows {
            radiance[shadow.path as usize] += shadow.contribution;
        }
        traced
    }
}
