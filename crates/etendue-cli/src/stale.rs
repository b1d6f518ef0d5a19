//! Whether a motion file is still that of the scene that uses it.

use etendue_motion::{DURATION, Options, motion_hash};
use etendue_scene::{
    Diagnostic, Diagnostics, description::SceneDescription, keyframes::Made, physics::BodyKind, timeline::Timeline,
};
use std::path::Path;

/// A warning if the scene, which was read from `scene`, has bodies, and the file that moves them was simulated of other physics. What
/// `etendue simulate` was told beside the scene (another step, another length) does not make a file another one's.
pub fn check(scene: &Path, description: &SceneDescription, timeline: &Timeline) -> Diagnostics {
    let mut found = Diagnostics::new();
    let mut bodies = description.objects.iter().filter_map(|object| object.body.as_ref());
    if !bodies.any(|body| body.kind == BodyKind::Dynamic) {
        return found;
    }
    let Some(made @ Made { hash: Some((theirs, place)), .. }) = timeline.made() else { return found };
    let options = options(made, description);
    let kinematic = |object: usize, time: f64| Some(timeline.track(object)?.at(time));
    let ours = motion_hash(description, timeline.input(), options, &kinematic);
    let ours: String = ours.iter().map(|byte| format!("{byte:02x}")).collect();
    if ours != *theirs {
        let message = "bodies move as in a file that was simulated of other physics than the scene has now";
        let label = format!("the hash of the scene's physics is {ours}");
        found.push(Diagnostic::warning(message).at(*place).label(label).help(again(scene, description, options)));
    }
    found
}

/// With which a file was simulated.
fn options(made: &Made, description: &SceneDescription) -> Options {
    let step = made.step.unwrap_or(description.physics.step);
    Options { duration: Some(step * made.rows.saturating_sub(1) as f64), step: Some(step) }
}

/// The command that makes the file anew.
fn again(scene: &Path, description: &SceneDescription, options: Options) -> String {
    let physics = &description.physics;
    let file = description.animation.keyframes.as_ref().map(|record| description.folder.join(&record.file.value));
    let file = file.unwrap_or_default();
    let mut command = format!("etendue simulate {} -o {}", scene.display(), file.display());
    if let Some(step) = options.step.filter(|step| *step != physics.step) {
        command += &format!(" --step {step}");
    }
    let usual = physics.duration.unwrap_or(DURATION);
    if let Some(duration) = options.duration.filter(|duration| (duration - usual).abs() > physics.step) {
        command += &format!(" --duration {duration}");
    }
    format!("simulate again: {command}")
}
