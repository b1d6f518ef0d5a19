//! From linear light to 8 bits: exposure, balance, tone curve, encoding.
//!
//! The default is no curve but clipping, what Mitsuba, pbrt and most others write, so that pictures can be compared; the
//! others trade that for softer highlights.

use std::fmt;
use std::str::FromStr;

use crate::film::UnknownName;
use crate::math::{exp_wide, exp2, ln_wide, pow};
use crate::spectrum::Spectrum;

/// How linear Rec. 709 colours above 0 are brought to the display's [0, 1], still linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ToneCurve {
    /// Each channel clipped at 1.
    #[default]
    None,
    /// Luminance L to L (1 + L / 16) / (1 + L), so that L = 4 is white (Reinhard et al., "Photographic Tone Reproduction
    /// for Digital Images", 2002, equation 4), then clipped. Keeps hues until a channel clips.
    Reinhard,
    /// The ACES reference rendering and Rec. 709 display transforms in Hill's fit (BakingLab, 2015). Raises contrast,
    /// highlights pass into white.
    Aces,
    /// Sobotka's AgX with its base look (github.com/sobotka/AgX, 2022): channels mixed a little, 16.5 stops about middle grey
    /// through a sigmoid, and unmixed. Bright colours pass into white without turning their hue.
    AgX,
}

/// Beyond this everything is white in every curve; keeps the arithmetic finite.
const LARGE: f32 = 1e9;

impl ToneCurve {
    /// Every curve.
    pub const ALL: [Self; 4] = [Self::None, Self::Reinhard, Self::Aces, Self::AgX];

    /// The name it has in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Reinhard => "reinhard",
            Self::Aces => "aces",
            Self::AgX => "agx",
        }
    }

    /// Display-linear colour in [0, 1] of a linear one, exposure applied before. Negative channels and NaN count as 0.
    pub fn apply(self, rgb: [f32; 3]) -> [f32; 3] {
        let rgb = rgb.map(|c| positive(c, LARGE));
        let mapped = match self {
            Self::None => rgb,
            Self::Reinhard => reinhard(rgb),
            Self::Aces => aces(rgb),
            Self::AgX => agx(rgb),
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

/// AgX after its published configuration and the short form of Wrensch, "Minimal AgX Implementation" (iolite-engine.com,
/// 2023), but with the sigmoid itself instead of a polynomial, so that black is black, white is white and nothing falls.
fn agx(rgb: [f32; 3]) -> [f32; 3] {
    // Both matrices are a scaling plus one share for all channels; the shares add up to 1 - SCALE, so greys stay grey.
    const SCALE: f32 = 0.8;
    const SHARES: [f32; 3] = [0.042_401_07, 0.078_436_5, 0.079_162_43];
    const MIDDLE_GREY: f32 = 0.18;
    const STOPS_BELOW: f64 = 10.0;
    const STOPS: f64 = 16.5;
    let common = |v: [f32; 3]| SHARES[0] * v[0] + SHARES[1] * v[1] + SHARES[2] * v[2];
    let mixed = rgb.map(|c| SCALE * c + common(rgb));
    let formed = mixed.map(|c| {
        let stops = ln_wide(c / MIDDLE_GREY) * std::f64::consts::LOG2_E;
        sigmoid(((stops + STOPS_BELOW) / STOPS).clamp(0.0, 1.0) as f32)
    });
    // The sigmoid's values are encoded for a display of gamma 2.2.
    formed.map(|c| pow(((c - common(formed)) / SCALE).max(0.0), 2.2))
}

/// Through (0, 0), (1, 1) and with slope 2 through the pivot (10 / 16.5, 1 / 2).
fn sigmoid(x: f32) -> f32 {
    const PIVOT: f32 = 10.0 / 16.5;
    const SLOPE: f32 = 2.0;
    if x <= 0.0 {
        // Exactly, whatever the rounding of what follows.
        return 0.0;
    }
    let from_pivot = x - PIVOT;
    let (bend, power) = if from_pivot < 0.0 { (59.507_875, 3.0) } else { (69.862_79, 3.25) };
    0.5 + SLOPE * from_pivot * pow(1.0 + bend * pow(from_pivot.abs(), power), -1.0 / power)
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

/// How display values are stored in 8 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Encoding {
    /// With the transfer function of sRGB (IEC 61966-2-1), as screens want it.
    #[default]
    Srgb,
    /// In proportion. On a screen that takes them for sRGB, such pictures are darker and of more contrast.
    Linear,
}

impl Encoding {
    /// Every encoding.
    pub const ALL: [Self; 2] = [Self::Srgb, Self::Linear];

    /// The name it has in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::Linear => "linear",
        }
    }

    /// The nearest of 0 to 255 of a value in [0, 1]; those beyond are clipped, NaN gives 0.
    pub fn to_8bit(self, value: f32) -> u8 {
        match self {
            Self::Srgb => to_srgb8(value),
            Self::Linear => (f64::from(positive(value, 1.0)) * 255.0 + 0.5) as u8,
        }
    }
}

impl fmt::Display for Encoding {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// All that lies between linear light and the bytes of a picture, in this order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplayTransform {
    /// Stops: light is multiplied by 2 to this power.
    pub exposure: f32,
    /// Light is multiplied by this, channel by channel; at least 0.
    pub balance: Spectrum,
    /// Brings light to [0, 1].
    pub curve: ToneCurve,
    /// Brings that to 8 bits.
    pub encoding: Encoding,
}

impl Default for DisplayTransform {
    fn default() -> Self {
        let (curve, encoding) = (ToneCurve::default(), Encoding::default());
        Self { exposure: 0.0, balance: Spectrum::ONE, curve, encoding }
    }
}

impl DisplayTransform {
    /// The function from linear light to bytes.
    pub fn encoder(self) -> impl Fn([f32; 3]) -> [u8; 3] + Copy + Send + Sync {
        let factors = self.balance * exposure_factor(self.exposure);
        move |light| self.curve.apply((Spectrum(light) * factors).0).map(|value| self.encoding.to_8bit(value))
    }
}

/// In words, for the metadata of pictures: `exposure 0, balance 1 1 1, tonemap none, encoding srgb`.
impl fmt::Display for DisplayTransform {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [r, g, b] = self.balance.0;
        let Self { exposure, curve, encoding, .. } = self;
        write!(f, "exposure {exposure}, balance {r} {g} {b}, tonemap {curve}, encoding {encoding}")
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
        assert_eq!(ToneCurve::None.apply([f32::NAN, 0.5, f32::NEG_INFINITY]), [0.0, 0.5, 0.0]);
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
        // White points and values by hand.
        let grey = ToneCurve::AgX.apply([0.18; 3]);
        assert!(grey.iter().all(|c| (f64::from(*c) - 0.5f64.powf(2.2)).abs() < 1e-5), "{grey:?}");
        assert!(ToneCurve::AgX.apply([0.18 * 2f32.powi(-10); 3])[0] < 1e-6);
        assert!(ToneCurve::AgX.apply([0.18 * 2f32.powf(6.5); 3])[0] > 0.9999);
        let mapped = ToneCurve::Reinhard.apply([4.0; 3]);
        assert!((mapped[0] - 1.0).abs() < 1e-6);
        let mapped = ToneCurve::Reinhard.apply([1.0; 3]);
        assert!((mapped[0] - 17.0 / 32.0).abs() < 1e-6);
    }

    /// The reference numbers follow AgX's configuration step by step with its own matrices, in f64.
    #[test]
    fn agx_as_configured() {
        const INSET: [[f64; 3]; 3] = [
            [0.842_479_062_253_094, 0.078_433_599_999_999_2, 0.079_223_745_147_764_3],
            [0.042_328_242_261_012_3, 0.878_468_636_469_772, 0.079_166_127_460_543_4],
            [0.042_375_654_905_705_1, 0.078_433_6, 0.879_142_973_793_104],
        ];
        const OUTSET: [[f64; 3]; 3] = [
            [1.196_879_005_120_17, -0.098_020_881_140_136_8, -0.099_029_744_079_720_5],
            [-0.052_896_851_757_456_2, 1.151_903_129_904_17, -0.098_961_176_844_843_3],
            [-0.052_971_635_514_443_8, -0.098_043_450_117_124_1, 1.151_073_672_641_16],
        ];
        let multiply = |m: [[f64; 3]; 3], v: [f64; 3]| m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2]);
        // Wrensch's polynomial of degree 7: off by up to 0.01 at its ends, which the last matrix enlarges.
        let curve = |x: f64| {
            let coefficients = [-17.86, 78.01, -126.7, 92.06, -28.72, 4.361, -0.1718, 0.002_857];
            coefficients.into_iter().fold(0.0, |sum, c| sum * x + c)
        };
        for rgb in [[0.18, 0.18, 0.18], [1.0, 0.2, 0.05], [0.0, 3.0, 0.4], [8.0, 0.1, 9.0], [0.01, 0.02, 0.03]] {
            let encode = |c: f64| curve(((c.log2() + 12.473_93) / 16.5).clamp(0.0, 1.0));
            let expected = multiply(OUTSET, multiply(INSET, rgb).map(encode));
            let mapped = ToneCurve::AgX.apply(rgb.map(|c| c as f32)).map(|c| f64::from(c).powf(1.0 / 2.2));
            for (mapped, expected) in mapped.into_iter().zip(expected) {
                assert!((mapped - expected.clamp(0.0, 1.0)).abs() < 0.02, "{rgb:?}: {mapped}, not {expected}");
            }
        }
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
    fn linear_levels_are_in_proportion() {
        for level in 0..=255u8 {
            let x = f32::from(level) / 255.0;
            assert_eq!(Encoding::Linear.to_8bit(x), level);
            assert_eq!(Encoding::Srgb.to_8bit(x), to_srgb8(x));
        }
        // The border between two levels lies half way.
        assert_eq!([127.4 / 255.0, 127.6 / 255.0].map(|x| Encoding::Linear.to_8bit(x)), [127, 128]);
        assert_eq!([f32::NAN, -1.0, 2.0, f32::INFINITY].map(|x| Encoding::Linear.to_8bit(x)), [0, 0, 255, 255]);
    }

    #[test]
    fn the_whole_transform() {
        let all = DisplayTransform::default();
        assert_eq!(all.encoder()([0.18, 0.5, 7.0]), [118, 188, 255]);
        let linear = DisplayTransform { encoding: Encoding::Linear, ..all };
        assert_eq!(linear.encoder()([0.2, 0.4, 7.0]), [51, 102, 255]);
        let balanced = DisplayTransform { exposure: 1.0, balance: Spectrum([2.0, 1.0, 0.5]), ..linear };
        assert_eq!(balanced.encoder()([0.1, 0.1, 0.1]), [102, 51, 26]);
        let curved = DisplayTransform { curve: ToneCurve::Reinhard, ..balanced };
        assert_eq!(curved.encoder()([0.25, 0.5, 1.0]), [135; 3], "1 17/32, after balance and exposure");
        assert_eq!(curved.to_string(), "exposure 1, balance 2 1 0.5, tonemap reinhard, encoding linear");
    }

    #[test]
    fn names() {
        for curve in ToneCurve::ALL {
            assert_eq!(curve.to_string().parse(), Ok(curve));
        }
        assert!("filmic".parse::<ToneCurve>().is_err());
        assert_eq!(ToneCurve::default(), ToneCurve::None);
    }
}
