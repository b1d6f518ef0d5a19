//! The cone under which a disk is seen.
//!
//! In the plane through the disk's axis and the context the cone's edges go to the nearest and the farthest point of the rim, so that
//! its own axis halves the angle between them. Along that axis, on the unit disk across it, the cone is an ellipse; in these
//! coordinates (x, y), with z the cosine to the axis, an element of solid angle is dx dy / z. What the context's surface gathers
//! from there is dealt with in [`ProjectedCone`](super::projected_cone::ProjectedCone).

use super::{between, larger};
use crate::math::{DVec3, sin_cos_wide};
use std::f64::consts::{PI, TAU};

/// Directions d with (d.x / a)^2 + (d.y / b)^2 <= 1 and d.z > 0 in the frame of its axes, a <= b.
#[derive(Clone, Copy, Debug)]
pub(super) struct EllipticCone {
    /// Along the ellipse's half axes; the second is in the disk's plane. Unit.
    pub across: [DVec3; 2],
    /// In its middle, unit.
    pub axis: DVec3,
    /// The ellipse's half axes: sines of the least and the greatest half angle, in (0, 1].
    pub half: [f64; 2],
}

impl EllipticCone {
    /// Of the disk about `center`, relative to the apex, across the unit vector `normal`, which points to the apex's side; `height` of
    /// the apex over the disk's plane, above 0. Metres.
    pub fn of_disk(center: DVec3, normal: DVec3, height: f64, radius: f64) -> Self {
        let flat = center - normal * center.dot(normal);
        let aside = flat.length();
        let is_aside = aside > 1e-9 * (height + radius);
        let (aside, out) = if is_aside { (aside, flat / aside) } else { (0.0, normal.any_orthonormal_vector()) };
        // In the plane of `out` and `normal`: the ends of the disk, their distances, and unit vectors to them.
        let ends = [aside - radius, aside + radius];
        let [near, far] = ends.map(|end| (end * end + height * height).sqrt());
        let sum = [ends[0] / near + ends[1] / far, -height * (1.0 / near + 1.0 / far)];
        let chord = [ends[1] / far - ends[0] / near, height * (1.0 / near - 1.0 / far)];
        let (sum_length, chord_length) = (length(sum), length(chord));
        // Each where it is not the difference of nearly the same numbers.
        let is_narrow = sum_length > chord_length;
        let along =
            if is_narrow { sum.map(|x| x / sum_length) } else { [chord[1] / chord_length, -chord[0] / chord_length] };
        let sine = 2.0 * radius * (height / near / far);
        let least = if is_narrow { sine / sum_length } else { 0.5 * chord_length };
        // Where the axis meets the disk, half of the disk's width there.
        let reach = height / -along[1];
        let width = 2.0 * radius * (near / (near + far)) * (far / near).sqrt();
        let greatest = width / length([reach, width]);
        let half = [between(least, f64::MIN_POSITIVE, 1.0), between(greatest, f64::MIN_POSITIVE, 1.0)];
        Self {
            across: [out * -along[1] + normal * along[0], out.cross(normal)],
            axis: out * along[0] + normal * along[1],
            half: [half[0].min(half[1]), half[1]],
        }
    }

    /// The direction at a point of the ellipse, unit; `z` is its cosine with the axis.
    pub fn direction(&self, x: f64, y: f64, z: f64) -> DVec3 {
        let direction = self.across[0] * x + self.across[1] * y + self.axis * z;
        direction / direction.length()
    }

    /// Where a direction is on the ellipse, over the half axes.
    pub fn locate(&self, direction: DVec3) -> [f64; 2] {
        [0, 1].map(|i| direction.dot(self.across[i]) / self.half[i])
    }

    /// A direction, unit, for `u` in [0, 1)^2. Angles on the ellipse, as multiples of its half axes, are even; along each, solid angle.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        let [a, b] = self.half;
        let (sin, cos) = sin_cos_wide(TAU * u[1]);
        let share = a * a * cos * cos + b * b * sin * sin;
        let root = larger(1.0 - share, 0.0).sqrt();
        let versine = u[0] * share / (1.0 + root);
        let r = (u[0] * (2.0 - versine) / (1.0 + root)).sqrt();
        self.direction(a * r * cos, b * r * sin, 1.0 - versine)
    }

    /// Density per solid angle with which [`Self::sample`] draws a direction of the cone: within a factor of two of even.
    pub fn density(&self, direction: DVec3) -> f64 {
        let [a, b] = self.half;
        let [x, y] = self.locate(direction);
        let square = x * x + y * y;
        let share = if square > 0.0 { (a * a * x * x + b * b * y * y) / square } else { a * b };
        (1.0 + larger(1.0 - share, 0.0).sqrt()) / (2.0 * PI * a * b)
    }
}

fn length([x, y]: [f64; 2]) -> f64 {
    (x * x + y * y).sqrt()
}

#[cfg(test)]
mod tests {
    #![allow(clippy::disallowed_methods)]

    use super::*;
    use crate::math::dvec3;

    /// Disks of radius 1 in the plane z = 0 from heights and distances aside of all sizes.
    fn cones() -> impl Iterator<Item = (DVec3, EllipticCone)> {
        let sizes = [0.0, 1e-6, 0.01, 0.5, 0.99, 1.0, 1.01, 2.0, 40.0, 1e5];
        let heights = [1e-6, 1e-3, 0.1, 1.0, 7.0, 300.0, 1e6];
        sizes.into_iter().flat_map(move |aside| {
            heights.into_iter().map(move |height| {
                let apex = dvec3(0.6 * aside, -0.8 * aside, height);
                (apex, EllipticCone::of_disk(-apex, DVec3::Z, height, 1.0))
            })
        })
    }

    #[test]
    fn rims_are_on_the_ellipse() {
        for (apex, cone) in cones() {
            let [a, b] = cone.half;
            assert!(a > 0.0 && a <= b && b <= 1.0, "{cone:?}");
            let [x, y] = cone.across;
            assert!(x.cross(y).distance(cone.axis) < 1e-9 && x.dot(y).abs() < 1e-12, "{cone:?}");
            for i in 0..100 {
                let (sin, cos) = (TAU * f64::from(i) / 100.0).sin_cos();
                let direction = (dvec3(cos, sin, 0.0) - apex).normalize();
                let [x, y] = cone.locate(direction);
                // Rounding of the direction, over the ellipse's least half axis.
                let slack = 1e-6 + 1e-14 / a;
                assert!(((x * x + y * y).sqrt() - 1.0).abs() < slack, "{apex}: {x} {y} of {cone:?}");
                assert!(direction.dot(cone.axis) > -1e-12, "{apex} {cone:?}");
            }
        }
    }

    /// By the midpoint rule over the disk.
    #[test]
    fn densities_are_normed() {
        for (apex, cone) in cones().filter(|(apex, _)| apex.z > 0.05 && apex.length() < 1e3) {
            let side = 600;
            let mut integral = 0.0;
            for i in 0..side * side {
                let [s, t] = [i % side, i / side].map(|k| (f64::from(k) + 0.5) / f64::from(side));
                let (sin, cos) = (TAU * t).sin_cos();
                let offset = dvec3(s * cos, s * sin, 0.0) - apex;
                let distance = offset.length();
                let solid_angle = apex.z / (distance * distance * distance) * s * TAU / f64::from(side * side);
                integral += cone.density(offset / distance) * solid_angle;
            }
            assert!((integral - 1.0).abs() < 2e-3, "{apex}: {integral}");
        }
    }
}
