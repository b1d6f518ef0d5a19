//! The layers beside the colour, and transparent pictures.

mod common;

use common::*;
use etendue::{
    film::{Aov, Film, FilmSettings},
    image::{ChannelData, Image},
    integrator::Integrator,
    material::Scattering,
    math::{DVec3, dvec3},
    render::{RenderControl, RenderSettings, render},
    sampling::{Filter, Sampler},
    scene::Scene,
    spectrum::Spectrum,
};

const SIDE: u32 = 24;

fn developed(scene: &Scene, settings: &RenderSettings, aovs: &[Aov], transparent: bool, shift: DVec3) -> Image {
    let settings_of_film = FilmSettings { resolution: [SIDE; 2], crop: None, aovs: aovs.to_vec(), transparent };
    let film = Film::new(&settings_of_film).expect("a film");
    let view = camera(shift + dvec3(0.0, 0.0, 5.0), shift);
    render(scene, &view, settings, &film, &RenderControl::default()).expect("valid settings");
    assert_eq!(film.left_out().count, 0);
    film.develop()
}

fn channels<const N: usize>(image: &Image, names: [&str; N]) -> [Vec<f32>; N] {
    names.map(|name| image.f32_channel(name).unwrap_or_else(|| panic!("no channel {name}")).to_vec())
}

/// A room of sorts: a floor, a mirror ball, a veil, a lamp and a sky.
fn room() -> Scene {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.8, 0.7, 0.6]);
    let lamp = parts.emitter([9.0, 8.0, 7.0], true);
    let mirror = parts.material(Scattering::Mirror { reflectance: Spectrum::ONE });
    let veil = parts.diffuse([0.3, 0.5, 0.4]);
    parts.0.materials[veil].opacity = 0.6.into();
    parts.rectangle(dvec3(-4.0, -1.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(8.0, 0.0, 0.0), white);
    parts.rectangle(dvec3(0.3, 1.6, -1.0), dvec3(1.0, 0.0, 0.0), dvec3(0.0, 0.0, 1.0), lamp);
    parts.sphere(dvec3(-0.7, -0.3, 0.0), 0.7, mirror);
    parts.sphere(dvec3(0.8, -0.5, 0.3), 0.5, veil);
    parts.0.environment = Some(Spectrum([0.2, 0.3, 0.4]).into());
    parts.build()
}

/// Direct light is what a render sees whose paths end after two edges, and indirect light is the rest: bit for bit, and for
/// every integrator.
#[test]
fn direct_and_indirect_light_add_up_to_the_colour() {
    let scene = room();
    for integrator in SOLVERS {
        let settings = RenderSettings { filter: Filter::Lanczos { radius: 3.0 }, ..statistics(integrator, 24) };
        let image = developed(&scene, &settings, &[Aov::Indirect, Aov::Direct], false, DVec3::ZERO);
        let two_edges = developed(&scene, &RenderSettings { max_depth: Some(2), ..settings }, &[], false, DVec3::ZERO);
        let mut some_indirect = 0;
        for channel in ["R", "G", "B"] {
            let (direct, indirect) = (format!("Direct.{channel}"), format!("Indirect.{channel}"));
            let [all, direct, indirect] = channels(&image, [channel, &direct, &indirect]);
            assert_eq!(Some(&direct[..]), two_edges.f32_channel(channel), "{integrator}");
            for ((all, direct), indirect) in all.iter().zip(&direct).zip(&indirect) {
                let rounding = 1e-6 * (direct.abs() + indirect.abs());
                assert!((all - direct - indirect).abs() <= rounding, "{integrator}: {all} {direct} {indirect}");
                some_indirect += usize::from(*indirect > 0.01 * direct);
            }
        }
        assert!(some_indirect > 200, "{integrator}: {some_indirect}");
    }
}

/// Where a ball of emission 1 is alone, colour and alpha are the same number, sample by sample, whatever the filter.
#[test]
fn colour_is_multiplied_by_alpha() {
    let mut parts = Parts::default();
    let glow = parts.emitter([1.0; 3], true);
    parts.sphere(DVec3::ZERO, 1.0, glow);
    parts.0.environment = Some(Spectrum([7.0, 8.0, 9.0]).into());
    let scene = parts.build();
    for filter in Filter::ALL {
        let settings = RenderSettings { filter, ..statistics(Integrator::Path, 16) };
        let image = developed(&scene, &settings, &[Aov::Alpha], true, DVec3::ZERO);
        let names: Vec<&str> = image.channels.iter().map(|c| c.name.as_str()).collect();
        assert_eq!(names, ["R", "G", "B", "A", "Alpha.A"]);
        let [r, g, a, layer] = channels(&image, ["R", "G", "A", "Alpha.A"]);
        assert!(r == a && g == a && a == layer, "{filter}");
        assert_eq!((a[0], r[0]), (0.0, 0.0), "{filter}");
        let middle = (SIDE / 2 * SIDE + SIDE / 2) as usize;
        assert!((0.4..1.8).contains(&a[middle]) && a.iter().any(|a| *a > 0.2 && *a < 0.8), "{filter}: an edge");
        if filter == Filter::default() {
            assert_eq!(a[middle], 1.0);
        }
        // With the sky in the picture, the layer alone tells.
        let opaque = developed(&scene, &settings, &[Aov::Alpha], false, DVec3::ZERO);
        assert_eq!(opaque.f32_channel("Alpha.A"), Some(&layer[..]));
        assert!(opaque.f32_channel("A").is_none() && opaque.f32_channel("B").is_some_and(|b| b[0] > 5.0));
    }
}

/// A surface that is there by 60 % has alpha 0.6 on average, and its light is not darkened twice.
#[test]
fn a_veil_is_partly_there() {
    let mut parts = Parts::default();
    let veil = parts.emitter([2.0; 3], true);
    parts.0.materials[veil].opacity = 0.6.into();
    parts.rectangle(dvec3(-9.0, -9.0, 0.0), dvec3(18.0, 0.0, 0.0), dvec3(0.0, 18.0, 0.0), veil);
    parts.0.environment = Some(Spectrum::splat(5.0).into());
    let image = developed(&parts.build(), &statistics(Integrator::Path, 64), &[], true, DVec3::ZERO);
    let [r, a] = channels(&image, ["R", "A"]);
    let mean = |v: &[f32]| f64::from(v.iter().sum::<f32>()) / f64::from(SIDE * SIDE);
    let error = (0.6f64 * 0.4 / f64::from(SIDE * SIDE * 64)).sqrt();
    assert!((mean(&a) - 0.6).abs() < 4.0 * error, "{}", mean(&a));
    assert!(r.iter().zip(&a).all(|(r, a)| *r == 2.0 * a));
}

/// Behind glass and in mirrors the environment stays.
#[test]
fn only_what_the_camera_sees_directly_is_transparent() {
    let mut parts = Parts::default();
    let mirror = parts.material(Scattering::Mirror { reflectance: Spectrum::ONE });
    parts.sphere(DVec3::ZERO, 1.0, mirror);
    parts.0.environment = Some(Spectrum::splat(3.0).into());
    let settings = RenderSettings { filter: Filter::Box { radius: 0.5 }, ..statistics(Integrator::Path, 16) };
    let image = developed(&parts.build(), &settings, &[], true, DVec3::ZERO);
    let [r, a] = channels(&image, ["R", "A"]);
    assert!(r.iter().zip(&a).all(|(r, a)| (r - 3.0 * a).abs() < 1e-4) && a.contains(&1.0) && a.contains(&0.0));
}

/// Positions are those of the world, also where single precision is coarse there; they and texture coordinates do not fade
/// at edges.
#[test]
fn positions_and_texture_coordinates() {
    for shift in [DVec3::ZERO, dvec3(4096.0, -8192.0, 1024.0), dvec3(3e12, 0.0, -2e14)] {
        let mut parts = Parts::default();
        let white = parts.diffuse([0.5; 3]);
        // A tilted sheet whose texture coordinates are an affine map of its points.
        let (corner, u, v) = (dvec3(-0.9, -0.9, 0.4), dvec3(1.8, 0.1, 0.3), dvec3(0.2, 1.7, -0.6));
        parts.rectangle(shift + corner, u, v, white);
        parts.0.environment = Some(Spectrum::ONE.into());
        let scene = parts.build();
        for filter in [Filter::default(), Filter::Lanczos { radius: 3.0 }] {
            let settings = RenderSettings { filter, ..statistics(Integrator::Path, 16) };
            let aovs = [Aov::Uv, Aov::Position, Aov::Alpha, Aov::Depth, Aov::Normal];
            let image = developed(&scene, &settings, &aovs, false, shift);
            let [x, y, z] = channels(&image, ["P.X", "P.Y", "P.Z"]);
            let [s, t, depth, alpha] = channels(&image, ["UV.U", "UV.V", "Depth.Z", "Alpha.A"]);
            let (mut hits, mut edges) = (0, 0);
            for i in 0..x.len() {
                let position = dvec3(x[i].into(), y[i].into(), z[i].into());
                let expected = shift + corner + u * f64::from(s[i]) + v * f64::from(t[i]);
                if s[i] == 0.0 && t[i] == 0.0 {
                    assert_eq!((position, depth[i]), (DVec3::ZERO, 0.0));
                    continue;
                }
                let precision = 1e-4 + 2e-7 * shift.abs().max_element();
                assert!((position - expected).length() < precision, "{position} is not {expected}");
                assert!((0.0..=1.0).contains(&s[i]) && (0.0..=1.0).contains(&t[i]));
                if shift == DVec3::ZERO {
                    assert!((f64::from(depth[i]) - (5.0 - expected.z)).abs() < 1e-4);
                }
                hits += 1;
                edges += u32::from(alpha[i] < 0.9);
            }
            assert!(hits > 100 && edges > 10, "{hits} {edges}");
        }
    }
}

#[test]
fn samples_are_counted_and_ids_are_whole() {
    let settings = RenderSettings { sampler: Sampler::Stratified, ..statistics(Integrator::Path, 5) };
    let image = developed(&room(), &settings, &[Aov::Samples, Aov::Ids], false, DVec3::ZERO);
    let integers = |name: &str| match &image.channels.iter().find(|c| c.name == name).expect("a channel").data {
        ChannelData::U32(data) => data.clone(),
        ChannelData::F32(_) => panic!("{name} is not of integers"),
    };
    assert!(integers("Samples").iter().all(|n| *n == 5));
    let (objects, materials) = (integers("Id.Object"), integers("Id.Material"));
    // The objects have one material each, in this order.
    let material_of = [0, 1, 2, 3, 4];
    assert!(objects.iter().zip(&materials).all(|(o, m)| material_of[*o as usize] == *m));
    assert!((0..=4).all(|id| objects.contains(&id)), "all are seen, and the sky");
}

/// Views have the same layers of the first surface as light transport has.
#[test]
fn views_have_layers_too() {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.5, 0.25, 0.75]);
    parts.sphere(DVec3::ZERO, 1.0, white);
    let scene = parts.build();
    let aovs = [Aov::Albedo, Aov::Normal, Aov::Depth, Aov::Position, Aov::Uv, Aov::Ids, Aov::Alpha];
    let layers = |integrator| {
        let image = developed(&scene, &statistics(integrator, 4), &aovs, true, DVec3::ZERO);
        image.channels.into_iter().skip(3).collect::<Vec<_>>()
    };
    let reference = layers(Integrator::Path);
    for integrator in Integrator::ALL {
        assert_eq!(layers(integrator), reference, "{integrator}");
    }
}
