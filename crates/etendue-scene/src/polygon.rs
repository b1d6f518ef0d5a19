//! Polygons to triangles.

use glam::DVec3;

/// Twice the vector area (Newell): along the normal, right-handed to the order of the corners.
pub(crate) fn newell(points: &[DVec3]) -> DVec3 {
    let Some(&first) = points.first() else { return DVec3::ZERO };
    // About the first corner, so that polygons far away keep their precision.
    points.windows(2).map(|pair| (pair[0] - first).cross(pair[1] - first)).sum()
}

/// The angle between the edges from `here` to `before` and to `after`, radians in [0, pi].
pub(crate) fn angle_at(before: DVec3, here: DVec3, after: DVec3) -> f64 {
    let (a, b) = (before - here, after - here);
    libm::atan2(a.cross(b).length(), a.dot(b))
}

/// How a polygon was cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Cut {
    /// Into triangles that cover it.
    Exact,
    /// It crosses itself, or has no area: the triangles use each corner, but may overlap.
    Forced,
    /// Cutting it rightly would take too long: a fan about its first corner.
    TooComplex,
}

/// Cuts polygons by clipping ears (Meisters 1975) in the coordinate plane that their Newell normal faces most.
///
/// That takes time quadratic in the corners of a concave polygon; one file may use `WORK_PER_CORNER` corner tests a
/// corner, and `FREE_WORK` more.
#[derive(Debug)]
pub(crate) struct Triangulator {
    flat: Vec<[f64; 2]>,
    next: Vec<u32>,
    previous: Vec<u32>,
    reflex: Vec<bool>,
    work_left: u64,
}

const FREE_WORK: u64 = 1 << 26;
const WORK_PER_CORNER: u64 = 64;

/// Ears are taken in three sweeps, so that slivers along straight runs of corners are made only where they must: the sine
/// of the ear's angle is above the first of these, then of the second, then positive.
const SHARPNESS: [f64; 3] = [0.05, 1e-6, 0.0];

impl Triangulator {
    pub fn new() -> Self {
        Self { flat: vec![], next: vec![], previous: vec![], reflex: vec![], work_left: FREE_WORK }
    }

    /// Appends `points.len() - 2` triangles with the polygon's orientation, as indices into `points`, to `triangles`.
    /// Nothing for less than three points.
    pub fn cut(&mut self, points: &[DVec3], triangles: &mut Vec<[u32; 3]>) -> Cut {
        match points.len() {
            0..3 => Cut::Exact,
            3 => {
                triangles.push([0, 1, 2]);
                Cut::Exact
            }
            4 => cut_quad(points, triangles),
            _ => self.cut_any(points, triangles),
        }
    }

    fn cut_any(&mut self, points: &[DVec3], triangles: &mut Vec<[u32; 3]>) -> Cut {
        self.work_left = self.work_left.saturating_add(points.len() as u64 * WORK_PER_CORNER);
        let normal = newell(points);
        if normal == DVec3::ZERO || !normal.is_finite() {
            fan(0, points.len() as u32, triangles);
            return Cut::Forced;
        }
        self.project(points, normal);
        self.clip(triangles)
    }

    /// Drops the axis that the normal is nearest to, so that the polygon turns counter-clockwise.
    fn project(&mut self, points: &[DVec3], normal: DVec3) {
        let size = normal.abs();
        let (u, v) = match (size.x >= size.y && size.x >= size.z, size.y >= size.z) {
            (true, _) => (1, 2),
            (false, true) => (2, 0),
            (false, false) => (0, 1),
        };
        let axis = 3 - u - v;
        let (u, v) = if normal[axis] < 0.0 { (v, u) } else { (u, v) };
        self.flat.clear();
        self.flat.extend(points.iter().map(|&p| p - points[0]).map(|p| [p[u], p[v]]));
    }

    fn clip(&mut self, triangles: &mut Vec<[u32; 3]>) -> Cut {
        let count = self.flat.len() as u32;
        self.next.clear();
        self.next.extend((1..count).chain([0]));
        self.previous.clear();
        self.previous.extend([count - 1].into_iter().chain(0..count - 1));
        self.reflex.clear();
        self.reflex.resize(count as usize, false);
        for corner in 0..count {
            self.update_reflex(corner);
        }
        let mut cut = Cut::Exact;
        let (mut left, mut corner, mut level, mut since_last) = (count, 0, 0, 0);
        while left > 3 {
            let forced = level == SHARPNESS.len();
            if forced || self.is_ear(corner, SHARPNESS[level]) {
                if forced {
                    cut = Cut::Forced;
                    level = SHARPNESS.len() - 1;
                }
                let (before, after) = (self.previous[corner as usize], self.next[corner as usize]);
                triangles.push([before, corner, after]);
                self.next[before as usize] = after;
                self.previous[after as usize] = before;
                self.update_reflex(before);
                self.update_reflex(after);
                left -= 1;
                since_last = 0;
                // Taking every other corner keeps the triangles fat.
                corner = self.next[after as usize];
            } else {
                since_last += 1;
                corner = self.next[corner as usize];
                if since_last > left {
                    level += 1;
                    since_last = 0;
                }
            }
            if self.work_left == 0 {
                self.fan_rest(corner, left, triangles);
                return Cut::TooComplex;
            }
        }
        self.fan_rest(corner, left, triangles);
        cut
    }

    fn fan_rest(&self, first: u32, left: u32, triangles: &mut Vec<[u32; 3]>) {
        let mut corner = self.next[first as usize];
        for _ in 2..left {
            let after = self.next[corner as usize];
            triangles.push([first, corner, after]);
            corner = after;
        }
    }

    fn corners(&self, corner: u32) -> [[f64; 2]; 3] {
        let corner = corner as usize;
        [self.previous[corner] as usize, corner, self.next[corner] as usize].map(|i| self.flat[i])
    }

    fn update_reflex(&mut self, corner: u32) {
        let [a, b, c] = self.corners(corner);
        self.reflex[corner as usize] = turn(a, b, c) <= 0.0;
    }

    /// True if the triangle at `corner` turns left by at least this sine and holds no other corner.
    fn is_ear(&mut self, corner: u32, sharpness: f64) -> bool {
        self.work_left = self.work_left.saturating_sub(1);
        if self.reflex[corner as usize] {
            return false;
        }
        let [a, b, c] = self.corners(corner);
        let area = turn(a, b, c);
        let lengths = square_distance(a, b) * square_distance(b, c);
        if area <= 0.0 || area * area < sharpness * sharpness * lengths {
            return false;
        }
        let last = self.previous[corner as usize];
        let mut other = self.next[self.next[corner as usize] as usize];
        while other != last {
            self.work_left = self.work_left.saturating_sub(1);
            let p = self.flat[other as usize];
            // Only reflex corners can reach into the ear; those on its corners (bridges to holes) do not count.
            if self.reflex[other as usize]
                && p != a
                && p != b
                && p != c
                && turn(a, b, p) >= 0.0
                && turn(b, c, p) >= 0.0
                && turn(c, a, p) >= 0.0
            {
                return false;
            }
            other = self.next[other as usize];
        }
        true
    }
}

/// Twice the signed area of a triangle, positive if it turns left.
fn turn(a: [f64; 2], b: [f64; 2], c: [f64; 2]) -> f64 {
    (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
}

fn square_distance(a: [f64; 2], b: [f64; 2]) -> f64 {
    let (x, y) = (b[0] - a[0], b[1] - a[1]);
    x * x + y * y
}

fn fan(first: u32, count: u32, triangles: &mut Vec<[u32; 3]>) {
    triangles.extend((first + 1..first + count - 1).map(|i| [first, i, i + 1]));
}

/// The diagonal from the first corner, as everyone's, unless the quadrilateral is concave there.
fn cut_quad(points: &[DVec3], triangles: &mut Vec<[u32; 3]>) -> Cut {
    let [a, b, c, d] = [points[0], points[1], points[2], points[3]];
    let normal = (c - a).cross(d - b);
    let side = |p: DVec3, q: DVec3, r: DVec3| (q - p).cross(r - p).dot(normal);
    let first = side(a, b, c).min(side(a, c, d));
    let second = side(b, c, d).min(side(b, d, a));
    if first > 0.0 || first >= second || first.is_nan() || second.is_nan() {
        triangles.extend([[0, 1, 2], [0, 2, 3]]);
    } else {
        triangles.extend([[1, 2, 3], [1, 3, 0]]);
    }
    if first.max(second) > 0.0 { Cut::Exact } else { Cut::Forced }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;
    use proptest::{prelude::*, test_runner::RngSeed};

    fn cut(points: &[DVec3]) -> (Vec<[u32; 3]>, Cut) {
        let mut triangles = vec![];
        let cut = Triangulator::new().cut(points, &mut triangles);
        (triangles, cut)
    }

    /// Each triangle turns with the polygon, the areas add up to it, and the polygon's edges are the triangles' borders:
    /// together, an exact cover.
    fn assert_covers(points: &[DVec3]) {
        let (triangles, how) = cut(points);
        assert_eq!(how, Cut::Exact);
        assert_eq!(triangles.len(), points.len() - 2);
        let normal = newell(points);
        let mut sum = 0.0;
        let mut borders = std::collections::BTreeMap::new();
        for t in &triangles {
            let area = newell(&t.map(|i| points[i as usize])).dot(normal.normalize());
            assert!(area >= 0.0, "{t:?} turns against the polygon: {area}");
            sum += area;
            for k in 0..3 {
                let (a, b) = (t[k], t[(k + 1) % 3]);
                *borders.entry((a.min(b), a.max(b))).or_insert(0) += if a < b { 1 } else { -1 };
            }
        }
        assert!((sum - normal.length()).abs() <= 1e-9 * normal.length(), "{sum} of {}", normal.length());
        let n = points.len() as u32;
        for ((a, b), balance) in borders {
            let edge = b == a + 1 || (a == 0 && b == n - 1);
            assert_eq!(balance != 0, edge, "edge {a} {b}");
        }
    }

    #[test]
    fn concave_quads_are_cut_at_the_reflex_corner() {
        let dart = [dvec3(0.0, 0.0, 0.0), dvec3(2.0, -1.0, 0.0), dvec3(0.5, 0.0, 0.0), dvec3(2.0, 1.0, 0.0)];
        for turn in 0..4 {
            let mut points = dart;
            points.rotate_left(turn);
            assert_covers(&points);
            points.reverse();
            assert_covers(&points);
        }
        assert_eq!(cut(&[DVec3::ZERO; 4]), (vec![[0, 1, 2], [0, 2, 3]], Cut::Forced));
    }

    #[test]
    fn combs_with_straight_runs_and_any_orientation() {
        // A comb: every tooth concave, the back with many corners on a straight line.
        let mut comb: Vec<DVec3> = (0..20).map(|i| dvec3(i as f64, 0.0, 0.0)).collect();
        comb.extend((0..20).rev().map(|i| dvec3(i as f64, if i % 2 == 0 { 5.0 } else { 0.5 }, 0.0)));
        let turns = [
            glam::DMat3::IDENTITY,
            glam::DMat3::from_cols(DVec3::Y, DVec3::Z, DVec3::X),
            glam::DMat3::from_cols(DVec3::Z, DVec3::X, DVec3::Y),
            glam::DMat3::from_cols(DVec3::X, -DVec3::Y, -DVec3::Z),
            glam::DMat3::from_cols(dvec3(0.6, 0.8, 0.0), dvec3(-0.48, 0.36, 0.8), dvec3(0.64, -0.48, 0.6)),
        ];
        for matrix in turns {
            for shift in 0..comb.len() {
                let mut points: Vec<DVec3> = comb.iter().map(|&p| matrix * p + dvec3(1e4, -3e4, 2e4)).collect();
                points.rotate_left(shift);
                let (triangles, _) = cut(&points);
                assert_eq!(triangles.len(), points.len() - 2);
                if matrix == turns[0] || matrix == turns[1] {
                    assert_covers(&points);
                }
            }
        }
    }

    #[test]
    fn a_bridge_to_a_hole() {
        let square = |s: f64| [(-s, -s), (s, -s), (s, s), (-s, s)].map(|(x, y)| dvec3(x, y, 0.0));
        let (outer, inner) = (square(2.0), square(1.0));
        let mut points = outer.to_vec();
        points.push(outer[0]);
        points.extend([inner[0], inner[3], inner[2], inner[1], inner[0]]);
        let (triangles, how) = cut(&points);
        let area: f64 = triangles.iter().map(|t| newell(&t.map(|i| points[i as usize])).z).sum();
        assert_eq!((how, triangles.len(), area), (Cut::Exact, 8, 24.0));
    }

    #[test]
    fn huge_concave_polygons_end() {
        let star: Vec<DVec3> = (0..200_000u32)
            .map(|i| {
                let (y, x) = libm::sincos(f64::from(i) * std::f64::consts::TAU / 200_000.0);
                dvec3(x, y, 0.0) * if i % 2 == 0 { 1.0 } else { 0.5 }
            })
            .collect();
        let (triangles, how) = cut(&star);
        assert_eq!(triangles.len(), star.len() - 2);
        assert_eq!(how, Cut::TooComplex);
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(4), failure_persistence: None, ..ProptestConfig::default() })]

        /// Corners at increasing angles about the centre never cross, however the radii jump.
        #[test]
        fn star_shaped_polygons_are_covered(radii in prop::collection::vec(0.05f64..1.0, 4..40)) {
            let n = radii.len() as f64;
            let points: Vec<DVec3> = radii.iter().enumerate().map(|(i, r)| {
                let (y, x) = libm::sincos(i as f64 * std::f64::consts::TAU / n);
                dvec3(x * r, y * r, 0.3)
            }).collect();
            assert_covers(&points);
        }

        #[test]
        fn any_corners_end_in_triangles(
            corners in prop::collection::vec((-2i8..3, -2i8..3, -2i8..3), 0..24)
        ) {
            let points: Vec<DVec3> =
                corners.iter().map(|&(x, y, z)| dvec3(x.into(), y.into(), z.into())).collect();
            let (triangles, _) = cut(&points);
            prop_assert_eq!(triangles.len(), points.len().saturating_sub(2));
            prop_assert!(triangles.iter().flatten().all(|&i| (i as usize) < points.len()));
        }
    }
}
