//! Scripts of the older renderer that the paper describes: `render.cfg`, with its dialect of OBJ and MTL.
//!
//! A script becomes the text of a scene file, which is read as any other: what is rendered is what `etendue scene` writes.
//! Places in messages are those of the script. docs/old-scripts.md tells every key.

mod camera;
mod grammar;
mod materials;
mod notes;
mod search;
mod text;

pub use camera::{ScriptCamera, ScriptLens};
pub use grammar::{KEYS, PixelSampler, Script, ScriptObject, parse};
pub use text::{SceneText, scene_text};

use crate::{
    Diagnostic, Diagnostics, FileId, Limits, Origin, SourceError, SourceMap, Span,
    description::{Lens, Located, SceneDescription, ShapeRecord, Step},
    mesh_file::{self, MeshFile, MeshFormat, MeshLimits, unknown_kind},
    not_read_yet, read_toml,
};
use etendue::texture::Pattern;
use materials::Materials;
use search::Search;
use std::{
    collections::BTreeMap,
    f64::consts::PI,
    fs::File,
    io::Read,
    path::{Path, PathBuf},
};

/// Exponent of brushed metal that is as wide as the old program's. That drew slopes 2 s / sqrt(1 - s^2) with s = |x|^1.7, x even in [0, 1];
/// of the normals that reflect light from above upwards, half lie within 15.5 degrees of the surface's, as with cos^5.
const BRUSHED_EXPONENT: f32 = 5.0;

/// Radius of a round lens with the area of a square one.
fn lens_radius(side: f64) -> f64 {
    side / PI.sqrt()
}

/// A script whose files have been found and read.
#[derive(Debug)]
pub struct ScriptScene {
    path: PathBuf,
    script: Script,
    camera: Located<ScriptCamera>,
    objects: Vec<Placed>,
    materials: Materials,
    /// By the path of a mesh file: names of its materials, and of those of the scene that stand in their places.
    replaced: BTreeMap<PathBuf, Vec<[String; 2]>>,
    meshes: BTreeMap<PathBuf, MeshFile>,
}

/// An object whose file has been found.
#[derive(Debug)]
struct Placed {
    path: PathBuf,
    file: Located<String>,
    transform: Vec<Located<Step>>,
}

/// Bytes at the start of a file by which a script is known.
const SNIFFED: u64 = 16 << 10;

/// Whether an input is a script: by its ending `.cfg`, or where that is of nothing known (`render.cfg.old`) by its content.
pub fn is_script(path: &Path) -> bool {
    let ending = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    if ending == "cfg" {
        return true;
    }
    if ending == "toml" || MeshFormat::of_path(path).is_some() || not_read_yet(path).is_some() || !path.is_file() {
        return false;
    }
    let mut start = Vec::new();
    let read = File::open(path).and_then(|file| file.take(SNIFFED).read_to_end(&mut start));
    read.is_ok() && looks_like_script(&start)
}

/// Two lines or more that begin with a key of scripts, and no fewer than others.
fn looks_like_script(start: &[u8]) -> bool {
    if start.contains(&0) {
        return false;
    }
    let words = start.split(|&byte| byte == b'\n' || byte == b'\r').filter_map(|line| {
        line.split(u8::is_ascii_whitespace).find(|word| !word.is_empty()).filter(|word| !word.starts_with(b"#"))
    });
    let (keys, others): (Vec<_>, Vec<_>) = words.partition(|word| grammar::is_key(word));
    keys.len() >= 2 && keys.len() >= others.len()
}

/// Reads a script and the mesh files that it names. The scene comes back only if there are no errors.
///
/// # Errors
/// The script itself cannot be read.
pub fn read_script(
    path: &Path,
    sources: &mut SourceMap,
    limits: &Limits,
) -> Result<(Option<ScriptScene>, Diagnostics), SourceError> {
    let file = sources.read(path, limits.scene_bytes)?;
    let mut found = Diagnostics::new();
    let script = parse(&sources.bytes(file), file, &mut found);
    let mut reader = Reader { search: Search::new(path), sources, limits, found };
    let scene = reader.scene(path, file, script);
    let Reader { mut found, .. } = reader;
    let scene = scene.filter(|_| !found.has_errors());
    if let Some(scene) = &scene {
        notes::tell(scene, &mut found);
    }
    found.sort();
    Ok((scene, found))
}

struct Reader<'a> {
    search: Search,
    sources: &'a mut SourceMap,
    limits: &'a Limits,
    found: Diagnostics,
}

impl Reader<'_> {
    fn scene(&mut self, path: &Path, file: FileId, script: Script) -> Option<ScriptScene> {
        let start = || Origin::from(Span::new(file, 0..0));
        let mut objects = Vec::new();
        for object in &script.objects {
            self.place(object, &mut objects);
        }
        if script.objects.is_empty() {
            match &script.from_raw {
                Some(origin) => {
                    let error = Diagnostic::unsupported("`fromRaw` shows a stored picture, which is not read");
                    self.found.push(error.at(origin.clone()).help("the script has no objects that could be rendered"));
                }
                None => self.found.push(Diagnostic::error("the script has no `object`").at(start())),
            }
        }
        let mut scene_parts = (Materials::default(), BTreeMap::new(), BTreeMap::new());
        let (materials, replaced, meshes) = &mut scene_parts;
        for (number, object) in objects.iter().enumerate() {
            let known = self.sources.ids().count();
            if !meshes.contains_key(&object.path) {
                let Some(mut mesh) = self.mesh(object) else { continue };
                let stated = materials.add(&mut mesh, &self.search, self.sources, &mut self.found);
                replaced.insert(object.path.clone(), stated);
                meshes.insert(object.path.clone(), mesh);
            }
            if number == 0 {
                materials.look_for_medium(self.sources.ids().skip(known), self.sources);
            }
        }
        let Some(camera) = script.camera.clone() else {
            // A camera that could not be read has been reported.
            if !self.found.has_errors() {
                self.found.push(Diagnostic::error("the script has no `camera`").at(start()));
            }
            return None;
        };
        let (materials, replaced, meshes) = scene_parts;
        Some(ScriptScene { path: path.to_owned(), script, camera, objects, materials, replaced, meshes })
    }

    /// Finds the file of an object, or those of a list.
    fn place(&mut self, object: &ScriptObject, objects: &mut Vec<Placed>) {
        let path = match self.search.need(&object.file) {
            Ok(path) => path,
            Err(error) => return self.found.push(error),
        };
        if !object.is_list {
            let (file, transform) = (object.file.clone(), object.transform.clone());
            return objects.push(Placed { path, file, transform });
        }
        let list = match self.sources.read(&path, self.limits.scene_bytes) {
            Ok(list) => list,
            Err(error) => return self.found.push(Diagnostic::error(error.to_string()).at(object.file.origin.clone())),
        };
        let listed = parse(&self.sources.bytes(list), list, &mut self.found);
        for inner in &listed.objects {
            if inner.is_list {
                let error = Diagnostic::error("a list of objects inside of a list").at(inner.file.origin.clone());
                self.found.push(error.help("list the objects themselves"));
            } else {
                self.place(inner, objects);
            }
        }
        if let Some(last) = objects.last_mut() {
            last.transform.extend(object.transform.iter().cloned());
        }
    }

    fn mesh(&mut self, object: &Placed) -> Option<MeshFile> {
        let origin = || object.file.origin.clone();
        if MeshFormat::of_path(&object.path).is_none() {
            self.found.push(unknown_kind(&object.path).at(origin()));
            return None;
        }
        let limits = MeshLimits { file: self.limits.file_bytes, library: self.limits.library_bytes };
        let file = match mesh_file::open(self.sources, &object.path, &limits) {
            Ok(file) => file,
            Err(error) => {
                self.found.push(Diagnostic::error(error.to_string()).at(origin()));
                return None;
            }
        };
        match mesh_file::read(self.sources, file, &limits) {
            Ok(mesh) => Some(mesh),
            Err(found) => {
                self.found.append(found);
                None
            }
        }
    }
}

impl ScriptScene {
    /// Width and height of the picture, pixels.
    pub fn size(&self) -> [u32; 2] {
        let pixels = || self.camera.value.pixels().map(|side| libm::round(side).clamp(1.0, 65_536.0) as u32);
        self.script.size.as_ref().map_or_else(pixels, |size| size.value)
    }

    /// The description of the scene, with places in the script, and the mesh files that were read for it, by their paths.
    /// Its files are named as the script's path was: relative to the working directory if that was.
    ///
    /// # Errors
    /// What the reader of scene files refuses.
    pub fn describe(
        self,
        sources: &mut SourceMap,
    ) -> Result<(SceneDescription, BTreeMap<PathBuf, MeshFile>, Diagnostics), Diagnostics> {
        let written = scene_text(&self, &mut |path| Ok::<_, std::convert::Infallible>(path.to_owned()));
        let written = written.unwrap_or_else(|never| match never {});
        let bytes = written.text.clone().into_bytes();
        let name = format!("scene of {}", self.path.display());
        let file = sources.insert(name, bytes.clone()).map_err(|error| {
            let mut found = Diagnostics::new();
            found.push(Diagnostic::error(error.to_string()));
            found
        })?;
        let (description, read) = read_toml(file, &bytes, Path::new(""));
        let place = |origin: &mut Origin| {
            let span = origin.span().filter(|span| span.file == file);
            if let Some(known) = span.and_then(|span| written.origin(span.start)) {
                *origin = known.clone();
            }
        };
        let mut found = Diagnostics::new();
        found.extend(read.iter().cloned().map(|mut finding| {
            finding.origin.iter_mut().for_each(place);
            finding
        }));
        let Some(mut description) = description else { return Err(found) };
        replace_origins(&mut description, &place);
        Ok((description, self.meshes, found))
    }
}

/// Lets `place` change every origin of what a script's scene may hold.
fn replace_origins(description: &mut SceneDescription, place: &dyn Fn(&mut Origin)) {
    place(&mut description.camera.origin);
    if let Lens::Perspective { focus: crate::description::Focus::Point(point), .. } = &mut description.camera.lens {
        place(&mut point.origin);
    }
    description.world_medium.iter_mut().for_each(|name| place(&mut name.origin));
    description.media.iter_mut().for_each(|record| place(&mut record.origin));
    for record in &mut description.materials {
        place(&mut record.origin);
        record.material = record.material.map_textures(&mut |texture, _| {
            let mut texture = texture.clone();
            if let Pattern::Image(image) = &mut std::sync::Arc::make_mut(&mut texture).pattern {
                place(&mut image.file.origin);
            }
            Some(texture)
        });
    }
    for object in &mut description.objects {
        place(&mut object.origin);
        object.name.iter_mut().for_each(|name| place(&mut name.origin));
        object.materials.iter_mut().flatten().for_each(|name| place(&mut name.origin));
        object.transform.iter_mut().for_each(|step| place(&mut step.origin));
        if let ShapeRecord::File { path, .. } = &mut object.shape {
            place(&mut path.origin);
        }
    }
}
