//! Phase functions: where light goes that a medium scatters.
//!
//! `wo` and `wi` are unit vectors away from the scattering point, `wo` to where the light goes, `wi` to where it comes from;
//! the scattering angle is that between `-wi` and `wo`. A phase function's value is its density: it integrates to 1.

use crate::{
    math::{PI, Vec3},
    sampling::warp,
};

/// One shape of scattering.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PhaseKind {
    /// Alike in all directions.
    Isotropic,
}

/// A shape and its share.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseComponent {
    /// The shape.
    pub kind: PhaseKind,
    /// Its probability; all components' sum to 1.
    pub weight: f32,
}

/// A mixture of shapes.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseFunction {
    components: Vec<PhaseComponent>,
}

/// A direction drawn from a phase function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhaseSample {
    /// Unit vector, away from the scattering point, to where the light comes from.
    pub wi: Vec3,
    /// Density per steradian, and value.
    pub pdf: f32,
}

impl Default for PhaseFunction {
    fn default() -> Self {
        Self { components: vec![PhaseComponent { kind: PhaseKind::Isotropic, weight: 1.0 }] }
    }
}

impl PhaseFunction {
    /// The shapes with their shares.
    pub fn components(&self) -> &[PhaseComponent] {
        &self.components
    }

    /// Value and density per steradian.
    #[inline]
    pub fn eval(&self, wo: Vec3, wi: Vec3) -> f32 {
        let _ = (wo, wi);
        1.0 / (4.0 * PI)
    }

    /// Draws a direction: `u_lobe` in [0, 1) chooses the shape, `u` in [0, 1)^2 the direction.
    #[inline]
    pub fn sample(&self, wo: Vec3, u_lobe: f32, u: [f32; 2]) -> PhaseSample {
        let _ = (wo, u_lobe);
        PhaseSample { wi: warp::uniform_sphere(u), pdf: 1.0 / (4.0 * PI) }
    }
}
