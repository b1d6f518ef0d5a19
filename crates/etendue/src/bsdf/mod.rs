//! Scattering at surfaces, in the local shading frame (z along the shading normal).

use crate::{math::Vec3, spectrum::Spectrum};

/// A probability density with its measure. Densities compare only in equal measures.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Density {
    /// Per steradian.
    SolidAngle(f32),
    /// The probability of a discrete direction (a Dirac).
    Discrete(f32),
}

/// A direction drawn from a BSDF.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// Unit vector, away from the surface, local frame.
    pub wi: Vec3,
    /// `f cos / density`: what the throughput is multiplied by.
    pub weight: Spectrum,
    /// Density of `wi` over all lobes of `wi`'s measure.
    pub density: Density,
    /// True if `wi` is on the other side of the surface than `wo`.
    pub transmitted: bool,
}
