//! Brushed metal in scenes: the solvers agree, and arcs are worth their cost.

#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue::{
    bsdf::GrooveForm,
    camera::CameraSettings,
    integrator::Integrator,
    material::{Number, Scattering, Tangent, TangentField},
    math::{DAffine3, DVec3, dvec3},
    scene::{Mesh, Scene, Shape},
    spectrum::Spectrum,
    texture::{Samples, Texture, TextureImage, Transfer},
};
use etendue_testkit::tiles::{Demands, Replicates, compare};
use std::{sync::Arc, time::Instant};

const SIZE: [u32; 2] = [24, 24];
const TILE: usize = 8;
const REPLICATES: u64 = 32;
/// Comparisons that share a level.
const FAMILY: u32 = 6;

fn brushed(parts: &mut Parts, exponent: f32, form: GrooveForm, tangent: Tangent) -> usize {
    let reflectance = Spectrum([0.9, 0.8, 0.7]);
    let material = parts.material(Scattering::BrushedMetal { reflectance, exponent, form });
    parts.0.materials[material].tangent = TangentField { direction: tangent, rotation: 0.0.into() };
    material
}

fn radial(center: DVec3) -> Tangent {
    Tangent::Radial { center, axis: None }
}

fn floor(parts: &mut Parts, material: usize) {
    parts.rectangle(dvec3(-4.0, -1.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(8.0, 0.0, 0.0), material);
}

fn view() -> CameraSettings {
    camera(dvec3(0.0, 0.8, 5.0), dvec3(0.0, -0.3, 0.0))
}

/// A pan of the default form, a wall, and lamps of three shapes, two of them not seen by the camera.
fn three_lamps() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let pan = brushed(&mut parts, 20.0, GrooveForm::Reciprocal, radial(dvec3(0.0, -1.0, 0.5)));
    let wall = parts.diffuse([0.3, 0.4, 0.6]);
    let (lamp, both) = (parts.emitter([3.0, 2.5, 2.0], false), parts.emitter([2.0, 2.5, 3.0], true));
    floor(&mut parts, pan);
    parts.rectangle(dvec3(-4.0, -1.0, -2.0), dvec3(8.0, 0.0, 0.0), dvec3(0.0, 6.0, 0.0), wall);
    parts.sphere(dvec3(-1.2, 0.3, -0.5), 0.5, lamp);
    parts.rectangle(dvec3(0.8, 1.4, -1.0), dvec3(1.2, 0.0, 0.0), dvec3(0.0, 0.2, 1.5), both);
    let triangle = mesh(vec![[0.4, 0.0, -1.0], [1.6, 0.2, -1.2], [1.2, 1.0, -0.8]], vec![[0, 1, 2]]);
    let triangle = parts.shape(triangle);
    parts.place(triangle, DAffine3::IDENTITY, lamp);
    (parts.build(), view())
}

/// Curved bodies of the normalised form under a sky, with a lamp of more triangles than are looked at one by one, an ellipsoid,
/// and a screen with a picture.
fn many_lamps() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let brass = brushed(&mut parts, 60.0, GrooveForm::Normalised, Tangent::Uv);
    let steel = brushed(&mut parts, 8.0, GrooveForm::Normalised, Tangent::Constant(dvec3(1.0, 0.0, 1.0)));
    let lamp = parts.emitter([2.0, 1.8, 1.5], false);
    let screen = parts.emitter([1.0; 3], false);
    let picture = (0..6 * 4).map(|i| [0.0, 4.0, 1.0, 2.0, 0.0][i % 5]).collect::<Vec<f32>>();
    let image = TextureImage::new(6, 4, 1, Samples::F32(picture.into()), Transfer::Linear).expect("an image");
    let emission = parts.0.materials[screen].emission.as_mut().expect("it emits");
    emission.radiance.texture = Some(Arc::new(Texture::new(Arc::new(image))));
    floor(&mut parts, steel);
    parts.sphere(dvec3(-0.9, -0.3, 0.0), 0.7, brass);
    parts.rectangle(dvec3(-2.0, -0.8, -1.5), dvec3(4.0, 0.0, 0.0), dvec3(0.0, 2.0, -0.5), screen);
    let (body, egg) = (parts.shape(ball(2)), parts.shape(Shape::Sphere { center: DVec3::ZERO, radius: 1.0 }));
    parts.place(body, DAffine3::from_translation(dvec3(1.0, 1.3, 0.5)) * DAffine3::from_scale(DVec3::splat(0.5)), lamp);
    parts.place(
        egg,
        DAffine3::from_translation(dvec3(1.1, -0.5, 0.6)) * DAffine3::from_scale(dvec3(0.5, 0.2, 0.3)),
        lamp,
    );
    parts.0.environment = Some(Spectrum::splat(0.3).into());
    (parts.build(), view())
}

/// Interpolated normals, veils before lamps, a lamp around everything, grooves turned by a texture.
fn inside_a_lamp() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let metal = brushed(&mut parts, 3.0, GrooveForm::Reciprocal, radial(dvec3(0.0, 0.5, 0.0)));
    let image = TextureImage::new(2, 2, 1, Samples::F32(vec![0.0, 1.0, 0.3, 0.7].into()), Transfer::Linear);
    let texture = Some(Arc::new(Texture::new(Arc::new(image.expect("an image")))));
    parts.0.materials[metal].tangent.rotation = Number { factor: 3.0, texture };
    let room = parts.diffuse([0.5; 3]);
    let room = parts.emitting(room, [0.5, 0.6, 0.7], true);
    let lamp = parts.emitter([3.0, 2.0, 1.0], false);
    let veil = parts.diffuse([0.6, 0.5, 0.3]);
    parts.0.materials[veil].opacity = 0.5.into();
    let Shape::Mesh(ball) = ball(1) else { unreachable!("a ball is a mesh") };
    let normals = ball.positions.clone();
    let smooth = parts.shape(Shape::Mesh(Mesh { normals: Some(normals), ..ball }));
    parts.place(smooth, DAffine3::from_scale(DVec3::splat(0.9)), metal);
    parts.sphere(DVec3::ZERO, 7.0, room);
    parts.rectangle(dvec3(-1.0, 1.5, -0.5), dvec3(2.0, 0.0, 0.0), dvec3(0.0, 0.0, 1.0), lamp);
    parts.rectangle(dvec3(-1.0, 1.2, 0.0), dvec3(2.0, 0.0, 0.0), dvec3(0.0, 0.0, 0.5), veil);
    (parts.build(), view())
}

fn replicates(scene: &Scene, view: &CameraSettings, integrator: usize, spp: u32) -> Replicates {
    let mut all = Replicates::new(SIZE.map(|s| s as usize), 3, TILE);
    for replicate in 0..REPLICATES {
        let mut settings = statistics(SOLVERS[integrator], spp);
        settings.seed = 1000 * (integrator as u64 + 1) + replicate;
        settings.max_depth = Some(6);
        all.push(&interleaved(&picture(scene, view, SIZE, &settings)));
    }
    all
}

fn solvers_agree(name: &str, (scene, view): (Scene, CameraSettings), spp: [u32; 3]) {
    let sets = [0, 1, 2].map(|i| replicates(&scene, &view, i, spp[i]));
    let demands = Demands { level: etendue_testkit::sidak(0.01, FAMILY as usize), ..Demands::default() };
    for other in [1, 2] {
        compare(&sets[0], &sets[other]).assert(demands, &format!("{name}: path against {}", SOLVERS[other]));
    }
}

#[test]
fn solvers_agree_with_lamps_of_every_shape() {
    solvers_agree("three lamps", three_lamps(), [32, 48, 96]);
}

#[test]
fn solvers_agree_with_many_lamps_and_a_sky() {
    solvers_agree("many lamps", many_lamps(), [48, 96, 96]);
}

#[test]
fn solvers_agree_inside_a_lamp() {
    solvers_agree("inside a lamp", inside_a_lamp(), [32, 48, 48]);
}

/// A lamp of 5 cm radius, 4 m over a brushed floor and out of sight.
fn small_lamp() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let pan = brushed(&mut parts, 20.0, GrooveForm::Reciprocal, radial(dvec3(0.3, -1.0, 0.4)));
    let lamp = parts.emitter([100.0; 3], false);
    floor(&mut parts, pan);
    parts.sphere(dvec3(0.4, 3.0, -1.0), 0.05, lamp);
    (parts.build(), view())
}

/// Mean variance of the pixels of one sample's estimate, from independent pictures, with the standard error of its logarithm;
/// and seconds.
fn variance(scene: &Scene, view: &CameraSettings, integrator: Integrator, spp: u32, seed: u64) -> (f64, f64, f64) {
    let pictures = 24;
    let start = Instant::now();
    let values: Vec<Vec<f32>> = (0..pictures)
        .map(|i| {
            let mut settings = statistics(integrator, spp);
            (settings.seed, settings.max_depth) = (seed + i, Some(2));
            interleaved(&picture(scene, view, [32, 32], &settings))
        })
        .collect();
    let seconds = start.elapsed().as_secs_f64();
    // Squared differences of pairs of pictures are independent estimates of twice the variance.
    let pairs: etendue_testkit::Moments = values
        .chunks_exact(2)
        .map(|pair| {
            let squares = pair[0].iter().zip(&pair[1]).map(|(a, b)| f64::from(a - b) * f64::from(a - b));
            0.5 * squares.sum::<f64>() / pair[0].len() as f64 * f64::from(spp)
        })
        .collect();
    (pairs.mean(), pairs.standard_error() / pairs.mean(), seconds)
}

/// Treating the lobe as a Dirac, as a renderer does that knows no arcs, is what `brute` does there: lamps are found by chance.
#[test]
fn arcs_of_a_small_lamp_lower_the_variance_at_least_twentyfold() {
    let (scene, view) = small_lamp();
    let scale = if proving() { 16 } else { 1 };
    let (by_lobe, error_lobe, seconds_lobe) = variance(&scene, &view, Integrator::Brute, 64 * scale, 100);
    let (by_arcs, error_arcs, seconds_arcs) = variance(&scene, &view, Integrator::Path, 64 * scale, 900);
    let ratio = by_lobe / by_arcs;
    // One-sided 95 % of a normal distribution of the logarithm, t with 11 degrees of freedom: 1.796.
    let lower = ratio * (-1.796 * error_lobe.hypot(error_arcs)).exp();
    let at_equal_time = lower * seconds_lobe / seconds_arcs;
    println!("variance over {ratio:.0}, at least {lower:.0}; at equal time at least {at_equal_time:.0}");
    assert!(lower >= 20.0, "only {lower} of {ratio}");
    assert!(at_equal_time >= 20.0, "only {at_equal_time} at equal time");
}

/// Fields are of the world: a scene moved as a whole, with its centres, is the same picture.
#[test]
fn a_moved_scene_with_its_centre_is_the_same() {
    let at = |offset: DVec3| {
        let mut parts = Parts::default();
        let center = offset + dvec3(0.25, -1.0, 0.5);
        let pan = brushed(&mut parts, 20.0, GrooveForm::Normalised, radial(center));
        let lamp = parts.emitter([3.0; 3], false);
        parts.rectangle(offset + dvec3(-4.0, -1.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(8.0, 0.0, 0.0), pan);
        parts.sphere(offset + dvec3(0.5, 0.5, -1.0), 0.5, lamp);
        let view = camera(offset + dvec3(0.0, 0.75, 5.0), offset);
        interleaved(&picture(&parts.build(), &view, SIZE, &statistics(Integrator::Path, 64)))
    };
    let (here, there) = (at(DVec3::ZERO), at(dvec3(65536.0, -32768.0, 16384.0)));
    let difference: f32 = here.iter().zip(&there).map(|(a, b)| (a - b).abs()).sum::<f32>() / here.iter().sum::<f32>();
    assert!(difference < 0.01, "{difference}");
}
