//! Faces that came to lie against the original surface beside them, and what is done about them.
//!
//! A collapse compares faces with what was merged into their corners, polish with what they were before; neither asks the surface
//! itself. Here every face that may be turned is compared with the original faces nearest to four points of it. Where one looks
//! the other way, the surface is changed about it: an edge is turned, a vertex moved, or one taken out.

mod change;
mod nearby;

use std::ops::ControlFlow;

use crate::draft::Draft;
use crate::faces::GONE;
use crate::polish::Grouped;
use crate::surface::{cross, dot, is_in_reach, length, sub};
use crate::{MeshRef, Progress, SimplifyError, Stage};
use change::Field;
use nearby::Nearby;

/// Times that all faces that are turned are looked at.
const ROUNDS: usize = 8;

/// Faces that are looked at in a round: so many, and one of so many of all.
const LOOKED_AT: usize = 512;
const ONE_OF: usize = 20;

/// A face whose normal is within the angle of this cosine of what was merged into each of its corners is not turned.
const ALIKE: f64 = 0.5;

/// A point, or a direction.
type Point = [f64; 3];

/// Mends faces that are turned over against the original, which is in the unit of the mesh; gives the number of those that stay so.
///
/// A face is turned over if at its middle or at one of three points towards its corners the nearest face of the original looks
/// the other way, and none that looks the same way is about as near: half again as far, or a tenth of the longest edge
/// away. The result does not depend on the number of threads.
pub(crate) fn set_upright(
    original: &MeshRef<'_>,
    draft: &mut Draft,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<usize, SimplifyError> {
    let suspects: Vec<u32> = (0..draft.mesh.faces.len() as u32).filter(|&face| is_suspect(draft, face)).collect();
    let places = |draft: &Draft, faces: &[u32]| -> Vec<Triangle> {
        faces.iter().map(|&face| Triangle::of(draft, draft.mesh.faces[face as usize])).collect()
    };
    let turned_of = |draft: &Draft, nearby: &Nearby, faces: &[u32]| -> Vec<u32> {
        let looks = nearby.look(&places(draft, faces));
        faces.iter().zip(looks).filter(|(_, look)| look.turned).map(|(&face, _)| face).collect()
    };
    let Some(mut nearby) = Nearby::of(original, &places(draft, &suspects))? else { return Ok(0) };
    let mut turned = turned_of(draft, &nearby, &suspects);
    let most = LOOKED_AT + draft.mesh.faces.len() / ONE_OF;
    let node = nodes(draft);
    for _ in 0..ROUNDS {
        if turned.is_empty() {
            break;
        }
        if progress(Progress { stage: Stage::Polish, done: 1.0 }).is_break() {
            return Err(SimplifyError::Interrupted);
        }
        let mut field = Field::of(draft, &node);
        let around = field.around(&turned);
        let Some(about) = Nearby::of(original, &places(field.draft, &around))? else { return Ok(0) };
        nearby = about;
        let mut changed = false;
        for &face in turned.iter().take(most) {
            changed |= field.mend(face, &nearby);
        }
        if !changed {
            break;
        }
        let left: Vec<u32> = around.into_iter().filter(|&face| draft.mesh.faces[face as usize] != GONE).collect();
        turned = turned_of(draft, &nearby, &left);
    }
    let count = nearby.count_turned(&places(draft, &turned));
    draft.clean();
    Ok(count)
}

/// True if a face has to be compared with the original itself.
fn is_suspect(draft: &Draft, face: u32) -> bool {
    let corners = draft.mesh.faces[face as usize];
    let triangle = Triangle::of(draft, corners);
    let size = length(triangle.normal);
    triangle.is_in_reach
        && corners.iter().any(|&v| {
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
    is_in_reach: bool,
}

impl Triangle {
    fn of(draft: &Draft, corners: [u32; 3]) -> Self {
        Self::at(corners.map(|v| draft.mesh.positions[v as usize]))
    }

    fn at(places: [[f32; 3]; 3]) -> Self {
        let corners = places.map(|place| place.map(f64::from));
        let [a, b, c] = corners;
        let sides = [sub(b, a), sub(c, b), sub(a, c)];
        let longest_squared = sides.into_iter().map(|side| dot(side, side)).fold(0.0, f64::max);
        let normal = cross(sides[0], sub(c, a));
        Self { corners, normal, longest_squared, is_in_reach: places.into_iter().all(is_in_reach) }
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
