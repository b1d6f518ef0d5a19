//! Light samples of lanes.

use super::{
    group::Lanes,
    numbers::{Numbers, Vectors},
};
use crate::{
    bsdf::{Density, LANES},
    integrator::wave::Context,
    light::{BallView, DrawnPoint, Light, LightSample, LightTable, Selected, TriangleView, sample_above},
    math::{Vec3, vec3},
    spectrum::Spectrum,
};
use etendue_accel::{Kernel, run};

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
    pub index: [u32; LANES],
    pub probability: Numbers,
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

/// Lights of a shape that lanes have chosen, each its own.
pub(super) struct ShapedLights {
    /// The corners of a triangle; the corner and the edges of a rectangle; the centre of a sphere, and its radius as x.
    pub shape: [Vectors; 3],
    /// A [`Kind`].
    pub kind: [u32; LANES],
    pub two_sided: [u32; LANES],
}

impl ShapedLights {
    pub const NONE: Self = Self { shape: [Vectors::ZERO; 3], kind: [Kind::Other as u32; LANES], two_sided: [0; LANES] };
}

/// Kinds of lights with vector code of their own.
#[derive(Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub(super) enum Kind {
    Other,
    Triangle,
    Rectangle,
    Sphere,
    Sky,
}

impl Lanes {
    pub fn choose_lights(&mut self, context: &Context) {
        let lights = context.scene.lights();
        let Some(sole) = lights.sole(self.transmits) else {
            run(context.scene.accelerator().isa(), Choose { lanes: self, lights });
            return;
        };
        let to = &mut self.lights;
        for i in 0..self.len {
            to.index[i] = sole.index;
            to.probability[i] = sole.probability;
            to.lit[i] = Lit::Ask as u32;
        }
    }

    pub fn sample_lights(&mut self, context: &Context) {
        let isa = context.scene.accelerator().isa();
        let [triangles, rectangles, spheres, skies] = self.look_at_lights(context);
        // Where only few want it, vector code costs more than it saves.
        let pays = |count: usize| count * 8 >= self.len;
        let [triangles, rectangles, spheres, skies] = [pays(triangles), pays(rectangles), pays(spheres), pays(skies)];
        if triangles {
            run(isa, Triangles { lanes: self });
        }
        if rectangles {
            self.sample_rectangles(context);
        }
        if spheres {
            run(isa, Spheres { lanes: self });
        }
        if skies {
            run(isa, Sky { lanes: self });
        }
        // Those of other kinds, and those for which a rectangle's map is not good enough.
        for i in 0..self.len {
            if self.lights.lit[i] == Lit::Ask as u32 {
                self.sample_light(context, i);
            }
        }
    }

    /// Fetches what is to be known of the chosen lights; how many are triangles, rectangles, spheres, and the sky.
    fn look_at_lights(&mut self, context: &Context) -> [usize; 4] {
        let mut counts = [0; 5];
        let (n, transmits) = (self.len, self.transmits);
        let Self { lights, shaped_lights: to, .. } = self;
        let sole = context.scene.lights().sole(transmits).and_then(|sole| context.scene.uniform_light(sole.index));
        if let Some(Light::Rectangle(light)) = sole
            && context.scene.uniform_rectangle(lights.index[0]).is_some()
        {
            // Its shape is known already.
            to.kind[..n].fill(Kind::Rectangle as u32);
            (0..n).for_each(|i| lights.radiance.set_spectrum(i, light.radiance));
            return [0, n, 0, 0];
        }
        for i in 0..n {
            let light = context.scene.uniform_light(lights.index[i]);
            let mut set = |shape: [Vec3; 3], two_sided: bool, radiance: Spectrum| {
                to.shape[0].set(i, shape[0]);
                to.shape[1].set(i, shape[1]);
                to.shape[2].set(i, shape[2]);
                to.two_sided[i] = u32::from(two_sided);
                lights.radiance.set_spectrum(i, radiance);
            };
            let kind = match light {
                Some(Light::Triangle(light)) => {
                    set(light.vertices, light.two_sided, light.radiance);
                    Kind::Triangle
                }
                Some(Light::Rectangle(light)) => {
                    set([light.corner, light.u, light.v], light.two_sided, light.radiance);
                    Kind::Rectangle
                }
                Some(Light::Sphere(light)) if !transmits && let Some(radius) = light.radius() => {
                    set([light.center, vec3(radius, 0.0, 0.0), Vec3::ZERO], light.two_sided, light.radiance);
                    Kind::Sphere
                }
                Some(Light::Environment(light)) if !transmits => {
                    lights.radiance.set_spectrum(i, light.radiance);
                    Kind::Sky
                }
                _ => Kind::Other,
            };
            to.kind[i] = kind as u32;
            counts[kind as usize] += 1;
        }
        [Kind::Triangle, Kind::Rectangle, Kind::Sphere, Kind::Sky].map(|kind| counts[kind as usize])
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

impl LightSamples {
    /// Takes a sample for lane `i`, if that is one of the light's `own`.
    #[inline(always)]
    pub fn take(&mut self, i: usize, own: bool, found: Lit, sample: &DrawnPoint, has_target: bool) {
        let keep = |new: f32, old: f32| if own { new } else { old };
        let keep3 = |new: Vec3, old: Vec3| vec3(keep(new.x, old.x), keep(new.y, old.y), keep(new.z, old.z));
        let density = sample.density * self.probability[i];
        let is_usable = sample.is_valid & (density > 0.0);
        let found = if (found as u32 == Lit::Continuous as u32) & !is_usable { Lit::No as u32 } else { found as u32 };
        self.lit[i] = if own { found } else { self.lit[i] };
        self.has_target[i] = if own { u32::from(has_target) } else { self.has_target[i] };
        self.wi.set(i, keep3(sample.wi, self.wi.get(i)));
        self.target.set(i, keep3(sample.target, self.target.get(i)));
        self.density[i] = keep(density, self.density[i]);
    }
}

/// The choice of lights.
struct Choose<'a> {
    lanes: &'a mut Lanes,
    lights: &'a LightTable,
}

impl Kernel for Choose<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (n, transmits) = (self.lanes.len, self.lanes.transmits);
        let Lanes { lights, vertices, drawn, .. } = self.lanes;
        for i in 0..n {
            let chosen = self.lights.select_here(&vertices.light_context(i, transmits), drawn.select[i]);
            lights.index[i] = chosen.map_or(NO_LIGHT, |chosen| chosen.index);
            lights.probability[i] = chosen.map_or(0.0, |chosen| chosen.probability);
            lights.lit[i] = if chosen.is_some() { Lit::Ask } else { Lit::No } as u32;
        }
    }
}

/// Samples of triangles, each lane's own.
struct Triangles<'a> {
    lanes: &'a mut Lanes,
}

impl Kernel for Triangles<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (n, transmits) = (self.lanes.whole(), self.lanes.transmits);
        let Lanes { lights, shaped_lights, vertices, drawn, .. } = self.lanes;
        for i in 0..n {
            let shape = [shaped_lights.shape[0].get(i), shaped_lights.shape[1].get(i), shaped_lights.shape[2].get(i)];
            let ctx = vertices.light_context(i, transmits);
            let view = TriangleView::new(shape, shaped_lights.two_sided[i] != 0, &ctx);
            let point = view.sample(&ctx, [drawn.place[0][i], drawn.place[1][i]]);
            let found = if view.is_seen { Lit::Continuous } else { Lit::No };
            lights.take(i, shaped_lights.kind[i] == Kind::Triangle as u32, found, &point, true);
        }
    }
}

/// Samples of spheres, each lane's own: those that are seen from outside, and whose middle is above the horizon.
struct Spheres<'a> {
    lanes: &'a mut Lanes,
}

impl Kernel for Spheres<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let Lanes { lights, shaped_lights, vertices, drawn, .. } = self.lanes;
        for i in 0..n {
            let ctx = vertices.light_context(i, false);
            let view = BallView::new(shaped_lights.shape[0].get(i), shaped_lights.shape[1].0[0][i], &ctx);
            let point = view.sample_up([drawn.place[0][i], drawn.place[1][i]]);
            let found = if view.is_usable & view.is_up() { Lit::Continuous } else { Lit::Ask };
            lights.take(i, shaped_lights.kind[i] == Kind::Sphere as u32, found, &point, true);
        }
    }
}

/// Directions to a sky that is the same all around, on the side of the view.
struct Sky<'a> {
    lanes: &'a mut Lanes,
}

impl Kernel for Sky<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let Lanes { lights, shaped_lights, vertices, drawn, .. } = self.lanes;
        for i in 0..n {
            let normal = vertices.light_context(i, false).normal;
            let (wi, density) = sample_above(normal, [drawn.place[0][i], drawn.place[1][i]]);
            let sample = DrawnPoint { wi, target: Vec3::ZERO, at: [0.0; 2], density, is_valid: density > 0.0 };
            lights.take(i, shaped_lights.kind[i] == Kind::Sky as u32, Lit::Continuous, &sample, false);
        }
    }
}
