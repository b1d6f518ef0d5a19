//! Models without a scene file: `etendue scene`, and what `etendue render` makes of one.

use crate::{
    args::{ModelArgs, RenderArgs, SceneArgs},
    exit::{Exit, Failure},
    report, scene_input,
};
use etendue_scene::{
    Limits, SourceMap,
    image_file::{self, read_image},
    mesh_file::{self, MeshFile, MeshFormat, MeshLimits, unknown_kind},
    model_scene::{self, ModelEnvironment, ModelOptions, ModelSurface, model_scene},
    output::atomic,
    read::MAX_SIDE,
    script::is_script,
};
use std::{
    io::Write,
    path::{self, Component, Path, PathBuf},
};

/// What shows a model, wherever the scene file is.
#[derive(Clone, Copy)]
pub struct Look<'a> {
    model: &'a Path,
    args: &'a ModelArgs,
    size: Option<[u32; 2]>,
    transparent: bool,
}

impl<'a> From<&'a RenderArgs> for Look<'a> {
    fn from(args: &'a RenderArgs) -> Self {
        Self { model: &args.input, args: &args.look, size: args.size, transparent: args.transparent }
    }
}

impl<'a> From<&'a SceneArgs> for Look<'a> {
    fn from(args: &'a SceneArgs) -> Self {
        Self { model: &args.model, args: &args.look, size: args.size, transparent: args.transparent }
    }
}

/// Whether an input is a model, not a scene file.
pub fn is_model(input: &Path) -> bool {
    MeshFormat::of_path(input).is_some()
}

/// Reads a mesh file; errors are reported.
pub fn read(model: &Path, sources: &mut SourceMap, limits: &Limits) -> Result<MeshFile, Failure> {
    let limits = MeshLimits { file: limits.file_bytes, library: limits.library_bytes };
    let file = mesh_file::open(sources, model, &limits)?;
    mesh_file::read(sources, file, &limits).map_err(|found| {
        report::diagnostics(&found, sources);
        Failure::reported(Exit::of(&found))
    })
}

/// The text of the automatic scene, for a scene file in `folder`; absent: the working directory, whatever its name.
pub fn scene_text(look: Look<'_>, mesh: &MeshFile, folder: Option<&Path>) -> Result<String, Failure> {
    let name = |path: &Path| match folder {
        None => Ok(path.to_owned()),
        Some(folder) => relative(path, folder),
    };
    let Look { args, .. } = look;
    let environment = match &args.env {
        None => None,
        Some(path) => Some(ModelEnvironment { file: name(path)?, brightness: brightness(path)? }),
    };
    let surface = match &args.material {
        Some(ModelSurface::Picture(path)) => Some(ModelSurface::Picture(name(path)?)),
        other => other.clone(),
    };
    let options = ModelOptions {
        file: name(look.model)?,
        environment,
        up: args.up.unwrap_or_default(),
        ground: !args.no_ground,
        transparent: look.transparent,
        view: args.view,
        surface,
        size: look.size.map(fitting),
    };
    let path = look.model.display();
    model_scene(mesh, &options).map_err(|e| {
        let hint = format!("etendue info {path} tells what is in it");
        Failure::new(Exit::BadInput, format!("{path}: {e}")).hint(hint)
    })
}

/// A size that a scene file may have, of the same shape: what is rendered is the size that was asked for.
fn fitting(size: [u32; 2]) -> [u32; 2] {
    let shrink = size[0].max(size[1]).div_ceil(MAX_SIDE);
    size.map(|side| (side / shrink).max(1))
}

/// `etendue scene`: writes the automatic scene.
pub fn run(args: &SceneArgs) -> Result<Exit, Failure> {
    let model = &args.model;
    if is_script(model) {
        return script_scene(args);
    }
    if !is_model(model) {
        let error = unknown_kind(model);
        let hint = error.help.unwrap_or_default();
        let exit = if error.is_unsupported { Exit::Unsupported } else { Exit::BadInput };
        return Err(Failure::new(exit, error.message).hint(hint));
    }
    if let Some([width, height]) = args.size.filter(|size| fitting(*size) != *size) {
        let message = format!("a scene file cannot ask for {width} x {height} pixels");
        return Err(Failure::new(Exit::Usage, message).hint(format!("both sides may be up to {MAX_SIDE}")));
    }
    if let Some(path) = &args.output {
        check_ending(path)?;
        atomic::check_writable(path)?;
    }
    let mut sources = SourceMap::new();
    let mesh = read(model, &mut sources, &Limits::default())?;
    let folder = args.output.as_deref().map(|path| path.parent().unwrap_or(Path::new("")));
    let text = scene_text(args.into(), &mesh, folder)?;
    match &args.output {
        None => report::result(text.trim_end())?,
        Some(path) => {
            atomic::write(path, |file| Ok(file.write_all(text.as_bytes())?))?;
            report::say(format!("{}: render it with etendue render {0}", path.display()));
        }
    }
    Ok(Exit::Done)
}

/// The scene file of a script, which says itself how it is shown.
fn script_scene(args: &SceneArgs) -> Result<Exit, Failure> {
    let size = args.size.map(|_| "--size");
    let given = args.look.first_given().or(size).or(args.transparent.then_some("--transparent"));
    if let Some(option) = given {
        let message = format!("{option} is for models, but {} is a script", args.model.display());
        return Err(Failure::new(Exit::Usage, message).hint("edit the scene file that is written"));
    }
    args.output.as_deref().map_or(Ok(()), check_ending)?;
    scene_input::write_script_scene(&args.model, args.output.as_deref())
}

/// Refuses names of scene files that would not be read back.
pub fn check_ending(path: &Path) -> Result<(), Failure> {
    if path.extension().is_some_and(|e| e.eq_ignore_ascii_case("toml")) {
        return Ok(());
    }
    let message = format!("`{}`: a scene file ends in .toml", path.display());
    Err(Failure::new(Exit::Usage, message).hint("give a name such as scene.toml"))
}

/// The name of a file as seen from a folder.
pub fn relative(path: &Path, folder: &Path) -> Result<PathBuf, Failure> {
    let cannot = |e| Failure::new(Exit::BadInput, format!("cannot tell where {} is: {e}", path.display()));
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    // Links in the folders count as where they lead to; the file keeps its name.
    let parent = path.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let parent = parent.canonicalize().or_else(|_| path::absolute(parent)).map_err(cannot)?;
    let folder = folder.canonicalize().or_else(|_| path::absolute(folder)).map_err(cannot)?;
    let full = parent.join(path.file_name().unwrap_or_default());
    Ok(between(&folder, &full))
}

/// The way from an absolute folder to an absolute file.
fn between(folder: &Path, file: &Path) -> PathBuf {
    let (from, to): (Vec<Component>, Vec<Component>) = (folder.components().collect(), file.components().collect());
    let common = from.iter().zip(&to).take_while(|(a, b)| a == b).count();
    if common == 0 {
        // Another drive.
        return file.to_owned();
    }
    let up = from[common..].iter().map(|_| Component::ParentDir);
    up.chain(to[common..].iter().copied()).collect()
}

/// How bright an equirectangular picture is.
fn brightness(path: &Path) -> Result<f64, Failure> {
    let image = read_image(path, &image_file::Limits::default())?;
    model_scene::brightness(&image).ok_or_else(|| {
        let message = format!("{} has no colour to light a model with", path.display());
        Failure::new(Exit::BadInput, message).hint("--env takes an equirectangular picture of the surroundings")
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_between_folders() {
        for (folder, file, way) in [
            ("/a/b", "/a/b/c.obj", "c.obj"),
            ("/a/b", "/a/c.obj", "../c.obj"),
            ("/a/b/d", "/a/c/e.obj", "../../c/e.obj"),
            ("/", "/c.obj", "c.obj"),
        ] {
            assert_eq!(between(Path::new(folder), Path::new(file)), Path::new(way));
        }
    }
}
