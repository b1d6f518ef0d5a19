//! Triangles so large that most rays would meet them anyway: walls, floors, the ground. Left among the others their boxes cover
//! everything and are entered by every ray. Set apart, they are tested first, sixteen rays at a time ([`crate::flat`]), and most
//! rays of a room are done with that: what they hit is nearer than all else that is there. The tree holds them all the same,
//! apart from the others, for rays that come alone and whoever asks for more than hits.

use rayon::prelude::*;

use super::Bvh;
use super::node::{Child, LANES};
use super::traverse::Scene;
use crate::bounds::Bounds;
use crate::flat::{self, Beyond, Flat, Flight};
use crate::geometry::World;
use crate::isa::Isa;
use crate::items::{Item, ItemKind, bounds_of};
use crate::ray::Ray;
use crate::search::Found;
use crate::simd::Simd;
use crate::source::Source;

/// Triangles are large if the areas of their boxes are this share of that of the box around everything, or more.
const SHARES: [f32; 4] = [1.0 / 32.0, 1.0 / 16.0, 1.0 / 8.0, 1.0 / 4.0];

/// Of as many triangles as make a flat world, at most this part is set apart.
const PART: usize = 4;

/// They must have this share of the areas of all boxes: where everything is large, the others are no easier without them.
const LEAST_OF_ALL: f64 = 0.25;

/// The large triangles, where the tree has any apart.
#[derive(Debug)]
pub(super) struct Large {
    pub flat: Flat,
    /// Around everything else: the boxes of the topmost node of the others, or one.
    pub boxes: Vec<Bounds>,
}

/// Moves large triangles to the front, if that is worth while; how many.
pub(super) fn choose(items: &mut [Item], world: &World, isa: Isa) -> usize {
    let source = Source::Top(world);
    if source.sole_kind().is_some_and(|kind| kind != ItemKind::Triangle) {
        return 0;
    }
    let area = |item: &Item| item.bounds().half_area();
    let least = SHARES[0] * bounds_of(items).half_area();
    let is_large = |item: &Item| area(item) >= least && source.kind(item.id()) == ItemKind::Triangle;
    let parts = items.par_chunks(CHUNK).enumerate().map(|(chunk, items)| {
        let large = items.iter().enumerate().filter(|(_, item)| is_large(item));
        let large: Vec<(usize, f32)> = large.map(|(i, item)| (chunk * CHUNK + i, area(item))).collect();
        (large, items.iter().map(|item| f64::from(area(item))).sum::<f64>())
    });
    let parts: Vec<(Vec<(usize, f32)>, f64)> = parts.collect();
    let all: f64 = parts.iter().map(|(_, sum)| sum).sum();
    let candidates: Vec<(usize, f32)> = parts.into_iter().flat_map(|(large, _)| large).collect();
    for share in SHARES.map(|share| share / SHARES[0]) {
        let large = candidates.iter().filter(|(_, area)| *area >= share * least);
        if large.clone().count() > flat::most(isa) / PART {
            continue;
        }
        let theirs: f64 = large.clone().map(|(_, area)| f64::from(*area)).sum();
        if theirs < LEAST_OF_ALL * all {
            return 0;
        }
        let places: Vec<usize> = large.map(|(place, _)| *place).collect();
        places.iter().enumerate().for_each(|(to, &from)| items.swap(to, from));
        return places.len();
    }
    0
}

/// Items that a thread looks at in one go.
const CHUNK: usize = 1 << 14;

/// Says of a place that it is in the list of large triangles.
const LISTED: u32 = 1 << 31;

/// What is left of rays that have met the large triangles.
#[derive(Debug, Default)]
pub(super) struct Remains {
    /// Rays that go on, up to what they have hit.
    pub rays: Vec<Ray>,
    /// The index of each, and what it has hit.
    pub found: Vec<(u32, Found)>,
}

impl Remains {
    /// Tests rays with the large triangles. Those that can hit nothing else are finished.
    #[inline(always)]
    pub fn fill<S: Simd, const ANY: bool>(
        &mut self,
        simd: S,
        (scene, large): (&Scene<'_>, &Large),
        rays: &[Ray],
        finish: &mut impl FnMut(usize, Found),
    ) {
        let Self { rays: remaining, found: before } = self;
        remaining.clear();
        before.clear();
        let beyond = Some(Beyond { boxes: &large.boxes, padding: scene.bvh.top.padding });
        let finish = |index: usize, found: Found, enters: bool| {
            let (hit, found) = (found.hit, Found { place: LISTED | found.place, ..found });
            if !enters || ANY && hit.is_hit() {
                finish(index, found);
                return;
            }
            let ray = rays[index];
            // Up to the hit and no further: what is equally far may have a smaller id.
            let t_max = if hit.is_hit() { hit.t.next_up() } else { ray.t_max };
            remaining.push(Ray { t_max, ..ray });
            before.push((index as u32, found));
        };
        Flight::<_, ANY> { flat: &large.flat, rays, beyond, finish }.run(simd);
    }

    /// The index and the best hit of the ray at a place among the remaining ones, of which the tree has found another.
    #[inline(always)]
    pub fn best(&self, place: usize, other: Found) -> (usize, Found) {
        let (index, found) = self.found[place];
        let (this, that) = (&found.hit, &other.hit);
        let is_nearer = that.t < this.t || (that.t == this.t && that.id < this.id);
        (index as usize, if is_nearer { other } else { found })
    }
}

impl Bvh {
    /// The corners of the triangle at a place.
    #[inline(always)]
    pub fn corners(&self, place: u32) -> Option<[[f32; 3]; 3]> {
        match place & LISTED {
            0 => Some(self.arrays.packs.get(place as usize / LANES)?.get(place as usize % LANES)),
            _ => self.large.as_ref()?.flat.corners(place ^ LISTED),
        }
    }

    /// The boxes around all but the large triangles, as they are in the tree.
    pub(super) fn boxes_of_others(&self) -> Vec<Bounds> {
        match (self.top.others.map(Child::of), self.arrays.nodes.get(self.top_start.nodes)) {
            (Some(Child::Node(index)), _) => self.node(index).used().map(|(bounds, _)| bounds).collect(),
            (Some(leaf), Some(root)) => {
                root.used().filter(|(_, word)| *word == leaf.word()).map(|(bounds, _)| bounds).collect()
            }
            _ => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::items;
    use crate::{Geometry, Instance, Place, PrimitiveId, TriangleMesh};

    fn mesh(triangles: impl Iterator<Item = [[f32; 3]; 3]>) -> Geometry {
        let positions: Vec<[f32; 3]> = triangles.flatten().collect();
        let indices: Vec<[u32; 3]> = (0..positions.len() as u32 / 3).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Geometry::Triangles(TriangleMesh { positions: positions.into(), indices: indices.into() })
    }

    /// So many triangles, a little above one another.
    fn stack(count: usize, size: f32) -> Geometry {
        mesh((0..count).map(|i| {
            let z = i as f32 / count as f32;
            [[0.0, 0.0, z], [size, 0.0, z], [0.0, size, z]]
        }))
    }

    fn chosen(geometries: Vec<Geometry>) -> Vec<PrimitiveId> {
        let instances =
            (0..geometries.len() as u32).map(|geometry| Instance { geometry, place: Place::World, mask: 1 });
        let world = World { instances: instances.collect(), geometries };
        let mut items = items::of_top(&world, &items::object_bounds(&world)).unwrap();
        let before = items.len();
        let count = choose(&mut items, &world, Isa::Avx512);
        let mut all: Vec<PrimitiveId> = items.iter().map(Item::id).collect();
        let mut first = all[..count].to_vec();
        all.sort_unstable();
        all.dedup();
        assert_eq!(all.len(), before, "each is there once");
        first.sort_unstable();
        first
    }

    #[test]
    fn walls_are_chosen_and_crowds_are_not() {
        let ids = |instance, count| (0..count).map(|primitive| PrimitiveId { instance, primitive }).collect::<Vec<_>>();
        assert_eq!(chosen(vec![stack(1000, 0.1), stack(2, 10.0), stack(3, 9.0)]), [ids(1, 2), ids(2, 3)].concat());
        // The largest where there are many that are rather large.
        assert_eq!(chosen(vec![stack(200, 3.0), stack(8, 10.0)]), ids(1, 8));
        // None where all are.
        assert_eq!(chosen(vec![stack(5000, 10.0)]), []);
        // None where small ones have most of the area.
        assert_eq!(chosen(vec![stack(100_000, 0.3), stack(4, 10.0)]), []);
    }
}
