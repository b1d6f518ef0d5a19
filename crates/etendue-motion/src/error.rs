//! What can go wrong between a scene and its motion.

use etendue_scene::Origin;

/// Why a simulation has no result.
#[derive(Debug, thiserror::Error)]
pub enum MotionError {
    /// No object is dynamic.
    #[error("no object has a dynamic body")]
    NoBodies,
    /// The result would be too large.
    #[error("{bodies} bodies over {steps} steps are more than {limit} poses")]
    TooLarge {
        /// Bodies that are recorded.
        bodies: usize,
        /// Steps that are recorded.
        steps: usize,
        /// [`MAX_POSES`](crate::MAX_POSES).
        limit: usize,
    },
    /// A body has no size, no mass, or a shape of which nothing that collides can be made.
    #[error("the body of `{name}` {what}")]
    Body {
        /// The object.
        name: String,
        /// What is wrong with it.
        what: String,
        /// Where it is described.
        origin: Origin,
    },
    /// A body has left the numbers.
    #[error("the body of `{name}` flew apart after {time} s of the simulation")]
    Exploded {
        /// The object.
        name: String,
        /// Seconds from where the simulation began.
        time: f64,
        /// Where it is described.
        origin: Origin,
    },
    /// The caller wanted no more.
    #[error("the simulation was stopped")]
    Stopped,
}

impl MotionError {
    /// What may be done about it.
    pub fn hint(&self) -> Option<&'static str> {
        match self {
            Self::NoBodies => Some("give an object `body = \"dynamic\"`"),
            Self::TooLarge { .. } => Some("make `step` longer or `duration` shorter, or let fewer bodies be dynamic"),
            Self::Body { .. } => Some("choose another `shape` for the body, or give it a `mass`"),
            Self::Exploded { .. } => Some(
                "bodies that start inside of each other, very different masses, stiff motors and large speeds need a smaller \
                 `step` or more `substeps`",
            ),
            Self::Stopped => None,
        }
    }

    /// Where the trouble is described, if that is one place.
    pub fn origin(&self) -> Option<&Origin> {
        match self {
            Self::Body { origin, .. } | Self::Exploded { origin, .. } => Some(origin),
            Self::NoBodies | Self::TooLarge { .. } | Self::Stopped => None,
        }
    }
}
