//! The film through its public face: exactness, halves, layers, limits.

mod common;

use common::*;
use etendue::{
    film::{Aov, Film, FilmError, FilmSettings},
    image::{ChannelData, Image},
    integrator::Integrator,
    math::{DAffine3, DVec3, dvec3},
    render::{RenderControl, RenderError, RenderSettings, render},
    sampling::Sampler,
    scene::{DeltaLight, Scene},
    spectrum::Spectrum,
};
use etendue_testkit::{Moments, ttest::t_test};

fn film(resolution: [u32; 2], crop: Option<[u32; 4]>, aovs: &[Aov]) -> Result<Film, FilmError> {
    Film::new(&FilmSettings { resolution, crop, aovs: aovs.to_vec(), transparent: false })
}

fn developed(scene: &Scene, settings: &RenderSettings, aovs: &[Aov]) -> Image {
    let film = film([16, 16], None, aovs).expect("a film");
    let view = camera(dvec3(0.0, 0.5, 4.0), dvec3(0.0, 0.0, 0.0));
    render(scene, &view, settings, &film, &RenderControl::default()).expect("valid settings");
    film.develop()
}

fn lit_ball() -> Scene {
    let mut parts = Parts::default();
    let green = parts.diffuse([0.2, 0.6, 0.1]);
    let glow = parts.emitter([4.0, 4.0, 4.0], false);
    parts.sphere(DVec3::ZERO, 0.8, green);
    parts.rectangle(dvec3(-1.0, 2.0, -1.0), dvec3(2.0, 0.0, 0.0), dvec3(0.0, 0.0, 2.0), glow);
    parts.build()
}

#[test]
fn films_that_cannot_be_are_refused() {
    assert!(matches!(film([0, 5], None, &[]), Err(FilmError::Empty(..))));
    assert!(matches!(film([u32::MAX, u32::MAX], None, &[]), Err(FilmError::TooLarge(..))));
    assert!(matches!(film([8, 8], Some([2, 2, 2, 4]), &[]), Err(FilmError::Crop(..))));
    assert!(matches!(film([8, 8], Some([0, 0, 9, 4]), &[]), Err(FilmError::Crop(..))));
    assert!(film([8, 8], Some([7, 7, 8, 8]), &[]).is_ok());
}

#[test]
fn settings_out_of_range_are_refused() {
    let scene = lit_ball();
    let view = camera(dvec3(0.0, 0.5, 4.0), dvec3(0.0, 0.0, 0.0));
    let film = film([4, 4], None, &[]).expect("a film");
    let base = RenderSettings::default();
    for settings in [
        RenderSettings { spp: 0, ..base.clone() },
        RenderSettings { threads: 0, ..base.clone() },
        RenderSettings { tile: 0, ..base.clone() },
        RenderSettings { wave: u32::MAX, ..base.clone() },
        RenderSettings { max_depth: Some(0), ..base.clone() },
    ] {
        let error = render(&scene, &view, &settings, &film, &RenderControl::default());
        assert!(matches!(error, Err(RenderError::Range { .. })), "{settings:?}");
    }
    assert_eq!(film.sample_counts().total, 0);
}

/// The variance that the two halves tell is that of the mean over seeds, for points that are not independent too.
#[test]
fn variance_from_two_halves_is_that_of_repeated_renders() {
    let scene = lit_ball();
    for sampler in [Sampler::Independent, Sampler::Sobol] {
        let settings = |seed| RenderSettings { sampler, seed, ..statistics(Integrator::Path, 16) };
        let (mut told, mut pictures) = (Moments::new(), vec![Moments::new(); 256]);
        for seed in 0..96 {
            let image = developed(&scene, &settings(seed), &[Aov::Variance]);
            let variance = image.f32_channel("Variance.G").expect("a layer");
            told.push(variance.iter().map(|v| f64::from(*v)).sum::<f64>() / 256.0);
            for (pixel, value) in pictures.iter_mut().zip(image.f32_channel("G").expect("colour")) {
                pixel.push(f64::from(*value));
            }
        }
        let observed = pictures.iter().map(Moments::variance).sum::<f64>() / 256.0;
        let ratio = told.mean() / observed;
        assert!((0.9..1.1).contains(&ratio), "{sampler:?}: told {:.3e}, observed {observed:.3e}", told.mean());
        assert!(t_test(&told, 2.0 * observed).p_value < 1e-6, "the test can tell a factor of two");
    }
}

#[test]
fn one_half_alone_tells_no_variance() {
    let image = developed(&lit_ball(), &statistics(Integrator::Path, 1), &[Aov::Variance]);
    assert!(image.f32_channel("Variance.R").expect("a layer").iter().all(|v| v.is_infinite()));
}

#[test]
fn layers_hold_the_first_surface() {
    let image = developed(&lit_ball(), &statistics(Integrator::Path, 16), &Aov::ALL);
    let channel = |name: &str| image.f32_channel(name).unwrap_or_else(|| panic!("no channel {name}"));
    let centre = 8 * 16 + 8;
    assert!((channel("Albedo.G")[centre] - 0.6).abs() < 1e-5);
    let normal = [channel("N.X")[centre], channel("N.Y")[centre], channel("N.Z")[centre]];
    assert!(normal[2] > 0.9 && normal.iter().map(|c| c * c).sum::<f32>() <= 1.0 + 1e-5);
    let distance = (4.0f32 * 4.0 + 0.25).sqrt();
    assert!((channel("Depth.Z")[centre] - (distance - 0.8)).abs() < 0.02);
    let ids: Vec<_> = image.channels.iter().filter(|c| c.name.starts_with("Id.")).collect();
    assert_eq!(ids.len(), 2);
    for id in ids {
        let ChannelData::U32(data) = &id.data else { panic!("ids are integers") };
        assert_eq!((data[centre], data[0]), (1, 0), "{}", id.name);
    }
    assert_eq!(channel("Depth.Z")[0], 0.0);
}

#[test]
fn layers_do_not_change_the_colour() {
    let scene = lit_ball();
    let settings = statistics(Integrator::Path, 4);
    let colour = |aovs: &[Aov]| interleaved(&developed(&scene, &settings, aovs));
    assert_eq!(colour(&[]), colour(&Aov::ALL));
}

/// A sample too bright for the sums is left out, counted and located; the picture stays finite.
#[test]
fn samples_out_of_range_are_counted_and_located() {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.8; 3]);
    parts.rectangle(dvec3(-5.0, -1.0, -5.0), dvec3(0.0, 0.0, 10.0), dvec3(10.0, 0.0, 0.0), white);
    parts.0.delta_lights.push(DeltaLight::Point { position: dvec3(0.0, 1.0, 0.0), intensity: Spectrum::splat(1e20) });
    let scene = parts.build();
    let film = film([8, 8], None, &[]).expect("a film");
    let view = camera(dvec3(0.0, 0.5, 4.0), dvec3(0.0, 0.0, 0.0));
    render(&scene, &view, &statistics(Integrator::Path, 2), &film, &RenderControl::default()).expect("valid");
    let left_out = film.left_out();
    assert!(left_out.count > 0);
    let [_, y] = left_out.first.expect("a place");
    assert!(y >= 3, "the floor is in the lower half, not in row {y}");
    assert!(interleaved(&film.develop()).iter().all(|v| v.is_finite()));
}

#[test]
fn an_empty_scene_is_its_sky() {
    let mut parts = Parts::default();
    parts.0.environment = Some(Spectrum([0.25, 0.5, 0.75]).into());
    let scene = parts.build();
    let image = developed(&scene, &statistics(Integrator::Path, 3), &Aov::ALL);
    assert!(interleaved(&image).chunks(3).all(|p| p == [0.25, 0.5, 0.75]));
}

#[test]
fn a_second_render_adds_to_the_first() {
    // Sums are exact, so two renders into one film are the same as their samples in any order.
    let scene = lit_ball();
    let view = camera(dvec3(0.0, 0.5, 4.0), dvec3(0.0, 0.0, 0.0));
    let of = |seeds: [u64; 2]| {
        let film = film([8, 8], None, &[]).expect("a film");
        for seed in seeds {
            let settings = RenderSettings { seed, ..statistics(Integrator::Path, 5) };
            render(&scene, &view, &settings, &film, &RenderControl::default()).expect("valid");
        }
        assert_eq!(film.sample_counts().min, 10);
        interleaved(&film.develop())
    };
    assert_eq!(of([1, 2]), of([2, 1]));
}

#[test]
fn moving_the_whole_scene_does_not_change_the_picture() {
    // Recentring takes the shift out again, up to the rounding of f64.
    let make = |shift: DVec3| {
        let mut parts = Parts::default();
        let white = parts.diffuse([0.7; 3]);
        let body = parts.shape(ball(2));
        parts.place(body, DAffine3::from_translation(shift), white);
        parts.0.environment = Some(Spectrum::ONE.into());
        let view = camera(shift + dvec3(0.0, 0.5, 4.0), shift);
        interleaved(&picture(&parts.build(), &view, [16, 16], &statistics(Integrator::Path, 4)))
    };
    let (here, there) = (make(DVec3::ZERO), make(dvec3(16384.0, -8192.0, 32768.0)));
    let unequal = here.iter().zip(&there).filter(|(a, b)| (*a - *b).abs() > 1e-3).count();
    assert!(unequal * 50 < here.len(), "{unequal} of {} numbers differ", here.len());
}
