//! Scenes with a closed form that is not uniform radiance, and the paper's direct lighting as printed.

mod common;

use common::*;
use etendue::{
    bsdf::Bsdf,
    math::{DVec3, Frame, Vec3, dvec3},
    sampling::{Sampler, Slot},
    scene::{DeltaLight, Scene},
    spectrum::Spectrum,
};
use etendue_accel::{Hit, PrimitiveId, Ray};
use etendue_testkit::Moments;

const ROOM: f64 = 1.0;
const LAMP: f64 = 0.4;
const RHO: f32 = 0.8;
const EMITTED: f32 = 2.0;

/// A lamp, a black sphere of radius r that emits E, in the middle of a room, a sphere of radius R and albedo rho. From each
/// point of the room the lamp covers the fraction P = (r / R)^2 of the cosine-weighted hemisphere. The room is equally
/// bright everywhere: B = rho (P E + (1 - P) B), so B = rho P E / (1 - rho (1 - P)).
fn lamp_in_a_room() -> Scene {
    let mut parts = Parts::default();
    let wall = parts.diffuse([RHO; 3]);
    let lamp = parts.emitter([EMITTED; 3], false);
    parts.sphere(DVec3::ZERO, ROOM, wall);
    parts.sphere(DVec3::ZERO, LAMP, lamp);
    parts.build()
}

fn covered() -> f64 {
    (LAMP / ROOM) * (LAMP / ROOM)
}

fn exact_wall() -> f64 {
    let (rho, p) = (f64::from(RHO), covered());
    rho * p * f64::from(EMITTED) / (1.0 - rho * (1.0 - p))
}

#[test]
fn a_lamp_in_a_room_lights_it_as_derived() {
    let scene = lamp_in_a_room();
    let view = camera(dvec3(0.0, 0.0, 0.7), dvec3(0.0, 0.5, 1.0));
    for integrator in SOLVERS {
        let moments = means(&scene, &view, [8, 8], &statistics(integrator, 1024), 16);
        assert_mean(&integrator.to_string(), &moments, exact_wall(), 0.003);
    }
}

/// The paper's estimator (2.5) in the room above: direct light from the lamp, plus reflected light from a cosine-distributed
/// direction that counts zero if it hits the lamp; `factor` multiplies the second term.
fn paper_estimate(scene: &Scene, seed: u64, samples: u32, factor: f32) -> f64 {
    let sampler = Sampler::Independent;
    let wall = Bsdf::Diffuse(etendue::bsdf::Diffuse::new(Spectrum::splat(RHO), Spectrum::BLACK));
    // The lamp's share is the same everywhere, so its direct light is known exactly.
    let direct = RHO * covered() as f32 * EMITTED;
    let mut sum = 0.0;
    for index in 0..samples {
        let key = sampler.key(seed, [0, 0], index);
        let (mut throughput, mut radiance) = (1.0, 0.0);
        let mut position = Vec3::Z * ROOM as f32;
        let mut normal = -Vec3::Z;
        let mut skip = PrimitiveId { instance: 0, primitive: 0 };
        for vertex in 0.. {
            radiance += throughput * direct;
            let u = sampler.two_d(key, vertex, Slot::BsdfDirection);
            let Some(sample) = wall.sample(Vec3::Z, sampler.one_d(key, vertex, Slot::BsdfLobe), u) else { break };
            let wi = Frame::from_normal(normal).to_world(sample.wi);
            let ray = Ray {
                origin: position.into(),
                t_min: 0.0,
                direction: wi.into(),
                t_max: f32::INFINITY,
                time: 0.0,
                mask: u32::MAX,
                skip,
            };
            let mut hit = [Hit::MISS];
            scene.accelerator().closest_hits(&[ray], &mut hit);
            assert!(hit[0].is_hit(), "the room is closed");
            if hit[0].id.instance == 1 {
                break;
            }
            let point = scene.surface_point(&ray, &hit[0]);
            (position, normal, skip) = (point.position, -point.geometric_normal, point.id);
            // Roulette with the albedo keeps the mean.
            throughput *= factor;
            if sampler.one_d(key, vertex, Slot::Roulette) >= RHO {
                break;
            }
        }
        sum += f64::from(radiance);
    }
    sum / f64::from(samples)
}

#[test]
fn the_papers_printed_factor_fails_the_furnace_and_its_unbiased_form_passes() {
    let scene = lamp_in_a_room();
    let estimate =
        |factor: f32| -> Moments { (0..32).map(|seed| paper_estimate(&scene, seed, 4096, factor)).collect() };
    let unbiased = estimate(1.0);
    assert_mean("zero where the lamp is hit", &unbiased, exact_wall(), 0.003);
    let printed = estimate(1.0 / (1.0 - covered() as f32));
    let too_bright = printed.mean() / exact_wall();
    let (rho, p) = (f64::from(RHO), covered());
    let derived = (1.0 - rho * (1.0 - p)) / (1.0 - rho);
    assert!((printed.mean() - exact_wall()) / printed.standard_error() > 10.0, "1/Pr must fail: {too_bright}");
    assert!((too_bright / derived - 1.0).abs() < 0.02, "1/Pr is too bright by {too_bright}, derived {derived}");
}

#[test]
fn a_point_light_over_a_floor() {
    // Seen from above at the foot: L = rho / pi * I / d^2.
    let mut parts = Parts::default();
    let floor = parts.diffuse([0.6; 3]);
    parts.rectangle(dvec3(-5.0, 0.0, -5.0), dvec3(0.0, 0.0, 10.0), dvec3(10.0, 0.0, 0.0), floor);
    parts.0.delta_lights.push(DeltaLight::Point { position: dvec3(0.0, 2.0, 0.0), intensity: Spectrum::splat(3.0) });
    let scene = parts.build();
    let mut view = camera(dvec3(0.3, 5.0, 0.0), dvec3(0.0, 0.0, 0.0));
    view.projection = etendue::camera::Projection::Perspective {
        fov: 1e-3,
        axis: etendue::camera::FovAxis::X,
        lens_radius: 0.0,
        aperture: etendue::camera::Aperture::Round,
        focus_distance: 1.0,
    };
    let exact = 0.6 / std::f64::consts::PI * 3.0 / 4.0;
    for integrator in &SOLVERS[..2] {
        let image = picture(&scene, &view, [4, 4], &statistics(*integrator, 16));
        for value in interleaved(&image) {
            assert!((f64::from(value) / exact - 1.0).abs() < 1e-5, "{integrator}: {value}, not {exact}");
        }
    }
}
