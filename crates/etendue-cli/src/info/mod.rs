//! `etendue info`: what is in a file.

mod image;
mod mesh;
mod records;
mod scene;
mod text;
mod volume;

use crate::{
    args::InfoArgs,
    exit::{Exit, Failure},
    model, report,
};
use etendue_scene::{mesh_file::unknown_kind, not_read_yet, script::is_script};
use serde::Serialize;

/// Tells of the file, as the arguments say.
pub fn run(args: &InfoArgs) -> Result<Exit, Failure> {
    let path = &args.file;
    let is_scene = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("toml")) || is_script(path);
    if is_scene {
        return print(&scene::read(path)?, args.json);
    }
    if model::is_model(path) {
        return print(&mesh::read(path)?, args.json);
    }
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("npy")) {
        return print(&volume::read(path)?, args.json);
    }
    if not_read_yet(path).is_some() {
        let error = unknown_kind(path);
        return Err(Failure::new(Exit::Unsupported, error.message).hint(error.help.unwrap_or_default()));
    }
    print(&image::read(path)?, args.json)
}

/// What is told of one kind of file.
trait Told: Serialize {
    /// For people.
    fn text(&self) -> String;
}

fn print(told: &impl Told, json: bool) -> Result<Exit, Failure> {
    let text = if json { serde_json::to_string(told).unwrap_or_default() } else { told.text() };
    report::result(text.trim_end())?;
    Ok(Exit::Done)
}
