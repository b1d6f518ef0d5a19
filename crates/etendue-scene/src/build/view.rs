//! The camera as the renderer takes it.

use crate::description::{CameraRecord, FovAxis, Lens, View};
use etendue::camera::{self, CameraSettings, Projection};

/// Degrees to radians, sides of the picture to axes, the point looked at to a direction and a distance.
pub fn camera(record: &CameraRecord, [width, height]: [u32; 2]) -> CameraSettings {
    let direction = match record.view {
        View::LookAt(target) => target - record.position,
        View::Direction(direction) => direction,
    };
    let projection = match record.lens {
        Lens::Orthographic { height } => Projection::Orthographic { height },
        Lens::Perspective { fov, axis, radius, focus } => Projection::Perspective {
            fov: fov.to_radians(),
            axis: match axis {
                FovAxis::X => camera::FovAxis::X,
                FovAxis::Y => camera::FovAxis::Y,
                FovAxis::Smaller if width <= height => camera::FovAxis::X,
                FovAxis::Smaller => camera::FovAxis::Y,
                FovAxis::Larger if width >= height => camera::FovAxis::X,
                FovAxis::Larger => camera::FovAxis::Y,
            },
            lens_radius: radius,
            aperture: camera::Aperture::Round,
            focus_distance: focus.unwrap_or(match record.view {
                View::LookAt(_) => direction.length(),
                // The reader asks for a distance where there is a lens; for a pinhole any does.
                View::Direction(_) => 1.0,
            }),
        },
    };
    CameraSettings { position: record.position, direction, up: record.up, projection }
}
