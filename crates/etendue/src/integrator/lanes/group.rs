//! The lanes: vertices that are taken together, and the order of what is done to them.

use super::{
    SurfaceVertex,
    lights::{LightSamples, ShapedLights},
    numbers::{Numbers, Vectors},
    rectangles::Near,
    resampled::{Keep, Kept, TakeKept},
    stages::{Draw, DrawLights, Gather, Place, Scatter},
};
use crate::{
    bsdf::{Density, LANES, LaneBsdf, MOST_NUMBERS},
    integrator::{
        paths::{Paths, Previous},
        shade::{ROULETTE_FROM, Strategy},
        shadow::ShadowQueue,
        wave::Context,
    },
    light::LightContext,
    math::Vec3,
    sampling::KeyLanes,
};
use etendue_accel::{PrimitiveId, run};

/// Facets of which [`flat_point`](crate::surface::flat_point) makes vertices.
pub(super) struct Facets {
    pub corners: [Vectors; 3],
    pub weights: [Numbers; 2],
}

/// Vertices as they come from the surface; see [`SurfaceVertex`].
pub(super) struct Vertices {
    pub position: Vectors,
    pub offset: Numbers,
    pub beyond: Vectors,
    pub beyond_offset: Numbers,
    pub geometric_normal: Vectors,
    pub shading_normal: Vectors,
    pub base: Vectors,
    pub roughness: Numbers,
    pub wo: Vectors,
    /// Of the shutter.
    pub time: Numbers,
    pub throughput: Vectors,
    /// See [`Progress::eta`](crate::integrator::paths::Progress::eta).
    pub eta: Numbers,
    /// 1 where roulette is played, else 0.
    pub plays: [u32; LANES],
}

impl Vertices {
    /// `transmits`: light from below counts too.
    #[inline(always)]
    pub fn light_context(&self, i: usize, transmits: bool) -> LightContext {
        let (point, normal) = (self.position.get(i), self.gathering_normal(i));
        LightContext { point, normal, transmits, time: self.time[i] }
    }

    /// The shading normal on the side of `wo`.
    #[inline(always)]
    pub fn gathering_normal(&self, i: usize) -> Vec3 {
        let (normal, wo) = (self.shading_normal.get(i), self.wo.get(i));
        normal * if wo.dot(normal) < 0.0 { -1.0 } else { 1.0 }
    }
}

/// Random numbers.
pub(super) struct Drawn {
    /// See [`Sampler::fine`](crate::sampling::Sampler::fine).
    pub select: [f64; LANES],
    pub place: [Numbers; 2],
    pub lobe: Numbers,
    pub turn: [Numbers; 2],
    pub roulette: Numbers,
}

/// The next rays.
pub(super) struct Onward {
    pub origin: Vectors,
    pub direction: Vectors,
    /// Where light was gathered: see [`LightContext`].
    pub from_normal: Vectors,
    pub density: Numbers,
    /// 1 where the density is that of a discrete direction, else 0.
    pub discrete: [u32; LANES],
    /// 1 where the ray goes to the other side, else 0.
    pub transmitted: [u32; LANES],
    pub eta: Numbers,
    pub throughput: Vectors,
}

/// Vertices of one kind that are taken together.
pub(super) struct Lanes {
    pub len: usize,
    /// True if all vertices are pushed as facets, false if none is.
    flat: bool,
    /// True if light from below counts too. Outside of what loops over lanes read: copied before.
    pub transmits: bool,
    /// For how many candidates each light sample is drawn.
    pub candidates: u32,
    pub facets: Facets,
    path: [u32; LANES],
    skip: [PrimitiveId; LANES],
    beyond_skip: [PrimitiveId; LANES],
    pub keys: KeyLanes<LANES>,
    /// Those for light samples.
    pub light_keys: KeyLanes<LANES>,
    pub vertices: Vertices,
    /// What the vertices scatter like: see [`LaneBsdf::load`].
    pub numbers: [Numbers; MOST_NUMBERS],
    pub drawn: Drawn,
    pub lights: LightSamples,
    pub shaped_lights: ShapedLights,
    pub near: Near,
    pub kept: Kept,
    pub onward: Onward,
}

impl Lanes {
    /// Empty lanes, for facets or for vertices, of a kind that transmits or does not.
    pub fn new(flat: bool, transmits: bool) -> Box<Self> {
        let (numbers, vectors, flags) = ([0.0; LANES], Vectors::ZERO, [0; LANES]);
        Box::new(Self {
            len: 0,
            flat,
            transmits,
            candidates: 1,
            facets: Facets { corners: [vectors; 3], weights: [numbers; 2] },
            path: flags,
            skip: [PrimitiveId::NONE; LANES],
            beyond_skip: [PrimitiveId::NONE; LANES],
            keys: KeyLanes::default(),
            light_keys: KeyLanes::default(),
            vertices: Vertices {
                position: vectors,
                offset: numbers,
                beyond: vectors,
                beyond_offset: numbers,
                geometric_normal: vectors,
                shading_normal: vectors,
                base: vectors,
                roughness: numbers,
                wo: vectors,
                time: numbers,
                throughput: vectors,
                eta: numbers,
                plays: flags,
            },
            numbers: [numbers; MOST_NUMBERS],
            drawn: Drawn {
                select: [0.0; LANES],
                place: [numbers; 2],
                lobe: numbers,
                turn: [numbers; 2],
                roulette: numbers,
            },
            lights: LightSamples::NONE,
            shaped_lights: ShapedLights::NONE,
            near: Near::NONE,
            kept: Kept::NONE,
            onward: Onward {
                origin: vectors,
                direction: vectors,
                from_normal: vectors,
                density: numbers,
                discrete: flags,
                transmitted: flags,
                eta: numbers,
                throughput: vectors,
            },
        })
    }

    /// As they are, empty, for light samples of so many candidates.
    pub fn with_candidates(mut self: Box<Self>, candidates: u32) -> Box<Self> {
        self.candidates = candidates;
        self
    }

    /// Adds the vertex that path `path` has reached. The lanes must not be full.
    #[inline]
    pub fn push<B: LaneBsdf>(&mut self, paths: &Paths, path: usize, vertex: &SurfaceVertex, bsdf: B) {
        let (i, to) = (self.len, &mut self.vertices);
        to.position.set(i, vertex.position);
        to.offset[i] = vertex.offset;
        to.beyond.set(i, vertex.beyond);
        to.beyond_offset[i] = vertex.beyond_offset;
        to.geometric_normal.set(i, vertex.geometric_normal);
        to.shading_normal.set(i, vertex.shading_normal);
        to.base.set(i, vertex.base);
        to.roughness[i] = vertex.roughness;
        self.push_path(paths, path, vertex.wo, bsdf, [vertex.skip, vertex.beyond_skip]);
    }

    /// As [`Self::push`], a facet that path `path` has hit.
    #[inline]
    pub fn push_facet<B: LaneBsdf>(&mut self, paths: &Paths, path: usize, corners: &[Vec3; 3], bsdf: B) {
        let (i, hit) = (self.len, &paths.hits[path]);
        let [a, b, c] = &mut self.facets.corners;
        a.set(i, corners[0]);
        b.set(i, corners[1]);
        c.set(i, corners[2]);
        self.facets.weights[0][i] = hit.u;
        self.facets.weights[1][i] = hit.v;
        self.push_path(paths, path, -Vec3::from(paths.rays[path].direction), bsdf, [hit.id; 2]);
    }

    #[inline]
    fn push_path<B: LaneBsdf>(&mut self, paths: &Paths, path: usize, wo: Vec3, bsdf: B, skip: [PrimitiveId; 2]) {
        let (i, to, progress) = (self.len, &mut self.vertices, &paths.progress[path]);
        to.wo.set(i, wo);
        to.time[i] = paths.rays[path].time;
        to.throughput.set_spectrum(i, paths.throughput[path]);
        to.eta[i] = progress.eta;
        to.plays[i] = u32::from(progress.depth >= ROULETTE_FROM);
        bsdf.store(&mut self.numbers, i);
        self.keys.set(i, paths.samples[path].key, progress.vertex);
        self.path[i] = path as u32;
        [self.skip[i], self.beyond_skip[i]] = skip;
        self.len += 1;
    }

    /// True if no more can be pushed.
    #[inline]
    pub fn is_full(&self) -> bool {
        self.len == LANES
    }

    /// Takes what lanes there are through light samples and scattering, and empties them. All must have been pushed with a BSDF of
    /// this kind.
    pub fn finish<B: LaneBsdf>(
        &mut self,
        context: &Context,
        strategy: Strategy,
        paths: &mut Paths,
        shadows: &mut ShadowQueue,
    ) {
        if self.len == 0 {
            return;
        }
        let isa = context.scene.accelerator().isa();
        let gathers = strategy != Strategy::Bsdf && !B::IS_DELTA && !context.scene.lights().is_empty();
        if self.flat {
            run(isa, Place { lanes: self });
        }
        run(isa, Draw { lanes: self, sampler: context.sampler, lobes: B::CHOOSES_LOBE });
        if gathers {
            self.gather::<B>(context, strategy);
            self.send_light(shadows);
        }
        run(isa, Scatter::<B>::new(self));
        self.hand_back(context, paths);
        self.len = 0;
    }

    /// What light brings to the lanes.
    fn gather<B: LaneBsdf>(&mut self, context: &Context, strategy: Strategy) {
        let (isa, sampler, candidates) = (context.scene.accelerator().isa(), context.sampler, self.candidates);
        let selects = context.scene.lights().sole(self.transmits).is_none();
        for candidate in 0..candidates {
            run(isa, DrawLights { lanes: self, sampler, candidate, selects });
            self.choose_lights(context);
            self.sample_lights(context);
            run(isa, Gather::<B>::new(self, strategy == Strategy::Both));
            if candidates > 1 {
                run(isa, Keep { lanes: self, sampler, candidate });
            }
        }
        if candidates > 1 {
            run(isa, TakeKept { lanes: self });
        }
    }

    /// So many lanes that loops over them have whole vectors; those beyond the last vertex are idle.
    #[inline(always)]
    pub fn whole(&self) -> usize {
        self.len.next_multiple_of(16).min(LANES)
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
            let is_discrete = onward.discrete[i] != 0;
            let density = if is_discrete { Density::Discrete } else { Density::SolidAngle }(onward.density[i]);
            paths.throughput[path] = throughput;
            let (point, normal) = (self.vertices.position.get(i), onward.from_normal.get(i));
            let context_there = LightContext { point, normal, transmits: self.transmits, time: self.vertices.time[i] };
            paths.previous[path] = Previous { context: context_there, density };
            if context.scene.filters_textures() {
                paths.cones[path] = paths.cones[path].scattered(density);
            }
            let ray = &mut paths.rays[path];
            ray.origin = onward.origin.get(i).into();
            ray.direction = onward.direction.get(i).into();
            ray.skip = if onward.transmitted[i] != 0 { self.beyond_skip[i] } else { self.skip[i] };
            let progress = &mut paths.progress[path];
            progress.eta = onward.eta[i];
            progress.depth += 1;
            progress.vertex += 1;
        }
    }
}
