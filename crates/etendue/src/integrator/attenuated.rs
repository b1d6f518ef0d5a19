//! What shadow rays in scenes with media take along, and what media leave of them.

use super::shadow::{ShadowQueue, segment};
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
}

/// Fraction of light that passes from a ray's origin to its hit, or to its end.
pub(super) fn attenuation(scene: &Scene, traveller: &mut Traveller, ray: &Ray, hit: &Hit) -> Spectrum {
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
