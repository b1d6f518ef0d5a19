//! The command line.

mod animate;
mod display;
mod files;
mod labels;
mod model;
mod simplify;
mod simulate;
mod still;

pub use animate::{AnimateArgs, FrameRange};
use clap::{Args, Parser, Subcommand, builder::TypedValueParser, value_parser};
pub use display::DisplayArgs;
use etendue::{
    film::Aov,
    integrator::Integrator,
    render::{MAX_SPP, MAX_THREADS, MAX_TILE, MAX_WAVE},
    sampling::{Filter, Sampler},
};
use etendue_accel::{AcceleratorKind, Isa};
use etendue_scene::output::metric::Metric;
pub use files::{CompletionsArgs, ConvertArgs, InfoArgs, ManArgs};
pub use labels::{LabelArgs, LabelChoice};
pub use model::{ModelArgs, SceneArgs};
pub use simplify::SimplifyArgs;
pub use simulate::SimulateArgs;
use std::{path::PathBuf, str::FromStr};
pub use still::StillArgs;

/// Physically based Monte Carlo rendering on the CPU
#[derive(Debug, Parser)]
#[command(name = "etendue", version, before_help = EXAMPLES, arg_required_else_help = true)]
pub struct Cli {
    /// Print the JSON schema of scene files, for editors
    #[arg(long, exclusive = true)]
    pub schema: bool,

    /// What to do; absent with `--schema` alone.
    #[command(subcommand)]
    pub command: Option<Command>,
}

const EXAMPLES: &str = "\
Examples:
  etendue render bunny.obj                        a picture of a model: bunny.png and bunny.exr
  etendue render scenes/cornell-box.toml          a scene
  etendue render scene.toml -o a.exr --spp 256    one file, more samples
  etendue animate bunny.obj --turntable -o bunny.mp4   a film
  etendue scene bunny.obj -o bunny.toml           a scene of a model, to be edited
  etendue info bunny.obj                          what is in a file
  etendue convert render.exr render.png           a file into another
  etendue simplify scan.stl -o small.ply --faces 5000   fewer triangles, the same shape
  etendue simulate marbles.toml -o marbles.json   bodies that fall and collide: their motion
  etendue diff a.exr reference.exr -o heat.png    how far a is from the reference

Exit codes: 0 done, 1 usage, 2 bad input, 3 unsupported, 4 cannot write,
5 misses the mark, 130 interrupted";

/// The subcommands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Render a scene or a model into picture files
    Render(Box<StillArgs>),
    /// Render a scene that moves, or a model that turns, into numbered pictures or a film
    #[command(mut_arg("output", |arg| arg.help(animate::OUTPUT)))]
    Animate(Box<AnimateArgs>),
    /// Write the automatic scene of a model, for editing
    Scene(SceneArgs),
    /// Tell what is in a scene, a model or a picture
    Info(InfoArgs),
    /// Turn a model or a picture into another format
    Convert(ConvertArgs),
    /// Make a model of fewer triangles with the same shape
    Simplify(SimplifyArgs),
    /// Let the bodies of a scene fall and collide, and write their motion
    Simulate(SimulateArgs),
    /// Measure how far a picture is from a reference
    Diff(DiffArgs),
    /// Print the completions of a shell
    Completions(CompletionsArgs),
    /// Print the manual page
    Man(ManArgs),
}

/// Arguments of everything that renders.
#[derive(Debug, Args)]
pub struct RenderArgs {
    /// Scene file (.toml), script of the older renderer (.cfg), or a model (.obj, .ply, .stl, .off, also .gz)
    pub input: PathBuf,

    /// Picture to write, .png, .exr, .hdr or .pfm; repeat for several [default: NAME.png and NAME.exr in the working directory]
    #[arg(short, long, value_name = "FILE")]
    pub output: Vec<PathBuf>,

    /// Samples per pixel
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_SPP)))]
    pub spp: Option<u32>,

    /// Size of the whole picture in pixels
    #[arg(long, value_name = "WxH", value_parser = parse_size)]
    pub size: Option<[u32; 2]>,

    /// Picks the random numbers
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,

    /// Worker threads [default: one for each processor]
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=MAX_THREADS as i64))]
    pub threads: Option<u32>,

    /// Longest path in edges, the camera segment included; no limit by default
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..))]
    pub depth: Option<u32>,

    /// Where random numbers come from
    #[arg(long, value_name = "S", value_parser = names(&Sampler::ALL, Sampler::name))]
    pub sampler: Option<Sampler>,

    /// What is estimated, and how
    #[arg(long, value_name = "I", value_parser = names(&Integrator::ALL, Integrator::name))]
    pub integrator: Option<Integrator>,

    /// What finds the hits
    #[arg(long, value_name = "A", value_parser = names(&AcceleratorKind::ALL, AcceleratorKind::name))]
    pub accel: Option<AcceleratorKind>,

    /// Reconstruction filter
    #[arg(long, value_name = "F", value_parser = names(&Filter::ALL, Filter::name))]
    pub filter: Option<Filter>,

    /// Render this part only: left, top, right and bottom edge in pixels of the whole, right and bottom exclusive
    #[arg(long, value_name = "X0,Y0,X1,Y1", value_parser = parse_crop)]
    pub crop: Option<[u32; 4]>,

    /// How 8 bit pictures are made.
    #[command(flatten)]
    pub display: DisplayArgs,

    /// Extra layers of .exr files, separated by commas
    #[arg(long, value_name = "LIST", value_delimiter = ',', value_parser = names(&Aov::ALL, Aov::name))]
    pub aov: Option<Vec<Aov>>,

    /// What is written for data sets.
    #[command(flatten)]
    pub labels: LabelArgs,

    /// Nothing instead of the environment behind the surfaces: pictures get an alpha channel
    #[arg(long)]
    pub transparent: bool,

    /// Side of a tile in pixels
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_TILE)))]
    pub tile: Option<u32>,

    /// Paths that a worker moves together
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=i64::from(MAX_WAVE)))]
    pub wave: Option<u32>,

    /// Instruction set [default: the best that the processor has]
    #[arg(long, value_name = "NAME", value_parser = names(&Isa::ALL, Isa::name))]
    pub isa: Option<Isa>,

    /// How a model without a scene file is shown.
    #[command(flatten)]
    pub look: ModelArgs,

    /// Print one JSON object on standard output at the end
    #[arg(long)]
    pub json: bool,

    /// No progress and no messages but warnings and errors
    #[arg(long)]
    pub quiet: bool,

    /// Print a table of counts, memory and speed on standard error at the end
    #[arg(long)]
    pub stats: bool,
}

const DIFF_EXAMPLES: &str = "\
Examples:
  etendue diff a.exr reference.exr
  etendue diff a.exr reference.exr --metric mae -o heat.png
  etendue diff a.png reference.png --metric flip -o heat.png
  etendue diff a.exr reference.exr --fail-above 1e-3 --json

relmse is the mean over pixels and channels of (a-b)^2 / (b^2 + 0.01), mse of (a-b)^2, mae of
|a-b|; b is the reference. Colour is compared where both have it, otherwise the channels of
floats that both have. PNG, JPEG and other 8 and 16 bit files are decoded to linear values
first. Pixels that are not finite in either are counted, and left out of the mean.

flip is what an observer sees who flips between the two (Andersson et al. 2020), from 0 to 1,
at 67 pixels a degree; where the reference is a file of floats (.exr, .hdr, .pfm) it becomes
hdr-flip, the largest over the exposures that the reference needs (Andersson et al. 2021).";

/// Arguments of `etendue diff`.
#[derive(Debug, Args)]
#[command(before_help = DIFF_EXAMPLES, allow_negative_numbers = true)]
pub struct DiffArgs {
    /// Picture (.png, .jpg, .exr, .hdr, .pfm, .tga, .bmp, .webp)
    pub a: PathBuf,

    /// Reference
    pub b: PathBuf,

    /// How the difference is measured
    #[arg(long, value_name = "METRIC", default_value = Metric::RelMse.name(), value_parser = names(&Metric::ALL, Metric::name))]
    pub metric: Metric,

    /// Write a heat map of the error (.png)
    #[arg(short, long, value_name = "FILE")]
    pub output: Option<PathBuf>,

    /// Exit with 5 if the difference is above this, or a pixel is not finite
    #[arg(long, value_name = "X", value_parser = parse_limit)]
    pub fail_above: Option<f64>,

    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// One of a closed set by its name.
fn names<T: Copy + Send + Sync + 'static>(
    all: &'static [T],
    name: fn(T) -> &'static str,
) -> impl TypedValueParser<Value = T> {
    clap::builder::PossibleValuesParser::new(all.iter().map(|&v| name(v))).try_map(move |given| {
        all.iter().copied().find(|&v| name(v) == given).ok_or_else(|| format!("`{given}` is not known"))
    })
}

/// One of a closed set with its name beside it.
fn names_of<T: Clone + Send + Sync + 'static>(all: &'static [(&'static str, T)]) -> impl TypedValueParser<Value = T> {
    clap::builder::PossibleValuesParser::new(all.iter().map(|(name, _)| *name)).try_map(move |given| {
        let found = all.iter().find(|(name, _)| *name == given);
        found.map(|(_, value)| value.clone()).ok_or_else(|| format!("`{given}` is not known"))
    })
}

/// Side of a picture.
const MAX_SIDE: u32 = 1 << 20;

fn parse_size(text: &str) -> Result<[u32; 2], String> {
    let parsed = text.split_once(['x', 'X']).and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
    match parsed {
        Some(size) if size.iter().all(|v| (1..=MAX_SIDE).contains(v)) => Ok(size),
        _ => Err(format!("expected WxH such as 640x480, both from 1 to {MAX_SIDE}")),
    }
}

fn parse_crop(text: &str) -> Result<[u32; 4], String> {
    let numbers: Vec<Option<u32>> = text.split(',').map(|n| n.trim().parse().ok()).collect();
    match numbers[..] {
        [Some(x0), Some(y0), Some(x1), Some(y1)] if x0 < x1 && y0 < y1 => Ok([x0, y0, x1, y1]),
        _ => Err("expected X0,Y0,X1,Y1 such as 0,0,64,64 with X0 < X1 and Y0 < Y1, inside the picture".to_owned()),
    }
}

fn parse_limit(text: &str) -> Result<f64, String> {
    finite_in(text, 0.0, f64::MAX)
}

fn finite_in<T: FromStr + PartialOrd + std::fmt::Display>(text: &str, low: T, high: T) -> Result<T, String> {
    match text.parse::<T>() {
        Ok(value) if value >= low && value <= high => Ok(value),
        _ => Err(format!("expected a number from {low} to {high:.3}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::CommandFactory;

    #[test]
    fn the_definition_is_sound() {
        Cli::command().debug_assert();
    }

    #[test]
    fn values_with_a_shape_of_their_own() {
        assert_eq!(parse_size("640x480"), Ok([640, 480]));
        for bad in ["", "640", "640x", "0x1", "640x480x2", "-1x2", "1x1048577", "99999999999x1"] {
            assert!(parse_size(bad).is_err_and(|e| e.contains("1 to 1048576")), "{bad}");
        }
        assert_eq!(parse_crop("1,2,3,4"), Ok([1, 2, 3, 4]));
        for bad in ["", "1,2,3", "1,2,1,4", "1,4,3,4", "1,2,3,4,5", "-1,2,3,4", "a,b,c,d"] {
            assert!(parse_crop(bad).is_err(), "{bad}");
        }
        assert!(parse_limit("-1").is_err() && parse_limit("inf").is_err() && parse_limit("0").is_ok());
    }

    #[test]
    fn exposure_may_be_negative() {
        let cli = Cli::try_parse_from(["etendue", "render", "a.toml", "--exposure", "-2"]).unwrap();
        assert!(matches!(cli.command, Some(Command::Render(args)) if args.render.display.exposure == Some(-2.0)));
    }
}
