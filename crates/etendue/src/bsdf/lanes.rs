//! Scattering without branches: BSDFs as plain numbers, so that loops over many vertices become vector code.
//!
//! A kind's `eval` and `sample` are the formulas of its variant of [`Bsdf`], and give the same bits: both call the same functions, or
//! products so short that nothing can differ.

use super::{Bsdf, BsdfEval};
use crate::{
    math::{PI, Vec3, vec3},
    sampling::warp,
    spectrum::Spectrum,
};

/// Vertices that are taken together. A multiple of the longest vectors; all their numbers fit the L1 cache.
pub(crate) const LANES: usize = 64;

/// Most numbers that any kind has.
pub(crate) const MOST_NUMBERS: usize = 32;

/// One lane's scattering as plain numbers, evaluated without branches so that loops over lanes become vector code.
pub(crate) trait LaneBsdf: Copy + Default + 'static {
    /// Numbers a lane has, at most [`MOST_NUMBERS`].
    const NUMBERS: usize;
    /// True if no lobe has a density per solid angle: no light samples.
    const IS_DELTA: bool;
    /// True if a continuous lobe transmits: light from below counts.
    const TRANSMITS: bool;
    /// False if nothing depends on the number that chooses the lobe.
    const CHOOSES_LOBE: bool = true;

    /// Lane `i` of some arrays of numbers.
    fn load(numbers: &[[f32; LANES]], i: usize) -> Self;

    /// Puts the numbers where [`Self::load`] finds them.
    fn store(self, numbers: &mut [[f32; LANES]], i: usize);

    /// See [`Bsdf::eval`].
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval;

    /// See [`Bsdf::sample`].
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> LaneSample;
}

/// A direction drawn from a BSDF; see [`BsdfSample`](super::BsdfSample).
#[derive(Clone, Copy, Debug)]
pub(crate) struct LaneSample {
    /// Unit vector, away from the surface, local frame.
    pub wi: Vec3,
    /// What the throughput is multiplied by.
    pub weight: Spectrum,
    /// Per steradian, or the probability of a discrete direction.
    pub density: f32,
    pub is_discrete: bool,
    pub transmitted: bool,
    pub eta: f32,
    /// False where light is absorbed; the rest is any numbers then.
    pub is_valid: bool,
}

/// A BSDF of those that have a form for lanes. Its frame is any about the normal.
#[derive(Clone, Copy, Debug)]
pub(crate) enum InLanes {
    Lambert(Lambert),
}

impl Bsdf {
    /// The form for lanes, if there is one.
    #[inline]
    pub(crate) fn in_lanes(&self) -> Option<InLanes> {
        match self {
            Self::Diffuse(diffuse) => diffuse.lambert().map(InLanes::Lambert),
            _ => None,
        }
    }
}

/// Lambertian reflection alone, of an albedo that is not black.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lambert {
    pub albedo: Spectrum,
}

impl LaneBsdf for Lambert {
    const NUMBERS: usize = 3;
    const IS_DELTA: bool = false;
    const TRANSMITS: bool = false;
    const CHOOSES_LOBE: bool = false;

    #[inline(always)]
    fn load(numbers: &[[f32; LANES]], i: usize) -> Self {
        Self { albedo: Spectrum([numbers[0][i], numbers[1][i], numbers[2][i]]) }
    }

    #[inline(always)]
    fn store(self, numbers: &mut [[f32; LANES]], i: usize) {
        [numbers[0][i], numbers[1][i], numbers[2][i]] = self.albedo.0;
    }

    #[inline(always)]
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        let reflected = wo.z * wi.z > 0.0;
        let value = self.albedo * (wi.z.abs() * (1.0 / PI));
        let pdf = warp::cosine_hemisphere_pdf(wi.z.abs());
        BsdfEval { value: value * if reflected { 1.0 } else { 0.0 }, pdf: if reflected { pdf } else { 0.0 } }
    }

    #[inline(always)]
    fn sample(&self, wo: Vec3, _u_lobe: f32, u: [f32; 2]) -> LaneSample {
        let local = warp::cosine_hemisphere(u);
        let z = if wo.z > 0.0 { local.z } else { -local.z };
        LaneSample {
            wi: vec3(local.x, local.y, z),
            weight: self.albedo,
            density: warp::cosine_hemisphere_pdf(local.z),
            is_discrete: false,
            transmitted: false,
            eta: 1.0,
            is_valid: (wo.z != 0.0) & (local.z > 0.0),
        }
    }
}
