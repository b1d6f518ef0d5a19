//! What flat lights share: which side the context is on, and the lifted target.

use super::{LightContext, LightSample, is_usable, larger, margin, max_abs};
use crate::{
    bsdf::Density,
    math::{DVec3, Vec3},
    spectrum::Spectrum,
};

/// A flat light as seen from a context on an emitting side of it, farther from its plane than the margin.
#[derive(Clone, Copy)]
pub(super) struct Facing {
    /// The context.
    point: DVec3,
    /// Unit normal on the context's side.
    normal: DVec3,
    /// Of the context over the plane, above `margin`.
    height: f64,
    /// Offset of targets along `normal`.
    margin: f64,
}

impl Facing {
    /// `cross` is along the front's normal, of any length. `None` if the light shows no emitting side, if the context is
    /// in its plane, or if anything is degenerate.
    #[inline]
    pub(super) fn new<const N: usize>(
        ctx: &LightContext,
        corners: &[DVec3; N],
        cross: DVec3,
        two_sided: bool,
    ) -> Option<Self> {
        let (facing, is_seen) = Self::look(ctx, corners, cross, two_sided);
        is_seen.then_some(facing)
    }

    /// As [`Self::new`], false for `None`. Without branches.
    #[inline(always)]
    pub(super) fn look<const N: usize>(
        ctx: &LightContext,
        corners: &[DVec3; N],
        cross: DVec3,
        two_sided: bool,
    ) -> (Self, bool) {
        let point = ctx.point.as_dvec3();
        let front = cross / cross.length();
        let mut coordinate = max_abs(point);
        let mut distance = 0.0f64;
        for &corner in corners {
            coordinate = larger(max_abs(corner), coordinate);
            distance = larger(max_abs(corner - point), distance);
        }
        let margin = margin(coordinate, distance);
        let over = front.dot(point - corners[0]);
        let side = 1f64.copysign(over);
        let height = over * side;
        let is_seen = (height > margin) & ((over > 0.0) | two_sided);
        (Self { point, normal: front * side, height, margin }, is_seen)
    }

    /// Height of the context over the plane, metres, above 0.
    #[inline(always)]
    pub(super) fn height(&self) -> f64 {
        self.height
    }

    /// Unit, on the context's side.
    #[inline(always)]
    pub(super) fn normal(&self) -> DVec3 {
        self.normal
    }

    /// The point at `offset` from the context, drawn with `density` per solid angle; `at` as in [`LightSample`].
    #[inline(always)]
    pub(super) fn draw(&self, offset: DVec3, at: [f64; 2], density: f64) -> DrawnPoint {
        DrawnPoint::new(offset, self.target(offset), at, density)
    }

    /// The end of a shadow ray to the point at `offset` from the context.
    #[inline(always)]
    pub(super) fn target(&self, offset: DVec3) -> Vec3 {
        (self.point + offset + self.normal * self.margin).as_vec3()
    }
}

/// A point drawn on a flat light; see [`LightSample`].
#[derive(Clone, Copy)]
pub(crate) struct DrawnPoint {
    pub wi: Vec3,
    pub target: Vec3,
    pub at: [f32; 2],
    pub density: f32,
    /// False if the numbers are out of range, which counts as no sample.
    pub is_valid: bool,
}

impl DrawnPoint {
    /// The point at `offset` from the context, drawn with `density` per solid angle.
    #[inline(always)]
    pub(super) fn new(offset: DVec3, target: Vec3, at: [f64; 2], density: f64) -> Self {
        let length = offset.length();
        Self {
            wi: (offset / length).as_vec3(),
            target,
            at: [at[0] as f32, at[1] as f32],
            density: density as f32,
            is_valid: is_usable(density) & (length > 0.0) & (length < f64::INFINITY),
        }
    }

    /// The sample, if there is one.
    #[inline(always)]
    pub(super) fn sample(&self, radiance: Spectrum) -> Option<LightSample> {
        let Self { wi, target, at, density, is_valid } = *self;
        is_valid.then_some(LightSample {
            wi,
            at,
            target: Some(target),
            radiance,
            density: Density::SolidAngle(density),
        })
    }
}
