//! All lights of a scene, and the choice among them.

use super::{Light, LightContext, LightSample};
use crate::{bsdf::Density, math::Vec3, sampling::Distribution1D, spectrum::Spectrum};

/// Most lights that a table takes: leaves at least half of the probability to be dealt out by power.
pub const MAX_LIGHTS: usize = Distribution1D::MAX_LEN;

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
        Ok(Self { lights, selection, environment: environment.map(|index| index as u32) })
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
        let density = match sample.density {
            Density::SolidAngle(density) => Density::SolidAngle(density * probability),
            Density::Discrete(density) => Density::Discrete(density * probability),
        };
        Some(LightSample { density, ..sample })
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
