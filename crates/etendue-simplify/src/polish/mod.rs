//! Vertices of a simplified mesh towards the surface that it came from.
//!
//! Points of the original look for the closest faces of the simplified mesh; all vertices together are moved so that the faces pass
//! as near as possible by the tangent planes of their points, in the sense of least squares, and the points look again: the
//! vertex positions of Hoppe et al., "Mesh optimization" (1993), by the tangent distances of Chen and Medioni, "Object modelling
//! by registration of multiple range images" (1992). Of all rounds the best one is kept.

mod attributes;
mod fit;
mod net;
mod rounds;
mod slide;

use std::ops::ControlFlow;

use etendue_accel::ClosestPoints;

use crate::curves::Curves;
use crate::vertex::Kind;
use crate::{Mesh, MeshRef, Progress, SimplifyError, Stage};
pub(crate) use attributes::continue_at;
pub(crate) use net::Grouped;
use net::Net;
use rounds::Rounds;

/// Times that vertices are moved.
const ROUNDS: usize = 3;

/// Times that moves may be taken back at the end.
const REPAIRS: usize = 3;

/// What a mesh is polished towards.
pub(crate) struct Originals<'a> {
    pub mesh: &'a MeshRef<'a>,
    /// Stands for it where distances to it are measured.
    pub stand_in: &'a ClosestPoints,
    pub curves: Option<&'a Curves>,
}

/// Moves the vertices of a simplified mesh, each as far as its kind lets it, so that the surface comes nearer to that of the original;
/// attributes follow. Vertices at one position stay together, and have the strictest of their kinds. No face turns over or
/// loses its shape, and what is measured on points of the original, root mean square and largest distance, gets no worse; nor does the
/// largest distance from vertices and middles of faces to what stands for the original. Vertices of curves slide along them, and stay where
/// they end or meet; edges are creases where their cosine is below `crease_cosine` and they run along one of the original's.
/// Indices of both meshes have been checked. The result does not depend on the number of threads.
pub(crate) fn polish(
    originals: &Originals<'_>,
    simplified: &mut Mesh,
    pinned: &[Kind],
    crease_cosine: f64,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<(), SimplifyError> {
    let net = Net::of(simplified, pinned);
    if !net.can_move() {
        return Ok(());
    }
    let Some(mut rounds) = Rounds::start(originals, &net, simplified, crease_cosine) else { return Ok(()) };
    for round in 0..=ROUNDS + REPAIRS {
        let done = round as f32 / (ROUNDS + REPAIRS + 1) as f32;
        if (progress)(Progress { stage: Stage::Polish, done }).is_break() {
            return Err(SimplifyError::Interrupted);
        }
        rounds.measure()?;
        if round < ROUNDS {
            if !rounds.advance() {
                break;
            }
        } else if rounds.is_within() {
            break;
        } else {
            rounds.take_back();
        }
    }
    let (positions, points) = rounds.finish();
    attributes::follow(simplified, &net, &positions, &points);
    Ok(())
}
