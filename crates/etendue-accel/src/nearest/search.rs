//! Descent through the wide BVH, the nearest box first.
//!
//! # What may be skipped
//!
//! Let u = 2^-24, R the largest magnitude of a coordinate of mesh or point. `triangle` computes everything relative to the point in
//! f64, so its distance is at least that of a true point of the triangle less 2^-49 R, and its square is relatively off by 2^-50.
//! The distance to a box is computed in f32 from the rounded point: u R for that, then relative errors of u in the
//! difference, the subtraction of the pad, the squares and the sums. A pad of 4 u |point| + 2^-44 R and a factor of
//! 1 - 16 u together make it less than what any triangle inside computes. The best distance is rounded up to f32 for the
//! comparison, and equal ones stay: a smaller face may be there.

use super::triangle::closest;
use super::{ClosestPoint, triangle};
use crate::bounds::{greatest, round_up};
use crate::bvh::Bvh;
use crate::bvh::node::{Child, LANES, Node, WIDTH};
use crate::geometry::TriangleMesh;
use crate::isa::SimdKernel;
use crate::local_ray::COORDINATE_LIMIT;
use crate::simd::Simd;

const BELOW: f32 = 1.0 - 16.0 / (1 << 24) as f32;

/// The search for a slice of points.
pub(super) struct Search<'a> {
    pub mesh: &'a TriangleMesh,
    pub bvh: &'a Bvh,
    pub points: &'a [[f64; 3]],
    /// As many as points, or none.
    pub hints: &'a [u32],
    pub within: f64,
    pub found: &'a mut [ClosestPoint],
}

/// A box that waits: a lower bound of the square of its distance, and its child word.
#[derive(Clone, Copy, Default)]
struct Waiting {
    distance: f32,
    word: u32,
}

/// The best so far.
struct Best {
    closest: ClosestPoint,
    /// At least its squared distance.
    limit: f32,
}

impl Best {
    #[inline(always)]
    fn of(closest: ClosestPoint) -> Self {
        Self { closest, limit: limit_of(closest.distance_squared) }
    }

    #[inline(always)]
    fn offer(&mut self, closest: ClosestPoint) {
        if closest.is_before(&self.closest) {
            *self = Self::of(closest);
        }
    }
}

/// Finite, so that missing children, which are infinitely far, are beyond it.
#[inline(always)]
fn limit_of(distance_squared: f64) -> f32 {
    let limit = round_up(distance_squared);
    if limit < f32::MAX { limit } else { f32::MAX }
}

impl SimdKernel for Search<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, _simd: S) {
        let bounds = self.bvh.bounds();
        let reach = bounds.reach();
        let mut stack = vec![Waiting::default(); self.bvh.stack_len()];
        let mut previous = u32::MAX;
        let start = ClosestPoint { distance_squared: self.within * self.within, ..ClosestPoint::NONE };
        for (index, (&point, found)) in self.points.iter().zip(&mut *self.found).enumerate() {
            *found = ClosestPoint::NONE;
            let (Some(root), true) = (self.bvh.root(), is_in_range(point)) else { continue };
            let mut best = Best::of(start);
            let hint = self.hints.get(index).copied().unwrap_or(previous);
            if let Some(face) = self.mesh.indices.get(hint as usize) {
                let corners = face.map(|i| self.mesh.positions[i as usize]);
                let (distance_squared, weights) = triangle::closest_on_triangle(point, &corners);
                best.offer(ClosestPoint { distance_squared, weights, face: hint });
            }
            let near = Near::new(point, reach);
            descend(self.bvh, root, &near, &mut best, &mut stack);
            if best.closest.is_found() {
                *found = best.closest;
            }
            previous = best.closest.face;
        }
    }
}

fn is_in_range(point: [f64; 3]) -> bool {
    point.iter().all(|x| x.abs() <= f64::from(COORDINATE_LIMIT))
}

/// A point as boxes see it.
struct Near {
    point: [f64; 3],
    rounded: [f32; 3],
    pad: f32,
}

impl Near {
    #[inline(always)]
    fn new(point: [f64; 3], reach: f32) -> Self {
        let rounded = point.map(|x| x as f32);
        let far = greatest(greatest(rounded[0].abs(), rounded[1].abs()), rounded[2].abs());
        let pad = far * (4.0 / (1 << 24) as f32) + (far + reach) * (1.0 / (1_u64 << 44) as f32);
        Self { point, rounded, pad }
    }

    /// Lower bounds of the squared distances to the boxes of a node.
    #[inline(always)]
    fn distances(&self, node: &Node) -> [f32; WIDTH] {
        let mut sums = [0.0; WIDTH];
        for axis in 0..3 {
            let (low, high) = (&node.rows[2 * axis], &node.rows[2 * axis + 1]);
            let x = self.rounded[axis];
            for i in 0..WIDTH {
                let gap = greatest(greatest(low[i] - x, x - high[i]) - self.pad, 0.0);
                sums[i] += gap * gap;
            }
        }
        for sum in &mut sums {
            *sum *= BELOW;
        }
        sums
    }
}

/// Improves on the best by all that is below a child word.
#[inline(always)]
fn descend(bvh: &Bvh, root: u32, near: &Near, best: &mut Best, stack: &mut [Waiting]) {
    stack[0] = Waiting { distance: 0.0, word: root };
    let mut len = 1;
    while len > 0 {
        len -= 1;
        let Waiting { distance, word } = stack[len];
        if distance > best.limit {
            continue;
        }
        match Child::of(word) {
            Child::Node(index) => {
                let node = bvh.node(index);
                let distances = near.distances(node);
                let mut close = 0_u32;
                for (i, &distance) in distances.iter().enumerate() {
                    close |= u32::from(distance <= best.limit) << i;
                }
                let base = len;
                while close != 0 {
                    let child = close.trailing_zeros() as usize & (WIDTH - 1);
                    close &= close - 1;
                    let new = Waiting { distance: distances[child], word: node.children[child] };
                    // The farther ones first.
                    let mut place = len;
                    while place > base && stack[place - 1].distance < new.distance {
                        stack[place] = stack[place - 1];
                        place -= 1;
                    }
                    stack[place] = new;
                    len += 1;
                }
            }
            Child::Packs { first, count } => {
                for pack in bvh.packs(first, count) {
                    let found = closest::<LANES>(near.point, &pack.corners);
                    for lane in 0..LANES {
                        best.offer(ClosestPoint {
                            distance_squared: found.distance_squared[lane],
                            weights: found.weights.map(|weights| weights[lane]),
                            face: pack.primitive[lane],
                        });
                    }
                }
            }
            Child::Spheres { .. } | Child::Instance(_) => {}
        }
    }
}
