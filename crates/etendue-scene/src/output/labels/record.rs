//! What belongs to no pixel: the camera, the objects and where they are, as JSON.

use etendue::{
    film::PixelRect,
    labels::{Axes, Labels, Subject, Subjects, Visibility},
    material::Material,
    math::{DAffine3, DVec3},
};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// What labels are of.
#[derive(Clone, Copy, Debug)]
pub struct About<'a> {
    /// Number of the frame; absent: a still.
    pub frame: Option<u64>,
    /// Scene time, seconds.
    pub time: f64,
    /// Scene time from one frame to the next, seconds; absent: a still.
    pub interval: Option<f64>,
    /// By which the frame is known again; see `etendue animate --resume`.
    pub stamp: Option<&'a str>,
    /// Pixels of the whole image.
    pub resolution: [u32; 2],
    /// The objects.
    pub subjects: &'a Subjects,
    /// The materials in the order of their ids.
    pub materials: &'a [Material],
    /// Hash of the scene's files, hexadecimal.
    pub scene_hash: &'a str,
}

/// The whole file: a line for each entry and each object.
pub fn text(labels: &Labels, about: &About<'_>, software: &str, files: &[PathBuf]) -> String {
    let area = labels.area;
    let names: Vec<String> = files.iter().map(|file| file_name(file)).collect();
    let materials: Vec<&str> = about.materials.iter().map(|material| material.name.as_str()).collect();
    let entries = [
        ("format", json!("etendue-labels")),
        ("version", json!(1)),
        ("software", json!(software)),
        ("scene_hash", json!(about.scene_hash)),
        ("frame", json!(about.frame)),
        ("time", json!(about.time)),
        ("interval", json!(about.interval)),
        ("stamp", json!(about.stamp)),
        ("size", json!(about.resolution)),
        ("area", rectangle(&area)),
        ("files", json!(names)),
        ("camera", camera(labels)),
        ("materials", json!(materials)),
    ];
    let mut text = "{\n".to_owned();
    for (name, value) in entries {
        text += &format!("\"{name}\": {value},\n");
    }
    let objects: Vec<String> = (0..about.subjects.list().len()).map(|i| object(labels, about, i).to_string()).collect();
    text += &format!("\"objects\": [\n{}\n]\n}}\n", objects.join(",\n"));
    text
}

fn file_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().into_owned()).unwrap_or_default()
}

fn rectangle(area: &PixelRect) -> Value {
    json!([area.x0, area.y0, area.x1, area.y1])
}

fn camera(labels: &Labels) -> Value {
    let view = &labels.view;
    let k = view.intrinsics();
    let of = |axes| json!({ "camera_to_world": view.to_world(axes), "world_to_camera": view.from_world(axes) });
    json!({
        "model": if k.orthographic { "orthographic" } else { "pinhole" },
        "fx": k.fx,
        "fy": k.fy,
        "cx": k.cx,
        "cy": k.cy,
        "opencv": of(Axes::OpenCv),
        "opengl": of(Axes::OpenGl),
    })
}

fn object(labels: &Labels, about: &About<'_>, number: usize) -> Value {
    let subject = &about.subjects.list()[number];
    let to_world = &labels.to_world[number];
    let mut object = json!({
        "id": number + 1,
        "name": subject.name,
        "object_to_world": matrix(to_world),
        "bounds": bounds(subject),
        "box": oriented(subject, to_world),
    });
    if let Some(seen) = labels.visibility.as_ref().and_then(|seen| seen.get(number)) {
        add_visibility(&mut object, seen);
    }
    object
}

fn add_visibility(object: &mut Value, seen: &Visibility) {
    object["visible_pixels"] = json!(seen.visible);
    object["unoccluded_pixels"] = json!(seen.unoccluded);
    object["visible_fraction"] = json!(seen.fraction());
    object["visible_box"] = json!(seen.visible_box.as_ref().map(rectangle));
    object["unoccluded_box"] = json!(seen.unoccluded_box.as_ref().map(rectangle));
}

/// Rows of 4x4.
fn matrix(m: &DAffine3) -> Value {
    let [x, y, z] = [m.matrix3.x_axis, m.matrix3.y_axis, m.matrix3.z_axis];
    let row = |i: usize| [x[i], y[i], z[i], m.translation[i]];
    json!([row(0), row(1), row(2), [0.0, 0.0, 0.0, 1.0]])
}

/// Corners of the box in the object's own space.
fn bounds(subject: &Subject) -> Value {
    json!(subject.bounds.map(|corners| corners.map(|corner| corner.to_array())))
}

/// The same box in the world: its middle and half of its edges.
fn oriented(subject: &Subject, to_world: &DAffine3) -> Value {
    let Some([low, high]) = subject.bounds else { return Value::Null };
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let edge = |axis: DVec3| to_world.transform_vector3(axis * half).to_array();
    json!({
        "center": to_world.transform_point3(middle).to_array(),
        "half_edges": [edge(DVec3::X), edge(DVec3::Y), edge(DVec3::Z)],
    })
}
