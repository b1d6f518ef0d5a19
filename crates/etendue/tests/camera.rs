//! Cameras: geometry, lens, and what they refuse.

#![allow(clippy::disallowed_methods, reason = "a test may use the platform's functions")]

use etendue::{
    camera::{Camera, CameraError, CameraSettings, FovAxis, Projection},
    math::{DVec3, Vec3, dvec3},
};
use etendue_testkit::{Rng, chi2::ChiSquare};

fn settings(projection: Projection) -> CameraSettings {
    CameraSettings { position: dvec3(1.0, 2.0, 3.0), direction: dvec3(0.0, 0.0, -2.0), up: DVec3::Y, projection }
}

fn perspective(axis: FovAxis, lens_radius: f64) -> CameraSettings {
    settings(Projection::Perspective { fov: 90f64.to_radians(), axis, lens_radius, focus_distance: 5.0 })
}

fn make(settings: &CameraSettings) -> Camera {
    Camera::new(settings, [200, 100], DVec3::ZERO).expect("a valid camera")
}

fn close(a: Vec3, b: Vec3) -> bool {
    (a - b).length() < 1e-6 * (1.0 + a.length())
}

#[test]
fn the_field_of_view_spans_the_named_axis() {
    let middle = [0.5, 0.5];
    let across = make(&perspective(FovAxis::X, 0.0));
    assert!(close(across.ray(200.0, 50.0, middle).direction, Vec3::new(1.0, 0.0, -1.0).normalize()));
    assert!(close(across.ray(100.0, 0.0, middle).direction, Vec3::new(0.0, 0.5, -1.0).normalize()));
    let down = make(&perspective(FovAxis::Y, 0.0));
    assert!(close(down.ray(100.0, 0.0, middle).direction, Vec3::new(0.0, 1.0, -1.0).normalize()));
    assert!(close(down.ray(0.0, 50.0, middle).direction, Vec3::new(-2.0, 0.0, -1.0).normalize()));
}

#[test]
fn positions_are_relative_to_the_scene_centre() {
    let camera = Camera::new(&perspective(FovAxis::X, 0.0), [200, 100], dvec3(1.0, 0.0, 3.0)).expect("valid");
    assert_eq!(camera.ray(3.0, 4.0, [0.5; 2]).origin, Vec3::new(0.0, 2.0, 0.0));
}

#[test]
fn an_orthographic_camera_sends_parallel_rays() {
    let camera = make(&settings(Projection::Orthographic { height: 4.0 }));
    let corner = camera.ray(0.0, 0.0, [0.5; 2]);
    assert!(close(corner.origin, Vec3::new(-3.0, 4.0, 3.0)));
    assert_eq!(corner.direction, -Vec3::Z);
}

#[test]
fn the_lens_is_filled_evenly_and_the_focal_plane_stays() {
    let camera = make(&perspective(FovAxis::X, 0.25));
    let mut rng = Rng::new(5);
    let in_focus = make(&perspective(FovAxis::X, 0.0)).ray(160.0, 30.0, [0.5; 2]);
    let target = in_focus.origin + in_focus.direction * (5.0 / -in_focus.direction.z);
    for _ in 0..1000 {
        let ray = camera.ray(160.0, 30.0, rng.f32x2());
        let at_plane = ray.origin + ray.direction * (5.0 / -ray.direction.z);
        assert!(close(at_plane, target), "{at_plane} is not {target}");
    }
    // On the lens: uniform over the disk. Radius squared and angle make that a uniform density on a square.
    let lens_point = |rng: &mut Rng| {
        let on_lens = (camera.ray(160.0, 30.0, rng.f32x2()).origin - Vec3::new(1.0, 2.0, 3.0)) / 0.25;
        let radius = f64::from(on_lens.truncate().length_squared());
        let turn = f64::from(on_lens.y).atan2(f64::from(on_lens.x)) / std::f64::consts::TAU;
        Some([radius.min(1.0 - 1e-9), turn.rem_euclid(1.0)])
    };
    ChiSquare::new(200_000).seed(6).square(lens_point, |_| 1.0).assert(0.01, 1, "points on the lens");
}

#[test]
fn cameras_that_cannot_be_are_refused() {
    let refused = |s: &CameraSettings| Camera::new(s, [8, 8], DVec3::ZERO).expect_err("not a camera");
    let good = perspective(FovAxis::X, 0.0);
    assert_eq!(refused(&CameraSettings { direction: DVec3::ZERO, ..good }), CameraError::NoDirection);
    assert_eq!(refused(&CameraSettings { up: dvec3(0.0, 0.0, 3.0), ..good }), CameraError::UpParallel);
    assert_eq!(refused(&CameraSettings { position: dvec3(f64::NAN, 0.0, 0.0), ..good }), CameraError::NotFinite);
    for fov in [0.0, -1.0, std::f64::consts::PI, f64::NAN] {
        let projection = Projection::Perspective { fov, axis: FovAxis::X, lens_radius: 0.0, focus_distance: 1.0 };
        assert!(matches!(refused(&settings(projection)), CameraError::FieldOfView(_)));
    }
    for (lens_radius, focus_distance) in [(-1.0, 1.0), (0.1, 0.0), (f64::INFINITY, 1.0)] {
        let projection = Projection::Perspective { fov: 1.0, axis: FovAxis::X, lens_radius, focus_distance };
        assert!(matches!(refused(&settings(projection)), CameraError::Range(..)));
    }
    assert!(matches!(refused(&settings(Projection::Orthographic { height: 0.0 })), CameraError::Range(..)));
}
