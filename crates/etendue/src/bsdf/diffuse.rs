//! Lambertian reflection and transmission.

use super::{BsdfEval, BsdfSample, Density, Scatter, lanes::Lambert, share};
use crate::{
    math::{PI, Vec3},
    sampling::warp,
    spectrum::Spectrum,
};

/// The same radiance in all directions of a side, from either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Diffuse {
    reflectance: Spectrum,
    transmittance: Spectrum,
    /// Probability of the reflecting lobe.
    reflect: f32,
    /// Probability of the transmitting lobe; both are 0 for black.
    transmit: f32,
}

impl Diffuse {
    /// Albedos of reflection and transmission, each >= 0, together at most 1.
    #[inline]
    pub fn new(reflectance: Spectrum, transmittance: Spectrum) -> Self {
        let (r, t) = (reflectance.mean(), transmittance.mean());
        Self { reflectance, transmittance, reflect: share(r, t), transmit: share(t, r) }
    }

    /// The form for lanes, if it reflects and does nothing else.
    #[inline]
    pub(super) fn lambert(&self) -> Option<Lambert> {
        let reflects_alone = self.transmittance.is_black() && !self.reflectance.is_black();
        reflects_alone.then_some(Lambert { albedo: self.reflectance })
    }
}

impl Scatter for Diffuse {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        if wo.z == 0.0 {
            return BsdfEval::ZERO;
        }
        let (albedo, chosen) = if (wo.z > 0.0) == (wi.z > 0.0) {
            (self.reflectance, self.reflect)
        } else {
            (self.transmittance, self.transmit)
        };
        let pdf = warp::cosine_hemisphere_pdf(wi.z.abs());
        BsdfEval { value: albedo * (wi.z.abs() * (1.0 / PI)), pdf: chosen * pdf }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        let transmitted = u_lobe >= self.reflect;
        let (albedo, chosen) =
            if transmitted { (self.transmittance, self.transmit) } else { (self.reflectance, self.reflect) };
        let local = warp::cosine_hemisphere(u);
        if wo.z == 0.0 || local.z <= 0.0 || chosen <= 0.0 {
            return None;
        }
        let up = (wo.z > 0.0) != transmitted;
        Some(BsdfSample {
            wi: Vec3::new(local.x, local.y, if up { local.z } else { -local.z }),
            weight: albedo / chosen,
            density: Density::SolidAngle(chosen * warp::cosine_hemisphere_pdf(local.z)),
            transmitted,
            eta: 1.0,
        })
    }

    #[inline]
    fn is_delta(&self) -> bool {
        self.reflectance.is_black() && self.transmittance.is_black()
    }

    #[inline]
    fn transmits(&self) -> bool {
        !self.transmittance.is_black()
    }

    #[inline]
    fn albedo(&self) -> Spectrum {
        self.reflectance + self.transmittance
    }
}
