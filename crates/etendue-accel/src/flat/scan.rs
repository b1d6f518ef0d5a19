//! The first pass: sixteen rays against all triangles, in f32.

use super::{FlatTriangle, LIMIT};
use crate::bounds::{greatest, least};

/// Rays of a group.
pub(crate) const LANES: usize = 16;

/// Sixteen rays with the same axis of the largest component, and with x, y and z as the shear has them.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    pub origin: [[f32; LANES]; 3],
    pub direction: [[f32; LANES]; 3],
    pub shear: [[f32; LANES]; 3],
    /// Infinite for lanes without a ray, which excludes all hits.
    pub t_min: [f32; LANES],
    pub t_max: [f32; LANES],
    pub mask: [u32; LANES],
    /// The primitive that the ray left, or 0.
    pub skip: [u32; LANES],
}

impl Group {
    pub const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        direction: [[0.0; LANES]; 3],
        shear: [[0.0; LANES]; 3],
        t_min: [f32::INFINITY; LANES],
        t_max: [0.0; LANES],
        mask: [0; LANES],
        skip: [0; LANES],
    };
}

/// Pairs of triangle and ray that the exact test has to decide: indices of triangles times [`LANES`] plus lanes.
#[derive(Debug)]
pub(crate) struct Pairs {
    /// One vector more than can be used, because vectors are stored whole.
    words: [u32; LANES * (LIMIT + 1)],
    len: usize,
}

impl Pairs {
    pub fn new() -> Self {
        Self { words: [0; LANES * (LIMIT + 1)], len: 0 }
    }

    pub fn clear(&mut self) {
        self.len = 0;
    }

    pub fn used(&self) -> &[u32] {
        &self.words[..self.len]
    }

    /// The place for the next vector.
    #[inline(always)]
    pub fn place(&mut self) -> &mut [u32; LANES] {
        let start = self.len.min(LANES * LIMIT);
        (&mut self.words[start..start + LANES]).try_into().expect("a slice of this length")
    }

    /// Says how many words of the last place count.
    #[inline(always)]
    pub fn advance(&mut self, count: u32) {
        self.len += count as usize;
    }
}

/// Lists what may be hits, in plain code: see [`crate::simd::Simd::scan`].
#[inline(always)]
pub(crate) fn scan<const AXIS: usize, const ANY: bool>(
    triangles: &[FlatTriangle],
    rays: &Group,
    pairs: &mut Pairs,
) -> u32 {
    let mut certain = 0;
    let mut bound = rays.t_max;
    for (index, triangle) in triangles.iter().enumerate() {
        let mut sheared = [[[0.0_f32; LANES]; 3]; 3];
        for (corner, [x, y, depth]) in triangle.corners.iter().zip(&mut sheared) {
            let (px, py, pz) = (corner[(AXIS + 1) % 3], corner[(AXIS + 2) % 3], corner[AXIS]);
            for i in 0..LANES {
                let z = pz - rays.origin[2][i];
                x[i] = (px - rays.origin[0][i]) - rays.shear[0][i] * z;
                y[i] = (py - rays.origin[1][i]) - rays.shear[1][i] * z;
                depth[i] = rays.shear[2][i] * z;
            }
        }
        let [[ax, ay, ad], [bx, by, bd], [cx, cy, cd]] = sheared;
        let (mut listed, mut sure) = (0, 0);
        for i in 0..LANES {
            let u = cx[i] * by[i] - cy[i] * bx[i];
            let v = ax[i] * cy[i] - ay[i] * cx[i];
            let w = bx[i] * ay[i] - by[i] * ax[i];
            let (first, last) = (least(least(u, v), w), greatest(greatest(u, v), w));
            let (low, high) = (least(least(ad[i], bd[i]), cd[i]), greatest(greatest(ad[i], bd[i]), cd[i]));
            let seen = (triangle.mask & rays.mask[i] != 0) & (triangle.order != rays.skip[i]);
            // A difference of rounded products that is not 0 has the right sign, and so has the product of two of them.
            let sides = first * last;
            let may = seen & (sides >= 0.0) & (high > rays.t_min[i]) & (low <= bound[i]);
            let must = may & (sides > 0.0) & (low > rays.t_min[i]) & (high < rays.t_max[i]);
            listed |= u32::from(may) << i;
            sure |= u32::from(must) << i;
            bound[i] = if must { least(bound[i], high) } else { bound[i] };
        }
        if ANY {
            certain |= sure;
            listed &= !certain;
        }
        while listed != 0 {
            let lane = listed.trailing_zeros();
            listed &= listed - 1;
            pairs.place()[0] = (index * LANES) as u32 + lane;
            pairs.advance(1);
        }
    }
    certain
}
