//! The second pass: the exact test on the listed pairs, and the best hit of each ray.

use super::scan::{Group, LANES};
use super::{FlatTriangle, Order};
use crate::ray::Hit;
use crate::triangle::{decide, weights};

/// Pairs that are decided at once.
const BATCH: usize = 8;

/// The best hit of each lane. The second half of the arrays takes what is not better than the best.
#[derive(Debug)]
pub(super) struct Best {
    /// The end of the range until something is found.
    t: [f32; 2 * LANES],
    /// 0 until something is found.
    order: [Order; 2 * LANES],
    /// For the weights; zero weights for spheres.
    edges: [[f64; 3]; 2 * LANES],
}

impl Best {
    pub fn new(rays: &Group) -> Self {
        let mut t = [0.0; 2 * LANES];
        t[..LANES].copy_from_slice(&rays.t_max);
        Self { t, order: [0; 2 * LANES], edges: [[0.0; 3]; 2 * LANES] }
    }

    /// Keeps a hit beyond `t_min` if it is the best of its lane. The order of offers does not matter. The first must be
    /// nearer than the end of the range, since no order is below 0.
    #[inline(always)]
    pub fn offer(&mut self, lane: usize, t_min: f32, t: f32, order: Order, edges: [f64; 3]) {
        let nearer = (t < self.t[lane]) | ((t == self.t[lane]) & (order < self.order[lane]));
        let place = if nearer & (t > t_min) { lane } else { lane + LANES };
        (self.t[place], self.order[place], self.edges[place]) = (t, order, edges);
    }

    /// Where the best hits are, or the ranges end.
    #[inline(always)]
    pub fn ends(&self) -> &[f32; LANES] {
        self.t.first_chunk().expect("as many and more")
    }

    /// What a lane found, with the order instead of the id.
    #[inline(always)]
    pub fn hit(&self, lane: usize) -> (Order, Hit) {
        let [u, v] = weights(self.edges[lane]);
        (self.order[lane], Hit { t: self.t[lane], u, v, ..Hit::MISS })
    }
}

/// Decides pairs.
#[inline(always)]
pub(super) fn settle<const AXIS: usize>(triangles: &[FlatTriangle], rays: &Group, pairs: &[u32], best: &mut Best) {
    for pairs in pairs.chunks(BATCH) {
        let mut corners = [[[0.0; BATCH]; 3]; 3];
        let mut orders = [0; BATCH];
        for i in 0..BATCH {
            // A pair may be decided twice.
            let pair = pairs[i.min(pairs.len() - 1)] as usize;
            let (triangle, lane) = (&triangles[pair / LANES], pair % LANES);
            orders[i] = triangle.order;
            for (corner, sheared) in triangle.corners.iter().zip(&mut corners) {
                let z = corner[AXIS] - rays.origin[2][lane];
                sheared[0][i] = (corner[(AXIS + 1) % 3] - rays.origin[0][lane]) - rays.shear[0][lane] * z;
                sheared[1][i] = (corner[(AXIS + 2) % 3] - rays.origin[1][lane]) - rays.shear[1][lane] * z;
                sheared[2][i] = rays.shear[2][lane] * z;
            }
        }
        let found = decide(corners);
        for (i, pair) in pairs.iter().enumerate() {
            let lane = *pair as usize % LANES;
            let [v, w, det] = &found.edges;
            best.offer(lane, rays.t_min[lane], found.t[i], orders[i], [v[i], w[i], det[i]]);
        }
    }
}
