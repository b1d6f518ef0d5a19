//! A conductor of GGX microfacets with exact Fresnel reflectance (Walter et al. 2007; Heitz 2014).

use super::{BsdfEval, BsdfSample, Density, Scatter, fresnel, ggx, ggx::Ggx, mirrored, on_side};
use crate::{math::Vec3, spectrum::Spectrum};

/// Reflects the same from both sides. Light that would leave a facet into another is lost (single scattering).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughMetal {
    eta: Spectrum,
    k: Spectrum,
    tint: Spectrum,
    /// `None`: smooth.
    ggx: Option<Ggx>,
}

impl RoughMetal {
    /// Index of refraction `eta + i k` per channel; GGX widths along x and y, both below [`ggx::ALPHA_MIN`] for a smooth
    /// metal; `tint` in [0, 1] multiplies the reflection.
    #[inline]
    pub fn new(eta: Spectrum, k: Spectrum, alpha: [f32; 2], tint: Spectrum) -> Self {
        Self { eta, k, tint, ggx: Ggx::new(alpha[0], alpha[1]) }
    }

    #[inline]
    fn reflectance(&self, cos: f32) -> Spectrum {
        fresnel::conductor(cos, self.eta, self.k) * self.tint
    }
}

impl Scatter for RoughMetal {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let side = 1.0f32.copysign(wo.z);
        let (wo, wi) = (on_side(wo, side), on_side(wi, side));
        let (Some(ggx), true) = (self.ggx, wo.z > 0.0 && wi.z > 0.0) else {
            return BsdfEval::ZERO;
        };
        let Some(m) = ggx::half_vector(wo, wi) else {
            return BsdfEval::ZERO;
        };
        let (value, pdf) = ggx.bounded_reflection(wo, wi, m);
        BsdfEval { value: self.reflectance(wo.dot(m)) * value, pdf }
    }

    #[inline]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let Some(ggx) = self.ggx else {
            return Some(BsdfSample {
                wi: mirrored(wo),
                weight: self.reflectance(wo.z.abs()),
                density: Density::Discrete(1.0),
                transmitted: false,
                eta: 1.0,
            });
        };
        let side = 1.0f32.copysign(wo.z);
        let wo = on_side(wo, side);
        let wi = ggx::reflected(wo, ggx.sample_bounded(wo, u));
        if wi.z <= 0.0 {
            return None;
        }
        let m = ggx::half_vector(wo, wi)?;
        let (_, pdf) = ggx.bounded_reflection(wo, wi, m);
        Some(BsdfSample {
            wi: on_side(wi, side),
            weight: self.reflectance(wo.dot(m)) * ggx.bounded_weight(wo, wi),
            density: Density::SolidAngle(pdf),
            transmitted: false,
            eta: 1.0,
        })
    }

    #[inline]
    fn is_delta(&self) -> bool {
        self.ggx.is_none()
    }

    #[inline]
    fn transmits(&self) -> bool {
        false
    }

    #[inline]
    fn albedo(&self) -> Spectrum {
        self.reflectance(1.0)
    }

    #[inline]
    fn is_anisotropic(&self) -> bool {
        self.ggx.is_some_and(|ggx| ggx.is_anisotropic())
    }
}
