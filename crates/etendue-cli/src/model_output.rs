//! Models that the program writes.

use crate::{
    exit::{Exit, Failure},
    model, report,
};
use etendue_scene::{
    SourceMap,
    mesh_file::{MeshFile, unknown_kind},
    mesh_output::{MeshOutputFormat, write_mesh},
    not_read_yet,
};
use std::path::{Path, PathBuf};

/// The format that a name asks for.
pub fn format_of(output: &Path) -> Result<MeshOutputFormat, Failure> {
    MeshOutputFormat::of_path(output).ok_or_else(|| {
        let message = format!("`{}`: the ending names no format that models are written in", output.display());
        Failure::new(Exit::Usage, message).hint("models are written as .obj, .ply and .stl")
    })
}

/// Refuses what is known not to be read yet.
pub fn refuse_unread_kind(input: &Path) -> Result<(), Failure> {
    if not_read_yet(input).is_none() {
        return Ok(());
    }
    let error = unknown_kind(input);
    Err(Failure::new(Exit::Unsupported, error.message).hint(error.help.unwrap_or_default()))
}

/// Refuses what is no model.
pub fn check_is_model(input: &Path) -> Result<(), Failure> {
    refuse_unread_kind(input)?;
    if model::is_model(input) {
        return Ok(());
    }
    let error = unknown_kind(input);
    Err(Failure::new(Exit::BadInput, error.message).hint(error.help.unwrap_or_default()))
}

/// Says what the format cannot hold.
pub fn tell_losses(format: MeshOutputFormat, mesh: &MeshFile) {
    let is_stl = format == MeshOutputFormat::Stl;
    let lost = [
        ("materials", !mesh.materials.is_empty() && !format.keeps_materials()),
        ("spheres", !mesh.spheres.is_empty() && format != MeshOutputFormat::Obj),
        ("normals", mesh.mesh.normals.is_some() && is_stl),
        ("texture coordinates", mesh.mesh.uvs.is_some() && is_stl),
        ("vertex colours", mesh.mesh.colors.is_some() && is_stl),
    ];
    let lost: Vec<&str> = lost.iter().filter(|(_, lost)| *lost).map(|(what, _)| *what).collect();
    if !lost.is_empty() {
        let ending = format.ending();
        report::warning(&format!(".{ending} files hold no {}: they are left out", lost.join(" and no ")));
    }
}

/// Writes a model that came from `input`: whole, or not at all.
pub fn write(
    output: &Path,
    format: MeshOutputFormat,
    mesh: &MeshFile,
    input: &Path,
    sources: &SourceMap,
) -> Result<(), Failure> {
    Ok(write_mesh(output, format, mesh, &texture_folder(input, mesh, sources))?)
}

/// Where relative names of textures start: at the library's place, or the model's.
fn texture_folder(input: &Path, mesh: &MeshFile, sources: &SourceMap) -> PathBuf {
    let library = mesh.materials.iter().find_map(|m| m.origin.as_ref()?.span());
    let file = library.map_or(input, |span| sources.path(span.file));
    file.parent().unwrap_or(Path::new("")).to_owned()
}
