//! Quadric error metrics (Garland and Heckbert 1997) with uncertain planes (Trettner and Kobbelt 2020).
//!
//! A quadric is kept relative to the vertex it belongs to, so that all numbers have the size of its neighbourhood and single
//! precision does.

use crate::vector::{Vec3, add, area_normal, cross, dot, scale, sub};

/// Of the trace: what pulls a minimum to where it is looked for.
const PULL: f32 = 1e-6;

/// `x` costs `x A x - 2 b x + c`, the sum over planes of weight times squared distance; `x` is relative to the vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Quadric {
    /// xx, yy, zz, xy, xz, yz.
    pub a: [f32; 6],
    pub b: Vec3,
    pub c: f32,
    /// Sum of weights: area.
    pub w: f32,
}

impl Quadric {
    /// Of a plane through `point`, with a unit normal.
    pub fn plane(normal: Vec3, point: Vec3, weight: f32) -> Self {
        let [x, y, z] = normal;
        let d = dot(normal, point);
        Self {
            a: [x * x, y * y, z * z, x * y, x * z, y * z].map(|v| v * weight),
            b: scale(normal, d * weight),
            c: d * d * weight,
            w: weight,
        }
    }

    /// Of a triangle, weighted by area, relative to `origin`. `variance` is that of its normal, which is not quite certain.
    #[inline(always)]
    pub fn triangle(corners: [Vec3; 3], origin: Vec3, variance: f32) -> Self {
        let [p, q, r] = corners.map(|corner| sub(corner, origin));
        let normal = area_normal(p, q, r);
        let twice = dot(normal, normal).sqrt();
        // A triangle without area has no plane and no weight.
        let inverse = if twice > 0.0 { 1.0 / twice } else { 0.0 };
        let middle = scale(add(add(p, q), r), 1.0 / 3.0);
        let mut quadric = Self::plane(scale(normal, inverse), middle, 0.5 * twice);
        let spread = variance * quadric.w;
        for diagonal in &mut quadric.a[..3] {
            *diagonal += spread;
        }
        quadric.b = add(quadric.b, scale(middle, spread));
        quadric.c += spread * dot(middle, middle);
        quadric
    }

    /// Of the plane that stands on an edge of a face, relative to the edge's first end.
    pub fn edge(edge: Vec3, face_normal: Vec3, weight: f32) -> Self {
        let across = cross(edge, face_normal);
        let length = dot(across, across).sqrt();
        if length > 0.0 {
            let mut quadric = Self::plane(scale(across, 1.0 / length), [0.0; 3], weight * dot(edge, edge));
            // Edges have no area; the weight is for means of faces.
            quadric.w = 0.0;
            quadric
        } else {
            Self::default()
        }
    }

    #[inline(always)]
    pub fn plus(mut self, other: &Self) -> Self {
        for i in 0..6 {
            self.a[i] += other.a[i];
        }
        self.b = add(self.b, other.b);
        self.c += other.c;
        self.w += other.w;
        self
    }

    /// `A x`.
    #[inline(always)]
    pub fn times(&self, x: Vec3) -> Vec3 {
        let [xx, yy, zz, xy, xz, yz] = self.a;
        [xx * x[0] + xy * x[1] + xz * x[2], xy * x[0] + yy * x[1] + yz * x[2], xz * x[0] + yz * x[1] + zz * x[2]]
    }

    /// The cost of `x`.
    #[inline(always)]
    pub fn at(&self, x: Vec3) -> f32 {
        let ax = self.times(x);
        self.c + (dot(ax, x) - 2.0 * dot(self.b, x))
    }

    /// The same, relative to `origin + by`.
    #[inline(always)]
    pub fn moved(&self, by: Vec3) -> Self {
        let ax = self.times(by);
        Self { a: self.a, b: sub(self.b, ax), c: self.c + (dot(ax, by) - 2.0 * dot(self.b, by)), w: self.w }
    }

    /// How far from `place` the cost is least, and true where that is well defined. Where the cost hardly changes along a line or a plane,
    /// it is the point of these that is nearest to the place.
    #[inline(always)]
    pub fn minimum_near(&self, place: Vec3) -> (Vec3, bool) {
        let [a00, a11, a22, a01, a02, a12] = self.a;
        let b = sub(self.b, self.times(place));
        let pull = (a00 + a11 + a22) * PULL;
        let a00 = a00 + pull;
        let l1 = a01 / a00;
        let l2 = a02 / a00;
        let d1 = a11 + pull - l1 * a01;
        let t = a12 - l2 * a01;
        let m = t / d1;
        let d2 = a22 + pull - l2 * a02 - m * t;
        let y0 = b[0];
        let y1 = b[1] - l1 * y0;
        let y2 = b[2] - l2 * y0 - m * y1;
        let z = y2 / d2;
        let y = y1 / d1 - m * z;
        let x = y0 / a00 - l1 * y - l2 * z;
        // Not a short circuit: lanes have no branches.
        let good = (a00 > 0.0) & (d1 > 0.0) & (d2 > 0.0);
        ([x, y, z], good)
    }
}
