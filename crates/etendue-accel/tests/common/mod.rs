//! Random numbers, generated shapes and the size of the tests.
#![allow(dead_code, clippy::disallowed_methods)]

use std::sync::Arc;

use etendue_accel::{
    Accelerator, AcceleratorKind, Geometry, Instance, Isa, Motion, Place, PrimitiveId, Ray, RigidKey, Sphere,
    Transform, TriangleMesh, World,
};

/// Rays for a test: ten million if `ETENDUE_PROVE` is 1, else a few.
pub fn ray_count() -> usize {
    if std::env::var("ETENDUE_PROVE").is_ok_and(|value| value == "1") { 10_000_000 } else { 100_000 }
}

/// SplitMix64 (Steele, Lea, Flood 2014).
#[derive(Clone)]
pub struct Rng(pub u64);

impl Rng {
    pub fn word(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let z = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    pub fn below(&mut self, n: usize) -> usize {
        ((u128::from(self.word()) * n as u128) >> 64) as usize
    }

    /// In [0, 1).
    pub fn unit(&mut self) -> f64 {
        (self.word() >> 11) as f64 / (1_u64 << 53) as f64
    }

    pub fn range(&mut self, low: f32, high: f32) -> f32 {
        (f64::from(low) + self.unit() * (f64::from(high) - f64::from(low))) as f32
    }

    pub fn point(&mut self, reach: f32) -> [f32; 3] {
        std::array::from_fn(|_| self.range(-reach, reach))
    }

    pub fn direction(&mut self) -> [f32; 3] {
        loop {
            let p = self.point(1.0);
            let length = p.iter().map(|x| x * x).sum::<f32>().sqrt();
            if length > 0.1 && length < 1.0 {
                return p.map(|x| x / length);
            }
        }
    }

    pub fn pick<'a, T>(&mut self, from: &'a [T]) -> &'a T {
        &from[self.below(from.len())]
    }

    pub fn chance(&mut self, p: f64) -> bool {
        self.unit() < p
    }

    /// Rotation, stretch and shear.
    pub fn linear(&mut self) -> [[f32; 3]; 3] {
        loop {
            let m = [self.point(1.0), self.point(1.0), self.point(1.0)];
            let det = dot(m[0], cross(m[1], m[2]));
            if det.abs() > 0.05 {
                return m;
            }
        }
    }
}

pub fn add(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| a[i] + b[i])
}

pub fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

pub fn scale(a: [f32; 3], s: f32) -> [f32; 3] {
    a.map(|x| x * s)
}

pub fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn ray(origin: [f32; 3], direction: [f32; 3]) -> Ray {
    Ray { origin, direction, t_min: 0.0, t_max: f32::INFINITY, time: 0.0, mask: u32::MAX, skip: PrimitiveId::NONE }
}

pub fn mesh(positions: Vec<[f32; 3]>, indices: Vec<[u32; 3]>) -> TriangleMesh {
    TriangleMesh { positions: positions.into(), indices: indices.into() }
}

pub fn triangles(mesh: &TriangleMesh) -> Geometry {
    Geometry::Triangles(mesh.clone())
}

pub fn spheres(list: Vec<Sphere>) -> Geometry {
    Geometry::Spheres(list.into())
}

pub fn plain(geometry: u32) -> Instance {
    Instance { geometry, place: Place::World, mask: u32::MAX }
}

pub fn placed(geometry: u32, linear: [[f32; 3]; 3], shift: [f32; 3]) -> Instance {
    let rows = std::array::from_fn(|r| [linear[r][0], linear[r][1], linear[r][2], shift[r]]);
    Instance { geometry, place: Place::Fixed(Transform::new(rows).expect("an inverse")), mask: u32::MAX }
}

/// An instance on its way: from one key to the next by turns of up to half a revolution and shifts up to `reach`.
pub fn moving(
    rng: &mut Rng,
    geometry: u32,
    linear: [[f32; 3]; 3],
    shift: [f32; 3],
    keys: usize,
    reach: f32,
) -> Instance {
    let base = std::array::from_fn(|r| [linear[r][0], linear[r][1], linear[r][2], shift[r]].map(f64::from));
    let key = |i: usize, rng: &mut Rng| {
        let axis = rng.direction().map(f64::from);
        let half_angle = 0.5 * *rng.pick(&[0.0, 1e-9, 0.01, 1.0, 3.0, std::f64::consts::PI, 3.2, 6.0]);
        let rotation = [axis[0], axis[1], axis[2]].map(|x| x * f64::sin(half_angle));
        RigidKey {
            time: i as f64 / (keys - 1).max(1) as f64,
            rotation: [rotation[0], rotation[1], rotation[2], f64::cos(half_angle)],
            translation: rng.point(reach).map(f64::from),
        }
    };
    let keys: Vec<RigidKey> = (0..keys).map(|i| key(i, rng)).collect();
    let motion = Motion::new(base, &keys).expect("a motion");
    Instance { geometry, place: Place::Moving(Arc::new(motion)), mask: u32::MAX }
}

pub fn world_of(mesh: &TriangleMesh) -> World {
    World { geometries: vec![triangles(mesh)], instances: vec![plain(0)] }
}

/// Maps the positions of a mesh.
pub fn mapped(mesh: &TriangleMesh, map: impl FnMut([f32; 3]) -> [f32; 3]) -> TriangleMesh {
    let positions: Vec<_> = mesh.positions.iter().copied().map(map).collect();
    TriangleMesh { positions: positions.into(), indices: Arc::clone(&mesh.indices) }
}

/// A box from -1 to 1 with n by n squares a side; vertices are shared.
pub fn subdivided_box(n: usize) -> TriangleMesh {
    let mut positions: Vec<[f32; 3]> = Vec::new();
    let mut numbers = std::collections::BTreeMap::new();
    let mut indices = Vec::new();
    for axis in 0..3 {
        for side in [0, n] {
            for i in 0..n {
                for j in 0..n {
                    let mut corner = |di: usize, dj: usize| {
                        let mut key = [0; 3];
                        (key[axis], key[(axis + 1) % 3], key[(axis + 2) % 3]) = (side, i + di, j + dj);
                        *numbers.entry(key).or_insert_with(|| {
                            positions.push(key.map(|k| 2.0 * k as f32 / n as f32 - 1.0));
                            positions.len() as u32 - 1
                        })
                    };
                    let (a, b, c, d) = (corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1));
                    indices.extend([[a, b, c], [a, c, d]]);
                }
            }
        }
    }
    mesh(positions, indices)
}

/// A sphere of radius 1 from an octahedron, each face split in four `levels` times.
pub fn ball(levels: usize) -> TriangleMesh {
    let mut positions: Vec<[f32; 3]> =
        vec![[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, -1.0]];
    let mut faces: Vec<[u32; 3]> =
        vec![[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]];
    for _ in 0..levels {
        let mut middles = std::collections::BTreeMap::new();
        let mut middle = |a: u32, b: u32| {
            *middles.entry((a.min(b), a.max(b))).or_insert_with(|| {
                let sum = add(positions[a as usize], positions[b as usize]);
                positions.push(scale(sum, 1.0 / dot(sum, sum).sqrt()));
                positions.len() as u32 - 1
            })
        };
        let split = |&[a, b, c]: &[u32; 3]| {
            let (ab, bc, ca) = (middle(a, b), middle(b, c), middle(c, a));
            [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
        };
        faces = faces.iter().flat_map(split).collect();
    }
    mesh(positions, faces)
}

/// A torus around z with radii 1 and 0.4.
pub fn torus(around: usize, across: usize) -> TriangleMesh {
    let mut positions = Vec::new();
    let mut indices = Vec::new();
    for i in 0..around {
        for j in 0..across {
            let a = std::f64::consts::TAU * i as f64 / around as f64;
            let b = std::f64::consts::TAU * j as f64 / across as f64;
            let r = 1.0 + 0.4 * b.cos();
            positions.push([(r * a.cos()) as f32, (r * a.sin()) as f32, (0.4 * b.sin()) as f32]);
            let at = |i: usize, j: usize| ((i % around) * across + j % across) as u32;
            let (p, q, r, s) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
            indices.extend([[p, q, r], [p, r, s]]);
        }
    }
    mesh(positions, indices)
}

/// Every kind on every instruction set of this machine, the reference first.
pub fn all_accelerators(world: &World) -> Vec<(String, Accelerator)> {
    let mut all = Vec::new();
    for kind in AcceleratorKind::ALL {
        for isa in Isa::available() {
            let built = Accelerator::build(world, kind, isa, 2).expect("a world");
            all.push((format!("{kind} {isa}"), built));
        }
    }
    all
}
