//! What vertices carry survives, and the same bits come out of any number of threads.
// What is made is measured, never compared bit by bit with another machine's.
#![allow(clippy::disallowed_methods)]

mod shapes;

use etendue_simplify::{Mesh, Options, Simplified, Target, check, simplify};
use shapes::{ball, bumpy, carry_on, grid, measured};

fn run(mesh: &Mesh, faces: usize) -> Simplified {
    simplify(&mesh.as_ref(), &Options::new(Target::Faces(faces)), &mut carry_on).unwrap()
}

/// A bumpy field whose texture coordinates are its x and y, cut in two along the middle: the right half's are shifted by what
/// is given for their y.
fn seamed(shift: impl Fn(f32) -> f32) -> (Mesh, f32) {
    let mut mesh = grid(48, |x, y| 0.05 * (8.0 * x).sin() * (6.0 * y).cos());
    let xs = mesh.positions.iter().map(|p| p[0]);
    let line = 0.5 * (xs.clone().fold(f32::MAX, f32::min) + xs.fold(f32::MIN, f32::max));
    let mut right = vec![u32::MAX; mesh.positions.len()];
    let mut uvs: Vec<[f32; 2]> = mesh.positions.iter().map(|p| [p[0], p[1]]).collect();
    for face in &mut mesh.faces {
        let x: f32 = face.iter().map(|&v| mesh.positions[v as usize][0]).sum();
        if x / 3.0 > line {
            for v in face {
                let to = &mut right[*v as usize];
                if *to == u32::MAX {
                    *to = mesh.positions.len() as u32;
                    let p = mesh.positions[*v as usize];
                    mesh.positions.push(p);
                    uvs.push([p[0] + shift(p[1]), p[1]]);
                }
                *v = *to;
            }
        }
    }
    mesh.uvs = Some(uvs);
    (mesh, line)
}

#[test]
fn texture_coordinates_follow_and_seams_stay() {
    let (mesh, line) = seamed(|_| 5.0);
    let result = run(&mesh, 400);
    // An edge of the border takes one face with it, one inside two.
    assert!((399..=400).contains(&result.mesh.faces.len()));
    let uvs = result.mesh.uvs.as_ref().unwrap();
    for face in &result.mesh.faces {
        let right = face.iter().map(|&v| uvs[v as usize][0]).sum::<f32>() / 3.0 > 2.5;
        for &v in face {
            let (p, uv) = (result.mesh.positions[v as usize], uvs[v as usize]);
            let shift = if right { 5.0 } else { 0.0 };
            assert!((uv[0] - shift - p[0]).abs() < 0.02 && (uv[1] - p[1]).abs() < 0.02, "{p:?} has {uv:?}");
            assert!(if right { p[0] > line - 0.01 } else { p[0] < line + 0.01 }, "{p:?} is over the seam");
        }
    }
    // Welded, the seam has closed without a gap.
    let findings = check(&result.mesh.as_ref());
    assert_eq!(findings.boundary_loops, 1);
    assert!(findings.is_manifold());
}

#[test]
fn both_sides_of_a_seam_that_closes_at_a_point_keep_their_texture() {
    // Half way up both sides have the same texture coordinates: one wedge there, two at its neighbours on the seam.
    let shift = |y: f32| 5.0 * (y - 0.5);
    let (mesh, line) = seamed(shift);
    for (faces, polish) in [(400, false), (120, false), (120, true)] {
        let options = Options { polish, ..Options::new(Target::Faces(faces)) };
        let result = simplify(&mesh.as_ref(), &options, &mut carry_on).unwrap().mesh;
        let uvs = result.uvs.as_ref().unwrap();
        for face in &result.faces {
            let right = face.iter().map(|&v| result.positions[v as usize][0]).sum::<f32>() / 3.0 > line;
            for &v in face {
                let (p, uv) = (result.positions[v as usize], uvs[v as usize]);
                let wanted = p[0] + if right { shift(p[1]) } else { 0.0 };
                assert!((uv[0] - wanted).abs() < 0.1 && (uv[1] - p[1]).abs() < 0.05, "to {faces}: {p:?} has {uv:?}");
            }
        }
    }
}

#[test]
fn normals_and_colours_follow() {
    let mut mesh = ball(48, |_| 1.0);
    mesh.normals = Some(mesh.positions.clone());
    mesh.colors = Some(mesh.positions.iter().map(|p| [0.5 + 0.5 * p[0], 0.5 + 0.5 * p[1], 0.25, 1.0]).collect());
    let result = run(&mesh, 600);
    let (normals, colors) = (result.mesh.normals.as_ref().unwrap(), result.mesh.colors.as_ref().unwrap());
    for ((p, n), c) in result.mesh.positions.iter().zip(normals).zip(colors) {
        let cosine = p.iter().zip(n).map(|(p, n)| p * n).sum::<f32>();
        assert!(cosine > 0.99, "{p:?} has normal {n:?}");
        assert!((c[0] - 0.5 - 0.5 * p[0]).abs() < 0.06 && (c[2] - 0.25).abs() < 0.01 && c[3] > 0.99, "{p:?} has {c:?}");
    }
}

#[test]
fn same_bits_for_any_number_of_threads() {
    // More than one block.
    let mesh = ball(80, bumpy);
    let results: Vec<Mesh> = [1, 2, 3, 7]
        .into_iter()
        .map(|threads| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| run(&mesh, 1500).mesh)
        })
        .collect();
    assert!(results.iter().all(|result| *result == results[0]));
}

#[test]
fn errors_on_a_bumpy_ball() {
    let mesh = ball(80, bumpy);
    for (faces, rms, largest) in [(4000, 1.6e-4, 1.1e-3), (1000, 5.2e-4, 3.5e-3)] {
        let result = run(&mesh, faces);
        let findings = check(&result.mesh.as_ref());
        assert_eq!(result.mesh.faces.len(), faces);
        assert!(findings.is_watertight() && findings.is_sound() && findings.euler_number() == 2);
        let distance = measured(&mesh, &result.mesh, 20_000);
        println!(
            "{faces}: rms {:.2e} largest {:.2e}",
            distance.rms() / distance.diagonal,
            distance.largest() / distance.diagonal
        );
        assert!(distance.rms() < rms * distance.diagonal && distance.largest() < largest * distance.diagonal);
    }
}

#[test]
fn a_seam_that_ends_inside_keeps_its_length() {
    // From the left border to the middle of a flat square: vertices above it are others than those below.
    let n = 16;
    let mut mesh = grid(n, |_, _| 0.0);
    let row = n / 2;
    let mut uvs: Vec<[f32; 2]> = mesh.positions.iter().map(|p| [p[0], p[1]]).collect();
    for column in 0..row {
        let old = row * (n + 1) + column;
        let new = mesh.positions.len() as u32;
        mesh.positions.push(mesh.positions[old as usize]);
        uvs.push([mesh.positions[old as usize][0], 0.8]);
        for face in mesh.faces.iter_mut().skip((2 * n * row) as usize) {
            face.iter_mut().filter(|v| **v == old).for_each(|v| *v = new);
        }
    }
    mesh.uvs = Some(uvs);
    let options = Options { polish: false, ..Options::new(Target::Faces(24)) };
    let result = simplify(&mesh.as_ref(), &options, &mut carry_on).unwrap().mesh;
    // Where two vertices are at one place.
    let place = |v: usize| result.positions[v].map(f32::to_bits);
    let double: Vec<f32> = (0..result.positions.len())
        .filter(|&v| (0..result.positions.len()).any(|w| w != v && place(w) == place(v)))
        .map(|v| result.positions[v][0])
        .collect();
    assert!(double.contains(&0.0), "{double:?}");
    assert!(result.positions.contains(&[0.5, 0.5, 0.0]));
    // From the end of the seam a face on either side goes to a vertex of its own at the seam.
    let end = result.positions.iter().position(|p| *p == [0.5, 0.5, 0.0]).unwrap() as u32;
    let at_seam = |v: u32| {
        double.contains(&result.positions[v as usize][0]) && (result.positions[v as usize][1] - 0.5).abs() < 1e-3
    };
    let mut others: Vec<u32> =
        result.faces.iter().filter(|face| face.contains(&end)).flatten().copied().filter(|&v| at_seam(v)).collect();
    others.sort_unstable();
    others.dedup();
    assert_eq!(others.len(), 2, "{double:?} {:?}", result.positions);
}
