//! Perfect specular reflection.

use super::{BsdfEval, BsdfSample, Density, Scatter, mirrored};
use crate::{math::Vec3, spectrum::Spectrum};

/// Reflects the same share from every angle and from both sides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mirror {
    reflectance: Spectrum,
}

impl Mirror {
    /// `reflectance` in [0, 1].
    #[inline]
    pub fn new(reflectance: Spectrum) -> Self {
        Self { reflectance }
    }
}

impl Scatter for Mirror {
    #[inline]
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> BsdfEval {
        BsdfEval::ZERO
    }

    #[inline]
    fn sample(&self, wo: Vec3, _u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 || self.reflectance.is_black() {
            return None;
        }
        Some(BsdfSample {
            wi: mirrored(wo),
            weight: self.reflectance,
            density: Density::Discrete(1.0),
            transmitted: false,
            eta: 1.0,
        })
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
        self.reflectance
    }
}
