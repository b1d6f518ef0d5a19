//! The picture depends on scene, settings and seed: not on threads, tiles, waves, accelerators or instruction sets.

mod common;

use common::*;
use etendue::{
    camera::{Aperture, CameraSettings, FovAxis, Projection},
    film::{Aov, Film, FilmSettings},
    image::{ChannelData, Image},
    integrator::Integrator,
    light::RadianceMap,
    material::Scattering,
    math::{DAffine3, DMat3, DVec3, dvec3},
    render::{RenderControl, RenderSettings, render},
    sampling::{Filter, Sampler},
    scene::{AcceleratorSettings, DeltaLight, Environment, Scene, SceneParts},
    spectrum::Spectrum,
    texture::{Samples, Texture, TextureImage, Transfer},
};
use etendue_accel::{AcceleratorKind, Isa, KdTreeSplit};
use std::sync::Arc;

fn parts() -> SceneParts {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.7; 3]);
    let light = parts.emitter([5.0, 4.0, 3.0], true);
    let tint = Spectrum::ONE;
    let glass =
        parts.material(Scattering::Glass { ior: 1.5, reflection_tint: tint, transmission_tint: tint, thin: false });
    let veil = parts.diffuse([0.2, 0.5, 0.3]);
    parts.0.materials[veil].opacity = 0.6.into();
    parts.rectangle(dvec3(-4.0, -1.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(8.0, 0.0, 0.0), white);
    parts.sphere(dvec3(-0.8, -0.3, 0.0), 0.7, glass);
    parts.rectangle(dvec3(-1.0, 2.0, -1.0), dvec3(2.0, 0.0, 0.0), dvec3(0.0, 0.0, 2.0), light);
    let body = parts.shape(ball(3));
    for (i, material) in [white, veil, light, glass].into_iter().enumerate() {
        let at = dvec3(0.8 * i as f64 - 0.6, 0.3 * i as f64 - 0.5, -0.5 * i as f64);
        let scale = DVec3::new(0.3, 0.4 + 0.05 * i as f64, 0.35);
        parts.place(
            body,
            DAffine3::from_translation(at) * DAffine3::from_rotation_y(0.3) * DAffine3::from_scale(scale),
            material,
        );
    }
    all_lights(&mut parts);
    parts.0
}

/// A sky from an image, lights without extent, and emission and opacity with textures, on shapes of every kind.
fn all_lights(parts: &mut Parts) {
    let sky = (0..32 * 16).map(|i| if i == 100 { [90.0, 80.0, 70.0] } else { [0.2, 0.3, (i % 7) as f32 * 0.1] });
    let map = Arc::new(RadianceMap::new(32, 16, sky.collect()).expect("a valid map"));
    let orientation = DMat3::from_rotation_y(0.4);
    parts.0.environment = Some(Environment::Image { map, orientation, strength: Spectrum([0.5, 0.6, 0.7]) });
    let (position, direction) = (dvec3(1.5, 2.0, 1.0), dvec3(-0.5, -1.0, -0.4));
    let (intensity, irradiance) = (Spectrum([3.0, 2.0, 1.0]), Spectrum::splat(0.3));
    parts.0.delta_lights = vec![
        DeltaLight::Point { position: position * -1.0, intensity },
        DeltaLight::Spot { position, direction, half_angle: 0.5, blend: 0.3, intensity },
        DeltaLight::Directional { direction, irradiance },
    ];
    let samples: Vec<f32> = (0..9 * 5).map(|i| (i % 4) as f32 * 0.3).collect();
    let image = TextureImage::new(9, 5, 1, Samples::F32(samples.into()), Transfer::Linear).expect("an image");
    let texture = Some(Arc::new(Texture::new(Arc::new(image))));
    let screen = parts.emitter([1.0; 3], true);
    let material = &mut parts.0.materials[screen];
    material.emission.as_mut().expect("it emits").radiance.texture = texture.clone();
    material.opacity.texture = texture;
    parts.rectangle(dvec3(-2.0, -0.5, -1.0), dvec3(1.2, 0.0, 0.0), dvec3(0.0, 0.9, 0.0), screen);
    parts.sphere(dvec3(1.6, 1.2, -0.6), 0.3, screen);
    let body = parts.shape(ball(1));
    for (x, mirror) in [(2.2, 1.0), (-2.2, -1.0)] {
        let scale = DAffine3::from_scale(dvec3(0.3 * mirror, 0.5, 0.3));
        parts.place(body, DAffine3::from_translation(dvec3(x, 0.4, 0.3)) * scale, screen);
    }
}

fn scene(kind: AcceleratorKind, isa: Isa) -> Scene {
    Scene::build(parts(), &AcceleratorSettings { kind, isa, threads: 2 }).expect("a valid scene")
}

fn base() -> RenderSettings {
    RenderSettings { spp: 10, seed: 7, threads: 2, splitting: Some(3), ..RenderSettings::default() }
}

fn layers(scene: &Scene, settings: &RenderSettings, crop: Option<[u32; 4]>) -> Image {
    let film = Film::new(&FilmSettings { resolution: [48, 36], crop, aovs: Aov::ALL.to_vec(), transparent: false })
        .expect("a film");
    let view = camera(dvec3(0.5, 0.8, 6.0), dvec3(0.0, 0.0, 0.0));
    render(scene, &view, settings, &film, &RenderControl::default()).expect("valid settings");
    film.develop()
}

/// Bits of every channel, so that equal means equal.
fn bits(image: &Image) -> Vec<(String, Vec<u32>)> {
    let of = |data: &ChannelData| match data {
        ChannelData::F32(v) => v.iter().map(|v| v.to_bits()).collect(),
        ChannelData::U32(v) => v.clone(),
    };
    image.channels.iter().map(|c| (c.name.clone(), of(&c.data))).collect()
}

#[test]
fn same_bits_for_any_threads_tiles_and_waves() {
    let scene = scene(AcceleratorKind::Bvh, Isa::detect());
    let reference = bits(&layers(&scene, &base(), None));
    for (threads, tile, wave) in [(1, 32, 256), (7, 32, 256), (2, 1, 1), (3, 5, 17), (2, 4096, 1000), (1, 7, 65536)] {
        let image = layers(&scene, &RenderSettings { threads, tile, wave, ..base() }, None);
        assert_eq!(reference, bits(&image), "threads {threads}, tile {tile}, wave {wave}");
    }
}

#[test]
fn same_bits_for_any_accelerator_and_instruction_set() {
    let reference = bits(&layers(&scene(AcceleratorKind::Brute, Isa::Portable), &base(), None));
    let kinds = [
        AcceleratorKind::Brute,
        AcceleratorKind::KdTree(KdTreeSplit::SurfaceArea),
        AcceleratorKind::KdTree(KdTreeSplit::Midpoint),
        AcceleratorKind::Bvh,
    ];
    for kind in kinds {
        for isa in Isa::available() {
            assert_eq!(reference, bits(&layers(&scene(kind, isa), &base(), None)), "{kind:?} {isa:?}");
        }
    }
}

/// Every sampler, filter and aperture, with all layers and a transparent background.
#[test]
fn same_bits_for_every_sampler_filter_and_aperture() {
    let scene = scene(AcceleratorKind::Bvh, Isa::detect());
    let lens = |aperture| CameraSettings {
        projection: Projection::Perspective {
            fov: 0.7,
            axis: FovAxis::X,
            lens_radius: 0.2,
            aperture,
            focus_distance: 5.5,
        },
        ..camera(dvec3(0.5, 0.8, 6.0), dvec3(0.0, 0.0, 0.0))
    };
    let apertures =
        [Aperture::Round, Aperture::Square { rotation: 0.3 }, Aperture::Polygon { blades: 5, rotation: -0.2 }];
    let cases = apertures.map(|aperture| (Sampler::default(), Filter::default(), aperture)).into_iter();
    let cases = cases.chain(Filter::ALL.map(|filter| (Sampler::default(), filter, Aperture::Round)));
    let cases = cases.chain(Sampler::ALL.map(|sampler| (sampler, Filter::default(), Aperture::Round)));
    for (sampler, filter, aperture) in cases {
        let view = lens(aperture);
        let picture = |crop, threads, tile, wave| {
            let settings = FilmSettings { resolution: [24, 18], crop, aovs: Aov::ALL.to_vec(), transparent: true };
            let film = Film::new(&settings).expect("a film");
            let settings = RenderSettings { sampler, filter, threads, tile, wave, ..base() };
            render(&scene, &view, &settings, &film, &RenderControl::default()).expect("valid settings");
            bits(&film.develop())
        };
        let reference = picture(None, 1, 32, 256);
        assert_eq!(reference, picture(None, 3, 5, 17), "{sampler}, {filter}, {aperture:?}");
        let [x0, y0, x1, y1] = [7, 3, 20, 15];
        for ((name, whole), (_, part)) in reference.iter().zip(&picture(Some([x0, y0, x1, y1]), 2, 4096, 1000)) {
            let cut: Vec<u32> = (y0..y1).flat_map(|y| (x0..x1).map(move |x| whole[(y * 24 + x) as usize])).collect();
            assert_eq!(&cut, part, "{name}, {sampler}, {filter}, {aperture:?}");
        }
    }
}

#[test]
fn a_crop_is_that_crop_of_the_whole() {
    let scene = scene(AcceleratorKind::Bvh, Isa::detect());
    for (sampler, splitting) in [(Sampler::Sobol, None), (Sampler::Independent, Some(1))] {
        let settings = RenderSettings { sampler, splitting, ..base() };
        let whole = bits(&layers(&scene, &settings, None));
        let [x0, y0, x1, y1] = [11, 5, 40, 29];
        let part = bits(&layers(&scene, &settings, Some([x0, y0, x1, y1])));
        for ((name, whole), (_, part)) in whole.iter().zip(&part) {
            let cut: Vec<u32> = (y0..y1).flat_map(|y| (x0..x1).map(move |x| whole[(y * 48 + x) as usize])).collect();
            assert_eq!(&cut, part, "{name}, {sampler:?}");
        }
    }
}

#[test]
fn another_seed_is_another_picture_and_the_same_seed_the_same() {
    let scene = scene(AcceleratorKind::Bvh, Isa::detect());
    let picture = |seed| bits(&layers(&scene, &RenderSettings { seed, ..base() }, None));
    assert_eq!(picture(3), picture(3));
    assert_ne!(picture(3), picture(4));
}

#[test]
fn every_view_renders_without_a_number_left_out() {
    let scene = scene(AcceleratorKind::Bvh, Isa::detect());
    for integrator in Integrator::ALL {
        let view = camera(dvec3(0.5, 0.8, 6.0), dvec3(0.0, 0.0, 0.0));
        let image = picture(&scene, &view, [32, 24], &RenderSettings { integrator, spp: 4, ..base() });
        assert!(interleaved(&image).iter().any(|v| *v > 0.0), "{integrator} is black");
    }
}

#[test]
fn a_cancelled_render_keeps_whole_samples() {
    let scene = scene(AcceleratorKind::Bvh, Isa::detect());
    let film = Film::new(&FilmSettings { resolution: [48, 36], crop: None, aovs: vec![], transparent: false })
        .expect("a film");
    let control = RenderControl::default();
    control.cancel();
    let view = camera(dvec3(0.5, 0.8, 6.0), dvec3(0.0, 0.0, 0.0));
    render(&scene, &view, &base(), &film, &control).expect("valid settings");
    assert_eq!(film.sample_counts().total, 0);
    assert!(interleaved(&film.develop()).iter().all(|v| *v == 0.0));
}
