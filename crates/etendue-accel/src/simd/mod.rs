//! The vector operations of traversal, for every instruction set: eight boxes, the filter of four triangles, and the
//! filter of sixteen rays on many.

use crate::bounds::{greatest, least};
use crate::bvh::node::{LANES, Node, Pack, WIDTH, near_rows};
use crate::flat::{self, FlatTriangle, Group, Pairs};
use crate::local_ray::LocalRay;
use crate::padding::SlabRay;

#[cfg(target_arch = "x86_64")]
pub(crate) mod x86;
#[cfg(target_arch = "x86_64")]
mod x86_scan;

/// What is still to be visited: child words with the entry distances of their boxes. Has room for [`WIDTH`] entries
/// more than are used, because vectors are stored whole.
#[derive(Debug)]
pub(crate) struct Stack<'a> {
    pub entry: &'a mut [f32],
    pub child: &'a mut [u32],
    pub len: usize,
}

impl Stack<'_> {
    #[inline(always)]
    pub fn push(&mut self, entry: f32, child: u32) {
        self.entry[self.len] = entry;
        self.child[self.len] = child;
        self.len += 1;
    }

    /// The place for the next vector.
    #[inline(always)]
    fn place(&mut self) -> (&mut [f32], &mut [u32]) {
        let end = self.len + WIDTH;
        (&mut self.entry[self.len..end], &mut self.child[self.len..end])
    }
}

/// An instruction set at work. Values of the types for optional sets exist only where the processor has them.
pub(crate) trait Simd: Copy {
    /// Pushes the children whose padded boxes the ray enters within the range, the nearest last.
    fn push_children(self, node: &Node, ray: &SlabRay, range: (f32, f32), stack: &mut Stack<'_>);

    /// A bit for every triangle that the exact test of [`crate::triangle`] may accept. The sheared corners have the same
    /// bits as there, so what is rejected here would be rejected there.
    fn candidates(self, pack: &Pack, ray: &LocalRay) -> u32;

    /// Lists the pairs of a triangle and a ray of the group that the exact test of [`crate::triangle`] may accept as the
    /// closest hit, at most [`flat::LIMIT`] triangles. The axis is that of the rays' largest components. With `ANY` gives
    /// a bit for every ray that is certain to hit something within its range, and lists pairs for the others only.
    fn scan<const AXIS: usize, const ANY: bool>(
        self,
        triangles: &[FlatTriangle],
        rays: &Group,
        pairs: &mut Pairs,
    ) -> u32;

    /// Asks for the first cache lines of something that will be read soon.
    fn prefetch<T>(self, what: &T);
}

/// Plain code, vectorised as far as the compiler can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

impl Simd for Portable {
    #[inline(always)]
    fn push_children(self, node: &Node, ray: &SlabRay, (t_min, t_max): (f32, f32), stack: &mut Stack<'_>) {
        let (mut enter, mut exit) = ([t_min; WIDTH], [t_max; WIDTH]);
        for (axis, near) in near_rows(ray).into_iter().enumerate() {
            let (first, last) = (&node.rows[near], &node.rows[near ^ 1]);
            for i in 0..WIDTH {
                enter[i] = greatest(first[i] * ray.rate[axis] - ray.near[axis], enter[i]);
                exit[i] = least(last[i] * ray.rate[axis] - ray.far[axis], exit[i]);
            }
        }
        let order = node.order[ray.octant];
        let (entries, children) = stack.place();
        let mut used = 0;
        for i in 0..WIDTH {
            let child = (order >> (3 * i) & 7) as usize;
            entries[used & 7] = enter[child];
            children[used & 7] = node.children[child];
            used += usize::from(enter[child] <= exit[child]);
        }
        stack.len += used;
    }

    #[inline(always)]
    fn candidates(self, pack: &Pack, ray: &LocalRay) -> u32 {
        let [kx, ky, kz] = ray.axes;
        let mut sheared = [[[0.0_f32; LANES]; 2]; 3];
        for (corner, [x, y]) in pack.corners.iter().zip(&mut sheared) {
            for i in 0..LANES {
                let z = corner[kz][i] - ray.origin[kz];
                x[i] = (corner[kx][i] - ray.origin[kx]) - ray.shear[0] * z;
                y[i] = (corner[ky][i] - ray.origin[ky]) - ray.shear[1] * z;
            }
        }
        let [[ax, ay], [bx, by], [cx, cy]] = sheared;
        let mut found = 0;
        for i in 0..LANES {
            let u = cx[i] * by[i] - cy[i] * bx[i];
            let v = ax[i] * cy[i] - ay[i] * cx[i];
            let w = bx[i] * ay[i] - by[i] * ax[i];
            let same_side = greatest(greatest(u, v), w) <= 0.0 || least(least(u, v), w) >= 0.0;
            found |= u32::from(same_side) << i;
        }
        found
    }

    #[inline(always)]
    fn scan<const AXIS: usize, const ANY: bool>(
        self,
        triangles: &[FlatTriangle],
        rays: &Group,
        pairs: &mut Pairs,
    ) -> u32 {
        flat::scan::<AXIS, ANY>(triangles, rays, pairs)
    }

    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn prefetch<T>(self, what: &T) {
        x86::prefetch(what);
    }

    #[cfg(not(target_arch = "x86_64"))]
    #[inline(always)]
    fn prefetch<T>(self, _what: &T) {}
}
