//! What a medium does to a path on the way to the next surface, and light sampled there.
//!
//! Light from an emitter that a medium scatters once on a segment can be found in three ways: at the distance t of a free
//! flight by sampling the light, or by the phase function; and at a distance drawn about the light (equiangular) by sampling the
//! light. With p the densities given the same path up to the segment, they are joined as pairs (t, direction):
//!
//! | distance | direction | density |
//! |---|---|---|
//! | free flight | light | p_flight(t) p_light(wi) |
//! | equiangular about the light | light | p_equi(t) p_light(wi) |
//! | free flight | phase function | p_flight(t) p_phase(wi) |
//!
//! by the power heuristic with exponent 2. The choice of the light is part of p_light, by the point at t; for an equiangular
//! distance the light is chosen before, by the segment, and p_equi is that of the light which the direction finds times the
//! ratio of the two probabilities. Only ratios are formed: what they have in common cancels.

use super::{
    attenuated::Traveller,
    paths::{Flown, Paths, Previous},
    shade::{Strategy, first_hit_at, survives},
    shadow::ShadowQueue,
    splitting::each_part,
    wave::Context,
};
use crate::{
    bsdf::Density,
    light::{LightContext, LightSample, Selected},
    math::Vec3,
    medium::{Density as Grid, Equiangular, Medium, Segment},
    sampling::Slot,
    spectrum::Spectrum,
};
use etendue_accel::{Hit, PrimitiveId, Ray};

/// Where a light is more mean free paths away than this, its light has died down, and distances about it would be in vain.
const FARTHEST: f32 = 6.0;
/// Mean free paths after which nothing is left to be found.
const LONGEST: f32 = 32.0;

/// Takes path `path` along its ray to what the ray hits; false if a medium scattered or ended it on the way.
pub(super) fn travel(
    context: &Context,
    strategy: Strategy,
    paths: &mut Paths,
    path: usize,
    shadows: &mut ShadowQueue,
) -> bool {
    let (ray, hit) = (paths.rays[path], paths.hits[path]);
    if !hit.is_hit() {
        // No body goes on for ever: one that is still there has a hole, or was left by rounding at an edge.
        context.scene.interiors().leave_all(&mut paths.bodies[path]);
    }
    let Some(medium) = context.scene.interiors().medium(&paths.bodies[path]) else { return true };
    let length = if hit.is_hit() { hit.t } else { f32::INFINITY };
    let segment = Segment { origin: ray.origin.into(), direction: ray.direction.into(), length };
    let last = paths.progress[path].depth >= context.max_depth;
    if strategy != Strategy::Bsdf && !last {
        connect(context, strategy, paths, path, (medium, &segment), shadows);
    }
    let (key, number) = (paths.samples[path].key, paths.progress[path].vertex);
    let u = context.sampler.one_d(key, number, Slot::FreeFlight);
    let mut stream = context.sampler.stream(key, number, Slot::FreeFlight);
    let mut flight = medium.sample_flight(&segment, paths.throughput[path], u, &mut stream);
    let first = paths.progress[path].depth == 1;
    if medium.scattering.is_black() && !(first && context.transparent) {
        // What only absorbs needs no flights that end in it, but for alpha, which is the share of them.
        flight.distance = None;
        flight.weight = medium.transmittance(&segment, &mut stream);
    }
    let emitted = paths.throughput[path] * flight.emitted;
    paths.radiance[path] += emitted;
    paths.throughput[path] *= flight.weight;
    let goes_on = !paths.throughput[path].is_black();
    let Some(distance) = flight.distance else {
        paths.progress[path].alive = goes_on;
        return goes_on;
    };
    if context.wants_layers && first {
        keep_first_surface(context, paths, path);
    }
    if last || !goes_on {
        // It has met the medium.
        paths.progress[path].depth += 1;
        paths.progress[path].alive = false;
        return false;
    }
    let flown = Flown { segment, distance, density: flight.density, extinction: densest(medium) };
    let position = before(context, &ray, &hit, &segment, distance);
    let at = MediumPoint { medium, position, wo: -segment.direction, time: ray.time };
    each_part(context, paths, path, |paths, path| {
        if strategy != Strategy::Bsdf {
            sample_light(context, strategy, paths, path, (&at, &flown), shadows);
        }
        paths.progress[path].alive = scatter(context, paths, path, (&at, flown));
    });
    false
}

/// A point where a medium scatters.
struct MediumPoint<'a> {
    medium: &'a Medium,
    position: Vec3,
    /// Unit, towards where the path comes from.
    wo: Vec3,
    /// Shutter time.
    time: f32,
}

impl MediumPoint<'_> {
    fn light_context(&self) -> LightContext {
        LightContext { point: self.position, normal: Vec3::ZERO, transmits: true, time: self.time }
    }
}

/// The point at a distance along a segment, on the near side of the surface that its ray hits even when rounded.
fn before(context: &Context, ray: &Ray, hit: &Hit, segment: &Segment, distance: f32) -> Vec3 {
    let position = segment.origin + segment.direction * distance;
    if !hit.is_hit() {
        return position;
    }
    let surface = context.scene.surface_point(ray, hit);
    let normal = surface.geometric_normal * -1.0f32.copysign(segment.direction.dot(surface.geometric_normal));
    let height = (position - surface.position).dot(normal);
    position + normal * (surface.offset - height).max(0.0)
}

/// Layers show the first surface, whether or not a medium scatters before it; not where the ray may pass the surface.
fn keep_first_surface(context: &Context, paths: &mut Paths, path: usize) {
    let (ray, hit) = (paths.rays[path], paths.hits[path]);
    if !hit.is_hit() {
        return;
    }
    let point = context.scene.surface_point(&ray, &hit);
    let direction = Vec3::from(ray.direction);
    let hidden = context.scene.interiors().meet(&paths.bodies[path], &point, direction).hidden;
    if !hidden && context.scene.opacity(&point, &hit) >= 1.0 {
        paths.first[path] = first_hit_at(context, point, &hit, -direction, paths.cones[path].advanced(hit.t).width);
    }
}

/// The extinction coefficient where the medium is densest, 1/m.
fn densest(medium: &Medium) -> Spectrum {
    medium.extinction() * medium.density.as_ref().map_or(1.0, Grid::largest)
}

/// The distances along a segment that are drawn about a light; `None` where free flights alone are.
fn distances(context: &Context, extinction: Spectrum, segment: &Segment, light: u32) -> Option<Equiangular> {
    let anchor = context.scene.lights().lights()[light as usize].anchor()?;
    let length = segment.length.min(LONGEST / extinction.min_component());
    let drawn = Equiangular::new(&Segment { length, ..*segment }, anchor)?;
    (drawn.nearest() * extinction.mean() <= FARTHEST && length > 0.0).then_some(drawn)
}

/// Density of the equiangular distance over that of the flight that was drawn, each times the probability of the light.
/// `chosen` is the light and its probability at the end of the flight, above 0.
fn ratio(context: &Context, flown: &Flown, chosen: Selected) -> f32 {
    match distances(context, flown.extinction, &flown.segment, chosen.index) {
        Some(drawn) if flown.distance <= drawn.length() => {
            let before = context.scene.lights().probability_along(&flown.segment, chosen.index);
            drawn.pdf(flown.distance) / flown.density * (before / chosen.probability)
        }
        _ => 0.0,
    }
}

#[inline]
fn square(a: f32) -> f32 {
    a * a
}

/// Light from a light that is chosen first, scattered at a distance drawn about it.
fn connect(
    context: &Context,
    strategy: Strategy,
    paths: &Paths,
    path: usize,
    (medium, segment): (&Medium, &Segment),
    shadows: &mut ShadowQueue,
) {
    let (key, number) = (paths.samples[path].key, paths.progress[path].vertex);
    let sampler = context.sampler;
    let lights = context.scene.lights();
    let u = sampler.fine(key, number, Slot::EquiangularLight);
    let Some(chosen) = lights.select_along(segment, u) else { return };
    let Some(drawn) = distances(context, densest(medium), segment, chosen.index) else { return };
    let Some(distance) = drawn.sample(sampler.one_d(key, number, Slot::EquiangularDistance)) else { return };
    let position = before(context, &paths.rays[path], &paths.hits[path], segment, distance);
    let at = MediumPoint { medium, position, wo: -segment.direction, time: paths.rays[path].time };
    let u = sampler.two_d(key, number, Slot::EquiangularPosition);
    let Some(sample) = context.scene.sample_chosen_light(&at.light_context(), chosen, u) else { return };
    let scattering = medium.scattering_at(at.position);
    if scattering.is_black() {
        return;
    }
    let mut stream = sampler.stream(key, number, Slot::EquiangularPath);
    let transmittance = medium.transmittance(&Segment { length: distance, ..*segment }, &mut stream);
    let throughput = paths.throughput[path];
    let (own, flight) = (drawn.pdf(distance), medium.flight_density(segment, throughput, distance));
    let phase = medium.phase.eval(at.wo, sample.wi);
    let at_point = lights.probability(&at.light_context(), chosen.index) / chosen.probability;
    let others = square(flight / own);
    let weight = match (sample.density, strategy) {
        (Density::SolidAngle(light), Strategy::Both) => {
            1.0 / (1.0 + others * (square(at_point) + square(phase / light)))
        }
        _ => 1.0 / (1.0 + others * square(at_point)),
    };
    let arriving = throughput * transmittance * scattering * (phase * weight / own);
    let traveller = Traveller { bodies: paths.bodies[path], stream, direct: is_direct(context, paths, path) };
    queue(path, &at, &sample, arriving, traveller, shadows);
}

fn sample_light(
    context: &Context,
    strategy: Strategy,
    paths: &Paths,
    path: usize,
    (at, flown): (&MediumPoint, &Flown),
    shadows: &mut ShadowQueue,
) {
    let (key, number) = (paths.samples[path].key, paths.progress[path].vertex);
    let select = context.sampler.fine(key, number, Slot::LightSelect);
    let Some(chosen) = context.scene.lights().select(&at.light_context(), select) else { return };
    let u = context.sampler.two_d(key, number, Slot::LightPosition);
    let Some(sample) = context.scene.sample_chosen_light(&at.light_context(), chosen, u) else { return };
    let phase = at.medium.phase.eval(at.wo, sample.wi);
    let equiangular = square(ratio(context, flown, chosen));
    let weight = match (sample.density, strategy) {
        (Density::SolidAngle(own), Strategy::Both) => 1.0 / (1.0 + equiangular + square(phase / own)),
        _ => 1.0 / (1.0 + equiangular),
    };
    let arriving = paths.throughput[path] * (phase * weight);
    let stream = context.sampler.stream(key, number, Slot::LightPath);
    let traveller = Traveller { bodies: paths.bodies[path], stream, direct: is_direct(context, paths, path) };
    queue(path, at, &sample, arriving, traveller, shadows);
}

/// True if light samples from the end of the edge being traced are direct light, and that is told apart.
pub(super) fn is_direct(context: &Context, paths: &Paths, path: usize) -> bool {
    context.wants_direct && paths.progress[path].depth == 1
}

/// Queues a light sample, `arriving` being what the path takes of its radiance before it is divided by its density.
fn queue(
    path: usize,
    at: &MediumPoint,
    sample: &LightSample,
    arriving: Spectrum,
    traveller: Traveller,
    shadows: &mut ShadowQueue,
) {
    let density = sample.density.value();
    let contribution = arriving * sample.radiance * (1.0 / density);
    if !contribution.is_black() {
        let from = (at.position, PrimitiveId::NONE);
        shadows.push_within(path, from, sample.wi, sample.target, contribution, traveller);
    }
}

/// Draws the next direction; false if the path ends here.
fn scatter(context: &Context, paths: &mut Paths, path: usize, (at, flown): (&MediumPoint, Flown)) -> bool {
    let (key, number) = (paths.samples[path].key, paths.progress[path].vertex);
    let lobe = context.sampler.one_d(key, number, Slot::BsdfLobe);
    let u = context.sampler.two_d(key, number, Slot::Phase);
    let sample = at.medium.phase.sample(at.wo, lobe, u);
    if !survives(context, paths, path) {
        return false;
    }
    paths.previous[path] = Previous { context: at.light_context(), density: Density::SolidAngle(sample.pdf) };
    if context.scene.filters_textures() {
        paths.cones[path] = paths.cones[path].advanced(flown.distance).scattered(Density::SolidAngle(sample.pdf));
    }
    paths.flown[path] = flown;
    let ray = &mut paths.rays[path];
    ray.origin = at.position.into();
    ray.direction = sample.wi.normalize().into();
    ray.skip = PrimitiveId::NONE;
    let progress = &mut paths.progress[path];
    progress.depth += 1;
    progress.vertex += 1;
    true
}

/// Weight of emission of `light` (absent: from infinity) that the phase function found from the last vertex of path `path`,
/// `light_density` being what light sampling has for the same direction. `None` if the last vertex is not in a medium.
pub(super) fn found_weight(
    context: &Context,
    strategy: Strategy,
    paths: &Paths,
    path: usize,
    light: Option<u32>,
    light_density: impl FnOnce() -> f32,
) -> Option<f32> {
    let flown = &paths.flown[path];
    let Density::SolidAngle(own) = paths.previous[path].density else { return None };
    if flown.density <= 0.0 {
        return None;
    }
    if strategy == Strategy::Bsdf {
        return Some(1.0);
    }
    let by_light = light_density();
    if by_light <= 0.0 {
        return Some(1.0);
    }
    if strategy == Strategy::Light {
        return Some(0.0);
    }
    let equiangular = light.map_or(0.0, |index| {
        let probability = context.scene.lights().probability(&paths.previous[path].context, index);
        ratio(context, flown, Selected { index, probability })
    });
    // At least so much that nothing times infinity does not come up.
    let by_light = (by_light / own).max(f32::MIN_POSITIVE);
    Some(1.0 / (1.0 + square(by_light) + square(by_light * equiangular)))
}
