//! Rays per second on a generated mesh, for every kind of accelerator and instruction set side by side.
//!
//! `cargo run --release -p etendue-accel --example rays [TRIANGLES] [RAYS]`
#![allow(clippy::disallowed_methods)]

use std::sync::OnceLock;
use std::time::Instant;

use etendue_accel::{
    Accelerator, AcceleratorKind, Geometry, Hit, Instance, Isa, Place, PrimitiveId, Ray, TriangleMesh, World,
};

/// Rays are handed over in slices of this length, like a wave of paths.
const SLICE: usize = 256;

/// The median of this many runs counts; the runs of all competitors alternate.
const RUNS: usize = 5;

/// Brute force and the kd-tree are measured on one ray in this many.
const SLOW: usize = 16;

fn main() {
    let mut arguments = std::env::args().skip(1).map(|text| text.parse::<usize>().expect("a number"));
    let triangles = arguments.next().unwrap_or(1_000_000);
    let rays = arguments.next().unwrap_or(200_000);
    let world = World {
        geometries: vec![Geometry::Triangles(bumpy_ball(triangles))],
        instances: vec![Instance { geometry: 0, place: Place::World, mask: u32::MAX }],
    };
    let mut competitors = Vec::new();
    for kind in AcceleratorKind::ALL {
        if kind == AcceleratorKind::Brute && triangles > 2000 {
            continue;
        }
        for isa in Isa::available() {
            let start = Instant::now();
            let built = Accelerator::build(&world, kind, isa, 0).expect("a world");
            let stats = built.stats();
            println!(
                "{kind:>16} {isa:>8}: built in {:.2} s, {} nodes, depth {}, {:.1} bytes a triangle",
                start.elapsed().as_secs_f64(),
                stats.nodes,
                stats.depth,
                stats.bytes as f64 / stats.primitives as f64
            );
            competitors.push((kind, isa, built));
        }
    }
    let camera = camera_rays(rays);
    let mut hits = vec![Hit::MISS; camera.len()];
    competitors[competitors.len() - 1].2.closest_hits(&camera, &mut hits);
    let bounces = bounce_rays(&camera, &hits);
    let shadows: Vec<Ray> = bounces.iter().map(|ray| Ray { t_max: 1.0, ..*ray }).collect();
    println!("Mrays/s on one thread, median of {RUNS} runs:");
    println!("{:>16} {:>8} {:>10} {:>10} {:>10}", "", "", "camera", "bounce", "shadow");
    let mut seconds = vec![[const { Vec::new() }; 3]; competitors.len()];
    for _ in 0..RUNS {
        for ((kind, _, accelerator), seconds) in competitors.iter().zip(&mut seconds) {
            let share = if *kind == AcceleratorKind::Bvh { 1 } else { SLOW };
            for (set, (rays, times)) in [&camera, &bounces, &shadows].into_iter().zip(seconds).enumerate() {
                times.push(time(accelerator, rays, share, set == 2));
            }
        }
    }
    for ((kind, isa, _), seconds) in competitors.iter().zip(&mut seconds) {
        let [camera, bounce, shadow] = seconds.each_mut().map(|times| {
            times.sort_by(f64::total_cmp);
            1e-6 / times[times.len() / 2]
        });
        println!("{kind:>16} {isa:>8} {camera:10.3} {bounce:10.3} {shadow:10.3}");
    }
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

/// A sphere of radius about 1 with bumps, by latitude and longitude.
fn bumpy_ball(triangles: usize) -> TriangleMesh {
    let rows = ((triangles as f64 / 4.0).sqrt() as usize).max(2);
    let columns = 2 * rows;
    let mut positions = Vec::new();
    for i in 0..=rows {
        for j in 0..columns {
            let (a, b) =
                (std::f64::consts::PI * i as f64 / rows as f64, std::f64::consts::TAU * j as f64 / columns as f64);
            let r = 1.0 + 0.05 * (9.0 * a).sin() * (14.0 * b).sin() + 0.01 * (83.0 * a).cos() * (97.0 * b).sin();
            positions.push([r * a.sin() * b.cos(), r * a.cos(), r * a.sin() * b.sin()].map(|x| x as f32));
        }
    }
    let mut indices = Vec::new();
    for i in 0..rows {
        for j in 0..columns {
            let at = |i: usize, j: usize| (i * columns + j % columns) as u32;
            let (p, q, r, s) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            indices.extend([[p, q, r], [p, r, s]]);
        }
    }
    TriangleMesh { positions: positions.into(), indices: indices.into() }
}

fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY, time: 0.0, mask: u32::MAX, skip: PrimitiveId::NONE }
}

/// From one point, in order of pixels.
fn camera_rays(count: usize) -> Vec<Ray> {
    let side = (count as f64).sqrt() as usize;
    let place = |i: usize| 1.6 * (i as f32 + 0.5) / side as f32 - 0.8;
    let pixel = |i: usize| ray([0.3, 0.2, 2.5], [place(i % side) - 0.12, place(i / side) - 0.08, -1.0]);
    (0..side * side).map(pixel).collect()
}

/// From what the camera sees into random directions.
fn bounce_rays(camera: &[Ray], hits: &[Hit]) -> Vec<Ray> {
    let mut state = 1_u64;
    let mut random = || {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    };
    let mut bounces = Vec::new();
    for (ray, hit) in camera.iter().zip(hits).filter(|(_, hit)| hit.is_hit()) {
        let origin = std::array::from_fn(|a| ray.origin[a] + hit.t * ray.direction[a]);
        let direction = [random(), random(), random()];
        bounces.push(Ray { origin, direction, skip: hit.id, ..*ray });
    }
    bounces
}
