//! Why a world cannot be built.

/// What is wrong with a [`crate::World`], and where.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// A face names a vertex that does not exist.
    #[error("geometry {geometry}, face {face}: vertex index {index} of {vertices} vertices")]
    Index {
        /// Index of the geometry.
        geometry: usize,
        /// Index of the face.
        face: usize,
        /// The bad index.
        index: u32,
        /// How many vertices there are.
        vertices: usize,
    },
    /// A coordinate is not finite or its magnitude is above 2^50.
    #[error("geometry {geometry}, vertex {vertex}: position {position:?} is not finite or beyond 1e15")]
    Position {
        /// Index of the geometry.
        geometry: usize,
        /// Index of the vertex.
        vertex: usize,
        /// The position.
        position: [f32; 3],
    },
    /// A centre or radius is not finite or reaches beyond 2^50, or the radius is not above 0.
    #[error("geometry {geometry}, sphere {sphere}: centre {center:?} or radius {radius} is out of range")]
    Sphere {
        /// Index of the geometry.
        geometry: usize,
        /// Index of the sphere.
        sphere: usize,
        /// Its centre.
        center: [f32; 3],
        /// Its radius.
        radius: f32,
    },
    /// An instance places a geometry that does not exist.
    #[error("instance {instance}: geometry {index} of {geometries} geometries")]
    Geometry {
        /// Index of the instance.
        instance: usize,
        /// The bad index.
        index: u32,
        /// How many geometries there are.
        geometries: usize,
    },
    /// A transform has no inverse, scales beyond 2^38, was not made by [`crate::Transform::new`], or moves its geometry
    /// beyond 2^50.
    #[error("instance {instance}: the transform {reason}")]
    Transform {
        /// Index of the instance.
        instance: usize,
        /// What is wrong.
        reason: &'static str,
    },
    /// As many places as instances are wanted.
    #[error("{places} places for {instances} instances")]
    Places {
        /// How many places there are.
        places: usize,
        /// How many instances there are.
        instances: usize,
    },
    /// More of something than its index can count.
    #[error("{count} {what}: at most {limit} are possible")]
    TooMany {
        /// What there is too much of.
        what: &'static str,
        /// How many there are.
        count: u64,
        /// How many there may be.
        limit: u64,
    },
    /// The memory for the structure is not there.
    #[error("no memory for {bytes} bytes of {what}")]
    Memory {
        /// What it is for.
        what: &'static str,
        /// How much.
        bytes: u64,
    },
    /// The threads for the build could not be started.
    #[error("cannot start {threads} threads: {reason}")]
    Threads {
        /// How many.
        threads: usize,
        /// What the system said.
        reason: String,
    },
}

/// An empty vector with room for `count`, or an error.
pub(crate) fn room<T>(what: &'static str, count: usize) -> Result<Vec<T>, BuildError> {
    let mut vector = Vec::new();
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    vector.try_reserve_exact(count).map_err(|_| BuildError::Memory { what, bytes })?;
    Ok(vector)
}

/// An index or count that must be below a limit.
pub(crate) fn limited(what: &'static str, count: usize, limit: u64) -> Result<u32, BuildError> {
    let error = BuildError::TooMany { what, count: count as u64, limit };
    u32::try_from(count).ok().filter(|&n| u64::from(n) <= limit).ok_or(error)
}
