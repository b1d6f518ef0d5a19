//! Light samples out of several candidates: the same picture in the mean, with less error among many lamps.

mod common;

use common::*;
use etendue::{
    camera::CameraSettings,
    film::{Aov, Film, FilmSettings},
    integrator::Integrator,
    math::{DAffine3, DVec3, dvec3},
    render::{RenderControl, RenderSettings, render},
    scene::Scene,
};
use etendue_testkit::{Moments, Rng, sidak, ttest};

/// Lamps of several kinds over a floor with white balls, none of them in sight.
fn crowd(lamps: usize) -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let mut rng = Rng::new(11);
    let white = parts.diffuse([0.7, 0.6, 0.5]);
    parts.rectangle(dvec3(-3.0, 0.0, -3.0), dvec3(0.0, 0.0, 6.0), dvec3(6.0, 0.0, 0.0), white);
    parts.sphere(dvec3(-0.5, 0.3, 0.2), 0.3, white);
    parts.sphere(dvec3(0.4, 0.25, 0.4), 0.25, white);
    let colours = [[9.0, 6.0, 2.0], [2.0, 5.0, 9.0], [6.0, 6.0, 6.0]].map(|radiance| parts.emitter(radiance, false));
    let block = parts.shape(cube(false));
    for i in 0..lamps {
        let lamp = colours[i % 3];
        let at = dvec3(rng.range(-3.0, 3.0), rng.range(0.8, 2.5), rng.range(-3.0, 3.0));
        let mut edge = || DVec3::from(rng.direction()) * 0.1;
        let (u, v) = (edge(), edge());
        match i % 8 {
            0 => parts.sphere(at, 0.03, lamp),
            1 => {
                let small = DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(0.02));
                parts.place(block, small, lamp);
            }
            _ => parts.rectangle(at, u, v, lamp),
        }
    }
    (parts.build(), camera(dvec3(0.0, 0.9, 2.2), dvec3(0.0, 0.0, 0.0)))
}

/// Mean of a picture, mean variance of its pixels, and rays.
fn rendered((scene, view): &(Scene, CameraSettings), settings: &RenderSettings) -> (f64, f64, u64) {
    let aovs = vec![Aov::Variance];
    let film = FilmSettings { resolution: [32, 24], crop: None, aovs, transparent: false };
    let (film, control) = (Film::new(&film).expect("a film"), RenderControl::default());
    render(scene, view, settings, &film, &control).expect("valid settings");
    assert_eq!(film.left_out().count, 0);
    let image = film.develop();
    let mean = |name: &str| {
        let values = image.f32_channel(name).expect("a channel");
        values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
    };
    (mean("G"), mean("Variance.G"), control.rays())
}

fn settings(integrator: Integrator, seed: u64, resampling: Option<bool>) -> RenderSettings {
    let settings = RenderSettings { spp: 8, seed, integrator, resampling, ..RenderSettings::default() };
    RenderSettings { max_depth: Some(4), threads: 2, ..settings }
}

#[test]
fn resampling_changes_the_error_alone() {
    let room = crowd(150);
    for integrator in [Integrator::Path, Integrator::LightSplit] {
        let (mut difference, mut variances) = (Moments::new(), [0.0; 2]);
        for seed in 0..60 {
            let plain = rendered(&room, &settings(integrator, seed, Some(false)));
            let resampled = rendered(&room, &settings(integrator, 1000 + seed, Some(true)));
            difference.push(resampled.0 - plain.0);
            variances[0] += plain.1;
            variances[1] += resampled.1;
        }
        ttest::t_test(&difference, 0.0).assert(sidak(0.01, 2), &format!("{integrator}"));
        let ratio = variances[1] / variances[0];
        assert!(ratio < 0.7, "{integrator}: {ratio} of the variance");
    }
}

/// What is worth it is found out: the picture is one of the two, the same for any seed, and among few lamps there is no choice.
#[test]
fn resampling_is_chosen_where_it_pays() {
    let room = crowd(150);
    let rays = |resampling| rendered(&room, &settings(Integrator::Path, 3, resampling));
    let chosen = rays(None);
    assert!(chosen == rays(Some(true)) && chosen != rays(Some(false)));
    let few = crowd(1);
    let rays = |resampling| rendered(&few, &settings(Integrator::Path, 3, resampling));
    let plain = rays(None);
    assert!(plain == rays(Some(false)));
}
