//! What a script says that means something else here.

use super::{ScriptScene, grammar::PixelSampler};
use crate::{Diagnostic, Diagnostics, description::Located, mtl::OldUse};

/// Says each kind of reinterpretation once, at its first place.
pub fn tell(scene: &ScriptScene, found: &mut Diagnostics) {
    camera(scene, found);
    settings(scene, found);
    materials(scene, found);
    let moved = |object: &&super::Placed| !object.transform.is_empty();
    let has_spheres = |object: &&super::Placed| scene.meshes.get(&object.path).is_some_and(|m| !m.spheres.is_empty());
    if let Some(object) = scene.objects.iter().filter(moved).find(has_spheres) {
        let note = "`relocate`, `scale` and `rotate` act on spheres too, which the old program left where they were";
        found.push(Diagnostic::note(note).at(object.transform[0].origin.clone()));
    }
}

fn camera(scene: &ScriptScene, found: &mut Diagnostics) {
    let Located { value: camera, origin } = &scene.camera;
    let mut note = |message: String| found.push(Diagnostic::note(message).at(origin.clone()));
    if let Some(lens) = camera.lens {
        let side = lens.side(camera.distance);
        note(format!(
            "`camera`: the aperture of {} on the window is a square lens of {side:.6}, of the area of a round one of radius {:.6}",
            lens.aperture,
            super::lens_radius(side)
        ));
    }
    let skew = camera.skew();
    if skew > 0.1 {
        note(format!(
            "`camera`: up is {skew:.1} degrees from perpendicular to the view, which skewed the picture; it is not skewed here"
        ));
    }
    let Some(size) = &scene.script.size else { return };
    let pixels = camera.pixels();
    if (0..2).any(|i| (pixels[i] / f64::from(size.value[i]) - 1.0).abs() > 0.005) {
        let [width, height] = pixels.map(libm::round);
        let message = format!("the window holds {width} x {height} pixels of that `step`: it is fitted to the picture");
        let warning = Diagnostic::warning(message).at(size.origin.clone());
        found.push(warning.label("the old program showed the part of the window from its lower left corner"));
    }
}

fn settings(scene: &ScriptScene, found: &mut Diagnostics) {
    let script = &scene.script;
    let mut note = |message: String, origin| found.push(Diagnostic::note(message).at(origin));
    if let Some(ambient) = &script.ambient {
        let message = "`ambient` is the radiance of a constant environment, 1 for 255 of the old program";
        note(message.to_owned(), ambient.origin.clone());
    }
    if let Some(filter) = &script.filter {
        let message = "`filter` multiplies the picture where it becomes 8 bits (`balance`), which are stored in proportion to the light (`encoding`)";
        note(message.to_owned(), filter.origin.clone());
    }
    if let Some(samples) = &script.samples {
        let sampler = match samples.value {
            PixelSampler::Stratified(side) => format!("`Stratified {side}` is {side} times {side} samples"),
            PixelSampler::LatinCube(number) => format!("`LatinCube {number}` is {number} samples"),
        };
        let message = format!("`pixelSampler`: {sampler} a pixel, of the default sampler");
        note(message, samples.origin.clone());
    }
    if let Some(Located { value: depth, origin }) = &script.depth {
        let message = format!(
            "`rayTraceSampler`: depth {depth} is paths of {} edges, with the light that was added at the last surface; sampler and size have no meaning here",
            depth + 1
        );
        note(message, origin.clone());
    }
    for (message, origin) in [
        ("`intersectionTester` is not used: it does not change the picture; see --accel", &script.tester),
        ("`threading` is not used; see --threads", &script.threads),
        (
            "`writeRaw` is not used: -o with the name of an .exr, .hdr or .pfm file keeps values as they are",
            &script.write_raw,
        ),
    ] {
        if let Some(origin) = origin {
            note(message.to_owned(), origin.clone());
        }
    }
    if let Some(origin) = &script.from_raw {
        let warning = "`fromRaw` is not read: the objects are rendered instead of showing a stored picture";
        found.push(Diagnostic::warning(warning).at(origin.clone()));
    }
}

fn materials(scene: &ScriptScene, found: &mut Diagnostics) {
    let materials = &scene.materials;
    let first = |used: fn(&OldUse) -> bool| materials.surfaces.iter().find(|surface| used(&surface.used_as));
    let mut note = |message: &str, origin| found.push(Diagnostic::note(message).at(origin));
    // A lamp whose own material needs no other is not stated.
    let own = || scene.meshes.values().flat_map(|mesh| &mesh.materials).find(|m| m.material.emission.is_some());
    let stated = materials.surfaces.iter().find(|surface| surface.material.emission.is_some());
    let lamp = stated.map(|surface| surface.origin.clone()).or_else(|| own()?.origin.clone());
    if let Some(origin) = lamp {
        note("`AreaLightSource` emits radiance `Kd` on both sides, 1 for 255 of the old program", origin);
    }
    if let Some(surface) = first(|used| matches!(used, OldUse::Brushed(_))) {
        let message = "`bump` on a surface with `Ks` is brushed metal of that colour, its normals spread radially about (0.3, 0.3, 0) as the old program had it; the picture and `Kd` are not used";
        note(message, surface.origin.clone());
    }
    if let Some(medium) = &materials.medium {
        let message = "`GlobalScatter` fills the world: `n` is its extinction, `Kd` its albedo, and it scatters as tiny matte spheres do";
        note(message, medium.origin.clone());
    }
    if let Some(image) = materials.images.first() {
        note(
            "pictures are taken as they are stored, without the transfer function of sRGB, and go on with their edge",
            image.origin.clone(),
        );
    }
}
