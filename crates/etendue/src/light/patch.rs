//! Flat lights that are small as seen from the context: points of their area, in proportion to what they bring there.
//!
//! An element of area at distance d, seen from the height h over the light's plane and under the cosine c at the context, brings
//! `c h / d^3`. Over a parallelogram that is not near this is close to the bilinear function with the same values at the corners,
//! from which points are drawn at little cost (Hart et al., "Practical Product Sampling by Fitting and Composing Warps", 2020).
//! So what is left to the weight is less than with points that are uniform in solid angle, and takes no angles at all.

use super::{LightContext, between, larger};
use crate::math::{DVec3, Vec3};

/// Least square of the distance from a parallelogram's middle, over that of its diagonal.
const FAR: f64 = 2.25;
/// Least square of the distance from a triangle's corner, over that of its longest edge: points are even on it.
const VERY_FAR: f64 = 25.0;
/// Least cosine between the light's normal and the way to the context: below, rounded directions tell distances badly.
const LEAST_COS: f64 = 0.05;
/// Least value at a corner, over the greatest: not all that scatters goes with the cosine.
const LEAST_VALUE: f64 = 0.05;

/// A parallelogram, or with `weights` absent a triangle, and the density of its points.
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
    /// Values at the corner, at the ends of `u` and `v`, and at that of both; `None`: a triangle with points that are even.
    weights: Option<[f64; 4]>,
}

impl Patch {
    /// A parallelogram `height` below the context, above 0; false where it is too near. Without branches.
    #[inline(always)]
    pub fn parallelogram(ctx: &LightContext, height: f64, corner: DVec3, u: DVec3, v: DVec3) -> (Self, bool) {
        let diagonal = u.length_squared() + v.length_squared() + 2.0 * u.dot(v).abs();
        let middle = corner + (u + v) * 0.5;
        let (patch, usable) = Self::new(height, corner, u, v, middle, diagonal * FAR);
        let normal = ctx.normal.as_dvec3();
        // On both sides or in a medium nothing is known of the cosine.
        let any = ctx.transmits | (normal.length_squared() == 0.0);
        let value = |c: DVec3| {
            let square = c.length_squared();
            let cos = if any { square.sqrt() } else { larger(c.dot(normal), 0.0) };
            cos / (square * square)
        };
        let [w00, w10, w01, w11] = [value(corner), value(corner + u), value(corner + v), value(corner + u + v)];
        let least = LEAST_VALUE * larger(larger(w00, w10), larger(w01, w11));
        let weights = [larger(w00, least), larger(w10, least), larger(w01, least), larger(w11, least)];
        (Self { weights: Some(weights), ..patch }, usable & (least > 0.0))
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
        (Self { corner, u, v, front: cross / span, span, height, weights: None }, usable)
    }

    /// The point for `u` in [0, 1)^2, relative to the context, its multiples of the edges, and its density per solid angle.
    #[inline(always)]
    pub fn sample(&self, [u, v]: [f64; 2]) -> (DVec3, [f64; 2], f64) {
        let at = match self.weights {
            None => {
                let root = u.sqrt();
                [1.0 - root, v * root]
            }
            Some([w00, w10, w01, w11]) => {
                let b = linear(w00 + w10, w01 + w11, v);
                let mix = |from: f64, to: f64| from + (to - from) * b;
                [linear(mix(w00, w01), mix(w10, w11), u), b]
            }
        };
        let offset = self.corner + self.u * at[0] + self.v * at[1];
        (offset, at, self.density(at, offset.length_squared()))
    }

    /// Density per solid angle in direction of the unit vector `wi`, which meets the light.
    #[inline]
    pub fn pdf(&self, wi: Vec3) -> f64 {
        let wi = wi.as_dvec3();
        let distance = self.height / wi.dot(self.front).abs();
        let on = wi * distance - self.corner;
        let scale = 1.0 / self.span;
        let at = [on.cross(self.v).dot(self.front) * scale, self.u.cross(on).dot(self.front) * scale];
        let density = self.density([between(at[0], 0.0, 1.0), between(at[1], 0.0, 1.0)], distance * distance);
        if density.is_finite() { density } else { 0.0 }
    }

    #[inline(always)]
    fn density(&self, [a, b]: [f64; 2], square: f64) -> f64 {
        let even = square * square.sqrt() / (self.height * self.span);
        match self.weights {
            None => 2.0 * even,
            Some([w00, w10, w01, w11]) => {
                let own = (w00 * (1.0 - a) + w10 * a) * (1.0 - b) + (w01 * (1.0 - a) + w11 * a) * b;
                4.0 * own / (w00 + w10 + w01 + w11) * even
            }
        }
    }
}

/// A number in [0, 1] with a density that goes from `from` to `to`, not both 0.
#[inline(always)]
fn linear(from: f64, to: f64, u: f64) -> f64 {
    let root = larger(from * from + (to * to - from * from) * u, 0.0).sqrt();
    between(u * (from + to) / (from + root), 0.0, 1.0)
}
