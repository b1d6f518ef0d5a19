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
    lanes::{
        InLanes, LaneBsdf, LaneNumbers, LaneSample, Numbers, either, either_spectrum, either_vector, lane_numbers,
    },
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

lane_numbers!(Phong {
    diffuse: Spectrum,
    specular: Spectrum,
    diffuse_transmission: Spectrum,
    transmission: Spectrum,
    exponent: f32,
    transmission_exponent: f32,
    ior: f32,
    inverse_total: f32,
});

/// [`Phong`] whose continuous lobes are known to reflect only, or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhongInLanes<const TRANSMITS: bool>(Phong);

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
#[inline(always)]
fn lobe(cos_a: f32, cos_i: f32, exponent: f32) -> (f32, f32) {
    let pdf = warp::cosine_power_hemisphere_pdf(cos_a, exponent);
    (pdf * ((exponent + 2.0) / (exponent + 1.0)) * cos_i, pdf)
}

/// A direction of the lobe about `axis`.
#[inline(always)]
fn sample_lobe(axis: Vec3, exponent: f32, u: [f32; 2]) -> Vec3 {
    Frame::from_normal(axis).to_world(warp::cosine_power_hemisphere(u, exponent)).normalize()
}

/// A lobe among others, chosen by one number; if none of these, it is the diffuse one.
#[derive(Clone, Copy)]
struct Choice {
    glossy: bool,
    diffuse_transmission: bool,
    transmission: bool,
    /// What is left of the number above the probabilities of all; not negative if none of them was chosen.
    rest: f32,
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
    #[inline(always)]
    fn probability(&self, albedo: Spectrum) -> f32 {
        albedo.mean() * self.inverse_total
    }

    /// `Ks` if its lobe is no mirror.
    #[inline(always)]
    fn glossy(&self) -> Spectrum {
        either_spectrum(self.exponent < MIRROR_EXPONENT, self.specular, Spectrum::BLACK)
    }

    /// `Ts` if its lobe is no Dirac.
    #[inline(always)]
    fn glossy_transmission(&self) -> Spectrum {
        either_spectrum(self.transmission_exponent < MIRROR_EXPONENT, self.transmission, Spectrum::BLACK)
    }

    /// `Kd` and `Ks`; both directions with z > 0.
    #[inline(always)]
    fn eval_reflection(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let cosine = wi.z * (1.0 / PI);
        let glossy = self.glossy();
        let (f, density) = lobe(mirrored(wo).dot(wi), wi.z, self.exponent);
        let value = self.diffuse * cosine + glossy * f;
        BsdfEval { value, pdf: self.probability(self.diffuse) * cosine + self.probability(glossy) * density }
    }

    /// `Td`; `wo` with z > 0, `wi` with z < 0; `eta` the index beyond the surface over that on this side.
    #[inline(always)]
    fn eval_diffuse_transmission(&self, wi: Vec3, eta: f32) -> BsdfEval {
        let cosine = -wi.z * (1.0 / PI);
        let value = self.diffuse_transmission * (cosine * (1.0 / (eta * eta)).min(1.0));
        BsdfEval { value, pdf: self.probability(self.diffuse_transmission) * cosine }
    }

    /// `Ts`, total internal reflection included; `wo` with z > 0.
    #[inline(always)]
    fn eval_transmission(&self, wo: Vec3, wi: Vec3, eta: f32) -> BsdfEval {
        let (cos_i, reflects, to_denser) = (wi.z.abs(), wi.z > 0.0, eta >= 1.0);
        let inverse = 1.0 / eta;
        let beyond_o = fresnel::dielectric(wo.z, eta).cos_t;
        let beyond_i = fresnel::dielectric(cos_i, either(reflects, eta, inverse)).cos_t;
        // From the denser of the two media into the thinner, where the lobe is.
        let (dense, thin) = (either_vector(to_denser, wi, wo), either_vector(to_denser, wo, wi));
        let cos_t = either(to_denser, beyond_i, beyond_o);
        let refracted = refracted_by_surface(dense, cos_t, either(to_denser, inverse, eta));
        let cos_a = either(reflects, mirrored(wo).dot(wi), refracted.dot(thin));
        let is_total = (beyond_o <= 0.0) & (beyond_i <= 0.0);
        let exists = (reflects & is_total) | (!reflects & (cos_t > 0.0));

        let (f, density) = lobe(cos_a, cos_i, self.transmission_exponent);
        let squeezed = either(reflects | to_denser, 1.0, inverse * inverse);
        let spread = either(!reflects & to_denser, eta * eta * (cos_i / cos_t), 1.0);
        let glossy = self.glossy_transmission();
        let (value, pdf) = (glossy * (f * squeezed), self.probability(glossy) * density * spread);
        BsdfEval { value, pdf }.only_if(exists)
    }

    /// The lobe for `u`.
    #[inline(always)]
    fn choose(&self, u: f32) -> Choice {
        let after_diffuse = u - self.probability(self.diffuse);
        let after_glossy = after_diffuse - self.probability(self.glossy());
        let after_diffuse_transmission = after_glossy - self.probability(self.diffuse_transmission);
        let rest = after_diffuse_transmission - self.probability(self.glossy_transmission());
        Choice {
            glossy: (after_diffuse >= 0.0) & (after_glossy < 0.0),
            diffuse_transmission: (after_glossy >= 0.0) & (after_diffuse_transmission < 0.0),
            transmission: (after_diffuse_transmission >= 0.0) & (rest < 0.0),
            rest,
        }
    }

    /// The lobes without extent, `rest` being what is left of the number that chose above the probabilities of the others.
    #[inline(always)]
    fn sample_discrete(&self, wo: Vec3, eta: f32, rest: f32) -> LaneSample {
        let cos_t = fresnel::dielectric(wo.z.abs(), eta).cos_t;
        let clear = self.transmission - self.glossy_transmission();
        let mirror = self.specular - self.glossy();
        let is_total = cos_t <= 0.0;
        let reflection = either_spectrum(is_total, mirror + clear, mirror);
        let refraction = either_spectrum(is_total, Spectrum::BLACK, clear);
        let (reflect, refract) = (self.probability(reflection), self.probability(refraction));
        let transmitted = rest >= reflect;
        let sample = LaneSample::discrete(
            either_vector(transmitted, refracted_by_surface(wo, cos_t, eta), mirrored(wo)),
            either_spectrum(transmitted, refraction / (eta * eta), reflection),
            either(transmitted, refract, reflect),
        );
        LaneSample { transmitted, eta: either(transmitted, eta, 1.0), ..sample }
    }

    /// The form for lanes, of one that has continuous lobes.
    #[inline]
    pub(super) fn in_lanes(self) -> InLanes {
        if Scatter::transmits(&self) {
            InLanes::PhongBothSides(PhongInLanes(self))
        } else {
            InLanes::Phong(PhongInLanes(self))
        }
    }
}

impl<const TRANSMITS: bool> LaneNumbers for PhongInLanes<TRANSMITS> {
    const NUMBERS: usize = Phong::NUMBERS;

    #[inline(always)]
    fn load(numbers: &[Numbers], i: usize) -> Self {
        Self(Phong::load(numbers, i))
    }

    #[inline(always)]
    fn store(self, numbers: &mut [Numbers], i: usize) {
        self.0.store(numbers, i);
    }
}

impl<const TRANSMITS: bool> PhongInLanes<TRANSMITS> {
    /// All continuous lobes; `wo` with z > 0, `eta` the index beyond the surface over that on this side.
    #[inline(always)]
    fn eval_from_above(&self, wo: Vec3, wi: Vec3, eta: f32) -> BsdfEval {
        let reflection = self.0.eval_reflection(wo, wi).only_if(wi.z > 0.0);
        if !TRANSMITS {
            return reflection;
        }
        let through = self.0.eval_diffuse_transmission(wi, eta).only_if(wi.z < 0.0);
        let glossy = self.0.eval_transmission(wo, wi, eta).only_if(wi.z != 0.0);
        BsdfEval {
            value: reflection.value + through.value + glossy.value,
            pdf: reflection.pdf + through.pdf + glossy.pdf,
        }
    }

    /// A direction of the chosen glossy lobe, and whether it is not lost; `wo` with z > 0.
    #[inline(always)]
    fn sample_glossy(&self, wo: Vec3, eta: f32, choice: Choice, u: [f32; 2]) -> (Vec3, bool) {
        let phong = &self.0;
        let mirror = mirrored(wo);
        if !TRANSMITS {
            let wi = sample_lobe(mirror, phong.exponent, u);
            return (wi, wi.z > 0.0);
        }
        let to_denser = choice.transmission & (eta >= 1.0);
        let beyond = fresnel::dielectric(wo.z, eta).cos_t;
        let to_thinner = choice.transmission & (eta < 1.0) & (beyond > 0.0);
        let is_total = choice.transmission & (eta < 1.0) & (beyond <= 0.0);
        let axis = either_vector(to_thinner, refracted_by_surface(wo, beyond, eta), mirror);
        let axis = either_vector(to_denser, wo, axis);
        let exponent = either(choice.transmission, phong.transmission_exponent, phong.exponent);
        let lobe = sample_lobe(axis, exponent, u);
        let cos_t = fresnel::dielectric(lobe.z, eta).cos_t;
        let wi = either_vector(to_denser, refracted_by_surface(lobe, cos_t, eta), lobe);
        let is_there = if to_thinner { lobe.z < 0.0 } else { lobe.z > 0.0 };
        (wi, is_there & (!is_total | (cos_t <= 0.0)))
    }
}

impl<const TRANSMITS: bool> LaneBsdf for PhongInLanes<TRANSMITS> {
    const IS_DELTA: bool = false;
    const TRANSMITS: bool = TRANSMITS;
    const CHOOSES_LOBE: bool = true;

    #[inline(always)]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let side = 1.0f32.copysign(wo.z);
        let eta = relative_index(self.0.ior, wo);
        self.eval_from_above(on_side(wo, side), on_side(wi, side), eta).only_if(wo.z != 0.0)
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> LaneSample {
        let eta = relative_index(self.0.ior, wo);
        let side = 1.0f32.copysign(wo.z);
        let up = on_side(wo, side);
        let choice = self.0.choose(u_lobe);
        let (glossy, is_there) = self.sample_glossy(up, eta, choice, u);
        let diffuse = on_side(warp::cosine_hemisphere(u), either(choice.diffuse_transmission, -1.0, 1.0));
        let is_glossy = choice.glossy | choice.transmission;
        let wi = either_vector(is_glossy, glossy, diffuse);
        let eval = self.eval_from_above(up, wi, eta);
        let transmitted = wi.z < 0.0;
        let continuous = LaneSample::continuous(on_side(wi, side), eval, !is_glossy | is_there);
        let continuous = LaneSample { transmitted, eta: either(transmitted, eta, 1.0), ..continuous };
        let discrete = self.0.sample_discrete(wo, eta, choice.rest);
        LaneSample::either(choice.rest >= 0.0, discrete, continuous).only_if(wo.z != 0.0)
    }
}

impl Scatter for Phong {
    #[inline]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        if self.transmits() {
            PhongInLanes::<true>(*self).eval(wo, wi)
        } else {
            PhongInLanes::<false>(*self).eval(wo, wi)
        }
    }

    #[inline]
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        if self.transmits() {
            PhongInLanes::<true>(*self).sample(wo, u_lobe, u).alone()
        } else {
            PhongInLanes::<false>(*self).sample(wo, u_lobe, u).alone()
        }
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
