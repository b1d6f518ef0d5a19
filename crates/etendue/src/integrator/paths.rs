//! The state of the paths of a wave: a structure of arrays, kept dense.

use crate::{
    bsdf::Density,
    film::FirstHit,
    light::{LightCircle, LightContext},
    math::Vec3,
    medium::Segment,
    sampling::SampleKey,
    scene::BodyStack,
    spectrum::Spectrum,
    texture::RayCone,
};
use etendue_accel::{Hit, Ray};

/// The last vertex that scattered, as multiple importance sampling needs it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Previous {
    /// Where light was sampled.
    pub context: LightContext,
    /// Density with which the ray's direction was drawn; discrete for the camera.
    pub density: Density,
}

impl Previous {
    /// The camera: nothing else could have found what its ray finds.
    pub fn camera(point: Vec3, time: f32) -> Self {
        let context = LightContext { point, normal: Vec3::ZERO, transmits: false, time };
        Self { context, density: Density::Discrete(1.0) }
    }
}

/// The free flight that ended where a medium scattered the path last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flown {
    pub segment: Segment,
    /// Metres along the segment.
    pub distance: f32,
    /// See [`Flight::density`](crate::medium::Flight::density); 0 where the last vertex is on a surface or the camera.
    pub density: f32,
    /// Of the medium, 1/m.
    pub extinction: Spectrum,
}

impl Flown {
    /// No flight.
    pub const NONE: Self = Self {
        segment: Segment { origin: Vec3::ZERO, direction: Vec3::ZERO, length: 0.0 },
        distance: 0.0,
        density: 0.0,
        extinction: Spectrum::BLACK,
    };
}

/// Which sample a path is.
#[derive(Clone, Copy, Debug)]
pub(super) struct SampleId {
    pub key: SampleKey,
    /// Absolute pixel.
    pub pixel: [u32; 2],
    /// Sample index in the pixel.
    pub index: u32,
    /// Weight of the sample in the pixel; negative in the negative lobes of a filter.
    pub weight: f32,
    /// Which of the parts that the sample was split into; 0 for the first, or all of it.
    pub part: u32,
}

/// How far a path has come.
#[derive(Clone, Copy, Debug)]
pub(super) struct Progress {
    /// Path edges so far, the one being traced included.
    pub depth: u32,
    /// Vertex number for random dimensions; also counts vertices where the path passed straight through.
    pub vertex: u32,
    /// Index of refraction where the path is over that where it started, times the root of the number of parts that the sample was
    /// split into: the throughput times its square is what roulette goes by.
    pub eta: f32,
    /// False once nothing more can come.
    pub alive: bool,
    /// True until the sample is split: see [`each_part`](super::splitting::each_part).
    pub is_whole: bool,
}

macro_rules! structure_of_arrays {
    ($(#[$meta:meta])* $name:ident { $($field:ident: $kind:ty),* $(,)? }) => {
        $(#[$meta])*
        #[derive(Default)]
        pub(super) struct $name { $(pub $field: Vec<$kind>),* }

        impl $name {
            pub fn with_capacity(n: usize) -> Self {
                Self { $($field: Vec::with_capacity(n)),* }
            }

            fn duplicate(&mut self, index: usize) {
                $(if let Some(copy) = self.$field.get(index).copied() {
                    self.$field.push(copy);
                })*
            }

            pub fn swap_remove(&mut self, index: usize) {
                // Arrays that a scene has no use for stay empty.
                $(if !self.$field.is_empty() { self.$field.swap_remove(index); })*
            }
        }
    };
}

structure_of_arrays! {
    /// All paths of a wave; index i of every array is path i.
    Paths {
        rays: Ray,
        hits: Hit,
        samples: SampleId,
        throughput: Spectrum,
        radiance: Spectrum,
        previous: Previous,
        circles: LightCircle,
        progress: Progress,
        cones: RayCone,
        first: FirstHit,
        direct: Spectrum,
        bodies: BodyStack,
        flown: Flown,
    }
}

impl Paths {
    pub fn len(&self) -> usize {
        self.rays.len()
    }

    /// Adds a path that starts with `ray`. Records for layers are kept if `first` or `direct` says so, the same for all paths.
    pub fn push(&mut self, ray: Ray, cone: RayCone, sample: SampleId, first: bool, direct: bool) {
        self.rays.push(ray);
        self.hits.push(Hit::MISS);
        self.samples.push(sample);
        self.throughput.push(Spectrum::ONE);
        self.radiance.push(Spectrum::BLACK);
        self.previous.push(Previous::camera(Vec3::from(ray.origin), ray.time));
        if !self.circles.is_empty() {
            self.circles.push(LightCircle::default());
        }
        self.progress.push(Progress { depth: 1, vertex: 1, eta: 1.0, alive: true, is_whole: true });
        self.cones.push(cone);
        if first {
            self.first.push(FirstHit::default());
        }
        if direct {
            self.direct.push(Spectrum::BLACK);
        }
    }

    /// Leaves path `path` what one of so many parts has.
    pub fn split(&mut self, path: usize, parts: u32) {
        let progress = &mut self.progress[path];
        progress.is_whole = false;
        progress.eta *= (parts as f32).sqrt();
        self.throughput[path] *= 1.0 / parts as f32;
    }

    /// Adds a copy of path `path`, which has found nothing yet; its number.
    pub fn branch(&mut self, path: usize) -> usize {
        self.duplicate(path);
        let branch = self.len() - 1;
        self.radiance[branch] = Spectrum::BLACK;
        if let Some(direct) = self.direct.get_mut(branch) {
            *direct = Spectrum::BLACK;
        }
        branch
    }

    /// To be called after [`Self::push`] in a scene with media: the path starts inside of some bodies.
    pub fn push_bodies(&mut self, bodies: BodyStack) {
        self.bodies.push(bodies);
        self.flown.push(Flown::NONE);
    }

    /// Keeps the circle on which light was sampled at the vertex that path `path` is at.
    pub fn keep_circle(&mut self, path: usize, circle: LightCircle) {
        // Few scenes have any, so the array is there from the first on.
        if self.circles.is_empty() {
            self.circles.resize(self.len(), LightCircle::default());
        }
        self.circles[path] = circle;
    }

    /// What path `path` met first, if layers want it.
    pub fn first(&self, path: usize) -> FirstHit {
        self.first.get(path).copied().unwrap_or_default()
    }

    /// True if path `path`, which has found its last hit or miss, met anything that it did not pass straight through:
    /// a surface, or a medium that scattered it.
    pub fn met_something(&self, path: usize) -> bool {
        self.progress[path].depth > 1 || self.hits[path].is_hit()
    }

    /// Light on at most two edges of a path that has ended, if layers want it.
    pub fn direct(&self, path: usize) -> Spectrum {
        let Some(direct) = self.direct.get(path) else { return Spectrum::BLACK };
        if self.progress[path].depth == 1 { self.radiance[path] } else { *direct }
    }
}
