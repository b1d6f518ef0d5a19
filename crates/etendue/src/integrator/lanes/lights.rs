//! Light samples of lanes.
#![expect(clippy::needless_range_loop, reason = "an index is the lane, in several arrays at once")]

use super::{
    group::Lanes,
    numbers::{Numbers, Vectors},
};
use crate::{
    bsdf::{Density, LANES},
    integrator::wave::Context,
    light::{LightSample, RectangleFrame, Selected},
    math::{Vec3, vec3},
    spectrum::Spectrum,
};
use etendue_accel::{Kernel, run};

/// Fewest lanes for which a light's own vector code is run; fewer are sampled one by one.
const FEWEST: usize = 6;

const NO_LIGHT: u32 = u32::MAX;

/// Whether a lane has a light sample.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Lit {
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
pub(super) struct LightSamples {
    /// Index of the light, or [`NO_LIGHT`].
    index: [u32; LANES],
    probability: Numbers,
    /// A [`Lit`].
    pub lit: [u32; LANES],
    pub wi: Vectors,
    pub target: Vectors,
    /// 1 where there is a target, 0 where the light is infinitely far.
    pub has_target: [u32; LANES],
    pub radiance: Vectors,
    pub density: Numbers,
    /// What arrives if nothing is in between, and the shadow ray; 0 for none.
    pub contribution: Vectors,
    pub origin: Vectors,
    pub direction: Vectors,
}

impl LightSamples {
    pub const NONE: Self = Self {
        index: [NO_LIGHT; LANES],
        probability: [0.0; LANES],
        lit: [Lit::No as u32; LANES],
        wi: Vectors::ZERO,
        target: Vectors::ZERO,
        has_target: [0; LANES],
        radiance: Vectors::ZERO,
        density: [0.0; LANES],
        contribution: Vectors::ZERO,
        origin: Vectors::ZERO,
        direction: Vectors::ZERO,
    };
}

impl Lanes {
    pub fn choose_lights(&mut self, context: &Context) {
        let lights = context.scene.lights();
        for i in 0..self.len {
            let chosen = lights.select(&self.vertices.light_context(i, self.transmits), self.drawn.select[i]);
            let to = &mut self.lights;
            to.index[i] = chosen.map_or(NO_LIGHT, |chosen| chosen.index);
            to.probability[i] = chosen.map_or(0.0, |chosen| chosen.probability);
            to.lit[i] = if chosen.is_some() { Lit::Ask } else { Lit::No } as u32;
        }
    }

    pub fn sample_lights(&mut self, context: &Context) {
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
        let at = self.vertices.light_context(i, self.transmits);
        let place = [self.drawn.place[0][i], self.drawn.place[1][i]];
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
}

/// Samples of one rectangle for the lanes that chose it.
struct Rectangle<'a> {
    lanes: &'a mut Lanes,
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
        let transmits = self.lanes.transmits;
        let Lanes { lights, vertices, drawn, .. } = self.lanes;
        for i in 0..n {
            let view = frame.view(&vertices.light_context(i, transmits));
            let point = frame.sample(&view, [drawn.place[0][i], drawn.place[1][i]]);
            let is_valid = point.is_valid & (point.density * lights.probability[i] > 0.0);
            let found = if is_valid { Lit::Continuous as u32 } else { Lit::No as u32 };
            let found = if view.has_map() { found } else { Lit::Ask as u32 };
            let found = if view.is_seen { found } else { Lit::No as u32 };
            let own = lights.index[i] == chosen;
            let keep = |new: f32, old: f32| if own { new } else { old };
            let keep3 = |new: Vec3, old: Vec3| vec3(keep(new.x, old.x), keep(new.y, old.y), keep(new.z, old.z));
            lights.lit[i] = if own { found } else { lights.lit[i] };
            lights.has_target[i] = if own { 1 } else { lights.has_target[i] };
            lights.wi.set(i, keep3(point.wi, lights.wi.get(i)));
            lights.target.set(i, keep3(point.target, lights.target.get(i)));
            let density = point.density * lights.probability[i];
            lights.density[i] = keep(density, lights.density[i]);
            lights.radiance.set(i, keep3(radiance, lights.radiance.get(i)));
        }
    }
}
