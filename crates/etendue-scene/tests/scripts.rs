//! Scripts of the older renderer: every key, what it becomes, what is said, and where.
#![allow(clippy::disallowed_methods)]

use etendue::{
    bsdf::PhongLobes,
    material::{Relief, Scattering},
    math::DVec3,
    sampling::Filter,
    spectrum::Spectrum,
    texture::{Pattern, Transfer, Wrap},
    tonemap::{DisplayTransform, Encoding},
};
use etendue_scene::{
    Limits, Severity, SourceMap, build_with,
    description::{
        Angle, ApertureRecord, EnvironmentRecord, Focus, Lens, Located, SceneDescription, ShapeRecord, Step, View,
    },
    read_toml,
    script::{KEYS, is_script, read_script, scene_text},
};
use std::{
    fs,
    path::{Path, PathBuf},
};

const FLOOR: &str = "mtllib scene/1.mtl\nv -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nvt 0 0\nvt 1 0\nvt 1 1\nvt 0 1\n\
                     usemtl floor\nf 1/1 2/2 3/3 4/4\n";
const LAMP: &str =
    "mtllib scene/1.mtl\nv 0 0 2\nv 1 0 2\nv 1 1 2\nusemtl AreaLightSource\nf 1 2 3\nusemtl glass\nsphere 0 0 1 0.5\n";
const LIBRARY: &str = "newmtl floor\nKd 0.5 0.5 0.5\nKs 0 0 0\nNs 1000\n\
                       newmtl AreaLightSource\nKd 1 1 0.85\n\
                       newmtl glass\nKd 0 0 0\nKs 0.1 0.1 0.1\nNs 1000\nTr 1\nTd 0 0 0\nTs 0.9 0.9 0.9\nNst 1000\nn 1.5\n";
const CAMERA: &str = "camera 3.5 0 0 -1 0 0 0 0 1 2.5 2 2 0.005\n";

/// A folder with a script in `scene/`, as the old program had its scenes.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        for (name, text) in [("scene/floor.obj", FLOOR), ("scene/lamp.obj", LAMP), ("scene/1.mtl", LIBRARY)] {
            folder.put(name, text);
        }
        folder
    }

    fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        let path = self.path(name);
        fs::create_dir_all(path.parent().unwrap()).unwrap();
        fs::write(path, bytes).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// What a script gives, and what is said, file names without the folder.
    fn read(&self, script: &str) -> (Option<SceneDescription>, Vec<String>) {
        let path = self.path("scene/1.cfg");
        fs::write(&path, script).unwrap();
        let mut sources = SourceMap::new();
        let (scene, mut found) = read_script(&path, &mut sources, &Limits::default()).unwrap();
        let prefix = format!("{}/", self.0.path().display());
        let Some(scene) = scene else {
            assert!(found.has_errors());
            return (None, found.iter().map(|d| d.one_line(&sources).replace(&prefix, "")).collect());
        };
        let (description, meshes, more) = scene.describe(&mut sources).unwrap();
        found.append(more);
        assert!(!found.has_errors());
        build_with(&description, &mut sources, &Limits::default(), meshes).unwrap();
        (Some(description), found.iter().map(|d| d.one_line(&sources).replace(&prefix, "")).collect())
    }

    /// The description of a script that is right.
    fn scene(&self, script: &str) -> SceneDescription {
        let (description, said) = self.read(script);
        description.unwrap_or_else(|| panic!("{script}\n{}", said.join("\n")))
    }
}

/// A script of a camera and the floor, and more.
fn with(more: &str) -> String {
    format!("object scene/floor.obj\n{more}\n{CAMERA}")
}

fn notes(script: &str) -> Vec<String> {
    Folder::new().read(script).1
}

#[test]
fn a_camera_is_a_window_before_a_point() {
    let scene = Folder::new().scene(&with("imageSize 400 200"));
    assert_eq!((scene.camera.position, scene.camera.up), (DVec3::new(3.5, 0.0, 0.0), DVec3::Z));
    assert_eq!(scene.camera.view, View::Direction(DVec3::NEG_X));
    let Lens::Perspective { angle, radius, aperture, .. } = scene.camera.lens else { panic!() };
    assert_eq!(angle, Angle::Focal { length: 2.5, width: 2.0, height: Some(2.0) });
    assert_eq!((radius, aperture), (0.0, ApertureRecord::Round));
    // Without a size, the window's own.
    assert_eq!(Folder::new().scene(&with("")).film.size, [400, 400]);
}

/// The numbers of the paper's first figure.
#[test]
fn the_camera_of_the_first_figure() {
    let camera = "camera -4.81455 -3.35453 5.45768 0.621478 0.466949 -0.629066 0.46311 0.428683 0.775732 2.5 2 2 0.0025 5.8 0.06\n\
                  camera::move tiltRight 0.16\n";
    let scene = Folder::new().scene(&format!("object scene/floor.obj\n{camera}imageSize 800 800\n"));
    let View::Direction(direction) = scene.camera.view else { panic!() };
    let near = |a: DVec3, b: [f64; 3]| assert!((a - DVec3::from_array(b)).abs().max_element() < 6e-6, "{a}");
    near(direction, [0.71351, 0.33889, -0.61324]);
    assert_eq!(scene.camera.near_clip, 2.5);
    near(scene.camera.up, [0.46311, 0.428683, 0.775732]);
    near(direction.cross(scene.camera.up), [0.52577, -0.83749, 0.14892]);
    let Lens::Perspective { radius, aperture, focus, .. } = scene.camera.lens else { panic!() };
    // A square with this side has the area of a circle with that radius.
    let side = 0.06 * 5.8 / (5.8 - 2.5);
    assert!((radius * radius * std::f64::consts::PI - side * side).abs() < 1e-15);
    assert_eq!((aperture, focus), (ApertureRecord::Square { rotation: 0.0 }, Focus::Distance(5.8)));
}

#[test]
fn moves_of_the_camera() {
    let position = |moves: &str| {
        Folder::new().scene(&format!("object scene/floor.obj\n{CAMERA}{moves}")).camera.position.to_array()
    };
    assert_eq!(position("camera::move 1 2 3"), [2.5, 2.0, 3.0]);
    assert_eq!(position("camera::move zoomIn 0.5\ncamera::move zoomIn 0.5"), [2.5, 0.0, 0.0]);
    let direction = |moves: &str| {
        let scene = Folder::new().scene(&format!("object scene/floor.obj\n{CAMERA}{moves}"));
        let View::Direction(direction) = scene.camera.view else { panic!() };
        (direction * 5.0).to_array().map(|x| x.round())
    };
    assert_eq!(direction("camera::move tiltUp 0.75"), [-4.0, 0.0, 3.0]);
    assert_eq!(direction("CAMERA::MOVE tiltright 0.75"), [-4.0, 3.0, 0.0]);
    let rolled = Folder::new().scene(&format!("object scene/floor.obj\n{CAMERA}camera::move rotate 0.75"));
    assert_eq!((rolled.camera.up * 5.0).to_array().map(|x| x.round()), [0.0, 3.0, 4.0]);
}

#[test]
fn what_has_a_place_of_its_own() {
    let script =
        with("ambient 0.7 0.7 0.68\npixelSampler Stratified 60\nrayTraceSampler Stratified 8 8\nfilter 12 6 3");
    let scene = Folder::new().scene(&script);
    assert_eq!(scene.environment, Some(EnvironmentRecord::Constant(Spectrum([0.7, 0.7, 0.68]))));
    assert_eq!((scene.sampler.spp, scene.integrator.depth), (3600, Some(9)));
    let display = DisplayTransform {
        balance: Spectrum([12.0, 6.0, 3.0]),
        encoding: Encoding::Linear,
        ..DisplayTransform::default()
    };
    assert_eq!(scene.film.display, display);
    assert_eq!(scene.film.filter, Filter::Gaussian { sigma: std::f32::consts::FRAC_1_SQRT_2, radius: 0.5 });
    let scene = Folder::new().scene(&with("ambient 0 0 0\npixelsampler latincube 100"));
    assert_eq!((scene.environment, scene.sampler.spp, scene.integrator.depth), (None, 100, None));
}

#[test]
fn steps_act_on_the_object_before_them() {
    let scene = Folder::new().scene(&format!(
        "object scene/floor.obj\nscale 2\nrelocate 5 5 -5\nobject scene\\LAMP.obj # behind\nrotate 0 0.5\nrotate 1 0.25\nrotate 2 -0.7\n{CAMERA}"
    ));
    let steps = |i: usize| scene.objects[i].transform.iter().map(|s| s.value).collect::<Vec<_>>();
    assert_eq!(steps(0), [Step::Scale(DVec3::splat(2.0)), Step::Relocate(DVec3::new(5.0, 5.0, -5.0))]);
    let turn = |axis, angle| Step::Rotate { axis, angle };
    assert_eq!(steps(1)[0], turn(DVec3::X, 90.0));
    assert_eq!(steps(1)[1], turn(DVec3::Y, -45.0), "x turned towards z");
    let Step::Rotate { axis: DVec3::Z, angle } = steps(1)[2] else { panic!() };
    assert!((angle + 126.0).abs() < 1e-12);
    let names: Vec<_> = scene.objects.iter().map(|o| &o.name.as_ref().unwrap().value[..]).collect();
    assert_eq!(names, ["floor", "lamp"]);
}

#[test]
fn lists_of_objects() {
    let folder = Folder::new();
    folder.put("scene/all.txt", "object scene/floor.obj\nscale 3\nobject scene/floor.obj\n");
    let scene = folder.scene(&format!("scene scene/all.txt\nscale 2\n{CAMERA}"));
    let scales: Vec<Vec<Step>> = scene.objects.iter().map(|o| o.transform.iter().map(|s| s.value).collect()).collect();
    assert_eq!(scales, [[Step::Scale(DVec3::splat(3.0))], [Step::Scale(DVec3::splat(2.0))]]);
    let names: Vec<_> = scene.objects.iter().map(|o| &o.name.as_ref().unwrap().value[..]).collect();
    assert_eq!(names, ["floor", "floor-2"]);
    folder.put("scene/all.txt", "scene scene/all.txt\n");
    let said = folder.read(&format!("scene scene/all.txt\n{CAMERA}")).1;
    assert_eq!(said, ["scene/all.txt:1:7: error: a list of objects inside of a list; list the objects themselves"]);
}

/// One note for each kind of reinterpretation, at its place.
#[test]
fn what_is_reinterpreted_is_told() {
    let script = "object scene/lamp.obj\nscale 2\nambient 1 1 1\n\
                  camera 3 0 0 -1 0 0 0 0 1 2 2 2 0.005 4 0.1\n\
                  pixelSampler Stratified 30\n# intersectionTester SimpleIntersectionTester\n\
                  intersectionTester KdtreeIntersectionTester\nrayTraceSampler Stratified 7 8\nthreading 10\n\
                  imageSize 400 400\nfilter 8 8 8\nwriteRaw bright.raw\nfromRaw bright.raw\n";
    assert_eq!(
        notes(script),
        [
            "scene/1.cfg:2:1: note: `relocate`, `scale` and `rotate` act on spheres too, which the old program left where they were",
            "scene/1.cfg:3:1: note: `ambient` is the radiance of a constant environment, 1 for 255 of the old program",
            "scene/1.cfg:4:1: note: `camera`: the aperture of 0.1 on the window is a square lens of 0.200000, of the area of a round one of radius 0.112838",
            "scene/1.cfg:5:1: note: `pixelSampler`: `Stratified 30` is 30 times 30 samples a pixel, of the default sampler",
            "scene/1.cfg:7:1: note: `intersectionTester` is not used: it does not change the picture; see --accel",
            "scene/1.cfg:8:1: note: `rayTraceSampler`: depth 7 is paths of 8 edges, with the light that was added at the last surface; sampler and size have no meaning here",
            "scene/1.cfg:9:1: note: `threading` is not used; see --threads",
            "scene/1.cfg:11:1: note: `filter` multiplies the picture where it becomes 8 bits (`balance`), which are stored in proportion to the light (`encoding`)",
            "scene/1.cfg:12:1: note: `writeRaw` is not used: -o with the name of an .exr, .hdr or .pfm file keeps values as they are",
            "scene/1.cfg:13:1: warning: `fromRaw` is not read: the objects are rendered instead of showing a stored picture",
            "scene/1.mtl:5:1: note: `AreaLightSource` emits radiance `Kd` on both sides, 1 for 255 of the old program",
        ]
    );
    assert_eq!(
        notes(&format!("object scene/floor.obj\nobjekt a\n{CAMERA}imageSize 800 400 3\n")),
        [
            "scene/1.cfg:2:1: warning: unknown key `objekt` ignored; did you mean `object`?",
            "scene/1.cfg:4:1: warning: the window holds 400 x 400 pixels of that `step`: it is fitted to the picture (the old program showed the part of the window from its lower left corner)",
            "scene/1.cfg:4:19: warning: `imageSize` takes no more: the rest of the line is ignored",
        ]
    );
    assert_eq!(
        notes("object scene/floor.obj\ncamera 3 0 0 -1 0 0 1 0 1 2 2 2 0.005\n"),
        [
            "scene/1.cfg:2:1: note: `camera`: up is 45.0 degrees from perpendicular to the view, which skewed the picture; it is not skewed here"
        ]
    );
}

#[test]
fn what_is_wrong_is_told_with_its_place() {
    for (script, said) in [
        (with("ambient 1 1"), "scene/1.cfg:2:12: error: a number is missing (expected blue)"),
        (
            with("ambient 1 -1 1"),
            "scene/1.cfg:2:11: error: green is out of range: -1 (must be at least 0 and at most 1e30)",
        ),
        (with("filter 1 1 nan"), "scene/1.cfg:2:12: error: `nan` is not a finite number (expected blue)"),
        (with("scale 0"), "scene/1.cfg:2:7: error: a scale of 0 flattens the object (expected a factor other than 0)"),
        (with("rotate 3 1"), "scene/1.cfg:2:8: error: the axis is out of range: 3 (must be at least 0 and at most 2)"),
        (with("rotate 0.5 1"), "scene/1.cfg:2:8: error: the axis is not a whole number: 0.5 (expected a whole number)"),
        (
            with("imageSize 0 4"),
            "scene/1.cfg:2:11: error: the width is out of range: 0 (must be at least 1 and at most 65536)",
        ),
        (
            with("pixelSampler Stratified 5000"),
            "scene/1.cfg:2:25: error: the number of samples is out of range: 5000 (must be at least 1 and at most 4096)",
        ),
        (
            with("pixelSampler Latin 5"),
            "scene/1.cfg:2:14: error: `Latin` is no sampler of pixels (expected Stratified or LatinCube); did you mean `LatinCube`?",
        ),
        (
            with("rayTraceSampler Stratified 0"),
            "scene/1.cfg:2:28: error: the depth is out of range: 0 (must be at least 1 and at most 1048575)",
        ),
        (
            with("camera::move 1 1 1"),
            "scene/1.cfg:2:1: error: there is no camera yet to be moved (expected after `camera`)",
        ),
        (with("object"), "scene/1.cfg:2:1: error: the name of a file is missing (expected a file)"),
        (
            with("object scene/missing.obj"),
            "scene/1.cfg:2:8: error: no such file: scene/missing.obj (not there, nor in the folders above); the old program looked from the folder that it was started in; put the file there, or begin the line with #",
        ),
        (
            with("object scene/1.mtl"),
            "scene/1.cfg:2:8: error: cannot read scene/1.mtl as a mesh; meshes are read from files that end in .obj, .ply, .stl, .off, also with .gz",
        ),
        (
            format!("scale 2\n{}", with("")),
            "scene/1.cfg:1:1: error: there is no object yet to be moved; it acts on the `object` before it",
        ),
        ("camera 0 0 0 1 0 0 2 0 0 1 1 1 1".to_owned(), "scene/1.cfg:1:1: error: the script has no `object`"),
        ("object scene/floor.obj".to_owned(), "scene/1.cfg:1:1: error: the script has no `camera`"),
        (
            "object scene/floor.obj\ncamera 0 0 0 1 0 0 2 0 0 1 1 1 1".to_owned(),
            "scene/1.cfg:2:1: error: direction or up is zero, or they are parallel (expected two directions across each other)",
        ),
        (
            "object scene/floor.obj\ncamera 0 0 0 1 0 0 0 0 1 2 1 1 1 1.5 0.1".to_owned(),
            "scene/1.cfg:2:34: error: the focal plane lies before the window (must be beyond the window at 2)",
        ),
        (
            format!("object scene/floor.obj\n{CAMERA}camera::move roll 1"),
            "scene/1.cfg:3:14: error: the camera cannot `roll` (expected zoomIn, tiltUp, tiltRight or rotate)",
        ),
        (
            "fromRaw a.raw".to_owned(),
            "scene/1.cfg:1:1: error: `fromRaw` shows a stored picture, which is not read; the script has no objects that could be rendered",
        ),
    ] {
        let (scene, found) = Folder::new().read(&script);
        assert!(scene.is_none() && found.iter().any(|line| line == said), "{script}\n{said}\n{}", found.join("\n"));
    }
    // What asks for something that is not there, and nothing else, is not bad input.
    let folder = Folder::new();
    folder.put("scene/1.cfg", "fromRaw a.raw\n");
    let mut sources = SourceMap::new();
    let (_, found) = read_script(&folder.path("scene/1.cfg"), &mut sources, &Limits::default()).unwrap();
    assert!(found.only_unsupported());
}

/// Records say where they come from: lines of the script.
#[test]
fn origins() {
    let folder = Folder::new();
    let text = format!("# first\nobject scene/floor.obj\n  scale 2\n{CAMERA}");
    folder.put("scene/1.cfg", &text);
    let mut sources = SourceMap::new();
    let (scene, _) = read_script(&folder.path("scene/1.cfg"), &mut sources, &Limits::default()).unwrap();
    let (description, ..) = scene.unwrap().describe(&mut sources).unwrap();
    let at = |origin: &etendue_scene::Origin| {
        let span = origin.span().unwrap();
        assert!(sources.path(span.file).ends_with("scene/1.cfg"));
        &text[span.start..span.end]
    };
    let object = &description.objects[0];
    let ShapeRecord::File { path: Located { origin, .. }, .. } = &object.shape else { panic!() };
    assert_eq!((at(&object.origin), at(origin)), ("scene/floor.obj", "scene/floor.obj"));
    assert_eq!(at(&object.transform[0].origin), "scale 2");
    assert_eq!(at(&description.camera.origin), CAMERA.trim_end());
}

fn phong(
    scene: &SceneDescription,
    name: &str,
) -> PhongLobes<
    etendue::material::Color<etendue_scene::description::TextureRecord>,
    etendue::material::Number<etendue_scene::description::TextureRecord>,
> {
    let record = scene.materials.iter().find(|m| m.material.name == name).unwrap();
    let Scattering::Phong(lobes) = &record.material.scattering else { panic!("{record:?}") };
    lobes.clone()
}

/// The old program had its own idea of materials, whatever their keys.
#[test]
fn materials_mean_what_they_meant() {
    let folder = Folder::new();
    folder.put(
        "scene/1.mtl",
        "newmtl floor\nKd 0.5 0.5 0.5\nKs 0.25 0.25 0.25\nNs 50\ntexture scene/t.png Kd\nnewmtl glass\nKd 0.1 0.2 0.3\nTs 0.9 0.9 0.9\n",
    );
    folder.put("scene/t.png", png());
    let scene = folder.scene(&format!("object scene/floor.obj\nobject scene/lamp.obj\n{CAMERA}"));
    let floor = phong(&scene, "floor");
    let texture = floor.diffuse.texture.as_ref().unwrap();
    let Pattern::Image(image) = &texture.pattern else { panic!() };
    assert_eq!((image.transfer, floor.diffuse.factor), (Some(Transfer::Linear), Spectrum::splat(0.5)));
    assert_eq!(texture.mapping.wrap, [Wrap::Clamp; 2]);
    assert_eq!((floor.specular.factor, floor.exponent.factor), (Spectrum::splat(0.25), 50.0));
    let glass = phong(&scene, "glass");
    assert_eq!(glass.transmission.factor, Spectrum::BLACK, "nothing says that it is transparent");
    assert_eq!(scene.objects[0].materials[0].clone().map(|name| name.value), ["floor", "floor"]);
    assert_eq!(scene.objects[1].materials[0].clone().map(|name| name.value), ["glass", "glass"]);
    // In a library that is in the dialect anyway, what it says needs no repetition.
    assert!(Folder::new().scene(&with("")).materials.is_empty());
}

#[test]
fn bumps_are_brushed_metal_where_there_is_something_to_reflect() {
    let folder = Folder::new();
    folder.put("scene/t.png", png());
    folder.put(
        "scene/1.mtl",
        format!("{LIBRARY}newmtl plain\nKd 1 1 1\nbump scene/t.png\n")
            .replace("Ks 0 0 0\nNs 1000\n", "Ks 1 1 1\nNs 1000\nbump scene/t.png Kd\n"),
    );
    let (scene, said) = folder.read(&with(""));
    let scene = scene.unwrap();
    let floor = &scene.materials[0].material;
    let Scattering::BrushedMetal { reflectance, .. } = &floor.scattering else { panic!("{floor:?}") };
    assert_eq!(reflectance.factor, Spectrum::ONE);
    assert!(said[0].contains("`bump` on a surface with `Ks` is brushed metal"), "{said:?}");
    folder.put("scene/1.mtl", "newmtl floor\nKd 0.5 0.5 0.5\nbump scene/t.png\n");
    let scene = folder.scene(&with(""));
    assert!(matches!(&scene.materials[0].material.relief, Some(Relief::Bump { height }) if height.factor == 0.01));
}

/// The medium is that of the first object's library, if it has a rate.
#[test]
fn a_material_fills_the_world() {
    let folder = Folder::new();
    folder.put("scene/1.mtl", format!("{LIBRARY}newmtl GlobalScatter\nKd 1 0.5 0.25\nn 0.05\n"));
    let (scene, said) = folder.read(&with(""));
    let scene = scene.unwrap();
    assert_eq!(scene.world_medium.as_ref().unwrap().value, "gas");
    let medium = &scene.media[0].medium;
    assert_eq!(medium.extinction(), Spectrum::splat(0.05));
    assert_eq!(medium.scattering, Spectrum([0.05, 0.025, 0.0125]));
    let kinds: Vec<_> = medium.phase.components().iter().map(|component| component.kind.name()).collect();
    assert_eq!(kinds, ["lambert-sphere"]);
    let note = "scene/1.mtl:16:1: note: `GlobalScatter` fills the world: `n` is its extinction, `Kd` its albedo, and it scatters as tiny matte spheres do";
    assert!(said.iter().any(|line| line == note), "{said:?}");
    for none in ["newmtl GlobalScatter\nKd 1\n", "newmtl global_scatter\nKd 1\nn 1\n"] {
        folder.put("scene/1.mtl", format!("{LIBRARY}{none}"));
        assert!(folder.scene(&with("")).world_medium.is_none(), "{none}");
    }
}

/// A white pixel.
fn png() -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, 1, 1);
    encoder.set_color(png::ColorType::Rgb);
    encoder.write_header().unwrap().write_image_data(&[255; 3]).unwrap();
    bytes
}

/// The scene file that is written reads as what the script gives.
#[test]
fn the_scene_file_says_the_same() {
    let folder = Folder::new();
    folder.put("scene/t.png", png());
    folder.put("scene/1.mtl", format!("{LIBRARY}texture scene/t.png Kd\n"));
    let script =
        format!("object scene/lamp.obj\nrotate 2 0.3\nambient 1 2 3\nfilter 2 2 2\nrayTraceSampler x 3\n{CAMERA}");
    let path = folder.path("scene/1.cfg");
    fs::write(&path, script).unwrap();
    let mut sources = SourceMap::new();
    let (scene, _) = read_script(&path, &mut sources, &Limits::default()).unwrap();
    let scene = scene.unwrap();
    let written = scene_text(&scene, &mut |path| Ok::<_, ()>(path.to_owned())).unwrap();
    assert_eq!(written.text.lines().count(), written.origins.len());
    let (again, found) = {
        let file = sources.insert("again.toml", written.text.clone().into_bytes()).unwrap();
        read_toml(file, written.text.as_bytes(), Path::new(""))
    };
    assert!(found.is_empty(), "{found:?}\n{}", written.text);
    let (again, (described, ..)) = (again.unwrap(), scene.describe(&mut sources).unwrap());
    // But for the origins, which stand nowhere in these.
    assert_eq!(
        format!("{:?}", (again.film.display, again.sampler, again.integrator, &again.environment)),
        format!("{:?}", (described.film.display, described.sampler, described.integrator, &described.environment))
    );
    assert_eq!((again.camera.position, &again.camera.lens), (described.camera.position, &described.camera.lens));
    assert_eq!(again.materials.len(), described.materials.len());
    let steps = |d: &SceneDescription| d.objects[0].transform.iter().map(|s| s.value).collect::<Vec<_>>();
    assert_eq!(steps(&again), steps(&described));
}

#[test]
fn scripts_are_known_by_ending_and_by_content() {
    let folder = Folder::new();
    let script = with("imageSize 4 4");
    for (name, text, is) in [
        ("a.cfg", "anything", true),
        ("a.CFG", "", true),
        ("1.cfg.v_b2b998", &script[..], true),
        ("noending", &script, true),
        ("a.toml", &script, false),
        ("a.obj", &script, false),
        ("a.txt", "object a.obj\nsome other words\nand more\nand more\n", false),
        ("b.txt", "camera\n", false),
        ("c.bin", "object a\0\ncamera 1\n", false),
        ("a.png", "\u{89}PNG", false),
    ] {
        folder.put(name, text);
        assert_eq!(is_script(&folder.path(name)), is, "{name}");
    }
    assert!(!is_script(&folder.path("missing")) && !is_script(folder.0.path()));
    assert_eq!(KEYS.len(), 16);
}

mod hostile {
    use super::*;
    use proptest::{collection::vec, prelude::*, sample::select, test_runner::RngSeed};

    fn whole() -> String {
        with(
            "ambient 0.7 0.7 0.68\nobject scene/lamp.obj\nscale 1.5\nrelocate 0 0 0\nrotate 2 -0.7\nscene scene/all.txt\n\
             camera::move tiltRight 0.16\ncamera::move 1 2 3\npixelSampler Stratified 3\nrayTraceSampler Stratified 8 8\n\
             threading 3\nimageSize 80 80\nfilter 1.5 1.5 1.5\nwriteRaw a.txt\nintersectiontester x\n",
        )
    }

    /// Whatever it says, it ends in a scene or in an error, and every finding has a place.
    fn survives(folder: &Folder, bytes: &[u8]) {
        let path = folder.path("scene/1.cfg");
        fs::write(&path, bytes).unwrap();
        let mut sources = SourceMap::new();
        let (scene, found) = read_script(&path, &mut sources, &Limits::default()).unwrap();
        assert_eq!(scene.is_none(), found.count(Severity::Error) > 0);
        for finding in &found {
            assert!(finding.place(&sources).is_some(), "{finding:?}");
        }
        if let Some(scene) = scene {
            let described = scene.describe(&mut sources);
            let (description, meshes, _) = described.unwrap_or_else(|found| panic!("{found:?}"));
            let _ = build_with(&description, &mut sources, &Limits::default(), meshes);
        }
    }

    #[test]
    fn every_truncation() {
        let folder = Folder::new();
        folder.put("scene/all.txt", "object scene/floor.obj\n");
        let whole = whole();
        (0..=whole.len()).for_each(|end| survives(&folder, &whole.as_bytes()[..end]));
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 500, rng_seed: RngSeed::Fixed(11), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn random_statements(lines in vec((select(KEYS), vec(select(vec!["0", "1", "-1", "2.5", "1e300", "nan", "x", "#", "scene/floor.obj", "Stratified", "tiltUp", "1e-320", "65536", "\\", "é"]), 0..16)), 0..20)) {
            let folder = Folder::new();
            let text: String = lines.iter().map(|(key, words)| format!("{key} {}\n", words.join(" "))).collect();
            survives(&folder, text.as_bytes());
            survives(&folder, with(&text).as_bytes());
        }

        #[test]
        fn damaged_bytes(flips in vec((any::<prop::sample::Index>(), any::<u8>()), 1..12)) {
            let folder = Folder::new();
            let mut bytes = whole().into_bytes();
            for (at, value) in flips {
                let length = bytes.len();
                bytes[at.index(length)] = value;
            }
            survives(&folder, &bytes);
        }
    }
}
