//! The way of a mesh through the crate.

use std::ops::ControlFlow;
use std::time::Instant;

use etendue_accel::TriangleMesh;

use crate::bounded::bounded;
use crate::curves::Curves;
use crate::draft::Draft;
use crate::engine::reduce;
use crate::metric::Metric;
use crate::polish::{Originals, polish};
use crate::prepare::{prepare, validate};
use crate::scale::Scale;
use crate::surface::search;
use crate::upright::set_upright;
use crate::{MeshRef, Options, Placement, Progress, Report, Simplified, SimplifyError, Stage, Target};

/// Simplifies a mesh: collapses edges, the cheapest first, until the target is reached or no edge may be collapsed.
///
/// Vertices at exactly one position are one for the topology; faces with two corners at one position, repeated faces and faces
/// with coordinates that are not finite are left out and counted. No face turns over, unless it is smaller than the error; no
/// edge gets more than two faces, no hole is torn or closed; borders of the surface and of materials and seams of attributes stay
/// where they are. At the end faces that are turned over against the original nearest to them are mended, those that cannot be are
/// counted. Self-intersections are not looked for. The result depends on the input and the options alone, not on the
/// number of threads. Indices of locked vertices that are not there are ignored.
///
/// `progress` is called now and then, and may end the work. Takes about 150 bytes a face of the input beside it, without attributes
/// and without the polish.
///
/// # Errors
///
/// If an index or the length of an array is wrong, an option is out of its range, there are more vertices or corners than 32 bits
/// count, or `progress` says so.
///
/// ```
/// use std::ops::ControlFlow;
/// use etendue_simplify::{MeshRef, Options, Target, simplify};
///
/// // A square of 8 by 8 squares.
/// let at = |i: u32| [(i % 9) as f32, (i / 9) as f32, 0.0];
/// let positions: Vec<[f32; 3]> = (0..81).map(at).collect();
/// let corners = (0..72).filter(|i| i % 9 < 8);
/// let faces: Vec<[u32; 3]> = corners.flat_map(|i| [[i, i + 1, i + 10], [i, i + 10, i + 9]]).collect();
/// let mesh = MeshRef { positions: &positions, faces: &faces, normals: None, uvs: None, colors: None, materials: None };
/// let result = simplify(&mesh, &Options::new(Target::Faces(2)), &mut |_| ControlFlow::Continue(()))?;
/// assert_eq!(result.mesh.faces.len(), 2);
/// assert_eq!(result.mesh.positions.len(), 4);
/// # Ok::<(), etendue_simplify::SimplifyError>(())
/// ```
pub fn simplify(
    mesh: &MeshRef<'_>,
    options: &Options,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Simplified, SimplifyError> {
    validate(mesh)?;
    check(options)?;
    let Some(scale) = Scale::of(&[mesh]) else { return scaled(mesh, options, progress).map(Reduced::finish) };
    let positions = scale.positions(mesh);
    let near = MeshRef { positions: &positions, ..*mesh };
    let mut reduced = scaled(&near, &scale.options(options), progress)?;
    scale.undo(&mut reduced);
    // What is very small beside the rest loses digits on the way.
    reduced.draft.settle(mesh.positions);
    Ok(reduced.finish())
}

/// Simplifies a valid mesh of usual size.
fn scaled(
    mesh: &MeshRef<'_>,
    options: &Options,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Reduced, SimplifyError> {
    match options.target {
        Target::Faces(faces) => reduced(mesh, options, faces, progress),
        Target::Ratio(ratio) => reduced(mesh, options, (mesh.faces.len() as f64 * ratio) as usize, progress),
        Target::Error(most) => bounded(mesh, most, options, progress),
    }
}

/// A simplified mesh and how it came about.
pub(crate) struct Reduced {
    pub draft: Draft,
    pub report: Report,
}

impl Reduced {
    fn finish(self) -> Simplified {
        Simplified { mesh: self.draft.mesh, report: self.report }
    }
}

/// Simplifies a mesh to so many faces.
pub(crate) fn reduced(
    mesh: &MeshRef<'_>,
    options: &Options,
    faces: usize,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Reduced, SimplifyError> {
    let metric = Metric::new(options);
    let start = Instant::now();
    tell(progress, Stage::Prepare, 0.0)?;
    let (mut work, dropped) = prepare(mesh, options, &metric);
    let prepare_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    tell(progress, Stage::Collapse, 0.0)?;
    let outcome = reduce(&mut work, &metric, faces, progress)?;
    let unit = work.unit;
    // Where nothing was collapsed, all is in its place.
    let stand_in = work.stand_in.take().filter(|_| outcome.collapses > 0);
    let curves = if outcome.collapses > 0 { Curves::of(mesh.positions, &work.curves)? } else { None };
    let mut draft = Draft::of(work, mesh.positions);
    let collapse_seconds = start.elapsed().as_secs_f64();
    let start = Instant::now();
    let mut search_stand_in = None;
    if let Some(stand_in) = stand_in {
        let search = search_stand_in.insert(search(&borrowed(&stand_in))?);
        let before = draft.mesh.positions.clone();
        let originals = Originals { mesh, stand_in: search, curves: curves.as_ref() };
        polish(&originals, &mut draft.mesh, &draft.kinds, libm::cos(options.crease_angle), progress)?;
        draft.note_moves(&before);
        draft.settle(mesh.positions);
    }
    let turned = if outcome.collapses > 0 {
        let may_move = options.placement != Placement::Endpoint || options.polish && !options.fast;
        set_upright(mesh, search_stand_in.as_ref(), curves.as_ref(), may_move, &mut draft, progress)?
    } else {
        0
    };
    draft.settle(mesh.positions);
    let polish_seconds = start.elapsed().as_secs_f64();
    let report = Report {
        faces_in: mesh.faces.len(),
        faces_out: draft.mesh.faces.len(),
        vertices_in: mesh.positions.len(),
        vertices_out: draft.mesh.positions.len(),
        collapses: outcome.collapses,
        cuts: outcome.cuts,
        refused: outcome.refused,
        dropped,
        turned,
        // A vertex that was taken out at the end may have reached it.
        stopped: outcome.stopped.filter(|_| draft.mesh.faces.len() > faces),
        prepare_seconds,
        collapse_seconds,
        polish_seconds,
        distance: None,
        error_estimate: f64::from(outcome.worst).sqrt() * unit,
    };
    Ok(Reduced { draft, report })
}

fn tell(progress: &mut dyn FnMut(Progress) -> ControlFlow<()>, stage: Stage, done: f32) -> Result<(), SimplifyError> {
    match progress(Progress { stage, done }) {
        ControlFlow::Continue(()) => Ok(()),
        ControlFlow::Break(()) => Err(SimplifyError::Interrupted),
    }
}

fn check(options: &Options) -> Result<(), SimplifyError> {
    let bad = |option, found, expected| Err(SimplifyError::BadOption { option, found, expected });
    match options.target {
        Target::Ratio(ratio) if !(ratio > 0.0 && ratio <= 1.0) => {
            return bad("ratio", ratio, "above 0 and at most 1");
        }
        Target::Error(error) if !(error >= 0.0 && error.is_finite()) => {
            return bad("largest error", error, "0 or more");
        }
        _ => {}
    }
    if let Placement::Probabilistic { sigma } = options.placement
        && !(0.0..=1.0).contains(&sigma)
    {
        return bad("sigma", sigma, "between 0 and 1");
    }
    if !(options.crease_angle > 0.0 && options.crease_angle <= std::f64::consts::PI) {
        return bad("crease angle", options.crease_angle, "above 0 and at most pi");
    }
    Ok(())
}

fn borrowed(mesh: &TriangleMesh) -> MeshRef<'_> {
    let (positions, faces) = (&*mesh.positions, &*mesh.indices);
    MeshRef { positions, faces, normals: None, uvs: None, colors: None, materials: None }
}
