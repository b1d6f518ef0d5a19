//! How surfaces scatter, in terms of parameters.

use super::{Color, Number};
use crate::{
    bsdf::{
        BrushedMetal, Bsdf, Diffuse, Glass, GrooveForm, Mirror, Mtl, Phong, PhongLobes, Principled,
        PrincipledParameters, RoughGlass, RoughMetal,
    },
    spectrum::Spectrum,
    texture::Lookup,
};
use std::{convert::Infallible, ops::RangeInclusive};

/// How a surface scatters. `C` and `N` are what colours and numbers are: values ([`Spectrum`], `f32`) at one point, or
/// [`Color`] and [`Number`] over a whole surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scattering<C = Spectrum, N = f32> {
    /// Lambertian reflection and transmission, the same from both sides.
    Diffuse {
        /// Albedo of reflection, in [0, 1].
        reflectance: C,
        /// Albedo of transmission; `reflectance + transmittance <= 1`.
        transmittance: C,
    },
    /// Perfect specular reflection.
    Mirror {
        /// In [0, 1].
        reflectance: C,
    },
    /// A smooth dielectric: Fresnel reflection and refraction.
    Glass {
        /// Index of refraction inside (behind the normal) over outside.
        ior: N,
        /// Multiplies what is reflected.
        reflection_tint: C,
        /// Multiplies what is refracted.
        transmission_tint: C,
        /// A thin sheet: light goes straight through, with the sheet's inter-reflections summed.
        thin: bool,
    },
    /// A conductor with GGX microfacets.
    RoughMetal {
        /// Real part of the index of refraction, per channel.
        eta: C,
        /// Imaginary part.
        k: C,
        /// GGX alpha along the tangent (u) and across, in [0, 1]; with both below
        /// [`ALPHA_MIN`](crate::bsdf::ggx::ALPHA_MIN) the metal is smooth.
        alpha: [N; 2],
        /// Multiplies the reflection.
        tint: C,
    },
    /// A dielectric with GGX microfacets.
    RoughGlass {
        /// Index of refraction inside over outside.
        ior: N,
        /// GGX alpha, in [0, 1]; below [`ALPHA_MIN`](crate::bsdf::ggx::ALPHA_MIN) the glass is smooth.
        alpha: N,
        /// Multiplies what is reflected.
        reflection_tint: C,
        /// Multiplies what is refracted.
        transmission_tint: C,
    },
    /// Grooves that scatter into a circle of directions. See [`BrushedMetal`].
    BrushedMetal {
        /// In [0, 1].
        reflectance: C,
        /// Power k of the cosine of the grooves' walls' tilts, from 0 to 1e9: the larger, the narrower the lobe.
        exponent: N,
        /// What happens towards the horizon.
        form: GrooveForm,
    },
    /// What an MTL file's `Kd Ks Ns Tf Ni d` imply, as an energy-conserving mixture of a diffuse, a specular (mirror or
    /// GGX) and a refracting lobe; each channel's albedos are scaled down together where they sum to more than 1.
    Mtl {
        /// `Kd`.
        diffuse: C,
        /// `Ks`.
        specular: C,
        /// Width of the specular lobe, GGX alpha; 0 is a mirror.
        alpha: N,
        /// `Tf`, specular transmission.
        transmission: C,
        /// `Ni`.
        ior: N,
    },
    /// Diffuse and glossy reflection and transmission, without Fresnel's equations; each channel's shares are scaled down
    /// together where they sum to more than 1. See [`Phong`].
    Phong(PhongLobes<C, N>),
    /// Coat and sheen over metal, opaque and clear dielectric. See [`Principled`].
    Principled(PrincipledParameters<C, N>),
    /// Scatters nothing: a pure emitter, or an invisible boundary with `opacity` 0.
    Black,
}

/// Indices of refraction, relative or of a metal, must be in this range (of a metal, either `eta` or `k`).
pub const INDEX_RANGE: RangeInclusive<f32> = 1e-3..=1e3;
/// Albedos, tints and widths.
pub(super) const UNIT: RangeInclusive<f32> = 0.0..=1.0;
/// Components of a metal's index of refraction.
const METAL: RangeInclusive<f32> = 0.0..=1e3;
/// Exponents of lobes that are powers of a cosine.
const EXPONENT: RangeInclusive<f32> = 0.0..=1e9;
/// Radians: beyond, a turn more or less would be lost in rounding.
pub(super) const ANGLE: RangeInclusive<f32> = -1e3..=1e3;

impl<C, N> Scattering<C, N> {
    /// Maps every parameter, given its name, the range of its values, and itself. This is the one list of parameters.
    ///
    /// # Errors
    /// The first that `color` or `number` gives.
    #[inline]
    pub fn try_map<D, M, E>(
        &self,
        mut color: impl FnMut(&'static str, RangeInclusive<f32>, &C) -> Result<D, E>,
        mut number: impl FnMut(&'static str, RangeInclusive<f32>, &N) -> Result<M, E>,
    ) -> Result<Scattering<D, M>, E> {
        Ok(match self {
            Self::Diffuse { reflectance, transmittance } => Scattering::Diffuse {
                reflectance: color("reflectance", UNIT, reflectance)?,
                transmittance: color("transmittance", UNIT, transmittance)?,
            },
            Self::Mirror { reflectance } => {
                Scattering::Mirror { reflectance: color("reflectance", UNIT, reflectance)? }
            }
            Self::Glass { ior, reflection_tint, transmission_tint, thin } => Scattering::Glass {
                ior: number("ior", INDEX_RANGE, ior)?,
                reflection_tint: color("reflection_tint", UNIT, reflection_tint)?,
                transmission_tint: color("transmission_tint", UNIT, transmission_tint)?,
                thin: *thin,
            },
            Self::RoughMetal { eta, k, alpha, tint } => Scattering::RoughMetal {
                eta: color("eta", METAL, eta)?,
                k: color("k", METAL, k)?,
                alpha: [number("alpha", UNIT, &alpha[0])?, number("alpha", UNIT, &alpha[1])?],
                tint: color("tint", UNIT, tint)?,
            },
            Self::RoughGlass { ior, alpha, reflection_tint, transmission_tint } => Scattering::RoughGlass {
                ior: number("ior", INDEX_RANGE, ior)?,
                alpha: number("alpha", UNIT, alpha)?,
                reflection_tint: color("reflection_tint", UNIT, reflection_tint)?,
                transmission_tint: color("transmission_tint", UNIT, transmission_tint)?,
            },
            Self::BrushedMetal { reflectance, exponent, form } => Scattering::BrushedMetal {
                reflectance: color("reflectance", UNIT, reflectance)?,
                exponent: number("exponent", EXPONENT, exponent)?,
                form: *form,
            },
            Self::Mtl { diffuse, specular, alpha, transmission, ior } => Scattering::Mtl {
                diffuse: color("diffuse", UNIT, diffuse)?,
                specular: color("specular", UNIT, specular)?,
                alpha: number("alpha", UNIT, alpha)?,
                transmission: color("transmission", UNIT, transmission)?,
                ior: number("ior", INDEX_RANGE, ior)?,
            },
            Self::Phong(p) => Scattering::Phong(PhongLobes {
                diffuse: color("diffuse", UNIT, &p.diffuse)?,
                specular: color("specular", UNIT, &p.specular)?,
                exponent: number("exponent", EXPONENT, &p.exponent)?,
                diffuse_transmission: color("diffuse_transmission", UNIT, &p.diffuse_transmission)?,
                transmission: color("transmission", UNIT, &p.transmission)?,
                transmission_exponent: number("transmission_exponent", EXPONENT, &p.transmission_exponent)?,
                ior: number("ior", INDEX_RANGE, &p.ior)?,
            }),
            Self::Principled(p) => Scattering::Principled(PrincipledParameters {
                base_color: color("base_color", UNIT, &p.base_color)?,
                metallic: number("metallic", UNIT, &p.metallic)?,
                roughness: number("roughness", UNIT, &p.roughness)?,
                anisotropic: number("anisotropic", UNIT, &p.anisotropic)?,
                rotation: number("rotation", ANGLE, &p.rotation)?,
                ior: number("ior", INDEX_RANGE, &p.ior)?,
                specular: number("specular", UNIT, &p.specular)?,
                transmission: number("transmission", UNIT, &p.transmission)?,
                coat: number("coat", UNIT, &p.coat)?,
                coat_roughness: number("coat_roughness", UNIT, &p.coat_roughness)?,
                sheen: color("sheen", UNIT, &p.sheen)?,
                sheen_roughness: number("sheen_roughness", UNIT, &p.sheen_roughness)?,
            }),
            Self::Black => Scattering::Black,
        })
    }
}

impl<C, N> Scattering<C, N> {
    /// The index of refraction, where light goes from one medium into another.
    pub fn ior(&self) -> Option<&N> {
        match self {
            Self::Glass { ior, thin: false, .. } | Self::RoughGlass { ior, .. } | Self::Mtl { ior, .. } => Some(ior),
            Self::Phong(lobes) => Some(&lobes.ior),
            Self::Principled(parameters) => Some(&parameters.ior),
            _ => None,
        }
    }

    fn ior_mut(&mut self) -> Option<&mut N> {
        match self {
            Self::Glass { ior, thin: false, .. } | Self::RoughGlass { ior, .. } | Self::Mtl { ior, .. } => Some(ior),
            Self::Phong(lobes) => Some(&mut lobes.ior),
            Self::Principled(parameters) => Some(&mut parameters.ior),
            _ => None,
        }
    }
}

impl<T> Scattering<Color<T>, Number<T>> {
    /// The values, if no parameter has a texture.
    pub fn constant(&self) -> Option<Scattering> {
        let color = |_, _, color: &Color<T>| if color.texture.is_none() { Ok(color.factor) } else { Err(()) };
        let number = |_, _, number: &Number<T>| if number.texture.is_none() { Ok(number.factor) } else { Err(()) };
        self.try_map(color, number).ok()
    }
}

impl<T> From<Scattering> for Scattering<Color<T>, Number<T>> {
    fn from(values: Scattering) -> Self {
        let mapped = values.try_map(|_, _, c| Ok::<_, Infallible>((*c).into()), |_, _, n| Ok((*n).into()));
        mapped.unwrap_or_else(|never| match never {})
    }
}

impl Scattering<Color, Number> {
    /// The values at a point, brought into their ranges.
    #[inline]
    pub fn at(&self, at: &Lookup) -> Scattering {
        let clamp = |value: f32, range: &RangeInclusive<f32>| {
            // Not `clamp`: a texture's value that is not a number becomes the least.
            value.max(*range.start()).min(*range.end())
        };
        let mapped = self.try_map(
            |_, range, color| Ok::<_, Infallible>(color.at(at).map(|value| clamp(value, &range))),
            |_, range, number| Ok(clamp(number.at(at), &range)),
        );
        mapped.unwrap_or_else(|never| match never {}).conserving()
    }
}

impl Scattering {
    /// Albedos that share the light scaled down together where textures make them sum to more than 1.
    #[inline]
    fn conserving(self) -> Self {
        match self {
            Self::Diffuse { reflectance, transmittance } => {
                let scale = (reflectance + transmittance).map(|sum| 1.0 / sum.max(1.0));
                Self::Diffuse { reflectance: reflectance * scale, transmittance: transmittance * scale }
            }
            other => other,
        }
    }

    /// The same for a body that lies in surroundings with this index of refraction.
    #[inline]
    pub fn within(mut self, surroundings: f32) -> Self {
        if let Some(ior) = self.ior_mut() {
            *ior = (*ior / surroundings).clamp(*INDEX_RANGE.start(), *INDEX_RANGE.end());
        }
        self
    }

    /// How a point with these values scatters. Meant for values in their ranges.
    #[inline]
    pub fn bsdf(&self) -> Bsdf {
        match *self {
            Self::Diffuse { reflectance, transmittance } => Bsdf::Diffuse(Diffuse::new(reflectance, transmittance)),
            Self::Mirror { reflectance } => Bsdf::Mirror(Mirror::new(reflectance)),
            Self::Glass { ior, reflection_tint, transmission_tint, thin } => {
                Bsdf::Glass(Glass::new(ior, reflection_tint, transmission_tint, thin))
            }
            Self::RoughMetal { eta, k, alpha, tint } => match RoughMetal::new(eta, k, alpha, tint) {
                Ok(rough) => Bsdf::RoughMetal(rough),
                Err(smooth) => Bsdf::Mirror(smooth),
            },
            Self::RoughGlass { ior, alpha, reflection_tint, transmission_tint } => {
                match RoughGlass::new(ior, [alpha; 2], reflection_tint, transmission_tint) {
                    Ok(rough) => Bsdf::RoughGlass(rough),
                    Err(smooth) => Bsdf::Glass(smooth),
                }
            }
            Self::BrushedMetal { reflectance, exponent, form } => {
                Bsdf::BrushedMetal(BrushedMetal::new(reflectance, exponent, form))
            }
            Self::Mtl { diffuse, specular, alpha, transmission, ior } => {
                Bsdf::Mtl(Mtl::new(diffuse, specular, alpha, transmission, ior))
            }
            Self::Phong(lobes) => Bsdf::Phong(Phong::new(&lobes)),
            Self::Principled(parameters) => Bsdf::Principled(Principled::new(&parameters)),
            Self::Black => Bsdf::Black,
        }
    }
}
