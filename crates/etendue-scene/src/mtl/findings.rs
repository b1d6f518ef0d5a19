//! What is approximated, ignored or wrong in a material library.

use crate::{
    Diagnostic,
    text::{
        counted,
        tally::{Fate, Finding},
    },
};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ignored {
    Unknown,
    Case,
    Ambient,
    AmbientEmits,
    AmbientMap,
    Antialiasing,
    BadIllum,
    BadIor,
    BeforeFirst,
    BlackFactor,
    Brdf,
    BumpHeight,
    Clamped,
    Conflict,
    ConstantFresnel,
    Decal,
    Displacement,
    ExponentMap,
    ExponentUnused,
    ForcedFresnel,
    GlassMap,
    GlassSpecular,
    Halo,
    LampByName,
    Medium,
    MediumByName,
    NoFile,
    NormalsByName,
    OpaqueDialect,
    OpaqueGlass,
    Option,
    Reflection,
    Spectral,
    SpecularUnused,
    SpecularOfPbr,
    TintUnused,
    TooMany,
    UnitIndex,
}

impl Ignored {
    /// Counted by statements, where other kinds count materials.
    pub fn is_of_statements(self) -> bool {
        matches!(
            self,
            Self::Ambient
                | Self::AmbientEmits
                | Self::AmbientMap
                | Self::Antialiasing
                | Self::Brdf
                | Self::Decal
                | Self::Displacement
                | Self::Medium
                | Self::Reflection
        )
    }
}

impl Finding for Ignored {
    fn fate(self) -> Fate {
        match self {
            Self::Case
            | Self::AmbientEmits
            | Self::BadIllum
            | Self::BadIor
            | Self::BlackFactor
            | Self::BumpHeight
            | Self::Clamped
            | Self::Conflict
            | Self::ConstantFresnel
            | Self::ExponentMap
            | Self::ForcedFresnel
            | Self::GlassMap
            | Self::Halo
            | Self::LampByName
            | Self::NormalsByName
            | Self::OpaqueGlass
            | Self::UnitIndex => Fate::Approximated,
            _ => Fate::Ignored,
        }
    }

    fn describe(self, key: &str, count: usize) -> Diagnostic {
        let times = if count == 1 { String::new() } else { format!(" ({count} times)") };
        let materials = counted(count, "material");
        let note = |message: String| Diagnostic::note(message);
        let warning = |message: String| Diagnostic::warning(message);
        match self {
            Self::Unknown => warning(format!("unknown key `{key}` ignored{times}")),
            Self::Case => note(format!("`{key}` is not in the usual case, but read all the same{times}")),
            Self::Ambient => note(format!("`Ka` ignored: ambient light is computed{times}")),
            Self::AmbientEmits => note(format!("`Ka` above 1 counts as emission `Ke`{times}")),
            Self::AmbientMap => note(format!("`map_Ka` ignored: ambient light is computed{times}")),
            Self::Antialiasing => note(format!("`{key}` has no meaning here and is ignored{times}")),
            Self::BadIllum => warning(format!("`{key}` counts as 2{times}")).label("expected 0 to 10"),
            Self::BadIor => {
                warning(format!("`{key}` out of range: {materials} with 1.5 instead")).label("expected 0.1 to 10")
            }
            Self::BeforeFirst => warning(format!("`{key}` before the first `newmtl` ignored{times}")),
            Self::BlackFactor => {
                note(format!("`{key}` 0 with a map, which it would blacken, counts as 1 ({materials})"))
            }
            Self::Brdf => note(format!("`BRDF` has no meaning here and is ignored{times}")),
            Self::BumpHeight => note(format!(
                "`bump`: white stands 0.01 units above black, times `-bm`, since files do not say ({materials})"
            )),
            Self::Clamped => warning(format!("`{key}` out of range, clamped{times}")),
            Self::Conflict => warning(format!("`Tr` is not 1 - `d`: `d` counts ({materials})")),
            Self::ConstantFresnel => note(format!("illum 5: the same reflection at every angle ({materials})")),
            Self::Decal => warning(format!("`decal` ignored: one image a colour is read{times}")),
            Self::Displacement => warning(format!("`disp` ignored: surfaces are not displaced{times}")),
            Self::ExponentMap => {
                note(format!("`map_Ns`: the lobe is Phong's, with exponent `Ns` times the map ({materials})"))
            }
            Self::ExponentUnused => note(format!("`{key}` ignored: `Pr` says how rough it is ({materials})")),
            Self::ForcedFresnel => note(format!("illum 6: Fresnel's equations are used all the same ({materials})")),
            Self::GlassMap => {
                note(format!("`{key}` on glass: the part of the surface that is not there ({materials})"))
            }
            Self::GlassSpecular => note(format!("glass reflects by Fresnel's equations, not by `{key}` ({materials})")),
            Self::Halo => note(format!("`d -halo` counts as `d`{times}")),
            Self::LampByName => note(format!("`AreaLightSource` emits `Kd` ({materials})")),
            Self::Medium => {
                note(format!("`{key}` has no meaning here and is ignored: the medium is `GlobalScatter`{times}"))
            }
            Self::MediumByName => {
                note(format!("`GlobalScatter` stands for a medium, which scripts fill the world with ({materials})"))
            }
            Self::NoFile => warning(format!("`{key}` without a file name ignored{times}")),
            Self::NormalsByName => {
                note(format!("`bump` read as a map of normals, as its file's name says ({materials})"))
            }
            Self::OpaqueDialect => note(format!("`{key}` ignored, as `Tr` 0 asks ({materials})")),
            Self::OpaqueGlass => {
                note(format!("illum 4, 6, 7 or 9 with `Ni` 1 and nothing transparent counts as opaque ({materials})"))
            }
            Self::Option => note(format!("`{key}` ignored{times}")),
            Self::Reflection => note(format!("`refl` ignored: reflections are computed{times}")),
            Self::Spectral => warning(format!("`{key}` is not read: only red, green and blue are{times}")),
            Self::SpecularUnused => note(format!("`{key}` ignored, as illum 0 and 1 ask ({materials})")),
            Self::SpecularOfPbr => {
                note(format!("`{key}` ignored: with PBR keys reflection follows from `Ni` and `Pm` ({materials})"))
            }
            Self::TintUnused => note(format!("`Tf` ignored: illum asks for no refraction ({materials})")),
            Self::TooMany => warning(format!("{materials} beyond the first {key} ignored")),
            Self::UnitIndex => note(format!("`Ni` 1 with PBR keys counts as 1.5 ({materials})")),
        }
    }
}
