//! Optical constants of real metals.
//!
//! Each channel has the constants whose reflectance, between 0 and 84 degrees, is that channel of the colour in which the
//! metal reflects daylight: measured spectra, weighted by the CIE 1931 observer and D65, in linear Rec. 709, white 1, what
//! is beyond the gamut brought into it. So they are no values at any one wavelength, but give the right colour at every
//! angle, to 0.005. The spectra are those of
//! - Johnson and Christy, "Optical constants of the noble metals", Phys. Rev. B 6, 4370 (1972): silver, gold, copper;
//! - Johnson and Christy, "Optical constants of transition metals", Phys. Rev. B 9, 5056 (1974): titanium, chromium,
//!   iron, cobalt, nickel, palladium;
//! - Rakic, "Algorithm for the determination of intrinsic optical constants of metal films: application to aluminum",
//!   Appl. Opt. 34, 4755 (1995): aluminium,
//!
//! as tabulated by the refractiveindex.info database (public domain).

use crate::spectrum::Spectrum;

/// Index of refraction of a metal against vacuum, `eta + i k`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Metal {
    /// English name, lower case.
    pub name: &'static str,
    /// Real part per channel.
    pub eta: Spectrum,
    /// Imaginary part per channel.
    pub k: Spectrum,
}

const fn metal(name: &'static str, eta: [f32; 3], k: [f32; 3]) -> Metal {
    Metal { name, eta: Spectrum(eta), k: Spectrum(k) }
}

/// All that are known.
pub static METALS: [Metal; 10] = [
    metal("silver", [0.0564, 0.0549, 0.0431], [4.4803, 3.5446, 2.5891]),
    metal("gold", [0.0297, 0.4991, 1.4690], [8.0083, 2.2624, 1.7738]),
    metal("copper", [0.2181, 1.0441, 1.2948], [3.3290, 2.6239, 2.3613]),
    metal("aluminium", [1.5010, 0.9848, 0.6050], [7.6495, 6.5473, 5.3453]),
    metal("iron", [2.9230, 2.9193, 2.5464], [3.0774, 2.9371, 2.7500]),
    metal("chromium", [3.2473, 3.1144, 2.2856], [3.2867, 3.3360, 3.1170]),
    metal("titanium", [2.7477, 2.5078, 2.2399], [3.8427, 3.3974, 3.0143]),
    metal("nickel", [2.0328, 1.9029, 1.7281], [4.1994, 3.5696, 2.8953]),
    metal("cobalt", [2.2573, 2.0350, 1.7131], [4.2275, 3.7941, 3.2376]),
    metal("palladium", [1.7957, 1.6216, 1.3954], [4.3639, 3.8113, 3.2120]),
];

/// Finds a metal by its name, in any case; American and chemical spellings are known too.
pub fn find(name: &str) -> Option<&'static Metal> {
    let name = name.to_ascii_lowercase();
    let name = match name.as_str() {
        "aluminum" | "al" => "aluminium",
        "ag" => "silver",
        "au" => "gold",
        "cu" => "copper",
        "fe" => "iron",
        "cr" | "chrome" => "chromium",
        "ti" => "titanium",
        "ni" => "nickel",
        "co" => "cobalt",
        "pd" => "palladium",
        other => other,
    };
    METALS.iter().find(|metal| metal.name == name)
}

/// The names that [`find`] knows, for messages.
pub fn names() -> impl Iterator<Item = &'static str> {
    METALS.iter().map(|metal| metal.name)
}
