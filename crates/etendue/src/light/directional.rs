//! Parallel light from infinity.

use super::{Emitter, LightContext, LightSample, environment, is_unit};
use crate::{bsdf::Density, math::Vec3, spectrum::Spectrum};

/// Parallel light: one discrete direction, the same everywhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DirectionalLight {
    /// Where the light travels to, unit length.
    pub direction: Vec3,
    /// W m^-2 on a plane that faces it.
    pub irradiance: Spectrum,
}

impl Emitter for DirectionalLight {
    #[inline]
    fn radiance(&self) -> Spectrum {
        self.irradiance
    }

    fn etendue(&self, scene_radius: f64) -> f64 {
        if is_unit(self.direction) { environment::cross_section(scene_radius) } else { 0.0 }
    }

    #[inline]
    fn sample(&self, _ctx: &LightContext, _u: [f32; 2]) -> Option<LightSample> {
        let (wi, radiance) = (-self.direction, self.irradiance);
        is_unit(wi).then_some(LightSample { wi, at: [0.0; 2], target: None, radiance, density: Density::Discrete(1.0) })
    }

    #[inline]
    fn pdf(&self, _ctx: &LightContext, _wi: Vec3, _distance: f32) -> f32 {
        0.0
    }
}
