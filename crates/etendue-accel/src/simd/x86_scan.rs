//! Rays in the lanes of vectors, against one triangle after the other.

use std::arch::x86_64::*;

use super::x86::COMPRESS;
use crate::flat::{FlatTriangle, Group, LANES, Pairs};

/// x and y of a corner, and its ray parameter.
type Sheared<V> = (V, V, V);

#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn scan_avx512<const AXIS: usize, const ANY: bool>(
    triangles: &[FlatTriangle],
    rays: &Group,
    pairs: &mut Pairs,
) -> u32 {
    let (ox, oy, oz) = (load16(&rays.origin[0]), load16(&rays.origin[1]), load16(&rays.origin[2]));
    let (sx, sy, sz) = (load16(&rays.shear[0]), load16(&rays.shear[1]), load16(&rays.shear[2]));
    let (t_min, t_max) = (load16(&rays.t_min), load16(&rays.t_max));
    let (mask, skip) = (load16_words(&rays.mask), load16_words(&rays.skip));
    let zero = _mm512_setzero_ps();
    let mut numbers = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    let mut bound = t_max;
    let mut certain = 0;
    for triangle in triangles {
        let mut corners = [(zero, zero, zero); 3];
        for (corner, sheared) in triangle.corners.iter().zip(&mut corners) {
            let px = _mm512_set1_ps(corner[(AXIS + 1) % 3]);
            let py = _mm512_set1_ps(corner[(AXIS + 2) % 3]);
            let z = _mm512_sub_ps(_mm512_set1_ps(corner[AXIS]), oz);
            let x = _mm512_sub_ps(_mm512_sub_ps(px, ox), _mm512_mul_ps(sx, z));
            let y = _mm512_sub_ps(_mm512_sub_ps(py, oy), _mm512_mul_ps(sy, z));
            *sheared = (x, y, _mm512_mul_ps(sz, z));
        }
        let [a, b, c] = corners;
        let cross =
            |p: Sheared<__m512>, q: Sheared<__m512>| _mm512_sub_ps(_mm512_mul_ps(p.0, q.1), _mm512_mul_ps(p.1, q.0));
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        let (first, last) = (_mm512_min_ps(_mm512_min_ps(u, v), w), _mm512_max_ps(_mm512_max_ps(u, v), w));
        let low = _mm512_min_ps(_mm512_min_ps(a.2, b.2), c.2);
        let high = _mm512_max_ps(_mm512_max_ps(a.2, b.2), c.2);
        let seen = _mm512_test_epi32_mask(mask, _mm512_set1_epi32(triangle.mask as i32));
        let seen = _mm512_mask_cmpneq_epi32_mask(seen, skip, _mm512_set1_epi32(triangle.order as i32));
        let seen = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(seen, high, t_min);
        let seen = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(seen, low, bound);
        // A difference of rounded products that is not 0 has the right sign, and so has the product of two of them.
        let sides = _mm512_mul_ps(first, last);
        let mut listed = _mm512_mask_cmp_ps_mask::<_CMP_GE_OQ>(seen, sides, zero);
        let sure = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(seen, sides, zero);
        let sure = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(sure, low, t_min);
        let sure = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(sure, high, t_max);
        if ANY {
            certain |= sure;
            listed &= !certain;
        } else {
            bound = _mm512_mask_min_ps(bound, sure, bound, high);
        }
        store16(pairs.place(), _mm512_maskz_compress_epi32(listed, numbers));
        pairs.advance(listed.count_ones());
        numbers = _mm512_add_epi32(numbers, _mm512_set1_epi32(LANES as i32));
    }
    u32::from(certain)
}

#[inline]
#[target_feature(enable = "avx2,popcnt")]
pub(super) fn scan_avx2<const AXIS: usize, const ANY: bool>(
    triangles: &[FlatTriangle],
    rays: &Group,
    pairs: &mut Pairs,
) -> u32 {
    let low = half_scan_avx2::<AXIS, ANY, 0>(triangles, rays, pairs);
    let high = half_scan_avx2::<AXIS, ANY, 1>(triangles, rays, pairs);
    low | high << (LANES / 2)
}

/// Eight of the rays.
#[inline]
#[target_feature(enable = "avx2,popcnt")]
fn half_scan_avx2<const AXIS: usize, const ANY: bool, const HALF: usize>(
    triangles: &[FlatTriangle],
    rays: &Group,
    pairs: &mut Pairs,
) -> u32 {
    let [ox, oy, oz] = &rays.origin;
    let [sx, sy, sz] = &rays.shear;
    let (ox, oy, oz) = (load_half::<HALF>(ox), load_half::<HALF>(oy), load_half::<HALF>(oz));
    let (sx, sy, sz) = (load_half::<HALF>(sx), load_half::<HALF>(sy), load_half::<HALF>(sz));
    let (t_min, t_max) = (load_half::<HALF>(&rays.t_min), load_half::<HALF>(&rays.t_max));
    let (mask, skip) = (load_half_words::<HALF>(&rays.mask), load_half_words::<HALF>(&rays.skip));
    let (zero, zero_words) = (_mm256_setzero_ps(), _mm256_setzero_si256());
    let mut bound = t_max;
    let mut certain = 0_u32;
    for (index, triangle) in triangles.iter().enumerate() {
        let mut corners = [(zero, zero, zero); 3];
        for (corner, sheared) in triangle.corners.iter().zip(&mut corners) {
            let px = _mm256_set1_ps(corner[(AXIS + 1) % 3]);
            let py = _mm256_set1_ps(corner[(AXIS + 2) % 3]);
            let z = _mm256_sub_ps(_mm256_set1_ps(corner[AXIS]), oz);
            let x = _mm256_sub_ps(_mm256_sub_ps(px, ox), _mm256_mul_ps(sx, z));
            let y = _mm256_sub_ps(_mm256_sub_ps(py, oy), _mm256_mul_ps(sy, z));
            *sheared = (x, y, _mm256_mul_ps(sz, z));
        }
        let [a, b, c] = corners;
        let cross =
            |p: Sheared<__m256>, q: Sheared<__m256>| _mm256_sub_ps(_mm256_mul_ps(p.0, q.1), _mm256_mul_ps(p.1, q.0));
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        let (first, last) = (_mm256_min_ps(_mm256_min_ps(u, v), w), _mm256_max_ps(_mm256_max_ps(u, v), w));
        let low = _mm256_min_ps(_mm256_min_ps(a.2, b.2), c.2);
        let high = _mm256_max_ps(_mm256_max_ps(a.2, b.2), c.2);
        let hidden = _mm256_or_si256(
            _mm256_cmpeq_epi32(_mm256_and_si256(mask, _mm256_set1_epi32(triangle.mask as i32)), zero_words),
            _mm256_cmpeq_epi32(skip, _mm256_set1_epi32(triangle.order as i32)),
        );
        // A difference of rounded products that is not 0 has the right sign, and so has the product of two of them.
        let sides = _mm256_mul_ps(first, last);
        let one_side = _mm256_cmp_ps::<_CMP_GE_OQ>(sides, zero);
        let within = _mm256_and_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(high, t_min), _mm256_cmp_ps::<_CMP_LE_OQ>(low, bound));
        let may = _mm256_andnot_ps(_mm256_castsi256_ps(hidden), _mm256_and_ps(one_side, within));
        let off_edges = _mm256_cmp_ps::<_CMP_GT_OQ>(sides, zero);
        let inside = _mm256_and_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(low, t_min), _mm256_cmp_ps::<_CMP_LT_OQ>(high, t_max));
        let sure = _mm256_and_ps(may, _mm256_and_ps(off_edges, inside));
        let mut listed = _mm256_movemask_ps(may) as u32;
        if ANY {
            certain |= _mm256_movemask_ps(sure) as u32;
            listed &= !certain;
        } else {
            bound = _mm256_blendv_ps(bound, _mm256_min_ps(bound, high), sure);
        }
        let lanes = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(COMPRESS[listed as usize & 255] as i64));
        let start = index * LANES + HALF * (LANES / 2);
        store8(pairs.place(), _mm256_add_epi32(lanes, _mm256_set1_epi32(start as i32)));
        pairs.advance(listed.count_ones());
    }
    certain
}

#[inline]
#[target_feature(enable = "avx512f")]
fn load16(from: &[f32; LANES]) -> __m512 {
    // SAFETY: the array holds sixteen floats; the load needs no alignment.
    unsafe { _mm512_loadu_ps(from.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn load16_words(from: &[u32; LANES]) -> __m512i {
    // SAFETY: the array holds sixteen words; the load needs no alignment.
    unsafe { _mm512_loadu_si512(from.as_ptr().cast()) }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn store16(to: &mut [u32; LANES], value: __m512i) {
    // SAFETY: the array holds sixteen words; the store needs no alignment.
    unsafe { _mm512_storeu_si512(to.as_mut_ptr().cast(), value) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load_half<const HALF: usize>(from: &[f32; LANES]) -> __m256 {
    const { assert!(HALF < 2) };
    // SAFETY: the half lies inside the array, which holds twice eight floats; the load needs no alignment.
    unsafe { _mm256_loadu_ps(from.as_ptr().add(HALF * (LANES / 2))) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load_half_words<const HALF: usize>(from: &[u32; LANES]) -> __m256i {
    const { assert!(HALF < 2) };
    // SAFETY: the half lies inside the array, which holds twice eight words; the load needs no alignment.
    unsafe { _mm256_loadu_si256(from.as_ptr().add(HALF * (LANES / 2)).cast()) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn store8(to: &mut [u32; LANES], value: __m256i) {
    // SAFETY: the array holds more than eight words; the store needs no alignment.
    unsafe { _mm256_storeu_si256(to.as_mut_ptr().cast(), value) }
}
