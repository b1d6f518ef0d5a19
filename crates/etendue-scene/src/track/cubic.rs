//! Smooth curves through poses.

use super::PoseTrack;
use etendue::{
    math::{DQuat, DVec3},
    motion::Pose,
};

/// The pose of the pivot at a time between keys `key` and `key + 1`.
///
/// Its way is a cubic whose slope at a key is that of the parabola through the key and its neighbours, so that it is followed
/// exactly where it is uniformly accelerated. Rotations are cumulative cubic Bezier curves (Kim, Kim and Shin, "A general
/// construction scheme for unit quaternion curves with simple high order derivatives", 1995) whose angular velocity at a key is the
/// same mean of the turns before and after it.
pub fn between(track: &PoseTrack, key: usize, time: f64) -> Pose {
    let (t0, t1) = (track.times[key], track.times[key + 1]);
    let (h, s) = (t1 - t0, (time - t0) / (t1 - t0));
    let [from, to] = [key, key + 1].map(|key| track.about_pivot(key));
    let straight = (to.translation - from.translation) / h;
    let place = |key: usize| track.about_pivot(key).translation;
    let chord = |key: usize| (place(key + 1) - place(key)) / (track.times[key + 1] - track.times[key]);
    let [begin, end] = [key, key + 1].map(|key| slope(track, key, &chord).unwrap_or(straight));
    let translation = hermite(from.translation, to.translation, begin * h, end * h, s);

    // The turn from key to key as a vector in the frame of the first: axis times angle over time.
    let spin = |key: usize| log(relative(track, key)) / (track.times[key + 1] - track.times[key]);
    let [begin, end] = [key, key + 1].map(|key| slope(track, key, &spin).unwrap_or_else(|| spin(key)));
    let (first, last) = (exp(begin * (h / 3.0)), exp(end * (h / 3.0)));
    let middle = log((first.conjugate() * relative(track, key) * last.conjugate()).normalize());
    let rest = 1.0 - s;
    let weights = [1.0 - rest * rest * rest, s * s * (3.0 - 2.0 * s), s * s * s];
    let rotation = from.rotation
        * exp(begin * (h / 3.0 * weights[0]))
        * exp(middle * weights[1])
        * exp(end * (h / 3.0 * weights[2]));
    Pose { rotation: rotation.normalize(), translation }
}

/// The slope at a key, from those of the intervals about it; at an end as the parabola through three keys has it, `None` if there are
/// only two.
fn slope(track: &PoseTrack, key: usize, chord: &impl Fn(usize) -> DVec3) -> Option<DVec3> {
    let last = track.times.len() - 1;
    let length = |key: usize| track.times[key + 1] - track.times[key];
    match key {
        _ if last < 2 => None,
        0 => Some(end_slope(chord(0), chord(1), length(0), length(1))),
        key if key == last => Some(end_slope(chord(last - 1), chord(last - 2), length(last - 1), length(last - 2))),
        key => {
            let (before, after) = (length(key - 1), length(key));
            Some((chord(key - 1) * after + chord(key) * before) / (before + after))
        }
    }
}

fn end_slope(near: DVec3, far: DVec3, near_length: f64, far_length: f64) -> DVec3 {
    near + (near - far) * (near_length / (near_length + far_length))
}

fn hermite(a: DVec3, b: DVec3, begin: DVec3, end: DVec3, s: f64) -> DVec3 {
    let rest = 1.0 - s;
    a + (b - a) * (s * s * (3.0 - 2.0 * s)) + begin * (s * rest * rest) - end * (s * s * rest)
}

/// The turn from a key to the next, the shorter way.
fn relative(track: &PoseTrack, key: usize) -> DQuat {
    let turn = track.poses[key].rotation.conjugate() * track.poses[key + 1].rotation;
    if turn.w < 0.0 { -turn } else { turn }
}

/// Axis times angle of a unit quaternion, radians.
fn log(q: DQuat) -> DVec3 {
    let v = q.xyz();
    let sin = v.length();
    if sin < 1e-150 { DVec3::ZERO } else { v * (2.0 * libm::atan2(sin, q.w) / sin) }
}

/// The unit quaternion that turns by a vector, axis times angle, radians.
fn exp(v: DVec3) -> DQuat {
    let angle = v.length();
    if angle < 1e-150 {
        return DQuat::IDENTITY;
    }
    let v = v * (libm::sin(0.5 * angle) / angle);
    DQuat::from_xyzw(v.x, v.y, v.z, libm::cos(0.5 * angle))
}
