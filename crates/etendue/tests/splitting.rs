//! Splitting: the same picture in the mean, with less error in the same time where it is chosen.

mod common;

use common::*;
use etendue::{
    camera::CameraSettings,
    film::{Aov, Film, FilmSettings},
    image::Image,
    integrator::Integrator,
    material::Scattering,
    math::{DAffine3, DVec3, dvec3},
    render::{RenderControl, RenderError, RenderSettings, render},
    scene::Scene,
    spectrum::Spectrum,
};

/// A closed room with a lamp, a mirror ball and a white one.
fn room() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.7; 3]);
    let mirror = parts.material(Scattering::Mirror { reflectance: Spectrum::splat(0.9) });
    let lamp = parts.emitter([6.0, 5.0, 4.0], false);
    let walls = parts.shape(cube(true));
    parts.place(walls, DAffine3::from_scale(DVec3::splat(2.0)), white);
    parts.rectangle(dvec3(-0.5, 1.95, -0.5), dvec3(1.0, 0.0, 0.0), dvec3(0.0, 0.0, 1.0), lamp);
    parts.sphere(dvec3(-0.8, -1.3, -0.3), 0.7, mirror);
    parts.sphere(dvec3(0.8, -1.3, 0.2), 0.7, white);
    (parts.build(), camera(dvec3(0.2, 0.1, 1.9), dvec3(0.0, -0.6, -1.0)))
}

fn developed(scene: &Scene, view: &CameraSettings, settings: &RenderSettings, transparent: bool) -> (Image, u64) {
    let aovs = vec![Aov::Direct, Aov::Variance, Aov::Normal];
    let film = Film::new(&FilmSettings { resolution: [32, 24], crop: None, aovs, transparent }).expect("a film");
    let control = RenderControl::default();
    render(scene, view, settings, &film, &control).expect("valid settings");
    assert_eq!(film.left_out().count, 0);
    (film.develop(), control.rays())
}

fn channel<'a>(image: &'a Image, name: &str) -> &'a [f32] {
    image.f32_channel(name).unwrap_or_else(|| panic!("no channel {name}"))
}

fn mean(values: &[f32]) -> f64 {
    values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
}

/// On a white wall in a room nearly all of the error is from where light has been before: as many parts of a sample as samples do
/// as well, and what they cost less is the way from the camera.
#[test]
fn parts_do_as_well_as_samples() {
    let (scene, _) = room();
    // A wall and nothing else: no edges, of which parts know nothing.
    let view = camera(dvec3(0.0, 0.2, -0.5), dvec3(0.0, 0.3, -2.0));
    let error_and_rays = |spp, splitting| {
        let settings = RenderSettings {
            max_depth: Some(6),
            splitting: Some(splitting),
            ..RenderSettings { spp, threads: 2, ..RenderSettings::default() }
        };
        let (image, rays) = developed(&scene, &view, &settings, false);
        let error: f64 = ["R", "G", "B"].iter().map(|c| mean(channel(&image, &format!("Variance.{c}")))).sum();
        (error, rays as f64)
    };
    let (samples, parts) = (error_and_rays(64, 1), error_and_rays(16, 4));
    assert!(parts.0 < 1.35 * samples.0, "error {:.2e} of parts, {:.2e} of samples", parts.0, samples.0);
    assert!(parts.1 < 0.92 * samples.1, "{} rays of parts, {} of samples", parts.1, samples.1);
    let once = error_and_rays(16, 1);
    assert!(once.0 > 2.5 * parts.0, "error {:.2e} of one part, {:.2e} of four", once.0, parts.0);
}

/// What is known from the first hit does not change, and direct light does not in the mean.
#[test]
fn layers_are_those_of_whole_samples() {
    let (scene, view) = room();
    let settings = |splitting, integrator| RenderSettings {
        splitting: Some(splitting),
        max_depth: Some(5),
        ..statistics(integrator, 256)
    };
    for integrator in SOLVERS {
        let image = |splitting| developed(&scene, &view, &settings(splitting, integrator), true).0;
        let (whole, split) = (image(1), image(5));
        for name in ["N.X", "N.Y", "N.Z", "A"] {
            assert_eq!(channel(&whole, name), channel(&split, name), "{integrator} {name}");
        }
        let (a, b) = (mean(channel(&whole, "Direct.R")), mean(channel(&split, "Direct.R")));
        assert!((a - b).abs() < 0.03 * a, "{integrator}: direct light {a}, {b} in parts");
    }
}

#[test]
fn nothing_is_split_in_more_parts_than_there_may_be() {
    let (scene, view) = room();
    let film = Film::new(&FilmSettings { resolution: [4, 4], crop: None, aovs: vec![], transparent: false });
    let film = film.expect("a film");
    for (splitting, valid) in [(0, false), (1, true), (16, true), (17, false)] {
        let settings = RenderSettings { splitting: Some(splitting), ..statistics(Integrator::Path, 1) };
        let result = render(&scene, &view, &settings, &film, &RenderControl::default());
        match result {
            Ok(()) => assert!(valid, "{splitting}"),
            Err(RenderError::Range { name, .. }) => assert!(!valid && name == "splitting", "{splitting}"),
            Err(other) => panic!("{other}"),
        }
    }
}

/// A picture with the number of parts left open is one of those with a number given; of one pixel too.
#[test]
fn the_choice_is_one_of_the_numbers() {
    let (scene, view) = room();
    for size in [[1, 1], [3, 40], [40, 30]] {
        let picture = |splitting| {
            let settings = RenderSettings { spp: 2, splitting, max_depth: Some(6), ..RenderSettings::default() };
            interleaved(&picture(&scene, &view, size, &settings))
        };
        let chosen = picture(None);
        let matches = [1, 2, 4, 8, 16].into_iter().filter(|parts| picture(Some(*parts)) == chosen);
        assert_eq!(matches.count(), 1, "{size:?}");
    }
}
