//! A bare model that turns round once.

use etendue::{
    camera::{CameraSettings, FovAxis, Projection},
    math::DVec3,
};
use etendue_scene::{
    animation::{LengthRecord, MotionRecord, RotationRecord},
    curve::{Blend, Curve},
    description::SceneDescription,
    timeline::{Clock, Timeline},
};

/// How much of the picture the model may fill.
const FILLED: f64 = 0.94;
/// Directions that a turning model is looked at from, to fit the picture.
const DIRECTIONS: u32 = 180;

/// Lets the model, the first object of its automatic scene, turn about the vertical through its middle, counter-clockwise seen from
/// above: round once in `frames`, so that the last of them leads to the first.
pub fn turn(description: &mut SceneDescription, frames: u32) {
    description.animation.length = Some(LengthRecord::Frames(frames));
    let times = Clock::new(&description.animation);
    let round = f64::from(frames) * times.interval;
    if let Some(model) = description.objects.first_mut() {
        // A round before and one after, for shutters that open before frames or close after them.
        let keys = vec![(times.start - round, -360.0), (times.start + 2.0 * round, 720.0)];
        model.motion = Some(MotionRecord {
            translate: Curve::constant(DVec3::ZERO),
            rotate: RotationRecord::About { axis: DVec3::Y, angle: Curve { keys, blend: Blend::Linear } },
            pivot: None,
            origin: model.origin.clone(),
        });
    }
}

/// The camera, as far back as it must be to see the model all the way round.
pub fn fit(timeline: &Timeline) -> CameraSettings {
    let mut camera = timeline.input().camera;
    let Some([low, high]) = timeline.bounds(0) else { return camera };
    let Projection::Perspective { fov, axis, .. } = camera.projection else { return camera };
    let [width, height] = timeline.input().film.resolution.map(f64::from);
    let tangent = libm::tan(0.5 * fov);
    let [across, up] = match axis {
        FovAxis::X => [tangent, tangent * height / width],
        FovAxis::Y => [tangent * width / height, tangent],
    };
    let forward = camera.direction.normalize_or_zero();
    let right = forward.cross(camera.up).normalize_or_zero();
    let above = right.cross(forward);
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let radius = DVec3::new(half.x, 0.0, half.z).length();
    let back = |i: u32| {
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * f64::from(i) / f64::from(DIRECTIONS));
        [-half.y, half.y].map(|y| {
            let seen = middle + DVec3::new(radius * cos, y, radius * sin) - camera.position;
            let wanted = f64::max(seen.dot(right).abs() / across, seen.dot(above).abs() / up) / FILLED;
            wanted - seen.dot(forward)
        })
    };
    let most = (0..DIRECTIONS).flat_map(back).fold(0.0, f64::max);
    camera.position -= forward * most;
    camera
}
