//! Emission with textures: what light samples carry is what rays find, it is drawn where the light is, and all solvers agree.
#![allow(clippy::disallowed_methods, reason = "references are computed with the platform's functions")]

mod common;

use common::*;
use etendue::{
    bsdf::Density,
    camera::CameraSettings,
    integrator::Integrator,
    light::LightContext,
    material::Color,
    math::{DAffine3, DVec3, Vec3, dvec3, vec3},
    scene::{Mesh, Scene, Shape},
    spectrum::Spectrum,
    texture::{
        Channel, Checker, Coordinates, Filtering, Grid, Mapping, Noise, Pattern, Procedure, Samples, Texture,
        TextureImage, Transfer, Wrap,
    },
};
use etendue_accel::{Hit, PrimitiveId, Ray};
use etendue_testkit::{
    Moments, Rng,
    chi2::ChiSquare,
    tiles::{Demands, Replicates, compare},
};
use std::sync::Arc;

fn texture(size: [u32; 2], mapping: Mapping, texel: impl Fn(u32, u32) -> [f32; 3]) -> Arc<Texture> {
    let samples: Vec<f32> = (0..size[0] * size[1]).flat_map(|i| texel(i % size[0], i / size[0])).collect();
    let image = TextureImage::new(size[0], size[1], 3, Samples::F32(samples.into()), Transfer::Linear).unwrap();
    Arc::new(Texture { pattern: Pattern::Image(Arc::new(image)), mapping })
}

/// Dark blue with one brighter spot.
fn screen(spot: [f32; 3]) -> Arc<Texture> {
    let spot = |x: u32, y: u32| if (20..22).contains(&x) && y == 9 { spot } else { [0.05, 0.08, 0.2] };
    texture([48, 27], Mapping { wrap: [Wrap::Clamp; 2], ..Mapping::default() }, spot)
}

/// A thousand times as bright as the rest.
const SPOT: [f32; 3] = [120.0, 100.0, 80.0];

/// Black and two colours, nearest.
fn checker() -> Arc<Texture> {
    let colours = [[0.0; 3], [4.0, 3.0, 1.0], [0.0; 3], [0.5, 1.0, 4.0]];
    let mapping = Mapping { filtering: Filtering::Nearest, ..Mapping::default() };
    texture([4, 4], mapping, |x, y| colours[((x + y) % 4) as usize])
}

/// Opacity from 0.2 to 1.
fn veil() -> Arc<Texture> {
    let mapping = Mapping { channel: Channel::Red, base: 0.2, gain: 0.8, ..Mapping::default() };
    texture([3, 2], mapping, |x, y| [f32::from(x as u8 == y as u8); 3])
}

fn lamp(parts: &mut Parts, factor: f32, image: Arc<Texture>, two_sided: bool) -> usize {
    let lamp = parts.emitter([1.0; 3], two_sided);
    let radiance = Color { factor: Spectrum::splat(factor), texture: Some(image) };
    parts.0.materials[lamp].emission.as_mut().unwrap().radiance = radiance;
    lamp
}

/// Two triangles with texture coordinates that are turned and stretched.
fn sheet() -> Shape {
    let Shape::Mesh(bare) =
        mesh(vec![[0.0, 0.0, 0.0], [1.0, 0.1, 0.0], [1.1, 0.9, 0.2], [-0.1, 1.0, 0.0]], vec![[0, 1, 2], [0, 2, 3]])
    else {
        unreachable!("a mesh is a mesh")
    };
    let uvs = vec![[0.1, 0.2], [1.3, 0.4], [1.2, 1.6], [-0.3, 1.1]];
    Shape::Mesh(Mesh { uvs: Some(uvs.into()), ..bare })
}

/// A floor under a screen, a mirrored instance and a plain one of a sheet, a veiled ellipsoid.
fn many_lamps() -> (Scene, CameraSettings) {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.6; 3]);
    parts.rectangle(dvec3(-3.0, 0.0, -3.0), dvec3(0.0, 0.0, 6.0), dvec3(6.0, 0.0, 0.0), white);
    let screen = lamp(&mut parts, 1.0, screen([20.0, 16.0, 12.0]), false);
    parts.rectangle(dvec3(-1.6, 0.9, -1.0), dvec3(1.6, 0.0, 0.0), dvec3(0.0, 0.9, 0.0), screen);
    let checks = lamp(&mut parts, 0.8, checker(), true);
    parts.0.materials[checks].opacity.texture = Some(veil());
    let sheet = parts.shape(sheet());
    let turn = DAffine3::from_rotation_x(-1.2);
    parts.place(sheet, DAffine3::from_translation(dvec3(0.5, 1.2, -0.5)) * turn, checks);
    let mirror = DAffine3::from_scale(dvec3(-0.8, 0.6, 0.7));
    parts.place(sheet, DAffine3::from_translation(dvec3(2.2, 1.0, 0.3)) * mirror * turn, checks);
    let globe = lamp(&mut parts, 0.4, checker(), false);
    parts.0.materials[globe].opacity = etendue::material::Number { factor: 0.9, texture: Some(veil()) };
    let ball = parts.shape(Shape::Sphere { center: DVec3::ZERO, radius: 0.3 });
    let stretch = DAffine3::from_rotation_z(0.4) * DAffine3::from_scale(dvec3(1.0, 1.5, 0.8));
    parts.place(ball, DAffine3::from_translation(dvec3(-0.9, 1.3, 0.6)) * stretch, globe);
    (parts.build(), camera(dvec3(0.3, 2.6, 4.0), dvec3(0.0, 0.3, 0.0)))
}

#[test]
fn solvers_agree() {
    let (scene, view) = many_lamps();
    let replicates = |integrator: usize, spp: u32| {
        let mut all = Replicates::new([24, 24], 3, 8);
        for replicate in 0..32 {
            let mut settings = statistics(SOLVERS[integrator], spp);
            settings.seed = 1000 * (integrator as u64 + 1) + replicate;
            settings.max_depth = Some(3);
            all.push(&interleaved(&picture(&scene, &view, [24, 24], &settings)));
        }
        all
    };
    let path = replicates(0, 256);
    let demands = Demands { level: etendue_testkit::sidak(0.01, 2), ..Demands::default() };
    for (other, spp) in [(1, 256), (2, 640)] {
        compare(&path, &replicates(other, spp)).assert(demands, &format!("path against {}", SOLVERS[other]));
    }
}

fn ray(origin: Vec3, direction: Vec3, t_max: f32) -> Ray {
    let (origin, direction) = (origin.into(), direction.into());
    Ray { origin, t_min: 0.0, direction, t_max, time: 0.0, mask: u32::MAX, skip: PrimitiveId::NONE }
}

/// A ray along a sample, as far as its target and a little on, hits the light that was sampled, where it was: density,
/// radiance and opacity are the same there. Points on the edge of a piece or texel may be told apart.
#[test]
fn samples_are_what_rays_find() {
    let (scene, _) = many_lamps();
    let mut rng = Rng::new(4);
    let (mut compared, mut differ) = (0, 0);
    for _ in 0..20_000 {
        let point = vec3(rng.f32() * 4.0 - 2.0, rng.f32() * 2.0, rng.f32() * 4.0 - 2.0);
        let ctx = LightContext { point, normal: Vec3::ZERO, transmits: true, time: 0.0 };
        let Some(sample) = scene.sample_light(&ctx, rng.f64(), rng.f32x2()) else { continue };
        let target = sample.target.expect("all lights are near");
        let distance = (target - point).length();
        // Past the target by more than its lift, and not beyond the light.
        let mut hits = [Hit::MISS];
        let near = ray(point + sample.wi * (distance - 1e-4), sample.wi, 2e-3);
        scene.accelerator().closest_hits(&[near], &mut hits);
        if !hits[0].is_hit() {
            continue;
        }
        let surface = scene.surface_point(&near, &hits[0]);
        if surface.geometric_normal.dot(sample.wi).abs() < 0.05 {
            continue;
        }
        let Density::SolidAngle(density) = sample.density else { panic!("no light is discrete") };
        let pdf = scene.lights().pdf_hit(&ctx, surface.light, sample.wi, distance);
        let material = &scene.materials()[surface.material as usize];
        let emitted = material.emission.as_ref().expect("a light was sampled");
        let at = scene.lookup(&surface, &hits[0]);
        let found = emitted.at(&at) * scene.opacity(&surface, &hits[0]);
        let close = |a: f32, b: f32| (a - b).abs() <= 2e-2 * a.max(b) + 1e-5;
        let same = close(density, pdf) && (0..3).all(|c| close(sample.radiance[c], found[c]));
        compared += 1;
        differ += u32::from(!same);
    }
    assert!(compared > 8_000, "only {compared} compared");
    assert!(differ * 100 < compared, "{differ} of {compared} differ");
}

/// A rectangle with one bright texel in the blur of bilinear lookups, seen from a point.
#[test]
fn chi_square_of_points_on_a_textured_rectangle() {
    let mut parts = Parts::default();
    let screen = lamp(&mut parts, 1.0, screen(SPOT), false);
    parts.rectangle(dvec3(-0.8, -0.45, 0.0), dvec3(1.6, 0.0, 0.0), dvec3(0.0, 0.9, 0.0), screen);
    let scene = parts.build();
    let (corner, ctx) = (dvec3(-0.8, -0.45, 0.0), vec3(0.3, -0.2, 0.9));
    let ctx = LightContext { point: ctx, normal: Vec3::ZERO, transmits: true, time: 0.0 };
    ChiSquare::new(if proving() { 2_000_000 } else { 100_000 })
        .stray_fraction(1e-3)
        .mass_tolerance(2e-3)
        .rectangle(
            [0.0, 1.0],
            [0.0, 1.0],
            |rng| {
                let sample = scene.sample_light(&ctx, rng.f64(), rng.f32x2())?;
                let at = ctx.point + sample.wi * (-ctx.point.z / sample.wi.z);
                let at = at.as_dvec3() - corner;
                Some([at.x / 1.6, at.y / 0.9])
            },
            |[s, t]| {
                let target = (corner + dvec3(1.6 * s, 0.9 * t, 0.0)).as_vec3();
                let offset = target - ctx.point;
                let beam = ray(ctx.point, offset, 2.0);
                let mut hits = [Hit::MISS];
                scene.accelerator().closest_hits(&[beam], &mut hits);
                if !hits[0].is_hit() {
                    return 0.0;
                }
                let light = scene.surface_point(&beam, &hits[0]).light;
                let (distance, wi) = (offset.length(), offset.normalize());
                let pdf = f64::from(scene.lights().pdf_hit(&ctx, light, wi, distance));
                pdf * f64::from(wi.z.abs() / (distance * distance)) * 1.6 * 0.9
            },
        )
        .assert(0.01, 1, "points on a screen");
}

/// Where the texture is the same everywhere, nothing is different from a plain emitter.
#[test]
fn an_even_texture_is_as_bright_as_none() {
    let lit = |textured: bool| {
        let mut parts = Parts::default();
        let white = parts.diffuse([0.6; 3]);
        parts.rectangle(dvec3(-3.0, 0.0, -3.0), dvec3(0.0, 0.0, 6.0), dvec3(6.0, 0.0, 0.0), white);
        let even = texture([16, 16], Mapping::default(), |_, _| [2.0, 2.0, 2.0]);
        let light = if textured { lamp(&mut parts, 0.5, even, false) } else { parts.emitter([1.0; 3], false) };
        parts.rectangle(dvec3(-0.5, 1.0, -0.5), dvec3(1.0, 0.0, 0.0), dvec3(0.0, 0.0, 1.0), light);
        parts.build()
    };
    let view = camera(dvec3(0.0, 2.0, 5.0), dvec3(0.0, 0.0, 0.0));
    let mean = |scene: &Scene| means(scene, &view, [16, 16], &statistics(Integrator::Path, 64), 16);
    let (textured, plain) = (lit(true), lit(false));
    assert!(textured.lights().lights().len() == 256 && plain.lights().lights().len() == 1);
    assert_mean("textured", &mean(&textured), mean(&plain).mean(), 0.004);
}

/// Light that a procedure gives, in texture coordinates and in space, on a rectangle, a mesh and a ball.
#[test]
fn solvers_agree_on_computed_light() {
    let mut parts = Parts::default();
    let white = parts.diffuse([0.6; 3]);
    parts.rectangle(dvec3(-3.0, 0.0, -3.0), dvec3(0.0, 0.0, 6.0), dvec3(6.0, 0.0, 0.0), white);
    let of = |procedure, coordinates| {
        let colors = [Spectrum::BLACK.into(), Spectrum([3.0, 2.0, 0.5]).into()];
        Arc::new(Texture::of(Pattern::Procedure { procedure, coordinates, colors }))
    };
    let space = Coordinates::Object { scale: Vec3::splat(4.0), offset: Vec3::ZERO };
    let screen = lamp(&mut parts, 1.0, of(Procedure::Checker(Checker), space), true);
    parts.rectangle(dvec3(-1.6, 0.9, -1.0), dvec3(1.6, 0.0, 0.0), dvec3(0.0, 0.9, 0.0), screen);
    let clouds = lamp(&mut parts, 1.5, of(Procedure::Noise(Noise::DEFAULT), space), false);
    let ball = parts.shape(Shape::Sphere { center: DVec3::ZERO, radius: 0.3 });
    parts.place(ball, DAffine3::from_translation(dvec3(-0.9, 1.3, 0.6)), clouds);
    let board = lamp(&mut parts, 0.8, of(Procedure::Grid(Grid { width: 0.4 }), Coordinates::Uv), true);
    parts.0.materials[board].opacity.texture = Some(of(Procedure::Checker(Checker), space));
    let sheet = parts.shape(sheet());
    parts.place(sheet, DAffine3::from_translation(dvec3(0.5, 1.2, -0.5)) * DAffine3::from_rotation_x(-1.2), board);
    let (scene, view) = (parts.build(), camera(dvec3(0.3, 2.6, 4.0), dvec3(0.0, 0.3, 0.0)));
    let mean = |integrator, spp| {
        let settings = statistics(integrator, spp);
        means(&scene, &view, [12, 12], &etendue::render::RenderSettings { max_depth: Some(3), ..settings }, 24)
    };
    let path = mean(Integrator::Path, 128);
    for (integrator, spp) in [(Integrator::LightSplit, 128), (Integrator::Brute, 512)] {
        let other = mean(integrator, spp);
        let (a, b) = (path.standard_error(), other.standard_error());
        let error = (a * a + b * b).sqrt();
        let sigma = (path.mean() - other.mean()) / error;
        assert!(error < 0.01 * path.mean(), "{integrator}: {error} of {}", path.mean());
        assert!(sigma.abs() < 3.5, "{integrator}: {} and {}, {sigma:.1} sigma", path.mean(), other.mean());
    }
}

/// One bright spot on a dark screen: light samples go there.
#[test]
fn a_bright_spot_is_sampled_where_it_is() {
    let (scene, view) = {
        let mut parts = Parts::default();
        let white = parts.diffuse([0.6; 3]);
        parts.rectangle(dvec3(-3.0, 0.0, -3.0), dvec3(0.0, 0.0, 6.0), dvec3(6.0, 0.0, 0.0), white);
        let screen = lamp(&mut parts, 1.0, screen(SPOT), false);
        parts.rectangle(dvec3(-0.8, 0.4, 0.0), dvec3(1.6, 0.0, 0.0), dvec3(0.0, 0.9, 0.0), screen);
        (parts.build(), camera(dvec3(0.0, 3.0, 3.5), dvec3(0.0, 0.0, 1.0)))
    };
    let variance = |integrator: Integrator| {
        let pictures: Vec<Vec<f32>> = (0..24)
            .map(|seed| {
                let settings = statistics(integrator, 64);
                let settings = etendue::render::RenderSettings { seed, max_depth: Some(2), ..settings };
                interleaved(&picture(&scene, &view, [16, 16], &settings))
            })
            .collect();
        let of = |pixel: usize| pictures.iter().map(|p| f64::from(p[pixel])).collect::<Moments>().variance();
        // The lower rows show the floor alone.
        let pixels = 16 * 10 * 3..16 * 16 * 3;
        let count = pixels.len() as f64;
        pixels.map(of).sum::<f64>() / count
    };
    let (path, brute) = (variance(Integrator::Path), variance(Integrator::Brute));
    println!("variance at 64 samples: path {path:.3e}, brute {brute:.3e}, ratio {:.0}", brute / path);
    assert!(brute > 100.0 * path, "path {path:.3e}, brute {brute:.3e}");
}

/// A large mesh of which little shines has lights where it shines only, however many faces and texels there are.
#[test]
fn lights_are_bounded_and_where_the_texture_shines() {
    const SIDE: u32 = 100;
    let at = |i: u32| [(i % (SIDE + 1)) as f32 / SIDE as f32, (i / (SIDE + 1)) as f32 / SIDE as f32];
    let uvs: Vec<[f32; 2]> = (0..(SIDE + 1) * (SIDE + 1)).map(at).collect();
    let indices = (0..SIDE * SIDE).flat_map(|i| {
        let a = i / SIDE * (SIDE + 1) + i % SIDE;
        [[a, a + 1, a + SIDE + 2], [a, a + SIDE + 2, a + SIDE + 1]]
    });
    let Shape::Mesh(bare) = mesh(uvs.iter().map(|[x, y]| [*x, *y, 0.0]).collect(), indices.collect()) else {
        unreachable!("a mesh is a mesh")
    };
    let count = |lit: fn(u32, u32) -> bool| {
        let mut parts = Parts::default();
        let image = texture([1000, 1000], Mapping::default(), |x, y| [f32::from(u8::from(lit(x, y))); 3]);
        let glow = lamp(&mut parts, 1.0, image, false);
        let shape = parts.shape(Shape::Mesh(Mesh { uvs: Some(uvs.clone().into()), ..bare.clone() }));
        parts.place(shape, DAffine3::IDENTITY, glow);
        let scene = parts.build();
        let lights = scene.lights();
        (lights.lights().len(), (0..lights.lights().len() as u32).filter(|i| lights.may_choose(*i)).count())
    };
    let (few, chosen) = count(|x, y| (500..503).contains(&x) && y == 300);
    assert!((100..1000).contains(&few) && chosen > 0 && chosen < few, "{few} lights, {chosen} shine");
    let (all, _) = count(|_, _| true);
    assert!((100_000..=1 << 18).contains(&all), "{all} lights");
}
