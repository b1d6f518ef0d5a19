//! What the keys of a Wavefront MTL file imply, made physical.
//!
//! The file format's own formula is Phong's, which neither conserves energy nor is reciprocal. Here each key is a share
//! of the light:
//! - `Kd` is reflected by a Lambertian lobe;
//! - `Ks` is reflected by a mirror, or by GGX facets whose width stands for `Ns`, with that reflectance at all angles;
//! - `Tf` meets a smooth dielectric interface of index `Ni`, which reflects or refracts it by Fresnel's formulas, total
//!   internal reflection included.
//!
//! Where the three sum to more than 1 in a channel, they are scaled down together in that channel. (`d`, the share of the
//! surface that is there at all, is [`Material::opacity`](crate::material::Material::opacity).)

use super::{
    BsdfEval, BsdfSample, Scatter, fresnel, ggx,
    ggx::Ggx,
    glass::{refracted_by_surface, relative_index},
    mirrored, on_side,
};
use crate::{
    math::{PI, Vec3},
    sampling::warp,
    spectrum::Spectrum,
};

/// A mixture of diffuse, specular and refracting lobes, the same from both sides but for the index of refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mtl {
    diffuse: Spectrum,
    specular: Spectrum,
    transmission: Spectrum,
    ior: f32,
    /// Of the specular lobe; `None` is a mirror.
    ggx: Option<Ggx>,
    /// One over the sum of the lobes' mean albedos, or 0 if that is 0. A lobe's probability is its mean albedo times this.
    inverse_total: f32,
}

impl Mtl {
    /// `Kd`, `Ks`, `Tf` >= 0; `alpha` the GGX width of the specular lobe, a mirror below [`ggx::ALPHA_MIN`]; `ior` > 0 the
    /// index behind the surface (z < 0) over that before it.
    #[inline]
    pub fn new(diffuse: Spectrum, specular: Spectrum, alpha: f32, transmission: Spectrum, ior: f32) -> Self {
        let scale = (diffuse + specular + transmission).map(|sum| 1.0 / sum.max(1.0));
        let (diffuse, specular, transmission) = (diffuse * scale, specular * scale, transmission * scale);
        let total = diffuse.mean() + specular.mean() + transmission.mean();
        let inverse_total = if total > 0.0 { 1.0 / total } else { 0.0 };
        Self { diffuse, specular, transmission, ior, ggx: Ggx::new(alpha, alpha), inverse_total }
    }

    /// Probability of a lobe.
    #[inline]
    fn probability(&self, albedo: Spectrum) -> f32 {
        albedo.mean() * self.inverse_total
    }

    /// The albedo of GGX facets; none where the specular lobe is a mirror.
    #[inline]
    fn glossy(&self) -> Spectrum {
        if self.ggx.is_some() { self.specular } else { Spectrum::BLACK }
    }

    /// Both directions with z > 0.
    #[inline]
    fn eval_continuous(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let cosine = wi.z * (1.0 / PI);
        let mut value = self.diffuse * cosine;
        let mut pdf = self.probability(self.diffuse) * cosine;
        if let Some(ggx) = self.ggx
            && !self.specular.is_black()
            && let (m, true) = ggx::half_vector(wo, wi)
        {
            let (glossy, glossy_pdf) = ggx.bounded_reflection(wo, wi, m);
            value += self.specular * glossy;
            pdf += self.probability(self.specular) * glossy_pdf;
        }
        BsdfEval { value, pdf }
    }

    /// A direction from the diffuse or the glossy lobe, weighted by both.
    #[inline]
    fn sample_continuous(&self, wo: Vec3, diffuse: bool, u: [f32; 2]) -> Option<BsdfSample> {
        let side = 1.0f32.copysign(wo.z);
        let wo = on_side(wo, side);
        let wi = if diffuse { warp::cosine_hemisphere(u) } else { ggx::reflected(wo, self.ggx?.sample_bounded(wo, u)) };
        if wi.z <= 0.0 {
            return None;
        }
        BsdfSample::continuous(on_side(wi, side), self.eval_continuous(wo, wi), false, 1.0)
    }
}

impl Scatter for Mtl {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let side = 1.0f32.copysign(wo.z);
        let (wo, wi) = (on_side(wo, side), on_side(wi, side));
        if wo.z > 0.0 && wi.z > 0.0 { self.eval_continuous(wo, wi) } else { BsdfEval::ZERO }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let up_to_diffuse = self.probability(self.diffuse);
        let up_to_glossy = up_to_diffuse + self.probability(self.glossy());
        if u_lobe < up_to_glossy {
            return self.sample_continuous(wo, u_lobe < up_to_diffuse, u);
        }
        // The mirror and the interface's reflection share one direction: one discrete lobe.
        let eta = relative_index(self.ior, wo);
        let interface = fresnel::dielectric(wo.z.abs(), eta);
        let reflection = self.specular - self.glossy() + self.transmission * interface.reflectance;
        let refraction = self.transmission * (1.0 - interface.reflectance);
        let transmitted = u_lobe >= up_to_glossy + self.probability(reflection);
        if transmitted {
            BsdfSample::refracted(
                refracted_by_surface(wo, interface.cos_t, eta),
                refraction,
                self.probability(refraction),
                eta,
            )
        } else {
            BsdfSample::reflected(mirrored(wo), reflection, self.probability(reflection))
        }
    }

    #[inline]
    fn is_delta(&self) -> bool {
        self.diffuse.is_black() && self.glossy().is_black()
    }

    #[inline]
    fn transmits(&self) -> bool {
        false
    }

    #[inline]
    fn albedo(&self) -> Spectrum {
        self.diffuse + self.specular + self.transmission
    }
}
