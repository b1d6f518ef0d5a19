//! Polish brings the surface nearer, and spoils nothing.
#![allow(clippy::disallowed_methods)]

mod shapes;

use std::ops::ControlFlow;

use etendue_simplify::{Distance, Mesh, Options, SimplifyError, Stage, Target, check, simplify};
use shapes::*;

const SAMPLES: usize = 60_000;

/// Simplified without and with polish.
fn both(mesh: &Mesh, faces: usize, change: impl Fn(&mut Options)) -> [Mesh; 2] {
    [false, true].map(|polish| {
        let mut options = Options { polish, ..Options::new(Target::Faces(faces)) };
        change(&mut options);
        simplify(&mesh.as_ref(), &options, &mut carry_on).unwrap().mesh
    })
}

fn distances(mesh: &Mesh, pair: &[Mesh; 2]) -> [Distance; 2] {
    [0, 1].map(|i| measured(mesh, &pair[i], SAMPLES))
}

fn normal(mesh: &Mesh, face: [u32; 3]) -> [f64; 3] {
    let [a, b, c] = face.map(|v| mesh.positions[v as usize].map(f64::from));
    let (p, q): ([f64; 3], [f64; 3]) = ([0, 1, 2].map(|i| b[i] - a[i]), [0, 1, 2].map(|i| c[i] - a[i]));
    let n = [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2], p[0] * q[1] - p[1] * q[0]];
    let length = n.iter().map(|x| x * x).sum::<f64>().sqrt();
    n.map(|x| x / length)
}

#[test]
fn smooth_shapes_come_nearer() {
    for (name, mesh, faces, gain) in [
        ("bumps", ball(60, bumpy), 1000, 0.8),
        ("torus", torus(160, 80), 600, 0.8),
        ("ball", ball(50, |_| 1.0), 400, 0.8),
    ] {
        let pair = both(&mesh, faces, |_| ());
        let [rough, fine] = distances(&mesh, &pair);
        println!(
            "{name}: rms {:.3e} -> {:.3e}, largest {:.3e} -> {:.3e}",
            rough.rms(),
            fine.rms(),
            rough.largest(),
            fine.largest()
        );
        assert!(fine.rms() < gain * rough.rms(), "{name}: {} {}", rough.rms(), fine.rms());
        assert!(fine.largest() < 1.01 * rough.largest(), "{name}: {} {}", rough.largest(), fine.largest());
        assert_eq!(pair[0].faces, pair[1].faces);
        let found = check(&pair[1].as_ref());
        assert!(found.is_sound() && found.is_watertight() && found.is_manifold(), "{name}: {found:?}");
    }
}

#[test]
fn no_face_turns_over() {
    let mesh = ball(60, bumpy);
    let [rough, fine] = both(&mesh, 300, |_| ());
    let mut moved = 0;
    for &face in &fine.faces {
        let (before, now) = (normal(&rough, face), normal(&fine, face));
        let cosine: f64 = (0..3).map(|i| before[i] * now[i]).sum();
        assert!(cosine >= 0.5 - 1e-6, "{cosine}");
        moved += usize::from(cosine < 0.999_999);
    }
    assert!(moved > 250);
}

#[test]
fn flat_faces_and_creases_stay() {
    // The sides of a box are met exactly before; edges and corners must not be rounded off.
    let grid = grid(12, |_, _| 0.0);
    let side = |map: &dyn Fn([f32; 3]) -> [f32; 3]| moved(&grid, map);
    let mut block = side(&|[x, y, _]| [x, y, 1.0]);
    for other in [
        side(&|[x, y, _]| [y, x, 0.0]),
        side(&|[x, y, _]| [1.0, x, y]),
        side(&|[x, y, _]| [0.0, y, x]),
        side(&|[x, y, _]| [y, 1.0, x]),
        side(&|[x, y, _]| [x, 0.0, y]),
    ] {
        block = joined(&block, &other);
    }
    assert!(check(&block.as_ref()).is_watertight());
    let pair = both(&block, 60, |_| ());
    let [rough, fine] = distances(&block, &pair);
    println!("block: largest {:.3e} -> {:.3e}", rough.largest(), fine.largest());
    assert!(fine.largest() < 2e-5 && fine.largest() < 1e-6 + 1.05 * rough.largest(), "{fine:?}");
    // A drum: smooth along its side, sharp at both rims.
    let drum = drum(96, 24);
    let pair = both(&drum, 120, |_| ());
    let [rough, fine] = distances(&drum, &pair);
    println!(
        "drum: rms {:.3e} -> {:.3e}, largest {:.3e} -> {:.3e}",
        rough.rms(),
        fine.rms(),
        rough.largest(),
        fine.largest()
    );
    assert!(fine.rms() <= rough.rms() * 1.001 && fine.largest() <= rough.largest() * 1.05);
    let rims = |mesh: &Mesh| mesh.positions.iter().filter(|p| p[2].abs() < 0.003 || (p[2] - 1.0).abs() < 0.003).count();
    assert_eq!(rims(&pair[0]), rims(&pair[1]), "vertices leave the rims");
}

#[test]
fn what_is_fixed_stays_fixed() {
    let mesh = grid(40, |x, y| 0.1 * (7.0 * x).sin() * (5.0 * y).cos());
    let locked = vec![0, 20 * 41 + 20, 30 * 41 + 7];
    let keep = locked.clone();
    let pair = both(&mesh, 200, move |options| {
        options.keep_boundary = true;
        options.locked = keep.clone();
    });
    for mesh_out in &pair {
        for &v in &locked {
            assert!(mesh_out.positions.contains(&mesh.positions[v as usize]));
        }
    }
    let rim = |mesh: &Mesh| {
        let mut rim: Vec<[u32; 3]> = mesh
            .positions
            .iter()
            .filter(|[x, y, _]| [0.0, 1.0].contains(x) || [0.0, 1.0].contains(y))
            .map(|p| p.map(|x| (x + 0.0).to_bits()))
            .collect();
        rim.sort_unstable();
        rim
    };
    assert_eq!(rim(&pair[0]), rim(&pair[1]));
    assert_eq!(rim(&pair[1]), rim(&mesh));
    let [rough, fine] = distances(&mesh, &pair);
    assert!(fine.rms() < rough.rms());
}

#[test]
fn attributes_follow() {
    // Texture coordinates are the place seen from above, so that they can be told from the positions.
    let bare = grid(60, |x, y| 0.1 * (7.0 * x).sin() * (5.0 * y).cos());
    let uvs = bare.positions.iter().map(|p| [p[0], p[1]]).collect();
    let colors = bare.positions.iter().map(|p| [p[0], p[1], 0.5, 1.0]).collect();
    let steep = |[x, y, _]: [f32; 3]| {
        let (x, y) = (f64::from(x), f64::from(y));
        let slope = [-0.7 * (7.0 * x).cos() * (5.0 * y).cos(), 0.5 * (7.0 * x).sin() * (5.0 * y).sin(), 1.0];
        let length = slope.iter().map(|s| s * s).sum::<f64>().sqrt();
        slope.map(|s| s / length)
    };
    let normals = bare.positions.iter().map(|&p| steep(p).map(|x| x as f32)).collect();
    let mesh = Mesh { uvs: Some(uvs), colors: Some(colors), normals: Some(normals), ..bare };
    let [rough, fine] = both(&mesh, 300, |_| ());
    assert!(rough.positions != fine.positions);
    let off = |mesh: &Mesh| {
        let off = |(p, uv): (&[f32; 3], &[f32; 2])| (p[0] - uv[0]).abs().max((p[1] - uv[1]).abs());
        mesh.positions.iter().zip(mesh.uvs.as_ref().unwrap()).map(off).fold(0.0, f32::max)
    };
    assert!(off(&fine) <= off(&rough) + 2e-3, "{} {}", off(&rough), off(&fine));
    for (uv, color) in fine.uvs.as_ref().unwrap().iter().zip(fine.colors.as_ref().unwrap()) {
        assert!((uv[0].clamp(0.0, 1.0) - color[0]).abs() < 0.01 && (uv[1].clamp(0.0, 1.0) - color[1]).abs() < 0.01);
    }
    let bent = |mesh: &Mesh| {
        let cosines = mesh.positions.iter().zip(mesh.normals.as_ref().unwrap()).map(|(&p, n)| {
            let steep = steep(p);
            (0..3).map(|i| steep[i] * f64::from(n[i])).sum::<f64>()
        });
        cosines.sum::<f64>() / mesh.positions.len() as f64
    };
    println!("cosine of normals {} -> {}", bent(&rough), bent(&fine));
    assert!(bent(&fine) > 0.99);
}

#[test]
fn threads_leave_no_trace() {
    let mesh = ball(40, bumpy);
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| both(&mesh, 500, |_| ())[1].clone())
    };
    assert!(with(1) == with(3));
}

#[test]
fn polish_can_be_interrupted() {
    let mesh = ball(20, bumpy);
    let stop = &mut |progress: etendue_simplify::Progress| match progress.stage {
        Stage::Polish => ControlFlow::Break(()),
        _ => ControlFlow::Continue(()),
    };
    let result = simplify(&mesh.as_ref(), &Options::new(Target::Faces(200)), stop);
    assert_eq!(result.unwrap_err(), SimplifyError::Interrupted);
}

#[test]
fn bounds_on_the_distance_hold() {
    let mesh = ball(24, bumpy);
    let mut faces = Vec::new();
    for bound in [0.01, 0.05] {
        let options = Options { seed: 5, ..Options::new(Target::Error(bound)) };
        let found = simplify(&mesh.as_ref(), &options, &mut carry_on).unwrap();
        let said = found.report.distance.unwrap();
        assert!(said.largest() <= bound * (1.0 + 1e-6), "{said:?}");
        // A denser measure finds hardly more.
        let denser = measured(&mesh, &found.mesh, 300_000);
        assert!(denser.largest() <= 1.02 * bound, "{} {bound}", denser.largest());
        let count = found.mesh.faces.len();
        println!("within {bound}: {count} faces");
        assert_eq!(count, found.report.faces_out);
        // Considerably fewer do not do.
        let fewer = Options { target: Target::Faces(count * 17 / 20), ..options };
        let fewer = simplify(&mesh.as_ref(), &fewer, &mut carry_on).unwrap().mesh;
        assert!(measured(&mesh, &fewer, 200_000).largest() > bound);
        faces.push(count);
    }
    assert!(faces.windows(2).all(|pair| pair[1] < pair[0]) && faces[0] < mesh.faces.len());
}

#[test]
fn bounds_at_their_ends() {
    let mesh = ball(12, bumpy);
    let to = |mesh: &Mesh, bound| simplify(&mesh.as_ref(), &Options::new(Target::Error(bound)), &mut carry_on).unwrap();
    assert_eq!(to(&mesh, 0.0).mesh.faces.len(), mesh.faces.len());
    let least = to(&mesh, 100.0);
    assert!(least.mesh.faces.len() <= 8 && least.report.distance.is_some());
    let flat = to(&grid(20, |_, _| 0.0), 1e-3);
    assert!(flat.mesh.faces.len() <= 4, "{}", flat.mesh.faces.len());
    assert_eq!(to(&Mesh::default(), 0.1).report.distance, None);
}

#[test]
fn sizes_leave_no_trace() {
    let mesh = ball(16, bumpy);
    let usual = both(&mesh, 200, |_| ());
    for exponent in [-100, 120] {
        let size = libm::exp2(f64::from(exponent)) as f32;
        let sized = |mesh: &Mesh| moved(mesh, |p| p.map(|x| x * size));
        assert!(both(&sized(&mesh), 200, |_| ()) == [0, 1].map(|i| sized(&usual[i])), "2^{exponent}");
    }
}

#[test]
fn bounds_have_the_unit_of_the_mesh() {
    let mesh = ball(16, bumpy);
    let bound = |exponent: i32| {
        let size = libm::exp2(f64::from(exponent));
        let sized = moved(&mesh, |p| p.map(|x| (f64::from(x) * size) as f32));
        let options = Options { polish: false, fast: true, ..Options::new(Target::Error(0.05 * size)) };
        let found = simplify(&sized.as_ref(), &options, &mut carry_on).unwrap();
        (found.mesh.faces.len(), found.report.distance.unwrap().largest() / size)
    };
    let (usual, large) = (bound(0), bound(60));
    assert!(usual.0 == large.0 && (large.1 / usual.1 - 1.0).abs() < 1e-6 && usual.1 <= 0.05, "{usual:?} {large:?}");
}
