//! Layers and transparent pictures of scenes with media.
#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue::{
    camera::{CameraSettings, Projection},
    film::{Aov, Film, FilmSettings},
    image::Image,
    integrator::Integrator,
    material::Scattering,
    math::{DAffine3, DVec3, dvec3},
    medium::Medium,
    render::{RenderControl, RenderSettings, render},
    scene::{Scene, Shape},
    spectrum::Spectrum,
};

const SIZE: [u32; 2] = [24, 24];

fn developed(
    scene: &Scene,
    view: &CameraSettings,
    settings: &RenderSettings,
    aovs: &[Aov],
    transparent: bool,
) -> Image {
    let film = FilmSettings { resolution: SIZE, crop: None, aovs: aovs.to_vec(), transparent };
    let film = Film::new(&film).expect("a valid film");
    render(scene, view, settings, &film, &RenderControl::default()).expect("valid settings");
    film.develop()
}

fn channel<'a>(image: &'a Image, name: &str) -> &'a [f32] {
    image.f32_channel(name).expect("the channel was asked for")
}

/// Two bodies of gas that overlap, invisible, before a wall, with a lamp; `world` fills the rest.
fn bodies_before_a_wall(world: bool) -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    for (name, scattering) in [("gas", 0.6), ("fog", 0.2)] {
        let scattering = Spectrum([scattering, 0.5 * scattering, 0.3]);
        parts.0.media.push(Medium { name: name.to_owned(), scattering, ..Medium::default() });
    }
    parts.0.world_medium = world.then(|| "fog".to_owned());
    for (x, priority) in [(-0.4, 1), (0.4, 2)] {
        let boundary = parts.material(Scattering::Black);
        parts.0.materials[boundary].opacity = 0.0.into();
        parts.0.materials[boundary].interior = Some("gas".to_owned());
        parts.0.materials[boundary].priority = Some(priority);
        let shape = parts.shape(cube(false));
        let to = DAffine3::from_translation(dvec3(x, 0.0, 0.0)) * DAffine3::from_scale(DVec3::splat(0.7));
        parts.place(shape, to, boundary);
    }
    let wall = parts.diffuse([0.5, 0.6, 0.7]);
    parts.rectangle(dvec3(-1.0, -3.0, -1.5), dvec3(4.0, 0.0, 0.0), dvec3(0.0, 6.0, 0.0), wall);
    let lamp = parts.emitter([4.0; 3], false);
    parts.sphere(dvec3(0.2, 1.2, 0.3), 0.3, lamp);
    (parts.build(), camera(dvec3(0.0, 0.2, 3.5), DVec3::ZERO))
}

/// Direct light is what a render sees whose paths end after two edges, also where an edge is in pieces of several media: but for
/// roundings of sums, since light that is longer arrives in between.
#[test]
fn direct_light_has_two_edges_in_media_too() {
    for world in [false, true] {
        let (scene, view) = bodies_before_a_wall(world);
        for integrator in SOLVERS {
            let settings = RenderSettings { max_depth: Some(6), splitting: Some(2), ..statistics(integrator, 16) };
            let two_edges = RenderSettings { max_depth: Some(2), ..settings.clone() };
            let two_edges = developed(&scene, &view, &two_edges, &[], false);
            let image = developed(&scene, &view, &settings, &[Aov::Direct], false);
            for name in ["R", "G", "B"] {
                let (direct, expected) = (channel(&image, &format!("Direct.{name}")), channel(&two_edges, name));
                let wrong = direct.iter().zip(expected).filter(|(a, b)| (*a - *b).abs() > 1e-5 * (1.0 + b.abs()));
                assert_eq!(wrong.count(), 0, "{integrator}, world {world}, {name}");
                let whole = channel(&image, name);
                assert!(
                    whole.iter().zip(direct).any(|(all, direct)| all > &(direct + 1e-3)),
                    "there is indirect light"
                );
            }
        }
    }
}

/// The first surface is kept whether or not gas scatters before it.
#[test]
fn layers_look_through_fog() {
    let (foggy, view) = bodies_before_a_wall(true);
    let settings = RenderSettings { max_depth: Some(4), ..statistics(Integrator::Path, 64) };
    let image = developed(&foggy, &view, &settings, &[Aov::Ids, Aov::Depth], false);
    let depth = channel(&image, "Depth.Z");
    // To the right of the bodies, the wall 5 m away.
    let pixel = 12 * 24 + 23;
    assert!((depth[pixel] - 5.0).abs() < 0.1, "depth {}", depth[pixel]);
}

/// A pixel of gas alone covers as much as the gas takes from the light, as the mean of its channels.
#[test]
fn gas_covers_what_is_behind_it() {
    for scattering in [[0.4, 0.1, 0.1], [0.0; 3]] {
        gas_covers(Spectrum([0.1, 0.2, 0.5]), Spectrum(scattering));
    }
}

fn gas_covers(absorption: Spectrum, scattering: Spectrum) {
    let mut parts = Parts::default();
    parts.0.media.push(Medium { name: "gas".to_owned(), absorption, scattering, ..Medium::default() });
    let boundary = parts.material(Scattering::Black);
    parts.0.materials[boundary].opacity = 0.0.into();
    parts.0.materials[boundary].interior = Some("gas".to_owned());
    let shape = parts.shape(cube(false));
    parts.place(shape, DAffine3::IDENTITY, boundary);
    parts.0.environment = Some(Spectrum::ONE.into());
    let scene = parts.build();
    let view = CameraSettings {
        projection: Projection::Orthographic { height: 0.1 },
        ..camera(dvec3(0.0, 0.0, 3.0), DVec3::ZERO)
    };
    let extinction = (absorption + scattering).0.map(f64::from);
    let exact = extinction.map(|k| 1.0 - (-2.0 * k).exp()).iter().sum::<f64>() / 3.0;
    let moments = (0..16)
        .map(|seed| {
            let settings = RenderSettings { seed, max_depth: Some(1), ..statistics(Integrator::Path, 64) };
            let image = developed(&scene, &view, &settings, &[], true);
            assert!(channel(&image, "R").iter().all(|value| *value == 0.0), "what is behind does not shine through");
            let alpha = channel(&image, "A");
            alpha.iter().map(|a| f64::from(*a)).sum::<f64>() / alpha.len() as f64
        })
        .collect();
    assert_mean("alpha", &moments, exact, 0.01);
}

/// The world's medium begins where rays do: it absorbs from there on, also where a body stands before.
#[test]
fn fog_begins_on_the_near_plane() {
    for near_clip in [0.0, 1.5, 2.5] {
        let mut parts = Parts::default();
        let absorption = Spectrum([0.1, 0.2, 0.5]);
        parts.0.media.push(Medium { name: "smoke".to_owned(), absorption, ..Medium::default() });
        parts.0.world_medium = Some("smoke".to_owned());
        let boundary = parts.material(Scattering::Black);
        parts.0.materials[boundary].opacity = 0.0.into();
        parts.0.materials[boundary].priority = Some(1);
        let (hollow, lamp) = (parts.shape(cube(false)), parts.emitter([1.0; 3], true));
        parts.place(hollow, DAffine3::IDENTITY, boundary);
        let wall =
            parts.shape(Shape::Rectangle { corner: dvec3(-9.0, -9.0, -2.0), u: DVec3::X * 18.0, v: DVec3::Y * 18.0 });
        parts.place(wall, DAffine3::IDENTITY, lamp);
        let view = CameraSettings {
            projection: Projection::Orthographic { height: 0.1 },
            near_clip,
            ..camera(dvec3(0.0, 0.0, 3.0), DVec3::ZERO)
        };
        let settings = RenderSettings { max_depth: Some(1), ..statistics(Integrator::Path, 2) };
        let image = developed(&parts.build(), &view, &settings, &[], false);
        // Before the body, two metres of nothing within, and behind it.
        let smoke = (2.0 - near_clip).max(0.0) + 1.0;
        for (name, k) in ["R", "G", "B"].into_iter().zip(absorption.0) {
            let exact = (-f64::from(k) * smoke).exp() as f32;
            let found = channel(&image, name);
            assert!(found.iter().all(|value| (value - exact).abs() < 1e-5), "{near_clip} {name}: {} {exact}", found[0]);
        }
    }
}
