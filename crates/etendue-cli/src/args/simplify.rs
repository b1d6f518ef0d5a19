//! Arguments of `etendue simplify`.

use super::names_of;
use clap::{Args, value_parser};
use etendue_scene::simplify::{Goal, METHODS, PLACEMENTS};
use etendue_simplify::{Keep, Method, Placement};
use std::path::PathBuf;

const EXAMPLES: &str = "\
Examples:
  etendue simplify scan.stl -o small.ply --faces 5000
  etendue simplify cow.obj -o cow-quarter.obj --ratio 0.25
  etendue simplify scan.stl -o small.stl --max-error 0.1%
  etendue simplify scan.stl -o small.obj --faces 500 --measure 100000 --json | jq .distance.largest
  etendue simplify cow.obj -o plain.ply --ratio 0.1 --keep none --fast

Fewer triangles, the same shape. Models are read from OBJ, PLY, STL and OFF files, also gzipped, and
written as OBJ (with MTL), PLY or STL. Points of equal position are one for this, so that open edges
are only where the surface ends. The result depends on the model, the options and --seed, never on
the number of threads. Where holes, folds or faces turned over would come of going on, it stops
above the target and says why. Ctrl-C leaves the output as it was.";

/// Arguments of `etendue simplify`.
#[derive(Debug, Args)]
#[command(before_help = EXAMPLES)]
pub struct SimplifyArgs {
    /// Model (.obj, .ply, .stl, .off, also .gz)
    pub input: PathBuf,

    /// Model to write (.obj, .ply, .stl)
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,

    /// When to stop.
    #[command(flatten)]
    pub goal: GoalArgs,

    /// What decides which edge is collapsed next
    #[arg(long, value_name = "M", default_value = METHODS[0].0, value_parser = names_of(&METHODS))]
    pub method: Method,

    /// Where the vertex of a collapsed edge goes [default: probabilistic; midpoint for shortest-edge]
    #[arg(long, value_name = "P", value_parser = names_of(&PLACEMENTS))]
    pub placement: Option<Placement>,

    /// Of probabilistic placement: how far positions are from certain, from 0 to 1 times the length of edges
    #[arg(long, value_name = "X", value_parser = parse_sigma)]
    pub sigma: Option<f64>,

    /// Vertices of open edges stay where they are
    #[arg(long)]
    pub keep_boundary: bool,

    /// Keep edges that are sharper than this, degrees [default: 40]
    #[arg(long, value_name = "DEG", value_parser = parse_angle)]
    pub crease_angle: Option<f64>,

    /// What is kept besides positions: uv, normals, colors, materials, or none [default: all that is there]
    #[arg(long, value_name = "LIST", value_parser = parse_keep)]
    pub keep: Option<Keep>,

    /// Vertices that stay: a file with the index of one a line, as the model's file counts them, from 0
    #[arg(long, value_name = "FILE")]
    pub lock: Option<PathBuf>,

    /// Less care, more speed
    #[arg(long)]
    pub fast: bool,

    /// Do not move vertices towards the original surface at the end
    #[arg(long)]
    pub no_polish: bool,

    /// Exit with 5 if more triangles are left than were asked for; what there is is written all the same
    #[arg(long)]
    pub require_target: bool,

    /// Measure the distance to the original and back, from so many points and all vertices of each
    #[arg(long, value_name = "N", value_parser = value_parser!(u32).range(1..=MAX_SAMPLES))]
    pub measure: Option<u32>,

    /// Picks the random numbers, of perturbed placement and of --measure
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,

    /// Print one JSON object on standard output at the end
    #[arg(long)]
    pub json: bool,

    /// No progress and no messages but warnings and errors
    #[arg(long)]
    pub quiet: bool,
}

/// Points of `--measure`.
const MAX_SAMPLES: i64 = 1 << 30;

/// When to stop: one of these.
#[derive(Clone, Copy, Debug, Args)]
#[group(required = true, multiple = false)]
pub struct GoalArgs {
    /// At most so many triangles
    #[arg(long, value_name = "N")]
    pub faces: Option<u32>,

    /// At most this fraction of the triangles
    #[arg(long, value_name = "R", value_parser = parse_ratio)]
    pub ratio: Option<f64>,

    /// As few triangles as keep the measured distance within this, in the model's unit, or in % of its diagonal
    #[arg(long, value_name = "E", value_parser = parse_error)]
    pub max_error: Option<Goal>,
}

impl GoalArgs {
    /// The one that was given.
    pub fn goal(self) -> Goal {
        let faces = self.faces.map(|faces| Goal::Faces(faces as usize));
        faces.or(self.ratio.map(Goal::Ratio)).or(self.max_error).unwrap_or(Goal::Ratio(1.0))
    }
}

impl SimplifyArgs {
    /// `--placement` with its `--sigma`; an error if they do not go together.
    pub fn placement(&self) -> Result<Placement, &'static str> {
        match (self.placement, self.sigma) {
            (None, None) => Ok(Placement::Auto),
            (None | Some(Placement::Probabilistic { .. }), Some(sigma)) => Ok(Placement::Probabilistic { sigma }),
            (Some(_), Some(_)) => Err("--sigma is for probabilistic placement"),
            (Some(placement), None) => Ok(placement),
        }
    }
}

fn parse_ratio(text: &str) -> Result<f64, String> {
    let ratio = text.parse().ok().filter(|r| *r > 0.0 && *r <= 1.0);
    ratio.ok_or_else(|| "expected a fraction above 0 and at most 1".to_owned())
}

fn parse_error(text: &str) -> Result<Goal, String> {
    Goal::of_distance(text)
        .ok_or_else(|| "expected a distance above 0 such as 0.02, or 0.1% of the diagonal".to_owned())
}

fn parse_sigma(text: &str) -> Result<f64, String> {
    super::finite_in(text, 0.0, 1.0)
}

fn parse_angle(text: &str) -> Result<f64, String> {
    let angle = text.parse().ok().filter(|a| *a > 0.0 && *a <= 180.0);
    angle.ok_or_else(|| "expected degrees above 0 and at most 180".to_owned())
}

fn parse_keep(text: &str) -> Result<Keep, String> {
    let mut keep = Keep { uvs: false, normals: false, colors: false, materials: false };
    if text == "none" {
        return Ok(keep);
    }
    for name in text.split(',') {
        let part = match name.trim() {
            "uv" => &mut keep.uvs,
            "normals" => &mut keep.normals,
            "colors" => &mut keep.colors,
            "materials" => &mut keep.materials,
            other => return Err(format!("`{other}` is none of uv, normals, colors, materials, none")),
        };
        *part = true;
    }
    Ok(keep)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_with_a_shape_of_their_own() {
        let all = Keep::default();
        assert_eq!(parse_keep("uv,normals, colors,materials"), Ok(all));
        assert_eq!(parse_keep("none").map(|k| [k.uvs, k.normals, k.colors, k.materials]), Ok([false; 4]));
        assert_eq!(parse_keep("uv"), Ok(Keep { normals: false, colors: false, materials: false, ..all }));
        for bad in ["", "uvs", "uv,none", "uv,"] {
            assert!(parse_keep(bad).is_err_and(|e| e.contains("uv, normals")), "{bad}");
        }
        assert_eq!(parse_error("0.5"), Ok(Goal::Error(0.5)));
        assert_eq!(parse_error("2 %"), Ok(Goal::RelativeError(0.02)));
        for bad in ["", "%", "0", "-1", "nan", "inf", "1%%", "0%"] {
            assert!(parse_error(bad).is_err(), "{bad}");
        }
        assert!(["0", "-0.5", "1.01", "nan", "x"].iter().all(|bad| parse_ratio(bad).is_err()));
        assert!(["0", "181", "nan"].iter().all(|bad| parse_angle(bad).is_err()));
        assert_eq!((parse_ratio("1"), parse_angle("180")), (Ok(1.0), Ok(180.0)));
    }
}
