//! Rays in the lanes of vectors, against one facet after the other.

use std::arch::x86_64::*;

use super::x86::COMPRESS;
use crate::flat::{Facet, Facets, Group, LANES, Pairs};

#[inline]
#[target_feature(enable = "avx512f,popcnt")]
pub(super) fn scan_avx512<const ANY: bool>(facets: &Facets, rays: &Group, pairs: &mut Pairs) -> u32 {
    let mut scan = Scan16::new(rays);
    for facet in &facets.quadrilaterals {
        scan.meet::<ANY, 4>(facet, rays, pairs);
    }
    for facet in &facets.triangles {
        scan.meet::<ANY, 3>(facet, rays, pairs);
    }
    u32::from(scan.certain)
}

/// Sixteen rays; the formulas are those of the plain code in [`crate::flat`].
struct Scan16 {
    origin: [__m512; 3],
    direction: [__m512; 3],
    reach: __m512,
    length: __m512,
    t_min: __m512,
    t_max: __m512,
    mask: __m512i,
    skip: __m512i,
    bound: __m512,
    certain: u16,
}

impl Scan16 {
    #[inline]
    #[target_feature(enable = "avx512f,popcnt")]
    fn new(rays: &Group) -> Self {
        let [ox, oy, oz] = &rays.origin;
        let [dx, dy, dz] = &rays.direction;
        let t_max = load16(&rays.t_max);
        Self {
            origin: [load16(ox), load16(oy), load16(oz)],
            direction: [load16(dx), load16(dy), load16(dz)],
            reach: load16(&rays.reach),
            length: load16(&rays.length),
            t_min: load16(&rays.t_min),
            t_max,
            mask: load16_words(&rays.mask),
            skip: load16_words(&rays.skip),
            bound: t_max,
            certain: 0,
        }
    }

    #[inline]
    #[target_feature(enable = "avx512f,popcnt")]
    fn meet<const ANY: bool, const EDGES: usize>(&mut self, facet: &Facet<EDGES>, rays: &Group, pairs: &mut Pairs) {
        let zero = _mm512_setzero_ps();
        let [ox, oy, oz] = self.origin;
        let [dx, dy, dz] = self.direction;
        // Not by `map`, into which closures of other instruction sets are not inlined.
        let [nx, ny, nz] = facet.normal;
        let (nx, ny, nz) = (_mm512_set1_ps(nx), _mm512_set1_ps(ny), _mm512_set1_ps(nz));
        let speed = _mm512_fmadd_ps(nx, dx, _mm512_fmadd_ps(ny, dy, _mm512_mul_ps(nz, dz)));
        let above = _mm512_fnmadd_ps(nz, oz, _mm512_set1_ps(facet.height));
        let above = _mm512_fnmadd_ps(nx, ox, _mm512_fnmadd_ps(ny, oy, above));
        // One step of Newton's method; where that is not a number nothing is excluded.
        let rate = _mm512_rcp14_ps(speed);
        let rate = _mm512_fmadd_ps(rate, _mm512_fnmadd_ps(speed, rate, _mm512_set1_ps(1.0)), rate);
        let t = _mm512_mul_ps(above, rate);
        let doubt = _mm512_mul_ps(_mm512_abs_ps(rate), _mm512_add_ps(self.reach, _mm512_set1_ps(facet.slack)));
        let margin = _mm512_mul_ps(doubt, self.length);
        let [u, v] = facet.axes();
        let on_u = _mm512_fmadd_ps(t, load16(&rays.direction[u]), load16(&rays.origin[u]));
        let on_v = _mm512_fmadd_ps(t, load16(&rays.direction[v]), load16(&rays.origin[v]));
        let distance = |line: &[f32; 3]| {
            let rest = _mm512_fmadd_ps(_mm512_set1_ps(line[1]), on_v, _mm512_set1_ps(line[2]));
            _mm512_fmadd_ps(_mm512_set1_ps(line[0]), on_u, rest)
        };
        let mut inside = distance(&facet.edges[0]);
        for edge in &facet.edges[1..] {
            inside = _mm512_min_ps(distance(edge), inside);
        }
        let (low, high) = (_mm512_sub_ps(t, doubt), _mm512_add_ps(t, doubt));
        let may = _mm512_test_epi32_mask(self.mask, _mm512_set1_epi32(facet.mask as i32));
        let may = _mm512_mask_cmp_ps_mask::<_CMP_NLT_UQ>(may, _mm512_add_ps(inside, margin), zero);
        let may = _mm512_mask_cmp_ps_mask::<_CMP_NLE_UQ>(may, high, self.t_min);
        let may = _mm512_mask_cmp_ps_mask::<_CMP_NGT_UQ>(may, low, self.bound);
        let first = _mm512_mask_cmpneq_epi32_mask(may, self.skip, _mm512_set1_epi32(facet.orders[0] as i32));
        let second = if EDGES > 3 {
            _mm512_mask_cmpneq_epi32_mask(may, self.skip, _mm512_set1_epi32(facet.orders[1] as i32))
        } else {
            first
        };
        let sure = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(first & second, inside, margin);
        let sure = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(sure, low, self.t_min);
        let sure = _mm512_mask_cmp_ps_mask::<_CMP_LT_OQ>(sure, high, self.t_max);
        if ANY {
            self.certain |= sure;
        } else {
            self.bound = _mm512_mask_min_ps(self.bound, sure, self.bound, high);
        }
        let left = if ANY { !self.certain } else { !0 };
        if EDGES > 3 {
            let side = distance(&facet.diagonal);
            let first = _mm512_mask_cmp_ps_mask::<_CMP_NLT_UQ>(first & left, _mm512_add_ps(side, margin), zero);
            let second = _mm512_mask_cmp_ps_mask::<_CMP_NGT_UQ>(second & left, side, margin);
            list16(pairs, facet.places[0], first);
            list16(pairs, facet.places[1], second);
        } else {
            list16(pairs, facet.places[0], first & left);
        }
    }
}

/// Adds a triangle with each lane that has its bit.
#[inline]
#[target_feature(enable = "avx512f,popcnt")]
fn list16(pairs: &mut Pairs, triangle: u32, lanes: u16) {
    let numbers = _mm512_setr_epi32(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
    let numbers = _mm512_add_epi32(numbers, _mm512_set1_epi32((triangle * LANES as u32) as i32));
    pairs.push(words16(_mm512_maskz_compress_epi32(lanes, numbers)), lanes.count_ones());
}

#[inline]
#[target_feature(enable = "avx2,fma,popcnt")]
pub(super) fn scan_avx2<const ANY: bool>(facets: &Facets, rays: &Group, pairs: &mut Pairs) -> u32 {
    let low = half_scan_avx2::<ANY, 0>(facets, rays, pairs);
    let high = half_scan_avx2::<ANY, 1>(facets, rays, pairs);
    low | high << (LANES / 2)
}

/// Eight of the rays.
#[inline]
#[target_feature(enable = "avx2,fma,popcnt")]
fn half_scan_avx2<const ANY: bool, const HALF: usize>(facets: &Facets, rays: &Group, pairs: &mut Pairs) -> u32 {
    let mut scan = Scan8 { bound: load_half::<HALF>(&rays.t_max), certain: 0 };
    for facet in &facets.quadrilaterals {
        scan.meet::<ANY, HALF, 4>(facet, rays, pairs);
    }
    for facet in &facets.triangles {
        scan.meet::<ANY, HALF, 3>(facet, rays, pairs);
    }
    scan.certain
}

/// What is known of eight rays.
struct Scan8 {
    bound: __m256,
    certain: u32,
}

impl Scan8 {
    #[inline]
    #[target_feature(enable = "avx2,fma,popcnt")]
    fn meet<const ANY: bool, const HALF: usize, const EDGES: usize>(
        &mut self,
        facet: &Facet<EDGES>,
        rays: &Group,
        pairs: &mut Pairs,
    ) {
        let (zero, zero_words) = (_mm256_setzero_ps(), _mm256_setzero_si256());
        let [ox, oy, oz] = &rays.origin;
        let [dx, dy, dz] = &rays.direction;
        // Not by `map`, into which closures of other instruction sets are not inlined.
        let [nx, ny, nz] = facet.normal;
        let (nx, ny, nz) = (_mm256_set1_ps(nx), _mm256_set1_ps(ny), _mm256_set1_ps(nz));
        let speed = _mm256_mul_ps(nz, load_half::<HALF>(dz));
        let speed = _mm256_fmadd_ps(nx, load_half::<HALF>(dx), _mm256_fmadd_ps(ny, load_half::<HALF>(dy), speed));
        let above = _mm256_fnmadd_ps(nz, load_half::<HALF>(oz), _mm256_set1_ps(facet.height));
        let above = _mm256_fnmadd_ps(nx, load_half::<HALF>(ox), _mm256_fnmadd_ps(ny, load_half::<HALF>(oy), above));
        let rate = _mm256_div_ps(_mm256_set1_ps(1.0), speed);
        let t = _mm256_mul_ps(above, rate);
        let around = _mm256_add_ps(load_half::<HALF>(&rays.reach), _mm256_set1_ps(facet.slack));
        let doubt = _mm256_mul_ps(_mm256_andnot_ps(_mm256_set1_ps(-0.0), rate), around);
        let margin = _mm256_mul_ps(doubt, load_half::<HALF>(&rays.length));
        let [u, v] = facet.axes();
        let on = |axis: usize| {
            _mm256_fmadd_ps(t, load_half::<HALF>(&rays.direction[axis]), load_half::<HALF>(&rays.origin[axis]))
        };
        let (on_u, on_v) = (on(u), on(v));
        let distance = |line: &[f32; 3]| {
            let rest = _mm256_fmadd_ps(_mm256_set1_ps(line[1]), on_v, _mm256_set1_ps(line[2]));
            _mm256_fmadd_ps(_mm256_set1_ps(line[0]), on_u, rest)
        };
        let mut inside = distance(&facet.edges[0]);
        for edge in &facet.edges[1..] {
            inside = _mm256_min_ps(distance(edge), inside);
        }
        let (low, high) = (_mm256_sub_ps(t, doubt), _mm256_add_ps(t, doubt));
        let (t_min, t_max) = (load_half::<HALF>(&rays.t_min), load_half::<HALF>(&rays.t_max));
        let (mask, skip) = (load_half_words::<HALF>(&rays.mask), load_half_words::<HALF>(&rays.skip));
        let unseen = _mm256_and_si256(mask, _mm256_set1_epi32(facet.mask as i32));
        let unseen = _mm256_castsi256_ps(_mm256_cmpeq_epi32(unseen, zero_words));
        let within =
            _mm256_and_ps(_mm256_cmp_ps::<_CMP_NLE_UQ>(high, t_min), _mm256_cmp_ps::<_CMP_NGT_UQ>(low, self.bound));
        let within = _mm256_and_ps(within, _mm256_cmp_ps::<_CMP_NLT_UQ>(_mm256_add_ps(inside, margin), zero));
        let may = _mm256_andnot_ps(unseen, within);
        let skipped = |order: u32| _mm256_castsi256_ps(_mm256_cmpeq_epi32(skip, _mm256_set1_epi32(order as i32)));
        let first = _mm256_andnot_ps(skipped(facet.orders[0]), may);
        let second = if EDGES > 3 { _mm256_andnot_ps(skipped(facet.orders[1]), may) } else { first };
        let certain = _mm256_and_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(low, t_min), _mm256_cmp_ps::<_CMP_LT_OQ>(high, t_max));
        let certain = _mm256_and_ps(certain, _mm256_cmp_ps::<_CMP_GT_OQ>(inside, margin));
        let sure = _mm256_and_ps(certain, _mm256_and_ps(first, second));
        if ANY {
            self.certain |= _mm256_movemask_ps(sure) as u32;
        } else {
            self.bound = _mm256_blendv_ps(self.bound, _mm256_min_ps(self.bound, high), sure);
        }
        let left = if ANY { !self.certain } else { !0 };
        if EDGES > 3 {
            let side = distance(&facet.diagonal);
            let first = _mm256_and_ps(first, _mm256_cmp_ps::<_CMP_NLT_UQ>(_mm256_add_ps(side, margin), zero));
            let second = _mm256_and_ps(second, _mm256_cmp_ps::<_CMP_NGT_UQ>(side, margin));
            list8::<HALF>(pairs, facet.places[0], _mm256_movemask_ps(first) as u32 & left);
            list8::<HALF>(pairs, facet.places[1], _mm256_movemask_ps(second) as u32 & left);
        } else {
            list8::<HALF>(pairs, facet.places[0], _mm256_movemask_ps(first) as u32 & left);
        }
    }
}

/// Adds a triangle with each lane of a half that has its bit.
#[inline]
#[target_feature(enable = "avx2,popcnt")]
fn list8<const HALF: usize>(pairs: &mut Pairs, triangle: u32, lanes: u32) {
    let numbers = _mm256_cvtepu8_epi32(_mm_cvtsi64_si128(COMPRESS[lanes as usize & 255] as i64));
    let start = triangle as usize * LANES + HALF * (LANES / 2);
    pairs.push(words8(_mm256_add_epi32(numbers, _mm256_set1_epi32(start as i32))), lanes.count_ones());
}

#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn load16(from: &[f32; LANES]) -> __m512 {
    // SAFETY: the array holds sixteen floats; the load needs no alignment.
    unsafe { _mm512_loadu_ps(from.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn load16_words(from: &[u32; LANES]) -> __m512i {
    // SAFETY: the array holds sixteen words; the load needs no alignment.
    unsafe { _mm512_loadu_si512(from.as_ptr().cast()) }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn words16(vector: __m512i) -> [u32; LANES] {
    // SAFETY: both are sixteen words.
    unsafe { std::mem::transmute::<__m512i, [u32; LANES]>(vector) }
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
fn words8(vector: __m256i) -> [u32; LANES / 2] {
    // SAFETY: both are eight words.
    unsafe { std::mem::transmute::<__m256i, [u32; LANES / 2]>(vector) }
}
