//! As few faces as a bound on the measured distance allows.
//!
//! The distance falls about as one over the number of faces on smooth surfaces, in steps elsewhere. The search guesses by that rule from
//! what was measured last, and halves the bracket, in proportion, where a guess did not help.

use std::ops::ControlFlow;

use crate::distance::{Side, between};
use crate::simplify::{Reduced, reduced};
use crate::{Distance, MeshRef, Options, Progress, SimplifyError};

/// Samples each way.
const SAMPLES: usize = 200_000;

/// Numbers of faces that are tried.
const ATTEMPTS: usize = 16;

/// The search ends where the fewest faces that hold are at most this over the most that do not.
const CLOSE: f64 = 1.02;

/// Of the diagonal: what a surface measures against itself by rounding.
const ROUNDING: f64 = 1.0 / (1_u64 << 40) as f64;

/// Simplifies a valid mesh as far as the distance to it stays at most `most`.
pub(crate) fn bounded(
    mesh: &MeshRef<'_>,
    most: f64,
    options: &Options,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Reduced, SimplifyError> {
    let all = mesh.faces.len();
    let original = match Side::of(mesh) {
        Ok(original) => original,
        Err(SimplifyError::NoSurface) => return reduced(mesh, options, all, progress),
        Err(error) => return Err(error),
    };
    let bound = most + ROUNDING * original.diagonal();
    let mut seconds = [0.0; 3];
    let mut best: Option<Reduced> = None;
    let mut bracket = Bracket { fails: 0, holds: all };
    let mut next = (all / 8).max(1);
    for attempt in 0..ATTEMPTS {
        let mut tried = reduced(mesh, options, next, progress)?;
        let distance = measured(&original, &tried, options.seed, progress)?;
        let report = &mut tried.report;
        report.distance = distance;
        let of_this = [report.prepare_seconds, report.collapse_seconds, report.polish_seconds];
        (0..3).for_each(|i| seconds[i] += of_this[i]);
        let faces = report.faces_out;
        let is_least = report.stopped.is_some();
        let far = distance.map_or(f64::INFINITY, |distance| distance.largest());
        if far <= bound {
            bracket.holds = faces.min(bracket.holds);
            if best.as_ref().is_none_or(|best| faces <= best.report.faces_out) {
                best = Some(tried);
            }
            if is_least || faces <= 1 {
                break;
            }
        } else {
            bracket.fails = next.max(bracket.fails);
        }
        match bracket.next(attempt, next, far / bound) {
            Some(faces) => next = faces,
            None => break,
        }
    }
    let mut result = match best {
        Some(best) => best,
        None => {
            // Nothing collapsed, nothing moved.
            let mut all = reduced(mesh, &Options { polish: false, ..options.clone() }, all, progress)?;
            all.report.distance = measured(&original, &all, options.seed, progress)?;
            all
        }
    };
    let report = &mut result.report;
    [report.prepare_seconds, report.collapse_seconds, report.polish_seconds] = seconds;
    Ok(result)
}

/// `None` if nothing is left to measure.
fn measured(
    original: &Side<'_>,
    tried: &Reduced,
    seed: u64,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Option<Distance>, SimplifyError> {
    match Side::of(&tried.draft.mesh.as_ref()) {
        Ok(side) => between(original, &side, SAMPLES, seed, progress).map(Some),
        Err(SimplifyError::NoSurface) => Ok(None),
        Err(error) => Err(error),
    }
}

/// Numbers of faces that are known to be too few and to be enough.
struct Bracket {
    fails: usize,
    holds: usize,
}

impl Bracket {
    /// What to try after `last`, whose distance was so many times the bound; `None` if the bracket is narrow enough.
    fn next(&self, attempt: usize, last: usize, over: f64) -> Option<usize> {
        let (fails, holds) = (self.fails as f64, self.holds as f64);
        if self.fails + 1 >= self.holds || holds <= CLOSE * fails {
            return None;
        }
        let guess = last as f64 * over.clamp(1.0 / 16.0, 16.0);
        let inside = guess > CLOSE.sqrt() * fails.max(holds / 16.0) && CLOSE.sqrt() * guess < holds;
        // Every third attempt at least halves what is left.
        let next = if inside && attempt % 3 != 2 { guess } else { (fails.max(holds / 16.0) * holds).sqrt() };
        Some((next.round() as usize).clamp(self.fails + 1, self.holds - 1))
    }
}
