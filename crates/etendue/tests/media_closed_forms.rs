//! Media against closed forms: transmittance, light scattered once, and the mean length of paths through a body.
#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue::{
    camera::{CameraSettings, Projection},
    integrator::Integrator,
    material::Scattering,
    math::{DAffine3, DQuat, DVec3, dvec3},
    medium::{Medium, PhaseFunction, PhaseKind},
    render::RenderSettings,
    scene::{DeltaLight, Scene, Shape},
    spectrum::Spectrum,
};
use etendue_testkit::{Moments, integrate_1d, integrate_2d};
use std::f64::consts::PI;

fn medium(absorption: [f32; 3], scattering: [f32; 3]) -> Medium {
    Medium {
        name: "gas".to_owned(),
        absorption: Spectrum(absorption),
        scattering: Spectrum(scattering),
        ..Medium::default()
    }
}

/// Parallel rays along `direction` through a square of side `height` about `position`.
fn parallel(position: DVec3, direction: DVec3, height: f64) -> CameraSettings {
    CameraSettings { projection: Projection::Orthographic { height }, ..camera(position, position + direction) }
}

/// Adds an invisible body full of the medium.
fn filled(parts: &mut Parts, shape: Shape, to: DAffine3) {
    let boundary = parts.material(Scattering::Black);
    parts.0.materials[boundary].opacity = 0.0.into();
    parts.0.materials[boundary].interior = Some("gas".to_owned());
    let shape = parts.shape(shape);
    parts.place(shape, to, boundary);
}

/// Means of a picture's channels over `replicates` seeds.
fn channel_means(
    scene: &Scene,
    view: &CameraSettings,
    size: [u32; 2],
    settings: &RenderSettings,
    replicates: u64,
) -> [Moments; 3] {
    let mut moments = [(); 3].map(|()| Moments::new());
    for seed in 0..replicates {
        let values = interleaved(&picture(scene, view, size, &RenderSettings { seed, ..settings.clone() }));
        for (channel, moments) in moments.iter_mut().enumerate() {
            let of_channel = values.iter().skip(channel).step_by(3).map(|v| f64::from(*v));
            moments.push(of_channel.sum::<f64>() / (values.len() / 3) as f64);
        }
    }
    moments
}

/// Holds the means of all channels against `exact`.
fn assert_channels(what: &str, moments: &[Moments; 3], exact: [f64; 3], precision: f64) {
    for (channel, (moments, exact)) in moments.iter().zip(exact).enumerate() {
        assert_mean(&format!("{what}, channel {channel}"), moments, exact, precision);
    }
}

const ABSORPTION: [f32; 3] = [0.1, 0.4, 1.2];
const SCATTERING: [f32; 3] = [0.5, 0.3, 0.0];

fn extinction() -> [f64; 3] {
    [0, 1, 2].map(|c| f64::from(ABSORPTION[c]) + f64::from(SCATTERING[c]))
}

/// Light straight through 2 m of gas, nothing scattered being let in by the depth limit: `exp(-2 k)` in each channel.
#[test]
fn a_slab_lets_through_what_it_should() {
    for (number, (name, shape)) in
        [("box", cube(false)), ("sphere", Shape::Sphere { center: DVec3::ZERO, radius: 1.0 })].into_iter().enumerate()
    {
        for integrator in SOLVERS {
            let mut parts = Parts::default();
            parts.0.media.push(medium(ABSORPTION, SCATTERING));
            filled(&mut parts, shape.clone(), DAffine3::IDENTITY);
            parts.0.environment = Some(Spectrum::ONE.into());
            let view = parallel(dvec3(0.0, 0.0, 3.0), DVec3::NEG_Z, 1e-3);
            let settings = RenderSettings { max_depth: Some(1), ..statistics(integrator, 256) };
            let moments = channel_means(&parts.build(), &view, [8, 8], &settings, 16);
            let exact = extinction().map(|k| (-2.0 * k).exp());
            assert_channels(&format!("{name} {number}, {integrator}"), &moments, exact, 0.01);
        }
    }
}

/// What only absorbs is computed, not drawn: a single sample is exact.
#[test]
fn absorption_alone_makes_no_noise() {
    let mut parts = Parts::default();
    parts.0.media.push(medium(ABSORPTION, [0.0; 3]));
    filled(&mut parts, cube(false), DAffine3::IDENTITY);
    parts.0.environment = Some(Spectrum::ONE.into());
    let view = parallel(dvec3(0.0, 0.0, 3.0), DVec3::NEG_Z, 1e-3);
    let scene = parts.build();
    for integrator in SOLVERS {
        let values = interleaved(&picture(&scene, &view, [2, 2], &statistics(integrator, 1)));
        for (value, k) in values.iter().zip(ABSORPTION.into_iter().cycle()) {
            let exact = (-2.0 * f64::from(k)).exp();
            assert!((f64::from(*value) / exact - 1.0).abs() < 1e-5, "{integrator}: {value}, not {exact}");
        }
    }
}

/// A ball of radius 1/2 full of gas, cut in half by the plane from which parallel rays start: those within the ball go through
/// `sqrt(r^2 - x^2)` of it, the others through none. The camera's centre is in the middle of the ball, or beside it.
#[test]
fn rays_know_the_bodies_that_they_start_in() {
    const RADIUS: f64 = 0.5;
    let mut parts = Parts::default();
    parts.0.media.push(medium(ABSORPTION, SCATTERING));
    let ball = Shape::Sphere { center: DVec3::ZERO, radius: 1.0 };
    filled(&mut parts, ball, DAffine3::from_scale(DVec3::splat(RADIUS)));
    parts.0.environment = Some(Spectrum::ONE.into());
    let scene = parts.build();
    for (number, x) in [0.0, 0.7].into_iter().enumerate() {
        let view = parallel(dvec3(x, 0.0, 0.0), DVec3::NEG_Z, 2.5);
        let settings = RenderSettings { max_depth: Some(1), ..statistics(SOLVERS[number], 64) };
        let moments = channel_means(&scene, &view, [16, 16], &settings, 16);
        let exact = extinction().map(|k| {
            let lost = |r: f64| 2.0 * PI * r * (1.0 - (-k * (RADIUS * RADIUS - r * r).max(0.0).sqrt()).exp());
            1.0 - integrate_1d(lost, [0.0, RADIUS], 64, 1e-10) / (2.5 * 2.5)
        });
        assert_channels(&format!("centre at {x}"), &moments, exact, 0.001);
    }
}

/// A ray that goes straight to a lamp is scattered on its way like any other: the lamp's own light arrives as `L exp(-k d)`.
#[test]
fn a_lamp_is_dimmed_by_the_gas_before_it() {
    for integrator in SOLVERS {
        let mut parts = Parts::default();
        parts.0.media.push(medium(ABSORPTION, SCATTERING));
        parts.0.world_medium = Some("gas".to_owned());
        let lamp = parts.emitter([2.0; 3], false);
        parts.sphere(DVec3::ZERO, 0.5, lamp);
        let view = parallel(dvec3(0.0, 0.0, 2.0), DVec3::NEG_Z, 1e-3);
        let settings = RenderSettings { max_depth: Some(1), ..statistics(integrator, 256) };
        let moments = channel_means(&parts.build(), &view, [8, 8], &settings, 16);
        let exact = extinction().map(|k| 2.0 * (-1.5 * k).exp());
        assert_channels(&integrator.to_string(), &moments, exact, 0.01);
    }
}

/// A point light over a grey floor, through a slab of gas 1 m thick: `rho / pi I / h^2 exp(-k)`. The shadow rays go through both of
/// its faces.
#[test]
fn light_samples_are_weakened_by_a_slab() {
    let mut parts = Parts::default();
    parts.0.media.push(medium(ABSORPTION, SCATTERING));
    let slab = DAffine3::from_translation(dvec3(0.0, 1.5, 0.0)) * DAffine3::from_scale(dvec3(3.0, 0.5, 3.0));
    filled(&mut parts, cube(false), slab);
    let floor = parts.diffuse([0.5; 3]);
    parts.rectangle(dvec3(-2.0, 0.0, -2.0), dvec3(0.0, 0.0, 4.0), dvec3(4.0, 0.0, 0.0), floor);
    let position = dvec3(0.0, 3.0, 0.0);
    parts.0.delta_lights.push(DeltaLight::Point { position, intensity: Spectrum::splat(5.0) });
    let scene = parts.build();
    // From below the slab, at an angle that does not matter.
    let view = parallel(dvec3(0.0, 0.8, 0.4), dvec3(0.0, -2.0, -1.0), 1e-3);
    for integrator in [Integrator::Path, Integrator::LightSplit] {
        let settings = RenderSettings { max_depth: Some(2), ..statistics(integrator, 4) };
        let moments = channel_means(&scene, &view, [4, 4], &settings, 4);
        let exact = extinction().map(|k| 0.5 / PI * 5.0 / 9.0 * (-k).exp());
        assert_channels(&integrator.to_string(), &moments, exact, 1e-3);
    }
}

/// Radiance along the ray that passes a spherical lamp at distance `off`, light that the gas has scattered once: over distances t
/// from the camera (`before` metres ahead of the lamp) and directions of the lamp's cone at an angle a off its centre,
/// `integral exp(-k t) s / (4 pi) 2 pi sin(a) exp(-k d(a)) L da dt`.
fn glow(off: f64, before: f64, radius: f64, k: f64, s: f64) -> f64 {
    let scattered = |[t, share]: [f64; 2]| {
        let distance = ((t - before) * (t - before) + off * off).sqrt();
        let widest = (radius / distance).asin();
        let a = share * widest;
        let to_lamp = distance * a.cos() - (radius * radius - (distance * a.sin()).powi(2)).max(0.0).sqrt();
        (-k * (t + to_lamp)).exp() * s * 0.5 * a.sin() * widest
    };
    let end = before + 60.0 / k.max(0.5);
    [[0.0, before - 1.0], [before - 1.0, before + 1.0], [before + 1.0, end]]
        .into_iter()
        .map(|[low, high]| integrate_2d(scattered, [low, 0.0], [high, 1.0], 16, 1e-12))
        .sum()
}

#[test]
fn a_spherical_lamp_lights_the_gas_about_it() {
    const RADIUS: f64 = 0.05;
    for (off, integrators) in [(0.3, &SOLVERS[..]), (0.08, &SOLVERS[..2])] {
        let mut parts = Parts::default();
        parts.0.media.push(medium([0.05, 0.1, 0.3], [0.2, 0.4, 0.1]));
        parts.0.world_medium = Some("gas".to_owned());
        let lamp = parts.emitter([100.0; 3], false);
        parts.sphere(DVec3::ZERO, RADIUS, lamp);
        let scene = parts.build();
        let view = parallel(dvec3(off, 0.0, 2.0), DVec3::NEG_Z, 1e-4);
        let exact = [0, 1, 2].map(|c| {
            let (a, s) = ([0.05, 0.1, 0.3][c], [0.2, 0.4, 0.1][c]);
            100.0 * glow(off, 2.0, RADIUS, a + s, s)
        });
        for integrator in integrators {
            let (spp, precision) = if *integrator == Integrator::Brute { (4096, 0.03) } else { (256, 0.01) };
            let spp = if proving() { 16 * spp } else { spp };
            let settings = RenderSettings { max_depth: Some(2), ..statistics(*integrator, spp) };
            let moments = channel_means(&scene, &view, [8, 8], &settings, 16);
            assert_channels(&format!("lamp {off} m off, {integrator}"), &moments, exact, precision);
        }
    }
}

/// A point light in gas that scatters forward: `integral exp(-k (t + d)) s p(angle) I / d^2 dt`.
#[test]
fn a_point_light_lights_gas_that_scatters_forward() {
    const G: f64 = 0.6;
    let kind = PhaseKind::HenyeyGreenstein { g: G as f32 };
    let mut parts = Parts::default();
    let phase = PhaseFunction::from(kind);
    parts.0.media.push(Medium { phase, ..medium([0.1; 3], [0.2; 3]) });
    parts.0.world_medium = Some("gas".to_owned());
    parts.0.delta_lights.push(DeltaLight::Point { position: DVec3::ZERO, intensity: Spectrum::ONE });
    // Something to have a scene about, out of the way.
    let black = parts.material(Scattering::Black);
    parts.sphere(dvec3(0.0, 5.0, 0.0), 0.1, black);
    let scene = parts.build();
    let (off, before) = (0.2, 1.5);
    let view = parallel(dvec3(off, 0.0, before), DVec3::NEG_Z, 1e-4);
    let (k, s) = (0.3, 0.2);
    let scattered = |t: f64| {
        let distance2 = (t - before) * (t - before) + off * off;
        let distance = distance2.sqrt();
        // Light goes from the lamp to the point and on to the camera: along +z.
        let cos = (before - t) / distance;
        let p = (1.0 - G * G) / (4.0 * PI * (1.0 + G * G - 2.0 * G * cos).powf(1.5));
        (-k * (t + distance)).exp() * s * p / distance2
    };
    let exact = [[0.0, 1.0], [1.0, 2.0], [2.0, 100.0]].map(|range| integrate_1d(scattered, range, 64, 1e-12));
    for integrator in [Integrator::Path, Integrator::LightSplit] {
        let settings = RenderSettings { max_depth: Some(2), ..statistics(integrator, 128) };
        let moments = means(&scene, &view, [8, 8], &settings, 16);
        assert_mean(&format!("forward, {integrator}"), &moments, exact.iter().sum(), 0.01);
    }
}

/// However a body scatters, the mean length of all ways through it that begin as light from everywhere does is 4 V / S (Blanco and
/// Fournier, "An invariance property of diffusive random walks", 2003). A medium that does not absorb and emits E per metre gives
/// every way E times its length; so, over random directions, the radiance of a body seen against black, integrated over the
/// picture, has the mean E V, and the mean projection of a convex body is S / 4.
#[test]
fn the_mean_way_through_a_body_is_four_times_its_volume_over_its_surface() {
    const DIRECTIONS: u32 = 400;
    let sphere = Shape::Sphere { center: DVec3::ZERO, radius: 1.0 };
    let bodies = [("sphere", sphere, 4.0 / 3.0, 4.0 * PI), ("cube", cube(false), 2.0 * 4.0 / 6.0, 24.0)];
    for (name, shape, length, surface) in bodies {
        for (number, (scattering, g)) in [(0.3, 0.0), (3.0, 0.0), (10.0, 0.7)].into_iter().enumerate() {
            let mut parts = Parts::default();
            let phase = PhaseFunction::from(PhaseKind::HenyeyGreenstein { g });
            let gas = medium([0.0; 3], [scattering; 3]);
            parts.0.media.push(Medium { phase, emission: Spectrum::ONE, ..gas });
            filled(&mut parts, shape.clone(), DAffine3::IDENTITY);
            let scene = parts.build();
            let side = 3.6;
            let moments: Moments = (0..DIRECTIONS)
                .map(|seed| {
                    // A direction of equal parts of the sphere, by the golden angle.
                    let z = (f64::from(seed) + 0.5) / (0.5 * f64::from(DIRECTIONS)) - 1.0;
                    let turn = DQuat::from_rotation_z(2.399_963 * f64::from(seed));
                    let to = turn * dvec3((1.0 - z * z).sqrt(), 0.0, z);
                    let view = parallel(-4.0 * to, to, side);
                    let settings = statistics(SOLVERS[number], 2);
                    let settings = RenderSettings { seed: u64::from(seed), ..settings };
                    let values = interleaved(&picture(&scene, &view, [16, 16], &settings));
                    let mean = values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64;
                    mean * side * side / (surface / 4.0)
                })
                .collect();
            assert_mean(&format!("{name}, scattering {scattering}, g {g}"), &moments, length, 0.01);
        }
    }
}

/// A body that shines, 4 km from the scene's middle, where points of the gas are rounded so coarsely that many would lie beyond the
/// surface: a path that were thought inside there would gather more light.
fn body_far_away(parts: &mut Parts, shape: Shape) -> CameraSettings {
    const AWAY: f64 = 4e3;
    parts.0.media.push(Medium { emission: Spectrum::ONE, ..medium([0.0; 3], [10.0; 3]) });
    let black = parts.material(Scattering::Black);
    parts.sphere(dvec3(-AWAY, 0.0, 0.0), 0.1, black);
    filled(parts, shape, DAffine3::from_translation(dvec3(AWAY, 0.0, 0.0)) * DAffine3::from_rotation_y(0.3));
    parallel(dvec3(AWAY, 0.0, 4.0), DVec3::NEG_Z, 3.0)
}

#[test]
fn the_mean_way_keeps_its_length_far_away() {
    let mut parts = Parts::default();
    let view = body_far_away(&mut parts, Shape::Sphere { center: DVec3::ZERO, radius: 1.0 });
    let wall = parts.material(Scattering::Black);
    parts.sphere(dvec3(4e3, 0.0, 0.0), 5.0, wall);
    let moments = means(&parts.build(), &view, [32, 32], &statistics(Integrator::Brute, 64), 16);
    assert_mean("sphere", &moments, 4.0 / 3.0 * PI / 9.0, 0.01);
}

/// At an edge a point may still be rounded to the outside of one face; what has no surface behind it is outside then.
#[test]
fn no_way_goes_on_for_ever() {
    let mut parts = Parts::default();
    let view = body_far_away(&mut parts, cube(false));
    let scene = parts.build();
    let brightest = (0..4).map(|seed| {
        let settings = RenderSettings { seed, ..statistics(Integrator::Brute, 256) };
        interleaved(&picture(&scene, &view, [16, 16], &settings)).into_iter().fold(0.0, f32::max)
    });
    // A pixel is the mean of 256 ways, of 4 V / S = 4/3 each on average.
    let brightest = brightest.fold(0.0, f32::max);
    assert!(brightest < 6.0, "a pixel of {brightest}");
}

/// A pane of glass in a liquid, in front of a wall that shines: two crossings at right angles let through what Fresnel's formula
/// says for the ratio of the indices, and the tint of each.
#[test]
fn glass_in_a_liquid_refracts_by_the_ratio_of_their_indices() {
    let white = Spectrum::ONE;
    for (glass, liquid) in [(1.5, 1.2), (1.5, 1.5), (1.1, 1.6)] {
        let mut parts = Parts::default();
        let of =
            |ior, transmission_tint| Scattering::Glass { ior, reflection_tint: white, transmission_tint, thin: false };
        let water = parts.material(of(liquid, white));
        parts.0.materials[water].priority = Some(1);
        let pane = parts.material(of(glass, Spectrum::splat(0.5)));
        parts.0.materials[pane].priority = Some(2);
        let wall = parts.emitter([1.0; 3], false);
        let shape = parts.shape(cube(false));
        parts.place(shape, DAffine3::from_scale(DVec3::splat(10.0)), water);
        parts.place(shape, DAffine3::from_scale(dvec3(2.0, 2.0, 0.2)), pane);
        parts.rectangle(dvec3(-3.0, -3.0, -2.0), dvec3(6.0, 0.0, 0.0), dvec3(0.0, 6.0, 0.0), wall);
        let view = parallel(dvec3(0.0, 0.0, 3.0), DVec3::NEG_Z, 1.0);
        let settings = RenderSettings { max_depth: Some(3), ..statistics(Integrator::Path, 64) };
        let moments = means(&parts.build(), &view, [8, 8], &settings, 16);
        let reflected = f64::from((glass - liquid) / (glass + liquid)).powi(2);
        let exact = (0.5 * (1.0 - reflected)).powi(2);
        assert_mean(&format!("{glass} in {liquid}"), &moments, exact, 0.01);
    }
}

/// In a world full of gas no light comes from infinity, and no samples are spent on it.
#[test]
fn skies_are_not_seen_through_an_endless_world() {
    let mut parts = Parts::default();
    parts.0.media.push(medium(ABSORPTION, SCATTERING));
    parts.0.world_medium = Some("gas".to_owned());
    let lamp = parts.emitter([1.0; 3], false);
    parts.sphere(dvec3(0.0, 9.0, 0.0), 0.1, lamp);
    parts.0.environment = Some(Spectrum::ONE.into());
    parts.0.delta_lights.push(DeltaLight::Directional { direction: DVec3::NEG_Y, irradiance: Spectrum::ONE });
    let scene = parts.build();
    assert_eq!(scene.lights().lights().len(), 1, "only the lamp is left");
    for integrator in SOLVERS {
        let settings = RenderSettings { max_depth: Some(1), ..statistics(integrator, 4) };
        let values = interleaved(&picture(&scene, &parallel(DVec3::ZERO, DVec3::Z, 1.0), [4, 4], &settings));
        assert!(values.iter().all(|value| *value == 0.0), "{integrator}");
    }
}
