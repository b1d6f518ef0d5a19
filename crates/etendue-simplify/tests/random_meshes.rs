//! Ugly input through every option: nothing crashes, what was watertight stays so, and no fault is added. A fixed sample; ten
//! thousand with `ETENDUE_PROVE=1`.
// What is made is measured, never compared bit by bit with another machine's.
#![allow(clippy::disallowed_methods)]

mod shapes;

use etendue_simplify::{Mesh, Method, Options, Placement, Target, check, simplify};
use etendue_testkit::Rng;
use shapes::{carry_on, grid, joined, moved, torus};

fn below(rng: &mut Rng, n: usize) -> usize {
    ((rng.f64() * n as f64) as usize).min(n - 1)
}

/// Grids with holes, glued at random, with faults.
fn random_mesh(rng: &mut Rng) -> Mesh {
    let n = 2 + below(rng, 9) as u32;
    let rough = 0.3 * rng.f64();
    let mut mesh = if rng.f64() < 0.3 { torus(3 + n, 3 + n / 2) } else { grid(n, |_, _| 0.0) };
    mesh = moved(&mesh, |p| p.map(|x| x + (rough * (rng.f64() - 0.5)) as f32 * 0.3));
    if rng.f64() < 0.3 {
        let second = moved(&mesh, |p| [p[0] + 0.5, p[1], p[2] + 0.1]);
        mesh = joined(&mesh, &second);
    }
    let holes = rng.f64() * rng.f64() * 0.4;
    if rng.f64() < 0.5 {
        mesh.faces.retain(|_| rng.f64() >= holes);
    }
    let count = mesh.positions.len();
    if rng.f64() < 0.5 {
        // Glue: one vertex instead of another.
        for _ in 0..below(rng, 6) {
            let (from, to) = (below(rng, count) as u32, below(rng, count) as u32);
            mesh.faces.as_flattened_mut().iter_mut().filter(|v| **v == from).for_each(|v| *v = to);
        }
    }
    if rng.f64() < 0.5 {
        for _ in 0..below(rng, 8) {
            let face = [0; 3].map(|_| below(rng, count) as u32);
            mesh.faces.push(face);
        }
        for _ in 0..below(rng, 4) {
            let (from, to) = (below(rng, count), below(rng, count));
            mesh.positions[to] = mesh.positions[from];
        }
        if rng.f64() < 0.3 {
            let v = below(rng, count);
            mesh.positions[v][0] = f32::INFINITY;
        }
    }
    if rng.f64() < 0.4 {
        mesh.uvs = Some(mesh.positions.iter().map(|p| [p[0], (p[1] * 3.0).floor()]).collect());
    }
    if rng.f64() < 0.3 {
        mesh.normals = Some(mesh.positions.iter().map(|_| [0.0, 0.0, 1.0]).collect());
    }
    if rng.f64() < 0.3 {
        mesh.colors = Some(mesh.positions.iter().map(|_| [rng.f64() as f32, 0.0, 1.0, 1.0]).collect());
    }
    if rng.f64() < 0.3 {
        mesh.materials = Some(mesh.faces.iter().map(|_| below(rng, 2) as u32).collect());
    }
    mesh
}

fn random_options(rng: &mut Rng, mesh: &Mesh) -> Options {
    let mut options = Options::new(match below(rng, 4) {
        0 => Target::Ratio(0.05 + 0.9 * rng.f64()),
        1 => Target::Faces(0),
        _ => Target::Faces(below(rng, mesh.faces.len().max(1))),
    });
    options.method = [Method::Quadric, Method::Quadric, Method::QuadricUnion, Method::ShortestEdge][below(rng, 4)];
    options.placement = [
        Placement::Auto,
        Placement::Probabilistic { sigma: 0.1 },
        Placement::Perturbed,
        Placement::Endpoint,
        Placement::Midpoint,
    ][below(rng, 5)];
    options.keep_boundary = rng.f64() < 0.2;
    options.keep_topology = rng.f64() < 0.3;
    options.fast = rng.f64() < 0.2;
    options.polish = rng.f64() < 0.5;
    options.seed = below(rng, 1000) as u64;
    options.keep.uvs = rng.f64() < 0.8;
    options.locked = (0..below(rng, 5)).map(|_| below(rng, mesh.positions.len() + 3) as u32).collect();
    options
}

#[test]
fn nothing_breaks() {
    let count = if std::env::var_os("ETENDUE_PROVE").is_some() { 10_000 } else { 400 };
    let mut collapses = 0;
    for seed in 0..count {
        let mut rng = Rng::new(seed);
        let mesh = random_mesh(&mut rng);
        let options = random_options(&mut rng, &mesh);
        let before = check(&mesh.as_ref());
        let result =
            simplify(&mesh.as_ref(), &options, &mut carry_on).unwrap_or_else(|error| panic!("{seed}: {error}"));
        let after = check(&result.mesh.as_ref());
        let report = result.report;
        collapses += report.collapses;
        assert_eq!(report.faces_out, result.mesh.faces.len());
        let bad = [after.bad_indices.count, after.non_finite.count, after.collapsed.count];
        assert_eq!(bad, [0; 3], "{seed}: faces that are none");
        assert!(after.flat.count <= before.flat.count, "{seed}: {} flat, were {}", after.flat.count, before.flat.count);
        assert!(
            after.non_manifold_edges.count <= before.non_manifold_edges.count,
            "{seed}: {} non-manifold edges, were {}",
            after.non_manifold_edges.count,
            before.non_manifold_edges.count
        );
        if before.is_watertight() && before.is_manifold() {
            assert!(after.is_watertight() && after.is_manifold(), "{seed}: no longer watertight");
        }
        assert!(after.boundary_loops <= before.boundary_loops || !before.is_manifold(), "{seed}: a hole was torn");
        let wanted = match options.target {
            Target::Faces(faces) => faces,
            Target::Ratio(ratio) => (ratio * mesh.faces.len() as f64) as usize,
            Target::Error(_) => unreachable!("not among the options"),
        };
        assert_eq!(report.stopped.is_some(), report.faces_out > wanted, "{seed}: {report:?}, wanted {wanted}");
    }
    assert!(collapses > 20 * count as usize, "{collapses} collapses are no test");
}
