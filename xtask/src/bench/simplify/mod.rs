//! `cargo xtask bench simplify`: fewer triangles, beside the tools that people use.

mod models;
mod page;
mod tools;

use super::{
    peers::Peer,
    report::{interval, keep},
    scenes,
    statistics::{Runs, estimate, resampled_seconds},
};
use crate::{cargo, gallery::program::Program, root};
use models::{Model, Subject};
pub use page::write_page;
use serde_json::{Value, json};
use std::{
    fs,
    path::{Path, PathBuf},
    process::{Command, Stdio},
};
use tools::Tool;

const HELP: &str = "\
Simplifies the Stanford dragon and models of the project's own, all tools in turns, and measures how far off what they make is.

  cargo xtask bench simplify            ours alone
  cargo xtask bench simplify --peers    meshoptimizer, fast-simplification, pyfqmr, pymeshlab and Open3D too, fetched into
                                        target/bench; the first is compiled and wants a C++ compiler

  --model NAME    this model (repeat for more; default all): dragon, gear, vase, plate
  --file PATH     a model of any format that is read instead of these; its figures are printed, not kept
  --faces N,...   of --file: to so many faces
  --claim         both forms of the quadric beside each other, for each placement, without polish (ours alone)
  --curve         error over time: at seven numbers of faces, ours in four ways and, with --peers, meshoptimizer
  --turns N       times that each is timed (default 5; of what takes more than 2 s, 2)
  --samples N     points of each distance, each way (default 300000)
  --quick         2 turns, 30000 points: to see that all works
  --program FILE  another etendue than the one that is built

Seconds are those of simplifying in memory, polish included, without reading and writing. Distances are of ours to all.
";

/// A tool that takes longer is timed twice.
const SLOW: f64 = 2.0;
/// What sigma is tried.
const SIGMAS: [f64; 7] = [0.0, 0.001, 0.003, 0.01, 0.03, 0.1, 0.3];

/// What the command line asks for.
#[derive(Debug, PartialEq)]
struct Wish {
    peers: bool,
    models: Vec<String>,
    turns: usize,
    samples: usize,
    program: Option<PathBuf>,
    file: Option<PathBuf>,
    faces: Vec<usize>,
    claim: bool,
    curve: bool,
}

impl Wish {
    fn parse(arguments: &[&str]) -> Result<Self, String> {
        let mut wish = Self {
            peers: false,
            models: vec![],
            turns: 5,
            samples: 300_000,
            program: None,
            file: None,
            faces: vec![],
            claim: false,
            curve: false,
        };
        let mut rest = arguments.iter();
        while let Some(&argument) = rest.next() {
            let mut value = || rest.next().copied().ok_or_else(|| format!("{argument} takes a value"));
            let number = |text: &str, low: usize, high: usize| {
                let number = text.parse().ok().filter(|n| (low..=high).contains(n));
                number.ok_or_else(|| format!("{argument} {text}: a number from {low} to {high}"))
            };
            match argument {
                "--peers" => wish.peers = true,
                "--quick" => (wish.turns, wish.samples) = (2, 30_000),
                "--model" => {
                    let name = value()?;
                    if !models::ALL.iter().any(|model| model.name == name) {
                        let names: Vec<&str> = models::ALL.iter().map(|model| model.name).collect();
                        return Err(format!("no model {name}; there are {}", names.join(", ")));
                    }
                    wish.models.push(name.to_owned());
                }
                "--turns" => wish.turns = number(value()?, 1, 1000)?,
                "--samples" => wish.samples = number(value()?, 1000, 100_000_000)?,
                "--program" => wish.program = Some(PathBuf::from(value()?)),
                "--file" => wish.file = Some(PathBuf::from(value()?)),
                "--faces" => {
                    let sizes: Result<Vec<usize>, String> =
                        value()?.split(',').map(|text| number(text, 1, 1 << 30)).collect();
                    wish.faces = sizes?;
                }
                "--claim" => wish.claim = true,
                "--curve" => wish.curve = true,
                _ => return Err(format!("`{argument}` is no option\n\n{HELP}")),
            }
        }
        if wish.file.is_some() == wish.faces.is_empty() {
            return Err("--file and --faces go together".to_owned());
        }
        if wish.file.is_some() && !wish.models.is_empty() {
            return Err("--file or --model, not both".to_owned());
        }
        if wish.curve && (wish.claim || wish.file.is_some()) {
            return Err("--curve goes with neither --claim nor --file".to_owned());
        }
        Ok(wish)
    }

    fn wants(&self, model: &Model) -> bool {
        self.models.is_empty() || self.models.iter().any(|name| name == model.name)
    }
}

/// Runs the command.
pub fn run(arguments: &[&str]) -> Result<(), String> {
    if arguments.iter().any(|a| ["--help", "-h", "help"].contains(a)) {
        print!("{HELP}");
        return Ok(());
    }
    let wish = Wish::parse(arguments)?;
    let folder = place();
    fs::create_dir_all(&folder).map_err(|e| format!("{}: {e}", folder.display()))?;
    let program = match &wish.program {
        Some(program) => program.clone(),
        None => Program::build()?.path().to_owned(),
    };
    let session = Session { wish: &wish, program, meter: meter()? };
    let subjects: Vec<Subject> = match &wish.file {
        Some(file) => vec![session.file(file)?],
        None => models::ALL.iter().filter(|model| wish.wants(model)).map(Model::subject).collect::<Result<_, _>>()?,
    };
    for mut subject in subjects {
        if wish.curve {
            subject.sizes = along(&subject.sizes);
        }
        let mut tools = if wish.claim {
            tools::both_forms(&session.program)
        } else {
            tools::ours(&session.program, subject.is_own || wish.curve)
        };
        if wish.peers && !wish.claim {
            tools.extend(if wish.curve { tools::fastest()? } else { tools::theirs()? });
        }
        let result = session.measure(&subject, &mut tools)?;
        if wish.file.is_none() {
            let what = match (wish.claim, wish.curve) {
                (true, _) => CLAIM,
                (_, true) => CURVE,
                _ => "simplify",
            };
            keep(&format!("{what}-{}", subject.name), &result)?;
        }
    }
    Ok(())
}

/// What results of `--claim` and of `--curve` begin with.
const CLAIM: &str = "simplify-claim";
const CURVE: &str = "simplify-curve";

/// Numbers of faces of a curve.
const STEPS: usize = 7;

/// Numbers of faces in equal ratios, from half the least to twice the most.
fn along(sizes: &[usize]) -> Vec<usize> {
    let (least, most) = sizes.iter().fold((usize::MAX, 0), |(least, most), &n| (least.min(n), most.max(n)));
    let (first, ratio) = (0.5 * least as f64, 4.0 * most as f64 / least as f64);
    let step = |i: usize| first * libm::pow(ratio, i as f64 / (STEPS - 1) as f64);
    (0..STEPS).map(|i| step(i).round() as usize).collect()
}

/// Where models and what comes of them are.
fn place() -> PathBuf {
    super::folder().join("simplify")
}

/// The program that measures distances.
fn meter() -> Result<PathBuf, String> {
    let arguments = ["build", "--release", "--locked", "--package", "etendue-scene", "--example", "mesh_distance"];
    let output = cargo(&arguments)
        .args(["--message-format", "json-render-diagnostics"])
        .stderr(Stdio::inherit())
        .output()
        .map_err(|e| format!("cannot run cargo: {e}"))?;
    let path = |line: &str| Some(PathBuf::from(serde_json::from_str::<Value>(line).ok()?["executable"].as_str()?));
    let messages = String::from_utf8_lossy(&output.stdout);
    messages.lines().filter_map(path).next_back().ok_or_else(|| "mesh_distance does not build".to_owned())
}

struct Session<'a> {
    wish: &'a Wish,
    program: PathBuf,
    meter: PathBuf,
}

impl Session<'_> {
    /// A file of any format as one that all tools read.
    fn file(&self, file: &Path) -> Result<Subject, String> {
        let name = file.file_stem().map_or_else(|| "model".to_owned(), |name| name.to_string_lossy().into_owned());
        let path = place().join(format!("file-{name}.ply"));
        let done = Command::new(&self.program).arg("convert").args([file, &path]).output();
        let done = done.map_err(|e| format!("{}: {e}", self.program.display()))?;
        if !done.status.success() {
            return Err(String::from_utf8_lossy(&done.stderr).into_owned());
        }
        let faces = self.distance(&path, &path)?["faces"][0].as_u64().unwrap_or(0) as usize;
        let what = format!("{}, {faces} faces", file.display());
        Ok(Subject { name, what, faces, sizes: self.wish.faces.clone(), path, is_own: false })
    }

    fn measure(&self, model: &Subject, tools: &mut [Tool]) -> Result<Value, String> {
        let path = &model.path;
        println!("== {}", model.what);
        for tool in tools.iter_mut() {
            tool.open(path)?;
        }
        let sizes: Result<Vec<Value>, String> =
            model.sizes.iter().map(|&faces| self.size(model, faces, tools)).collect();
        let middle = model.sizes.get(1).copied().unwrap_or(0);
        let sigma =
            if model.is_own && !self.wish.claim && !self.wish.curve { self.sigmas(path, middle)? } else { json!([]) };
        Ok(json!({
            "model": model.name,
            "what": model.what,
            "turns": self.wish.turns,
            "samples": self.wish.samples,
            "peers": self.wish.peers,
            "faces": model.faces,
            "sizes": sizes?,
            "sigma": { "faces": middle, "tried": sigma },
        }))
    }

    fn size(&self, model: &Subject, faces: usize, tools: &mut [Tool]) -> Result<Value, String> {
        let path = &model.path;
        let mut times: Vec<Vec<f64>> = vec![vec![]; tools.len()];
        let output = |i: usize| place().join(format!("{}-{faces}-{i}.ply", model.name));
        for turn in 0..self.wish.turns {
            for i in 0..tools.len() {
                // Who goes first changes, so that a machine that slows down favours nobody.
                let i = (i + turn) % tools.len();
                let slow = times[i].len() >= 2 && times[i].iter().all(|t| *t > SLOW);
                if !slow {
                    times[i].push(tools[i].simplify(faces, &output(i))?);
                }
            }
        }
        let mut entries = Vec::new();
        for (i, tool) in tools.iter().enumerate() {
            let found = self.distance(path, &output(i))?;
            let diagonal = found["diagonal"].as_f64().unwrap_or(1.0);
            let relative = |key: &str| found[key].as_f64().unwrap_or(f64::NAN) / diagonal;
            let ones = vec![1.0; times[i].len()];
            let runs = Runs { build: 0.0, render: &times[i], error: &ones };
            let seconds = interval(estimate(&resampled_seconds(&runs, 1.0, faces as u64)));
            println!(
                "  {faces:6} {:34} {:7.3} s  rms {:9.3e}  largest {:9.3e}  {} faces",
                tool.name,
                seconds[0].as_f64().unwrap_or(0.0),
                relative("rms"),
                relative("largest"),
                found["faces"][1]
            );
            entries.push(json!({
                "name": tool.name,
                "ours": tool.is_ours(),
                "seconds": seconds,
                "times": times[i],
                "faces": found["faces"][1],
                "rms": relative("rms"),
                "largest": relative("largest"),
            }));
        }
        let check = match tools.iter_mut().find(|tool| tool.measures()) {
            Some(tool) => self.cross_check(tool, path, &output(0), &entries[0])?,
            None => Value::Null,
        };
        Ok(json!({ "faces": faces, "tools": entries, "check": check }))
    }

    /// Our distance of two files.
    fn distance(&self, a: &Path, b: &Path) -> Result<Value, String> {
        let output = Command::new(&self.meter).args([a, b]).arg(self.wish.samples.to_string()).output();
        let output = output.map_err(|e| format!("{}: {e}", self.meter.display()))?;
        serde_json::from_slice(&output.stdout)
            .map_err(|_| format!("{}: {}", b.display(), String::from_utf8_lossy(&output.stderr).trim()))
    }

    /// MeshLab's distance of the same files over ours.
    fn cross_check(&self, tool: &mut Tool, a: &Path, b: &Path, ours: &Value) -> Result<Value, String> {
        let theirs = tool.measure(a, b, self.wish.samples)?;
        let diagonal = self.distance(a, a)?["diagonal"].as_f64().unwrap_or(1.0);
        let ratio = |key: &str| {
            let of = |v: &Value| v[key].as_f64().unwrap_or(f64::NAN);
            of(&theirs) / diagonal / of(ours)
        };
        let (rms, largest) = (ratio("rms"), ratio("largest"));
        println!("         MeshLab's distance over ours: rms {rms:.4}, largest {largest:.4}");
        Ok(json!({ "rms": rms, "largest": largest }))
    }

    fn sigmas(&self, path: &Path, faces: usize) -> Result<Value, String> {
        let mut tried = Vec::new();
        for sigma in SIGMAS {
            let text = sigma.to_string();
            let mut tool = Tool::own(&self.program, "sigma", &["--sigma", &text, "--no-polish"]);
            tool.open(path)?;
            let output = place().join("sigma.ply");
            tool.simplify(faces, &output)?;
            let found = self.distance(path, &output)?;
            let relative =
                |key: &str| found[key].as_f64().unwrap_or(f64::NAN) / found["diagonal"].as_f64().unwrap_or(1.0);
            let (rms, largest) = (relative("rms"), relative("largest"));
            println!("  {faces:6} sigma {text:6} rms {rms:9.3e}  largest {largest:9.3e}");
            tried.push(json!({ "sigma": sigma, "rms": rms, "largest": largest }));
        }
        Ok(Value::Array(tried))
    }
}

/// The kept results that begin with `what`, in the order of the models.
fn kept(what: &str) -> Vec<Value> {
    models::ALL.iter().filter_map(|model| super::page::kept(&format!("{what}-{}", model.name))).collect()
}

/// What comes from PyPI, all in one virtual environment.
const SIMPLIFIERS: Peer = Peer {
    name: "simplifiers",
    script: "bench/simplify/with_simplifiers.py",
    pythons: &["3.11", "3.12"],
    packages: &["fast-simplification==0.2.0", "pyfqmr==0.5.0", "pymeshlab==2025.7.post1", "open3d==0.20.0", "numpy"],
    libraries: "libusb-1.0-0 libgl1 libegl1 libgomp1",
};

/// Builds meshoptimizer with the program that talks with it.
fn meshoptimizer() -> Result<PathBuf, String> {
    let target = super::folder().join("meshoptimizer");
    let manifest = root().join("bench/simplify/meshoptimizer/Cargo.toml");
    let mut command = cargo(&["build", "--release", "--quiet", "--manifest-path"]);
    let status = command.arg(manifest).arg("--target-dir").arg(&target).status();
    match status {
        Ok(status) if status.success() => Ok(target.join("release/rival-meshoptimizer")),
        Ok(_) => Err("meshoptimizer does not build; it wants a C++ compiler".to_owned()),
        Err(e) => Err(format!("cannot run cargo: {e}")),
    }
}

/// The dragon, fetched if it is not there.
fn dragon() -> Result<PathBuf, String> {
    scenes::dragon()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wishes() {
        let parse = |text: &str| Wish::parse(&text.split_whitespace().collect::<Vec<_>>());
        let some = parse("--model gear --peers --turns 3").unwrap();
        assert_eq!((some.peers, some.turns, some.models.len()), (true, 3, 1));
        assert!(parse("--curve --peers").unwrap().curve);
        assert_eq!(along(&[1000, 4000]), [500, 794, 1260, 2000, 3175, 5040, 8000]);
        assert_eq!(parse("--quick").unwrap().samples, 30_000);
        assert!(models::ALL.iter().all(|model| parse("").unwrap().wants(model)));
        let file = parse("--file a.obj --faces 200,50").unwrap();
        assert_eq!((file.file, file.faces), (Some(PathBuf::from("a.obj")), vec![200, 50]));
        for wrong in [
            "--file a.obj",
            "--faces 9",
            "--file a.obj --faces 9 --model gear",
            "--file a.obj --faces 9,x",
            "--curve --claim",
            "--curve --file a.obj --faces 9",
            "--model",
            "--model other",
            "--turns 0",
            "--samples x",
            "gear",
        ] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }
}
