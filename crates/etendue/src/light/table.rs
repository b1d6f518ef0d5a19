//! All lights of a scene, and the choice among them.

use super::{Light, LightCircle, LightContext, LightSample};
use crate::{bsdf::Density, math::Vec3, sampling::Distribution1D, spectrum::Spectrum};

/// Most lights that a table takes: leaves at least half of the probability to be dealt out by power.
pub const MAX_LIGHTS: usize = Distribution1D::MAX_LEN;

/// So many lights that circles may meet are looked at one by one; among more one is chosen by power.
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

/// Lights with their selection probabilities, immutable. Lights are named by their index in the list that the table was
/// built from.
///
/// A light is chosen in proportion to its power ([`Light::power`]). Lights at infinity share at most one half if there
/// are others: their power grows with the scene and would starve small lamps in a large one. Lights without power
/// are never chosen; any other has a probability of at least 2^-24.
#[derive(Clone, Debug, Default)]
pub struct LightTable {
    lights: Vec<Light>,
    /// Which light, by power.
    selection: Distribution1D,
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
        if lights.len() > MAX_LIGHTS {
            return Err(LightTableError::TooMany { count: lights.len() });
        }
        let environment = lights.iter().position(Light::is_environment);
        if lights.iter().filter(|light| light.is_environment()).count() > 1 {
            return Err(LightTableError::SeveralEnvironments);
        }
        let mut weights: Vec<f64> = lights.iter().map(|light| light.power(scene_radius)).collect();
        limit_infinite(&lights, &mut weights);
        // Powers are finite and not negative, so the number is all that can be wrong.
        let selection = Distribution1D::new(&weights).map_err(|_| LightTableError::TooMany { count: lights.len() })?;
        let met = |light: &Light| matches!(light, Light::Triangle(_) | Light::Rectangle(_) | Light::Sphere(_));
        let candidates = (0..lights.len()).filter(|&i| met(&lights[i]) && weights[i] > 0.0).map(|i| i as u32);
        let few: Vec<u32> = candidates.take(FEW + 1).collect();
        let few = (few.len() <= FEW).then(|| few.into());
        Ok(Self { lights, selection, environment: environment.map(|index| index as u32), few })
    }

    /// The lights, degenerate ones included.
    #[inline]
    pub fn lights(&self) -> &[Light] {
        &self.lights
    }

    /// True if there is no light that could be chosen.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.selection.is_empty()
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
    pub fn probability(&self, index: u32) -> f32 {
        self.selection.probability(index as usize)
    }

    /// The light for the number `u` in [0, 1), or `None` in an empty table.
    #[inline]
    pub fn select(&self, u: f32) -> Option<u32> {
        self.selection.choose(u).map(|choice| choice.index as u32)
    }

    /// A direction towards a light chosen with `u_select`, a number in [0, 1); `u` in [0, 1)^2 places it on the light.
    /// `None` if the light cannot be seen from the context (its whole surface facing away): an estimate of 0.
    #[inline]
    pub fn sample(&self, ctx: &LightContext, u_select: f32, u: [f32; 2]) -> Option<LightSample> {
        self.sample_chosen(ctx, self.select(u_select)?, u)
    }

    /// As [`LightTable::sample`], towards light `index`, which [`LightTable::select`] has chosen.
    #[inline]
    pub fn sample_chosen(&self, ctx: &LightContext, index: u32, u: [f32; 2]) -> Option<LightSample> {
        let probability = self.probability(index);
        let sample = self.lights.get(index as usize)?.sample(ctx, u)?;
        Some(LightSample { density: sample.density.chosen(probability), ..sample })
    }

    /// Density per solid angle with which [`LightTable::sample`] draws the unit vector `wi` towards light `light`, its
    /// choice included, given that a ray from the context along `wi` meets it at `distance` metres. 0 for discrete lights,
    /// for lights that are never chosen, and where `sample` gives `None`.
    #[inline]
    pub fn pdf_hit(&self, ctx: &LightContext, light: u32, wi: Vec3, distance: f32) -> f32 {
        let probability = self.probability(light);
        if probability > 0.0 { probability * self.lights[light as usize].pdf(ctx, wi, distance) } else { 0.0 }
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
    /// chooses the light, `u` in [0, 1)^2 the angle (its second number refines the choice). `None` where the circle meets
    /// no light, or not the chosen one: an estimate of 0.
    pub fn sample_circle(&self, circle: &LightCircle, u_select: f32, u: [f32; 2]) -> Option<(u32, LightSample)> {
        let Some(few) = &self.few else {
            let index = self.select(u_select)?;
            return self.sample_arcs(circle, index, |_| f64::from(self.probability(index)), u[0]);
        };
        let weights = self.weights(few, circle);
        let total: f64 = weights.iter().sum();
        if !(total > 0.0 && total.is_finite()) {
            return None;
        }
        let mut left = (f64::from(u_select) + f64::from(u[1]) / f64::from(1 << 24)) * total;
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
        let light = self.lights.get(index as usize)?;
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
        let Some(emitter) = self.lights.get(light as usize) else { return 0.0 };
        let (arcs, phi) = (emitter.arcs(circle), circle.angle(wi));
        if !arcs.contains(phi) || !emitter.is_nearest(&circle.context(), wi, distance) {
            return 0.0;
        }
        let mass = circle.mass(&arcs);
        if mass <= 0.0 {
            return 0.0;
        }
        let probability = match &self.few {
            None => f64::from(self.probability(light)),
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

/// Scales the weights of lights at infinity down to what all others have together, if there are others.
fn limit_infinite(lights: &[Light], weights: &mut [f64]) {
    let sum = |infinite: bool| -> f64 {
        lights.iter().zip(&*weights).filter(|(light, _)| light.is_infinite() == infinite).map(|(_, w)| w).sum()
    };
    let (near, far) = (sum(false), sum(true));
    if near > 0.0 && far > near {
        let scale = near / far;
        for (_, weight) in lights.iter().zip(weights).filter(|(light, _)| light.is_infinite()) {
            *weight *= scale;
        }
    }
}
