//! Flat lights that are small as seen from the context: points of their area, in proportion to what they bring there.
//!
//! An element of area at distance d, seen from the height h over the light's plane and under the cosine c at the context, brings
//! `c h / d^3`. Over a parallelogram that is not near this is close to the bilinear function with the same values at the corners
//! ([`Bilinear`](super::bilinear::Bilinear)). So what is left to the weight is less than with points that are uniform in solid
//! angle, and takes no angles at all.

use super::{between, larger};
use crate::math::{DVec3, Vec3};

/// Least square of the distance from a parallelogram's middle, over that of its diagonal.
const FAR: f64 = 2.25;
/// Least square of the distance from a triangle's corner, over that of its longest edge: points are even on it.
const VERY_FAR: f64 = 25.0;
/// Least cosine between the light's normal and the way to the context: below, rounded directions tell distances badly.
const LEAST_COS: f64 = 0.05;

/// A parallelogram, or the triangle between its corner and the ends of its edges, as seen from a context.
#[derive(Clone, Copy)]
pub(super) struct Patch {
    /// Relative to the context.
    corner: DVec3,
    u: DVec3,
    v: DVec3,
    /// Unit, along `u` x `v`.
    front: DVec3,
    /// |u x v|, m^2.
    span: f64,
    /// Of the context over the plane, above 0.
    height: f64,
}

/// A point of a [`Patch`].
pub(super) struct PatchPoint {
    /// Relative to the context.
    pub offset: DVec3,
    /// Density per solid angle of points that are even on the parallelogram.
    pub even: f64,
}

impl Patch {
    /// A parallelogram `height` below the context, above 0; false where it is too near. Without branches.
    #[inline(always)]
    pub fn parallelogram(height: f64, corner: DVec3, u: DVec3, v: DVec3) -> (Self, bool) {
        let diagonal = u.length_squared() + v.length_squared() + 2.0 * u.dot(v).abs();
        let middle = corner + (u + v) * 0.5;
        Self::new(height, corner, u, v, middle, diagonal * FAR)
    }

    /// As [`Self::parallelogram`], of the triangle between a corner and the ends of `u` and `v`.
    #[inline(always)]
    pub fn triangle(height: f64, corner: DVec3, u: DVec3, v: DVec3) -> (Self, bool) {
        let longest = larger(u.length_squared(), larger(v.length_squared(), (v - u).length_squared()));
        Self::new(height, corner, u, v, corner, longest * VERY_FAR)
    }

    #[inline(always)]
    fn new(height: f64, corner: DVec3, u: DVec3, v: DVec3, at: DVec3, least: f64) -> (Self, bool) {
        let square = at.length_squared();
        let is_far = (square > least) & (height * height > square * (LEAST_COS * LEAST_COS)) & (square < f64::INFINITY);
        let cross = u.cross(v);
        let span = cross.length();
        let usable = is_far & (span > 0.0) & (span < f64::INFINITY);
        (Self { corner, u, v, front: cross / span, span, height }, usable)
    }

    /// The point at these multiples of the edges.
    #[inline(always)]
    pub fn point(&self, at: [f64; 2]) -> PatchPoint {
        let offset = self.corner + self.u * at[0] + self.v * at[1];
        PatchPoint { offset, even: self.even(offset.length_squared()) }
    }

    /// The point in direction of the unit vector `wi`, which meets the light, as multiples of the edges in [0, 1], and its density
    /// as in [`PatchPoint`].
    #[inline]
    pub fn towards(&self, wi: Vec3) -> ([f64; 2], f64) {
        let wi = wi.as_dvec3();
        let distance = self.height / wi.dot(self.front).abs();
        let on = wi * distance - self.corner;
        let scale = 1.0 / self.span;
        let at = [on.cross(self.v).dot(self.front) * scale, self.u.cross(on).dot(self.front) * scale];
        (at.map(|at| between(at, 0.0, 1.0)), self.even(distance * distance))
    }

    #[inline(always)]
    fn even(&self, square: f64) -> f64 {
        square * square.sqrt() / (self.height * self.span)
    }
}
