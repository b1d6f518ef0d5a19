//! Where the error lies: pixels of a block share out their points, so that what is left of the noise once neighbours are averaged is less
//! than of independent pixels, with any number of samples.

mod common;

use common::*;
use etendue::{
    camera::CameraSettings,
    film::{Film, FilmSettings},
    math::{DAffine3, dvec3},
    render::{RenderControl, RenderSettings, render},
    sampling::Sampler,
    scene::Scene,
};

const SIDE: u32 = 48;
/// Pixels on each side of the middle over which pictures are blurred.
const REACH: usize = 4;

/// A block on a floor between two walls under a lamp.
fn room() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.7; 3]);
    let lamp = parts.emitter([20.0; 3], false);
    parts.rectangle(dvec3(-2.0, 0.0, -2.0), dvec3(0.0, 0.0, 4.0), dvec3(4.0, 0.0, 0.0), white);
    parts.rectangle(dvec3(-2.0, 0.0, -2.0), dvec3(4.0, 0.0, 0.0), dvec3(0.0, 3.0, 0.0), white);
    parts.rectangle(dvec3(-2.0, 0.0, -2.0), dvec3(0.0, 3.0, 0.0), dvec3(0.0, 0.0, 4.0), white);
    parts.rectangle(dvec3(-0.4, 2.5, -0.4), dvec3(0.8, 0.0, 0.0), dvec3(0.0, 0.0, 0.8), lamp);
    let block = parts.shape(cube(false));
    let turned = DAffine3::from_rotation_y(0.4) * DAffine3::from_scale(dvec3(0.4, 0.5, 0.4));
    parts.place(block, DAffine3::from_translation(dvec3(0.3, 0.5, 0.0)) * turned, white);
    (parts.build(), camera(dvec3(0.5, 2.0, 3.0), dvec3(-0.1, 0.6, -0.5)))
}

fn picture(scene: &Scene, view: &CameraSettings, sampler: Sampler, spp: u32, seed: u64) -> Vec<f64> {
    let settings = RenderSettings { spp, seed, sampler, max_depth: Some(4), threads: 2, ..RenderSettings::default() };
    let film = FilmSettings { resolution: [SIDE; 2], crop: None, aovs: Vec::new(), transparent: false };
    let film = Film::new(&film).expect("a film");
    render(scene, view, &settings, &film, &RenderControl::default()).expect("valid settings");
    film.develop().f32_channel("G").expect("a channel").iter().map(|v| f64::from(*v)).collect()
}

/// Mean square of a picture under a Gaussian of 1.5 pixels, over what it would be if pixels were independent.
fn left_of_noise(noise: &[f64]) -> [f64; 2] {
    let side = SIDE as usize;
    let weight = |x: usize, y: usize| {
        let squared = |at: usize| at.abs_diff(REACH) as f64 * at.abs_diff(REACH) as f64;
        libm::exp(-(squared(x) + squared(y)) / (2.0 * 1.5 * 1.5))
    };
    let window: Vec<_> = (0..=2 * REACH).flat_map(|y| (0..=2 * REACH).map(move |x| (x, y))).collect();
    let sum: f64 = window.iter().map(|&(x, y)| weight(x, y)).sum();
    let (mut blurred, mut alone) = (0.0, 0.0);
    for (left, top) in (0..side - 2 * REACH).flat_map(|y| (0..side - 2 * REACH).map(move |x| (x, y))) {
        let mut mean = 0.0;
        for &(x, y) in &window {
            let (weight, value) = (weight(x, y) / sum, noise[(top + y) * side + left + x]);
            mean += weight * value;
            alone += weight * weight * value * value;
        }
        blurred += mean * mean;
    }
    [blurred, alone]
}

#[test]
fn noise_goes_where_blurring_takes_it_away() {
    let (scene, view) = room();
    let ratio = |sampler, spp, pairs| {
        let (mut blurred, mut alone) = (0.0, 0.0);
        for pair in 0..pairs {
            let [a, b] = [0, 1].map(|i| picture(&scene, &view, sampler, spp, 2 * pair + i));
            let noise: Vec<f64> = a.iter().zip(&b).map(|(a, b)| a - b).collect();
            let [more, apart] = left_of_noise(&noise);
            blurred += more;
            alone += apart;
        }
        blurred / alone
    };
    let independent = ratio(Sampler::Independent, 4, 12);
    assert!((0.85..1.15).contains(&independent), "{independent}");
    let ratios = [(1, 16), (4, 16), (16, 8), (64, 4)].map(|(spp, pairs)| ratio(Sampler::Sobol, spp, pairs));
    for (ratio, most) in ratios.into_iter().zip([0.8, 0.8, 0.9, 1.0]) {
        assert!(ratio < most, "{ratios:?}");
    }
}
