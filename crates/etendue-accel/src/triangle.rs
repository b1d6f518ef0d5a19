//! The ray-triangle test that every accelerator calls: watertight (Woop, Benthin, Wald, "Watertight Ray/Triangle
//! Intersection", 2013), with exact signs.
//!
//! The sheared vertices are rounded to f32, by the same operations wherever a vertex is used, so neighbours see the same
//! points. The three edge functions are differences of products of those. In f32, rounding is monotonic, so a difference
//! that is not 0 has the right sign; that is enough to reject most triangles, in packs. What is not rejected is decided in
//! f64, where products of two f32 are exact: the sign is right also when it is 0, and each edge function has full
//! relative precision, however thin the triangle. So the weights are precise, which the paper's f32 weights are not for
//! slivers, and the proof of the boxes (`padding.rs`) rests on that.

use crate::bounds::{greatest, least};
use crate::local_ray::LocalRay;

/// A hit on a triangle, not yet compared with the range of t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct TriangleHit {
    pub t: f32,
    /// Weight of the second vertex.
    pub u: f32,
    /// Weight of the third vertex; `u + v` is at most 1.
    pub v: f32,
}

/// A vertex relative to the origin, sheared: its distances from the ray along two axes, and its ray parameter.
#[inline(always)]
fn shear(ray: &LocalRay, p: [f32; 3]) -> [f32; 3] {
    let [kx, ky, kz] = ray.axes;
    let (x, y, z) = (p[kx] - ray.origin[kx], p[ky] - ray.origin[ky], p[kz] - ray.origin[kz]);
    [x - ray.shear[0] * z, y - ray.shear[1] * z, ray.shear[2] * z]
}

/// Where the line of the ray meets a triangle. None if the triangle is seen edge-on or has no area.
#[inline(always)]
pub(crate) fn intersect(ray: &LocalRay, vertices: &[[f32; 3]; 3]) -> Option<TriangleHit> {
    let (a, b, c) = (shear(ray, vertices[0]), shear(ray, vertices[1]), shear(ray, vertices[2]));
    let (u, v, w) = (c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]);
    if least(least(u, v), w) < 0.0 && greatest(greatest(u, v), w) > 0.0 {
        return None;
    }
    decide(a, b, c)
}

#[inline(never)]
fn decide(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> Option<TriangleHit> {
    let cross = |p: [f32; 3], q: [f32; 3]| f64::from(p[0]) * f64::from(q[1]) - f64::from(p[1]) * f64::from(q[0]);
    let edges = [cross(c, b), cross(a, c), cross(b, a)];
    if edges.iter().any(|&e| e < 0.0) && edges.iter().any(|&e| e > 0.0) {
        return None;
    }
    let det = edges[0] + edges[1] + edges[2];
    if det == 0.0 {
        return None;
    }
    let depths = [a[2], b[2], c[2]];
    let sum = edges[0] * f64::from(depths[0]) + edges[1] * f64::from(depths[1]) + edges[2] * f64::from(depths[2]);
    let [low, high] = [f32::min, f32::max].map(|pick| pick(pick(depths[0], depths[1]), depths[2]));
    // A convex combination; rounding may leave the hull by its last bit. Adding 0 turns -0 into 0.
    let t = ((sum / det) as f32).max(low).min(high) + 0.0;
    let u = (edges[1] / det) as f32 + 0.0;
    let v = ((edges[2] / det) as f32).min(1.0 - u) + 0.0;
    Some(TriangleHit { t, u, v })
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    fn hit(origin: [f32; 3], direction: [f32; 3], face: &[[f32; 3]; 3]) -> Option<TriangleHit> {
        intersect(&LocalRay::new(origin, direction).unwrap(), face)
    }

    #[test]
    fn weights_and_parameter() {
        let found = hit([1.0, 2.0, 3.0], [0.0, 0.0, -2.0], &FACE);
        assert_eq!(found, Some(TriangleHit { t: 1.5, u: 0.25, v: 0.5 }));
        let from_behind = hit([1.0, 2.0, -3.0], [0.0, 0.0, 1.0], &FACE);
        assert_eq!(from_behind, Some(TriangleHit { t: 3.0, u: 0.25, v: 0.5 }));
    }

    #[test]
    fn edges_and_vertices_belong_to_the_triangle() {
        for p in [[0.0, 0.0], [4.0, 0.0], [0.0, 4.0], [2.0, 0.0], [0.0, 2.0], [2.0, 2.0]] {
            assert!(hit([p[0], p[1], 1.0], [0.0, 0.0, -1.0], &FACE).is_some(), "{p:?}");
        }
        assert!(hit([2.0, f32::from_bits(0x4000_0001), 1.0], [0.0, 0.0, -1.0], &FACE).is_none());
        assert!(hit([1.0, -f32::MIN_POSITIVE, 1.0], [0.0, 0.0, -1.0], &FACE).is_none());
    }

    #[test]
    fn no_area_no_hit() {
        let point = [[1.0, 1.0, 0.0]; 3];
        let line = [[0.0, 0.0, 0.0], [2.0, 2.0, 0.0], [1.0, 1.0, 0.0]];
        for face in [point, line] {
            assert_eq!(hit([1.0, 1.0, 1.0], [0.0, 0.0, -1.0], &face), None);
        }
        assert_eq!(hit([-1.0, 1.0, 0.0], [1.0, 0.0, 0.0], &FACE), None, "edge-on");
    }

    #[test]
    fn products_below_the_range_of_f32_keep_their_signs() {
        let tiny = FACE.map(|p| p.map(|x| x * 1e-25));
        assert!(hit([1e-25, 2e-25, 1.0], [0.0, 0.0, -1.0], &tiny).is_some());
        assert!(hit([3e-25, 2e-25, 1.0], [0.0, 0.0, -1.0], &tiny).is_none());
    }

    #[test]
    fn thin_triangles_have_precise_parameters() {
        // A needle along (1, 1, 1), a few bits wide, crossed by a ray along (1, 1, -1) at its middle.
        let width = 1e-6;
        let needle = [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.5 + width, 0.5 - width, 0.5]];
        let found = hit([0.0, 0.0, 1.0], [1.0, 1.0, -1.0], &needle).unwrap();
        assert!((found.t - 0.5).abs() < 2e-6, "{found:?}");
    }
}
