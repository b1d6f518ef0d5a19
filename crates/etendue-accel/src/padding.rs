//! How much larger boxes must be than what they hold, so that no box test loses a hit.
//!
//! # What is to be shown
//!
//! A primitive test accepts a hit at parameter t. Every box around the primitive must then accept an interval that holds
//! t, although the primitive test and the box test round differently. It is enough that, on every axis, the exact number
//! o + t d is within `pad` of the box, less what the box test itself rounds.
//!
//! Let u = 2^-24, |.| the largest magnitude of components, o and d the ray as the primitive sees it, E the largest
//! magnitude of a coordinate of the structure, R = |o| + E, which bounds |v - o| for every vertex v.
//!
//! # Triangles
//!
//! Let z be the axis of the largest component of d. The test rounds v - o (u R an axis), the factor dx/dz, of magnitude at
//! most 1, and its product with the z distance (3 u R together), and their difference (u times at most 2 R): a sheared x
//! or y is off by at most 6.1 u R. Signs of the edge functions are exact, so an accepted origin lies in the hull of the
//! rounded sheared points: there are convex weights whose combination of vertices, P, has t* = (P - o).z / dz with
//! |o + t* d - P| <= 6.1 u R. The computed t differs from t* by the rounding of the depths (3 u R in space: v - o, 1/dz
//! and their product) and of t itself (u R); weights come from f64 and add nothing that counts. |t - t*| |d| <= 4.1 u R,
//! and clamping t to the hull of the depths does not increase it. Together |o + t d - P| <= 10.2 u R. Where a triangle is in a tree
//! in pieces, P is in the box of one of them.
//!
//! # Spheres
//!
//! All in f64 but the last rounding. An error e of the discriminant moves a root by at most sqrt(e)/|d| where the line
//! grazes; e is some 2^-51 R^2, so that is 1.5 u R; the rounding of t adds u R.
//!
//! # Instances
//!
//! M, T are linear part and shift of `to_world`, N, S those of `to_object`; ||.|| the largest row sum of magnitudes. The
//! object ray is rounded: o' = N o + S + e1, d' = N d + e2 with |e1| <= 4 u (||N|| |o| + |S|), |e2| <= 4 u ||N|| |d|. At a
//! hit, |o' + t d' - P'| <= 10.2 u (|o'| + E') for a point P' of the object, by the above. The exact image M P' + T lies in
//! the world box, so
//!
//!   |o + t d - (M P' + T)| <= 10.2 u ||M|| (|o'| + E') + 4 u ||M|| (||N|| (|o| + t |d|) + |S|) + r
//!
//! where r = ||M N - 1|| |o + t d| + |M S + T| is what the rounding of the inverse leaves, measured in f64 when building.
//! With t |d| <= |o| + E (to first order), |o'| <= ||N|| |o| + |S|, k = ||M|| ||N|| >= 1, this is at most
//!
//!   u (19 k |o| + 4 k E + 11 ||M|| E' + 15 ||M|| |S|) + r.
//!
//! # The box test
//!
//! Computes row * rd - (o' * rd), with or without fusing, rd the rounded 1/d', o' the origin with the pad. In space it is
//! off by at most 4 u R plus u times |o| + pad for rounding o'. d' is d with components below 2^-32 |d| raised to that:
//! within t of the hit this moves the ray by at most 2^-32 R.
//!
//! # The sum
//!
//! 10.2 + 4 + 1.1 + a little < 16 for plain structures, 19 + 5.1 + a little < 26 for instances. The pad is
//!
//!   32 u (k (|o| + E) + F)
//!
//! with k = 1 and F = 0 without instances, else the largest over them of k = ||M|| ||N|| + ||M N - 1|| / 32 u and of
//! F = ||M|| (E' + |S|) + |M S + T| / 32 u. A floor of 2^-100 covers numbers that lose bits below the range of f32. Pads
//! are cut at 2^52, beyond all coordinates: no number of a box test can overflow, and none is NaN.

use crate::bounds::{Bounds, greatest, least, round_up};
use crate::geometry::{Place, Transform};
use crate::local_ray::{COORDINATE_LIMIT, LocalRay};

/// 32 u.
const SLACK: f64 = 32.0 / (1 << 24) as f64;

/// Below this, rounding is absolute.
const FLOOR: f64 = 1.0 / (1_u128 << 100) as f64;

/// Smallest component of a box test's direction, relative to the largest.
pub(crate) const FLATTEST: f32 = 1.0 / (1_u64 << 32) as f32;

/// The pad of one structure as a function of the ray: `slope * |o| + constant`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Padding {
    slope: f32,
    constant: f32,
}

impl Padding {
    /// For a structure with these bounds that holds these instances (with the bounds of their objects).
    pub fn new<'a>(bounds: &Bounds, instances: impl IntoIterator<Item = (&'a Place, Bounds)>) -> Self {
        let (mut factor, mut far) = (1.0_f64, 0.0_f64);
        for (place, object) in instances {
            let stretch = match place {
                Place::World => continue,
                Place::Fixed(transform) => Stretch::of(transform),
                Place::Moving(motion) => motion.stretch(),
            };
            factor = factor.max(stretch.forth * stretch.back + stretch.residual / SLACK);
            let shifts = stretch.forth * (f64::from(object.reach()) + stretch.back_shift);
            far = far.max(shifts + stretch.residual_shift / SLACK);
        }
        let constant = SLACK * (factor * f64::from(bounds.reach()) + far) + FLOOR;
        Self { slope: round_up(SLACK * factor), constant: round_up(constant) }
    }

    /// The pad for a ray.
    #[inline(always)]
    pub fn of(&self, ray: &LocalRay) -> f32 {
        self.at(ray.origin_reach())
    }

    /// The pad for a ray whose origin reaches so far.
    #[inline(always)]
    pub fn at(&self, origin_reach: f32) -> f32 {
        least(self.slope * origin_reach + self.constant, 4.0 * COORDINATE_LIMIT)
    }
}

/// Row-sum norms of a transform, or bounds of them at all times.
pub(crate) struct Stretch {
    /// Of `to_world`.
    pub forth: f64,
    /// Of `to_object`.
    pub back: f64,
    /// Largest coordinate of the shift of `to_object`.
    pub back_shift: f64,
    /// Of the product less the identity.
    pub residual: f64,
    /// Largest coordinate of the product's shift.
    pub residual_shift: f64,
}

impl Stretch {
    pub fn of(transform: &Transform) -> Self {
        let m = transform.to_world.map(|row| row.map(f64::from));
        let n = transform.to_object.map(|row| row.map(f64::from));
        let norm = |rows: &[[f64; 4]; 3]| {
            rows.iter().map(|row| row[..3].iter().map(|x| x.abs()).sum::<f64>()).fold(0.0, f64::max)
        };
        let shift = |rows: &[[f64; 4]; 3]| rows.iter().map(|row| row[3].abs()).fold(0.0, f64::max);
        let mut product = [[0.0; 4]; 3];
        for r in 0..3 {
            for c in 0..4 {
                product[r][c] = m[r][0] * n[0][c] + m[r][1] * n[1][c] + m[r][2] * n[2][c];
            }
            product[r][r] -= 1.0;
            product[r][3] += m[r][3];
        }
        Self {
            forth: norm(&m),
            back: norm(&n),
            back_shift: shift(&n),
            residual: norm(&product),
            residual_shift: shift(&product),
        }
    }
}

/// A ray as box tests use it. A plane at p is crossed at `p * rate - start * rate`; near planes have the start moved
/// forward by the pad, far planes backward, which is the same as padding every box and costs nothing.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SlabRay {
    /// Reciprocal direction, finite.
    pub rate: [f32; 3],
    /// Start for near planes, times rate.
    pub near: [f32; 3],
    /// Start for far planes, times rate.
    pub far: [f32; 3],
    /// Bit a is set if the direction's component a is negative.
    pub octant: u32,
}

impl SlabRay {
    /// No ray.
    pub const NONE: Self = Self { rate: [0.0; 3], near: [0.0; 3], far: [0.0; 3], octant: 0 };

    #[inline(always)]
    pub fn new(ray: &LocalRay, padding: &Padding) -> Self {
        let pad = padding.of(ray);
        let least_direction = ray.direction[ray.axes[2] as usize].abs() * FLATTEST;
        let ([dx, dy, dz], [ox, oy, oz]) = (ray.direction, ray.origin);
        let (direction, origin) = ([dx, dy, dz, 1.0_f32], [ox, oy, oz, 0.0]);
        // Four lanes, of which the last is unused, are vectors.
        let rate = direction.map(|d| 1.0 / greatest(d.abs(), least_direction).copysign(d));
        let forward = direction.map(|d| pad.copysign(d));
        let near: [f32; 4] = std::array::from_fn(|a| (origin[a] + forward[a]) * rate[a]);
        let far: [f32; 4] = std::array::from_fn(|a| (origin[a] - forward[a]) * rate[a]);
        let octant = dx.to_bits() >> 31 | dy.to_bits() >> 31 << 1 | dz.to_bits() >> 31 << 2;
        let three = |[x, y, z, _]: [f32; 4]| [x, y, z];
        Self { rate: three(rate), near: three(near), far: three(far), octant }
    }

    /// The interval of t inside one padded box, cut to a range.
    #[inline(always)]
    pub fn interval(&self, bounds: &Bounds, t_min: f32, t_max: f32) -> (f32, f32) {
        let (mut enter, mut exit) = (t_min, t_max);
        for a in 0..3 {
            let (first, last) = self.planes(a, bounds.min[a], bounds.max[a]);
            enter = greatest(first, enter);
            exit = least(last, exit);
        }
        (enter, exit)
    }

    /// Where the ray enters and leaves the padded slab between two coordinates of an axis.
    #[inline(always)]
    pub fn planes(&self, axis: usize, low: f32, high: f32) -> (f32, f32) {
        let (first, last) = if self.octant >> axis & 1 == 0 { (low, high) } else { (high, low) };
        (first * self.rate[axis] - self.near[axis], last * self.rate[axis] - self.far[axis])
    }
}
