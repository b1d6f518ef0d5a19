//! Bodies of a scene, simulated as far as the frames need.

use crate::{
    exit::{Exit, Failure},
    load::Loaded,
    progress::StageView,
    simulate,
};
use etendue_motion::{Control, MotionError, Options, Progress};
use etendue_scene::{description::SceneDescription, physics::BodyKind};
use std::ops::ControlFlow;

/// True if the scene has bodies whose motion is not read from a file.
pub fn are_simulated(description: &SceneDescription) -> bool {
    let mut bodies = description.objects.iter().filter_map(|object| object.body.as_ref());
    description.animation.keyframes.is_none() && bodies.any(|body| body.kind == BodyKind::Dynamic)
}

/// Lets the bodies of the scene move its objects, up to a time, seconds, or as long as the scene says.
pub fn simulate(
    loaded: &mut Loaded,
    until: Option<f64>,
    stopped: &dyn Fn() -> bool,
    quiet: bool,
) -> Result<(), Failure> {
    let description = &loaded.description;
    if !are_simulated(description) {
        return Ok(());
    }
    let physics = &description.physics;
    // A step more, so that no rounding lets the last moment be the end of the motion for a picture alone and not in a longer film.
    let needed = until.map(|until| (until - physics.start).max(0.0) + physics.step);
    let options = Options { duration: physics.duration.or(needed), step: None };
    let view = StageView::new(quiet);
    let mut progress = |now: Progress| {
        view.update("simulate", now.done as f32 / now.total.max(1) as f32);
        if stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let timeline = &loaded.timeline;
    let kinematic = |object: usize, time: f64| Some(timeline.track(object)?.at(time));
    let mut control = Control { progress: &mut progress, kinematic: &kinematic };
    let bake = etendue_motion::simulate(description, timeline.input(), options, &mut control);
    drop(view);
    let bake = bake.map_err(|error| match error {
        MotionError::Stopped => Failure::new(Exit::Interrupted, "interrupted while bodies were simulated"),
        error => simulate::failure(&error, &loaded.sources),
    })?;
    for (object, track) in bake.tracks() {
        loaded.timeline.set_body_track(object, track);
    }
    Ok(())
}
