//! What surfaces are made of.

use crate::spectrum::Spectrum;

/// A surface's emission.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Emission {
    /// Radiance, W sr^-1 m^-2 per channel, the same in all directions.
    pub radiance: Spectrum,
    /// Emits on both sides; otherwise only on the side that the geometric normal points to.
    pub two_sided: bool,
}

/// How a surface scatters.
#[derive(Clone, Debug, PartialEq)]
pub enum Scattering {
    /// Lambertian reflection and transmission, the same from both sides.
    Diffuse {
        /// Albedo of reflection, in [0, 1].
        reflectance: Spectrum,
        /// Albedo of transmission; `reflectance + transmittance <= 1`.
        transmittance: Spectrum,
    },
    /// Perfect specular reflection.
    Mirror {
        /// In [0, 1].
        reflectance: Spectrum,
    },
    /// A smooth dielectric: Fresnel reflection and refraction.
    Glass {
        /// Index of refraction inside (behind the normal) over outside.
        ior: f32,
        /// Multiplies what is reflected.
        reflection_tint: Spectrum,
        /// Multiplies what is refracted.
        transmission_tint: Spectrum,
        /// A thin sheet: light goes straight through, with the sheet's inter-reflections summed.
        thin: bool,
    },
    /// A conductor with GGX microfacets.
    RoughMetal {
        /// Real part of the index of refraction, per channel.
        eta: Spectrum,
        /// Imaginary part.
        k: Spectrum,
        /// GGX alpha, in (0, 1].
        alpha: f32,
        /// Multiplies the reflection.
        tint: Spectrum,
    },
    /// A dielectric with GGX microfacets.
    RoughGlass {
        /// Index of refraction inside over outside.
        ior: f32,
        /// GGX alpha, in (0, 1].
        alpha: f32,
        /// Multiplies what is reflected.
        reflection_tint: Spectrum,
        /// Multiplies what is refracted.
        transmission_tint: Spectrum,
    },
    /// What an MTL file's `Kd Ks Ns Tf Ni d` imply, as an energy-conserving mixture of a diffuse, a specular (mirror or
    /// GGX) and a refracting lobe; each channel's albedos are scaled down together where they sum to more than 1.
    Mtl {
        /// `Kd`.
        diffuse: Spectrum,
        /// `Ks`.
        specular: Spectrum,
        /// Width of the specular lobe, GGX alpha; 0 is a mirror.
        alpha: f32,
        /// `Tf`, specular transmission.
        transmission: Spectrum,
        /// `Ni`.
        ior: f32,
    },
    /// Scatters nothing: a pure emitter, or an invisible boundary with `opacity` 0.
    Black,
}

/// A surface's material.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// As in the file.
    pub name: String,
    /// How it scatters.
    pub scattering: Scattering,
    /// What it emits.
    pub emission: Option<Emission>,
    /// Fraction of the surface that is there, in [0, 1] (MTL `d`); the rest lets rays pass straight.
    pub opacity: f32,
}
