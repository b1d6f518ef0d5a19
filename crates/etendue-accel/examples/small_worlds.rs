//! Nanoseconds a ray in worlds that fit into the caches, for every accelerator and instruction set side by side: rooms of
//! few triangles with blocks in them, and balls of up to 7,000 triangles.
//!
//! `cargo run --release -p etendue-accel --example small_worlds [ROUNDS] [WORLD]`
//!
//! Rounds are so short, a millisecond or less, that the fastest is free of what else the machine does. All rays are incoherent: diffuse bounces, and segments between points of the surfaces. `tree` is the wide tree also
//! where `bvh` does without.
#![allow(clippy::disallowed_methods)]

use std::time::Instant;

use etendue_accel::{
    Accelerator, AcceleratorKind, Geometry, Hit, Instance, Isa, KdTreeSplit, Place, PrimitiveId, Ray, Transform,
    TriangleMesh, World,
};

/// Rays are handed over in slices of this length, like a wave of paths.
const SLICE: usize = 256;

/// Rays of a set.
const RAYS: usize = 24 * SLICE;

fn main() {
    let rounds = std::env::args().nth(1).map_or(100, |text| text.parse::<usize>().expect("a number"));
    println!("ns a ray on one thread, the fastest of {rounds} rounds in turns");
    for (blocks, name) in [(0, "room"), (2, "room"), (4, "room"), (6, "room"), (9, "room"), (13, "room"), (20, "room")]
    {
        compare(name, &room(blocks), rounds);
    }
    for triangles in [200, 1000, 7000] {
        compare("ball", &ball(triangles), rounds);
    }
}

/// All accelerators on one mesh.
fn compare(kind: &str, mesh: &TriangleMesh, rounds: usize) {
    let name = format!("{kind} of {} triangles", mesh.indices.len());
    if std::env::args().nth(2).is_some_and(|only| !name.contains(&only)) {
        return;
    }
    let plain =
        World { geometries: vec![Geometry::Triangles(mesh.clone())], instances: vec![instance(0, Place::World)] };
    // Nothing, but placed by a transform: this keeps the tree.
    let mut placed = plain.clone();
    let nothing = TriangleMesh { positions: [[0.0; 3]].into(), indices: [].into() };
    placed.geometries.push(Geometry::Triangles(nothing));
    placed.instances.push(instance(1, Place::Fixed(Transform::IDENTITY)));
    let mut contestants = Vec::new();
    let kd_tree = AcceleratorKind::KdTree(KdTreeSplit::SurfaceArea);
    for (label, world, kind, isas) in [
        ("kdtree", &plain, kd_tree, vec![Isa::detect()]),
        ("tree", &placed, AcceleratorKind::Bvh, Isa::available()),
        ("bvh", &plain, AcceleratorKind::Bvh, Isa::available()),
    ] {
        for isa in isas {
            contestants.push((label, isa, Accelerator::build(world, kind, isa, 1).expect("a world")));
        }
    }
    let (bounces, segments) = rays(&contestants[0].2);
    let mut times = vec![[const { Vec::new() }; 3]; contestants.len()];
    for _ in 0..rounds {
        for ((_, _, accelerator), times) in contestants.iter().zip(&mut times) {
            times[0].push(closest(accelerator, &bounces));
            times[1].push(any(accelerator, &segments));
            times[2].push(alone(accelerator, &bounces));
        }
    }
    println!("{name}: closest, any, closest one a call");
    for ((label, isa, _), times) in contestants.iter().zip(times) {
        let [closest, any, alone] = times.map(|times| times.into_iter().fold(f64::INFINITY, f64::min));
        println!("{label:>10} {isa:>9} {closest:8.1} {any:8.1} {alone:8.1}");
    }
}

fn instance(geometry: u32, place: Place) -> Instance {
    Instance { geometry, place, mask: u32::MAX }
}

fn closest(accelerator: &Accelerator, rays: &[Ray]) -> f64 {
    let mut hits = [Hit::MISS; SLICE];
    timed(rays, |slice| {
        accelerator.closest_hits(slice, &mut hits[..slice.len()]);
        std::hint::black_box(&hits);
    })
}

fn alone(accelerator: &Accelerator, rays: &[Ray]) -> f64 {
    let mut hit = [Hit::MISS];
    timed(rays, |slice| {
        for ray in slice {
            accelerator.closest_hits(std::slice::from_ref(ray), &mut hit);
            std::hint::black_box(&hit);
        }
    })
}

fn any(accelerator: &Accelerator, rays: &[Ray]) -> f64 {
    let mut occluded = [false; SLICE];
    timed(rays, |slice| {
        accelerator.any_hits(slice, &mut occluded[..slice.len()]);
        std::hint::black_box(&occluded);
    })
}

/// Nanoseconds a ray.
fn timed(rays: &[Ray], mut trace: impl FnMut(&[Ray])) -> f64 {
    let start = Instant::now();
    rays.chunks(SLICE).for_each(&mut trace);
    start.elapsed().as_secs_f64() * 1e9 / rays.len() as f64
}

struct Random(u64);

impl Random {
    /// In [-1, 1).
    fn number(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 40) as f32 / (1_u64 << 23) as f32 - 1.0
    }

    fn vector(&mut self) -> [f32; 3] {
        [self.number(), self.number(), self.number()]
    }
}

/// Bounces of a long walk of paths, and segments from their starts to the ends of others.
fn rays(accelerator: &Accelerator) -> (Vec<Ray>, Vec<Ray>) {
    let mut random = Random(1);
    let mut ray = |origin, skip| Ray {
        origin,
        direction: random.vector(),
        t_min: 0.0,
        t_max: f32::INFINITY,
        time: 0.0,
        mask: u32::MAX,
        skip,
    };
    let mut starts: Vec<Ray> = (0..RAYS).map(|_| ray([0.0; 3], PrimitiveId::NONE)).collect();
    let mut ends = starts.clone();
    for _ in 0..4 {
        starts = ends;
        let mut hits = vec![Hit::MISS; RAYS];
        accelerator.closest_hits(&starts, &mut hits);
        let onward = starts.iter().zip(&hits).map(|(start, hit)| match hit.is_hit() {
            true => ray(std::array::from_fn(|a| start.origin[a] + hit.t * start.direction[a]), hit.id),
            false => ray([0.0; 3], PrimitiveId::NONE),
        });
        ends = onward.collect();
    }
    let segments = starts.iter().zip(ends.iter().skip(1).chain(&ends[..1])).map(|(from, to)| Ray {
        direction: std::array::from_fn(|a| to.origin[a] - from.origin[a]),
        t_max: 0.9999,
        ..*from
    });
    (starts.clone(), segments.collect())
}

/// A mesh as it grows.
#[derive(Default)]
struct Growing {
    positions: Vec<[f32; 3]>,
    indices: Vec<[u32; 3]>,
}

impl Growing {
    /// The sides of a turned box.
    fn block(&mut self, center: [f32; 3], half: [f32; 3], angle: f32) {
        let first = self.positions.len() as u32;
        for corner in 0..8 {
            let [x, y, z] = [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { -half[axis] } else { half[axis] });
            let (sin, cos) = angle.sin_cos();
            let turned = [cos * x - sin * z, y, sin * x + cos * z];
            self.positions.push(std::array::from_fn(|a| center[a] + turned[a]));
        }
        for [a, b, c, d] in [[0, 2, 6, 4], [1, 5, 7, 3], [0, 4, 5, 1], [2, 3, 7, 6], [0, 1, 3, 2], [4, 6, 7, 5]]
            .map(|side| side.map(|i| i + first))
        {
            self.indices.extend([[a, b, c], [a, c, d]]);
        }
    }

    fn mesh(self) -> TriangleMesh {
        TriangleMesh { positions: self.positions.into(), indices: self.indices.into() }
    }
}

/// A room with blocks on its floor.
fn room(blocks: usize) -> TriangleMesh {
    let mut growing = Growing::default();
    let mut random = Random(7);
    growing.block([0.0; 3], [1.0; 3], 0.01);
    for _ in 0..blocks {
        let [x, y, z] = random.vector();
        let (size, height) = (0.6 / (blocks as f32).sqrt(), 0.4 + 0.3 * y);
        growing.block([0.7 * x, height - 0.99, 0.7 * z], [size * 0.5, height, size * 0.5], random.number());
    }
    growing.mesh()
}

/// A ball with bumps, by latitude and longitude.
fn ball(triangles: usize) -> TriangleMesh {
    let rows = ((triangles as f64 / 4.0).sqrt() as usize).max(2);
    let columns = 2 * rows;
    let mut growing = Growing::default();
    for i in 0..=rows {
        for j in 0..columns {
            let (a, b) =
                (std::f64::consts::PI * i as f64 / rows as f64, std::f64::consts::TAU * j as f64 / columns as f64);
            let r = 1.0 + 0.1 * (9.0 * a).sin() * (14.0 * b).sin();
            growing.positions.push([r * a.sin() * b.cos(), r * a.cos(), r * a.sin() * b.sin()].map(|x| x as f32));
        }
    }
    for i in 0..rows {
        for j in 0..columns {
            let at = |i: usize, j: usize| (i * columns + j % columns) as u32;
            let (p, q, r, s) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            growing.indices.extend([[p, q, r], [p, r, s]]);
        }
    }
    growing.mesh()
}
