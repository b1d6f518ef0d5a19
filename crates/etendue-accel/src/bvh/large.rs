//! Triangles so large that most rays would meet them anyway: walls, floors, the ground. Left among the others their boxes cover
//! everything and are entered by every ray. Set apart, they are tested first, sixteen rays at a time ([`crate::flat`]), and most
//! rays of a room are done with that: what they hit is nearer than all else that is there. The tree holds them all the same,
//! apart from the others, for rays that come alone and whoever asks for more than hits.

use rayon::prelude::*;

use super::Bvh;
use super::node::WIDTH;
use super::traverse::Scene;
use crate::bounds::Bounds;
use crate::error::BuildError;
use crate::flat::{self, Box16, Flat, Flight};
use crate::geometry::World;
use crate::isa::Isa;
use crate::items::{Item, ItemKind, bounds_of};
use crate::ray::{Hit, Ray};
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
    /// Around everything else.
    pub bounds: Bounds,
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

impl Large {
    /// Of items of which so many have been moved to the front, and some others are left.
    pub fn new(world: &World, items: &[Item], count: usize) -> Result<Self, BuildError> {
        let (large, others) = items.split_at(count);
        Ok(Self { flat: Flat::of_triangles(world, large)?, bounds: bounds_of(others) })
    }
}

/// What is left of rays that have met the large triangles.
#[derive(Debug, Default)]
pub(super) struct Remains {
    /// Rays that go on, up to what they have hit.
    pub rays: Vec<Ray>,
    /// The index of each, and what it has hit.
    pub found: Vec<(u32, Hit)>,
}

impl Remains {
    /// Tests rays with the large triangles. Those that can hit nothing else are finished.
    #[inline(always)]
    pub fn fill<S: Simd, const ANY: bool>(
        &mut self,
        simd: S,
        (scene, large): (&Scene<'_>, &Large),
        rays: &[Ray],
        finish: &mut impl FnMut(usize, Hit),
    ) {
        let Self { rays: remaining, found } = self;
        remaining.clear();
        found.clear();
        let beyond = Some(Box16 { bounds: large.bounds, padding: scene.bvh.top.padding });
        let finish = |index: usize, hit: Hit, enters: bool| {
            if !enters || ANY && hit.is_hit() {
                finish(index, hit);
                return;
            }
            let ray = rays[index];
            // Up to the hit and no further: what is equally far may have a smaller id.
            let t_max = if hit.is_hit() { hit.t.next_up() } else { ray.t_max };
            remaining.push(Ray { t_max, ..ray });
            found.push((index as u32, hit));
        };
        Flight::<_, ANY> { flat: &large.flat, rays, beyond, finish }.run(simd);
    }

    /// The index and the best hit of the ray at a place among the remaining ones, of which the tree has found another.
    #[inline(always)]
    pub fn best(&self, place: usize, other: Hit) -> (usize, Hit) {
        let (index, hit) = self.found[place];
        let is_nearer = other.t < hit.t || (other.t == hit.t && other.id < hit.id);
        (index as usize, if is_nearer { other } else { hit })
    }
}

impl Bvh {
    /// The box around all but the large triangles, after the boxes of the tree have changed.
    pub(super) fn bounds_of_others(&self) -> Option<Bounds> {
        self.top.others?;
        let root = self.arrays.nodes.get(self.top_start.nodes)?;
        let row = |row: usize| root.rows[row][1 % WIDTH];
        Some(Bounds { min: [row(0), row(2), row(4)], max: [row(1), row(3), row(5)] })
    }
}
