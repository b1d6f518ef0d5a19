//! From scene files on disk to the renderer's parts.
#![allow(clippy::disallowed_methods)]

use etendue::{
    camera::{Aperture, FovAxis, Projection},
    math::DVec3,
    scene::{SceneParts, Shape},
};
use etendue_scene::{Diagnostics, Input, Limits, ReadError, SourceMap, build, read_scene};
use std::{fs, path::Path};

#[path = "../examples/make_mesh.rs"]
mod make_mesh;

const CAMERA: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n";
const TRIANGLES: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 2\nf 1 2 3\nf 2 4 3\n";

fn lines(found: &Diagnostics, sources: &SourceMap, folder: &Path) -> Vec<String> {
    let prefix = format!("{}/", folder.display());
    found.iter().map(|d| d.one_line(sources).replace(&prefix, "")).collect()
}

/// Reads and builds `text` in a folder with some files.
fn run_with(text: &str, files: &[(&str, &[u8])], limits: &Limits) -> Result<Input, Vec<String>> {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in files {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    let path = folder.path().join("scene.toml");
    let text = if text.contains("[camera]") { text.to_owned() } else { format!("{CAMERA}{text}") };
    fs::write(&path, text).unwrap();
    let mut sources = SourceMap::new();
    let (description, found) = read_scene(&path, &mut sources, limits).unwrap();
    let Some(description) = description else { return Err(lines(&found, &sources, folder.path())) };
    build(&description, &mut sources, limits).map_err(|found| lines(&found, &sources, folder.path()))
}

fn run(text: &str, files: &[(&str, &[u8])]) -> Result<Input, Vec<String>> {
    run_with(text, files, &Limits::default())
}

/// The lowest and highest corner of an object in the world, from its parts.
fn bounds(parts: &SceneParts, object: usize) -> (DVec3, DVec3) {
    let object = &parts.objects[object];
    let points: Vec<DVec3> = match &parts.shapes[object.shape] {
        Shape::Mesh(mesh) => mesh.positions.iter().map(|p| mesh.origin + DVec3::from_array(p.map(f64::from))).collect(),
        Shape::Rectangle { corner, u, v } => vec![*corner, *corner + *u, *corner + *v, *corner + *u + *v],
        Shape::Sphere { center, radius } => {
            let ring = (0..3600).map(|i| f64::from(i) * 0.1f64.to_radians());
            let at = |t: f64, p: f64| *center + DVec3::new(t.sin() * p.cos(), t.sin() * p.sin(), t.cos()) * *radius;
            ring.flat_map(|p| (0..=180).map(move |t| (f64::from(t).to_radians(), p))).map(|(t, p)| at(t, p)).collect()
        }
    };
    let placed = points.into_iter().map(|p| object.transform.transform_point3(p));
    placed.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
}

fn near(a: DVec3, b: DVec3, tolerance: f64) -> bool {
    (a - b).abs().max_element() <= tolerance
}

#[test]
fn a_file_is_read_once_and_shared() {
    let input = run(
        "[meshes.m]\nfile = \"a.obj\"\n[[objects]]\nmesh = \"m\"\n[[objects]]\nfile = \"a.obj\"\ntransform = { scale = 2 }\n\
         [meshes.unused]\nfile = \"b.obj\"\n",
        &[("a.obj", TRIANGLES.as_bytes()), ("b.obj", TRIANGLES.as_bytes())],
    )
    .unwrap();
    assert_eq!((input.parts.shapes.len(), input.parts.objects.len(), input.files.len()), (1, 2, 2));
    assert_eq!(input.parts.objects[1].shape, 0);
}

#[test]
fn materials_of_files_and_their_override() {
    let obj = format!("mtllib a.mtl\nusemtl red\n{TRIANGLES}").replace("f 2 4 3", "usemtl blue\nf 2 4 3");
    let mtl = "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n";
    let input = run(
        "[materials.m]\ntype = \"mirror\"\n[[objects]]\nfile = \"a.obj\"\n[[objects]]\nfile = \"a.obj\"\nmaterial = \"m\"\n\
         [[objects]]\nshape = \"sphere\"\n",
        &[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())],
    )
    .unwrap();
    let parts = &input.parts;
    let names = |i: usize| -> Vec<&str> {
        parts.objects[i].materials.iter().map(|m| parts.materials[*m].name.as_str()).collect()
    };
    assert_eq!(names(0), ["red", "blue"]);
    assert_eq!(names(1), ["m", "m"]);
    assert_eq!(names(2), [""]);
    assert_eq!(input.files.iter().filter(|f| f.ends_with("a.mtl")).count(), 1);
}

#[test]
fn spheres_boxes_and_disks_are_shared_where_they_are_moved() {
    let object = |shape: &str, rest: &str| format!("[[objects]]\nshape = \"{shape}\"\n{rest}\n");
    let moved = "transform = [{ translate = [1, 0, 0] }]";
    let text: String = ["sphere", "box", "disk"].iter().map(|s| object(s, moved).repeat(3)).collect();
    let input = run(&format!("{text}{}", object("rectangle", moved).repeat(2)), &[]).unwrap();
    assert_eq!((input.parts.objects.len(), input.parts.shapes.len()), (11, 5));
    let input = run(&object("sphere", "").repeat(2), &[]).unwrap();
    assert_eq!(input.parts.shapes.len(), 2);
}

#[test]
fn spheres_of_a_file_go_with_its_mesh() {
    let obj = format!(
        "mtllib a.mtl\nsphere 2 0 0 1\nusemtl red\n{TRIANGLES}usemtl blue\nsphere 0 -3 0 1\nusemtl red\nsphere 0 0 9 0.5\n"
    );
    let mtl = "newmtl red\nKd 1 0 0\nnewmtl blue\nKd 0 0 1\n";
    let files: &[(&str, &[u8])] = &[("a.obj", obj.as_bytes()), ("a.mtl", mtl.as_bytes())];
    let input = run(
        "[materials.m]\ntype = \"mirror\"\n[[objects]]\nfile = \"a.obj\"\nname = \"all\"\n\
         transform = [{ scale = 2 }, { relocate = [5, 6, 7] }]\n[[objects]]\nfile = \"a.obj\"\nmaterial = \"m\"\n",
        files,
    )
    .unwrap();
    let parts = &input.parts;
    assert_eq!((parts.shapes.len(), parts.objects.len()), (4, 8));
    let names = |i: usize| -> Vec<&str> {
        parts.objects[i].materials.iter().map(|m| parts.materials[*m].name.as_str()).collect()
    };
    // Materials of faces first, then those of spheres: red, none, blue.
    assert_eq!(names(0), ["red", "", "blue"]);
    assert_eq!([1, 2, 3].map(names), [[""], ["blue"], ["red"]]);
    assert_eq!([4, 5, 6, 7].map(|i| names(i).contains(&"m")), [true; 4]);
    assert!((0..4).all(|i| parts.objects[i].name == "all" && parts.objects[i].transform == parts.objects[0].transform));
    let lowest = (0..4).map(|i| bounds(parts, i).0).fold(DVec3::INFINITY, DVec3::min);
    assert!(near(lowest, DVec3::new(5.0, 6.0, 7.0), 1e-3), "{lowest}");

    let input = run("[[objects]]\nfile = \"s.obj\"\n", &[("s.obj", b"sphere 1 2 3 4\n")]).unwrap();
    assert!(matches!(input.parts.shapes[..], [Shape::Sphere { radius: 4.0, .. }]));
    let many = Limits { placed: 3, ..Limits::default() };
    let errors = run_with("[[objects]]\nfile = \"a.obj\"\n", files, &many).unwrap_err();
    assert_eq!(errors, ["scene.toml:2:1: error: the objects place more than 3 shapes"]);
}

#[test]
fn crease_angles_of_files_and_inline_meshes() {
    let fold = "v 0 0 0\nv 0 1 0\nv 1 0 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\n";
    let inline = "[meshes.m]\npositions = [[0,0,0],[0,1,0],[1,0,0],[0,0,1]]\nindices = [[0,2,1],[0,1,3]]\n";
    let text = format!(
        "{inline}crease_angle = 100\n[meshes.f]\nfile = \"a.obj\"\ncrease_angle = 100\n\
         [[objects]]\nmesh = \"m\"\n[[objects]]\nmesh = \"f\"\n[[objects]]\nfile = \"a.obj\"\n\
         [[objects]]\nfile = \"a.obj\"\ncrease_angle = 80\n[[objects]]\nfile = \"s.obj\"\ncrease_angle = 80\n\
         [[objects]]\nfile = \"a.obj\"\ncrease_angle = 100\n"
    );
    let smooth = format!("s 1\n{fold}");
    let input = run(&text, &[("a.obj", fold.as_bytes()), ("s.obj", smooth.as_bytes())]).unwrap();
    let vertices = |i: usize| match &input.parts.shapes[input.parts.objects[i].shape] {
        Shape::Mesh(mesh) => (mesh.positions.len(), mesh.normals.is_some()),
        _ => panic!(),
    };
    let expected = [(4, true), (4, true), (4, false), (6, true), (4, true), (4, true)];
    assert_eq!([0, 1, 2, 3, 4, 5].map(vertices), expected);
    assert_eq!(input.parts.objects[5].shape, input.parts.objects[1].shape);
    let notes: Vec<&str> = input.findings.iter().map(|d| d.message.as_str()).collect();
    assert_eq!(notes, ["`crease_angle` is not used: the file has normals or smoothing groups"]);
    for wrong in ["crease_angle = 0", "crease_angle = 181", "crease_angle = 30\nmesh = \"f\""] {
        let file = if wrong.contains("mesh") { "" } else { "file = \"a.obj\"\n" };
        let text = format!("[meshes.f]\nfile = \"a.obj\"\n[[objects]]\n{file}{wrong}\n");
        assert_eq!(run(&text, &[("a.obj", fold.as_bytes())]).unwrap_err().len(), 1, "{wrong}");
    }
}

/// A flat grid of 8 x 8 squares as OBJ.
fn flat_grid() -> String {
    let mut text = String::new();
    (0..81).for_each(|i| text += &format!("v {} {} 0\n", i % 9, i / 9));
    let corners = (0..64).map(|i| i / 8 * 9 + i % 8 + 1);
    corners.for_each(|a| text += &format!("f {a} {} {} {}\n", a + 1, a + 10, a + 9));
    text
}

#[test]
fn simplified_meshes_of_files_and_inline() {
    let roof = "[meshes.m]\npositions = [[0,0,0],[1,0,0],[1,1,0],[0,1,0],[0.5,0.5,0]]\nindices = [[0,1,4],[1,2,4],[2,3,4],[3,0,4]]\n";
    let text = format!(
        "{roof}simplify = {{ faces = 2 }}\n[meshes.f]\nfile = \"a.obj\"\nsimplify = {{ faces = 20 }}\ncrease_angle = 30\n\
         [[objects]]\nmesh = \"m\"\n[[objects]]\nmesh = \"f\"\n[[objects]]\nfile = \"a.obj\"\n\
         [[objects]]\nfile = \"a.obj\"\nsimplify = {{ ratio = 0.5 }}\n[[objects]]\nfile = \"a.obj\"\nsimplify = {{ ratio = 0.5 }}\n\
         [[objects]]\nfile = \"a.obj\"\nsimplify = {{ ratio = 0.5, seed = 1 }}\n\
         [[objects]]\nfile = \"a.obj\"\nsimplify = {{ faces = 20, keep_boundary = true }}\n"
    );
    let input = run(&text, &[("a.obj", flat_grid().as_bytes())]).unwrap();
    let mesh = |i: usize| match &input.parts.shapes[input.parts.objects[i].shape] {
        Shape::Mesh(mesh) => mesh,
        _ => panic!(),
    };
    let faces = [0, 1, 2, 3, 4, 5, 6].map(|i| mesh(i).indices.len());
    assert_eq!(faces[..6], [2, 20, 128, 64, 64, 64]);
    assert!(faces[6] > 20 && faces[6] < 64, "32 open edges need 30 faces: {faces:?}");
    assert!(mesh(1).normals.is_some() && mesh(2).normals.is_none());
    let (simple, whole) = (bounds(&input.parts, 1), bounds(&input.parts, 2));
    assert!(near(simple.0, whole.0, 1e-4) && near(simple.1, whole.1, 1e-4), "{simple:?}");
    let shapes = [2, 3, 4, 5].map(|i| input.parts.objects[i].shape);
    assert!(shapes[1] == shapes[2] && shapes[0] != shapes[1] && shapes[1] != shapes[3], "{shapes:?}");
    let from: Vec<_> = input.imports.iter().map(|i| (i.triangles, i.simplified_from)).collect();
    assert_eq!(from[..3], [(20, Some(128)), (128, None), (64, Some(128))]);
    let told: Vec<&str> = input.findings.iter().map(|d| d.message.as_str()).collect();
    assert_eq!(told[..2], ["simplified from 4 to 2 triangles", "simplified from 128 to 20 triangles"]);
    assert!(told.iter().any(|line| line.contains("to no less than")), "{told:?}");
    let wrong = "[[objects]]\nmesh = \"m\"\nsimplify = { faces = 3 }\n";
    assert_eq!(run(&format!("{roof}{wrong}"), &[]).unwrap_err().len(), 1);
}

#[test]
fn transforms_apply_in_order_and_relocate_moves_the_lowest_corner() {
    let steps = "[{ scale = [1, 2, 3] }, { rotate = { axis = [1, 2, 3], angle = 50 } }, { relocate = [7, 8, 9] }]";
    for (shape, tolerance) in [("sphere", 1e-3), ("rectangle", 1e-12), ("box", 1e-12), ("disk", 1e-12), ("mesh", 1e-12)]
    {
        let file = if shape == "mesh" { "file = \"a.obj\"\n" } else { "" };
        let text = format!("[[objects]]\nshape = \"{shape}\"\n{file}transform = {steps}");
        let input = run(&text, &[("a.obj", TRIANGLES.as_bytes())]).unwrap();
        let (min, _) = bounds(&input.parts, 0);
        assert!(near(min, DVec3::new(7.0, 8.0, 9.0), tolerance), "{shape}: {min}");
    }
    let text = |steps: &str| format!("[[objects]]\nshape = \"box\"\ntransform = [{steps}]");
    let a = run(&text("{ scale = 2 }, { translate = [1, 0, 0] }"), &[]).unwrap();
    assert!(near(bounds(&a.parts, 0).0, DVec3::new(0.0, -1.0, -1.0), 0.0));
    let b = run(&text("{ translate = [1, 0, 0] }, { scale = 2 }"), &[]).unwrap();
    assert!(near(bounds(&b.parts, 0).0, DVec3::new(1.0, -1.0, -1.0), 0.0));
    let c = run(&text("{ matrix = [0,-1,0,5, 1,0,0,6, 0,0,1,7] }, { rotate = { axis = \"z\", angle = -90 } }"), &[])
        .unwrap();
    assert!(near(c.parts.objects[0].transform.translation, DVec3::new(6.0, -5.0, 7.0), 0.0));
    assert!(near(c.parts.objects[0].transform.matrix3.x_axis, DVec3::X, 0.0));
}

#[test]
fn shapes_face_where_the_manual_says() {
    let input = run("[[objects]]\nshape = \"rectangle\"\nsize = [2, 4]\n[[objects]]\nshape = \"disk\"\n", &[]).unwrap();
    let Shape::Rectangle { corner, u, v } = &input.parts.shapes[0] else { panic!() };
    assert_eq!((*corner, u.cross(*v).normalize()), (DVec3::new(-1.0, -2.0, 0.0), DVec3::Z));
}

#[test]
fn cameras() {
    let camera = |text: &str, size: &str| run(&format!("[camera]\n{text}\n[film]\nsize = {size}"), &[]).unwrap().camera;
    let look = "position = [0, 0, 3]\nlook_at = [0, 4, 0]\nfov = 90\n";
    for (axis, size, expected) in [
        ("x", "[2, 1]", FovAxis::X),
        ("y", "[2, 1]", FovAxis::Y),
        ("smaller", "[2, 1]", FovAxis::Y),
        ("smaller", "[1, 2]", FovAxis::X),
        ("larger", "[2, 1]", FovAxis::X),
        ("larger", "[1, 2]", FovAxis::Y),
    ] {
        let settings = camera(&format!("{look}fov_axis = \"{axis}\""), size);
        let Projection::Perspective { fov, axis, focus_distance, .. } = settings.projection else { panic!() };
        assert_eq!((axis, focus_distance), (expected, 5.0));
        assert!((fov - std::f64::consts::FRAC_PI_2).abs() < 1e-15);
    }
    let settings =
        camera("type = \"orthographic\"\nposition = [1, 2, 3]\ndirection = [0, 0, -1]\nheight = 3", "[2, 1]");
    assert_eq!(settings.projection, Projection::Orthographic { height: 3.0 });
}

#[test]
fn lenses_by_focal_length() {
    let lens = |text: &str, size: &str| {
        let text = format!("[camera]\nposition = [0, 0, 3]\nlook_at = [0, 0, 0]\n{text}\n[film]\nsize = {size}");
        let settings = run(&text, &[]).unwrap().camera;
        let Projection::Perspective { fov, axis, lens_radius, .. } = settings.projection else { panic!() };
        (libm::tan(0.5 * fov), axis, lens_radius)
    };
    let close = |a: f64, b: f64| (a - b).abs() < 1e-12;
    // 36 mm wide, unless it is said otherwise; half the side over the focal length.
    let (tangent, axis, radius) = lens("focal_length = 50\nf_number = 2", "[30, 20]");
    assert!(close(tangent, 18.0 / 50.0) && axis == FovAxis::X && close(radius, 0.0125));
    let (tangent, axis, radius) = lens("focal_length = 20\nsensor = 10\nlens_radius = 0.5", "[10, 90]");
    assert!(close(tangent, 5.0 / 20.0) && axis == FovAxis::X && radius == 0.5);
    let shapes = [("[30, 20]", FovAxis::X, 18.0), ("[40, 20]", FovAxis::X, 18.0), ("[20, 20]", FovAxis::Y, 12.0)];
    for (size, expected, half) in shapes {
        let (tangent, axis, _) = lens("focal_length = 35\nsensor = [36, 24]", size);
        assert!(close(tangent, half / 35.0) && axis == expected, "{size}");
    }
}

#[test]
fn focus_roll_and_apertures() {
    let camera = |text: &str| {
        let objects = "[[objects]]\nname = \"ball\"\nshape = \"sphere\"\ncenter = [5, 1, 1]\n\
             transform = { scale = [1, 2, 1] }\n[[objects]]\nfile = \"a.obj\"\ntransform = { translate = [0, 0, -8] }";
        let text = format!("[camera]\nposition = [0, 0, 3]\n{text}\n{objects}");
        run(&text, &[("a.obj", TRIANGLES.as_bytes())])
    };
    let focus = |text: &str| match camera(text).unwrap().camera.projection {
        Projection::Perspective { focus_distance, .. } => focus_distance,
        Projection::Orthographic { .. } => panic!(),
    };
    let ahead = "direction = [0, 0, -2]\nlens_radius = 0.1";
    assert_eq!(focus(&format!("{ahead}\nfocus_point = [7, 8, -1]")), 4.0);
    assert_eq!(focus(&format!("{ahead}\nfocus_object = \"ball\"")), 2.0);
    // The triangles reach from z = 0 to 2, and lie 8 farther away.
    assert_eq!(focus(&format!("{ahead}\nfocus_object = \"object 2\"")), 3.0 - (1.0 - 8.0));
    let behind = camera(&format!("{ahead}\nfocus_point = [0, 0, 4]")).unwrap_err();
    assert_eq!(
        behind,
        [
            "scene.toml:5:15: error: `focus_point` is not before the camera; focus on something that the camera can see, \
          or give a `focus_distance`"
        ]
    );
    let unknown = camera(&format!("{ahead}\nfocus_object = \"bal\"")).unwrap_err();
    assert_eq!(unknown, ["scene.toml:5:16: error: no object is called `bal`; did you mean `ball`?"]);
    let rolled = camera("direction = [0, 0, -2]\nroll = 90").unwrap().camera;
    assert_eq!(rolled.up, DVec3::X);
    let square = format!("{ahead}\nfocus_distance = 1\naperture = \"square\"\naperture_rotation = 90");
    let Projection::Perspective { aperture, .. } = camera(&square).unwrap().camera.projection else { panic!() };
    assert_eq!(aperture, Aperture::Square { rotation: std::f64::consts::FRAC_PI_2 });
}

#[test]
fn the_hash_depends_on_every_byte_of_every_file() {
    let hash = |text: &str, obj: &str| {
        run(&format!("[[objects]]\nfile = \"a.obj\"\n{text}"), &[("a.obj", obj.as_bytes())]).unwrap().scene_hash
    };
    let base = hash("", TRIANGLES);
    assert_eq!(base, hash("", TRIANGLES));
    assert_ne!(base, hash("# comment", TRIANGLES));
    assert_ne!(base, hash("", &TRIANGLES.replace("v 1 1 2", "v 1 1 3")));
}

#[test]
fn files_that_are_missing_or_foreign() {
    let found = run(
        "[meshes.m]\nfile = \"bunyn.obj\"\n[[objects]]\nfile = \"a.fbx\"\n[[objects]]\nfile = \"x/y.ply\"\n[flim]\n",
        &[("bunny.obj", b"")],
    )
    .unwrap_err();
    assert_eq!(found.len(), 4);
    assert_eq!(found[0], "scene.toml:3:8: error: no such file: bunyn.obj; did you mean `bunny.obj`?");
    assert_eq!(
        found[1],
        "scene.toml:5:8: error: a.fbx: FBX files are not read yet; meshes are read from files that end in .obj, .ply, .stl, .off, also with .gz"
    );
    assert!(found[2].starts_with("scene.toml:7:8: error: no such file: x/y.ply; there is no folder"), "{}", found[2]);
    assert_eq!(found[3], "scene.toml:8:2: error: unknown key `flim` in the scene file; did you mean `film`?");
}

#[test]
fn errors_in_mesh_files_have_their_place_there() {
    let found = run(
        "[[objects]]\nfile = \"a.obj\"\n[[objects]]\nfile = \"b.ply\"",
        &[("a.obj", b"v 0 0 0\nv 1 x 0\nf 1 2 3\n"), ("b.ply", b"ply\nformat nonsense 1.0\n")],
    )
    .unwrap_err();
    assert!(found.iter().any(|l| l.starts_with("a.obj:2:5: error")), "{found:?}");
    assert!(found.iter().any(|l| l.starts_with("b.ply:2:")), "{found:?}");
}

#[test]
fn limits_are_kept() {
    let files: &[(&str, &[u8])] = &[("a.obj", TRIANGLES.as_bytes())];
    let text = "[[objects]]\nfile = \"a.obj\"\ntransform = { relocate = [0, 0, 0] }\n[[objects]]\nfile = \"a.obj\"\n";
    let default = Limits::default();
    let errors = |limits: &Limits| run_with(text, files, limits).unwrap_err().join("\n");
    assert!(errors(&Limits { triangles: 1, ..default }).contains("more than 1 triangles"));
    assert!(errors(&Limits { file_bytes: 10, ..default }).contains("a.obj is larger than the limit of 10 bytes"));
    assert!(errors(&Limits { relocated_vertices: 3, ..default }).contains("too many `relocate`"));
    assert!(run_with(text, files, &Limits { triangles: 2, relocated_vertices: 4, ..default }).is_ok());
    let path = tempfile::tempdir().unwrap();
    let scene = path.path().join("s.toml");
    fs::write(&scene, CAMERA).unwrap();
    let result = read_scene(&scene, &mut SourceMap::new(), &Limits { scene_bytes: 10, ..default });
    assert!(matches!(result, Err(ReadError::Source(_))));
}

#[test]
fn transforms_that_grow_beyond_single_precision_are_refused() {
    let steps = "{ scale = 1e10 }, ".repeat(3);
    let found = run(&format!("[[objects]]\nshape = \"box\"\ntransform = [{steps}]"), &[]).unwrap_err();
    assert_eq!(found, ["scene.toml:4:32: error: the transform is too large, or flattens the object"]);
}

#[test]
fn other_kinds_of_input_are_refused_by_name() {
    for name in ["model.obj", "scene.usd", "scene", "scene.toml.bak"] {
        let result = read_scene(Path::new(name), &mut SourceMap::new(), &Limits::default());
        assert!(matches!(result, Err(ReadError::Unsupported { .. })), "{name}");
    }
    let result = read_scene(Path::new("/nowhere/scene.TOML"), &mut SourceMap::new(), &Limits::default());
    assert!(matches!(result, Err(ReadError::Source(_))));
}

#[test]
fn the_scenes_of_the_project_build_without_findings() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let mut scenes = 0;
    for entry in fs::read_dir(&folder).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|e| e == "toml") {
            let mut sources = SourceMap::new();
            let (description, found) = read_scene(&path, &mut sources, &Limits::default()).unwrap();
            assert!(found.is_empty(), "{:?}", lines(&found, &sources, &folder));
            let input = build(&description.unwrap(), &mut sources, &Limits::default()).unwrap();
            assert!(input.findings.is_empty(), "{:?}", lines(&input.findings, &sources, &folder));
            scenes += 1;
        }
    }
    assert!(scenes >= 4);
}

#[test]
fn the_mesh_of_the_project_is_what_its_generator_makes() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/knot.ply");
    assert!(fs::read(path).unwrap() == make_mesh::knot());
}

#[test]
fn materials_of_files_are_replaced_by_name() {
    let obj: &[u8] =
        b"mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl a\nsphere 0 0 0 1\n";
    let mtl: &[u8] = b"newmtl a\nKd 0.1 0.1 0.1\nnewmtl b\nKd 0.2 0.2 0.2\n";
    let scene = |materials: &str| {
        let text = format!(
            "[materials.x]\ntype = \"black\"\n[[objects]]\nfile = \"m.obj\"\n[[objects]]\nfile = \"m.obj\"\nmaterials = {materials}\n"
        );
        run(&text, &[("m.obj", obj), ("m.mtl", mtl)])
    };
    let Input { parts, findings, .. } = scene("{ a = \"x\" }").unwrap();
    let names = |object: usize| -> Vec<&str> {
        parts.objects[object].materials.iter().map(|&m| &parts.materials[m].name[..]).collect()
    };
    // Mesh and sphere of the first object, then of the second.
    assert_eq!([names(0), names(1), names(2), names(3)], [vec!["a", "b"], vec!["a"], vec!["x", "b"], vec!["x"]]);
    assert_eq!(findings.iter().count(), 0);
    let Input { findings, .. } = scene("{ c = \"x\" }").unwrap();
    let said: Vec<_> = findings.iter().map(|d| d.message.clone()).collect();
    assert_eq!(said, ["the file has no material that is called `c`"]);
    let unknown = scene("{ a = \"y\" }").unwrap_err();
    assert!(unknown[0].contains("scene.toml:8:19: error: no material is called `y`"), "{unknown:?}");
    let both = scene("{ a = \"x\" }\nmaterial = \"x\"").unwrap_err();
    assert!(both[0].contains("`material` and `materials` exclude each other"), "{both:?}");
}

#[test]
fn bodies_that_are_not_closed_are_told() {
    let found = |objects: &str, obj: &str| -> Vec<String> {
        let text = format!(
            "[media.milk]\nscattering = 1\n[materials.milk]\ntype = \"boundary\"\ninterior = \"milk\"\n\
             [materials.wall]\ntype = \"diffuse\"\n{objects}"
        );
        let input = run(&text, &[("m.obj", obj.as_bytes())]).unwrap();
        input.findings.iter().map(|d| d.message.clone()).collect()
    };
    let open =
        |edges: &str| vec![format!("`object 1` bounds a body, but is not closed: {edges} no face on the other side")];
    for closed in ["shape = \"sphere\"", "shape = \"box\"\nmin = [0, 0, 0]\nmax = [1, 1, 1]"] {
        assert_eq!(found(&format!("[[objects]]\nmaterial = \"milk\"\n{closed}\n"), ""), [""; 0]);
    }
    let rectangle =
        "[[objects]]\nmaterial = \"milk\"\nshape = \"rectangle\"\ncorner = [0, 0, 0]\nu = [1, 0, 0]\nv = [0, 1, 0]\n";
    assert_eq!(found(rectangle, ""), open("4 edges have"));
    assert_eq!(found(&rectangle.replace("milk", "wall"), ""), [""; 0], "walls need not be closed");
    // A tetrahedron whose corners are written anew for each face, then one without its last face, then one with a face turned over.
    let corner = ["0 0 0", "1 0 0", "0 1 0", "0 0 1"];
    let obj = |faces: &[[usize; 3]]| -> String {
        let vertices = faces.iter().flatten().map(|&c| format!("v {}\n", corner[c])).collect::<String>();
        let faces =
            (0..faces.len()).map(|i| format!("f {} {} {}\n", 3 * i + 1, 3 * i + 2, 3 * i + 3)).collect::<String>();
        vertices + &faces
    };
    let solid = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];
    let of_file = "[[objects]]\nmaterial = \"milk\"\nfile = \"m.obj\"\n";
    assert_eq!(found(of_file, &obj(&solid)), [""; 0]);
    assert_eq!(found(of_file, &obj(&solid[..3])), open("3 edges have"));
    assert_eq!(found(of_file, &obj(&[solid[0], solid[1], solid[2], [1, 3, 2]])), open("3 edges have"));
}
