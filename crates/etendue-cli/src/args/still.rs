//! Arguments of `etendue render`.

use super::{RenderArgs, animate::MAX_FRAME, finite_in};
use clap::{Args, value_parser};

const RENDER_EXAMPLES: &str = "\
Examples:
  etendue render scenes/cornell-box.toml
  etendue render bunny.obj
  etendue render part.stl --up z --view front --material aluminium
  etendue render cow.obj --env sky.hdr --transparent -o cow.png
  etendue render scene.toml -o quick.png --size 320x240 --spp 16
  etendue render scene.toml -o out.exr --aov albedo,normal,depth --spp 1024 --seed 7
  etendue render scene.toml -o out.png --labels object,depth,visibility --labels-format npy
  etendue render scene.toml -o detail.exr --size 1920x1080 --crop 960,500,1060,600
  etendue render scene.toml --json --quiet | jq .film_hash
  etendue render marbles.toml -o landed.png --time 1.2

Options given here replace what the scene file says. The picture depends on the scene, --spp,
--size, --seed, --depth, --sampler, --integrator, --filter, --transparent, --frame and --time; never on --threads, --accel,
--tile, --wave or --isa. While it renders, the files are refreshed every few seconds. Ctrl-C
stops after the tiles in work and writes what there is; a second one stops at once.";

/// Arguments of `etendue render`.
#[derive(Debug, Args)]
#[command(before_help = RENDER_EXAMPLES, allow_negative_numbers = true)]
pub struct StillArgs {
    /// Render this frame, counted from 0, as `etendue animate` does, with its motion blur and noise
    #[arg(long, value_name = "K", value_parser = value_parser!(u32).range(0..=i64::from(MAX_FRAME)), help_heading = "Time")]
    pub frame: Option<u32>,

    /// Render the scene as it is at this time, seconds, with the motion blur of a frame; bodies have fallen till then
    #[arg(long, value_name = "T", value_parser = parse_time, conflicts_with = "frame", help_heading = "Time")]
    pub time: Option<f64>,

    /// All else.
    #[command(flatten)]
    pub render: RenderArgs,
}

fn parse_time(text: &str) -> Result<f64, String> {
    finite_in(text, -1e9, 1e9)
}
