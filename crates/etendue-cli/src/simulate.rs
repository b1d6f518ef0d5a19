//! `etendue simulate`: a scene with bodies in, their poses over time out.

use crate::{
    args::SimulateArgs,
    exit::{Exit, Failure},
    progress::StageView,
    report, scene_input,
    signals::Signals,
};
use etendue_motion::{Bake, Control, MotionError, Options, Progress, simulate, write_json};
use etendue_scene::{
    Diagnostic, Diagnostics, Limits, Severity, SourceMap, build_with, import::counted, output::atomic,
    timeline::Timeline,
};
use serde::Serialize;
use std::{
    io::BufWriter,
    ops::ControlFlow,
    sync::{
        Arc,
        atomic::{AtomicBool, Ordering},
    },
    time::Instant,
};

/// What `--json` prints.
#[derive(Debug, Serialize)]
struct Summary {
    /// File written.
    output: String,
    /// Dynamic bodies.
    bodies: usize,
    /// Recorded steps.
    steps: usize,
    /// Scene time of the first pose, seconds.
    start: f64,
    /// Scene time of the last pose, seconds.
    end: f64,
    /// Of all that the motion depends on.
    hash: String,
    /// Wall-clock time of the simulation alone.
    seconds: f64,
}

/// Simulates as the arguments say.
pub fn run(args: &SimulateArgs) -> Result<Exit, Failure> {
    if !args.output.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("json")) {
        let message = format!("motion is written as .json, not as `{}`", args.output.display());
        return Err(Failure::new(Exit::Usage, message).hint("end the file's name in .json"));
    }
    atomic::check_writable(&args.output)?;
    let cancelled = Arc::new(AtomicBool::new(false));
    let flag = cancelled.clone();
    let signals = Signals::install(move || flag.store(true, Ordering::SeqCst), "stopping; nothing is written");
    let limits = Limits::default();
    let mut sources = SourceMap::new();
    let mut scene = scene_input::read(&args.input, &mut sources, &limits)?;
    // What an earlier run may have written is made anew.
    scene.description.animation.keyframes = None;
    let description = &scene.description;
    let timeline = build_with(description, &mut sources, &limits, scene.meshes)
        .and_then(|input| Timeline::new(description, input, &mut sources, &limits))
        .map_err(|found| {
            report::diagnostics(&found, &sources);
            Failure::reported(Exit::of(&found))
        })?;
    tell(&scene.found, &sources);
    tell(&timeline.input().findings, &sources);

    signals.start_work();
    let clock = Instant::now();
    let view = StageView::new(args.quiet);
    let mut progress = |now: Progress| {
        view.update("simulate", now.done as f32 / now.total.max(1) as f32);
        if cancelled.load(Ordering::SeqCst) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let kinematic = |object: usize, time: f64| Some(timeline.track(object)?.at(time));
    let mut control = Control { progress: &mut progress, kinematic: &kinematic };
    let options = Options { duration: args.duration, step: args.step };
    let bake = simulate(description, timeline.input(), options, &mut control).map_err(|e| failure(&e, &sources))?;
    drop(view);
    let seconds = clock.elapsed().as_secs_f64();
    atomic::write(&args.output, |file| Ok(write_json(&bake, BufWriter::new(file))?))?;
    let summary = summary(args, &bake, seconds);
    if !args.quiet {
        let (bodies, steps) =
            (counted(summary.bodies, "body").replace("bodys", "bodies"), counted(summary.steps, "step"));
        report::say(format!("{}: {bodies}, {steps}; {seconds:.2} s", summary.output));
    }
    if args.json {
        report::result(&serde_json::to_string(&summary).unwrap_or_default())?;
    }
    Ok(if signals.interrupted() { Exit::Interrupted } else { Exit::Done })
}

/// Warnings; notes are told by `etendue info`.
fn tell(found: &Diagnostics, sources: &SourceMap) {
    let mut kept = Diagnostics::new();
    kept.extend(found.iter().filter(|d| d.severity != Severity::Note).cloned());
    report::diagnostics(&kept, sources);
}

/// What a simulation without a result is told as: with the place in the scene file, where there is one.
pub fn failure(error: &MotionError, sources: &SourceMap) -> Failure {
    if let MotionError::Stopped = error {
        return Failure::reported(Exit::Interrupted);
    }
    let mut diagnostic = Diagnostic::error(error.to_string());
    if let Some(origin) = error.origin() {
        diagnostic = diagnostic.at(origin.clone());
    }
    if let Some(hint) = error.hint() {
        diagnostic = diagnostic.help(hint);
    }
    let mut found = Diagnostics::new();
    found.push(diagnostic);
    report::diagnostics(&found, sources);
    Failure::reported(Exit::BadInput)
}

fn summary(args: &SimulateArgs, bake: &Bake, seconds: f64) -> Summary {
    Summary {
        output: args.output.display().to_string(),
        bodies: bake.bodies.len(),
        steps: bake.times.len().saturating_sub(1),
        start: bake.times.first().copied().unwrap_or(0.0),
        end: bake.times.last().copied().unwrap_or(0.0),
        hash: bake.hash.iter().map(|byte| format!("{byte:02x}")).collect(),
        seconds,
    }
}
