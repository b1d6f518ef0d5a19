//! Values with keys, motion of objects, and keyframe files.
#![allow(clippy::disallowed_methods, reason = "references")]

use etendue::{
    math::{DAffine3, DMat3, DQuat, DVec3},
    motion::Shutter,
    scene::DeltaLight,
    spectrum::Spectrum,
};
use etendue_scene::{
    Diagnostics, Limits, SourceMap,
    animation::{FrameRate, LengthRecord},
    build,
    read::Part,
    read_scene, read_toml,
    timeline::{Clock, Moment, Timeline},
};
use std::{f64::consts::FRAC_PI_2, fs, path::Path};

const CAMERA: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n";

/// What is wrong with a scene, each with its line.
fn wrong(text: &str) -> Vec<String> {
    let mut sources = SourceMap::new();
    let file = sources.insert("s.toml", text.as_bytes().to_vec()).unwrap();
    let (_, found) = read_toml(file, text.as_bytes(), Path::new(""));
    found.iter().map(|d| d.one_line(&sources)).collect()
}

struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.0.path().join(name), bytes).unwrap();
    }

    /// The timeline of a scene, or what is wrong with it.
    fn timeline(&self, text: &str) -> Result<Timeline, String> {
        self.put("s.toml", text);
        let mut sources = SourceMap::new();
        let limits = Limits::default();
        let told = |found: Diagnostics, sources: &SourceMap| {
            found.iter().map(|d| d.one_line(sources)).collect::<Vec<_>>().join("\n")
        };
        let (description, found) = read_scene(&self.0.path().join("s.toml"), &mut sources, &limits).unwrap();
        let Some(description) = description else { return Err(told(found, &sources)) };
        let input = build(&description, &mut sources, &limits).map_err(|found| told(found, &sources))?;
        Timeline::new(&description, input, &mut sources, &limits).map_err(|found| told(found, &sources))
    }
}

fn timeline(text: &str) -> Timeline {
    Folder::new().timeline(text).unwrap()
}

#[test]
fn values_with_keys() {
    let scene = timeline(
        r##"
        camera = { position = { keys = [[0, [0, 0, 5]], [2, [4, 0, 5]]] }, look_at = [0, 0, 0], fov = { keys = [[1, 40], [2, 20]] } }
        animation = { start = 1 }
        environment = { top = { keys = [[0, 0], [1, 2]] }, bottom = 1 }
        materials.a = { type = "diffuse", reflectance = { keys = [[0, [1, 0, 0]], [1, "#000000"]] } }
        materials.b = { type = "principled", roughness = { keys = [[0, 0.2], [4, 1]], interpolation = "step" } }
        materials.c = { type = "black", emission = { keys = [[0, 0], [1, [1, 2, 3]]] } }
        lights = [{ position = { keys = [[0, [0, 4, 0]], [1, [0, 6, 0]]] }, intensity = 3 }]
        "##,
    );
    let camera = scene.camera(1.5).unwrap();
    assert_eq!(camera.position, DVec3::new(3.0, 0.0, 5.0));
    assert_eq!(scene.input().camera, scene.camera(1.0).unwrap(), "what is built is of the start");
    assert!(
        matches!(camera.projection, etendue::camera::Projection::Perspective { fov, .. } if (fov - 30f64.to_radians()).abs() < 1e-12)
    );
    let parts = |time| scene.parts(Moment::at(time)).unwrap();
    let reflectance = |time| match &parts(time).materials[0].scattering {
        etendue::material::Scattering::Diffuse { reflectance, .. } => reflectance.factor,
        other => panic!("{other:?}"),
    };
    assert_eq!((reflectance(0.5), reflectance(7.0)), (Spectrum([0.5, 0.0, 0.0]), Spectrum::BLACK));
    let emission = parts(0.5).materials[2].emission.as_ref().unwrap().radiance.factor;
    assert_eq!(emission, Spectrum([0.5, 1.0, 1.5]));
    let DeltaLight::Point { position, .. } = parts(0.25).delta_lights[0] else { panic!() };
    assert_eq!(position, DVec3::new(0.0, 4.5, 0.0));
    let changes = scene.changes(Moment::at(0.5)).unwrap();
    assert_eq!(changes.materials.iter().map(|(index, _)| *index).collect::<Vec<_>>(), [0, 1, 2]);
    assert!(changes.environment.is_some() && changes.motions.is_empty());
    assert_eq!(scene.frames(&Clock::new(scene.animation())), Some(76), "up to the last key");
}

/// A part of a file is only read again where it has keys, and only those records are given anew.
#[test]
fn what_has_no_keys_is_left_alone() {
    let scene = timeline(&format!(
        "{CAMERA}materials.a = {{ type = \"diffuse\" }}\nmaterials.b = {{ type = \"mirror\", reflectance = {{ keys = [[0, 0], [1, 1]] }} }}\n"
    ));
    let changes = scene.changes(Moment::at(0.5)).unwrap();
    assert_eq!(changes.materials.iter().map(|(index, _)| *index).collect::<Vec<_>>(), [1]);
    assert!(changes.delta_lights.is_none() && changes.environment.is_none());
    assert!(!scene.camera_changes());
    let still = timeline(CAMERA);
    assert_eq!(still.frames(&Clock::new(still.animation())), None);
    let mut sources = SourceMap::new();
    let file = sources.insert("s", CAMERA.as_bytes().to_vec()).unwrap();
    let varying = read_toml(file, CAMERA.as_bytes(), Path::new("")).0.unwrap().varying;
    assert!(varying.is_empty() && Part::ALL.iter().all(|part| !varying.has(*part)));
}

#[test]
fn animations() {
    let text = format!(
        "{CAMERA}[animation]\nstart = 2\nspeed = 0.5\nfps = \"30000/1001\"\nduration = 3\nshutter = [-0.25, 0.25]\nshutter_curve = [0.25, 0.5]\n"
    );
    let scene = timeline(&text);
    let animation = scene.animation();
    assert_eq!(animation.fps, FrameRate { numerator: 30_000, denominator: 1001 });
    assert_eq!(animation.curve, Shutter::Trapezoid { rise: 0.25, fall: 0.5 });
    assert_eq!(animation.length, Some(LengthRecord::Duration(3.0)));
    let clock = Clock::new(animation);
    let interval = 0.5 * 1001.0 / 30_000.0;
    assert!((clock.interval - interval).abs() < 1e-15);
    let moment = clock.moment(10);
    assert!((moment.time - (2.0 + 10.0 * interval)).abs() < 1e-12);
    assert!((moment.shutter[1] - moment.time - 0.25 * interval).abs() < 1e-12);
    assert_eq!(scene.frames(&clock), Some(180));
    assert_eq!(
        timeline(&format!("{CAMERA}animation = {{ frames = 7, shutter = 0.5 }}")).animation().shutter,
        [0.0, 0.5]
    );
}

#[test]
fn mistakes_have_their_places() {
    for (line, part) in [
        ("camera.fov = { keys = [[0, 40], [1, 200]] }", "`fov` is out of range: 200"),
        ("camera.fov = { keys = [[1, 40], [1, 50]] }", "keys must be in order of time"),
        ("camera.fov = { keys = [] }", "there are no keys"),
        ("camera.fov = { keys = [[0, 40, 1]] }", "a key is a time and a value"),
        ("camera.fov = { keys = [0, 40] }", "`keys` must be a key"),
        ("camera.fov = { keys = [[0, [1, 2, 3]]] }", "`fov` must be a number"),
        ("camera.fov = { keys = [[nan, 40]] }", "is NaN"),
        ("camera.fov = { keys = [[0, 40]], interpolation = \"smooth\" }", "has no `smooth`"),
        ("camera.fov = { keys = [[0, 40]], times = 3 }", "unknown key `times`"),
        ("camera.up = { keys = [[0, [0, 0, 0]]] }", "`up` is zero"),
        ("objects = [{ shape = \"sphere\", radius = { keys = [[0, 1]] } }]", "`radius` cannot change over time"),
        ("film.exposure = { keys = [[0, 1]] }", "`exposure` cannot change over time"),
        ("objects = [{ shape = \"sphere\", motion = {} }]", "motion needs `translate` or `rotate`"),
        (
            "objects = [{ shape = \"sphere\", motion = { rotate = { keys = [[0, [0, 0, 0, 2]]] } } }]",
            "no unit quaternion",
        ),
        (
            "objects = [{ shape = \"sphere\", motion = { translate = { keys = [[0, [1, 2, 3]]], interpolation = \"step\" } } }]",
            "does not jump",
        ),
        (
            "objects = [{ shape = \"sphere\", body = \"dynamic\", motion = { translate = [1, 2, 3] } }]",
            "a dynamic body moves by itself",
        ),
        ("animation = { shutter = [0.5, 0] }", "closes before it opens"),
        ("animation = { shutter_curve = [0.7, 0.7] }", "falls before it has risen"),
        ("animation = { fps = \"25/0\" }", "is no frame rate"),
        ("animation = { frames = 1, duration = 1 }", "exclude each other"),
        ("animation = { keyframes = { file = \"a.npy\", times = [0, 2, 1] } }", "times must be ascending"),
    ] {
        let text = format!("camera.position = [0, 0, 5]\ncamera.look_at = [0, 0, 0]\n{line}\n");
        let found = wrong(&text);
        assert!(found.iter().any(|f| f.contains(part) && f.contains("s.toml:3:")), "{line}\n{found:#?}");
    }
}

/// Cameras whose numbers have no sense together at some time are told then.
#[test]
fn a_camera_may_have_no_sense_at_a_time() {
    let scene = timeline("camera = { position = { keys = [[0, [0, 0, 5]], [1, [0, 0, -5]]] }, look_at = [0, 0, 0] }");
    assert!(scene.camera(0.25).is_ok());
    let error = scene.camera(0.5).unwrap_err();
    assert!(error.iter().any(|d| d.message.contains("the camera's own position")), "{error:?}");
}

#[test]
fn objects_move_from_where_they_are_placed() {
    let scene = timeline(&format!(
        r#"{CAMERA}
        [[objects]]
        shape = "box"
        transform = [{{ translate = [3, 0, 0] }}]
        motion = {{ rotate = {{ axis = "y", angle = {{ keys = [[0, 0], [1, 360]] }} }}, translate = {{ keys = [[0, [0, 0, 0]], [1, [0, 2, 0]]] }} }}
        [[objects]]
        shape = "sphere"
        center = [0, 1, 0]
        motion = {{ rotate = {{ keys = [[0, {{ axis = "z", angle = 0 }}], [1, {{ axis = "z", angle = 90 }}]] }}, pivot = [0, 0, 0] }}
        [[objects]]
        shape = "sphere"
        motion = {{ translate = {{ keys = [[0, [0, 0, 0]], [1, [0, 0, 0]]] }} }}
        "#
    ));
    let poses = scene.poses(0.25);
    let at = |index: usize, p: DVec3| {
        let transform = scene.input().parts.objects[index].transform;
        poses[index].to_affine().transform_point3(transform.transform_point3(p))
    };
    assert!((at(0, DVec3::ZERO) - DVec3::new(3.0, 0.5, 0.0)).length() < 1e-12, "it turns about its middle");
    assert!((at(0, DVec3::X) - DVec3::new(3.0, 0.5, -1.0)).length() < 1e-12);
    let half = 22.5f64.to_radians();
    assert!((at(1, DVec3::Y) - DVec3::new(-half.sin(), half.cos(), 0.0)).length() < 1e-12, "about its pivot");
    let moves: Vec<bool> = (0..3).map(|object| scene.track(object).is_some()).collect();
    assert_eq!(moves, [true, true, false], "what stays where it is does not move");
    let parts = scene.parts(Moment { time: 0.0, shutter: [0.0, 0.5] }).unwrap();
    assert!(parts.objects[0].motion.as_ref().is_some_and(|motion| !motion.is_still()));
    assert!(parts.objects[2].motion.is_none());
}

#[test]
fn focus_follows_what_moves() {
    let scene = timeline(
        r#"
        camera = { position = [0, 0, 5], direction = [0, 0, -1], lens_radius = 0.1, focus_object = "ball" }
        [[objects]]
        name = "ball"
        shape = "sphere"
        motion = { translate = { keys = [[0, [0, 0, 0]], [1, [0, 0, -4]]] } }
        "#,
    );
    let distance = |time| match scene.camera(time).unwrap().projection {
        etendue::camera::Projection::Perspective { focus_distance, .. } => focus_distance,
        _ => panic!(),
    };
    assert!(scene.camera_changes());
    assert!((distance(0.0) - 5.0).abs() < 1e-9 && (distance(0.5) - 7.0).abs() < 1e-9);
    let motion = scene.camera_motion(Moment { time: 0.0, shutter: [0.0, 0.1] }).unwrap().unwrap();
    assert!(motion.keys.len() > 10 && motion.keys[0].0 == 0.0 && motion.keys.last().unwrap().0 == 1.0);
}

const TWO: &str = r#"
    [[objects]]
    name = "ball"
    shape = "sphere"
    transform = [{ scale = 2 }, { translate = [0, 0, 1] }]
    [[objects]]
    name = "cube"
    shape = "box"
"#;

fn motion_json(times: &str, name: &str, positions: &str, rotations: &str) -> String {
    format!(
        r#"{{"format": "etendue-motion", "version": 1, "hash": "abc",
        "times": {times},
        "objects": [{{"name": "{name}", "positions": {positions}, "rotations": {rotations}}}]}}"#
    )
}

const STILL: &str = "[[0,0,0,1],[0,0,0,1]]";

#[test]
fn keyframes_of_json() {
    let folder = Folder::new();
    folder.put("m.json", motion_json("[0, 2]", "ball", "[[0,0,0],[0.1,4,0]]", STILL));
    let scene = folder.timeline(&format!("{CAMERA}animation = {{ keyframes = \"m.json\" }}\n{TWO}")).unwrap();
    let track = scene.track(0).unwrap();
    assert_eq!(track.poses[1].translation, DVec3::new(0.1, 4.0, 0.0), "numbers are read exactly");
    assert_eq!(scene.poses(1.0)[0].translation, DVec3::new(0.05, 2.0, 0.0));
    assert!(scene.track(1).is_none());
    assert!(scene.input().files.iter().any(|file| file.ends_with("m.json")), "it counts among the scene's files");
    assert_eq!(scene.frames(&Clock::new(scene.animation())), Some(51));
    // Under another name, at other times, as places.
    let text = format!(
        "{CAMERA}[animation.keyframes]\nfile = \"m.json\"\nobjects = [\"cube\"]\ntimes = [1, 2]\nrelative = false\ninterpolation = \"cubic\"\n{TWO}"
    );
    let scene = folder.timeline(&text).unwrap();
    assert!(scene.track(0).is_none());
    assert_eq!(*scene.track(1).unwrap().times, [1.0, 2.0]);
}

#[test]
fn keyframes_that_do_not_fit() {
    let two = "[[0,0,0],[1,0,0]]";
    let json = |text: &str| ("m.json", text.as_bytes().to_vec());
    let good = motion_json("[0, 1]", "ball", two, STILL);
    for (file, part) in [
        (json(&motion_json("[1, 1]", "ball", two, STILL)), "error: times must be ascending, but 1 follows 1"),
        (json(&motion_json("[]", "ball", two, STILL)), "there are no times"),
        (json(&motion_json("[0, 1, 2]", "ball", two, STILL)), "error: `ball` has 2 positions, but there are 3 times"),
        (json(&motion_json("[0, 1]", "ball", two, "[[0,0,0,1]]")), "`ball` has 1 rotations"),
        (json(&motion_json("[0, 1]", "ball", two, "[[0,0,0,1],[0,0,0,0]]")), "error: a rotation is a unit quaternion"),
        (json(&motion_json("[0, 1]", "ball", "[[0,0,0],[1e999,0,0]]", STILL)), "m.json:3"),
        (json(&motion_json("[0, 1]", "ball", "[[0,0,0],[NaN,0,0]]", STILL)), "m.json:3"),
        (json(&motion_json("[0, 1]", "ball", "[[0,0,0],[1e300,0,0]]", STILL)), "too far away"),
        (json(&motion_json("[0, 1]", "bell", two, STILL)), "moves no object of the scene"),
        (json(&good.replace("etendue-motion", "other")), "expected `etendue-motion`"),
        (json(&good.replace("\"version\": 1", "\"version\": 2")), "version 2 of the format is not known"),
        (json(&good.replace("hash", "hush")), "unknown field `hush`"),
        (json(&good[..60]), "m.json:2"),
        (json("hello"), "this is no file of poses"),
        (json(""), "this is no file of poses"),
    ] {
        let folder = Folder::new();
        folder.put(file.0, &file.1);
        let error = folder.timeline(&format!("{CAMERA}animation = {{ keyframes = \"m.json\" }}\n{TWO}")).unwrap_err();
        assert!(error.contains(part), "{part}\n{error}");
    }
    let folder = Folder::new();
    let error = folder.timeline(&format!("{CAMERA}animation = {{ keyframes = \"no.json\" }}\n{TWO}")).unwrap_err();
    assert!(error.contains("s.toml:2:") && error.contains("no such file"), "{error}");
    folder.put("m.json", &good);
    for (keyframes, part) in [
        ("objects = [\"ball\", \"cube\"]", "the file has poses of 1 objects, `objects` names 2"),
        ("times = [0]", "the file has 2 rows of poses, `times` has 1"),
    ] {
        let text = format!("{CAMERA}animation = {{ keyframes = {{ file = \"m.json\", {keyframes} }} }}\n{TWO}");
        let error = folder.timeline(&text).unwrap_err();
        assert!(error.contains(part), "{part}\n{error}");
    }
    let moved =
        TWO.replacen("shape", "motion = { translate = { keys = [[0, [0, 0, 0]], [1, [1, 0, 0]]] } }\n    shape", 1);
    let error = folder.timeline(&format!("{CAMERA}animation = {{ keyframes = \"m.json\" }}\n{moved}")).unwrap_err();
    assert!(error.contains("has a `motion` of its own"), "{error}");
}

/// An array of matrices as NumPy saves it.
fn npy(descr: &str, fortran: bool, shape: [usize; 4], at: impl Fn([usize; 4]) -> f64) -> Vec<u8> {
    let [t, n, r, c] = shape;
    let order = if fortran { "True" } else { "False" };
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': {order}, 'shape': ({t}, {n}, {r}, {c}), }}").into_bytes();
    header.resize((header.len() + 10).next_multiple_of(64) - 11, b' ');
    header.push(b'\n');
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header);
    let mut index = [0; 4];
    for flat in 0..t * n * r * c {
        let mut rest = flat;
        let order: [usize; 4] = if fortran { [0, 1, 2, 3] } else { [3, 2, 1, 0] };
        for dimension in order {
            index[dimension] = rest % shape[dimension];
            rest /= shape[dimension];
        }
        let value = at(index);
        match descr {
            "<f4" => bytes.extend((value as f32).to_le_bytes()),
            _ => bytes.extend(value.to_le_bytes()),
        }
    }
    bytes
}

/// Object to world of object `n` in row `t`.
fn matrix(t: usize, n: usize) -> DAffine3 {
    let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.3 * t as f64 + n as f64);
    DAffine3::from_rotation_translation(turn, DVec3::new(t as f64, n as f64, -1.0))
}

fn cell([t, n, r, c]: [usize; 4]) -> f64 {
    let affine = matrix(t, n);
    match (r, c) {
        (3, 3) => 1.0,
        (3, _) => 0.0,
        (r, 3) => affine.translation[r],
        (r, c) => affine.matrix3.col(c)[r],
    }
}

#[test]
fn keyframes_of_numpy() {
    for (descr, fortran) in [("<f8", false), ("<f8", true), ("<f4", false), ("<f4", true)] {
        let folder = Folder::new();
        folder.put("p.npy", npy(descr, fortran, [4, 2, 4, 4], cell));
        let keyframes = "keyframes = { file = \"p.npy\", objects = [\"ball\", \"cube\"], start = 1, fps = 2 }";
        let scene = folder.timeline(&format!("{CAMERA}animation = {{ {keyframes} }}\n{TWO}")).unwrap();
        for (n, scale) in [(0, 2.0), (1, 1.0)] {
            let track = scene.track(n).unwrap();
            assert_eq!(*track.times, [1.0, 1.5, 2.0, 2.5]);
            for t in 0..4 {
                let world = track.poses[t].to_affine() * scene.input().parts.objects[n].transform;
                let expected = matrix(t, n) * DAffine3::from_scale(DVec3::splat(scale));
                assert!(world.abs_diff_eq(expected, 1e-6), "{descr} {fortran} {t} {n}: {world:?} {expected:?}");
            }
        }
    }
}

/// An absolute pose has the object's own origin go straight between rows.
#[test]
fn absolute_poses_turn_about_the_origin_of_the_object() {
    let folder = Folder::new();
    let spin = |[t, _, r, c]: [usize; 4]| {
        let turn = DMat3::from_rotation_z(FRAC_PI_2 * t as f64);
        match (r, c) {
            (3, 3) => 1.0,
            (3, _) => 0.0,
            (r, 3) => [10.0, 0.0, 0.0][r],
            (r, c) => turn.col(c)[r],
        }
    };
    folder.put("p.npy", npy("<f8", false, [2, 1, 4, 4], spin));
    let keyframes = "keyframes = { file = \"p.npy\", objects = [\"ball\"], fps = 1 }";
    let scene = folder.timeline(&format!("{CAMERA}animation = {{ {keyframes} }}\n{TWO}")).unwrap();
    let transform = scene.input().parts.objects[0].transform;
    let origin = (scene.poses(0.5)[0].to_affine() * transform).transform_point3(DVec3::ZERO);
    assert!((origin - DVec3::new(10.0, 0.0, 0.0)).length() < 1e-12, "{origin}");
}

#[test]
fn arrays_that_are_no_poses() {
    let whole = |at: fn([usize; 4]) -> f64| npy("<f8", false, [2, 2, 4, 4], at);
    let cases: [(Vec<u8>, &str); 8] = [
        (whole(|i| if i == [1, 0, 2, 3] { f64::NAN } else { cell(i) }), "poses[1, 0] has a number that is not finite"),
        (whole(|i| if i[2] < 3 && i[3] < 3 { 1.5 * cell(i) } else { cell(i) }), "poses[0, 0] scales or shears"),
        (whole(|i| if i[2] == 0 { -cell(i) } else { cell(i) }), "poses[0, 0] mirrors"),
        (whole(|i| if i == [0, 1, 3, 0] { 0.5 } else { cell(i) }), "poses[0, 1] has another last row"),
        (npy("<f8", false, [2, 2, 3, 4], cell), "shape (2, 2, 3, 4) is no array of poses"),
        (npy("<f8", false, [0, 2, 4, 4], cell), "has no poses"),
        (npy("<i8", false, [2, 2, 4, 4], cell), "type `<i8`"),
        (whole(cell)[..400].to_vec(), "bytes of samples, but shape and type make 512"),
    ];
    for (bytes, part) in cases {
        let folder = Folder::new();
        folder.put("p.npy", bytes);
        let keyframes = "keyframes = { file = \"p.npy\", objects = [\"ball\", \"cube\"] }";
        let error = folder.timeline(&format!("{CAMERA}animation = {{ {keyframes} }}\n{TWO}")).unwrap_err();
        assert!(error.contains(part) && error.contains("p.npy:"), "{part}\n{error}");
    }
    let folder = Folder::new();
    let huge = "{'descr': '<f8', 'fortran_order': False, 'shape': (4294967296, 4294967296, 4, 4), }";
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((huge.len() as u16).to_le_bytes());
    bytes.extend(huge.as_bytes());
    folder.put("p.npy", bytes);
    let error = folder.timeline(&format!("{CAMERA}animation = {{ keyframes = \"p.npy\" }}\n{TWO}")).unwrap_err();
    assert!(error.contains("at most"), "{error}");
    folder.put("p.npy", whole(cell));
    let error = folder.timeline(&format!("{CAMERA}animation = {{ keyframes = \"p.npy\" }}\n{TWO}")).unwrap_err();
    assert!(error.contains("does not say which objects it moves"), "{error}");
}
