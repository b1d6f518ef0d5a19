//! One vertex of a path: emission, light sample, BSDF sample, roulette.

use super::{
    paths::{Paths, Previous},
    shadow::ShadowQueue,
    wave::Context,
};
use crate::{
    bsdf::{Bsdf, Density},
    film::FirstHit,
    light::LightContext,
    math::{Frame, Vec3},
    sampling::Slot,
    spectrum::Spectrum,
    surface::{NO_LIGHT, SurfacePoint},
};
use etendue_accel::{Hit, Ray};

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
const ROULETTE_FROM: u32 = 4;
/// Paths survive with at most this probability, so that none is endless in a room that loses nothing. Variance stays finite
/// while the albedo's square is below it.
const MAX_SURVIVAL: f32 = 0.999;

/// Weight of a sample with density `own` where another strategy has density `other`, both in the same measure.
#[inline]
fn power_heuristic(own: f32, other: f32) -> f32 {
    if own.is_infinite() {
        return 1.0;
    }
    // A ratio, so that squares cannot overflow.
    let ratio = other / own;
    1.0 / (1.0 + ratio * ratio)
}

/// Weight of emission that a BSDF ray found, `light_density` being what light sampling has for the same direction.
#[inline]
fn found_weight(strategy: Strategy, density: Density, light_density: impl FnOnce() -> f32) -> f32 {
    match (strategy, density) {
        (Strategy::Bsdf, _) | (_, Density::Discrete(_)) => 1.0,
        // What light sampling never draws, such as the far side of a sphere that is partly not there, is left to the BSDF.
        (Strategy::Light, Density::SolidAngle(_)) => f32::from(light_density() <= 0.0),
        (Strategy::Both, Density::SolidAngle(own)) => power_heuristic(own, light_density()),
    }
}

/// Takes path `path` through the vertex that its ray has reached.
#[inline]
pub(super) fn shade(context: &Context, strategy: Strategy, paths: &mut Paths, path: usize, shadows: &mut ShadowQueue) {
    let hit = paths.hits[path];
    let ray = paths.rays[path];
    if !hit.is_hit() {
        add_environment(context, strategy, paths, path, Vec3::from(ray.direction));
        paths.progress[path].alive = false;
        return;
    }
    let point = context.scene.surface_point(&ray, &hit);
    paths.cones[path] = paths.cones[path].advanced(hit.t);
    if passes_through(context, paths, path, &ray, &hit, &point) {
        return;
    }
    let wo = -Vec3::from(ray.direction);
    let mut textured = Bsdf::Black;
    let vertex = Vertex::new(context, point, &hit, wo, paths.cones[path].width, &mut textured);
    if context.wants_layers && paths.progress[path].depth == 1 {
        paths.first[path] = first_hit(context, &vertex, &hit);
    }
    if vertex.point.light != NO_LIGHT {
        add_emission(context, strategy, paths, path, &vertex, &hit);
    }
    if paths.progress[path].depth >= context.max_depth {
        paths.progress[path].alive = false;
        return;
    }
    if strategy != Strategy::Bsdf && !vertex.bsdf.is_delta() {
        sample_light(context, strategy, paths, path, &vertex, shadows);
    }
    paths.progress[path].alive = scatter(context, paths, path, &vertex);
}

/// A surface point with its scattering, seen from `wo`.
struct Vertex<'a> {
    point: SurfacePoint,
    bsdf: &'a Bsdf,
    frame: Frame,
    /// Unit, towards where the path comes from: world and local.
    wo: Vec3,
    local_wo: Vec3,
}

impl<'a> Vertex<'a> {
    /// Where parameters have textures, the BSDF is made for this point, over the `width` of the path's cone in metres, and kept
    /// in `textured`.
    #[inline]
    fn new(
        context: &Context<'a>,
        mut point: SurfacePoint,
        hit: &Hit,
        wo: Vec3,
        width: f32,
        textured: &'a mut Bsdf,
    ) -> Self {
        let bsdf = match context.scene.bsdf(point.material) {
            Some(bsdf) => bsdf,
            None => {
                let at = context.scene.lookup_over(&point, hit, wo, width);
                point.shading_normal = context.scene.detailed_normal(&point, hit, &at);
                *textured = context.scene.bsdf_at(&point, &at);
                textured
            }
        };
        // Interpolated normals may face away from a viewer who does see the surface: there the true normal is used.
        if point.shading_normal.dot(wo) * point.geometric_normal.dot(wo) <= 0.0 {
            point.shading_normal = point.geometric_normal;
        }
        let frame = frame(context, &point, hit, bsdf);
        let local_wo = frame.to_local(wo);
        Self { point, bsdf, frame, wo, local_wo }
    }

    /// True if shading and geometric normal agree on which side `wi` is.
    #[inline]
    fn is_consistent(&self, wi: Vec3, local_wi: Vec3) -> bool {
        wi.dot(self.point.geometric_normal) * local_wi.z > 0.0
    }

    fn light_context(&self) -> LightContext {
        let normal = if self.local_wo.z < 0.0 { -self.point.shading_normal } else { self.point.shading_normal };
        LightContext { point: self.point.position, normal, transmits: self.bsdf.transmits() }
    }
}

/// What layers keep of a surface that is seen from `wo`, for integrators that do not scatter there.
pub(super) fn first_hit_at(context: &Context, point: SurfacePoint, hit: &Hit, wo: Vec3, width: f32) -> FirstHit {
    let mut textured = Bsdf::Black;
    first_hit(context, &Vertex::new(context, point, hit, wo, width, &mut textured), hit)
}

/// The local frame: where a BSDF has a direction, x is that of growing u.
#[inline]
fn frame(context: &Context, point: &SurfacePoint, hit: &Hit, bsdf: &Bsdf) -> Frame {
    let normal = point.shading_normal;
    if bsdf.is_anisotropic()
        && let Some(tangent) = context.scene.chart(point, hit).tangent(normal)
    {
        return Frame::from_tangent(normal, tangent);
    }
    Frame::from_normal(normal)
}

fn first_hit(context: &Context, vertex: &Vertex, hit: &Hit) -> FirstHit {
    FirstHit {
        albedo: vertex.bsdf.albedo(),
        normal: vertex.point.shading_normal,
        depth: context.camera.depth(vertex.point.position),
        position: (context.scene.center() + vertex.point.position.as_dvec3()).as_vec3(),
        uv: context.scene.texture_coordinates(&vertex.point, hit),
        object: vertex.point.id.instance + 1,
        material: vertex.point.material + 1,
    }
}

fn add_environment(context: &Context, strategy: Strategy, paths: &mut Paths, path: usize, direction: Vec3) {
    let radiance = context.scene.environment_radiance(direction);
    if radiance.is_black() {
        return;
    }
    let Previous { context: from, density } = &paths.previous[path];
    let weight = found_weight(strategy, *density, || context.scene.lights().pdf_environment(from, direction));
    paths.radiance[path] += paths.throughput[path] * radiance * weight;
}

/// Where a surface is partly not there, the path goes straight on with that probability.
fn passes_through(
    context: &Context,
    paths: &mut Paths,
    path: usize,
    ray: &Ray,
    hit: &Hit,
    point: &SurfacePoint,
) -> bool {
    if context.scene.is_opaque() {
        return false;
    }
    let opacity = context.scene.opacity(point, hit);
    let progress = &mut paths.progress[path];
    if opacity >= 1.0 || context.sampler.one_d(paths.samples[path].key, progress.vertex, Slot::Opacity) < opacity {
        return false;
    }
    progress.vertex += 1;
    let onward = &mut paths.rays[path];
    onward.origin = point.leave(Vec3::from(ray.direction)).into();
    onward.skip = hit.id;
    true
}

fn add_emission(context: &Context, strategy: Strategy, paths: &mut Paths, path: usize, vertex: &Vertex, hit: &Hit) {
    let material = &context.scene.materials()[vertex.point.material as usize];
    let Some(emission) = &material.emission else { return };
    if !emission.two_sided && vertex.point.geometric_normal.dot(vertex.wo) <= 0.0 {
        return;
    }
    let Previous { context: from, density } = &paths.previous[path];
    let weight = found_weight(strategy, *density, || {
        let distance = (vertex.point.position - from.point).length();
        context.scene.lights().pdf_hit(from, vertex.point.light, -vertex.wo, distance)
    });
    let radiance = match &emission.radiance.texture {
        None => emission.radiance.factor,
        Some(_) => emission.at(&context.scene.lookup(&vertex.point, hit)),
    };
    paths.radiance[path] += paths.throughput[path] * radiance * weight;
}

fn sample_light(
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
    let select = context.sampler.one_d(key, number, Slot::LightSelect);
    let position = context.sampler.two_d(key, number, Slot::LightPosition);
    let Some(light) = context.scene.sample_light(&vertex.light_context(), select, position) else { return };
    let local_wi = vertex.frame.to_local(light.wi);
    if !vertex.is_consistent(light.wi, local_wi) {
        return;
    }
    let eval = vertex.bsdf.eval(vertex.local_wo, local_wi);
    let weight = match (light.density, strategy) {
        (Density::SolidAngle(own), Strategy::Both) => power_heuristic(own, eval.pdf) / own,
        (Density::SolidAngle(own) | Density::Discrete(own), _) => 1.0 / own,
    };
    let contribution = paths.throughput[path] * eval.value * light.radiance * weight;
    if !contribution.is_black() {
        shadows.push(path, &vertex.point, light.wi, light.target, contribution);
    }
}

/// Draws the next direction; false if the path ends here.
fn scatter(context: &Context, paths: &mut Paths, path: usize, vertex: &Vertex) -> bool {
    let (key, number) = (paths.samples[path].key, paths.progress[path].vertex);
    let lobe = context.sampler.one_d(key, number, Slot::BsdfLobe);
    let direction = context.sampler.two_d(key, number, Slot::BsdfDirection);
    let Some(sample) = vertex.bsdf.sample(vertex.local_wo, lobe, direction) else { return false };
    let wi = vertex.frame.to_world(sample.wi);
    if !vertex.is_consistent(wi, sample.wi) {
        return false;
    }
    let mut throughput = paths.throughput[path] * sample.weight;
    if throughput.is_black() {
        return false;
    }
    let eta = paths.progress[path].eta * sample.eta;
    if paths.progress[path].depth >= ROULETTE_FROM {
        let u = context.sampler.one_d(key, number, Slot::Roulette);
        match roulette(throughput, eta, u) {
            Some(survivor) => throughput = survivor,
            None => return false,
        }
    }
    paths.throughput[path] = throughput;
    paths.previous[path] = Previous { context: vertex.light_context(), density: sample.density };
    if context.scene.filters_textures() {
        paths.cones[path] = paths.cones[path].scattered(sample.density);
    }
    let ray = &mut paths.rays[path];
    ray.origin = vertex.point.leave(wi).into();
    ray.direction = wi.normalize().into();
    ray.skip = vertex.point.id;
    let progress = &mut paths.progress[path];
    progress.eta = eta;
    progress.depth += 1;
    progress.vertex += 1;
    true
}

/// Unbiased Russian roulette (Arvo and Kirk 1990): a path survives with a probability near its weight, and is raised by it.
/// `eta` is the index of refraction where the path is over that at the camera: the radiance that is squeezed inside
/// glass is given back when the path leaves, so it is no loss.
#[inline]
fn roulette(throughput: Spectrum, eta: f32, u: f32) -> Option<Spectrum> {
    let survival = (throughput.max_component() * eta * eta).min(MAX_SURVIVAL);
    (u < survival).then(|| throughput * (1.0 / survival))
}
