//! The Phong family: diffuse and glossy reflection, diffuse and glossy transmission, without Fresnel's equations.
//!
//! Each of the four takes a constant share of the light:
//! - `Kd` is a Lambertian lobe;
//! - `Td` is one on the other side, f(wo, wi) / n_o^2 = Td / (pi n_dense^2) with n_dense the larger of the two indices: all
//!   of the share passes from the thinner medium to the denser; on the way back only n_thin^2 / n_dense^2 of it, since
//!   light that fills the hemisphere of the denser medium does not fit into that of the thinner;
//! - `Ks` is a lobe about the mirror direction, f = Ks (k + 2) / (2 pi) cos^k a with a the angle to that direction. This
//!   is the reciprocal form, whose albedo is Ks along the normal and never more (Lafortune and Willems, "Using the
//!   Modified Phong Reflectance Model for Physically Based Rendering", 1994); the density of its samples is
//!   (k + 1) / (2 pi) cos^k a. What would leave below the horizon is lost;
//! - `Ts` is the same lobe about the direction straight on, in the optically thinner of the two media, followed or
//!   preceded by ideal refraction into the denser one. So a path that leaves glass meets the lobe cos^k a about its
//!   refracted direction, and one that enters meets the reverse of that. Ideal refraction keeps n^2 cos(theta) domega, so
//!   with t the direction in the thinner medium that belongs to the one in the denser,
//!   f(wo, wi) / n_o^2 = Ts (k + 2) / (2 pi) cos^k a(t, thinner direction) / n_thin^2 is the same there and back.
//!   Where `wo` is beyond the critical angle, `Ts` is the lobe about the mirror direction, among the directions that are
//!   beyond it too.
//!
//! From an exponent of [`MIRROR_EXPONENT`] on a glossy lobe is a Dirac: a mirror, or clear refraction with total internal
//! reflection.

use super::{
    BsdfEval, BsdfSample, Scatter, fresnel,
    glass::{refracted_by_surface, relative_index},
    mirrored, on_side,
};
use crate::{
    math::{Frame, PI, Vec3},
    sampling::warp,
    spectrum::Spectrum,
};

/// Exponent from which on a glossy lobe is perfectly specular.
pub const MIRROR_EXPONENT: f32 = 1000.0;

/// A mixture of diffuse and glossy reflection and transmission, the same from both sides but for the index of refraction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Phong {
    diffuse: Spectrum,
    specular: Spectrum,
    diffuse_transmission: Spectrum,
    transmission: Spectrum,
    exponent: f32,
    transmission_exponent: f32,
    ior: f32,
    /// One over the sum of the lobes' mean albedos, or 0 if that is 0. A lobe's probability is its mean albedo times this.
    inverse_total: f32,
}

/// The shares and widths of [`Phong`]; `C` and `N` are what colours and numbers are, see
/// [`Scattering`](crate::material::Scattering).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongLobes<C = Spectrum, N = f32> {
    /// `Kd`, in [0, 1].
    pub diffuse: C,
    /// `Ks`, in [0, 1].
    pub specular: C,
    /// Exponent of `Ks`, >= 0.
    pub exponent: N,
    /// `Td`, in [0, 1].
    pub diffuse_transmission: C,
    /// `Ts`, in [0, 1].
    pub transmission: C,
    /// Exponent of `Ts`, >= 0.
    pub transmission_exponent: N,
    /// Index of refraction behind the surface (z < 0) over that before it.
    pub ior: N,
}

/// f cos_i and density of a lobe of albedo 1 at `cos_a` from its axis.
#[inline]
fn lobe(cos_a: f32, cos_i: f32, exponent: f32) -> (f32, f32) {
    let pdf = warp::cosine_power_hemisphere_pdf(cos_a, exponent);
    (pdf * ((exponent + 2.0) / (exponent + 1.0)) * cos_i, pdf)
}

/// A direction of the lobe about `axis`.
#[inline]
fn sample_lobe(axis: Vec3, exponent: f32, u: [f32; 2]) -> Vec3 {
    Frame::from_normal(axis).to_world(warp::cosine_power_hemisphere(u, exponent)).normalize()
}

/// True if a direction with this cosine sees total internal reflection.
#[inline]
fn is_total(cos: f32, eta: f32) -> bool {
    fresnel::dielectric(cos, eta).cos_t <= 0.0
}

impl Phong {
    /// Where the four shares sum to more than 1 in a channel, they are scaled down together in that channel.
    #[inline]
    pub fn new(lobes: &PhongLobes) -> Self {
        let PhongLobes { diffuse, specular, diffuse_transmission, transmission, .. } = *lobes;
        let scale = (diffuse + specular + diffuse_transmission + transmission).map(|sum| 1.0 / sum.max(1.0));
        let scaled = [diffuse, specular, diffuse_transmission, transmission].map(|share| share * scale);
        let total: f32 = scaled.iter().map(|share| share.mean()).sum();
        let [diffuse, specular, diffuse_transmission, transmission] = scaled;
        Self {
            diffuse,
            specular,
            diffuse_transmission,
            transmission,
            exponent: lobes.exponent,
            transmission_exponent: lobes.transmission_exponent,
            ior: lobes.ior,
            inverse_total: if total > 0.0 { 1.0 / total } else { 0.0 },
        }
    }

    /// Probability of a lobe.
    #[inline]
    fn probability(&self, albedo: Spectrum) -> f32 {
        albedo.mean() * self.inverse_total
    }

    /// `Ks` if its lobe is no mirror.
    #[inline]
    fn glossy(&self) -> Spectrum {
        if self.exponent < MIRROR_EXPONENT { self.specular } else { Spectrum::BLACK }
    }

    /// `Ts` if its lobe is no Dirac.
    #[inline]
    fn glossy_transmission(&self) -> Spectrum {
        if self.transmission_exponent < MIRROR_EXPONENT { self.transmission } else { Spectrum::BLACK }
    }

    /// Both directions with z > 0; `eta` the index beyond the surface over that on this side.
    #[inline]
    fn eval_reflection(&self, wo: Vec3, wi: Vec3, eta: f32) -> BsdfEval {
        let cosine = wi.z * (1.0 / PI);
        let mut value = self.diffuse * cosine;
        let mut pdf = self.probability(self.diffuse) * cosine;
        let cos_a = mirrored(wo).dot(wi);
        let glossy = self.glossy();
        if !glossy.is_black() {
            let (f, density) = lobe(cos_a, wi.z, self.exponent);
            value += glossy * f;
            pdf += self.probability(glossy) * density;
        }
        let transmission = self.glossy_transmission();
        if !transmission.is_black() && is_total(wo.z, eta) && is_total(wi.z, eta) {
            let (f, density) = lobe(cos_a, wi.z, self.transmission_exponent);
            value += transmission * f;
            pdf += self.probability(transmission) * density;
        }
        BsdfEval { value, pdf }
    }

    /// `wo` with z > 0, `wi` with z < 0.
    #[inline]
    fn eval_transmission(&self, wo: Vec3, wi: Vec3, eta: f32) -> BsdfEval {
        let (cos_i, inverse_eta2) = (-wi.z, 1.0 / (eta * eta));
        let cosine = cos_i * (1.0 / PI);
        let mut value = self.diffuse_transmission * (cosine * inverse_eta2.min(1.0));
        let mut pdf = self.probability(self.diffuse_transmission) * cosine;
        let transmission = self.glossy_transmission();
        if transmission.is_black() {
            return BsdfEval { value, pdf };
        }
        let (exponent, chosen) = (self.transmission_exponent, self.probability(transmission));
        if eta >= 1.0 {
            let cos_t = fresnel::dielectric(cos_i, 1.0 / eta).cos_t;
            if cos_t > 0.0 {
                let (f, density) = lobe(refracted_by_surface(wi, cos_t, 1.0 / eta).dot(wo), cos_i, exponent);
                value += transmission * f;
                pdf += chosen * density * (eta * eta) * (cos_i / cos_t);
            }
        } else {
            let cos_t = fresnel::dielectric(wo.z, eta).cos_t;
            if cos_t > 0.0 {
                let (f, density) = lobe(refracted_by_surface(wo, cos_t, eta).dot(wi), cos_i, exponent);
                value += transmission * (f * inverse_eta2);
                pdf += chosen * density;
            }
        }
        BsdfEval { value, pdf }
    }

    /// Both continuous sides; `wo` with z > 0.
    #[inline]
    fn eval_from_above(&self, wo: Vec3, wi: Vec3, eta: f32) -> BsdfEval {
        if wi.z > 0.0 {
            self.eval_reflection(wo, wi, eta)
        } else if wi.z < 0.0 {
            self.eval_transmission(wo, wi, eta)
        } else {
            BsdfEval::ZERO
        }
    }

    /// A direction of the glossy transmission lobe, which may be total internal reflection; `wo` with z > 0. `None` where
    /// it is lost.
    #[inline]
    fn sample_transmission(&self, wo: Vec3, eta: f32, u: [f32; 2]) -> Option<Vec3> {
        let exponent = self.transmission_exponent;
        if eta >= 1.0 {
            let thin = sample_lobe(wo, exponent, u);
            (thin.z > 0.0).then(|| refracted_by_surface(thin, fresnel::dielectric(thin.z, eta).cos_t, eta))
        } else {
            let cos_t = fresnel::dielectric(wo.z, eta).cos_t;
            if cos_t > 0.0 {
                Some(sample_lobe(refracted_by_surface(wo, cos_t, eta), exponent, u)).filter(|wi| wi.z < 0.0)
            } else {
                Some(sample_lobe(mirrored(wo), exponent, u)).filter(|wi| wi.z > 0.0 && is_total(wi.z, eta))
            }
        }
    }

    /// The lobes without extent, `rest` being what is left of `u_lobe` above the probabilities of the others.
    #[inline]
    fn sample_discrete(&self, wo: Vec3, eta: f32, rest: f32) -> Option<BsdfSample> {
        let cos_t = fresnel::dielectric(wo.z.abs(), eta).cos_t;
        let clear = self.transmission - self.glossy_transmission();
        let (reflection, refraction) = {
            let mirror = self.specular - self.glossy();
            if cos_t > 0.0 { (mirror, clear) } else { (mirror + clear, Spectrum::BLACK) }
        };
        let transmitted = rest >= self.probability(reflection);
        if transmitted {
            BsdfSample::refracted(refracted_by_surface(wo, cos_t, eta), refraction, self.probability(refraction), eta)
        } else {
            BsdfSample::reflected(mirrored(wo), reflection, self.probability(reflection))
        }
    }
}

impl Scatter for Phong {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        if wo.z == 0.0 {
            return BsdfEval::ZERO;
        }
        let side = 1.0f32.copysign(wo.z);
        self.eval_from_above(on_side(wo, side), on_side(wi, side), relative_index(self.ior, wo))
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if wo.z == 0.0 {
            return None;
        }
        let eta = relative_index(self.ior, wo);
        let side = 1.0f32.copysign(wo.z);
        let up = on_side(wo, side);
        let mut rest = u_lobe;
        let mut is_chosen = |albedo: Spectrum| {
            rest -= self.probability(albedo);
            rest < 0.0
        };
        let wi = if is_chosen(self.diffuse) {
            warp::cosine_hemisphere(u)
        } else if is_chosen(self.glossy()) {
            Some(sample_lobe(mirrored(up), self.exponent, u)).filter(|wi| wi.z > 0.0)?
        } else if is_chosen(self.diffuse_transmission) {
            on_side(warp::cosine_hemisphere(u), -1.0)
        } else if is_chosen(self.glossy_transmission()) {
            self.sample_transmission(up, eta, u)?
        } else {
            return self.sample_discrete(wo, eta, rest);
        };
        BsdfSample::continuous(on_side(wi, side), self.eval_from_above(up, wi, eta), wi.z < 0.0, eta)
    }

    #[inline]
    fn is_delta(&self) -> bool {
        let lobes = [self.diffuse, self.glossy(), self.diffuse_transmission, self.glossy_transmission()];
        lobes.iter().all(|lobe| lobe.is_black())
    }

    #[inline]
    fn transmits(&self) -> bool {
        !self.diffuse_transmission.is_black() || !self.glossy_transmission().is_black()
    }

    #[inline]
    fn albedo(&self) -> Spectrum {
        let passing = (self.ior * self.ior).min(1.0);
        self.diffuse + self.specular + self.diffuse_transmission * passing + self.transmission
    }
}
