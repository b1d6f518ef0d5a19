//! Closest points are those of a search through every face, bit for bit, on every instruction set.
#![allow(clippy::disallowed_methods)]

mod common;

use common::*;
use etendue_accel::{ClosestPoint, ClosestPoints, Isa, TriangleMesh, closest_on_triangle};

fn brute(mesh: &TriangleMesh, point: [f64; 3], within: f64) -> ClosestPoint {
    let mut best = ClosestPoint { distance_squared: within * within, ..ClosestPoint::NONE };
    for (face, corners) in mesh.indices.iter().enumerate() {
        let (distance_squared, weights) = closest_on_triangle(point, &corners.map(|i| mesh.positions[i as usize]));
        let nearer = distance_squared < best.distance_squared;
        if nearer || (distance_squared == best.distance_squared && best.face == u32::MAX) {
            best = ClosestPoint { distance_squared, weights, face: face as u32 };
        }
    }
    if best.is_found() { best } else { ClosestPoint::NONE }
}

/// Points in, on and around a mesh, in no order.
fn points(mesh: &TriangleMesh, count: usize, rng: &mut Rng) -> Vec<[f64; 3]> {
    let reach = mesh.positions.iter().flatten().fold(1e-30_f32, |reach, x| reach.max(x.abs()));
    let on_face = |rng: &mut Rng| {
        let face = rng.pick(&mesh.indices).map(|i| mesh.positions[i as usize].map(f64::from));
        let (u, v) = (rng.unit(), rng.unit());
        let (u, v) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
        std::array::from_fn(|a| face[0][a] + u * (face[1][a] - face[0][a]) + v * (face[2][a] - face[0][a]))
    };
    (0..count)
        .map(|_| match rng.below(6) {
            0 => rng.point(1.5 * reach).map(f64::from),
            1 => rng.pick(&mesh.positions).map(f64::from),
            2 => on_face(rng),
            3 => {
                let p: [f64; 3] = on_face(rng);
                let away = scale(rng.direction(), 1e-6 * reach);
                std::array::from_fn(|a| p[a] + f64::from(away[a]))
            }
            4 => rng.point((1e4 * reach).min(1e15)).map(f64::from),
            _ => {
                let (a, b) = (*rng.pick(&mesh.positions), *rng.pick(&mesh.positions));
                std::array::from_fn(|i| f64::midpoint(f64::from(a[i]), f64::from(b[i])))
            }
        })
        .collect()
}

fn soup(count: u32, size: f32, rng: &mut Rng) -> TriangleMesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let middle = rng.point(1.0);
        let mut face = [middle, add(middle, rng.point(size)), add(middle, rng.point(size))];
        match rng.below(8) {
            0 => face[1] = face[0],
            1 => face = [middle; 3],
            2 => face[2] = add(face[0], scale(sub(face[1], face[0]), 0.3)),
            _ => {}
        }
        positions.extend(face);
    }
    mesh(positions, (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

/// Long and thin, so that the tree holds them in pieces.
fn needles(count: u32, rng: &mut Rng) -> TriangleMesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let (start, along) = (rng.point(1.0), scale(rng.direction(), 1.5));
        positions.extend([start, add(start, along), add(start, rng.point(0.01))]);
    }
    mesh(positions, (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn worlds(rng: &mut Rng) -> Vec<(&'static str, TriangleMesh)> {
    let ball = ball(4);
    let far = mapped(&ball, |p| add(p, [1000.0, -3000.0, 5000.0]));
    let spread = mapped(&ball, |[x, y, z]| [x * 1e-6, y, z * 1e6]);
    vec![
        ("soup", soup(700, 0.3, rng)),
        ("dust", soup(700, 1e-4, rng)),
        ("needles", needles(600, rng)),
        ("large needles", mapped(&needles(600, rng), |p| scale(p, 3e14))),
        ("box", subdivided_box(9)),
        ("flat", mapped(&subdivided_box(6), |[x, y, _]| [x, y, 0.0])),
        ("torus", torus(40, 20)),
        ("huge", mapped(&ball, |p| scale(p, 7e14))),
        ("tiny", mapped(&ball, |p| scale(p, 1e-36))),
        ("below the range", mapped(&ball, |p| scale(p, 1e-43))),
        ("far", far),
        ("spread", spread),
        ("one", mesh(vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]])),
        ("point", mesh(vec![[0.5; 3]], vec![[0, 0, 0]])),
        ("ball", ball),
    ]
}

#[test]
fn all_instruction_sets_agree_with_brute_force() {
    let mut rng = Rng(17);
    let count = ray_count() / 300;
    for (name, mesh) in worlds(&mut rng) {
        let points = points(&mesh, count, &mut rng);
        let hints: Vec<u32> = points.iter().map(|_| rng.below(mesh.indices.len() + 3) as u32).collect();
        let reach = f64::from(mesh.positions.iter().flatten().fold(0.0_f32, |reach, x| reach.max(x.abs())));
        for within in [f64::INFINITY, 0.1 * reach, 0.0] {
            let expected: Vec<_> = points.iter().map(|&point| brute(&mesh, point, within)).collect();
            for isa in Isa::available() {
                let search = ClosestPoints::build(&mesh, isa).unwrap();
                let mut found = vec![ClosestPoint::NONE; points.len()];
                search.closest(&points, within, &mut found);
                for (i, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    assert_eq!(found, expected, "{name}, {isa}, {within}, point {:?}", points[i]);
                }
                found.fill(ClosestPoint::NONE);
                search.closest_from(&points, &hints, within, &mut found);
                assert!(found == expected, "{name}, {isa}: hints change answers");
            }
        }
    }
}

/// The distance in a frame of the triangle's own, by another way: the foot on the plane if it is inside, else the edges.
fn reference(point: [f64; 3], triangle: &[[f32; 3]; 3]) -> f64 {
    let sub = |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|i| a[i] - b[i]);
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let corners = triangle.map(|corner| corner.map(f64::from));
    let normal = cross(sub(corners[1], corners[0]), sub(corners[2], corners[0]));
    let sides = [0, 1, 2].map(|i| {
        let (p, q) = (corners[i], corners[(i + 1) % 3]);
        dot(cross(sub(q, p), sub(point, p)), normal)
    });
    if dot(normal, normal) > 0.0 && sides.iter().all(|&side| side >= 0.0) {
        return dot(sub(point, corners[0]), normal).abs() / dot(normal, normal).sqrt();
    }
    let edge = |i: usize| {
        let (p, q) = (corners[i], corners[(i + 1) % 3]);
        let along = sub(q, p);
        let t = (dot(sub(point, p), along) / dot(along, along)).clamp(0.0, 1.0);
        let t = if t.is_nan() { 0.0 } else { t };
        let off = sub(point, [0, 1, 2].map(|a| p[a] + t * along[a]));
        dot(off, off).sqrt()
    };
    edge(0).min(edge(1)).min(edge(2))
}

#[test]
fn distances_are_right() {
    let mut rng = Rng(3);
    for _ in 0..20_000 {
        let size = *rng.pick(&[1.0, 1e-3, 1e3]);
        let mut triangle = [rng.point(size), rng.point(size), rng.point(size)];
        match rng.below(6) {
            0 => triangle[2] = triangle[0],
            1 => triangle = [triangle[0]; 3],
            _ => {}
        }
        let point = rng.point(2.0).map(f64::from);
        let (distance_squared, [v, w]) = closest_on_triangle(point, &triangle);
        let expected = reference(point, &triangle);
        assert!((distance_squared.sqrt() - expected).abs() < 1e-9 * expected.max(1e-3), "{point:?} {triangle:?}");
        assert!(v >= 0.0 && w >= 0.0 && v + w <= 1.0 + 1e-15);
        let at = [0, 1, 2].map(|a| {
            let [p, q, r] = triangle.map(|corner| f64::from(corner[a]));
            p + v * (q - p) + w * (r - p) - point[a]
        });
        let distance = at.iter().map(|x| x * x).sum::<f64>().sqrt();
        assert!((distance - expected).abs() < 1e-9 * expected.max(1e-3), "the weights say where");
    }
}

#[test]
fn nothing_is_close_to_nowhere() {
    let nowhere = [[f64::NAN, 0.0, 0.0], [0.0, f64::INFINITY, 0.0], [0.0, 0.0, 1e16]];
    let search = ClosestPoints::build(&ball(1), Isa::detect()).unwrap();
    let mut found = [closest_of(&search, [0.0; 3]); 3];
    search.closest(&nowhere, f64::INFINITY, &mut found);
    assert!(found.iter().all(|found| *found == ClosestPoint::NONE));
    let empty = ClosestPoints::build(&mesh(Vec::new(), Vec::new()), Isa::detect()).unwrap();
    assert_eq!(closest_of(&empty, [0.0; 3]), ClosestPoint::NONE);
    let bad = mesh(vec![[f32::NAN; 3]; 3], vec![[0, 1, 2]]);
    assert!(ClosestPoints::build(&bad, Isa::detect()).is_err());
}

fn closest_of(search: &ClosestPoints, point: [f64; 3]) -> ClosestPoint {
    let mut found = [ClosestPoint::NONE];
    search.closest(&[point], f64::INFINITY, &mut found);
    found[0]
}
