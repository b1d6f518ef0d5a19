//! A wave: some hundred paths of one worker that move through the stages together, each stage over slices.

use super::{
    Integrator,
    lanes::Groups,
    paths::{Paths, SampleId},
    shade::{self, Strategy},
    shadow::ShadowQueue,
    splitting::Splitting,
    starts::Starts,
    views,
};
use crate::{
    bsdf::LANES,
    camera::Camera,
    film::PathSample,
    math::Vec3,
    motion::Shutter,
    sampling::{FilterSampler, Sampler},
    scene::{BodyStack, Scene},
};

/// What all paths of a render share.
#[derive(Clone)]
pub(crate) struct Context<'a> {
    pub scene: &'a Scene,
    pub camera: &'a Camera,
    /// The bodies in which the middle of the plane lies where rays begin, if nothing moves.
    pub camera_bodies: BodyStack,
    /// How times are drawn; absent where nothing moves, and all is at time 0.
    pub shutter: Option<Shutter>,
    pub filter: &'a FilterSampler,
    pub sampler: Sampler,
    pub seed: u64,
    pub integrator: Integrator,
    pub max_depth: u32,
    pub wants_layers: bool,
    pub wants_direct: bool,
    /// Camera rays that meet nothing bring nothing home.
    pub transparent: bool,
    /// Light samples of first vertices are out of several candidates, if there are several lights.
    pub resamples: bool,
    pub splitting: Splitting,
}

impl Context<'_> {
    /// True if paths keep track of the bodies and media that they are in; views do not.
    pub fn has_media(&self) -> bool {
        self.scene.interiors().matter() && self.integrator.is_solver()
    }
}

/// Work done by a worker.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Counters {
    pub rays: u64,
    pub paths: u64,
    /// Paths that lay in more bodies than are told apart.
    pub overflowed: u64,
}

/// The buffers of one worker, allocated once.
pub(crate) struct Wave {
    capacity: usize,
    paths: Paths,
    /// Corners of the facets that paths have hit, where there are plain ones.
    corners: Vec<[[f32; 3]; 3]>,
    shadows: ShadowQueue,
    groups: Groups,
    starts: Box<Starts>,
}

impl Wave {
    pub fn new(capacity: usize) -> Self {
        Self {
            capacity,
            paths: Paths::with_capacity(capacity),
            corners: Vec::with_capacity(capacity),
            shadows: ShadowQueue::with_capacity(capacity),
            groups: Groups::new(),
            starts: Starts::new(),
        }
    }

    /// Traces all `samples` (absolute pixel, sample index), and hands what their parts bring home to `keep`.
    pub fn run(
        &mut self,
        context: &Context,
        samples: &mut dyn Iterator<Item = ([u32; 2], u32)>,
        keep: &mut impl FnMut([u32; 2], u32, &PathSample),
    ) -> Counters {
        let mut counters = Counters::default();
        loop {
            counters.paths += self.start_paths(context, samples);
            if self.paths.len() == 0 {
                return counters;
            }
            counters.rays += self.paths.len() as u64;
            self.trace(context);
            context.scene.prefetch_surfaces(&self.paths.hits);
            self.shade(context);
            counters.rays += self.shadows.trace(context.scene, &mut self.paths);
            counters.overflowed += self.retire(keep);
        }
    }

    /// Fills the wave with camera rays.
    fn start_paths(&mut self, context: &Context, samples: &mut dyn Iterator<Item = ([u32; 2], u32)>) -> u64 {
        let before = self.paths.len();
        while self.paths.len() < self.capacity {
            let most = (self.capacity - self.paths.len()).min(LANES);
            let started = self.starts.draw(context, samples, most);
            self.starts.push(context, &mut self.paths);
            if started < most {
                break;
            }
        }
        (self.paths.len() - before) as u64
    }

    fn trace(&mut self, context: &Context) {
        let Self { paths: Paths { rays, hits, .. }, corners, .. } = self;
        if !context.scene.has_plain_facets() {
            return context.scene.accelerator().closest_hits(rays, hits);
        }
        corners.resize(rays.len(), [[0.0; 3]; 3]);
        context.scene.accelerator().closest_facets(rays, hits, corners);
    }

    fn shade(&mut self, context: &Context) {
        let strategy = match context.integrator {
            Integrator::Path => Strategy::Both,
            Integrator::LightSplit => Strategy::Light,
            Integrator::Brute => Strategy::Bsdf,
            view => {
                for path in 0..self.paths.len() {
                    views::shade(context, view, &mut self.paths, path, &mut self.shadows);
                }
                return;
            }
        };
        if context.has_media() {
            self.shade_within_media(context, strategy);
            return;
        }
        for path in 0..self.paths.len() {
            let depth = self.paths.progress[path].depth;
            let Self { paths, shadows, groups, corners, .. } = self;
            let corners = corners.get(path).map(|corners| corners.map(Vec3::from));
            // Layers want more of the first surface than plain facets tell.
            let corners = corners.filter(|_| paths.hits[path].is_hit() && !shade::wants_first(context, paths, path));
            let is_taken =
                corners.is_some_and(|corners| groups.take_facet(context, strategy, paths, (path, &corners), shadows));
            if !is_taken {
                shade::shade::<false>(context, strategy, paths, path, shadows, groups);
            }
            if context.wants_direct && depth == 2 {
                // What the second edge found is in; light samples of its end are on their way, and longer.
                self.paths.direct[path] = self.paths.radiance[path];
            }
        }
        self.groups.finish(context, strategy, &mut self.paths, &mut self.shadows);
    }

    fn shade_within_media(&mut self, context: &Context, strategy: Strategy) {
        for path in 0..self.paths.len() {
            let depth = self.paths.progress[path].depth;
            let before = self.paths.radiance[path];
            shade::shade::<true>(context, strategy, &mut self.paths, path, &mut self.shadows, &mut self.groups);
            if context.wants_direct && depth <= 2 {
                // Edges in several media come in pieces, between which longer ways of light arrive.
                let found = self.paths.radiance[path] - before;
                self.paths.direct[path] += found;
            }
        }
    }

    /// Hands finished paths to the film and closes the gaps.
    /// Returns how many of them lay in more bodies than are told apart.
    fn retire(&mut self, keep: &mut impl FnMut([u32; 2], u32, &PathSample)) -> u64 {
        let (mut path, mut overflowed) = (0, 0);
        while path < self.paths.len() {
            if self.paths.progress[path].alive {
                path += 1;
                continue;
            }
            let SampleId { pixel, index, weight, part, .. } = self.paths.samples[path];
            let sample = PathSample {
                radiance: self.paths.radiance[path],
                direct: self.paths.direct(path),
                weight,
                met_surface: self.paths.met_something(path),
                first: self.paths.first(path),
                part,
            };
            keep(pixel, index, &sample);
            overflowed += u64::from(self.paths.bodies.get(path).is_some_and(|bodies| bodies.overflowed));
            self.paths.swap_remove(path);
        }
        overflowed
    }
}
