//! A smooth dielectric, as an interface or as a thin sheet.

use super::{
    BsdfEval, BsdfSample, Scatter, fresnel,
    lanes::{LaneBsdf, LaneSample, either, either_spectrum, either_vector, lane_numbers},
    mirrored, share,
};
use crate::{math::Vec3, spectrum::Spectrum};

/// Fresnel reflection and refraction, both discrete.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Glass {
    ior: f32,
    reflection_tint: Spectrum,
    transmission_tint: Spectrum,
    thin: bool,
}

lane_numbers!(Glass { ior: f32, reflection_tint: Spectrum, transmission_tint: Spectrum, thin: bool });

impl Glass {
    /// `ior` > 0 is the index behind the surface (z < 0) over that before it; of a thin sheet, its own over that of the
    /// medium around it. Tints in [0, 1].
    ///
    /// A thin sheet reflects to and fro between its two faces: R' = R + T R T + T R^3 T + ... = 2R / (1 + R), and lets
    /// the rest straight through.
    #[inline]
    pub fn new(ior: f32, reflection_tint: Spectrum, transmission_tint: Spectrum, thin: bool) -> Self {
        Self { ior, reflection_tint, transmission_tint, thin }
    }
}

/// Index beyond the surface over that on the side of `wo`.
#[inline(always)]
pub(super) fn relative_index(ior: f32, wo: Vec3) -> f32 {
    let inverse = 1.0 / ior;
    if wo.z > 0.0 { ior } else { inverse }
}

/// `wo` refracted by the surface itself. `cos_t` and `eta` as in [`fresnel`].
#[inline(always)]
pub(super) fn refracted_by_surface(wo: Vec3, cos_t: f32, eta: f32) -> Vec3 {
    Vec3::new(-wo.x / eta, -wo.y / eta, if wo.z > 0.0 { -cos_t } else { cos_t }).normalize()
}

impl LaneBsdf for Glass {
    const IS_DELTA: bool = true;
    const TRANSMITS: bool = false;
    const CHOOSES_LOBE: bool = true;

    #[inline(always)]
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> BsdfEval {
        BsdfEval::ZERO
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, u_lobe: f32, _u: [f32; 2]) -> LaneSample {
        let beyond = relative_index(self.ior, wo);
        let interface = fresnel::dielectric(wo.z.abs(), either(self.thin, self.ior, beyond));
        let one_face = interface.reflectance;
        let reflected = either(self.thin, 2.0 * one_face / (1.0 + one_face), one_face);
        let eta = either(self.thin, 1.0, beyond);
        let through = either_vector(self.thin, -wo, refracted_by_surface(wo, interface.cos_t, beyond));
        let reflection = self.reflection_tint * reflected;
        let transmission = self.transmission_tint * (1.0 - reflected);
        let (r, t) = (reflection.mean(), transmission.mean());
        let (reflect, refract) = (share(r, t), share(t, r));
        let transmitted = u_lobe >= reflect;
        let sample = LaneSample::discrete(
            either_vector(transmitted, through, mirrored(wo)),
            either_spectrum(transmitted, transmission / (eta * eta), reflection),
            either(transmitted, refract, reflect),
        );
        LaneSample { transmitted, eta: either(transmitted, eta, 1.0), ..sample }.only_if(wo.z != 0.0)
    }
}

impl Scatter for Glass {
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
        let one_face = fresnel::dielectric(1.0, self.ior).reflectance;
        let reflected = if self.thin { 2.0 * one_face / (1.0 + one_face) } else { one_face };
        self.reflection_tint * reflected + self.transmission_tint * (1.0 - reflected)
    }
}
