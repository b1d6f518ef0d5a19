//! Sampling of emitters.

use crate::{bsdf::Density, math::Vec3, spectrum::Spectrum};

/// Where light is gathered.
#[derive(Clone, Copy, Debug)]
pub struct LightContext {
    /// World space, metres.
    pub point: Vec3,
    /// Unit shading normal on the side of `wo`, or zero where there is none (media).
    pub normal: Vec3,
    /// True if light from below `normal` counts too.
    pub transmits: bool,
}

/// A direction towards a light.
#[derive(Clone, Copy, Debug)]
pub struct LightSample {
    /// Unit vector towards the light.
    pub wi: Vec3,
    /// The point on the light, already offset from its surface towards the context so that the segment ends before it;
    /// `None` for lights at infinity.
    pub target: Option<Vec3>,
    /// Radiance that arrives if nothing is in between; for discrete lights (point) irradiance on a plane facing it.
    pub radiance: Spectrum,
    /// Density of this light and direction, the choice of the light included.
    pub density: Density,
}
