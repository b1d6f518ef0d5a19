//! Lights seen along a circle of directions, as brushed metal sees them: in arcs.
//!
//! A direction of the circle is `d(phi) = radius (cos(phi) x + sin(phi) z) + along y`, phi in (0, pi). A flat light with corners
//! is where d is on the inner side of the planes through the point and each edge, a sphere where d is within its cone: each
//! condition holds on one interval of the circle, so what is left are few arcs. On them phi is drawn in proportion to the
//! density of the metal's tilts ([`CosinePower`]), which leaves little for the weight to do: colours, shadows,
//! and what the grooves' form does at the horizon.

use super::{LightContext, elliptic_cone::EllipticCone, polynomial::unit_roots};
use crate::{
    bsdf::Circle,
    math::{DVec3, Frame, Vec3},
    sampling::CosinePower,
};
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// A circle of directions from a point, world space.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LightCircle {
    /// The point that gathers, metres.
    pub point: Vec3,
    /// Orthonormal: across the grooves, along them, and away from the surface on the side that is seen.
    axes: [DVec3; 3],
    radius: f64,
    along: f64,
    /// Angle of the mirror direction, radians.
    mirror: f64,
    tilts: CosinePower,
}

/// Below this share of the lobe an arc is not sampled: differences of masses have no more digits.
const LEAST_MASS: f64 = 1e-10;
/// On arcs where the density's logarithm changes by less, the density is taken as even: it is, to the square of this over 24.
const EVEN: f64 = 1e-3;

impl LightCircle {
    /// The `circle` of the local `frame` at a point.
    pub fn new(point: Vec3, frame: &Frame, circle: &Circle) -> Self {
        // A frame in f32 is orthonormal within its rounding only; small lights need more.
        let normal = frame.n.as_dvec3().normalize();
        let tangent = frame.s.as_dvec3();
        let x = (tangent - normal * normal.dot(tangent)).normalize();
        let axes = [x, normal.cross(x), normal * circle.side];
        Self { point, axes, radius: circle.radius, along: circle.along, mirror: circle.mirror, tilts: circle.tilts }
    }

    /// The unit vector at `phi` radians.
    #[inline]
    pub fn direction(&self, phi: f64) -> DVec3 {
        let [x, y, z] = self.axes;
        let (sin, cos) = libm::sincos(phi);
        (x * cos + z * sin) * self.radius + y * self.along
    }

    /// The angle of a direction on the circle, in (-pi, pi].
    #[inline]
    pub fn angle(&self, direction: Vec3) -> f64 {
        let direction = direction.as_dvec3();
        libm::atan2(direction.dot(self.axes[2]), direction.dot(self.axes[0]))
    }

    /// What lights need to know of the point; no direction is behind it.
    #[inline]
    pub(super) fn context(&self) -> LightContext {
        LightContext { point: self.point, normal: Vec3::ZERO, transmits: true, time: 0.0 }
    }

    /// Density of tilts at `phi`, per radian.
    #[inline]
    pub(super) fn density(&self, phi: f64) -> f64 {
        let sin = libm::sin(0.5 * (phi - self.mirror));
        self.tilts.density(sin * sin)
    }

    /// The density's integral over the arcs, without those that have too little of it to be sampled.
    pub(super) fn mass(&self, arcs: &Arcs) -> f64 {
        arcs.iter().map(|&arc| self.mass_of(arc)).sum()
    }

    #[inline]
    fn mass_of(&self, arc: [f64; 2]) -> f64 {
        if self.is_even(arc) {
            return (arc[1] - arc[0]) * self.density(0.5 * (arc[0] + arc[1]));
        }
        let [from, to] = arc.map(|phi| self.tilts.mass(0.5 * (phi - self.mirror)));
        if to - from >= LEAST_MASS { to - from } else { 0.0 }
    }

    /// True where the density is nearly the same all along: arcs so small that masses would cancel.
    #[inline]
    fn is_even(&self, [from, to]: [f64; 2]) -> bool {
        let width = 0.5 * (to - from);
        let tilt = 0.5 * (from - self.mirror).abs().max((to - self.mirror).abs());
        // The logarithm's slope is k tan(tilt), and tan(x) <= x (pi/2) / (pi/2 - x).
        tilt < FRAC_PI_2 && width * (1.0 + self.tilts.exponent() * tilt * FRAC_PI_2 / (FRAC_PI_2 - tilt)) < EVEN
    }

    /// The angle on the arcs below which there is the share `u` of their `mass`.
    pub(super) fn sample(&self, arcs: &Arcs, mass: f64, u: f64) -> Option<f64> {
        let mut left = u * mass;
        let mut last = None;
        for &arc in arcs.iter() {
            let own = self.mass_of(arc);
            if own <= 0.0 {
                continue;
            }
            last = Some(arc);
            if left < own && self.is_even(arc) {
                return Some((arc[0] + left / own * (arc[1] - arc[0])).min(arc[1]));
            }
            if left < own {
                let from = self.tilts.mass(0.5 * (arc[0] - self.mirror));
                let phi = self.mirror + 2.0 * self.tilts.angle(from + left);
                return Some(phi.clamp(arc[0], arc[1]));
            }
            left -= own;
        }
        // Rounding of the sum.
        last.map(|[_, to]| to)
    }

    /// Where the direction is on the inner side of a plane through the point: the clip of [`Arcs::clip`].
    #[inline]
    fn beside(&self, plane: DVec3) -> [f64; 3] {
        let [x, y, z] = self.axes;
        [self.radius * plane.dot(x), self.radius * plane.dot(z), self.along * plane.dot(y)]
    }

    /// The arcs in which a polygon is seen, by planes through the point and its edges.
    pub(super) fn arcs_of_polygon<const N: usize>(&self, edges: &[DVec3; N]) -> Arcs {
        let mut arcs = Arcs::half();
        for &plane in edges {
            arcs.clip(self.beside(plane));
        }
        arcs
    }

    /// The arcs in which a cone about the unit vector `axis` is seen; `versine` is 1 minus the cosine of its half angle.
    pub(super) fn arcs_of_cone(&self, axis: DVec3, versine: f64) -> Arcs {
        let [x, y, z] = self.axes;
        let (cos, sin, height) = (axis.dot(x), axis.dot(z), axis.dot(y));
        let radius = (cos * cos + sin * sin).sqrt();
        // |d - axis|^2 <= 2 versine, the distance split into the part off the circle's plane, the difference of radii and the
        // chord 4 r r' sin^2(angle / 2): precise for the smallest of cones.
        let off = (self.along - height) * (self.along - height) + (self.radius - radius) * (self.radius - radius);
        let chord = (2.0 * versine - off) / (4.0 * self.radius * radius);
        let mut arcs = Arcs::half();
        if chord >= 1.0 {
            return arcs;
        }
        // No number where the sphere is in line with the grooves.
        if chord <= 0.0 || chord.is_nan() {
            return Arcs::default();
        }
        arcs.keep(libm::atan2(sin, cos), 2.0 * libm::asin(chord.sqrt()));
        arcs
    }

    /// The arcs in which an elliptic cone is seen.
    ///
    /// With t the tangent of half the angle from where the circle is nearest to the cone's axis, directions times 1 + t^2 are
    /// quadratic in t, and where they are on the cone is a quartic's root.
    pub(super) fn arcs_of_elliptic_cone(&self, cone: &EllipticCone) -> Arcs {
        let [x, y, z] = self.axes;
        let nearest = libm::atan2(cone.axis.dot(z), cone.axis.dot(x));
        let (sin, cos) = libm::sincos(nearest);
        let (out, along) = ((x * cos + z * sin) * self.radius, (z * cos - x * sin) * self.radius);
        let start = out + y * self.along;
        let on_ellipse = [0, 1].map(|i| {
            let axis = cone.across[i] / cone.half[i];
            [start.dot(axis), 2.0 * along.dot(axis), (start - out * 2.0).dot(axis)]
        });
        let mut quartic = [1.0, 0.0, 2.0, 0.0, 1.0];
        for [p, q, r] in on_ellipse {
            let square = [p * p, 2.0 * p * q, q * q + 2.0 * p * r, 2.0 * q * r, r * r];
            quartic.iter_mut().zip(square).for_each(|(all, own)| *all -= own);
        }
        let mut ends = [0.0; 10];
        let mut count = 1;
        let mut add = |angle: f64| {
            let angle = nearest + angle;
            let angle = if angle > PI {
                angle - TAU
            } else if angle <= -PI {
                angle + TAU
            } else {
                angle
            };
            if angle > 0.0 && angle < PI && count < ends.len() - 1 {
                ends[count] = angle;
                count += 1;
            }
        };
        unit_roots(quartic).iter().for_each(|t| add(2.0 * libm::atan(*t)));
        quartic.reverse();
        unit_roots(quartic).iter().for_each(|t| add(2.0 * libm::atan2(1.0f64.copysign(*t), t.abs())));
        ends[count] = PI;
        let ends = &mut ends[..=count];
        ends.sort_unstable_by(f64::total_cmp);
        Arcs::between(ends, |phi| {
            let direction = self.direction(phi);
            let [x, y] = cone.locate(direction);
            x * x + y * y <= 1.0 && direction.dot(cone.axis) > 0.0
        })
    }
}

/// Planes through the origin and the edges of a polygon around, their normals inward; `front` is across the polygon, of any
/// length.
#[inline]
pub(super) fn edge_planes<const N: usize>(corners: &[DVec3; N], front: DVec3) -> [DVec3; N] {
    let sign = 1.0f64.copysign(corners[0].dot(front));
    std::array::from_fn(|i| corners[i].cross(corners[(i + 1) % N] - corners[i]) * sign)
}

/// Disjoint intervals of (0, pi), in order.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arcs {
    count: usize,
    arcs: [[f64; 2]; Self::MOST],
}

impl Arcs {
    /// A condition of one interval adds one arc at most, and no light has more than four.
    const MOST: usize = 5;

    /// All of (0, pi).
    pub(super) fn half() -> Self {
        let mut arcs = Self::default();
        arcs.push([0.0, PI]);
        arcs
    }

    /// The arcs, radians.
    pub fn iter(&self) -> std::slice::Iter<'_, [f64; 2]> {
        self.arcs[..self.count].iter()
    }

    /// True if `phi` is on one of them.
    pub fn contains(&self, phi: f64) -> bool {
        self.iter().any(|[from, to]| (*from..=*to).contains(&phi))
    }

    /// Those of the intervals between ascending angles whose middles are seen.
    fn between(ends: &[f64], is_seen: impl Fn(f64) -> bool) -> Self {
        let mut arcs = Self::default();
        let mut from = None;
        for pair in ends.windows(2) {
            let seen = is_seen(0.5 * (pair[0] + pair[1]));
            let start = from.filter(|_| seen).unwrap_or(pair[0]);
            if let (Some(start), false) = (from, seen) {
                arcs.push([start, pair[0]]);
            }
            from = seen.then_some(start);
        }
        if let (Some(start), Some(end)) = (from, ends.last()) {
            arcs.push([start, *end]);
        }
        arcs
    }

    fn push(&mut self, arc: [f64; 2]) {
        if self.count < Self::MOST && arc[1] > arc[0] {
            self.arcs[self.count] = arc;
            self.count += 1;
        }
    }

    /// Keeps where `a cos(phi) + b sin(phi) + c >= 0`.
    fn clip(&mut self, [a, b, c]: [f64; 3]) {
        let r = (a * a + b * b).sqrt();
        if c >= r {
            return;
        }
        if c > -r {
            self.keep(libm::atan2(b, a), libm::atan2(((r - c) * (r + c)).sqrt(), -c));
        } else {
            *self = Self::default();
        }
    }

    /// Keeps what is at most `half` in (0, pi) from `middle`, in [-pi, pi].
    fn keep(&mut self, middle: f64, half: f64) {
        let mut kept = Self::default();
        for arc in self.iter() {
            for turn in [-TAU, 0.0, TAU] {
                let (from, to) = (middle - half + turn, middle + half + turn);
                kept.push([arc[0].max(from), arc[1].min(to)]);
            }
        }
        *self = kept;
    }
}
