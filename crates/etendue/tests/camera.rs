//! Cameras: geometry, lens, and what they refuse.

#![allow(clippy::disallowed_methods, reason = "a test may use the platform's functions")]

use etendue::{
    camera::{Aperture, Camera, CameraError, CameraSettings, FovAxis, MAX_BLADES, Projection},
    math::{DVec3, Vec3, dvec3},
};
use etendue_testkit::{Rng, chi2::ChiSquare};
use std::f64::consts::{PI, TAU};

fn settings(projection: Projection) -> CameraSettings {
    CameraSettings {
        position: dvec3(1.0, 2.0, 3.0),
        direction: dvec3(0.0, 0.0, -2.0),
        up: DVec3::Y,
        projection,
        near_clip: 0.0,
    }
}

fn perspective(axis: FovAxis, lens_radius: f64) -> CameraSettings {
    with_aperture(axis, lens_radius, Aperture::Round)
}

fn with_aperture(axis: FovAxis, lens_radius: f64, aperture: Aperture) -> CameraSettings {
    settings(Projection::Perspective { fov: 90f64.to_radians(), axis, lens_radius, aperture, focus_distance: 5.0 })
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
        let turn = f64::from(on_lens.y).atan2(f64::from(on_lens.x)) / TAU;
        Some([radius.min(1.0 - 1e-9), turn.rem_euclid(1.0)])
    };
    ChiSquare::new(200_000).seed(6).square(lens_point, |_| 1.0).assert(0.01, 1, "points on the lens");
}

/// Corners of a regular polygon with the area of the unit disk, one of them at `first` radians.
fn corners(count: u32, first: f64) -> Vec<[f64; 2]> {
    let step = TAU / f64::from(count);
    let radius = (step / step.sin()).sqrt();
    (0..count).map(|i| first + f64::from(i) * step).map(|a| [radius * a.cos(), radius * a.sin()]).collect()
}

fn inside(corners: &[[f64; 2]], p: [f64; 2]) -> bool {
    (0..corners.len()).all(|i| {
        let (a, b) = (corners[i], corners[(i + 1) % corners.len()]);
        (b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) >= -1e-6
    })
}

/// Apertures are filled evenly up to their edges, stand as they are told, and blur as much as the round one of their radius.
#[test]
fn apertures_are_filled_evenly() {
    let turn = 0.3;
    let polygon = |blades| Aperture::Polygon { blades, rotation: turn };
    let cases = [
        (Aperture::Square { rotation: 0.0 }, corners(4, TAU / 8.0)),
        (Aperture::Square { rotation: turn }, corners(4, turn + TAU / 8.0)),
        (polygon(3), corners(3, turn + TAU / 4.0)),
        (polygon(6), corners(6, turn + TAU / 4.0)),
        (polygon(7), corners(7, turn + TAU / 4.0)),
        (polygon(MAX_BLADES), corners(MAX_BLADES, turn + TAU / 4.0)),
    ];
    for (seed, (aperture, corners)) in cases.iter().enumerate() {
        let camera = make(&with_aperture(FovAxis::X, 0.25, *aperture));
        let on_lens = |u: [f32; 2]| {
            let p = (camera.ray(160.0, 30.0, u).origin - Vec3::new(1.0, 2.0, 3.0)) / 0.25;
            [f64::from(p.x), f64::from(p.y)]
        };
        let drawn = |rng: &mut Rng| {
            let p = on_lens(rng.f32x2());
            assert!(inside(corners, p), "{aperture:?}: {p:?}");
            Some(p)
        };
        // Constant density inside: the outcome also says that all of the area is reached.
        let density = |p: [f64; 2]| if inside(corners, p) { 1.0 / PI } else { 0.0 };
        let test = ChiSquare::new(150_000).seed(60 + seed as u64).cells(100);
        test.rectangle([-1.6, 1.6], [-1.6, 1.6], drawn, density).assert(0.01, cases.len(), &format!("{aperture:?}"));
        let last = 1.0 - f32::EPSILON / 2.0;
        for u in [[0.0, 0.0], [last, 0.0], [0.0, last], [last, last], [last, 0.5]] {
            assert!(inside(corners, on_lens(u)), "{aperture:?} {u:?}");
        }
    }
}

/// Rays are the same half-lines, begun where they meet the plane; cones are as wide there as they have become.
#[test]
fn rays_begin_on_the_near_plane() {
    let views = [
        perspective(FovAxis::X, 0.0),
        perspective(FovAxis::X, 0.25),
        settings(Projection::Orthographic { height: 4.0 }),
    ];
    for view in views {
        let (whole, clipped) = (make(&view), make(&CameraSettings { near_clip: 1.5, ..view }));
        assert_eq!((clipped.depth(clipped.start()), clipped.origin()), (1.5, whole.origin()));
        let mut rng = Rng::new(4);
        for _ in 0..100 {
            let [x, y] = rng.f32x2();
            let u = rng.f32x2();
            let (from, to) = (whole.ray(200.0 * x, 100.0 * y, u), clipped.ray(200.0 * x, 100.0 * y, u));
            assert_eq!(from.direction, to.direction);
            assert!((clipped.depth(to.origin) - 1.5).abs() < 1e-6);
            let along = (to.origin - from.origin).length();
            assert!((from.origin + from.direction * along - to.origin).length() < 1e-6);
            let [before, after] = [&whole, &clipped].map(|camera| camera.cone(from.direction));
            assert!((before.advanced(along).width - after.width).abs() < 1e-6 && before.spread == after.spread);
        }
    }
}

#[test]
fn cameras_that_cannot_be_are_refused() {
    let refused = |s: &CameraSettings| Camera::new(s, [8, 8], DVec3::ZERO).expect_err("not a camera");
    let good = perspective(FovAxis::X, 0.0);
    assert_eq!(refused(&CameraSettings { direction: DVec3::ZERO, ..good }), CameraError::NoDirection);
    assert_eq!(refused(&CameraSettings { up: dvec3(0.0, 0.0, 3.0), ..good }), CameraError::UpParallel);
    for near_clip in [-1.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(refused(&CameraSettings { near_clip, ..good }), CameraError::Range(..)));
    }
    assert_eq!(refused(&CameraSettings { position: dvec3(f64::NAN, 0.0, 0.0), ..good }), CameraError::NotFinite);
    for fov in [0.0, -1.0, PI, f64::NAN] {
        let (axis, aperture) = (FovAxis::X, Aperture::Round);
        let projection = Projection::Perspective { fov, axis, lens_radius: 0.0, aperture, focus_distance: 1.0 };
        assert!(matches!(refused(&settings(projection)), CameraError::FieldOfView(_)));
    }
    for (lens_radius, focus_distance) in [(-1.0, 1.0), (0.1, 0.0), (f64::INFINITY, 1.0)] {
        let (axis, aperture) = (FovAxis::X, Aperture::Round);
        let projection = Projection::Perspective { fov: 1.0, axis, lens_radius, aperture, focus_distance };
        assert!(matches!(refused(&settings(projection)), CameraError::Range(..)));
    }
    for blades in [0, 2, MAX_BLADES + 1, u32::MAX] {
        let aperture = Aperture::Polygon { blades, rotation: 0.0 };
        assert_eq!(refused(&with_aperture(FovAxis::X, 0.1, aperture)), CameraError::Blades(blades));
    }
    let aperture = Aperture::Square { rotation: f64::NAN };
    assert_eq!(refused(&with_aperture(FovAxis::X, 0.1, aperture)), CameraError::NotFinite);
    assert!(matches!(refused(&settings(Projection::Orthographic { height: 0.0 })), CameraError::Range(..)));
}
