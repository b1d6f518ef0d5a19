//! From linear light to 8-bit sRGB: exposure, tone curve, transfer function.
//!
//! The default curve is the plain sRGB transfer with clipping, what Mitsuba, pbrt and most others write, so that pictures
//! can be compared; the others trade that for softer highlights.

use std::fmt;
use std::str::FromStr;

use crate::film::UnknownName;
use crate::math::{exp_wide, exp2, ln_wide, pow};

/// How linear Rec. 709 colours above 0 are brought to the display's [0, 1], still linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Each channel clipped at 1.
    #[default]
    Srgb,
    /// Luminance L to L (1 + L / 16) / (1 + L), so that L = 4 is white (Reinhard et al., "Photographic Tone Reproduction
    /// for Digital Images", 2002, equation 4), then clipped. Keeps hues until a channel clips.
    Reinhard,
    /// The ACES reference rendering and Rec. 709 display transforms in Hill's fit (BakingLab, 2015). Raises contrast,
    /// highlights pass into white.
    Aces,
}

/// Beyond this everything is white in every curve; keeps the arithmetic finite.
const LARGE: f32 = 1e9;

impl ToneCurve {
    /// Every curve.
    pub const ALL: [Self; 3] = [Self::Srgb, Self::Reinhard, Self::Aces];

    /// The name it has in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::Reinhard => "reinhard",
            Self::Aces => "aces",
        }
    }

    /// Display-linear colour in [0, 1] of a linear one, exposure applied before. Negative channels and NaN count as 0.
    pub fn apply(self, rgb: [f32; 3]) -> [f32; 3] {
        let rgb = rgb.map(|c| positive(c, LARGE));
        let mapped = match self {
            Self::Srgb => rgb,
            Self::Reinhard => reinhard(rgb),
            Self::Aces => aces(rgb),
        };
        mapped.map(|c| c.clamp(0.0, 1.0))
    }
}

/// The number if it is within [0, most], the nearer end if not, 0 for NaN.
fn positive(x: f32, most: f32) -> f32 {
    if x > 0.0 { x.min(most) } else { 0.0 }
}

fn reinhard(rgb: [f32; 3]) -> [f32; 3] {
    let luminance = 0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2];
    rgb.map(|c| c * ((1.0 + luminance / 16.0) / (1.0 + luminance)))
}

fn aces(rgb: [f32; 3]) -> [f32; 3] {
    const IN: [[f32; 3]; 3] = [[0.59719, 0.35458, 0.04823], [0.07600, 0.90834, 0.01566], [0.02840, 0.13383, 0.83777]];
    const OUT: [[f32; 3]; 3] =
        [[1.60475, -0.53108, -0.07367], [-0.10208, 1.10813, -0.00605], [-0.00327, -0.07276, 1.07602]];
    let multiply = |m: [[f32; 3]; 3], v: [f32; 3]| m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
    let fit = |v: f32| (v * (v + 0.024_578_6) - 0.000_090_537) / (v * (0.983_729 * v + 0.432_951) + 0.238_081);
    multiply(OUT, multiply(IN, rgb).map(fit))
}

impl fmt::Display for ToneCurve {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for ToneCurve {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL.into_iter().find(|t| t.name() == name).ok_or_else(|| UnknownName {
            kind: "tone curve",
            name: name.to_owned(),
            expected: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// The factor of an exposure in stops: 2 to their power.
pub fn exposure_factor(stops: f32) -> f32 {
    exp2(stops)
}

/// sRGB transfer (IEC 61966-2-1) of a linear value, rounded to the nearest of 0 to 255. NaN gives 0, infinity 255.
pub fn to_srgb8(linear: f32) -> u8 {
    let c = positive(linear, 1.0);
    let encoded =
        if c <= 0.003_130_8 { 12.92 * f64::from(c) } else { 1.055 * exp_wide(ln_wide(c) * (1.0 / 2.4)) - 0.055 };
    (encoded * 255.0 + 0.5) as u8
}

/// Linear value of an sRGB-encoded one in [0, 1] (IEC 61966-2-1).
pub fn srgb_to_linear(encoded: f32) -> f32 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { pow((encoded + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::disallowed_methods)]
    use super::*;

    #[test]
    fn transfer_is_correctly_rounded() {
        let reference = |x: f64| if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 };
        for bits in (0..=1.0f32.to_bits()).step_by(211) {
            let x = f32::from_bits(bits);
            // Distance from the nearest level, in levels.
            let exact = 255.0 * reference(f64::from(x));
            assert!((f64::from(to_srgb8(x)) - exact).abs() < 0.5 + 1e-8, "{x}");
        }
        for level in 0..=255u8 {
            assert_eq!(to_srgb8(srgb_to_linear(f32::from(level) / 255.0)), level);
        }
        // Known pairs: middle grey, the end of the straight part.
        assert_eq!([to_srgb8(0.18), to_srgb8(0.5), to_srgb8(0.003_130_8)], [118, 188, 10]);
    }

    #[test]
    fn ends_and_the_unordered() {
        for (x, level) in [(0.0, 0), (1.0, 255), (7.0, 255), (-1.0, 0), (f32::NAN, 0), (f32::INFINITY, 255)] {
            assert_eq!(to_srgb8(x), level, "{x}");
            for curve in ToneCurve::ALL {
                let mapped = curve.apply([x; 3]);
                assert!(mapped.iter().all(|c| (0.0..=1.0).contains(c)), "{curve} {x}: {mapped:?}");
                if x <= 0.0 || x.is_nan() {
                    assert_eq!(mapped, [0.0; 3], "{curve} {x}");
                } else if x.is_infinite() {
                    assert_eq!(mapped.map(to_srgb8), [255; 3], "{curve}");
                }
            }
        }
        assert_eq!(ToneCurve::Srgb.apply([f32::NAN, 0.5, f32::NEG_INFINITY]), [0.0, 0.5, 0.0]);
    }

    #[test]
    fn greys_rise() {
        for curve in ToneCurve::ALL {
            let mut last = [0.0; 3];
            for i in -600..=600 {
                let grey = 2f32.powf(i as f32 / 40.0);
                let mapped = curve.apply([grey; 3]);
                assert!((0..3).all(|c| mapped[c] >= last[c]), "{curve} {grey}: {mapped:?} after {last:?}");
                assert!(mapped[0] - mapped[1] < 1e-3 && mapped[1] - mapped[2] < 1e-3, "{curve}: grey stays grey");
                last = mapped;
            }
            assert!(last[0] > 0.999, "{curve}");
        }
        // White points and a value by hand.
        let mapped = ToneCurve::Reinhard.apply([4.0; 3]);
        assert!((mapped[0] - 1.0).abs() < 1e-6);
        let mapped = ToneCurve::Reinhard.apply([1.0; 3]);
        assert!((mapped[0] - 17.0 / 32.0).abs() < 1e-6);
    }

    #[test]
    fn exposure_in_stops() {
        for (stops, factor) in [(0.0, 1.0), (1.0, 2.0), (-3.0, 0.125), (10.0, 1024.0)] {
            assert_eq!(exposure_factor(stops), factor);
        }
        assert!((exposure_factor(0.5) - std::f32::consts::SQRT_2).abs() < 2e-7);
        assert!(exposure_factor(1e30).is_infinite() && exposure_factor(-1e30) == 0.0);
    }

    #[test]
    fn names() {
        for curve in ToneCurve::ALL {
            assert_eq!(curve.to_string().parse(), Ok(curve));
        }
        assert!("filmic".parse::<ToneCurve>().is_err());
        assert_eq!(ToneCurve::default(), ToneCurve::Srgb);
    }
}
