//! Renderers that take turns: ours as a program, others as processes that stay warm.

use super::{folder, picture::Picture};
use crate::{root, venv};
use serde_json::{Value, json};
use std::{
    io::{BufRead, BufReader, Write},
    path::{Path, PathBuf},
    process::{Child, ChildStdin, ChildStdout, Command, Stdio},
};

/// Software of others to be measured against.
pub struct Peer {
    /// The name of its virtual environment, and of its program.
    pub name: &'static str,
    /// The program that talks with it.
    pub script: &'static str,
    /// Python versions that it is made for, the best first.
    pub pythons: &'static [&'static str],
    pub packages: &'static [&'static str],
    /// Where the system's own libraries are missing, these Debian packages have them.
    pub libraries: &'static str,
}

/// All renderers.
pub const PEERS: &[Peer] = &[
    Peer {
        name: "mitsuba",
        script: "bench/peers/with_mitsuba.py",
        pythons: &["3.11", "3.12", "3.13"],
        packages: &["mitsuba==3.9.1", "numpy"],
        libraries: "libllvm19",
    },
    Peer {
        name: "cycles",
        script: "bench/peers/with_cycles.py",
        pythons: &["3.13"],
        packages: &["bpy==5.2.3", "numpy"],
        libraries: "libxi6 libxxf86vm1 libxfixes3 libxrender1 libsm6 libgl1 libegl1 libxkbcommon0",
    },
];

impl Peer {
    fn home(&self) -> PathBuf {
        folder().join(self.name)
    }

    /// Makes its virtual environment and fetches its packages from PyPI, unless it is there.
    pub fn install(&self) -> Result<(), String> {
        venv::install(&self.home(), self.pythons, self.packages)
    }

    /// Starts its program.
    pub fn start(&self) -> Result<Conversation, String> {
        let mut command = Command::new(venv::python_of(&self.home()));
        command.arg(root().join(self.script));
        Conversation::start(self.name, &mut command, self.libraries)
    }
}

/// A process that answers line by line.
pub struct Conversation {
    name: &'static str,
    child: Child,
    stdin: Option<ChildStdin>,
    stdout: BufReader<ChildStdout>,
    hint: String,
}

impl Conversation {
    /// Starts a program; what it says besides goes to `NAME.log`. `libraries` are what it may lack.
    pub fn start(name: &'static str, command: &mut Command, libraries: &str) -> Result<Self, String> {
        let log = folder().join(format!("{name}.log"));
        let told = |e: &dyn std::fmt::Display| format!("{name}: {e}");
        let file = std::fs::File::create(&log).map_err(|e| told(&e))?;
        let mut child =
            command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(file).spawn().map_err(|e| told(&e))?;
        let (Some(stdin), Some(stdout)) = (child.stdin.take(), child.stdout.take()) else {
            return Err(told(&"its pipes are missing"));
        };
        let hint = format!("see {}; it may lack {libraries} (apt-get install)", log.display());
        Ok(Self { name, child, stdin: Some(stdin), stdout: BufReader::new(stdout), hint })
    }

    /// The answer to a request.
    pub fn ask(&mut self, request: &Value) -> Result<Value, String> {
        let mut line = String::new();
        let told = |e: &dyn std::fmt::Display| format!("{}: {e}", self.name);
        if let Some(stdin) = &mut self.stdin {
            writeln!(stdin, "{request}").map_err(|e| format!("{} ({})", told(&e), self.hint))?;
        }
        self.stdout.read_line(&mut line).map_err(|e| told(&e))?;
        let answer: Value = serde_json::from_str(&line).map_err(|_| format!("{} ended; {}", self.name, self.hint))?;
        match answer["error"].as_str() {
            Some(error) => Err(told(&error)),
            None => Ok(answer),
        }
    }
}

impl Drop for Conversation {
    fn drop(&mut self) {
        self.stdin = None;
        let _ = self.child.wait();
    }
}

/// What a render took and gave.
pub struct Turn {
    /// Reading, seconds.
    pub load: f64,
    /// Acceleration structures and tables, seconds; of others 0 where it is part of `render`.
    pub build: f64,
    /// Rendering, seconds.
    pub render: f64,
    /// Rays traced, where that is known.
    pub rays: Option<f64>,
    pub picture: Picture,
}

/// A renderer with a scene.
pub struct Renderer {
    pub name: String,
    kind: Kind,
}

enum Kind {
    Ours { program: PathBuf, scene: PathBuf, size: [usize; 2], threads: usize },
    Theirs { conversation: Conversation, load: f64, build: f64 },
}

impl Renderer {
    pub fn ours(program: &Path, size: [usize; 2], threads: usize) -> Self {
        let kind = Kind::Ours { program: program.to_owned(), scene: PathBuf::new(), size, threads };
        Self { name: "Etendue".to_owned(), kind }
    }

    pub fn theirs(peer: &Peer) -> Result<Self, String> {
        let kind = Kind::Theirs { conversation: peer.start()?, load: 0.0, build: 0.0 };
        Ok(Self { name: peer.name.to_owned(), kind })
    }

    /// Whether this is the one that is measured.
    pub fn is_ours(&self) -> bool {
        matches!(self.kind, Kind::Ours { .. })
    }

    /// Takes another scene.
    pub fn open(&mut self, scene_file: &Path, picture_size: [usize; 2], thread_count: usize) -> Result<(), String> {
        match &mut self.kind {
            Kind::Ours { scene, .. } => *scene = scene_file.to_owned(),
            Kind::Theirs { conversation, load, build } => {
                let request = json!({ "scene": scene_file, "size": picture_size, "threads": thread_count });
                let answer = conversation.ask(&request)?;
                *load = answer["load"].as_f64().unwrap_or(0.0);
                *build = answer["build"].as_f64().unwrap_or(0.0);
                if let Some(name) = answer["name"].as_str() {
                    self.name = name.to_owned();
                }
                // Kernels are compiled at the first render, which is not timed.
                let output = folder().join("warm.pfm");
                conversation.ask(&json!({ "spp": 1, "seed": 0, "output": output }))?;
            }
        }
        Ok(())
    }

    /// Renders the scene.
    pub fn render(&mut self, spp: u64, seed: u64) -> Result<Turn, String> {
        let output = folder().join("turn.pfm");
        let (answer, load, build) = match &mut self.kind {
            Kind::Ours { program, scene, size: [width, height], threads } => {
                let mut command = Command::new(&*program);
                command.arg("render").arg(&*scene).arg("--output").arg(&output).args(["--quiet", "--json"]);
                command.args(["--filter", "box", "--size", &format!("{width}x{height}")]);
                command.args(["--spp", &spp.to_string(), "--seed", &seed.to_string()]);
                command.args(["--threads", &threads.to_string()]);
                let done = command.stderr(Stdio::inherit()).output();
                let done = done.map_err(|e| format!("{}: {e}", program.display()))?;
                if !done.status.success() {
                    return Err(format!("{} ended with {}", program.display(), done.status));
                }
                let answer: Value = serde_json::from_slice(&done.stdout).map_err(|e| e.to_string())?;
                let seconds = |key: &str| answer["seconds"][key].as_f64().unwrap_or(0.0);
                let (load, build) = (seconds("load"), seconds("build"));
                (json!({ "render": seconds("render"), "rays": answer["rays"] }), load, build)
            }
            Kind::Theirs { conversation, load, build } => {
                let request = json!({ "spp": spp, "seed": seed, "output": output });
                (conversation.ask(&request)?, *load, *build)
            }
        };
        let render = answer["render"].as_f64().ok_or_else(|| format!("{} tells no time", self.name))?;
        Ok(Turn { load, build, render, rays: answer["rays"].as_f64(), picture: Picture::read(&output)? })
    }
}
