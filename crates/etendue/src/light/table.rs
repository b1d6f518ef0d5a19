//! All lights of a scene, and the choice among them.

use super::{
    Light, LightCircle, LightContext, LightSample,
    carried::{Carrier, Carriers},
    extent::Extent,
    tree::{Gathers, LightTree, MAX_SOURCES, Selected, Source},
};
use crate::{bsdf::Density, math::Vec3, medium::Segment, sampling::Distribution1D, spectrum::Spectrum};

/// Most lights that a table takes.
pub const MAX_LIGHTS: usize = MAX_SOURCES;

/// So many lights that circles may meet are looked at one by one; among more one is chosen as for other surfaces.
const FEW: usize = 24;

/// Why a [`LightTable`] cannot be built.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LightTableError {
    /// More than [`MAX_LIGHTS`].
    #[error("{count} lights; at most {MAX_LIGHTS} can be sampled")]
    TooMany {
        /// How many there are.
        count: usize,
    },
    /// More than one light is all around.
    #[error("more than one environment")]
    SeveralEnvironments,
}

/// Lights with what their choice goes by, immutable. Lights are named by their index in the list that the table was built from.
///
/// Lights from infinity are chosen in proportion to their power ([`Light::power`]), and as one share: that of their power,
/// but at most one half if there are others, since it grows with the scene and would starve small lamps in a large one. Other
/// lights are chosen by what they may bring to the point that gathers. Lights without power are never chosen. An environment that
/// is the same in all directions is chosen by surfaces that reflect alone: what scatters to both sides or in a medium finds
/// it best by itself, and samples of it would be rays for nothing (Karlik et al., "MIS Compensation: Optimizing Sampling
/// Techniques in Multiple Importance Sampling", 2019).
#[derive(Clone, Debug, Default)]
pub struct LightTable {
    lights: Vec<Light>,
    /// The environment that is the same in all directions, if there is one, with the probability that it is chosen where it may
    /// be; the other shares are of the rest.
    even: Option<u32>,
    even_share: f32,
    /// Which other light from infinity, of `far`.
    selection: Distribution1D,
    far: Box<[u32]>,
    /// Probability that one of these is chosen.
    far_share: f32,
    tree: LightTree,
    carriers: Carriers,
    environment: Option<u32>,
    /// The lights with power that a circle may meet, if they are few.
    few: Option<Box<[u32]>>,
}

impl LightTable {
    /// `scene_radius` is the radius of a sphere about all geometry, in metres.
    ///
    /// # Errors
    /// [`LightTableError`] above [`MAX_LIGHTS`], or if there is more than one environment.
    pub fn new(lights: Vec<Light>, scene_radius: f64) -> Result<Self, LightTableError> {
        Self::with_carriers(lights, scene_radius, Vec::new())
    }

    /// As [`Self::new`], with what moves some of the lights, by ascending indices.
    pub(crate) fn with_carriers(
        lights: Vec<Light>,
        scene_radius: f64,
        carriers: Vec<Carrier>,
    ) -> Result<Self, LightTableError> {
        let carriers = Carriers::new(carriers);
        if lights.len() > MAX_LIGHTS {
            return Err(LightTableError::TooMany { count: lights.len() });
        }
        let environment = lights.iter().position(Light::is_environment);
        if lights.iter().filter(|light| light.is_environment()).count() > 1 {
            return Err(LightTableError::SeveralEnvironments);
        }
        let weights: Vec<f64> = lights.iter().map(|light| light.power(scene_radius)).collect();
        let is_even = |i: &usize| matches!(lights[*i], Light::Environment(_));
        let even = (0..lights.len()).find(|i| is_even(i) && weights[*i] > 0.0);
        let far = (0..lights.len()).filter(|i| lights[*i].is_infinite() && !is_even(i));
        let far: Box<[u32]> = far.map(|i| i as u32).collect();
        let far_weights: Vec<f64> = far.iter().map(|i| weights[*i as usize]).collect();
        // Powers are finite and not negative, so the number is all that can be wrong.
        let selection =
            Distribution1D::new(&far_weights).map_err(|_| LightTableError::TooMany { count: far_weights.len() })?;
        let sources = sources(&lights, &weights, &carriers);
        let near: f64 = sources.iter().map(|source| weights[source.index as usize]).sum();
        let (sky, suns) = (even.map_or(0.0, |i| weights[i]), far_weights.iter().sum::<f64>());
        // Of all light from infinity, and of it without the even sky.
        let even_share = if sky > 0.0 { far_share(sky + suns, near) * (sky / (sky + suns)) as f32 } else { 0.0 };
        let far_share = far_share(suns, near);
        let met = |light: &Light| {
            matches!(light, Light::Triangle(_) | Light::Rectangle(_) | Light::Disk(_) | Light::Sphere(_))
        };
        let candidates = (0..lights.len()).filter(|&i| met(&lights[i]) && weights[i] > 0.0).map(|i| i as u32);
        let candidates = candidates.filter(|&i| carriers.of(i).is_none());
        let few: Vec<u32> = candidates.take(FEW + 1).collect();
        let few = (few.len() <= FEW).then(|| few.into());
        let tree = LightTree::new(sources, lights.len());
        let environment = environment.map(|index| index as u32);
        let even = even.map(|index| index as u32);
        Ok(Self { lights, even, even_share, selection, far, far_share, tree, carriers, environment, few })
    }

    /// True for lights that move while the shutter is open.
    #[inline]
    pub fn is_carried(&self, index: u32) -> bool {
        self.carriers.of(index).is_some()
    }

    /// The lights, degenerate ones included; those that move, as they are in the middle of the exposure.
    #[inline]
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// True if there is no light that could be chosen.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.even.is_none() && self.tree.is_empty() && self.selection.is_empty()
    }

    /// True if light `index` may be chosen at some point.
    pub fn may_choose(&self, index: u32) -> bool {
        self.even == Some(index) || self.tree.holds(index) || self.far_probability(index) > 0.0
    }

    /// Probability that the even environment is chosen.
    #[inline(always)]
    fn even_probability(&self, ctx: &LightContext) -> f32 {
        if ctx.transmits || ctx.normal == Vec3::ZERO { 0.0 } else { self.even_share }
    }

    /// The index of the environment, if there is one.
    #[inline]
    pub fn environment(&self) -> Option<u32> {
        self.environment
    }

    /// Radiance that a ray along the unit vector `wi` meets when it leaves the scene; black without an environment.
    #[inline]
    pub fn environment_radiance(&self, wi: Vec3) -> Spectrum {
        self.environment.map_or(Spectrum::BLACK, |index| self.lights[index as usize].environment_radiance(wi))
    }

    /// Probability that [`LightTable::select`] chooses light `index`; 0 beyond the last.
    #[inline]
    pub fn probability(&self, ctx: &LightContext, index: u32) -> f32 {
        let even = self.even_probability(ctx);
        match self.lights.get(index as usize) {
            Some(Light::Environment(_)) => even,
            Some(light) if light.is_infinite() => (1.0 - even) * self.far_probability(index),
            Some(_) => (1.0 - even) * (1.0 - self.far_share) * self.tree.probability(ctx, index),
            None => 0.0,
        }
    }

    #[inline]
    fn far_probability(&self, index: u32) -> f32 {
        self.far.binary_search(&index).map_or(0.0, |at| self.far_share * self.selection.probability(at))
    }

    /// The light that [`LightTable::select`] chooses for every surface that light from below does not reach, or for all others, and
    /// whatever the number, if there is one.
    #[inline]
    pub(crate) fn sole(&self, transmits: bool) -> Option<Selected> {
        let certain = |index| Selected { index, probability: 1.0 };
        if self.even_share == 1.0 && !transmits {
            return self.even.map(certain);
        }
        if self.even_share > 0.0 || self.far_share > 0.0 { None } else { self.tree.only().map(certain) }
    }

    /// True if lights are so many that their choice goes by clusters of them.
    pub(crate) fn has_clusters(&self) -> bool {
        self.tree.has_clusters()
    }

    /// The light for the number `u` in [0, 1), of which 24 bits choose among eight lights: many lights need more. `None` where
    /// no light can bring anything.
    #[inline]
    pub fn select(&self, ctx: &LightContext, u: f64) -> Option<Selected> {
        self.select_here(ctx, u)
    }

    /// As [`LightTable::select`], inlined for kernels.
    #[inline(always)]
    pub(crate) fn select_here(&self, ctx: &LightContext, u: f64) -> Option<Selected> {
        let even = self.even_probability(ctx);
        if u < f64::from(even) {
            return Some(Selected { index: self.even?, probability: even });
        }
        let u = (u - f64::from(even)) / (1.0 - f64::from(even));
        let share = f64::from(self.far_share);
        if u < share {
            let choice = self.selection.choose((u / share) as f32)?;
            let probability = (1.0 - even) * (self.far_share * choice.probability);
            return Some(Selected { index: self.far[choice.index], probability });
        }
        self.select_near(ctx, (u - share) / (1.0 - share), (1.0 - even) * (1.0 - self.far_share))
    }

    #[inline(always)]
    fn select_near(&self, gathers: &impl Gathers, u: f64, share: f32) -> Option<Selected> {
        let selected = self.tree.select(gathers, u)?;
        Some(Selected { probability: share * selected.probability, ..selected })
    }

    /// A light at some place for all points of a segment, none of which is known yet: as [`LightTable::select`].
    #[inline]
    pub fn select_along(&self, segment: &Segment, u: f64) -> Option<Selected> {
        self.select_near(segment, u, 1.0)
    }

    /// Probability that [`LightTable::select_along`] chooses light `index`; 0 for light from infinity.
    #[inline]
    pub fn probability_along(&self, segment: &Segment, index: u32) -> f32 {
        self.tree.probability(segment, index)
    }

    /// A direction towards a light chosen with `u_select`, a number in [0, 1); `u` in [0, 1)^2 places it on the light.
    /// `None` if the light cannot be seen from the context (its whole surface facing away): an estimate of 0.
    #[inline]
    pub fn sample(&self, ctx: &LightContext, u_select: f64, u: [f32; 2]) -> Option<LightSample> {
        self.sample_chosen(ctx, self.select(ctx, u_select)?, u)
    }

    /// As [`LightTable::sample`], towards a light that has been chosen.
    #[inline]
    pub fn sample_chosen(&self, ctx: &LightContext, chosen: Selected, u: [f32; 2]) -> Option<LightSample> {
        let light = self.lights.get(chosen.index as usize)?;
        let sample = match self.carriers.of(chosen.index) {
            None => light.sample(ctx, u)?,
            Some(carrier) => {
                let (ctx, way) = carrier.seen_at_middle(ctx);
                way.back(light.sample(&ctx, u)?)
            }
        };
        let density = sample.density.chosen(chosen.probability);
        (density.value() > 0.0).then_some(LightSample { density, ..sample })
    }

    /// Density per solid angle with which [`LightTable::sample`] draws the unit vector `wi` towards light `light`, its
    /// choice included, given that a ray from the context along `wi` meets it at `distance` metres. 0 for discrete lights,
    /// for lights that are never chosen, and where `sample` gives `None`.
    #[inline]
    pub fn pdf_hit(&self, ctx: &LightContext, light: u32, wi: Vec3, distance: f32) -> f32 {
        let probability = self.probability(ctx, light);
        let Some(emitter) = self.lights.get(light as usize).filter(|_| probability > 0.0) else { return 0.0 };
        let density = match self.carriers.of(light) {
            None => emitter.pdf(ctx, wi, distance),
            Some(carrier) => {
                let (ctx, way) = carrier.seen_at_middle(ctx);
                emitter.pdf(&ctx, way.vector(wi), distance)
            }
        };
        probability * density
    }

    /// As [`LightTable::pdf_hit`], for a ray that leaves the scene; 0 without an environment.
    #[inline]
    pub fn pdf_environment(&self, ctx: &LightContext, wi: Vec3) -> f32 {
        self.environment.map_or(0.0, |index| self.pdf_hit(ctx, index, wi, f32::INFINITY))
    }
}

/// Lights along circles of directions. Few lights are chosen in proportion to the share of the lobe that they fill times their
/// mean radiance: what brushed metal would reflect of them without shadows.
impl LightTable {
    /// A direction of a circle towards a light, with its density per radian, and the light's index. `u_select` in [0, 1)
    /// chooses the light, the first number of `u` the angle. `None` where the circle meets no light, or not the chosen one: an
    /// estimate of 0.
    pub fn sample_circle(&self, circle: &LightCircle, u_select: f64, u: [f32; 2]) -> Option<(u32, LightSample)> {
        let Some(few) = &self.few else {
            let chosen = self.select(&circle.context(), u_select)?;
            return self.sample_arcs(circle, chosen.index, |_| f64::from(chosen.probability), u[0]);
        };
        let weights = self.weights(few, circle);
        let total: f64 = weights.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut left = u_select * total;
        let mut chosen = None;
        for (index, weight) in few.iter().zip(weights).filter(|(_, weight)| *weight > 0.0) {
            chosen = Some(*index);
            if left < weight {
                break;
            }
            left -= weight;
        }
        let index = chosen?;
        self.sample_arcs(circle, index, |mass| self.brightness(index) * mass / total, u[0])
    }

    /// A direction to light `index`, which `probability` has chosen, given how much of the lobe it fills.
    fn sample_arcs(
        &self,
        circle: &LightCircle,
        index: u32,
        probability: impl FnOnce(f64) -> f64,
        u: f32,
    ) -> Option<(u32, LightSample)> {
        // Carried lights are left to the lobe.
        let light = self.lights.get(index as usize).filter(|_| !self.is_carried(index))?;
        let arcs = light.arcs(circle);
        let mass = circle.mass(&arcs);
        if mass <= 0.0 {
            return None;
        }
        let phi = circle.sample(&arcs, mass, f64::from(u))?;
        let density = super::finite_density(probability(mass) * circle.density(phi) / mass)?;
        let reached = light.reach(circle, phi)?;
        let sample = LightSample {
            wi: circle.direction(phi).as_vec3().normalize(),
            target: Some(reached.target),
            at: reached.at,
            radiance: light.radiance(),
            density: Density::Arc(density),
        };
        Some((index, sample))
    }

    /// Density per radian with which [`Self::sample_circle`] draws the unit vector `wi` of the circle towards light `light`, given
    /// that a ray along it meets the light at `distance` metres; 0 where it never does.
    pub fn pdf_circle(&self, circle: &LightCircle, light: u32, wi: Vec3, distance: f32) -> f32 {
        let Some(emitter) = self.lights.get(light as usize).filter(|_| !self.is_carried(light)) else { return 0.0 };
        let (arcs, phi) = (emitter.arcs(circle), circle.angle(wi));
        if !arcs.contains(phi) || !emitter.is_nearest(&circle.context(), wi, distance) {
            return 0.0;
        }
        let mass = circle.mass(&arcs);
        if mass <= 0.0 {
            return 0.0;
        }
        let probability = match &self.few {
            None => f64::from(self.probability(&circle.context(), light)),
            Some(few) => self.brightness(light) * mass / self.weights(few, circle).iter().sum::<f64>(),
        };
        super::finite_density(probability * circle.density(phi) / mass).unwrap_or(0.0)
    }

    /// What a circle gets from each light without shadows, up to a factor.
    fn weights(&self, few: &[u32], circle: &LightCircle) -> [f64; FEW] {
        let mut weights = [0.0; FEW];
        for (weight, &index) in weights.iter_mut().zip(few) {
            *weight = self.brightness(index) * circle.mass(&self.lights[index as usize].arcs(circle));
        }
        weights
    }

    fn brightness(&self, index: u32) -> f64 {
        self.lights[index as usize].radiance().0.iter().map(|&c| f64::from(c)).sum()
    }
}

/// Share of the choices that light from infinity has, in whole multiples of 2^-12.
fn far_share(far: f64, near: f64) -> f32 {
    const STEPS: f64 = 4096.0;
    match (far > 0.0, near > 0.0) {
        (false, _) => 0.0,
        (true, false) => 1.0,
        (true, true) => ((far / (far + near)).min(0.5) * STEPS).round().max(1.0) as f32 / STEPS as f32,
    }
}

/// The lights at some place that have power.
fn sources(lights: &[Light], weights: &[f64], carriers: &Carriers) -> Vec<Source> {
    let shine = |i: &usize| weights[*i] > 0.0 && !lights[*i].is_infinite();
    let largest = (0..lights.len()).filter(shine).fold(0.0, |most: f64, i| most.max(weights[i]));
    // Scaled, so that no sum overflows; and none so dark that it vanishes.
    let power = |i: usize| ((weights[i] / largest).max(1e-24)) as f32;
    let extent = |i: usize| {
        let extent = Extent::of(&lights[i])?;
        Some(carriers.of(i as u32).map_or(extent, |carrier| carrier.widened(&extent)))
    };
    let source = |i| Some(Source { index: i as u32, power: power(i), extent: extent(i)? });
    (0..lights.len()).filter(shine).filter_map(source).collect()
}
