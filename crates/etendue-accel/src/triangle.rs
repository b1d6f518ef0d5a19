//! The ray-triangle test that every accelerator calls: watertight (Woop, Benthin, Wald, "Watertight Ray/Triangle
//! Intersection", 2013), with exact signs.
//!
//! The sheared vertices are rounded to f32, by the same operations wherever a vertex is used, so neighbours see the same
//! points. The three edge functions are differences of products of those. In f32, rounding is monotonic, so a difference
//! that is not 0 has the right sign; that is enough to reject most triangles, in packs. What is not rejected is decided in
//! f64, where products of two f32 are exact: the sign is right also when it is 0, and each edge function has full
//! relative precision, however thin the triangle. So the weights are precise, which the paper's f32 weights are not for
//! slivers, and the proof of the boxes (`padding.rs`) rests on that.
//!
//! The ray parameter of a hit lies between those of the vertices, so the range of t rejects exactly, before any division;
//! the weights are divided for the winner alone.

use crate::bounds::{greatest, least};
use crate::local_ray::{Axis, LocalRay};

/// Where lines meet triangles, a lane each, not yet compared with a range of t.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossings<const N: usize> {
    /// Ray parameters; NaN where a line misses its triangle, sees it edge-on, or the triangle has no area.
    pub t: [f32; N],
    /// The edge functions of the second and third vertex, and the sum of all three: see [`weights`].
    pub edges: [[f64; N]; 3],
}

/// A vertex relative to the origin, sheared: its distances from the ray along two axes, and its ray parameter.
#[inline(always)]
pub(crate) fn shear(ray: &LocalRay, p: [f32; 3]) -> [f32; 3] {
    let ([px, py, pz], [ox, oy, oz]) = (Axis::of(ray.axes, &p), Axis::of(ray.axes, &ray.origin));
    let (x, y, z) = (px - ox, py - oy, pz - oz);
    [x - ray.shear[0] * z, y - ray.shear[1] * z, ray.shear[2] * z]
}

/// The smallest of three and the largest.
#[inline(always)]
fn hull([a, b, c]: [f32; 3]) -> (f32, f32) {
    (least(least(a, b), c), greatest(greatest(a, b), c))
}

/// Where the line of the ray meets a triangle: the ray parameter, and the edge functions for [`weights`]. None if it
/// does not, or if the parameter cannot be above `t_min` and at most `t_max`: it lies between those of the vertices.
#[inline(always)]
pub(crate) fn intersect(
    ray: &LocalRay,
    vertices: &[[f32; 3]; 3],
    (t_min, t_max): (f32, f32),
) -> Option<(f32, [f64; 3])> {
    let (a, b, c) = (shear(ray, vertices[0]), shear(ray, vertices[1]), shear(ray, vertices[2]));
    let (low, high) = hull([a[2], b[2], c[2]]);
    if !(high > t_min && low <= t_max) {
        return None;
    }
    let (first, last) = hull([c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]]);
    if first < 0.0 && last > 0.0 {
        return None;
    }
    let lane = |p: [f32; 3]| [[p[0]], [p[1]], [p[2]]];
    let Crossings { t: [t], edges: [[v], [w], [det]] } = decide([lane(a), lane(b), lane(c)]);
    if t.is_nan() { None } else { Some((t, [v, w, det])) }
}

/// The exact test of triangles given by their sheared vertices (by vertex and axis), a lane each.
#[inline(always)]
pub(crate) fn decide<const N: usize>([a, b, c]: [[[f32; N]; 3]; 3]) -> Crossings<N> {
    let mut found = Crossings { t: [0.0; N], edges: [[0.0; N]; 3] };
    for i in 0..N {
        let cross = |p: &[[f32; N]; 3], q: &[[f32; N]; 3]| {
            f64::from(p[0][i]) * f64::from(q[1][i]) - f64::from(p[1][i]) * f64::from(q[0][i])
        };
        let (u, v, w) = (cross(&c, &b), cross(&a, &c), cross(&b, &a));
        let both_sides = ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0));
        let det = u + v + w;
        let depths = [a[2][i], b[2][i], c[2][i]];
        let sum = u * f64::from(depths[0]) + v * f64::from(depths[1]) + w * f64::from(depths[2]);
        let (low, high) = hull(depths);
        // A convex combination; rounding may leave the hull by its last bit. Adding 0 turns -0 into 0.
        let t = least(greatest((sum / det) as f32, low), high) + 0.0;
        found.t[i] = if both_sides | (det == 0.0) { f32::NAN } else { t };
        found.edges[0][i] = v;
        found.edges[1][i] = w;
        found.edges[2][i] = det;
    }
    found
}

/// The weights of the second and the third vertex at a crossing; their sum is at most 1.
#[inline(always)]
pub(crate) fn weights([v, w, det]: [f64; 3]) -> [f32; 2] {
    let second = (v / det) as f32 + 0.0;
    [second, least((w / det) as f32, 1.0 - second) + 0.0]
}

#[cfg(test)]
mod tests {
    use super::*;

    const FACE: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [4.0, 0.0, 0.0], [0.0, 4.0, 0.0]];

    const LINE: (f32, f32) = (f32::NEG_INFINITY, f32::INFINITY);

    /// Ray parameter and weights.
    fn hit(origin: [f32; 3], direction: [f32; 3], face: &[[f32; 3]; 3]) -> Option<[f32; 3]> {
        let (t, edges) = intersect(&LocalRay::new(origin, direction).unwrap(), face, LINE)?;
        let [u, v] = weights(edges);
        Some([t, u, v])
    }

    #[test]
    fn weights_and_parameter() {
        let found = hit([1.0, 2.0, 3.0], [0.0, 0.0, -2.0], &FACE);
        assert_eq!(found, Some([1.5, 0.25, 0.5]));
        let from_behind = hit([1.0, 2.0, -3.0], [0.0, 0.0, 1.0], &FACE);
        assert_eq!(from_behind, Some([3.0, 0.25, 0.5]));
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
        assert!((found[0] - 0.5).abs() < 2e-6, "{found:?}");
    }
}
