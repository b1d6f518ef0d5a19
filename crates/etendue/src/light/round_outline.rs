//! Flat polygons that are nearly disks.

use crate::math::{DVec2, DVec3, dvec2};
use std::{f64::consts::PI, sync::Arc};

/// Least share of the circle about a polygon that it covers: regular ones of eight corners do.
const LEAST_COVER: f64 = 0.9;

/// A flat polygon, all of whose rim is seen from its middle, and the circle about it.
#[derive(Clone, Debug, PartialEq)]
pub struct RoundOutline {
    center: DVec3,
    /// Unit.
    normal: DVec3,
    /// In the plane, unit.
    axes: [DVec3; 2],
    radius: f64,
    area: f64,
    /// Of the greatest circle about the middle that is all within.
    inner: f64,
    /// By ascending angles, counter-clockwise as seen from where the normal points.
    corners: Arc<[Corner]>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Corner {
    /// In (-pi, pi].
    angle: f64,
    at: DVec2,
}

impl RoundOutline {
    /// Of the corners around, metres, which are taken to be in a plane; the normal points to where they are seen to run
    /// counter-clockwise. `None` unless they cover nine tenths of the circle about the middle of their area, and run around it just
    /// once.
    pub fn new(rim: &[DVec3]) -> Option<Self> {
        let first = *rim.first()?;
        let fans: Vec<[DVec3; 2]> = rim.windows(2).map(|pair| [pair[0] - first, pair[1] - first]).collect();
        let cross: DVec3 = fans.iter().map(|[a, b]| a.cross(*b)).sum();
        let normal = cross.try_normalize()?;
        let area = 0.5 * cross.length();
        let moment: DVec3 = fans.iter().map(|[a, b]| (*a + *b) * a.cross(*b).dot(normal)).sum();
        let center = first + moment / (6.0 * area);
        let x_axis = normal.any_orthonormal_vector();
        let axes = [x_axis, normal.cross(x_axis)];
        let flat = |corner: &DVec3| on_axes(axes, *corner - center);
        let points: Vec<DVec2> = rim.iter().map(flat).collect();
        let radius = points.iter().map(|point| point.length()).fold(0.0, f64::max);
        let is_round = area >= LEAST_COVER * PI * radius * radius && area.is_finite() && center.is_finite();
        let corners = around(points).filter(|_| is_round)?;
        let inner = sides(&corners).map(|[a, b]| (a.perp_dot(b)) / (b - a).length()).fold(f64::INFINITY, f64::min);
        Some(Self { center, normal, axes, radius, area, inner, corners })
    }

    /// Middle of the area, metres.
    pub fn center(&self) -> DVec3 {
        self.center
    }

    /// Unit length.
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// Of the circle about the polygon, metres.
    pub fn radius(&self) -> f64 {
        self.radius
    }

    /// Of the polygon, m^2.
    pub fn area(&self) -> f64 {
        self.area
    }

    /// The polygon's corners, metres, counter-clockwise as seen from where the normal points.
    pub fn rim(&self) -> impl Iterator<Item = DVec3> + '_ {
        self.corners.iter().map(|corner| self.center + self.axes[0] * corner.at.x + self.axes[1] * corner.at.y)
    }

    /// True if a point of the plane, relative to the middle, is in the polygon.
    #[inline]
    pub fn contains(&self, point: DVec3) -> bool {
        let point = on_axes(self.axes, point);
        point.length_squared() <= self.inner * self.inner || self.contains_outer(point)
    }

    fn contains_outer(&self, point: DVec2) -> bool {
        let angle = libm::atan2(point.y, point.x);
        let count = self.corners.len();
        let next = self.corners.partition_point(|corner| corner.angle <= angle) % count;
        let [a, b] = [(next + count - 1) % count, next].map(|i| self.corners[i].at);
        (b - a).perp_dot(point - a) >= 0.0
    }
}

fn on_axes([x, y]: [DVec3; 2], vector: DVec3) -> DVec2 {
    dvec2(vector.dot(x), vector.dot(y))
}

/// The corners from the one with the least angle on; `None` if they do not run once around the origin.
fn around(points: Vec<DVec2>) -> Option<Arc<[Corner]>> {
    let mut corners: Vec<Corner> = points.into_iter().map(|at| Corner { angle: libm::atan2(at.y, at.x), at }).collect();
    let least = corners.iter().enumerate().min_by(|a, b| a.1.angle.total_cmp(&b.1.angle))?.0;
    corners.rotate_left(least);
    let ascends = corners.windows(2).all(|pair| pair[0].angle < pair[1].angle);
    let turns = sides(&corners).all(|[a, b]| a.perp_dot(b) > 0.0);
    (ascends && turns).then(|| corners.into())
}

fn sides(corners: &[Corner]) -> impl Iterator<Item = [DVec2; 2]> {
    let next = corners.iter().skip(1).chain(corners.first());
    corners.iter().zip(next).map(|(a, b)| [a.at, b.at])
}

#[cfg(test)]
mod tests {
    #![allow(clippy::disallowed_methods)]

    use super::*;
    use crate::math::dvec3;

    /// A polygon of `count` corners at these distances from (3, 2, 1), in a slanting plane.
    fn polygon(count: u32, radius: impl Fn(u32) -> f64) -> Vec<DVec3> {
        let normal = DVec3::new(0.36, 0.48, 0.8);
        let x = normal.any_orthonormal_vector();
        let y = normal.cross(x);
        let corner = |i: u32| {
            let (sin, cos) = (2.0 * PI * f64::from(i) / f64::from(count)).sin_cos();
            DVec3::new(3.0, 2.0, 1.0) + (x * cos + y * sin) * radius(i)
        };
        (0..count).map(corner).collect()
    }

    #[test]
    fn regular_polygons_are_round_from_eight_corners_on() {
        for count in 3..200 {
            let outline = RoundOutline::new(&polygon(count, |_| 0.7));
            assert_eq!(outline.is_some(), count >= 8, "{count}");
            let Some(outline) = outline else { continue };
            assert!((outline.center() - DVec3::new(3.0, 2.0, 1.0)).length() < 1e-6);
            assert!((outline.normal() - DVec3::new(0.36, 0.48, 0.8)).length() < 1e-5);
            assert!((outline.radius() - 0.7).abs() < 1e-6);
            let n = f64::from(count);
            let area = 0.5 * n * 0.49 * (2.0 * PI / n).sin();
            assert!((outline.area() - area).abs() < 1e-6, "{count}");
        }
    }

    /// As often as the area says, and by which side of each edge a point is on.
    #[test]
    fn points_are_within_or_without() {
        for (count, radius) in [(8, 0.0), (12, 0.01), (64, 0.0), (50, 0.03)] {
            let rim = polygon(count, |i| 1.0 + radius * (f64::from(i) * 2.3).sin());
            let outline = RoundOutline::new(&rim).expect("is round");
            let corners: Vec<DVec2> = rim.iter().map(|c| on_axes(outline.axes, *c - outline.center)).collect();
            let mut within = 0;
            let side = 400;
            for i in 0..side * side {
                let at = [i % side, i / side].map(|k| 2.2 * (f64::from(k) + 0.5) / f64::from(side) - 1.1);
                let point = dvec2(at[0], at[1]);
                // The number of edges that a ray along x meets.
                let crossings = corners.iter().zip(corners.iter().cycle().skip(1)).filter(|(a, b)| {
                    let (low, high) = (a.y.min(b.y), a.y.max(b.y));
                    let reach = a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x);
                    point.y >= low && point.y < high && reach > point.x
                });
                let expected = crossings.count() % 2 == 1;
                within += u32::from(expected);
                let world = outline.axes[0] * point.x + outline.axes[1] * point.y;
                assert_eq!(outline.contains(world), expected, "{count}: {point}");
            }
            let area = f64::from(within) * 2.2 * 2.2 / f64::from(side * side);
            assert!((area / outline.area() - 1.0).abs() < 1e-3);
        }
    }

    #[test]
    fn what_is_not_round_is_refused() {
        let ellipse: Vec<DVec3> = polygon(64, |_| 1.0).iter().map(|c| dvec3(c.x, 1.2 * c.y, c.z)).collect();
        assert_eq!(RoundOutline::new(&ellipse), None);
        assert_eq!(RoundOutline::new(&polygon(64, |i| if i / 5 == 2 { 0.3 } else { 1.0 })), None, "a bite");
        let mut back = polygon(64, |_| 1.0);
        back.swap(7, 8);
        assert_eq!(RoundOutline::new(&back), None, "a rim that goes back");
        let twice = [polygon(64, |_| 1.0), polygon(64, |_| 1.0)].concat();
        assert_eq!(RoundOutline::new(&twice), None, "twice around");
        assert_eq!(RoundOutline::new(&[]), None);
        assert_eq!(RoundOutline::new(&[DVec3::ONE; 9]), None);
        assert_eq!(RoundOutline::new(&polygon(64, |_| f64::INFINITY)), None);
        assert_eq!(RoundOutline::new(&polygon(64, |i| if i == 3 { f64::NAN } else { 1.0 })), None);
        let huge: Vec<DVec3> = polygon(64, |_| 1e30).iter().map(|c| *c * 1e150).collect();
        assert_eq!(RoundOutline::new(&huge), None);
    }
}
