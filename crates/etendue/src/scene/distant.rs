//! Lights without geometry: from a scene's parts to lights relative to its centre.

use super::{DeltaLight, Environment};
use crate::{
    light::{ConstantEnvironment, DirectionalLight, ImageEnvironment, Light, PointLightSource, SpotLight},
    math::{DMat3, DVec3},
    spectrum::Spectrum,
};
use std::sync::Arc;

pub(super) fn delta_light(light: &DeltaLight, center: DVec3) -> Light {
    let local = |position: DVec3| (position - center).as_vec3();
    let unit = |direction: DVec3| direction.normalize().as_vec3();
    match *light {
        DeltaLight::Point { position, intensity } => {
            Light::Point(PointLightSource { position: local(position), intensity })
        }
        DeltaLight::Spot { position, direction, half_angle, blend, intensity } => Light::Spot(SpotLight {
            position: local(position),
            axis: unit(direction),
            cos_outer: libm::cos(half_angle) as f32,
            cos_inner: libm::cos(half_angle * (1.0 - blend)) as f32,
            intensity,
        }),
        DeltaLight::Directional { direction, irradiance } => {
            Light::Directional(DirectionalLight { direction: unit(direction), irradiance })
        }
    }
}

/// `None` for a black environment.
pub(super) fn environment_light(environment: &Environment) -> Option<Light> {
    let light = match environment {
        Environment::Constant(radiance) => Light::Environment(ConstantEnvironment { radiance: *radiance }),
        Environment::Image { map, orientation, strength } => {
            Light::Image(Arc::new(ImageEnvironment::new(map.clone(), *orientation, *strength)))
        }
    };
    (!light.radiance().is_black()).then_some(light)
}

fn is_light(colour: Spectrum) -> bool {
    colour.0.iter().all(|c| c.is_finite() && *c >= 0.0)
}

pub(super) fn validate_delta_light(light: &DeltaLight) -> Result<(), &'static str> {
    let (colour, position, direction) = match *light {
        DeltaLight::Point { position, intensity } => (intensity, position, DVec3::X),
        DeltaLight::Spot { position, direction, half_angle, blend, intensity } => {
            if !(half_angle > 0.0 && half_angle <= std::f64::consts::PI && (0.0..=1.0).contains(&blend)) {
                return Err("the half angle must be above 0 up to pi, the blend from 0 to 1");
            }
            (intensity, position, direction)
        }
        DeltaLight::Directional { direction, irradiance } => (irradiance, DVec3::ZERO, direction),
    };
    if !is_light(colour) || !position.is_finite() {
        return Err("position and intensity must be finite, intensity not negative");
    }
    direction.try_normalize().map(|_| ()).ok_or("the direction must be finite and not zero")
}

pub(super) fn validate_environment(environment: &Environment) -> Result<(), &'static str> {
    match environment {
        Environment::Constant(radiance) if is_light(*radiance) => Ok(()),
        Environment::Constant(_) => Err("radiance must be finite and not negative"),
        Environment::Image { strength, .. } if !is_light(*strength) => Err("strength must be finite and not negative"),
        Environment::Image { orientation, .. } => {
            let error = *orientation * orientation.transpose() - DMat3::IDENTITY;
            let is_rotation = error.to_cols_array().iter().all(|e| e.abs() < 1e-6) && orientation.determinant() > 0.0;
            is_rotation.then_some(()).ok_or("orientation must be a rotation")
        }
    }
}
