//! Coefficients of real materials.
//!
//! From the measurements of Jensen, Marschner, Levoy and Hanrahan, "A Practical Model for Subsurface Light Transport" (2001),
//! figure 5, which are per millimetre: reduced scattering and absorption coefficients for red, green and blue. Reduced
//! scattering is what an isotropic phase function would need to look the same after many scatterings, so that is the phase function that
//! belongs to them.

use crate::spectrum::Spectrum;

/// A material that light goes deep into. It scatters alike in all directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Preset {
    /// English name, lower case with dashes.
    pub name: &'static str,
    /// Reduced scattering coefficient, 1/m.
    pub scattering: Spectrum,
    /// Absorption coefficient, 1/m.
    pub absorption: Spectrum,
}

/// From coefficients per millimetre.
const fn preset(name: &'static str, scattering: [f32; 3], absorption: [f32; 3]) -> Preset {
    const fn metres([r, g, b]: [f32; 3]) -> Spectrum {
        Spectrum([r * 1000.0, g * 1000.0, b * 1000.0])
    }
    Preset { name, scattering: metres(scattering), absorption: metres(absorption) }
}

/// All that are known.
pub static PRESETS: [Preset; 12] = [
    preset("apple", [2.29, 2.39, 1.97], [0.0030, 0.0034, 0.046]),
    preset("chicken", [0.15, 0.21, 0.38], [0.015, 0.077, 0.19]),
    preset("chicken-2", [0.19, 0.25, 0.32], [0.018, 0.088, 0.20]),
    preset("cream", [7.38, 5.47, 3.15], [0.0002, 0.0028, 0.0163]),
    preset("ketchup", [0.18, 0.07, 0.03], [0.061, 0.97, 1.45]),
    preset("marble", [2.19, 2.62, 3.00], [0.0021, 0.0041, 0.0071]),
    preset("potato", [0.68, 0.70, 0.55], [0.0024, 0.0090, 0.12]),
    preset("skim-milk", [0.70, 1.22, 1.90], [0.0014, 0.0025, 0.0142]),
    preset("skin", [0.74, 0.88, 1.01], [0.032, 0.17, 0.48]),
    preset("skin-2", [1.09, 1.59, 1.79], [0.013, 0.070, 0.145]),
    preset("spectralon", [11.6, 20.4, 14.9], [0.0, 0.0, 0.0]),
    preset("whole-milk", [2.55, 3.21, 3.77], [0.0011, 0.0024, 0.014]),
];

/// Finds one by its name.
pub fn find(name: &str) -> Option<&'static Preset> {
    PRESETS.iter().find(|preset| preset.name == name)
}

/// All names.
pub fn names() -> impl Iterator<Item = &'static str> {
    PRESETS.iter().map(|preset| preset.name)
}
