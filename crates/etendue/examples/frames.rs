//! What motion costs: bringing a scene of many bodies to its next frame, and rays among bodies that move against rays among
//! bodies that rest there.
//!
//! `cargo run --release -p etendue --example frames -- [BODIES] [KEYS] [PICTURE.ppm]`: medians over frames that alternate.
//! The picture is one of the frames with an open shutter.

use etendue::{
    camera::{Aperture, CameraSettings, FovAxis, Projection},
    film::{Film, FilmSettings},
    image::Image,
    material::{Emission, Material, Scattering},
    math::{DAffine3, DQuat, DVec3, dvec3},
    motion::{Motion, Pose},
    render::{RenderControl, RenderSettings, render},
    scene::{AcceleratorSettings, FrameChanges, Mesh, Object, Scene, SceneParts, Shape},
    spectrum::Spectrum,
    texture::{Samples, Texture, TextureImage, Transfer},
};
use etendue_accel::{AcceleratorKind, Isa};
use std::{sync::Arc, time::Instant};

const SIZE: [u32; 2] = [320, 180];
const FRAMES: usize = 9;

fn main() {
    let mut arguments = std::env::args().skip(1);
    let bodies = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(200);
    let keys = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(21);
    let mut scene = scene(bodies);
    let (mut updates, mut moving, mut resting) = (Vec::new(), Vec::new(), Vec::new());
    for frame in 0..FRAMES {
        for (keys, rendered) in [(keys, &mut moving), (1, &mut resting)] {
            let motions: Vec<_> = (0..bodies).map(|i| (i + 1, motion(i, frame, keys))).collect();
            let start = Instant::now();
            scene = scene.with_frame(FrameChanges { motions, ..FrameChanges::default() }, 2).expect("a frame");
            let update = start.elapsed();
            let start = Instant::now();
            picture(&scene, 4);
            rendered.push(start.elapsed().as_secs_f64());
            if keys > 1 {
                updates.push(update.as_secs_f64());
            }
        }
    }
    let [update, moving, resting] = [updates, moving, resting].map(median);
    println!("{bodies} bodies, {keys} keys each: {:.2} ms for the next frame", update * 1e3);
    println!("4 samples a pixel: {:.0} ms moving, {:.0} ms at rest", moving * 1e3, resting * 1e3);
    if let Some(path) = arguments.next() {
        let motions: Vec<_> = (0..bodies).map(|i| (i + 1, motion(i, 3, keys))).collect();
        scene = scene.with_frame(FrameChanges { motions, ..FrameChanges::default() }, 2).expect("a frame");
        std::fs::write(path, portable_pixmap(&picture(&scene, 64))).expect("a file that can be written");
    }
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// Boxes with a texture that spin, and balls that fall, over a floor.
fn scene(bodies: usize) -> Scene {
    let mut parts = SceneParts::default();
    let white = Scattering::Diffuse { reflectance: Spectrum::splat(0.7), transmittance: Spectrum::BLACK };
    let material = |name: &str, scattering| Material::new(name.to_owned(), scattering);
    let checks: Vec<f32> = (0..64).map(|i| if (i + i / 8) % 2 == 0 { 0.9 } else { 0.1 }).collect();
    let image = TextureImage::new(8, 8, 1, Samples::F32(checks.into()), Transfer::Linear).expect("an image");
    let mut checked = material("checked", white);
    if let Scattering::Diffuse { reflectance, .. } = &mut checked.scattering {
        reflectance.texture = Some(Arc::new(Texture::new(Arc::new(image))));
    }
    let radiance = Spectrum::splat(12.0).into();
    let lamp =
        Material { emission: Some(Emission { radiance, two_sided: false }), ..material("lamp", Scattering::Black) };
    parts.materials = vec![material("white", white), checked, material("ball", white), lamp];
    parts.shapes = vec![
        Shape::Rectangle { corner: dvec3(-9.0, 0.0, -9.0), u: DVec3::Z * 18.0, v: DVec3::X * 18.0 },
        block(),
        Shape::Sphere { center: DVec3::ZERO, radius: 0.3 },
        Shape::Rectangle { corner: dvec3(-2.0, 7.0, -2.0), u: DVec3::X * 4.0, v: DVec3::Z * 4.0 },
    ];
    let object = |name: &str, shape, transform, motion| Object {
        name: name.to_owned(),
        shape,
        transform,
        materials: vec![[0, 1, 2, 3][shape]],
        motion,
    };
    parts.objects.push(object("floor", 0, DAffine3::IDENTITY, None));
    for i in 0..bodies {
        let at = DAffine3::from_translation(place(i));
        parts.objects.push(object("body", 1 + i % 2, at, Some(motion(i, 0, 1))));
    }
    parts.objects.push(object("lamp", 3, DAffine3::IDENTITY, None));
    parts.environment = Some(Spectrum::splat(0.3).into());
    let settings = AcceleratorSettings { kind: AcceleratorKind::Bvh, isa: Isa::detect(), threads: 2 };
    Scene::build(parts, &settings).expect("a scene")
}

fn place(i: usize) -> DVec3 {
    let part = |factor: f64| (i as f64 * factor).fract();
    dvec3(6.0 * part(0.618_034) - 3.0, 0.6 + 3.0 * part(0.754_878), 6.0 * part(0.569_840) - 3.0)
}

/// Spins of a box about its middle, or falls of a ball, in a frame; with one key, where the frame begins.
fn motion(i: usize, frame: usize, keys: usize) -> Motion {
    let at = |share: f64| {
        let time = 0.3 * (frame as f64 + share);
        let rotation = match i % 2 {
            0 => DQuat::from_axis_angle(dvec3(0.3, 1.0, 0.2).normalize(), 2.5 * time + i as f64),
            _ => DQuat::IDENTITY,
        };
        let fall = if i.is_multiple_of(2) { 0.0 } else { -0.8 * time * time };
        Pose { rotation, translation: place(i) - rotation * place(i) + DVec3::Y * fall }
    };
    let key = |k: usize| {
        let share = k as f64 / (keys - 1) as f64;
        (share, at(share))
    };
    if keys > 1 { Motion { keys: (0..keys).map(key).collect() } } else { Motion::resting(at(0.0)) }
}

/// A cube with sides of 0.6 and texture coordinates on each.
fn block() -> Shape {
    let (mut positions, mut uvs, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for axis in 0..3 {
        for side in [-0.3_f32, 0.3] {
            let first = positions.len() as u32;
            for [u, v] in [[0.0_f32, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]] {
                let mut position = [0.0; 3];
                position[axis] = side;
                position[(axis + 1) % 3] = 0.6 * u - 0.3;
                position[(axis + 2) % 3] = 0.6 * v - 0.3;
                positions.push(position);
                uvs.push([u, v]);
            }
            indices.extend([[first, first + 1, first + 2], [first, first + 2, first + 3]]);
        }
    }
    Shape::Mesh(Mesh {
        origin: DVec3::ZERO,
        positions: positions.into(),
        indices: indices.into(),
        normals: None,
        uvs: Some(uvs.into()),
        colors: None,
        face_materials: None,
    })
}

fn picture(scene: &Scene, spp: u32) -> Image {
    let projection = Projection::Perspective {
        fov: 0.8,
        axis: FovAxis::X,
        lens_radius: 0.0,
        aperture: Aperture::Round,
        focus_distance: 1.0,
    };
    let position = dvec3(0.0, 3.0, 9.0);
    let direction = dvec3(0.0, 1.4, 0.0) - position;
    let camera = CameraSettings { position, direction, up: DVec3::Y, projection, near_clip: 0.0 };
    let film = FilmSettings { resolution: SIZE, crop: None, aovs: vec![], transparent: false };
    let film = Film::new(&film).expect("a film");
    let settings = RenderSettings { spp, threads: 2, ..RenderSettings::default() };
    render(scene, &camera, &settings, &film, &RenderControl::default()).expect("valid settings");
    film.develop()
}

fn portable_pixmap(image: &Image) -> Vec<u8> {
    let mut bytes = format!("P6\n{} {}\n255\n", SIZE[0], SIZE[1]).into_bytes();
    let channels = ["R", "G", "B"].map(|name| image.f32_channel(name).expect("colour"));
    for i in 0..channels[0].len() {
        bytes.extend(channels.map(|channel| (255.0 * channel[i].clamp(0.0, 1.0).sqrt()) as u8));
    }
    bytes
}
