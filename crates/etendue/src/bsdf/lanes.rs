//! BSDFs in lanes: one vertex's scattering as plain numbers, evaluated without branches, so that loops over vertices of one
//! kind become vector code.
//!
//! The kinds are the BSDFs themselves: their scalar form ([`Bsdf`]) calls the same functions, so a vertex scatters the same,
//! to the bit, in lanes and alone. What such a function computes where a direction does not exist is thrown away at its
//! end, and may be anything on the way, NaN included.

use super::{
    Bsdf, BsdfEval, BsdfSample, Density, Diffuse, Glass, Lambert, Mirror, Mtl, PhongInLanes, RoughGlass, RoughMetal,
};
use crate::{
    math::{Vec3, vec3},
    spectrum::Spectrum,
};

/// Vertices that are taken together. A multiple of the longest vectors; all their numbers fit the L1 cache.
pub const LANES: usize = 64;

/// Most numbers that any kind has.
pub const MOST_NUMBERS: usize = 16;

/// A number of each lane.
pub type Numbers = [f32; LANES];

/// Something that is stored as so many numbers, in arrays that each hold one of them for all lanes.
pub trait LaneNumbers: Copy {
    /// How many; of a [`LaneBsdf`] at most [`MOST_NUMBERS`].
    const NUMBERS: usize;

    /// Of lane `i`. `numbers` has at least [`Self::NUMBERS`] arrays, `i` is below [`LANES`].
    fn load(numbers: &[Numbers], i: usize) -> Self;

    /// The inverse.
    fn store(self, numbers: &mut [Numbers], i: usize);
}

/// One lane's scattering as plain numbers, evaluated without branches.
///
/// Directions, values and densities are as those of [`Bsdf`]. Discrete lobes may lie beside continuous ones.
pub trait LaneBsdf: LaneNumbers + 'static {
    /// True if no lobe has a density per solid angle, so that light samples find nothing.
    const IS_DELTA: bool;
    /// True if a continuous lobe transmits.
    const TRANSMITS: bool;
    /// False if nothing depends on the number that chooses the lobe.
    const CHOOSES_LOBE: bool;

    /// See [`Bsdf::eval`].
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval;

    /// See [`Bsdf::sample`].
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> LaneSample;
}

/// A BSDF of those that go in lanes. It looks the same when the surface is turned about its normal.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum InLanes {
    /// Diffuse reflection alone.
    Lambert(Lambert),
    /// Diffuse reflection and transmission.
    Diffuse(Diffuse),
    /// Mirrors and polished metals.
    Mirror(Mirror),
    /// Smooth dielectrics.
    Glass(Glass),
    /// Isotropic GGX conductors.
    RoughMetal(RoughMetal),
    /// GGX dielectrics.
    RoughGlass(RoughGlass),
    /// The lobes of MTL files.
    Mtl(Mtl),
    /// Phong's lobes that reflect, and Diracs beside them.
    Phong(PhongInLanes<false>),
    /// All of Phong's lobes.
    PhongBothSides(PhongInLanes<true>),
}

impl Bsdf {
    /// The form for lanes, if there is one.
    #[inline]
    pub fn in_lanes(&self) -> Option<InLanes> {
        match *self {
            Self::Diffuse(diffuse) if !self.is_delta() => Some(diffuse.in_lanes()),
            Self::Mirror(mirror) => Some(InLanes::Mirror(mirror)),
            Self::Glass(glass) => Some(InLanes::Glass(glass)),
            Self::RoughMetal(metal) if !self.is_anisotropic() => Some(InLanes::RoughMetal(metal)),
            Self::RoughGlass(glass) if !self.is_anisotropic() => Some(InLanes::RoughGlass(glass)),
            Self::Mtl(mtl) if !self.is_delta() => Some(InLanes::Mtl(mtl)),
            Self::Phong(phong) if !self.is_delta() => Some(phong.in_lanes()),
            _ => None,
        }
    }
}

/// A direction drawn from a BSDF in lanes.
#[derive(Clone, Copy, Debug)]
pub struct LaneSample {
    /// Unit vector, away from the surface, local frame.
    pub wi: Vec3,
    /// See [`BsdfSample::weight`].
    pub weight: Spectrum,
    /// See [`BsdfSample::density`].
    pub density: f32,
    /// True if the density is a probability, else it is per steradian.
    pub is_discrete: bool,
    /// See [`BsdfSample::transmitted`].
    pub transmitted: bool,
    /// See [`BsdfSample::eta`].
    pub eta: f32,
    /// False where the light is absorbed; all else is then anything.
    pub is_valid: bool,
}

impl LaneSample {
    /// A direction of continuous lobes on the side of `wo`, that have this value and density together.
    #[inline(always)]
    pub(super) fn continuous(wi: Vec3, BsdfEval { value, pdf }: BsdfEval, is_valid: bool) -> Self {
        let is_valid = is_valid & (pdf > 0.0);
        Self { wi, weight: value / pdf, density: pdf, is_discrete: false, transmitted: false, eta: 1.0, is_valid }
    }

    /// A discrete direction that scatters `value` and was chosen with `probability`.
    #[inline(always)]
    pub(super) fn discrete(wi: Vec3, value: Spectrum, probability: f32) -> Self {
        let (weight, is_valid) = (value / probability, probability > 0.0);
        Self { wi, weight, density: probability, is_discrete: true, transmitted: false, eta: 1.0, is_valid }
    }

    /// This sample if `is_valid`, else one that is not.
    #[inline(always)]
    pub(super) fn only_if(self, is_valid: bool) -> Self {
        Self { is_valid: self.is_valid & is_valid, ..self }
    }

    /// `a` if `first`, else `b`.
    #[inline(always)]
    pub(super) fn either(first: bool, a: Self, b: Self) -> Self {
        Self {
            wi: either_vector(first, a.wi, b.wi),
            weight: either_spectrum(first, a.weight, b.weight),
            density: either(first, a.density, b.density),
            is_discrete: if first { a.is_discrete } else { b.is_discrete },
            transmitted: if first { a.transmitted } else { b.transmitted },
            eta: either(first, a.eta, b.eta),
            is_valid: if first { a.is_valid } else { b.is_valid },
        }
    }

    /// The sample as a lone vertex has it.
    #[inline(always)]
    pub(super) fn alone(self) -> Option<BsdfSample> {
        let Self { wi, weight, density, is_discrete, transmitted, eta, is_valid } = self;
        let density = if is_discrete { Density::Discrete(density) } else { Density::SolidAngle(density) };
        is_valid.then_some(BsdfSample { wi, weight, density, transmitted, eta })
    }
}

impl BsdfEval {
    /// This if `is_there`, else nothing.
    #[inline(always)]
    pub(super) fn only_if(self, is_there: bool) -> Self {
        let keep = |number: f32| if is_there { number } else { 0.0 };
        Self { value: self.value.map(keep), pdf: keep(self.pdf) }
    }
}

/// `a` if `first`, else `b`.
#[inline(always)]
pub(super) fn either(first: bool, a: f32, b: f32) -> f32 {
    if first { a } else { b }
}

/// `a` if `first`, else `b`.
#[inline(always)]
pub(super) fn either_vector(first: bool, a: Vec3, b: Vec3) -> Vec3 {
    vec3(either(first, a.x, b.x), either(first, a.y, b.y), either(first, a.z, b.z))
}

/// `a` if `first`, else `b`.
#[inline(always)]
pub(super) fn either_spectrum(first: bool, a: Spectrum, b: Spectrum) -> Spectrum {
    let ([ar, ag, ab], [br, bg, bb]) = (a.0, b.0);
    Spectrum([either(first, ar, br), either(first, ag, bg), either(first, ab, bb)])
}

impl LaneNumbers for f32 {
    const NUMBERS: usize = 1;

    #[inline(always)]
    fn load(numbers: &[Numbers], i: usize) -> Self {
        numbers[0][i]
    }

    #[inline(always)]
    fn store(self, numbers: &mut [Numbers], i: usize) {
        numbers[0][i] = self;
    }
}

impl LaneNumbers for bool {
    const NUMBERS: usize = 1;

    #[inline(always)]
    fn load(numbers: &[Numbers], i: usize) -> Self {
        numbers[0][i] != 0.0
    }

    #[inline(always)]
    fn store(self, numbers: &mut [Numbers], i: usize) {
        numbers[0][i] = if self { 1.0 } else { 0.0 };
    }
}

impl LaneNumbers for Spectrum {
    const NUMBERS: usize = 3;

    #[inline(always)]
    fn load(numbers: &[Numbers], i: usize) -> Self {
        Self([numbers[0][i], numbers[1][i], numbers[2][i]])
    }

    #[inline(always)]
    fn store(self, numbers: &mut [Numbers], i: usize) {
        let [r, g, b] = self.0;
        numbers[0][i] = r;
        numbers[1][i] = g;
        numbers[2][i] = b;
    }
}

/// Stores a structure as the numbers of its fields, one after another.
macro_rules! lane_numbers {
    ($kind:ty { $($field:ident: $number:ty),* $(,)? }) => {
        impl $crate::bsdf::lanes::LaneNumbers for $kind {
            const NUMBERS: usize = 0 $(+ <$number as $crate::bsdf::lanes::LaneNumbers>::NUMBERS)*;

            #[inline(always)]
            fn load(numbers: &[$crate::bsdf::lanes::Numbers], i: usize) -> Self {
                $(
                    let $field = <$number as $crate::bsdf::lanes::LaneNumbers>::load(numbers, i);
                    let numbers = &numbers[<$number as $crate::bsdf::lanes::LaneNumbers>::NUMBERS..];
                )*
                let _ = numbers;
                Self { $($field),* }
            }

            #[inline(always)]
            fn store(self, numbers: &mut [$crate::bsdf::lanes::Numbers], i: usize) {
                $(
                    $crate::bsdf::lanes::LaneNumbers::store(self.$field, numbers, i);
                    let numbers = &mut numbers[<$number as $crate::bsdf::lanes::LaneNumbers>::NUMBERS..];
                )*
                let _ = numbers;
            }
        }
    };
}
pub(super) use lane_numbers;
