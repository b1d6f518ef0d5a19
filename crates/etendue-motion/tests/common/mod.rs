//! Scenes in, motion out.

#![allow(dead_code)]

use etendue::math::DVec3;
use etendue_motion::{Bake, Control, MotionError, Options, simulate};
use etendue_scene::{Input, Limits, SourceMap, build, description::SceneDescription, read_toml};
use std::{ops::ControlFlow, path::Path};

const CAMERA: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n";

/// The scene of a text and what is built of it.
#[track_caller]
pub fn scene(text: &str) -> (SceneDescription, Input) {
    let text = format!("{CAMERA}{text}");
    let mut sources = SourceMap::new();
    let file = sources.insert("s.toml", text.clone().into_bytes()).unwrap();
    let (description, found) = read_toml(file, text.as_bytes(), Path::new(""));
    let found: Vec<String> = found.iter().map(|d| d.one_line(&sources)).collect();
    let description = description.unwrap_or_else(|| panic!("{found:?}"));
    let input = build(&description, &mut sources, &Limits::default());
    let input =
        input.unwrap_or_else(|found| panic!("{:?}", found.iter().map(|d| d.one_line(&sources)).collect::<Vec<_>>()));
    (description, input)
}

/// Its motion, nothing kinematic.
#[track_caller]
pub fn try_run(text: &str) -> Result<Bake, MotionError> {
    let (description, input) = scene(text);
    let mut control = Control { progress: &mut |_| ControlFlow::Continue(()), kinematic: &|_, _| None };
    simulate(&description, &input, Options::default(), &mut control)
}

/// Its motion.
#[track_caller]
pub fn run(text: &str) -> Bake {
    try_run(text).unwrap()
}

/// Where a point that was at `start` is, for every recorded time.
pub fn path(bake: &Bake, body: usize, start: DVec3) -> Vec<DVec3> {
    bake.bodies[body].poses.iter().map(|pose| pose.to_affine().transform_point3(start)).collect()
}

/// Speeds between recorded times, m/s.
pub fn velocities(bake: &Bake, path: &[DVec3]) -> Vec<DVec3> {
    let step = |i: usize| (path[i + 1] - path[i]) / (bake.times[i + 1] - bake.times[i]);
    (0..path.len() - 1).map(step).collect()
}
