//! `etendue simplify`: a model in, the same shape of fewer triangles out.

mod lock;
mod summary;

use crate::{
    args::SimplifyArgs,
    exit::{Exit, Failure},
    memory, model, model_output,
    progress::StageView,
    report,
    signals::Signals,
};
use etendue_scene::{
    Diagnostic, Limits, Severity, SourceMap,
    import::{Import, counted},
    mesh_file::MeshFile,
    mesh_output::MeshOutputFormat,
    output::atomic,
    simplify::{borrowed, keep_only, simplify_file},
};
use etendue_simplify::{Distance, Dropped, Keep, Options, Progress, Report, SimplifyError, Stage, distance};
use std::{
    ops::ControlFlow,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Instant,
};
use summary::{DistanceEntry, Seconds, Summary};

/// Simplifies as the arguments say.
pub fn run(args: &SimplifyArgs) -> Result<Exit, Failure> {
    let placement = args.placement().map_err(|message| {
        Failure::new(Exit::Usage, message).hint("leave --sigma out, or ask for --placement probabilistic")
    })?;
    model_output::check_is_model(&args.input)?;
    let format = model_output::format_of(&args.output)?;
    atomic::check_writable(&args.output)?;
    let cancelled = Arc::new(AtomicBool::new(false));
    let flag = cancelled.clone();
    let signals = Signals::install(move || flag.store(true, Ordering::SeqCst), "stopping; nothing is written");
    let mut seconds = Seconds::default();

    let clock = Instant::now();
    let mut sources = SourceMap::new();
    let mut original = model::read(&args.input, &mut sources, &Limits::default())?;
    tell_notes(args, &original, &sources);
    let locked = locked(args, &original, &mut sources)?;
    prepare(args, format, &mut original);
    seconds.load = lap(clock);

    let defaults = Options::new(args.goal.goal().target(&original.mesh));
    let options = Options {
        method: args.method,
        placement,
        keep_boundary: args.keep_boundary,
        crease_angle: args.crease_angle.map_or(defaults.crease_angle, f64::to_radians),
        locked,
        fast: args.fast,
        polish: !args.no_polish,
        seed: args.seed,
        ..defaults
    };
    signals.start_work();
    let view = StageView::new(args.quiet);
    let mut progress = |now: Progress| {
        view.update(words(now.stage), now.done);
        if cancelled.load(Ordering::SeqCst) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let clock = Instant::now();
    let (simplified, report) = simplify_file(&original, &options, &mut progress).map_err(|e| failure_of(e, args))?;
    seconds.polish = report.polish_seconds;
    seconds.simplify = lap(clock) - seconds.polish;
    let clock = Instant::now();
    let measured = match args.measure {
        Some(samples) => measure(args, &original, &simplified, samples, &mut progress)?,
        None => None,
    };
    seconds.measure = lap(clock);
    drop(view);
    if cancelled.load(Ordering::SeqCst) {
        return Err(Failure::reported(Exit::Interrupted));
    }

    let clock = Instant::now();
    model_output::write(&args.output, format, &simplified, &args.input, &sources)?;
    seconds.write = lap(clock);

    tell(args, &simplified, &report, &seconds, measured.as_ref());
    if args.json {
        let distance = measured.as_ref().map(DistanceEntry::new);
        report::result(&Summary::new(&args.output, &report, seconds, memory::peak(), distance).json())?;
    }
    if signals.interrupted() {
        return Ok(Exit::Interrupted);
    }
    Ok(if args.require_target && report.stopped.is_some() { Exit::Incomplete } else { Exit::Done })
}

fn lap(clock: Instant) -> f64 {
    clock.elapsed().as_secs_f64()
}

fn words(stage: Stage) -> &'static str {
    match stage {
        Stage::Prepare => "prepare",
        Stage::Collapse => "collapse",
        Stage::Polish => "polish",
        Stage::Measure => "measure",
    }
}

/// What the reader left out or changed.
fn tell_notes(args: &SimplifyArgs, model: &MeshFile, sources: &SourceMap) {
    let is_told = |note: &&Diagnostic| !args.quiet || note.severity != Severity::Note;
    model.notes.iter().filter(is_told).for_each(|note| report::say(note.one_line(sources)));
}

/// Vertices of the mesh that `--lock` names.
fn locked(args: &SimplifyArgs, model: &MeshFile, sources: &mut SourceMap) -> Result<Vec<u32>, Failure> {
    let Some(path) = &args.lock else { return Ok(vec![]) };
    let file = sources.read(path, Limits::default().file_bytes)?;
    lock::read(&sources.bytes(file), file, &model.numbering).map_err(|found| {
        report::diagnostics(&found, sources);
        Failure::reported(Exit::BadInput)
    })
}

/// Takes away what is not to be kept, and tells what cannot be.
fn prepare(args: &SimplifyArgs, format: MeshOutputFormat, model: &mut MeshFile) {
    keep_only(model, args.keep.unwrap_or_default());
    model_output::tell_losses(format, model);
    let is_stl = format == MeshOutputFormat::Stl;
    let holds = Keep { uvs: !is_stl, normals: !is_stl, colors: !is_stl, materials: format.keeps_materials() };
    keep_only(model, holds);
    if !model.groups.is_empty() && !args.quiet {
        let names = counted(model.groups.len(), "named object or group").replace("groups", "groups' names");
        report::warning(&format!("{names} left out: simplified faces are of the model as a whole"));
    }
}

fn failure_of(error: SimplifyError, args: &SimplifyArgs) -> Failure {
    match error {
        SimplifyError::Interrupted => Failure::reported(Exit::Interrupted),
        error => Failure::new(Exit::BadInput, format!("cannot simplify {}: {error}", args.input.display()))
            .hint(format!("etendue info {} tells what is in it", args.input.display())),
    }
}

/// `None` if one of both has no faces, which is told.
fn measure(
    args: &SimplifyArgs,
    original: &MeshFile,
    simplified: &MeshFile,
    samples: u32,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Option<Distance>, Failure> {
    if original.mesh.indices.is_empty() || simplified.mesh.indices.is_empty() {
        report::warning("there is no surface to measure the distance of");
        return Ok(None);
    }
    let (original, simplified) = (borrowed(&original.mesh), borrowed(&simplified.mesh));
    let measured = distance(&original, &simplified, samples as usize, args.seed, progress);
    measured.map(Some).map_err(|error| failure_of(error, args))
}

/// What people want to know at the end.
fn tell(args: &SimplifyArgs, model: &MeshFile, report: &Report, seconds: &Seconds, measured: Option<&Distance>) {
    let Dropped { degenerate, duplicate, non_finite, .. } = report.dropped;
    let dropped = [
        (degenerate, "with two corners at one place"),
        (duplicate, "twice there"),
        (non_finite, "with a corner not finite"),
    ];
    for (count, what) in dropped.into_iter().filter(|(count, _)| *count > 0) {
        report::warning(&format!("{} {what} left out", counted(count, "face")));
    }
    if let Some(stopped) = &report.stopped {
        let left = counted(report.faces_out, "triangle");
        report::warning(&format!("the target is not reached, {left} are left: {stopped}"));
    }
    if report.turned > 0 {
        let what = counted(report.turned, "triangle");
        report::warning(&format!("{what} turned over against the original beside, as thin or folded parts may have"));
    }
    if args.quiet {
        return;
    }
    let import = Import::new(&args.output, model);
    let written = Import { keys: Vec::new(), simplified_from: Some(report.faces_in), ..import };
    report::say(format!("{written}; {:.2} s", seconds.simplify + seconds.polish));
    if let Some(measured) = measured {
        let of_diagonal = |distance: f64| format!("{distance:.3e} ({:.4} %)", 100.0 * distance / measured.diagonal);
        let (rms, largest) = (of_diagonal(measured.rms()), of_diagonal(measured.largest()));
        report::say(format!("distance: rms {rms}, largest {largest} of the diagonal"));
    }
}
