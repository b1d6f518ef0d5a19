//! What one ray is looking for and the best it has found: all accelerators offer primitives here.

use crate::bvh::node::{LANES, Pack};
use crate::geometry::Sphere;
use crate::local_ray::LocalRay;
use crate::ray::{Hit, PrimitiveId, Ray};
use crate::triangle::Crossings;
use crate::{sphere, triangle};

/// The state of a search. Its result does not depend on the order of the offers: the smallest (t, instance, primitive)
/// wins.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Search {
    pub t_min: f32,
    t_max: f32,
    pub mask: u32,
    pub time: f32,
    skip: PrimitiveId,
    /// Until something is found, `t` is the end of the range and the id is `NONE`.
    pub best: Hit,
    /// Where its triangle is, see [`Found`].
    place: u32,
}

/// What a search has come to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Found {
    pub hit: Hit,
    /// Where the triangle that is hit is: the number of a pack times [`LANES`] and its lane, or its place in a list; or
    /// [`Found::NOWHERE`].
    pub place: u32,
}

impl Found {
    /// No triangle, or in none of them.
    pub const NOWHERE: u32 = u32::MAX;

    /// Nothing.
    pub const MISS: Self = Self { hit: Hit::MISS, place: Self::NOWHERE };

    /// A hit in no pack.
    #[inline(always)]
    pub fn apart(hit: Hit) -> Self {
        Self { hit, place: Self::NOWHERE }
    }
}

impl Search {
    /// For nothing.
    pub const NONE: Self = Self {
        t_min: 0.0,
        t_max: 0.0,
        mask: 0,
        time: 0.0,
        skip: PrimitiveId::NONE,
        best: Hit::MISS,
        place: Found::NOWHERE,
    };

    /// The search and the ray in world space; `None` if the ray hits nothing by definition.
    #[inline(always)]
    pub fn start(ray: &Ray) -> Option<(Self, LocalRay)> {
        let search = Self::new(ray);
        let in_order = search.t_min < ray.t_max;
        let local = LocalRay::new(ray.origin, ray.direction)?;
        in_order.then_some((search, local))
    }

    /// The search of a ray that may hit something.
    #[inline(always)]
    pub fn new(ray: &Ray) -> Self {
        let best = Hit { t: ray.t_max, ..Hit::MISS };
        Self {
            t_min: Self::first_t(ray),
            t_max: ray.t_max,
            mask: ray.mask,
            time: ray.time,
            skip: ray.skip,
            best,
            place: Found::NOWHERE,
        }
    }

    /// Where a ray's range begins.
    #[inline(always)]
    pub fn first_t(ray: &Ray) -> f32 {
        if ray.t_min < 0.0 { 0.0 } else { ray.t_min }
    }

    /// From where to where something better may be.
    #[inline(always)]
    pub fn range(&self) -> (f32, f32) {
        (self.t_min, self.best.t)
    }

    /// The result.
    #[inline(always)]
    pub fn found(&self) -> Found {
        let hit = if self.best.is_hit() { self.best } else { Hit::MISS };
        Found { hit, place: self.place }
    }

    /// Takes something better.
    #[inline(always)]
    pub fn take(&mut self, found: Found) {
        (self.best, self.place) = (found.hit, found.place);
    }

    /// Tests a triangle. True if it is the best so far.
    #[inline(always)]
    pub fn triangle(&mut self, ray: &LocalRay, vertices: &[[f32; 3]; 3], id: PrimitiveId) -> bool {
        match triangle::intersect(ray, vertices, (self.t_min, self.best.t)) {
            Some((t, edges)) => self.crossing(t, edges, id, Found::NOWHERE),
            None => false,
        }
    }

    /// Takes a triangle at a place that the exact test has decided, NaN for a miss. True if it is the best so far.
    #[inline(always)]
    pub fn crossing(&mut self, t: f32, edges: [f64; 3], id: PrimitiveId, place: u32) -> bool {
        if !(self.is_better(t, id) && id != self.skip) {
            return false;
        }
        let [u, v] = triangle::weights(edges);
        self.take(Found { hit: Hit { t, u, v, id }, place });
        true
    }

    /// The primitive of an instance that is skipped, or a number that none has.
    #[inline(always)]
    pub fn skipped_of(&self, instance: u32) -> u32 {
        if self.skip.instance == instance { self.skip.primitive } else { u32::MAX }
    }

    /// Takes the triangles of a numbered pack that have a bit, which the exact test has decided, where a lane gives an instance. True if
    /// any is the best so far.
    #[inline(always)]
    pub fn pack(
        &mut self,
        (index, pack): (usize, &Pack),
        (mut candidates, crossings): (u32, &Crossings<LANES>),
        instance_of: impl Fn(&Self, usize) -> Option<u32>,
    ) -> bool {
        let mut found = false;
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize % LANES;
            candidates &= candidates - 1;
            if let Some(instance) = instance_of(self, lane) {
                let id = PrimitiveId { instance, primitive: pack.primitive[lane] };
                let [v, w, det] = &crossings.edges;
                let place = (index * LANES + lane) as u32;
                found |= self.crossing(crossings.t[lane], [v[lane], w[lane], det[lane]], id, place);
            }
        }
        found
    }

    /// Tests a sphere. True if it is the best so far.
    #[inline(always)]
    pub fn sphere(&mut self, ray: &LocalRay, sphere: &Sphere, id: PrimitiveId) -> bool {
        let Some([near, far]) = sphere::intersect(ray, sphere) else { return false };
        let offer = |search: &mut Self, t| search.offer(Hit { t, u: 0.0, v: 0.0, id });
        if id == self.skip {
            return sphere::points_inward(ray.origin, ray.direction, sphere) && offer(self, far);
        }
        offer(self, near) || offer(self, far)
    }

    #[inline(always)]
    fn offer(&mut self, hit: Hit) -> bool {
        let better = self.is_better(hit.t, hit.id);
        if better {
            self.take(Found::apart(hit));
        }
        better
    }

    #[inline(always)]
    fn is_better(&self, t: f32, id: PrimitiveId) -> bool {
        let nearer = t < self.best.t || (t == self.best.t && id < self.best.id);
        t > self.t_min && t < self.t_max && nearer
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn id(instance: u32, primitive: u32) -> PrimitiveId {
        PrimitiveId { instance, primitive }
    }

    fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
        Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY, time: 0.0, mask: !0, skip: PrimitiveId::NONE }
    }

    #[test]
    fn ties_go_to_the_smaller_id() {
        let face = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0]];
        let ids = [id(1, 0), id(0, 7), id(0, 9), id(2, 1)];
        for rotation in 0..4 {
            let (mut search, local) = Search::start(&ray([0.0, 0.0, 1.0], [0.0, 0.0, -1.0])).unwrap();
            for i in 0..4 {
                search.triangle(&local, &face, ids[(i + rotation) % 4]);
            }
            assert_eq!(search.found().hit.id, id(0, 7));
        }
    }

    #[test]
    fn the_range_is_exclusive() {
        let face = [[-1.0, -1.0, 0.0], [2.0, -1.0, 0.0], [-1.0, 2.0, 0.0]];
        let base = ray([0.0, 0.0, 1.0], [0.0, 0.0, -1.0]);
        for (t_min, t_max, expected) in [
            (0.0, 1.0, false),
            (1.0, 2.0, false),
            (0.5, 1.0_f32.next_up(), true),
            (-1.0, 2.0, true),
            (-3.0, -1.0, false),
        ] {
            let found = Search::start(&Ray { t_min, t_max, ..base })
                .is_some_and(|(mut search, local)| search.triangle(&local, &face, id(0, 0)));
            assert_eq!(found, expected, "({t_min}, {t_max})");
        }
        assert!(Search::start(&Ray { t_min: f32::NAN, ..base }).is_none());
        assert!(Search::start(&Ray { t_max: f32::NAN, ..base }).is_none());
        assert!(Search::start(&ray([0.0; 3], [0.0; 3])).is_none());
        assert!(Search::start(&ray([0.0, f32::NAN, 0.0], [0.0, 0.0, 1.0])).is_none());
        assert!(Search::start(&ray([0.0; 3], [0.0, f32::INFINITY, 1.0])).is_none());
    }

    #[test]
    fn the_skipped_sphere_shows_its_far_side_inward_only() {
        let ball = Sphere { center: [0.0; 3], radius: 1.0 };
        let try_ray = |origin, direction, skip| {
            let (mut search, local) = Search::start(&Ray { skip, ..ray(origin, direction) }).unwrap();
            search.sphere(&local, &ball, id(3, 4)).then(|| search.found().hit.t)
        };
        let on_top = [0.0, 0.0, 1.000001];
        assert_eq!(try_ray(on_top, [0.0, 0.0, 1.0], id(3, 4)), None);
        assert_eq!(try_ray([0.0, 0.0, 0.999999], [0.0, 0.0, 1.0], id(3, 4)), None, "outward from a point inside");
        assert!(try_ray(on_top, [0.0, 0.0, -1.0], id(3, 4)).unwrap() > 1.9);
        assert!(try_ray(on_top, [0.0, 0.0, -1.0], id(3, 5)).unwrap() < 1e-5);
        assert_eq!(try_ray([0.0; 3], [0.0, 2.0, 0.0], PrimitiveId::NONE), Some(0.5), "from inside");
    }
}
