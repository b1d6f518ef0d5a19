//! Shadow rays in scenes with media: attenuated on the way, and passing through what only bounds a medium.

use super::{
    paths::Paths,
    shadow::{ShadowQueue, segment},
};
use crate::{
    math::Vec3,
    medium::Segment,
    sampling::Stream,
    scene::{BodyStack, Scene},
    spectrum::Spectrum,
};
use etendue_accel::{Hit, PrimitiveId, Ray};

/// What a shadow ray takes along in a scene with media.
#[derive(Clone, Copy, Debug)]
pub(super) struct Traveller {
    /// Where it is.
    pub bodies: BodyStack,
    /// Random numbers for media whose density varies.
    pub stream: Stream,
    /// True if what arrives is direct light, and that is told apart.
    pub direct: bool,
}

impl ShadowQueue {
    /// As [`Self::push`], from a point or a surface (an origin with what to skip), with what it takes along.
    pub fn push_within(
        &mut self,
        path: usize,
        (origin, skip): (Vec3, PrimitiveId),
        wi: Vec3,
        target: Option<Vec3>,
        contribution: Spectrum,
        traveller: Traveller,
    ) {
        self.push_ray(path, segment(origin, wi, target, skip), target, contribution);
        self.travellers.push(traveller);
    }

    /// As [`Self::trace`], where every ray was pushed with a traveller.
    pub fn trace_within(&mut self, scene: &Scene, paths: &mut Paths) -> u64 {
        let rays = if scene.is_opaque() && !scene.interiors().may_hide() {
            self.trace_unbroken(scene)
        } else {
            self.trace_through_bodies(scene)
        };
        // In queue order, so that a path's terms are always summed alike.
        for (shadow, traveller) in self.shadows.iter().zip(&self.travellers) {
            let path = shadow.path as usize;
            paths.radiance[path] += shadow.contribution;
            if traveller.direct {
                paths.direct[path] += shadow.contribution;
            }
        }
        self.rays.clear();
        self.shadows.clear();
        self.travellers.clear();
        rays
    }

    /// Where every surface stops light, each ray stays in one medium.
    fn trace_unbroken(&mut self, scene: &Scene) -> u64 {
        self.occluded.clear();
        self.occluded.resize(self.rays.len(), false);
        scene.accelerator().any_hits(&self.rays, &mut self.occluded);
        for (at, occluded) in self.occluded.iter().enumerate() {
            let contribution = &mut self.shadows[at].contribution;
            if *occluded {
                *contribution = Spectrum::BLACK;
            } else {
                *contribution *= attenuation(scene, &mut self.travellers[at], &self.rays[at], &Hit::MISS);
            }
        }
        self.rays.len() as u64
    }

    fn trace_through_bodies(&mut self, scene: &Scene) -> u64 {
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
                if let Some(onward) = self.pass(scene, at, ray, hit) {
                    self.rays.push(onward);
                    still_open.push(at);
                }
            }
            open = still_open;
        }
        traced
    }

    /// Takes shadow `at` to what its ray hits; the rest of its way if there is one.
    fn pass(&mut self, scene: &Scene, at: usize, ray: &Ray, hit: &Hit) -> Option<Ray> {
        let (shadow, traveller) = (&mut self.shadows[at], &mut self.travellers[at]);
        if !hit.is_hit() {
            shadow.contribution *= attenuation(scene, traveller, ray, hit);
            return None;
        }
        let point = scene.surface_point(ray, hit);
        let direction = Vec3::from(ray.direction);
        if !scene.interiors().meet(&traveller.bodies, &point, direction).hidden {
            shadow.contribution *= 1.0 - scene.opacity(&point, hit);
            if shadow.contribution.is_black() {
                return None;
            }
        }
        shadow.contribution *= attenuation(scene, traveller, ray, hit);
        scene.interiors().cross(&mut traveller.bodies, &point, direction);
        let onward = segment(point.leave(direction), direction, shadow.target, hit.id);
        (!shadow.contribution.is_black()).then_some(onward)
    }
}

/// Fraction of light that passes from a ray's origin to its hit, or to its end.
fn attenuation(scene: &Scene, traveller: &mut Traveller, ray: &Ray, hit: &Hit) -> Spectrum {
    if !hit.is_hit() && ray.t_max.is_infinite() {
        // As for paths: no body goes on for ever.
        scene.interiors().leave_all(&mut traveller.bodies);
    }
    let Some(medium) = scene.interiors().medium(&traveller.bodies) else { return Spectrum::ONE };
    let direction = Vec3::from(ray.direction);
    let scale = direction.length();
    let length = scale * if hit.is_hit() { hit.t } else { ray.t_max };
    let segment = Segment { origin: ray.origin.into(), direction: direction / scale, length };
    medium.transmittance(&segment, &mut traveller.stream)
}
