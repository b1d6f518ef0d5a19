//! Wavelengths of daylight, and how they make a colour.

use crate::{math::exp_wide, spectrum::Spectrum};

/// Number of bands of [`WIDTH`] nanometres.
pub const BANDS: usize = 18;
/// Numbers in [`Bands`]: whole vectors of them, so that no loop ends in one by one. Those that are no band are 0 in whatever
/// scatters, absorbs or reflects.
pub const LANES: usize = BANDS.next_multiple_of(8);
/// A value for each band: sums over steps and directions are a thousandth of a thousandth off, less than their steps are.
pub type Bands = [f32; LANES];
/// Where the first band begins, nm.
const FIRST: f64 = 380.0;
/// Width of a band, nm.
const WIDTH: f64 = 20.0;
/// What a picture's white of 1 W sr^-1 m^-2 is worth, cd per W/sr: the efficacy of daylight within the visible band that
/// pictures in the Radiance format use (Ward, "Real Pixels", Graphics Gems II, 1991).
pub const EFFICACY: f64 = 179.0;
/// Lumens a watt at 555 nm.
const PEAK_EFFICACY: f64 = 683.002;

/// Irradiance of the sun outside of the atmosphere, W m^-2 nm^-1, means over 10 nm from 380 nm on: ASTM G173-03, column
/// "extraterrestrial".
const SUN: [f64; 2 * BANDS] = [
    1.01249, 1.14716, 1.72765, 1.73054, 1.6887, 1.61253, 1.91198, 2.03474, 2.02042, 2.02212, 1.93377, 1.95809, 1.91686,
    1.8298, 1.8685, 1.8931, 1.85149, 1.8504, 1.8341, 1.8345, 1.8147, 1.78158, 1.7533, 1.6965, 1.68194, 1.64654, 1.6048,
    1.52143, 1.55622, 1.5113, 1.474, 1.4482, 1.41018, 1.36775, 1.34188, 1.31429,
];

/// Absorption cross section of ozone at 233 K, 1e-25 m^2 a molecule, means over the same 10 nm: Serdyuchenko, Gorshelev,
/// Weber, Chehade and Burrows, "High spectral resolution ozone absorption cross-sections", 2014.
const OZONE: [f64; 2 * BANDS] = [
    0.002_818, 0.006_636, 0.015_27, 0.027_63, 0.0552, 0.084_51, 0.1582, 0.2316, 0.3669, 0.4924, 0.7752, 0.9016, 1.48,
    1.602, 2.139, 2.755, 3.091, 3.5, 4.266, 4.672, 4.398, 4.701, 5.019, 4.305, 3.74, 3.215, 2.662, 2.238, 1.852, 1.473,
    1.209, 0.9423, 0.7455, 0.6566, 0.5105, 0.415,
];

/// Values of bands with as many digits as are computed with.
pub fn narrow(values: [f64; LANES]) -> Bands {
    values.map(|value| value as f32)
}

/// A value for each band out of its middle, nm.
pub fn at_middles(value: impl Fn(f64) -> f64) -> [f64; LANES] {
    std::array::from_fn(|band| if band < BANDS { value(FIRST + WIDTH * (band as f64 + 0.5)) } else { 0.0 })
}

/// Absorption cross section of ozone, m^2 a molecule.
pub fn ozone() -> [f64; LANES] {
    std::array::from_fn(|band| if band < BANDS { 0.5e-25 * (OZONE[2 * band] + OZONE[2 * band + 1]) } else { 0.0 })
}

/// Reflectance from a linear colour: blue to 490 nm, green from there to 580 nm, red above, mixed over 20 nm.
pub fn reflectance(colour: Spectrum) -> Bands {
    let [red, green, blue] = colour.0.map(f64::from);
    let above = |edge: f64, wavelength: f64| ((wavelength - edge) / 20.0 + 0.5).clamp(0.0, 1.0);
    narrow(at_middles(|w| {
        let (green_on, red_on) = (above(490.0, w), above(580.0, w));
        blue * (1.0 - green_on) + green * (green_on - red_on) + red * red_on
    }))
}

/// The colour matching functions of the CIE's 2 degree observer of 1931, by the fit of Wyman, Sloan and Shirley, "Simple
/// Analytic Approximations to the CIE XYZ Color Matching Functions", 2013, with several lobes.
pub fn matching(wavelength: f64) -> [f64; 3] {
    let lobe = |height: f64, middle: f64, below: f64, above: f64| {
        let distance = (wavelength - middle) / if wavelength < middle { below } else { above };
        height * exp_wide(-0.5 * distance * distance)
    };
    [
        lobe(1.056, 599.8, 37.9, 31.0) + lobe(0.362, 442.0, 16.0, 26.7) + lobe(-0.065, 501.1, 20.4, 26.2),
        lobe(0.821, 568.8, 46.9, 40.5) + lobe(0.286, 530.9, 16.3, 31.1),
        lobe(1.217, 437.0, 11.8, 36.0) + lobe(0.681, 459.0, 26.0, 13.8),
    ]
}

/// From CIE XYZ to linear Rec. 709 (ITU-R BT.709), white point D65.
fn rec709([x, y, z]: [f64; 3]) -> [f64; 3] {
    [
        3.240_454_2 * x - 1.537_138_5 * y - 0.498_531_4 * z,
        -0.969_266 * x + 1.876_010_8 * y + 0.041_556 * z,
        0.055_643_4 * x - 0.204_025_9 * y + 1.057_225_2 * z,
    ]
}

/// What each band of sunlight that is scaled by 1 adds to a linear colour, W m^-2.
pub struct Colours([[f64; 3]; BANDS]);

impl Colours {
    pub fn new() -> Self {
        const STEP: f64 = 2.0;
        let band = |band: usize| {
            let mut xyz = [0.0; 3];
            let mut wavelength = FIRST + WIDTH * band as f64 + 0.5 * STEP;
            for half in [2 * band, 2 * band + 1] {
                for _ in 0..5 {
                    let weight = SUN[half] * STEP * PEAK_EFFICACY / EFFICACY;
                    let m = matching(wavelength);
                    xyz = [0, 1, 2].map(|i| xyz[i] + weight * m[i]);
                    wavelength += STEP;
                }
            }
            rec709(xyz)
        };
        Self(std::array::from_fn(band))
    }

    /// The linear colour of sunlight that is scaled so in each band; what Rec. 709 has no colour for keeps components
    /// below 0.
    pub fn sum(&self, bands: &Bands) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (value, colour) in bands.iter().zip(&self.0) {
            sum = [0, 1, 2].map(|i| sum[i] + f64::from(*value) * colour[i]);
        }
        sum
    }
}

/// The same luminance with as much of the colour as Rec. 709 can show: mixed with grey until nothing is below 0.
pub fn displayable(rgb: [f64; 3]) -> Spectrum {
    let luminance = 0.212_672_9 * rgb[0] + 0.715_152_2 * rgb[1] + 0.072_175 * rgb[2];
    let lowest = rgb[0].min(rgb[1]).min(rgb[2]);
    if lowest >= 0.0 {
        return Spectrum(rgb.map(|c| c as f32));
    }
    if luminance <= 0.0 {
        return Spectrum::BLACK;
    }
    let keep = luminance / (luminance - lowest);
    Spectrum(rgb.map(|c| (luminance + (c - luminance) * keep).max(0.0) as f32))
}
