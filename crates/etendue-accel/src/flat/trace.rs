//! Slices of rays through a list of primitives.

use std::ops::Range;

use super::scan::{Columns, Group, LANES, Pairs};
use super::settle::{Best, settle};
use super::{Flat, sphere};
use crate::bounds::{Bounds, greatest, least};
use crate::isa::SimdKernel;
use crate::padding::{FLATTEST, Padding};
use crate::ray::{Hit, PrimitiveId, Ray};
use crate::search::Found;
use crate::simd::Simd;

/// Searches a world that is nothing but a list for a slice of rays; `finish` gets the index of each ray and what was found.
pub(crate) struct Trace<'a, F, const ANY: bool> {
    pub flat: &'a Flat,
    pub rays: &'a [Ray],
    pub finish: F,
}

impl<F: FnMut(usize, Found), const ANY: bool> SimdKernel for Trace<'_, F, ANY> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let finish = |index, found, _enters| (self.finish)(index, found);
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

/// Sees nothing.
const VOID: Ray =
    Ray { origin: [0.0; 3], t_min: 0.0, direction: [0.0; 3], t_max: 0.0, time: 0.0, mask: 0, skip: PrimitiveId::NONE };

impl<F: FnMut(usize, Found, bool), const ANY: bool> Flight<'_, F, ANY> {
    #[inline(always)]
    pub fn run<S: Simd>(mut self, simd: S) {
        let (mut pairs, mut columns) = (Pairs::new(), Columns::EMPTY);
        for (chunk, rays) in self.rays.chunks(LANES).enumerate() {
            match <&[Ray; LANES]>::try_from(rays) {
                Ok(rays) => simd.transpose(rays, &mut columns),
                Err(_) => {
                    let mut whole = [VOID; LANES];
                    whole[..rays.len()].copy_from_slice(rays);
                    simd.transpose(&whole, &mut columns);
                }
            }
            self.group(simd, chunk * LANES..chunk * LANES + rays.len(), &columns, &mut pairs);
        }
    }

    /// Some rays, by their indices.
    #[inline(always)]
    fn group<S: Simd>(&mut self, simd: S, indices: Range<usize>, columns: &Columns, pairs: &mut Pairs) {
        let mut group = Group::of(columns);
        for (lane, skip) in group.skip.iter_mut().enumerate() {
            let [instance, primitive] = columns.skip.map(|row| row[lane]);
            *skip = self.flat.order_of(PrimitiveId { instance, primitive });
        }
        pairs.clear();
        let certain = simd.scan::<ANY>(&self.flat.facets, &group, pairs);
        let mut best = Best::new(&group);
        settle(simd, &self.flat.triangles, &group, pairs.used(), &mut best);
        sphere::spheres(&self.flat.spheres, &group, &mut best);
        let enter = self.beyond.map_or(0, |beyond| enter(beyond, &group, best.ends()));
        let found = best.hits();
        for (lane, index) in indices.enumerate() {
            let id = match found.orders[lane].checked_sub(1) {
                Some(place) => self.flat.ids[place as usize],
                None if ANY && certain >> lane & 1 == 1 => self.flat.ids[0],
                None => PrimitiveId::NONE,
            };
            let hit = Hit { t: found.t[lane], u: found.u[lane], v: found.v[lane], id };
            let hit = if hit.is_hit() { hit } else { Hit::MISS };
            let found = Found { hit, place: found.orders[lane].wrapping_sub(1) };
            (self.finish)(index, found, enter >> lane & 1 == 1);
        }
    }
}

/// A bit for every ray of a group that enters one of the padded boxes in its range, which ends at `ends`: the test of
/// [`crate::padding::SlabRay`].
#[inline(always)]
fn enter(beyond: Beyond<'_>, rays: &Group, ends: &[f32; LANES]) -> u32 {
    let (mut pad, mut longest) = ([0.0_f32; LANES], [0.0_f32; LANES]);
    for i in 0..LANES {
        let [dx, dy, dz] = rays.direction.each_ref().map(|row| row[i].abs());
        longest[i] = greatest(greatest(dx, dy), dz);
        let reach = greatest(greatest(rays.origin[0][i].abs(), rays.origin[1][i].abs()), rays.origin[2][i].abs());
        pad[i] = beyond.padding.at(reach);
    }
    let zero = [[0.0_f32; LANES]; 3];
    let (mut rate, mut near, mut far) = (zero, zero, zero);
    for place in 0..3 {
        for i in 0..LANES {
            let (o, d, z) = (rays.origin[place][i], rays.direction[place][i], longest[i]);
            let forward = pad[i].copysign(d);
            rate[place][i] = 1.0 / greatest(d.abs(), z * FLATTEST).copysign(d);
            near[place][i] = (o + forward) * rate[place][i];
            far[place][i] = (o - forward) * rate[place][i];
        }
    }
    let mut entered = [0_u32; LANES];
    for bounds in beyond.boxes {
        let (mut enter, mut exit) = (rays.t_min, *ends);
        for place in 0..3 {
            let (low, high) = (bounds.min[place], bounds.max[place]);
            for i in 0..LANES {
                let backward = rate[place][i] < 0.0;
                let (first, last) = (if backward { high } else { low }, if backward { low } else { high });
                enter[i] = greatest(first * rate[place][i] - near[place][i], enter[i]);
                exit[i] = least(last * rate[place][i] - far[place][i], exit[i]);
            }
        }
        for i in 0..LANES {
            entered[i] |= u32::from((enter[i] <= exit[i]) & (rays.mask[i] != 0));
        }
    }
    entered.iter().enumerate().map(|(i, bit)| bit << i).sum()
}
