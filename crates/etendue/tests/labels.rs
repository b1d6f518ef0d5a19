//! Labels against closed forms: planes, spheres, flow, occlusion and visible fractions.
#![allow(clippy::disallowed_methods, reason = "references in f64")]

mod common;

use common::*;
use etendue::{
    camera::{Aperture, CameraSettings, FovAxis, Projection},
    labels::{Axes, Label, LabelError, LabelSettings, Labeller, Labels, Moment, Subjects, View, Way},
    math::{DAffine3, DMat3, DQuat, DVec3, dvec3},
    motion::{Motion, Pose},
    scene::{AcceleratorSettings, Scene, SceneParts},
};
use etendue_accel::{AcceleratorKind, Isa};
use std::f64::consts::PI;

const SIZE: [u32; 2] = [120, 80];

fn settings() -> LabelSettings {
    LabelSettings { resolution: SIZE, crop: None, labels: Label::ALL.to_vec(), threads: 2 }
}

/// A scene at a moment; what has no pose never moves.
struct Frame {
    scene: Scene,
    camera: CameraSettings,
}

impl Frame {
    fn new(parts: &SceneParts, poses: &[Pose], camera: CameraSettings) -> Self {
        Self::by(parts, poses, camera, AcceleratorKind::Bvh, Isa::detect())
    }

    fn by(parts: &SceneParts, poses: &[Pose], camera: CameraSettings, kind: AcceleratorKind, isa: Isa) -> Self {
        let mut parts = parts.clone();
        for (object, pose) in parts.objects.iter_mut().zip(poses) {
            object.motion = Some(Motion::resting(*pose));
        }
        let scene = Scene::build(parts, &AcceleratorSettings { kind, isa, threads: 1 }).expect("a scene");
        Self { scene, camera }
    }

    fn moment(&self) -> Moment<'_> {
        Moment { scene: &self.scene, camera: &self.camera }
    }
}

/// The labels of `here`, with the flow to `next` as if it were both the next frame and the previous one.
fn labels_of(parts: &SceneParts, settings: LabelSettings, here: &Frame, next: Option<&Frame>) -> Labels {
    let mut labeller = Labeller::new(Subjects::of(parts), settings).expect("a labeller");
    let mut labels = labeller.label(&here.moment()).expect("labels");
    for way in next.iter().flat_map(|_| Way::ALL) {
        labeller.follow(&mut labels, way, &next.expect("a frame").moment()).expect("flow");
    }
    labels
}

fn still(count: usize) -> Vec<Pose> {
    vec![Pose::IDENTITY; count]
}

fn shift(by: DVec3) -> Pose {
    Pose { rotation: DQuat::IDENTITY, translation: by }
}

fn turn(axis: DVec3, angle: f64) -> Pose {
    Pose { rotation: DQuat::from_axis_angle(axis.normalize(), angle), translation: DVec3::ZERO }
}

/// The reference's own camera: 40 degrees across the width of [`SIZE`].
struct Pinhole {
    position: DVec3,
    /// Rows: right, down, forward.
    axes: DMat3,
    focal: f64,
}

impl Pinhole {
    fn of(camera: &CameraSettings) -> Self {
        let forward = camera.direction.normalize();
        let right = forward.cross(camera.up).normalize();
        let axes = DMat3::from_cols(right, forward.cross(right), forward).transpose();
        Self { position: camera.position, axes, focal: 0.5 * f64::from(SIZE[0]) / 20f64.to_radians().tan() }
    }

    fn middle() -> [f64; 2] {
        SIZE.map(|n| 0.5 * f64::from(n))
    }

    fn direction(&self, [x, y]: [f64; 2]) -> DVec3 {
        let [cx, cy] = Self::middle();
        (self.axes.transpose() * dvec3((x - cx) / self.focal, (y - cy) / self.focal, 1.0)).normalize()
    }

    fn project(&self, point: DVec3) -> [f64; 2] {
        let p = self.axes * (point - self.position);
        let [cx, cy] = Self::middle();
        [cx + self.focal * p.x / p.z, cy + self.focal * p.y / p.z]
    }
}

fn pixels() -> impl Iterator<Item = (usize, [f64; 2])> {
    let [width, height] = SIZE;
    (0..width * height).map(move |i| (i as usize, [f64::from(i % width) + 0.5, f64::from(i / width) + 0.5]))
}

/// The nearest distance at which a ray meets a sphere, and how far beside its middle it passes.
fn on_sphere(origin: DVec3, direction: DVec3, center: DVec3, radius: f64) -> (Option<f64>, f64) {
    let b = (origin - center).dot(direction);
    let beside = (origin - center - direction * b).length();
    let t = -b - (radius * radius - beside * beside).max(0.0).sqrt();
    ((beside < radius && t > 0.0).then_some(t), beside)
}

fn close(a: f64, b: f64, tolerance: f64) -> bool {
    (a - b).abs() <= tolerance
}

fn frame_holds([x, y]: [f64; 2]) -> bool {
    (0.0..f64::from(SIZE[0])).contains(&x) && (0.0..f64::from(SIZE[1])).contains(&y)
}

#[test]
fn the_view_is_the_renderers_camera() {
    let perspective = camera(dvec3(3.0, 1.0, 7.0), dvec3(0.2, -0.4, 0.1));
    let tall = CameraSettings {
        projection: Projection::Perspective {
            fov: 1.1,
            axis: FovAxis::Y,
            lens_radius: 0.0,
            aperture: Aperture::Round,
            focus_distance: 1.0,
        },
        ..perspective
    };
    let parallel =
        CameraSettings { projection: Projection::Orthographic { height: 3.0 }, near_clip: 0.5, ..perspective };
    for settings in [perspective, tall, parallel] {
        let view = View::new(&settings, SIZE).expect("a view");
        let traced = etendue::camera::Camera::new(&settings, SIZE, DVec3::ZERO).expect("a camera");
        for (_, place) in pixels().step_by(7) {
            let (origin, direction) = view.ray(place);
            let ray = traced.ray(place[0] as f32, place[1] as f32, [0.5; 2]);
            assert!((ray.direction.as_dvec3() - direction).length() < 1e-6);
            let off = ray.origin.as_dvec3() - origin;
            assert!(off.cross(direction).length() < 1e-5 && close(off.dot(view.forward()), settings.near_clip, 1e-5));
            let point = origin + direction * 4.2;
            let again = view.project(point).expect("it is before the camera");
            assert!((0..2).all(|i| close(again[i], place[i], 1e-9)), "{again:?} {place:?}");
            // The matrices say the same.
            let in_camera = apply(view.from_world(Axes::OpenCv), point);
            let k = view.intrinsics();
            let scale = if k.orthographic { 1.0 } else { in_camera.z };
            let by_matrix = [k.fx * in_camera.x / scale + k.cx, k.fy * in_camera.y / scale + k.cy];
            assert!((0..2).all(|i| close(by_matrix[i], place[i], 1e-9)));
            assert!((apply(view.to_world(Axes::OpenCv), in_camera) - point).length() < 1e-12);
            let flipped = apply(view.from_world(Axes::OpenGl), point);
            assert!((flipped - in_camera * dvec3(1.0, -1.0, -1.0)).length() < 1e-12);
        }
        assert_eq!(view.project(settings.position - settings.direction), None);
    }
}

fn apply(m: [[f64; 4]; 4], p: DVec3) -> DVec3 {
    DVec3::from([0, 1, 2].map(|i| m[i][0] * p.x + m[i][1] * p.y + m[i][2] * p.z + m[i][3]))
}

#[test]
fn a_plane_has_the_depth_normal_and_position_of_the_plane() {
    let mut parts = Parts::default();
    let grey = parts.diffuse([0.25, 0.5, 0.75]);
    let (corner, u, v) = (dvec3(-30.0, -1.0, -30.0), dvec3(0.0, 0.0, 60.0), dvec3(60.0, 0.5, 0.0));
    parts.rectangle(corner, u, v, grey);
    let mut camera = camera(dvec3(1.0, 2.0, 9.0), dvec3(0.0, 0.0, 0.0));
    // The lens is not seen.
    let Projection::Perspective { lens_radius, focus_distance, aperture, .. } = &mut camera.projection else {
        unreachable!()
    };
    (*lens_radius, *focus_distance, *aperture) = (0.5, 3.0, Aperture::Polygon { blades: 3, rotation: 0.3 });
    let here = Frame::new(&parts.0, &[], camera);
    let labels = labels_of(&parts.0, settings(), &here, None);
    let (pinhole, normal) = (Pinhole::of(&camera), u.cross(v).normalize());
    let mut met = 0;
    for (i, place) in pixels() {
        let direction = pinhole.direction(place);
        let t = (corner - camera.position).dot(normal) / direction.dot(normal);
        let point = camera.position + direction * t;
        let inside = t > 0.0
            && (point - corner).dot(u) < u.length_squared()
            && (point - corner).dot(v) < v.length_squared()
            && (point - corner).dot(u) > 0.0
            && (point - corner).dot(v) > 0.0;
        assert_eq!(labels.object[i], u32::from(inside), "{place:?}");
        if !inside {
            assert_eq!((labels.depth[i], labels.material[i], labels.face[i]), (f32::INFINITY, 0, 0));
            assert!(labels.position[i].iter().all(|x| x.is_nan()) && labels.normal[i] == [0.0; 3]);
            continue;
        }
        met += 1;
        let depth = direction.dot(camera.direction.normalize()) * t;
        assert!(close(labels.depth[i].into(), depth, 2e-6 * depth), "{} {depth}", labels.depth[i]);
        assert!((DVec3::from(labels.position[i].map(f64::from)) - point).length() < 2e-6 * t);
        assert!((DVec3::from(labels.normal[i].map(f64::from)) - normal).length() < 1e-6);
        assert_eq!((labels.material[i], labels.albedo[i]), (1, [0.25, 0.5, 0.75]));
        assert!((1..=2).contains(&labels.face[i]));
    }
    assert!(met > 3000, "{met}");
    // From below, the normal is that of the other side.
    let below = common::camera(dvec3(1.0, -5.0, 9.0), dvec3(0.0, 0.0, 0.0));
    let labels = labels_of(&parts.0, settings(), &Frame::new(&parts.0, &[], below), None);
    let middle = (SIZE[0] * SIZE[1] / 2 + SIZE[0] / 2) as usize;
    assert!((DVec3::from(labels.normal[middle].map(f64::from)) + normal).length() < 1e-6);
}

/// A ball before a wall, and a box beside it.
fn ball_and_wall() -> (SceneParts, DVec3, f64) {
    let mut parts = Parts::default();
    let grey = parts.diffuse([0.5; 3]);
    parts.rectangle(dvec3(-50.0, -40.0, -3.0), dvec3(100.0, 0.0, 0.0), dvec3(0.0, 80.0, 0.0), grey);
    let (center, radius) = (dvec3(-0.4, 0.1, 1.0), 0.7);
    parts.sphere(center, radius, grey);
    (parts.0, center, radius)
}

#[test]
fn flow_and_occlusion_of_a_ball_that_passes_a_wall() {
    let (parts, center, radius) = ball_and_wall();
    let by = dvec3(0.55, 0.2, 0.3);
    let (before, after) =
        (camera(dvec3(0.1, 0.3, 8.0), dvec3(0.0, 0.0, 0.0)), camera(dvec3(0.2, 0.1, 7.5), dvec3(0.1, 0.0, 0.0)));
    for (from, to) in [(before, before), (before, after)] {
        let here = Frame::new(&parts, &still(2), from);
        let there = Frame::new(&parts, &[Pose::IDENTITY, shift(by)], to);
        let labels = labels_of(&parts, settings(), &here, Some(&there));
        let (p0, p1) = (Pinhole::of(&from), Pinhole::of(&to));
        let flow = labels.flow[0].as_ref().expect("flow");
        assert_eq!(labels.flow[0], labels.flow[1]);
        let (mut counts, mut undecided) = ([[0; 2]; 2], 0);
        for (i, place) in pixels() {
            let direction = p0.direction(place);
            let (ball, beside) = on_sphere(from.position, direction, center, radius);
            if close(beside, radius, 1e-4) {
                undecided += 1;
                continue;
            }
            assert_eq!(labels.object[i], 1 + u32::from(ball.is_some()), "{place:?}");
            let (moved, hidden) = match ball {
                Some(t) => {
                    let point = from.position + direction * t + by;
                    let normal = (point - center - by) / radius;
                    let cosine = normal.dot((to.position - point).normalize());
                    if close(cosine, 0.0, 1e-4) {
                        continue;
                    }
                    (point, cosine < 0.0)
                }
                None => {
                    let point = from.position + direction * ((-3.0 - from.position.z) / direction.z);
                    let back = (point - to.position).normalize();
                    let (_, beside) = on_sphere(to.position, back, center + by, radius);
                    if close(beside, radius, 1e-4) {
                        continue;
                    }
                    (point, beside < radius)
                }
            };
            let expected = p1.project(moved);
            for axis in 0..2 {
                let flow = f64::from(flow.to[i][axis]);
                assert!(close(flow, expected[axis] - place[axis], 1e-3), "{place:?}: {flow}, {expected:?}");
            }
            let occluded = hidden || !frame_holds(expected);
            assert_eq!(flow.occluded[i], u8::from(occluded), "{place:?} {expected:?}");
            counts[usize::from(ball.is_some())][usize::from(occluded)] += 1;
        }
        assert!(undecided < 40 && counts[0].iter().all(|n| *n > 100) && counts[1][0] > 300, "{undecided} {counts:?}");
    }
}

#[test]
fn what_rests_has_no_flow() {
    let (parts, ..) = ball_and_wall();
    let camera = camera(dvec3(0.1, 0.3, 170.0), dvec3(0.0, 0.0, 0.0));
    let here = Frame::new(&parts, &[], camera);
    let labels = labels_of(&parts, settings(), &here, Some(&here));
    let flow = labels.flow[0].as_ref().expect("flow");
    assert!(labels.object.contains(&0), "there is background");
    assert!(flow.to.iter().all(|flow| *flow == [0.0; 2]) && flow.occluded.iter().all(|occluded| *occluded == 0));
}

#[test]
fn a_ball_that_turns_hides_its_face() {
    let mut parts = Parts::default();
    let grey = parts.diffuse([0.5; 3]);
    let center = dvec3(0.3, 0.0, -0.2);
    parts.sphere(center, 1.0, grey);
    let mesh = parts.shape(ball(4));
    let place = DAffine3::from_translation(dvec3(-2.2, 0.3, 0.0)) * DAffine3::from_scale(dvec3(0.8, 0.6, 0.7));
    parts.place(mesh, place, grey);
    let parts = parts.0;
    let camera = camera(dvec3(-0.5, 0.4, 9.0), dvec3(-0.8, 0.0, 0.0));
    let here = Frame::new(&parts, &still(2), camera);
    let pose = turn(dvec3(0.1, 1.0, 0.2), 1.9);
    // Each about its own middle.
    let about = |middle: DVec3| Pose { translation: middle - pose.rotation * middle, ..pose };
    let poses = [about(center), about(place.translation)];
    let there = Frame::new(&parts, &poses, camera);
    let labels = labels_of(&parts, settings(), &here, Some(&there));
    let flow = labels.flow[0].as_ref().expect("flow");
    let pinhole = Pinhole::of(&camera);
    let mut counts = [[0; 2]; 2];
    for (i, place) in pixels().filter(|(i, _)| labels.object[*i] > 0) {
        let which = labels.object[i] as usize - 1;
        let direction = pinhole.direction(place);
        let point = match which {
            0 => on_sphere(camera.position, direction, center, 1.0).0.map(|t| camera.position + direction * t),
            _ => Some(DVec3::from(labels.position[i].map(f64::from))),
        };
        let Some(point) = point else { continue };
        let moved = poses[which].to_affine().transform_point3(point);
        let expected = pinhole.project(moved);
        assert!((0..2).all(|axis| close(flow.to[i][axis].into(), expected[axis] - place[axis], 1e-3)), "{place:?}");
        let normal = match which {
            0 => (point - center).normalize(),
            _ => DVec3::from(labels.normal[i].map(f64::from)),
        };
        let cosine = (pose.rotation * normal).dot((camera.position - moved).normalize());
        // Both are convex: what faces the camera is seen.
        if cosine.abs() > 1e-3 {
            assert_eq!(flow.occluded[i], u8::from(cosine < 0.0), "{which} {place:?} {cosine}");
            counts[which][usize::from(cosine < 0.0)] += 1;
        }
    }
    assert!(counts.iter().flatten().all(|n| *n > 40), "{counts:?}");
}

#[test]
fn the_background_turns_by_a_homography() {
    let (parts, center, radius) = ball_and_wall();
    let mut parts = parts;
    // Without the wall.
    parts.objects.remove(0);
    let from = camera(dvec3(0.1, 0.3, 8.0), center);
    let mut to = from;
    let turned = DQuat::from_axis_angle(dvec3(0.3, 1.0, 0.5).normalize(), 0.11);
    (to.direction, to.up, to.position) =
        (turned * from.direction, turned * from.up, from.position + dvec3(0.4, 0.0, 0.0));
    let (here, there) = (Frame::new(&parts, &still(1), from), Frame::new(&parts, &still(1), to));
    let labels = labels_of(&parts, settings(), &here, Some(&there));
    let flow = labels.flow[0].as_ref().expect("flow");
    let (p0, p1) = (Pinhole::of(&from), Pinhole::of(&to));
    let [cx, cy] = Pinhole::middle();
    let k = DMat3::from_cols(dvec3(p0.focal, 0.0, 0.0), dvec3(0.0, p0.focal, 0.0), dvec3(cx, cy, 1.0));
    let homography = k * p1.axes * p0.axes.transpose() * k.inverse();
    let mut counts = [0; 2];
    for (i, place) in pixels().filter(|(i, _)| labels.object[*i] == 0) {
        let p = homography * dvec3(place[0], place[1], 1.0);
        let expected = [p.x / p.z, p.y / p.z];
        assert!((0..2).all(|axis| close(flow.to[i][axis].into(), expected[axis] - place[axis], 1e-3)), "{place:?}");
        let (_, beside) = on_sphere(to.position, p0.direction(place), center, radius);
        if !close(beside, radius, 1e-4) {
            let occluded = beside < radius || !frame_holds(expected);
            assert_eq!(flow.occluded[i], u8::from(occluded), "{place:?}");
            counts[usize::from(occluded)] += 1;
        }
    }
    assert!(counts.iter().all(|n| *n > 500), "{counts:?}");
    // Behind the camera there is no place.
    to.direction = -from.direction;
    let labels = labels_of(&parts, settings(), &here, Some(&Frame::new(&parts, &still(1), to)));
    let flow = labels.flow[0].as_ref().expect("flow");
    assert!(flow.to.iter().flatten().all(|x| x.is_nan()) && flow.occluded.iter().all(|occluded| *occluded == 1));
}

#[test]
fn parallel_rays_and_where_they_begin() {
    let (parts, center, _) = ball_and_wall();
    let from = CameraSettings {
        projection: Projection::Orthographic { height: 4.0 },
        near_clip: 2.0,
        ..camera(dvec3(0.0, 0.0, 6.0), DVec3::ZERO)
    };
    let to = CameraSettings { position: from.position + dvec3(0.5, 0.0, 0.0), ..from };
    let here = Frame::new(&parts, &still(2), from);
    // The ball comes to lie before the plane where rays begin.
    let there = Frame::new(&parts, &[Pose::IDENTITY, shift(dvec3(0.0, 0.5, 5.0 - center.z))], to);
    let labels = labels_of(&parts, settings(), &here, Some(&there));
    let flow = labels.flow[0].as_ref().expect("flow");
    let pixel = 4.0 / f64::from(SIZE[1]);
    for (i, place) in pixels() {
        let up = if labels.object[i] == 2 { 0.5 } else { 0.0 };
        let expected = [-0.5 / pixel, -up / pixel];
        assert!((0..2).all(|axis| close(flow.to[i][axis].into(), expected[axis], 1e-3)), "{:?}", flow.to[i]);
        let inside = frame_holds([place[0] + expected[0], place[1] + expected[1]]);
        assert_eq!(flow.occluded[i] == 0, labels.object[i] == 1 && inside, "{place:?}");
    }
    // With the wall out of sight there is background, which parallel rays see the same part of for ever.
    let mut parts = parts;
    parts.objects.remove(0);
    let here = Frame::new(&parts, &still(1), from);
    let labels = labels_of(&parts, settings(), &here, Some(&Frame::new(&parts, &still(1), to)));
    let flow = labels.flow[0].as_ref().expect("flow");
    assert!(labels.object.iter().zip(&flow.to).all(|(object, flow)| *object == 1 || flow.iter().all(|x| x.is_nan())));
    let labels = labels_of(&parts, settings(), &here, Some(&here));
    assert!(labels.flow[0].as_ref().expect("flow").occluded.iter().all(|occluded| *occluded == 0));
}

#[test]
fn visible_fractions_of_squares_behind_cards() {
    let mut parts = Parts::default();
    let (grey, veil) = (parts.diffuse([0.5; 3]), parts.diffuse([0.5; 3]));
    parts.0.materials[veil].opacity = 0.4.into();
    let square = |parts: &mut Parts, x: f64, y: f64, z: f64, w: f64, h: f64, material| {
        parts.rectangle(dvec3(x, y, z), dvec3(w, 0.0, 0.0), dvec3(0.0, h, 0.0), material);
    };
    // An orthographic camera with ten pixels to the metre, whose picture reaches from -6, -4 to 6, 4.
    square(&mut parts, -5.0, -3.0, 0.0, 4.0, 4.0, grey);
    square(&mut parts, -2.0, -3.5, 1.0, 2.0, 5.0, grey);
    square(&mut parts, -5.0, -3.0, 2.0, 1.0, 4.0, veil);
    square(&mut parts, 4.0, 2.0, 0.0, 4.0, 1.0, grey);
    square(&mut parts, 20.0, 0.0, 0.0, 1.0, 1.0, grey);
    square(&mut parts, 1.0, -2.0, -1.0, 1.0, 1.0, grey);
    square(&mut parts, 0.5, -2.5, 0.5, 2.0, 2.0, grey);
    // Covers the same pixels as the square that it lies on, from behind the plane where rays begin too.
    square(&mut parts, -5.0, -3.0, 12.0, 4.0, 4.0, grey);
    let parts = parts.0;
    let camera = CameraSettings {
        projection: Projection::Orthographic { height: 8.0 },
        ..camera(dvec3(0.0, 0.0, 10.0), DVec3::ZERO)
    };
    let here = Frame::new(&parts, &[], camera);
    let labels = labels_of(&parts, settings(), &here, None);
    let seen = labels.visibility.as_ref().expect("visibility");
    let rect = |r: Option<etendue::film::PixelRect>| r.map(|r| [r.x0, r.y0, r.x1, r.y1]);
    let numbers = |i: usize| (seen[i].visible, seen[i].unoccluded);
    assert_eq!(numbers(0), (1200, 1600), "a quarter is behind the card");
    assert_eq!(
        (rect(seen[0].visible_box), rect(seen[0].unoccluded_box)),
        (Some([10, 30, 40, 70]), Some([10, 30, 50, 70]))
    );
    assert_eq!(numbers(1), (1000, 1000));
    assert_eq!(numbers(2), (0, 0), "less than half of it is there");
    assert_eq!(numbers(3), (200, 200), "what is outside of the picture does not count");
    assert_eq!((numbers(4), seen[4].fraction(), seen[4].visible_box), ((0, 0), None, None));
    assert_eq!((numbers(5), seen[5].fraction()), ((0, 100), Some(0.0)));
    assert_eq!(numbers(6), (400, 400));
    assert_eq!(numbers(7), (0, 0), "behind the camera");
    assert_eq!(seen[0].fraction(), Some(0.75));
}

/// Objects of all kinds in one another's way.
fn crowd() -> SceneParts {
    let mut parts = Parts::default();
    let own_material = |parts: &mut Parts| parts.diffuse([0.3, 0.6, 0.2]);
    let (single, shared) = (parts.shape(ball(3)), parts.shape(ball(2)));
    let mut random = 1u64;
    let mut next = || {
        random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (random >> 40) as f64 / (1u64 << 24) as f64
    };
    for number in 0..14 {
        let material = own_material(&mut parts);
        let at = dvec3(next() * 5.0 - 2.5, next() * 3.0 - 1.5, next() * 5.0 - 2.5);
        let scale = dvec3(0.4 + next(), 0.4 + next(), 0.4 + next());
        let place =
            DAffine3::from_translation(at) * DAffine3::from_rotation_x(6.0 * next()) * DAffine3::from_scale(scale);
        let uniform = DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(scale.x));
        match number % 4 {
            0 => parts.place(shared, place, material),
            1 => {
                let shape = parts.shape(etendue::scene::Shape::Sphere { center: dvec3(0.1, 0.0, 0.2), radius: 0.8 });
                parts.place(shape, if number == 1 { place } else { uniform }, material);
            }
            2 => parts.rectangle(at, dvec3(2.0 * next(), 1.0, 0.3), dvec3(-0.5, next(), 1.0), material),
            _ if number == 3 => parts.place(single, place, material),
            _ => {
                let shape = parts.shape(cube(false));
                parts.place(shape, place * DAffine3::from_scale(DVec3::splat(0.4)), material);
            }
        }
    }
    parts.0
}

#[test]
fn unoccluded_is_what_is_seen_when_all_others_are_not_there() {
    let parts = crowd();
    let inside = camera(dvec3(0.3, 0.2, 0.4), dvec3(1.0, 0.0, 0.0));
    for (view, least) in [(camera(dvec3(0.5, 1.0, 9.0), DVec3::ZERO), 8), (inside, 1)] {
        let labels = labels_of(&parts, settings(), &Frame::new(&parts, &[], view), None);
        let seen = labels.visibility.as_ref().expect("visibility");
        let mut hidden = 0;
        for (number, object) in parts.objects.iter().enumerate() {
            let mut alone = parts.clone();
            for material in (0..alone.materials.len()).filter(|m| *m != object.materials[0]) {
                alone.materials[material].opacity = 0.0.into();
            }
            let alone = labels_of(&alone, settings(), &Frame::new(&alone, &[], view), None);
            let expected = alone.object.iter().filter(|id| **id == number as u32 + 1).count() as u64;
            // The outline of spheres is that of exact ones.
            let slack = if number % 4 == 1 { 2 } else { 0 };
            let Some(found) = seen.get(number) else { panic!("{number}") };
            assert!(found.unoccluded.abs_diff(expected) <= slack, "{number}: {found:?}, alone {expected}");
            let visible = labels.object.iter().filter(|id| **id == number as u32 + 1).count() as u64;
            assert_eq!(found.visible, visible);
            hidden += usize::from(visible < expected);
        }
        assert!(hidden >= least, "{hidden}");
    }
}

#[test]
fn ids_stay_when_objects_leave_the_picture() {
    let (mut parts, ..) = ball_and_wall();
    let extra = parts.objects[1].clone();
    // A piece of the ball, and another object like it.
    parts.objects.push(extra.clone());
    parts.objects.push(etendue::scene::Object { name: "other".to_owned(), ..extra });
    let subjects = Subjects::of(&parts);
    let names: Vec<(&str, [usize; 2])> = subjects.list().iter().map(|s| (s.name.as_str(), s.objects)).collect();
    assert_eq!(names, [("o0", [0, 1]), ("o1", [1, 3]), ("other", [3, 4])]);
    let [low, high] = subjects.list()[1].bounds.expect("bounds");
    assert!((low - dvec3(-1.1, -0.6, 0.3)).length() < 1e-12 && (high - dvec3(0.3, 0.8, 1.7)).length() < 1e-12);
    let camera = camera(dvec3(0.1, 0.3, 8.0), dvec3(0.0, 0.0, 0.0));
    let away = shift(dvec3(100.0, 0.0, 0.0));
    let near = shift(dvec3(1.5, 0.0, 0.0));
    let ids = |poses: [Pose; 4]| {
        let labels = labels_of(&parts, settings(), &Frame::new(&parts, &poses, camera), None);
        let mut ids = labels.object.clone();
        ids.sort_unstable();
        ids.dedup();
        (ids, labels.visibility.expect("visibility").iter().map(|v| v.visible > 0).collect::<Vec<_>>())
    };
    assert_eq!(ids([Pose::IDENTITY, Pose::IDENTITY, Pose::IDENTITY, near]), (vec![1, 2, 3], vec![true; 3]));
    assert_eq!(ids([Pose::IDENTITY, away, away, near]), (vec![1, 3], vec![true, false, true]));
}

fn all_bits(labels: &Labels) -> Vec<u32> {
    let mut bits = Vec::new();
    bits.extend(labels.object.iter().chain(&labels.material).chain(&labels.face));
    bits.extend(labels.depth.iter().map(|x| x.to_bits()));
    let triples = labels.normal.iter().chain(&labels.position).chain(&labels.albedo);
    bits.extend(triples.flatten().map(|x| x.to_bits()));
    for flow in labels.flow.iter().flatten() {
        bits.extend(flow.to.iter().flatten().map(|x| x.to_bits()));
        bits.extend(flow.occluded.iter().map(|occluded| u32::from(*occluded)));
    }
    for seen in labels.visibility.iter().flatten() {
        bits.extend([seen.visible as u32, seen.unoccluded as u32]);
    }
    bits
}

#[test]
fn the_same_bits_whatever_finds_them() {
    let mut parts = crowd();
    parts.materials[3].opacity = 0.4.into();
    let poses: Vec<Pose> = (0..parts.objects.len())
        .map(|i| Pose { translation: dvec3(0.05 * i as f64, 0.1, 0.0), ..turn(dvec3(1.0, i as f64, 2.0), 0.1) })
        .collect();
    let (from, to) = (camera(dvec3(0.5, 1.0, 9.0), DVec3::ZERO), camera(dvec3(0.7, 1.0, 8.5), DVec3::ZERO));
    let run = |kind, isa, threads| {
        let (here, there) =
            (Frame::by(&parts, &still(poses.len()), from, kind, isa), Frame::by(&parts, &poses, to, kind, isa));
        all_bits(&labels_of(&parts, LabelSettings { threads, ..settings() }, &here, Some(&there)))
    };
    let expected = run(AcceleratorKind::Bvh, Isa::detect(), 1);
    assert!(expected.len() > 100_000);
    for kind in AcceleratorKind::ALL {
        assert!(run(kind, Isa::detect(), 3) == expected, "{kind}");
    }
    for isa in Isa::available() {
        assert!(run(AcceleratorKind::Bvh, isa, 2) == expected, "{isa}");
    }
}

#[test]
fn a_crop_has_the_labels_of_the_whole() {
    let parts = crowd();
    let camera = camera(dvec3(0.5, 1.0, 9.0), DVec3::ZERO);
    let here = Frame::new(&parts, &still(parts.objects.len()), camera);
    let poses = vec![shift(dvec3(0.3, 0.1, 0.0)); parts.objects.len()];
    let there = Frame::new(&parts, &poses, camera);
    let crop = [31, 17, 75, 60];
    let whole = labels_of(&parts, settings(), &here, Some(&there));
    let part = labels_of(&parts, LabelSettings { crop: Some(crop), ..settings() }, &here, Some(&there));
    let (whole_flow, part_flow) = (whole.flow[0].as_ref().expect("flow"), part.flow[0].as_ref().expect("flow"));
    let mut i = 0;
    for y in crop[1]..crop[3] {
        for x in crop[0]..crop[2] {
            let w = (y * SIZE[0] + x) as usize;
            assert_eq!((whole.object[w], whole.depth[w]), (part.object[i], part.depth[i]));
            assert_eq!((whole_flow.to[w], whole_flow.occluded[w]), (part_flow.to[i], part_flow.occluded[i]));
            i += 1;
        }
    }
    assert_eq!(i, part.object.len());
    let counted: u64 = part.visibility.expect("visibility").iter().map(|v| v.visible).sum();
    assert_eq!(counted, part.object.iter().filter(|id| **id > 0).count() as u64);
}

#[test]
fn what_is_not_asked_for_is_not_made() {
    let (parts, ..) = ball_and_wall();
    let here = Frame::new(&parts, &still(2), camera(dvec3(0.1, 0.3, 8.0), DVec3::ZERO));
    let labels = labels_of(&parts, LabelSettings { labels: vec![Label::Depth], ..settings() }, &here, None);
    assert_eq!(labels.depth.len(), labels.object.len());
    assert!(labels.material.is_empty() && labels.normal.is_empty() && labels.visibility.is_none());
    for label in Label::ALL {
        assert_eq!(label.name().parse::<Label>(), Ok(label));
    }
    assert!("nonsense".parse::<Label>().is_err());
}

#[test]
fn what_cannot_be_labelled_is_an_error() {
    let (parts, ..) = ball_and_wall();
    let new = |resolution, crop| Labeller::new(Subjects::of(&parts), LabelSettings { resolution, crop, ..settings() });
    assert!(matches!(new([0, 5], None), Err(LabelError::Size(0, 5))));
    assert!(matches!(new([1 << 20, 1 << 20], None), Err(LabelError::Size(..))));
    assert!(matches!(new(SIZE, Some([0, 0, 121, 5])), Err(LabelError::Crop(..))));
    assert!(matches!(new(SIZE, Some([5, 0, 5, 5])), Err(LabelError::Crop(..))));
    let mut labeller = new(SIZE, None).expect("a labeller");
    let mut here = Frame::new(&parts, &still(2), camera(dvec3(0.1, 0.3, 8.0), DVec3::ZERO));
    here.camera.up = here.camera.direction;
    assert!(matches!(labeller.label(&here.moment()), Err(LabelError::Camera(_))));
    let mut fewer = parts.clone();
    fewer.objects.pop();
    let fewer = Frame::new(&fewer, &[], here.camera);
    assert!(matches!(labeller.label(&fewer.moment()), Err(LabelError::Moment { expected: 2, found: 1 })));
}

#[test]
fn numbers_of_the_camera() {
    let camera = camera(dvec3(0.0, 0.0, 8.0), DVec3::ZERO);
    let k = View::new(&camera, SIZE).expect("a view").intrinsics();
    let focal = 60.0 / (20.0 * PI / 180.0).tan();
    assert!(close(k.fx, focal, 1e-9) && close(k.fy, focal, 1e-9) && k.cx == 60.0 && k.cy == 40.0 && !k.orthographic);
}
