//! What was done.

use std::fmt;

use crate::{Distance, Mesh};

/// A simplified mesh and how it came about.
#[derive(Clone, Debug, PartialEq)]
pub struct Simplified {
    /// The mesh. Its vertices are the used ones alone, in an order of its own (neighbours are near each other); so are its
    /// faces.
    pub mesh: Mesh,
    /// How it came about.
    pub report: Report,
}

/// Faces that were left out before anything else.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Dropped {
    /// With two corners at one position.
    pub degenerate: usize,
    /// The same three positions in the same sense as an earlier face.
    pub duplicate: usize,
    /// With a coordinate that is infinite or not a number.
    pub non_finite: usize,
}

/// Why the target was not reached: how many of the edges that are left each constraint refuses.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Stopped {
    /// A face would turn over or lose its area.
    pub flips: usize,
    /// The surface would be joined, torn or closed, or a part of it vanish.
    pub topology: usize,
    /// Both ends are locked, or have to stay: ends and crossings of borders, and where more than two faces meet.
    pub fixed: usize,
    /// The edge joins two borders: of the surface, of materials, or seams of attributes.
    pub borders: usize,
}

impl fmt::Display for Stopped {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let all = self.flips + self.topology + self.fixed + self.borders;
        if all == 0 {
            return f.write_str("no edges are left");
        }
        let reasons = [
            (self.flips, "would turn a face over"),
            (self.topology, "would change the topology"),
            (self.fixed, "are between vertices that stay"),
            (self.borders, "would join borders"),
        ];
        write!(f, "of {all} edges left")?;
        let mut comma = "";
        for (count, reason) in reasons.iter().filter(|(count, _)| *count > 0) {
            write!(f, "{comma} {count} {reason}")?;
            comma = ",";
        }
        Ok(())
    }
}

/// How a mesh was simplified.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Faces of the input.
    pub faces_in: usize,
    /// Faces of the result.
    pub faces_out: usize,
    /// Vertices of the input.
    pub vertices_in: usize,
    /// Vertices of the result.
    pub vertices_out: usize,
    /// Edges collapsed.
    pub collapses: usize,
    /// Handles and tunnels cut.
    pub cuts: usize,
    /// Edges whose turn came but that a constraint refused; an edge may be counted several times.
    pub refused: usize,
    /// Faces left out.
    pub dropped: Dropped,
    /// Faces that are turned over against the nearest original ones, and could not be mended.
    pub turned: usize,
    /// Why the target was not reached, if it was not.
    pub stopped: Option<Stopped>,
    /// Seconds for topology and quadrics.
    pub prepare_seconds: f64,
    /// Seconds for collapses.
    pub collapse_seconds: f64,
    /// Seconds for the polish, and for mending faces that are turned over.
    pub polish_seconds: f64,
    /// The distance to the input that was measured to reach [`crate::Target::Error`]; `None` for other targets.
    pub distance: Option<Distance>,
    /// The quadrics' estimate of the largest distance, in the unit of positions: not a bound.
    pub error_estimate: f64,
}
