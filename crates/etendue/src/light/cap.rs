//! Caps of the sphere of directions, sampled by projected solid angle.
//!
//! What is seen of a round light is a cap about the direction of its middle. Projected along the normal onto the unit disk, what is
//! above the horizon is an ellipse, or where the horizon cuts it a part of one next to a segment of the disk (Ureña and Georgiev,
//! "Stratified Sampling of Projected Spherical Caps", 2018; Peters and Dachsbacher, "Sampling Projected Spherical Caps in Real Time",
//! 2019). A point that is uniform there is a direction with a density in proportion to the cosine.

use super::{between, larger};
use crate::math::{DVec3, Frame, atan2_wide, exp_wide, ln_wide, sin_cos_wide};
use std::f64::consts::PI;

/// Least sine of the half angle: what is smaller has about the same cosine everywhere.
const LEAST_SINE: f64 = 0.01;
/// Least area of what the horizon leaves, over the square of that sine: below, differences lose too much.
const LEAST_AREA: f64 = 1e-6;
/// A cosine that no difference of directions in f32 can tell from 0.
const GRAZING: f64 = 1e-8;

/// A cap and what of its projection is above the horizon. Its functions have no branches but for caps whose middle is below.
#[derive(Clone, Copy)]
pub(super) struct ProjectedCap {
    normal: DVec3,
    /// In the horizon's plane: below the middle of the cap, and across.
    x_axis: DVec3,
    y_axis: DVec3,
    /// The ellipse: its middle on the x axis, and half axes.
    middle: f64,
    half: [f64; 2],
    /// The y of where the ellipse touches the disk's edge, or 0.
    top: f64,
    /// Area of what is seen of the ellipse. The rest is a segment of the disk.
    left: f64,
    /// On the disk, above 0.
    pub area: f64,
    /// The middle is above the horizon.
    pub is_up: bool,
}

impl ProjectedCap {
    /// About the unit vector `axis`, with this sine of the half angle, below a right angle, over the horizon of the unit vector
    /// `normal`; false where directions that are uniform in the cap serve as well, or none is above the horizon.
    #[inline(always)]
    pub fn look(axis: DVec3, sine: f64, normal: DVec3) -> (Self, bool) {
        let cosine = larger((1.0 - sine) * (1.0 + sine), 0.0).sqrt();
        let up = axis.dot(normal);
        let flat = axis - normal * up;
        let across = flat.length();
        let is_inclined = across > 1e-9;
        let (inclined, any) = (flat / larger(across, 1e-9), Frame::from_normal(normal.as_vec3()).s.as_dvec3());
        let pick = |inclined: f64, any: f64| if is_inclined { inclined } else { any };
        let x_axis = DVec3::new(pick(inclined.x, any.x), pick(inclined.y, any.y), pick(inclined.z, any.z));
        let (middle, half) = (cosine * across, [sine * up.abs(), sine]);
        // Where the cap's edge does not meet the horizon, the ellipse is seen whole.
        let is_cut = cosine < across;
        let touches = if is_cut { cosine / larger(across, 1e-9) } else { 1.0 };
        let top = larger((1.0 - touches) * (1.0 + touches), 0.0).sqrt();
        let on_ellipse = between(cosine * up.abs() / (sine * larger(across, 1e-9)), 0.0, 1.0);
        let beyond = half[0] * half[1] * segment(if is_cut { on_ellipse } else { 1.0 });
        let is_up = up >= 0.0;
        let left = if is_up { PI * half[0] * half[1] - beyond } else { 0.0 };
        // Below the horizon: of the segment what is not ellipse.
        let area = left + segment(touches) - if is_up { 0.0 } else { beyond };
        let y_axis = normal.cross(x_axis);
        let is_usable = (sine >= LEAST_SINE) & (area > LEAST_AREA * sine * sine);
        (Self { normal, x_axis, y_axis, middle, half, top, left, area, is_up }, is_usable)
    }

    /// Density per solid angle of a direction in the cap, above 0 also for one that is drawn on the horizon.
    #[inline(always)]
    pub fn density(&self, direction: DVec3) -> f64 {
        larger(direction.dot(self.normal), GRAZING) / self.area
    }

    /// A direction, unit length, for `u` in [0, 1)^2. Only if the cap's middle is above the horizon.
    #[inline(always)]
    pub fn sample_up(&self, u: [f64; 2]) -> DVec3 {
        let (reached, side) = (u[0] * self.area, 2.0 * u[1] - 1.0);
        let on_ellipse = reached < self.left;
        let share = reached / larger(self.half[0] * self.half[1], f64::MIN_POSITIVE);
        let (sin, cos) = sin_cos_wide(segment_angle(if on_ellipse { share } else { self.area - reached }));
        let x = if on_ellipse { self.middle - self.half[0] * cos } else { cos };
        let y = side * sin * if on_ellipse { self.half[1] } else { 1.0 };
        self.direction(x, y)
    }

    /// As [`Self::sample_up`], wherever the middle is.
    pub fn sample(&self, u: [f64; 2]) -> DVec3 {
        if self.is_up {
            return self.sample_up(u);
        }
        // What the disk has more than the ellipse, a moon, is alike on both sides of the x axis.
        let reached = (2.0 * u[0] - 1.0) * 0.5 * self.area;
        let y = moon_at(self.middle, self.half, self.top, reached.abs()).copysign(reached);
        let (from, to) = moon_row(self.middle, self.half, y);
        self.direction(from + (to - from) * u[1], y)
    }

    #[inline(always)]
    fn direction(&self, x: f64, y: f64) -> DVec3 {
        let up = larger(1.0 - x * x - y * y, 0.0).sqrt();
        let direction = self.x_axis * x + self.y_axis * y + self.normal * up;
        direction / direction.length()
    }
}

/// Area of the unit disk right of `x`.
#[inline(always)]
fn segment(x: f64) -> f64 {
    let y = larger((1.0 - x) * (1.0 + x), 0.0).sqrt();
    atan2_wide(y, x) - x * y
}

/// The angle t whose cosine has so much area of the unit disk right of it, in [0, pi]: t - sin(t) cos(t).
#[inline(always)]
fn segment_angle(area: f64) -> f64 {
    let area = between(area, 0.0, PI);
    let is_most = area > 0.5 * PI;
    let small = if is_most { PI - area } else { area };
    // The first term of its series, a fit to within 2e-4, and one step of Newton's method.
    let root = exp_wide(ln_wide((1.5 * small) as f32) / 3.0);
    let z = root * root;
    let fit = 0.066_347_86 + z * (0.013_528_47 + z * (-0.001_100_88 + z * 0.002_696_06));
    let t = root * (1.0 + z * fit);
    let (sin, cos) = sin_cos_wide(t);
    let t = between(t - (t - sin * cos - small) / larger(2.0 * sin * sin, 1e-30), 0.0, 0.5 * PI);
    if is_most { PI - t } else { t }
}

/// Where a row of the moon begins and ends.
fn moon_row(middle: f64, half: [f64; 2], y: f64) -> (f64, f64) {
    let on = y / half[1];
    let from = middle + half[0] * larger((1.0 - on) * (1.0 + on), 0.0).sqrt();
    let to = larger((1.0 - y) * (1.0 + y), 0.0).sqrt();
    (from, larger(to, from))
}

/// Area of the moon from its middle row to that at `y`, and the length of that row.
fn moon(middle: f64, half: [f64; 2], y: f64) -> [f64; 2] {
    // Below the unit circle, from its top point on.
    let under = |y: f64| {
        let x = larger((1.0 - y) * (1.0 + y), 0.0).sqrt();
        0.5 * (atan2_wide(y, x) + x * y)
    };
    let (from, to) = moon_row(middle, half, y);
    [under(y) - middle * y - half[0] * half[1] * under(between(y / half[1], 0.0, 1.0)), to - from]
}

/// The row up to which the moon has this area from its middle row.
fn moon_at(middle: f64, half: [f64; 2], top: f64, area: f64) -> f64 {
    let (mut low, mut high) = (0.0, top);
    let mut y = 0.5 * top;
    // Newton's method, halving the interval where that leaves it: rows vanish at the top.
    for _ in 0..60 {
        let [reached, row] = moon(middle, half, y);
        let off = reached - area;
        if off > 0.0 {
            high = y
        } else {
            low = y
        }
        let next = y - off / row;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        let step = (next - y).abs();
        y = next;
        if step <= 1e-12 * top {
            break;
        }
    }
    y
}

#[cfg(test)]
mod tests {
    #![allow(clippy::disallowed_methods)]

    use super::*;
    use crate::math::dvec3;

    /// Caps at all heights over the horizon, whole, cut, and but for their tops below it.
    fn caps() -> impl Iterator<Item = (f64, f64, ProjectedCap)> {
        let sines = [0.0101f64, 0.05, 0.3, 0.7, 0.95, 0.9999];
        sines.into_iter().flat_map(|sine| {
            (-40..=40).filter_map(move |i| {
                let half = sine.asin();
                let over = if i == 40 { 0.5 * PI } else { half * f64::from(i) / 30.0 };
                let axis = dvec3(0.6 * over.cos(), over.sin(), 0.8 * over.cos());
                let (cap, is_usable) = ProjectedCap::look(axis, sine, DVec3::Y);
                (is_usable && over.abs() <= 0.5 * PI).then_some((half, over, cap))
            })
        })
    }

    /// Against the integral over the cap's rings: each is above the horizon where its cosine with the normal is.
    #[test]
    fn areas_are_projected_solid_angles() {
        let mut shapes = [0; 3];
        for (half, over, cap) in caps() {
            let rings = 4000;
            let integral: f64 = (0..rings)
                .map(|i| {
                    let t = half * (f64::from(i) + 0.5) / f64::from(rings);
                    let (a, b) = (t.cos() * over.sin(), t.sin() * over.cos());
                    // The ring's mean of max(a + b cos(phi), 0).
                    let above = if a >= b {
                        PI * a
                    } else if a <= -b {
                        0.0
                    } else {
                        let end = (-a / b).acos();
                        a * end + b * end.sin()
                    };
                    2.0 * above * t.sin() * half / f64::from(rings)
                })
                .sum();
            assert!((cap.area / integral - 1.0).abs() < 2e-3, "{half} {over}: {}, not {integral}", cap.area);
            shapes[if cap.is_up { usize::from(cap.top > 0.0) } else { 2 }] += 1;
        }
        assert!(shapes.iter().all(|count| *count > 20), "{shapes:?}");
    }

    /// All directions are in the cap and above the horizon, the extreme numbers among them.
    #[test]
    fn directions_are_in_the_cap() {
        const LAST: f64 = 1.0 - f64::EPSILON;
        for (half, over, cap) in caps() {
            let axis = dvec3(0.6 * over.cos(), over.sin(), 0.8 * over.cos());
            for i in 0..=20 {
                for j in 0..=20 {
                    let u = [i, j].map(|i: u8| (f64::from(i) / 20.0).min(LAST));
                    let d = cap.sample(u);
                    let chord = 2.0 * (0.5 * half).sin();
                    assert!((d - axis).length() < chord + 1e-6 && d.y > -1e-9, "{half} {over} {u:?}: {d}");
                }
            }
        }
    }

    #[test]
    fn segments_are_inverted() {
        for i in 0..=1000 {
            let t = PI * f64::from(i) / 1000.0;
            let found = segment_angle(t - t.sin() * t.cos());
            // Near pi the area tells the angle badly: all of it but for the cube of the difference.
            assert!((found - t).abs() < if i < 980 { 2e-7 } else { 2e-5 }, "{t}: {found}");
        }
    }
}
