//! Sixteen rays that go the same way, in the lanes of vectors.

use super::node::{LANES, Node, Pack, WIDTH, rows_of};
use crate::bounds::{Bounds, greatest, least};
use crate::local_ray::LocalRay;
use crate::padding::{FLATTEST, Padding};
use crate::ray::Ray;
use crate::search::Search;

/// Rays of a beam.
pub(crate) const BEAM: usize = 16;

/// A number for each ray.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lanes(pub [f32; BEAM]);

impl Lanes {
    const ZERO: Self = Self([0.0; BEAM]);

    /// For rays that do not count.
    pub const NONE: Self = Self([f32::NAN; BEAM]);
}

/// Rays that share the octant of their directions and the axis of the largest component. Vectors are by the axes of the
/// shear ([`LocalRay`]): x, y, z.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beam {
    /// Which axes of space these are.
    pub axes: [usize; 3],
    /// Where the rows of a node begin that have the near and the far planes of each.
    pub rows: [[u8; 3]; 2],
    pub octant: u32,
    pub origin: [Lanes; 3],
    pub direction: [Lanes; 3],
    pub shear: [Lanes; 3],
    /// See [`crate::padding::SlabRay`]: the same numbers.
    pub rate: [Lanes; 3],
    pub near: [Lanes; 3],
    pub far: [Lanes; 3],
    pub outline: Outline,
    pub t_min: Lanes,
    /// The parameters of the best hits so far, at first the ends of the ranges; minus infinity for rays that want no more.
    pub bound: Lanes,
}

/// What holds for all rays of a beam: where a plane at p is crossed lies between the least and the greatest of p times either
/// rate, less the start. All roundings are monotonic, so what is found from these is a bound of what each ray finds.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Outline {
    /// The least and the greatest rate.
    pub rate: [[f32; 2]; 3],
    /// The greatest start for near planes.
    pub near: [f32; 3],
    /// The least start for far planes.
    pub far: [f32; 3],
}

impl Outline {
    #[inline(always)]
    fn of(rate: &[Lanes; 3], near: &[Lanes; 3], far: &[Lanes; 3]) -> Self {
        let mut outline = Self { rate: [[0.0; 2]; 3], near: [0.0; 3], far: [0.0; 3] };
        for a in 0..3 {
            outline.rate[a] = [lowest(&rate[a]), highest(&rate[a])];
            (outline.near[a], outline.far[a]) = (highest(&near[a]), lowest(&far[a]));
        }
        outline
    }

    /// The children that any ray may enter, a bit each.
    #[inline(always)]
    pub fn children(&self, node: &Node, rows: &[[u8; 3]; 2]) -> u32 {
        let (mut enter, mut exit) = ([0.0; WIDTH], [f32::INFINITY; WIDTH]);
        let [near_rows, far_rows] = rows;
        for (a, (&near, &far)) in near_rows.iter().zip(far_rows).enumerate() {
            let (first, last) = (node.row(near), node.row(far));
            let ([slow, fast], near, far) = (self.rate[a], self.near[a], self.far[a]);
            for i in 0..WIDTH {
                enter[i] = greatest(least(first[i] * slow - near, first[i] * fast - near), enter[i]);
                exit[i] = least(greatest(last[i] * slow - far, last[i] * fast - far), exit[i]);
            }
        }
        (0..WIDTH).map(|i| u32::from(enter[i] <= exit[i]) << i).sum()
    }
}

/// All numbers as one, by halves.
#[inline(always)]
fn fold(Lanes(lanes): &Lanes, of: impl Fn(f32, f32) -> f32) -> f32 {
    let mut part = *lanes;
    for len in [BEAM / 2, BEAM / 4, BEAM / 8, BEAM / 16] {
        for i in 0..len {
            part[i] = of(part[i], part[i + len]);
        }
    }
    part[0]
}

/// The least number.
#[inline(always)]
fn lowest(lanes: &Lanes) -> f32 {
    fold(lanes, least)
}

/// The greatest number.
#[inline(always)]
fn highest(lanes: &Lanes) -> f32 {
    fold(lanes, greatest)
}

/// Some children in an order, see [`Node::order_of`]: their numbers, and how many.
#[inline(always)]
pub(crate) fn in_order(order: u32, children: u32) -> ([u8; WIDTH], usize) {
    let (mut numbers, mut used) = ([0; WIDTH], 0);
    for i in 0..WIDTH {
        let child = order >> (3 * i) & 7;
        numbers[used & 7] = child as u8;
        used += (children >> child & 1) as usize;
    }
    (numbers, used.min(WIDTH))
}

/// Numbers of headings.
pub(crate) const HEADINGS: usize = 3 << 3;

/// The octant of a ray and the axis of its largest component, if it can hit anything: below [`HEADINGS`].
#[inline(always)]
pub(crate) fn heading(ray: &Ray) -> Option<usize> {
    let [x, y, z] = ray.direction.map(|d| d.to_bits() >> 31);
    Some(LocalRay::major_axis(ray.origin, ray.direction)? << 3 | (x | y << 1 | z << 2) as usize)
}

impl Beam {
    /// Some rays of one heading as a beam.
    #[inline(always)]
    pub fn new(rays: &[Ray], members: &[u32; BEAM], heading: usize, padding: &Padding) -> Self {
        let (axis, octant) = (heading >> 3, heading as u32 & 7);
        let axes = [(axis + 1) % 3, (axis + 2) % 3, axis];
        let rows = rows_of(octant).map(|rows| axes.map(|axis| rows[axis]));
        let zero = [Lanes::ZERO; 3];
        let (mut origin, mut direction) = (zero, zero);
        let (mut t_min, mut bound) = (Lanes::ZERO, Lanes::ZERO);
        for (i, &member) in members.iter().enumerate() {
            let ray = &rays[member as usize];
            for a in 0..3 {
                origin[a].0[i] = ray.origin[axes[a]];
                direction[a].0[i] = ray.direction[axes[a]];
            }
            t_min.0[i] = Search::first_t(ray);
            // A range that is none never begins.
            bound.0[i] = if t_min.0[i] < ray.t_max { ray.t_max } else { f32::NEG_INFINITY };
        }
        let (mut shear, mut rate, mut near, mut far) = (zero, zero, zero, zero);
        let mut pad = Lanes::ZERO;
        for i in 0..BEAM {
            let reach = greatest(greatest(origin[0].0[i].abs(), origin[1].0[i].abs()), origin[2].0[i].abs());
            pad.0[i] = padding.at(reach);
        }
        for a in 0..3 {
            for i in 0..BEAM {
                let (d, z) = (direction[a].0[i], direction[2].0[i]);
                shear[a].0[i] = if a == 2 { 1.0 } else { d } / z;
                rate[a].0[i] = 1.0 / greatest(d.abs(), z.abs() * FLATTEST).copysign(d);
                let forward = pad.0[i].copysign(d);
                near[a].0[i] = (origin[a].0[i] + forward) * rate[a].0[i];
                far[a].0[i] = (origin[a].0[i] - forward) * rate[a].0[i];
            }
        }
        let outline = Outline::of(&rate, &near, &far);
        Self { axes, rows, octant, origin, direction, shear, rate, near, far, outline, t_min, bound }
    }
}

impl Beam {
    /// How far the rays are apart: the greatest difference of their directions over that of the major axis, or of their origins as
    /// a part of a box's longest side.
    #[inline(always)]
    pub fn spread(&self, bounds: &Bounds) -> f32 {
        let (mut origins, mut directions, mut side) = (0.0, 0.0, f32::MIN_POSITIVE);
        for a in 0..3 {
            origins = greatest(origins, highest(&self.origin[a]) - lowest(&self.origin[a]));
            side = greatest(side, bounds.max[a] - bounds.min[a]);
            if a < 2 {
                directions = greatest(directions, highest(&self.shear[a]) - lowest(&self.shear[a]));
            }
        }
        greatest(directions, origins / side)
    }

    /// One of the rays.
    #[inline(always)]
    pub fn ray(&self, lane: usize) -> Option<LocalRay> {
        let (mut origin, mut direction) = ([0.0; 3], [0.0; 3]);
        for a in 0..3 {
            origin[self.axes[a]] = self.origin[a].0[lane];
            direction[self.axes[a]] = self.direction[a].0[lane];
        }
        LocalRay::new(origin, direction)
    }
}

/// In plain code: see [`crate::simd::Simd::beam_children`].
#[inline(always)]
pub(crate) fn children(
    node: &Node,
    beam: &Beam,
    children: &[u8],
    enters: &mut [Lanes; WIDTH],
    words: &mut [u32; WIDTH],
) -> usize {
    let mut used = 0;
    for &child in children {
        let child = usize::from(child) % WIDTH;
        let (mut enter, mut exit) = (beam.t_min.0, beam.bound.0);
        for a in 0..3 {
            let (first, last) = (node.row(beam.rows[0][a])[child], node.row(beam.rows[1][a])[child]);
            for r in 0..BEAM {
                enter[r] = greatest(first * beam.rate[a].0[r] - beam.near[a].0[r], enter[r]);
                exit[r] = least(last * beam.rate[a].0[r] - beam.far[a].0[r], exit[r]);
            }
        }
        let mut any = false;
        for r in 0..BEAM {
            let enters = enter[r] <= exit[r];
            any |= enters;
            enter[r] = if enters { enter[r] } else { f32::NAN };
        }
        enters[used & 7].0 = enter;
        words[used & 7] = node.children[child];
        used += usize::from(any);
    }
    used
}

/// In plain code: see [`crate::simd::Simd::waiting`].
#[inline(always)]
pub(crate) fn waiting(enters: &Lanes, bound: &Lanes) -> u32 {
    (0..BEAM).map(|i| u32::from(enters.0[i] <= bound.0[i]) << i).sum()
}

/// In plain code: see [`crate::simd::Simd::beam_triangle`].
#[inline(always)]
pub(crate) fn triangle(pack: &Pack, place: usize, beam: &Beam, sheared: &mut [[[f32; BEAM]; 3]; 3]) -> u32 {
    let place = place % LANES;
    for (corner, [x, y, depth]) in pack.corners.iter().zip(&mut *sheared) {
        let [px, py, pz] = [0, 1, 2].map(|a| corner[beam.axes[a]][place]);
        for i in 0..BEAM {
            let z = pz - beam.origin[2].0[i];
            x[i] = (px - beam.origin[0].0[i]) - beam.shear[0].0[i] * z;
            y[i] = (py - beam.origin[1].0[i]) - beam.shear[1].0[i] * z;
            depth[i] = beam.shear[2].0[i] * z;
        }
    }
    let [[ax, ay, ad], [bx, by, bd], [cx, cy, cd]] = &*sheared;
    let mut found = 0;
    for i in 0..BEAM {
        let u = cx[i] * by[i] - cy[i] * bx[i];
        let v = ax[i] * cy[i] - ay[i] * cx[i];
        let w = bx[i] * ay[i] - by[i] * ax[i];
        let (first, last) = (least(least(u, v), w), greatest(greatest(u, v), w));
        let (low, high) = (least(least(ad[i], bd[i]), cd[i]), greatest(greatest(ad[i], bd[i]), cd[i]));
        // A difference of rounded products that is not 0 has the right sign, and so has the product of two of them.
        let may = (first * last >= 0.0) & (high > beam.t_min.0[i]) & (low <= beam.bound.0[i]);
        found |= u32::from(may) << i;
    }
    found
}
