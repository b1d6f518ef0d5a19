//! Lights without extent that shine into a cone.

use super::{Emitter, LightContext, LightSample, PointLightSource, is_unit};
use crate::{math::Vec3, spectrum::Spectrum};
use std::f64::consts::PI;

/// A light without extent that shines into a cone: full intensity in the inner cone, none outside of the outer one, and
/// between them 3 t^2 - 2 t^3, t growing with the cosine of the angle off the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpotLight {
    /// Metres.
    pub position: Vec3,
    /// Where the cone points, unit length.
    pub axis: Vec3,
    /// Cosine of the outer cone's half angle, in [-1, 1).
    pub cos_outer: f32,
    /// Cosine of the inner cone's half angle, in [`cos_outer`, 1].
    pub cos_inner: f32,
    /// Radiant intensity on the axis, W/sr.
    pub intensity: Spectrum,
}

impl SpotLight {
    /// Share of the intensity at an angle off the axis, by its cosine.
    #[inline]
    fn falloff(&self, cos: f32) -> f32 {
        if cos >= self.cos_inner {
            return 1.0;
        }
        let t = (cos - self.cos_outer) / (self.cos_inner - self.cos_outer);
        if t > 0.0 { t * t * (3.0 - 2.0 * t) } else { 0.0 }
    }
}

impl Emitter for SpotLight {
    #[inline]
    fn radiance(&self) -> Spectrum {
        self.intensity
    }

    /// Exact: the falloff's mean over the cosines between the cones is one half.
    fn etendue(&self, _scene_radius: f64) -> f64 {
        let (inner, outer) = (f64::from(self.cos_inner), f64::from(self.cos_outer));
        let usable = self.position.is_finite() && is_unit(self.axis) && (-1.0..=inner).contains(&outer);
        if usable && inner <= 1.0 { 2.0 * PI * (1.0 - 0.5 * (inner + outer)) } else { 0.0 }
    }

    #[inline]
    fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> Option<LightSample> {
        let bare = PointLightSource { position: self.position, intensity: self.intensity };
        let sample = bare.sample(ctx, u)?;
        let radiance = sample.radiance * self.falloff(-self.axis.dot(sample.wi));
        // Also false where the axis is not a number.
        (radiance.max_component() > 0.0 && radiance.is_finite()).then_some(LightSample { radiance, ..sample })
    }

    #[inline]
    fn pdf(&self, _ctx: &LightContext, _wi: Vec3, _distance: f32) -> f32 {
        0.0
    }
}
