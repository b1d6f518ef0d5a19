//! What an OBJ file may hold that is skipped, approximated or repaired.

use crate::{
    Diagnostic,
    text::{counted, tally::Finding},
};

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Skipped {
    Unknown,
    LinesAndPoints,
    FreeForm,
    Attribute,
    Weight,
    BadColour,
    MoreNumbers,
    BadUv,
    BadNormal,
    BadSmoothing,
    FewCorners,
    IndexZero,
    ZeroNormal,
    MissingUv,
    RepeatedCorner,
    Flattened,
    SelfIntersecting,
    TooComplex,
}

impl Skipped {
    /// Statements are told apart by their word.
    pub fn names_the_word(self) -> bool {
        matches!(self, Self::Unknown | Self::LinesAndPoints | Self::Attribute | Self::BadSmoothing)
    }
}

impl Finding for Skipped {
    fn describe(self, key: &str, count: usize) -> Diagnostic {
        let of = |thing: &str| counted(count, thing);
        match self {
            Self::Unknown => Diagnostic::warning(format!("unknown statement `{key}` ignored{}", times(count))),
            Self::LinesAndPoints => {
                let what = if key == "l" { "lines" } else { "points" };
                Diagnostic::note(format!("`{key}`: {what} are not rendered ({})", of("statement")))
            }
            Self::FreeForm => {
                let message = format!("free-form curves and surfaces are not read ({})", of("statement"));
                Diagnostic::warning(message).help("export the model as polygons")
            }
            Self::Attribute => Diagnostic::note(format!("`{key}` has no meaning here and is ignored{}", times(count))),
            Self::Weight => Diagnostic::note(format!("weights (w) of vertices are ignored ({})", of("line"))),
            Self::BadColour => Diagnostic::warning(format!(
                "vertex colours that are no finite numbers count as white ({})",
                of("line")
            )),
            Self::MoreNumbers => Diagnostic::note(format!("surplus numbers are ignored ({})", of("line"))),
            Self::BadUv => {
                Diagnostic::warning(format!("texture coordinates that are not finite count as 0 ({})", of("line")))
            }
            Self::BadNormal => {
                Diagnostic::warning(format!("normals that are not finite are replaced ({})", of("line")))
            }
            Self::BadSmoothing => {
                Diagnostic::warning(format!("smoothing group `{key}` counts as none{}", times(count)))
                    .label("expected a whole number or `off`")
            }
            Self::FewCorners => Diagnostic::warning(format!("{} with fewer than three corners skipped", of("face"))),
            Self::IndexZero => Diagnostic::warning(format!(
                "index 0 of texture vertices and normals counts as none ({})",
                of("corner")
            )),
            Self::ZeroNormal => {
                Diagnostic::note(format!("{} without length replaced by those of the faces", of("normal")))
            }
            Self::MissingUv => Diagnostic::note(format!(
                "{} without texture coordinates, in a file that has them, get (0, 0)",
                of("corner")
            )),
            Self::RepeatedCorner => Diagnostic::note(format!("{} merged with the same corner beside it", of("corner"))),
            Self::Flattened => {
                Diagnostic::note(format!("{} with fewer than three different corners skipped", of("face")))
            }
            Self::SelfIntersecting => {
                Diagnostic::warning(format!("{} crossing itself or without area cut as well as may be", of("polygon")))
            }
            Self::TooComplex => {
                Diagnostic::warning(format!("{} with too many corners cut as if convex", of("polygon")))
            }
        }
    }
}

fn times(count: usize) -> String {
    if count == 1 { String::new() } else { format!(" ({count} times)") }
}
