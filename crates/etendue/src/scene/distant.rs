//! Lights without geometry: from a scene's parts to lights relative to its centre.

use super::{DeltaLight, Environment, SceneError, SceneParts};
use crate::{
    light::{
        Carrier, ConstantEnvironment, DirectionalLight, ImageEnvironment, LISTED_AT, Light, PointLightSource,
        SpotLight, SunSky, atmosphere,
    },
    math::{DAffine3, DMat3, DVec3},
    motion::{Motion, Pose},
    spectrum::Spectrum,
};
use std::sync::Arc;

/// The lights without geometry, those that move as they are in the middle of the exposure with what moves them; without those from infinity if
/// these are hidden. `first` is the index of the first.
pub(super) fn list(
    parts: &SceneParts,
    center: DVec3,
    hides_infinity: bool,
    first: usize,
) -> Result<(Vec<Light>, Vec<Carrier>), SceneError> {
    let (mut lights, mut carriers) = (Vec::new(), Vec::new());
    for (index, light) in parts.delta_lights.iter().enumerate() {
        if hides_infinity && matches!(light, DeltaLight::Directional { .. }) {
            continue;
        }
        let moves = parts.light_motions.binary_search_by_key(&index, |(moved, _)| *moved);
        let motion = moves.ok().map(|at| &parts.light_motions[at].1);
        let pose = motion.map(|motion| motion.rest().unwrap_or_else(|| motion.at(LISTED_AT.into())));
        if let Some(motion) = motion.filter(|motion| motion.rest().is_none()) {
            let carried = motion.about(DAffine3::from_translation(center), center);
            let motion = carried.ok_or(SceneError::DeltaLight(index, "the motion goes too far"))?;
            let at = (first + lights.len()) as u32;
            carriers.push(Carrier::new(at..at + 1, Arc::new(motion)));
        }
        lights.push(delta_light(&pose.map_or(*light, |pose| moved(light, pose)), center));
    }
    Ok((lights, carriers))
}

/// A light at a pose.
fn moved(light: &DeltaLight, pose: Pose) -> DeltaLight {
    let mut light = *light;
    if let DeltaLight::Point { position, .. } | DeltaLight::Spot { position, .. } = &mut light {
        *position = pose.rotation * *position + pose.translation;
    }
    if let DeltaLight::Spot { direction, .. } | DeltaLight::Directional { direction, .. } = &mut light {
        *direction = pose.rotation * *direction;
    }
    light
}

/// True if any of them moves while the shutter is open.
pub(super) fn is_moving(motions: &[(usize, Motion)]) -> bool {
    motions.iter().any(|(_, motion)| motion.rest().is_none())
}

fn delta_light(light: &DeltaLight, center: DVec3) -> Light {
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
            let sky = ImageEnvironment::with_cells(Arc::new(daylight.map), orientation, *strength, atmosphere::CELLS);
            let irradiance = if *sun_disk { daylight.sun * *strength } else { Spectrum::BLACK };
            Light::SunSky(Arc::new(SunSky::new(sky, sun, up, *sun_radius, irradiance)))
        }
    };
    (!light.radiance().is_black()).then_some(light)
}

fn is_light(colour: Spectrum) -> bool {
    colour.0.iter().all(|c| c.is_finite() && *c >= 0.0)
}

pub(super) fn validate_delta_lights(lights: &[DeltaLight], motions: &[(usize, Motion)]) -> Result<(), SceneError> {
    for (i, light) in lights.iter().enumerate() {
        validate_delta_light(light).map_err(|what| SceneError::DeltaLight(i, what))?;
    }
    for (i, motion) in motions {
        motion.check().map_err(|what| SceneError::DeltaLight(*i, what))?;
    }
    let is_listed = motions.iter().all(|(i, _)| *i < lights.len());
    let ascends = motions.windows(2).all(|pair| pair[0].0 < pair[1].0);
    (is_listed && ascends).then_some(()).ok_or(SceneError::DeltaLight(lights.len(), "motions are of other lights"))
}

fn validate_delta_light(light: &DeltaLight) -> Result<(), &'static str> {
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
