//! Polish and the curves of a mesh: open edges, borders and creases.
#![allow(clippy::disallowed_methods)]

mod shapes;

use std::collections::BTreeMap;

use etendue_simplify::{Mesh, Options, Target, check, simplify};
use shapes::*;

type Point = [f64; 3];

/// Simplified without and with polish: the same faces over other positions.
fn both(mesh: &Mesh, faces: usize) -> [Mesh; 2] {
    let pair = [false, true].map(|polish| {
        let options = Options { polish, ..Options::new(Target::Faces(faces)) };
        simplify(&mesh.as_ref(), &options, &mut carry_on).unwrap().mesh
    });
    assert_eq!(pair[0].faces, pair[1].faces);
    pair
}

fn sub(a: Point, b: Point) -> Point {
    [0, 1, 2].map(|i| a[i] - b[i])
}

fn dot(a: Point, b: Point) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

fn normal(mesh: &Mesh, face: usize) -> Point {
    let [a, b, c] = mesh.faces[face].map(|v| mesh.positions[v as usize].map(f64::from));
    let (p, q) = (sub(b, a), sub(c, a));
    let n = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    n.map(|x| x / dot(n, n).sqrt())
}

/// The edges of curves: open, between materials, or sharper than 40 degrees.
fn curves(mesh: &Mesh) -> Vec<[u32; 2]> {
    let mut faces: BTreeMap<[u32; 2], Vec<usize>> = BTreeMap::new();
    for (face, corners) in mesh.faces.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            faces.entry([a.min(b), a.max(b)]).or_default().push(face);
        }
    }
    let is_curve = |faces: &[usize]| match *faces {
        [one, other] => {
            mesh.materials.as_ref().is_some_and(|m| m[one] != m[other])
                || dot(normal(mesh, one), normal(mesh, other)) < 40f64.to_radians().cos()
        }
        _ => true,
    };
    faces.into_iter().filter(|(_, faces)| is_curve(faces)).map(|(edge, _)| edge).collect()
}

/// The distance of a point to the nearest of some edges.
fn distance(point: Point, mesh: &Mesh, edges: &[[u32; 2]]) -> f64 {
    let to_edge = |edge: &[u32; 2]| {
        let [a, b] = edge.map(|v| mesh.positions[v as usize].map(f64::from));
        let side = sub(b, a);
        let t = (dot(sub(point, a), side) / dot(side, side)).clamp(0.0, 1.0);
        let left = sub(sub(point, a), side.map(|x| t * x));
        dot(left, left).sqrt()
    };
    edges.iter().map(to_edge).fold(f64::INFINITY, f64::min)
}

/// Root mean square and largest distance from a mesh's curves to those of another.
fn off(from: &Mesh, to: &Mesh) -> [f64; 2] {
    let there = curves(to);
    let (mut squares, mut largest, mut length) = (0.0, 0.0f64, 0.0);
    for edge in curves(from) {
        let [a, b] = edge.map(|v| from.positions[v as usize].map(f64::from));
        let side = sub(b, a);
        let far = distance([0, 1, 2].map(|i| 0.5 * (a[i] + b[i])), to, &there);
        let long = dot(side, side).sqrt();
        squares += long * far * far;
        length += long;
        largest = largest.max(far);
    }
    [(squares / length).sqrt(), largest]
}

/// A sheet over an ellipse, whose border rises and falls.
fn dish() -> Mesh {
    let (around, rings) = (240, 24);
    let mut positions = vec![[0.0; 3]];
    let mut faces = Vec::new();
    for ring in 1..=rings {
        for i in 0..around {
            let angle = std::f64::consts::TAU * f64::from(i) / f64::from(around);
            let r = f64::from(ring) / f64::from(rings);
            let height = 0.15 * r * r * (3.0 * angle + 1.0).sin();
            positions.push([2.5 * r * angle.cos(), r * angle.sin(), height].map(|x| x as f32));
            let at = |ring: i32, i: i32| if ring == 0 { 0 } else { (1 + (ring - 1) * around + i % around) as u32 };
            faces.push([at(ring - 1, i), at(ring, i), at(ring, i + 1)]);
            if ring > 1 {
                faces.push([at(ring - 1, i), at(ring, i + 1), at(ring - 1, i + 1)]);
            }
        }
    }
    mesh_of(positions, faces)
}

/// A sheet of two materials with a bent border between them; its rim is straight.
fn flag() -> Mesh {
    let sheet = grid(48, |_, _| 0.0);
    let bent = moved(&sheet, |[x, y, _]| {
        let (x, y) = (f64::from(x), f64::from(y));
        let inside = 4.0 * x * (1.0 - x);
        [x + 0.15 * inside * (6.0 * y * y).sin(), y, 0.05 * (5.0 * x + 2.0 * y).sin()].map(|x| x as f32)
    });
    let left = |face: &[u32; 3]| face.iter().all(|&v| v % 49 <= 24);
    let materials = bent.faces.iter().map(|face| u32::from(left(face))).collect();
    Mesh { materials: Some(materials), ..bent }
}

#[test]
fn vertices_of_borders_slide_along_them() {
    for (name, mesh, faces, gain) in
        [("dish", dish(), 300, 0.97), ("dish", dish(), 120, 0.97), ("flag", flag(), 200, 0.97)]
    {
        let [rough, fine] = both(&mesh, faces);
        let there = curves(&mesh);
        let (mut moved, mut count) = (0, 0);
        let mut on_curves: Vec<u32> = curves(&rough).into_iter().flatten().collect();
        on_curves.sort_unstable();
        on_curves.dedup();
        for v in on_curves {
            let [before, now] = [&rough, &fine].map(|mesh| mesh.positions[v as usize].map(f64::from));
            let [was, is] = [before, now].map(|p| distance(p, &mesh, &there));
            assert!(is <= was + 1e-6, "{name}: {was} {is}");
            count += 1;
            moved += usize::from(before != now);
        }
        let [was, is] = [off(&mesh, &rough), off(&mesh, &fine)];
        println!("{name} to {faces}: {moved} of {count} moved, rms and largest of curves {was:?} -> {is:?}");
        assert!(4 * moved > count, "{name}: {moved} of {count}");
        assert!(is[0] < gain * was[0], "{name}: {was:?} {is:?}");
        let found = check(&fine.as_ref());
        assert!(found.is_sound() && found.is_manifold(), "{name}: {found:?}");
        assert_eq!(found.boundary_loops, check(&mesh.as_ref()).boundary_loops);
    }
}

#[test]
fn creases_come_no_farther_off() {
    // Rims whose curvature changes, and the edge of a lens.
    let tin = moved(&drum(240, 24), |[x, y, z]| [2.5 * x, y, z + 0.2 * x * y]);
    let lens = moved(&ball(40, |_| 1.0), |[x, y, z]| [2.0 * x, y, 0.4 * z * z.abs()]);
    for (name, mesh, faces) in [("tin", &tin, 400), ("tin", &tin, 150), ("lens", &lens, 300)] {
        let [rough, fine] = both(mesh, faces);
        let [was, is] = [off(mesh, &rough), off(mesh, &fine)];
        println!("{name} to {faces}: rms and largest of creases {was:?} -> {is:?}");
        assert!(is[0] < 0.9 * was[0] && is[1] < 0.8 * was[1], "{name}: {was:?} {is:?}");
        assert!(rough.positions != fine.positions);
    }
}

#[test]
fn ends_and_corners_of_curves_stay() {
    let mesh = flag();
    let [_, fine] = both(&mesh, 200);
    // The corners of the sheet, and both ends of the border between materials.
    for corner in [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]] {
        let near = |p: &[f32; 3]| (f64::from(p[0]) - corner[0]).hypot(f64::from(p[1]) - corner[1]);
        let nearest = fine.positions.iter().map(near).fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-3, "{corner:?}: {nearest}");
    }
    for v in [24, 48 * 49 + 24] {
        assert!(fine.positions.contains(&mesh.positions[v]), "vertex {v}");
    }
}
