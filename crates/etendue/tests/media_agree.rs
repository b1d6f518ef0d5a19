//! Light in media by three integrators: `path` joins free flights, distances about lights and phase functions; `light-split` has
//! light samples alone; `brute` has free flights and phase functions alone, which is plain delta tracking.

mod common;

use common::*;
use etendue::{
    camera::CameraSettings,
    integrator::Integrator,
    material::Scattering,
    math::{DAffine3, DVec3, dvec3},
    medium::{Medium, PhaseKind},
    render::RenderSettings,
    scene::Scene,
    spectrum::Spectrum,
};
use etendue_testkit::{
    Moments,
    tiles::{Demands, Replicates, compare},
};

const SIZE: [u32; 2] = [16, 16];
const TILE: usize = 8;
const REPLICATES: u64 = 32;

fn medium(name: &str, absorption: [f32; 3], scattering: [f32; 3], phase: PhaseKind) -> Medium {
    Medium {
        name: name.to_owned(),
        absorption: Spectrum(absorption),
        scattering: Spectrum(scattering),
        phase: phase.into(),
        ..Medium::default()
    }
}

fn glass(ior: f32) -> Scattering {
    let white = Spectrum::ONE;
    Scattering::Glass { ior, reflection_tint: white, transmission_tint: white, thin: false }
}

fn body(parts: &mut Parts, scattering: Scattering, interior: Option<&str>, priority: Option<i32>) -> usize {
    let material = parts.material(scattering);
    if scattering == Scattering::Black {
        parts.0.materials[material].opacity = 0.0.into();
    }
    parts.0.materials[material].interior = interior.map(str::to_owned);
    parts.0.materials[material].priority = priority;
    material
}

/// A sphere that shines in fog, over a floor.
fn lamp_in_fog() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    parts.0.media.push(medium("fog", [0.02; 3], [0.15; 3], PhaseKind::Isotropic));
    parts.0.world_medium = Some("fog".to_owned());
    let floor = parts.diffuse([0.6; 3]);
    parts.rectangle(dvec3(-4.0, -1.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(8.0, 0.0, 0.0), floor);
    let lamp = parts.emitter([4.0, 3.0, 2.0], false);
    parts.sphere(dvec3(0.3, 0.5, 0.0), 0.5, lamp);
    (parts.build(), camera(dvec3(0.0, 0.5, 4.0), dvec3(0.0, 0.1, 0.0)))
}

/// Gas of strong colours that scatters forward, between triangles that shine.
fn coloured_gas() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let forward = PhaseKind::HenyeyGreenstein { g: 0.5 };
    parts.0.media.push(medium("gas", [0.0, 0.3, 0.9], [0.8, 0.2, 0.05], forward));
    parts.0.world_medium = Some("gas".to_owned());
    let wall = parts.diffuse([0.5, 0.7, 0.7]);
    let room = parts.shape(cube(true));
    parts.place(room, DAffine3::from_scale(DVec3::splat(2.0)), wall);
    let glow = parts.emitter([3.0; 3], false);
    let lamp = parts.shape(ball(0));
    parts.place(lamp, DAffine3::from_translation(dvec3(0.6, 0.4, 0.0)) * DAffine3::from_scale(DVec3::splat(0.7)), glow);
    (parts.build(), camera(dvec3(-0.4, 0.1, 1.9), dvec3(0.2, 0.1, 0.0)))
}

/// A body of milk in a clear boundary and one in glass, over a floor, under a rectangle that shines.
fn bodies_of_milk() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    parts.0.media.push(medium("milk", [0.05, 0.1, 0.3], [2.0, 1.5, 1.0], PhaseKind::LambertSphere));
    let cloud = body(&mut parts, Scattering::Black, Some("milk"), None);
    let filled = body(&mut parts, glass(1.3), Some("milk"), None);
    let floor = parts.diffuse([0.6; 3]);
    parts.rectangle(dvec3(-4.0, -1.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(8.0, 0.0, 0.0), floor);
    let light = parts.emitter([2.5; 3], true);
    parts.rectangle(dvec3(-2.0, 2.0, -1.5), dvec3(4.0, 0.0, 0.0), dvec3(0.0, 0.3, 3.0), light);
    let shape = parts.shape(cube(false));
    let at = |x: f64| DAffine3::from_translation(dvec3(x, -0.2, 0.0)) * DAffine3::from_rotation_y(0.5);
    parts.place(shape, at(-1.0) * DAffine3::from_scale(DVec3::splat(0.6)), cloud);
    parts.place(shape, at(1.0) * DAffine3::from_scale(DVec3::splat(0.6)), filled);
    (parts.build(), camera(dvec3(0.0, 0.8, 4.5), dvec3(0.0, -0.1, 0.0)))
}

/// From inside of a cloud within a ball of thin gas, under a sky, with a body of higher priority and a leaf that is half there.
fn inside_of_clouds() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    parts.0.media.push(medium("gas", [0.02, 0.02, 0.1], [0.2, 0.3, 0.4], PhaseKind::Rayleigh));
    parts.0.media.push(medium("cloud", [0.0; 3], [1.2, 1.0, 0.8], PhaseKind::HenyeyGreenstein { g: 0.3 }));
    let gas = body(&mut parts, Scattering::Black, Some("gas"), Some(1));
    let cloud = body(&mut parts, Scattering::Black, Some("cloud"), Some(2));
    let clear = body(&mut parts, glass(1.4), None, Some(3));
    parts.sphere(DVec3::ZERO, 2.0, gas);
    let shape = parts.shape(cube(false));
    parts.place(shape, DAffine3::from_scale(DVec3::splat(0.7)), cloud);
    parts.sphere(dvec3(0.4, 0.1, -0.8), 0.5, clear);
    let leaf = parts.diffuse([0.5, 0.6, 0.2]);
    parts.0.materials[leaf].opacity = 0.5.into();
    parts.rectangle(dvec3(-0.8, -0.6, -1.2), dvec3(0.8, 0.0, 0.3), dvec3(0.0, 1.0, 0.0), leaf);
    let lamp = parts.emitter([3.0, 2.0, 1.0], false);
    parts.sphere(dvec3(-1.0, 1.2, -1.5), 0.6, lamp);
    parts.0.environment = Some(Spectrum([0.4, 0.5, 0.7]).into());
    (parts.build(), camera(dvec3(0.1, 0.05, 0.3), dvec3(0.0, 0.1, -1.0)))
}

fn replicates(scene: &Scene, view: &CameraSettings, integrator: usize, spp: u32) -> Replicates {
    let mut all = Replicates::new(SIZE.map(|s| s as usize), 3, TILE);
    for replicate in 0..REPLICATES {
        let mut settings = statistics(SOLVERS[integrator], spp);
        settings.seed = 1000 * (integrator as u64 + 1) + replicate;
        settings.max_depth = Some(10);
        // What is split agrees with what is not.
        settings.splitting = Some([3, 1, 1][integrator]);
        all.push(&interleaved(&picture(scene, view, SIZE, &settings)));
    }
    all
}

fn solvers_agree(name: &str, (scene, view): (Scene, CameraSettings), spp: [u32; 3]) {
    let spp = spp.map(|spp| if proving() { 8 * spp } else { spp });
    let sets = [0, 1, 2].map(|i| replicates(&scene, &view, i, spp[i]));
    // The level is shared by the comparisons of all scenes.
    let demands = Demands { level: etendue_testkit::sidak(0.01, 8), ..Demands::default() };
    for other in [1, 2] {
        compare(&sets[0], &sets[other]).assert(demands, &format!("{name}: path against {}", SOLVERS[other]));
    }
}

#[test]
fn about_a_lamp_in_fog() {
    solvers_agree("fog", lamp_in_fog(), [96, 128, 192]);
}

#[test]
fn in_coloured_gas() {
    solvers_agree("gas", coloured_gas(), [96, 128, 96]);
}

#[test]
fn on_bodies_of_milk() {
    solvers_agree("milk", bodies_of_milk(), [64, 64, 144]);
}

#[test]
fn from_inside_of_clouds() {
    solvers_agree("clouds", inside_of_clouds(), [64, 96, 96]);
}

/// A small lamp in thin fog: its radius is 1 % of the scene's. The room is black, so that all light but the lamp's own has been
/// scattered in the fog.
fn small_lamp() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    parts.0.media.push(medium("fog", [0.0; 3], [0.1; 3], PhaseKind::Isotropic));
    parts.0.world_medium = Some("fog".to_owned());
    let wall = parts.material(Scattering::Black);
    parts.sphere(DVec3::ZERO, 1.0, wall);
    let lamp = parts.emitter([1e4; 3], false);
    parts.sphere(dvec3(0.0, 0.2, -0.2), 0.01, lamp);
    // The lamp itself, which all find alike, is outside of the picture.
    (parts.build(), camera(dvec3(0.0, 0.0, 0.9), dvec3(0.0, -0.3, -0.2)))
}

/// Variance of a sample times the seconds that it takes: that of pixels over independent pictures, and their mean.
fn cost(integrator: Integrator, spp: u32, (scene, view): &(Scene, CameraSettings), seed: u64) -> f64 {
    let mut pixels = vec![Moments::new(); (SIZE[0] * SIZE[1]) as usize];
    let start = std::time::Instant::now();
    for replicate in 0..8 {
        let settings = RenderSettings { seed: 100 * seed + replicate, ..statistics(integrator, spp) };
        let values = interleaved(&picture(scene, view, SIZE, &settings));
        for (pixel, value) in pixels.iter_mut().zip(values.chunks(3)) {
            pixel.push(f64::from(value[0]));
        }
    }
    let seconds = start.elapsed().as_secs_f64();
    seconds * pixels.iter().map(Moments::variance).sum::<f64>() / pixels.len() as f64
}

/// How many times the variance of free flights and phase functions alone is that of all techniques together, in equal time.
/// The former is underestimated if anything: few of its pictures have the bright points that it is made of. With a quarter of its samples
/// all eight pictures of a seed may be without any.
#[test]
fn distances_about_a_small_lamp_pay() {
    let scene = small_lamp();
    let logarithms: Moments = (0..8)
        .map(|seed| {
            let [path, brute] =
                [(Integrator::Path, 4), (Integrator::Brute, 256)].map(|(i, spp)| cost(i, spp, &scene, seed));
            libm::log(brute / path)
        })
        .collect();
    // Student's t for a one-sided level of 5 % and 7 degrees of freedom.
    let lower = libm::exp(logarithms.mean() - 1.895 * logarithms.standard_error());
    println!("variance in equal time: {:.1} times lower, at least {lower:.1}", libm::exp(logarithms.mean()));
    assert!(lower >= 3.0, "the variance is lower by {lower:.2} at least, not by 3");
}
