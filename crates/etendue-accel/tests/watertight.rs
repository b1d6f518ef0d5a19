//! No ray escapes from a closed mesh or a sphere, wherever it is aimed, however large and far the thing is.
#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue_accel::{Accelerator, AcceleratorKind, Hit, Isa, KdTreeSplit, Sphere, TriangleMesh, World};

/// Size and place of a thing.
const PLACES: [(f32, [f32; 3]); 3] =
    [(1.0, [0.0; 3]), (1e4, [0.0; 3]), (1.0, [1e4 / 1.732_050_8, -1e4 / 1.732_050_8, 1e4 / 1.732_050_8])];

/// Rays are traced in slices of this many.
const SLICE: usize = 1000;

/// Traces rays that must all hit something, on the wide tree with every instruction set in turn and on the kd-tree.
fn none_escapes(name: &str, world: &World, count: usize, mut ray: impl FnMut() -> etendue_accel::Ray) {
    let mut accelerators: Vec<Accelerator> = Isa::available()
        .into_iter()
        .map(|isa| Accelerator::build(world, AcceleratorKind::Bvh, isa, 2).expect("a world"))
        .collect();
    let tree = AcceleratorKind::KdTree(KdTreeSplit::SurfaceArea);
    accelerators.push(Accelerator::build(world, tree, Isa::detect(), 2).expect("a world"));
    for slice in 0..count.div_ceil(SLICE) {
        let rays: Vec<_> = (0..SLICE).map(|_| ray()).collect();
        let mut hits = vec![Hit::MISS; SLICE];
        accelerators[slice % accelerators.len()].closest_hits(&rays, &mut hits);
        for (ray, hit) in rays.iter().zip(&hits) {
            assert!(hit.is_hit(), "{name}: {ray:?} escapes");
        }
    }
}

fn check_mesh(name: &str, mesh: &TriangleMesh, inside: impl Fn(&mut Rng) -> [f32; 3]) {
    for (size, shift) in PLACES {
        let place = |p: [f32; 3]| add(scale(p, size), shift);
        let placed = mapped(mesh, place);
        let mut rng = Rng(21 + mesh.indices.len() as u64);
        let next = || {
            let origin = place(inside(&mut rng));
            let face = rng.pick(&placed.indices).map(|i| placed.positions[i as usize]);
            let (a, b) = (face[0], face[1]);
            let target = match rng.below(3) {
                0 => a,
                1 => scale(add(a, b), 0.5),
                _ => add(a, scale(sub(b, a), rng.range(0.0, 1.0))),
            };
            let mut direction = sub(target, origin);
            if rng.chance(0.1) {
                direction = [0.0; 3];
                direction[rng.below(3)] = *rng.pick(&[1.0, -1.0]);
            }
            ray(origin, direction)
        };
        none_escapes(name, &world_of(&placed), 2 * ray_count() / 15, next);
    }
}

#[test]
fn boxes() {
    check_mesh("box", &subdivided_box(10), |rng| if rng.chance(0.3) { [0.0; 3] } else { rng.point(0.9) });
}

#[test]
fn balls() {
    check_mesh("ball", &ball(5), |rng| if rng.chance(0.3) { [0.0; 3] } else { rng.point(0.5) });
}

#[test]
fn bumpy_balls() {
    let mut rng = Rng(22);
    let bumpy = mapped(&ball(5), |p| scale(p, rng.range(0.6, 1.4)));
    check_mesh("bumpy ball", &bumpy, |rng| if rng.chance(0.3) { [0.0; 3] } else { rng.point(0.2) });
}

#[test]
fn tori() {
    // From inside the tube.
    check_mesh("torus", &torus(120, 60), |rng| {
        let angle = std::f32::consts::TAU * rng.range(0.0, 1.0);
        add([angle.cos(), angle.sin(), 0.0], rng.point(0.15))
    });
}

#[test]
fn spheres_hold_their_rays() {
    for (size, shift) in PLACES {
        let sphere = Sphere { center: shift, radius: size };
        let world = World { geometries: vec![spheres(vec![sphere])], instances: vec![plain(0)] };
        let mut rng = Rng(23);
        let next = || {
            let depth = *rng.pick(&[0.0, 0.5, 0.9]);
            let origin = add(shift, scale(rng.direction(), size * depth));
            let mut direction = rng.direction();
            if rng.chance(0.2) {
                direction[rng.below(3)] = 0.0;
            }
            if rng.chance(0.1) {
                direction = [0.0; 3];
                direction[rng.below(3)] = *rng.pick(&[1.0, -1.0]);
            }
            ray(origin, direction)
        };
        none_escapes("sphere", &world, 2 * ray_count() / 15, next);
    }
}

/// The test itself can fail: with one face gone, rays escape.
#[test]
fn a_hole_is_found() {
    let whole = ball(3);
    let pierced = mesh(whole.positions.to_vec(), whole.indices[1..].to_vec());
    let world = world_of(&pierced);
    let accelerator = Accelerator::build(&world, AcceleratorKind::Bvh, Isa::detect(), 1).unwrap();
    let corners = whole.indices[0].map(|i| whole.positions[i as usize]);
    let middle = corners.into_iter().fold([0.0; 3], add);
    let mut hits = [Hit::MISS];
    accelerator.closest_hits(&[ray([0.0; 3], middle)], &mut hits);
    assert!(!hits[0].is_hit());
}
