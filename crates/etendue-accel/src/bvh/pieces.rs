//! Triangles whose boxes are large beside them, put into the tree in pieces: needles, beams, railings that run askew. Their
//! boxes hold little of them and overlap each other however they are grouped. The box of a piece is smaller, the triangle in it
//! the same: it is tested where any of its boxes is entered, twice without harm.
//!
//! (Ernst and Greiner, "Early Split Clipping for Bounding Volume Hierarchies", 2007; shared out by what boxes have to lose as
//! in Karras and Aila, "Fast Parallel Construction of High-Quality Bounding Volume Hierarchies", 2013.) A diagonal cut in k has
//! boxes of a k-th of the area together, so one more saves A / k^2, and the most is saved with k in proportion to the root of
//! A, the area of the box less what infinitely many pieces would have.

use rayon::prelude::*;

use crate::bounds::Bounds;
use crate::clip::Polygon;
use crate::error::BuildError;
use crate::items::{Item, ItemKind};
use crate::source::Source;

/// Where a line through everything enters fewer boxes than this on average, nothing is cut, and no triangle looked at: scans,
/// with their small even triangles, have some five.
const DEEP: f64 = 8.0;

/// Pieces whose boxes could lose less than this many times an even share of the area of the box around everything are not cut.
const LEAST: f32 = 16.0;

/// Nothing is cut unless all boxes together lose this share of their areas.
const WORTH: f64 = 0.125;

/// Most pieces of a triangle.
const MOST: f32 = 32.0;

const _: () = assert!(MOST as usize <= Polygon::CUTS, "as many cuts in succession as their proof allows");

/// Most additional pieces for each item,
const EXTRA: usize = 3;

/// as long as they are no more than this in all (64 MB of the tree); beyond that half as many as items.
const EXTRA_IN_ALL: usize = 1 << 20;

/// Items or triangles that a thread looks at in one go.
const CHUNK: usize = 1 << 12;

/// A triangle that may be cut.
#[derive(Clone, Copy)]
struct Candidate {
    item: u32,
    /// The root of what its box has to lose.
    weight: f32,
}

impl Candidate {
    /// How many pieces, if a piece with this weight is not cut.
    #[inline(always)]
    fn pieces(&self, limit: f32) -> usize {
        let pieces = self.weight / limit;
        (if pieces < MOST { pieces } else { MOST }) as usize
    }

    #[inline(always)]
    fn extra(&self, limit: f32) -> usize {
        self.pieces(limit).saturating_sub(1)
    }
}

/// Replaces triangles behind the first few items by pieces where that is worth while. Their boxes lie within the old ones.
pub(super) fn cut(items: &mut Vec<Item>, apart: usize, source: Source<'_>) -> Result<(), BuildError> {
    let others = &items[apart..];
    let (bounds, all) = measured(others);
    let world = bounds.half_area();
    if all.is_nan() || all < DEEP * f64::from(world) {
        return Ok(());
    }
    let least = LEAST * (world / others.len() as f32);
    let candidates = candidates(others, apart, source, least);
    let places = (u32::MAX >> 1) as usize;
    let most = (EXTRA * others.len()).min(EXTRA_IN_ALL).max(others.len() / 2).min(places.saturating_sub(items.len()));
    let limit = limit(&candidates, most, (least, world));
    if saved(&candidates, limit) < WORTH * all {
        return Ok(());
    }
    let extra = candidates.iter().map(|candidate| candidate.extra(limit)).sum::<usize>();
    let bytes = (extra * size_of::<Item>()) as u64;
    items.try_reserve_exact(extra).map_err(|_| BuildError::Memory { what: "pieces", bytes })?;
    let whole = &*items;
    let parts: Vec<Pieces> = candidates.par_chunks(CHUNK).map(|part| Pieces::of(part, whole, source, limit)).collect();
    for Pieces { firsts, others } in parts {
        firsts.into_iter().for_each(|(place, item)| items[place as usize] = item);
        items.extend(others);
    }
    Ok(())
}

/// The pieces of some candidates.
#[derive(Default)]
struct Pieces {
    /// One of each triangle with the place of its item.
    firsts: Vec<(u32, Item)>,
    others: Vec<Item>,
}

impl Pieces {
    fn of(candidates: &[Candidate], items: &[Item], source: Source<'_>, limit: f32) -> Self {
        let mut pieces = Self::default();
        for candidate in candidates.iter().filter(|candidate| candidate.extra(limit) > 0) {
            let item = &items[candidate.item as usize];
            let Some(corners) = source.triangle(item.id()) else { continue };
            let (whole, start) = (item.bounds(), pieces.others.len());
            divide(&Polygon::of(&corners), candidate.pieces(limit), &mut |part| {
                pieces.others.push(Item::new(&part.bounds(&whole), item.id()));
            });
            pieces.firsts.push((candidate.item, pieces.others.swap_remove(start)));
        }
        pieces
    }
}

/// Cuts a part of a triangle in so many pieces, or fewer if it cannot be cut, each in the middle of its box's longest side.
fn divide(polygon: &Polygon, pieces: usize, found: &mut impl FnMut(&Polygon)) {
    let [x, y, z] = polygon.sides();
    let axis = if x >= y && x >= z { 0 } else { 1 + usize::from(z > y) };
    let parts = if pieces > 1 { polygon.cut(axis, polygon.middle(axis)) } else { None };
    let Some([below, above]) = parts else { return found(polygon) };
    let root = |part: &Polygon| {
        let [x, y, z] = part.sides();
        (x * y + y * z + z * x).sqrt()
    };
    let (first, second) = (root(&below), root(&above));
    let share = (pieces as f64 * (first / (first + second)) + 0.5) as usize;
    let share = share.clamp(1, pieces - 1);
    divide(&below, share, found);
    divide(&above, pieces - share, found);
}

/// The box around items, and the half areas of their boxes together.
fn measured(items: &[Item]) -> (Bounds, f64) {
    let of_chunk = |items: &[Item]| {
        items.iter().fold((Bounds::EMPTY, 0.0), |(around, all), item| {
            let bounds = item.bounds();
            (around.join(&bounds), all + f64::from(bounds.half_area()))
        })
    };
    let parts: Vec<(Bounds, f64)> = items.par_chunks(CHUNK).map(of_chunk).collect();
    parts.iter().fold((Bounds::EMPTY, 0.0), |(around, all), (bounds, area)| (around.join(bounds), all + area))
}

/// The triangles whose boxes have at least so much to lose.
fn candidates(others: &[Item], apart: usize, source: Source<'_>, least: f32) -> Vec<Candidate> {
    let of_chunk = |(chunk, items): (usize, &[Item])| {
        let candidate = |(place, item): (usize, &Item)| {
            let area = item.bounds().half_area();
            if area.is_nan() || area <= least || source.kind(item.id()) != ItemKind::Triangle {
                return None;
            }
            let excess = area - least_area(&source.triangle(item.id())?);
            let item = (apart + chunk * CHUNK + place) as u32;
            (excess > least).then(|| Candidate { item, weight: excess.sqrt() })
        };
        items.iter().enumerate().filter_map(candidate).collect::<Vec<_>>()
    };
    let parts: Vec<Vec<Candidate>> = others.par_chunks(CHUNK).enumerate().map(of_chunk).collect();
    parts.concat()
}

/// The half areas of boxes around infinitely many pieces together: those of the triangle's shadows along the axes.
fn least_area([a, b, c]: &[[f32; 3]; 3]) -> f32 {
    let (e, f): ([f64; 3], [f64; 3]) = (
        std::array::from_fn(|i| f64::from(b[i]) - f64::from(a[i])),
        std::array::from_fn(|i| f64::from(c[i]) - f64::from(a[i])),
    );
    let shadow = |i: usize, j: usize| (e[i] * f[j] - e[j] * f[i]).abs();
    (0.5 * (shadow(1, 2) + shadow(2, 0) + shadow(0, 1))) as f32
}

/// The weight below which pieces are not cut: no less than the root of the one area, and such that there are at most so many
/// more.
fn limit(candidates: &[Candidate], most: usize, (least, world): (f32, f32)) -> f32 {
    let extra = |limit: f32| {
        let parts = candidates.par_chunks(CHUNK);
        parts.map(|part| part.iter().map(|candidate| candidate.extra(limit)).sum::<usize>()).sum::<usize>()
    };
    // No triangle has the weight of the world, so nothing would be cut.
    let (mut low, mut high) = (least.sqrt(), 2.0 * world.sqrt());
    if extra(low) <= most {
        return low;
    }
    for _ in 0..20 {
        let middle = 0.5 * (low + high);
        if extra(middle) <= most {
            high = middle;
        } else {
            low = middle;
        }
    }
    high
}

/// The half areas that boxes will lose, about.
fn saved(candidates: &[Candidate], limit: f32) -> f64 {
    let of = |candidate: &Candidate| {
        let pieces = candidate.pieces(limit).max(1) as f64;
        f64::from(candidate.weight) * f64::from(candidate.weight) * (1.0 - 1.0 / pieces)
    };
    candidates.iter().map(of).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::{Geometry, TriangleMesh};
    use crate::items;
    use crate::random::Random;

    fn plus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
        std::array::from_fn(|i| a[i] + b[i])
    }

    /// Triangles of a length and a width at random places.
    fn needles(count: u32, length: f32, width: f32) -> Geometry {
        let mut random = Random(3);
        let mut positions = Vec::new();
        for _ in 0..count {
            let (p, along) = (random.point(1.0), random.point(length));
            positions.extend([p, plus(p, along), plus(plus(p, along), random.point(width))]);
        }
        let indices: Vec<[u32; 3]> = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Geometry::Triangles(TriangleMesh { positions: positions.into(), indices: indices.into() })
    }

    fn cut_up(geometry: &Geometry, apart: usize) -> Vec<Item> {
        let mut items = items::of_geometry(geometry).unwrap();
        cut(&mut items, apart, Source::Geometry(geometry)).unwrap();
        items
    }

    #[test]
    fn needles_are_cut_and_scans_are_not() {
        let (count, needles, small) = (4000, needles(4000, 1.5, 0.01), needles(4000, 0.01, 0.01));
        let pieces = cut_up(&needles, 1000);
        assert!((count * 5 / 4..=4 * count).contains(&pieces.len()), "{}", pieces.len());
        assert_eq!(cut_up(&small, 0).len(), count);
        let whole = items::of_geometry(&needles).unwrap();
        assert!(pieces[..1000].iter().zip(&whole).all(|(a, b)| a.lanes == b.lanes), "what is apart stays");
        assert!(pieces[count..].iter().all(|piece| piece.id().primitive >= 1000));
        let holds = |piece: &Item, whole: &Item| whole.bounds().join(&piece.bounds()) == whole.bounds();
        assert!(pieces.iter().all(|piece| holds(piece, &whole[piece.id().primitive as usize])));
    }

    #[test]
    fn no_more_pieces_than_there_may_be() {
        let mut random = Random(5);
        let candidates: Vec<Candidate> = (0..20_000).map(|item| Candidate { item, weight: random.unit() }).collect();
        for most in [0, 1, 1000, 10_000, 30_000, 60_000, 10_000_000] {
            let limit = limit(&candidates, most, (1e-6, 1.0));
            let extra = candidates.iter().map(|candidate| candidate.extra(limit)).sum::<usize>();
            assert!(extra <= most && extra >= most.min(60_000) * 9 / 10, "{most}: {extra}");
        }
    }

    /// Thin ones, wide ones, some without area, near and far from the origin.
    #[test]
    fn pieces_cover_their_triangles() {
        let mut random = Random(7);
        for turn in 0..20_000 {
            let size = [1.0, 1e-38, 1e12, 1e-3][turn % 4];
            let place = random.point(size * [0.0, 1.0, 1e3, 1e6][turn / 4 % 4]);
            let (a, b) = (plus(place, random.point(size)), plus(place, random.point(size)));
            let c = match turn % 5 {
                0 => plus(place, random.point(size)),
                1 => b,
                2 => plus(b, random.point(1e-4 * size)),
                3 => std::array::from_fn(|i| 0.5 * (a[i] + b[i])),
                _ => plus(std::array::from_fn(|i| 0.5 * (a[i] + b[i])), random.point(1e-7 * size)),
            };
            let (corners, pieces) = ([a, b, c], 2 + turn % 31);
            let (whole, mut parts) = (Bounds::of_points(corners), Vec::new());
            divide(&Polygon::of(&corners), pieces, &mut |part| parts.push(part.bounds(&whole)));
            assert!(parts.len() <= pieces && parts.iter().all(|part| whole.join(part) == whole));
            let [a, b, c] = corners.map(|corner| corner.map(f64::from));
            for (i, j) in (0..=8).flat_map(|i| (0..=8 - i).map(move |j| (i, j))) {
                let (v, w) = (f64::from(i) / 8.0, f64::from(j) / 8.0);
                let p: [f64; 3] = std::array::from_fn(|x| (1.0 - v - w) * a[x] + v * b[x] + w * c[x]);
                let holds = |part: &Bounds| {
                    // Less what the point itself is rounded by.
                    let tiny = f64::from(whole.reach()) * 1e-15;
                    (0..3).all(|x| f64::from(part.min[x]) - tiny <= p[x] && p[x] <= f64::from(part.max[x]) + tiny)
                };
                assert!(parts.iter().any(holds), "{turn}: {p:?} {corners:?}");
            }
        }
    }
}
