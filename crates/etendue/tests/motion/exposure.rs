//! Exposures against their averages over time.

use super::*;
use etendue::{
    camera::CameraMotion,
    image::Image,
    integrator::Integrator,
    math::dvec3,
    motion::Shutter,
    render::RenderSettings,
    scene::{AcceleratorSettings, Scene, Shape},
    spectrum::Spectrum,
};
use etendue_accel::{AcceleratorKind, Isa};
use etendue_testkit::{sidak, ttest::z_test};
use std::f64::consts::PI;

const SHUTTERS: [Shutter; 3] = [Shutter::Box, Shutter::Triangle, Shutter::Trapezoid { rise: 0.1, fall: 0.5 }];

/// Share of the light that is in by a time.
fn light_by(shutter: Shutter, time: f64) -> f64 {
    let [rise, fall] = shutter.shares();
    let ramp = |t: f64, width: f64| match t {
        _ if width == 0.0 => t,
        t if t < width => 0.5 * t * t / width,
        t => t - 0.5 * width,
    };
    let all = 1.0 - 0.5 * (rise + fall);
    let (early, late) = (ramp(time, rise), all - ramp(1.0 - time, fall));
    if time < rise {
        early / all
    } else if 1.0 - time < fall {
        late / all
    } else {
        (time - 0.5 * rise) / all
    }
}

/// Holds pixels, each seen black or at radiance 1 by its samples, against their expectations.
fn assert_pixels(what: &str, image: &Image, spp: u32, tests: usize, expected: impl Fn(usize) -> f64) {
    let found = image.f32_channel("R").expect("colour");
    let level = sidak(0.001, found.len() * tests);
    let mut grey = 0;
    for (i, found) in found.iter().enumerate() {
        let p = expected(i).clamp(0.0, 1.0);
        // Pixels that are never, or always, lit allow no other number.
        let error = (p * (1.0 - p) / f64::from(spp)).sqrt() + 1e-6;
        z_test(f64::from(*found), error, p).assert(level, &format!("{what}, pixel {i}"));
        grey += usize::from(p > 0.1 && p < 0.9);
    }
    assert!(grey > found.len() / 8, "{what}: {grey} pixels say little");
}

#[test]
fn a_moving_edge_is_blurred_by_the_shutter() {
    let (size, spp) = ([64, 2], 1024);
    for shutter in SHUTTERS {
        // The glow's right edge goes from x = -0.7 to 0.8; a third of the way is made in the first half of the time.
        let mut parts = Parts::default();
        let glow = parts.emitter([1.0; 3], false);
        let corner = dvec3(-40.0, -40.0, 0.0);
        let plate = parts.shape(Shape::Rectangle { corner, u: DVec3::X * 40.0, v: DVec3::Y * 80.0 });
        let at = |x: f64| Pose { rotation: DQuat::IDENTITY, translation: DVec3::X * x };
        let motion = Motion { keys: [(0.0, at(-0.7)), (0.5, at(-0.2)), (1.0, at(0.8))].into() };
        parts.place_moving(plate, DAffine3::IDENTITY, glow, motion);
        let scene = parts.build();
        let settings = RenderSettings { shutter, ..statistics(Integrator::Path, spp) };
        // Pixels are squares: x goes from -1 to 1.
        let image = picture(&scene, &downwards(2.0 * 2.0 / 64.0), size, &settings);
        let arrival = |x: f64| if x < -0.2 { (x + 0.7).max(0.0) } else { (0.5 + 0.5 * (x + 0.2)).min(1.0) };
        assert_pixels(&format!("{shutter:?}"), &image, spp, SHUTTERS.len(), |i| {
            let inside = |k: u32| ((i % 64) as f64 + (f64::from(k) + 0.5) / 500.0) / 32.0 - 1.0;
            (0..500).map(|k| 1.0 - light_by(shutter, arrival(inside(k)))).sum::<f64>() / 500.0
        });
    }
}

#[test]
fn a_spinning_sector_is_as_bright_as_it_is_long_there() {
    let (size, spp) = ([24, 24], 1024);
    // A sector of 60 degrees, and turns in one go, in several, and by single degrees.
    for (keys, turn) in [(2, 170.0_f64), (5, 640.0), (200, 360.0)] {
        let turn = turn.to_radians();
        let mut parts = Parts::default();
        let glow = parts.emitter([1.0; 3], false);
        let far = |angle: f64| [9.0 * angle.cos() as f32, 9.0 * angle.sin() as f32, 0.0];
        let (first, last) = (0.4, 0.4 + PI / 3.0);
        let sector = parts.shape(mesh(vec![[0.0; 3], far(first), far(last)], vec![[0, 1, 2]]));
        let key = |i: u32| {
            let share = f64::from(i) / f64::from(keys - 1);
            (share, pose(DVec3::Z, turn * share, DVec3::ZERO, DVec3::ZERO))
        };
        let motion = Motion { keys: (0..keys).map(key).collect() };
        parts.place_moving(sector, DAffine3::IDENTITY, glow, motion);
        let image = picture(&parts.build(), &downwards(2.0), size, &statistics(Integrator::Path, spp));
        // Share of turns in [0, turn] that bring the sector to an angle.
        let covered = |angle: f64| {
            let lap = 2.0 * PI;
            let until = |end: f64| {
                let whole = (end / lap).floor();
                whole * (last - first) + (end - whole * lap).min(last - first)
            };
            let start = (angle - last).rem_euclid(lap);
            // Turns from start to start + 60 degrees, and every lap.
            let begin = lap - start;
            (until(begin + turn) - until(begin)) / turn
        };
        assert_pixels(&format!("{keys} keys"), &image, spp, 3, |i| {
            let at = |k: usize, of: usize| (of as f64 + (k as f64 + 0.5) / 32.0) / 12.0 - 1.0;
            let points = (0..32 * 32).map(|k| (at(k % 32, i % 24), -at(k / 32, i / 24)));
            points.map(|(x, y)| covered(y.atan2(x))).sum::<f64>() / (32.0 * 32.0)
        });
    }
}

/// Some bright things about a place.
fn still_life(motion: Option<Motion>) -> Scene {
    let mut parts = Parts::default();
    let (body, block) = (parts.shape(ball(2)), parts.shape(cube(false)));
    for i in 0..6 {
        let glow = parts.emitter([[1.0, 0.2, 0.1], [0.2, 1.0, 0.3], [0.1, 0.3, 1.0]][i % 3], true);
        let at = dvec3(1.5 * (i % 3) as f64 - 1.5, 1.4 * (i / 3) as f64 - 0.7, -6.0 - 0.3 * i as f64);
        let to = DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(0.5));
        parts.place([body, block][i % 2], to, glow);
        parts.0.objects[i].motion = motion.clone();
    }
    parts.build_with(AcceleratorKind::Bvh)
}

#[test]
fn a_moving_camera_sees_what_a_moving_scene_shows() {
    let view = camera(DVec3::ZERO, dvec3(0.2, 0.1, -6.0));
    let turn = DQuat::from_axis_angle(dvec3(0.1, 1.0, 0.2).normalize(), 0.2);
    let turned = CameraSettings { direction: turn * view.direction, up: turn * view.up, ..view };
    let shift = dvec3(0.5, -0.3, 0.8);
    let shifted = CameraSettings { position: shift, ..view };
    let still = |rotation| Pose { rotation, translation: DVec3::ZERO };
    let cases =
        [(shifted, straight(DVec3::ZERO, -shift)), (turned, between(still(DQuat::IDENTITY), still(turn.inverse())))];
    for (i, (end, motion)) in cases.into_iter().enumerate() {
        let mut settings = RenderSettings { spp: 64, threads: 2, ..RenderSettings::default() };
        let scene_moves = interleaved(&picture(&still_life(Some(motion)), &view, [40, 30], &settings));
        settings.camera_motion = Some(CameraMotion { keys: [(0.0, view), (1.0, end)].into() });
        let camera_moves = interleaved(&picture(&still_life(None), &view, [40, 30], &settings));
        settings.camera_motion = None;
        let nothing_moves = interleaved(&picture(&still_life(None), &view, [40, 30], &settings));
        let apart =
            |a: &[f32], b: &[f32]| a.iter().zip(b).map(|(a, b)| f64::from(a - b).abs()).sum::<f64>() / a.len() as f64;
        // Only rays that graze an edge may tell them apart.
        assert!(apart(&scene_moves, &camera_moves) < 1e-4, "case {i}: {}", apart(&scene_moves, &camera_moves));
        assert!(apart(&scene_moves, &nothing_moves) > 1e-2, "case {i}");
    }
}

#[test]
fn a_lens_is_focused_and_a_zoom_turned_meanwhile() {
    let lens = |fov: f64, lens_radius, focus_distance| {
        let aperture = etendue::camera::Aperture::Polygon { blades: 5, rotation: 0.1 };
        let axis = etendue::camera::FovAxis::X;
        let projection = Projection::Perspective { fov, axis, lens_radius, aperture, focus_distance };
        CameraSettings { projection, near_clip: 0.1, ..camera(DVec3::ZERO, -DVec3::Z) }
    };
    let (wide, narrow) = (lens(0.9, 0.0, 4.0), lens(0.5, 0.3, 8.0));
    let settings = |keys: &[(f64, CameraSettings)]| RenderSettings {
        camera_motion: Some(CameraMotion { keys: keys.into() }),
        ..statistics(Integrator::Path, 64)
    };
    let scene = still_life(None);
    let mean = |settings: &RenderSettings| means(&scene, &wide, [40, 30], settings, 8);
    let whole = mean(&settings(&[(0.0, wide), (1.0, narrow)]));
    // The mean of rests on the way.
    let mut rests = etendue_testkit::Moments::new();
    for seed in 0..8 {
        let steps = 8;
        let at = |i: u32| {
            let s = (f64::from(i) + 0.5) / f64::from(steps);
            lens(0.9 - 0.4 * s, 0.3 * s, 4.0 + 4.0 * s)
        };
        let still = |i| RenderSettings { seed: 100 * (seed + 1), ..settings(&[(0.0, at(i)), (1.0, at(i))]) };
        rests.push(
            (0..steps).map(|i| means(&scene, &wide, [40, 30], &still(i), 1).mean()).sum::<f64>() / f64::from(steps),
        );
    }
    assert!((whole.mean() / rests.mean() - 1.0).abs() < 0.004, "{} {}", whole.mean(), rests.mean());
    let first = mean(&settings(&[(0.0, wide), (1.0, wide)]));
    assert!((whole.mean() / first.mean() - 1.0).abs() > 0.05, "nothing changes");
}

#[test]
fn what_rests_is_as_if_nothing_could_move() {
    let view = camera(DVec3::ZERO, dvec3(0.2, 0.1, -6.0));
    let settings = RenderSettings { spp: 8, threads: 2, ..RenderSettings::default() };
    let open = RenderSettings {
        shutter: Shutter::Triangle,
        camera_motion: Some(CameraMotion { keys: [(0.0, view), (1.0, view)].into() }),
        ..settings.clone()
    };
    let (scene, size) = (still_life(None), [40, 30]);
    assert_eq!(bits(&picture(&scene, &view, size, &settings)), bits(&picture(&scene, &view, size, &open)));
    // Instances stay instances: the same bits whether they could move or not.
    let resting = still_life(Some(Motion::resting(Pose::IDENTITY)));
    assert_eq!(bits(&picture(&scene, &view, size, &settings)), bits(&picture(&resting, &view, size, &open)));
    // And at a pose, as if placed there.
    let away = pose(dvec3(1.0, 2.0, -1.0), 0.3, dvec3(0.0, 0.0, -6.0), dvec3(0.1, 0.2, 0.3));
    let placed = |moves: bool| {
        let mut parts = Parts::default();
        let grey = parts.diffuse([0.5, 0.6, 0.7]);
        let body = parts.shape(ball(1));
        for x in [-1.0, 1.0] {
            let to = DAffine3::from_translation(dvec3(x, 0.0, -6.0)) * DAffine3::from_scale(dvec3(0.8, 0.5, 0.9));
            let to = if moves { to } else { away.to_affine() * to };
            parts.place(body, to, grey);
            parts.0.objects.last_mut().expect("placed").motion = moves.then(|| Motion::resting(away));
        }
        // Both scenes have the same centre: of this.
        parts.sphere(dvec3(0.0, 0.0, -6.0), 100.0, grey);
        parts.0.environment = Some(Spectrum::ONE.into());
        let grow = parts.emitter([1.0; 3], true);
        parts.rectangle(dvec3(-2.0, 3.0, -8.0), DVec3::X * 4.0, DVec3::Z * 4.0, grow);
        let settings = AcceleratorSettings { kind: AcceleratorKind::Bvh, isa: Isa::detect(), threads: 1 };
        Scene::build(parts.0, &settings).expect("a scene")
    };
    assert_eq!(
        bits(&picture(&placed(false), &view, size, &settings)),
        bits(&picture(&placed(true), &view, size, &open))
    );
}
