//! Shading normals of bumps and of coarse meshes: soft terminators, no light from below, no gain of energy, and the picture of
//! the geometry that they stand for.
#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue::{
    camera::CameraSettings,
    integrator::Integrator,
    material::{Number, Relief, Scattering},
    math::{DAffine3, DVec3, Vec3, dvec3},
    scene::{DeltaLight, Mesh, Scene, Shape},
    spectrum::Spectrum,
    texture::{Filtering, Samples, Texture, TextureImage, Transfer},
};
use etendue_testkit::tiles::{Demands, Replicates, compare};
use std::{f64::consts::PI, sync::Arc};

fn texture(size: u32, channels: usize, texel: impl Fn(u32, u32) -> Vec<f32>) -> Arc<Texture> {
    let samples: Vec<f32> = (0..size * size).flat_map(|i| texel(i % size, i / size)).collect();
    let image = TextureImage::new(size, size, channels, Samples::F32(samples.into()), Transfer::Linear).unwrap();
    let mut texture = Texture::new(Arc::new(image));
    // As sharp at a distance as near by.
    texture.mapping.filtering = Filtering::Bilinear;
    Arc::new(texture)
}

/// Height of waves of 32 to a side, over texture coordinates in [0, 1], between -1 and 1.
fn wave(u: f64, v: f64) -> f64 {
    (32.0 * PI * u).sin() * (32.0 * PI * v).sin()
}

/// Waves as a bump map, `height` metres.
fn waves(height: f32) -> Relief {
    const SIZE: u32 = 512;
    let at = |i: u32| (f64::from(i) + 0.5) / f64::from(SIZE);
    let map = texture(SIZE, 1, |x, y| vec![wave(at(x), 1.0 - at(y)) as f32]);
    Relief::Bump { height: Number { factor: height, texture: Some(map) } }
}

/// One normal, tilted by `tilt` radians towards growing u.
fn tilted(tilt: f64) -> Relief {
    let texel = [0.5 * tilt.sin() + 0.5, 0.5, 0.5 * tilt.cos() + 0.5].map(|c| c as f32);
    Relief::Normals { map: texture(1, 3, |_, _| texel.to_vec()), scale: [1.0; 2] }
}

/// A square of the plane y = 0 with u along x.
fn floor(parts: &mut Parts, half: f64, material: usize) {
    parts.rectangle(dvec3(-half, 0.0, half), dvec3(2.0 * half, 0.0, 0.0), dvec3(0.0, 0.0, -2.0 * half), material);
}

fn sun(parts: &mut Parts, to_sun: DVec3) {
    parts.0.delta_lights.push(DeltaLight::Directional { direction: -to_sun, irradiance: Spectrum::splat(PI as f32) });
}

/// Mean of a picture of direct light, with footprints far smaller than waves.
fn direct(scene: &Scene, view: &CameraSettings, spp: u32) -> f64 {
    let settings = etendue::render::RenderSettings { max_depth: Some(2), ..statistics(Integrator::Path, spp) };
    let values = interleaved(&picture(scene, view, [160, 160], &settings));
    values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64
}

fn at(elevation: f64) -> DVec3 {
    let (sin, cos) = elevation.to_radians().sin_cos();
    dvec3(cos, sin, 0.0)
}

/// A plane with normals tilted by 40 degrees towards a light that goes down: without shadowing it would be lit at the
/// horizon with sin 40 degrees, and then go out.
#[test]
fn a_tilted_normal_is_lit_softly_and_never_from_below() {
    let tilt = 40f64.to_radians();
    let lit = |elevation: f64| {
        let mut parts = Parts::default();
        let white = parts.diffuse([1.0; 3]);
        parts.0.materials[white].relief = Some(tilted(tilt));
        floor(&mut parts, 100.0, white);
        sun(&mut parts, at(elevation));
        direct(&parts.build(), &camera(dvec3(0.0, 5.0, 0.0), DVec3::ZERO), 1)
    };
    let mut before = f64::INFINITY;
    for (elevation, least, most) in [
        (50.0f64, 0.98, 1.0),
        (30.0, 0.92, 1.0),
        (15.0, 0.7, 0.95),
        (5.0, 0.3, 0.6),
        (1.0, 0.05, 0.15),
        (0.1, 0.0, 0.02),
    ] {
        let plain = (elevation.to_radians() + tilt).sin();
        let found = lit(elevation);
        let share = found / plain;
        assert!((least..=most).contains(&share), "{elevation}: {found} of {plain} is {share}");
        assert!(found <= before, "{elevation}");
        before = if elevation < 50.0 { found } else { before };
    }
    assert_eq!([-0.1, -5.0, -30.0].map(lit), [0.0; 3], "light from below leaks");
}

/// Tilted away from the viewer, so that it would not be seen at all, a surface is not black.
#[test]
fn normals_that_face_away_are_not_black() {
    for scattering in [
        Scattering::Diffuse { reflectance: Spectrum::ONE, transmittance: Spectrum::BLACK },
        Scattering::Mirror { reflectance: Spectrum::ONE },
    ] {
        let mut parts = Parts::default();
        let white = parts.material(scattering);
        parts.0.materials[white].relief = Some(tilted(50f64.to_radians()));
        floor(&mut parts, 1000.0, white);
        parts.0.environment = Some(Spectrum::ONE.into());
        // From -x, 10 degrees above the floor.
        let scene = parts.build();
        let view = camera(at(170.0) * 5.0, DVec3::ZERO);
        let settings = etendue::render::RenderSettings { max_depth: Some(2), ..statistics(Integrator::Path, 64) };
        let values = interleaved(&picture(&scene, &view, [8, 8], &settings));
        // The lower half, where no ray sees the sky.
        let below = &values[5 * 8 * 3..];
        assert!(below.iter().all(|v| *v > 0.3 && *v < 1.5), "{below:?}");
    }
}

/// A mesh of the floor with waves that are there.
fn displaced(height: f64, half: f64) -> Shape {
    const CELLS: u32 = 640;
    let at = |i: u32| f64::from(i) / f64::from(CELLS);
    let corner = |i: u32| {
        let (u, v) = (at(i % (CELLS + 1)), at(i / (CELLS + 1)));
        let slope = |a: f64, b: f64| 32.0 * PI * height / (2.0 * half) * (32.0 * PI * a).cos() * (32.0 * PI * b).sin();
        let position = dvec3((2.0 * u - 1.0) * half, height * wave(u, v), (1.0 - 2.0 * v) * half);
        (position, dvec3(-slope(u, v), 1.0, slope(v, u)).normalize())
    };
    let corners: Vec<(DVec3, DVec3)> = (0..(CELLS + 1) * (CELLS + 1)).map(corner).collect();
    let faces = (0..CELLS * CELLS).flat_map(|i| {
        let a = i / CELLS * (CELLS + 1) + i % CELLS;
        let (b, c, d) = (a + 1, a + CELLS + 1, a + CELLS + 2);
        [[a, b, d], [a, d, c]]
    });
    Shape::Mesh(Mesh {
        origin: DVec3::ZERO,
        positions: corners.iter().map(|c| c.0.as_vec3().to_array()).collect(),
        indices: faces.collect(),
        normals: Some(corners.iter().map(|c| c.1.as_vec3().to_array()).collect()),
        uvs: None,
        colors: None,
        face_materials: None,
    })
}

/// Waves as a bump map reflect as much as waves of geometry do, which throw shadows; without shadowing they reflect far more
/// of light that grazes.
#[test]
fn bumps_reflect_what_displaced_geometry_reflects() {
    let (half, height) = (8.0, 0.12);
    let view = camera(dvec3(0.0, 8.0, 0.0), DVec3::ZERO);
    let (mut better, mut worst) = (0, 0.0f64);
    for elevation in [45.0, 20.0, 10.0, 5.0, 2.0] {
        let to_sun = DAffine3::from_rotation_y(0.3).transform_vector3(at(elevation));
        let scene = |is_bump: bool| {
            let mut parts = Parts::default();
            let white = parts.diffuse([1.0; 3]);
            if is_bump {
                parts.0.materials[white].relief = Some(waves(height as f32));
                floor(&mut parts, half, white);
            } else {
                let shape = parts.shape(displaced(height, half));
                parts.place(shape, DAffine3::IDENTITY, white);
            }
            sun(&mut parts, to_sun);
            direct(&parts.build(), &view, 1)
        };
        let (bump, truth) = (scene(true), scene(false));
        // Without shadowing: the mean of max(0, n . l) over a wave.
        const N: u32 = 200;
        let plain = (0..N * N)
            .map(|i| {
                let [a, b] = [i % N, i / N].map(|k| 2.0 * PI * (f64::from(k) + 0.5) / f64::from(N));
                let slope = 32.0 * PI * height / (2.0 * half);
                let normal = dvec3(-slope * a.cos() * b.sin(), 1.0, slope * a.sin() * b.cos()).normalize();
                normal.dot(to_sun).max(0.0) / f64::from(N * N)
            })
            .sum::<f64>();
        println!("{elevation}: bump {bump:.4}, displaced {truth:.4}, without shadowing {plain:.4}");
        better += u32::from((bump - truth).abs() <= (plain - truth).abs() + 0.01);
        worst = worst.max((bump - truth).abs());
    }
    assert!(better == 5 && worst < 0.05, "{better}, {worst}");
}

/// A ball of triangles with the normals of the sphere.
fn smooth_ball(levels: u32) -> Shape {
    let Shape::Mesh(mesh) = ball(levels) else { unreachable!() };
    let normals = mesh.positions.iter().map(|p| Vec3::from(*p).normalize().to_array()).collect();
    Shape::Mesh(Mesh { normals: Some(normals), ..mesh })
}

/// Radiance of a white unit ball, direct light from the right, by pixel.
fn lit_ball(shape: Shape) -> Vec<f32> {
    let mut parts = Parts::default();
    let white = parts.diffuse([1.0; 3]);
    let shape = parts.shape(shape);
    parts.place(shape, DAffine3::IDENTITY, white);
    sun(&mut parts, dvec3(0.95, 0.2, 0.25).normalize());
    let settings = etendue::render::RenderSettings { max_depth: Some(2), ..statistics(Integrator::Path, 16) };
    interleaved(&picture(&parts.build(), &camera(dvec3(0.0, 0.0, 8.0), DVec3::ZERO), [96, 96], &settings))
}

/// A coarse ball is shaded as the sphere that it stands for.
#[test]
fn coarse_balls_have_the_terminator_of_a_sphere() {
    let sphere = lit_ball(Shape::Sphere { center: DVec3::ZERO, radius: 1.0 });
    for (levels, mean_limit, limit) in [(2, 0.02, 0.12), (3, 0.006, 0.05), (4, 0.002, 0.02)] {
        let coarse = lit_ball(smooth_ball(levels));
        // Within the silhouette of both.
        let inside = |i: usize| {
            let (x, y) = ((i % 96) as f64 - 47.5, (i / 96) as f64 - 47.5);
            x.hypot(y) < 0.9 * 8f64.recip().atan().tan() / 20f64.to_radians().tan() * 48.0
        };
        let errors: Vec<f64> =
            (0..96 * 96).filter(|i| inside(*i)).map(|i| f64::from(coarse[3 * i] - sphere[3 * i]).abs()).collect();
        let mean = errors.iter().sum::<f64>() / errors.len() as f64;
        let worst = errors.iter().copied().fold(0.0, f64::max);
        println!("{levels} levels: mean error {mean:.5}, worst {worst:.4} of {} pixels", errors.len());
        assert!(mean < mean_limit && worst < limit, "{levels} levels: mean error {mean}, worst {worst}");
    }
}

/// Closed bodies lit from above, seen from below: exactly black.
#[test]
fn nothing_leaks_to_the_far_side() {
    for (bump, shape) in [
        (true, Shape::Sphere { center: DVec3::ZERO, radius: 1.0 }),
        (true, smooth_ball(2)),
        (false, smooth_ball(1)),
        (true, cube(false)),
    ] {
        let mut parts = Parts::default();
        let white = parts.diffuse([0.9; 3]);
        if bump {
            parts.0.materials[white].relief = Some(waves(0.1));
        }
        let shape = parts.shape(shape);
        parts.place(shape, DAffine3::from_rotation_y(0.3), white);
        sun(&mut parts, DVec3::Y);
        let view = camera(dvec3(0.0, -8.0, 0.0), DVec3::ZERO);
        let settings = statistics(Integrator::Path, 16);
        let values = interleaved(&picture(&parts.build(), &view, [64, 64], &settings));
        // The middle of the far side, away from a lifted terminator at the silhouette.
        let middle = (20..44).flat_map(|y| (20..44).map(move |x| 3 * (y * 64 + x)));
        assert!(middle.clone().all(|i| values[i] == 0.0), "light leaks through a closed body");
    }
}

/// Strong bumps on bodies in a furnace: nothing shines brighter than what is around it.
#[test]
fn bumps_gain_no_energy() {
    let gold = etendue::bsdf::metals::find("gold").expect("a known metal");
    let materials = [
        ("diffuse", Scattering::Diffuse { reflectance: Spectrum::ONE, transmittance: Spectrum::BLACK }, 0.8),
        ("mirror", Scattering::Mirror { reflectance: Spectrum::ONE }, 0.8),
        ("metal", Scattering::RoughMetal { eta: gold.eta, k: gold.k, alpha: [0.3; 2], tint: Spectrum::ONE }, 0.4),
        (
            "glass",
            Scattering::Glass {
                ior: 1.5,
                reflection_tint: Spectrum::ONE,
                transmission_tint: Spectrum::ONE,
                thin: false,
            },
            0.7,
        ),
    ];
    for (name, scattering, least) in materials {
        // Without texture coordinates, the waves are in each face of the mesh.
        for (shape, height) in [(Shape::Sphere { center: DVec3::ZERO, radius: 1.0 }, 0.05), (smooth_ball(2), 0.003)] {
            let mut parts = Parts::default();
            let material = parts.material(scattering);
            parts.0.materials[material].relief = Some(waves(height));
            let shape = parts.shape(shape);
            parts.place(shape, DAffine3::IDENTITY, material);
            parts.0.environment = Some(Spectrum::ONE.into());
            let view = camera(dvec3(0.0, 0.0, 4.0), DVec3::ZERO);
            let settings = statistics(Integrator::Path, 64);
            let moments = means(&parts.build(), &view, [24, 24], &settings, 8);
            let (mean, error) = (moments.mean(), moments.standard_error());
            println!("{name}: {mean:.4} +- {error:.4}");
            assert!(mean - 3.0 * error <= 1.0 && mean > least, "{name}: mean {mean} +- {error}");
        }
    }
}

/// With strong bumps and on coarse meshes light and BSDF samples weigh the same integrand.
#[test]
fn solvers_agree() {
    let mut parts = Parts::default();
    let (white, red) = (parts.diffuse([0.7; 3]), parts.diffuse([0.8, 0.3, 0.2]));
    let gold = etendue::bsdf::metals::find("gold").expect("a known metal");
    let metal =
        parts.material(Scattering::RoughMetal { eta: gold.eta, k: gold.k, alpha: [0.3; 2], tint: Spectrum::ONE });
    let frosted = parts.material(Scattering::RoughGlass {
        ior: 1.4,
        alpha: 0.3,
        reflection_tint: Spectrum::ONE,
        transmission_tint: Spectrum::ONE,
    });
    for material in [red, metal, frosted] {
        parts.0.materials[material].relief = Some(waves(0.1));
    }
    let lamp = parts.emitter([4.0, 3.5, 3.0], false);
    floor(&mut parts, 4.0, white);
    let coarse = parts.shape(smooth_ball(1));
    for (x, material) in [(-1.7, white), (0.0, red), (1.7, metal)] {
        let place = DAffine3::from_translation(dvec3(x, 0.8, 0.0)) * DAffine3::from_scale(dvec3(0.8, 0.7, 0.8));
        parts.place(coarse, place, material);
    }
    parts.sphere(dvec3(-0.9, 0.5, 1.3), 0.5, frosted);
    parts.sphere(dvec3(0.9, 0.5, 1.3), 0.5, metal);
    parts.rectangle(dvec3(2.5, 1.0, -1.0), dvec3(0.0, 0.0, 2.0), dvec3(0.3, 1.5, 0.0), lamp);
    parts.0.environment = Some(Spectrum::splat(0.2).into());
    let (scene, view) = (parts.build(), camera(dvec3(0.0, 2.5, 6.0), dvec3(0.0, 0.6, 0.0)));
    let replicates = |integrator: usize, spp: u32| {
        let mut all = Replicates::new([24, 24], 3, 8);
        for replicate in 0..32 {
            let mut settings = statistics(SOLVERS[integrator], spp);
            settings.seed = 9000 * (integrator as u64 + 1) + replicate;
            settings.max_depth = Some(8);
            all.push(&interleaved(&picture(&scene, &view, [24, 24], &settings)));
        }
        all
    };
    let path = replicates(0, 48);
    let demands = Demands { level: etendue_testkit::sidak(0.01, 2), ..Demands::default() };
    for (other, spp) in [(1, 64), (2, 96)] {
        compare(&path, &replicates(other, spp)).assert(demands, &format!("path against {}", SOLVERS[other]));
    }
}
