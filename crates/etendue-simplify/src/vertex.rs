//! What is known of a vertex while edges are collapsed.

use crate::quadric::Quadric;
use crate::vector::Vec3;

/// Where a vertex may go.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
#[repr(u8)]
pub(crate) enum Kind {
    /// Anywhere.
    Free,
    /// Along its curve: the border of the surface or of a material, or a seam of attributes.
    Curve,
    /// Nowhere.
    Fixed,
}

/// A vertex in one line of cache.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Vertex {
    pub position: Vec3,
    /// Relative to the position.
    pub quadric: Quadric,
    pub kind: Kind,
    /// True if it was merged into another.
    pub dead: bool,
    /// True if faces of other blocks are at it, so that it has to wait.
    pub held: bool,
    /// True if it was on a curve of the input at the start: an open edge, a border, a seam or a crease.
    pub has_curve: bool,
    /// Counts changes of the vertex and of all that were merged into it, so that the sum of two vertices' stamps never
    /// repeats.
    pub stamp: u32,
}

const _: () = assert!(size_of::<Vertex>() == 64);
