//! Estimators of the radiance along camera rays.

mod attenuated;
mod circle;
mod enclosure;
mod horizon;
mod lanes;
mod paths;
mod pilot;
mod resampling;
mod shade;
mod shadow;
mod splitting;
mod starts;
mod views;
mod volume;
pub(crate) mod wave;

pub(crate) use enclosure::bodies_about;
pub(crate) use pilot::{Worthwhile, worthwhile};
pub use splitting::MAX_PARTS;
pub(crate) use splitting::Splitting;

use crate::film::UnknownName;
use std::{fmt, str::FromStr};

/// What a camera ray is turned into.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    /// Path tracing; light and BSDF sampling joined by multiple importance sampling (Veach 1997).
    Path,
    /// Path tracing with light sampling alone wherever the BSDF is not a Dirac: emission that a BSDF ray hits there counts
    /// zero, unless no light sample could have found it. The paper's direct lighting in its unbiased form.
    LightSplit,
    /// Path tracing with BSDF sampling alone. Does not see point, spot and directional lights.
    Brute,
    /// Shading normal, [-1, 1] mapped to [0, 1].
    Normal,
    /// Texture coordinates in red and green.
    Uv,
    /// Distance along the camera's axis, metres.
    Depth,
    /// A colour for each pair of object and material.
    Ids,
    /// Fraction of the cosine-weighted hemisphere that is free up to a distance.
    Ao {
        /// Metres; absent: any distance counts.
        distance: Option<f32>,
    },
}

impl Integrator {
    /// Every integrator, with default parameters.
    pub const ALL: [Self; 8] = [
        Self::Path,
        Self::LightSplit,
        Self::Brute,
        Self::Normal,
        Self::Uv,
        Self::Depth,
        Self::Ids,
        Self::Ao { distance: None },
    ];

    /// True if it solves the light's transport, and is not a view.
    pub fn is_solver(self) -> bool {
        matches!(self, Self::Path | Self::LightSplit | Self::Brute)
    }

    /// The name it has in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Path => "path",
            Self::LightSplit => "light-split",
            Self::Brute => "brute",
            Self::Normal => "normal",
            Self::Uv => "uv",
            Self::Depth => "depth",
            Self::Ids => "ids",
            Self::Ao { .. } => "ao",
        }
    }
}

impl fmt::Display for Integrator {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Integrator {
    type Err = UnknownName;
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL.into_iter().find(|i| i.name() == name).ok_or_else(|| UnknownName {
            kind: "integrator",
            name: name.to_owned(),
            expected: Self::ALL.map(Self::name).join(", "),
        })
    }
}
