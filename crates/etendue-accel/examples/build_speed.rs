//! Milliseconds to build the BVH: balls of a thousand faces and up, and many small ones that are placed twice each.
//!
//! `cargo run --release -p etendue-accel --example build_speed [ROUNDS] [THREADS]`
//!
//! The median and the fastest of so many rounds (default 30), on so many threads (default: all processors).
#![allow(clippy::disallowed_methods)]

use std::{hint::black_box, time::Instant};

use etendue_accel::{Accelerator, AcceleratorKind, Geometry, Instance, Isa, Place, Transform, TriangleMesh, World};

fn main() {
    let mut numbers = std::env::args().skip(1).map(|text| text.parse::<usize>().expect("a number"));
    let (rounds, threads) = (numbers.next().unwrap_or(30).max(1), numbers.next().unwrap_or(0));
    for faces in [300, 1_000, 7_000, 50_000, 400_000] {
        let world = World { geometries: vec![ball(faces)], instances: vec![instance(0, Place::World)] };
        time(&format!("a ball of {faces} faces"), &world, rounds, threads);
    }
    for (balls, faces) in [(2_000, 200), (200, 7_000)] {
        let geometries = (0..balls).map(|_| ball(faces)).collect();
        let places = [Transform::IDENTITY, Transform::new(TURNED).expect("a rotation")];
        let twice = (0..balls).flat_map(|i| places.map(|place| instance(i, Place::Fixed(place))));
        let world = World { geometries, instances: twice.collect() };
        time(&format!("{balls} balls of {faces} faces, twice each"), &world, rounds, threads);
    }
}

/// A quarter turn about z, and a little aside.
const TURNED: [[f32; 4]; 3] = [[0.0, -1.0, 0.0, 3.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];

fn instance(geometry: u32, place: Place) -> Instance {
    Instance { geometry, place, mask: u32::MAX }
}

fn time(name: &str, world: &World, rounds: usize, threads: usize) {
    let mut times: Vec<f64> = (0..rounds)
        .map(|_| {
            let clock = Instant::now();
            let built = Accelerator::build(world, AcceleratorKind::Bvh, Isa::detect(), threads);
            let milliseconds = clock.elapsed().as_secs_f64() * 1e3;
            black_box(built.expect("a world"));
            milliseconds
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("{name}: {:.3} ms, at best {:.3}", times[rounds / 2], times[0]);
}

/// A sphere of about so many faces, somewhat bumpy.
fn ball(faces: usize) -> Geometry {
    let columns = (faces as f32).sqrt() as u32;
    let rows = faces as u32 / (2 * columns);
    let point = |row: u32, column: u32| {
        let (polar, turn) = (row as f32 / rows as f32, column as f32 / columns as f32);
        let (sin, cos) = (std::f32::consts::PI * polar).sin_cos();
        let (y, x) = (std::f32::consts::TAU * turn).sin_cos();
        let radius = 1.0 + 0.05 * (20.0 * turn).sin() * (13.0 * polar).cos();
        [radius * sin * x, radius * sin * y, radius * cos]
    };
    let positions = (0..=rows).flat_map(|row| (0..columns).map(move |column| point(row, column)));
    let cells = (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column)));
    let triangles = cells.flat_map(|(row, column)| {
        let at = |row: u32, column: u32| row * columns + column % columns;
        let [a, b, c, d] = [at(row, column), at(row + 1, column), at(row + 1, column + 1), at(row, column + 1)];
        [[a, b, c], [a, c, d]]
    });
    let indices: Vec<[u32; 3]> = triangles.collect();
    Geometry::Triangles(TriangleMesh { positions: positions.collect(), indices: indices.into() })
}
