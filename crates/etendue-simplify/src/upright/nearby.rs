//! The part of the original that is near to some faces.

use etendue_accel::{ClosestPoint, ClosestPoints, Isa, TriangleMesh, closest_on_triangle};
use rayon::prelude::*;

use super::{POINTS, Point, Triangle};
use crate::surface::{dot, is_in_reach, normal};
use crate::{MeshRef, SimplifyError};

/// Cells of the grid that marks what is near, along each axis.
const CELLS: usize = 128;
const LAST: f32 = (CELLS - 1) as f32;

/// Faces of the original that a thread takes at once.
const PART: usize = 1 << 13;

/// An original face is as near as the nearest if it is at most so many times as far away, or as this part of the longest edge.
const AS_NEAR: f64 = 1.5;
const OF_EDGE: f64 = 0.1;

/// One of so many faces is looked at to tell how many are near.
const PROBE: usize = 16;

/// More than what distances are rounded by.
const SLACK: f64 = 1.001;

/// Faces of the original near to some others, ready for closest points.
pub(super) struct Nearby {
    search: ClosestPoints,
    normals: Vec<Point>,
}

/// The corners of an original face.
type Corners = [[f32; 3]; 3];

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
        Self::every(original, places, 1)
    }

    /// The same of every so manieth face.
    pub fn every(original: &MeshRef<'_>, places: &[(Point, f64)], step: usize) -> Result<Option<Self>, SimplifyError> {
        let Some(grid) = Grid::around(places) else { return Ok(None) };
        let near: Vec<Corners> = grid.every(original, step).collect();
        if near.is_empty() { Ok(None) } else { Self::with(&near).map(Some) }
    }

    /// The same with about so many faces at most, evenly left out in their order: what is large beside them is near to others just as
    /// well.
    pub fn thinned(
        original: &MeshRef<'_>,
        places: &[(Point, f64)],
        most: usize,
    ) -> Result<Option<Self>, SimplifyError> {
        let Some(grid) = Grid::around(places) else { return Ok(None) };
        let mut step = 1;
        if original.faces.len() > most {
            step = (PROBE * grid.every(original, PROBE).count()).div_ceil(most).max(1);
        }
        let mut near: Vec<Corners> = grid.every(original, step).collect();
        if near.is_empty() && step > 1 {
            near = grid.every(original, 1).collect();
        }
        if near.is_empty() { Ok(None) } else { Self::with(&near).map(Some) }
    }

    /// Some faces of the original, evenly left out in their order; `None` if there are none.
    pub fn some_of(original: &MeshRef<'_>, most: usize) -> Result<Option<Self>, SimplifyError> {
        let part = |step: usize| -> Vec<Corners> {
            let places = |face: &[u32; 3]| face.map(|v| original.positions[v as usize]);
            let faces = original.faces.iter().step_by(step).map(places);
            faces.filter(|corners| corners.iter().all(|&p| is_in_reach(p))).collect()
        };
        let mut some = part(original.faces.len().div_ceil(most).max(1));
        if some.is_empty() {
            some = part(1);
        }
        if some.is_empty() { Ok(None) } else { Self::with(&some).map(Some) }
    }

    fn with(faces: &[Corners]) -> Result<Self, SimplifyError> {
        let normals = faces.iter().map(|&corners| normal(corners)).collect();
        let indices = (0..faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = TriangleMesh { positions: faces.as_flattened().into(), indices };
        Ok(Self { search: ClosestPoints::build(&mesh, Isa::detect())?, normals })
    }

    /// The points of faces, and how far about them the nearest of the original is at most.
    pub fn within(&self, faces: &[Triangle]) -> Vec<(Point, f64)> {
        let found = self.nearest(faces);
        let points = faces.iter().flat_map(Triangle::points).zip(found);
        points.map(|(point, found)| (point, found.distance_squared.sqrt() * SLACK)).collect()
    }

    /// The same, and how far about them the original is as near as that.
    pub fn about(&self, faces: &[Triangle]) -> Vec<(Point, f64)> {
        let longest = |i: usize| OF_EDGE * faces[i / POINTS].longest_squared.sqrt();
        let within = self.within(faces).into_iter().enumerate();
        within.map(|(i, (point, far))| (point, (AS_NEAR * far).max(SLACK * longest(i)))).collect()
    }

    /// Looks at faces.
    pub fn look(&self, faces: &[Triangle]) -> Vec<Look> {
        let found = self.nearest(faces);
        let look = |(face, found): (&Triangle, &[ClosestPoint])| Look {
            turned: face.is_surface && found.iter().any(|found| self.is_against(face, found)),
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
fn span(corners: &Corners, axis: usize) -> [f32; 2] {
    let [a, b, c] = corners.map(|corner| corner[axis]);
    [a.min(b).min(c), a.max(b).max(c)]
}

/// A coarse grid over places: which cells are near to one.
struct Grid {
    /// Where it begins and ends.
    low: [f32; 3],
    high: [f32; 3],
    /// Cells over lengths.
    scale: [f32; 3],
    /// A bit a cell.
    rows: Vec<u128>,
}

const _: () = assert!(CELLS == u128::BITS as usize, "a row is a word");

impl Grid {
    /// With all cells within a distance of each place.
    fn around(places: &[(Point, f64)]) -> Option<Self> {
        let ends = |&(place, reach): &(Point, f64)| {
            [place.map(|x| ((x - reach) as f32).next_down()), place.map(|x| ((x + reach) as f32).next_up())]
        };
        let both = |a: [[f32; 3]; 2], b: [[f32; 3]; 2]| {
            [[0, 1, 2].map(|i| a[0][i].min(b[0][i])), [0, 1, 2].map(|i| a[1][i].max(b[1][i]))]
        };
        let [low, high] = places.iter().map(ends).reduce(both)?;
        let scale = [0, 1, 2].map(|axis| {
            let width = high[axis] - low[axis];
            if width > 0.0 { (CELLS as f32 / width).min(f32::MAX) } else { 0.0 }
        });
        let mut grid = Self { low, high, scale, rows: vec![0; CELLS * CELLS] };
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

    /// Every so manieth face of a mesh, if it is in reach and meets a marked cell.
    fn every<'a>(&'a self, mesh: &'a MeshRef<'_>, step: usize) -> impl ParallelIterator<Item = Corners> + 'a {
        let corners = move |i: usize| mesh.faces[i * step].map(|v| mesh.positions[v as usize]);
        let all = (0..mesh.faces.len().div_ceil(step)).into_par_iter().with_min_len(PART);
        all.map(corners).filter(|corners| self.holds(corners) && corners.iter().all(|&p| is_in_reach(p)))
    }

    /// The cell of a place; beside the grid, the one next to it. What is not before another place along an axis is in no cell before
    /// that of the other, rounded or not.
    fn cell(&self, place: [f32; 3]) -> [usize; 3] {
        [0, 1, 2].map(|axis| ((place[axis] - self.low[axis]) * self.scale[axis]).clamp(0.0, LAST) as usize)
    }

    /// True if a triangle's box meets a marked cell.
    fn holds(&self, corners: &Corners) -> bool {
        let [a, b, c] = *corners;
        let low = [0, 1, 2].map(|axis| a[axis].min(b[axis]).min(c[axis]));
        let high = [0, 1, 2].map(|axis| a[axis].max(b[axis]).max(c[axis]));
        // Not a short circuit: most are not near, and no branch tells which.
        if (0..3)
            .fold(false, |is_beside, axis| is_beside | (high[axis] < self.low[axis]) | (low[axis] > self.high[axis]))
        {
            return false;
        }
        let (from, to) = (self.cell(low), self.cell(high));
        let bits = row(from[0], to[0]);
        (from[2]..=to[2]).any(|z| (from[1]..=to[1]).any(|y| self.rows[z * CELLS + y] & bits != 0))
    }
}

/// The bits from one to another.
fn row(from: usize, to: usize) -> u128 {
    (u128::MAX >> (CELLS - 1 - to)) & (u128::MAX << from)
}
