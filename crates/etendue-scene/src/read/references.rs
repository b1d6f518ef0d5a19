//! Names that must be defined, and files that must be there.

use super::{error_at, fields::Context};
use crate::{
    Diagnostic, Diagnostics, Severity,
    description::{Focus, Lens, Located, MeshSource, SceneDescription, ShapeRecord},
    diagnostic::nearest,
    physics::BodyKind,
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// Checks every name that refers to another record, and that names are given once.
pub fn check(cx: &Context, description: &SceneDescription) {
    let materials: BTreeSet<&str> = description.materials.iter().map(|m| m.material.name.as_str()).collect();
    let meshes: BTreeSet<&str> = description.meshes.iter().map(|m| m.name.as_str()).collect();
    let media: BTreeSet<&str> = description.media.iter().map(|m| m.medium.name.as_str()).collect();
    if let Some(medium) = &description.world_medium {
        check_name(cx, medium, "medium", &media);
    }
    for record in &description.materials {
        if let (Some(name), Some(origin)) = (&record.material.interior, &record.interior) {
            let name = Located { value: name.clone(), origin: origin.clone() };
            check_name(cx, &name, "medium", &media);
        }
    }
    let mut names = BTreeMap::new();
    check_focus(cx, description);
    for object in &description.objects {
        if let Some(material) = &object.material {
            check_name(cx, material, "material", &materials);
        }
        for [_, material] in &object.materials {
            check_name(cx, material, "material", &materials);
        }
        if let ShapeRecord::Mesh(mesh) = &object.shape {
            check_name(cx, mesh, "mesh", &meshes);
        }
        if let (Some(motion), Some(body)) = (&object.motion, &object.body)
            && body.kind == BodyKind::Dynamic
        {
            let error = error_at("a dynamic body moves by itself, not by keys".to_owned(), &motion.origin);
            cx.push(error.help("make the body `kinematic`, or leave `motion` out"));
        }
        if let Some(name) = &object.name
            && names.insert(name.value.as_str(), ()).is_some()
        {
            cx.push(error_at(format!("two objects are called `{}`", name.value), &name.origin));
        }
    }
}

/// Objects may also be called by their number, as in messages.
fn check_focus(cx: &Context, description: &SceneDescription) {
    let Lens::Perspective { focus: Focus::Object(name), .. } = &description.camera.lens else { return };
    let numbered: Vec<String> = (1..=description.objects.len()).map(|number| format!("object {number}")).collect();
    let named = description.objects.iter().zip(&numbered);
    let known: BTreeSet<&str> = named.map(|(o, number)| o.name.as_ref().map_or(&number[..], |n| &n.value)).collect();
    if !known.contains(name.value.as_str()) {
        let error = error_at(format!("no object is called `{}`", name.value), &name.origin);
        cx.missing(match nearest(&name.value, known.iter().copied()) {
            Some(near) => error.help(format!("did you mean `{near}`?")),
            None => error.help("give the object a `name`"),
        });
    }
}

fn check_name(cx: &Context, name: &Located<String>, kind: &str, known: &BTreeSet<&str>) {
    if known.contains(name.value.as_str()) || cx.diagnostics.borrow().is_full(Severity::Error) {
        return;
    }
    let error = error_at(format!("no {kind} is called `{}`", name.value), &name.origin);
    cx.missing(match nearest(&name.value, known.iter().copied()) {
        Some(near) => error.help(format!("did you mean `{near}`?")),
        None => error.help(format!("define it in [{}.NAME]", plural(kind))),
    });
}

fn plural(kind: &str) -> &'static str {
    match kind {
        "mesh" => "meshes",
        "medium" => "media",
        _ => "materials",
    }
}

/// Checks that the mesh files are there, without reading them.
pub fn check_files(description: &SceneDescription) -> Diagnostics {
    let of_meshes = description.meshes.iter().filter_map(|m| match &m.source {
        MeshSource::File(path) => Some(path),
        MeshSource::Inline(_) => None,
    });
    let of_objects = description.objects.iter().filter_map(|o| match &o.shape {
        ShapeRecord::File { path, .. } => Some(path),
        _ => None,
    });
    let mut seen = BTreeMap::new();
    let mut diagnostics = Diagnostics::new();
    for file in of_meshes.chain(of_objects) {
        if let Some(error) = crate::build::unknown_ending(&file.value, &file.origin) {
            diagnostics.push(error);
            continue;
        }
        let found = *seen.entry(&file.value).or_insert_with(|| description.folder.join(&file.value).exists());
        if !found && !diagnostics.is_full(Severity::Error) {
            diagnostics.push(missing_file(&description.folder.join(&file.value), file));
        }
    }
    diagnostics
}

fn missing_file(path: &Path, file: &Located<PathBuf>) -> Diagnostic {
    let error = error_at(format!("no such file: {}", path.display()), &file.origin);
    let Some(folder) = path.parent() else { return error };
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let Ok(listing) = folder.read_dir() else {
        return error.help(format!("there is no folder {}", folder.display()));
    };
    let mut names: Vec<String> = listing.take(1000).filter_map(|e| e.ok()?.file_name().into_string().ok()).collect();
    names.sort();
    let wanted = path.file_name().unwrap_or_default().to_string_lossy();
    error.suggest(&wanted, names.iter().map(String::as_str))
}
