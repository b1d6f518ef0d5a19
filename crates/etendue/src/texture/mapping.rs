//! How texture coordinates become texels, and texels values.

use crate::{
    film::UnknownName,
    math::{Vec2, floor},
};
use std::{fmt, str::FromStr};

/// What lies beyond the edge of an image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Wrap {
    /// The image again.
    #[default]
    Repeat,
    /// The image mirrored, then again.
    Mirror,
    /// Its edge.
    Clamp,
    /// Nothing: all channels 0, opacity too.
    Black,
}

/// Between texels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Filtering {
    /// A mean over the part of the surface that a path stands for: bilinear in coarser copies of the image (Williams,
    /// "Pyramidal Parametrics", 1983), and between two of them. Like `Bilinear` where that part is smaller than a texel.
    #[default]
    Trilinear,
    /// Linear along both axes; texels have their values at their centres.
    Bilinear,
    /// The texel that the point is in.
    Nearest,
}

/// Which number a texture gives where one is wanted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Channel {
    /// Rec. 709 luminance; of grey images the grey.
    #[default]
    Luminance,
    /// Red.
    Red,
    /// Green.
    Green,
    /// Blue.
    Blue,
    /// Opacity; 1 where the image has none.
    Alpha,
}

macro_rules! named {
    ($kind:ident, $what:literal, $($variant:ident = $name:literal),*) => {
        impl $kind {
            /// All of them.
            pub const ALL: [Self; [$($name),*].len()] = [$(Self::$variant),*];

            /// The name it has in files.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $name),* }
            }
        }

        impl fmt::Display for $kind {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(self.name())
            }
        }

        impl FromStr for $kind {
            type Err = UnknownName;

            fn from_str(name: &str) -> Result<Self, UnknownName> {
                Self::ALL.into_iter().find(|v| v.name() == name).ok_or_else(|| UnknownName {
                    kind: $what,
                    name: name.to_owned(),
                    expected: Self::ALL.map(Self::name).join(", "),
                })
            }
        }
    };
}
named!(Wrap, "wrap mode", Repeat = "repeat", Mirror = "mirror", Clamp = "clamp", Black = "black");
named!(Filtering, "texture filter", Trilinear = "trilinear", Bilinear = "bilinear", Nearest = "nearest");
named!(Channel, "channel", Luminance = "luminance", Red = "red", Green = "green", Blue = "blue", Alpha = "alpha");

impl Channel {
    /// The number that a texel gives.
    #[inline]
    pub fn of(self, [r, g, b, a]: [f32; 4]) -> f32 {
        match self {
            Self::Luminance if r == g && g == b => r,
            Self::Luminance => crate::spectrum::Spectrum([r, g, b]).luminance(),
            Self::Red => r,
            Self::Green => g,
            Self::Blue => b,
            Self::Alpha => a,
        }
    }
}

impl Wrap {
    /// A coordinate in image widths, brought near to [0, 1) where the image repeats, so that texels keep their precision
    /// far from it. What is not finite counts as 0.
    #[inline]
    pub(super) fn fold(self, x: f32) -> f32 {
        if !x.is_finite() {
            return 0.0;
        }
        match self {
            Self::Repeat => x - floor(x),
            Self::Mirror => {
                let halves = x * 0.5;
                2.0 * (halves - floor(halves))
            }
            // Farther out nothing changes.
            Self::Clamp | Self::Black => x.clamp(-2.0, 3.0),
        }
    }

    /// The texel at a position in texels that [`Self::fold`] has brought near; `None` beyond the edge of a black image.
    #[inline]
    pub(super) fn texel(self, position: f32, count: u32) -> Option<u32> {
        // The cast saturates, and the next steps bound it.
        let at = floor(position) as i64;
        let count = i64::from(count);
        let index = match self {
            // Most are, and a division takes long.
            _ if (0..count).contains(&at) => at,
            Self::Repeat => at.rem_euclid(count),
            Self::Mirror => {
                let at = at.rem_euclid(2 * count);
                at.min(2 * count - 1 - at)
            }
            Self::Clamp => at.clamp(0, count - 1),
            Self::Black => return None,
        };
        Some(index as u32)
    }
}

/// An affine map of texture coordinates: rows `[a, b, c]` give `a u + b v + c`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct UvTransform(pub [[f32; 3]; 2]);

impl Default for UvTransform {
    fn default() -> Self {
        Self([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    }
}

impl UvTransform {
    /// Texture coordinates times `scale`, turned by `rotation` degrees counter-clockwise, plus `offset`.
    pub fn new(scale: [f64; 2], rotation: f64, offset: [f64; 2]) -> Self {
        let (sin, cos) = (libm::sin(rotation.to_radians()), libm::cos(rotation.to_radians()));
        let row = |u: f64, v: f64, shift: f64| [(u * scale[0]) as f32, (v * scale[1]) as f32, shift as f32];
        Self([row(cos, -sin, offset[0]), row(sin, cos, offset[1])])
    }

    #[inline]
    fn row(row: [f32; 3], uv: Vec2) -> f32 {
        row[0] * uv.x + row[1] * uv.y + row[2]
    }

    /// The mapped coordinates.
    #[inline]
    pub fn apply(&self, uv: Vec2) -> Vec2 {
        Vec2::new(Self::row(self.0[0], uv), Self::row(self.0[1], uv))
    }

    /// A vector, mapped.
    #[inline]
    pub fn linear(&self, v: Vec2) -> Vec2 {
        let [[a, b, _], [c, d, _]] = self.0;
        Vec2::new(a * v.x + b * v.y, c * v.x + d * v.y)
    }

    /// How much u and v are stretched, each at least 0.
    pub fn scale(&self) -> Vec2 {
        let column = |i: usize| Vec2::new(self.0[0][i], self.0[1][i]).length();
        Vec2::new(column(0), column(1))
    }

    /// True if every number is finite.
    pub fn is_finite(&self) -> bool {
        self.0.iter().flatten().all(|x| x.is_finite())
    }
}

/// How texture coordinates become texels, and texels values.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mapping {
    /// Beyond the edges, along u and v.
    pub wrap: [Wrap; 2],
    /// Between texels.
    pub filtering: Filtering,
    /// Applied to the surface's texture coordinates.
    pub transform: UvTransform,
    /// Values are `base + gain * texel`.
    pub gain: f32,
    /// See `gain`.
    pub base: f32,
    /// Where a number is wanted.
    pub channel: Channel,
}

impl Default for Mapping {
    fn default() -> Self {
        Self {
            wrap: [Wrap::Repeat; 2],
            filtering: Filtering::Trilinear,
            transform: UvTransform::default(),
            gain: 1.0,
            base: 0.0,
            channel: Channel::Luminance,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// By division, wherever the position is.
    #[test]
    fn texels_beyond_the_edges_are_those_of_the_rest_of_a_division() {
        for count in [1u32, 2, 3, 7, 512, 1 << 24] {
            let n = i64::from(count);
            let edges = [-2 * n, -n, 0, n, 2 * n, 3 * n];
            for at in edges.into_iter().flat_map(|edge| (-9..9).map(move |near| edge + near)) {
                let position = at as f32 + 0.25;
                let at = f64::from(position).floor() as i64;
                let mirrored = at.rem_euclid(2 * n);
                let expected = [
                    (Wrap::Repeat, Some(at.rem_euclid(n))),
                    (Wrap::Mirror, Some(mirrored.min(2 * n - 1 - mirrored))),
                    (Wrap::Clamp, Some(at.clamp(0, n - 1))),
                    (Wrap::Black, (0..n).contains(&at).then_some(at)),
                ];
                for (wrap, expected) in expected {
                    assert_eq!(wrap.texel(position, count).map(i64::from), expected, "{wrap} {position} of {count}");
                }
            }
        }
    }
}
