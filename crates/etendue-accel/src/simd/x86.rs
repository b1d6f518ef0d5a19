//! AVX2 with FMA, and AVX-512 on 256-bit vectors.
//!
//! Fused multiply-subtract appears in box tests only, where the proof of `padding.rs` allows either rounding.

use std::arch::x86_64::*;

use super::Simd;
use super::x86_alone::{self, Aim, Slabs};
use super::x86_beam::{beam_children, beam_triangle, waiting};
use super::x86_beam_avx2;
use super::x86_flat::{shear, transpose};
use super::x86_scan::{scan_avx2, scan_avx512};
use crate::bvh::beam::{BEAM, Beam, Lanes};
use crate::bvh::node::{LANES, Node, Pack, WIDTH, rows_of};
use crate::flat::{self, Columns, Facets, FlatTriangle, Group, Pairs, Sheared};
use crate::isa::SimdKernel;
use crate::local_ray::LocalRay;
use crate::padding::{Padding, SlabRay};
use crate::ray::Ray;

/// Exists only inside [`run_avx2`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx2(());

/// Exists only inside [`run_avx512`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Avx512(());

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
pub(crate) fn run_avx2<K: SimdKernel>(kernel: K) -> K::Output {
    kernel.run(Avx2(()))
}

#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw,avx512cd")]
pub(crate) fn run_avx512<K: SimdKernel>(kernel: K) -> K::Output {
    kernel.run(Avx512(()))
}

/// See [`Simd::apart`].
#[cold]
#[inline(never)]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn apart_avx2<K: SimdKernel>(kernel: K) -> K::Output {
    kernel.run(Avx2(()))
}

/// See [`Simd::apart`].
#[cold]
#[inline(never)]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw,avx512cd")]
fn apart_avx512<K: SimdKernel>(kernel: K) -> K::Output {
    kernel.run(Avx512(()))
}

impl Simd for Avx2 {
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
        // SAFETY: a value of type Avx2 exists only in code that `run_avx2` runs, so the processor has the features.
        unsafe { children_avx2::<ANY>(node, ray, range, entries, words) }
    }

    type Aim = Aim;
    type Slabs = Slabs;

    #[inline(always)]
    fn aim(self, ray: &Ray, padding: &Padding) -> Option<Aim> {
        // SAFETY: as above.
        unsafe { Aim::new(ray, padding) }
    }

    #[inline(always)]
    fn aim_inside(self, ray: &LocalRay, slab: &SlabRay) -> Aim {
        Aim::inside(ray, slab)
    }

    #[inline(always)]
    fn slabs(self, aim: &Aim) -> Slabs {
        // SAFETY: as above.
        unsafe { aim.slabs() }
    }

    #[inline(always)]
    fn visit<const ANY: bool>(
        self,
        node: &Node,
        slabs: &Slabs,
        range: (f32, f32),
        entries: &mut [f32; WIDTH],
        words: &mut [u32; WIDTH],
    ) -> (usize, u32) {
        // SAFETY: as above.
        unsafe { x86_alone::visit_avx2::<ANY>(node, slabs, range, entries, words) }
    }

    #[inline(always)]
    fn candidates_alone(self, pack: &Pack, aim: &Aim, skip: u32) -> u32 {
        // SAFETY: as above.
        unsafe { x86_alone::candidates(pack, aim, skip) }
    }

    #[inline(always)]
    fn within(self, pack: &Pack, aim: &Aim, range: (f32, f32), candidates: u32) -> (u32, [[[f32; LANES]; 3]; 3]) {
        // SAFETY: as above.
        unsafe { x86_alone::within(pack, aim, range, candidates) }
    }

    #[inline(always)]
    fn apart<K: SimdKernel>(self, kernel: K) -> K::Output {
        // SAFETY: as above.
        unsafe { apart_avx2(kernel) }
    }

    #[inline(always)]
    fn candidates(self, pack: &Pack, ray: &LocalRay) -> u32 {
        // SAFETY: as above.
        unsafe { candidates_avx2(pack, ray) }
    }

    #[inline(always)]
    fn beam_outline(self, node: &Node, beam: &Beam) -> u32 {
        // SAFETY: as above.
        unsafe { x86_beam_avx2::beam_outline(node, beam) }
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
        // SAFETY: as above.
        unsafe { x86_beam_avx2::beam_children(node, beam, children, enters, words) }
    }

    #[inline(always)]
    fn waiting(self, enters: &Lanes, bound: &Lanes) -> u32 {
        // SAFETY: as above.
        unsafe { x86_beam_avx2::waiting(enters, bound) }
    }

    #[inline(always)]
    fn beam_triangle(self, pack: &Pack, place: usize, beam: &Beam, sheared: &mut [[[f32; BEAM]; 3]; 3]) -> u32 {
        // SAFETY: as above.
        unsafe { x86_beam_avx2::beam_triangle(pack, place, beam, sheared) }
    }

    #[inline(always)]
    fn scan<const ANY: bool>(self, facets: &Facets, rays: &Group, pairs: &mut Pairs) -> u32 {
        // SAFETY: as above.
        unsafe { scan_avx2::<ANY>(facets, rays, pairs) }
    }

    #[inline(always)]
    fn cull(self, entries: &mut [f32], words: &mut [u32], len: usize, t: f32) -> usize {
        // SAFETY: as above.
        unsafe { cull_avx2(entries, words, len, t) }
    }

    #[inline(always)]
    fn maxima(self, a: &[f32; 8], b: &[f32; 8]) -> [f32; 8] {
        // SAFETY: as above.
        unsafe { maxima(a, b) }
    }

    #[inline(always)]
    fn prefetch_lines<const LINES: usize>(self, start: *const u8) {
        prefetch::<LINES>(start);
    }
}

impl Simd for Avx512 {
    const BEAM_SPREAD: f32 = f32::INFINITY;

    #[inline(always)]
    fn children<const ANY: bool>(
        self,
        node: &Node,
        ray: &SlabRay,
        range: &(f32, f32),
        entries: &mut [f32; WIDTH],
        words: &mut [u32; WIDTH],
    ) -> usize {
        // SAFETY: a value of type Avx512 exists only in code that `run_avx512` runs, so the processor has the features.
        unsafe { children_avx512::<ANY>(node, ray, range, entries, words) }
    }

    type Aim = Aim;
    type Slabs = Slabs;

    #[inline(always)]
    fn aim(self, ray: &Ray, padding: &Padding) -> Option<Aim> {
        // SAFETY: as above.
        unsafe { Aim::new(ray, padding) }
    }

    #[inline(always)]
    fn aim_inside(self, ray: &LocalRay, slab: &SlabRay) -> Aim {
        Aim::inside(ray, slab)
    }

    #[inline(always)]
    fn slabs(self, aim: &Aim) -> Slabs {
        // SAFETY: as above.
        unsafe { aim.slabs() }
    }

    #[inline(always)]
    fn visit<const ANY: bool>(
        self,
        node: &Node,
        slabs: &Slabs,
        range: (f32, f32),
        entries: &mut [f32; WIDTH],
        words: &mut [u32; WIDTH],
    ) -> (usize, u32) {
        // SAFETY: as above.
        unsafe { x86_alone::visit_avx512::<ANY>(node, slabs, range, entries, words) }
    }

    #[inline(always)]
    fn candidates_alone(self, pack: &Pack, aim: &Aim, skip: u32) -> u32 {
        // SAFETY: as above.
        unsafe { x86_alone::candidates(pack, aim, skip) }
    }

    #[inline(always)]
    fn within(self, pack: &Pack, aim: &Aim, range: (f32, f32), candidates: u32) -> (u32, [[[f32; LANES]; 3]; 3]) {
        // SAFETY: as above.
        unsafe { x86_alone::within(pack, aim, range, candidates) }
    }

    #[inline(always)]
    fn apart<K: SimdKernel>(self, kernel: K) -> K::Output {
        // SAFETY: as above.
        unsafe { apart_avx512(kernel) }
    }

    #[inline(always)]
    fn candidates(self, pack: &Pack, ray: &LocalRay) -> u32 {
        // SAFETY: as above; the features of AVX2 are among those of Avx512.
        unsafe { candidates_avx2(pack, ray) }
    }

    #[inline(always)]
    fn beam_outline(self, node: &Node, beam: &Beam) -> u32 {
        // SAFETY: as above.
        unsafe { x86_beam_avx2::beam_outline(node, beam) }
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
        // SAFETY: as above.
        unsafe { beam_children(node, beam, children, enters, words) }
    }

    #[inline(always)]
    fn waiting(self, enters: &Lanes, bound: &Lanes) -> u32 {
        // SAFETY: as above.
        unsafe { waiting(enters, bound) }
    }

    #[inline(always)]
    fn beam_triangle(self, pack: &Pack, place: usize, beam: &Beam, sheared: &mut [[[f32; BEAM]; 3]; 3]) -> u32 {
        // SAFETY: as above.
        unsafe { beam_triangle(pack, place, beam, sheared) }
    }

    #[inline(always)]
    fn scan<const ANY: bool>(self, facets: &Facets, rays: &Group, pairs: &mut Pairs) -> u32 {
        // SAFETY: as above.
        unsafe { scan_avx512::<ANY>(facets, rays, pairs) }
    }

    #[inline(always)]
    fn transpose(self, rays: &[Ray; flat::LANES], columns: &mut Columns) {
        // SAFETY: as above.
        unsafe { transpose(rays, columns) }
    }

    #[inline(always)]
    fn shear(self, triangles: &[FlatTriangle], rays: &Group, pairs: &[u32; flat::LANES], sheared: &mut Sheared) {
        // SAFETY: as above.
        unsafe { shear(triangles, rays, pairs, sheared) }
    }

    #[inline(always)]
    fn cull(self, entries: &mut [f32], words: &mut [u32], len: usize, t: f32) -> usize {
        // SAFETY: as above.
        unsafe { cull_avx512(entries, words, len, t) }
    }

    #[inline(always)]
    fn maxima(self, a: &[f32; 8], b: &[f32; 8]) -> [f32; 8] {
        // SAFETY: as above.
        unsafe { maxima(a, b) }
    }

    #[inline(always)]
    fn prefetch_lines<const LINES: usize>(self, start: *const u8) {
        prefetch::<LINES>(start);
    }
}

/// See [`Simd::maxima`].
#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn maxima(a: &[f32; 8], b: &[f32; 8]) -> [f32; 8] {
    let mut maxima = [0.0; 8];
    // SAFETY: the arrays hold eight elements, and neither loads nor stores need alignment.
    unsafe {
        _mm256_storeu_ps(maxima.as_mut_ptr(), _mm256_max_ps(_mm256_loadu_ps(a.as_ptr()), _mm256_loadu_ps(b.as_ptr())))
    };
    maxima
}

/// Asks for so many cache lines.
#[inline(always)]
pub(super) fn prefetch<const LINES: usize>(start: *const u8) {
    for line in 0..LINES {
        // SAFETY: prefetching reads nothing that the program can see, at any address; SSE is part of x86-64.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64 * line).cast()) }
    }
}

// The functions below are not compiled for a set of their own but inlined into code that is: calls would spill vectors.

/// Entry and exit distances of the eight boxes.
///
/// # Safety
/// The processor has AVX2 and FMA.
#[inline(always)]
unsafe fn intervals(node: &Node, ray: &SlabRay, (t_min, t_max): &(f32, f32)) -> (__m256, __m256) {
    // SAFETY: the caller says so; rows of eight floats begin where the table says, and the loads need no alignment.
    unsafe {
        let [near, far] = rows_of(ray.octant);
        let row = |start: u8| _mm256_loadu_ps(node.rows.as_ptr().cast::<f32>().add(usize::from(start)));
        let near = |axis: usize| {
            let rate = _mm256_set1_ps(ray.rate[axis]);
            _mm256_fmsub_ps(row(near[axis]), rate, _mm256_set1_ps(ray.near[axis]))
        };
        let far = |axis: usize| {
            let rate = _mm256_set1_ps(ray.rate[axis]);
            _mm256_fmsub_ps(row(far[axis]), rate, _mm256_set1_ps(ray.far[axis]))
        };
        let enter = _mm256_max_ps(_mm256_max_ps(near(0), near(1)), _mm256_max_ps(near(2), _mm256_broadcast_ss(t_min)));
        let exit = _mm256_min_ps(_mm256_min_ps(far(0), far(1)), _mm256_min_ps(far(2), _mm256_broadcast_ss(t_max)));
        (enter, exit)
    }
}

/// The indices of the children from far to near.
///
/// # Safety
/// The processor has AVX2.
#[inline(always)]
pub(super) unsafe fn order_of(node: &Node, octant: u32) -> __m256i {
    // SAFETY: the caller says so.
    unsafe {
        // Only the lowest three bits of an index count.
        let word = _mm256_set1_epi32(node.order[octant as usize & 7] as i32);
        _mm256_srlv_epi32(word, _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21))
    }
}

/// # Safety
/// The processor has the features of [`Avx2`].
#[inline(always)]
unsafe fn children_avx2<const ANY: bool>(
    node: &Node,
    ray: &SlabRay,
    range: &(f32, f32),
    entries: &mut [f32; WIDTH],
    words: &mut [u32; WIDTH],
) -> usize {
    // SAFETY: the caller says so; arrays hold eight elements, and loads and stores need no alignment.
    unsafe {
        let (enter, exit) = intervals(node, ray, range);
        let children = _mm256_loadu_si256(node.children.as_ptr().cast());
        let mut entered = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, exit);
        let order = order_of(node, ray.octant);
        if !ANY {
            entered = _mm256_permutevar8x32_ps(entered, order);
        }
        let entered = _mm256_movemask_ps(entered) as usize;
        let mut places = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(COMPRESS[entered & 255] as i64));
        if !ANY {
            places = _mm256_permutevar8x32_epi32(order, places);
        }
        _mm256_storeu_ps(entries.as_mut_ptr(), _mm256_permutevar8x32_ps(enter, places));
        _mm256_storeu_si256(words.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(children, places));
        entered.count_ones() as usize
    }
}

/// # Safety
/// The processor has the features of [`Avx512`].
#[inline(always)]
unsafe fn children_avx512<const ANY: bool>(
    node: &Node,
    ray: &SlabRay,
    range: &(f32, f32),
    entries: &mut [f32; WIDTH],
    words: &mut [u32; WIDTH],
) -> usize {
    // SAFETY: as in `children_avx2`.
    unsafe {
        let intervals = intervals(node, ray, range);
        compress_avx512::<ANY>(node, ray.octant, intervals, entries, words).count_ones() as usize
    }
}

/// Writes entry distances and words of the children that are entered, and gives their bits: in the order of [`Node::order_of`].
///
/// # Safety
/// The processor has the features of [`Avx512`].
#[inline(always)]
pub(super) unsafe fn compress_avx512<const ANY: bool>(
    node: &Node,
    octant: u32,
    (mut enter, mut exit): (__m256, __m256),
    entries: &mut [f32; WIDTH],
    words: &mut [u32; WIDTH],
) -> u8 {
    // SAFETY: the caller says so; arrays hold eight elements, and loads and stores need no alignment.
    unsafe {
        let mut children = _mm256_loadu_si256(node.children.as_ptr().cast());
        if !ANY {
            let order = order_of(node, octant);
            enter = _mm256_permutexvar_ps(order, enter);
            exit = _mm256_permutexvar_ps(order, exit);
            children = _mm256_permutexvar_epi32(order, children);
        }
        let entered = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(enter, exit);
        _mm256_storeu_ps(entries.as_mut_ptr(), _mm256_maskz_compress_ps(entered, enter));
        _mm256_storeu_si256(words.as_mut_ptr().cast(), _mm256_maskz_compress_epi32(entered, children));
        entered
    }
}

/// # Safety
/// The processor has the features of [`Avx2`].
#[inline(always)]
unsafe fn cull_avx2(entries: &mut [f32], words: &mut [u32], len: usize, t: f32) -> usize {
    let (mut kept, mut from) = (0, 0);
    while from < len {
        let (Some(old), Some(old_words)) = (entries[from..].first_chunk(), words[from..].first_chunk()) else { break };
        let (old, old_words): (&[f32; 8], &[u32; 8]) = (old, old_words);
        // SAFETY: the caller says so; arrays hold eight elements, and the loads need no alignment.
        let (old, old_words, near) = unsafe {
            let old = _mm256_loadu_ps(old.as_ptr());
            let near = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(old, _mm256_set1_ps(t))) as u32;
            (old, _mm256_loadu_si256(old_words.as_ptr().cast()), near)
        };
        let near = near & (255 >> 8_usize.saturating_sub(len - from));
        let (Some(new), Some(new_words)) = (entries[kept..].first_chunk_mut(), words[kept..].first_chunk_mut()) else {
            break;
        };
        let (new, new_words): (&mut [f32; 8], &mut [u32; 8]) = (new, new_words);
        // SAFETY: as above, of stores.
        unsafe {
            let compress = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(COMPRESS[near as usize & 255] as i64));
            _mm256_storeu_ps(new.as_mut_ptr(), _mm256_permutevar8x32_ps(old, compress));
            _mm256_storeu_si256(new_words.as_mut_ptr().cast(), _mm256_permutevar8x32_epi32(old_words, compress));
        }
        kept += near.count_ones() as usize;
        from += 8;
    }
    kept
}

/// # Safety
/// The processor has the features of [`Avx512`].
#[inline(always)]
unsafe fn cull_avx512(entries: &mut [f32], words: &mut [u32], len: usize, t: f32) -> usize {
    let (mut kept, mut from) = (0, 0);
    while from < len {
        let (Some(old), Some(old_words)) = (entries[from..].first_chunk(), words[from..].first_chunk()) else { break };
        let (old, old_words): (&[f32; 16], &[u32; 16]) = (old, old_words);
        let among = 0xffff_u16 >> 16_usize.saturating_sub(len - from);
        // SAFETY: the caller says so; arrays hold sixteen elements, and the loads need no alignment.
        let (old, old_words, near) = unsafe {
            let old = _mm512_loadu_ps(old.as_ptr());
            let near = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(among, old, _mm512_set1_ps(t));
            (old, _mm512_loadu_si512(old_words.as_ptr().cast()), near)
        };
        let (Some(new), Some(new_words)) = (entries[kept..].first_chunk_mut(), words[kept..].first_chunk_mut()) else {
            break;
        };
        let (new, new_words): (&mut [f32; 16], &mut [u32; 16]) = (new, new_words);
        // SAFETY: as above, of stores.
        unsafe {
            _mm512_storeu_ps(new.as_mut_ptr(), _mm512_maskz_compress_ps(near, old));
            _mm512_storeu_si512(new_words.as_mut_ptr().cast(), _mm512_maskz_compress_epi32(near, old_words));
        }
        kept += near.count_ones() as usize;
        from += 16;
    }
    kept
}

/// # Safety
/// The processor has AVX2.
#[inline(always)]
unsafe fn candidates_avx2(pack: &Pack, ray: &LocalRay) -> u32 {
    // SAFETY: the caller says so; there are three axes, arrays hold four floats, and the loads need no alignment.
    unsafe {
        let axes = ray.axes.map(|axis| axis as usize);
        let [ox, oy, oz] = axes.map(|axis| _mm_broadcast_ss(ray.origin.get_unchecked(axis)));
        let (sx, sy) = (_mm_set1_ps(ray.shear[0]), _mm_set1_ps(ray.shear[1]));
        let sheared = |corner: &[[f32; 4]; 3]| {
            let [x, y, z] = axes.map(|axis| _mm_loadu_ps(corner.get_unchecked(axis).as_ptr()));
            let z = _mm_sub_ps(z, oz);
            let x = _mm_sub_ps(_mm_sub_ps(x, ox), _mm_mul_ps(sx, z));
            let y = _mm_sub_ps(_mm_sub_ps(y, oy), _mm_mul_ps(sy, z));
            (x, y)
        };
        let [a, b, c] = &pack.corners;
        let ((ax, ay), (bx, by), (cx, cy)) = (sheared(a), sheared(b), sheared(c));
        let u = _mm_sub_ps(_mm_mul_ps(cx, by), _mm_mul_ps(cy, bx));
        let v = _mm_sub_ps(_mm_mul_ps(ax, cy), _mm_mul_ps(ay, cx));
        let w = _mm_sub_ps(_mm_mul_ps(bx, ay), _mm_mul_ps(by, ax));
        let zero = _mm_setzero_ps();
        let none_positive = _mm_cmple_ps(_mm_max_ps(_mm_max_ps(u, v), w), zero);
        let none_negative = _mm_cmpge_ps(_mm_min_ps(_mm_min_ps(u, v), w), zero);
        _mm_movemask_ps(_mm_or_ps(none_positive, none_negative)) as u32
    }
}

/// For each set of lanes, their numbers in order, one a byte.
pub(super) static COMPRESS: [u64; 256] = {
    let mut table = [0; 256];
    let mut set = 0;
    while set < 256 {
        let (mut lane, mut used) = (0, 0);
        while lane < 8 {
            if set >> lane & 1 == 1 {
                table[set] |= (lane as u64) << (8 * used);
                used += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    table
};
