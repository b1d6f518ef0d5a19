//! Lights that move: light samples, scattering and both together estimate the same.

use super::*;
use etendue::{
    bsdf::metals,
    integrator::Integrator,
    material::Scattering,
    math::dvec3,
    medium::Medium,
    scene::{DeltaLight, Scene, Shape},
    spectrum::Spectrum,
    texture::{Samples, Texture, TextureImage, Transfer},
};
use etendue_testkit::tiles::{Demands, Replicates, compare};
use std::sync::Arc;

const SIZE: [u32; 2] = [24, 24];
const TILE: usize = 8;
const REPLICATES: u64 = 32;

fn room(parts: &mut Parts) {
    let white = parts.diffuse([0.7; 3]);
    let blue = parts.diffuse([0.3, 0.4, 0.7]);
    parts.rectangle(dvec3(-4.0, -1.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(8.0, 0.0, 0.0), white);
    parts.rectangle(dvec3(-4.0, -1.0, -2.0), dvec3(8.0, 0.0, 0.0), dvec3(0.0, 6.0, 0.0), blue);
}

/// A plate that turns over, a ball that flies, a disk that turns upright, and a mesh whose glow has a texture, all over moving bodies.
fn lamps() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    room(&mut parts);
    let glow = parts.emitter([4.0, 3.0, 2.0], false);
    let lamp = parts.emitter([2.0, 2.0, 4.0], false);
    let plate = parts.shape(Shape::Rectangle { corner: dvec3(-1.2, 2.0, -0.4), u: DVec3::X * 1.2, v: DVec3::Z });
    let over = pose(DVec3::Z, 2.8, dvec3(-0.6, 2.0, 0.0), dvec3(0.0, 0.2, 0.0));
    parts.place_moving(plate, DAffine3::IDENTITY, glow, between(Pose::IDENTITY, over));
    let ball_of_light = parts.shape(Shape::Sphere { center: dvec3(1.5, 0.0, 0.8), radius: 0.35 });
    parts.place_moving(ball_of_light, DAffine3::IDENTITY, lamp, straight(DVec3::ZERO, dvec3(-0.8, 1.6, -0.5)));
    let round = parts.shape(round_sheet(16));
    let to = DAffine3::from_translation(dvec3(1.2, 1.1, 0.2)) * DAffine3::from_scale(dvec3(0.3, -0.3, 1.0));
    let upright = pose(DVec3::X, 1.5, dvec3(1.2, 1.1, 0.2), dvec3(0.1, -0.2, 0.3));
    parts.place_moving(round, to, glow, between(Pose::IDENTITY, upright));
    let samples: Vec<f32> = (0..8 * 4).map(|i| (i % 5) as f32 * 0.5).collect();
    let image = TextureImage::new(8, 4, 1, Samples::F32(samples.into()), Transfer::Linear).expect("an image");
    let screen = parts.emitter([1.5; 3], true);
    let material = &mut parts.0.materials[screen];
    material.emission.as_mut().expect("it emits").radiance.texture = Some(Arc::new(Texture::new(Arc::new(image))));
    let body = parts.shape(ball(1));
    let to = DAffine3::from_translation(dvec3(0.3, 1.3, -1.0)) * DAffine3::from_scale(dvec3(0.4, -0.5, 0.4));
    let spin = pose(DVec3::Y, 3.0, dvec3(0.3, 1.3, -1.0), dvec3(0.3, 0.0, 0.2));
    parts.place_moving(body, to, screen, between(Pose::IDENTITY, spin));
    let gold = metals::find("gold").expect("a known metal");
    let metal =
        parts.material(Scattering::RoughMetal { eta: gold.eta, k: gold.k, alpha: [0.4; 2], tint: Spectrum::ONE });
    let block = parts.shape(cube(false));
    let to = DAffine3::from_translation(dvec3(-0.9, -0.4, 0.3)) * DAffine3::from_scale(DVec3::splat(0.4));
    let tumble = pose(DVec3::ONE, 1.0, dvec3(-0.9, -0.4, 0.3), dvec3(0.2, 0.3, 0.0));
    parts.place_moving(block, to, metal, between(Pose::IDENTITY, tumble));
    parts.0.environment = Some(Spectrum::splat(0.1).into());
    (parts.build(), camera(dvec3(0.0, 0.8, 5.0), dvec3(0.0, 0.1, 0.0)))
}

fn replicates(scene: &Scene, view: &CameraSettings, integrator: usize, spp: u32) -> Replicates {
    let mut all = Replicates::new(SIZE.map(|s| s as usize), 3, TILE);
    for replicate in 0..REPLICATES {
        let mut settings = statistics(SOLVERS[integrator], spp);
        settings.seed = 1000 * (integrator as u64 + 1) + replicate;
        settings.max_depth = Some(6);
        settings.splitting = Some([2, 1, 1][integrator]);
        all.push(&interleaved(&picture(scene, view, SIZE, &settings)));
    }
    all
}

#[test]
fn solvers_agree_about_moving_lamps() {
    let (scene, view) = lamps();
    let sets = [0, 1, 2].map(|i| replicates(&scene, &view, i, [64, 96, 192][i]));
    let demands = Demands { level: etendue_testkit::sidak(0.01, 2), tile_error: 0.03, ..Demands::default() };
    for other in [1, 2] {
        compare(&sets[0], &sets[other]).assert(demands, &format!("path against {}", SOLVERS[other]));
    }
}

/// A lamp far from everything, on its way past a small white plate: the mean of its irradiance at rests on the way.
#[test]
fn a_lamp_on_its_way_lights_as_at_all_its_rests() {
    let lit = |motion: Motion, replicates: u64| {
        let mut parts = Parts::default();
        let (white, glow) = (parts.diffuse([1.0; 3]), parts.emitter([1.0; 3], false));
        parts.rectangle(dvec3(-0.05, 0.0, -0.05), DVec3::Z * 0.1, DVec3::X * 0.1, white);
        // Shines down.
        let plate = parts.shape(Shape::Rectangle { corner: dvec3(-0.5, 1.0, -0.5), u: DVec3::X, v: DVec3::Z });
        parts.place_moving(plate, DAffine3::IDENTITY, glow, motion);
        let view = CameraSettings {
            projection: Projection::Orthographic { height: 0.05 },
            ..camera(dvec3(0.0, 0.5, 0.0), DVec3::ZERO)
        };
        let settings = etendue::render::RenderSettings { max_depth: Some(2), ..statistics(SOLVERS[1], 64) };
        means(&parts.build(), &view, [8, 8], &settings, replicates)
    };
    let end = pose(dvec3(0.2, 0.1, 1.0), 1.2, dvec3(0.0, 1.0, 0.0), dvec3(1.0, 0.5, 0.0));
    let found = lit(between(Pose::IDENTITY, end), 64);
    let steps = 64;
    let rest =
        |i: u32| lit(Motion::resting(Pose::IDENTITY.between(end, (f64::from(i) + 0.5) / f64::from(steps))), 2).mean();
    let exact = (0..steps).map(rest).sum::<f64>() / f64::from(steps);
    assert!(found.standard_error() < 0.003 * exact, "{}", found.standard_error());
    let sigma = (found.mean() - exact) / (found.standard_error() + 0.0005 * exact);
    assert!(sigma.abs() < 3.0, "{} not {exact}: {sigma}", found.mean());
}

/// Lights without extent on their way over a small plate, through air that is clear or not: the mean of their light at rests on the way.
#[test]
fn lights_without_extent_are_blurred_along_their_way() {
    let end = pose(dvec3(1.0, 0.2, 0.3), 0.7, dvec3(0.0, 1.0, 0.0), dvec3(0.8, 0.3, -0.2));
    let intensity = Spectrum::splat(2.0);
    let (position, direction) = (dvec3(-0.3, 1.0, 0.1), dvec3(0.2, -1.0, 0.1));
    let point = DeltaLight::Point { position, intensity };
    let spot = DeltaLight::Spot { position, direction, half_angle: 0.8, blend: 0.5, intensity };
    let sun = DeltaLight::Directional { direction, irradiance: intensity };
    for (name, light, foggy) in
        [("point", point, false), ("spot", spot, false), ("sun", sun, false), ("point in fog", point, true)]
    {
        let lit = |motion: Motion, replicates: u64| {
            let mut parts = Parts::default();
            let white = parts.diffuse([1.0; 3]);
            parts.rectangle(dvec3(-0.05, 0.0, -0.05), DVec3::Z * 0.1, DVec3::X * 0.1, white);
            // Another beside those that lamps are chosen among; the sun would be chosen seldom in so small a scene.
            let other = DeltaLight::Point { position: DVec3::Y, intensity: Spectrum::splat(0.1) };
            parts.0.delta_lights = if name == "sun" { vec![light] } else { vec![other, light] };
            parts.0.light_motions = vec![(parts.0.delta_lights.len() - 1, motion)];
            if foggy {
                let (name, scattering) = ("fog".to_owned(), Spectrum::splat(0.3));
                parts.0.media.push(Medium { name, scattering, ..Medium::default() });
                parts.0.world_medium = Some("fog".to_owned());
            }
            let view = CameraSettings {
                projection: Projection::Orthographic { height: 0.05 },
                ..camera(dvec3(0.0, 0.5, 0.0), DVec3::ZERO)
            };
            let settings = etendue::render::RenderSettings { max_depth: Some(2), ..statistics(Integrator::Path, 64) };
            means(&parts.build(), &view, [8, 8], &settings, replicates)
        };
        let found = lit(between(Pose::IDENTITY, end), 64);
        let steps = 64;
        let at = |i: u32| Pose::IDENTITY.between(end, (f64::from(i) + 0.5) / f64::from(steps));
        let rests: Vec<_> = (0..steps).map(|i| lit(Motion::resting(at(i)), if foggy { 4 } else { 2 })).collect();
        let exact = rests.iter().map(|rest| rest.mean()).sum::<f64>() / f64::from(steps);
        let error = rests.iter().map(|rest| rest.standard_error().powi(2)).sum::<f64>().sqrt() / f64::from(steps);
        let error = error.hypot(found.standard_error());
        assert!(error < 0.004 * exact, "{name}: {error} of {exact}");
        let sigma = (found.mean() - exact) / (error + 0.0005 * exact);
        assert!(sigma.abs() < 3.2, "{name}: {} not {exact}: {sigma}", found.mean());
        // At either end of its way it is another.
        let ends = [0, steps - 1].map(|i| lit(Motion::resting(at(i)), 2).mean());
        assert!(ends.iter().all(|end| (end / exact - 1.0).abs() > 0.02), "{name}: {ends:?} and {exact} say nothing");
    }
}
