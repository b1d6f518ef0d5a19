//! Lambertian reflection and transmission.

use super::{
    BsdfEval, BsdfSample, Scatter,
    lanes::{InLanes, LaneBsdf, LaneSample, either, either_spectrum, lane_numbers},
    on_side, share,
};
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

lane_numbers!(Diffuse { reflectance: Spectrum, transmittance: Spectrum, reflect: f32, transmit: f32 });

/// [`Diffuse`] that reflects something and transmits nothing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lambert {
    /// In [0, 1], not black.
    pub albedo: Spectrum,
}

lane_numbers!(Lambert { albedo: Spectrum });

impl Diffuse {
    /// Albedos of reflection and transmission, each >= 0, together at most 1.
    #[inline]
    pub fn new(reflectance: Spectrum, transmittance: Spectrum) -> Self {
        let (r, t) = (reflectance.mean(), transmittance.mean());
        Self { reflectance, transmittance, reflect: share(r, t), transmit: share(t, r) }
    }

    /// The form for lanes, of one that scatters something.
    #[inline]
    pub(super) fn in_lanes(self) -> InLanes {
        if self.transmittance.is_black() {
            InLanes::Lambert(Lambert { albedo: self.reflectance })
        } else {
            InLanes::Diffuse(self)
        }
    }
}

impl LaneBsdf for Lambert {
    const IS_DELTA: bool = false;
    const TRANSMITS: bool = false;
    const CHOOSES_LOBE: bool = false;

    #[inline(always)]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let cosine = wi.z.abs();
        let value = self.albedo * (cosine * (1.0 / PI));
        let is_lit = (wo.z != 0.0) & ((wo.z > 0.0) == (wi.z > 0.0));
        BsdfEval { value, pdf: warp::cosine_hemisphere_pdf(cosine) }.only_if(is_lit)
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> LaneSample {
        let local = warp::cosine_hemisphere(u);
        LaneSample {
            wi: Vec3::new(local.x, local.y, either(wo.z > 0.0, local.z, -local.z)),
            weight: self.albedo,
            density: warp::cosine_hemisphere_pdf(local.z),
            is_discrete: false,
            transmitted: false,
            eta: 1.0,
            is_valid: (wo.z != 0.0) & (local.z > 0.0),
        }
    }
}

impl LaneBsdf for Diffuse {
    const IS_DELTA: bool = false;
    const TRANSMITS: bool = true;
    const CHOOSES_LOBE: bool = true;

    #[inline(always)]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let reflects = (wo.z > 0.0) == (wi.z > 0.0);
        let albedo = either_spectrum(reflects, self.reflectance, self.transmittance);
        let chosen = either(reflects, self.reflect, self.transmit);
        let pdf = chosen * warp::cosine_hemisphere_pdf(wi.z.abs());
        BsdfEval { value: albedo * (wi.z.abs() * (1.0 / PI)), pdf }.only_if(wo.z != 0.0)
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> LaneSample {
        let transmitted = u_lobe >= self.reflect;
        let albedo = either_spectrum(transmitted, self.transmittance, self.reflectance);
        let chosen = either(transmitted, self.transmit, self.reflect);
        let local = warp::cosine_hemisphere(u);
        let side = 1.0f32.copysign(wo.z) * either(transmitted, -1.0, 1.0);
        LaneSample {
            wi: on_side(local, side),
            weight: albedo / chosen,
            density: chosen * warp::cosine_hemisphere_pdf(local.z),
            is_discrete: false,
            transmitted,
            eta: 1.0,
            is_valid: (wo.z != 0.0) & (local.z > 0.0) & (chosen > 0.0),
        }
    }
}

impl Scatter for Diffuse {
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
