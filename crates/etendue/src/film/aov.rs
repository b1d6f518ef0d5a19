//! The layers that a picture may have beside its colour.

use std::{fmt, str::FromStr};

/// An extra layer of the image. Those of the surface are of the first one that a camera ray meets and does not pass through.
///
/// Albedo, normal, direct and indirect light and alpha are filtered as the colour is, so that they fade at silhouettes as
/// it does. Depth, position and texture coordinates have no value where nothing is: they are plain means over the samples
/// that met a surface, and 0 where none did.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Aov {
    /// Directional albedo of the material: `Albedo.R`, `.G`, `.B`.
    Albedo,
    /// Shading normal in world space: `N.X`, `.Y`, `.Z`.
    Normal,
    /// Distance along the camera's axis, metres: `Depth.Z`.
    Depth,
    /// Position in world space, metres: `P.X`, `.Y`, `.Z`.
    Position,
    /// Texture coordinates: `UV.U`, `UV.V`.
    Uv,
    /// Light on paths of at most two edges, the camera segment included: emission that is seen, and light scattered
    /// once: `Direct.R`, `.G`, `.B`.
    Direct,
    /// All other light; with `Direct` it adds up to the colour: `Indirect.R`, `.G`, `.B`.
    Indirect,
    /// Fraction of the samples that met a surface, also where the sky is in the picture: `Alpha.A`.
    Alpha,
    /// Object and material of the pixel's first sample, counted from 1, 0 for none; never filtered: `Id.Object`,
    /// `Id.Material`.
    Ids,
    /// Number of samples: `Samples`.
    Samples,
    /// Estimated variance of the pixel's mean: `Variance.R`, `.G`, `.B`.
    Variance,
}

impl Aov {
    /// Every layer.
    pub const ALL: [Self; 11] = [
        Self::Albedo,
        Self::Normal,
        Self::Depth,
        Self::Position,
        Self::Uv,
        Self::Direct,
        Self::Indirect,
        Self::Alpha,
        Self::Ids,
        Self::Samples,
        Self::Variance,
    ];

    /// The name it has in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Position => "position",
            Self::Uv => "uv",
            Self::Direct => "direct",
            Self::Indirect => "indirect",
            Self::Alpha => "alpha",
            Self::Ids => "ids",
            Self::Samples => "samples",
            Self::Variance => "variance",
        }
    }

    /// The channels that it has in an image.
    pub fn channels(self) -> &'static [&'static str] {
        match self {
            Self::Albedo => &["Albedo.R", "Albedo.G", "Albedo.B"],
            Self::Normal => &["N.X", "N.Y", "N.Z"],
            Self::Depth => &["Depth.Z"],
            Self::Position => &["P.X", "P.Y", "P.Z"],
            Self::Uv => &["UV.U", "UV.V"],
            Self::Direct => &["Direct.R", "Direct.G", "Direct.B"],
            Self::Indirect => &["Indirect.R", "Indirect.G", "Indirect.B"],
            Self::Alpha => &["Alpha.A"],
            Self::Ids => &["Id.Object", "Id.Material"],
            Self::Samples => &["Samples"],
            Self::Variance => &["Variance.R", "Variance.G", "Variance.B"],
        }
    }
}

impl fmt::Display for Aov {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of the known ones.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown {kind} `{name}`; expected one of {expected}")]
pub struct UnknownName {
    /// What was looked for.
    pub kind: &'static str,
    /// What was given.
    pub name: String,
    /// The known names.
    pub expected: String,
}

impl FromStr for Aov {
    type Err = UnknownName;
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL.into_iter().find(|a| a.name() == name).ok_or_else(|| UnknownName {
            kind: "layer",
            name: name.to_owned(),
            expected: Self::ALL.map(Self::name).join(", "),
        })
    }
}
