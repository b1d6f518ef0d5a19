//! The curves of the original: open edges, borders of materials, seams and creases, as paths that can be followed.

use etendue_accel::{ClosestPoint, ClosestPoints, Isa, TriangleMesh};

use crate::SimplifyError;
use crate::polish::Grouped;
use crate::surface::{dot, is_in_reach, sub};

/// A point.
type Point = [f64; 3];

/// A path is followed over so many edges.
const MOST: usize = 1 << 14;

/// Of the length of an edge: how far its ends may be from a curve that it stands for, and how long the curve may be between them.
const BESIDE: f64 = 0.1;
const LONGER: f64 = 2.0;

/// A place is an end of its edge within this part of it.
const AT_END: f64 = 1e-6;

/// Edges of the original that curves are made of.
pub(crate) struct Curves {
    places: Vec<Point>,
    /// Each edge's ends.
    edges: Vec<[u32; 2]>,
    /// The edges at each place.
    at: Grouped,
    /// The edges as faces without area.
    search: ClosestPoints,
}

/// A place on a curve.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Foot {
    edge: u32,
    /// Part of the edge, from its first end.
    along: f64,
    pub place: Point,
    pub distance_squared: f64,
}

impl Curves {
    /// Of edges between vertices of a mesh; `None` if there are none.
    pub fn of(positions: &[[f32; 3]], edges: &[[u32; 2]]) -> Result<Option<Self>, SimplifyError> {
        let is_fine = |edge: &&[u32; 2]| edge.iter().all(|&v| is_in_reach(positions[v as usize]));
        let mut edges: Vec<[u32; 2]> = edges.iter().filter(is_fine).copied().collect();
        if edges.is_empty() {
            return Ok(None);
        }
        let mut used = edges.as_flattened().to_vec();
        used.sort_unstable();
        used.dedup();
        for v in edges.as_flattened_mut() {
            *v = used.partition_point(|u| u < v) as u32;
        }
        let places: Vec<[f32; 3]> = used.iter().map(|&v| positions[v as usize]).collect();
        let indices = edges.iter().map(|&[a, b]| [a, b, b]).collect();
        let search =
            ClosestPoints::build(&TriangleMesh { positions: places.as_slice().into(), indices }, Isa::detect())?;
        let places: Vec<Point> = places.iter().map(|p| p.map(f64::from)).collect();
        Ok(Some(Self { at: Grouped::new(places.len(), &edges), places, edges, search }))
    }

    /// What of the curves is nearest to points; `None` where nothing is.
    pub fn feet<const N: usize>(&self, points: [Point; N]) -> [Option<Foot>; N] {
        let mut found = [ClosestPoint::NONE; N];
        self.search.closest(&points, f64::INFINITY, &mut found);
        found.map(|found| {
            if !found.is_found() {
                return None;
            }
            let along = match found.weights[0] + found.weights[1] {
                along if along < AT_END => 0.0,
                along if along > 1.0 - AT_END => 1.0,
                along => along,
            };
            let place = self.place(found.face, along);
            Some(Foot { edge: found.face, along, place, distance_squared: found.distance_squared })
        })
    }

    fn place(&self, edge: u32, along: f64) -> Point {
        let [a, b] = self.edges[edge as usize].map(|v| self.places[v as usize]);
        [0, 1, 2].map(|axis| (1.0 - along) * a[axis] + along * b[axis])
    }

    /// True if a curve runs along an edge from one point to another.
    pub fn join(&self, ends: [Point; 2]) -> bool {
        let [Some(from), Some(to)] = self.feet(ends) else { return false };
        let edge = sub(ends[1], ends[0]);
        let squared = dot(edge, edge);
        let is_beside = |foot: &Foot| foot.distance_squared <= BESIDE * BESIDE * squared;
        if !is_beside(&from) || !is_beside(&to) {
            return false;
        }
        let most = LONGER * squared.sqrt();
        // From either: a path ends where curves meet.
        [[&from, &to], [&to, &from]]
            .into_iter()
            .any(|[from, to]| [false, true].into_iter().any(|forth| self.walk(from, forth, &[to], most).is_some()))
    }

    /// The curve from one place over another to a third, and which of its points is the second.
    pub fn stretch(&self, from: &Foot, over: &Foot, to: &Foot, most: f64) -> Option<(Vec<Point>, usize)> {
        let (one, mut back) = self.walk(over, false, &[from, to], most)?;
        let (other, mut forth) = self.walk(over, true, &[from, to], most)?;
        if one == other {
            return None;
        }
        if one == 1 {
            std::mem::swap(&mut back, &mut forth);
        }
        back.reverse();
        let middle = back.len() - 1;
        back.extend(&forth[1..]);
        Some((back, middle))
    }

    /// The points from one place along its curve, in the sense of its edge or against it, to the first of some others, and which that
    /// is; `None` if it meets other curves or ends before, is longer than `most`, or comes back.
    fn walk(&self, from: &Foot, forth: bool, targets: &[&Foot], most: f64) -> Option<(usize, Vec<Point>)> {
        let mut points = vec![from.place];
        let mut length = 0.0;
        let mut edge = from.edge;
        let mut is_forth = forth;
        // How far along its edge, in the sense of the walk, a place is.
        let reach = |along: f64, is_forth: bool| if is_forth { along } else { 1.0 - along };
        let mut after = reach(from.along, forth);
        for _ in 0..MOST {
            let ahead = |foot: &Foot| reach(foot.along, is_forth);
            let first = (0..targets.len())
                .filter(|&i| targets[i].edge == edge && ahead(targets[i]) > after)
                .min_by(|&i, &j| ahead(targets[i]).total_cmp(&ahead(targets[j])));
            let end = self.edges[edge as usize][usize::from(is_forth)];
            let place = self.places[end as usize];
            let is_there =
                |i: &usize| targets[*i].place == place && self.edges[targets[*i].edge as usize].contains(&end);
            let found = first.or_else(|| (0..targets.len()).find(is_there).filter(|_| points[0] != place));
            let next = found.map_or(place, |i| targets[i].place);
            let step = sub(next, points[points.len() - 1]);
            length += dot(step, step).sqrt();
            if length > most {
                return None;
            }
            points.push(next);
            if let Some(found) = found {
                return Some((found, points));
            }
            let [a, b] = *self.at.of(end) else { return None };
            edge = if a == edge { b } else { a };
            if edge == from.edge {
                return None;
            }
            is_forth = self.edges[edge as usize][0] == end;
            // A place at the very start of an edge was met with the end of the one before.
            after = 0.0;
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A zigzag along x with a branch at its fourth vertex.
    fn zigzag() -> Curves {
        let mut positions: Vec<[f32; 3]> = (0..8).map(|i| [i as f32, (i % 2) as f32 * 0.1, 0.0]).collect();
        positions.push([3.0, 5.0, 0.0]);
        let mut edges: Vec<[u32; 2]> = (0..7).map(|i| if i % 3 == 0 { [i + 1, i] } else { [i, i + 1] }).collect();
        edges.push([3, 8]);
        Curves::of(&positions, &edges).unwrap().unwrap()
    }

    #[test]
    fn curves_are_followed_to_where_they_meet() {
        let curves = zigzag();
        let foot = |x: f64| curves.feet([[x, 0.05, 0.0]])[0].unwrap();
        let (points, middle) = curves.stretch(&foot(3.5), &foot(4.6), &foot(6.5), 9.0).unwrap();
        assert_eq!((points.len(), middle), (6, 2));
        assert!(points.windows(2).all(|pair| pair[0][0] < pair[1][0]), "{points:?}");
        let (points, middle) = curves.stretch(&foot(6.5), &foot(4.6), &foot(3.5), 9.0).unwrap();
        assert_eq!((points.len(), middle), (6, 3));
        assert!(points.windows(2).all(|pair| pair[0][0] > pair[1][0]), "{points:?}");
        assert!(curves.stretch(&foot(2.5), &foot(4.6), &foot(6.5), 9.0).is_none(), "over a branch");
        assert!(curves.stretch(&foot(3.5), &foot(4.6), &foot(6.5), 1.0).is_none(), "too long");
        assert!(curves.stretch(&foot(4.2), &foot(4.6), &foot(4.9), 9.0).is_some(), "on one edge");
        assert!(curves.stretch(&foot(4.2), &foot(4.1), &foot(4.9), 9.0).is_none(), "both ahead");
    }

    #[test]
    fn edges_along_curves_are_known() {
        let curves = zigzag();
        for (ends, joined) in [
            ([[4.1, 0.0, 0.0], [6.3, 0.1, 0.0]], true),
            ([[6.3, 0.1, 0.0], [4.1, 0.0, 0.0]], true),
            // To where a branch begins, and beyond.
            ([[3.0, 0.1, 0.0], [6.0, 0.0, 0.0]], true),
            ([[6.0, 0.0, 0.0], [3.0, 0.1, 0.0]], true),
            ([[2.0, 0.0, 0.0], [6.0, 0.0, 0.0]], false),
            // Across, and beside.
            ([[3.0, 3.0, 0.0], [6.0, 0.0, 0.0]], false),
            ([[4.1, 1.0, 0.0], [6.3, 1.0, 0.0]], false),
        ] {
            assert_eq!(curves.join(ends), joined, "{ends:?}");
        }
    }
}
