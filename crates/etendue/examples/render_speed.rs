//! How long a ray takes, shading included, in scenes that are made here: `cargo run --release --example render_speed`.
//!
//! Prints for each scene the nanoseconds of processor time a ray, on one thread, and a hash of the picture. Arguments: which
//! scenes, `portable`, `avx2` or `avx512` for the instruction set, a number for the samples a pixel, `wave=N`.

use etendue::{
    camera::{Aperture, CameraSettings, FovAxis, Projection},
    film::{Film, FilmSettings},
    image::ChannelData,
    material::{Emission, Material, Scattering},
    math::{DAffine3, DVec3, dvec3, vec3},
    render::{RenderControl, RenderSettings, render},
    sampling::Filter,
    scene::{AcceleratorSettings, Environment, Mesh, Object, Scene, SceneParts, Shape},
    spectrum::Spectrum,
};
use etendue_accel::{AcceleratorKind, Isa};
use std::{error::Error, time::Instant};

const SCENES: [&str; 6] = ["room", "panel", "sky", "gloss", "lamps", "large"];

#[derive(Default)]
struct Parts(SceneParts);

impl Parts {
    fn material(&mut self, scattering: Scattering) -> usize {
        self.0.materials.push(Material::new("", scattering));
        self.0.materials.len() - 1
    }

    fn diffuse(&mut self, rgb: [f32; 3]) -> usize {
        self.material(Scattering::Diffuse { reflectance: Spectrum(rgb), transmittance: Spectrum::BLACK })
    }

    fn emitter(&mut self, rgb: [f32; 3]) -> usize {
        let material = self.material(Scattering::Black);
        self.0.materials[material].emission = Some(Emission { radiance: Spectrum(rgb).into(), two_sided: false });
        material
    }

    fn place(&mut self, shape: Shape, transform: DAffine3, material: usize) {
        self.0.shapes.push(shape);
        let (name, shape) = (format!("o{}", self.0.objects.len()), self.0.shapes.len() - 1);
        self.0.objects.push(Object { name, shape, transform, materials: vec![material], motion: None });
    }

    fn rectangle(&mut self, corner: [f64; 3], u: [f64; 3], v: [f64; 3], material: usize) {
        let [corner, u, v] = [corner, u, v].map(DVec3::from);
        self.place(Shape::Rectangle { corner, u, v }, DAffine3::IDENTITY, material);
    }

    /// Five walls without the front, 2 m wide, and a lamp below the ceiling.
    fn room(&mut self) {
        self.walls();
        let lamp = self.emitter([17.0, 12.0, 4.0]);
        self.rectangle([-0.25, 0.99, -0.25], [0.5, 0.0, 0.0], [0.0, 0.0, 0.5], lamp);
    }

    fn walls(&mut self) {
        let (white, red) = (self.diffuse([0.73; 3]), self.diffuse([0.6, 0.06, 0.05]));
        let green = self.diffuse([0.14, 0.45, 0.09]);
        self.rectangle([-1.0, -1.0, -1.0], [0.0, 0.0, 2.0], [2.0, 0.0, 0.0], white);
        self.rectangle([-1.0, 1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 0.0, 2.0], white);
        self.rectangle([-1.0, -1.0, -1.0], [2.0, 0.0, 0.0], [0.0, 2.0, 0.0], white);
        self.rectangle([-1.0, -1.0, -1.0], [0.0, 2.0, 0.0], [0.0, 0.0, 2.0], red);
        self.rectangle([1.0, -1.0, -1.0], [0.0, 0.0, 2.0], [0.0, 2.0, 0.0], green);
    }

    /// A lamp as that of [`Self::room`], cut into 10 triangles.
    fn panel(&mut self) {
        let lamp = self.emitter([17.0, 12.0, 4.0]);
        let corner = |i: u32| [-0.25 + 0.1 * (i / 2) as f32, 0.99, if i.is_multiple_of(2) { -0.25 } else { 0.25 }];
        let mesh = Mesh {
            positions: (0..12).map(corner).collect(),
            indices: (0..5).flat_map(|i| [[2 * i, 2 * i + 2, 2 * i + 1], [2 * i + 1, 2 * i + 2, 2 * i + 3]]).collect(),
            origin: DVec3::ZERO,
            normals: None,
            uvs: None,
            colors: None,
            face_materials: None,
        };
        self.place(Shape::Mesh(mesh), DAffine3::IDENTITY, lamp);
    }

    fn cube(&mut self, at: [f64; 3], half: [f64; 3], turn: f64, material: usize) {
        let positions = (0..8).map(|i: u32| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { 1.0 } else { -1.0 }));
        let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let faces = quads.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]);
        let mesh = Mesh {
            positions: positions.collect(),
            indices: faces.collect(),
            origin: DVec3::ZERO,
            normals: None,
            uvs: None,
            colors: None,
            face_materials: None,
        };
        let transform = DAffine3::from_translation(DVec3::from(at))
            * DAffine3::from_rotation_y(turn)
            * DAffine3::from_scale(DVec3::from(half));
        self.place(Shape::Mesh(mesh), transform, material);
    }

    /// A bumpy ball of 2 n^2 triangles with smooth normals.
    fn ball(&mut self, at: [f64; 3], radius: f64, n: u32, material: usize) {
        let point = |i: u32, j: u32| {
            let (s, c) = etendue::math::sin_cos_turns(i as f32 / n as f32);
            let (t, d) = etendue::math::sin_cos_turns(0.5 * j as f32 / n as f32);
            let (ripple, _) = etendue::math::sin_cos_turns(5.0 * (i + j) as f32 / n as f32);
            let p = vec3(c * t, d, s * t) * (1.0 + 0.05 * ripple);
            (p.to_array(), p.normalize().to_array())
        };
        let (positions, normals) = (0..=n).flat_map(|j| (0..=n).map(move |i| (i, j))).map(|(i, j)| point(i, j)).unzip();
        let cells = (0..n).flat_map(|j| (0..n).map(move |i| j * (n + 1) + i));
        let indices = cells.flat_map(|k| [[k, k + 1, k + n + 2], [k, k + n + 2, k + n + 1]]).collect();
        let normals: Vec<[f32; 3]> = normals;
        let positions: Vec<[f32; 3]> = positions;
        let mesh = Mesh {
            origin: DVec3::ZERO,
            positions: positions.into(),
            indices,
            normals: Some(normals.into()),
            uvs: None,
            colors: None,
            face_materials: None,
        };
        let transform = DAffine3::from_translation(DVec3::from(at)) * DAffine3::from_scale(DVec3::splat(radius));
        self.place(Shape::Mesh(mesh), transform, material);
    }

    fn scene(name: &str) -> SceneParts {
        let mut parts = Self::default();
        let clay = parts.diffuse([0.7, 0.6, 0.5]);
        match name {
            "room" | "panel" => {
                if name == "room" {
                    parts.room();
                } else {
                    parts.walls();
                    parts.panel();
                }
                parts.cube([-0.35, -0.4, -0.3], [0.3, 0.6, 0.3], 0.3, clay);
                parts.cube([0.35, -0.7, 0.3], [0.3, 0.3, 0.3], -0.3, clay);
            }
            "sky" | "large" => {
                parts.0.environment = Some(Environment::Constant(Spectrum([0.8, 0.9, 1.0])));
                parts.rectangle([-9.0, -1.0, -9.0], [0.0, 0.0, 18.0], [18.0, 0.0, 0.0], clay);
                parts.ball([0.0, 0.0, 0.0], 1.0, if name == "sky" { 300 } else { 700 }, clay);
            }
            "gloss" => {
                parts.room();
                let tint = Spectrum::ONE;
                let gold = parts.material(Scattering::RoughMetal {
                    eta: Spectrum([0.2, 0.4, 1.4]),
                    k: Spectrum([3.9, 2.4, 1.6]),
                    alpha: [0.2; 2],
                    tint,
                });
                let glass = parts.material(Scattering::Glass {
                    ior: 1.5,
                    reflection_tint: tint,
                    transmission_tint: tint,
                    thin: false,
                });
                parts.ball([-0.4, -0.5, -0.2], 0.45, 100, gold);
                parts.ball([0.4, -0.5, 0.2], 0.45, 100, glass);
            }
            _ => {
                parts.room();
                parts.ball([0.0, -0.4, 0.0], 0.5, 100, clay);
                let lamp = parts.emitter([2.0, 3.0, 4.0]);
                for i in 0..200 {
                    let at = f64::from(i) / 100.0 - 1.0;
                    let center = dvec3(at, f64::from(i % 7) * 0.2 - 0.6, f64::from(i % 13) * 0.1 - 0.9);
                    parts.place(Shape::Sphere { center, radius: 0.01 }, DAffine3::IDENTITY, lamp);
                }
            }
        }
        parts.0
    }
}

/// Seconds that this process has had a processor; where that is not told, seconds since `start`.
fn processor_seconds(start: Instant) -> f64 {
    let told = std::fs::read_to_string("/proc/self/schedstat").ok();
    let nanoseconds = told.and_then(|line| line.split(' ').next()?.parse::<f64>().ok());
    nanoseconds.map_or_else(|| start.elapsed().as_secs_f64(), |ns| ns * 1e-9)
}

/// FNV-1a over all numbers.
fn hash(film: &Film) -> u64 {
    let mut hash = 0xcbf2_9ce4_8422_2325_u64;
    for channel in film.develop().channels {
        if let ChannelData::F32(values) = channel.data {
            for value in values {
                hash = (hash ^ u64::from(value.to_bits())).wrapping_mul(0x100_0000_01b3);
            }
        }
    }
    hash
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let isa = arguments.iter().find_map(|a| a.parse::<Isa>().ok()).unwrap_or(Isa::detect());
    let spp = arguments.iter().find_map(|a| a.parse().ok()).unwrap_or(4);
    let wave = arguments.iter().find_map(|a| a.strip_prefix("wave=")?.parse().ok());
    let wanted = |name: &&&str| {
        arguments.iter().any(|a| a == **name) || !SCENES.iter().any(|s| arguments.iter().any(|a| a == s))
    };
    for name in SCENES.iter().filter(wanted) {
        let settings = AcceleratorSettings { kind: AcceleratorKind::Bvh, isa, threads: 1 };
        let scene = Scene::build(Parts::scene(name), &settings)?;
        let resolution = [256, 256];
        let film = Film::new(&FilmSettings { resolution, crop: None, aovs: vec![], transparent: false })?;
        let camera = CameraSettings {
            position: dvec3(0.0, 0.0, 3.6),
            direction: dvec3(0.0, 0.0, -1.0),
            up: DVec3::Y,
            projection: Projection::Perspective {
                fov: 40f64.to_radians(),
                axis: FovAxis::X,
                lens_radius: 0.0,
                aperture: Aperture::Round,
                focus_distance: 1.0,
            },
            near_clip: 0.0,
        };
        let mut settings =
            RenderSettings { spp, max_depth: Some(8), filter: Filter::Box { radius: 0.5 }, ..Default::default() };
        settings.wave = wave.unwrap_or(settings.wave);
        let (control, start) = (RenderControl::default(), Instant::now());
        let before = processor_seconds(start);
        render(&scene, &camera, &settings, &film, &control)?;
        let seconds = processor_seconds(start) - before;
        println!(
            "{name:6} {:7.1} ns a ray, {:5.2} rays a path, picture {:016x}",
            seconds * 1e9 / control.rays() as f64,
            control.rays() as f64 / control.paths() as f64,
            hash(&film)
        );
    }
    Ok(())
}
