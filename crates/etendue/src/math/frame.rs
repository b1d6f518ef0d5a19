//! Orthonormal frames.

use super::{Vec3, vec3};

/// A right-handed orthonormal basis with `n` as z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// Local x.
    pub s: Vec3,
    /// Local y.
    pub t: Vec3,
    /// Local z.
    pub n: Vec3,
}

impl Frame {
    /// A frame about the unit vector `n`, continuous but for n.z = 0-
    /// (Duff et al., "Building an Orthonormal Basis, Revisited", 2017).
    #[inline(always)]
    pub fn from_normal(n: Vec3) -> Self {
        let sign = 1.0f32.copysign(n.z);
        let a = -1.0 / (sign + n.z);
        let b = n.x * n.y * a;
        Self { s: vec3(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), t: vec3(b, sign + n.y * n.y * a, -n.y), n }
    }

    /// A frame about the unit vector `n` with x along `tangent`, a unit vector across `n`.
    #[inline(always)]
    pub fn from_tangent(n: Vec3, tangent: Vec3) -> Self {
        Self { s: tangent, t: n.cross(tangent), n }
    }

    /// World to local.
    #[inline(always)]
    pub fn to_local(&self, v: Vec3) -> Vec3 {
        vec3(v.dot(self.s), v.dot(self.t), v.dot(self.n))
    }

    /// Local to world.
    #[inline(always)]
    pub fn to_world(&self, v: Vec3) -> Vec3 {
        self.s * v.x + self.t * v.y + self.n * v.z
    }
}
