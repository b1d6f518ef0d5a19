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
    BsdfEval, BsdfSample, Scatter, fresnel, ggx,
    ggx::Ggx,
    glass::{Glass, relative_index},
    lanes::{LaneBsdf, LaneSample, either, either_spectrum, either_vector, lane_numbers},
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

lane_numbers!(RoughGlass { ior: f32, reflection_tint: Spectrum, transmission_tint: Spectrum, ggx: Ggx });

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
    #[inline(always)]
    fn choice(&self, reflectance: f32) -> (f32, f32) {
        let r = reflectance * self.reflection_tint.mean();
        let t = (1.0 - reflectance) * self.transmission_tint.mean();
        (share(r, t), share(t, r))
    }

    /// `wo` with z > 0; reflection and refraction differ by few factors.
    #[inline(always)]
    fn eval_from_above(&self, wo: Vec3, wi: Vec3, eta: f32) -> BsdfEval {
        let reflects = wi.z > 0.0;
        let sum = wo + wi * either(reflects, 1.0, eta);
        let (m, exists) = ggx::unit(sum);
        let m = m * 1.0f32.copysign(m.z);
        let (cos_o, cos_i) = (wo.dot(m), -wi.dot(m));
        let reflectance = fresnel::dielectric(cos_o, eta).reflectance;
        let transmittance = fresnel::transmittance(cos_o, cos_i, eta);
        let (reflect, refract) = self.choice(reflectance);
        let beyond = on_side(wi, -1.0);
        let (density, masking) = (self.ggx.density(m), self.ggx.masking_over_cos(wo));

        let quarter = 0.25 * density;
        let glossy = reflectance * (quarter * wi.z * self.ggx.masking_shadowing_over_cosines(wo, wi));
        let reflection = BsdfEval { value: self.reflection_tint * glossy, pdf: reflect * (quarter * masking) };

        let visible = masking * density * cos_o * cos_i / sum.length_squared();
        let value = self.transmission_tint * (transmittance * visible * self.ggx.masking(beyond));
        let refraction = BsdfEval { value, pdf: refract * visible * (eta * eta) };
        // The two directions must lie on opposite sides of the facet, each on that side of the surface.
        let faces = (wi.z < 0.0) & (cos_o > 0.0) & (cos_i > 0.0) & (m.z > 0.0);
        let value = either_spectrum(reflects, reflection.value, refraction.value);
        BsdfEval { value, pdf: either(reflects, reflection.pdf, refraction.pdf) }.only_if(exists & (reflects | faces))
    }
}

impl LaneBsdf for RoughGlass {
    const IS_DELTA: bool = false;
    const TRANSMITS: bool = true;
    const CHOOSES_LOBE: bool = true;

    #[inline(always)]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let eta = relative_index(self.ior, wo);
        let side = 1.0f32.copysign(wo.z);
        self.eval_from_above(on_side(wo, side), on_side(wi, side), eta).only_if(wo.z != 0.0)
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> LaneSample {
        let eta = relative_index(self.ior, wo);
        let side = 1.0f32.copysign(wo.z);
        let is_seen = wo.z != 0.0;
        let wo = on_side(wo, side);
        let m = self.ggx.sample_visible(wo, u);
        let cos_o = wo.dot(m);
        let interface = fresnel::dielectric(cos_o, eta);
        let (reflect, refract) = self.choice(interface.reflectance);
        let transmitted = u_lobe >= reflect;
        let below = fresnel::refracted(wo, m, cos_o, interface.cos_t, eta);
        let wi = either_vector(transmitted, below, ggx::reflected(wo, m));

        let shadowing = self.ggx.masking(on_side(wi, -1.0));
        let through = (1.0 - interface.reflectance) * shadowing / (refract * eta * eta);
        let back = interface.reflectance * self.ggx.reflection_weight(wo, wi) / reflect;
        let tint = either_spectrum(transmitted, self.transmission_tint, self.reflection_tint);
        let density = self.eval_from_above(wo, wi, eta).pdf;
        let passes = (refract > 0.0) & (interface.cos_t > 0.0) & (wi.z < 0.0);
        LaneSample {
            wi: on_side(wi, side),
            weight: tint * either(transmitted, through, back),
            density,
            is_discrete: false,
            transmitted,
            eta: either(transmitted, eta, 1.0),
            is_valid: is_seen & (density > 0.0) & if transmitted { passes } else { wi.z > 0.0 },
        }
    }
}

impl Scatter for RoughGlass {
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
        true
    }

    #[inline]
    fn albedo(&self) -> Spectrum {
        let reflected = fresnel::dielectric(1.0, self.ior).reflectance;
        self.reflection_tint * reflected + self.transmission_tint * (1.0 - reflected)
    }
}
