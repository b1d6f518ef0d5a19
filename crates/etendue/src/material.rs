//! What surfaces are made of.

use crate::{
    bsdf::{
        Bsdf, Diffuse, Glass, Mirror, Mtl, Phong, PhongLobes, Principled, PrincipledParameters, RoughGlass, RoughMetal,
    },
    spectrum::Spectrum,
};
use std::ops::RangeInclusive;

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
        /// GGX alpha, in [0, 1]; below [`ALPHA_MIN`](crate::bsdf::ggx::ALPHA_MIN) the metal is smooth.
        alpha: f32,
        /// Multiplies the reflection.
        tint: Spectrum,
    },
    /// A dielectric with GGX microfacets.
    RoughGlass {
        /// Index of refraction inside over outside.
        ior: f32,
        /// GGX alpha, in [0, 1]; below [`ALPHA_MIN`](crate::bsdf::ggx::ALPHA_MIN) the glass is smooth.
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
    /// Diffuse and glossy reflection and transmission, without Fresnel's equations; each channel's shares are scaled down
    /// together where they sum to more than 1. See [`Phong`].
    Phong(PhongLobes),
    /// Coat and sheen over metal, opaque and clear dielectric. See [`Principled`].
    Principled(PrincipledParameters),
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

/// Indices of refraction, relative or of a metal, must be in this range (of a metal, either `eta` or `k`).
pub const INDEX_RANGE: RangeInclusive<f32> = 1e-3..=1e3;

/// Angles, radians, are at most this: beyond, a turn more or less would be lost in rounding.
const MAX_ANGLE: f32 = 1e3;

/// How far a sum of albedos may pass 1 by rounding.
const ALBEDO_SLACK: f32 = 1e-5;

/// Why a material cannot be used.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MaterialError {
    /// A number is NaN or outside its range.
    #[error("material `{material}`: `{parameter}` is {value}, but must be in [{min}, {max}]")]
    OutOfRange {
        /// The material's name.
        material: String,
        /// The parameter, by the name of its field.
        parameter: &'static str,
        /// What it is (of a colour, the worst channel).
        value: f32,
        /// Least that it may be.
        min: f32,
        /// Most that it may be; infinite for any finite number.
        max: f32,
    },
    /// Albedos that share the light sum to more than 1.
    #[error("material `{material}`: `{parameters}` sum to {sum} in one channel, which is more light than arrives")]
    CreatesEnergy {
        /// The material's name.
        material: String,
        /// The parameters, by the names of their fields.
        parameters: &'static str,
        /// The largest sum over the channels.
        sum: f32,
    },
}

impl MaterialError {
    /// The name of the field that is wrong; where several are, the first.
    pub fn parameter(&self) -> &'static str {
        match self {
            Self::OutOfRange { parameter, .. } => parameter,
            Self::CreatesEnergy { parameters, .. } => parameters.split(' ').next().unwrap_or(parameters),
        }
    }
}

/// Checks the parameters of one material.
struct Check<'a> {
    material: &'a str,
}

impl Check<'_> {
    fn number(&self, parameter: &'static str, value: f32, range: RangeInclusive<f32>) -> Result<(), MaterialError> {
        if range.contains(&value) && value.is_finite() {
            return Ok(());
        }
        let (min, max) = range.into_inner();
        Err(MaterialError::OutOfRange { material: self.material.to_owned(), parameter, value, min, max })
    }

    fn color(&self, parameter: &'static str, color: Spectrum, max: f32) -> Result<(), MaterialError> {
        color.0.into_iter().try_for_each(|channel| self.number(parameter, channel, 0.0..=max))
    }

    /// Each number >= 0, their sum at most 1 in every channel.
    fn albedos(&self, parameters: &'static str, sum: Spectrum) -> Result<(), MaterialError> {
        let sum = sum.max_component();
        if sum <= 1.0 + ALBEDO_SLACK {
            return Ok(());
        }
        Err(MaterialError::CreatesEnergy { material: self.material.to_owned(), parameters, sum })
    }
}

impl Material {
    /// How a point of this material scatters. Meant for materials that passed [`validate`](Self::validate).
    pub fn bsdf(&self) -> Bsdf {
        match self.scattering {
            Scattering::Diffuse { reflectance, transmittance } => {
                Bsdf::Diffuse(Diffuse::new(reflectance, transmittance))
            }
            Scattering::Mirror { reflectance } => Bsdf::Mirror(Mirror::new(reflectance)),
            Scattering::Glass { ior, reflection_tint, transmission_tint, thin } => {
                Bsdf::Glass(Glass::new(ior, reflection_tint, transmission_tint, thin))
            }
            Scattering::RoughMetal { eta, k, alpha, tint } => {
                Bsdf::RoughMetal(RoughMetal::new(eta, k, [alpha; 2], tint))
            }
            Scattering::RoughGlass { ior, alpha, reflection_tint, transmission_tint } => {
                match RoughGlass::new(ior, [alpha; 2], reflection_tint, transmission_tint) {
                    Ok(rough) => Bsdf::RoughGlass(rough),
                    Err(smooth) => Bsdf::Glass(smooth),
                }
            }
            Scattering::Mtl { diffuse, specular, alpha, transmission, ior } => {
                Bsdf::Mtl(Mtl::new(diffuse, specular, alpha, transmission, ior))
            }
            Scattering::Phong(lobes) => Bsdf::Phong(Phong::new(&lobes)),
            Scattering::Principled(p) => Bsdf::Principled(Principled::new(&p)),
            Scattering::Black => Bsdf::Black,
        }
    }

    /// Checks ranges and energy: the first parameter that is wrong, if any.
    pub fn validate(&self) -> Result<(), MaterialError> {
        let check = Check { material: &self.name };
        match self.scattering {
            Scattering::Diffuse { reflectance, transmittance } => {
                check.color("reflectance", reflectance, 1.0)?;
                check.color("transmittance", transmittance, 1.0)?;
                check.albedos("reflectance + transmittance", reflectance + transmittance)?;
            }
            Scattering::Mirror { reflectance } => check.color("reflectance", reflectance, 1.0)?,
            Scattering::Glass { ior, reflection_tint, transmission_tint, thin: _ } => {
                check.number("ior", ior, INDEX_RANGE)?;
                check.color("reflection_tint", reflection_tint, 1.0)?;
                check.color("transmission_tint", transmission_tint, 1.0)?;
            }
            Scattering::RoughMetal { eta, k, alpha, tint } => {
                check.color("eta", eta, *INDEX_RANGE.end())?;
                check.color("k", k, *INDEX_RANGE.end())?;
                for (eta, k) in eta.0.into_iter().zip(k.0) {
                    check.number("eta", eta.max(k), INDEX_RANGE)?;
                }
                check.number("alpha", alpha, 0.0..=1.0)?;
                check.color("tint", tint, 1.0)?;
            }
            Scattering::RoughGlass { ior, alpha, reflection_tint, transmission_tint } => {
                check.number("ior", ior, INDEX_RANGE)?;
                check.number("alpha", alpha, 0.0..=1.0)?;
                check.color("reflection_tint", reflection_tint, 1.0)?;
                check.color("transmission_tint", transmission_tint, 1.0)?;
            }
            Scattering::Mtl { diffuse, specular, alpha, transmission, ior } => {
                check.color("diffuse", diffuse, 1.0)?;
                check.color("specular", specular, 1.0)?;
                check.number("alpha", alpha, 0.0..=1.0)?;
                check.color("transmission", transmission, 1.0)?;
                check.number("ior", ior, INDEX_RANGE)?;
            }
            Scattering::Phong(p) => {
                check.color("diffuse", p.diffuse, 1.0)?;
                check.color("specular", p.specular, 1.0)?;
                check.number("exponent", p.exponent, 0.0..=f32::MAX)?;
                check.color("diffuse_transmission", p.diffuse_transmission, 1.0)?;
                check.color("transmission", p.transmission, 1.0)?;
                check.number("transmission_exponent", p.transmission_exponent, 0.0..=f32::MAX)?;
                check.number("ior", p.ior, INDEX_RANGE)?;
            }
            Scattering::Principled(p) => {
                check.color("base_color", p.base_color, 1.0)?;
                check.number("metallic", p.metallic, 0.0..=1.0)?;
                check.number("roughness", p.roughness, 0.0..=1.0)?;
                check.number("anisotropic", p.anisotropic, 0.0..=1.0)?;
                check.number("rotation", p.rotation, -MAX_ANGLE..=MAX_ANGLE)?;
                check.number("ior", p.ior, INDEX_RANGE)?;
                check.number("specular", p.specular, 0.0..=1.0)?;
                check.number("transmission", p.transmission, 0.0..=1.0)?;
                check.number("coat", p.coat, 0.0..=1.0)?;
                check.number("coat_roughness", p.coat_roughness, 0.0..=1.0)?;
                check.color("sheen", p.sheen, 1.0)?;
                check.number("sheen_roughness", p.sheen_roughness, 0.0..=1.0)?;
            }
            Scattering::Black => {}
        }
        if let Some(emission) = self.emission {
            check.color("radiance", emission.radiance, f32::INFINITY)?;
        }
        check.number("opacity", self.opacity, 0.0..=1.0)
    }

    /// What the albedo image shows: the share of light that is scattered at normal incidence.
    pub fn albedo(&self) -> Spectrum {
        self.bsdf().albedo()
    }

    /// True if the surface has only delta lobes, or none.
    pub fn is_delta(&self) -> bool {
        self.bsdf().is_delta()
    }

    /// True if lights on the other side of the surface count in light sampling.
    pub fn transmits(&self) -> bool {
        self.bsdf().transmits()
    }
}
