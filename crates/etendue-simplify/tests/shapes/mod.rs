//! Meshes for measuring.
#![allow(dead_code, clippy::disallowed_methods)]

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};
use std::ops::ControlFlow;

use etendue_simplify::{Distance, Mesh, MeshRef, Progress, distance};

pub fn carry_on(_: Progress) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

pub fn mesh_of(positions: Vec<[f32; 3]>, faces: Vec<[u32; 3]>) -> Mesh {
    Mesh { positions, faces, ..Mesh::default() }
}

pub fn measured(a: &Mesh, b: &Mesh, samples: usize) -> Distance {
    distance(&a.as_ref(), &b.as_ref(), samples, 7, &mut carry_on).unwrap()
}

/// A sphere from an octahedron, each face cut into `n` by `n`; the radius is a function of the direction.
pub fn ball(n: u32, radius: impl Fn([f64; 3]) -> f64) -> Mesh {
    let mut numbers = BTreeMap::new();
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    let n = n as i64;
    for signs in 0..8 {
        let sign = [0, 1, 2].map(|bit| if signs >> bit & 1 == 0 { 1 } else { -1 });
        let mut at = |i: i64, j: i64| {
            let key = [sign[0] * i, sign[1] * j, sign[2] * (n - i - j)];
            *numbers.entry(key).or_insert_with(|| {
                // Angles rather than coordinates, for faces of about one size.
                let p = key.map(|k| (k as f64 / n as f64 * PI / 2.0).sin());
                let length = p.iter().map(|x| x * x).sum::<f64>().sqrt();
                let p = p.map(|x| x / length);
                positions.push(p.map(|x| (x * radius(p)) as f32));
                positions.len() as u32 - 1
            })
        };
        for i in 0..n {
            for j in 0..n - i {
                let mut new = vec![[at(i, j), at(i + 1, j), at(i, j + 1)]];
                if i + j < n - 1 {
                    new.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
                }
                let turned = sign.iter().product::<i64>() < 0;
                faces.extend(new.into_iter().map(|[a, b, c]| if turned { [a, c, b] } else { [a, b, c] }));
            }
        }
    }
    mesh_of(positions, faces)
}

/// The radius of a sphere with bumps.
pub fn bumpy([x, y, z]: [f64; 3]) -> f64 {
    1.0 + 0.1 * (5.0 * x).sin() * (4.0 * y + 1.0).cos() * (6.0 * z).sin()
}

/// A torus around z with radii 1 and 0.4.
pub fn torus(around: u32, across: u32) -> Mesh {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let (a, b) = (TAU * f64::from(i) / f64::from(around), TAU * f64::from(j) / f64::from(across));
            let r = 1.0 + 0.4 * b.cos();
            positions.push([(r * a.cos()) as f32, (r * a.sin()) as f32, (0.4 * b.sin()) as f32]);
            let at = |i: u32, j: u32| (i % around) * across + j % across;
            let (p, q, r, s) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            faces.extend([[p, q, r], [p, r, s]]);
        }
    }
    mesh_of(positions, faces)
}

/// A square grid of `n` by `n` squares, from 0 to 1 in x and y.
pub fn grid(n: u32, height: impl Fn(f64, f64) -> f64) -> Mesh {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for i in 0..=n {
        for j in 0..=n {
            let (x, y) = (f64::from(j) / f64::from(n), f64::from(i) / f64::from(n));
            positions.push([x as f32, y as f32, height(x, y) as f32]);
            if i < n && j < n {
                let p = i * (n + 1) + j;
                faces.extend([[p, p + 1, p + n + 2], [p, p + n + 2, p + n + 1]]);
            }
        }
    }
    mesh_of(positions, faces)
}

/// A cylinder along z with flat ends: rings of `around` vertices, `along` of them on the side.
pub fn drum(around: u32, along: u32) -> Mesh {
    let mut positions = Vec::new();
    let mut faces = Vec::new();
    for i in 0..=along {
        for j in 0..around {
            let a = TAU * f64::from(j) / f64::from(around);
            positions.push([a.cos() as f32, a.sin() as f32, (f64::from(i) / f64::from(along)) as f32]);
            if i < along {
                let (p, q) = (i * around + j, i * around + (j + 1) % around);
                faces.extend([[p, q, q + around], [p, q + around, p + around]]);
            }
        }
    }
    for (ring, z) in [(0, 0.0), (along * around, 1.0)] {
        positions.push([0.0, 0.0, z]);
        let middle = positions.len() as u32 - 1;
        for j in 0..around {
            let (p, q) = (ring + j, ring + (j + 1) % around);
            faces.push(if ring == 0 { [middle, q, p] } else { [middle, p, q] });
        }
    }
    mesh_of(positions, faces)
}

/// Both meshes in one.
pub fn joined(a: &Mesh, b: &Mesh) -> Mesh {
    let shift = a.positions.len() as u32;
    let faces = b.faces.iter().map(|face| face.map(|v| v + shift));
    mesh_of([&a.positions[..], &b.positions].concat(), a.faces.iter().copied().chain(faces).collect())
}

pub fn moved(mesh: &Mesh, map: impl FnMut([f32; 3]) -> [f32; 3]) -> Mesh {
    Mesh { positions: mesh.positions.iter().copied().map(map).collect(), ..mesh.clone() }
}

pub fn borrowed<'a>(positions: &'a [[f32; 3]], faces: &'a [[u32; 3]]) -> MeshRef<'a> {
    MeshRef { positions, faces, normals: None, uvs: None, colors: None, materials: None }
}
