//! A conductor of GGX microfacets with exact Fresnel reflectance (Walter et al. 2007; Heitz 2014).

use super::{
    BsdfEval, BsdfSample, Mirror, Scatter, fresnel, ggx,
    ggx::Ggx,
    lanes::{LaneBsdf, LaneSample, lane_numbers},
    on_side,
};
use crate::{math::Vec3, spectrum::Spectrum};

/// Reflects the same from both sides. Light that would leave a facet into another is lost (single scattering).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughMetal {
    eta: Spectrum,
    k: Spectrum,
    tint: Spectrum,
    ggx: Ggx,
}

lane_numbers!(RoughMetal { eta: Spectrum, k: Spectrum, tint: Spectrum, ggx: Ggx });

impl RoughMetal {
    /// Index of refraction `eta + i k` per channel; GGX widths along x and y; `tint` in [0, 1] multiplies the reflection. A
    /// mirror of that metal as the error where both widths are below [`ggx::ALPHA_MIN`].
    #[inline]
    pub fn new(eta: Spectrum, k: Spectrum, alpha: [f32; 2], tint: Spectrum) -> Result<Self, Mirror> {
        match Ggx::new(alpha[0], alpha[1]) {
            Some(ggx) => Ok(Self { eta, k, tint, ggx }),
            None => Err(Mirror::metal(eta, k, tint)),
        }
    }

    #[inline(always)]
    fn reflectance(&self, cos: f32) -> Spectrum {
        fresnel::conductor(cos, self.eta, self.k) * self.tint
    }
}

impl LaneBsdf for RoughMetal {
    const IS_DELTA: bool = false;
    const TRANSMITS: bool = false;
    const CHOOSES_LOBE: bool = false;

    #[inline(always)]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let side = 1.0f32.copysign(wo.z);
        let (wo, wi) = (on_side(wo, side), on_side(wi, side));
        let (m, exists) = ggx::half_vector(wo, wi);
        let (value, pdf) = self.ggx.bounded_reflection(wo, wi, m);
        BsdfEval { value: self.reflectance(wo.dot(m)) * value, pdf }.only_if(exists & (wo.z > 0.0) & (wi.z > 0.0))
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> LaneSample {
        let side = 1.0f32.copysign(wo.z);
        let wo = on_side(wo, side);
        let wi = ggx::reflected(wo, self.ggx.sample_bounded(wo, u));
        let (m, exists) = ggx::half_vector(wo, wi);
        let (_, density) = self.ggx.bounded_reflection(wo, wi, m);
        LaneSample {
            wi: on_side(wi, side),
            weight: self.reflectance(wo.dot(m)) * self.ggx.bounded_weight(wo, wi),
            density,
            is_discrete: false,
            transmitted: false,
            eta: 1.0,
            is_valid: exists & (wo.z != 0.0) & (wi.z > 0.0),
        }
    }
}

impl Scatter for RoughMetal {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        LaneBsdf::eval(self, wo, wi)
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        LaneBsdf::sample(self, wo, u_lobe, u).alone()
    }

    #[inline]
    fn is_delta(&self) -> bool {
        false
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
        self.ggx.is_anisotropic()
    }
}
