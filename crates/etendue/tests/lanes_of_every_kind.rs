//! Vertices of every kind of BSDF that goes in lanes scatter there to the bit as one by one, on facets, smooth meshes, bumps
//! and spheres, with textures and without: in scenes with media all go one by one, so a body of fog that no path ever reaches
//! must not change a picture.

mod common;

use common::*;
use etendue::{
    bsdf::PhongLobes,
    film::{Film, FilmSettings},
    image::ChannelData,
    integrator::Integrator,
    material::{Material, Relief, Scattering},
    math::{DAffine3, DVec3, Vec3, dvec3},
    medium::Medium,
    render::{RenderControl, RenderSettings, render},
    scene::{AcceleratorSettings, Environment, Scene, SceneParts, Shape},
    spectrum::Spectrum,
    texture::{Color, Number, Samples, Texture, TextureImage, Transfer},
};
use etendue_accel::{AcceleratorKind, Isa};
use std::sync::Arc;

fn checks() -> Arc<Texture> {
    let samples: Vec<f32> = (0..6 * 4).map(|i| 0.2 + (i % 4) as f32 * 0.2).collect();
    let image = TextureImage::new(6, 4, 1, Samples::F32(samples.into()), Transfer::Linear).expect("an image");
    Arc::new(Texture::new(Arc::new(image)))
}

fn scatterings() -> Vec<Scattering> {
    let (one, black) = (Spectrum::ONE, Spectrum::BLACK);
    let (brown, blue) = (Spectrum([0.5, 0.3, 0.2]), Spectrum([0.1, 0.2, 0.4]));
    let phong = PhongLobes {
        diffuse: brown,
        specular: blue,
        exponent: 40.0,
        diffuse_transmission: black,
        transmission: black,
        transmission_exponent: 0.0,
        ior: 1.3,
    };
    let (eta, k) = (Spectrum([0.2, 0.4, 1.4]), Spectrum([3.9, 2.4, 1.6]));
    vec![
        Scattering::Diffuse { reflectance: brown, transmittance: black },
        Scattering::Diffuse { reflectance: brown, transmittance: blue },
        Scattering::Mirror { reflectance: Spectrum([0.9, 0.8, 0.7]) },
        Scattering::Glass { ior: 1.5, reflection_tint: one, transmission_tint: Spectrum([0.8, 1.0, 0.9]), thin: false },
        Scattering::Glass { ior: 1.5, reflection_tint: one, transmission_tint: one, thin: true },
        Scattering::RoughMetal { eta, k, alpha: [0.2; 2], tint: one },
        Scattering::RoughMetal { eta, k, alpha: [0.0; 2], tint: one },
        Scattering::RoughMetal { eta, k, alpha: [0.1, 0.4], tint: one },
        Scattering::RoughGlass { ior: 1.5, alpha: 0.15, reflection_tint: one, transmission_tint: one },
        Scattering::Mtl { diffuse: brown, specular: blue, alpha: 0.3, transmission: black, ior: 1.0 },
        Scattering::Mtl { diffuse: brown, specular: blue, alpha: 0.0, transmission: blue, ior: 1.4 },
        Scattering::Phong(phong),
        Scattering::Phong(PhongLobes { specular: black, transmission: blue, transmission_exponent: 1e4, ..phong }),
        Scattering::Phong(PhongLobes { transmission: blue, transmission_exponent: 30.0, ..phong }),
        Scattering::Phong(PhongLobes { diffuse_transmission: blue, ior: 0.8, ..phong }),
    ]
}

/// The ball with smooth normals.
fn smooth_ball(levels: u32) -> Shape {
    let Shape::Mesh(mut mesh) = ball(levels) else { unreachable!("a ball is a mesh") };
    mesh.normals =
        Some(mesh.positions.iter().map(|p| Vec3::from(*p).normalize().to_array()).collect::<Vec<_>>().into());
    Shape::Mesh(mesh)
}

/// A room with a ball of every kind: of facets, of smooth normals, with bumps, exact, or with a texture.
fn parts(foggy: bool) -> SceneParts {
    let mut parts = Parts::default();
    let (white, lamp) = (parts.diffuse([0.7, 0.6, 0.5]), parts.emitter([9.0, 8.0, 7.0], false));
    parts.rectangle(dvec3(-1.0, -1.0, -1.0), dvec3(0.0, 0.0, 2.0), dvec3(2.0, 0.0, 0.0), white);
    parts.rectangle(dvec3(-1.0, -1.0, -1.0), dvec3(2.0, 0.0, 0.0), dvec3(0.0, 2.0, 0.0), white);
    parts.rectangle(dvec3(-0.4, 0.95, -0.4), dvec3(0.8, 0.0, 0.0), dvec3(0.0, 0.0, 0.8), lamp);
    parts.sphere(dvec3(0.8, 0.7, 0.6), 0.1, lamp);
    let (flat, smooth) = (parts.shape(ball(2)), parts.shape(smooth_ball(1)));
    for (i, scattering) in scatterings().into_iter().enumerate() {
        for form in 0..5 {
            let material = parts.material(scattering);
            let at = dvec3(-0.84 + 0.12 * i as f64, -0.8 + 0.3 * f64::from(form), -0.6 + 0.4 * (i % 3) as f64);
            let transform = DAffine3::from_translation(at) * DAffine3::from_scale(DVec3::splat(0.11));
            match form {
                0 => parts.place(flat, transform, material),
                1 => parts.place(smooth, transform, material),
                2 => {
                    let height = Number { factor: 0.02, texture: Some(checks()) };
                    parts.0.materials[material].relief = Some(Relief::Bump { height });
                    parts.place(smooth, transform, material);
                }
                3 => parts.sphere(at, 0.11, material),
                _ => {
                    textured(&mut parts.0.materials[material]);
                    parts.sphere(at, 0.11, material);
                }
            }
        }
    }
    parts.0.environment = Some(Environment::Constant(Spectrum([0.2, 0.3, 0.4])));
    let shell = parts.material(Scattering::Black);
    if foggy {
        parts.0.media.push(Medium { name: "fog".to_owned(), scattering: Spectrum::splat(0.1), ..Medium::default() });
        parts.0.materials[shell].interior = Some("fog".to_owned());
    }
    parts.sphere(dvec3(-90.0, -90.0, 90.0), 0.01, shell);
    parts.sphere(dvec3(90.0, 90.0, 90.0), 0.01, shell);
    parts.0
}

/// Gives every colour of a material the checks.
fn textured(material: &mut Material) {
    let color = |color: &Color| Color { factor: color.factor, texture: Some(checks()) };
    let mapped = material.scattering.try_map(|_, _, c| Ok::<_, ()>(color(c)), |_, _, n| Ok(n.clone()));
    material.scattering = mapped.expect("nothing fails");
}

fn picture(foggy: bool, isa: Isa, settings: &RenderSettings) -> (Vec<u32>, u64) {
    let accelerator = AcceleratorSettings { kind: AcceleratorKind::Bvh, isa, threads: 2 };
    let scene = Scene::build(parts(foggy), &accelerator).expect("a valid scene");
    let settings_of_film = FilmSettings { resolution: [54, 45], crop: None, aovs: vec![], transparent: false };
    let film = Film::new(&settings_of_film).expect("a film");
    let (camera, control) = (camera(dvec3(0.1, 0.1, 2.6), dvec3(0.0, -0.1, -0.5)), RenderControl::default());
    render(&scene, &camera, settings, &film, &control).expect("valid settings");
    assert_eq!(film.left_out().count, 0);
    let bits = film.develop().channels.into_iter().flat_map(|channel| match channel.data {
        ChannelData::F32(values) => values.iter().map(|v| v.to_bits()).collect(),
        ChannelData::U32(values) => values,
    });
    (bits.collect(), control.rays())
}

#[test]
fn every_kind_scatters_in_lanes_as_alone() {
    for integrator in SOLVERS {
        let resampling = Some(integrator != Integrator::LightSplit);
        let settings = RenderSettings { spp: 6, integrator, resampling, threads: 2, ..RenderSettings::default() };
        let settings = RenderSettings { max_depth: Some(9), ..settings };
        let one_by_one = picture(true, Isa::detect(), &settings);
        for isa in Isa::available() {
            for wave in [1, 90, 256] {
                let settings = RenderSettings { wave, ..settings.clone() };
                let in_lanes = picture(false, isa, &settings);
                assert_eq!(in_lanes.1, one_by_one.1, "rays: {integrator} {isa}, waves of {wave}");
                assert!(in_lanes.0 == one_by_one.0, "{integrator} {isa}, waves of {wave}");
            }
        }
    }
}
