//! Scene files in TOML: bytes to a [`SceneDescription`], with every finding of one run.

mod again;
mod animation;
mod fields;
mod keyed;
pub mod keys;
mod light;
mod material;
mod medium;
mod object;
mod pattern;
mod physics;
mod references;
mod settings;
mod simplify;
mod sky;
mod tangent;
mod texture;
mod toml_syntax;
mod values;

pub(crate) use animation::{DURATION, FPS, MAX_FRAMES, ROWS, SHUTTER, SPEED};
pub(crate) use keyed::TIME;
pub(crate) use material::PRIORITY;
pub use material::default_material;
pub(crate) use medium::{COEFFICIENT, FREE_PATH, MEAN_COSINE, TINT, WEIGHT};
pub(crate) use object::SEGMENTS;
pub(crate) use pattern::{KINDS as PATTERNS, MAX_STOPS};
pub(crate) use physics::{
    DURATIONS, FORCES, FREQUENCIES, FRICTIONS, MASSES, MAX_IGNORED, PARTS, RATIOS, SIZES, SPEEDS, STEPS, TIMES,
};
pub use references::check_files;
pub(crate) use settings::MAX_DEPTH;
pub use settings::MAX_SIDE;
pub(crate) use simplify::{FACES, RATIO, SIGMAS};
pub(crate) use sky::{LATITUDES, LONGITUDES, SUN_SIZES, TURBIDITIES, ZONES};
pub use values::{Bounds, rotation, sin_cos_degrees};

use crate::{
    Diagnostic, Diagnostics, FileId, Span,
    animation::Varying,
    description::{
        CameraRecord, EnvironmentRecord, Located, MaterialRecord, MediumRecord, MeshRecord, SceneDescription,
    },
    value::{Data, Entry},
};
use etendue::scene::DeltaLight;
use fields::{Context, Fields, Item};
pub use keyed::Part;
use std::path::Path;

/// Media, materials, meshes, objects and lights that a scene file may have, of each.
pub const MAX_RECORDS: usize = 1 << 20;

/// Reads the text of a scene file. `folder` is where its relative file names start. No other file is touched.
/// A description comes back only if there are no errors.
pub fn read_toml(file: FileId, bytes: &[u8], folder: &Path) -> (Option<SceneDescription>, Diagnostics) {
    let (description, diagnostics) = read_any(file, bytes, folder);
    (Some(description).filter(|_| !diagnostics.has_errors()), diagnostics)
}

/// Reads the text of a scene file; with errors, the description has something in the place of what could not be read.
fn read_any(file: FileId, bytes: &[u8], folder: &Path) -> (SceneDescription, Diagnostics) {
    let mut diagnostics = Diagnostics::new();
    let (entries, damaged) = toml_syntax::read(file, bytes, &mut diagnostics);
    let cx = Context::new(diagnostics, damaged);
    let description = scene(&cx, &entries, file, folder);
    references::check(&cx, &description);
    physics::check(&cx, &description);
    let mut diagnostics = cx.diagnostics.into_inner();
    diagnostics.sort();
    (description, diagnostics)
}

fn scene(cx: &Context, entries: &[Entry], file: FileId, folder: &Path) -> SceneDescription {
    // What the file lacks as a whole is said at its start.
    let origin = Span::new(file, 0..0).into();
    let fields = Fields::new(cx, &keys::FILE, entries, &origin);
    // First, since materials name them.
    fields.read("textures", texture::textures);
    let animation = animation::animation(&fields);
    cx.time.set(animation.start);
    let description = SceneDescription {
        folder: folder.to_owned(),
        camera: camera(&fields).unwrap_or_else(|| settings::any_camera(&origin)),
        film: settings::film(&fields),
        sampler: settings::sampler(&fields),
        integrator: settings::integrator(&fields),
        accelerator: settings::accelerator(&fields),
        environment: environment(&fields),
        media: fields.read("media", media).unwrap_or_default(),
        world_medium: medium::world(&fields),
        materials: materials(&fields).unwrap_or_default(),
        meshes: fields.read("meshes", meshes).unwrap_or_default(),
        objects: fields.read("objects", |item| records(item, "objects", object::object)).unwrap_or_default(),
        lights: lights(&fields).unwrap_or_default(),
        animation,
        varying: Varying::default(),
        physics: fields.read("physics", physics::physics).unwrap_or_default(),
        joints: fields.read("joints", |item| records(item, "joints", physics::joint)).unwrap_or_default(),
    };
    fields.finish();
    SceneDescription { varying: again::varying(cx, entries, &origin), ..description }
}

fn camera(file: &Fields) -> Option<CameraRecord> {
    file.cx().in_part(Part::Camera, || file.need("camera", settings::camera))
}

fn environment(file: &Fields) -> Option<EnvironmentRecord> {
    file.cx().in_part(Part::Environment, || light::environment(file))
}

fn lights(file: &Fields) -> Option<Vec<Located<DeltaLight>>> {
    let read = |item| records(item, "lights", light::light);
    file.cx().in_part(Part::Lights, || file.read("lights", read))
}

/// The named tables of `[materials]`, `[meshes]` or `[textures]`.
fn named<'a>(item: Item<'a>, kind: &str) -> Option<impl Iterator<Item = (&'a Entry, Item<'a>)>> {
    let Data::Table(entries) = &item.value.data else {
        return item.wrong_kind_help("a table of tables", &format!("[{kind}.NAME]"));
    };
    if entries.len() > MAX_RECORDS {
        return item.error(format!("more than {MAX_RECORDS} {kind}"), "too many");
    }
    Some(entries.iter().map(move |entry| (entry, Item { cx: item.cx, name: &entry.key, value: &entry.value })))
}

fn materials(file: &Fields) -> Option<Vec<MaterialRecord>> {
    let record = |(entry, item): (&Entry, Item)| {
        let (material, interior) = material::material(item, &entry.key);
        MaterialRecord { material, interior, origin: entry.origin.clone() }
    };
    let read = |item: Item| Some(named(item, "materials")?.map(record).collect());
    file.cx().in_part(Part::Materials, || file.read("materials", read))
}

fn media(item: Item) -> Option<Vec<MediumRecord>> {
    Some(named(item, "media")?.map(|(entry, item)| medium::medium(item, entry)).collect())
}

fn meshes(item: Item) -> Option<Vec<MeshRecord>> {
    let record = |(entry, item): (&Entry, Item)| {
        let (source, crease_angle, simplify) = object::mesh_source(item);
        MeshRecord { name: entry.key.clone(), source, crease_angle, simplify, origin: entry.origin.clone() }
    };
    Some(named(item, "meshes")?.map(record).collect())
}

/// The tables of `[[objects]]` or `[[lights]]`.
fn records<'a, T>(item: Item<'a>, kind: &str, read: impl Fn(Item<'a>) -> Option<T>) -> Option<Vec<T>> {
    let items = item.array_help("an array of tables", &format!("[[{kind}]]"))?;
    if items.len() > MAX_RECORDS {
        return item.error(format!("more than {MAX_RECORDS} {kind}"), "too many");
    }
    Some(items.filter_map(read).collect())
}

/// Reads a scene file, and checks that the files it names are there. The folder of relative names is the scene file's.
pub fn read_scene(
    path: &Path,
    sources: &mut crate::SourceMap,
    limits: &crate::Limits,
) -> Result<(Option<SceneDescription>, Diagnostics), ReadError> {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    if ending != "toml" {
        return Err(ReadError::Unsupported { path: path.to_owned() });
    }
    let file = sources.read(path, limits.scene_bytes)?;
    let bytes = sources.bytes(file);
    let (description, mut diagnostics) = read_any(file, &bytes, path.parent().unwrap_or(Path::new("")));
    diagnostics.append(check_files(&description));
    diagnostics.sort();
    Ok((Some(description).filter(|_| !diagnostics.has_errors()), diagnostics))
}

/// A scene that cannot even be looked into.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file cannot be read.
    #[error(transparent)]
    Source(#[from] crate::SourceError),
    /// A format that is not read.
    #[error("{}", unsupported(path))]
    Unsupported {
        /// The file.
        path: std::path::PathBuf,
    },
}

fn unsupported(path: &Path) -> String {
    let path_shown = path.display();
    match crate::not_read_yet(path) {
        Some(kind) => format!("{path_shown}: {kind} files are not read yet; scenes are read from .toml files"),
        None => format!("cannot read {path_shown} as a scene: scenes are read from .toml files"),
    }
}

/// An error with its place, for [`references`].
fn error_at(message: String, origin: &crate::Origin) -> Diagnostic {
    Diagnostic::error(message).at(origin.clone())
}
