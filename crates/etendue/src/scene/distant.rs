//! Lights without geometry: from a scene's parts to lights relative to its centre.

use super::{DeltaLight, Environment};
use crate::{
    light::{
        ConstantEnvironment, DirectionalLight, ImageEnvironment, Light, PointLightSource, SpotLight, SunSky, atmosphere,
    },
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
        Environment::Sky { sun, up, atmosphere, strength, sun_radius, sun_disk } => {
            let (sun, up) = (sun.normalize(), up.normalize());
            let daylight = atmosphere.daylight(libm::asin(sun.dot(up).clamp(-1.0, 1.0)));
            // The map's middle column below the sun; anywhere where the sun is straight above.
            let ahead = (sun - up * sun.dot(up)).try_normalize().unwrap_or_else(|| up.any_orthonormal_vector());
            let orientation = DMat3::from_cols(up.cross(ahead), up, ahead);
            let sky = ImageEnvironment::new(Arc::new(daylight.map), orientation, *strength);
            let irradiance = if *sun_disk { daylight.sun * *strength } else { Spectrum::BLACK };
            Light::SunSky(Arc::new(SunSky::new(sky, sun, up, *sun_radius, irradiance)))
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
        Environment::Sky { sun, up, atmosphere: air, strength, sun_radius, .. } => {
            if !is_light(*strength) {
                return Err("strength must be finite and not negative");
            }
            if sun.try_normalize().is_none() || up.try_normalize().is_none() {
                return Err("directions must be finite and not zero");
            }
            if !atmosphere::TURBIDITY.contains(&air.turbidity) {
                return Err("turbidity must be from 1 to 10");
            }
            if !air.ground.0.iter().all(|c| (0.0..=1.0).contains(c)) {
                return Err("ground must be from 0 to 1");
            }
            let is_angle = *sun_radius >= 1e-4 && *sun_radius <= std::f64::consts::FRAC_PI_2;
            is_angle.then_some(()).ok_or("sun's radius must be from 1e-4 to pi / 2")
        }
        Environment::Image { orientation, .. } => {
            let error = *orientation * orientation.transpose() - DMat3::IDENTITY;
            let is_rotation = error.to_cols_array().iter().all(|e| e.abs() < 1e-6) && orientation.determinant() > 0.0;
            is_rotation.then_some(()).ok_or("orientation must be a rotation")
        }
    }
}
