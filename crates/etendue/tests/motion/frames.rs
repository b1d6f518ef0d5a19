//! Frames: alone and one after the other, on any number of threads, accelerator and instruction set.

use super::*;
use etendue::{
    camera::CameraMotion,
    integrator::Integrator,
    material::Scattering,
    math::dvec3,
    motion::Shutter,
    render::RenderSettings,
    scene::{AcceleratorSettings, DeltaLight, FrameChanges, Scene, SceneError, Shape},
    spectrum::Spectrum,
};
use etendue_accel::{AcceleratorKind, Isa};

const SIZE: [u32; 2] = [40, 30];

fn view() -> CameraSettings {
    camera(dvec3(0.0, 1.0, 6.0), DVec3::ZERO)
}

/// Where object `i` is in a frame; some rest in some frames.
fn motion(i: usize, frame: usize) -> Motion {
    let at = |time: f64| {
        let time = time + frame as f64 * 2.0 + i as f64;
        let about = dvec3(0.3 * i as f64, 0.0, 0.0);
        pose(dvec3(0.3, 1.0, 0.1 * i as f64), 1.3 * time, about, dvec3(0.2 * time.sin(), 0.1 * time, 0.0))
    };
    match (i + frame) % 3 {
        0 => Motion::resting(at(0.0)),
        1 => between(at(0.0), at(1.0)),
        _ => Motion { keys: [(0.0, at(0.0)), (0.3, at(0.4)), (1.0, at(1.0))].into() },
    }
}

fn light(frame: usize) -> DeltaLight {
    DeltaLight::Point { position: dvec3(frame as f64, 3.0, 2.0), intensity: Spectrum::splat(4.0) }
}

/// A frame built from nothing; meshes placed once and often, spheres, ellipsoids, and moving lights of every kind.
fn fresh(frame: usize, kind: AcceleratorKind, isa: Isa) -> Scene {
    fresh_with(frame, frame, kind, isa)
}

/// The places of one frame with the colours and lights of another; the sky goes with the latter.
fn fresh_with(frame: usize, look: usize, kind: AcceleratorKind, isa: Isa) -> Scene {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.7; 3]);
    let color = parts.diffuse([0.1 * look as f32 + 0.2, 0.5, 0.3]);
    let metal = parts.material(Scattering::Mirror { reflectance: Spectrum::splat(0.9) });
    let glow = parts.emitter([5.0, 4.0, 3.0], true);
    let lamp = parts.emitter([2.0 + look as f32, 3.0, 5.0], false);
    parts.rectangle(dvec3(-4.0, -1.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(8.0, 0.0, 0.0), white);
    let (often, once, bulb) = (parts.shape(ball(2)), parts.shape(cube(false)), parts.shape(ball(1)));
    let sphere = parts.shape(Shape::Sphere { center: dvec3(0.1, 0.0, 0.0), radius: 1.0 });
    let plate = parts.shape(Shape::Rectangle { corner: dvec3(-0.5, 0.0, -0.5), u: DVec3::X, v: DVec3::Z });
    let scaled =
        |x: f64, y: f64, scale: DVec3| DAffine3::from_translation(dvec3(x, y, 0.0)) * DAffine3::from_scale(scale);
    let small = DVec3::splat(0.3);
    let things = [
        (often, scaled(-1.0, 0.0, small), white),
        (often, scaled(1.0, 0.0, dvec3(0.3, 0.5, -0.3)), color),
        (once, scaled(0.0, 0.4, small), metal),
        (sphere, scaled(0.8, 0.9, small), color),
        (sphere, scaled(-0.8, 0.9, dvec3(0.3, 0.2, 0.4)), white),
        (plate, scaled(0.2, 1.8, DVec3::ONE), glow),
        (bulb, scaled(-1.5, 1.5, DVec3::splat(0.2)), lamp),
        (sphere, scaled(1.5, 1.4, DVec3::splat(0.2)), glow),
    ];
    for (i, (shape, to, material)) in things.into_iter().enumerate() {
        parts.place_moving(shape, to, material, motion(i, frame));
    }
    parts.0.delta_lights = vec![light(look)];
    parts.0.environment = (look > 0).then(|| Spectrum::splat(0.2).into());
    Scene::build(parts.0, &AcceleratorSettings { kind, isa, threads: 2 }).expect("a scene")
}

fn changes(frame: usize) -> FrameChanges {
    let fresh = fresh(frame, AcceleratorKind::Brute, Isa::Portable);
    FrameChanges {
        motions: (0..8).map(|i| (i + 1, motion(i, frame))).collect(),
        materials: [1, 4].map(|i| (i, fresh.materials()[i].clone())).into(),
        delta_lights: Some(vec![light(frame)]),
        light_motions: Vec::new(),
        environment: Some((frame > 0).then(|| Spectrum::splat(0.2).into())),
    }
}

fn settings() -> RenderSettings {
    let end = CameraSettings { position: dvec3(0.2, 1.1, 5.9), ..view() };
    RenderSettings {
        spp: 6,
        threads: 2,
        splitting: Some(2),
        shutter: Shutter::Trapezoid { rise: 0.2, fall: 0.1 },
        camera_motion: Some(CameraMotion { keys: [(0.0, view()), (1.0, end)].into() }),
        ..RenderSettings::default()
    }
}

#[test]
fn a_frame_alone_is_the_frame_in_sequence() {
    for kind in AcceleratorKind::ALL {
        let mut scene = fresh(0, kind, Isa::detect());
        for frame in [1, 2, 5, 0] {
            scene = scene.with_frame(changes(frame), 2).expect("a frame");
            let alone = fresh(frame, kind, Isa::detect());
            assert_eq!((scene.is_moving(), scene.center()), (true, alone.center()));
            for integrator in [Integrator::Path, Integrator::Normal] {
                let settings = RenderSettings { integrator, ..settings() };
                let pictures = [&scene, &alone].map(|scene| bits(&picture(scene, &view(), SIZE, &settings)));
                assert!(pictures[0] == pictures[1], "{kind}, frame {frame}, {integrator}");
            }
        }
    }
}

/// Nothing but motions changes, and lights are among what moves.
#[test]
fn lights_move_along() {
    let kind = AcceleratorKind::Bvh;
    let mut scene = fresh(0, kind, Isa::detect());
    for frame in [1, 2, 3] {
        let only = FrameChanges { motions: changes(frame).motions, ..FrameChanges::default() };
        scene = scene.with_frame(only, 1).expect("a frame");
        let alone = fresh_with(frame, 0, kind, Isa::detect());
        let pictures = [&scene, &alone].map(|scene| bits(&picture(scene, &view(), SIZE, &settings())));
        assert!(pictures[0] == pictures[1], "frame {frame}");
    }
}

#[test]
fn same_bits_however_it_is_done() {
    let of = |kind, isa, settings: &RenderSettings| bits(&picture(&fresh(1, kind, isa), &view(), SIZE, settings));
    let reference = of(AcceleratorKind::Brute, Isa::Portable, &settings());
    for kind in AcceleratorKind::ALL {
        for isa in Isa::available() {
            assert!(reference == of(kind, isa, &settings()), "{kind} {isa}");
        }
    }
    for (threads, tile, wave) in [(1, 32, 256), (3, 5, 17), (2, 1, 1), (1, 7, 65536)] {
        let settings = RenderSettings { threads, tile, wave, ..settings() };
        assert!(reference == of(AcceleratorKind::Bvh, Isa::detect(), &settings), "{threads} {tile} {wave}");
    }
    let other = RenderSettings { shutter: Shutter::Box, ..settings() };
    assert!(reference != of(AcceleratorKind::Bvh, Isa::detect(), &other), "the shutter matters");
}

#[test]
fn what_cannot_be_is_refused() {
    let scene = || fresh(0, AcceleratorKind::Bvh, Isa::detect());
    let moved = |index, motion| FrameChanges { motions: vec![(index, motion)], ..FrameChanges::default() };
    let refused = |changes| scene().with_frame(changes, 1).err().expect("refused");
    let rest = Motion::resting(Pose::IDENTITY);
    assert!(matches!(refused(moved(99, rest.clone())), SceneError::Reference { index: 99, .. }));
    assert!(matches!(refused(moved(0, rest.clone())), SceneError::Motion(..)), "it never moves");
    let nan = Pose { translation: DVec3::NAN, ..Pose::IDENTITY };
    let long = Pose { rotation: DQuat::from_xyzw(0.0, 0.0, 0.0, 2.0), ..Pose::IDENTITY };
    let far = Pose { translation: DVec3::splat(1e20), ..Pose::IDENTITY };
    for wrong in [
        Motion { keys: [].into() },
        Motion { keys: [(0.0, Pose::IDENTITY), (0.5, nan)].into() },
        Motion { keys: [(0.5, Pose::IDENTITY), (1.0, far)].into() },
        Motion { keys: [(0.0, Pose::IDENTITY), (0.0, far), (1.0, far)].into() },
        Motion::resting(nan),
        Motion::resting(long),
        between(Pose::IDENTITY, nan),
        between(Pose::IDENTITY, long),
    ] {
        assert!(matches!(refused(moved(1, wrong.clone())), SceneError::Motion(..)), "{wrong:?}");
    }
    for wrong in [between(Pose::IDENTITY, far), Motion::resting(far)] {
        assert!(matches!(refused(moved(1, wrong)), SceneError::Accelerator(_) | SceneError::Transform(_)));
    }
}
