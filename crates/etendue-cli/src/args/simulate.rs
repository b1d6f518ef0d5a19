//! Arguments of `etendue simulate`.

use clap::Args;
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  etendue simulate marbles.toml -o marbles.json
  etendue simulate marbles.toml -o marbles.json --duration 4 --step 0.001
  etendue simulate marbles.toml -o marbles.json --quiet --json | jq .hash

Objects with a `body` fall, collide, bounce and roll as `[physics]` of the scene file says. The poses of those
that are dynamic are written for every step, as JSON that `motion` of `[animation]` reads back. The same scene
gives the same file, byte for byte, on every machine. Ctrl-C leaves the output as it was.";

/// Arguments of `etendue simulate`.
#[derive(Debug, Args)]
#[command(before_help = EXAMPLES, allow_negative_numbers = true)]
pub struct SimulateArgs {
    /// Scene file (.toml)
    pub input: PathBuf,

    /// File to write, .json
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,

    /// Seconds to simulate [default: the scene's, or 10]
    #[arg(long, value_name = "S", value_parser = parse_duration)]
    pub duration: Option<f64>,

    /// Seconds from one pose to the next [default: the scene's, or 1/480]
    #[arg(long, value_name = "S", value_parser = parse_step)]
    pub step: Option<f64>,

    /// Print one JSON object on standard output at the end
    #[arg(long)]
    pub json: bool,

    /// No progress and no messages but warnings and errors
    #[arg(long)]
    pub quiet: bool,
}

fn parse_duration(text: &str) -> Result<f64, String> {
    super::finite_in(text, 0.0, 1e6)
}

fn parse_step(text: &str) -> Result<f64, String> {
    let step = text.parse().ok().filter(|step| (1e-6..=1.0).contains(step));
    step.ok_or_else(|| "expected seconds from 0.000001 to 1".to_owned())
}
