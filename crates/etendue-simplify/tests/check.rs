//! What the checker says of each accident.
#![allow(clippy::disallowed_methods)]

mod shapes;

use etendue_simplify::{Findings, Found, Mesh, check};
use shapes::*;

fn findings(mesh: &Mesh) -> Findings {
    check(&mesh.as_ref())
}

fn tetrahedron(at: f32) -> Mesh {
    let positions = vec![[at, 0.0, 0.0], [at + 1.0, 0.0, 0.0], [at, 1.0, 0.0], [at, 0.0, 1.0]];
    mesh_of(positions, vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])
}

fn one<P>(place: P) -> Found<P> {
    Found { count: 1, first: Some(place) }
}

#[test]
fn whole_shapes_are_faultless() {
    for (mesh, euler) in [(ball(9, bumpy), 2), (torus(20, 11), 0), (drum(12, 3), 2), (tetrahedron(0.0), 2)] {
        let found = findings(&mesh);
        let expected = Findings {
            faces: mesh.faces.len(),
            vertices: mesh.positions.len(),
            edges: mesh.faces.len() * 3 / 2,
            components: 1,
            ..Findings::default()
        };
        assert_eq!(found, expected);
        assert!(found.is_watertight() && found.is_manifold() && found.is_sound());
        assert_eq!(found.euler_number(), euler);
    }
}

#[test]
fn seams_are_closed() {
    let ball = ball(5, bumpy);
    let corners: Vec<[f32; 3]> = ball.faces.iter().flatten().map(|&v| ball.positions[v as usize]).collect();
    let faces = (0..ball.faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let found = findings(&mesh_of(corners, faces));
    assert!(found.is_watertight() && found.is_manifold() && found.vertices == ball.positions.len());
}

#[test]
fn holes_and_rims() {
    let found = findings(&grid(4, |_, _| 0.0));
    assert_eq!((found.boundary_edges.count, found.boundary_loops, found.euler_number()), (16, 1, 1));
    assert!(!found.is_watertight() && found.is_manifold() && found.is_sound());
    let mut holes = grid(6, |_, _| 0.0);
    holes.faces.remove(2 * (6 * 4 + 4));
    holes.faces.remove(2 * (6 + 1));
    let found = findings(&holes);
    assert_eq!((found.boundary_edges.count, found.boundary_loops), (24 + 6, 3));
    let mut open = tetrahedron(0.0);
    open.faces.remove(0);
    let found = findings(&open);
    assert_eq!(found.boundary_edges, Found { count: 3, first: Some([0, 1]) });
}

#[test]
fn faults_of_faces() {
    let mut mesh = tetrahedron(0.0);
    mesh.positions.extend([[f32::NAN, 0.0, 0.0], [0.5, 0.0, 0.0], [0.0, 0.0, 1.0]]);
    mesh.faces.extend([[0, 1, 99], [0, 1, 4], [2, 3, 3], [2, 3, 6], [0, 5, 1], [3, 2, 1], [1, 2, 6]]);
    let found = findings(&mesh);
    assert_eq!(found.bad_indices, one(4));
    assert_eq!(found.non_finite, one(5));
    assert_eq!(found.collapsed, Found { count: 2, first: Some(6) });
    assert_eq!(found.flat, one(8));
    assert_eq!(found.duplicates, Found { count: 2, first: Some(9) });
    assert!(!found.is_sound());
    assert_eq!(found.faces, 11);
}

#[test]
fn edges_of_many_faces() {
    // Two tetrahedra that share an edge: joined, but no manifold.
    let mut mesh = tetrahedron(0.0);
    mesh.positions.extend([[0.5, -1.0, 0.0], [0.5, 0.0, -1.0]]);
    mesh.faces.extend([[0, 1, 4], [1, 0, 5], [1, 5, 4], [5, 0, 4]]);
    let found = findings(&mesh);
    assert_eq!(found.non_manifold_edges, one([0, 1]));
    assert!(!found.is_watertight() && !found.is_manifold());
    assert_eq!((found.non_manifold_vertices.count, found.components, found.boundary_edges.count), (0, 1, 0));
}

#[test]
fn bowties() {
    // Two tetrahedra that share a vertex, by index or by position alone.
    let mut mesh = joined(&tetrahedron(0.0), &tetrahedron(5.0));
    assert_eq!((findings(&mesh).components, findings(&mesh).non_manifold_vertices.count), (2, 0));
    let apex = mesh.positions[3];
    mesh.positions[5] = apex;
    let found = findings(&mesh);
    assert_eq!(found.non_manifold_vertices, one(3));
    assert_eq!((found.components, found.vertices, found.euler_number()), (1, 7, 3));
    assert!(found.is_watertight() && !found.is_manifold());
}

#[test]
fn faces_turned_over() {
    let mut mesh = ball(4, bumpy);
    mesh.faces[7].swap(0, 1);
    let found = findings(&mesh);
    assert_eq!(found.misoriented_edges.count, 3);
    assert!(found.is_watertight());
    // A strip that is joined with a twist has an odd edge somewhere.
    let strip = |n: u32| {
        (0..n).flat_map(move |i| {
            let (a, b) = (2 * i, 2 * i + 1);
            let (c, d) = if i + 1 < n { (a + 2, b + 2) } else { (1, 0) };
            [[a, c, b], [b, c, d]]
        })
    };
    let positions = (0..24).map(|i| {
        let (angle, side) = (f64::from(i / 2) / 12.0 * std::f64::consts::TAU, f64::from(i % 2) - 0.5);
        let r = 1.0 + 0.5 * side * (0.5 * angle).cos();
        [(r * angle.cos()) as f32, (r * angle.sin()) as f32, (0.5 * side * (0.5 * angle).sin()) as f32]
    });
    let found = findings(&mesh_of(positions.collect(), strip(12).collect()));
    assert_eq!((found.misoriented_edges.count, found.boundary_loops, found.euler_number()), (1, 1, 0));
}

#[test]
fn nothing_is_nothing() {
    assert_eq!(findings(&Mesh::default()), Findings::default());
    assert!(!Findings::default().is_watertight());
    let alone = mesh_of(vec![[0.0; 3]; 5], Vec::new());
    assert_eq!(findings(&alone), Findings::default());
}
