//! What is done to lanes that only depends on their own numbers.
#![expect(clippy::needless_range_loop, reason = "an index is the lane, in several arrays at once")]

use super::{
    group::{Facets, Lanes},
    lights::Lit,
};
use crate::{
    bsdf::LaneBsdf,
    integrator::{
        horizon::shadowing,
        shade::{power_heuristic, survival},
    },
    math::{Frame, vec3},
    sampling::{Sampler, Slot},
    surface::{flat_point, leave},
};
use etendue_accel::Kernel;
use std::marker::PhantomData;

/// The points of facets.
pub(super) struct Place<'a> {
    pub lanes: &'a mut Lanes,
}

impl Kernel for Place<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let Lanes { facets: Facets { corners: [a, b, c], weights }, vertices, .. } = self.lanes;
        for i in 0..n {
            let corners = [a.get(i), b.get(i), c.get(i)];
            let (position, offset, normal) = flat_point(corners, weights[0][i], weights[1][i]);
            vertices.position.set(i, position);
            vertices.offset[i] = offset;
            vertices.beyond.set(i, position);
            vertices.beyond_offset[i] = offset;
            vertices.geometric_normal.set(i, normal);
            vertices.shading_normal.set(i, normal);
            vertices.base.set(i, normal);
        }
    }
}

/// The random numbers, but for those of light samples.
pub(super) struct Draw<'a> {
    pub lanes: &'a mut Lanes,
    pub sampler: Sampler,
    /// True if a lobe is chosen.
    pub lobes: bool,
}

impl Kernel for Draw<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let Lanes { keys, drawn, .. } = self.lanes;
        if self.lobes {
            self.sampler.one_d_lanes(keys, n, Slot::BsdfLobe, &mut drawn.lobe);
        }
        self.sampler.two_d_lanes(keys, n, Slot::BsdfDirection, &mut drawn.turn);
        self.sampler.one_d_lanes(keys, n, Slot::Roulette, &mut drawn.roulette);
    }
}

/// The random numbers of light samples.
pub(super) struct DrawLights<'a> {
    pub lanes: &'a mut Lanes,
    pub sampler: Sampler,
    /// Which of the lanes' candidates.
    pub candidate: u32,
    /// True if a light is chosen.
    pub selects: bool,
}

impl Kernel for DrawLights<'_> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let (n, candidates) = (self.lanes.whole(), self.lanes.candidates);
        let Lanes { keys, light_keys, drawn, .. } = self.lanes;
        light_keys.set_parts(n, keys, self.candidate, candidates);
        if self.selects {
            self.sampler.fine_lanes(light_keys, n, Slot::LightSelect, &mut drawn.select);
        }
        self.sampler.two_d_lanes(light_keys, n, Slot::LightPosition, &mut drawn.place);
    }
}

/// What the light samples contribute, and their shadow rays.
pub(super) struct Gather<'a, B> {
    lanes: &'a mut Lanes,
    both: bool,
    kind: PhantomData<B>,
}

impl<'a, B> Gather<'a, B> {
    /// `both`: BSDF samples count too.
    pub fn new(lanes: &'a mut Lanes, both: bool) -> Self {
        Self { lanes, both, kind: PhantomData }
    }
}

impl<B: LaneBsdf> Kernel for Gather<'_, B> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let Lanes { lights, vertices, numbers, .. } = self.lanes;
        for i in 0..n {
            let bsdf = B::load(&numbers[..B::NUMBERS], i);
            let frame = Frame::from_normal(vertices.shading_normal.get(i));
            let wi = lights.wi.get(i);
            let (local_wi, local_wo) = (frame.to_local(wi), frame.to_local(vertices.wo.get(i)));
            let is_reflected = local_wi.z * local_wo.z > 0.0;
            let above = wi.dot(vertices.base.get(i)) * local_wi.z > 0.0;
            let below = B::TRANSMITS & (wi.dot(vertices.geometric_normal.get(i)) * local_wi.z > 0.0);
            let arrives = if is_reflected { above } else { below };
            let arrives = arrives & (lights.lit[i] >= Lit::Continuous as u32);
            let shadowing =
                if is_reflected { shadowing(wi.dot(vertices.base.get(i)), vertices.roughness[i]) } else { 1.0 };
            let eval = bsdf.eval(local_wo, local_wi);
            let own = lights.density[i];
            let shared = self.both & (lights.lit[i] == Lit::Continuous as u32);
            let heuristic = power_heuristic(own, eval.pdf);
            let weight = if shared { heuristic } else { 1.0 } / own;
            let contribution =
                vertices.throughput.spectrum(i) * eval.value * lights.radiance.spectrum(i) * (weight * shadowing);
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
pub(super) struct Scatter<'a, B> {
    lanes: &'a mut Lanes,
    kind: PhantomData<B>,
}

impl<'a, B> Scatter<'a, B> {
    pub fn new(lanes: &'a mut Lanes) -> Self {
        Self { lanes, kind: PhantomData }
    }
}

impl<B: LaneBsdf> Kernel for Scatter<'_, B> {
    type Output = ();

    #[inline(always)]
    fn run(self) {
        let n = self.lanes.whole();
        let Lanes { vertices, numbers, drawn, onward, .. } = self.lanes;
        for i in 0..n {
            let bsdf = B::load(&numbers[..B::NUMBERS], i);
            let frame = Frame::from_normal(vertices.shading_normal.get(i));
            let local_wo = frame.to_local(vertices.wo.get(i));
            let sample = bsdf.sample(local_wo, drawn.lobe[i], [drawn.turn[0][i], drawn.turn[1][i]]);
            let wi = frame.to_world(sample.wi);
            let is_reflected = !sample.transmitted;
            let along_base = wi.dot(vertices.base.get(i));
            let above = along_base * sample.wi.z > 0.0;
            let below = wi.dot(vertices.geometric_normal.get(i)) * sample.wi.z > 0.0;
            let leaves = sample.is_valid & if is_reflected { above } else { below };
            let is_shadowed = is_reflected & !sample.is_discrete;
            let shadowing = if is_shadowed { shadowing(along_base, vertices.roughness[i]) } else { 1.0 };
            let throughput = vertices.throughput.spectrum(i) * sample.weight * shadowing;
            let eta = vertices.eta[i] * sample.eta;
            let survival = survival(throughput, eta);
            let plays = vertices.plays[i] != 0;
            let raise = if plays { 1.0 / survival } else { 1.0 };
            let lives = leaves & (!plays | (drawn.roulette[i] < survival));
            let throughput = throughput.map(|c| if lives { c * raise } else { 0.0 });
            onward.throughput.set_spectrum(i, throughput);
            onward.eta[i] = eta;
            onward.density[i] = sample.density;
            onward.discrete[i] = u32::from(sample.is_discrete);
            let near = leave(vertices.position.get(i), vertices.geometric_normal.get(i), vertices.offset[i], wi);
            let far = leave(vertices.beyond.get(i), vertices.geometric_normal.get(i), vertices.beyond_offset[i], wi);
            let from = |near: f32, far: f32| if is_reflected { near } else { far };
            onward.origin.set(i, vec3(from(near.x, far.x), from(near.y, far.y), from(near.z, far.z)));
            onward.transmitted[i] = u32::from(!is_reflected);
            onward.direction.set(i, wi.normalize());
            onward.from_normal.set(i, vertices.gathering_normal(i));
        }
    }
}
