//! Ranges and energy of materials.

use super::{
    Color, Emission, Material, Number, Relief, Scattering, Tangent,
    scattering::{ANGLE, INDEX_RANGE, UNIT},
};
use crate::{math::DVec3, spectrum::Spectrum};
use std::ops::RangeInclusive;

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
    /// A number that must be the same everywhere has a texture.
    #[error(
        "material `{material}`: `{parameter}` is that of the whole body where there is a priority, and cannot have a texture"
    )]
    Textured {
        /// The material's name.
        material: String,
        /// The parameter, by the name of its field.
        parameter: &'static str,
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
            Self::OutOfRange { parameter, .. } | Self::Textured { parameter, .. } => parameter,
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

    fn color(&self, parameter: &'static str, color: Spectrum, range: RangeInclusive<f32>) -> Result<(), MaterialError> {
        color.0.into_iter().try_for_each(|channel| self.number(parameter, channel, range.clone()))
    }

    /// What textures are multiplied by may exceed the range of the product, which is brought into it where it is used.
    fn factor_range<T>(range: RangeInclusive<f32>, texture: &Option<T>) -> RangeInclusive<f32> {
        if texture.is_some() { 0.0..=f32::INFINITY } else { range }
    }

    /// Their sum at most 1 in every channel.
    fn albedos(&self, parameters: &'static str, sum: Spectrum) -> Result<(), MaterialError> {
        let sum = sum.max_component();
        if sum <= 1.0 + ALBEDO_SLACK {
            return Ok(());
        }
        Err(MaterialError::CreatesEnergy { material: self.material.to_owned(), parameters, sum })
    }
}

impl<T> Material<T> {
    /// Checks ranges and energy: the first parameter that is wrong, if any. Where a parameter has a texture, what depends on
    /// it is not an error but brought into its range at every point.
    ///
    /// # Errors
    /// The first parameter out of its range, or parameters that together create energy.
    pub fn validate(&self) -> Result<(), MaterialError> {
        let check = Check { material: &self.name };
        let color =
            |name, range, color: &Color<T>| check.color(name, color.factor, Check::factor_range(range, &color.texture));
        let number = |name, range, number: &Number<T>| {
            check.number(name, number.factor, Check::factor_range(range, &number.texture))
        };
        self.scattering.try_map(color, number)?;
        if let Some(values) = self.scattering.constant() {
            check_together(&check, &values)?;
        }
        if let Some(Emission { radiance, .. }) = &self.emission {
            check.color("radiance", radiance.factor, 0.0..=f32::INFINITY)?;
        }
        if self.priority.is_some() && self.scattering.ior().is_some_and(|ior| ior.texture.is_some()) {
            return Err(MaterialError::Textured { material: self.name.clone(), parameter: "ior" });
        }
        number("opacity", UNIT, &self.opacity)?;
        number("tangent", ANGLE, &self.tangent.rotation)?;
        check_tangent(&check, self.tangent.direction)?;
        let any = f32::NEG_INFINITY..=f32::INFINITY;
        match &self.relief {
            None => Ok(()),
            Some(Relief::Bump { height }) => check.number("bump", height.factor, any),
            Some(Relief::Normals { scale, .. }) => {
                scale.iter().try_for_each(|s| check.number("normal_scale", *s, any.clone()))
            }
        }
    }
}

/// Points are finite, and directions have a length.
fn check_tangent(check: &Check, tangent: Tangent) -> Result<(), MaterialError> {
    let (center, direction) = match tangent {
        Tangent::Uv => (None, None),
        Tangent::Constant(direction) => (None, Some(direction)),
        Tangent::Radial { center, axis } | Tangent::Tangential { center, axis } => (Some(center), axis),
    };
    let length = |v: DVec3| v.length() as f32;
    center.map_or(Ok(()), |center| check.number("tangent", length(center), 0.0..=f32::INFINITY))?;
    direction.map_or(Ok(()), |v| check.number("tangent", length(v), f32::MIN_POSITIVE..=f32::INFINITY))
}

/// What several parameters must keep together.
fn check_together(check: &Check, values: &Scattering) -> Result<(), MaterialError> {
    match *values {
        Scattering::Diffuse { reflectance, transmittance } => {
            check.albedos("reflectance + transmittance", reflectance + transmittance)
        }
        Scattering::RoughMetal { eta, k, .. } => {
            eta.0.into_iter().zip(k.0).try_for_each(|(eta, k)| check.number("eta", eta.max(k), INDEX_RANGE))
        }
        _ => Ok(()),
    }
}
