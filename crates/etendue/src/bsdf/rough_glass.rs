//! A dielectric interface of GGX microfacets (Walter et al., "Microfacet Models for Refraction through Rough Surfaces",
//! 2007), sampled by its visible normals.
//!
//! With m the facet's normal, eta the index on the side of `wi` over that on the side of `wo`, and radiance carried from
//! `wi` to `wo`, f cos_i is
//! - reflection: F D G2 / (4 z_o), G2 height-correlated;
//! - refraction: (1 - F) D G1(wo) G1(wi) |wo.m| |wi.m| / (z_o |wo + eta wi|^2), masking and shadowing being taken as
//!   independent on the two sides; m is along wo + eta wi, and its solid angle is eta^2 |wi.m| / |wo + eta wi|^2 times
//!   that of `wi`.

use super::{
    BsdfEval, BsdfSample, Density, Scatter, fresnel, ggx,
    ggx::Ggx,
    glass::{Glass, relative_index},
    on_side, share,
};
use crate::{math::Vec3, spectrum::Spectrum};

/// Refraction spreads light by some alpha times the change of index; below this spread it is treated as specular, because
/// the directions' own rounding would no longer be small against it.
const SPREAD_MIN: f32 = 1e-4;

/// GGX facets that reflect and refract. Light that would meet a second facet is lost (single scattering).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RoughGlass {
    ior: f32,
    reflection_tint: Spectrum,
    transmission_tint: Spectrum,
    ggx: Ggx,
}

impl RoughGlass {
    /// `ior` > 0 is the index behind the surface (z < 0) over that before it; GGX widths along x and y; tints in [0, 1].
    /// Smooth glass as the error where the widths are below [`ggx::ALPHA_MIN`], or `ior` so near 1 that even rough facets
    /// turn light by less than 1e-4 radians.
    #[inline]
    pub fn new(
        ior: f32,
        alpha: [f32; 2],
        reflection_tint: Spectrum,
        transmission_tint: Spectrum,
    ) -> Result<Self, Glass> {
        let spread = alpha[0].max(alpha[1]) * (ior - 1.0).abs().min((1.0 / ior - 1.0).abs());
        match Ggx::new(alpha[0], alpha[1]) {
            Some(ggx) if spread >= SPREAD_MIN => Ok(Self { ior, reflection_tint, transmission_tint, ggx }),
            _ => Err(Glass::new(ior, reflection_tint, transmission_tint, false)),
        }
    }

    /// Probabilities of reflection and refraction at a facet that reflects `reflectance`.
    #[inline]
    fn choice(&self, reflectance: f32) -> (f32, f32) {
        let r = reflectance * self.reflection_tint.mean();
        let t = (1.0 - reflectance) * self.transmission_tint.mean();
        (share(r, t), share(t, r))
    }

    /// Both directions with z > 0.
    #[inline]
    fn eval_reflection(&self, wo: Vec3, wi: Vec3, eta: f32) -> BsdfEval {
        let Some(m) = ggx::half_vector(wo, wi) else {
            return BsdfEval::ZERO;
        };
        let reflectance = fresnel::dielectric(wo.dot(m), eta).reflectance;
        let (value, pdf) = self.ggx.reflection(wo, wi, m);
        BsdfEval { value: self.reflection_tint * (reflectance * value), pdf: self.choice(reflectance).0 * pdf }
    }

    /// `wo` with z > 0, `wi` with z < 0.
    #[inline]
    fn eval_refraction(&self, wo: Vec3, wi: Vec3, eta: f32) -> BsdfEval {
        let sum = wo + wi * eta;
        let length2 = sum.length_squared();
        let Some(m) = sum.try_normalize() else {
            return BsdfEval::ZERO;
        };
        let m = if m.z < 0.0 { -m } else { m };
        let (cos_o, cos_i) = (wo.dot(m), -wi.dot(m));
        // The two directions must lie on opposite sides of the facet, each on that side of the surface.
        if cos_o <= 0.0 || cos_i <= 0.0 || m.z <= 0.0 {
            return BsdfEval::ZERO;
        }
        let reflectance = fresnel::dielectric(cos_o, eta).reflectance;
        let transmittance = fresnel::transmittance(cos_o, cos_i, eta);
        let visible = self.ggx.masking_over_cos(wo) * self.ggx.density(m) * cos_o * cos_i / length2;
        BsdfEval {
            value: self.transmission_tint * (transmittance * visible * self.ggx.masking(on_side(wi, -1.0))),
            pdf: self.choice(reflectance).1 * visible * (eta * eta),
        }
    }
}

impl Scatter for RoughGlass {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        if wo.z == 0.0 {
            return BsdfEval::ZERO;
        }
        let eta = relative_index(self.ior, wo);
        let side = 1.0f32.copysign(wo.z);
        let (wo, wi) = (on_side(wo, side), on_side(wi, side));
        if wi.z > 0.0 {
            self.eval_reflection(wo, wi, eta)
        } else if wi.z < 0.0 {
            self.eval_refraction(wo, wi, eta)
        } else {
            BsdfEval::ZERO
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let eta = relative_index(self.ior, wo);
        let side = 1.0f32.copysign(wo.z);
        let wo = on_side(wo, side);
        let m = self.ggx.sample_visible(wo, u);
        let cos_o = wo.dot(m);
        let interface = fresnel::dielectric(cos_o, eta);
        let (reflect, refract) = self.choice(interface.reflectance);
        let transmitted = u_lobe >= reflect;
        let (wi, weight, eta, eval) = if transmitted {
            if refract <= 0.0 || interface.cos_t <= 0.0 {
                return None;
            }
            let wi = fresnel::refracted(wo, m, cos_o, interface.cos_t, eta);
            if wi.z >= 0.0 {
                return None;
            }
            let shadowing = self.ggx.masking(on_side(wi, -1.0));
            let weight = self.transmission_tint * ((1.0 - interface.reflectance) * shadowing / (refract * eta * eta));
            (wi, weight, eta, self.eval_refraction(wo, wi, eta))
        } else {
            let wi = ggx::reflected(wo, m);
            if wi.z <= 0.0 {
                return None;
            }
            let weight = self.reflection_tint * (interface.reflectance * self.ggx.reflection_weight(wo, wi) / reflect);
            (wi, weight, 1.0, self.eval_reflection(wo, wi, eta))
        };
        (eval.pdf > 0.0).then(|| BsdfSample {
            wi: on_side(wi, side),
            weight,
            density: Density::SolidAngle(eval.pdf),
            transmitted,
            eta,
        })
    }

    #[inline]
    fn is_delta(&self) -> bool {
        false
    }

    #[inline]
    fn transmits(&self) -> bool {
        true
    }

    #[inline]
    fn albedo(&self) -> Spectrum {
        let reflected = fresnel::dielectric(1.0, self.ior).reflectance;
        self.reflection_tint * reflected + self.transmission_tint * (1.0 - reflected)
    }
}
