//! `path`, `light-split` and `brute` estimate the same integral in different ways: they must agree on every scene.

mod common;

use common::*;
use etendue::{
    bsdf::metals,
    camera::CameraSettings,
    material::Scattering,
    math::{DAffine3, DQuat, DVec3, dvec3},
    scene::Scene,
    spectrum::Spectrum,
};
use etendue_testkit::tiles::{Demands, Replicates, compare};

const SIZE: [u32; 2] = [24, 24];
const TILE: usize = 8;
const REPLICATES: u64 = 32;

fn tinted(rgb: [f32; 3]) -> Spectrum {
    Spectrum(rgb)
}

fn glass(ior: f32) -> Scattering {
    let tint = Spectrum::splat(0.95);
    Scattering::Glass { ior, reflection_tint: Spectrum::ONE, transmission_tint: tint, thin: false }
}

fn gold(alpha: f32) -> Scattering {
    let gold = metals::find("gold").expect("a known metal");
    Scattering::RoughMetal { eta: gold.eta, k: gold.k, alpha: [alpha; 2], tint: Spectrum::ONE }
}

fn floor_and_wall(parts: &mut Parts) {
    let white = parts.diffuse([0.7; 3]);
    let blue = parts.diffuse([0.3, 0.4, 0.7]);
    parts.rectangle(dvec3(-4.0, -1.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(8.0, 0.0, 0.0), white);
    parts.rectangle(dvec3(-4.0, -1.0, -2.0), dvec3(8.0, 0.0, 0.0), dvec3(0.0, 6.0, 0.0), blue);
}

/// A closed room with a large rectangle that emits, and two boxes.
fn room() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.7; 3]);
    let red = parts.diffuse([0.7, 0.2, 0.1]);
    let light = parts.emitter([3.0, 2.5, 2.0], false);
    let (walls, block) = (parts.shape(cube(true)), parts.shape(cube(false)));
    parts.place(walls, DAffine3::from_scale(DVec3::splat(2.0)), white);
    parts.rectangle(dvec3(-1.5, 1.95, -1.5), dvec3(3.0, 0.0, 0.0), dvec3(0.0, 0.0, 3.0), light);
    for (x, angle) in [(-0.8, 0.3), (0.7, -0.5)] {
        let at = DAffine3::from_translation(dvec3(x, -1.4, -0.3)) * DAffine3::from_rotation_y(angle);
        parts.place(block, at * DAffine3::from_scale(dvec3(0.5, 0.6, 0.5)), red);
    }
    (parts.build(), camera(dvec3(0.2, 0.1, 1.9), dvec3(0.0, -0.6, -1.0)))
}

/// Glass, mirror and thin glass under a sky, with a sphere that emits.
fn glass_under_sky() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    floor_and_wall(&mut parts);
    let clear = parts.material(glass(1.5));
    let mirror = parts.material(Scattering::Mirror { reflectance: tinted([0.9, 0.8, 0.7]) });
    let lamp = parts.emitter([2.0, 2.0, 3.0], false);
    parts.sphere(dvec3(-1.1, -0.3, 0.0), 0.7, clear);
    parts.sphere(dvec3(0.9, -0.4, 0.3), 0.6, mirror);
    parts.sphere(dvec3(0.2, 1.3, 0.2), 0.7, lamp);
    parts.0.environment = Some(tinted([0.4, 0.5, 0.6]).into());
    (parts.build(), camera(dvec3(0.0, 0.8, 5.0), dvec3(0.0, -0.1, 0.0)))
}

/// Rough metal balls between rectangles that emit.
fn rough_metal() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    floor_and_wall(&mut parts);
    let light = parts.emitter([2.5; 3], true);
    for (i, alpha) in [0.15, 0.4, 0.8].into_iter().enumerate() {
        let metal = parts.material(gold(alpha));
        parts.sphere(dvec3(1.4 * i as f64 - 1.4, -0.4, 0.0), 0.6, metal);
    }
    parts.rectangle(dvec3(-3.0, 2.0, -1.0), dvec3(6.0, 0.0, 0.0), dvec3(0.0, 1.0, 4.0), light);
    parts.0.environment = Some(Spectrum::splat(0.2).into());
    (parts.build(), camera(dvec3(0.0, 1.0, 5.0), dvec3(0.0, -0.2, 0.0)))
}

/// Rough glass and an MTL mixture, lit by a sky and a mesh that emits.
fn rough_glass() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    floor_and_wall(&mut parts);
    let frosted = parts.material(Scattering::RoughGlass {
        ior: 1.5,
        alpha: 0.3,
        reflection_tint: Spectrum::ONE,
        transmission_tint: tinted([0.9, 1.0, 0.9]),
    });
    let mixture = parts.material(Scattering::Mtl {
        diffuse: tinted([0.5, 0.2, 0.2]),
        specular: Spectrum::splat(0.3),
        alpha: 0.3,
        transmission: Spectrum::splat(0.2),
        ior: 1.3,
    });
    let glow = parts.emitter([1.5, 1.2, 0.9], false);
    parts.sphere(dvec3(-1.0, -0.3, 0.2), 0.7, frosted);
    let body = parts.shape(ball(2));
    parts.place(
        body,
        DAffine3::from_translation(dvec3(0.8, -0.4, 0.2)) * DAffine3::from_scale(DVec3::splat(0.6)),
        mixture,
    );
    let lamp = parts.shape(ball(1));
    parts.place(lamp, DAffine3::from_translation(dvec3(0.0, 1.4, 0.5)) * DAffine3::from_scale(DVec3::splat(0.8)), glow);
    parts.0.environment = Some(Spectrum::splat(0.3).into());
    (parts.build(), camera(dvec3(0.0, 0.8, 5.0), dvec3(0.0, -0.1, 0.0)))
}

/// Instances of one mesh: some emit, one is mirrored, all are turned and stretched; a leaf lets light through.
fn instances() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    floor_and_wall(&mut parts);
    let glow = parts.emitter([2.0, 2.0, 1.6], false);
    let leaf = parts
        .material(Scattering::Diffuse { reflectance: tinted([0.3, 0.5, 0.2]), transmittance: tinted([0.2, 0.4, 0.1]) });
    let body = parts.shape(ball(1));
    for i in 0..6 {
        let turn = DQuat::from_rotation_z(0.7 * f64::from(i)) * DQuat::from_rotation_x(0.4 * f64::from(i));
        let mirror = if i % 2 == 0 { 1.0 } else { -1.0 };
        let stretch = DVec3::new(0.35 * mirror, 0.5, 0.3);
        let at = dvec3(0.9 * f64::from(i) - 2.2, if i % 3 == 0 { 1.0 } else { -0.2 }, 0.2);
        let material = if i % 3 == 0 { glow } else { leaf };
        parts.place(body, DAffine3::from_scale_rotation_translation(stretch, turn, at), material);
    }
    parts.rectangle(dvec3(-1.0, -0.5, 1.0), dvec3(2.0, 0.0, 0.3), dvec3(0.0, 1.2, -0.2), leaf);
    parts.0.environment = Some(Spectrum::splat(0.25).into());
    (parts.build(), camera(dvec3(0.0, 0.8, 5.0), dvec3(0.0, 0.1, 0.0)))
}

/// Ellipsoids: one emits, one is glass; surfaces that are partly not there.
fn ellipsoids() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    floor_and_wall(&mut parts);
    let glow = parts.emitter([2.0, 1.8, 1.4], false);
    let clear = parts.material(glass(1.3));
    let veil = parts.diffuse([0.6, 0.5, 0.3]);
    parts.0.materials[veil].opacity = 0.5.into();
    let sphere = parts.shape(etendue::scene::Shape::Sphere { center: DVec3::ZERO, radius: 1.0 });
    let stretched = |at: DVec3, scale: DVec3| {
        DAffine3::from_translation(at) * DAffine3::from_rotation_z(0.5) * DAffine3::from_scale(scale)
    };
    parts.place(sphere, stretched(dvec3(0.4, 1.2, 0.3), dvec3(1.2, 0.4, 0.6)), glow);
    parts.place(sphere, stretched(dvec3(-1.1, -0.3, 0.2), dvec3(0.5, 0.7, 0.5)), clear);
    parts.place(sphere, stretched(dvec3(1.0, -0.4, 0.4), dvec3(0.7, 0.4, 0.5)), veil);
    parts.rectangle(dvec3(-2.0, 0.3, 0.5), dvec3(4.0, 0.0, 0.0), dvec3(0.0, 0.5, 0.5), veil);
    parts.0.environment = Some(Spectrum::splat(0.3).into());
    (parts.build(), camera(dvec3(0.0, 0.6, 5.0), dvec3(0.0, 0.1, 0.0)))
}

fn replicates(scene: &Scene, view: &CameraSettings, integrator: usize, spp: u32) -> Replicates {
    let mut all = Replicates::new(SIZE.map(|s| s as usize), 3, TILE);
    for replicate in 0..REPLICATES {
        let mut settings = statistics(SOLVERS[integrator], spp);
        settings.seed = 1000 * (integrator as u64 + 1) + replicate;
        settings.max_depth = Some(12);
        // What is split agrees with what is not.
        settings.splitting = Some([3, 1, 1][integrator]);
        all.push(&interleaved(&picture(scene, view, SIZE, &settings)));
    }
    all
}

fn solvers_agree(name: &str, (scene, view): (Scene, CameraSettings), spp: [u32; 3]) {
    let sets = [0, 1, 2].map(|i| replicates(&scene, &view, i, spp[i]));
    // The level is shared by the comparisons of all scenes.
    let demands = Demands { level: etendue_testkit::sidak(0.01, 12), ..Demands::default() };
    for other in [1, 2] {
        compare(&sets[0], &sets[other]).assert(demands, &format!("{name}: path against {}", SOLVERS[other]));
    }
}

#[test]
fn in_a_closed_room() {
    solvers_agree("room", room(), [32, 32, 64]);
}

#[test]
fn with_glass_under_a_sky() {
    solvers_agree("glass", glass_under_sky(), [32, 48, 64]);
}

#[test]
fn with_rough_metal() {
    solvers_agree("rough metal", rough_metal(), [32, 48, 48]);
}

#[test]
fn with_rough_glass() {
    solvers_agree("rough glass", rough_glass(), [32, 48, 64]);
}

#[test]
fn with_instances() {
    solvers_agree("instances", instances(), [32, 48, 64]);
}

#[test]
fn with_ellipsoids_and_veils() {
    solvers_agree("ellipsoids", ellipsoids(), [32, 48, 64]);
}

#[test]
fn a_planted_bias_of_one_per_cent_is_found() {
    let (scene, view) = room();
    let honest = replicates(&scene, &view, 0, 32);
    let mut biased = Replicates::new(SIZE.map(|s| s as usize), 3, TILE);
    for replicate in 0..REPLICATES {
        let mut settings = statistics(SOLVERS[1], 32);
        settings.seed = 5000 + replicate;
        settings.max_depth = Some(12);
        let picture = interleaved(&picture(&scene, &view, SIZE, &settings));
        biased.push(&picture.iter().map(|v| v * 1.01).collect::<Vec<_>>());
    }
    let demands = Demands { level: etendue_testkit::sidak(0.01, 12), ..Demands::default() };
    assert!(compare(&honest, &biased).check(demands).is_err(), "a bias of 1 % must be found");
}
