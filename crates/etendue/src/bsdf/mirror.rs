//! Perfect specular reflection: of mirrors, and of polished metals.

use super::{
    BsdfEval, BsdfSample, Scatter, fresnel,
    lanes::{LaneBsdf, LaneSample, lane_numbers},
    mirrored,
};
use crate::{math::Vec3, spectrum::Spectrum};

/// Reflects the same from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    eta: Spectrum,
    k: Spectrum,
    tint: Spectrum,
}

lane_numbers!(Mirror { eta: Spectrum, k: Spectrum, tint: Spectrum });

impl Mirror {
    /// The same `reflectance`, in [0, 1], at every angle.
    #[inline]
    pub fn new(reflectance: Spectrum) -> Self {
        // A conductor whose index is imaginary reflects all, and in floating point too, exactly.
        Self::metal(Spectrum::BLACK, Spectrum::ONE, reflectance)
    }

    /// A metal with the index of refraction `eta + i k` per channel; `tint` in [0, 1] multiplies the reflection.
    #[inline]
    pub fn metal(eta: Spectrum, k: Spectrum, tint: Spectrum) -> Self {
        Self { eta, k, tint }
    }

    #[inline(always)]
    fn reflectance(&self, cos: f32) -> Spectrum {
        fresnel::conductor(cos, self.eta, self.k) * self.tint
    }
}

impl LaneBsdf for Mirror {
    const IS_DELTA: bool = true;
    const TRANSMITS: bool = false;
    const CHOOSES_LOBE: bool = false;

    #[inline(always)]
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> BsdfEval {
        BsdfEval::ZERO
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, _u_lobe: f32, _u: [f32; 2]) -> LaneSample {
        LaneSample::discrete(mirrored(wo), self.reflectance(wo.z.abs()), 1.0)
            .only_if((wo.z != 0.0) & !self.tint.is_black())
    }
}

impl Scatter for Mirror {
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
        true
    }

    #[inline]
    fn transmits(&self) -> bool {
        false
    }

    #[inline]
    fn albedo(&self) -> Spectrum {
        self.reflectance(1.0)
    }
}
