//! Spot and directional lights beyond what the tests over all lights see.

use super::{cases::RADIANCE, double};
use etendue::{
    bsdf::Density,
    light::{DirectionalLight, Light, LightContext, SpotLight},
    math::{Vec3, vec3},
};

fn gatherer(point: Vec3) -> LightContext {
    LightContext { point, normal: Vec3::ZERO, transmits: false, time: 0.0 }
}

/// What a spot sends through a sphere of radius 1 about it is its power.
#[test]
fn power_of_a_spot_is_what_it_sends_out() {
    for (cos_outer, cos_inner) in [(0.5, 0.9), (0.9, 0.9), (-1.0, 1.0), (-0.3, 0.2), (0.999, 1.0)] {
        let position = vec3(0.3, -0.2, 0.7);
        let axis = vec3(0.6, 0.0, -0.8);
        let light = Light::Spot(SpotLight { position, axis, cos_outer, cos_inner, intensity: RADIANCE });
        const BANDS: u32 = 200_000;
        let across = axis.any_orthonormal_vector();
        let mean: f64 = (0..BANDS)
            .map(|band| {
                let cos = 2.0 * (f64::from(band) + 0.5) / f64::from(BANDS) - 1.0;
                let direction = double(axis) * cos + double(across) * (1.0 - cos * cos).sqrt();
                let sample = light.sample(&gatherer((double(position) + direction).as_vec3()), [0.5; 2]);
                sample.map_or(0.0, |s| f64::from(s.radiance.mean())) / f64::from(BANDS)
            })
            .sum();
        let (sent, stated) = (mean * 4.0 * std::f64::consts::PI, light.power(1.0));
        assert!(
            (sent / stated - 1.0).abs() < 1e-3,
            "cosines {cos_outer} to {cos_inner}: sends {sent}, states {stated}"
        );
    }
}

#[test]
fn a_spot_is_full_inside_dark_outside_and_half_between() {
    let (axis, cos_outer, cos_inner) = (Vec3::NEG_Z, 0.6, 0.8);
    let light = Light::Spot(SpotLight { position: Vec3::ZERO, axis, cos_outer, cos_inner, intensity: RADIANCE });
    let at = |cos: f32| light.sample(&gatherer(vec3((1.0 - cos * cos).sqrt(), 0.0, -cos) * 2.0), [0.5; 2]);
    for (cos, share) in [(1.0, 1.0), (0.81, 1.0), (0.7, 0.5), (0.75, 0.84375)] {
        let sample = at(cos).expect("lit");
        assert!((sample.radiance[0] / RADIANCE[0] * 4.0 - share).abs() < 1e-5, "{cos}: {:?}", sample.radiance);
        assert_eq!((sample.density, sample.target), (Density::Discrete(1.0), Some(Vec3::ZERO)));
    }
    for cos in [0.59, 0.0, -1.0] {
        assert!(at(cos).is_none(), "{cos}");
    }
}

#[test]
fn directional_light_comes_from_where_it_travels_from() {
    let direction = vec3(0.6, -0.8, 0.0);
    let light = Light::Directional(DirectionalLight { direction, irradiance: RADIANCE });
    let sample = light.sample(&gatherer(vec3(1e6, -3.0, 2.0)), [0.1, 0.9]).expect("everywhere");
    assert_eq!((sample.wi, sample.target, sample.radiance), (-direction, None, RADIANCE));
    assert!(light.is_delta() && light.is_infinite());
}
