//! Elliptic cones, as those of disks, by projected solid angle.
//!
//! On the ellipse of an [`EllipticCone`], with the surface's normal n in the cone's frame, what a direction (x, y, z) brings is
//! (n . d) dx dy / z = (n.z + (n.x x + n.y y) / z) dx dy. The second term is odd about the middle: two opposite points of the
//! ellipse bring 2 n.z together, wherever they are. So of a cone that is all above the horizon the projected solid angle is
//! pi a b n.z, and points that are even on the ellipse become directions in proportion to the cosine, if of two opposite ones each is
//! taken as often as its share says: the brighter one always, the other one by its share, or else the brighter one.
//!
//! Where the horizon cuts the cone, pairs are as frequent as before, and what they bring varies from n.z on; where its middle is
//! below the horizon, points nearer to the middle than all that is seen are left out.

use super::{elliptic_cone::EllipticCone, larger};
use crate::math::{DVec3, sin_cos_wide};
use std::f64::consts::{PI, TAU};

/// A cosine that no difference of directions in f32 can tell from 0.
const GRAZING: f64 = 1e-8;
/// Least range of squares of distances from the middle that is seen: a smaller one is lost in rounding.
const LEAST_RANGE: f64 = 1e-4;
/// The first number's digits beyond these, 10 of its 24, choose of two opposite points.
const COARSE: f64 = 16_384.0;
/// Half of the last digit.
const HALF: f64 = 0.5 / 1024.0;

/// What of a cone is above a horizon.
#[derive(Debug)]
pub(super) struct ProjectedCone<'a> {
    cone: &'a EllipticCone,
    normal: DVec3,
    /// The normal's part along the cone's axis.
    up: f64,
    /// Least square of the distance from the ellipse's middle, over its half axes, where something is seen.
    from: f64,
}

impl<'a> ProjectedCone<'a> {
    /// `None` where nothing, or next to nothing, is above the horizon of the unit vector `normal`.
    pub fn new(cone: &'a EllipticCone, normal: DVec3) -> Option<Self> {
        let up = cone.axis.dot(normal);
        let from = if up > 0.0 { 0.0 } else { Self::nearest(cone, normal, up) };
        (from < 1.0 - LEAST_RANGE).then_some(Self { cone, normal, up, from })
    }

    /// The horizon is where a quadratic form of the point on the ellipse is the square of `up`.
    fn nearest(cone: &EllipticCone, normal: DVec3, up: f64) -> f64 {
        let [x, y] = [0, 1].map(|i| cone.half[i] * normal.dot(cone.across[i]));
        let [a, b] = cone.half.map(|half| up * up * half * half);
        let (xx, yy) = (x * x + a, y * y + b);
        let lean = (0.25 * (xx - yy) * (xx - yy) + x * x * y * y).sqrt();
        up * up / larger(0.5 * (xx + yy) + lean, f64::MIN_POSITIVE)
    }

    /// What a direction and its opposite bring, times the former's z.
    #[inline(always)]
    fn pair(&self, direction: DVec3) -> [f64; 2] {
        let (cosine, z) = (direction.dot(self.normal), direction.dot(self.cone.axis));
        [larger(cosine, GRAZING), larger(2.0 * self.up * z - cosine, GRAZING)]
    }

    /// Density per solid angle with which [`Self::sample`] draws a direction of the cone, above 0 also for one on the horizon.
    pub fn density(&self, direction: DVec3) -> f64 {
        let [a, b] = self.cone.half;
        let [x, y] = self.cone.locate(direction);
        if x * x + y * y < self.from {
            return 0.0;
        }
        let [own, opposite] = self.pair(direction);
        let z = larger(direction.dot(self.cone.axis), GRAZING);
        2.0 * z * own / ((own + opposite) * PI * a * b * (1.0 - self.from))
    }

    /// A direction, unit, for `u` in [0, 1)^2.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        let [a, b] = self.cone.half;
        let (sin, cos) = sin_cos_wide(TAU * u[1]);
        let r = (self.from + (1.0 - self.from) * u[0]).sqrt();
        let (x, y) = (a * r * cos, b * r * sin);
        let z = larger(1.0 - x * x - y * y, 0.0).sqrt();
        let direction = self.cone.direction(x, y, z);
        let [own, opposite] = self.pair(direction);
        let chance = (u[0] * COARSE).fract() + HALF;
        if chance * (own + opposite) < 2.0 * own { direction } else { self.cone.direction(-x, -y, z) }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::disallowed_methods)]

    use super::*;
    use crate::math::dvec3;

    /// Cones over unit disks from near and far, and horizons that do not cut them, cut them above and below their middles, and hide
    /// all but a bit.
    fn scenes() -> impl Iterator<Item = (EllipticCone, DVec3)> {
        let apexes = [[0.0, 0.7], [0.6, 0.004], [0.99, 0.004], [1.2, 0.1], [0.3, 40.0], [50.0, 0.5]];
        apexes.into_iter().flat_map(|[aside, height]| {
            let apex = dvec3(0.6 * aside, -0.8 * aside, height);
            let cone = EllipticCone::of_disk(-apex, DVec3::Z, height, 1.0);
            (0..300).map(move |i| {
                let (tilt, turn) = (f64::from(i) * 1.3, f64::from(i) * 2.7);
                // Horizons near the cone's axis first, then all.
                let tilt = if i < 200 { 0.5 * PI + cone.half[1].asin() * tilt.sin() } else { tilt };
                let normal =
                    cone.axis * tilt.cos() + (cone.across[0] * turn.cos() + cone.across[1] * turn.sin()) * tilt.sin();
                (cone, normal)
            })
        })
    }

    /// By the midpoint rule over what of the ellipse is drawn from.
    #[test]
    fn densities_are_normed() {
        let mut seen = 0;
        for (cone, normal) in scenes() {
            let Some(projected) = ProjectedCone::new(&cone, normal) else { continue };
            seen += 1;
            let [a, b] = cone.half;
            let side = 120;
            let mut integral = 0.0;
            for i in 0..side * side {
                let [s, t] = [i % side, i / side].map(|k| (f64::from(k) + 0.5) / f64::from(side));
                let r = (projected.from + (1.0 - projected.from) * s).sqrt();
                let (sin, cos) = (TAU * t).sin_cos();
                let (x, y) = (a * r * cos, b * r * sin);
                let z = (1.0 - x * x - y * y).max(0.0).sqrt();
                integral += projected.density(cone.direction(x, y, z)) / z;
            }
            integral *= PI * a * b * (1.0 - projected.from) / f64::from(side * side);
            assert!((integral - 1.0).abs() < 1e-9, "{cone:?} {normal}: {integral}");
        }
        assert!(seen > 1000, "{seen}");
    }

    /// Nothing above the horizon is nearer to the middle than what is drawn from.
    #[test]
    fn what_is_seen_is_drawn_from() {
        for (cone, normal) in scenes() {
            let least = ProjectedCone::new(&cone, normal).map_or(1.0 - LEAST_RANGE, |projected| projected.from);
            let [a, b] = cone.half;
            for i in 0..400 {
                let (sin, cos) = (TAU * f64::from(i) / 400.0).sin_cos();
                let r = least.sqrt() * (1.0 - 1e-9);
                let (x, y) = (a * r * cos, b * r * sin);
                let direction = cone.direction(x, y, (1.0 - x * x - y * y).max(0.0).sqrt());
                assert!(least == 0.0 || direction.dot(normal) < 1e-9, "{cone:?} {normal} {i}");
            }
        }
    }
}
