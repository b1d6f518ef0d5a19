//! Small mesh files of a scene, several at once.
//!
//! Large files keep all processors busy by themselves, and are read one after the other. Of the small ones each takes one: they are
//! read and made meshes of side by side, before objects are placed, and wait for the object that names them. Whatever goes wrong is
//! left to that object, which reads the file again and reports it in its turn, so messages come in the order of the scene.

use crate::{
    Limits, SourceMap,
    description::{MeshRecord, MeshSource, SceneDescription, ShapeRecord},
    mesh_file::{self, MeshFile},
    parallel,
    source::read_bytes,
};
use std::{
    collections::{BTreeMap, BTreeSet},
    path::{Path, PathBuf},
};

/// A file of more bytes is not small.
const SMALL: u64 = 8 << 20;

/// Bytes of all that are read ahead.
const MOST: u64 = 256 << 20;

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

/// Adds the small mesh files of a description to `sources` and reads them; by path. Those in `loaded` are there already.
pub fn read_ahead(
    description: &SceneDescription,
    sources: &mut SourceMap,
    limits: &Limits,
    loaded: &BTreeMap<PathBuf, MeshFile>,
) -> BTreeMap<PathBuf, MeshFile> {
    let mut paths = named(description);
    let most = SMALL.min(limits.file_bytes);
    let mut left = MOST;
    paths.retain(|path| {
        let is_new = !loaded.contains_key(path) && sources.find(path).is_none();
        let length = |path: &Path| std::fs::metadata(path).ok().filter(|m| m.is_file()).map(|m| m.len());
        let fits = is_new && length(path).is_some_and(|length| length <= most.min(left) && length > 0);
        left -= if fits { length(path).unwrap_or(0).min(left) } else { 0 };
        fits
    });
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
        mesh_file::read_alone(path, bytes.clone(), *file)
    });
    files.into_iter().zip(meshes).filter_map(|((path, ..), mesh)| Some((path, mesh?))).collect()
}
