//! The renderer: built for speed, run as anyone would.

use crate::cargo;
use serde_json::Value;
use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// The release program.
pub struct Program(PathBuf);

impl Program {
    /// Builds it.
    pub fn build() -> Result<Self, String> {
        let arguments = [
            "build",
            "--release",
            "--locked",
            "--package",
            "etendue-cli",
            "--message-format",
            "json-render-diagnostics",
        ];
        let output =
            cargo(&arguments).stderr(Stdio::inherit()).output().map_err(|e| format!("cannot run cargo: {e}"))?;
        if !output.status.success() {
            return Err("the program does not build".to_owned());
        }
        let messages = String::from_utf8_lossy(&output.stdout);
        let executable =
            |line: &str| Some(PathBuf::from(serde_json::from_str::<Value>(line).ok()?["executable"].as_str()?));
        messages.lines().filter_map(executable).next_back().map(Self).ok_or_else(|| "cargo names no program".to_owned())
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.0
    }

    /// Renders a scene file to a picture and returns what the program tells of it.
    pub fn render(&self, scene: &Path, picture: &Path, quick: bool) -> Result<Value, String> {
        let mut command = Command::new(&self.0);
        command.arg("render").arg(scene).arg("--output").arg(picture).arg("--json");
        if quick {
            self.make_quick(&mut command, scene)?;
        }
        self.ask(&mut command, scene)
    }

    /// Renders a scene file to a film, or one frame of it to a picture with its number in its name.
    pub fn animate(&self, scene: &Path, output: &Path, frame: Option<u32>, quick: bool) -> Result<(), String> {
        let mut command = Command::new(&self.0);
        command.arg("animate").arg(scene).arg("--output").arg(output);
        if let Some(frame) = frame {
            command.arg("--frames").arg(format!("{frame}-{frame}"));
        }
        if quick {
            self.make_quick(&mut command, scene)?;
        }
        self.done(&mut command, scene).map(drop)
    }

    /// A quarter of the size and a sixteenth of the samples.
    fn make_quick(&self, command: &mut Command, scene: &Path) -> Result<(), String> {
        let info = self.info(scene)?;
        let size = |i: usize| (info["size"][i].as_u64().unwrap_or(4) / 4).max(1);
        let spp = (info["spp"].as_u64().unwrap_or(16) / 16).max(1);
        command.arg("--size").arg(format!("{}x{}", size(0), size(1))).arg("--spp").arg(spp.to_string());
        Ok(())
    }

    /// What the program knows of a file.
    pub fn info(&self, file: &Path) -> Result<Value, String> {
        self.ask(Command::new(&self.0).arg("info").arg(file).arg("--json"), file)
    }

    /// Runs a command that prints one JSON object; its messages go to the terminal.
    fn ask(&self, command: &mut Command, file: &Path) -> Result<Value, String> {
        let printed = self.done(command, file)?;
        serde_json::from_slice(&printed).map_err(|e| format!("{}: the program said: {e}", file.display()))
    }

    /// Runs a command to its end and returns what it printed.
    fn done(&self, command: &mut Command, file: &Path) -> Result<Vec<u8>, String> {
        let output = command.stderr(Stdio::inherit()).output().map_err(|e| format!("{}: {e}", self.0.display()))?;
        match output.status.code() {
            Some(0) => Ok(output.stdout),
            Some(130) | None => Err("stopped".to_owned()),
            Some(code) => Err(format!("{}: the program ended with code {code}", file.display())),
        }
    }
}
