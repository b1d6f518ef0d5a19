//! What to simplify to, and how.

/// When to stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Target {
    /// At most so many faces.
    Faces(usize),
    /// At most this fraction of the input's faces, in (0, 1].
    Ratio(f64),
    /// The fewest faces, to within some two in a hundred, whose two-sided distance to the input is at most this, in the unit of
    /// positions, as [`crate::distance`] measures it with all vertices and 200,000 samples each way (and 2^-40 of the diagonal
    /// for rounding).
    Error(f64),
}

/// What a collapse costs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Method {
    /// Quadrics that vertices accumulate (Garland and Heckbert 1997).
    #[default]
    Quadric,
    /// Quadrics of the faces that are at both ends now, each counted once.
    QuadricUnion,
    /// The length of the edge; collapses to its middle.
    ShortestEdge,
}

/// Where a collapsed edge's vertex goes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Placement {
    /// Where the probabilistic quadric is least (Trettner and Kobbelt 2020). `sigma`: standard deviation of positions over the
    /// local edge length.
    Probabilistic {
        /// Over the local edge length.
        sigma: f64,
    },
    /// Where the quadric of randomly perturbed vertices is least.
    Perturbed,
    /// The end that costs less.
    Endpoint,
    /// The middle.
    Midpoint,
    /// What suits the method: probabilistic for quadrics, the middle for the shortest edge.
    #[default]
    Auto,
}

/// Which attributes are kept, where the input has them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Keep {
    /// Texture coordinates.
    pub uvs: bool,
    /// Normals.
    pub normals: bool,
    /// Colours.
    pub colors: bool,
    /// Materials of faces, with their borders.
    pub materials: bool,
}

impl Default for Keep {
    fn default() -> Self {
        Self { uvs: true, normals: true, colors: true, materials: true }
    }
}

/// How to simplify.
#[derive(Clone, Debug, PartialEq)]
pub struct Options {
    /// When to stop.
    pub target: Target,
    /// What a collapse costs.
    pub method: Method,
    /// Where vertices go.
    pub placement: Placement,
    /// True if vertices of open edges stay where they are.
    pub keep_boundary: bool,
    /// True if handles and tunnels stay. Otherwise those that are in the way of a collapse are cut and closed, which leaves the
    /// surface as closed as it was.
    pub keep_topology: bool,
    /// Radians, in (0, pi]: sharper edges are creases, which are kept.
    pub crease_angle: f64,
    /// What is kept.
    pub keep: Keep,
    /// Indices of vertices that stay, in any order. Those that are not there, and those that no face uses, lock nothing.
    pub locked: Vec<u32>,
    /// Less care, more speed.
    pub fast: bool,
    /// True if vertices are moved towards the input's surface at the end.
    pub polish: bool,
    /// For what is random.
    pub seed: u64,
}

impl Options {
    /// The defaults, down to `target`.
    pub fn new(target: Target) -> Self {
        Self {
            target,
            method: Method::default(),
            placement: Placement::default(),
            keep_boundary: false,
            keep_topology: false,
            crease_angle: 40f64.to_radians(),
            keep: Keep::default(),
            locked: Vec::new(),
            fast: false,
            polish: true,
            seed: 0,
        }
    }
}

/// What is being done.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Topology and quadrics.
    Prepare,
    /// Collapses.
    Collapse,
    /// Vertices towards the input's surface.
    Polish,
    /// Distances.
    Measure,
}

/// How far it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Progress {
    /// What is being done.
    pub stage: Stage,
    /// In \[0, 1\], of the stage.
    pub done: f32,
}
