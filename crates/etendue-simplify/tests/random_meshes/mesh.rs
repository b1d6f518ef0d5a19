//! Meshes as nobody wants them.

use etendue_simplify::Mesh;
use etendue_testkit::Rng;

use crate::shapes::{ball, drum, grid, joined, mesh_of, moved, torus};

/// From 0 to below `n`, which is not 0.
pub fn below(rng: &mut Rng, n: usize) -> usize {
    ((rng.f64() * n as f64) as usize).min(n - 1)
}

/// Grids with holes, closed surfaces and boxes of flat faces; glued at random, with faults, of any size and place.
pub fn random_mesh(rng: &mut Rng, large: bool) -> Mesh {
    let mut mesh = surface(rng, large);
    let (rough, size) = (0.3 * rng.f64(), 1.0 / mesh.faces.len() as f64);
    // A share stays exact: planes, right angles, equal lengths.
    if rng.f64() < 0.7 {
        let noise = 3.0 * rough * size.sqrt();
        mesh = moved(&mesh, |p| p.map(|x| x + (noise * (rng.f64() - 0.5)) as f32));
    }
    if rng.f64() < 0.3 {
        let second = moved(&mesh, |p| [p[0] + 0.5, p[1], p[2] + 0.1]);
        mesh = joined(&mesh, &second);
    }
    let holes = rng.f64() * rng.f64() * 0.4;
    if rng.f64() < 0.4 {
        mesh.faces.retain(|_| rng.f64() >= holes);
    }
    if rng.f64() < 0.4 {
        glue(rng, &mut mesh);
    }
    if rng.f64() < 0.4 {
        mar(rng, &mut mesh);
    }
    attributes(rng, &mut mesh);
    if rng.f64() < 0.1 {
        mesh = soup(&mesh);
    }
    match below(rng, 12) {
        0 => moved(&mesh, |p| p.map(|x| x * 1e-30)),
        1 => moved(&mesh, |p| p.map(|x| x * 1e14)),
        2 => moved(&mesh, |[x, y, z]| [x + 4096.0, y - 100.0, z]),
        _ => mesh,
    }
}

fn surface(rng: &mut Rng, large: bool) -> Mesh {
    let n = if large { 100 + below(rng, 60) as u32 } else { 2 + below(rng, 9) as u32 };
    match below(rng, 8) {
        0 | 1 => torus(3 + n, 3 + n / 2),
        2 => ball(1 + n / 2, |_| 1.0),
        3 => drum(3 + n, 1 + n / 3),
        4 => stairs(rng, 1 + n / 4),
        _ => grid(n, |_, _| 0.0),
    }
}

/// Flat squares in three directions, a closed surface of many right angles: a block of unit cubes, some of them taken away.
fn stairs(rng: &mut Rng, n: u32) -> Mesh {
    let n = n.min(8) as i32;
    let side = n as usize;
    let filled: Vec<bool> = (0..side * side * side).map(|_| rng.f64() < 0.8).collect();
    let is_filled = |p: [i32; 3]| {
        let inside = p.iter().all(|x| (0..n).contains(x));
        inside && filled[(p[0] + n * (p[1] + n * p[2])) as usize]
    };
    let mut mesh = Mesh::default();
    let mut numbers = std::collections::BTreeMap::new();
    for cube in 0..n * n * n {
        let at = [cube % n, cube / n % n, cube / n / n];
        if !is_filled(at) {
            continue;
        }
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beside = at;
                beside[axis] += 2 * side - 1;
                if is_filled(beside) {
                    continue;
                }
                let corner = |u: i32, v: i32| {
                    let mut p = at;
                    p[axis] += side;
                    p[(axis + 1) % 3] += u;
                    p[(axis + 2) % 3] += v;
                    p
                };
                let square = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)].map(|p| {
                    *numbers.entry(p).or_insert_with(|| {
                        mesh.positions.push(p.map(|x| x as f32 / n as f32));
                        mesh.positions.len() as u32 - 1
                    })
                });
                let [a, b, c, d] = square;
                let faces = if side == 1 { [[a, b, c], [a, c, d]] } else { [[a, c, b], [a, d, c]] };
                mesh.faces.extend(faces);
            }
        }
    }
    if mesh.faces.is_empty() { grid(2, |_, _| 0.0) } else { mesh }
}

/// One vertex instead of another, at random places.
fn glue(rng: &mut Rng, mesh: &mut Mesh) {
    let count = mesh.positions.len();
    for _ in 0..below(rng, 6) {
        let (from, to) = (below(rng, count) as u32, below(rng, count) as u32);
        mesh.faces.as_flattened_mut().iter_mut().filter(|v| **v == from).for_each(|v| *v = to);
    }
}

/// Faces across, faces twice and the other way round, needles, equal places and places that are none.
fn mar(rng: &mut Rng, mesh: &mut Mesh) {
    let count = mesh.positions.len();
    for _ in 0..below(rng, 8) {
        let face = [0; 3].map(|_| below(rng, count) as u32);
        mesh.faces.push(face);
    }
    for _ in 0..below(rng, 4) {
        if let Some(&[a, b, c]) = mesh.faces.get(below(rng, mesh.faces.len().max(1))) {
            mesh.faces.push([[b, c, a], [a, c, b]][below(rng, 2)]);
        }
    }
    for _ in 0..below(rng, 4) {
        let (from, to) = (below(rng, count), below(rng, count));
        mesh.positions[to] = mesh.positions[from];
    }
    for _ in 0..below(rng, 3) {
        // Onto the line between two others: a face without area.
        if let Some(&[a, b, c]) = mesh.faces.get(below(rng, mesh.faces.len().max(1))) {
            let [p, q] = [a, b].map(|v| mesh.positions[v as usize]);
            mesh.positions[c as usize] = [0, 1, 2].map(|i| 0.5 * p[i] + 0.5 * q[i]);
        }
    }
    if rng.f64() < 0.3 {
        let v = below(rng, count);
        mesh.positions[v][below(rng, 3)] = [f32::INFINITY, f32::NAN, f32::MAX][below(rng, 3)];
    }
}

fn attributes(rng: &mut Rng, mesh: &mut Mesh) {
    if rng.f64() < 0.4 {
        // In strips: each has its own seam only where vertices differ, so within a face they may tear.
        mesh.uvs = Some(mesh.positions.iter().map(|p| [p[0], (p[1] * 3.0).floor()]).collect());
        if rng.f64() < 0.3 {
            split(rng, mesh);
        }
    }
    if rng.f64() < 0.3 {
        mesh.normals = Some(mesh.positions.iter().map(|_| [0.0, 0.0, 1.0]).collect());
    }
    if rng.f64() < 0.3 {
        mesh.colors = Some(mesh.positions.iter().map(|_| [rng.f64() as f32, 0.0, 1.0, 1.0]).collect());
    }
    match below(rng, 6) {
        0 => mesh.materials = Some(mesh.faces.iter().map(|_| below(rng, 2) as u32).collect()),
        1 | 2 => {
            let third = |face: &[u32; 3]| (mesh.positions[face[0] as usize][1] * 3.0) as u32 % 3;
            mesh.materials = Some(mesh.faces.iter().map(third).collect());
        }
        _ => {}
    }
}

/// Cuts the texture along a line: faces beyond it get vertices of their own there.
fn split(rng: &mut Rng, mesh: &mut Mesh) {
    let line = rng.f64() as f32;
    let mut second = vec![u32::MAX; mesh.positions.len()];
    let Some(uvs) = &mut mesh.uvs else { return };
    for face in &mut mesh.faces {
        if face.iter().all(|&v| mesh.positions[v as usize][0] >= line) {
            for v in face {
                let new = &mut second[*v as usize];
                if *new == u32::MAX {
                    *new = mesh.positions.len() as u32;
                    let (p, [s, t]) = (mesh.positions[*v as usize], uvs[*v as usize]);
                    mesh.positions.push(p);
                    uvs.push([s + 7.0, t]);
                }
                *v = *new;
            }
        }
    }
}

/// Every corner a vertex of its own, as in STL files.
fn soup(mesh: &Mesh) -> Mesh {
    let corners = mesh.faces.as_flattened();
    fn at<T: Copy>(list: &[T], corners: &[u32]) -> Vec<T> {
        corners.iter().map(|&v| list[v as usize]).collect()
    }
    let faces = (0..mesh.faces.len() as u32).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    Mesh {
        normals: mesh.normals.as_ref().map(|list| at(list, corners)),
        uvs: mesh.uvs.as_ref().map(|list| at(list, corners)),
        colors: mesh.colors.as_ref().map(|list| at(list, corners)),
        materials: mesh.materials.clone(),
        ..mesh_of(at(&mesh.positions, corners), faces)
    }
}
