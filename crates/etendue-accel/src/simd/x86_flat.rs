//! Sixteen rays from records to vectors, and the corners of triangles for them.

use std::arch::x86_64::*;

use super::x86_scan::{load16, load16_words};
use crate::flat::{Columns, FlatTriangle, Group, LANES, Sheared};
use crate::ray::Ray;

/// Words of a ray, and of a triangle.
const RAY_WORDS: usize = 12;
const TRIANGLE_WORDS: usize = 11;
const _: () = assert!(size_of::<Ray>() == 4 * RAY_WORDS && size_of::<FlatTriangle>() == 4 * TRIANGLE_WORDS);
const _: () = assert!(size_of::<Columns>() == 4 * RAY_WORDS * LANES);

/// Four words of each ray at a time: those of four rays in a vector, turned by two rounds of interleaving.
#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn transpose(rays: &[Ray; LANES], columns: &mut Columns) {
    let from = std::ptr::from_ref(rays).cast::<f32>();
    let to = std::ptr::from_mut(columns).cast::<f32>();
    for word in (0..RAY_WORDS).step_by(4) {
        // Rays 0, 4, 8, 12, then 1, 5, 9, 13, and so on.
        let mut rows = [_mm512_setzero_ps(); 4];
        for (first, row) in rows.iter_mut().enumerate() {
            // SAFETY: four words of a ray, of sixteen rays of so many words each.
            let quarter = |ray: usize| unsafe { _mm_loadu_ps(from.add((first + ray) * RAY_WORDS + word)) };
            let low = _mm512_insertf32x4::<1>(_mm512_castps128_ps512(quarter(0)), quarter(4));
            *row = _mm512_insertf32x4::<3>(_mm512_insertf32x4::<2>(low, quarter(8)), quarter(12));
        }
        let [a, b, c, d] = rows;
        let (ab, cd) = (_mm512_unpacklo_ps(a, b), _mm512_unpacklo_ps(c, d));
        let (ab_high, cd_high) = (_mm512_unpackhi_ps(a, b), _mm512_unpackhi_ps(c, d));
        let columns = [
            _mm512_shuffle_ps::<0b01_00_01_00>(ab, cd),
            _mm512_shuffle_ps::<0b11_10_11_10>(ab, cd),
            _mm512_shuffle_ps::<0b01_00_01_00>(ab_high, cd_high),
            _mm512_shuffle_ps::<0b11_10_11_10>(ab_high, cd_high),
        ];
        for (i, column) in columns.into_iter().enumerate() {
            // SAFETY: sixteen words of a column, of as many columns as words.
            unsafe { _mm512_storeu_ps(to.add((word + i) * LANES), column) };
        }
    }
}

/// The operations of [`crate::triangle::shear`], nothing fused.
#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn shear(triangles: &[FlatTriangle], rays: &Group, pairs: &[u32; LANES], sheared: &mut Sheared) {
    let Some(last) = triangles.len().checked_sub(1) else { return };
    let pairs = load16_words(pairs);
    let triangle = _mm512_min_epu32(_mm512_srli_epi32::<4>(pairs), _mm512_set1_epi32(last as i32));
    let start = _mm512_mullo_epi32(triangle, _mm512_set1_epi32(TRIANGLE_WORDS as i32));
    // Lanes are told by the lowest four bits.
    let of_ray = |row: &[f32; LANES]| _mm512_permutexvar_ps(pairs, load16(row));
    // Not by `map`, into which closures of other instruction sets are not inlined.
    let (ox, oy, oz) = (of_ray(&rays.turned[0]), of_ray(&rays.turned[1]), of_ray(&rays.turned[2]));
    let (sx, sy, sz) = (of_ray(&rays.shear[0]), of_ray(&rays.shear[1]), of_ray(&rays.shear[2]));
    let (two, three) = (_mm512_set1_epi32(2), _mm512_set1_epi32(3));
    let z_axis = _mm512_min_epu32(_mm512_permutexvar_epi32(pairs, load16_words(&rays.major)), two);
    let next = |axis: __m512i| {
        let next = _mm512_add_epi32(axis, _mm512_set1_epi32(1));
        _mm512_mask_sub_epi32(next, _mm512_cmpeq_epi32_mask(next, three), next, three)
    };
    let x_axis = next(z_axis);
    let axes =
        [_mm512_add_epi32(start, x_axis), _mm512_add_epi32(start, next(x_axis)), _mm512_add_epi32(start, z_axis)];
    let from = triangles.as_ptr().cast::<f32>();
    for (corner, [x, y, depth]) in sheared.iter_mut().enumerate() {
        let place = _mm512_set1_epi32(3 * corner as i32);
        // SAFETY: corners are the first nine words of a triangle, by corner and axis, which is at most 2; triangles are
        // among those there are. Words of so few triangles are far below the range of the indices.
        let take = |axis: __m512i| unsafe { _mm512_i32gather_ps::<4>(_mm512_add_epi32(axis, place), from) };
        let z = _mm512_sub_ps(take(axes[2]), oz);
        store(x, _mm512_sub_ps(_mm512_sub_ps(take(axes[0]), ox), _mm512_mul_ps(sx, z)));
        store(y, _mm512_sub_ps(_mm512_sub_ps(take(axes[1]), oy), _mm512_mul_ps(sy, z)));
        store(depth, _mm512_mul_ps(sz, z));
    }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn store(to: &mut [f32; LANES], value: __m512) {
    // SAFETY: the array holds sixteen floats; the store needs no alignment.
    unsafe { _mm512_storeu_ps(to.as_mut_ptr(), value) }
}
