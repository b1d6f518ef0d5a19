//! The part of the original that is near to some faces.

use etendue_accel::{ClosestPoint, ClosestPoints, Isa, TriangleMesh, closest_on_triangle};
use rayon::prelude::*;

use super::{POINTS, Point, Triangle};
use crate::surface::{dot, is_in_reach, normal};
use crate::{MeshRef, SimplifyError};

/// Cells of the grid that marks what is near, along each axis.
const CELLS: usize = 128;

/// Faces of the original that a thread takes at once.
const PART: usize = 1 << 13;

/// An original face is as near as the nearest if it is at most so many times as far away, or as this part of the longest edge.
const AS_NEAR: f64 = 1.5;
const OF_EDGE: f64 = 0.1;

/// Faces of the original near to some others, ready for closest points.
pub(super) struct Nearby {
    search: ClosestPoints,
    normals: Vec<Point>,
}

/// What a face looks like beside the original.
#[derive(Clone, Copy)]
pub(super) struct Look {
    /// True if one of the nearest original faces looks the other way.
    pub turned: bool,
    /// The largest squared distance of its points.
    pub far: f64,
}

impl Nearby {
    /// What of the original is within a distance of places; `None` if nothing is.
    pub fn of(original: &MeshRef<'_>, places: &[(Point, f64)]) -> Result<Option<Self>, SimplifyError> {
        Self::thinned(original, places, usize::MAX)
    }

    /// The same with at most so many faces, evenly left out in their order: what is large beside them is near to others just as well.
    pub fn thinned(
        original: &MeshRef<'_>,
        places: &[(Point, f64)],
        most: usize,
    ) -> Result<Option<Self>, SimplifyError> {
        let Some(grid) = Grid::around(places) else { return Ok(None) };
        let places = |face: &[u32; 3]| face.map(|v| original.positions[v as usize]);
        let is_near = |corners: &[[f32; 3]; 3]| corners.iter().all(|&p| is_in_reach(p)) && grid.holds(corners);
        let mut near: Vec<[[f32; 3]; 3]> =
            original.faces.par_iter().with_min_len(PART).map(places).filter(is_near).collect();
        if near.is_empty() {
            return Ok(None);
        }
        let step = near.len().div_ceil(most);
        if step > 1 {
            near = near.into_iter().step_by(step).collect();
        }
        let normals = near.iter().map(|&corners| normal(corners)).collect();
        let indices = (0..near.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = TriangleMesh { positions: near.as_flattened().into(), indices };
        Ok(Some(Self { search: ClosestPoints::build(&mesh, Isa::detect())?, normals }))
    }

    /// Looks at faces.
    pub fn look(&self, faces: &[Triangle]) -> Vec<Look> {
        let found = self.nearest(faces);
        let look = |(face, found): (&Triangle, &[ClosestPoint])| Look {
            turned: found.iter().any(|found| self.is_against(face, found)),
            far: found.iter().map(|found| found.distance_squared).fold(0.0, f64::max),
        };
        faces.iter().zip(found.chunks(POINTS)).map(look).collect()
    }

    /// How many of some faces are turned over, and not just where another part of the original is near.
    pub fn count_turned(&self, faces: &[Triangle]) -> usize {
        let found = self.nearest(faces);
        let corners = |i: usize| [0, 1, 2].map(|k| self.search.mesh().positions[3 * i + k]);
        let mut by_start: Vec<(f32, u32)> =
            (0..self.normals.len()).map(|i| (span(&corners(i), 0)[0], i as u32)).collect();
        by_start.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        let widest = (0..self.normals.len()).map(|i| span(&corners(i), 0)).map(|[low, high]| high - low);
        let widest = f64::from(widest.fold(0.0, f32::max));
        let is_turned = |(face, found): (&Triangle, &[ClosestPoint])| {
            face.points().into_iter().zip(found).any(|(point, found)| {
                if !self.is_against(face, found) {
                    return false;
                }
                let within = (AS_NEAR * AS_NEAR * found.distance_squared).max(OF_EDGE * OF_EDGE * face.longest_squared);
                let reach = within.sqrt();
                let first = by_start.partition_point(|&(x, _)| f64::from(x) < point[0] - reach - widest);
                let last = by_start.partition_point(|&(x, _)| f64::from(x) <= point[0] + reach);
                // A closed interval that is empty by rounding holds nothing.
                let near = by_start.get(first..last).unwrap_or(&[]);
                !near.iter().any(|&(_, i)| {
                    let corners = corners(i as usize);
                    let is_beside = |axis: usize| {
                        let [low, high] = span(&corners, axis).map(f64::from);
                        low <= point[axis] + reach && high >= point[axis] - reach
                    };
                    dot(face.normal, self.normals[i as usize]) > 0.0
                        && is_beside(1)
                        && is_beside(2)
                        && closest_on_triangle(point, &corners).0 <= within
                })
            })
        };
        faces.par_iter().zip(found.par_chunks(POINTS)).filter(|&(face, found)| is_turned((face, found))).count()
    }

    /// The places of the original that are nearest to points; a point that has none stays.
    pub fn places<const N: usize>(&self, points: [Point; N]) -> [Point; N] {
        let mut found = [ClosestPoint::NONE; N];
        self.search.closest(&points, f64::INFINITY, &mut found);
        std::array::from_fn(|i| {
            if !found[i].is_found() {
                return points[i];
            }
            let first = 3 * found[i].face as usize;
            let corners = [0, 1, 2].map(|k| self.search.mesh().positions[first + k].map(f64::from));
            let weights = found[i].corner_weights();
            [0, 1, 2].map(|axis| (0..3).map(|k| weights[k] * corners[k][axis]).sum())
        })
    }

    /// What is nearest to the points of each face.
    fn nearest(&self, faces: &[Triangle]) -> Vec<ClosestPoint> {
        let points: Vec<Point> = faces.iter().flat_map(Triangle::points).collect();
        let mut found = vec![ClosestPoint::NONE; points.len()];
        self.search.closest(&points, f64::INFINITY, &mut found);
        found
    }

    /// True if an original face looks the other way; one without area looks nowhere.
    fn is_against(&self, face: &Triangle, found: &ClosestPoint) -> bool {
        let Some(&normal) = self.normals.get(found.face as usize) else { return false };
        normal != [0.0; 3] && dot(face.normal, normal) <= 0.0
    }
}

/// For each face, true if the nearest face of a mesh looks the other way at one of its points.
pub(super) fn against(search: &ClosestPoints, faces: &[Triangle]) -> Vec<bool> {
    let mesh = search.mesh();
    let of_part = |faces: &[Triangle]| -> Vec<bool> {
        let points: Vec<Point> = faces.iter().flat_map(Triangle::points).collect();
        let mut found = vec![ClosestPoint::NONE; points.len()];
        search.closest(&points, f64::INFINITY, &mut found);
        let is_against = |face: &Triangle, found: &ClosestPoint| {
            let corners = mesh.indices.get(found.face as usize);
            corners.is_some_and(|corners| dot(face.normal, normal(corners.map(|v| mesh.positions[v as usize]))) <= 0.0)
        };
        faces.iter().zip(found.chunks(POINTS)).map(|(face, found)| found.iter().any(|f| is_against(face, f))).collect()
    };
    // In parts, for memory.
    faces.chunks(PART).flat_map(of_part).collect()
}

/// Where a triangle begins and ends along an axis.
fn span(corners: &[[f32; 3]; 3], axis: usize) -> [f32; 2] {
    let [a, b, c] = corners.map(|corner| corner[axis]);
    [a.min(b).min(c), a.max(b).max(c)]
}

/// A coarse grid over places: which cells are near to one.
struct Grid {
    low: Point,
    /// Cells over lengths.
    scale: Point,
    /// A bit a cell.
    rows: Vec<u128>,
}

const _: () = assert!(CELLS == u128::BITS as usize, "a row is a word");

impl Grid {
    /// With all cells within a distance of each place.
    fn around(places: &[(Point, f64)]) -> Option<Self> {
        let ends = |&(place, reach): &(Point, f64)| [place.map(|x| x - reach), place.map(|x| x + reach)];
        let both = |a: [Point; 2], b: [Point; 2]| {
            [[0, 1, 2].map(|i| a[0][i].min(b[0][i])), [0, 1, 2].map(|i| a[1][i].max(b[1][i]))]
        };
        let [low, high] = places.iter().map(ends).reduce(both)?;
        let scale = [0, 1, 2].map(|axis| {
            let width = high[axis] - low[axis];
            if width > 0.0 { (CELLS as f64 / width).min(f64::MAX) } else { 0.0 }
        });
        let mut grid = Self { low, scale, rows: vec![0; CELLS * CELLS] };
        for [low, high] in places.iter().map(ends) {
            let (from, to) = (grid.cell(low), grid.cell(high));
            let bits = row(from[0], to[0]);
            for z in from[2]..=to[2] {
                for y in from[1]..=to[1] {
                    grid.rows[z * CELLS + y] |= bits;
                }
            }
        }
        Some(grid)
    }

    /// The cell of a place; beside the grid, the one next to it.
    fn cell(&self, place: Point) -> [usize; 3] {
        [0, 1, 2].map(|axis| (((place[axis] - self.low[axis]) * self.scale[axis]) as usize).min(CELLS - 1))
    }

    /// True if a triangle's box meets a marked cell.
    fn holds(&self, corners: &[[f32; 3]; 3]) -> bool {
        let spans = [0, 1, 2].map(|axis| span(corners, axis).map(f64::from));
        let is_beside = (0..3).any(|axis| {
            let end = self.low[axis] + CELLS as f64 / self.scale[axis];
            spans[axis][1] < self.low[axis] || spans[axis][0] > end
        });
        if is_beside {
            return false;
        }
        let (from, to) = (self.cell(spans.map(|span| span[0])), self.cell(spans.map(|span| span[1])));
        let bits = row(from[0], to[0]);
        (from[2]..=to[2]).any(|z| (from[1]..=to[1]).any(|y| self.rows[z * CELLS + y] & bits != 0))
    }
}

/// The bits from one to another.
fn row(from: usize, to: usize) -> u128 {
    (u128::MAX >> (CELLS - 1 - to)) & (u128::MAX << from)
}
