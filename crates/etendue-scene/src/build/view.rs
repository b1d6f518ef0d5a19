//! The camera as the renderer takes it.

use crate::{
    Diagnostic, Origin,
    description::{Angle, ApertureRecord, CameraRecord, Focus, FovAxis, Lens, View},
    geometry,
    read::rotation,
};
use etendue::{
    camera::{self, Aperture, CameraSettings, Projection},
    math::{DAffine3, DMat3, DVec3},
    scene::{SceneParts, Shape},
};

use std::ops::Range;

/// Degrees to radians, sides of the picture to axes, what is looked at to a direction, what is in focus to a distance.
///
/// `moved`: objects of `parts` that are elsewhere, and how they got there.
///
/// # Errors
/// If what should be in focus is not before the camera.
pub fn camera(
    record: &CameraRecord,
    size: [u32; 2],
    parts: &SceneParts,
    moved: Option<(Range<usize>, DAffine3)>,
) -> Result<CameraSettings, Diagnostic> {
    let direction = match record.view {
        View::LookAt(target) => target - record.position,
        View::Direction(direction) => direction,
    };
    let forward = direction.normalize_or_zero();
    let [x, y, z] = rotation(forward, record.roll);
    let up = if record.roll == 0.0 { record.up } else { DMat3::from_cols(x, y, z) * record.up };
    let projection = match &record.lens {
        Lens::Orthographic { height } => Projection::Orthographic { height: *height },
        Lens::Perspective { angle, radius, aperture, focus } => {
            let (fov, axis) = field_of_view(*angle, size);
            let distance = focus_distance(focus, record, forward, parts, moved)?;
            let aperture = match *aperture {
                ApertureRecord::Round => Aperture::Round,
                ApertureRecord::Square { rotation } => Aperture::Square { rotation: rotation.to_radians() },
                ApertureRecord::Polygon { blades, rotation } => {
                    Aperture::Polygon { blades, rotation: rotation.to_radians() }
                }
            };
            Projection::Perspective { fov, axis, lens_radius: *radius, aperture, focus_distance: distance }
        }
    };
    Ok(CameraSettings { position: record.position, direction, up, projection, near_clip: record.near_clip })
}

/// Radians, and the side that they span.
fn field_of_view(angle: Angle, [width, height]: [u32; 2]) -> (f64, camera::FovAxis) {
    match angle {
        Angle::Field { fov, axis } => {
            let axis = match axis {
                FovAxis::X => camera::FovAxis::X,
                FovAxis::Y => camera::FovAxis::Y,
                FovAxis::Smaller if width <= height => camera::FovAxis::X,
                FovAxis::Smaller => camera::FovAxis::Y,
                FovAxis::Larger if width >= height => camera::FovAxis::X,
                FovAxis::Larger => camera::FovAxis::Y,
            };
            (fov.to_radians(), axis)
        }
        Angle::Focal { length, width: sensor_width, height: sensor_height } => {
            let across = |side: f64| 2.0 * libm::atan(0.5 * side / length);
            match sensor_height {
                // A picture that is narrower than the sensor spans its height.
                Some(side) if f64::from(width) * side < f64::from(height) * sensor_width => {
                    (across(side), camera::FovAxis::Y)
                }
                _ => (across(sensor_width), camera::FovAxis::X),
            }
        }
    }
}

/// Distance of the plane in focus along the view.
fn focus_distance(
    focus: &Focus,
    record: &CameraRecord,
    forward: DVec3,
    parts: &SceneParts,
    moved: Option<(Range<usize>, DAffine3)>,
) -> Result<f64, Diagnostic> {
    let to = |point: DVec3, what: String, origin: &Origin| {
        let distance = (point - record.position).dot(forward);
        if distance > 0.0 {
            return Ok(distance);
        }
        let error = Diagnostic::error(format!("{what} is not before the camera")).at(origin.clone());
        Err(error.help("focus on something that the camera can see, or give a `focus_distance`"))
    };
    match focus {
        Focus::Distance(distance) => Ok(*distance),
        Focus::Point(point) => to(point.value, "`focus_point`".to_owned(), &point.origin),
        Focus::Object(name) => match middle_of(&name.value, parts, moved) {
            Some(middle) => to(middle, format!("the middle of `{}`", name.value), &name.origin),
            // Its mesh could not be loaded, which has been reported.
            None => Ok(1.0),
        },
        Focus::Target => Ok(match record.view {
            View::LookAt(target) => (target - record.position).length(),
            // The reader asks for a focus where there is a lens; for a pinhole any does.
            View::Direction(_) => 1.0,
        }),
    }
}

/// The middle of the bounding box of all that is called `name`.
fn middle_of(name: &str, parts: &SceneParts, moved: Option<(Range<usize>, DAffine3)>) -> Option<DVec3> {
    let named = parts.objects.iter().enumerate().filter(|(_, object)| object.name == name);
    let placed = named.map(|(index, object)| match &moved {
        Some((range, motion)) if range.contains(&index) => (&parts.shapes[object.shape], *motion * object.transform),
        _ => (&parts.shapes[object.shape], object.transform),
    });
    middle_of_all(placed)
}

/// The middle of the box about some shapes.
fn middle_of_all<'a>(placed: impl Iterator<Item = (&'a Shape, DAffine3)>) -> Option<DVec3> {
    let [low, high] = bounds_of_all(placed)?;
    Some(0.5 * (low + high)).filter(|middle| middle.is_finite())
}

/// The box about some shapes.
fn bounds_of_all<'a>(placed: impl Iterator<Item = (&'a Shape, DAffine3)>) -> Option<[DVec3; 2]> {
    let boxes = placed.map(|(shape, transform)| {
        // The highest corner is the lowest one of the mirror image, mirrored back.
        let mirrored = DAffine3::from_scale(DVec3::NEG_ONE) * transform;
        [lowest(shape, &transform), -lowest(shape, &mirrored)]
    });
    boxes.reduce(|[low, high], [l, h]| [low.min(l), high.max(h)])
}

/// Of an object that is some of the parts' objects, the transform and the middle, in the world, of its bounding box in its own axes.
pub fn middle(parts: &SceneParts, placed: Range<usize>) -> Option<(DAffine3, DVec3)> {
    let transform = parts.objects.get(placed.clone())?.first()?.transform;
    let [low, high] = own_bounds(parts, placed)?;
    let middle = transform.transform_point3(0.5 * (low + high));
    middle.is_finite().then_some((transform, middle))
}

/// Lowest and highest corner, in the world, of an object's bounding box in its own axes.
pub fn bounds(parts: &SceneParts, placed: Range<usize>) -> Option<[DVec3; 2]> {
    let transform = parts.objects.get(placed.clone())?.first()?.transform;
    let own = own_bounds(parts, placed)?;
    let corner = |i: usize| DVec3::new(own[i & 1].x, own[i >> 1 & 1].y, own[i >> 2].z);
    let corners = (0..8).map(|i| transform.transform_point3(corner(i)));
    corners.map(|corner| [corner; 2]).reduce(|[low, high], [l, h]| [low.min(l), high.max(h)])
}

fn own_bounds(parts: &SceneParts, placed: Range<usize>) -> Option<[DVec3; 2]> {
    let objects = parts.objects.get(placed)?;
    bounds_of_all(objects.iter().map(|object| (&parts.shapes[object.shape], DAffine3::IDENTITY)))
}

/// The lowest corner of a shape's bounding box after a transform.
pub fn lowest(shape: &Shape, transform: &DAffine3) -> DVec3 {
    match shape {
        Shape::Mesh(mesh) => geometry::lowest_of_mesh(mesh, transform),
        Shape::Sphere { center, radius } => geometry::lowest_of_sphere(*center, *radius, transform),
        Shape::Rectangle { corner, u, v } => geometry::lowest_of_rectangle(*corner, *u, *v, transform),
    }
}
