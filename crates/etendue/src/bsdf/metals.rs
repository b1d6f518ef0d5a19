//! Optical constants of real metals.
//!
//! Each channel has the constants at one representative wavelength, R 650 nm, G 550 nm, B 450 nm, interpolated linearly
//! between the measurements of
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
    metal("silver", [0.0522, 0.0596, 0.0400], [4.4094, 3.5974, 2.6484]),
    metal("gold", [0.1556, 0.4241, 1.3831], [3.6024, 2.4721, 1.9155]),
    metal("copper", [0.2378, 1.0066, 1.2404], [3.6264, 2.5823, 2.3929]),
    metal("aluminium", [1.5580, 1.0152, 0.6332], [7.7124, 6.6273, 5.4544]),
    metal("iron", [2.9114, 2.9497, 2.5845], [3.0893, 2.9318, 2.7670]),
    metal("chromium", [3.1071, 3.1812, 2.3230], [3.3314, 3.3291, 3.1350]),
    metal("titanium", [2.7407, 2.5418, 2.2670], [3.8143, 3.4345, 3.0385]),
    metal("nickel", [1.9900, 1.9212, 1.7290], [4.2086, 3.6158, 2.9435]),
    metal("cobalt", [2.2371, 2.0524, 1.7365], [4.2357, 3.8242, 3.2745]),
    metal("palladium", [1.7893, 1.6412, 1.4080], [4.3750, 3.8455, 3.2540]),
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
