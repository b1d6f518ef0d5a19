//! What the first pass knows of triangles: planes and edges, those of two triangles that make a quadrilateral together.
//!
//! # How far the first pass may be off
//!
//! Let u = 2^-24, o and d the ray, E the largest magnitude of the facet's coordinates, R = |o| + E with |.| the largest
//! magnitude of components. By `padding.rs` a hit accepted by the exact test at t has a point P of the triangle with |o + t d - P|
//! at most 10.2 u R an axis, 17.7 u R in all. Let n be the rounded unit normal, D its offset, h how far corners lie off the
//! plane n x + D = 0, all three or four. At the hit the ray is at most 17.7 u R + h off this plane. The first pass computes
//! t' = -(n o + D) / (n d): the numerator is off by 5.2 u R, the denominator by 5.2 u |d|, which moves the hit by as much as 5.2 u R, and the quotient
//! by another 5.2 u R. So
//!
//!   |t' - t| <= (34 u R + h) / |n d|.
//!
//! The point o + t' d, along two axes, is then within |d| times that and 2 u R of the ray's at t; P is 17.7 u R away. Edges are lines
//! in the plane of these axes, their normals of unit length, so a distance from an edge moves by no more; rounded
//! coefficients and the sum add 9 u R. With the sum of components for |d|, which is at least |n d|, the computed distance is at least
//!
//!   -|d| (64 u R + h) / |n d|.
//!
//! The other way round, a ray whose distances are all above that meets the facets of rounded corners as well: the exact test moves
//! corners by 8.6 u R across the ray, and lengths in the plane seen along the ray shrink by |n d| / |d| at most. Two triangles share the corners of
//! their diagonal to the bit, so one of them is met. [`SPREAD`] is twice what is needed.

use super::{FlatTriangle, Order};

/// Of the coordinates' magnitude, how far numbers of the first pass may be off.
pub(super) const SPREAD: f32 = 128.0 / (1 << 24) as f32;

/// Covers numbers that lose bits below the range of f32.
const FLOOR: f64 = 1.0 / (1_u128 << 100) as f64;

/// Corners of two triangles lie in one plane if they are off it by this part of the largest coordinate at most.
const FLAT: f64 = 1e-6;

/// A triangle (three edges) or a convex quadrilateral of two triangles, as the first pass reads it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet<const EDGES: usize> {
    /// Unit; 0 if there is none.
    pub normal: [f32; 3],
    /// The product of the normal and a point of the plane.
    pub height: f32,
    /// That of the normal's largest component; edges are in the plane of the others.
    pub main: u32,
    /// Distances from the edges, positive inside: the factors of both coordinates, and the rest.
    pub edges: [[f32; 3]; EDGES],
    /// The same for the diagonal of a quadrilateral, positive in the first triangle.
    pub diagonal: [f32; 3],
    /// What heights may be off, metres, but for the part that goes with the origin.
    pub slack: f32,
    /// Of the instance.
    pub mask: u32,
    /// Of the triangles; the same twice for one.
    pub orders: [Order; 2],
    /// Their places among the triangles.
    pub places: [u32; 2],
}

/// All triangles of a list, each in one facet.
#[derive(Debug, Default)]
pub(crate) struct Facets {
    pub triangles: Vec<Facet<3>>,
    pub quadrilaterals: Vec<Facet<4>>,
}

type Point = [f64; 3];

fn minus(a: Point, b: Point) -> Point {
    std::array::from_fn(|axis| a[axis] - b[axis])
}

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|axis| a[axis] * b[axis]).sum()
}

fn cross(a: Point, b: Point) -> Point {
    std::array::from_fn(|axis| a[(axis + 1) % 3] * b[(axis + 2) % 3] - a[(axis + 2) % 3] * b[(axis + 1) % 3])
}

/// A factor of both coordinates and a rest.
fn line([a, b]: [[f64; 2]; 2]) -> [f64; 3] {
    let along = [b[0] - a[0], b[1] - a[1]];
    let length = (along[0] * along[0] + along[1] * along[1]).sqrt();
    if length == 0.0 {
        // Excludes nothing.
        return [0.0, 0.0, f64::INFINITY];
    }
    let [x, y] = [-along[1] / length, along[0] / length];
    [x, y, -(x * a[0] + y * a[1])]
}

fn distance(line: [f64; 3], point: [f64; 2]) -> f64 {
    line[0] * point[0] + line[1] * point[1] + line[2]
}

impl<const EDGES: usize> Facet<EDGES> {
    /// Around corners in turn; the diagonal is that from the first to the third. `None` if that is no convex polygon in one
    /// plane.
    fn new(corners: [Point; EDGES]) -> Option<Self> {
        let largest = corners.iter().flatten().fold(0.0, |largest: f64, x| largest.max(x.abs()));
        let across = cross(minus(corners[2], corners[0]), minus(corners[EDGES - 1], corners[1]));
        let length = dot(across, across).sqrt();
        if !(length > 0.0 && length.is_finite()) {
            return None;
        }
        let normal = across.map(|x| (x / length) as f32);
        let wide = normal.map(f64::from);
        let height = corners.iter().map(|&corner| dot(wide, corner)).sum::<f64>() / EDGES as f64;
        let off = corners.iter().fold(0.0, |off: f64, &corner| off.max((dot(wide, corner) - height).abs()));
        if EDGES > 3 && off > FLAT * largest {
            return None;
        }
        let main = (0..3).fold(0, |main, axis| if normal[axis].abs() > normal[main].abs() { axis } else { main });
        let axes = [(main + 1) % 3, (main + 2) % 3];
        let flat = corners.map(|corner| axes.map(|axis| corner[axis]));
        // Corners turn about the normal; seen along an axis they turn the other way where it points back.
        let turn = |line: [f64; 3]| if wide[main] < 0.0 { line.map(|x| -x) } else { line };
        let edge = |i: usize| line([flat[i], flat[(i + 1) % EDGES]]);
        let edges: [[f64; 3]; EDGES] =
            std::array::from_fn(|i| if edge(i)[2] == f64::INFINITY { edge(i) } else { turn(edge(i)) });
        let is_inside = |edge: usize, corner: usize| {
            corner == edge || corner == (edge + 1) % EDGES || distance(edges[edge], flat[corner]) > 0.0
        };
        if EDGES > 3 && !(0..EDGES).all(|edge| (0..EDGES).all(|corner| is_inside(edge, corner))) {
            return None;
        }
        let slack = (f64::from(SPREAD) * largest + off).max(FLOOR) * 1.001;
        Some(Self {
            normal,
            height: height as f32,
            main: main as u32,
            edges: edges.map(|edge| edge.map(|x| x as f32)),
            diagonal: turn(line([flat[0], flat[2]])).map(|x| x as f32),
            slack: slack as f32,
            mask: 0,
            orders: [0; 2],
            places: [0; 2],
        })
    }

    /// The axes of the plane of the edges.
    #[inline(always)]
    pub fn axes(&self) -> [usize; 2] {
        match self.main {
            0 => [1, 2],
            1 => [2, 0],
            _ => [0, 1],
        }
    }

    /// Excludes nothing.
    fn vague() -> Self {
        Self {
            normal: [0.0; 3],
            height: 0.0,
            main: 2,
            edges: [[0.0, 0.0, f32::INFINITY]; EDGES],
            diagonal: [0.0; 3],
            slack: f32::INFINITY,
            mask: 0,
            orders: [0; 2],
            places: [0; 2],
        }
    }

    /// Of one or two triangles at so many places.
    fn of(self, triangles: &[FlatTriangle], places: [usize; 2]) -> Self {
        let orders = places.map(|place| triangles[place].order);
        Self { mask: triangles[places[0]].mask, orders, places: places.map(|place| place as u32), ..self }
    }
}

impl Facets {
    pub fn new(triangles: &[FlatTriangle]) -> Self {
        let mut facets = Self::default();
        let mut taken = vec![false; triangles.len()];
        for place in 0..triangles.len() {
            if taken[place] {
                continue;
            }
            let others = (place + 1..triangles.len()).filter(|&other| !taken[other]);
            let pair = others.filter_map(|other| Some((other, quadrilateral(&triangles[place], &triangles[other])?)));
            if let Some((other, facet)) = { pair }.next() {
                taken[other] = true;
                facets.quadrilaterals.push(facet.of(triangles, [place, other]));
            } else {
                let corners = triangles[place].corners.map(|corner| corner.map(f64::from));
                let facet = Facet::new(corners).unwrap_or_else(Facet::vague);
                facets.triangles.push(facet.of(triangles, [place; 2]));
            }
        }
        facets
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.triangles[..]) + size_of_val(&self.quadrilaterals[..])
    }
}

/// The facet of two triangles that share an edge to the bit and make a convex quadrilateral in one plane.
fn quadrilateral(first: &FlatTriangle, second: &FlatTriangle) -> Option<Facet<4>> {
    if first.mask != second.mask {
        return None;
    }
    let bits = |triangle: &FlatTriangle| triangle.corners.map(|corner| corner.map(f32::to_bits));
    let (ours, theirs) = (bits(first), bits(second));
    // Our corner across from the diagonal, and theirs.
    let lone = (0..3).find(|&i| !theirs.contains(&ours[i]))?;
    let other = (0..3).find(|&i| !ours.contains(&theirs[i]))?;
    let [start, end] = [(lone + 1) % 3, (lone + 2) % 3];
    if !theirs.contains(&ours[start]) || !theirs.contains(&ours[end]) || ours[start] == ours[end] {
        return None;
    }
    let wide = |corner: [f32; 3]| corner.map(f64::from);
    let [lone, start, end] = [lone, start, end].map(|i| wide(first.corners[i]));
    Facet::new([start, wide(second.corners[other]), end, lone])
}
