//! Runs the program in a folder of its own.
#![allow(dead_code, reason = "each test program uses its own part")]

use etendue::image::Image;
use etendue_scene::image_file::{Limits, read_image};
use serde_json::Value;
use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Output},
};

/// A small scene: a sphere and a floor under a lamp.
pub const SCENE: &str = r#"
[camera]
position = [0, 1, 5]
look_at = [0, 0, 0]
fov = 40

[film]
size = [16, 12]

[sampler]
spp = 4

[materials.white]
type = "diffuse"
reflectance = 0.7

[materials.lamp]
type = "black"
emission = { radiance = 10 }

[[objects]]
shape = "sphere"
radius = 1
material = "white"

[[objects]]
shape = "rectangle"
corner = [-1, 3, -1]
u = [2, 0, 0]
v = [0, 0, 2]
material = "lamp"
"#;

/// True if tests are to run at full size.
pub fn proves() -> bool {
    std::env::var_os("ETENDUE_PROVE").is_some()
}

/// A heap of bodies, balls and boxes by turns, in layers of `side` by `side`, that falls onto a floor, as a film under a plain sky.
pub fn falling(count: u32, side: u32, size: [u32; 2], spp: u32, frames: u32) -> String {
    let [width, height] = size;
    let half = 0.3 * f64::from(side);
    let high = 0.7 * f64::from(count.div_ceil(side * side));
    let mut scene = format!(
        "[camera]\nposition = [0, {}, {}]\nlook_at = [0, {}, 0]\n[film]\nsize = [{width}, {height}]\n[sampler]\nspp = {spp}\n\
         [environment]\nradiance = 1\n[animation]\nframes = {frames}\nshutter = 0.5\n\
         [[objects]]\nshape = \"box\"\nmin = [-60, -1, -60]\nmax = [60, 0, 60]\nbody = \"fixed\"\n",
        2.0 + high,
        3.0 * half + high,
        0.3 * high,
    );
    for i in 0..count {
        let (x, z) = (f64::from(i % side) * 0.6 - half, f64::from(i / side % side) * 0.6 - half);
        let y = 0.5 + 0.7 * f64::from(i / (side * side));
        let shape = if i % 2 == 0 { "shape = \"sphere\"\nradius = 0.2" } else { "shape = \"box\"\nsize = 0.35" };
        scene += &format!(
            "[[objects]]\n{shape}\ntransform = {{ translate = [{x}, {y}, {z}] }}\n\
             body = {{ restitution = 0.3, angular_velocity = [{}, 90, {}] }}\n",
            i * 37 % 400,
            i * 53 % 300,
        );
    }
    scene
}

/// A folder that is gone after the test, with `scene.toml` in it.
pub struct Folder(tempfile::TempDir);

impl Folder {
    pub fn new() -> Self {
        let folder = Self(tempfile::tempdir().unwrap());
        folder.put("scene.toml", SCENE);
        folder
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub fn put(&self, name: &str, bytes: impl AsRef<[u8]>) {
        fs::write(self.path(name), bytes).unwrap();
    }

    /// The program, in this folder, with words of a command line.
    pub fn command(&self, words: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_etendue"));
        command.current_dir(self.0.path()).args(words.split_whitespace());
        command
    }

    pub fn run(&self, words: &str) -> Ended {
        Ended::from(self.command(words).output().unwrap(), words)
    }

    pub fn image(&self, name: &str) -> Image {
        read_image(&self.path(name), &Limits::default()).unwrap()
    }

    /// Names of the files in it, hidden ones too, but for the scene.
    pub fn files(&self) -> Vec<String> {
        let names = fs::read_dir(self.0.path()).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap());
        let mut names: Vec<String> = names.filter(|n| n != "scene.toml").collect();
        names.sort();
        names
    }
}

/// How a run ended.
#[derive(Debug)]
pub struct Ended {
    pub words: String,
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

impl Ended {
    pub fn from(output: Output, words: &str) -> Self {
        let text = |bytes| String::from_utf8(bytes).unwrap();
        Self {
            words: words.to_owned(),
            code: output.status.code().unwrap_or(-1),
            stdout: text(output.stdout),
            stderr: text(output.stderr),
        }
    }

    /// Ended with this code, without a panic.
    pub fn with_code(self, code: i32) -> Self {
        assert_eq!(self.code, code, "{self:#?}");
        assert!(!self.stderr.contains("panicked"), "{self:#?}");
        self
    }

    /// Standard error holds each of these.
    pub fn saying(self, parts: &[&str]) -> Self {
        for part in parts {
            assert!(self.stderr.contains(part), "no `{part}` in {self:#?}");
        }
        self
    }

    /// Standard output is one JSON object on one line.
    pub fn json(&self) -> Value {
        assert_eq!(self.stdout.lines().count(), 1, "{self:#?}");
        serde_json::from_str(&self.stdout).unwrap()
    }
}

/// A scene that ships with the project.
pub fn shipped(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes").join(name).with_extension("toml").display().to_string()
}
