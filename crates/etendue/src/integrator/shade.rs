//! One vertex of a path: emission, light sample, BSDF sample, roulette.

use super::{
    attenuated::Traveller,
    circle,
    horizon::Horizon,
    lanes::{Groups, SurfaceVertex},
    paths::{Flown, Paths, Previous},
    resampling::{CANDIDATES, Reservoir, is_resampled, magnitude},
    shadow::ShadowQueue,
    splitting::each_part,
    volume,
    wave::Context,
};
use crate::{
    bsdf::{Bsdf, Density, InLanes},
    film::FirstHit,
    light::{LightContext, LightSample},
    math::{Frame, Vec3},
    sampling::{SampleKey, Slot},
    scene::{BodyStack, Meeting},
    spectrum::Spectrum,
    surface::{NO_LIGHT, SurfacePoint},
};
use etendue_accel::{Hit, PrimitiveId};

/// Which samples count for emission that both light and BSDF sampling can find.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Strategy {
    /// Both, weighted by the power heuristic with exponent 2 (Veach 1997).
    Both,
    /// Light samples alone, wherever they can find the emission.
    Light,
    /// BSDF samples alone.
    Bsdf,
}

/// Edges that a path has before roulette may end it.
pub(super) const ROULETTE_FROM: u32 = 2;
/// A path survives with its weight times this: early roulette that leaves paths alone until they have lost half. Against
/// survival by the weight alone from the fourth edge it took 9 to 24 % off rays times error in rooms of diffuse walls, of
/// glossy bodies and of many lamps; 1 from the second edge lost in the first and won less in the others.
const GENEROSITY: f32 = 2.0;
/// Paths survive with at most this probability, so that none is endless in a room that loses nothing. Variance stays finite
/// while the albedo's square is below it.
const MAX_SURVIVAL: f32 = 0.999;

/// Weight of a sample with density `own` where another strategy has density `other`, both in the same measure.
#[inline(always)]
pub(super) fn power_heuristic(own: f32, other: f32) -> f32 {
    // A ratio, so that squares cannot overflow.
    let ratio = if own == f32::INFINITY { 0.0 } else { other / own };
    1.0 / (1.0 + ratio * ratio)
}

/// Weight of emission that a BSDF ray found, `light_density` being what light sampling has for the same direction, in the
/// measure of `density`.
#[inline]
fn found_weight(strategy: Strategy, density: Density, light_density: impl FnOnce() -> f32) -> f32 {
    match (strategy, density) {
        (Strategy::Bsdf, _) | (_, Density::Discrete(_)) => 1.0,
        // What light sampling never draws, such as the far side of a sphere that is partly not there, is left to the BSDF.
        (Strategy::Light, Density::SolidAngle(_) | Density::Arc(_)) => f32::from(light_density() <= 0.0),
        (Strategy::Both, Density::SolidAngle(own) | Density::Arc(own)) => power_heuristic(own, light_density()),
    }
}

/// Takes path `path` through the vertex that its ray has reached; without media, one that [`Groups::take_facet`] does not take.
#[inline]
pub(super) fn shade<const MEDIA: bool>(
    context: &Context,
    strategy: Strategy,
    paths: &mut Paths,
    path: usize,
    shadows: &mut ShadowQueue,
    groups: &mut Groups,
) {
    if MEDIA && !volume::travel(context, strategy, paths, path, shadows) {
        return;
    }
    let hit = paths.hits[path];
    let ray = paths.rays[path];
    if !hit.is_hit() {
        if !context.transparent || paths.met_something(path) {
            add_environment::<MEDIA>(context, strategy, paths, path, Vec3::from(ray.direction));
        }
        paths.progress[path].alive = false;
        return;
    }
    let wants_first = wants_first(context, paths, path);
    let point = context.scene.surface_point(&ray, &hit);
    paths.cones[path] = paths.cones[path].advanced(hit.t);
    let meeting = if MEDIA { meet(context, paths, path, &point) } else { Meeting::PLAIN };
    if meeting.hidden || passes_through(context, paths, path, &hit, &point) {
        go_on::<MEDIA>(context, paths, path, &point);
        return;
    }
    let wo = -Vec3::from(ray.direction);
    let mut textured = Bsdf::Black;
    let seen = Seen { wo, width: paths.cones[path].width, surroundings: meeting.surroundings };
    let vertex = Vertex::new(context, point, &hit, seen, &mut textured);
    if wants_first {
        paths.first[path] = first_hit(context, &vertex, &hit);
    }
    if vertex.point.light != NO_LIGHT {
        add_emission::<MEDIA>(context, strategy, paths, path, &vertex, &hit);
    }
    if paths.progress[path].depth >= context.max_depth {
        paths.progress[path].alive = false;
        return;
    }
    if !MEDIA && let Some(vertex) = vertex.for_lanes() {
        groups.take(context, strategy, paths, path, &vertex, shadows);
        return;
    }
    if !vertex.bsdf.is_delta() {
        each_part(context, paths, path, |paths, path| {
            if strategy != Strategy::Bsdf {
                sample_light::<MEDIA>(context, strategy, paths, path, &vertex, shadows);
            }
            paths.progress[path].alive = scatter::<MEDIA>(context, paths, path, &vertex);
        });
        return;
    }
    if strategy != Strategy::Bsdf
        && let Some(circle) = vertex.bsdf.circle(vertex.local_wo)
    {
        circle::sample_light::<MEDIA>(context, strategy, paths, path, &vertex, &circle, shadows);
    }
    paths.progress[path].alive = scatter::<MEDIA>(context, paths, path, &vertex);
}

/// True if layers want to know the surface that path `path` has reached.
#[inline]
pub(super) fn wants_first(context: &Context, paths: &Paths, path: usize) -> bool {
    context.wants_layers && paths.progress[path].depth == 1
}

/// How a path looks at a surface.
#[derive(Clone, Copy)]
struct Seen {
    /// Unit, towards where the path comes from.
    wo: Vec3,
    /// Diameter of the path's cone, metres.
    width: f32,
    /// Index of refraction around the body, for one that has its own; else 1.
    surroundings: f32,
}

/// A surface point with its scattering, seen from `wo`.
pub(super) struct Vertex<'a> {
    pub point: SurfacePoint,
    bsdf: &'a Bsdf,
    pub frame: Frame,
    /// Unit, towards where the path comes from: world and local.
    wo: Vec3,
    local_wo: Vec3,
    horizon: Horizon,
}

impl<'a> Vertex<'a> {
    /// Where parameters have textures, or the surroundings an index of refraction other than 1, the BSDF is made for this
    /// point and kept in `textured`.
    #[inline]
    fn new(
        context: &Context<'a>,
        mut point: SurfacePoint,
        hit: &Hit,
        Seen { wo, width, surroundings }: Seen,
        textured: &'a mut Bsdf,
    ) -> Self {
        let mut relief = None;
        let bsdf = match context.scene.bsdf(point.material) {
            Some(bsdf) if surroundings == 1.0 => bsdf,
            _ => {
                let at = context.scene.lookup_over(&point, hit, wo, width);
                relief = context.scene.detailed_normal(&point, hit, &at);
                *textured = context.scene.bsdf_within(&point, &at, surroundings);
                textured
            }
        };
        let horizon = Horizon::new(context, &mut point, hit, wo, relief, bsdf);
        let frame = frame(context, &point, hit, bsdf);
        let local_wo = frame.to_local(wo);
        Self { point, bsdf, frame, wo, local_wo, horizon }
    }

    /// The vertex for [`Groups`], if it goes in lanes.
    #[inline]
    fn for_lanes(&self) -> Option<(SurfaceVertex, InLanes)> {
        let bsdf = self.bsdf.in_lanes()?;
        let (offset, skip) = match self.horizon.lifted {
            Some(_) => (0.0, PrimitiveId::NONE),
            None => (self.point.offset, self.point.id),
        };
        let vertex = SurfaceVertex {
            position: self.gathers_at(),
            offset,
            skip,
            beyond: self.point.position,
            beyond_offset: self.point.offset,
            beyond_skip: self.point.id,
            geometric_normal: self.point.geometric_normal,
            shading_normal: self.point.shading_normal,
            base: self.horizon.base(),
            roughness: self.horizon.roughness(),
            wo: self.wo,
        };
        Some((vertex, bsdf))
    }

    /// True if shading and geometric normal agree on which side `wi` is.
    #[inline]
    pub fn is_consistent(&self, wi: Vec3, local_wi: Vec3) -> bool {
        if self.is_reflected(local_wi) {
            self.horizon.is_above(wi, local_wi.z)
        } else {
            wi.dot(self.point.geometric_normal) * local_wi.z > 0.0
        }
    }

    /// Fraction of light from `wi` that continuous lobes get to see: 0 where `wi` is not consistent, below 1 where bumps throw
    /// shadows.
    #[inline]
    pub fn shadowing(&self, wi: Vec3, local_wi: Vec3) -> f32 {
        match (self.is_consistent(wi, local_wi), self.is_reflected(local_wi)) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => self.horizon.shadowing(wi),
        }
    }

    #[inline]
    fn is_reflected(&self, local_wi: Vec3) -> bool {
        local_wi.z * self.local_wo.z > 0.0
    }

    /// Where light on the side of `wo` is gathered.
    #[inline]
    pub fn gathers_at(&self) -> Vec3 {
        self.horizon.lifted.unwrap_or(self.point.position)
    }

    /// Origin of a ray that leaves towards `wi`, and what it does not meet.
    #[inline]
    fn departure(&self, wi: Vec3, local_wi: Vec3) -> (Vec3, PrimitiveId) {
        match self.horizon.lifted {
            Some(lifted) if self.is_reflected(local_wi) => (lifted, PrimitiveId::NONE),
            _ => (self.point.leave(wi), self.point.id),
        }
    }

    /// The bodies in which light from `wi` arrives, those on the side of `wo` being known.
    fn bodies_towards(&self, context: &Context, bodies: &BodyStack, wi: Vec3, local_wi: Vec3) -> BodyStack {
        let mut bodies = *bodies;
        if local_wi.z * self.local_wo.z < 0.0 {
            context.scene.interiors().cross(&mut bodies, &self.point, wi);
        }
        bodies
    }

    fn light_context(&self) -> LightContext {
        let normal = if self.local_wo.z < 0.0 { -self.point.shading_normal } else { self.point.shading_normal };
        LightContext { point: self.gathers_at(), normal, transmits: self.bsdf.transmits(), time: self.point.time }
    }
}

/// What layers keep of a surface that is seen from `wo`, for integrators that do not scatter there.
pub(super) fn first_hit_at(context: &Context, point: SurfacePoint, hit: &Hit, wo: Vec3, width: f32) -> FirstHit {
    let mut textured = Bsdf::Black;
    let seen = Seen { wo, width, surroundings: 1.0 };
    first_hit(context, &Vertex::new(context, point, hit, seen, &mut textured), hit)
}

/// The local frame: where a BSDF has directions, they are those of the material's field.
#[inline]
fn frame(context: &Context, point: &SurfacePoint, hit: &Hit, bsdf: &Bsdf) -> Frame {
    if bsdf.is_anisotropic() {
        context.scene.directed_frame(point, hit)
    } else {
        Frame::from_normal(point.shading_normal)
    }
}

fn first_hit(context: &Context, vertex: &Vertex, hit: &Hit) -> FirstHit {
    FirstHit {
        albedo: vertex.bsdf.albedo(),
        normal: vertex.point.shading_normal,
        depth: context.camera.view(vertex.point.time).depth(vertex.point.position),
        position: (context.scene.center() + vertex.point.position.as_dvec3()).as_vec3(),
        uv: context.scene.texture_coordinates(&vertex.point, hit),
        object: vertex.point.id.instance + 1,
        material: vertex.point.material + 1,
    }
}

fn add_environment<const MEDIA: bool>(
    context: &Context,
    strategy: Strategy,
    paths: &mut Paths,
    path: usize,
    direction: Vec3,
) {
    let radiance = context.scene.environment_radiance(direction);
    if radiance.is_black() {
        return;
    }
    let Previous { context: from, density } = &paths.previous[path];
    let by_light = || match density {
        // Circles are not sampled for the environment.
        Density::Arc(_) => 0.0,
        _ => context.scene.lights().pdf_environment(from, direction),
    };
    let in_medium = if MEDIA { volume::found_weight(context, strategy, paths, path, None, by_light) } else { None };
    let weight = in_medium.unwrap_or_else(|| found_weight(strategy, *density, by_light));
    paths.radiance[path] += paths.throughput[path] * radiance * weight;
}

/// Where a surface is partly not there, the path goes straight on with that probability.
fn passes_through(context: &Context, paths: &Paths, path: usize, hit: &Hit, point: &SurfacePoint) -> bool {
    if context.scene.is_opaque() {
        return false;
    }
    let opacity = context.scene.opacity(point, hit);
    let (key, vertex) = (paths.samples[path].key, paths.progress[path].vertex);
    opacity < 1.0 && context.sampler.one_d(key, vertex, Slot::Opacity) >= opacity
}

/// Takes a path straight on behind a surface.
fn go_on<const MEDIA: bool>(context: &Context, paths: &mut Paths, path: usize, point: &SurfacePoint) {
    let onward = &mut paths.rays[path];
    let direction = Vec3::from(onward.direction);
    onward.origin = point.leave(direction).into();
    onward.skip = point.id;
    paths.progress[path].vertex += 1;
    if MEDIA {
        context.scene.interiors().cross(&mut paths.bodies[path], point, direction);
    }
}

/// What a surface is to a path, by the bodies that the path is in.
fn meet(context: &Context, paths: &Paths, path: usize, point: &SurfacePoint) -> Meeting {
    context.scene.interiors().meet(&paths.bodies[path], point, paths.rays[path].direction.into())
}

fn add_emission<const MEDIA: bool>(
    context: &Context,
    strategy: Strategy,
    paths: &mut Paths,
    path: usize,
    vertex: &Vertex,
    hit: &Hit,
) {
    let material = &context.scene.materials()[vertex.point.material as usize];
    let Some(emission) = &material.emission else { return };
    if !emission.two_sided && vertex.point.geometric_normal.dot(vertex.wo) <= 0.0 {
        return;
    }
    let Previous { context: from, density } = &paths.previous[path];
    let light = vertex.point.light;
    let by_light = || {
        let distance = (vertex.point.position - from.point).length();
        let (lights, wi) = (context.scene.lights(), -vertex.wo);
        match density {
            Density::Arc(_) => lights.pdf_circle(&paths.circles[path], light, wi, distance),
            _ => lights.pdf_hit(from, light, wi, distance),
        }
    };
    let in_medium =
        if MEDIA { volume::found_weight(context, strategy, paths, path, Some(light), by_light) } else { None };
    let weight = in_medium.unwrap_or_else(|| found_weight(strategy, *density, by_light));
    let radiance = match &emission.radiance.texture {
        None => emission.radiance.factor,
        Some(_) => emission.at(&context.scene.lookup(&vertex.point, hit)),
    };
    paths.radiance[path] += paths.throughput[path] * radiance * weight;
}

fn sample_light<const MEDIA: bool>(
    context: &Context,
    strategy: Strategy,
    paths: &Paths,
    path: usize,
    vertex: &Vertex,
    shadows: &mut ShadowQueue,
) {
    if context.scene.lights().is_empty() {
        return;
    }
    let (key, number) = (paths.samples[path].key, paths.progress[path].vertex);
    if !is_resampled(context, paths, path, vertex.bsdf.transmits()) {
        if let Some((light, contribution)) = draw_light(context, strategy, paths, path, vertex, key) {
            send_light::<MEDIA>(context, paths, path, vertex, &light, contribution, shadows);
        }
        return;
    }
    let mut reservoir = Reservoir { total: 0.0, u: context.sampler.one_d(key, number, Slot::LightResampling) };
    let mut kept = None;
    for candidate in 0..CANDIDATES {
        let drawn = draw_light(context, strategy, paths, path, vertex, key.part(candidate, CANDIDATES));
        let contribution = drawn.as_ref().map_or(Spectrum::BLACK, |(_, contribution)| *contribution);
        if reservoir.takes(magnitude(contribution)) {
            kept = drawn;
        }
    }
    if let Some((light, contribution)) = kept {
        let contribution = reservoir.whole(contribution, CANDIDATES);
        send_light::<MEDIA>(context, paths, path, vertex, &light, contribution, shadows);
    }
}

/// A light sample by the numbers of `key`, and what it contributes if nothing is in its way.
fn draw_light(
    context: &Context,
    strategy: Strategy,
    paths: &Paths,
    path: usize,
    vertex: &Vertex,
    key: SampleKey,
) -> Option<(LightSample, Spectrum)> {
    let number = paths.progress[path].vertex;
    let select = context.sampler.fine(key, number, Slot::LightSelect);
    let position = context.sampler.two_d(key, number, Slot::LightPosition);
    let light = context.scene.sample_light(&vertex.light_context(), select, position)?;
    let local_wi = vertex.frame.to_local(light.wi);
    let shadowing = vertex.shadowing(light.wi, local_wi);
    if shadowing == 0.0 {
        return None;
    }
    let eval = vertex.bsdf.eval(vertex.local_wo, local_wi);
    let weight = match (light.density, strategy) {
        (Density::SolidAngle(own), Strategy::Both) => power_heuristic(own, eval.pdf) / own,
        (own, _) => 1.0 / own.value(),
    };
    Some((light, paths.throughput[path] * eval.value * light.radiance * (weight * shadowing)))
}

/// Queues what a light sample contributes if nothing is in its way.
pub(super) fn send_light<const MEDIA: bool>(
    context: &Context,
    paths: &Paths,
    path: usize,
    vertex: &Vertex,
    light: &LightSample,
    contribution: Spectrum,
    shadows: &mut ShadowQueue,
) {
    if contribution.is_black() {
        return;
    }
    let local_wi = vertex.frame.to_local(light.wi);
    let from = vertex.departure(light.wi, local_wi);
    if !MEDIA {
        shadows.push(path, from, light.wi, light.target, contribution);
        return;
    }
    let (key, number) = (paths.samples[path].key, paths.progress[path].vertex);
    let traveller = Traveller {
        bodies: vertex.bodies_towards(context, &paths.bodies[path], light.wi, local_wi),
        stream: context.sampler.stream(key, number, Slot::LightPath),
        direct: volume::is_direct(context, paths, path),
    };
    shadows.push_within(path, from, light.wi, light.target, contribution, traveller);
}

/// Draws the next direction; false if the path ends here.
fn scatter<const MEDIA: bool>(context: &Context, paths: &mut Paths, path: usize, vertex: &Vertex) -> bool {
    let (key, number) = (paths.samples[path].key, paths.progress[path].vertex);
    let lobe = context.sampler.one_d(key, number, Slot::BsdfLobe);
    let direction = context.sampler.two_d(key, number, Slot::BsdfDirection);
    let Some(sample) = vertex.bsdf.sample(vertex.local_wo, lobe, direction) else { return false };
    let wi = vertex.frame.to_world(sample.wi);
    if !vertex.is_consistent(wi, sample.wi) {
        return false;
    }
    let shadowing = match sample.density {
        Density::Discrete(_) => 1.0,
        _ => vertex.shadowing(wi, sample.wi),
    };
    paths.throughput[path] = paths.throughput[path] * sample.weight * shadowing;
    paths.progress[path].eta *= sample.eta;
    if paths.throughput[path].is_black() || !survives(context, paths, path) {
        return false;
    }
    paths.previous[path] = Previous { context: vertex.light_context(), density: sample.density };
    if context.scene.filters_textures() {
        paths.cones[path] = paths.cones[path].scattered(sample.density);
    }
    if MEDIA {
        paths.bodies[path] = vertex.bodies_towards(context, &paths.bodies[path], wi, sample.wi);
        paths.flown[path] = Flown::NONE;
    }
    let (origin, skip) = vertex.departure(wi, sample.wi);
    let ray = &mut paths.rays[path];
    ray.origin = origin.into();
    ray.direction = wi.normalize().into();
    ray.skip = skip;
    let progress = &mut paths.progress[path];
    progress.depth += 1;
    progress.vertex += 1;
    true
}

/// Plays roulette with the throughput of path `path`; false if it ends.
pub(super) fn survives(context: &Context, paths: &mut Paths, path: usize) -> bool {
    let progress = paths.progress[path];
    if progress.depth < ROULETTE_FROM {
        return true;
    }
    let u = context.sampler.one_d(paths.samples[path].key, progress.vertex, Slot::Roulette);
    let survivor = roulette(paths.throughput[path], progress.eta, u);
    paths.throughput[path] = survivor.unwrap_or(Spectrum::BLACK);
    survivor.is_some()
}

/// Unbiased Russian roulette (Arvo and Kirk 1990): a path survives with a probability of twice its weight, and is raised by it.
/// `eta` is the index of refraction where the path is over that at the camera: the radiance that is squeezed inside
/// glass is given back when the path leaves, so it is no loss.
#[inline]
fn roulette(throughput: Spectrum, eta: f32, u: f32) -> Option<Spectrum> {
    let survival = survival(throughput, eta);
    (u < survival).then(|| throughput * (1.0 / survival))
}

/// The probability with which a path survives roulette.
#[inline(always)]
pub(super) fn survival(throughput: Spectrum, eta: f32) -> f32 {
    let survival = throughput.max_component() * (eta * eta * GENEROSITY);
    if survival < MAX_SURVIVAL { survival } else { MAX_SURVIVAL }
}
