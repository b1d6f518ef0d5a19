//! Spherical triangles: solid angle, and sampling, uniform or nearly by projected solid angle.

use super::{
    LightContext, between,
    bilinear::{Bilinear, LEAST_COSINE},
    larger,
};
use crate::math::{DVec3, atan2_wide, sin_cos_wide};

/// A triangle seen from the origin, with its solid angle.
///
/// Solid angle after van Oosterom and Strackee ("The Solid Angle of a Plane Triangle", 1983); sampling after Arvo
/// ("Stratified Sampling of Spherical Triangles", 1995) with half angles, as Peters does for polygons ("BRDF Importance
/// Sampling for Polygonal Lights", 2021). Every difference that could cancel is written as a product, so that relative
/// accuracy holds for solid angles from 1e-30 to 2 pi.
///
/// With a, b, c the unit vectors to the vertices: tan(omega / 2) = |det(a, b, c)| / (1 + a.b + b.c + c.a). The part of
/// the triangle between edge ab and the arc from b to a point e of edge ac is again a triangle. With h on the half way
/// from a to e, its solid angle satisfies tan(omega' / 2) = det(a, b, h) / ((a + b).h). For h along x a + y c that is
/// y g0 / (x g2 + y g1), and omega' = u omega gives x and y; e is a mirrored at h.
#[derive(Clone, Copy)]
pub(super) struct SphericalTriangle {
    /// Unit vectors to the vertices.
    directions: [DVec3; 3],
    /// Distances of the vertices.
    distances: [f64; 3],
    /// |det(a, b, c)|.
    g0: f64,
    /// (a + b).c.
    g1: f64,
    /// 1 + a.b.
    g2: f64,
    /// Steradians, in [0, 2 pi].
    pub(super) solid_angle: f64,
}

impl SphericalTriangle {
    /// From the vertices relative to the origin and the cross product of two edges, (b - a) x (c - a).
    #[inline(always)]
    pub(super) fn new(vertices: [DVec3; 3], cross: DVec3) -> Self {
        let distances = [vertices[0].length(), vertices[1].length(), vertices[2].length()];
        let directions = [vertices[0] / distances[0], vertices[1] / distances[1], vertices[2] / distances[2]];
        let [a, b, c] = directions;
        // Through the plane's distance: small triangles would cancel in a determinant of unit vectors.
        let g0 = vertices[0].dot(cross).abs() / (distances[0] * distances[1] * distances[2]);
        let g1 = (a + b).dot(c);
        let g2 = 0.5 * (a + b).length_squared();
        Self { directions, distances, g0, g1, g2, solid_angle: 2.0 * atan2_wide(g0, g1 + g2) }
    }

    /// Barycentric weights of a vertex each, summing to 1, of the point that is uniform in solid angle for uniform `u` in
    /// [0, 1)^2.
    #[inline(always)]
    pub(super) fn sample(&self, u: [f64; 2]) -> [f64; 3] {
        let [a, b, c] = self.directions;
        let (sin, cos) = sin_cos_wide(0.5 * u[0] * self.solid_angle);
        let y = self.g2 * sin;
        let x = larger(self.g0 * cos - self.g1 * sin, y);
        let ac = a.dot(c);
        // e = (e_a a + e_c c), the mirror image of a.
        let norm = x * x + y * y + 2.0 * x * y * ac;
        let e_a = (x - y) * (x + y) / norm;
        let e_c = 2.0 * y * (x + y * ac) / norm;
        let e = e_a * a + e_c * c;
        // Uniform in the cosine s along the arc from b to e: s = 1 - u (1 - b.e), and the direction is
        // (s - t b.e) b + t e, t the ratio of the sines.
        let near = 0.5 * (b - e).length_squared();
        let far = 0.5 * (b + e).length_squared();
        let t = (u[1] * (2.0 - u[1] * near) / far).sqrt();
        let e_b = (1.0 - t) + near * (t - u[1]);
        let weights = [
            larger(t * e_a, 0.0) / self.distances[0],
            larger(e_b, 0.0) / self.distances[1],
            larger(t * e_c, 0.0) / self.distances[2],
        ];
        let sum = weights[0] + weights[1] + weights[2];
        [weights[0] / sum, weights[1] / sum, weights[2] / sum]
    }
    /// The numbers for which [`Self::sample`] goes towards the unit vector `wi`, which is inside.
    fn locate(&self, wi: DVec3) -> [f64; 2] {
        let [a, b, c] = self.directions;
        // Where the arc from b through wi meets edge ac.
        let across = b.cross(wi);
        let e = (a * across.dot(c) - c * across.dot(a)).normalize_or(a);
        let e = if e.dot(a + c) < 0.0 { -e } else { e };
        // h = a + e = x a + y c.
        let y = (e.cross(a).length() / c.cross(a).length()).min(f64::MAX);
        let x = 1.0 + e.dot(a) - y * a.dot(c);
        let angle = 2.0 * atan2_wide(y * self.g0, x * self.g2 + y * self.g1);
        [
            between(angle / self.solid_angle, 0.0, 1.0),
            between((b - wi).length_squared() / (b - e).length_squared(), 0.0, 1.0),
        ]
    }

    /// With the cosines at the context as values at the vertices.
    #[inline(always)]
    pub(super) fn warped(self, ctx: &LightContext) -> Warped {
        let normal = ctx.normal.as_dvec3();
        // On both sides or in a medium nothing is known of the cosine.
        let any = ctx.transmits | (normal.length_squared() == 0.0) | (self.solid_angle < LEAST_WARPED);
        let cosine = |d: DVec3| if any { 1.0 } else { larger(d.dot(normal), 0.0) };
        let [a, b, c] = self.directions;
        let (a, b, c) = (cosine(a), cosine(b), cosine(c));
        Warped { triangle: self, weights: Bilinear::new([b, b, a, c], LEAST_COSINE) }
    }
}

/// Below this solid angle (steradians) points are even: in slivers a direction in f32 does not tell the numbers that lead to it.
const LEAST_WARPED: f64 = 2e-3;

/// A triangle that is sampled by what its points bring: nearly by projected solid angle.
#[derive(Clone, Copy)]
pub(super) struct Warped {
    triangle: SphericalTriangle,
    /// At the second vertex, twice, at the first and at the third.
    weights: Bilinear,
}

impl Warped {
    /// Integral of the value over solid angle.
    #[inline(always)]
    pub(super) fn total(&self) -> f64 {
        self.weights.mean() * self.triangle.solid_angle
    }

    /// Barycentric weights of a vertex each, and the value: [`Self::total`] times the density.
    #[inline(always)]
    pub(super) fn sample(&self, u: [f64; 2]) -> ([f64; 3], f64) {
        let u = self.weights.sample(u);
        (self.triangle.sample(u), self.weights.value(u))
    }

    /// The value in direction of the unit vector `wi`, which is inside.
    pub(super) fn value(&self, wi: DVec3) -> f64 {
        self.weights.value(self.triangle.locate(wi))
    }
}
