//! `cargo xtask bench load`: how fast files are read, beside a copy of their bytes in memory and beside another reader, and how
//! long a small scene takes from the start of the program to its picture.

use super::folder;
use crate::{cargo, root};
use serde_json::{Value, json};
use std::{
    fs,
    hint::black_box,
    path::{Path, PathBuf},
    process::{Command, Stdio},
    time::Instant,
};

mod files;

pub const HELP: &str = "\
Reads generated meshes from the page cache, in turns with a copy of the same bytes from memory to memory that is in use
already, and starts the program on small scenes. Prints medians, and ratios with the 95 % intervals of their medians.

  --peers       OBJ also beside rapidobj (from PyPI, compiled with c++ -O3)
  --pairs N     repetitions (default 7; fewer than 6 give no interval)
  --part N      files of an N-th of the usual 160 to 250 MB
  --json        the figures as JSON instead

`of a copy` is the speed over that of the copy, `of rapidobj` over that of rapidobj; memory is the peak over that of the mesh.
";

/// Scenes that a start is measured on.
const STARTS: [&str; 4] = ["cornell-box", "glass-spheres", "still-life", "daylight"];

struct Options {
    peers: bool,
    pairs: usize,
    part: usize,
    json: bool,
}

fn options(arguments: &[&str]) -> Result<Options, String> {
    let mut options = Options { peers: false, pairs: 7, part: 1, json: false };
    let mut rest = arguments.iter();
    while let Some(argument) = rest.next() {
        let mut number = || {
            let value = rest.next().and_then(|text| text.parse().ok()).filter(|n| (1..=1000).contains(n));
            value.ok_or(format!("{argument} takes a number from 1 to 1000"))
        };
        match *argument {
            "--peers" => options.peers = true,
            "--json" => options.json = true,
            "--pairs" => options.pairs = number()?,
            "--part" => options.part = number()?,
            other => return Err(format!("`{other}` is no option\n\n{HELP}")),
        }
    }
    Ok(options)
}

/// Runs it.
pub fn run(arguments: &[&str]) -> Result<(), String> {
    if let ["--help" | "-h" | "help"] = arguments {
        print!("{HELP}");
        return Ok(());
    }
    let options = options(arguments)?;
    let (reader, program) = build()?;
    let rival = if options.peers { Some(rival()?) } else { None };
    let mut results = vec![];
    for file in files::make(&folder().join("load"), options.part)? {
        let rival = rival.as_deref().filter(|_| file.extension().is_some_and(|e| e == "obj"));
        let result = measure(&reader, &file, rival, options.pairs)?;
        if !options.json {
            println!("{}", line(&result));
        }
        results.push(result);
    }
    let mut starts = vec![];
    for scene in STARTS {
        let result = start(&program, scene, options.pairs)?;
        if !options.json {
            println!(
                "start on {scene}: {:.1} ms to the picture on disk",
                result["milliseconds"].as_f64().unwrap_or(0.0)
            );
        }
        starts.push(result);
    }
    if options.json {
        println!("{:#}", json!({ "files": results, "starts": starts }));
    }
    Ok(())
}

/// The reader of meshes and the program, optimised.
fn build() -> Result<(PathBuf, PathBuf), String> {
    for what in [&["-p", "etendue-scene", "--example", "read_mesh"][..], &["-p", "etendue-cli"]] {
        let status = cargo(&["build", "--release", "--quiet"]).args(what).status().map_err(|e| e.to_string())?;
        if !status.success() {
            return Err("it does not build".to_owned());
        }
    }
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let release = target.join("release");
    Ok((release.join("examples/read_mesh"), release.join("etendue")))
}

/// The other reader, installed if it is not there.
fn rival() -> Result<PathBuf, String> {
    let output = Command::new("python3")
        .arg(root().join("bench/obj.py"))
        .arg("--rival")
        .env("ETENDUE_BENCH_DIR", folder())
        .stderr(Stdio::inherit())
        .output()
        .map_err(|error| format!("python3: {error}"))?;
    let path = String::from_utf8_lossy(&output.stdout).trim().to_owned();
    if output.status.success() && !path.is_empty() { Ok(path.into()) } else { Err("no rapidobj".to_owned()) }
}

/// What a program prints about a file.
fn told(program: &Path, file: &Path) -> Result<Value, String> {
    let output = Command::new(program).arg(file).output().map_err(|e| format!("{}: {e}", program.display()))?;
    if !output.status.success() {
        let errors = String::from_utf8_lossy(&output.stderr).into_owned();
        return Err(format!("{} {}: {errors}", program.display(), file.display()));
    }
    serde_json::from_slice(&output.stdout).map_err(|error| error.to_string())
}

fn number(value: &Value, key: &str) -> Result<f64, String> {
    value[key].as_f64().ok_or(format!("`{key}` is missing in {value}"))
}

/// Reader, copy and rival in turns.
fn measure(reader: &Path, file: &Path, rival: Option<&Path>, pairs: usize) -> Result<Value, String> {
    let bytes = fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
    // Touched before, so that no page is new.
    let mut copy = bytes.clone();
    let (mut seconds, mut of_copy, mut of_rival, mut rivals) = (vec![], vec![], vec![], vec![]);
    let (mut peak, mut mesh) = (0.0f64, 1.0);
    for _ in 0..pairs {
        let ours = told(reader, file)?;
        let own = number(&ours, "seconds")?;
        let clock = Instant::now();
        copy.copy_from_slice(black_box(&bytes));
        black_box(&mut copy);
        of_copy.push(clock.elapsed().as_secs_f64() / own);
        if let Some(rival) = rival {
            let theirs = told(rival, file)?;
            if theirs["triangles"] != ours["triangles"] {
                return Err(format!("{}: the readers find different numbers of triangles", file.display()));
            }
            let theirs = number(&theirs, "seconds")?;
            of_rival.push(theirs / own);
            rivals.push(theirs);
        }
        seconds.push(own);
        mesh = number(&ours, "mesh_bytes")?;
        peak = peak.max(ours["peak_bytes"].as_f64().unwrap_or(0.0));
    }
    let median = interval(&mut seconds)[1];
    let name = file.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let mut result = json!({
        "file": name,
        "bytes": bytes.len(),
        "seconds": median,
        "megabytes_per_second": bytes.len() as f64 / median * 1e-6,
        "of_copy": interval(&mut of_copy),
        "memory_of_mesh": peak / mesh,
    });
    if rival.is_some() {
        result["rapidobj_seconds"] = json!(interval(&mut rivals)[1]);
        result["of_rapidobj"] = json!(interval(&mut of_rival));
    }
    Ok(result)
}

fn line(result: &Value) -> String {
    let ratio = |key: &str| {
        let [low, median, high] = [0, 1, 2].map(|i| result[key][i].as_f64().unwrap_or(f64::NAN));
        format!("{median:.3} [{low:.3}, {high:.3}]")
    };
    let figure = |key: &str| result[key].as_f64().unwrap_or(f64::NAN);
    let rival =
        if result["of_rapidobj"].is_null() { String::new() } else { format!(", {} of rapidobj", ratio("of_rapidobj")) };
    format!(
        "{:12} {:4.0} MB  {:.3} s  {:5.0} MB/s, {} of a copy{rival}, memory {:.2} of the mesh",
        result["file"].as_str().unwrap_or(""),
        figure("bytes") * 1e-6,
        figure("seconds"),
        figure("megabytes_per_second"),
        ratio("of_copy"),
        figure("memory_of_mesh"),
    )
}

/// From the start of the process to its end, at one sample a pixel of a small picture.
fn start(program: &Path, scene: &str, pairs: usize) -> Result<Value, String> {
    let output = folder().join("load/start.exr");
    let mut milliseconds = vec![];
    for _ in 0..pairs {
        let clock = Instant::now();
        let status = Command::new(program)
            .arg("render")
            .arg(root().join(format!("scenes/{scene}.toml")))
            .args(["--quiet", "--spp", "1", "--size", "64x64", "-o"])
            .arg(&output)
            .stderr(Stdio::null())
            .status()
            .map_err(|error| error.to_string())?;
        milliseconds.push(clock.elapsed().as_secs_f64() * 1e3);
        if !status.success() {
            return Err(format!("{scene}.toml was not rendered"));
        }
    }
    let [low, median, high] = interval(&mut milliseconds);
    Ok(json!({ "scene": scene, "milliseconds": median, "interval": [low, high] }))
}

/// The median between the ends of its 95 % interval by order statistics; of fewer than 6 values, the least and the greatest.
fn interval(values: &mut [f64]) -> [f64; 3] {
    values.sort_by(f64::total_cmp);
    let count = values.len();
    let median = 0.5 * (values[(count - 1) / 2] + values[count / 2]);
    // The most values that may be left out at each end: the chance that fewer heads than that fall in `count` throws stays
    // within 2.5 %.
    let (mut term, mut sum, mut out) = ((0..count).fold(1.0, |chance, _| 0.5 * chance), 0.0, 0);
    while out < (count - 1) / 2 && sum + term <= 0.025 {
        sum += term;
        out += 1;
        term *= (count + 1 - out) as f64 / out as f64;
    }
    let out = out.saturating_sub(1);
    [values[out], median, values[count - 1 - out]]
}

#[cfg(test)]
mod tests {
    use super::interval;

    /// Ranks of the tables for the sign test.
    #[test]
    fn intervals_of_medians() {
        for (count, low) in [(1, 1), (5, 1), (6, 1), (8, 1), (9, 2), (15, 4), (20, 6), (25, 8)] {
            let mut values: Vec<f64> = (1..=count).rev().map(f64::from).collect();
            let [least, median, most] = interval(&mut values);
            assert_eq!(least, f64::from(low), "{count}");
            assert_eq!(most, f64::from(count + 1 - low), "{count}");
            assert_eq!(median, 0.5 * f64::from(count + 1));
        }
    }
}
