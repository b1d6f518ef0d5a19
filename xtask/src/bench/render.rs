//! `cargo xtask bench render`: seconds to an error, all renderers in turns in one session.

use super::{
    folder,
    peers::{PEERS, Renderer, Turn},
    picture::Picture,
    report, scenes,
    statistics::{self, Runs},
};
use crate::gallery::program::Program;
use serde_json::{Value, json};
use std::{fs, path::PathBuf};

pub const HELP: &str = "\
Renders scenes in turns with every renderer and prints the seconds to a relative mean squared error.

  cargo xtask bench render            ours alone
  cargo xtask bench render --peers    Mitsuba and Cycles too, installed into target/bench from PyPI

  --scene NAME    this scene (repeat for more; default all)
  --seeds N       pictures of each renderer (default 16)
  --target X      the error (default 1e-3)
  --limit S       most seconds of a picture (default 30): beyond it the time to the target is extrapolated, and marked
  --size N        pictures of N x N pixels (default 512)
  --threads N     default 2
  --quick         3 seeds of 64 samples, extrapolated and marked: to see that all works
  --program FILE  another etendue than the one that is built
";

/// Samples per pixel of the pilots.
const PILOTS: [u64; 2] = [16, 64];
/// Seeds of reference pictures start here; those of measured ones at 1.
const REFERENCE_SEED: u64 = 1_000_000;
/// Independent pictures that make a reference, each of so many times the samples that are measured. What is left of noise in
/// the reference counts as error of ours: a 32nd of it.
const REFERENCE_PARTS: u64 = 8;
const REFERENCE_FACTOR: u64 = 4;

/// What the command line asks for.
#[derive(Debug, PartialEq)]
struct Wish {
    peers: bool,
    scenes: Vec<String>,
    seeds: u64,
    target: f64,
    limit: f64,
    size: usize,
    threads: usize,
    quick: bool,
    program: Option<PathBuf>,
}

impl Wish {
    fn parse(arguments: &[&str]) -> Result<Self, String> {
        let mut wish = Self {
            peers: false,
            scenes: Vec::new(),
            seeds: 16,
            target: 1e-3,
            limit: 30.0,
            size: 512,
            threads: 2,
            quick: false,
            program: None,
        };
        let mut rest = arguments.iter();
        while let Some(&argument) = rest.next() {
            let mut value = || rest.next().copied().ok_or_else(|| format!("{argument} takes a value"));
            match argument {
                "--peers" => wish.peers = true,
                "--quick" => wish.quick = true,
                "--scene" => {
                    let name = value()?;
                    if !scenes::NAMES.contains(&name) {
                        return Err(format!("no scene {name}; there are {}", scenes::NAMES.join(", ")));
                    }
                    wish.scenes.push(name.to_owned());
                }
                "--program" => wish.program = Some(PathBuf::from(value()?)),
                "--seeds" => wish.seeds = number(argument, value()?, 2.0, 1000.0)? as u64,
                "--target" => wish.target = number(argument, value()?, 1e-7, 1.0)?,
                "--limit" => wish.limit = number(argument, value()?, 0.1, 1e5)?,
                "--size" => wish.size = number(argument, value()?, 16.0, 4096.0)? as usize,
                "--threads" => wish.threads = number(argument, value()?, 1.0, 1024.0)? as usize,
                _ => return Err(format!("`{argument}` is no option\n\n{HELP}")),
            }
        }
        if wish.quick {
            wish.seeds = wish.seeds.min(3);
        }
        if wish.scenes.is_empty() {
            wish.scenes = scenes::NAMES.iter().map(|&name| name.to_owned()).collect();
        }
        Ok(wish)
    }
}

fn number(option: &str, text: &str, low: f64, high: f64) -> Result<f64, String> {
    let value = text.parse().ok().filter(|v| (low..=high).contains(v));
    value.ok_or_else(|| format!("{option} {text}: a number from {low} to {high}"))
}

/// Runs the command.
pub fn run(arguments: &[&str]) -> Result<(), String> {
    if arguments.iter().any(|a| ["--help", "-h", "help"].contains(a)) {
        print!("{HELP}");
        return Ok(());
    }
    let wish = Wish::parse(arguments)?;
    let names: Vec<&str> = wish.scenes.iter().map(String::as_str).collect();
    scenes::make(&names)?;
    let program = match &wish.program {
        Some(program) => program.clone(),
        None => Program::build()?.path().to_owned(),
    };
    let mut renderers = vec![Renderer::ours(&program, [wish.size; 2], wish.threads)];
    if wish.peers {
        for peer in PEERS {
            peer.install()?;
            renderers.push(Renderer::theirs(peer)?);
        }
    }
    let mut results = Vec::new();
    for name in names {
        println!("== {name}");
        let result = Measurement { wish: &wish, name, scene: scenes::file(name) }.run(&mut renderers)?;
        report::keep(name, &result)?;
        report::print_scene(&result);
        results.push(result);
    }
    report::print_all(&results);
    Ok(())
}

/// One scene's part of the session.
struct Measurement<'a> {
    wish: &'a Wish,
    name: &'a str,
    scene: PathBuf,
}

/// One renderer's part of it.
struct Measured {
    spp: u64,
    /// Whether the time limit kept the samples below what the target needs.
    limited: bool,
    /// (seconds, error) of the pilots.
    pilots: [(f64, f64); 2],
    turns: Vec<Turn>,
}

impl Measurement<'_> {
    fn run(&self, renderers: &mut [Renderer]) -> Result<Value, String> {
        let mut measured = Vec::new();
        for renderer in &mut *renderers {
            renderer.open(&self.scene, [self.wish.size; 2], self.wish.threads)?;
            measured.push(self.pilot(renderer)?);
        }
        let reference_spp = measured.first().map_or(1, |ours| ours.spp) * REFERENCE_FACTOR;
        let reference = match renderers.iter_mut().find(|renderer| renderer.is_ours()) {
            Some(ours) => self.reference(ours, reference_spp)?,
            None => return Err("nobody renders the reference".to_owned()),
        };
        for seed in 0..self.wish.seeds {
            for i in 0..renderers.len() {
                // Who goes first changes, so that a machine that slows down favours nobody.
                let i = (i + seed as usize) % renderers.len();
                let turn = renderers[i].render(measured[i].spp, seed + 1)?;
                measured[i].turns.push(turn);
            }
        }
        self.result(renderers, &measured, &reference)
    }

    /// Two seeds each at few samples: how many the target needs.
    fn pilot(&self, renderer: &mut Renderer) -> Result<Measured, String> {
        let mut pilots = [(0.0, 0.0); 2];
        let mut per_sample = 0.0;
        for (pilot, spp) in pilots.iter_mut().zip(PILOTS) {
            let two = [renderer.render(spp, 501)?, renderer.render(spp, 502)?];
            let seconds = (two[0].render + two[1].render) / 2.0;
            let pictures = two.map(|turn| turn.picture);
            let middle = Picture::mean(&pictures).ok_or("no picture")?;
            let slices = pictures.each_ref().map(|picture| picture.values.as_slice());
            *pilot = (seconds, statistics::mean(&statistics::spread(&slices, &middle.values)));
            per_sample = seconds / spp as f64;
        }
        let samples = [0, 1].map(|i| (PILOTS[i] as f64, pilots[i].1));
        let needed = statistics::samples_for(self.wish.target, samples).clamp(1.0, 1e7);
        let affordable = (self.wish.limit / per_sample.max(1e-9)).max(1.0);
        let spp = if self.wish.quick { PILOTS[1] } else { needed.min(affordable).round().max(1.0) as u64 };
        println!(
            "  {:30} pilots {:.2e} {:.2e}: {needed:.0} samples for {:.0e}, {spp} taken",
            renderer.name, pilots[0].1, pilots[1].1, self.wish.target
        );
        Ok(Measured { spp, limited: (spp as f64) < 0.7 * needed, pilots, turns: Vec::new() })
    }

    /// Independent pictures by ours that together are the reference, kept by what makes them.
    fn reference(&self, ours: &mut Renderer, spp: u64) -> Result<Vec<Picture>, String> {
        let text = fs::read(&self.scene).map_err(|e| format!("{}: {e}", self.scene.display()))?;
        // Coarse steps: a pilot that differs a little finds what is there.
        let spp = spp.next_power_of_two();
        let key = fnv(&text);
        let home = folder().join(format!("references/{}-{key:016x}-{}-{spp}", self.name, self.wish.size));
        fs::create_dir_all(&home).map_err(|e| format!("{}: {e}", home.display()))?;
        println!("  reference of {REFERENCE_PARTS} x {spp} samples");
        let mut pictures = Vec::new();
        for part in 0..REFERENCE_PARTS {
            let path = home.join(format!("{part}.pfm"));
            if !path.is_file() {
                ours.render(spp, REFERENCE_SEED + part)?;
                let made = folder().join("turn.pfm");
                fs::rename(&made, &path).map_err(|e| format!("{}: {e}", path.display()))?;
            }
            pictures.push(Picture::read(&path)?);
        }
        Ok(pictures)
    }

    fn result(&self, renderers: &[Renderer], all: &[Measured], parts: &[Picture]) -> Result<Value, String> {
        let reference = Picture::mean(parts).ok_or("no reference")?;
        let part_slices: Vec<&[f32]> = parts.iter().map(|p| p.values.as_slice()).collect();
        let own = statistics::mean(&statistics::spread(&part_slices, &reference.values)) / parts.len() as f64;
        let mut entries = Vec::new();
        let mut resampled = Vec::new();
        for (renderer, measured) in renderers.iter().zip(all) {
            let (entry, seconds) = self.entry(renderer, measured, &reference, &part_slices)?;
            entries.push(entry);
            resampled.push(seconds);
        }
        let fastest = (1..resampled.len()).min_by(|&a, &b| resampled[a][0].total_cmp(&resampled[b][0]));
        let ratio = fastest.map(|i| statistics::ratio(&resampled[0], &resampled[i]));
        Ok(json!({
            "scene": self.name,
            "size": self.wish.size,
            "threads": self.wish.threads,
            "target": self.wish.target,
            "quick": self.wish.quick,
            "seeds": self.wish.seeds,
            "reference_error": own,
            "renderers": entries,
            "fastest_rival": fastest.map(|i| renderers[i].name.clone()),
            "ratio": ratio.as_ref().map(|r| report::interval(statistics::estimate(r))),
            "ratio_resampled": ratio,
        }))
    }

    /// What is reported of a renderer, and its resampled seconds to the target.
    fn entry(
        &self,
        renderer: &Renderer,
        measured: &Measured,
        reference: &Picture,
        parts: &[&[f32]],
    ) -> Result<(Value, Vec<f64>), String> {
        let turns = &measured.turns;
        let pictures: Vec<&[f32]> = turns.iter().map(|turn| turn.picture.values.as_slice()).collect();
        if pictures.iter().any(|p| p.len() != reference.values.len()) {
            return Err(format!("{}: its picture has another size", renderer.name));
        }
        let errors: Vec<[f64; 2]> = pictures.iter().map(|p| statistics::rel_mse(p, &reference.values)).collect();
        let [plain, trimmed] = [0, 1].map(|i| errors.iter().map(|e| e[i]).collect::<Vec<f64>>());
        let spread = statistics::spread(&pictures, &reference.values);
        let render: Vec<f64> = turns.iter().map(|turn| turn.render).collect();
        let of = |value: fn(&Turn) -> f64| statistics::median(&turns.iter().map(value).collect::<Vec<_>>());
        // A doubt never favours ours: its error is that to the reference, theirs the noise alone.
        let counted = if renderer.is_ours() { &plain } else { &spread };
        let runs = Runs { build: of(|turn| turn.build), render: &render, error: counted };
        let seconds = statistics::resampled_seconds(&runs, self.wish.target, fnv(self.name.as_bytes()));
        let median = statistics::median(&render);
        let paths = (reference.width * reference.height) as f64 * measured.spp as f64;
        let agreement = statistics::agreement(&pictures, parts, reference.width);
        let entry = json!({
            "name": renderer.name,
            "spp": measured.spp,
            "extrapolated": self.wish.quick || measured.limited,
            "load": of(|turn| turn.load),
            "build": runs.build,
            "render": render,
            "render_median": median,
            "mpaths_per_second": paths / median / 1e6,
            "mrays_per_second": turns.first().and_then(|turn| turn.rays).map(|rays| rays / median / 1e6),
            "rel_mse": statistics::mean(&plain),
            "rel_mse_trimmed": statistics::mean(&trimmed),
            "spread": statistics::mean(&spread),
            "errors": counted,
            "seconds_to_target": report::interval(statistics::estimate(&seconds)),
            "pilots": measured.pilots.iter().zip(PILOTS).map(|(&(s, e), n)| json!([n, s, e])).collect::<Vec<_>>(),
            "image_mean_off": agreement.image_off,
            "image_mean_excess": agreement.image_excess,
            "judged": agreement.judged,
            "tiles": agreement.tiles,
            "tiles_disagreeing": agreement.disagreeing,
            "tiles_worst": agreement.worst,
        });
        Ok((entry, seconds))
    }
}

/// The FNV-1a hash (Fowler, Noll and Vo).
fn fnv(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |h, &b| (h ^ u64::from(b)).wrapping_mul(0x0100_0000_01b3))
}

/// The folder of results.
pub fn results() -> PathBuf {
    folder().join("results")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn wishes() {
        let parse = |text: &str| Wish::parse(&text.split_whitespace().collect::<Vec<_>>());
        let all = parse("").unwrap();
        assert_eq!((all.scenes.len(), all.seeds, all.peers), (scenes::NAMES.len(), 16, false));
        let some = parse("--scene gap --scene fog --quick --target 1e-2 --size 64").unwrap();
        assert_eq!((some.scenes.len(), some.seeds, some.target, some.size), (2, 3, 1e-2, 64));
        for wrong in ["--scene", "--scene other", "--seeds 1", "--target x", "--size 0", "cornell"] {
            assert!(parse(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn hashes_are_the_published_ones() {
        assert_eq!(fnv(b"a"), 0xaf63_dc4c_8601_ec8c);
    }
}
