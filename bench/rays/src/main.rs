//! Etendue's accelerator beside Embree's on the same rays: `cargo xtask bench rays`, `bench build`.

#![deny(unsafe_code)]

#[expect(unsafe_code, reason = "calls a library of C to measure it; users never run this")]
mod embree;
mod mesh;
mod rays;
mod report;
mod statistics;
mod trace;
mod turns;

use clap::{Parser, ValueEnum};
use etendue_accel::{Accelerator, AcceleratorKind, Isa};
use std::path::PathBuf;
use std::process::ExitCode;

use embree::{Embree, Quality};
use mesh::Mesh;
use rays::{Maker, Set};
use report::Report;
use trace::Pair;
use turns::{Clock, Contender, timed};

/// What is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum What {
    /// Sets of rays through two meshes.
    Rays,
    /// Building, and memory.
    Build,
    /// The cost of a ray by the number of faces.
    Scaling,
}

#[derive(Parser)]
#[command(about = "Rays, build and memory of Etendue's accelerator beside Embree's")]
struct Options {
    what: What,
    /// Embree's library
    #[arg(long)]
    embree: PathBuf,
    /// A dragon in ASCII PLY
    #[arg(long)]
    dragon: Option<PathBuf>,
    /// Where to write the results as JSON
    #[arg(long)]
    json: Option<PathBuf>,
    /// Turns that count
    #[arg(long, default_value_t = 9)]
    turns: usize,
    /// Rays of a set
    #[arg(long, default_value_t = 1_000_000)]
    rays: usize,
    /// Numbers of threads
    #[arg(long, value_delimiter = ',', default_value = "1,2")]
    threads: Vec<usize>,
    /// Only the sets whose names contain one of these
    #[arg(long, value_delimiter = ',')]
    sets: Vec<String>,
    /// Only the meshes whose names contain one of these
    #[arg(long, value_delimiter = ',')]
    meshes: Vec<String>,
    /// Only the contenders whose names contain one of these
    #[arg(long, value_delimiter = ',')]
    contenders: Vec<String>,
    /// Also slices of other sizes
    #[arg(long)]
    slices: bool,
    /// Also Embree's tree with spatial splits
    #[arg(long)]
    high: bool,
    /// What time is
    #[arg(long, value_enum, default_value = "wall")]
    clock: Clock,
    /// Accelerator of ours
    #[arg(long, default_value = "bvh")]
    accel: AcceleratorKind,
    /// Instruction set of ours
    #[arg(long)]
    isa: Option<Isa>,
    /// Fails if the lower end of any judged ratio is below its target times this
    #[arg(long)]
    fail_below: Option<f64>,
}

fn main() -> ExitCode {
    let options = Options::parse();
    match run(&options) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(message) => {
            eprintln!("error: {message}");
            ExitCode::from(2)
        }
    }
}

/// False if a ratio is below what is asked for.
fn run(options: &Options) -> Result<bool, String> {
    if options.turns == 0 || options.rays == 0 || options.threads.contains(&0) {
        return Err("turns, rays and threads are at least 1".to_owned());
    }
    let mut report = Report::default();
    match options.what {
        What::Rays => measure_rays(options, &mut report)?,
        What::Build => measure_build(options, &mut report)?,
        What::Scaling => measure_scaling(options, &mut report)?,
    }
    if let Some(path) = &options.json {
        let text = serde_json::to_string_pretty(&report.json()).map_err(|e| e.to_string())?;
        std::fs::write(path, text + "\n").map_err(|e| format!("{}: {e}", path.display()))?;
    }
    Ok(options.fail_below.is_none_or(|factor| report.passes(factor)))
}

impl Options {
    fn isa(&self) -> Isa {
        self.isa.unwrap_or_else(Isa::detect)
    }

    /// The dragon, if there is a file, and a knot of 7,000 faces.
    fn meshes(&self) -> Result<Vec<Mesh>, String> {
        let mut meshes = Vec::new();
        if let Some(path) = &self.dragon {
            meshes.push(Mesh::read_ply("dragon", path)?);
        }
        meshes.push(Mesh::knot(140, 25));
        meshes.retain(|mesh| wanted(&self.meshes, &mesh.name));
        Ok(meshes)
    }

    fn accelerator(&self, mesh: &Mesh, threads: usize) -> Result<Accelerator, String> {
        Accelerator::build(&mesh.world(), self.accel, self.isa(), threads).map_err(|e| e.to_string())
    }
}

fn wanted(names: &[String], name: &str) -> bool {
    names.is_empty() || names.iter().any(|wanted| name.contains(wanted.as_str()))
}

fn measure_rays(options: &Options, report: &mut Report) -> Result<(), String> {
    let library = Embree::load(&options.embree, 2)?;
    for mesh in options.meshes()? {
        let ours = options.accelerator(&mesh, 0)?;
        let theirs = library.scene(&mesh, Quality::Medium)?;
        let high = if options.high { Some(library.scene(&mesh, Quality::High)?) } else { None };
        let pair = Pair { ours: &ours, embree: &theirs };
        for set in Set::ALL.into_iter().filter(|set| wanted(&options.sets, set.name())) {
            let rays = Maker::new(&mesh, &ours, options.rays).make(set);
            let agreement =
                if set.is_any() { trace::any_agreement(pair, &rays) } else { trace::agreement(pair, &rays) };
            report.set(&mesh, set.name(), rays.len(), agreement);
            for &threads in &options.threads {
                let contenders = |pair, slices| {
                    if set.is_any() {
                        trace::any(pair, &rays, options.clock, threads, slices)
                    } else {
                        trace::closest(pair, &rays, set == Set::Camera, options.clock, threads, slices)
                    }
                };
                let mut all = contenders(pair, options.slices);
                if let Some(high) = &high {
                    let others = contenders(Pair { embree: high, ..pair }, false);
                    all.extend(
                        others
                            .into_iter()
                            .filter(|c| trace::EMBREE.contains(&c.name.as_str()))
                            .map(|c| Contender { name: format!("{}, high quality", c.name), run: c.run }),
                    );
                }
                all.retain(|contender| wanted(&options.contenders, &contender.name));
                let seconds = turns::take(&all, options.turns);
                let names: Vec<String> = all.iter().map(|c| c.name.clone()).collect();
                report.rays(&mesh, set, threads, rays.len(), &names, &seconds);
            }
        }
    }
    Ok(())
}

fn measure_build(options: &Options, report: &mut Report) -> Result<(), String> {
    let meshes = options.meshes()?;
    for &threads in &options.threads {
        let library = Embree::load(&options.embree, threads)?;
        for mesh in &meshes {
            let bytes = options.accelerator(mesh, threads)?.stats().bytes as f64;
            let ours = || timed(options.clock, || options.accelerator(mesh, threads).map(drop)).0;
            let mut contenders = vec![Contender::new("etendue", ours)];
            let mut memory = vec![bytes];
            for quality in Quality::ALL {
                memory.push(library.scene(mesh, quality)?.bytes as f64);
                let library = &library;
                contenders.push(Contender::new(format!("embree {}", quality.name()), move || {
                    timed(options.clock, || library.scene(mesh, quality).map(drop)).0
                }));
            }
            let measured = contenders.into_iter().zip(memory);
            let (contenders, memory): (Vec<Contender<'_>>, Vec<f64>) =
                measured.filter(|(contender, _)| wanted(&options.contenders, &contender.name)).unzip();
            let seconds = turns::take(&contenders, options.turns);
            let names: Vec<String> = contenders.iter().map(|c| c.name.clone()).collect();
            report.build(mesh, threads, &names, &seconds, &memory);
        }
    }
    Ok(())
}

fn measure_scaling(options: &Options, report: &mut Report) -> Result<(), String> {
    let library = Embree::load(&options.embree, 2)?;
    for (along, around) in [(200, 25), (560, 90), (1250, 400), (5000, 1000)] {
        let mesh = Mesh::knot(along, around);
        let ours = options.accelerator(&mesh, 0)?;
        let theirs = library.scene(&mesh, Quality::Medium)?;
        let pair = Pair { ours: &ours, embree: &theirs };
        let set = Set::Shuffled;
        let rays = Maker::new(&mesh, &ours, options.rays).make(set);
        report.set(&mesh, set.name(), rays.len(), trace::agreement(pair, &rays));
        let threads = options.threads[0];
        let all = trace::closest(pair, &rays, false, options.clock, threads, false);
        let seconds = turns::take(&all, options.turns);
        let names: Vec<String> = all.iter().map(|c| c.name.clone()).collect();
        report.rays(&mesh, set, threads, rays.len(), &names, &seconds);
    }
    report.growth();
    Ok(())
}
