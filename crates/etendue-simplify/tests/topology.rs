//! One test per topological accident.
// What is made is measured, never compared bit by bit with another machine's.
#![allow(clippy::disallowed_methods)]

mod shapes;

use std::f64::consts::PI;
use std::ops::ControlFlow;

use etendue_simplify::{Mesh, MeshRef, Method, Options, Placement, Simplified, SimplifyError, Target, check, simplify};
use shapes::{ball, carry_on, grid, joined, mesh_of, moved, torus};

fn to(mesh: &Mesh, faces: usize) -> Simplified {
    run(mesh, &Options::new(Target::Faces(faces)))
}

fn run(mesh: &Mesh, options: &Options) -> Simplified {
    simplify(&mesh.as_ref(), options, &mut carry_on).unwrap()
}

fn tetrahedron() -> Mesh {
    mesh_of(
        vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        vec![[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]],
    )
}

/// A cube with `n` by `n` squares a side, its vertices shared.
fn cube(n: u32) -> Mesh {
    let mut parts = Vec::new();
    for axis in 0..3 {
        for side in [0.0, 1.0] {
            let face = grid(n, |_, _| 0.0);
            parts.push(moved(&face, |[x, y, _]| {
                let (x, y) = (x - low(&face, 0), y - low(&face, 1));
                let (x, y) = (x / size(&face, 0), y / size(&face, 1));
                let mut p = [0.0; 3];
                p[axis] = side;
                // The other axes in the order that turns the face outwards.
                let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
                (p[u], p[v]) = if side > 0.5 { (x, y) } else { (y, x) };
                p
            }));
        }
    }
    parts.iter().skip(1).fold(parts[0].clone(), |all, part| joined(&all, part))
}

fn low(mesh: &Mesh, axis: usize) -> f32 {
    mesh.positions.iter().map(|p| p[axis]).fold(f32::MAX, f32::min)
}

fn size(mesh: &Mesh, axis: usize) -> f32 {
    mesh.positions.iter().map(|p| p[axis]).fold(f32::MIN, f32::max) - low(mesh, axis)
}

#[test]
fn empty() {
    let result = to(&Mesh::default(), 10);
    assert_eq!(result.mesh.faces.len(), 0);
    assert_eq!(result.report.stopped, None);
    let vertices_only = to(&mesh_of(vec![[1.0, 2.0, 3.0]], vec![]), 0);
    assert_eq!(vertices_only.mesh.positions.len(), 0);
}

#[test]
fn one_triangle_stays() {
    let mesh = mesh_of(vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], vec![[0, 1, 2]]);
    let result = to(&mesh, 0);
    assert_eq!(result.mesh.faces.len(), 1);
    assert_eq!(result.report.stopped.unwrap().topology, 3);
}

#[test]
fn a_tetrahedron_goes_no_lower() {
    let result = to(&tetrahedron(), 1);
    assert_eq!(result.mesh.faces.len(), 4);
    assert_eq!(result.report.stopped.unwrap().topology, 6);
    assert_eq!(result.report.collapses, 0);
}

#[test]
fn two_tetrahedra_at_an_edge_stay() {
    let second = moved(&tetrahedron(), |[x, y, z]| [-x, -y, z]);
    let mesh = joined(&tetrahedron(), &second);
    let before = check(&mesh.as_ref());
    assert_eq!(before.non_manifold_edges.count, 1);
    let result = to(&mesh, 1);
    assert_eq!(result.mesh.faces.len(), 8);
    assert_eq!(check(&result.mesh.as_ref()).non_manifold_edges.count, 1);
}

#[test]
fn a_cube_becomes_twelve_faces() {
    let result = to(&cube(8), 12);
    assert_eq!(result.report.faces_in, 12 * 64);
    assert_eq!(result.mesh.faces.len(), 12);
    assert_eq!(result.mesh.positions.len(), 8);
    for p in &result.mesh.positions {
        assert!(p.iter().all(|x| x.abs() < 1e-5 || (x - 1.0).abs() < 1e-5), "{p:?}");
    }
}

#[test]
fn a_flat_square_stays_flat_and_keeps_its_border() {
    let mesh = grid(32, |_, _| 0.0);
    let result = to(&mesh, 2);
    assert_eq!(result.mesh.faces.len(), 2);
    assert!(result.mesh.positions.iter().all(|p| p[2].abs() < 1e-6));
    for axis in 0..2 {
        assert!((size(&result.mesh, axis) - size(&mesh, axis)).abs() < 1e-4);
    }
}

#[test]
fn a_border_that_is_kept_keeps_all_its_vertices() {
    let mesh = grid(16, |_, _| 0.0);
    let options = Options { keep_boundary: true, ..Options::new(Target::Faces(2)) };
    let result = run(&mesh, &options);
    let before = check(&mesh.as_ref()).boundary_edges.count;
    assert_eq!(check(&result.mesh.as_ref()).boundary_edges.count, before);
    // A polygon of n corners takes n - 2 triangles.
    assert!(result.mesh.faces.len() <= before, "{}", result.mesh.faces.len());
}

#[test]
fn locked_vertices_stay_to_the_bit() {
    let mesh = grid(24, |x, y| 0.1 * (9.0 * x).sin() * (7.0 * y).cos());
    let locked: Vec<u32> = (0..mesh.positions.len() as u32).step_by(37).collect();
    let options = Options { locked: locked.clone(), ..Options::new(Target::Faces(200)) };
    let result = run(&mesh, &options);
    for v in locked {
        assert!(result.mesh.positions.contains(&mesh.positions[v as usize]), "vertex {v}");
    }
}

#[test]
fn a_bowtie_keeps_its_knot() {
    let mesh = joined(&grid(8, |_, _| 0.0), &moved(&grid(8, |_, _| 0.0), |p| p));
    let corner =
        mesh.positions.iter().copied().fold([f32::MIN; 3], |a, p| if p[0] + p[1] > a[0] + a[1] { p } else { a });
    let first = grid(8, |_, _| 0.0);
    let opposite = moved(&first, |p| [2.0 * corner[0] - p[0], 2.0 * corner[1] - p[1], p[2]]);
    let mesh = joined(&first, &opposite);
    assert_eq!(check(&mesh.as_ref()).non_manifold_vertices.count, 1);
    let result = to(&mesh, 4);
    assert_eq!(result.mesh.faces.len(), 4);
    assert!(result.mesh.positions.contains(&corner));
    assert_eq!(check(&result.mesh.as_ref()).non_manifold_vertices.count, 1);
}

#[test]
fn a_moebius_strip_stays_one() {
    let (n, m) = (96, 6);
    let mut positions = Vec::new();
    for i in 0..n {
        for j in 0..=m {
            let (a, s) = (2.0 * PI * f64::from(i) / f64::from(n), f64::from(j) / f64::from(m) - 0.5);
            let r = 1.0 + s * (0.5 * a).cos();
            positions.push([r * a.cos(), r * a.sin(), s * (0.5 * a).sin()].map(|x| x as f32));
        }
    }
    let at = |i: u32, j: u32| if i == n { m - j } else { i * (m + 1) + j };
    let mut faces = Vec::new();
    for i in 0..n {
        for j in 0..m {
            faces.push([at(i, j), at(i + 1, j), at(i + 1, j + 1)]);
            faces.push([at(i, j), at(i + 1, j + 1), at(i, j + 1)]);
        }
    }
    let result = to(&mesh_of(positions, faces), 60);
    let findings = check(&result.mesh.as_ref());
    assert_eq!((findings.euler_number(), findings.boundary_loops, findings.components), (0, 1, 1));
    assert!(findings.is_manifold() && findings.is_sound());
    assert!(result.mesh.faces.len() < 200, "{}", result.mesh.faces.len());
}

#[test]
fn a_torus_keeps_its_genus() {
    let result = to(&torus(96, 48), 200);
    let findings = check(&result.mesh.as_ref());
    assert_eq!(result.mesh.faces.len(), 200);
    assert_eq!(findings.euler_number(), 0);
    assert!(findings.is_watertight() && findings.is_manifold() && findings.is_sound());
    let options = Options { keep_topology: true, ..Options::new(Target::Faces(4)) };
    let least = run(&torus(96, 48), &options);
    assert_eq!(check(&least.mesh.as_ref()).euler_number(), 0);
    assert!(least.report.stopped.is_some() && least.report.cuts == 0);
}

#[test]
fn a_thin_neck_is_not_cut() {
    // Two bulbs, with a bar of a hundredth between them.
    let dumbbell = moved(&ball(48, |_| 1.0), |[x, y, z]| {
        let bulb = ((z.abs() - 0.3) / 0.7).max(0.0);
        let narrow = if bulb > 0.0 { bulb.sqrt().max(0.01) } else { 0.01 };
        let radius = x.hypot(y).max(1e-6);
        let wanted = narrow * (1.0 - z * z).max(0.0).sqrt();
        [x * wanted / radius, y * wanted / radius, 3.0 * z]
    });
    for faces in [400, 150, 60] {
        let result = to(&dumbbell, faces);
        let findings = check(&result.mesh.as_ref());
        assert!(findings.is_watertight() && findings.is_manifold() && findings.is_sound());
        assert_eq!((findings.components, findings.euler_number()), (1, 2), "{faces}");
        assert_eq!(result.report.cuts, 0);
    }
}

#[test]
fn no_face_of_a_flat_comb_turns_over() {
    // Squares between the teeth are left out, so that many edges see round a corner.
    let mut comb = grid(24, |_, _| 0.0);
    let left: Vec<bool> = (0..comb.faces.len()).map(|i| (i / 2 % 24) % 4 > 1 || i / 48 < 4).collect();
    let mut i = 0;
    comb.faces.retain(|_| {
        i += 1;
        left[i - 1]
    });
    let area = |mesh: &Mesh, face: &[u32; 3]| {
        let [a, b, c] = face.map(|v| mesh.positions[v as usize].map(f64::from));
        0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]))
    };
    let before: f64 = comb.faces.iter().map(|face| area(&comb, face)).sum();
    for faces in [200, 60, 10] {
        for fast in [false, true] {
            let options = Options { fast, polish: false, ..Options::new(Target::Faces(faces)) };
            let mesh = run(&comb, &options).mesh;
            let least = mesh.faces.iter().map(|face| area(&mesh, face) / before).fold(f64::INFINITY, f64::min);
            assert!(least > 0.0, "{faces}: a face of {least}");
        }
    }
}

#[test]
fn a_hole_stays() {
    let mut mesh = grid(24, |_, _| 0.0);
    let middle = [0, 1].map(|axis| low(&mesh, axis) + 0.5 * size(&mesh, axis));
    let positions = mesh.positions.clone();
    mesh.faces.retain(|face| {
        face.iter().any(|&v| (0..2).any(|axis| (positions[v as usize][axis] - middle[axis]).abs() > 0.2))
    });
    assert_eq!(check(&mesh.as_ref()).boundary_loops, 2);
    let result = to(&mesh, 1);
    let findings = check(&result.mesh.as_ref());
    assert_eq!(findings.boundary_loops, 2);
    assert!(findings.is_manifold() && findings.is_sound());
    assert!(result.mesh.faces.len() <= 12, "{}", result.mesh.faces.len());
}

#[test]
fn borders_of_materials_stay() {
    let mut mesh = grid(32, |_, _| 0.0);
    let line = low(&mesh, 0) + 0.5 * size(&mesh, 0);
    let side = |face: &[u32; 3], positions: &[[f32; 3]]| {
        let x: f32 = face.iter().map(|&v| positions[v as usize][0]).sum();
        u32::from(x / 3.0 > line)
    };
    mesh.materials = Some(mesh.faces.iter().map(|face| 7 + side(face, &mesh.positions)).collect());
    let result = to(&mesh, 4);
    assert_eq!(result.mesh.faces.len(), 4);
    let materials = result.mesh.materials.as_ref().unwrap();
    for (face, material) in result.mesh.faces.iter().zip(materials) {
        assert_eq!(*material, 7 + side(face, &result.mesh.positions));
        for &v in face {
            let x = result.mesh.positions[v as usize][0];
            assert!(if *material == 7 { x <= line + 1e-5 } else { x >= line - 1e-5 });
        }
    }
}

#[test]
fn faults_are_left_out_and_counted() {
    let mut mesh = cube(4);
    let n = mesh.positions.len() as u32;
    mesh.positions.push([f32::NAN, 0.0, 0.0]);
    mesh.faces.push([0, 1, n]);
    mesh.faces.push([0, 0, 1]);
    let first = mesh.faces[5];
    mesh.faces.push([first[1], first[2], first[0]]);
    let result = to(&mesh, 12);
    let dropped = result.report.dropped;
    assert_eq!((dropped.non_finite, dropped.degenerate, dropped.duplicate), (1, 1, 1));
    assert_eq!(result.mesh.faces.len(), 12);
    assert!(check(&result.mesh.as_ref()).is_watertight());
}

#[test]
fn bad_arrays_are_errors() {
    let mut mesh = tetrahedron();
    mesh.faces.push([0, 1, 4]);
    let error = simplify(&mesh.as_ref(), &Options::new(Target::Faces(1)), &mut carry_on).unwrap_err();
    assert_eq!(error, SimplifyError::BadIndex { face: 4, vertex: 4, vertices: 4 });
    let mesh = tetrahedron();
    let short = MeshRef { uvs: Some(&[[0.0, 0.0]]), ..mesh.as_ref() };
    let error = simplify(&short, &Options::new(Target::Faces(1)), &mut carry_on).unwrap_err();
    assert!(matches!(error, SimplifyError::BadLength { found: 1, expected: 4, .. }));
    for target in [Target::Ratio(0.0), Target::Ratio(1.5), Target::Ratio(f64::NAN), Target::Error(-1.0)] {
        let error = simplify(&mesh.as_ref(), &Options::new(target), &mut carry_on).unwrap_err();
        assert!(matches!(error, SimplifyError::BadOption { .. }), "{target:?}");
    }
}

#[test]
fn a_callback_stops_it() {
    let error = simplify(&cube(4).as_ref(), &Options::new(Target::Faces(12)), &mut |_| ControlFlow::Break(()));
    assert_eq!(error.unwrap_err(), SimplifyError::Interrupted);
}

#[test]
fn any_size_and_place() {
    for (size, shift) in [(1e-30, 0.0), (1e30, 0.0), (1.0, 4096.0)] {
        let mesh = moved(&torus(48, 24), |p| p.map(|x| x * size + shift));
        let result = to(&mesh, 300);
        let findings = check(&result.mesh.as_ref());
        assert_eq!(result.mesh.faces.len(), 300, "size {size} at {shift}");
        assert!(findings.is_manifold() && findings.euler_number() == 0, "size {size} at {shift}");
    }
}

#[test]
fn every_method_and_placement() {
    let mesh = torus(64, 32);
    for method in [Method::Quadric, Method::QuadricUnion, Method::ShortestEdge] {
        for placement in [
            Placement::Auto,
            Placement::Probabilistic { sigma: 0.0 },
            Placement::Perturbed,
            Placement::Endpoint,
            Placement::Midpoint,
        ] {
            let options = Options { method, placement, polish: false, ..Options::new(Target::Faces(400)) };
            let result = run(&mesh, &options);
            let findings = check(&result.mesh.as_ref());
            assert_eq!(result.mesh.faces.len(), 400, "{method:?} {placement:?}");
            assert!(findings.is_manifold() && findings.is_sound() && findings.euler_number() == 0);
        }
    }
}

#[test]
fn endpoints_are_places_of_the_input() {
    // Where differences of coordinates are rounded.
    let mesh = moved(&ball(24, shapes::bumpy), |[x, y, z]| [x + 300.0, y - 40.0, z]);
    for method in [Method::Quadric, Method::QuadricUnion, Method::ShortestEdge] {
        let placement = Placement::Endpoint;
        let options = Options { method, placement, polish: false, ..Options::new(Target::Faces(400)) };
        let result = run(&mesh, &options);
        assert_eq!((result.mesh.faces.len(), result.report.cuts), (400, 0));
        assert!(result.mesh.positions.iter().all(|p| mesh.positions.contains(p)), "{method:?}");
    }
}

#[test]
fn one_vertex_far_off_does_no_harm() {
    // Within the numbers that a file may hold, beyond those that squares are taken of.
    for far in [1e17, 1e30, f32::MAX] {
        let mut mesh = torus(24, 12);
        mesh.positions[5][1] = far;
        let result = to(&mesh, 100);
        let findings = check(&result.mesh.as_ref());
        // What is smaller than rounding is left as it is.
        assert_eq!((result.mesh.faces.len(), result.report.turned), (100, 0), "{far}");
        assert!(findings.is_watertight() && findings.is_manifold() && findings.non_finite.count == 0, "{far}");
        let found = shapes::measured(&mesh, &result.mesh, 100);
        assert!(found.diagonal > 0.9 * f64::from(far) && found.largest() < found.diagonal, "{far}: {found:?}");
    }
}

#[test]
fn points_that_meet_stay_apart() {
    // The middles of one sheet's edges are vertices of the other.
    let sheet = moved(&grid(16, |_, _| 0.0), |p| p.map(|x| 16.0 * x));
    let both = joined(&sheet, &moved(&sheet, |[x, y, z]| [x + 0.5, y, z]));
    let before = check(&both.as_ref());
    assert_eq!((before.components, before.non_manifold_vertices.count), (2, 0));
    for faces in [900, 600] {
        let options = Options { method: Method::ShortestEdge, polish: false, ..Options::new(Target::Faces(faces)) };
        let after = check(&run(&both, &options).mesh.as_ref());
        assert_eq!((after.components, after.non_manifold_vertices.count), (2, 0), "{faces}");
        assert!(after.is_manifold() && after.is_sound() && after.boundary_loops == 2, "{faces}");
    }
}
