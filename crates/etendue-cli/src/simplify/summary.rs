//! What `etendue simplify --json` prints.

use etendue_simplify::{Distance, OneWay, Report};
use serde::Serialize;
use std::path::Path;

/// Wall-clock time of each part, seconds.
#[derive(Clone, Copy, Debug, Default, Serialize)]
pub struct Seconds {
    /// Reading files.
    pub load: f64,
    /// Topology, quadrics and collapses.
    pub simplify: f64,
    /// Vertices towards the original.
    pub polish: f64,
    /// Distances.
    pub measure: f64,
    /// Writing at the end.
    pub write: f64,
}

/// The object.
#[derive(Debug, Serialize)]
pub struct Summary {
    /// File written.
    output: String,
    faces_in: usize,
    faces_out: usize,
    vertices_in: usize,
    vertices_out: usize,
    /// Edges collapsed.
    collapses: usize,
    /// Collapses that would have done harm.
    refused: usize,
    /// Faces of the input that were left out.
    dropped: DroppedEntry,
    /// Faces turned over against the original that could not be mended.
    turned: usize,
    /// Why the target was not reached; `null` if it was.
    stopped: Option<String>,
    seconds: Seconds,
    /// Bytes; `null` where the system does not tell.
    peak_memory: Option<u64>,
    /// `null` if it was not asked for, and where there is no surface.
    distance: Option<DistanceEntry>,
}

#[derive(Debug, Serialize)]
struct DroppedEntry {
    degenerate: usize,
    duplicate: usize,
    non_finite: usize,
}

impl Summary {
    /// All of it.
    pub fn new(
        output: &Path,
        report: &Report,
        seconds: Seconds,
        peak_memory: Option<u64>,
        distance: Option<DistanceEntry>,
    ) -> Self {
        let dropped = &report.dropped;
        Self {
            output: output.display().to_string(),
            faces_in: report.faces_in,
            faces_out: report.faces_out,
            vertices_in: report.vertices_in,
            vertices_out: report.vertices_out,
            collapses: report.collapses,
            refused: report.refused,
            dropped: DroppedEntry {
                degenerate: dropped.degenerate,
                duplicate: dropped.duplicate,
                non_finite: dropped.non_finite,
            },
            turned: report.turned,
            stopped: report.stopped.as_ref().map(ToString::to_string),
            seconds,
            peak_memory,
            distance,
        }
    }

    /// One line.
    pub fn json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

/// Measured distances.
#[derive(Debug, Serialize)]
pub struct DistanceEntry {
    /// Of the original's bounding box.
    diagonal: f64,
    /// The larger of both ways, in the model's unit.
    rms: f64,
    largest: f64,
    /// The same over the diagonal.
    relative_rms: f64,
    relative_largest: f64,
    /// From the original to the simplified model.
    forth: WayEntry,
    /// From the simplified model to the original.
    back: WayEntry,
}

/// One way.
#[derive(Debug, Serialize)]
struct WayEntry {
    rms: f64,
    mean: f64,
    largest: f64,
    relative_rms: f64,
    relative_largest: f64,
}

impl WayEntry {
    fn new(way: &OneWay, relative: impl Fn(f64) -> f64) -> Self {
        let OneWay { rms, mean, largest, .. } = *way;
        Self { rms, mean, largest, relative_rms: relative(rms), relative_largest: relative(largest) }
    }
}

impl DistanceEntry {
    /// As measured.
    pub fn new(distance: &Distance) -> Self {
        let diagonal = distance.diagonal;
        let relative = |length: f64| if diagonal > 0.0 { length / diagonal } else { 0.0 };
        let (rms, largest) = (distance.rms(), distance.largest());
        Self {
            diagonal,
            rms,
            largest,
            relative_rms: relative(rms),
            relative_largest: relative(largest),
            forth: WayEntry::new(&distance.forth, relative),
            back: WayEntry::new(&distance.back, relative),
        }
    }
}
