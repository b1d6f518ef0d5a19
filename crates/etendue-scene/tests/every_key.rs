//! Every key of every type reads, and a description holds what was written.

use etendue::{
    bsdf::{GrooveForm, PhongLobes, PrincipledParameters},
    material::{Relief, Scattering, Tangent, TangentField},
    math::{DVec3, Vec3},
    scene::DeltaLight,
    spectrum::Spectrum,
    texture::{
        Channel, Checker, Coordinates, Filtering, Grid, Marble, Noise, Pattern, Procedure, Transfer, UvTransform, Wood,
        Wrap,
    },
};
use etendue_scene::{
    SourceMap,
    description::{
        Angle, ApertureRecord, EnvironmentRecord, Focus, FovAxis, Lens, SceneDescription, ShapeRecord, SkyRecord, Step,
        SunRecord, TextureRecord, UpAxis, View,
    },
    physics::{BodyKind, CollisionShape, Combine, JointKind, Mass},
    read_toml,
    sun_position::Moment,
};
use std::path::Path;

#[track_caller]
fn read(text: &str) -> SceneDescription {
    let text = if text.contains("[camera]") { text.to_owned() } else { format!("{CAMERA}{text}") };
    let mut sources = SourceMap::new();
    let file = sources.insert("s.toml", text.clone().into_bytes()).unwrap();
    let (description, diagnostics) = read_toml(file, text.as_bytes(), Path::new("folder"));
    let found: Vec<_> = diagnostics.iter().map(|d| d.one_line(&sources)).collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
    description.unwrap()
}

const CAMERA: &str = "camera = { position = [0, 0, 5], look_at = [0, 0, 0] }\n";

/// A value that a key takes, whatever the type of its table.
fn value(section: &str, key: &str) -> &'static str {
    match (section, key) {
        ("[camera]", "position") => "[1, 2, 3]",
        ("[camera]", "look_at") => "[0, 2, 3]",
        ("[camera]", "up") => "[0, 0, 1]",
        ("[camera]", "fov") => "30.5",
        ("[camera]", "fov_axis") => "\"smaller\"",
        ("[camera]", "lens_radius") => "0.25",
        ("[camera]", "roll") => "2.5",
        ("[camera]", "near_clip") => "0.125",
        ("[camera]", "focal_length") => "50",
        ("[camera]", "sensor") => "[24, 16]",
        ("[camera]", "f_number") => "2",
        ("[camera]", "aperture") => "\"polygon\"",
        ("[camera]", "blades") => "9",
        ("[camera]", "aperture_rotation") => "-15",
        ("[camera]", "focus_point") => "[0, 0, -1]",
        ("[camera]", "focus_distance" | "height") => "2",
        ("[film]", "size") => "[64, 32]",
        ("[film]", "filter") => "{ type = \"box\", radius = 1 }",
        ("[film]", "crop") => "[1, 2, 3, 4]",
        ("[film]", "exposure") => "-1.5",
        ("[film]", "balance") => "[2, 1, 0.5]",
        ("[film]", "encoding") => "\"linear\"",
        ("[film]", "tonemap") => "\"none\"",
        ("[film]", "transparent") => "true",
        ("[film]", "aovs") => "[\"depth\", \"albedo\"]",
        ("film.filter", "radius" | "sigma" | "b" | "c") => "0.75",
        ("[sampler]", "spp" | "seed") => "9",
        ("[integrator]", "depth" | "splitting") => "8",
        ("[integrator]", "distance") => "0.5",
        ("[accelerator]", "split") => "\"midpoint\"",
        ("[materials.NAME]", "emission") => "{ radiance = [1, 2, 3], two_sided = true }",
        ("[materials.NAME]", "thin") => "true",
        ("[materials.NAME]", "bump") => "{ file = \"h.png\", factor = 0.01 }",
        ("[materials.NAME]", "normal_map") => "{ file = \"n.png\" }",
        ("[materials.NAME]", "normal_scale") => "0.5",
        ("[materials.NAME]", "normal_y") => "\"down\"",
        ("[materials.NAME]", "tangent") => "{ type = \"radial\", center = [1, 2, 3], rotation = 90 }",
        ("[materials.NAME]", "form") => "\"normalised\"",
        ("[materials.NAME]", "metal") => "\"gold\"",
        ("[materials.NAME]", "ior") => "1.25",
        ("[materials.NAME]", "interior") => "\"milk\"",
        ("[materials.NAME]", "priority") => "-3",
        ("[materials.NAME]", "opacity" | "alpha" | "specular" | "transmission") => "0.5",
        ("[materials.NAME]", "exponent" | "transmission_exponent") => "50",
        ("[materials.NAME]", "metallic" | "roughness" | "anisotropic" | "coat" | "coat_roughness") => "0.25",
        ("[materials.NAME]", "rotation") => "90",
        ("[materials.NAME]", "sheen_roughness") => "0.75",
        ("[materials.NAME]", _) => "[0.25, 0.5, 0.125]",
        ("[textures.NAME]", "file") => "\"t.png\"",
        ("[textures.NAME]", "encoding") => "\"linear\"",
        ("[textures.NAME]", "channel") => "\"green\"",
        ("[textures.NAME]", "filter") => "\"bilinear\"",
        ("[textures.NAME]", "wrap") => "[\"mirror\", \"clamp\"]",
        ("[textures.NAME]", "coordinates") => "\"uv\"",
        ("[textures.NAME]", "scale" | "offset") => "[2, 4]",
        ("[textures.NAME]", "rotate") => "30",
        ("[textures.NAME]", "gain" | "base") => "0.5",
        ("[textures.NAME]", "color1") => "[0.25, 0.5, 0.125]",
        ("[textures.NAME]", "color2") => "{ texture = \"other\", factor = 0.5 }",
        ("[textures.NAME]", "weight") => "{ texture = \"other\" }",
        ("[textures.NAME]", "octaves") => "7",
        ("[textures.NAME]", "turbulence" | "radial") => "true",
        ("[textures.NAME]", "axis") => "\"z\"",
        ("[textures.NAME]", "seed") => "9",
        ("[textures.NAME]", "stops") => "[0.5, { at = 0.75, color = \"#ff0000\" }]",
        ("[textures.NAME]", "from") => "[0.25, 0]",
        ("[textures.NAME]", "to") => "[1, 1]",
        ("[textures.NAME]", _) => "0.25",
        ("[environment]", "image") => "\"sky.hdr\"",
        ("[environment]", "rotation") => "-30",
        ("[environment]", "up") => "\"z\"",
        ("[environment]", "elevation" | "azimuth") => "-12.5",
        ("[environment]", "date") => "2024-02-29",
        ("[environment]", "time") => "\"14:30:15\"",
        ("[environment]", "utc_offset" | "turbidity") => "2",
        ("[environment]", "latitude" | "longitude") => "50.25",
        ("[environment]", "ground" | "sun_size") => "0.5",
        ("[environment]", "sun_disk") => "false",
        ("[environment]", _) => "[1, 2, 3]",
        ("[[lights]]", "position" | "direction") => "[1, 2, 3]",
        ("[[lights]]", "target") => "[1, 2, 5]",
        ("[[lights]]", "angle") => "90",
        ("[[lights]]", "blend") => "0.5",
        ("[[lights]]", _) => "[1, 2, 3]",
        ("[[objects]]", "name") => "\"thing\"",
        ("[[objects]]", "material") => "\"m\"",
        ("[[objects]]", "materials") => "{ \"of the file\" = \"m\" }",
        ("[[objects]]", "transform") => "[{ scale = 2 }, { translate = [1, 2, 3] }]",
        ("[[objects]]", "mesh") => "\"m\"",
        ("[[objects]]", "file") => "\"a.obj\"",
        ("[[objects]]", "crease_angle") => "30",
        ("[[objects]]", "simplify") => "{ faces = 1000 }",
        ("[[objects]]", "center" | "corner" | "min") => "[-1, -2, -3]",
        ("[[objects]]", "radius") => "0.5",
        ("[[objects]]", "u") => "[1, 0, 0]",
        ("[[objects]]", "v") => "[0, 1, 0]",
        ("[[objects]]", "max") => "[1, 2, 3]",
        ("[[objects]]", "segments") => "5",
        ("[[objects]]", "size") => "[4, 5]",
        ("[[objects]]", "body") => "{ kind = \"kinematic\", restitution = 0.5 }",
        ("[[objects]]", "motion") => "{ translate = { keys = [[0, [0, 0, 0]], [1, [1, 2, 3]]] } }",
        ("body", "shape") => "\"hull\"",
        ("body", "group") => "\"g\"",
        ("body", "linear_velocity" | "angular_velocity") => "[1, 2, 3]",
        ("body", _) => "0.25",
        ("[physics]", "gravity") => "[0, 0, -2]",
        ("[physics]", "substeps" | "iterations") => "7",
        ("[physics]", "friction_rule" | "restitution_rule") => "\"min\"",
        ("[physics]", "sleep") => "false",
        ("[physics]", "ignore") => "[[\"g\", \"g\"]]",
        ("[physics]", _) => "0.25",
        ("[[joints]]", "bodies") => "[\"one\", \"two\"]",
        ("[[joints]]", "anchor") => "[1, 2, 3]",
        ("[[joints]]", "axis") => "[0, 0, 2]",
        ("[[joints]]", "limits") => "[-30, 60]",
        ("[[joints]]", "motor") => "{ velocity = 1, position = 2, stiffness = 3, damping = 4, max_force = 5 }",
        ("[[joints]]", "collide") => "true",
        _ => panic!("give `{key}` of {section} a value here"),
    }
}

/// Reads tables of one section and type with all keys of that type but those `left_out`.
fn all_keys(section_name: &str, header: &str, choice: &str, name: &str, left_out: &[&str]) -> SceneDescription {
    let section = etendue_scene::read::keys::SECTIONS.iter().find(|s| s.name == section_name).unwrap();
    let mut text = format!("{header}\n{choice} = \"{name}\"\n");
    for key in section.keys {
        let applies = key.types.is_empty() || key.types.contains(&name);
        if applies && key.name != choice && !left_out.contains(&key.name) {
            text += &format!("{} = {}\n", key.name, value(section_name, key.name));
        }
    }
    if section_name == "[textures.NAME]" {
        text += "[textures.other]\ntype = \"checker\"\n";
        text += "[materials.m]\ntype = \"diffuse\"\nreflectance = { texture = \"t\" }\n";
    }
    if section_name == "[[objects]]" {
        text += "[materials.m]\ntype = \"black\"\n[meshes.m]\nfile = \"b.ply\"\n";
    }
    if section_name == "[materials.NAME]" {
        text += "[media.milk]\n";
    }
    read(&text)
}

#[test]
fn cameras() {
    let left_out = ["direction", "focal_length", "sensor", "f_number", "focus_point", "focus_object"];
    let scene = all_keys("[camera]", "[camera]", "type", "perspective", &left_out);
    assert_eq!((scene.camera.position, scene.camera.up), (DVec3::new(1.0, 2.0, 3.0), DVec3::Z));
    assert_eq!((scene.camera.roll, scene.camera.near_clip), (2.5, 0.125));
    let Lens::Perspective { angle, radius, aperture, focus } = scene.camera.lens else { panic!() };
    assert_eq!(
        (angle, radius, focus),
        (Angle::Field { fov: 30.5, axis: FovAxis::Smaller }, 0.25, Focus::Distance(2.0))
    );
    assert_eq!(aperture, ApertureRecord::Polygon { blades: 9, rotation: -15.0 });
    let left_out = ["direction", "fov", "fov_axis", "lens_radius", "focus_distance", "focus_object"];
    let scene = all_keys("[camera]", "[camera]", "type", "perspective", &left_out);
    let Lens::Perspective { angle, radius, focus, .. } = scene.camera.lens else { panic!() };
    assert_eq!((angle, radius), (Angle::Focal { length: 50.0, width: 24.0, height: Some(16.0) }, 0.0125));
    assert!(matches!(focus, Focus::Point(at) if at.value == DVec3::new(0.0, 0.0, -1.0)));
    let scene = all_keys("[camera]", "[camera]", "type", "orthographic", &["direction"]);
    assert_eq!(scene.camera.lens, Lens::Orthographic { height: 2.0 });
    let scene = read("[camera]\nposition = [0, 0, 0]\ndirection = [0, 0, 3]\n");
    assert_eq!(scene.camera.view, View::Direction(DVec3::Z * 3.0));
}

#[test]
fn settings() {
    let scene = all_keys("[sampler]", "[sampler]", "type", "independent", &[]);
    assert_eq!((scene.sampler.spp, scene.sampler.seed), (9, 9));
    for name in ["path", "light-split", "brute", "normal", "uv", "depth", "ids", "ao"] {
        let scene = all_keys("[integrator]", "[integrator]", "type", name, &[]);
        assert_eq!(scene.integrator.integrator.name(), name);
        let solves = ["path", "light-split", "brute"].contains(&name);
        let parts = if solves { 8 } else { 1 };
        assert_eq!((scene.integrator.depth.is_some(), scene.integrator.splitting), (solves, Some(parts)));
    }
    assert_eq!(read("[integrator]\nsplitting = \"auto\"\n").integrator.splitting, None);
    for name in ["bvh", "kdtree", "brute"] {
        all_keys("[accelerator]", "[accelerator]", "type", name, &[]);
    }
    for name in ["gaussian", "box", "tent", "mitchell", "lanczos"] {
        all_keys("film.filter", "[film.filter]", "type", name, &[]);
    }
    let film = read(&format!(
        "[film]\nsize = {}\nexposure = 2\ncrop = {}\naovs = {}\n",
        value("[film]", "size"),
        value("[film]", "crop"),
        value("[film]", "aovs")
    ))
    .film;
    assert_eq!(
        (film.size, film.display.exposure, film.crop.unwrap().value, film.aovs.len()),
        ([64, 32], 2.0, [1, 2, 3, 4], 2)
    );
    assert_eq!(
        read("[environment]\nradiance = [1, 2, 3]").environment,
        Some(EnvironmentRecord::Constant(Spectrum([1.0, 2.0, 3.0])))
    );
}

#[test]
fn environments() {
    let environment = |name: &str| all_keys("[environment]", "[environment]", "type", name, &[]).environment.unwrap();
    let colour = Spectrum([1.0, 2.0, 3.0]);
    assert_eq!(environment("constant"), EnvironmentRecord::Constant(colour));
    let gradient = EnvironmentRecord::Gradient { top: colour, horizon: colour, bottom: colour, up: UpAxis::Z };
    assert_eq!(environment("gradient"), gradient);
    let EnvironmentRecord::Image { file, strength, rotation, up } = environment("image") else { panic!() };
    assert_eq!((file.value.as_path(), strength, rotation, up), (Path::new("sky.hdr"), colour, -30.0, UpAxis::Z));
    // Skies, by each way to place the sun.
    let moments = ["date", "time", "utc_offset", "latitude", "longitude"];
    let sky = |left_out: &[&str]| match all_keys("[environment]", "[environment]", "type", "sky", left_out).environment
    {
        Some(EnvironmentRecord::Sky(record)) => record,
        other => panic!("{other:?}"),
    };
    let SkyRecord { sun, up, north, turbidity, ground, strength, sun_size, sun_disk, .. } =
        sky(&[&moments[..], &["elevation", "azimuth"]].concat());
    assert_eq!((sun, north), (SunRecord::Direction(DVec3::new(1.0, 2.0, 3.0)), Some(DVec3::new(1.0, 2.0, 3.0))));
    assert_eq!((up, turbidity, sun_size, sun_disk), (UpAxis::Z, 2.0, 0.5, false));
    assert_eq!((ground, strength), (Spectrum::splat(0.5), colour));
    let angles = sky(&[&moments[..], &["sun"]].concat()).sun;
    assert_eq!(angles, SunRecord::Angles { elevation: -12.5, azimuth: -12.5 });
    let moment = Moment::new([2024, 2, 29], 12.0 * 3600.0 + 30.0 * 60.0 + 15.0).unwrap();
    let seen = sky(&["sun", "elevation", "azimuth"]).sun;
    assert_eq!(seen, SunRecord::Moment { moment, latitude: 50.25, longitude: 50.25 });
    // Without a type the other keys tell.
    let short = |text: &str| read(&format!("[environment]\n{text}")).environment.unwrap();
    let EnvironmentRecord::Image { strength, up: UpAxis::Y, .. } = short("image = \"a.exr\"") else { panic!() };
    assert_eq!(strength, Spectrum::ONE);
    let EnvironmentRecord::Gradient { horizon, bottom, .. } = short("top = 1\nhorizon = 2") else { panic!() };
    assert_eq!((horizon, bottom), (Spectrum::splat(2.0), Spectrum::splat(2.0)));
}

#[test]
fn lights() {
    let light =
        |name: &str, left_out: &[&str]| all_keys("[[lights]]", "[[lights]]", "type", name, left_out).lights[0].value;
    let (at, colour) = (DVec3::new(1.0, 2.0, 3.0), Spectrum([1.0, 2.0, 3.0]));
    assert_eq!(light("point", &[]), DeltaLight::Point { position: at, intensity: colour });
    assert_eq!(light("directional", &[]), DeltaLight::Directional { direction: at, irradiance: colour });
    let spot = |direction| {
        let half_angle = std::f64::consts::FRAC_PI_4;
        DeltaLight::Spot { position: at, direction, half_angle, blend: 0.5, intensity: colour }
    };
    assert_eq!(light("spot", &["target"]), spot(at));
    assert_eq!(light("spot", &["direction"]), spot(DVec3::new(0.0, 0.0, 2.0)));
}

#[test]
fn film_with_every_key() {
    let keys = ["size", "filter", "crop", "exposure", "balance", "tonemap", "encoding", "aovs", "transparent"];
    let lines: String = keys.iter().map(|k| format!("{k} = {}\n", value("[film]", k))).collect();
    assert!(read(&format!("[film]\n{lines}")).film.transparent);
}

#[test]
fn materials() {
    for name in [
        "diffuse",
        "mirror",
        "glass",
        "rough-metal",
        "rough-glass",
        "brushed-metal",
        "mtl",
        "phong",
        "principled",
        "black",
    ] {
        let left_out: &[&str] = if name == "rough-metal" { &["bump", "metal"] } else { &["bump"] };
        let scene = all_keys("[materials.NAME]", "[materials.m]", "type", name, left_out);
        let material = &scene.materials[0].material;
        assert_eq!((material.name.as_str(), &material.opacity), ("m", &0.5.into()));
        let emission = material.emission.as_ref().unwrap();
        assert_eq!((&emission.radiance, emission.two_sided), (&Spectrum([1.0, 2.0, 3.0]).into(), true));
        assert!(matches!(&material.relief, Some(Relief::Normals { scale: [0.5, -0.5], .. })));
        let direction = Tangent::Radial { center: DVec3::new(1.0, 2.0, 3.0), axis: None };
        assert_eq!(material.tangent, TangentField { direction, rotation: 90f32.to_radians().into() });
        assert_eq!((material.interior.as_deref(), material.priority), (Some("milk"), Some(-3)));
    }
    let boundary = &all_keys("[materials.NAME]", "[materials.m]", "type", "boundary", &[]).materials[0].material;
    assert_eq!((boundary.scattering.clone(), &boundary.opacity), (Scattering::Black, &0.0.into()));
    assert_eq!((boundary.interior.as_deref(), boundary.priority), (Some("milk"), Some(-3)));
    let scene = all_keys(
        "[materials.NAME]",
        "[materials.m]",
        "type",
        "rough-metal",
        &["eta", "k", "normal_map", "normal_scale", "normal_y"],
    );
    let Scattering::RoughMetal { alpha, .. } = &scene.materials[0].material.scattering else { panic!() };
    assert_eq!(alpha.each_ref().map(|a| a.factor), [0.5; 2]);
    let Some(Relief::Bump { height }) = &scene.materials[0].material.relief else { panic!() };
    assert_eq!(
        (height.factor, height.texture.as_ref().unwrap().first_image().unwrap().file.value.as_path()),
        (0.01, Path::new("h.png"))
    );
    let scene = read(
        "[materials.a]\ntype = \"diffuse\"\nreflectance = \"#ff0080\"\nemission = 3\n[materials.\"Z z\"]\ntype = \"glass\"",
    );
    let Scattering::Diffuse { reflectance, .. } = &scene.materials[0].material.scattering else { panic!() };
    let reflectance = reflectance.factor;
    assert_eq!((reflectance[0], reflectance[1]), (1.0, 0.0));
    assert!((reflectance[2] - 0.215_86).abs() < 1e-5);
    assert_eq!(scene.materials[0].material.emission.as_ref().unwrap().radiance, Spectrum::splat(3.0).into());
    assert_eq!(scene.materials[1].material.name, "Z z");
}

#[test]
fn direction_fields() {
    let field = |text: &str| {
        let scene = read(&format!("[materials.m]\ntype = \"brushed-metal\"\ntangent = {text}"));
        scene.materials[0].material.tangent.clone()
    };
    let center = DVec3::new(1.0, 2.0, 3.0);
    assert_eq!(field("\"uv\""), TangentField::default());
    assert_eq!(field("{ rotation = -45 }").rotation, (-45f32).to_radians().into());
    for (text, direction) in [
        ("type = \"uv\"", Tangent::Uv),
        ("type = \"constant\", direction = [0, 0, 2]", Tangent::Constant(DVec3::Z)),
        ("type = \"constant\", direction = \"x\"", Tangent::Constant(DVec3::X)),
        ("type = \"radial\", center = [1, 2, 3]", Tangent::Radial { center, axis: None }),
        ("type = \"radial\", center = [1, 2, 3], axis = \"y\"", Tangent::Radial { center, axis: Some(DVec3::Y) }),
        ("type = \"tangential\", center = [1, 2, 3]", Tangent::Tangential { center, axis: None }),
        (
            "type = \"tangential\", center = [1, 2, 3], axis = [3, 0, 0]",
            Tangent::Tangential { center, axis: Some(DVec3::X) },
        ),
    ] {
        let turned = field(&format!("{{ {text}, rotation = {{ file = \"turn.png\", factor = 180 }} }}"));
        assert_eq!(turned.direction, direction);
        assert_eq!(turned.rotation.factor, 180f32.to_radians());
        assert!(turned.rotation.texture.is_some());
    }
    let scene = all_keys("[materials.NAME]", "[materials.m]", "type", "brushed-metal", &["bump"]);
    let (reflectance, form) = (Spectrum([0.25, 0.5, 0.125]), GrooveForm::Normalised);
    let metal = Scattering::BrushedMetal { reflectance, exponent: 50.0, form };
    assert_eq!(scene.materials[0].material.scattering, metal.into());
}

#[test]
fn mixtures() {
    let metal = read("[materials.m]\ntype = \"rough-metal\"\nmetal = \"iron\"\nalpha = [0.1, { file = \"a.png\" }]");
    let Scattering::RoughMetal { alpha: [along, across], .. } = &metal.materials[0].material.scattering else {
        panic!()
    };
    assert_eq!((along, across.texture.is_some()), (&0.1.into(), true));
    let of = |name| all_keys("[materials.NAME]", "[materials.m]", "type", name, &["bump"]);
    let (color, half) = (Spectrum([0.25, 0.5, 0.125]), Spectrum::splat(0.5));
    let lobes = PhongLobes {
        diffuse: color,
        specular: half,
        exponent: 50.0,
        diffuse_transmission: color,
        transmission: half,
        transmission_exponent: 50.0,
        ior: 1.25,
    };
    assert_eq!(of("phong").materials[0].material.scattering, Scattering::Phong(lobes).into());
    let parameters = PrincipledParameters {
        base_color: color,
        metallic: 0.25,
        roughness: 0.25,
        anisotropic: 0.25,
        rotation: 90f32.to_radians(),
        ior: 1.25,
        specular: 0.5,
        transmission: 0.5,
        coat: 0.25,
        coat_roughness: 0.25,
        sheen: color,
        sheen_roughness: 0.75,
    };
    assert_eq!(of("principled").materials[0].material.scattering, Scattering::Principled(parameters).into());
}

#[test]
fn textures() {
    let scene = read(
        "[materials.m]\ntype = \"diffuse\"\nreflectance = { texture = \"t\", factor = [2, 1, 0.5] }\n\
         opacity = { texture = \"u\" }\nemission = { radiance = { file = \"e.exr\" } }\n\
         [textures.t]\nfile = \"a b.png\"\nencoding = \"linear\"\nchannel = \"red\"\nfilter = \"nearest\"\n\
         wrap = [\"mirror\", \"clamp\"]\nscale = [2, 4]\nrotate = 90\noffset = [0.25, 0.5]\ngain = -1\nbase = 1\n\
         [textures.u]\nfile = \"u.png\"\nwrap = \"black\"\nchannel = \"alpha\"",
    );
    let material = &scene.materials[0].material;
    let Scattering::Diffuse { reflectance, .. } = &material.scattering else { panic!() };
    assert_eq!(reflectance.factor, Spectrum([2.0, 1.0, 0.5]));
    let t = reflectance.texture.as_ref().unwrap();
    let image = t.first_image().unwrap();
    assert_eq!((image.file.value.as_path(), image.transfer), (Path::new("a b.png"), Some(Transfer::Linear)));
    let m = &t.mapping;
    assert_eq!((m.channel, m.filtering, m.wrap), (Channel::Red, Filtering::Nearest, [Wrap::Mirror, Wrap::Clamp]));
    assert_eq!((m.gain, m.base), (-1.0, 1.0));
    let turned = m.transform.apply(etendue::math::vec2(1.0, 0.0));
    assert!((turned.x - 0.25).abs() < 1e-6 && (turned.y - 2.5).abs() < 1e-6, "{turned}");
    let u = material.opacity.texture.as_ref().unwrap();
    assert_eq!(
        (u.first_image().unwrap().transfer, u.mapping.channel, u.mapping.wrap),
        (None, Channel::Alpha, [Wrap::Black; 2])
    );
    let emission = material.emission.as_ref().unwrap();
    assert_eq!(
        emission.radiance.texture.as_ref().unwrap().first_image().unwrap().file.value.as_path(),
        Path::new("e.exr")
    );
}

/// The texture `t` of a scene.
fn texture(scene: &SceneDescription) -> TextureRecord {
    let Scattering::Diffuse { reflectance, .. } = &scene.materials[0].material.scattering else { panic!() };
    reflectance.texture.clone().unwrap()
}

#[test]
fn patterns() {
    for name in ["image", "checker", "grid", "noise", "wood", "marble", "gradient", "mix", "multiply", "vertex-color"] {
        let texture = &*texture(&all_keys("[textures.NAME]", "[textures.t]", "type", name, &[]));
        assert_eq!(texture.pattern.name(), name);
        assert_eq!((texture.mapping.channel, texture.mapping.gain, texture.mapping.base), (Channel::Green, 0.5, 0.5));
        let placed = !["mix", "multiply", "vertex-color"].contains(&name);
        assert_eq!(texture.mapping.transform, if placed { transform() } else { UvTransform::default() }, "{name}");
        match texture.pattern.clone() {
            Pattern::Procedure { procedure, coordinates, colors: [first, second] } => {
                assert_eq!(coordinates, Coordinates::Uv);
                assert_eq!(first, Spectrum([0.25, 0.5, 0.125]).into());
                assert_eq!((second.factor, second.texture.unwrap().pattern.name()), (Spectrum::splat(0.5), "checker"));
                let (axis, distortion, seed) = (Vec3::Z, 0.25, 9);
                let expected = match procedure {
                    Procedure::Checker(_) => Procedure::Checker(Checker),
                    Procedure::Grid(_) => Procedure::Grid(Grid { width: 0.25 }),
                    Procedure::Noise(_) => {
                        Procedure::Noise(Noise { octaves: 7, roughness: 0.25, turbulence: true, seed })
                    }
                    Procedure::Wood(_) => Procedure::Wood(Wood { axis, distortion, seed }),
                    Procedure::Marble(_) => Procedure::Marble(Marble { axis, distortion, seed }),
                };
                assert_eq!(procedure, expected);
            }
            Pattern::Gradient(gradient) => {
                assert_eq!((gradient.from, gradient.to), (Vec3::new(0.25, 0.0, 0.0), Vec3::new(1.0, 1.0, 0.0)));
                let stops: Vec<_> = gradient.stops.iter().map(|stop| (stop.at, stop.color)).collect();
                assert_eq!(stops, [(0.0, Spectrum::splat(0.5)), (0.75, Spectrum([1.0, 0.0, 0.0]))]);
                assert!(gradient.radial);
            }
            Pattern::Mix { colors, weight } => {
                assert!(weight.texture.is_some() && colors[1].texture.is_some());
            }
            Pattern::Multiply(colors) => assert!(colors[1].texture.is_some()),
            Pattern::Image(_) | Pattern::VertexColor => {}
        }
    }
    let solid = read(
        "[materials.m]\ntype = \"diffuse\"\nreflectance = { texture = \"t\" }\n\
         [textures.t]\ntype = \"checker\"\ncoordinates = \"object\"\nscale = [1, 2, 3]\noffset = 0.5",
    );
    let Pattern::Procedure { coordinates, .. } = texture(&solid).pattern.clone() else { panic!() };
    let (scale, offset) = (Vec3::new(1.0, 2.0, 3.0), Vec3::splat(0.5));
    assert_eq!(coordinates, Coordinates::Object { scale, offset });
}

fn transform() -> UvTransform {
    UvTransform::new([2.0, 4.0], 30.0, [2.0, 4.0])
}

#[test]
fn objects() {
    for (name, left_out) in [
        ("mesh", &["file", "crease_angle", "simplify", "materials"][..]),
        ("mesh", &["mesh", "materials"]),
        ("sphere", &[]),
        ("rectangle", &["size"]),
        ("rectangle", &["corner", "u", "v"]),
        ("box", &["size"]),
        ("disk", &[]),
    ] {
        let scene = all_keys("[[objects]]", "[[objects]]", "shape", name, left_out);
        let object = &scene.objects[0];
        assert_eq!(object.transform.len(), 2);
        assert_eq!(object.material.as_ref().unwrap().value, "m");
    }
    let scene = all_keys("[[objects]]", "[[objects]]", "shape", "mesh", &["mesh", "material"]);
    let [of_file, of_scene] = &scene.objects[0].materials[0];
    assert_eq!((&of_file.value[..], &of_scene.value[..]), ("of the file", "m"));
    let scene = read("[[objects]]\nshape = \"box\"\nsize = 2\n[[objects]]\nshape = \"box\"\nsize = [1, 2, 3]");
    assert!(matches!(scene.objects[0].shape, ShapeRecord::Box { max, .. } if max == DVec3::ONE));
    assert!(matches!(scene.objects[1].shape, ShapeRecord::Box { max, .. } if max == DVec3::new(0.5, 1.0, 1.5)));
}

#[test]
fn bodies() {
    let of =
        |text: &str| read(&format!("[[objects]]\nshape = \"sphere\"\nbody = {text}")).objects[0].body.clone().unwrap();
    let all = |kind: &str, left_out: &str| {
        let section = etendue_scene::read::keys::SECTIONS.iter().find(|s| s.name == "body").unwrap();
        let used = section.keys.iter().filter(|k| k.types.is_empty() || k.types.contains(&kind));
        let used = used.filter(|k| k.name != "kind" && k.name != left_out);
        let keys: Vec<_> = used.map(|k| format!("{} = {}", k.name, value("body", k.name))).collect();
        of(&format!("{{ kind = \"{kind}\", {} }}", keys.join(", ")))
    };
    let v = DVec3::new(1.0, 2.0, 3.0);
    let heavy = all("dynamic", "density");
    assert_eq!((heavy.mass, heavy.linear_velocity, heavy.angular_velocity), (Mass::Total(0.25), v, v));
    assert_eq!((heavy.friction, heavy.restitution, heavy.gravity_scale), (0.25, 0.25, 0.25));
    assert_eq!((heavy.linear_damping, heavy.angular_damping), (0.25, 0.25));
    assert_eq!((heavy.shape, heavy.group.unwrap().value.as_str()), (CollisionShape::Hull, "g"));
    assert_eq!(all("dynamic", "mass").mass, Mass::Density(0.25));
    for kind in BodyKind::ALL {
        assert_eq!(of(&format!("\"{}\"", kind.name())).kind, kind);
        assert_eq!(all(kind.name(), "mass").kind, kind);
    }
}

#[test]
fn physics_and_joints() {
    let balls = "[[objects]]\nname = \"one\"\nshape = \"sphere\"\nbody = { group = \"g\" }\n\
                 [[objects]]\nname = \"two\"\nshape = \"sphere\"\nbody = \"fixed\"\n";
    let keys = |name: &str| etendue_scene::read::keys::SECTIONS.iter().find(|s| s.name == name).unwrap().keys;
    let lines = |name: &str, kind: &str| {
        let used = keys(name).iter().filter(|k| k.name != "type" && (k.types.is_empty() || k.types.contains(&kind)));
        used.map(|k| format!("{} = {}\n", k.name, value(name, k.name))).collect::<String>()
    };
    let physics = read(&format!("{balls}[physics]\n{}", lines("[physics]", ""))).physics;
    assert_eq!((physics.gravity, physics.step, physics.substeps), (DVec3::new(0.0, 0.0, -2.0), 0.25, 7));
    assert_eq!((physics.iterations, physics.start, physics.duration), (7, 0.25, Some(0.25)));
    assert_eq!((physics.warm_up, physics.length_unit, physics.sleep), (0.25, Some(0.25), false));
    assert_eq!((physics.friction_rule, physics.restitution_rule), (Combine::Min, Combine::Min));
    assert_eq!((physics.contact_frequency, physics.contact_damping, physics.ignore.len()), (0.25, 0.25, 1));
    for kind in JointKind::ALL {
        let joint = format!("[[joints]]\ntype = \"{}\"\n{}", kind.name(), lines("[[joints]]", kind.name()));
        let joint = &read(&format!("{balls}{joint}")).joints[0];
        let axial = matches!(kind, JointKind::Hinge | JointKind::Slider);
        assert_eq!((joint.kind, joint.anchor, joint.collide), (kind, DVec3::new(1.0, 2.0, 3.0), true));
        assert_eq!((joint.limits.is_some(), joint.motor.is_some()), (axial, axial));
        assert_eq!(joint.axis, if axial { DVec3::Z } else { DVec3::X });
    }
    let to_world = read(&format!("{balls}[[joints]]\ntype = \"ball\"\nbodies = \"one\"\nanchor = [0, 0, 0]"));
    assert!(to_world.joints[0].bodies.1.is_none());
}

#[test]
fn steps() {
    let scene = read(
        "[[objects]]\nshape = \"sphere\"\ntransform = [{ translate = [1, 2, 3] }, { rotate = { axis = \"z\", angle = 90 } },\n\
         { rotate = { axis = [0, 0, 2], angle = 9 } }, { scale = [1, -2, 3] }, { matrix = [[1,0,0,4],[0,1,0,5],[0,0,1,6]] },\n\
         { look_at = { position = [0, 0, 0], target = [0, 0, 1], up = [1, 0, 0] } }, { relocate = [0, 0, 0] }]\n\
         [[objects]]\nshape = \"sphere\"\ntransform = { scale = 3 }",
    );
    let steps: Vec<Step> = scene.objects[0].transform.iter().map(|s| s.value).collect();
    assert_eq!(steps[0], Step::Translate(DVec3::new(1.0, 2.0, 3.0)));
    assert_eq!(steps[2], Step::Rotate { axis: DVec3::Z, angle: 9.0 });
    assert_eq!(steps[3], Step::Scale(DVec3::new(1.0, -2.0, 3.0)));
    assert_eq!(steps[4], Step::Matrix([1.0, 0.0, 0.0, 4.0, 0.0, 1.0, 0.0, 5.0, 0.0, 0.0, 1.0, 6.0]));
    assert_eq!(steps[6], Step::Relocate(DVec3::ZERO));
    assert_eq!(scene.objects[1].transform[0].value, Step::Scale(DVec3::splat(3.0)));
}

#[test]
fn meshes() {
    let scene =
        read("[meshes.a]\nfile = \"a.obj\"\ncrease_angle = 180\n[[objects]]\nfile = \"b.ply\"\ncrease_angle = 1.5");
    assert_eq!(scene.meshes[0].crease_angle, Some(180.0));
    assert!(matches!(scene.objects[0].shape, ShapeRecord::File { crease_angle: Some(1.5), .. }));
    let scene = read(
        "[meshes.a]\npositions = [[0,0,0],[1,0,0],[1,1,0],[0,1,0]]\nindices = [[0,1,2,3]]\n\
         normals = [[0,0,2],[0,0,2],[0,0,2],[0,0,2]]\nuvs = [[0,0],[1,0],[1,1],[0,1]]",
    );
    let etendue_scene::description::MeshSource::Inline(mesh) = &scene.meshes[0].source else { panic!() };
    assert_eq!(*mesh.indices, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(mesh.normals.as_ref().unwrap()[3], [0.0, 0.0, 1.0]);
    assert_eq!(mesh.uvs.as_ref().unwrap()[2], [1.0, 1.0]);
}
