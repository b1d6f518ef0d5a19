//! Scenes under skies from images, through the renderer.

mod common;

use common::*;
use etendue::{
    camera::CameraSettings,
    integrator::Integrator,
    light::RadianceMap,
    math::{DMat3, dvec3},
    scene::{Environment, Scene},
    spectrum::Spectrum,
};
use etendue_testkit::{
    Moments,
    tiles::{Demands, Replicates, compare},
};
use std::sync::Arc;

/// A blue sky with a sun of about half a degree, 40 degrees high, that gives most of the light; the ground is dark.
fn sun_and_sky() -> Environment {
    const WIDTH: u32 = 720;
    const HEIGHT: u32 = 360;
    let texel = |i: u32| match (i % WIDTH, i / WIDTH) {
        (250, 100) => [2e4, 1.8e4, 1.5e4],
        (_, y) if y < HEIGHT / 2 => [0.3, 0.5, 0.9],
        _ => [0.05, 0.04, 0.03],
    };
    let map = RadianceMap::new(WIDTH, HEIGHT, (0..WIDTH * HEIGHT).map(texel).collect()).expect("a valid map");
    Environment::Image { map: Arc::new(map), orientation: DMat3::from_rotation_y(0.7), strength: Spectrum::splat(0.5) }
}

fn floor_with_ball(sky: Environment) -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.6; 3]);
    parts.rectangle(dvec3(-5.0, 0.0, -5.0), dvec3(0.0, 0.0, 10.0), dvec3(10.0, 0.0, 0.0), white);
    parts.sphere(dvec3(0.0, 0.7, 0.0), 0.7, white);
    parts.0.environment = Some(sky);
    (parts.build(), camera(dvec3(0.5, 3.0, 5.0), dvec3(0.0, 0.2, 0.0)))
}

/// Variance of a pixel between samples, mean over the picture.
fn variance(scene: &Scene, view: &CameraSettings, integrator: Integrator, spp: u32) -> f64 {
    const SIZE: [u32; 2] = [16, 16];
    let pictures: Vec<Vec<f32>> = (0..24)
        .map(|seed| {
            let settings = statistics(integrator, spp);
            let settings = etendue::render::RenderSettings { seed, max_depth: Some(2), ..settings };
            interleaved(&picture(scene, view, SIZE, &settings))
        })
        .collect();
    let pixels = pictures[0].len();
    let of = |pixel: usize| pictures.iter().map(|p| f64::from(p[pixel])).collect::<Moments>().variance();
    (0..pixels).map(of).sum::<f64>() / pixels as f64
}

/// BSDF sampling alone hits the sun so rarely that its variance is even underestimated here.
#[test]
fn a_small_sun_costs_at_most_a_twentieth_of_the_variance_of_bsdf_sampling() {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.6; 3]);
    parts.rectangle(dvec3(-5.0, 0.0, -5.0), dvec3(0.0, 0.0, 10.0), dvec3(10.0, 0.0, 0.0), white);
    parts.0.environment = Some(sun_and_sky());
    let (scene, view) = (parts.build(), camera(dvec3(0.0, 4.0, 0.1), dvec3(0.0, 0.0, 0.0)));
    let (path, brute) = (variance(&scene, &view, Integrator::Path, 64), variance(&scene, &view, Integrator::Brute, 64));
    println!("variance at 64 samples: path {path:.3e}, brute {brute:.3e}, ratio {:.0}", brute / path);
    assert!(brute > 20.0 * path, "path {path:.3e}, brute {brute:.3e}");
}

/// With a sun that BSDF sampling can find too.
#[test]
fn solvers_agree_under_an_image() {
    let texel = |i: u32| {
        let (x, y) = (i % 32, i / 32);
        let sun = if (9..14).contains(&x) && (3..6).contains(&y) { 12.0 } else { 0.0 };
        [0.2 + sun, 0.3 + 0.8 * sun, if y < 8 { 0.6 } else { 0.0 }]
    };
    let map = RadianceMap::new(32, 16, (0..512).map(texel).collect()).expect("a valid map");
    let orientation = DMat3::from_axis_angle(dvec3(0.2, 1.0, -0.3).normalize(), 1.9);
    let sky = Environment::Image { map: Arc::new(map), orientation, strength: Spectrum([0.5, 0.6, 0.7]) };
    let (scene, view) = floor_with_ball(sky);
    let replicates = |integrator: usize, spp: u32| {
        let mut all = Replicates::new([24, 24], 3, 8);
        for replicate in 0..32 {
            let mut settings = statistics(SOLVERS[integrator], spp);
            settings.seed = 5000 * (integrator as u64 + 1) + replicate;
            settings.max_depth = Some(6);
            all.push(&interleaved(&picture(&scene, &view, [24, 24], &settings)));
        }
        all
    };
    let path = replicates(0, 48);
    let demands = Demands { level: etendue_testkit::sidak(0.01, 2), ..Demands::default() };
    for (other, spp) in [(1, 144), (2, 192)] {
        compare(&path, &replicates(other, spp)).assert(demands, &format!("path against {}", SOLVERS[other]));
    }
}

/// The camera sees the map where it is.
#[test]
fn camera_rays_see_the_sky() {
    let texel = |i: u32| [(i % 64) as f32, (i / 64) as f32, 1.0];
    let map = Arc::new(RadianceMap::new(64, 32, (0..64 * 32).map(texel).collect()).expect("a valid map"));
    let mut parts = Parts::default();
    parts.0.environment =
        Some(Environment::Image { map: map.clone(), orientation: DMat3::IDENTITY, strength: Spectrum::splat(2.0) });
    let scene = parts.build();
    // Along +x, that is a quarter left of the centre.
    let view = camera(dvec3(3.0, 2.0, 1.0), dvec3(4.0, 2.0, 1.0));
    let image = interleaved(&picture(&scene, &view, [9, 9], &statistics(Integrator::Path, 64)));
    let expected = map.lookup(0.25, 0.5) * 2.0;
    let middle = &image[(4 * 9 + 4) * 3..][..3];
    for channel in 0..3 {
        assert!((middle[channel] - expected[channel]).abs() < 0.2, "{middle:?}, not {expected:?}");
    }
    // Right in the picture is right in the map, up is up.
    assert!(image[(4 * 9 + 8) * 3] > middle[0] + 1.0 && image[4 * 3 + 1] < middle[1] - 1.0);
}
