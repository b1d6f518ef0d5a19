//! The vector operations of traversal, for every instruction set: eight boxes, the filter of four triangles, and the
//! filter of sixteen rays on many.

use crate::bounds::{greatest, least};
use crate::bvh::beam::{self, BEAM, Beam, Lanes};
use crate::bvh::node::{LANES, Node, Pack, WIDTH, rows_of};
use crate::flat::{self, Columns, Facets, FlatTriangle, Group, Pairs, Sheared};
use crate::isa::SimdKernel;
use crate::local_ray::LocalRay;
use crate::padding::{Padding, SlabRay};
use crate::ray::Ray;

#[cfg(target_arch = "x86_64")]
pub(crate) mod x86;
#[cfg(target_arch = "x86_64")]
mod x86_alone;
#[cfg(target_arch = "x86_64")]
mod x86_beam;
#[cfg(target_arch = "x86_64")]
mod x86_beam_avx2;
#[cfg(target_arch = "x86_64")]
mod x86_flat;
#[cfg(target_arch = "x86_64")]
mod x86_scan;

/// An instruction set at work. Values of the types for optional sets exist only where the processor has them.
pub(crate) trait Simd: Copy {
    /// Rays further apart than this ([`Beam::spread`]) are not tried as a beam, as measured.
    const BEAM_SPREAD: f32;

    /// The children whose padded boxes the ray enters within the range, the nearest last; with `ANY` in the order of
    /// [`Node::order_of`]. Their entry distances and words, and how many there are.
    fn children<const ANY: bool>(
        self,
        node: &Node,
        ray: &SlabRay,
        range: &(f32, f32),
        entries: &mut [f32; WIDTH],
        words: &mut [u32; WIDTH],
    ) -> usize;

    /// What boxes and triangles ask of a ray that comes alone.
    type Aim;

    /// What boxes ask of it: numbers in registers, if there are such.
    type Slabs;

    /// A ray of the world; `None` if it hits nothing by definition.
    fn aim(self, ray: &Ray, padding: &Padding) -> Option<Self::Aim>;

    /// A ray inside of an instance.
    fn aim_inside(self, ray: &LocalRay, slab: &SlabRay) -> Self::Aim;

    /// To be asked for before each descent: registers are taken for as long as that is.
    fn slabs(self, aim: &Self::Aim) -> Self::Slabs;

    /// The same as [`Self::children`] for a ray that comes alone, and the nearest child's word, which is known long before
    /// what is written; any word if there is none.
    fn visit<const ANY: bool>(
        self,
        node: &Node,
        slabs: &Self::Slabs,
        range: (f32, f32),
        entries: &mut [f32; WIDTH],
        words: &mut [u32; WIDTH],
    ) -> (usize, u32);

    /// The same as [`Self::candidates`] for a ray that comes alone, without the primitive to be skipped.
    fn candidates_alone(self, pack: &Pack, aim: &Self::Aim, skip: u32) -> u32;

    /// Those candidates whose corners are not all outside of the range, and the sheared corners of all.
    fn within(self, pack: &Pack, aim: &Self::Aim, range: (f32, f32), candidates: u32) -> (u32, [[[f32; LANES]; 3]; 3]);

    /// Runs what is rare as a call, so that it takes no registers from what calls it.
    fn apart<K: SimdKernel>(self, kernel: K) -> K::Output;

    /// A bit for every triangle that the exact test of [`crate::triangle`] may accept. The sheared corners have the same
    /// bits as there, so what is rejected here would be rejected there.
    fn candidates(self, pack: &Pack, ray: &LocalRay) -> u32;

    /// A bit for every child whose padded box any ray of the beam may enter, and all that some ray does.
    fn beam_outline(self, node: &Node, beam: &Beam) -> u32;

    /// Of some children by number those whose padded boxes any ray of the beam enters: where the rays enter, NaN for those that
    /// do not, and words; how many there are.
    fn beam_children(
        self,
        node: &Node,
        beam: &Beam,
        children: &[u8],
        enters: &mut [Lanes; WIDTH],
        words: &mut [u32; WIDTH],
    ) -> usize;

    /// A bit for every ray that enters a box at or before its bound.
    fn waiting(self, enters: &Lanes, bound: &Lanes) -> u32;

    /// A bit for every ray of the beam that the exact test may let hit a triangle of the pack within its range. Where there
    /// is any, also the corners as sheared for each ray.
    fn beam_triangle(self, pack: &Pack, place: usize, beam: &Beam, sheared: &mut [[[f32; BEAM]; 3]; 3]) -> u32;

    /// Lists the pairs of a triangle and a ray of the group that the exact test of [`crate::triangle`] may accept as the
    /// closest hit, at most [`flat::LIMIT`] triangles. With `ANY` gives a bit for every ray that is certain to hit something within its range, and lists pairs for the others only.
    fn scan<const ANY: bool>(self, facets: &Facets, rays: &Group, pairs: &mut Pairs) -> u32;

    /// Sixteen rays by component.
    #[inline(always)]
    fn transpose(self, rays: &[Ray; flat::LANES], columns: &mut Columns) {
        columns.fill(rays);
    }

    /// Shears the corners of the triangles of pairs, as they are listed by [`Self::scan`], for their rays: the operations of
    /// [`crate::triangle::shear`].
    #[inline(always)]
    fn shear(self, triangles: &[FlatTriangle], rays: &Group, pairs: &[u32; flat::LANES], sheared: &mut Sheared) {
        flat::shear(triangles, rays, pairs, sheared);
    }

    /// Takes the words whose entry distances are beyond `t` off a stack, which has [`STACK_ROOM`] more than its length; the
    /// new length.
    fn cull(self, entries: &mut [f32], words: &mut [u32], len: usize, t: f32) -> usize;

    /// The larger of each pair, or the second where they are equal. Never compiled to a masked store, which the next load would
    /// have to wait for.
    fn maxima(self, a: &[f32; 8], b: &[f32; 8]) -> [f32; 8];

    /// Asks for so many cache lines, whether there is anything or not.
    fn prefetch_lines<const LINES: usize>(self, start: *const u8);
}

/// Entries of a stack beyond its length that may be read and written, because vectors are moved whole.
pub(crate) const STACK_ROOM: usize = 16;

/// Plain code, vectorised as far as the compiler can.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Portable;

impl Simd for Portable {
    const BEAM_SPREAD: f32 = 0.3;

    #[inline(always)]
    fn children<const ANY: bool>(
        self,
        node: &Node,
        ray: &SlabRay,
        range: &(f32, f32),
        entries: &mut [f32; WIDTH],
        words: &mut [u32; WIDTH],
    ) -> usize {
        let &(t_min, t_max) = range;
        let (mut enter, mut exit) = ([t_min; WIDTH], [t_max; WIDTH]);
        let [near, far] = rows_of(ray.octant);
        for axis in 0..3 {
            let (first, last) = (node.row(near[axis]), node.row(far[axis]));
            for i in 0..WIDTH {
                enter[i] = greatest(first[i] * ray.rate[axis] - ray.near[axis], enter[i]);
                exit[i] = least(last[i] * ray.rate[axis] - ray.far[axis], exit[i]);
            }
        }
        let order = node.order_of::<ANY>(ray.octant);
        let mut used = 0;
        for i in 0..WIDTH {
            let child = (order >> (3 * i) & 7) as usize;
            entries[used & 7] = enter[child];
            words[used & 7] = node.children[child];
            used += usize::from(enter[child] <= exit[child]);
        }
        used
    }

    type Aim = (LocalRay, SlabRay);
    type Slabs = SlabRay;

    #[inline(always)]
    fn aim(self, ray: &Ray, padding: &Padding) -> Option<Self::Aim> {
        let ray = LocalRay::new(ray.origin, ray.direction)?;
        Some((ray, SlabRay::new(&ray, padding)))
    }

    #[inline(always)]
    fn aim_inside(self, ray: &LocalRay, slab: &SlabRay) -> Self::Aim {
        (*ray, *slab)
    }

    #[inline(always)]
    fn slabs(self, (_, slab): &Self::Aim) -> SlabRay {
        *slab
    }

    #[inline(always)]
    fn visit<const ANY: bool>(
        self,
        node: &Node,
        slab: &SlabRay,
        range: (f32, f32),
        entries: &mut [f32; WIDTH],
        words: &mut [u32; WIDTH],
    ) -> (usize, u32) {
        let count = self.children::<ANY>(node, slab, &range, entries, words);
        (count, words[count.wrapping_sub(1) & 7])
    }

    #[inline(always)]
    fn candidates_alone(self, pack: &Pack, (ray, _): &Self::Aim, skip: u32) -> u32 {
        let skipped: u32 = (0..LANES).map(|lane| u32::from(pack.primitive[lane] == skip) << lane).sum();
        self.candidates(pack, ray) & !skipped
    }

    #[inline(always)]
    fn within(
        self,
        pack: &Pack,
        (ray, _): &Self::Aim,
        (t_min, t_max): (f32, f32),
        mut candidates: u32,
    ) -> (u32, [[[f32; LANES]; 3]; 3]) {
        let corners = pack.sheared(ray);
        let [[_, _, a], [_, _, b], [_, _, c]] = &corners;
        for i in 0..LANES {
            let [a, b, c] = [a[i], b[i], c[i]];
            let may = (greatest(greatest(a, b), c) > t_min) & (least(least(a, b), c) <= t_max);
            candidates &= !(u32::from(!may) << i);
        }
        (candidates, corners)
    }

    #[inline(always)]
    fn apart<K: SimdKernel>(self, kernel: K) -> K::Output {
        kernel.run(self)
    }

    #[inline(always)]
    fn candidates(self, pack: &Pack, ray: &LocalRay) -> u32 {
        let [[ax, ay, _], [bx, by, _], [cx, cy, _]] = pack.sheared(ray);
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
    fn beam_outline(self, node: &Node, beam: &Beam) -> u32 {
        beam.outline.children(node, &beam.rows)
    }

    #[inline(always)]
    fn beam_children(
        self,
        node: &Node,
        beam: &Beam,
        children: &[u8],
        enters: &mut [Lanes; WIDTH],
        words: &mut [u32; WIDTH],
    ) -> usize {
        beam::children(node, beam, children, enters, words)
    }

    #[inline(always)]
    fn waiting(self, enters: &Lanes, bound: &Lanes) -> u32 {
        beam::waiting(enters, bound)
    }

    #[inline(always)]
    fn beam_triangle(self, pack: &Pack, place: usize, beam: &Beam, sheared: &mut [[[f32; BEAM]; 3]; 3]) -> u32 {
        beam::triangle(pack, place, beam, sheared)
    }

    #[inline(always)]
    fn scan<const ANY: bool>(self, facets: &Facets, rays: &Group, pairs: &mut Pairs) -> u32 {
        flat::scan::<ANY>(facets, rays, pairs)
    }

    #[inline(always)]
    fn cull(self, entries: &mut [f32], words: &mut [u32], len: usize, t: f32) -> usize {
        let mut kept = 0;
        for i in 0..len {
            (entries[kept], words[kept]) = (entries[i], words[i]);
            // Equal distances stay: a smaller id may be there.
            kept += usize::from(entries[i] <= t);
        }
        kept
    }

    #[inline(always)]
    fn maxima(self, a: &[f32; 8], b: &[f32; 8]) -> [f32; 8] {
        let mut maxima = *a;
        for i in 0..8 {
            maxima[i] = greatest(a[i], b[i]);
        }
        maxima
    }

    #[cfg(target_arch = "x86_64")]
    #[inline(always)]
    fn prefetch_lines<const LINES: usize>(self, start: *const u8) {
        x86::prefetch::<LINES>(start);
    }

    #[cfg(not(target_arch = "x86_64"))]
    #[inline(always)]
    fn prefetch_lines<const LINES: usize>(self, _start: *const u8) {}
}
