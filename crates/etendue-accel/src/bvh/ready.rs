//! Rays made ready for traversal eight at a time, in the lanes of vectors: by itself each would take as long as two node steps.

use super::packets::Rest;
use crate::bounds::greatest;
use crate::local_ray::{Axis, LocalRay};
use crate::padding::{FLATTEST, Padding, SlabRay};
use crate::ray::Ray;
use crate::search::Search;

/// Rays made ready together.
const LANES: usize = 8;

/// A number of each ray by axis.
type Vectors = [[f32; LANES]; 3];

/// Rays of the world by component: the numbers of [`LocalRay`] and [`SlabRay`].
#[derive(Default)]
struct Columns {
    origin: Vectors,
    direction: Vectors,
    shear: Vectors,
    rate: Vectors,
    near: Vectors,
    far: Vectors,
    octant: [u32; LANES],
    /// The axis of the largest component of the direction.
    major: [u32; LANES],
    is_traceable: [bool; LANES],
}

impl Columns {
    #[inline(always)]
    fn set(&mut self, lane: usize, ray: &Ray) {
        for axis in 0..3 {
            self.origin[axis][lane] = ray.origin[axis];
            self.direction[axis][lane] = ray.direction[axis];
        }
    }

    /// Finds the rest from origins and directions.
    #[inline(always)]
    fn complete(&mut self, padding: &Padding) {
        let Self { origin, direction, shear, rate, near, far, octant, major, is_traceable } = self;
        let (mut pad, mut flattest) = ([0.0; LANES], [0.0; LANES]);
        for i in 0..LANES {
            let (o, d) = ([0, 1, 2].map(|a| origin[a][i]), [0, 1, 2].map(|a| direction[a][i]));
            (major[i], is_traceable[i]) = LocalRay::major(o, d);
            let reach = greatest(greatest(o[0].abs(), o[1].abs()), o[2].abs());
            pad[i] = padding.at(reach);
            let of_three = |[x, y, z]: [f32; 3]| {
                if major[i] == 0 {
                    x
                } else if major[i] == 1 {
                    y
                } else {
                    z
                }
            };
            let z = of_three(d);
            shear[0][i] = of_three([d[1], d[2], d[0]]) / z;
            shear[1][i] = of_three([d[2], d[0], d[1]]) / z;
            shear[2][i] = 1.0 / z;
            flattest[i] = z.abs() * FLATTEST;
            let [x, y, z] = d.map(|d| d.to_bits() >> 31);
            octant[i] = x | y << 1 | z << 2;
        }
        for a in 0..3 {
            for i in 0..LANES {
                let d = direction[a][i];
                rate[a][i] = 1.0 / greatest(d.abs(), flattest[i]).copysign(d);
                let forward = pad[i].copysign(d);
                near[a][i] = (origin[a][i] + forward) * rate[a][i];
                far[a][i] = (origin[a][i] - forward) * rate[a][i];
            }
        }
    }
}

/// Rays that are still to be started, in the order of [`Rest`].
pub(super) struct Queue<'a> {
    rays: &'a [Ray],
    rest: &'a Rest,
    padding: &'a Padding,
    columns: Columns,
    /// The number of the next ray.
    next: usize,
}

/// A ray whose turn it is.
pub(super) struct Next {
    /// Its number in the order of [`Rest`], and its index in the slice.
    pub number: usize,
    pub index: usize,
    /// False if it hits nothing by definition.
    pub may_hit: bool,
}

impl<'a> Queue<'a> {
    pub fn new(rays: &'a [Ray], rest: &'a Rest, padding: &'a Padding) -> Self {
        Self { rays, rest, padding, columns: Columns::default(), next: 0 }
    }

    /// The next ray, if there is any.
    #[inline(always)]
    pub fn next(&mut self) -> Option<Next> {
        let number = self.next;
        let index = self.rest.index(number)?;
        if number.is_multiple_of(LANES) {
            self.fill();
        }
        self.next += 1;
        let ray = &self.rays[index];
        let may_hit = self.columns.is_traceable[number % LANES] & (Search::first_t(ray) < ray.t_max);
        Some(Next { number, index, may_hit })
    }

    /// Writes a ray in place: it is not copied on the way.
    #[inline(always)]
    pub fn put(&self, next: &Next, search: &mut Search, local: &mut LocalRay, slab: &mut SlabRay) {
        let (columns, lane, ray) = (&self.columns, next.number % LANES, &self.rays[next.index]);
        *search = Search::new(ray);
        (local.origin, local.direction) = (ray.origin, ray.direction);
        local.axes = Axis::from_major(columns.major[lane]);
        for axis in 0..3 {
            local.shear[axis] = columns.shear[axis][lane];
            slab.rate[axis] = columns.rate[axis][lane];
            slab.near[axis] = columns.near[axis][lane];
            slab.far[axis] = columns.far[axis][lane];
        }
        slab.octant = columns.octant[lane];
    }

    #[inline(always)]
    fn fill(&mut self) {
        for lane in 0..LANES {
            let Some(index) = self.rest.index(self.next + lane) else { break };
            self.columns.set(lane, &self.rays[index]);
        }
        self.columns.complete(self.padding);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ray::PrimitiveId;

    #[test]
    fn lanes_have_the_bits_of_rays_alone() {
        let padding = Padding::new(&crate::bounds::Bounds { min: [-3.0; 3], max: [5.0; 3] }, []);
        let numbers = [0.0, -0.0, 1.0, -2.5, 1e-20, -3e-30, 7.0, f32::INFINITY, f32::NAN, 1e30, -4.0, 0.3, 5.0];
        let mut draws = (0_u32..).map(|i| numbers[(i.wrapping_mul(2_654_435_761) >> 20) as usize % numbers.len()]);
        let mut three = || [0; 3].map(|_| draws.next().unwrap());
        let rays: Vec<Ray> = (0..1003)
            .map(|i| Ray {
                origin: three(),
                direction: three(),
                t_min: if i % 7 == 0 { -1.0 } else { 0.5 },
                t_max: if i % 11 == 0 { 0.25 } else { 9.0 },
                time: 0.0,
                mask: !0,
                skip: PrimitiveId::NONE,
            })
            .collect();
        let rest = Rest { others: (0..1003).rev().collect(), ..Rest::default() };
        let mut queue = Queue::new(&rays, &rest, &padding);
        let mut some = 0;
        while let Some(next) = queue.next() {
            assert_eq!(next.index, 1002 - next.number);
            let alone = Search::start(&rays[next.index]);
            assert_eq!(next.may_hit, alone.is_some(), "{:?}", rays[next.index]);
            let Some((search, ray)) = alone else { continue };
            let mut ready = (Search::NONE, LocalRay::NONE, SlabRay::NONE);
            queue.put(&next, &mut ready.0, &mut ready.1, &mut ready.2);
            let slab = SlabRay::new(&ray, &padding);
            assert_eq!(format!("{ready:?}"), format!("{:?}", (search, ray, slab)));
            some += 1;
        }
        assert!(queue.next().is_none() && some > 100, "{some}");
    }
}
