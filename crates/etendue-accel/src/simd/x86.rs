//! AVX2 with FMA, and AVX-512 on 256-bit vectors.
//!
//! Fused multiply-subtract appears in box tests only, where the proof of `padding.rs` allows either rounding.

use std::arch::x86_64::*;

use super::x86_scan::{scan_avx2, scan_avx512};
use super::{Simd, Stack};
use crate::bvh::node::{Node, Pack, WIDTH, near_rows};
use crate::flat::{FlatTriangle, Group, Pairs};
use crate::isa::SimdKernel;
use crate::local_ray::LocalRay;
use crate::padding::SlabRay;

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

impl Simd for Avx2 {
    #[inline(always)]
    fn push_children(self, node: &Node, ray: &SlabRay, range: (f32, f32), stack: &mut Stack<'_>) {
        // SAFETY: a value of type Avx2 exists only in code that `run_avx2` runs, so the processor has the features.
        unsafe { push_children_avx2(node, ray, range, stack) }
    }

    #[inline(always)]
    fn candidates(self, pack: &Pack, ray: &LocalRay) -> u32 {
        // SAFETY: as above.
        unsafe { candidates_avx2(pack, ray) }
    }

    #[inline(always)]
    fn scan<const AXIS: usize, const ANY: bool>(
        self,
        triangles: &[FlatTriangle],
        rays: &Group,
        pairs: &mut Pairs,
    ) -> u32 {
        // SAFETY: as above.
        unsafe { scan_avx2::<AXIS, ANY>(triangles, rays, pairs) }
    }

    #[inline(always)]
    fn prefetch<T>(self, what: &T) {
        prefetch(what);
    }
}

impl Simd for Avx512 {
    #[inline(always)]
    fn push_children(self, node: &Node, ray: &SlabRay, range: (f32, f32), stack: &mut Stack<'_>) {
        // SAFETY: a value of type Avx512 exists only in code that `run_avx512` runs, so the processor has the features.
        unsafe { push_children_avx512(node, ray, range, stack) }
    }

    #[inline(always)]
    fn candidates(self, pack: &Pack, ray: &LocalRay) -> u32 {
        // SAFETY: as above; the features of AVX2 are among those of Avx512.
        unsafe { candidates_avx2(pack, ray) }
    }

    #[inline(always)]
    fn scan<const AXIS: usize, const ANY: bool>(
        self,
        triangles: &[FlatTriangle],
        rays: &Group,
        pairs: &mut Pairs,
    ) -> u32 {
        // SAFETY: as above.
        unsafe { scan_avx512::<AXIS, ANY>(triangles, rays, pairs) }
    }

    #[inline(always)]
    fn prefetch<T>(self, what: &T) {
        prefetch(what);
    }
}

/// Asks for all cache lines of a value.
#[inline(always)]
pub(super) fn prefetch<T>(what: &T) {
    let start = std::ptr::from_ref(what).cast::<i8>();
    for line in 0..size_of::<T>().div_ceil(64) {
        // SAFETY: prefetching reads nothing that the program can see, at any address; SSE is part of x86-64.
        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.wrapping_add(64 * line)) }
    }
}

/// Entry and exit distances of the eight boxes.
#[inline]
#[target_feature(enable = "avx2,fma")]
fn intervals(node: &Node, ray: &SlabRay, (t_min, t_max): (f32, f32)) -> (__m256, __m256) {
    let (mut enter, mut exit) = (_mm256_set1_ps(t_min), _mm256_set1_ps(t_max));
    for (axis, near) in near_rows(ray).into_iter().enumerate() {
        let rate = _mm256_set1_ps(ray.rate[axis]);
        let first = _mm256_fmsub_ps(load8(&node.rows[near]), rate, _mm256_set1_ps(ray.near[axis]));
        let last = _mm256_fmsub_ps(load8(&node.rows[near ^ 1]), rate, _mm256_set1_ps(ray.far[axis]));
        enter = _mm256_max_ps(first, enter);
        exit = _mm256_min_ps(last, exit);
    }
    (enter, exit)
}

/// The indices of the children from far to near.
#[inline]
#[target_feature(enable = "avx2")]
fn order_of(node: &Node, ray: &SlabRay) -> __m256i {
    // Only the lowest three bits of an index count.
    let word = _mm256_set1_epi32(node.order[ray.octant] as i32);
    _mm256_srlv_epi32(word, _mm256_setr_epi32(0, 3, 6, 9, 12, 15, 18, 21))
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt")]
fn push_children_avx2(node: &Node, ray: &SlabRay, range: (f32, f32), stack: &mut Stack<'_>) {
    let (enter, exit) = intervals(node, ray, range);
    let order = order_of(node, ray);
    let enter = _mm256_permutevar8x32_ps(enter, order);
    let exit = _mm256_permutevar8x32_ps(exit, order);
    let entered = _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, exit)) as usize;
    let children = _mm256_permutevar8x32_epi32(load8_words(&node.children), order);
    let compress = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(COMPRESS[entered & 255] as i64));
    let (entries, words) = stack.place();
    store8(entries, _mm256_permutevar8x32_ps(enter, compress));
    store8_words(words, _mm256_permutevar8x32_epi32(children, compress));
    stack.len += entered.count_ones() as usize;
}

#[inline]
#[target_feature(enable = "avx2,fma,bmi1,bmi2,lzcnt,popcnt,avx512f,avx512vl,avx512dq,avx512bw,avx512cd")]
fn push_children_avx512(node: &Node, ray: &SlabRay, range: (f32, f32), stack: &mut Stack<'_>) {
    let (enter, exit) = intervals(node, ray, range);
    let order = order_of(node, ray);
    let enter = _mm256_permutexvar_ps(order, enter);
    let exit = _mm256_permutexvar_ps(order, exit);
    let entered = _mm256_cmp_ps_mask::<_CMP_LE_OQ>(enter, exit);
    let children = _mm256_permutexvar_epi32(order, load8_words(&node.children));
    let (entries, words) = stack.place();
    store8(entries, _mm256_maskz_compress_ps(entered, enter));
    store8_words(words, _mm256_maskz_compress_epi32(entered, children));
    stack.len += entered.count_ones() as usize;
}

#[inline]
#[target_feature(enable = "avx2")]
fn candidates_avx2(pack: &Pack, ray: &LocalRay) -> u32 {
    let [kx, ky, kz] = ray.axes;
    let origin = ray.axes.map(|axis| ray.origin[axis]);
    let (ox, oy, oz) = (_mm_set1_ps(origin[0]), _mm_set1_ps(origin[1]), _mm_set1_ps(origin[2]));
    let (sx, sy) = (_mm_set1_ps(ray.shear[0]), _mm_set1_ps(ray.shear[1]));
    let mut sheared = [(ox, oy); 3];
    for (corner, point) in pack.corners.iter().zip(&mut sheared) {
        let z = _mm_sub_ps(load4(&corner[kz]), oz);
        let x = _mm_sub_ps(_mm_sub_ps(load4(&corner[kx]), ox), _mm_mul_ps(sx, z));
        let y = _mm_sub_ps(_mm_sub_ps(load4(&corner[ky]), oy), _mm_mul_ps(sy, z));
        *point = (x, y);
    }
    let [(ax, ay), (bx, by), (cx, cy)] = sheared;
    let u = _mm_sub_ps(_mm_mul_ps(cx, by), _mm_mul_ps(cy, bx));
    let v = _mm_sub_ps(_mm_mul_ps(ax, cy), _mm_mul_ps(ay, cx));
    let w = _mm_sub_ps(_mm_mul_ps(bx, ay), _mm_mul_ps(by, ax));
    let zero = _mm_setzero_ps();
    let none_positive = _mm_cmple_ps(_mm_max_ps(_mm_max_ps(u, v), w), zero);
    let none_negative = _mm_cmpge_ps(_mm_min_ps(_mm_min_ps(u, v), w), zero);
    _mm_movemask_ps(_mm_or_ps(none_positive, none_negative)) as u32
}

#[inline]
#[target_feature(enable = "avx2")]
fn load8(from: &[f32; WIDTH]) -> __m256 {
    // SAFETY: the array holds eight floats; the load needs no alignment.
    unsafe { _mm256_loadu_ps(from.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load8_words(from: &[u32; WIDTH]) -> __m256i {
    // SAFETY: the array holds eight words; the load needs no alignment.
    unsafe { _mm256_loadu_si256(from.as_ptr().cast()) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load4(from: &[f32; 4]) -> __m128 {
    // SAFETY: the array holds four floats; the load needs no alignment.
    unsafe { _mm_loadu_ps(from.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn store8(to: &mut [f32], value: __m256) {
    assert!(to.len() >= WIDTH);
    // SAFETY: the slice holds eight floats; the store needs no alignment.
    unsafe { _mm256_storeu_ps(to.as_mut_ptr(), value) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn store8_words(to: &mut [u32], value: __m256i) {
    assert!(to.len() >= WIDTH);
    // SAFETY: the slice holds eight words; the store needs no alignment.
    unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), value) }
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
