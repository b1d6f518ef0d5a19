//! Lights without extent.

use super::{Emitter, LightContext, LightSample};
use crate::{bsdf::Density, math::Vec3, spectrum::Spectrum};

/// A light without extent: one discrete direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLightSource {
    /// Metres.
    pub position: Vec3,
    /// Radiant intensity, W/sr, the same in all directions.
    pub intensity: Spectrum,
}

impl Emitter for PointLightSource {
    #[inline]
    fn radiance(&self) -> Spectrum {
        self.intensity
    }

    fn etendue(&self, _scene_radius: f64) -> f64 {
        if self.position.is_finite() { 4.0 * std::f64::consts::PI } else { 0.0 }
    }

    #[inline]
    fn sample(&self, ctx: &LightContext, _u: [f32; 2]) -> Option<LightSample> {
        let offset = self.position.as_dvec3() - ctx.point.as_dvec3();
        let square = offset.length_squared();
        let radiance = self.intensity.map(|c| (f64::from(c) / square) as f32);
        if !(square > 0.0 && square.is_finite() && radiance.is_finite()) {
            return None;
        }
        let wi = (offset / square.sqrt()).as_vec3();
        Some(LightSample { wi, at: [0.0; 2], target: Some(self.position), radiance, density: Density::Discrete(1.0) })
    }

    #[inline]
    fn pdf(&self, _ctx: &LightContext, _wi: Vec3, _distance: f32) -> f32 {
        0.0
    }
}
