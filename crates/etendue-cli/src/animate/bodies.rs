//! Bodies of a scene, simulated as far as the frames need.

use super::Stop;
use crate::{
    exit::{Exit, Failure},
    load::Loaded,
    progress::StageView,
    report, simulate,
};
use etendue_motion::{Control, MotionError, Options, Progress};
use etendue_scene::physics::BodyKind;
use std::ops::ControlFlow;

/// Lets the bodies of the scene move its objects, up to a time, seconds, or as long as the scene says. A scene with keyframes has been
/// simulated before.
pub fn simulate(loaded: &mut Loaded, until: Option<f64>, stop: &Stop, quiet: bool) -> Result<(), Failure> {
    let description = &loaded.description;
    let is_dynamic = |body: &etendue_scene::physics::BodyRecord| body.kind == BodyKind::Dynamic;
    let moves = description.objects.iter().filter_map(|object| object.body.as_ref()).any(is_dynamic);
    if !moves || description.animation.keyframes.is_some() {
        return Ok(());
    }
    let physics = &description.physics;
    let needed = until.map(|until| (until - physics.start).max(physics.step));
    let options = Options { duration: physics.duration.or(needed), step: None };
    let view = StageView::new(quiet);
    let mut progress = |now: Progress| {
        view.update("simulate", now.done as f32 / now.total.max(1) as f32);
        if stop.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let timeline = &loaded.timeline;
    let kinematic = |object: usize, time: f64| Some(timeline.track(object)?.at(time));
    let mut control = Control { progress: &mut progress, kinematic: &kinematic };
    let bake = etendue_motion::simulate(description, timeline.input(), options, &mut control);
    drop(view);
    let bake = bake.map_err(|error| match error {
        MotionError::Stopped => {
            report::say("interrupted before the first frame");
            Failure::reported(Exit::Interrupted)
        }
        error => simulate::failure(&error, &loaded.sources),
    })?;
    for (object, track) in bake.tracks() {
        loaded.timeline.set_body_track(object, track);
    }
    Ok(())
}
