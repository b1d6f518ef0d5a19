//! Rays among triangles that are longer than what is between them, and among even ones: needles, rooms, buildings, leaves, scans; in the
//! BVH and in the kd-tree, one thread.
//!
//! `cargo run --release -p etendue-accel --example long_triangles [RAYS] [MESH.ply]`, the mesh with positions and triangles in
//! little-endian binary.
#![allow(clippy::disallowed_methods)]

use std::sync::OnceLock;
use std::time::Instant;

use etendue_accel::{
    Accelerator, AcceleratorKind, Geometry, Hit, Instance, Isa, KdTreeSplit, Place, PrimitiveId, Ray, TriangleMesh,
    World,
};

/// Rays are handed over in slices of this length, like a wave of paths.
const SLICE: usize = 256;

struct Random(u64);

impl Random {
    fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 24) as f32
    }

    fn point(&mut self) -> [f32; 3] {
        std::array::from_fn(|_| self.unit())
    }

    fn direction(&mut self) -> [f32; 3] {
        loop {
            let p = self.point().map(|x| 2.0 * x - 1.0);
            let length = dot(p, p).sqrt();
            if length > 0.1 && length < 1.0 {
                return p.map(|x| x / length);
            }
        }
    }
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn add(a: [f32; 3], b: [f32; 3], s: f32) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + s * b[i])
}

fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[derive(Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<[u32; 3]>,
}

impl Mesh {
    fn triangle(&mut self, corners: [[f32; 3]; 3]) {
        let i = self.positions.len() as u32;
        self.positions.extend(corners);
        self.indices.push([i, i + 1, i + 2]);
    }

    /// A box around a middle with three half axes.
    fn cuboid(&mut self, middle: [f32; 3], axes: [[f32; 3]; 3]) {
        let first = self.positions.len() as u32;
        for i in 0..8 {
            let sign = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
            let p = add(middle, axes[0], sign(0));
            self.positions.push(add(add(p, axes[1], sign(1)), axes[2], sign(2)));
        }
        for [a, b, c, d] in [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]] {
            self.indices.push([first + a, first + b, first + c]);
            self.indices.push([first + a, first + c, first + d]);
        }
    }

    /// A beam from one point to another, of square section.
    fn beam(&mut self, p: [f32; 3], q: [f32; 3], width: f32) {
        let along = add(q, p, -1.0);
        let length = dot(along, along).sqrt();
        let side = cross(along, if along[1].abs() < 0.9 * length { [0.0, 1.0, 0.0] } else { [1.0, 0.0, 0.0] });
        let side = side.map(|x| x / dot(side, side).sqrt() * width * 0.5);
        let up = cross(along, side).map(|x| x / length);
        self.cuboid(add(p, along, 0.5), [along.map(|x| 0.5 * x), side, up]);
    }

    fn ball(&mut self, middle: [f32; 3], radius: f32, rows: u32) {
        let first = self.positions.len() as u32;
        let columns = 2 * rows;
        for i in 0..=rows {
            for j in 0..columns {
                let (a, b) =
                    (std::f32::consts::PI * i as f32 / rows as f32, std::f32::consts::TAU * j as f32 / columns as f32);
                let r = radius * (1.0 + 0.05 * (9.0 * a).sin() * (14.0 * b).sin());
                self.positions.push(add(middle, [a.sin() * b.cos(), a.cos(), a.sin() * b.sin()], r));
            }
        }
        let at = |i: u32, j: u32| first + i * columns + j % columns;
        for i in 0..rows {
            for j in 0..columns {
                let (p, q, r, s) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
                self.indices.extend([[p, q, r], [p, r, s]]);
            }
        }
    }

    fn turned(mut self, axes: [[f32; 3]; 3]) -> Self {
        for p in &mut self.positions {
            *p = axes.map(|axis| dot(axis, *p));
        }
        self
    }
}

/// Long thin triangles any way round.
fn needles(count: usize, length: f32) -> Mesh {
    let (mut mesh, mut random) = (Mesh::default(), Random(1));
    for _ in 0..count {
        let (middle, along) = (random.point(), random.direction());
        let side = cross(along, random.direction());
        let (p, q) = (add(middle, along, -0.5 * length), add(middle, along, 0.5 * length));
        mesh.triangle([p, q, add(q, side, 0.01 * length)]);
    }
    mesh
}

/// Even triangles any way round.
fn leaves(count: usize, size: f32) -> Mesh {
    let (mut mesh, mut random) = (Mesh::default(), Random(1));
    for _ in 0..count {
        let p = random.point();
        mesh.triangle([p, add(p, random.direction(), size), add(p, random.direction(), size)]);
    }
    mesh
}

/// A room with many small things on shelves.
fn room() -> Mesh {
    let (mut mesh, mut random) = (Mesh::default(), Random(2));
    mesh.cuboid([5.0, 1.5, 4.0], [[5.0, 0.0, 0.0], [0.0, 1.5, 0.0], [0.0, 0.0, 4.0]]);
    for i in 0..8 {
        let z = i as f32;
        mesh.cuboid([5.0, 0.8, z + 0.3], [[4.0, 0.0, 0.0], [0.0, 0.02, 0.0], [0.0, 0.0, 0.2]]);
        for _ in 0..20 {
            let middle = [1.0 + 8.0 * random.unit(), 0.95, z + 0.2 + 0.2 * random.unit()];
            mesh.ball(middle, 0.05 + 0.08 * random.unit(), 16);
        }
    }
    mesh
}

/// A lattice of beams, turned.
fn lattice(count: usize) -> Mesh {
    let mut mesh = Mesh::default();
    let place = |i: usize| i as f32 / (count - 1) as f32;
    for i in 0..count {
        for j in 0..count {
            let (u, v) = (place(i), place(j));
            mesh.beam([0.0, u, v], [1.0, u, v], 0.004);
            mesh.beam([u, 0.0, v], [u, 1.0, v], 0.004);
            mesh.beam([u, v, 0.0], [u, v, 1.0], 0.004);
        }
    }
    mesh.turned(turn())
}

fn turn() -> [[f32; 3]; 3] {
    let x = [0.8, 0.48, 0.36];
    let y = [-0.6, 0.64, 0.48];
    [x, y, cross(x, y)]
}

/// A house of several floors: slabs, columns, railings with bars and hand rails, ramps, boxes any way round.
fn house() -> Mesh {
    let (mut mesh, mut random) = (Mesh::default(), Random(3));
    for floor in 0..6 {
        let y = 3.0 * floor as f32;
        mesh.cuboid([20.0, y, 15.0], [[20.0, 0.0, 0.0], [0.0, 0.15, 0.0], [0.0, 0.0, 15.0]]);
        for i in 0..9 {
            for j in 0..7 {
                let (x, z) = (5.0 * i as f32, 5.0 * j as f32);
                mesh.beam([x, y, z], [x, y + 3.0, z], 0.4);
                mesh.beam([x, y + 2.8, z], [x + 5.0, y + 1.0, z], 0.05);
                mesh.beam([x, y + 2.8, z], [x, y + 1.0, z + 5.0], 0.05);
            }
        }
        for side in 0..2 {
            let z = 30.0 * side as f32;
            for rail in 0..6 {
                let h = y + 0.2 + 0.15 * rail as f32;
                mesh.beam([0.0, h, z], [40.0, h, z], 0.03);
            }
            for bar in 0..400 {
                let x = 0.1 * bar as f32;
                mesh.beam([x, y, z], [x, y + 1.1, z], 0.02);
            }
        }
        for ramp in 0..4 {
            let (x, z) = (8.0 * ramp as f32 + 2.0, 14.0);
            for rail in 0..4 {
                let h = y + 0.3 * rail as f32;
                mesh.beam([x, h, z], [x + 8.0, h + 3.0, z], 0.03);
                mesh.beam([x, h, z + 1.5], [x + 8.0, h + 3.0, z + 1.5], 0.03);
            }
            for step in 0..20 {
                let s = step as f32 / 20.0;
                mesh.beam([x + 8.0 * s, y + 3.0 * s, z], [x + 8.0 * s, y + 3.0 * s, z + 1.5], 0.25);
                mesh.beam([x + 8.0 * s, y + 3.0 * s, z], [x + 8.0 * s, y + 3.0 * s + 1.1, z], 0.02);
            }
        }
        for _ in 0..150 {
            let middle = [40.0 * random.unit(), y + 0.5, 30.0 * random.unit()];
            let a = 6.3 * random.unit();
            let size = 0.2 + 0.4 * random.unit();
            mesh.cuboid(
                middle,
                [[a.cos() * size, 0.0, a.sin() * size], [0.0, 0.4, 0.0], [-0.3 * a.sin(), 0.0, 0.3 * a.cos()]],
            );
        }
    }
    let a = 0.6_f32;
    mesh.turned([[a.cos(), 0.0, a.sin()], [0.0, 1.0, 0.0], [-a.sin(), 0.0, a.cos()]])
}

/// A mesh of triangles in binary PLY, little-endian, with nothing but positions.
fn read_ply(path: &str) -> Mesh {
    let bytes = std::fs::read(path).expect("a file");
    let end = bytes.windows(11).position(|w| w == b"end_header\n").expect("a header") + 11;
    let header = String::from_utf8_lossy(&bytes[..end]).into_owned();
    let count = |what: &str| -> usize {
        header.lines().find_map(|line| line.strip_prefix(what)).expect("a count").trim().parse().expect("a number")
    };
    let (vertices, faces) = (count("element vertex"), count("element face"));
    let word = |at: usize| [bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]];
    let position = |i: usize| std::array::from_fn(|a| f32::from_le_bytes(word(end + 12 * i + 4 * a)));
    let start = end + 12 * vertices;
    let face = |i: usize| std::array::from_fn(|a| u32::from_le_bytes(word(start + 13 * i + 1 + 4 * a)));
    Mesh { positions: (0..vertices).map(position).collect(), indices: (0..faces).map(face).collect() }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let rays = arguments.next().map_or(200_000, |text| text.parse().expect("a number of rays"));
    let mut ball = Mesh::default();
    ball.ball([0.0; 3], 1.0, 42);
    let mut scenes = vec![
        ("needles, 15 % of the world long", needles(50_000, 0.15)),
        ("needles, 2.5 %", needles(50_000, 0.025)),
        ("needles, 0.5 %", needles(50_000, 0.005)),
        ("crowd", leaves(20_000, 0.2)),
        ("leaves", leaves(200_000, 0.02)),
        ("lattice", lattice(24)),
        ("house", house()),
        ("room", room()),
        ("ball", ball),
    ];
    scenes.extend(arguments.next().map(|path| ("mesh", read_ply(&path))));
    for (name, mesh) in scenes {
        measure(name, mesh, rays);
    }
}

/// The kinds that are measured, and on one slice of rays in how many.
const KINDS: [(AcceleratorKind, usize); 2] =
    [(AcceleratorKind::Bvh, 1), (AcceleratorKind::KdTree(KdTreeSplit::SurfaceArea), 4)];

/// Builds and sets of rays are timed this many times; the kinds take turns.
const TURNS: usize = 5;

/// Prints the least seconds of builds, memory, and medians of the time of a ray.
fn measure(name: &str, mesh: Mesh, count: usize) {
    let faces = mesh.indices.len();
    let mesh = TriangleMesh { positions: mesh.positions.into(), indices: mesh.indices.into() };
    let instances = vec![Instance { geometry: 0, place: Place::World, mask: u32::MAX }];
    let world = World { geometries: vec![Geometry::Triangles(mesh)], instances };
    println!("{name}, {faces} faces");
    println!("{:>10} {:>9} {:>7}   ns a ray: camera, bounce, shuffled, shadow", "", "build ms", "B/face");
    let build = |kind| Accelerator::build(&world, kind, Isa::detect(), 1).expect("a world");
    let mut least = [f64::INFINITY; KINDS.len()];
    for _ in 0..TURNS {
        for ((kind, _), least) in KINDS.iter().zip(&mut least) {
            let start = Instant::now();
            drop(build(*kind));
            *least = least.min(start.elapsed().as_secs_f64());
        }
    }
    let built = KINDS.map(|(kind, _)| build(kind));
    let sets = ray_sets(&built[0], count);
    let mut times = vec![vec![Vec::new(); sets.len()]; KINDS.len()];
    for _ in 0..TURNS {
        for (set, (rays, any)) in sets.iter().enumerate() {
            for (kind, accelerator) in built.iter().enumerate() {
                times[kind][set].push(time(accelerator, rays, KINDS[kind].1, *any));
            }
        }
    }
    for (kind, accelerator) in built.iter().enumerate() {
        let bytes = accelerator.stats().bytes as f64 / faces as f64;
        print!("{:>10} {:9.1} {bytes:7.1}  ", KINDS[kind].0, least[kind] * 1e3);
        for times in &mut times[kind] {
            times.sort_by(f64::total_cmp);
            print!(" {:7.0}", times[TURNS / 2] * 1e9);
        }
        println!();
    }
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY, time: 0.0, mask: u32::MAX, skip: PrimitiveId::NONE }
}

/// From a camera, bounces, bounces in no order, and to lamps that are anywhere (where any hit will do).
fn ray_sets(accelerator: &Accelerator, count: usize) -> Vec<(Vec<Ray>, bool)> {
    let bounds = accelerator.bounds().expect("something");
    let size: [f32; 3] = std::array::from_fn(|a| bounds.max[a] - bounds.min[a]);
    let at = |p: [f32; 3]| -> [f32; 3] { std::array::from_fn(|a| bounds.min[a] + p[a] * size[a]) };
    let (eye, target) = (at([0.31, 0.47, 0.12]), at([0.6, 0.45, 0.8]));
    let forward = add(target, eye, -1.0);
    let right = cross(forward, [0.0, 1.0, 0.0]);
    let up = cross(right, forward).map(|x| x / dot(forward, forward).sqrt());
    let side = (count as f64).sqrt() as usize;
    let place = |i: usize| (i as f32 + 0.5) / side as f32 * 1.6 - 0.8;
    let camera: Vec<Ray> =
        (0..side * side).map(|i| ray(eye, add(add(forward, right, place(i % side)), up, place(i / side)))).collect();
    let mut hits = vec![Hit::MISS; camera.len()];
    accelerator.closest_hits(&camera, &mut hits);
    let mut random = Random(7);
    let mut bounces: Vec<Ray> = Vec::new();
    for (ray, hit) in camera.iter().zip(&hits).filter(|(_, hit)| hit.is_hit()) {
        bounces.push(Ray {
            origin: add(ray.origin, ray.direction, hit.t),
            direction: random.direction(),
            skip: hit.id,
            ..*ray
        });
    }
    let toward = |ray: &Ray, lamp: [f32; 3]| Ray { direction: add(lamp, ray.origin, -1.0), t_max: 1.0, ..*ray };
    let shadows: Vec<Ray> = bounces.iter().map(|ray| toward(ray, at(random.point()))).collect();
    let mut shuffled = bounces.clone();
    for i in (1..shuffled.len()).rev() {
        shuffled.swap(i, (random.unit() * i as f32) as usize);
    }
    vec![(camera, false), (bounces, false), (shuffled, false), (shadows, true)]
}

/// Seconds a ray, on every `stride`th slice.
fn time(accelerator: &Accelerator, rays: &[Ray], stride: usize, any: bool) -> f64 {
    let (mut hits, mut occluded) = ([Hit::MISS; SLICE], [false; SLICE]);
    let mut count = 0;
    let start = seconds();
    for slice in rays.chunks(SLICE).step_by(stride) {
        if any {
            accelerator.any_hits(slice, &mut occluded[..slice.len()]);
        } else {
            accelerator.closest_hits(slice, &mut hits[..slice.len()]);
        }
        std::hint::black_box((&hits, &occluded));
        count += slice.len();
    }
    (seconds() - start) / count.max(1) as f64
}

/// Seconds that this thread has run, where Linux tells; else seconds since the first call.
fn seconds() -> f64 {
    static START: OnceLock<Instant> = OnceLock::new();
    let told = std::fs::read_to_string("/proc/thread-self/schedstat").ok();
    let nanoseconds = told.and_then(|text| text.split(' ').next().and_then(|word| word.parse::<f64>().ok()));
    nanoseconds.map_or_else(|| START.get_or_init(Instant::now).elapsed().as_secs_f64(), |ns| ns * 1e-9)
}
