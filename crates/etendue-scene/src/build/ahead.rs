//! Small mesh files and images of a scene, several at once.
//!
//! Large mesh files keep all processors busy by themselves, and are read one after the other. Of the small ones each takes one: they are
//! read and made meshes of side by side, before objects are placed, and wait for the object that names them. Whatever goes wrong is
//! left to that object, which reads the file again and reports it in its turn, so messages come in the order of the scene.

use crate::{
    Limits, SourceMap,
    description::{MeshRecord, MeshSource, SceneDescription, ShapeRecord},
    image_file::{self, decode_texture},
    mesh_file::{self, MeshFile},
    parallel,
    source::read_bytes,
};
use etendue::texture::TextureImage;
use std::{
    collections::{BTreeMap, BTreeSet},
    path::PathBuf,
    sync::Arc,
};

/// A file of more bytes is not small.
const SMALL: u64 = 8 << 20;

/// Bytes of all mesh files, and of all images, that are read ahead.
const MOST: u64 = 256 << 20;

/// An image file of more bytes is not small, and one that makes more is left for later: each thread decodes one at a time.
const SMALL_IMAGE: u64 = 32 << 20;
const SMALL_DECODED: u64 = 256 << 20;

/// The paths of mesh files that objects name, in their order, each once. Those that are to be simplified are left out: their
/// whole meshes would wait in memory.
fn named(description: &SceneDescription) -> Vec<PathBuf> {
    let meshes: BTreeMap<&str, &MeshRecord> =
        description.meshes.iter().map(|mesh| (mesh.name.as_str(), mesh)).collect();
    let path_of = |shape| match shape {
        &ShapeRecord::File { ref path, simplify: None, .. } => Some(path),
        ShapeRecord::Mesh(name) => match meshes.get(name.value.as_str())? {
            MeshRecord { source: MeshSource::File(path), simplify: None, .. } => Some(path),
            _ => None,
        },
        _ => None,
    };
    let mut seen = BTreeSet::new();
    let paths = description.objects.iter().filter_map(|object| path_of(&object.shape));
    paths.map(|path| description.folder.join(&path.value)).filter(|path| seen.insert(path.clone())).collect()
}

/// Runs `work` for each of so many numbers on all processors; what came of each, in order.
fn each<T: Send>(count: usize, work: impl Fn(usize) -> Option<T> + Sync) -> Vec<Option<T>> {
    let keep = |all: &mut Vec<(usize, Option<T>)>, i| -> Result<(), std::convert::Infallible> {
        all.push((i, work(i)));
        Ok(())
    };
    let Ok(all) = parallel::run(parallel::threads(count), 0..count, Vec::new, keep);
    let mut results: Vec<Option<T>> = (0..count).map(|_| None).collect();
    all.into_iter().flatten().for_each(|(i, result)| results[i] = result);
    results
}

/// Keeps those files that have bytes, at most so many each and [`MOST`] together.
fn keep_small(paths: &mut Vec<PathBuf>, most: u64) {
    let mut left = MOST;
    paths.retain(|path| {
        let length = std::fs::metadata(path).ok().filter(|m| m.is_file()).map_or(0, |m| m.len());
        let fits = (1..=most.min(left)).contains(&length);
        left -= if fits { length } else { 0 };
        fits
    });
}

/// An image file that was read ahead.
#[derive(Debug)]
pub struct Decoded {
    /// The file.
    pub bytes: Vec<u8>,
    /// What is in it.
    pub image: Arc<TextureImage>,
}

/// Reads small image files, by path. Those that are large, or cannot be read, are left out.
pub fn decode_ahead(mut paths: Vec<PathBuf>, limits: &image_file::Limits) -> BTreeMap<PathBuf, Decoded> {
    keep_small(&mut paths, limits.file.min(SMALL_IMAGE));
    let limits = image_file::Limits { decoded: limits.decoded.min(SMALL_DECODED), ..*limits };
    if parallel::threads(paths.len()) < 2 {
        return BTreeMap::new();
    }
    let decoded = each(paths.len(), |i| {
        let bytes = read_bytes(&paths[i], limits.file).ok()?;
        let image = decode_texture(&paths[i], &bytes, &limits).ok()?.into_texture().ok()?;
        Some(Decoded { bytes, image: Arc::new(image) })
    });
    paths.into_iter().zip(decoded).filter_map(|(path, decoded)| Some((path, decoded?))).collect()
}

/// Adds the small mesh files of a description to `sources` and reads them; by path. Those in `loaded` are there already.
pub fn read_ahead(
    description: &SceneDescription,
    sources: &mut SourceMap,
    limits: &Limits,
    loaded: &BTreeMap<PathBuf, MeshFile>,
) -> BTreeMap<PathBuf, MeshFile> {
    let mut paths = named(description);
    let most = SMALL.min(limits.file_bytes);
    paths.retain(|path| !loaded.contains_key(path) && sources.find(path).is_none());
    keep_small(&mut paths, most);
    // On one processor too: the order of files is part of the scene's hash.
    if paths.len() < 2 {
        return BTreeMap::new();
    }
    let bytes = each(paths.len(), |i| {
        let bytes = read_bytes(&paths[i], most).ok()?;
        mesh_file::may_be_alone(&paths[i], &bytes).then_some(bytes)
    });
    let mut files = Vec::with_capacity(paths.len());
    for (path, bytes) in paths.into_iter().zip(bytes) {
        if let Some(bytes) = bytes
            && let Ok(file) = sources.insert(&path, bytes)
        {
            files.push((path, file, sources.bytes(file)));
        }
    }
    let meshes = each(files.len(), |i| {
        let (path, file, bytes) = &files[i];
        sources.digest(*file);
        mesh_file::read_alone(path, bytes.clone(), *file)
    });
    files.into_iter().zip(meshes).filter_map(|((path, ..), mesh)| Some((path, mesh?))).collect()
}
