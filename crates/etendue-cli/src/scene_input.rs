//! Scene files, and scripts of the older renderer, which become scene files.

use crate::{
    exit::{Exit, Failure},
    model, report,
};
use etendue_scene::{
    Diagnostics, Limits, ReadError, SourceMap,
    description::SceneDescription,
    mesh_file::MeshFile,
    output::atomic,
    read_scene,
    script::{ScriptScene, is_script, read_script, scene_text},
};
use std::{
    collections::BTreeMap,
    io::Write,
    path::{Path, PathBuf},
};

/// A scene before it is built.
pub struct SceneInput {
    /// What it says.
    pub description: SceneDescription,
    /// Mesh files that have been read for it, by their paths.
    pub meshes: BTreeMap<PathBuf, MeshFile>,
    /// Warnings and notes.
    pub found: Diagnostics,
}

/// Reads a scene file or a script; errors are reported.
pub fn read(path: &Path, sources: &mut SourceMap, limits: &Limits) -> Result<SceneInput, Failure> {
    if is_script(path) {
        let (scene, mut found) = script(path, sources, limits)?;
        let (description, meshes, more) = scene.describe(sources).map_err(|found| refused(&found, sources))?;
        found.append(more);
        return Ok(SceneInput { description, meshes, found });
    }
    let (description, found) = read_scene(path, sources, limits).map_err(read_failure)?;
    let description = description.ok_or_else(|| refused(&found, sources))?;
    Ok(SceneInput { description, meshes: BTreeMap::new(), found })
}

fn script(path: &Path, sources: &mut SourceMap, limits: &Limits) -> Result<(ScriptScene, Diagnostics), Failure> {
    let (scene, found) = read_script(path, sources, limits)?;
    let scene = scene.ok_or_else(|| refused(&found, sources))?;
    Ok((scene, found))
}

fn refused(found: &Diagnostics, sources: &SourceMap) -> Failure {
    report::diagnostics(found, sources);
    Failure::reported(Exit::of(found))
}

/// Writes the scene file of a script, to standard output without `output`, and tells what was found.
pub fn write_script_scene(path: &Path, output: Option<&Path>) -> Result<Exit, Failure> {
    if let Some(path) = output {
        atomic::check_writable(path)?;
    }
    let mut sources = SourceMap::new();
    let (scene, found) = script(path, &mut sources, &Limits::default())?;
    let folder = output.map(|path| path.parent().unwrap_or(Path::new("")));
    let written = scene_text(&scene, &mut |file| {
        if file.to_str().is_none() {
            let message = format!("the file name {file:?} is not UTF-8, and a scene file cannot name it");
            return Err(Failure::new(Exit::BadInput, message).hint("rename the file"));
        }
        folder.map_or(Ok(file.to_owned()), |folder| model::relative(file, folder))
    })?;
    report::diagnostics(&found, &sources);
    match output {
        None => report::result(written.text.trim_end())?,
        Some(path) => {
            atomic::write(path, |file| Ok(file.write_all(written.text.as_bytes())?))?;
            report::say(format!("{}: render it with etendue render {0}", path.display()));
        }
    }
    Ok(Exit::Done)
}

/// Why a scene file cannot even be looked into.
fn read_failure(error: ReadError) -> Failure {
    match error {
        ReadError::Unsupported { .. } => Failure::new(Exit::Unsupported, error).hint(
            "scenes are read from .toml files and .cfg scripts, models from .obj, .ply, .stl and .off files, also .gz",
        ),
        ReadError::Source(error) => error.into(),
    }
}
