//! AVX-512 for beams: sixteen rays against one box or one triangle after the other.

use std::arch::x86_64::*;

use crate::bvh::beam::{BEAM, Beam, Lanes};
use crate::bvh::node::{LANES, Node, Pack, WIDTH};

/// x and y of a corner, and its ray parameter.
type Sheared = (__m512, __m512, __m512);

#[inline]
#[target_feature(enable = "avx512f,popcnt")]
pub(super) fn beam_children(
    node: &Node,
    beam: &Beam,
    children: &[u8],
    enters: &mut [Lanes; WIDTH],
    words: &mut [u32; WIDTH],
) -> usize {
    let [near, far] = &beam.rows;
    let (x, to_x) = (node.row(near[0]), node.row(far[0]));
    let (y, to_y) = (node.row(near[1]), node.row(far[1]));
    let (z, to_z) = (node.row(near[2]), node.row(far[2]));
    let rate = [load(&beam.rate[0]), load(&beam.rate[1]), load(&beam.rate[2])];
    let near = [load(&beam.near[0]), load(&beam.near[1]), load(&beam.near[2])];
    let far = [load(&beam.far[0]), load(&beam.far[1]), load(&beam.far[2])];
    let (t_min, bound, none) = (load(&beam.t_min), load(&beam.bound), _mm512_set1_ps(f32::NAN));
    let mut used = 0;
    for &child in children {
        let child = usize::from(child) % WIDTH;
        let first = _mm512_fmsub_ps(_mm512_set1_ps(x[child]), rate[0], near[0]);
        let second = _mm512_fmsub_ps(_mm512_set1_ps(y[child]), rate[1], near[1]);
        let third = _mm512_fmsub_ps(_mm512_set1_ps(z[child]), rate[2], near[2]);
        let enter = _mm512_max_ps(_mm512_max_ps(first, second), _mm512_max_ps(third, t_min));
        let first = _mm512_fmsub_ps(_mm512_set1_ps(to_x[child]), rate[0], far[0]);
        let second = _mm512_fmsub_ps(_mm512_set1_ps(to_y[child]), rate[1], far[1]);
        let third = _mm512_fmsub_ps(_mm512_set1_ps(to_z[child]), rate[2], far[2]);
        let exit = _mm512_min_ps(_mm512_min_ps(first, second), _mm512_min_ps(third, bound));
        let entered = _mm512_cmp_ps_mask::<_CMP_LE_OQ>(enter, exit);
        store(&mut enters[used & 7].0, _mm512_mask_mov_ps(none, entered, enter));
        words[used & 7] = node.children[child];
        used += usize::from(entered != 0);
    }
    used
}

#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn waiting(enters: &Lanes, bound: &Lanes) -> u32 {
    u32::from(_mm512_cmp_ps_mask::<_CMP_LE_OQ>(load(enters), load(bound)))
}

#[inline]
#[target_feature(enable = "avx512f")]
pub(super) fn beam_triangle(pack: &Pack, place: usize, beam: &Beam, sheared: &mut [[[f32; BEAM]; 3]; 3]) -> u32 {
    let [kx, ky, kz] = beam.axes.map(|axis| axis % 3);
    let place = place % LANES;
    let (ox, oy, oz) = (load(&beam.origin[0]), load(&beam.origin[1]), load(&beam.origin[2]));
    let (sx, sy, sz) = (load(&beam.shear[0]), load(&beam.shear[1]), load(&beam.shear[2]));
    let shear = |corner: &[[f32; LANES]; 3]| {
        let z = _mm512_sub_ps(_mm512_set1_ps(corner[kz][place]), oz);
        let x = _mm512_sub_ps(_mm512_sub_ps(_mm512_set1_ps(corner[kx][place]), ox), _mm512_mul_ps(sx, z));
        let y = _mm512_sub_ps(_mm512_sub_ps(_mm512_set1_ps(corner[ky][place]), oy), _mm512_mul_ps(sy, z));
        (x, y, _mm512_mul_ps(sz, z))
    };
    let [a, b, c] = [shear(&pack.corners[0]), shear(&pack.corners[1]), shear(&pack.corners[2])];
    let cross = |p: Sheared, q: Sheared| _mm512_sub_ps(_mm512_mul_ps(p.0, q.1), _mm512_mul_ps(p.1, q.0));
    let (u, v, w) = (cross(c, b), cross(a, c), cross(b, a));
    let (first, last) = (_mm512_min_ps(_mm512_min_ps(u, v), w), _mm512_max_ps(_mm512_max_ps(u, v), w));
    // A difference of rounded products that is not 0 has the right sign, and so has the product of two of them.
    let found = _mm512_cmp_ps_mask::<_CMP_GE_OQ>(_mm512_mul_ps(first, last), _mm512_setzero_ps());
    let low = _mm512_min_ps(_mm512_min_ps(a.2, b.2), c.2);
    let high = _mm512_max_ps(_mm512_max_ps(a.2, b.2), c.2);
    let found = _mm512_mask_cmp_ps_mask::<_CMP_GT_OQ>(found, high, load(&beam.t_min));
    let found = _mm512_mask_cmp_ps_mask::<_CMP_LE_OQ>(found, low, load(&beam.bound));
    if found != 0 {
        for (to, from) in sheared.iter_mut().zip([a, b, c]) {
            store(&mut to[0], from.0);
            store(&mut to[1], from.1);
            store(&mut to[2], from.2);
        }
    }
    u32::from(found)
}

#[inline]
#[target_feature(enable = "avx512f")]
fn load(from: &Lanes) -> __m512 {
    // SAFETY: the array holds sixteen floats; the load needs no alignment.
    unsafe { _mm512_loadu_ps(from.0.as_ptr()) }
}

#[inline]
#[target_feature(enable = "avx512f")]
fn store(to: &mut [f32; BEAM], value: __m512) {
    // SAFETY: the array holds sixteen floats; the store needs no alignment.
    unsafe { _mm512_storeu_ps(to.as_mut_ptr(), value) }
}
