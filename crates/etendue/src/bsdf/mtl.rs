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
    lanes::{LaneBsdf, LaneSample, either, either_spectrum, either_vector, lane_numbers},
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
    /// False if the specular lobe is a mirror; its facets are then any.
    is_rough: bool,
    ggx: Ggx,
    /// One over the sum of the lobes' mean albedos, or 0 if that is 0. A lobe's probability is its mean albedo times this.
    inverse_total: f32,
}

lane_numbers!(Mtl {
    diffuse: Spectrum,
    specular: Spectrum,
    transmission: Spectrum,
    ior: f32,
    is_rough: bool,
    ggx: Ggx,
    inverse_total: f32,
});

impl Mtl {
    /// `Kd`, `Ks`, `Tf` >= 0; `alpha` the GGX width of the specular lobe, a mirror below [`ggx::ALPHA_MIN`]; `ior` > 0 the
    /// index behind the surface (z < 0) over that before it.
    #[inline]
    pub fn new(diffuse: Spectrum, specular: Spectrum, alpha: f32, transmission: Spectrum, ior: f32) -> Self {
        let scale = (diffuse + specular + transmission).map(|sum| 1.0 / sum.max(1.0));
        let (diffuse, specular, transmission) = (diffuse * scale, specular * scale, transmission * scale);
        let total = diffuse.mean() + specular.mean() + transmission.mean();
        let inverse_total = if total > 0.0 { 1.0 / total } else { 0.0 };
        let (is_rough, ggx) = Ggx::new(alpha, alpha).map_or((false, Ggx::WIDEST), |ggx| (true, ggx));
        Self { diffuse, specular, transmission, ior, is_rough, ggx, inverse_total }
    }

    /// Probability of a lobe.
    #[inline(always)]
    fn probability(&self, albedo: Spectrum) -> f32 {
        albedo.mean() * self.inverse_total
    }

    /// The albedo of GGX facets; none where the specular lobe is a mirror.
    #[inline(always)]
    fn glossy(&self) -> Spectrum {
        either_spectrum(self.is_rough, self.specular, Spectrum::BLACK)
    }

    /// Diffuse and glossy reflection; `wo` with z > 0.
    #[inline(always)]
    fn eval_continuous(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let cosine = wi.z * (1.0 / PI);
        let glossy = self.glossy();
        let (m, exists) = ggx::half_vector(wo, wi);
        let (f, density) = self.ggx.bounded_reflection(wo, wi, m);
        let is_there = exists & self.is_rough;
        let value = self.diffuse * cosine + glossy * either(is_there, f, 0.0);
        let pdf = self.probability(self.diffuse) * cosine + self.probability(glossy) * either(is_there, density, 0.0);
        BsdfEval { value, pdf }.only_if(wi.z > 0.0)
    }

    /// The lobes without extent, `rest` being what is left of the number that chose above the probabilities of the others. The
    /// mirror and the interface's reflection share one direction: one discrete lobe.
    #[inline(always)]
    fn sample_discrete(&self, wo: Vec3, rest: f32) -> LaneSample {
        let eta = relative_index(self.ior, wo);
        let interface = fresnel::dielectric(wo.z.abs(), eta);
        let reflection = self.specular - self.glossy() + self.transmission * interface.reflectance;
        let refraction = self.transmission * (1.0 - interface.reflectance);
        let (reflect, refract) = (self.probability(reflection), self.probability(refraction));
        let transmitted = rest >= reflect;
        let sample = LaneSample::discrete(
            either_vector(transmitted, refracted_by_surface(wo, interface.cos_t, eta), mirrored(wo)),
            either_spectrum(transmitted, refraction / (eta * eta), reflection),
            either(transmitted, refract, reflect),
        );
        LaneSample { transmitted, eta: either(transmitted, eta, 1.0), ..sample }
    }
}

impl LaneBsdf for Mtl {
    const IS_DELTA: bool = false;
    const TRANSMITS: bool = false;
    const CHOOSES_LOBE: bool = true;

    #[inline(always)]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let side = 1.0f32.copysign(wo.z);
        self.eval_continuous(on_side(wo, side), on_side(wi, side)).only_if(wo.z != 0.0)
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> LaneSample {
        let up_to_diffuse = self.probability(self.diffuse);
        let up_to_glossy = up_to_diffuse + self.probability(self.glossy());
        let side = 1.0f32.copysign(wo.z);
        let up = on_side(wo, side);
        let glossy = ggx::reflected(up, self.ggx.sample_bounded(up, u));
        let wi = either_vector(u_lobe < up_to_diffuse, warp::cosine_hemisphere(u), glossy);
        let continuous = LaneSample::continuous(on_side(wi, side), self.eval_continuous(up, wi), wi.z > 0.0);
        let discrete = self.sample_discrete(wo, u_lobe - up_to_glossy);
        LaneSample::either(u_lobe >= up_to_glossy, discrete, continuous).only_if(wo.z != 0.0)
    }
}

impl Scatter for Mtl {
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
