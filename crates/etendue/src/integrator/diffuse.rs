//! Diffuse vertices in lanes: vertices whose BSDF is Lambertian reflection, from all over a wave, go through light samples
//! and scattering together, in loops that become vector code.
//!
//! Which vertices these are depends on scene and vertex alone, and a lane's numbers on nothing in other lanes, so results
//! depend neither on the size of waves nor on the instruction set. The formulas are those of [`shade`](super::shade), and
//! give the same bits: they share the functions that are more than a product.
#![expect(clippy::needless_range_loop, reason = "an index is the lane, in several arrays at once")]

use super::{
    paths::{Paths, Previous},
    shade::{ROULETTE_FROM, Strategy, power_heuristic, survival},
    shadow::ShadowQueue,
    wave::Context,
};
use crate::{
    bsdf::Density,
    light::{LightContext, LightSample, RectangleFrame, Selected},
    math::{Frame, PI, Vec3, vec3},
    sampling::{KeyLanes, Sampler, Slot, warp},
    spectrum::Spectrum,
    surface::{flat_point, leave},
};
use etendue_accel::{Kernel, PrimitiveId, run};

/// Vertices that are taken together. A multiple of the longest vectors; all their numbers fit the L1 cache.
const LANES: usize = 64;

/// Fewest lanes for which a light's own vector code is run; fewer are sampled one by one.
const FEWEST: usize = 6;

/// A number of each lane.
type Numbers = [f32; LANES];

/// A vector of each lane.
#[derive(Clone, Copy)]
struct Vectors([Numbers; 3]);

impl Vectors {
    const ZERO: Self = Self([[0.0; LANES]; 3]);

    #[inline(always)]
    fn get(&self, i: usize) -> Vec3 {
        vec3(self.0[0][i], self.0[1][i], self.0[2][i])
    }

    #[inline(always)]
    fn set(&mut self, i: usize, v: Vec3) {
        self.0[0][i] = v.x;
        self.0[1][i] = v.y;
        self.0[2][i] = v.z;
    }

    #[inline(always)]
    fn spectrum(&self, i: usize) -> Spectrum {
        Spectrum([self.0[0][i], self.0[1][i], self.0[2][i]])
    }

    #[inline(always)]
    fn set_spectrum(&mut self, i: usize, spectrum: Spectrum) {
        self.set(i, Vec3::from_array(spectrum.0));
    }
}

/// A diffuse vertex, as [`Diffuse::take`] takes it.
pub(super) struct DiffuseVertex {
    /// Where light is gathered and rays leave from; with how far they are moved off, 0 for a point that was lifted.
    pub position: Vec3,
    pub offset: f32,
    /// What rays that leave do not meet.
    pub skip: PrimitiveId,
    pub geometric_normal: Vec3,
    pub shading_normal: Vec3,
    /// See [`Horizon`](super::horizon::Horizon).
    pub base: Vec3,
    /// Unit, towards where the path comes from.
    pub wo: Vec3,
    pub albedo: Spectrum,
}

/// Facets of which [`flat_point`] makes vertices.
struct Facets {
    corners: [Vectors; 3],
    weights: [Numbers; 2],
}

/// Vertices as they come from the surface.
struct Vertices {
    position: Vectors,
    offset: Numbers,
    geometric_normal: Vectors,
    shading_normal: Vectors,
    base: Vectors,
    wo: Vectors,
    albedo: Vectors,
    throughput: Vectors,
    /// See [`Progress::eta`](super::paths::Progress::eta); infinite where no roulette is played.
    eta: Numbers,
}

impl Vertices {
    #[inline(always)]
    fn light_context(&self, i: usize) -> LightContext {
        let (normal, wo) = (self.shading_normal.get(i), self.wo.get(i));
        let side = if wo.dot(normal) < 0.0 { -1.0 } else { 1.0 };
        LightContext { point: self.position.get(i), normal: normal * side, transmits: false }
    }
}

/// Whether a lane has a light sample.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
enum Lit {
    /// None.
    No,
    /// To be drawn one by one.
    Ask,
    /// From a direction that has a density per solid angle.
    Continuous,
    /// From a discrete direction.
    Discrete,
}

/// Light samples, and what comes of them.
struct LightSamples {
    /// Index of the light, or [`NO_LIGHT`].
    index: [u32; LANES],
    probability: Numbers,
    /// A [`Lit`].
    lit: [u32; LANES],
    wi: Vectors,
    target: Vectors,
    /// 1 where there is a target, 0 where the light is infinitely far.
    has_target: [u32; LANES],
    radiance: Vectors,
    density: Numbers,
    /// What arrives if nothing is in between, and the shadow ray; 0 for none.
    contribution: Vectors,
    origin: Vectors,
    direction: Vectors,
}

/// The next rays.
struct Onward {
    origin: Vectors,
    direction: Vectors,
    density: Numbers,
    throughput: Vectors,
}

const NO_LIGHT: u32 = u32::MAX;

/// The diffuse vertices of a wave: on plain facets, and all others.
pub(super) struct Diffuse {
    facets: Box<DiffuseLanes>,
    vertices: Box<DiffuseLanes>,
}

impl Diffuse {
    pub fn new() -> Self {
        Self { facets: DiffuseLanes::new(true), vertices: DiffuseLanes::new(false) }
    }

    /// Takes over path `path`, which has hit something, if that is a plain facet.
    #[inline]
    pub fn take_facet(
        &mut self,
        context: &Context,
        strategy: Strategy,
        paths: &mut Paths,
        path: usize,
        shadows: &mut ShadowQueue,
    ) -> bool {
        let Some((corners, albedo)) = context.scene.plain_facet(&paths.hits[path]) else { return false };
        let progress = &mut paths.progress[path];
        if progress.depth >= context.max_depth {
            progress.alive = false;
            return true;
        }
        paths.cones[path] = paths.cones[path].advanced(paths.hits[path].t);
        self.facets.push_facet(paths, path, &corners, albedo);
        if self.facets.is_full() {
            self.facets.finish(context, strategy, paths, shadows);
        }
        true
    }

    /// Takes over path `path` at the vertex that it has reached.
    #[inline]
    pub fn take(
        &mut self,
        context: &Context,
        strategy: Strategy,
        paths: &mut Paths,
        path: usize,
        vertex: &DiffuseVertex,
        shadows: &mut ShadowQueue,
    ) {
        self.vertices.push(paths, path, vertex);
        if self.vertices.is_full() {
            self.vertices.finish(context, strategy, paths, shadows);
        }
    }

    /// Takes all paths on that were taken over.
    pub fn finish(&mut self, context: &Context, strategy: Strategy, paths: &mut Paths, shadows: &mut ShadowQueue) {
        self.facets.finish(context, strategy, paths, shadows);
        self.vertices.finish(context, strategy, paths, shadows);
    }
}

/// Vertices that are taken together.
struct DiffuseLanes {
    len: usize,
    /// True if all vertices are pushed as facets, false if none is.
    flat: bool,
    facets: Facets,
    path: [u32; LANES],
    skip: [PrimitiveId; LANES],
    keys: KeyLanes<LANES>,
    vertices: Vertices,
    /// See [`Sampler::fine`].
    select: [f64; LANES],
    place: [Numbers; 2],
    turn: [Numbers; 2],
    roulette: Numbers,
    lights: LightSamples,
    onward: Onward,
}

impl DiffuseLanes {
    /// Empty lanes, for facets or for vertices.
    fn new(flat: bool) -> Box<Self> {
        let (numbers, vectors) = ([0.0; LANES], Vectors::ZERO);
        Box::new(Self {
            len: 0,
            flat,
            facets: Facets { corners: [vectors; 3], weights: [numbers; 2] },
            path: [0; LANES],
            skip: [PrimitiveId::NONE; LANES],
            keys: KeyLanes::default(),
            vertices: Vertices {
                position: vectors,
                offset: numbers,
                geometric_normal: vectors,
                shading_normal: vectors,
                base: vectors,
                wo: vectors,
                albedo: vectors,
                throughput: vectors,
                eta: numbers,
            },
            select: [0.0; LANES],
            place: [numbers; 2],
            turn: [numbers; 2],
            roulette: numbers,
            lights: LightSamples {
                index: [NO_LIGHT; LANES],
                probability: numbers,
                lit: [Lit::No as u32; LANES],
                wi: vectors,
                target: vectors,
                has_target: [0; LANES],
                radiance: vectors,
                density: numbers,
                contribution: vectors,
                origin: vectors,
                direction: vectors,
            },
            onward: Onward { origin: vectors, direction: vectors, density: numbers, throughput: vectors },
        })
    }

    /// Adds the vertex that path `path` has reached. The lanes must not be full.
    #[inline]
    fn push(&mut self, paths: &Paths, path: usize, vertex: &DiffuseVertex) {
        let (i, to) = (self.len, &mut self.vertices);
        to.position.set(i, vertex.position);
        to.offset[i] = vertex.offset;
        to.geometric_normal.set(i, vertex.geometric_normal);
        to.shading_normal.set(i, vertex.shading_normal);
        to.base.set(i, vertex.base);
        self.push_path(paths, path, vertex.wo, vertex.albedo, vertex.skip);
    }

    /// As [`Self::push`], a facet that path `path` has hit.
    #[inline]
    fn push_facet(&mut self, paths: &Paths, path: usize, corners: &[Vec3; 3], albedo: Spectrum) {
        let (i, hit) = (self.len, &paths.hits[path]);
        let [a, b, c] = &mut self.facets.corners;
        a.set(i, corners[0]);
        b.set(i, corners[1]);
        c.set(i, corners[2]);
        self.facets.weights[0][i] = hit.u;
        self.facets.weights[1][i] = hit.v;
        self.push_path(paths, path, -Vec3::from(paths.rays[path].direction), albedo, hit.id);
    }

    #[inline]
    fn push_path(&mut self, paths: &Paths, path: usize, wo: Vec3, albedo: Spectrum, skip: PrimitiveId) {
        let (i, to, progress) = (self.len, &mut self.vertices, &paths.progress[path]);
        to.wo.set(i, wo);
        to.albedo.set_spectrum(i, albedo);
        to.throughput.set_spectrum(i, paths.throughput[path]);
        to.eta[i] = if progress.depth < ROULETTE_FROM { f32::INFINITY } else { progress.eta };
        self.keys.set(i, paths.samples[path].key, progress.vertex);
        self.path[i] = path as u32;
        self.skip[i] = skip;
        self.len += 1;
    }

    /// True if no more can be pushed.
    #[inline]
    fn is_full(&self) -> bool {
        self.len == LANES
    }

    /// Takes what lanes there are through light samples and scattering, and empties them.
    fn finish(&mut self, context: &Context, strategy: Strategy, paths: &mut Paths, shadows: &mut ShadowQueue) {
        if self.len == 0 {
            return;
        }
        let isa = context.scene.accelerator().isa();
        let gathers = strategy != Strategy::Bsdf && !context.scene.lights().is_empty();
        if self.flat {
            run(isa, Place { lanes: self });
        }
        run(isa, Draw { lanes: self, sampler: context.sampler, gathers });
        if gathers {
            self.choose_lights(context);
            self.sample_lights(context);
            run(isa, Gather { lanes: self, both: strategy == Strategy::Both });
            self.send_light(shadows);
        }
        run(isa, Scatter { lanes: self });
        self.hand_back(context, paths);
        self.len = 0;
    }

    /// So many lanes that loops over them have whole vectors; those beyond the last vertex are idle.
    #[inline(always)]
    fn whole(&self) -> usize {
        self.len.next_multiple_of(16).min(LANES)
    }

    fn choose_lights(&mut self, context: &Context) {
        let lights = context.scene.lights();
        for i in 0..self.len {
            let chosen = lights.select(&self.light_context(i), self.select[i]);
            let to = &mut self.lights;
            to.index[i] = chosen.map_or(NO_LIGHT, |chosen| chosen.index);
            to.probability[i] = chosen.map_or(0.0, |chosen| chosen.probability);
            to.lit[i] = if chosen.is_some() { Lit::Ask } else { Lit::No } as u32;
        }
    }

    fn sample_lights(&mut self, context: &Context) {
        let isa = context.scene.accelerator().isa();
        for i in 0..self.len {
            let index = self.lights.index[i];
            let Some((frame, radiance)) = context.scene.uniform_rectangle(index) else { continue };
            let (before, rest) = self.lights.index[..self.len].split_at(i);
            let count = rest.iter().filter(|other| **other == index).count();
            if count >= FEWEST && !before.contains(&index) {
                run(isa, Rectangle { lanes: self, frame, radiance, index });
            }
        }
        // Those that share a light with few, and those for which a rectangle's map is not good enough.
        for i in 0..self.len {
            if self.lights.lit[i] == Lit::Ask as u32 {
                self.sample_light(context, i);
            }
        }
    }

    fn sample_light(&mut self, context: &Context, i: usize) {
        let at = self.light_context(i);
        let place = [self.place[0][i], self.place[1][i]];
        let chosen = Selected { index: self.lights.index[i], probability: self.lights.probability[i] };
        let sample = context.scene.sample_chosen_light(&at, chosen, place);
        let Some(LightSample { wi, target, radiance, density, .. }) = sample else {
            self.lights.lit[i] = Lit::No as u32;
            return;
        };
        let to = &mut self.lights;
        to.lit[i] = if let Density::SolidAngle(_) = density { Lit::Continuous } else { Lit::Discrete } as u32;
        to.wi.set(i, wi);
        to.target.set(i, target.unwrap_or_default());
        to.has_target[i] = u32::from(target.is_some());
        to.radiance.set_spectrum(i, radiance);
        to.density[i] = density.value();
    }

    #[inline]
    fn light_context(&self, i: usize) -> LightContext {
        self.vertices.light_context(i)
    }

    fn send_light(&self, shadows: &mut ShadowQueue) {
        let lights = &self.lights;
        for i in 0..self.len {
            let contribution = lights.contribution.spectrum(i);
            if !contribution.is_black() {
                let target = (lights.has_target[i] != 0).then(|| lights.target.get(i));
                let ends = (lights.origin.get(i), lights.direction.get(i));
                shadows.push_segment(self.path[i] as usize, ends, self.skip[i], target, contribution);
            }
        }
    }

    /// Gives the paths their next rays, or ends them.
    fn hand_back(&self, context: &Context, paths: &mut Paths) {
        let onward = &self.onward;
        for i in 0..self.len {
            let path = self.path[i] as usize;
            let throughput = onward.throughput.spectrum(i);
            if throughput.is_black() {
                paths.progress[path].alive = false;
                continue;
            }
            let density = Density::SolidAngle(onward.density[i]);
            paths.throughput[path] = throughput;
            paths.previous[path] = Previous { context: self.light_context(i), density };
            if context.scene.filters_textures() {
                paths.cones[path] = paths.cones[path].scattered(density);
            }
            let ray = &mut paths.rays[path];
            ray.origin = onward.origin.get(i).into();
            ray.direction = onward.direction.get(i).into();
            ray.skip = self.skip[i];
            let progress = &mut paths.progress[path];
            progress.depth += 1;
            progress.vertex += 1;
        }
    }
}

/// The points of facets.
struct Place<'a> {
    lanes: &'a mut DiffuseLanes,
}

impl Kernel for Place<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let DiffuseLanes { facets: Facets { corners: [a, b, c], weights }, vertices, .. } = self.lanes;
        for i in 0..n {
            let corners = [a.get(i), b.get(i), c.get(i)];
            let (position, offset, normal) = flat_point(corners, weights[0][i], weights[1][i]);
            vertices.position.set(i, position);
            vertices.offset[i] = offset;
            vertices.geometric_normal.set(i, normal);
            vertices.shading_normal.set(i, normal);
            vertices.base.set(i, normal);
        }
    }
}

/// The random numbers.
struct Draw<'a> {
    lanes: &'a mut DiffuseLanes,
    sampler: Sampler,
    gathers: bool,
}

impl Kernel for Draw<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let DiffuseLanes { keys, select, place, turn, roulette, .. } = self.lanes;
        if self.gathers {
            self.sampler.fine_lanes(keys, n, Slot::LightSelect, select);
            self.sampler.two_d_lanes(keys, n, Slot::LightPosition, place);
        }
        self.sampler.two_d_lanes(keys, n, Slot::BsdfDirection, turn);
        self.sampler.one_d_lanes(keys, n, Slot::Roulette, roulette);
    }
}

/// Samples of one rectangle for the lanes that chose it.
struct Rectangle<'a> {
    lanes: &'a mut DiffuseLanes,
    frame: &'a RectangleFrame,
    radiance: Spectrum,
    index: u32,
}

impl Kernel for Rectangle<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        // Copies, so that nothing in the loop can be thought to change them.
        let (frame, chosen, radiance) = (*self.frame, self.index, Vec3::from_array(self.radiance.0));
        let DiffuseLanes { lights, vertices, place, .. } = self.lanes;
        for i in 0..n {
            let view = frame.view(&vertices.light_context(i));
            let drawn = frame.sample(&view, [place[0][i], place[1][i]]);
            let is_valid = drawn.is_valid & (drawn.density * lights.probability[i] > 0.0);
            let found = if is_valid { Lit::Continuous as u32 } else { Lit::No as u32 };
            let found = if view.has_map() { found } else { Lit::Ask as u32 };
            let found = if view.is_seen { found } else { Lit::No as u32 };
            let own = lights.index[i] == chosen;
            let keep = |new: f32, old: f32| if own { new } else { old };
            let keep3 = |new: Vec3, old: Vec3| vec3(keep(new.x, old.x), keep(new.y, old.y), keep(new.z, old.z));
            lights.lit[i] = if own { found } else { lights.lit[i] };
            lights.has_target[i] = if own { 1 } else { lights.has_target[i] };
            lights.wi.set(i, keep3(drawn.wi, lights.wi.get(i)));
            lights.target.set(i, keep3(drawn.target, lights.target.get(i)));
            let density = drawn.density * lights.probability[i];
            lights.density[i] = keep(density, lights.density[i]);
            lights.radiance.set(i, keep3(radiance, lights.radiance.get(i)));
        }
    }
}

/// What the light samples contribute, and their shadow rays.
struct Gather<'a> {
    lanes: &'a mut DiffuseLanes,
    both: bool,
}

impl Kernel for Gather<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let DiffuseLanes { lights, vertices, .. } = self.lanes;
        for i in 0..n {
            let (wi, normal) = (lights.wi.get(i), vertices.shading_normal.get(i));
            let (in_z, out_z) = (wi.dot(normal), vertices.wo.get(i).dot(normal));
            let arrives = (in_z * out_z > 0.0) & (wi.dot(vertices.base.get(i)) * in_z > 0.0);
            let arrives = arrives & (lights.lit[i] >= Lit::Continuous as u32);
            let value = vertices.albedo.spectrum(i) * (in_z.abs() * (1.0 / PI));
            let own = lights.density[i];
            let shared = self.both & (lights.lit[i] == Lit::Continuous as u32);
            let heuristic = power_heuristic(own, warp::cosine_hemisphere_pdf(in_z.abs()));
            let weight = if shared { heuristic } else { 1.0 } / own;
            let contribution = vertices.throughput.spectrum(i) * value * lights.radiance.spectrum(i) * weight;
            lights.contribution.set_spectrum(i, contribution.map(|c| if arrives { c } else { 0.0 }));
            let origin = leave(vertices.position.get(i), vertices.geometric_normal.get(i), vertices.offset[i], wi);
            let to_target = lights.target.get(i) - origin;
            let direct = |to: f32, along: f32| if lights.has_target[i] != 0 { to } else { along };
            let direction = vec3(direct(to_target.x, wi.x), direct(to_target.y, wi.y), direct(to_target.z, wi.z));
            lights.origin.set(i, origin);
            lights.direction.set(i, direction);
        }
    }
}

/// The next directions, and roulette. The throughput is 0 where the path ends.
struct Scatter<'a> {
    lanes: &'a mut DiffuseLanes,
}

impl Kernel for Scatter<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let DiffuseLanes { vertices, turn, roulette, onward, .. } = self.lanes;
        for i in 0..n {
            let local = warp::cosine_hemisphere([turn[0][i], turn[1][i]]);
            let normal = vertices.shading_normal.get(i);
            let out_z = vertices.wo.get(i).dot(normal);
            let in_z = if out_z > 0.0 { local.z } else { -local.z };
            let wi = Frame::from_normal(normal).to_world(vec3(local.x, local.y, in_z));
            let leaves = (out_z != 0.0) & (local.z > 0.0) & (wi.dot(vertices.base.get(i)) * in_z > 0.0);
            let throughput = vertices.throughput.spectrum(i) * vertices.albedo.spectrum(i);
            let survival = survival(throughput, vertices.eta[i]);
            let plays = vertices.eta[i] < f32::INFINITY;
            let raise = if plays { 1.0 / survival } else { 1.0 };
            let lives = leaves & (!plays | (roulette[i] < survival));
            let throughput = throughput.map(|c| if lives { c * raise } else { 0.0 });
            onward.throughput.set_spectrum(i, throughput);
            onward.density[i] = warp::cosine_hemisphere_pdf(local.z);
            let origin = leave(vertices.position.get(i), vertices.geometric_normal.get(i), vertices.offset[i], wi);
            onward.origin.set(i, origin);
            onward.direction.set(i, wi.normalize());
        }
    }
}
