//! The closest point of a triangle, in f64, for any number of triangles in lanes.
//!
//! The closest point lies on one of the edges or is the foot of the perpendicular inside. All four are made and the nearest is
//! taken: each is a convex combination of the corners whatever is rounded, so no distance is too small, and where the
//! perpendicular of a needle is lost to cancellation, an edge is next to it.

/// Squared distances and weights of the second and third corner, a triangle a lane.
pub(super) struct Closest<const N: usize> {
    pub distance_squared: [f64; N],
    pub weights: [[f64; N]; 2],
}

/// The closest points of triangles, by corner and axis, to a point. Each lane has the bits that it has alone; a lane with NaN has NaN
/// for a distance.
#[inline(always)]
pub(super) fn closest<const N: usize>(point: [f64; 3], corners: &[[[f32; N]; 3]; 3]) -> Closest<N> {
    let mut result = Closest { distance_squared: [0.0; N], weights: [[0.0; N]; 2] };
    #[expect(clippy::needless_range_loop, reason = "an index is the lane")]
    for i in 0..N {
        let at = |corner: usize| -> [f64; 3] {
            [
                f64::from(corners[corner][0][i]) - point[0],
                f64::from(corners[corner][1][i]) - point[1],
                f64::from(corners[corner][2][i]) - point[2],
            ]
        };
        let (a, b, c) = (at(0), at(1), at(2));
        let (ab, ac, bc) = (sub(b, a), sub(c, a), sub(c, b));
        // Against the corner, since the point is the origin.
        let (along_ab, along_ac, along_bc) = (-dot(a, ab), -dot(a, ac), -dot(b, bc));
        let (ab_ab, ab_ac, ac_ac) = (dot(ab, ab), dot(ab, ac), dot(ac, ac));

        let t = clamped(along_ab / ab_ab);
        let (mut v, mut w) = (t, 0.0);
        let mut least = squared(a, ab, t, ac, 0.0);
        let mut offer = |distance: f64, other_v: f64, other_w: f64, allowed: bool| {
            let better = allowed & (distance < least);
            least = if better { distance } else { least };
            v = if better { other_v } else { v };
            w = if better { other_w } else { w };
        };
        let t = clamped(along_ac / ac_ac);
        offer(squared(a, ab, 0.0, ac, t), 0.0, t, true);
        let t = clamped(along_bc / dot(bc, bc));
        offer(squared(a, ab, 1.0 - t, ac, t), 1.0 - t, t, true);
        let scale = 1.0 / (ab_ab * ac_ac - ab_ac * ab_ac);
        let inside_v = (ac_ac * along_ab - ab_ac * along_ac) * scale;
        let inside_w = (ab_ab * along_ac - ab_ac * along_ab) * scale;
        let inside = (inside_v >= 0.0) & (inside_w >= 0.0) & (inside_v + inside_w <= 1.0);
        offer(squared(a, ab, inside_v, ac, inside_w), inside_v, inside_w, inside);

        result.distance_squared[i] = least;
        result.weights[0][i] = v;
        result.weights[1][i] = w;
    }
    result
}

/// The closest point of one triangle: its squared distance and the weights of the second and third corner. This is what
/// [`super::ClosestPoints`] computes, bit for bit.
pub fn closest_on_triangle(point: [f64; 3], triangle: &[[f32; 3]; 3]) -> (f64, [f64; 2]) {
    let found = closest::<1>(point, &triangle.map(|corner| corner.map(|x| [x])));
    (found.distance_squared[0], found.weights.map(|weight| weight[0]))
}

#[inline(always)]
fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// The square of |a + v ab + w ac|.
#[inline(always)]
fn squared(a: [f64; 3], ab: [f64; 3], v: f64, ac: [f64; 3], w: f64) -> f64 {
    let x = a[0] + v * ab[0] + w * ac[0];
    let y = a[1] + v * ab[1] + w * ac[1];
    let z = a[2] + v * ab[2] + w * ac[2];
    x * x + y * y + z * z
}

/// Into \[0, 1\]; 0 for the NaN of an edge without length.
#[inline(always)]
fn clamped(t: f64) -> f64 {
    let t = if t > 0.0 { t } else { 0.0 };
    if t < 1.0 { t } else { 1.0 }
}
