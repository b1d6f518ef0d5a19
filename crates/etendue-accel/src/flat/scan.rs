//! The first pass: sixteen rays against all facets, in f32.

use super::LIMIT;
use super::facet::{Facet, Facets};
use crate::bounds::least;

/// Rays of a group.
pub(crate) const LANES: usize = 16;

/// Sixteen rays with the same axis of the largest component, and with x, y and z as the shear has them.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    pub origin: [[f32; LANES]; 3],
    pub direction: [[f32; LANES]; 3],
    pub shear: [[f32; LANES]; 3],
    /// What heights over facets may be off because of the origin: [`super::facet`].
    pub reach: [f32; LANES],
    /// The sum of the magnitudes of the direction's components.
    pub length: [f32; LANES],
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
        reach: [0.0; LANES],
        length: [0.0; LANES],
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

    /// Adds a triangle with each lane that has its bit.
    #[inline(always)]
    fn push_each(&mut self, triangle: u32, mut lanes: u32) {
        while lanes != 0 {
            self.place()[0] = triangle * LANES as u32 + lanes.trailing_zeros();
            self.advance(1);
            lanes &= lanes - 1;
        }
    }
}

/// Where a group's components stand that facets know by axis.
#[inline(always)]
pub(crate) fn place_of<const AXIS: usize>(axis: u8) -> usize {
    let axis = axis as usize;
    if axis > AXIS { axis - AXIS - 1 } else { axis + 2 - AXIS }.min(2)
}

/// Lists what may be hits, in plain code: see [`crate::simd::Simd::scan`].
#[inline(always)]
pub(crate) fn scan<const AXIS: usize, const ANY: bool>(facets: &Facets, rays: &Group, pairs: &mut Pairs) -> u32 {
    let mut state = State { bound: rays.t_max, certain: 0 };
    facets.quadrilaterals.iter().for_each(|facet| state.meet::<AXIS, ANY, 4>(facet, rays, pairs));
    facets.triangles.iter().for_each(|facet| state.meet::<AXIS, ANY, 3>(facet, rays, pairs));
    state.certain
}

/// What is known of the rays of a group.
struct State {
    /// No hit beyond this counts.
    bound: [f32; LANES],
    /// Those that hit something for certain, if that is all that is asked.
    certain: u32,
}

impl State {
    #[inline(always)]
    #[expect(clippy::neg_cmp_op_on_partial_ord, reason = "what is not a number excludes nothing")]
    fn meet<const AXIS: usize, const ANY: bool, const EDGES: usize>(
        &mut self,
        facet: &Facet<EDGES>,
        rays: &Group,
        pairs: &mut Pairs,
    ) {
        let [nx, ny, nz] = [0, 1, 2].map(|place| facet.normal[(AXIS + 1 + place) % 3]);
        let [u, v] = facet.axes.map(place_of::<AXIS>);
        let (mut first, mut second, mut sure) = (0_u32, 0_u32, 0_u32);
        for i in 0..LANES {
            let [ox, oy, oz] = [rays.origin[0][i], rays.origin[1][i], rays.origin[2][i]];
            let [dx, dy, dz] = [rays.direction[0][i], rays.direction[1][i], rays.direction[2][i]];
            let rate = 1.0 / (nx * dx + (ny * dy + nz * dz));
            let t = (((facet.height - nz * oz) - ny * oy) - nx * ox) * rate;
            let doubt = rate.abs() * (rays.reach[i] + facet.slack);
            let margin = doubt * rays.length[i];
            let on = [t * rays.direction[u][i] + rays.origin[u][i], t * rays.direction[v][i] + rays.origin[v][i]];
            let distance = |line: &[f32; 3]| line[0] * on[0] + (line[1] * on[1] + line[2]);
            let mut inside = distance(&facet.edges[0]);
            for edge in &facet.edges[1..] {
                inside = least(distance(edge), inside);
            }
            let (low, high) = (t - doubt, t + doubt);
            let [is_first, is_second] = facet.orders.map(|order| order != rays.skip[i]);
            let seen = facet.mask & rays.mask[i] != 0;
            let may = seen & !(inside + margin < 0.0) & !(high <= rays.t_min[i]) & !(low > self.bound[i]);
            let must =
                may & is_first & is_second & (inside > margin) & (low > rays.t_min[i]) & (high < rays.t_max[i]);
            sure |= u32::from(must) << i;
            if EDGES > 3 {
                let side = distance(&facet.diagonal);
                first |= u32::from(may & is_first & !(side + margin < 0.0)) << i;
                second |= u32::from(may & is_second & !(side > margin)) << i;
            } else {
                first |= u32::from(may & is_first) << i;
            }
            self.bound[i] = if must & !ANY { least(self.bound[i], high) } else { self.bound[i] };
        }
        if ANY {
            self.certain |= sure;
            (first, second) = (first & !self.certain, second & !self.certain);
        }
        pairs.push_each(facet.places[0], first);
        if EDGES > 3 {
            pairs.push_each(facet.places[1], second);
        }
    }
}
