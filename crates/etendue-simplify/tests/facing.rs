//! Faces are not turned over against the original surface beside them.
#![allow(clippy::disallowed_methods)]

mod shapes;

use etendue_accel::{ClosestPoint, ClosestPoints, Isa, TriangleMesh};
use etendue_simplify::{Mesh, Method, Options, Placement, Target, check, simplify};
use shapes::*;

fn corners(mesh: &Mesh, face: usize) -> [[f64; 3]; 3] {
    mesh.faces[face].map(|v| mesh.positions[v as usize].map(f64::from))
}

fn normal([a, b, c]: [[f64; 3]; 3]) -> [f64; 3] {
    let (p, q): ([f64; 3], [f64; 3]) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
    [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]]
}

/// The least cosine between a face of `mesh` and the face of `original` that is nearest to one of four points of it, and the
/// number of faces with a cosine below 0.
fn facing(original: &Mesh, mesh: &Mesh) -> (f64, usize) {
    let triangles =
        TriangleMesh { positions: original.positions.as_slice().into(), indices: original.faces.as_slice().into() };
    let search = ClosestPoints::build(&triangles, Isa::detect()).unwrap();
    let weights = [[1.0 / 3.0; 3], [0.6, 0.2, 0.2], [0.2, 0.6, 0.2], [0.2, 0.2, 0.6]];
    let at = |face: usize, w: [f64; 3]| {
        let [a, b, c] = corners(mesh, face);
        [0, 1, 2].map(|i| w[0] * a[i] + w[1] * b[i] + w[2] * c[i])
    };
    let points: Vec<[f64; 3]> = (0..mesh.faces.len()).flat_map(|face| weights.map(|w| at(face, w))).collect();
    let mut found = vec![ClosestPoint::NONE; points.len()];
    search.closest(&points, f64::INFINITY, &mut found);
    let cosine = |a: [f64; 3], b: [f64; 3]| {
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|i| a[i] * b[i]).sum::<f64>();
        dot(a, b) / (dot(a, a) * dot(b, b)).sqrt()
    };
    let of_face = |(face, found): (usize, &[ClosestPoint])| {
        let here = normal(corners(mesh, face));
        let there = |found: &ClosestPoint| cosine(here, normal(corners(original, found.face as usize)));
        found.iter().map(there).fold(f64::INFINITY, f64::min)
    };
    let cosines: Vec<f64> = found.chunks(weights.len()).enumerate().map(of_face).collect();
    (cosines.iter().copied().fold(f64::INFINITY, f64::min), cosines.iter().filter(|c| c.is_nan() || **c <= 0.0).count())
}

#[test]
fn turned_faces_are_seen() {
    let mut mesh = ball(12, bumpy);
    let original = mesh.clone();
    assert_eq!(facing(&original, &mesh).1, 0);
    mesh.faces[5].swap(0, 1);
    mesh.faces[77].swap(1, 2);
    assert_eq!(facing(&original, &mesh).1, 2);
}

#[test]
fn faces_of_smooth_closed_models_face_outwards() {
    // No folds, and so many faces that all that rises and falls is still there.
    let mut faults: Vec<String> = vec![];
    let wavy = |p: [f64; 3]| 1.0 + 0.03 * (14.0 * p[0]).sin() * (12.0 * p[1] + 1.0).cos() * (13.0 * p[2]).sin();
    for (name, original, sizes) in [
        ("bumps", ball(40, bumpy), [1000, 300, 100]),
        ("waves", ball(50, wavy), [3000, 1500, 800]),
        ("torus", torus(100, 50), [1500, 500, 200]),
    ] {
        for faces in sizes {
            for (method, placement, fast) in [
                (Method::Quadric, Placement::Auto, false),
                (Method::Quadric, Placement::Auto, true),
                (Method::Quadric, Placement::Perturbed, false),
                (Method::Quadric, Placement::Endpoint, false),
                (Method::QuadricUnion, Placement::Auto, false),
                (Method::ShortestEdge, Placement::Auto, false),
            ] {
                for polish in [false, true].into_iter().take(2 - usize::from(fast)) {
                    let options = Options { method, placement, fast, polish, ..Options::new(Target::Faces(faces)) };
                    let result = simplify(&original.as_ref(), &options, &mut carry_on).unwrap();
                    let (least, turned) = facing(&original, &result.mesh);
                    assert!(check(&result.mesh.as_ref()).is_watertight());
                    if turned > 0 || result.report.turned > 0 {
                        let how = [fast, polish];
                        faults
                            .push(format!("{name} to {faces}, {method:?} {placement:?} {how:?}: {turned}, {least:.3}"));
                    }
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}
