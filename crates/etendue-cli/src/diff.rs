//! `etendue diff`: how far a picture is from a reference.

use crate::{
    args::DiffArgs,
    exit::{Exit, Failure},
    report, software,
};
use etendue::image::Image;
use etendue_scene::{
    image_file::{Limits, Range, read_image, read_image_and_range},
    output::{
        Format, Metadata, atomic, heat,
        metric::{Comparison, Metric, compare},
        png,
    },
};
use serde::Serialize;
use std::path::Path;

/// Compares two pictures as the arguments say.
pub fn run(args: &DiffArgs) -> Result<Exit, Failure> {
    if let Some(path) = &args.output {
        if Format::of_path(path)? != Format::Png {
            return Err(Failure::new(Exit::Usage, format!("`{}`: a heat map is a .png file", path.display())));
        }
        atomic::check_writable(path)?;
    }
    let limits = Limits::default();
    let a = read_image(&args.a, &limits)?;
    let (b, range) = read_image_and_range(&args.b, &limits)?;
    let metric = match (args.metric, range) {
        (Metric::Flip, Range::Any) => Metric::HdrFlip,
        (metric, _) => metric,
    };
    let comparison = compare(&a, &b, metric)?;
    let scale = heat::scale(&comparison, metric);
    if let Some(path) = &args.output {
        write_heat_map(path, &a, &comparison, metric, scale)?;
    }
    // A pixel that cannot be compared is no match.
    let failed = args.fail_above.is_some_and(|limit| comparison.mean > limit || comparison.nonfinite > 0);
    let outcome = Outcome::new(args, metric, &a, &comparison, scale, failed);
    report::result(&if args.json { outcome.json() } else { outcome.text() })?;
    Ok(if failed { Exit::Incomplete } else { Exit::Done })
}

fn write_heat_map(path: &Path, a: &Image, comparison: &Comparison, metric: Metric, scale: f64) -> Result<(), Failure> {
    let bytes = heat::heat_map(comparison, metric, scale);
    let metadata = Metadata { software: software(), ..Metadata::default() }.with("metric", metric).with("scale", scale);
    Ok(atomic::write(path, |file| png::write_rgb8(file, [a.width, a.height], &bytes, &metadata))?)
}

/// What is printed.
#[derive(Serialize)]
struct Outcome<'a> {
    a: String,
    b: String,
    width: u32,
    height: u32,
    channels: &'a [String],
    #[serde(serialize_with = "name")]
    metric: Metric,
    /// Mean over pixels and channels.
    value: f64,
    max: f64,
    max_at: [u32; 2],
    /// Pixels left out because a value is not finite.
    nonfinite: u64,
    first_nonfinite: Option<[u32; 2]>,
    fail_above: Option<f64>,
    failed: bool,
    heat_map: Option<String>,
    /// What the bright end of the heat map stands for.
    heat_scale: f64,
}

fn name<S: serde::Serializer>(metric: &Metric, serializer: S) -> Result<S::Ok, S::Error> {
    serializer.serialize_str(metric.name())
}

impl<'a> Outcome<'a> {
    fn new(
        args: &DiffArgs,
        metric: Metric,
        a: &Image,
        comparison: &'a Comparison,
        heat_scale: f64,
        failed: bool,
    ) -> Self {
        Self {
            a: args.a.display().to_string(),
            b: args.b.display().to_string(),
            width: a.width,
            height: a.height,
            channels: &comparison.channels,
            metric,
            value: comparison.mean,
            max: comparison.max,
            max_at: comparison.max_at,
            nonfinite: comparison.nonfinite,
            first_nonfinite: comparison.first_nonfinite,
            fail_above: args.fail_above,
            failed,
            heat_map: args.output.as_ref().map(|p| p.display().to_string()),
            heat_scale,
        }
    }

    fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }

    fn text(&self) -> String {
        let mut text = format!("{} {:e}", self.metric, self.value);
        if self.max > 0.0 {
            text += &format!(", largest {:e} at pixel {},{}", self.max, self.max_at[0], self.max_at[1]);
        }
        text += &format!(", channels {}", self.channels.join(" "));
        if let Some([x, y]) = self.first_nonfinite {
            text += &format!("\n{} pixels are not finite and left out, the first at {x},{y}", self.nonfinite);
        }
        if let Some(path) = &self.heat_map {
            let what = if self.metric.is_squared() { "root of the error" } else { "error" };
            text += &format!("\n{path}: {what}, bright end {:e}", self.heat_scale);
        }
        if let (true, Some(limit)) = (self.failed, self.fail_above) {
            text += &format!("\nfailed: the limit is {limit:e}");
        }
        text
    }
}
