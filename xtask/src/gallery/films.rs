//! The films of the gallery, and a sheet of frames of each for the documents.

use super::{program::Program, thumbnail};
use crate::{
    disk::{read, write},
    root,
};
use std::{fs, path::Path};

/// A film: the scene's name, and the frames that stand for it in the documents, three in a row.
pub struct Film {
    pub name: &'static str,
    shown: [u32; 6],
}

/// All of them.
pub const FILMS: [Film; 2] = [
    Film { name: "figure-9", shown: [0, 30, 45, 60, 88, 120] },
    Film { name: "bowl", shown: [0, 26, 44, 60, 84, 129] },
];

/// Renders every film to `gallery/out`, its sheet to `docs/images`. Quick ones leave the documents alone.
pub fn make(program: &Program, gallery: &Path, quick: bool) -> Result<(), String> {
    let out = gallery.join("out");
    for film in &FILMS {
        println!("== {}", film.name);
        let scene = gallery.join(format!("{}.toml", film.name));
        program.animate(&scene, &out.join(format!("{}.mp4", film.name)), None, quick)?;
        if quick {
            continue;
        }
        let mut frames = Vec::new();
        for frame in film.shown {
            let pattern = out.join(format!("{}.%04d.png", film.name));
            program.animate(&scene, &pattern, Some(frame), quick)?;
            let file = out.join(format!("{}.{frame:04}.png", film.name));
            frames.push(read(&file)?);
            fs::remove_file(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        }
        let sheet = thumbnail::sheet(&frames, 3).map_err(|e| format!("{}: {e}", film.name))?;
        write(&root().join(format!("docs/images/{}.png", film.name)), &sheet)?;
    }
    Ok(())
}
