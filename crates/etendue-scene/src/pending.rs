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
pub enum ToneCurve {
    None,
    Reinhard,
}
impl ToneCurve {
    pub const ALL: [Self; 2] = [Self::None, Self::Reinhard];
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "srgb",
            Self::Reinhard => "reinhard",
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

pub mod camera {
    use etendue::math::DVec3;
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum FovAxis {
        X,
        Y,
    }
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub enum Projection {
        Perspective { fov: f64, axis: FovAxis, lens_radius: f64, focus_distance: f64 },
        Orthographic { height: f64 },
    }
    #[derive(Clone, Copy, Debug, PartialEq)]
    pub struct CameraSettings {
        pub position: DVec3,
        pub direction: DVec3,
        pub up: DVec3,
        pub projection: Projection,
    }
}
#[derive(Clone, Debug)]
pub struct FilmSettings {
    pub resolution: [u32; 2],
    pub crop: Option<[u32; 4]>,
    pub aovs: Vec<Aov>,
}
pub mod mesh_file {
    use crate::*;
    use etendue::{material::Material, scene::Mesh};
    #[derive(Clone, Debug)]
    pub struct MeshFile {
        pub mesh: Mesh,
        pub materials: Vec<NamedMaterial>,
        pub notes: Diagnostics,
    }
    #[derive(Clone, Debug)]
    pub struct NamedMaterial {
        pub name: String,
        pub material: Material,
        pub origin: Option<Origin>,
    }
    pub enum MeshFormat {
        Obj,
        Ply,
    }
    impl MeshFormat {
        pub const ALL: [(MeshFormat, &'static str); 2] = [(MeshFormat::Obj, "obj"), (MeshFormat::Ply, "ply")];
        pub fn of_path(path: &std::path::Path) -> Option<Self> {
            match path.extension()?.to_str()? {
                "obj" => Some(Self::Obj),
                "ply" => Some(Self::Ply),
                _ => None,
            }
        }
    }
    pub struct MeshLimits {
        pub file: u64,
        pub library: u64,
    }
    pub fn read(_: &mut SourceMap, _: FileId, _: &MeshLimits) -> Result<MeshFile, Diagnostics> {
        Err(Diagnostics::new())
    }
}
