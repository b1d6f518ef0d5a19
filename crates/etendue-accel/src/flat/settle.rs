//! The second pass: the exact test on the listed pairs, and the best hit of each ray.

use super::scan::{Group, LANES};
use super::{FlatTriangle, Order};
use crate::simd::Simd;
use crate::triangle::{decide, weights};

/// Pairs that are decided at once.
const HALF: usize = LANES / 2;

/// The best hit of each lane. The second half of the arrays takes what is not better than the best.
#[derive(Debug)]
pub(super) struct Best {
    /// The end of the range until something is found.
    t: [f32; 2 * LANES],
    /// 0 until something is found.
    order: [Order; 2 * LANES],
    /// For the weights; zero weights for spheres.
    edges: [[f64; 2 * LANES]; 3],
}

impl Best {
    pub fn new(rays: &Group) -> Self {
        let mut t = [0.0; 2 * LANES];
        t[..LANES].copy_from_slice(&rays.t_max);
        Self { t, order: [0; 2 * LANES], edges: [[0.0; 2 * LANES]; 3] }
    }

    /// Keeps a hit beyond `t_min` if it is the best of its lane. The order of offers does not matter. The first must be
    /// nearer than the end of the range, since no order is below 0.
    #[inline(always)]
    pub fn offer(&mut self, lane: usize, t_min: f32, t: f32, order: Order, edges: [f64; 3]) {
        let nearer = (t < self.t[lane]) | ((t == self.t[lane]) & (order < self.order[lane]));
        let place = if nearer & (t > t_min) { lane } else { lane + LANES };
        (self.t[place], self.order[place]) = (t, order);
        for (row, edge) in self.edges.iter_mut().zip(edges) {
            row[place] = edge;
        }
    }

    /// Where the best hits are, or the ranges end.
    #[inline(always)]
    pub fn ends(&self) -> &[f32; LANES] {
        self.t.first_chunk().expect("as many and more")
    }

    /// What the lanes found: orders, and hits but for their ids.
    #[inline(always)]
    pub fn hits(&self) -> Found {
        let mut found = Found { orders: [0; LANES], t: *self.ends(), u: [0.0; LANES], v: [0.0; LANES] };
        found.orders.copy_from_slice(&self.order[..LANES]);
        for i in 0..LANES {
            [found.u[i], found.v[i]] = weights(self.edges.each_ref().map(|row| row[i]));
        }
        found
    }
}

/// What lanes found.
#[derive(Debug)]
pub(super) struct Found {
    pub orders: [Order; LANES],
    pub t: [f32; LANES],
    pub u: [f32; LANES],
    pub v: [f32; LANES],
}

/// The corners of pairs' triangles as sheared for their rays, by corner and axis.
pub(crate) type Sheared = [[[f32; LANES]; 3]; 3];

/// In plain code: see [`crate::simd::Simd::shear`].
#[inline(always)]
pub(crate) fn shear(triangles: &[FlatTriangle], rays: &Group, pairs: &[u32; LANES], sheared: &mut Sheared) {
    for (i, &pair) in pairs.iter().enumerate() {
        let (triangle, lane) = (&triangles[pair as usize / LANES], pair as usize % LANES);
        let z_axis = rays.major[lane] as usize;
        let (x_axis, y_axis) = ((z_axis + 1) % 3, (z_axis + 2) % 3);
        for (corner, sheared) in triangle.corners.iter().zip(&mut *sheared) {
            let z = corner[z_axis] - rays.turned[2][lane];
            sheared[0][i] = (corner[x_axis] - rays.turned[0][lane]) - rays.shear[0][lane] * z;
            sheared[1][i] = (corner[y_axis] - rays.turned[1][lane]) - rays.shear[1][lane] * z;
            sheared[2][i] = rays.shear[2][lane] * z;
        }
    }
}

/// Decides pairs.
#[inline(always)]
pub(super) fn settle<S: Simd>(simd: S, triangles: &[FlatTriangle], rays: &Group, pairs: &[u32], best: &mut Best) {
    for pairs in pairs.chunks(LANES) {
        // A pair may be decided twice.
        let mut whole = [pairs[pairs.len() - 1]; LANES];
        whole[..pairs.len()].copy_from_slice(pairs);
        let mut sheared = [[[0.0; LANES]; 3]; 3];
        simd.shear(triangles, rays, &whole, &mut sheared);
        for half in 0..pairs.len().div_ceil(HALF) {
            let part = |row: &[f32; LANES]| -> [f32; HALF] { std::array::from_fn(|i| row[half * HALF + i]) };
            let corners = sheared.each_ref().map(|corner| corner.each_ref().map(part));
            let found = decide(corners);
            for (i, pair) in pairs[half * HALF..].iter().take(HALF).enumerate() {
                let (triangle, lane) = (*pair as usize / LANES, *pair as usize % LANES);
                let [v, w, det] = &found.edges;
                best.offer(lane, rays.t_min[lane], found.t[i], triangles[triangle].order, [v[i], w[i], det[i]]);
            }
        }
    }
}
