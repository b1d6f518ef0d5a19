//! Diffuse vertices that go through the path loop in lanes scatter to the bit as those that go one by one: in scenes with
//! media all do, so a body of fog that no path ever reaches must not change a picture.

mod common;

use common::*;
use etendue::{
    film::{Aov, Film, FilmSettings},
    image::ChannelData,
    material::{Emission, Scattering},
    math::{DAffine3, dvec3},
    medium::Medium,
    render::{RenderControl, RenderSettings, render},
    sampling::Sampler,
    scene::{AcceleratorSettings, DeltaLight, Environment, Scene, SceneParts},
    spectrum::Spectrum,
    texture::{Color, Filtering, Mapping, Samples, Texture, TextureImage, Transfer},
};
use etendue_accel::{AcceleratorKind, Isa};
use std::sync::Arc;

fn checks(filtering: Filtering) -> Arc<Texture> {
    let samples: Vec<f32> = (0..6 * 4).map(|i| 0.2 + (i % 4) as f32 * 0.2).collect();
    let image = TextureImage::new(6, 4, 1, Samples::F32(samples.into()), Transfer::Linear).expect("an image");
    let texture = Texture::new(Arc::new(image));
    Arc::new(Texture { mapping: Mapping { filtering, ..texture.mapping }, ..texture })
}

/// Diffuse surfaces of every kind under lights of every kind, between two spheres far outside.
fn parts(foggy: bool, open: bool) -> SceneParts {
    let mut parts = Parts::default();
    let (white, red) = (parts.diffuse([0.7, 0.6, 0.5]), parts.diffuse([0.6, 0.1, 0.1]));
    let [papered, tiled] = [Filtering::Trilinear, Filtering::Bilinear].map(|filtering| {
        let reflectance = Color { factor: Spectrum([0.9, 0.8, 0.7]), texture: Some(checks(filtering)) };
        let material = parts.diffuse([0.0; 3]);
        parts.0.materials[material].scattering =
            Scattering::Diffuse { reflectance, transmittance: Spectrum::BLACK.into() };
        material
    });
    parts.rectangle(dvec3(-1.0, -1.0, -1.0), dvec3(0.0, 0.0, 2.0), dvec3(2.0, 0.0, 0.0), tiled);
    parts.rectangle(dvec3(-1.0, -1.0, -1.0), dvec3(2.0, 0.0, 0.0), dvec3(0.0, 2.0, 0.0), papered);
    parts.rectangle(dvec3(-1.0, -1.0, -1.0), dvec3(0.0, 2.0, 0.0), dvec3(0.0, 0.0, 2.0), red);
    if !open {
        parts.rectangle(dvec3(-1.0, 1.0, -1.0), dvec3(2.0, 0.0, 0.0), dvec3(0.0, 0.0, 2.0), white);
        parts.rectangle(dvec3(1.0, -1.0, -1.0), dvec3(0.0, 0.0, 2.0), dvec3(0.0, 2.0, 0.0), red);
        parts.rectangle(dvec3(-1.0, -1.0, 1.0), dvec3(0.0, 2.0, 0.0), dvec3(2.0, 0.0, 0.0), white);
    }
    let smooth = parts.shape(ball(2));
    parts.place(
        smooth,
        DAffine3::from_translation(dvec3(-0.4, -0.6, 0.1)) * DAffine3::from_scale(dvec3(0.3, 0.4, 0.3)),
        white,
    );
    parts.place(
        smooth,
        DAffine3::from_translation(dvec3(0.5, -0.6, -0.5)) * DAffine3::from_scale(dvec3(0.3, 0.4, 0.3)),
        papered,
    );
    let block = parts.shape(cube(false));
    let turned = DAffine3::from_rotation_y(0.4) * DAffine3::from_scale(dvec3(0.2, 0.3, 0.2));
    parts.place(block, DAffine3::from_translation(dvec3(0.4, -0.7, 0.4)) * turned, white);
    parts.sphere(dvec3(-0.1, -0.8, 0.6), 0.2, red);
    lamps(&mut parts);
    let shell = parts.material(Scattering::Black);
    if foggy {
        parts.0.media.push(Medium { name: "fog".to_owned(), scattering: Spectrum::splat(0.1), ..Medium::default() });
        parts.0.materials[shell].interior = Some("fog".to_owned());
    }
    parts.sphere(dvec3(-90.0, -90.0, 90.0), 0.01, shell);
    parts.sphere(dvec3(90.0, 90.0, 90.0), 0.01, shell);
    parts.0
}

fn lamps(parts: &mut Parts) {
    let lamp = parts.emitter([9.0, 8.0, 7.0], false);
    let thin = parts.emitter([900.0, 800.0, 300.0], true);
    let diffuse_lamp = parts.diffuse([0.8; 3]);
    parts.0.materials[diffuse_lamp].emission =
        Some(Emission { radiance: Spectrum([2.0, 4.0, 5.0]).into(), two_sided: true });
    parts.rectangle(dvec3(-0.3, 0.95, -0.3), dvec3(0.6, 0.0, 0.0), dvec3(0.0, 0.0, 0.6), lamp);
    // A parallelogram, a rectangle too small for its own map, a sphere, triangles.
    parts.rectangle(dvec3(-0.9, 0.2, -0.4), dvec3(0.0, 0.3, 0.1), dvec3(0.0, -0.1, 0.4), diffuse_lamp);
    parts.rectangle(dvec3(0.5, 0.5, 0.5), dvec3(2e-5, 0.0, 0.0), dvec3(0.0, 0.0, 2e-5), thin);
    parts.sphere(dvec3(0.7, 0.6, -0.3), 0.1, diffuse_lamp);
    let block = parts.shape(cube(false));
    parts.place(
        block,
        DAffine3::from_translation(dvec3(-0.6, 0.6, 0.6)) * DAffine3::from_scale(dvec3(0.1, 0.1, 0.1)),
        lamp,
    );
    parts.0.environment = Some(Environment::Constant(Spectrum([0.2, 0.3, 0.4])));
    let (intensity, irradiance) = (Spectrum([0.3, 0.2, 0.1]), Spectrum::splat(0.3));
    parts.0.delta_lights = vec![
        DeltaLight::Point { position: dvec3(0.1, 0.3, 0.2), intensity },
        DeltaLight::Directional { direction: dvec3(-0.3, -1.0, -0.4), irradiance },
    ];
}

fn picture(foggy: bool, open: bool, isa: Isa, settings: &RenderSettings) -> (Vec<(String, Vec<u32>)>, u64) {
    let accelerator = AcceleratorSettings { kind: AcceleratorKind::Bvh, isa, threads: 2 };
    let scene = Scene::build(parts(foggy, open), &accelerator).expect("a valid scene");
    let aovs = vec![Aov::Direct, Aov::Indirect];
    let film = Film::new(&FilmSettings { resolution: [48, 40], crop: None, aovs, transparent: false }).expect("a film");
    let (camera, control) = (camera(dvec3(0.2, 0.1, 0.9), dvec3(0.0, -0.2, -0.5)), RenderControl::default());
    render(&scene, &camera, settings, &film, &control).expect("valid settings");
    assert_eq!(film.left_out().count, 0);
    let bits = film.develop().channels.into_iter().map(|channel| match channel.data {
        ChannelData::F32(values) => (channel.name, values.iter().map(|v| v.to_bits()).collect()),
        ChannelData::U32(values) => (channel.name, values),
    });
    (bits.collect(), control.rays())
}

#[test]
fn lanes_scatter_as_single_vertices_do() {
    for integrator in SOLVERS {
        for (open, sampler) in [(false, Sampler::Sobol), (true, Sampler::Sobol), (false, Sampler::Independent)] {
            let settings = RenderSettings {
                spp: 6,
                integrator,
                sampler,
                max_depth: Some(9),
                splitting: Some(if open { 1 } else { 2 }),
                resampling: Some(open),
                threads: 2,
                ..RenderSettings::default()
            };
            let one_by_one = picture(true, open, Isa::detect(), &settings);
            for isa in Isa::available() {
                for wave in [1, 50, 256, 1000] {
                    let settings = RenderSettings { wave, ..settings.clone() };
                    let in_lanes = picture(false, open, isa, &settings);
                    assert!(in_lanes == one_by_one, "{integrator} {sampler} {isa}, waves of {wave}, open: {open}");
                }
            }
        }
    }
}
