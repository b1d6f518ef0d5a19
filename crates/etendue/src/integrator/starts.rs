//! Where paths start: random numbers and camera rays of many samples at once.

use super::{
    enclosure::{bodies_about, bodies_along},
    paths::{Paths, SampleId},
    wave::Context,
};
use crate::{
    bsdf::LANES,
    camera::View,
    math::Vec3,
    sampling::{KeyLanes, SampleKey, Sampler, Slot},
    texture::RayCone,
};
use etendue_accel::{Kernel, PrimitiveId, Ray, run};

/// Samples whose paths start together.
pub(super) struct Starts {
    len: usize,
    /// Absolute pixel, sample index, and key.
    samples: [([u32; 2], u32, SampleKey); LANES],
    keys: KeyLanes<LANES>,
    /// Where in the pixel's filter, in [0, 1)^2.
    offsets: [[f32; LANES]; 2],
    /// Image coordinates, and the sample's weight.
    at: [[f32; LANES]; 2],
    weights: [f32; LANES],
    /// Shutter times.
    times: [f32; LANES],
    origin: [[f32; LANES]; 3],
    direction: [[f32; LANES]; 3],
    /// Width and spread.
    cone: [[f32; LANES]; 2],
}

/// The random numbers of samples.
struct Draw<'a> {
    starts: &'a mut Starts,
    sampler: Sampler,
}

impl Kernel for Draw<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let Starts { len, samples, keys, offsets, .. } = self.starts;
        for (i, (_, _, key)) in samples[..*len].iter().enumerate() {
            keys.set(i, *key, 0);
        }
        self.sampler.two_d_lanes(keys, *len, Slot::Pixel, offsets);
    }
}

/// The rays of a pinhole or parallel camera at rest.
struct Look<'a> {
    starts: &'a mut Starts,
    view: View,
}

impl Kernel for Look<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        // Told apart outside of the loop, which is vector code only then.
        if self.view.is_parallel() { self.look::<true>() } else { self.look::<false>() }
    }
}

impl Look<'_> {
    #[inline(always)]
    fn look<const PARALLEL: bool>(self) {
        let view = self.view.told(PARALLEL);
        let Starts { at: [x, y], origin, direction, cone, .. } = self.starts;
        for i in 0..LANES {
            let ray = view.ray(x[i], y[i], None);
            for axis in 0..3 {
                (origin[axis][i], direction[axis][i]) = (ray.origin[axis], ray.direction[axis]);
            }
            let RayCone { width, spread } = view.cone(ray.direction);
            (cone[0][i], cone[1][i]) = (width, spread);
        }
    }
}

impl Starts {
    pub fn new() -> Box<Self> {
        let (zero, plane, space) = ([0.0; LANES], [[0.0; LANES]; 2], [[0.0; LANES]; 3]);
        Box::new(Self {
            len: 0,
            samples: [Default::default(); LANES],
            keys: KeyLanes::default(),
            offsets: plane,
            at: plane,
            weights: zero,
            times: zero,
            origin: space,
            direction: space,
            cone: plane,
        })
    }

    /// Takes up to `most` samples, at most [`LANES`], and makes their camera rays. How many there were.
    pub fn draw(
        &mut self,
        context: &Context,
        samples: &mut dyn Iterator<Item = ([u32; 2], u32)>,
        most: usize,
    ) -> usize {
        self.len = 0;
        // Samples come pixel by pixel.
        let (mut of, mut keys) = ([0; 2], context.sampler.keys(context.seed, [0; 2]));
        for (pixel, index) in samples.take(most.min(LANES)) {
            if pixel != of {
                (of, keys) = (pixel, context.sampler.keys(context.seed, pixel));
            }
            self.samples[self.len] = (pixel, index, keys.key(index));
            self.len += 1;
        }
        let isa = context.scene.accelerator().isa();
        run(isa, Draw { starts: self, sampler: context.sampler });
        for i in 0..self.len {
            let (offset, weight) = context.filter.sample([self.offsets[0][i], self.offsets[1][i]]);
            let [x, y] = self.samples[i].0.map(|c| c as f32 + 0.5);
            (self.at[0][i], self.at[1][i], self.weights[i]) = (x + offset.x, y + offset.y, weight);
        }
        if context.camera.has_lens() || context.shutter.is_some() {
            self.look_through_lens(context);
        } else {
            run(isa, Look { starts: self, view: context.camera.view(0.0) });
        }
        self.len
    }

    /// One ray after the other.
    fn look_through_lens(&mut self, context: &Context) {
        let has_lens = context.camera.has_lens();
        for i in 0..self.len {
            let key = self.samples[i].2;
            let lens = if has_lens { context.sampler.two_d(key, 0, Slot::Lens) } else { [0.5, 0.5] };
            let time = context.shutter.map_or(0.0, |shutter| shutter.time(context.sampler.one_d(key, 0, Slot::Time)));
            let view = context.camera.view(time);
            let ray = context.camera.ray_in(&view, self.at[0][i], self.at[1][i], lens);
            let RayCone { width, spread } = view.cone(ray.direction);
            self.times[i] = time;
            (self.cone[0][i], self.cone[1][i]) = (width, spread);
            for axis in 0..3 {
                (self.origin[axis][i], self.direction[axis][i]) = (ray.origin[axis], ray.direction[axis]);
            }
        }
    }

    /// Adds the paths of the samples.
    pub fn push(&self, context: &Context, paths: &mut Paths) {
        let has_media = context.has_media();
        for i in 0..self.len {
            let (pixel, index, key) = self.samples[i];
            let time = self.times[i];
            let ray = Ray {
                origin: self.origin.each_ref().map(|row| row[i]),
                t_min: 0.0,
                direction: self.direction.each_ref().map(|row| row[i]),
                t_max: f32::INFINITY,
                time,
                mask: u32::MAX,
                skip: PrimitiveId::NONE,
            };
            let id = SampleId { key, pixel, index, weight: self.weights[i], part: 0 };
            let cone = RayCone { width: self.cone[0][i], spread: self.cone[1][i] };
            paths.push(ray, cone, id, context.wants_layers, context.wants_direct);
            if has_media {
                let start = context.camera.view(time).start();
                let bodies = match context.shutter {
                    None => context.camera_bodies,
                    Some(_) => bodies_about(context.scene, start, time),
                };
                paths.push_bodies(bodies_along(context.scene, &bodies, start, Vec3::from(ray.origin), time));
            }
        }
    }
}
