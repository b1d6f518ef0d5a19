//! Slices of rays through a list of primitives.

use super::facet::SPREAD;
use super::scan::{Group, LANES, Pairs};
use super::settle::{Best, settle};
use super::{Flat, sphere};
use crate::bounds::{Bounds, greatest, least};
use crate::isa::SimdKernel;
use crate::local_ray::LocalRay;
use crate::padding::{FLATTEST, Padding};
use crate::ray::{Hit, Ray};
use crate::simd::Simd;

/// Rays that are sorted together.
const CHUNK: usize = 512;

/// Searches a world that is nothing but a list for a slice of rays; `finish` gets the index of each ray and what was found.
pub(crate) struct Trace<'a, F, const ANY: bool> {
    pub flat: &'a Flat,
    pub rays: &'a [Ray],
    pub finish: F,
}

impl<F: FnMut(usize, Hit), const ANY: bool> SimdKernel for Trace<'_, F, ANY> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let finish = |index, hit, _enters| (self.finish)(index, hit);
        Flight::<_, ANY> { flat: self.flat, rays: self.rays, beyond: None, finish }.run(simd);
    }
}

/// What lies beyond a list: boxes, and their padding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Beyond<'a> {
    pub boxes: &'a [Bounds],
    pub padding: Padding,
}

/// Searches a list of primitives for a slice of rays. `finish` gets the index of each ray, what was found, and whether the ray
/// enters one of the boxes beyond the list before that.
pub(crate) struct Flight<'a, F, const ANY: bool> {
    pub flat: &'a Flat,
    pub rays: &'a [Ray],
    pub beyond: Option<Beyond<'a>>,
    pub finish: F,
}

#[inline(always)]
fn start_of(ray: &Ray) -> f32 {
    if ray.t_min < 0.0 { 0.0 } else { ray.t_min }
}

impl<F: FnMut(usize, Hit, bool), const ANY: bool> Flight<'_, F, ANY> {
    #[inline(always)]
    pub fn run<S: Simd>(mut self, simd: S) {
        let mut pairs = Pairs::new();
        for (chunk, rays) in self.rays.chunks(CHUNK).enumerate() {
            // The last list is of rays that hit nothing by definition.
            let mut lists = [[0_u16; CHUNK]; 4];
            let mut lens = [0; 4];
            for (index, ray) in rays.iter().enumerate() {
                let axis = LocalRay::major_axis(ray.origin, ray.direction).unwrap_or(3);
                let list = if start_of(ray) < ray.t_max { axis } else { 3 };
                lists[list][lens[list]] = index as u16;
                lens[list] += 1;
            }
            let first = chunk * CHUNK;
            self.axis::<S, 0>(simd, first, &lists[0][..lens[0]], &mut pairs);
            self.axis::<S, 1>(simd, first, &lists[1][..lens[1]], &mut pairs);
            self.axis::<S, 2>(simd, first, &lists[2][..lens[2]], &mut pairs);
            lists[3][..lens[3]].iter().for_each(|&index| (self.finish)(first + index as usize, Hit::MISS, false));
        }
    }

    /// The rays of one axis, by their indices from `first`.
    #[inline(always)]
    fn axis<S: Simd, const AXIS: usize>(&mut self, simd: S, first: usize, list: &[u16], pairs: &mut Pairs) {
        for indices in list.chunks(LANES) {
            let group = self.gather::<AXIS>(first, indices);
            pairs.clear();
            let certain = simd.scan::<AXIS, ANY>(&self.flat.facets, &group, pairs);
            let mut best = Best::new(&group);
            settle::<AXIS>(&self.flat.triangles, &group, pairs.used(), &mut best);
            sphere::spheres::<AXIS>(&self.flat.spheres, &group, &mut best);
            let enter = self.beyond.map_or(0, |beyond| enter::<AXIS>(beyond, &group, best.ends()));
            for (lane, &index) in indices.iter().enumerate() {
                let (order, mut hit) = best.hit(lane);
                hit.id = match order.checked_sub(1) {
                    Some(place) => self.flat.ids[place as usize],
                    None if ANY && certain >> lane & 1 == 1 => self.flat.ids[0],
                    None => Hit::MISS.id,
                };
                let hit = if hit.is_hit() { hit } else { Hit::MISS };
                (self.finish)(first + index as usize, hit, enter >> lane & 1 == 1);
            }
        }
    }

    #[inline(always)]
    fn gather<const AXIS: usize>(&self, first: usize, indices: &[u16]) -> Group {
        let mut group = Group::EMPTY;
        for (lane, &index) in indices.iter().enumerate() {
            let ray = &self.rays[first + index as usize];
            for place in 0..3 {
                group.origin[place][lane] = ray.origin[(AXIS + 1 + place) % 3];
                group.direction[place][lane] = ray.direction[(AXIS + 1 + place) % 3];
            }
            (group.t_min[lane], group.t_max[lane]) = (start_of(ray), ray.t_max);
            (group.mask[lane], group.skip[lane]) = (ray.mask, self.flat.order_of(ray.skip));
        }
        for lane in 0..LANES {
            let rate = group.direction[2][lane];
            group.shear[0][lane] = group.direction[0][lane] / rate;
            group.shear[1][lane] = group.direction[1][lane] / rate;
            group.shear[2][lane] = 1.0 / rate;
            let [x, y, z] = [0, 1, 2].map(|place: usize| group.origin[place][lane].abs());
            group.reach[lane] = greatest(greatest(x, y), z) * SPREAD;
            let [x, y, z] = [0, 1, 2].map(|place: usize| group.direction[place][lane].abs());
            group.length[lane] = x + y + z;
        }
        group
    }
}

/// A bit for every ray of a group that enters one of the padded boxes in its range, which ends at `ends`: the test of
/// [`crate::padding::SlabRay`].
#[inline(always)]
fn enter<const AXIS: usize>(beyond: Beyond<'_>, rays: &Group, ends: &[f32; LANES]) -> u32 {
    let mut pad = [0.0_f32; LANES];
    for (i, pad) in pad.iter_mut().enumerate() {
        let reach = greatest(greatest(rays.origin[0][i].abs(), rays.origin[1][i].abs()), rays.origin[2][i].abs());
        *pad = beyond.padding.at(reach);
    }
    let zero = [[0.0_f32; LANES]; 3];
    let (mut rate, mut near, mut far) = (zero, zero, zero);
    for place in 0..3 {
        for i in 0..LANES {
            let (o, d, z) = (rays.origin[place][i], rays.direction[place][i], rays.direction[2][i]);
            let forward = pad[i].copysign(d);
            rate[place][i] = 1.0 / greatest(d.abs(), z.abs() * FLATTEST).copysign(d);
            near[place][i] = (o + forward) * rate[place][i];
            far[place][i] = (o - forward) * rate[place][i];
        }
    }
    let mut entered = [0_u32; LANES];
    for bounds in beyond.boxes {
        let (mut enter, mut exit) = (rays.t_min, *ends);
        for place in 0..3 {
            let axis = (AXIS + 1 + place) % 3;
            let (low, high) = (bounds.min[axis], bounds.max[axis]);
            for i in 0..LANES {
                let backward = rate[place][i] < 0.0;
                let (first, last) = (if backward { high } else { low }, if backward { low } else { high });
                enter[i] = greatest(first * rate[place][i] - near[place][i], enter[i]);
                exit[i] = least(last * rate[place][i] - far[place][i], exit[i]);
            }
        }
        for i in 0..LANES {
            entered[i] |= u32::from(enter[i] <= exit[i]);
        }
    }
    entered.iter().enumerate().map(|(i, bit)| bit << i).sum()
}
