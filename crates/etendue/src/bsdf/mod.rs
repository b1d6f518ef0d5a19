//! Scattering at surfaces, in the local shading frame (z along the shading normal).
//!
//! `wo` and `wi` are unit vectors that point away from the surface, `wo` to where the light goes (back along a path
//! traced from the camera), `wi` to where it comes from. Either may have a negative z: the other side of the surface.
//! For dielectrics z > 0 is outside.
//!
//! Paths carry radiance. Refraction squeezes light into another solid angle, so radiance changes by the square of the
//! relative index: light that comes from `wi` in a medium of index n_i and leaves along `wo` in one of index n_o is
//! multiplied by (n_o / n_i)^2 (Veach 1997, 5.2). A path that enters glass and leaves it again ends with a factor of 1.
//!
//! Directions exactly in the surface's plane (z = 0) scatter nothing.

mod brushed_metal;
mod diffuse;
pub mod directional_albedo;
pub mod fresnel;
pub mod ggx;
mod glass;
pub mod lanes;
pub mod metals;
mod mirror;
mod mtl;
mod phong;
mod principled;
mod rough_glass;
mod rough_metal;
mod sheen;

use crate::{math::Vec3, spectrum::Spectrum};

pub use brushed_metal::{BrushedMetal, Circle, GrooveForm};
pub use diffuse::{Diffuse, Lambert};
pub use glass::Glass;
pub(crate) use lanes::{InLanes, LANES, LaneBsdf, MOST_NUMBERS};
pub use mirror::Mirror;
pub use mtl::Mtl;
pub use phong::{MIRROR_EXPONENT, Phong, PhongInLanes, PhongLobes};
pub use principled::{Principled, PrincipledParameters};
pub use rough_glass::RoughGlass;
pub use rough_metal::RoughMetal;

/// A probability density with its measure. Densities compare only in equal measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Per steradian.
    SolidAngle(f32),
    /// Per radian of an angle round a circle of directions, outside of which there are none (brushed metal).
    Arc(f32),
    /// The probability of a discrete direction (a Dirac).
    Discrete(f32),
}

impl Density {
    /// The number without its measure.
    #[inline]
    pub fn value(self) -> f32 {
        let (Self::SolidAngle(value) | Self::Arc(value) | Self::Discrete(value)) = self;
        value
    }

    /// The density of a choice of this `probability` and then this.
    #[inline]
    pub fn chosen(self, probability: f32) -> Self {
        match self {
            Self::SolidAngle(value) => Self::SolidAngle(value * probability),
            Self::Arc(value) => Self::Arc(value * probability),
            Self::Discrete(value) => Self::Discrete(value * probability),
        }
    }
}

/// A direction drawn from a BSDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Unit vector, away from the surface, local frame.
    pub wi: Vec3,
    /// `f |cos| / density`: what the throughput is multiplied by.
    pub weight: Spectrum,
    /// Density of `wi` over all lobes of `wi`'s measure.
    pub density: Density,
    /// True if `wi` is on the other side of the surface than `wo`.
    pub transmitted: bool,
    /// Index of refraction on the side of `wi` over that on the side of `wo`; 1 where nothing is refracted. `weight`
    /// holds its inverse square, which roulette should not take for a loss.
    pub eta: f32,
}

impl BsdfSample {
    /// A direction drawn from continuous lobes that have this value and density together; `None` if the density is 0. `eta` is
    /// the index beyond the surface over that on the side of `wo`.
    #[inline]
    fn continuous(wi: Vec3, BsdfEval { value, pdf }: BsdfEval, transmitted: bool, eta: f32) -> Option<Self> {
        let (density, eta) = (Density::SolidAngle(pdf), if transmitted { eta } else { 1.0 });
        (pdf > 0.0).then(|| Self { wi, weight: value / pdf, density, transmitted, eta })
    }

    /// A discrete direction on the side of `wo` that scatters `value` and was chosen with `probability`; `None` if that is 0.
    #[inline]
    fn reflected(wi: Vec3, value: Spectrum, probability: f32) -> Option<Self> {
        let density = Density::Discrete(probability);
        (probability > 0.0).then(|| Self { wi, weight: value / probability, density, transmitted: false, eta: 1.0 })
    }

    /// The same on the other side, `value` being the share of the power and `eta` the index there over that here.
    #[inline]
    fn refracted(wi: Vec3, value: Spectrum, probability: f32, eta: f32) -> Option<Self> {
        let sample = Self::reflected(wi, value / (eta * eta), probability)?;
        Some(Self { transmitted: true, eta, ..sample })
    }
}

/// A BSDF's continuous lobes, for a pair of directions; or a [`Circle`]'s, for an angle on it and per radian.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfEval {
    /// `f(wo, wi) |cos theta_i|`, per steradian; the cosine is included.
    pub value: Spectrum,
    /// Density per steradian with which [`Bsdf::sample`] draws `wi` given `wo`; over all `wi` it sums to the probability
    /// that a continuous lobe is chosen and its direction not lost below the horizon.
    pub pdf: f32,
}

impl BsdfEval {
    /// Nothing is scattered.
    pub const ZERO: Self = Self { value: Spectrum::BLACK, pdf: 0.0 };
}

/// What every kind of BSDF does; the contracts stand at the methods of [`Bsdf`].
trait Scatter {
    fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval;
    fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample>;
    fn is_delta(&self) -> bool;
    fn transmits(&self) -> bool;
    fn albedo(&self) -> Spectrum;
    fn is_anisotropic(&self) -> bool {
        false
    }
}

/// How a point of a surface scatters: what a [`Material`](crate::material::Material) becomes once its parameters are
/// known there.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bsdf {
    /// Lambertian reflection and transmission.
    Diffuse(Diffuse),
    /// Perfect specular reflection, of a mirror or of a polished metal.
    Mirror(Mirror),
    /// Smooth dielectric interface or sheet.
    Glass(Glass),
    /// GGX conductor.
    RoughMetal(RoughMetal),
    /// GGX dielectric interface.
    RoughGlass(RoughGlass),
    /// Grooves that scatter into a circle of directions.
    BrushedMetal(BrushedMetal),
    /// Mixture of diffuse, specular and refracting lobes.
    Mtl(Mtl),
    /// Mixture of diffuse and glossy reflection and transmission.
    Phong(Phong),
    /// Coat and sheen over metal, opaque and clear dielectric.
    Principled(Principled),
    /// Scatters nothing.
    Black,
}

macro_rules! dispatch {
    ($bsdf:expr, $b:ident => $call:expr) => {
        match $bsdf {
            Bsdf::Diffuse($b) => $call,
            Bsdf::Mirror($b) => $call,
            Bsdf::Glass($b) => $call,
            Bsdf::RoughMetal($b) => $call,
            Bsdf::RoughGlass($b) => $call,
            Bsdf::BrushedMetal($b) => $call,
            Bsdf::Mtl($b) => $call,
            Bsdf::Phong($b) => $call,
            Bsdf::Principled($b) => $call,
            Bsdf::Black => {
                let $b = &Black;
                $call
            }
        }
    };
}

impl Bsdf {
    /// The continuous lobes' value (cosine included) and density for the pair; delta lobes count as nothing in both.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> BsdfEval {
        dispatch!(self, b => Scatter::eval(b, wo, wi))
    }

    /// Draws a direction for `wo`: `u_lobe` in [0, 1) chooses the lobe, `u` in [0, 1)^2 the direction inside it. `None`
    /// where the light is absorbed, which counts as a weight of 0.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> Option<BsdfSample> {
        dispatch!(self, b => Scatter::sample(b, wo, u_lobe, u))
    }

    /// The circle of directions from which all light comes that leaves towards `wo`, for BSDFs that scatter so: brushed metal.
    /// Per steradian such a lobe is 0 in [`Self::eval`].
    #[inline]
    pub fn circle(&self, wo: Vec3) -> Option<Circle> {
        match self {
            Self::BrushedMetal(metal) => metal.circle(wo),
            _ => None,
        }
    }

    /// True if there are only delta lobes (or none), or a circle: light sampling by solid angle finds nothing.
    #[inline]
    pub fn is_delta(&self) -> bool {
        dispatch!(self, b => b.is_delta())
    }

    /// True if a continuous lobe transmits, so that lights on the other side of the surface count.
    #[inline]
    pub fn transmits(&self) -> bool {
        dispatch!(self, b => b.transmits())
    }

    /// True if it looks different when the surface is turned about its normal, so that the frame's x must be along the
    /// surface's tangent.
    #[inline]
    pub fn is_anisotropic(&self) -> bool {
        dispatch!(self, b => b.is_anisotropic())
    }

    /// Share of light from along the normal that is scattered, per channel, in [0, 1]; of rough surfaces that of their
    /// facets. A guide for denoisers, not an exact integral.
    #[inline]
    pub fn albedo(&self) -> Spectrum {
        dispatch!(self, b => b.albedo())
    }
}

/// Scatters nothing.
struct Black;

impl Scatter for Black {
    fn eval(&self, _wo: Vec3, _wi: Vec3) -> BsdfEval {
        BsdfEval::ZERO
    }

    fn sample(&self, _wo: Vec3, _u_lobe: f32, _u: [f32; 2]) -> Option<BsdfSample> {
        None
    }

    fn is_delta(&self) -> bool {
        true
    }

    fn transmits(&self) -> bool {
        false
    }

    fn albedo(&self) -> Spectrum {
        Spectrum::BLACK
    }
}

/// `wo` reflected by the surface itself.
#[inline(always)]
fn mirrored(wo: Vec3) -> Vec3 {
    Vec3::new(-wo.x, -wo.y, wo.z)
}

/// `v` with its z multiplied by `side` (1 or -1): formulas for z > 0 serve the other side of a surface as well.
#[inline(always)]
fn on_side(v: Vec3, side: f32) -> Vec3 {
    Vec3::new(v.x, v.y, v.z * side)
}

/// Probability of the first of two lobes with weights `a` and `b`; 0 if both are 0.
#[inline(always)]
fn share(a: f32, b: f32) -> f32 {
    let sum = a + b;
    let share = a / sum;
    if sum > 0.0 { share } else { 0.0 }
}
