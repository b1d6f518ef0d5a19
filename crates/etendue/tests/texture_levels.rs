//! Coarser copies of images: they keep means, the footprint picks the right one, and far floors do not alias.
#![allow(clippy::disallowed_methods, reason = "references are computed with the platform's functions")]

mod common;

use common::*;
use etendue::{
    camera::{Camera, CameraSettings, Projection},
    integrator::Integrator,
    material::{Color, Scattering},
    math::{DVec3, Vec2, Vec3, dvec3, vec2},
    render::RenderSettings,
    scene::Scene,
    spectrum::Spectrum,
    texture::{
        Filtering, Footprint, Lookup, Mapping, Pattern, RayCone, Samples, Texture, TextureImage, Transfer, UvTransform,
        Wrap,
    },
};
use etendue_accel::{Hit, PrimitiveId, Ray};
use etendue_testkit::Rng;
use std::sync::Arc;

fn image(size: [u32; 2], channels: usize, samples: Samples, transfer: Transfer) -> Arc<TextureImage> {
    let image = TextureImage::new(size[0], size[1], channels, samples, transfer).unwrap();
    image.build_levels();
    Arc::new(image)
}

fn random(size: [u32; 2], channels: usize, seed: u64) -> Arc<TextureImage> {
    let mut rng = Rng::new(seed);
    let samples: Vec<f32> = (0..size[0] as usize * size[1] as usize * channels).map(|_| rng.f32()).collect();
    image(size, channels, Samples::F32(samples.into()), Transfer::Linear)
}

fn mean(size: [u32; 2], texel: impl Fn(u32, u32) -> [f32; 4]) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for y in 0..size[1] {
        for x in 0..size[0] {
            let value = texel(x, y);
            (0..4).for_each(|c| sum[c] += f64::from(value[c]));
        }
    }
    sum.map(|sum| sum / f64::from(size[0]) / f64::from(size[1]))
}

#[test]
fn every_level_has_the_mean_of_the_image() {
    let mut rng = Rng::new(2);
    for size in [[1, 1], [2, 2], [7, 5], [64, 64], [1, 333], [16384, 1], [3, 1024], [255, 31]] {
        for channels in 1..=4 {
            let count = size[0] as usize * size[1] as usize * channels;
            let bytes: Vec<u8> = (0..count).map(|_| rng.u64() as u8).collect();
            let words: Vec<u16> = (0..count).map(|_| rng.u64() as u16).collect();
            let floats: Vec<f32> = (0..count).map(|_| rng.f32() * 50.0 - 10.0).collect();
            for (samples, transfer, tolerance) in [
                (Samples::U8(bytes.clone().into()), Transfer::Srgb, 1e-4),
                (Samples::U8(bytes.into()), Transfer::Linear, 1e-4),
                (Samples::U16(words.into()), Transfer::Srgb, 1e-4),
                (Samples::F32(floats.into()), Transfer::Linear, 2e-4),
            ] {
                let image = image(size, channels, samples, transfer);
                let whole = mean(size, |x, y| image.texel(x, y));
                let mut expected = size;
                for (number, level) in image.levels().iter().enumerate() {
                    expected = expected.map(|n| (n / 2).max(1));
                    assert_eq!(level.size(), expected);
                    let found = mean(level.size(), |x, y| level.texel(x, y));
                    for c in 0..4 {
                        let error = (found[c] - whole[c]).abs();
                        assert!(error < tolerance, "{size:?} {channels} level {number}: {found:?}, not {whole:?}");
                    }
                }
                assert_eq!(expected, [1, 1], "down to one texel");
                let bytes: usize = image.levels().iter().map(|level| level.bytes()).sum();
                // Two thirds of 8 bits, one third of more; twice as much where one side is 1 already.
                assert!(bytes <= 2 * image.bytes() + 8 * channels, "{size:?}: {bytes} of {}", image.bytes());
            }
        }
    }
    let even = image([256, 256], 3, Samples::U8(vec![10; 3 << 16].into()), Transfer::Srgb);
    assert_eq!(even.levels().iter().map(|l| l.bytes()).sum::<usize>(), 2 * 3 * ((1 << 16) - 1) / 3);
    assert!(even.with_transfer(Transfer::Linear).levels().is_empty(), "another meaning has other means");
}

/// Where the footprint is as wide as a texel of a level, lookups at its texels are that level.
#[test]
fn the_footprint_picks_the_level() {
    let image = random([64, 32], 1, 5);
    for transform in [UvTransform::default(), UvTransform::new([2.0, 3.0], 90.0, [0.25, 0.5])] {
        let texture =
            Texture { pattern: Pattern::Image(image.clone()), mapping: Mapping { transform, ..Mapping::default() } };
        for (number, level) in image.levels().iter().take(5).enumerate() {
            let [width, height] = level.size().map(|n| n as f32);
            for (x, y) in [(0, 0), (1, 0), (level.size()[0] - 1, level.size()[1] - 1)] {
                let inside = vec2((x as f32 + 0.5) / width, 1.0 - (y as f32 + 0.5) / height);
                // From the image's coordinates back to those of the surface.
                let undo = |v: Vec2| match transform == UvTransform::default() {
                    true => v,
                    false => vec2(v.y / 2.0, -v.x / 3.0),
                };
                let uv = undo(inside - transform.apply(Vec2::ZERO));
                let axes = [undo(vec2(1.0 / width, 0.0)), undo(vec2(0.0, 1.0 / height))];
                let footprint = Footprint { uv: axes, ..Footprint::default() };
                let found = texture.number(&Lookup { footprint, ..uv.into() });
                let expected = level.texel(x, y)[0];
                assert!((found - expected).abs() < 1e-4, "level {number} at {x}, {y}: {found}, not {expected}");
                // Half way to the next level, the mean of both.
                let between = Footprint { uv: axes.map(|a| a * std::f32::consts::SQRT_2), ..Footprint::default() };
                let found = texture.number(&Lookup { footprint: between, ..uv.into() });
                assert!(image.levels().get(number + 1).is_none() || (found - expected).abs() < 0.5);
            }
        }
        let all = Footprint { uv: [vec2(50.0, 0.0), vec2(0.0, 50.0)], ..Footprint::default() };
        let whole = mean(image.size(), |x, y| image.texel(x, y))[0] as f32;
        let found = texture.number(&Lookup { footprint: all, ..vec2(0.3, 0.8).into() });
        assert!((found - whole).abs() < 1e-4, "the whole image: {found}, not {whole}");
        let point = texture.number(&vec2(0.3, 0.8).into());
        let bilinear = Texture { mapping: Mapping { filtering: Filtering::Bilinear, ..texture.mapping }, ..texture };
        assert_eq!(point, bilinear.number(&vec2(0.3, 0.8).into()), "a point is bilinear to the bit");
    }
}

/// A footprint that is long in one direction is blurred along it alone.
#[test]
fn long_footprints_stay_sharp_across() {
    let stripes: Vec<f32> = (0..64 * 64).map(|i| (i % 64 % 2) as f32).collect();
    let texture = Texture::new(image([64, 64], 1, Samples::F32(stripes.into()), Transfer::Linear));
    let long = |along: Vec2, across: Vec2| Footprint { uv: [along, across], ..Footprint::default() };
    let texel = 1.0 / 64.0;
    let at = |footprint| texture.number(&Lookup { footprint, ..vec2(1.5 * texel, 0.5).into() });
    let along_stripes = at(long(vec2(0.0, 6.0 * texel), vec2(texel, 0.0)));
    let across_stripes = at(long(vec2(0.0, texel), vec2(6.0 * texel, 0.0)));
    assert!((along_stripes - 1.0).abs() < 1e-4, "{along_stripes}");
    assert!((across_stripes - 0.5).abs() < 1e-4, "{across_stripes}");
}

#[test]
fn edges_hold_at_every_level() {
    let image = random([37, 12], 4, 9);
    let mut rng = Rng::new(3);
    for wrap in Wrap::ALL {
        let mapping = Mapping { wrap: [wrap; 2], ..Mapping::default() };
        let texture = Texture { pattern: Pattern::Image(image.clone()), mapping };
        for _ in 0..3000 {
            let uv = vec2(rng.f32() * 2.0 - 1.0, rng.f32() * 2.0 - 1.0);
            let width = 0.001 * 2000.0f32.powi(i32::from(rng.f32() < 0.5)) * rng.f32();
            let footprint = Footprint { uv: [vec2(width, 0.0), vec2(0.0, width * rng.f32())], ..Footprint::default() };
            let at = |uv: Vec2| texture.color(&Lookup { footprint, ..uv.into() });
            let close = |a: Spectrum, b: Spectrum| (0..3).all(|c| (a[c] - b[c]).abs() < 2e-3);
            let here = at(uv);
            match wrap {
                Wrap::Repeat => assert!(close(here, at(uv + vec2(1.0, -2.0))), "{uv} {width}"),
                Wrap::Mirror => {
                    assert!(close(here, at(uv + vec2(2.0, -2.0))), "{uv} {width}");
                    assert!(close(here, at(-uv)), "{uv} {width}: {here:?} mirrored {:?}", at(-uv));
                    assert!(close(here, at(vec2(2.0, 2.0) - uv)), "{uv} {width}");
                }
                Wrap::Clamp => assert!(close(at(vec2(9.0, uv.y)), at(vec2(77.0, uv.y)))),
                Wrap::Black => assert_eq!(at(vec2(9.0, uv.y)), Spectrum::BLACK),
            }
        }
    }
}

#[test]
fn no_footprint_breaks_a_lookup() {
    let mut rng = Rng::new(6);
    let extremes = [0.0, -0.0, 1.0, f32::MAX, f32::MIN, f32::INFINITY, f32::NAN, 1e-40, 16_777_216.0, 1e-20, -3.0];
    for size in [[1, 1], [1, 77], [16384, 1], [3, 5], [64, 64]] {
        let texture = Texture::new(random(size, 2, 8));
        for _ in 0..20_000 {
            let mut number = || match rng.f32() {
                x if x < 0.5 => extremes[(x * 22.0) as usize],
                x => (x - 0.75) * 10.0,
            };
            let mut pair = || vec2(number(), number());
            let footprint = Footprint { uv: [pair(), pair()], ..Footprint::default() };
            let at = Lookup { footprint, ..pair().into() };
            for wrap in Wrap::ALL {
                let mapping = Mapping { wrap: [wrap; 2], ..Mapping::default() };
                let value = Texture { mapping, ..texture.clone() }.number(&at);
                assert!((-1e-5..=1.00001).contains(&value), "{wrap} {size:?} at {at:?}: {value}");
            }
        }
    }
}

fn ray(origin: Vec3, direction: Vec3) -> Ray {
    Ray {
        origin: origin.into(),
        t_min: 0.0,
        direction: direction.into(),
        t_max: f32::INFINITY,
        time: 0.0,
        mask: u32::MAX,
        skip: PrimitiveId::NONE,
    }
}

/// A square of 4 m with texture coordinates from 0 to 1, seen from above: of a plane that faces the camera the footprint is the
/// pixel; of an inclined one it is longer along the view.
#[test]
fn footprints_are_those_of_pixels() {
    for (projection, pixel) in [
        (Projection::Orthographic { height: 2.0 }, 2.0 / 50.0),
        (camera(DVec3::Y, DVec3::ZERO).projection, 2.0 * 3.0 * 20f64.to_radians().tan() / 100.0),
    ] {
        for (slope, longer) in [(0.0, 1.0), (1.0, 2f64.sqrt())] {
            let mut parts = Parts::default();
            let white = parts.diffuse([0.5; 3]);
            parts.rectangle(dvec3(-2.0, -2.0 * slope, 2.0), dvec3(4.0, 4.0 * slope, 0.0), dvec3(0.0, 0.0, -4.0), white);
            let scene = parts.build();
            let view = CameraSettings { projection, ..camera(dvec3(0.0, 3.0, 0.0), DVec3::ZERO) };
            let camera = Camera::new(&view, [100, 50], scene.center()).unwrap();
            let camera_ray = camera.ray(50.0, 25.0, [0.5; 2]);
            let ray = ray(camera_ray.origin, camera_ray.direction);
            let mut hits = [Hit::MISS];
            scene.accelerator().closest_hits(&[ray], &mut hits);
            let point = scene.surface_point(&ray, &hits[0]);
            let cone = camera.cone(camera_ray.direction).advanced(hits[0].t);
            assert!((f64::from(cone.width) - pixel).abs() < 1e-4 * pixel, "{} of {pixel}", cone.width);
            let at = scene.lookup_over(&point, &hits[0], -camera_ray.direction, cone.width);
            let extent = at.uv_extent();
            // The rectangle is longer as well where it is inclined.
            let expected = [pixel / 4.0; 2];
            for (found, expected) in [(extent.x, expected[0]), (extent.y, expected[1])] {
                assert!((f64::from(found) - expected).abs() < 2e-3 * expected, "{slope}: {extent}, not {expected}");
            }
            let metres = at.footprint.position.map(|axis| f64::from(axis.length()));
            assert!((metres[0].max(metres[1]) - pixel * longer).abs() < 2e-3 * pixel, "{metres:?}");
        }
    }
    let wider = RayCone { width: 0.1, spread: 0.01 }.advanced(10.0);
    assert!((wider.width - 0.2).abs() < 1e-6);
    let diffuse = wider.scattered(etendue::bsdf::Density::SolidAngle(std::f32::consts::FRAC_1_PI));
    assert!((diffuse.spread - 0.51).abs() < 1e-4);
    assert_eq!(wider.scattered(etendue::bsdf::Density::Discrete(0.5)), wider);
    assert!(wider.scattered(etendue::bsdf::Density::SolidAngle(0.0)).spread < 0.6);
}

/// A floor of small tiles that goes to the horizon.
fn floor(filtering: Filtering) -> Scene {
    let tiles: Vec<f32> = (0..64 * 64).map(|i| if (i % 64 / 8 + i / 64 / 8) % 2 == 0 { 0.9 } else { 0.1 }).collect();
    let image = image([64, 64], 1, Samples::F32(tiles.into()), Transfer::Linear);
    let transform = UvTransform::new([60.0, 60.0], 0.0, [0.0, 0.0]);
    let mapping = Mapping { filtering, transform, ..Mapping::default() };
    let texture = Some(Arc::new(Texture { pattern: Pattern::Image(image), mapping }));
    let mut parts = Parts::default();
    let floor = parts.diffuse([1.0; 3]);
    let reflectance = Color { factor: Spectrum::ONE, texture };
    parts.0.materials[floor].scattering = Scattering::Diffuse { reflectance, transmittance: Spectrum::BLACK.into() };
    parts.rectangle(dvec3(-60.0, 0.0, 60.0), dvec3(120.0, 0.0, 0.0), dvec3(0.0, 0.0, -120.0), floor);
    parts.0.environment = Some(Spectrum::ONE.into());
    parts.build()
}

/// At one sample a pixel the far floor is near to what many samples make of it, and what many samples make of both is the
/// same but for a blur.
#[test]
fn far_floors_do_not_alias() {
    const SIZE: [u32; 2] = [96, 48];
    let view = camera(dvec3(0.3, 2.0, 55.0), dvec3(0.0, 0.0, 20.0));
    let render = |filtering, spp| {
        let settings = RenderSettings { max_depth: Some(2), ..statistics(Integrator::Brute, spp) };
        interleaved(&picture(&floor(filtering), &view, SIZE, &settings))
    };
    let truth = render(Filtering::Bilinear, 512);
    let difference = |values: &[f32]| {
        let squares = values.iter().zip(&truth).map(|(a, b)| f64::from(a - b).powi(2));
        (squares.sum::<f64>() / values.len() as f64).sqrt()
    };
    let mean = |values: &[f32]| values.iter().map(|v| f64::from(*v)).sum::<f64>() / values.len() as f64;
    let (filtered, unfiltered) =
        (difference(&render(Filtering::Trilinear, 1)), difference(&render(Filtering::Bilinear, 1)));
    let many = render(Filtering::Trilinear, 512);
    println!("one sample: {filtered:.4} filtered, {unfiltered:.4} not; many: {:.4}", difference(&many));
    assert!(filtered < 0.3 * unfiltered, "{filtered} and {unfiltered}");
    assert!(difference(&many) < filtered);
    let bias = mean(&many) - mean(&truth);
    assert!(bias.abs() < 0.004, "{bias}: {} and {}", mean(&many), mean(&truth));
}
