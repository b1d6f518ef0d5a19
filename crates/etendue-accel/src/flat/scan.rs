//! The first pass: sixteen rays against all facets, in f32.

use super::LIMIT;
use super::facet::{Facet, Facets, SPREAD};
use crate::bounds::{greatest, least};
use crate::local_ray::LocalRay;
use crate::ray::Ray;

/// Rays of a group.
pub(crate) const LANES: usize = 16;

/// Sixteen rays as they are handed over, by component: the fields of [`Ray`] in their order.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Columns {
    pub origin: [[f32; LANES]; 3],
    pub t_min: [f32; LANES],
    pub direction: [[f32; LANES]; 3],
    pub t_max: [f32; LANES],
    pub time: [f32; LANES],
    pub mask: [u32; LANES],
    /// Instance and primitive of [`Ray::skip`].
    pub skip: [[u32; LANES]; 2],
}

impl Columns {
    pub const EMPTY: Self = Self {
        origin: [[0.0; LANES]; 3],
        t_min: [0.0; LANES],
        direction: [[0.0; LANES]; 3],
        t_max: [0.0; LANES],
        time: [0.0; LANES],
        mask: [0; LANES],
        skip: [[0; LANES]; 2],
    };

    /// In plain code: see [`crate::simd::Simd::transpose`].
    #[inline(always)]
    pub fn fill(&mut self, rays: &[Ray; LANES]) {
        for (lane, ray) in rays.iter().enumerate() {
            for axis in 0..3 {
                self.origin[axis][lane] = ray.origin[axis];
                self.direction[axis][lane] = ray.direction[axis];
            }
            (self.t_min[lane], self.t_max[lane], self.time[lane]) = (ray.t_min, ray.t_max, ray.time);
            self.mask[lane] = ray.mask;
            (self.skip[0][lane], self.skip[1][lane]) = (ray.skip.instance, ray.skip.primitive);
        }
    }
}

/// Sixteen rays, ready for all tests.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Group {
    pub origin: [[f32; LANES]; 3],
    pub direction: [[f32; LANES]; 3],
    /// Factors of the shear: see [`LocalRay`].
    pub shear: [[f32; LANES]; 3],
    /// The axis of space that is z of the shear; x and y are the next ones.
    pub major: [u32; LANES],
    /// The origin along x, y and z of the shear.
    pub turned: [[f32; LANES]; 3],
    /// What heights over facets may be off because of the origin: [`super::facet`].
    pub reach: [f32; LANES],
    /// The sum of the magnitudes of the direction's components.
    pub length: [f32; LANES],
    /// At least 0.
    pub t_min: [f32; LANES],
    pub t_max: [f32; LANES],
    /// 0 for rays that hit nothing by definition.
    pub mask: [u32; LANES],
    /// The primitive that the ray left, or 0.
    pub skip: [u32; LANES],
}

impl Group {
    /// All but `skip`, which stays 0.
    #[inline(always)]
    pub fn of(rays: &Columns) -> Self {
        let mut group = Self {
            origin: rays.origin,
            direction: rays.direction,
            shear: [[0.0; LANES]; 3],
            major: [0; LANES],
            turned: [[0.0; LANES]; 3],
            reach: [0.0; LANES],
            length: [0.0; LANES],
            t_min: [0.0; LANES],
            t_max: rays.t_max,
            mask: [0; LANES],
            skip: [0; LANES],
        };
        let Columns { origin: [ox, oy, oz], direction: [dx, dy, dz], .. } = rays;
        for i in 0..LANES {
            let (origin, direction) = ([ox[i], oy[i], oz[i]], [dx[i], dy[i], dz[i]]);
            let (major, is_traceable) = LocalRay::major(origin, direction);
            let turn = |v: [f32; 3], place: usize| {
                let [x, y, z] = [v[(place + 1) % 3], v[(place + 2) % 3], v[place]];
                if major == 0 {
                    x
                } else if major == 1 {
                    y
                } else {
                    z
                }
            };
            let along = turn(direction, 2);
            for place in 0..2 {
                group.shear[place][i] = turn(direction, place) / along;
                group.turned[place][i] = turn(origin, place);
            }
            group.shear[2][i] = 1.0 / along;
            group.turned[2][i] = turn(origin, 2);
            group.major[i] = major;
            group.reach[i] = greatest(greatest(origin[0].abs(), origin[1].abs()), origin[2].abs()) * SPREAD;
            group.length[i] = direction[0].abs() + direction[1].abs() + direction[2].abs();
            let start = if rays.t_min[i] < 0.0 { 0.0 } else { rays.t_min[i] };
            group.t_min[i] = start;
            group.mask[i] = if is_traceable & (start < rays.t_max[i]) { rays.mask[i] } else { 0 };
        }
        group
    }
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

    /// Adds the first `count` of some words, as long as there is room.
    #[inline(always)]
    pub fn push<const N: usize>(&mut self, words: [u32; N], count: u32) {
        const { assert!(N <= LANES) };
        let start = self.len.min(LANES * LIMIT);
        self.words[start..start + N].copy_from_slice(&words);
        self.len = start + (count as usize).min(N);
    }

    /// Adds a triangle with each lane that has its bit.
    #[inline(always)]
    fn push_each(&mut self, triangle: u32, mut lanes: u32) {
        while lanes != 0 {
            self.push([triangle * LANES as u32 + lanes.trailing_zeros()], 1);
            lanes &= lanes - 1;
        }
    }
}

/// Lists what may be hits, in plain code: see [`crate::simd::Simd::scan`].
#[inline(always)]
pub(crate) fn scan<const ANY: bool>(facets: &Facets, rays: &Group, pairs: &mut Pairs) -> u32 {
    let mut state = State { bound: rays.t_max, certain: 0 };
    facets.quadrilaterals.iter().for_each(|facet| state.meet::<ANY, 4>(facet, rays, pairs));
    facets.triangles.iter().for_each(|facet| state.meet::<ANY, 3>(facet, rays, pairs));
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
    fn meet<const ANY: bool, const EDGES: usize>(&mut self, facet: &Facet<EDGES>, rays: &Group, pairs: &mut Pairs) {
        let [nx, ny, nz] = facet.normal;
        let [u, v] = facet.axes();
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
            let must = may & is_first & is_second & (inside > margin) & (low > rays.t_min[i]) & (high < rays.t_max[i]);
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
