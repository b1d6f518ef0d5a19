//! Constant radiance from infinity, and the directions that suit it.

use super::{Emitter, LightContext, LightSample};
use crate::{
    bsdf::Density,
    math::{Frame, Vec3},
    sampling::warp,
    spectrum::Spectrum,
};
use std::f64::consts::PI;

/// The same radiance from every direction. Sampled in proportion to the cosine where only one side of a surface
/// gathers, else uniformly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConstantEnvironment {
    /// W sr^-1 m^-2.
    pub radiance: Spectrum,
}

/// True if only the hemisphere about the context's normal counts.
#[inline]
fn one_sided(ctx: &LightContext) -> bool {
    !ctx.transmits && ctx.normal != Vec3::ZERO
}

/// A direction for radiance that arrives alike from everywhere, with its density per solid angle, above 0.
#[inline]
pub(super) fn sample_direction(ctx: &LightContext, u: [f32; 2]) -> Option<(Vec3, f32)> {
    if !one_sided(ctx) {
        return Some((warp::uniform_sphere(u), warp::UNIFORM_SPHERE_PDF));
    }
    let (wi, density) = sample_above(ctx.normal, u);
    (density > 0.0).then_some((wi, density))
}

/// [`sample_direction`] on the side of a normal, where the density may be 0. Without branches.
#[inline(always)]
pub(crate) fn sample_above(normal: Vec3, u: [f32; 2]) -> (Vec3, f32) {
    let wi = Frame::from_normal(normal).to_world(warp::cosine_hemisphere(u));
    (wi, warp::cosine_hemisphere_pdf(normal.dot(wi)))
}

/// Density per solid angle of [`sample_direction`].
#[inline]
pub(super) fn direction_pdf(ctx: &LightContext, wi: Vec3) -> f32 {
    if one_sided(ctx) { warp::cosine_hemisphere_pdf(ctx.normal.dot(wi)) } else { warp::UNIFORM_SPHERE_PDF }
}

/// The cross section of a sphere about the scene, m^2. A scene without extent is still lit from infinity.
pub(super) fn cross_section(scene_radius: f64) -> f64 {
    let scene_radius = if scene_radius > 0.0 && scene_radius.is_finite() { scene_radius } else { 1.0 };
    PI * scene_radius * scene_radius
}

/// What comes from all directions into a sphere about the scene, m^2 sr.
pub(super) fn etendue(scene_radius: f64) -> f64 {
    4.0 * PI * cross_section(scene_radius)
}

impl Emitter for ConstantEnvironment {
    #[inline]
    fn radiance(&self) -> Spectrum {
        self.radiance
    }

    fn etendue(&self, scene_radius: f64) -> f64 {
        etendue(scene_radius)
    }

    #[inline]
    fn sample(&self, ctx: &LightContext, u: [f32; 2]) -> Option<LightSample> {
        let (wi, density) = sample_direction(ctx, u)?;
        Some(LightSample {
            wi,
            at: [0.0; 2],
            target: None,
            radiance: self.radiance,
            density: Density::SolidAngle(density),
        })
    }

    #[inline]
    fn pdf(&self, ctx: &LightContext, wi: Vec3, _distance: f32) -> f32 {
        direction_pdf(ctx, wi)
    }
}
