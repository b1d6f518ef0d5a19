//! What can go wrong.

/// Why a mesh is not simplified.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum SimplifyError {
    /// A face names a vertex that is not there.
    #[error("face {face} names vertex {vertex}, but there are {vertices}")]
    BadIndex {
        /// Index of the face.
        face: usize,
        /// What it names.
        vertex: u32,
        /// How many there are.
        vertices: usize,
    },
    /// An array of vertices or faces has another length than it must.
    #[error("{what}: {found} entries, expected {expected}")]
    BadLength {
        /// The array.
        what: &'static str,
        /// Its length.
        found: usize,
        /// What it must be.
        expected: usize,
    },
    /// An option is out of its range.
    #[error("{option}: {found} is not {expected}")]
    BadOption {
        /// The option.
        option: &'static str,
        /// Its value.
        found: f64,
        /// Its range.
        expected: &'static str,
    },
    /// More vertices or faces than 32 bits count.
    #[error("too many {what}: {found}")]
    TooLarge {
        /// Of what.
        what: &'static str,
        /// How many.
        found: usize,
    },
    /// A mesh whose distance is asked for has no face with finite corners.
    #[error("there is no surface to measure")]
    NoSurface,
    /// Closest points of a mesh cannot be searched.
    #[error("closest points: {0}")]
    Search(#[from] etendue_accel::BuildError),
    /// The callback asked to stop.
    #[error("interrupted")]
    Interrupted,
}
