//! Arguments of `etendue animate`.

use super::{RenderArgs, finite_in};
use clap::{Args, value_parser};
use etendue_scene::animation::FrameRate;
use std::path::PathBuf;

/// Largest number of a frame.
pub const MAX_FRAME: u32 = 1_000_000_000;

/// What `--output` takes here.
pub const OUTPUT: &str = "\
Film to write, .mp4, .gif, .png (animated), .y4m, or - for Y4M on standard output; or numbered pictures, frame.%04d.png, .exr, .hdr \
or .pfm; repeat for several [default: NAME.mp4 in the working directory]";

const EXAMPLES: &str = "\
Examples:
  etendue animate moving.toml -o film.mp4
  etendue animate moving.toml -o frame.%04d.exr --frames 0-9 --spp 256
  etendue animate moving.toml -o film.gif --fps 12.5 --size 480x270
  etendue animate moving.toml -o frame.%04d.png --shutter 0,0.5 --resume
  etendue animate moving.toml -o - --quiet | ffmpeg -i - film.mkv
  etendue animate bunny.obj --turntable -o bunny.mp4
  etendue animate moving.toml -o film.mp4 --json | jq -r .film_hash

Frame k, counted from 0, shows the scene at start + k * speed / fps seconds. A frame depends on
what a picture depends on and on its time, never on the frames before it: rendered alone it is
the same, bit for bit. Options given here replace what [animation] in the scene file says.

Frames of a film are kept in FILM.frames until the film is whole. Ctrl-C stops after the tiles
in work; the same command with --resume goes on with the frames that are not there yet.";

/// Arguments of `etendue animate`.
#[derive(Debug, Args)]
#[command(before_help = EXAMPLES, allow_negative_numbers = true)]
pub struct AnimateArgs {
    /// Frames of a second of film: 25, 29.97, 30000/1001 [default: what the scene says, else 25]
    #[arg(long, value_name = "FPS", value_parser = str::parse::<FrameRate>, help_heading = "Time")]
    pub fps: Option<FrameRate>,

    /// Frames to render: A-B (both included), A- for all from A, or one [default: all]
    #[arg(long, value_name = "A-B", value_parser = parse_frames, help_heading = "Time")]
    pub frames: Option<FrameRange>,

    /// Scene seconds of a second of film [default: what the scene says, else 1]
    #[arg(long, value_name = "X", value_parser = parse_speed, help_heading = "Time")]
    pub speed: Option<f64>,

    /// Scene time of frame 0, seconds
    #[arg(long, value_name = "S", value_parser = parse_start, help_heading = "Time")]
    pub start: Option<f64>,

    /// Opening and closing of the shutter, fractions of the time from frame to frame: 0,0.5; 0,0 is no motion blur
    #[arg(long, value_name = "A,B", value_parser = parse_shutter, help_heading = "Time")]
    pub shutter: Option<[f64; 2]>,

    /// The same noise in all frames instead of another in each
    #[arg(long, help_heading = "Time")]
    pub fixed_noise: bool,

    /// Take poses from this file (.json, .npy) instead of what the scene names or simulates
    #[arg(long, value_name = "FILE", help_heading = "Time")]
    pub keyframes: Option<PathBuf>,

    /// Turn a model without a scene file round once, in this many frames [default: 100]
    #[arg(
        long, value_name = "FRAMES", help_heading = "Time", num_args = 0..=1, require_equals = true,
        default_missing_value = "100", value_parser = value_parser!(u32).range(1..=i64::from(MAX_FRAME)),
    )]
    pub turntable: Option<u32>,

    /// Quality of .mp4 files, from 0 (small) to 100 (good)
    #[arg(long, value_name = "Q", default_value_t = 75, value_parser = value_parser!(u8).range(0..=100))]
    pub quality: u8,

    /// Leave out frames that are there already and were made by the same command
    #[arg(long)]
    pub resume: bool,

    /// All options of `etendue render`.
    #[command(flatten)]
    pub render: RenderArgs,
}

/// Frames from the first to the last, both included.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameRange {
    /// The first.
    pub first: u32,
    /// The last; absent: that of the animation.
    pub last: Option<u32>,
}

fn parse_frames(text: &str) -> Result<FrameRange, String> {
    let number = |text: &str| text.trim().parse().ok().filter(|n| *n <= MAX_FRAME);
    let range = match text.split_once('-') {
        None => number(text).map(|only| FrameRange { first: only, last: Some(only) }),
        Some((first, "")) => number(first).map(|first| FrameRange { first, last: None }),
        Some((first, last)) => {
            number(first).zip(number(last)).map(|(first, last)| FrameRange { first, last: Some(last) })
        }
    };
    range.filter(|range| range.last.is_none_or(|last| range.first <= last)).ok_or_else(|| {
        format!("expected A-B with A <= B, A-, or a single frame, such as 0-99, 50- or 12; at most {MAX_FRAME}")
    })
}

fn parse_speed(text: &str) -> Result<f64, String> {
    finite_in(text, 1e-9, 1e6)
}

fn parse_start(text: &str) -> Result<f64, String> {
    finite_in(text, -1e9, 1e9)
}

fn parse_shutter(text: &str) -> Result<[f64; 2], String> {
    let numbers = text.split_once(',').and_then(|(a, b)| Some([a.trim().parse().ok()?, b.trim().parse().ok()?]));
    match numbers {
        Some([open, close]) if (-1.0..=1.0).contains(&open) && (open..=1.0).contains(&close) => Ok([open, close]),
        _ => Err("expected OPEN,CLOSE from -1 to 1 with OPEN <= CLOSE, such as 0,0.5".to_owned()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_of_frames() {
        let range = |first, last| Ok(FrameRange { first, last });
        assert_eq!(parse_frames("0-99"), range(0, Some(99)));
        assert_eq!(parse_frames("7"), range(7, Some(7)));
        assert_eq!(parse_frames("7-"), range(7, None));
        assert_eq!(parse_frames("1000000000"), range(1_000_000_000, Some(1_000_000_000)));
        for bad in ["", "-", "5-3", "-3", "a-b", "1-2-3", "1000000001", "99999999999999999999", "1.5", "0:9"] {
            assert!(parse_frames(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn shutters() {
        assert_eq!(parse_shutter("0,0.5"), Ok([0.0, 0.5]));
        assert_eq!(parse_shutter("-0.25, 0.25"), Ok([-0.25, 0.25]));
        for bad in ["", "0.5", "0.5,0", "0,2", "nan,1", "0,nan", "0,1,2"] {
            assert!(parse_shutter(bad).is_err(), "{bad}");
        }
    }
}
