//! Faces that came to lie against the original surface beside them, and what is done about them.
//!
//! A collapse compares faces with what was merged into their corners, polish with what they were before; neither asks the surface
//! itself. Here every face that may be turned is compared with the original faces nearest to four points of it. Where one looks
//! the other way, the surface is changed about it: an edge is turned, a vertex moved, or one taken out.

mod change;
mod nearby;

use std::ops::ControlFlow;

use etendue_accel::ClosestPoints;

use crate::curves::Curves;
use crate::draft::Draft;
use crate::faces::GONE;
use crate::polish::Grouped;
use crate::surface::{cross, dot, is_in_reach, length, sub};
use crate::{MeshRef, Progress, SimplifyError, Stage};
use change::Field;
use nearby::Nearby;

/// Times that all faces that are turned are looked at.
const ROUNDS: usize = 8;

/// Original faces that are enough to tell which of a few changes is better.
const ENOUGH: usize = 40_000;

/// Original faces, of all, that are enough to tell how far off the nearest is at most.
const FEW: usize = 20_000;
/// One of so many is enough to tell that better.
const SOME: usize = 8;

/// Faces that are looked at in a round: so many, and one of so many of all.
const LOOKED_AT: usize = 512;
const ONE_OF: usize = 20;

/// A face whose normal is within the angle of this cosine of what was merged into each of its corners is not turned.
const ALIKE: f64 = 0.5;

/// A point, or a direction.
type Point = [f64; 3];

/// How far about a face that is changed the original is asked for, over its longest edge.
const ABOUT: f64 = 0.2;

/// Mends faces that are turned over against the original, which is in the unit of the mesh; gives the number of those that stay so.
///
/// A face is turned over if at its middle or at one of three points towards its corners the nearest face of the original looks
/// the other way, and none that looks the same way is about as near: half again as far, or a tenth of the longest edge
/// away. `stand_in` is what the original was when it had fewer faces, if that is at hand, to ask all faces first. Vertices stay at
/// places of vertices of the input unless they `may_move`. The result does not depend on the number of threads.
pub(crate) fn set_upright(
    original: &MeshRef<'_>,
    stand_in: Option<&ClosestPoints>,
    curves: Option<&Curves>,
    may_move: bool,
    draft: &mut Draft,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<usize, SimplifyError> {
    let all: Vec<Triangle> = draft.mesh.faces.iter().map(|&corners| Triangle::of(draft, corners)).collect();
    let against = stand_in.map(|stand_in| nearby::against(stand_in, &all));
    let is_against = |face: u32| against.as_ref().is_some_and(|against| against[face as usize]);
    let is_suspect = |&face: &u32| {
        all[face as usize].is_surface && (is_against(face) || is_unlike(draft, face, &all[face as usize]))
    };
    let suspects: Vec<u32> = (0..all.len() as u32).filter(is_suspect).collect();
    let Some(few) = Nearby::some_of(original, FEW)?.filter(|_| !suspects.is_empty()) else { return Ok(0) };
    let mut turned = turned_of(original, &few, &all, suspects)?;
    if turned.is_empty() {
        return Ok(0);
    }
    let node = nodes(draft);
    let mut seen = turned.clone();
    let around = Field::of(draft, &node, curves, may_move).around(&turned);
    let places: Vec<(Point, f64)> = around.iter().flat_map(|&face| all[face as usize].places(ABOUT)).collect();
    let Some(nearby) = Nearby::thinned(original, &places, ENOUGH)? else { return Ok(0) };
    let most = LOOKED_AT + all.len() / ONE_OF;
    let mut stay: Vec<u32> = Vec::new();
    for _ in 0..ROUNDS {
        if progress(Progress { stage: Stage::Polish, done: 1.0 }).is_break() {
            return Err(SimplifyError::Interrupted);
        }
        let mut field = Field::of(draft, &node, curves, may_move);
        let around = field.around(&turned);
        stay.extend(turned.drain(turned.len().min(most)..));
        turned.retain(|&face| !field.mend(face, &nearby));
        seen.extend(&field.changed);
        // Where nothing has changed about a face, nothing else will be found.
        stay.extend(turned.into_iter().filter(|&face| !field.is_stirred(face)));
        stay.sort_unstable();
        let is_left = |face: &u32| draft.mesh.faces[*face as usize] != GONE && stay.binary_search(face).is_err();
        let left: Vec<u32> = around.into_iter().filter(is_left).collect();
        let looks = nearby.look(&triangles(draft, &left));
        turned = left.into_iter().zip(looks).filter(|(_, look)| look.turned).map(|(face, _)| face).collect();
        seen.extend(&turned);
        if turned.is_empty() {
            break;
        }
    }
    seen.sort_unstable();
    seen.dedup();
    let is_left = |face: &u32| draft.mesh.faces[*face as usize] != GONE;
    let all: Vec<Triangle> = triangles(draft, &seen.into_iter().filter(is_left).collect::<Vec<u32>>());
    let turned = turned_of(original, &few, &all, (0..all.len() as u32).collect())?;
    let turned: Vec<Triangle> = turned.into_iter().map(|i| all[i as usize]).collect();
    let count = Nearby::of(original, &few.about(&turned))?.map_or(0, |nearby| nearby.count_turned(&turned));
    draft.clean();
    Ok(count)
}

/// Of some faces those that are turned over, ascending. `few` are some of the original's faces.
fn turned_of(
    original: &MeshRef<'_>,
    few: &Nearby,
    all: &[Triangle],
    faces: Vec<u32>,
) -> Result<Vec<u32>, SimplifyError> {
    let triangles: Vec<Triangle> = faces.iter().map(|&face| all[face as usize]).collect();
    let mut within = few.within(&triangles);
    // What every so manieth face tells makes the rest fewer.
    if let Some(more) = Nearby::every(original, &within, SOME)? {
        within = more.within(&triangles);
    }
    let Some(nearby) = Nearby::of(original, &within)? else { return Ok(vec![]) };
    let looks = nearby.look(&triangles);
    Ok(faces.into_iter().zip(looks).filter(|(_, look)| look.turned).map(|(face, _)| face).collect())
}

fn triangles(draft: &Draft, faces: &[u32]) -> Vec<Triangle> {
    faces.iter().map(|&face| Triangle::of(draft, draft.mesh.faces[face as usize])).collect()
}

/// True if a face does not look the way of all that was merged into its corners.
fn is_unlike(draft: &Draft, face: u32, triangle: &Triangle) -> bool {
    let size = length(triangle.normal);
    draft.mesh.faces[face as usize].iter().any(|&v| {
        let facing = draft.facing[v as usize].map(f64::from);
        dot(facing, triangle.normal) < ALIKE * length(facing) * size
    })
}

/// For each vertex the first one of its point.
fn nodes(draft: &Draft) -> Vec<u32> {
    // Vertices of a point follow each other.
    let mut first: Vec<u32> = (0..draft.owners.len() as u32).collect();
    for v in 1..first.len() {
        if draft.owners[v] == draft.owners[v - 1] {
            first[v] = first[v - 1];
        }
    }
    first
}

/// A face by its places.
#[derive(Clone, Copy)]
struct Triangle {
    corners: [Point; 3],
    /// Twice its area long.
    normal: Point,
    longest_squared: f64,
    /// True if all corners are in reach and it is wider than what places are rounded by: what is not looks nowhere.
    is_surface: bool,
}

impl Triangle {
    fn of(draft: &Draft, corners: [u32; 3]) -> Self {
        Self::at(corners.map(|v| draft.mesh.positions[v as usize]), draft.rounding)
    }

    fn at(places: [[f32; 3]; 3], rounding: f64) -> Self {
        let corners = places.map(|place| place.map(f64::from));
        let [a, b, c] = corners;
        let sides = [sub(b, a), sub(c, b), sub(a, c)];
        let longest_squared = sides.into_iter().map(|side| dot(side, side)).fold(0.0, f64::max);
        let normal = cross(sides[0], sub(c, a));
        let is_wide = dot(normal, normal) > rounding * rounding * longest_squared;
        Self { corners, normal, longest_squared, is_surface: is_wide && places.into_iter().all(is_in_reach) }
    }

    /// Places all over it, and how far about them, so that all within a part of the longest edge is within that.
    fn places(&self, part: f64) -> impl Iterator<Item = (Point, f64)> + use<> {
        const STEPS: u32 = 8;
        let [a, b, c] = self.corners;
        let reach = (part + 0.7 / f64::from(STEPS)) * self.longest_squared.sqrt();
        (0..=STEPS)
            .flat_map(move |i| (0..=STEPS - i).map(move |j| [i, j].map(|k| f64::from(k) / f64::from(STEPS))))
            .map(move |[v, w]| {
                ([0, 1, 2].map(|axis| a[axis] + v * (b[axis] - a[axis]) + w * (c[axis] - a[axis])), reach)
            })
    }

    /// Its middle, and a point towards each corner.
    fn points(&self) -> [Point; POINTS] {
        let third = 1.0 / 3.0;
        let weights = [[third; 3], [0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]];
        let [a, b, c] = self.corners;
        weights.map(|w| [0, 1, 2].map(|axis| w[0] * a[axis] + w[1] * b[axis] + w[2] * c[axis]))
    }
}

/// Points of a face that are looked at.
const POINTS: usize = 4;

#[cfg(test)]
mod tests;
