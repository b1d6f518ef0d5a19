//! Textures: where texels lie, what they decode to, and what materials make of them.
#![allow(clippy::disallowed_methods, reason = "references are computed with the platform's functions")]

mod common;

use common::*;
use etendue::{
    camera::{CameraSettings, Projection},
    integrator::Integrator,
    material::{Color, Material, Number, Relief, Scattering},
    math::{DAffine3, DVec3, Vec2, Vec3, dvec3, vec2, vec3},
    scene::{Mesh, Scene, Shape},
    spectrum::Spectrum,
    surface::Chart,
    texture::{
        Channel, Coordinates, Filtering, Footprint, Gradient, Lookup, Mapping, Pattern, Samples, Stop, Texture,
        TextureImage, Transfer, UvTransform, Wrap,
    },
};
use etendue_accel::{Hit, PrimitiveId, Ray};
use etendue_testkit::Rng;
use std::sync::Arc;

fn image(width: u32, height: u32, channels: usize, values: &[f32]) -> Arc<TextureImage> {
    let samples = Samples::F32(values.into());
    Arc::new(TextureImage::new(width, height, channels, samples, Transfer::Linear).unwrap())
}

fn grey(width: u32, height: u32, values: &[f32]) -> Texture {
    Texture::new(image(width, height, 1, values))
}

fn mapped(texture: &Texture, change: impl FnOnce(&mut Mapping)) -> Texture {
    let mut texture = texture.clone();
    change(&mut texture.mapping);
    texture
}

/// The first texel of the file is the upper left one, which has the largest v.
#[test]
fn texels_lie_where_the_image_shows_them() {
    let texture = grey(3, 2, &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0]);
    let centre = |x: f32, y: f32| vec2((x + 0.5) / 3.0, 1.0 - (y + 0.5) / 2.0);
    for filtering in Filtering::ALL {
        let texture = mapped(&texture, |m| m.filtering = filtering);
        for (i, expected) in [1.0, 2.0, 3.0, 4.0, 5.0, 6.0].into_iter().enumerate() {
            let found = texture.number(&centre((i % 3) as f32, (i / 3) as f32).into());
            assert!((found - expected).abs() < 1e-5, "{filtering}: texel {i} is {found}");
        }
    }
    assert!((texture.number(&vec2(1.0 / 3.0, 0.75).into()) - 1.5).abs() < 1e-5, "between the first two");
    assert!((texture.number(&vec2(0.5, 0.5).into()) - 3.5).abs() < 1e-5, "in the middle");
    let nearest = mapped(&texture, |m| m.filtering = Filtering::Nearest);
    assert_eq!(nearest.number(&vec2(0.32, 0.6).into()), 1.0);
    assert_eq!(nearest.number(&vec2(0.34, 0.4).into()), 5.0);
}

#[test]
fn beyond_the_edges() {
    let texture = grey(4, 1, &[1.0, 2.0, 3.0, 4.0]);
    let at = |wrap, x: f32| {
        let texture = mapped(&texture, |m| (m.wrap, m.filtering) = ([wrap; 2], Filtering::Nearest));
        texture.number(&vec2((x + 0.5) / 4.0, 0.5).into())
    };
    for (wrap, expected) in [
        (Wrap::Repeat, [3.0, 4.0, 1.0, 2.0, 3.0, 4.0, 1.0, 2.0]),
        (Wrap::Mirror, [2.0, 1.0, 1.0, 2.0, 3.0, 4.0, 4.0, 3.0]),
        (Wrap::Clamp, [1.0, 1.0, 1.0, 2.0, 3.0, 4.0, 4.0, 4.0]),
        (Wrap::Black, [0.0, 0.0, 1.0, 2.0, 3.0, 4.0, 0.0, 0.0]),
    ] {
        let found: Vec<f32> = (-2..6).map(|x| at(wrap, x as f32)).collect();
        assert_eq!(found, expected, "{wrap}");
        let far: Vec<f32> = (0..4).map(|x| at(wrap, 8000.0 + x as f32)).collect();
        let expected = match wrap {
            Wrap::Repeat | Wrap::Mirror => [1.0, 2.0, 3.0, 4.0],
            Wrap::Clamp => [4.0; 4],
            Wrap::Black => [0.0; 4],
        };
        assert_eq!(far, expected, "{wrap} a thousand images away");
    }
    // Bilinear lookups wrap too: between the last texel and the first.
    assert!((texture.number(&vec2(0.0, 0.5).into()) - 2.5).abs() < 1e-5);
    let clamped = mapped(&texture, |m| m.wrap = [Wrap::Clamp; 2]);
    assert!((clamped.number(&vec2(0.0, 0.5).into()) - 1.0).abs() < 1e-5);
}

/// Repeated and bilinear, an image's mean over the surface is the mean of its texels.
#[test]
fn a_lookup_loses_nothing() {
    let mut rng = Rng::new(1);
    let values: Vec<f32> = (0..35).map(|_| rng.f32()).collect();
    let mean = values.iter().sum::<f32>() / 35.0;
    let texture = grey(7, 5, &values);
    let n = 350;
    let sum: f64 = (0..n * n)
        .map(|i| f64::from(texture.number(&(vec2((i % n) as f32 + 0.5, (i / n) as f32 + 0.5) / n as f32).into())))
        .sum();
    assert!((sum / f64::from(n * n) - f64::from(mean)).abs() < 1e-4);
}

#[test]
fn stored_values_are_decoded() {
    let of = |samples, channels, transfer| Arc::new(TextureImage::new(1, 1, channels, samples, transfer).unwrap());
    let bytes = |b: &[u8]| Samples::U8(b.into());
    let srgb = |v: f64| if v <= 0.04045 { v / 12.92 } else { ((v + 0.055) / 1.055).powf(2.4) };
    for v in 0..=255u8 {
        let colour = of(bytes(&[v, 0, 255, v]), 4, Transfer::Srgb).texel(0, 0);
        let expected = srgb(f64::from(v) / 255.0) as f32;
        assert_eq!((colour[1], colour[2], colour[3]), (0.0, 1.0, f32::from(v) / 255.0), "opacity is linear");
        assert!((colour[0] - expected).abs() <= 1e-7 + 1e-6 * expected);
        assert_eq!(of(bytes(&[v]), 1, Transfer::Linear).texel(0, 0)[0], f32::from(v) / 255.0);
    }
    let wide = of(Samples::U16([40000u16, 65535].into()), 2, Transfer::Srgb).texel(0, 0);
    assert!((f64::from(wide[0]) - srgb(40000.0 / 65535.0)).abs() < 1e-6 && wide[3] == 1.0 && wide[1] == wide[0]);
    let float = of(Samples::F32([7.5, -1.0, 3.0].into()), 3, Transfer::Srgb);
    assert_eq!(float.texel(0, 0), [7.5, -1.0, 3.0, 1.0], "floats are linear");
    assert_eq!(float.range(), [-1.0, 7.5]);
    let image = of(bytes(&[188]), 1, Transfer::Linear);
    assert!((image.with_transfer(Transfer::Srgb).texel(0, 0)[0] - 0.502_886).abs() < 1e-5);
    for bad in [
        TextureImage::new(0, 1, 1, bytes(&[]), Transfer::Linear),
        TextureImage::new(1, 1, 5, bytes(&[0; 5]), Transfer::Linear),
        TextureImage::new(2, 1, 1, bytes(&[0]), Transfer::Linear),
        TextureImage::new(1, 1, 1, Samples::F32([f32::NAN].into()), Transfer::Linear),
        TextureImage::new(1 << 31, 1 << 31, 4, bytes(&[]), Transfer::Linear),
    ] {
        assert!(bad.is_err());
    }
}

#[test]
fn channels_gain_and_transform() {
    let texture = Texture::new(image(1, 1, 4, &[0.2, 0.4, 0.6, 0.8]));
    for (channel, expected) in [
        (Channel::Red, 0.2),
        (Channel::Green, 0.4),
        (Channel::Blue, 0.6),
        (Channel::Alpha, 0.8),
        (Channel::Luminance, Spectrum([0.2, 0.4, 0.6]).luminance()),
    ] {
        let texture = mapped(&texture, |m| m.channel = channel);
        assert_eq!(texture.number(&Vec2::ZERO.into()), expected, "{channel}");
        let affine = mapped(&texture, |m| (m.base, m.gain) = (1.0, -0.5));
        assert!((affine.number(&Vec2::ZERO.into()) - (1.0 - 0.5 * expected)).abs() < 1e-6);
    }
    let turned = UvTransform::new([2.0, 3.0], 90.0, [0.5, 0.25]).apply(vec2(1.0, 1.0));
    assert!((turned - vec2(-2.5, 2.25)).length() < 1e-5, "scaled, then turned, then moved: {turned}");
    for (texture, opaque) in [
        (mapped(&texture, |m| m.channel = Channel::Alpha), false),
        (Texture { mapping: Mapping { channel: Channel::Alpha, ..Mapping::default() }, ..grey(1, 1, &[0.0]) }, true),
        (mapped(&grey(1, 1, &[1.0]), |m| m.wrap = [Wrap::Black; 2]), false),
        (grey(2, 1, &[1.0, 1.0]), true),
        (grey(2, 1, &[1.0, 0.99]), false),
    ] {
        let opacity = Number { factor: 1.0, texture: Some(Arc::new(texture)) };
        let material = Material { opacity, ..Material::new("veil", Scattering::Black) };
        assert_eq!(material.is_opaque(), opaque, "{material:?}");
    }
}

#[test]
fn no_coordinate_breaks_a_lookup() {
    let mut rng = Rng::new(5);
    let texture = grey(3, 5, &(0..15).map(|i| i as f32).collect::<Vec<_>>());
    let extremes =
        [0.0, -0.0, 1.0, f32::MAX, f32::MIN, f32::INFINITY, f32::NAN, 1e-40, 0.999_999_94, 16_777_216.0, -1e7];
    for _ in 0..20_000 {
        let mut coordinate = || match rng.f32() {
            x if x < 0.5 => extremes[(x * 22.0) as usize],
            x => (x - 0.75) * 1e9,
        };
        let uv = vec2(coordinate(), coordinate());
        for wrap in Wrap::ALL {
            for filtering in Filtering::ALL {
                let texture = mapped(&texture, |m| (m.wrap, m.filtering) = ([wrap; 2], filtering));
                let value = texture.number(&uv.into());
                assert!((0.0..=14.0).contains(&value), "{wrap} {filtering} at {uv}: {value}");
            }
        }
    }
}

fn unit_sphere() -> Shape {
    Shape::Sphere { center: DVec3::ZERO, radius: 1.0 }
}

/// A bent quad of two triangles whose texture coordinates are turned and stretched.
fn bent() -> Shape {
    let Shape::Mesh(mesh) =
        mesh(vec![[0.0, 0.0, 0.0], [2.0, 0.0, 0.5], [2.0, 1.0, 0.0], [0.0, 1.5, 0.0]], vec![[0, 1, 2], [0, 2, 3]])
    else {
        unreachable!()
    };
    Shape::Mesh(Mesh { uvs: Some([[0.1, 0.2], [0.9, 0.5], [0.7, 1.4], [-0.2, 1.1]].into()), ..mesh })
}

/// The hit of a ray towards `target`, its point and chart.
fn chart_at(scene: &Scene, from: DVec3, target: DVec3) -> (Vec3, Chart, u32) {
    let origin = (from - scene.center()).as_vec3();
    let direction = ((target - from).normalize()).as_vec3();
    let ray = Ray {
        origin: origin.into(),
        t_min: 0.0,
        direction: direction.into(),
        t_max: f32::INFINITY,
        time: 0.0,
        mask: u32::MAX,
        skip: PrimitiveId::NONE,
    };
    let mut hits = [Hit::MISS];
    scene.accelerator().closest_hits(&[ray], &mut hits);
    assert!(hits[0].is_hit());
    let point = scene.surface_point(&ray, &hits[0]);
    (point.position, scene.chart(&point, &hits[0]), hits[0].id.primitive)
}

/// Tangents predict how the point moves with the texture coordinates, for meshes, spheres, ellipsoids and instances.
#[test]
fn tangents_are_derivatives() {
    let stretched = DAffine3::from_scale_rotation_translation(
        dvec3(1.0, 2.0, -0.7),
        etendue::math::DQuat::from_rotation_x(0.4),
        dvec3(0.3, 0.1, 5.0),
    );
    for (what, shape, transform, copies) in [
        ("mesh", bent(), DAffine3::IDENTITY, 1),
        ("moved mesh", bent(), stretched, 1),
        ("instance", bent(), stretched, 2),
        ("sphere", unit_sphere(), DAffine3::IDENTITY, 1),
        ("ellipsoid", unit_sphere(), stretched, 1),
    ] {
        let mut parts = Parts::default();
        let white = parts.diffuse([0.5; 3]);
        let shape = parts.shape(shape);
        for copy in 0..copies {
            parts.place(shape, DAffine3::from_translation(dvec3(50.0 * copy as f64, 0.0, 0.0)) * transform, white);
        }
        let scene = parts.build();
        let mut checked = 0;
        for i in 0..12 {
            // Points of the shape that a ray from outside meets.
            let local = if what.contains("sphere") || what == "ellipsoid" {
                let a = 0.5 + 0.4 * f64::from(i);
                dvec3(0.8 * a.cos(), 0.6 * (1.3 * a).sin(), 0.3).normalize()
            } else {
                dvec3(0.2 + 0.14 * f64::from(i), 0.3 + 0.05 * f64::from(i), 0.1)
            };
            let (near, beside) = (transform.transform_point3(local), local + dvec3(1e-3, 2e-3, 0.0));
            let eye = transform.transform_point3(local * 1.5 + dvec3(0.0, 0.0, 4.0));
            let (p, chart, face) = chart_at(&scene, eye, near);
            let (q, other, other_face) = chart_at(&scene, eye, transform.transform_point3(beside));
            if face != other_face || (other.uv - chart.uv).length() > 0.1 {
                continue;
            }
            let d = other.uv - chart.uv;
            let predicted = chart.dpdu * d.x + chart.dpdv * d.y;
            let error = (predicted - (q - p)).length() / (q - p).length();
            assert!(error < 0.02, "{what}, {i}: {predicted} for {}, {error}", q - p);
            checked += 1;
        }
        assert!(checked >= 6, "{what}: {checked}");
    }
}

/// A ramp of heights tilts the normal by its slope, whatever the parametrisation.
#[test]
fn a_ramp_tilts_the_normal() {
    let ramp: Vec<f32> = (0..64).map(|x| x as f32 / 64.0).collect();
    let texture = mapped(&grey(64, 1, &ramp), |m| m.wrap = [Wrap::Clamp; 2]);
    let normal = vec3(0.0, 0.0, 1.0);
    // Heights grow by `factor` over one unit of u, which is as long as `dpdu`.
    for (dpdu, dpdv) in [
        (vec3(2.0, 0.0, 0.0), vec3(0.0, 3.0, 0.0)),
        (vec3(-2.0, 0.0, 0.0), vec3(0.0, 3.0, 0.0)),
        (vec3(2.0, 0.0, 0.0), vec3(2.0, 3.0, 0.0)),
        (vec3(1.0, 1.0, 0.7), vec3(-0.3, 2.0, -5.0)),
    ] {
        let chart = Chart { uv: vec2(0.4, 0.3), dpdu, dpdv };
        let factor = 0.8;
        let height = Number { factor, texture: Some(Arc::new(texture.clone())) };
        let found = Relief::Bump { height: height.clone() }.normal(normal, &chart.uv.into(), &chart);
        // The gradient g lies in the plane and has g . dpdu = factor, g . dpdv = 0.
        let (u, v) = (vec2(dpdu.x, dpdu.y), vec2(dpdv.x, dpdv.y));
        let gradient = vec2(v.y, -v.x) * factor / (u.x * v.y - u.y * v.x);
        let expected = vec3(-gradient.x, -gradient.y, 1.0).normalize();
        assert!((found - expected).length() < 1e-3, "{dpdu} {dpdv}: {found}, not {expected}");
        // Scaled texture coordinates: the same ramp within half the length.
        let scaled = mapped(&texture, |m| m.transform = UvTransform::new([2.0, 1.0], 0.0, [0.0, 0.0]));
        let height = Number { factor, texture: Some(Arc::new(scaled)) };
        let found = Relief::Bump { height }.normal(normal, &vec2(0.2, 0.3).into(), &chart);
        let expected = vec3(-2.0 * gradient.x, -2.0 * gradient.y, 1.0).normalize();
        assert!((found - expected).length() < 1e-3, "scaled: {found}, not {expected}");
    }
    let flat = Chart { uv: vec2(0.4, 0.3), dpdu: Vec3::ZERO, dpdv: Vec3::ZERO };
    let height = Number { factor: 1.0, texture: Some(Arc::new(texture)) };
    assert_eq!(
        Relief::Bump { height }.normal(normal, &flat.uv.into(), &flat),
        normal,
        "without directions there is no slope"
    );
}

/// The same slope from a gradient, in texture coordinates and in space, and with a footprint.
#[test]
fn computed_heights_tilt_the_normal() {
    let normal = vec3(0.0, 0.0, 1.0);
    let chart = Chart { uv: vec2(0.4, 0.3), dpdu: vec3(2.0, 0.5, 0.0), dpdv: vec3(0.0, 3.0, 0.0) };
    let stops = [(0.0, 0.0), (1.0, 1.0)].map(|(at, grey)| Stop { at, color: Spectrum::splat(grey) });
    let of = |coordinates, to| {
        let gradient = Gradient { coordinates, from: Vec3::ZERO, to, radial: false, stops: stops.into() };
        Number { factor: 0.5, texture: Some(Arc::new(Texture::of(Pattern::Gradient(gradient)))) }
    };
    // Up by 0.5 over 4 m along x, whose own space is turned by a quarter about z.
    let space = of(Coordinates::Object { scale: Vec3::ONE, offset: Vec3::ZERO }, vec3(0.0, 4.0, 0.0));
    let turned = |v: Vec3| vec3(-v.y, v.x, v.z);
    let mut at = Lookup::new(chart.uv, vec3(0.3, 1.0, 0.0));
    at.tangents = [turned(chart.dpdu), turned(chart.dpdv)];
    let expected = vec3(-0.125, 0.0, 1.0).normalize();
    for width in [0.0, 0.1] {
        at.footprint =
            Footprint { uv: [vec2(width, 0.0), vec2(0.0, width)], position: [Vec3::X * width, Vec3::Y * width] };
        let found = Relief::Bump { height: space.clone() }.normal(normal, &at, &chart);
        assert!((found - expected).length() < 1e-3, "{width}: {found}, not {expected}");
    }
    // 0.5 over one unit of u.
    let along_u = Relief::Bump { height: of(Coordinates::Uv, Vec3::X) }.normal(normal, &at, &chart);
    let expected = vec3(-0.25, 0.0, 1.0).normalize();
    assert!((along_u - expected).length() < 1e-3, "{along_u}, not {expected}");
    let colors = Number { factor: 1.0, texture: Some(Arc::new(Texture::of(Pattern::VertexColor))) };
    assert_eq!(Relief::Bump { height: colors }.normal(normal, &at, &chart), normal, "without slope");
}

/// Colours of vertices are interpolated, also of instances and mirrored meshes; other shapes are white.
#[test]
fn colours_of_vertices() {
    let Shape::Mesh(bare) = bent() else { panic!() };
    let colors: Vec<[f32; 4]> = bare.positions.iter().map(|p| [0.1 + 0.4 * p[0], 0.5 * p[1], 0.25, 1.0]).collect();
    let shape = Shape::Mesh(Mesh { colors: Some(colors.into()), ..bare });
    for (copies, mirror) in [(1, 1.0), (1, -1.0), (2, -1.0)] {
        let mut parts = Parts::default();
        let white = parts.diffuse([0.5; 3]);
        let shape = parts.shape(shape.clone());
        let transform = DAffine3::from_scale(dvec3(mirror, 1.0, 1.0));
        for copy in 0..copies {
            parts.place(shape, DAffine3::from_translation(dvec3(0.0, 0.0, -5.0 * copy as f64)) * transform, white);
        }
        parts.sphere(dvec3(20.0, 0.0, 0.0), 1.0, white);
        let scene = parts.build();
        let look = |x: f64, y: f64| {
            let from = (dvec3(x, y, 4.0) - scene.center()).as_vec3();
            let ray = Ray { origin: from.into(), direction: [0.0, 0.0, -1.0], ..RAY };
            let mut hits = [Hit::MISS];
            scene.accelerator().closest_hits(&[ray], &mut hits);
            scene.lookup(&scene.surface_point(&ray, &hits[0]), &hits[0])
        };
        for (x, y) in [(0.4, 0.3), (1.5, 0.9), (0.2, 1.1)] {
            let at = look(x * mirror, y);
            let expected = [0.1 + 0.4 * x as f32, 0.5 * y as f32, 0.25, 1.0];
            assert!((0..4).all(|c| (at.color[c] - expected[c]).abs() < 1e-4), "{:?}, not {expected:?}", at.color);
            // In the object's own space, wherever it is.
            assert!((at.position - vec3(x as f32, y as f32, at.position.z)).length() < 1e-4, "{}", at.position);
        }
        assert_eq!(look(20.0, 0.1).color, [1.0; 4]);
    }
}

const RAY: Ray = Ray {
    origin: [0.0; 3],
    t_min: 0.0,
    direction: [0.0, 0.0, -1.0],
    t_max: f32::INFINITY,
    time: 0.0,
    mask: u32::MAX,
    skip: PrimitiveId::NONE,
};

#[test]
fn normal_maps_follow_the_texture_coordinates() {
    let normal = vec3(0.0, 0.0, 1.0);
    let map = |x: f32, y: f32, z: f32| {
        let stored = [x, y, z].map(|v| 0.5 * v + 0.5);
        Arc::new(Texture::new(image(1, 1, 3, &stored)))
    };
    let chart = |dpdu, dpdv| Chart { uv: Vec2::ZERO, dpdu, dpdv };
    let (right, up) = (vec3(3.0, 0.0, 0.0), vec3(0.0, 0.5, 0.0));
    for (relief, chart, expected) in [
        ((map(0.0, 0.0, 1.0), [1.0; 2]), chart(right, up), normal),
        ((map(0.6, 0.0, 0.8), [1.0; 2]), chart(right, up), vec3(0.6, 0.0, 0.8)),
        ((map(0.0, 0.6, 0.8), [1.0; 2]), chart(right, up), vec3(0.0, 0.6, 0.8)),
        ((map(0.6, 0.0, 0.8), [1.0; 2]), chart(-right, up), vec3(-0.6, 0.0, 0.8)),
        ((map(0.0, 0.6, 0.8), [1.0; 2]), chart(-right, up), vec3(0.0, 0.6, 0.8)),
        ((map(0.6, 0.0, 0.8), [2.0; 2]), chart(right, up), vec3(1.2, 0.0, 0.8).normalize()),
        ((map(0.0, 0.6, 0.8), [1.0, -1.0]), chart(right, up), vec3(0.0, -0.6, 0.8)),
        ((map(0.6, 0.0, -0.8), [1.0; 2]), chart(right, up), normal),
        ((map(0.6, 0.0, 0.8), [1.0; 2]), chart(Vec3::ZERO, up), normal),
    ] {
        let (map, scale) = relief;
        let found = Relief::Normals { map, scale }.normal(normal, &Lookup::from(chart.uv), &chart);
        assert!((found - expected).length() < 1e-5, "{found}, not {expected}");
    }
}

fn board(dark: f32, light: f32) -> Arc<Texture> {
    let values: Vec<f32> = (0..64).map(|i| if (i % 8 + i / 8) % 2 == 0 { light } else { dark }).collect();
    Arc::new(mapped(&grey(8, 8, &values), |m| m.filtering = Filtering::Nearest))
}

/// A floor under a sky of radiance 1 has the radiance of its albedo, so that its mean is the texture's.
#[test]
fn a_textured_floor_has_the_texture_s_radiance() {
    for integrator in SOLVERS {
        let mut parts = Parts::default();
        let floor = parts.diffuse([1.0; 3]);
        let reflectance = Color { factor: Spectrum::splat(0.5), texture: Some(board(0.2, 1.0)) };
        parts.0.materials[floor].scattering =
            Scattering::Diffuse { reflectance, transmittance: Spectrum::BLACK.into() };
        parts.rectangle(dvec3(-8.0, 0.0, 8.0), dvec3(16.0, 0.0, 0.0), dvec3(0.0, 0.0, -16.0), floor);
        parts.0.environment = Some(Spectrum::ONE.into());
        let view = camera(dvec3(0.0, 10.0, 0.0), dvec3(0.0, 0.0, 0.0));
        // 40 degrees from 10 m: the camera sees 7.28 m squared, some 3.6 squares.
        let picture = picture(&parts.build(), &view, [64, 64], &statistics(integrator, 64));
        let (mut dark, mut light) = (0, 0);
        for value in interleaved(&picture) {
            match value {
                v if (v - 0.1).abs() < 0.01 => dark += 1,
                v if (v - 0.5).abs() < 0.05 => light += 1,
                _ => {}
            }
        }
        assert!(dark > 3000 && light > 3000, "{integrator}: {dark} dark and {light} light values");
    }
}

/// A sheet, half of a checker board of it opaque by half, 8 m square.
fn sheet(parts: &mut Parts, y: f64) {
    let black = parts.material(Scattering::Black);
    parts.0.materials[black].opacity = Number { factor: 0.5, texture: Some(board(0.0, 1.0)) };
    parts.rectangle(dvec3(-4.0, y, 4.0), dvec3(8.0, 0.0, 0.0), dvec3(0.0, 0.0, -8.0), black);
    parts.0.environment = Some(Spectrum::ONE.into());
}

/// Before a sky of radiance 1, a black sheet shows what it lets through.
#[test]
fn opacity_follows_its_texture() {
    let mut parts = Parts::default();
    sheet(&mut parts, 0.0);
    let scene = parts.build();
    let projection = Projection::Orthographic { height: 8.0 };
    let view = CameraSettings { projection, ..camera(dvec3(0.0, 4.0, 0.0), DVec3::ZERO) };
    for integrator in SOLVERS {
        let moments = means(&scene, &view, [16, 16], &statistics(integrator, 64), 16);
        assert_mean(&format!("{integrator}"), &moments, 0.75, 0.002);
    }
}

/// Light that passes a cut-out sheet on its way to a floor: shadow rays count as much of it as paths do.
#[test]
fn cut_out_shadows_agree() {
    let mut parts = Parts::default();
    sheet(&mut parts, 1.0);
    let floor = parts.diffuse([0.8; 3]);
    parts.rectangle(dvec3(-4.0, 0.0, 4.0), dvec3(8.0, 0.0, 0.0), dvec3(0.0, 0.0, -8.0), floor);
    let scene = parts.build();
    let view = camera(dvec3(0.0, 0.9, 0.0), DVec3::ZERO);
    let [path, split, brute] = SOLVERS.map(|integrator| means(&scene, &view, [8, 8], &statistics(integrator, 256), 32));
    for (what, other) in [("light-split", &split), ("brute", &brute)] {
        let error = path.standard_error().hypot(other.standard_error());
        let sigma = (path.mean() - other.mean()) / error;
        assert!(error < 0.002 * path.mean(), "{what}: {error}");
        assert!(sigma.abs() < 3.5, "{what}: {} and {}, {sigma:.1} sigma", path.mean(), other.mean());
    }
    assert!(path.mean() < 0.7, "the sheet stops nothing: {}", path.mean());
}

/// Products beyond a parameter's range are brought into it: no texture makes light.
#[test]
fn textures_make_no_energy() {
    let bright = Arc::new(grey(1, 1, &[5.0]));
    let color = |factor: f32| Color { factor: Spectrum::splat(factor), texture: Some(bright.clone()) };
    let both: Scattering<Color, Number> = Scattering::Diffuse { reflectance: color(1.0), transmittance: color(0.1) };
    let Scattering::Diffuse { reflectance, transmittance } = both.at(&Vec2::ZERO.into()) else { panic!() };
    assert!((reflectance[0] + transmittance[0] - 1.0).abs() < 1e-6);
    let glass: Scattering<Color, Number> = Scattering::RoughGlass {
        ior: Number { factor: -1.0, texture: Some(bright.clone()) },
        alpha: Number { factor: 1.0, texture: Some(bright.clone()) },
        reflection_tint: color(-3.0),
        transmission_tint: color(1.0),
    };
    let Scattering::RoughGlass { ior, alpha, reflection_tint, transmission_tint } = glass.at(&Vec2::ZERO.into()) else {
        panic!()
    };
    assert_eq!((ior, alpha), (1e-3, 1.0));
    assert_eq!((reflection_tint, transmission_tint), (Spectrum::BLACK, Spectrum::ONE));
}

/// Stretched highlights follow the texture coordinates: a sheet whose u and v are exchanged, with the two widths exchanged,
/// is the same sheet.
#[test]
fn highlights_follow_u_and_v() {
    let sheet = |turned: bool, alpha: [f32; 2]| {
        let mut parts = Parts::default();
        let metal = parts.material(Scattering::RoughMetal {
            eta: Spectrum::splat(0.2),
            k: Spectrum::splat(3.0),
            alpha,
            tint: Spectrum::ONE,
        });
        let (corner, u, v) = if turned {
            (dvec3(4.0, 0.0, -4.0), dvec3(0.0, 0.0, 8.0), dvec3(-8.0, 0.0, 0.0))
        } else {
            (dvec3(-4.0, 0.0, -4.0), dvec3(8.0, 0.0, 0.0), dvec3(0.0, 0.0, 8.0))
        };
        parts.rectangle(corner, u, v, metal);
        let light = parts.emitter([20.0; 3], true);
        parts.sphere(dvec3(0.0, 2.0, -2.0), 0.3, light);
        // To the side of where a mirror would show the light.
        let view = camera(dvec3(0.0, 2.0, 2.0), dvec3(1.0, 0.0, 0.0));
        means(&parts.build(), &view, [8, 8], &statistics(Integrator::Path, 64), 32)
    };
    let (wide, turned, narrow) = (sheet(false, [0.5, 0.05]), sheet(true, [0.05, 0.5]), sheet(false, [0.05, 0.5]));
    let sigma = (wide.mean() - turned.mean()) / wide.standard_error().hypot(turned.standard_error());
    assert!(sigma.abs() < 3.5, "{} and {}: {sigma:.1} sigma", wide.mean(), turned.mean());
    assert!(wide.mean() > 1.5 * narrow.mean(), "{} along u, {} along v", wide.mean(), narrow.mean());
}
