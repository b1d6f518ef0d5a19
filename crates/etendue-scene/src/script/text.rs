//! The scene of a script as the text of a scene file, each line with the place in the script that it comes from.

use super::{
    ScriptScene,
    materials::{Image, Medium, Surface, unused_name},
};
use crate::{
    Origin,
    description::{Located, Step},
    mtl::OldUse,
    write_toml::{number, numbers, text, vector},
};
use etendue::{
    bsdf::{MIRROR_EXPONENT, PhongLobes},
    material::{Color, Emission, Number, Parameter, Relief, Scattering},
    math::DVec3,
    spectrum::Spectrum,
};
use std::{
    collections::BTreeSet,
    path::{Path, PathBuf},
};

/// The centre about which the old program spread the normals of every surface with `bump`.
const BRUSHED_CENTRE: DVec3 = DVec3::new(0.3, 0.3, 0.0);

/// Text, and where its lines come from.
#[derive(Debug, Default)]
pub struct SceneText {
    /// Of a scene file.
    pub text: String,
    /// Of each line.
    pub origins: Vec<Option<Origin>>,
}

impl SceneText {
    fn line(&mut self, origin: Option<&Origin>, line: impl AsRef<str>) {
        self.text += line.as_ref();
        self.text.push('\n');
        self.origins.push(origin.cloned());
    }

    /// The origin of the line that holds the byte at `offset`.
    pub fn origin(&self, offset: usize) -> Option<&Origin> {
        let line = self.text.as_bytes()[..offset.min(self.text.len())].iter().filter(|&&byte| byte == b'\n').count();
        self.origins.get(line)?.as_ref()
    }
}

/// The text of the scene file. `name` gives the name that it has for a file.
pub fn scene_text<E>(scene: &ScriptScene, name: &mut dyn FnMut(&Path) -> Result<PathBuf, E>) -> Result<SceneText, E> {
    let mut name = |path: &Path| name(path).map(|path| text(&path.to_string_lossy()));
    let mut out = SceneText::default();
    out.line(None, format!("# The scene of the script {}.", text(&scene.path.display().to_string())));
    camera(scene, &mut out);
    settings(scene, &mut out);
    if let Some(medium) = scene.materials.medium.as_ref().filter(|medium| medium.rate > 0.0) {
        gas(medium, &mut out);
    }
    for image in &scene.materials.images {
        let file = name(&image.path)?;
        out.line(None, "");
        out.line(Some(&image.origin), format!("[textures.{}]", key(&image.name)));
        out.line(Some(&image.origin), format!("file = {file}"));
        out.line(Some(&image.origin), "encoding = \"linear\"");
        out.line(Some(&image.origin), "wrap = \"clamp\"");
    }
    for surface in &scene.materials.surfaces {
        out.line(None, "");
        material(surface, &scene.materials.images, &mut out);
    }
    objects(scene, &mut name, &mut out)?;
    Ok(out)
}

fn camera(scene: &ScriptScene, out: &mut SceneText) {
    let Located { value: camera, origin } = &scene.camera;
    let mut line = |line: String| out.line(Some(origin), line);
    line("[camera]".to_owned());
    line(format!("position = {}", vector(camera.position)));
    line(format!("direction = {}", vector(camera.direction)));
    line(format!("up = {}", vector(camera.up)));
    line(format!("near_clip = {}", number(camera.distance)));
    line(format!("focal_length = {}", number(camera.distance)));
    line(format!("sensor = {}", numbers(camera.window)));
    if let Some(lens) = camera.lens {
        line(format!("lens_radius = {}", number(super::lens_radius(lens.side(camera.distance)))));
        line("aperture = \"square\"".to_owned());
        line(format!("focus_distance = {}", number(lens.focus)));
    }
}

fn settings(scene: &ScriptScene, out: &mut SceneText) {
    let script = &scene.script;
    let [width, height] = scene.size();
    out.line(None, "");
    out.line(None, "[film]");
    out.line(script.size.as_ref().map(|s| &s.origin), format!("size = [{width}, {height}]"));
    out.line(None, "filter = { type = \"gaussian\", sigma = 0.70710678, radius = 0.5 }");
    if let Some(filter) = &script.filter {
        out.line(Some(&filter.origin), format!("balance = {}", numbers(filter.value)));
    }
    out.line(None, "encoding = \"linear\"");
    if let Some(samples) = &script.samples {
        out.line(None, "");
        out.line(Some(&samples.origin), "[sampler]");
        out.line(Some(&samples.origin), format!("spp = {}", samples.value.spp()));
    }
    if let Some(depth) = &script.depth {
        out.line(None, "");
        out.line(Some(&depth.origin), "[integrator]");
        out.line(Some(&depth.origin), format!("depth = {}", depth.value + 1));
    }
    if let Some(ambient) = script.ambient.as_ref().filter(|ambient| ambient.value != [0.0; 3]) {
        out.line(None, "");
        out.line(Some(&ambient.origin), "[environment]");
        out.line(Some(&ambient.origin), format!("radiance = {}", numbers(ambient.value)));
    }
}

/// What fills the world: tiny matte balls, as the old program took the gas for.
fn gas(medium: &Medium, out: &mut SceneText) {
    out.line(None, "");
    let mut line = |line: String| out.line(Some(&medium.origin), line);
    line("[world]".to_owned());
    line("medium = \"gas\"".to_owned());
    line(String::new());
    line("[media.gas]".to_owned());
    line(format!("extinction = {}", digits(medium.rate)));
    line(format!("albedo = {}", rgb(medium.albedo)));
    line("phase = \"lambert-sphere\"".to_owned());
}

fn objects<E>(
    scene: &ScriptScene,
    name: &mut dyn FnMut(&Path) -> Result<String, E>,
    out: &mut SceneText,
) -> Result<(), E> {
    let mut names = BTreeSet::new();
    for object in &scene.objects {
        let origin = Some(&object.file.origin);
        let stem = object.path.file_stem().unwrap_or_default().to_string_lossy();
        let own = unused_name(&stem, |name| names.contains(name));
        out.line(None, "");
        out.line(origin, "[[objects]]");
        if !own.is_empty() {
            out.line(origin, format!("name = {}", text(&own)));
        }
        out.line(origin, format!("file = {}", name(&object.path)?));
        if let Some(replaced) = scene.replaced.get(&object.path).filter(|replaced| !replaced.is_empty()) {
            let pairs = replaced.iter().map(|[of_file, other]| format!("{} = {}", key(of_file), text(other)));
            out.line(origin, format!("materials = {{ {} }}", pairs.collect::<Vec<_>>().join(", ")));
        }
        if !object.transform.is_empty() {
            out.line(origin, "transform = [");
            for step in &object.transform {
                out.line(Some(&step.origin), format!("    {},", transform_step(&step.value)));
            }
            out.line(origin, "]");
        }
        names.insert(own);
    }
    Ok(())
}

/// The three kinds of steps that scripts have.
fn transform_step(step: &Step) -> String {
    match *step {
        Step::Relocate(to) => format!("{{ relocate = {} }}", vector(to)),
        Step::Scale(factors) => format!("{{ scale = {} }}", number(factors.x)),
        Step::Rotate { axis, angle } => {
            let letter = ["x", "y", "z"][axis.abs().max_position()];
            format!("{{ rotate = {{ axis = \"{letter}\", angle = {} }} }}", number(angle))
        }
        Step::Translate(_) | Step::Matrix(_) | Step::LookAt { .. } => String::new(),
    }
}

/// A key of a table: bare if it may be.
fn key(name: &str) -> String {
    let is_bare = !name.is_empty() && name.bytes().all(|b| b.is_ascii_alphanumeric() || b == b'_' || b == b'-');
    if is_bare { name.to_owned() } else { text(name) }
}

/// In as few digits as read back to the same bits.
fn digits(value: f32) -> String {
    number(format!("{value}").parse().unwrap_or_default())
}

fn rgb(Spectrum([r, g, b]): Spectrum) -> String {
    if r == g && g == b { digits(r) } else { format!("[{}, {}, {}]", digits(r), digits(g), digits(b)) }
}

fn textured(texture: Option<usize>, factor: String, images: &[Image]) -> String {
    match texture.and_then(|index| images.get(index)) {
        None => factor,
        Some(image) if factor == "1" => format!("{{ texture = {} }}", text(&image.name)),
        Some(image) => format!("{{ texture = {}, factor = {factor} }}", text(&image.name)),
    }
}

fn color(color: &Color<usize>, images: &[Image]) -> String {
    textured(color.texture, rgb(color.factor), images)
}

fn scalar(number: &Number<usize>, images: &[Image]) -> String {
    textured(number.texture, digits(number.factor), images)
}

fn material(surface: &Surface, images: &[Image], out: &mut SceneText) {
    let mut line = |line: String| out.line(Some(&surface.origin), line);
    line(format!("[materials.{}]", key(&surface.name)));
    if let OldUse::Brushed(reflectance) = surface.used_as {
        line("type = \"brushed-metal\"".to_owned());
        line(format!("reflectance = {}", rgb(reflectance)));
        line(format!("exponent = {}", digits(super::BRUSHED_EXPONENT)));
        line("form = \"normalised\"".to_owned());
        return line(format!("tangent = {{ type = \"radial\", center = {} }}", vector(BRUSHED_CENTRE)));
    }
    match &surface.material.scattering {
        Scattering::Phong(lobes) => phong(lobes, images, &mut line),
        _ => line("type = \"black\"".to_owned()),
    }
    if let Some(Emission { radiance, two_sided }) = &surface.material.emission {
        line(format!("emission = {{ radiance = {}, two_sided = {two_sided} }}", color(radiance, images)));
    }
    if let Some(Relief::Bump { height }) = &surface.material.relief {
        line(format!("bump = {}", scalar(height, images)));
    }
}

fn phong(lobes: &PhongLobes<Color<usize>, Number<usize>>, images: &[Image], line: &mut dyn FnMut(String)) {
    line("type = \"phong\"".to_owned());
    let black = |color: &Color<usize>| color.factor.is_black();
    let transparent = !black(&lobes.diffuse_transmission) || !black(&lobes.transmission);
    for (name, value) in [
        ("diffuse", &lobes.diffuse),
        ("specular", &lobes.specular),
        ("diffuse_transmission", &lobes.diffuse_transmission),
        ("transmission", &lobes.transmission),
    ] {
        if !black(value) {
            line(format!("{name} = {}", color(value, images)));
        }
    }
    let is_mirror = |exponent: &Number<usize>| *exponent == Parameter::constant(MIRROR_EXPONENT);
    if !black(&lobes.specular) {
        line(format!("exponent = {}", scalar(&lobes.exponent, images)));
    }
    if !black(&lobes.transmission) && !is_mirror(&lobes.transmission_exponent) {
        line(format!("transmission_exponent = {}", scalar(&lobes.transmission_exponent, images)));
    }
    if transparent && lobes.ior != Parameter::constant(1.0) {
        line(format!("ior = {}", scalar(&lobes.ior, images)));
    }
}
