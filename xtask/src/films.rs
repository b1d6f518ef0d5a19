//! The tests of `etendue-video` that decode by FFmpeg.

use crate::{
    cargo, root,
    test::{Counts, succeeds},
    venv,
};
use std::{ffi::OsString, process::Command};

/// Carries FFmpeg as a program, for the usual systems and processors.
const PACKAGE: &str = "imageio-ffmpeg==0.8.1";

/// Lints and runs them.
pub fn test(counts: &mut Counts) -> bool {
    let ffmpeg = match ffmpeg() {
        Ok(program) => program,
        Err(e) => {
            eprintln!("{e}");
            return false;
        }
    };
    let package = ["-p", "etendue-video", "--features", "ffmpeg"];
    let lints = [&["clippy", "--locked"], &package[..], &["--all-targets", "--", "-D", "warnings"]].concat();
    let tests = [&["test", "--locked"], &package[..], &["--test", "ffmpeg"]].concat();
    succeeds(&mut cargo(&lints)) && counts.run(cargo(&tests).env("ETENDUE_FFMPEG", ffmpeg))
}

/// The program: the one that `ETENDUE_FFMPEG` names, or one from PyPI.
fn ffmpeg() -> Result<OsString, String> {
    if let Some(program) = std::env::var_os("ETENDUE_FFMPEG") {
        return Ok(program);
    }
    let home = root().join("target/ffmpeg");
    venv::install(&home, &["3", "3.13", "3.12", "3.11"], &[PACKAGE])?;
    let tell = "import imageio_ffmpeg; print(imageio_ffmpeg.get_ffmpeg_exe())";
    let output = Command::new(venv::python_of(&home)).args(["-c", tell]).output().map_err(|e| e.to_string())?;
    let path = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    if output.status.success() && !path.is_empty() {
        Ok(path.into())
    } else {
        Err(format!("no FFmpeg in {}: {}", home.display(), String::from_utf8_lossy(&output.stderr)))
    }
}
