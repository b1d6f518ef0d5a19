//! Stand-ins until the core has them.
#![allow(missing_docs)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    Box { radius: f32 },
    Gaussian { sigma: f32, radius: f32 },
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aov {
    Albedo,
    Normal,
    Depth,
    Ids,
    Variance,
}
impl Aov {
    pub const ALL: [Self; 5] = [Self::Albedo, Self::Normal, Self::Depth, Self::Ids, Self::Variance];
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Ids => "ids",
            Self::Variance => "variance",
        }
    }
}
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Integrator {
    Path,
    LightSplit,
    Brute,
    Normal,
    Uv,
    Depth,
    Ids,
    Ao { distance: Option<f32> },
}
impl Integrator {
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
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KdTreeSplit {
    SurfaceArea,
    Midpoint,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AcceleratorKind {
    Brute,
    KdTree(KdTreeSplit),
    Bvh,
}
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Tonemap {
    Srgb,
    Linear,
}
impl Tonemap {
    pub const ALL: [Self; 2] = [Self::Srgb, Self::Linear];
    pub fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::Linear => "linear",
        }
    }
}
pub mod metals {
    use etendue::spectrum::Spectrum;
    pub struct Metal {
        pub name: &'static str,
        pub eta: Spectrum,
        pub k: Spectrum,
    }
    pub static METALS: [Metal; 1] =
        [Metal { name: "gold", eta: Spectrum([0.143, 0.375, 1.442]), k: Spectrum([3.983, 2.386, 1.603]) }];
    pub fn find(name: &str) -> Option<&'static Metal> {
        METALS.iter().find(|m| m.name == name)
    }
    pub fn names() -> impl Iterator<Item = &'static str> {
        METALS.iter().map(|m| m.name)
    }
}
