//! AVX2 for beams: sixteen rays in two halves against one box or one triangle after the other.

use std::arch::x86_64::*;

use crate::bvh::beam::{BEAM, Beam, Lanes, Outline};
use crate::bvh::node::{LANES, Node, Pack, WIDTH};

/// Rays of a vector.
const HALF: usize = 8;

/// x and y of a corner, and its ray parameter.
type Sheared = (__m256, __m256, __m256);

/// See [`crate::simd::Simd::beam_outline`].
#[inline]
#[target_feature(enable = "avx2,fma")]
pub(super) fn beam_outline(node: &Node, beam: &Beam) -> u32 {
    let Outline { rate, near, far } = &beam.outline;
    let (mut enter, mut exit) = (_mm256_setzero_ps(), _mm256_set1_ps(f32::INFINITY));
    for axis in 0..3 {
        let (first, last) = (row(node, beam.rows[0][axis]), row(node, beam.rows[1][axis]));
        let (slow, fast) = (_mm256_set1_ps(rate[axis][0]), _mm256_set1_ps(rate[axis][1]));
        let (near, far) = (_mm256_set1_ps(near[axis]), _mm256_set1_ps(far[axis]));
        let first = _mm256_min_ps(_mm256_fmsub_ps(first, slow, near), _mm256_fmsub_ps(first, fast, near));
        let last = _mm256_max_ps(_mm256_fmsub_ps(last, slow, far), _mm256_fmsub_ps(last, fast, far));
        (enter, exit) = (_mm256_max_ps(first, enter), _mm256_min_ps(last, exit));
    }
    _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(enter, exit)) as u32
}

#[inline]
#[target_feature(enable = "avx2,fma,popcnt")]
pub(super) fn beam_children(
    node: &Node,
    beam: &Beam,
    children: &[u8],
    enters: &mut [Lanes; WIDTH],
    words: &mut [u32; WIDTH],
) -> usize {
    let [near, far] = &beam.rows;
    let (near_x, near_y, near_z) = (node.row(near[0]), node.row(near[1]), node.row(near[2]));
    let (far_x, far_y, far_z) = (node.row(far[0]), node.row(far[1]), node.row(far[2]));
    let none = _mm256_set1_ps(f32::NAN);
    let mut used = 0;
    for &child in children {
        let child = usize::from(child) % WIDTH;
        let (x, to_x) = (_mm256_set1_ps(near_x[child]), _mm256_set1_ps(far_x[child]));
        let (y, to_y) = (_mm256_set1_ps(near_y[child]), _mm256_set1_ps(far_y[child]));
        let (z, to_z) = (_mm256_set1_ps(near_z[child]), _mm256_set1_ps(far_z[child]));
        let mut any = 0;
        for half in 0..2 {
            let rate = [load(&beam.rate[0], half), load(&beam.rate[1], half), load(&beam.rate[2], half)];
            let near = [load(&beam.near[0], half), load(&beam.near[1], half), load(&beam.near[2], half)];
            let far = [load(&beam.far[0], half), load(&beam.far[1], half), load(&beam.far[2], half)];
            let first = _mm256_fmsub_ps(x, rate[0], near[0]);
            let second = _mm256_fmsub_ps(y, rate[1], near[1]);
            let third = _mm256_fmsub_ps(z, rate[2], near[2]);
            let t_min = load(&beam.t_min, half);
            let enter = _mm256_max_ps(_mm256_max_ps(first, second), _mm256_max_ps(third, t_min));
            let first = _mm256_fmsub_ps(to_x, rate[0], far[0]);
            let second = _mm256_fmsub_ps(to_y, rate[1], far[1]);
            let third = _mm256_fmsub_ps(to_z, rate[2], far[2]);
            let bound = load(&beam.bound, half);
            let exit = _mm256_min_ps(_mm256_min_ps(first, second), _mm256_min_ps(third, bound));
            let entered = _mm256_cmp_ps::<_CMP_LE_OQ>(enter, exit);
            store(&mut enters[used & 7].0, half, _mm256_blendv_ps(none, enter, entered));
            any |= _mm256_movemask_ps(entered);
        }
        words[used & 7] = node.children[child];
        used += usize::from(any != 0);
    }
    used
}

#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn waiting(enters: &Lanes, bound: &Lanes) -> u32 {
    let half = |half| _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(load(enters, half), load(bound, half))) as u32;
    half(0) | half(1) << HALF
}

#[inline]
#[target_feature(enable = "avx2")]
pub(super) fn beam_triangle(pack: &Pack, place: usize, beam: &Beam, sheared: &mut [[[f32; BEAM]; 3]; 3]) -> u32 {
    let [kx, ky, kz] = beam.axes.map(|axis| axis % 3);
    let place = place % LANES;
    let mut all = 0;
    for half in 0..2 {
        let (ox, oy, oz) = (load(&beam.origin[0], half), load(&beam.origin[1], half), load(&beam.origin[2], half));
        let (sx, sy, sz) = (load(&beam.shear[0], half), load(&beam.shear[1], half), load(&beam.shear[2], half));
        let shear = |corner: &[[f32; LANES]; 3]| {
            let z = _mm256_sub_ps(_mm256_set1_ps(corner[kz][place]), oz);
            let x = _mm256_sub_ps(_mm256_sub_ps(_mm256_set1_ps(corner[kx][place]), ox), _mm256_mul_ps(sx, z));
            let y = _mm256_sub_ps(_mm256_sub_ps(_mm256_set1_ps(corner[ky][place]), oy), _mm256_mul_ps(sy, z));
            (x, y, _mm256_mul_ps(sz, z))
        };
        let (a, b, c) = (shear(&pack.corners[0]), shear(&pack.corners[1]), shear(&pack.corners[2]));
        let cross = |p: Sheared, q: Sheared| _mm256_sub_ps(_mm256_mul_ps(p.0, q.1), _mm256_mul_ps(p.1, q.0));
        let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
        let (first, last) = (_mm256_min_ps(_mm256_min_ps(u, v), w), _mm256_max_ps(_mm256_max_ps(u, v), w));
        // A difference of rounded products that is not 0 has the right sign, and so has the product of two of them.
        let inside = _mm256_cmp_ps::<_CMP_GE_OQ>(_mm256_mul_ps(first, last), _mm256_setzero_ps());
        let low = _mm256_min_ps(_mm256_min_ps(a.2, b.2), c.2);
        let high = _mm256_max_ps(_mm256_max_ps(a.2, b.2), c.2);
        let begins = _mm256_cmp_ps::<_CMP_GT_OQ>(high, load(&beam.t_min, half));
        let ends = _mm256_cmp_ps::<_CMP_LE_OQ>(low, load(&beam.bound, half));
        let found = _mm256_movemask_ps(_mm256_and_ps(inside, _mm256_and_ps(begins, ends))) as u32;
        if found != 0 {
            for (to, from) in sheared.iter_mut().zip([a, b, c]) {
                store(&mut to[0], half, from.0);
                store(&mut to[1], half, from.1);
                store(&mut to[2], half, from.2);
            }
        }
        all |= found << (HALF * half);
    }
    all
}

#[inline]
#[target_feature(enable = "avx2")]
fn row(node: &Node, start: u8) -> __m256 {
    // SAFETY: the array holds eight floats; the load needs no alignment.
    unsafe { _mm256_loadu_ps(node.row(start).as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn load(from: &Lanes, half: usize) -> __m256 {
    // SAFETY: the array holds sixteen floats; the load needs no alignment.
    unsafe { _mm256_loadu_ps(from.0.as_ptr().add(HALF * (half & 1))) }
}

#[inline]
#[target_feature(enable = "avx2")]
fn store(to: &mut [f32; BEAM], half: usize, value: __m256) {
    // SAFETY: the array holds sixteen floats; the store needs no alignment.
    unsafe { _mm256_storeu_ps(to.as_mut_ptr().add(HALF * (half & 1)), value) }
}
