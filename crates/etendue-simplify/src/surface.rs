//! A mesh as a surface: points uniform by area, and closest points.

use etendue_accel::{ClosestPoints, Isa, TriangleMesh};
use rayon::prelude::*;

use crate::{MeshRef, SimplifyError};

/// Coordinates reach at most this far (2^50); faces with a corner beyond, or one that is not finite, are no surface.
const REACH: f32 = (1_u64 << 50) as f32;

/// Faces that a thread works on at once.
const PART: usize = 1 << 13;

/// That every face names vertices that are there.
pub(crate) fn check_indices(mesh: &MeshRef<'_>) -> Result<(), SimplifyError> {
    let vertices = mesh.positions.len();
    let is_bad = |face: &[u32; 3]| face.iter().any(|&v| v as usize >= vertices);
    match mesh.faces.par_iter().with_min_len(PART).position_first(is_bad) {
        None => Ok(()),
        Some(face) => {
            let vertex = mesh.faces[face].into_iter().find(|&v| v as usize >= vertices).unwrap_or_default();
            Err(SimplifyError::BadIndex { face, vertex, vertices })
        }
    }
}

/// True if a face can be part of a surface.
pub(crate) fn is_in_reach(position: [f32; 3]) -> bool {
    position.iter().all(|x| x.abs() <= REACH)
}

/// A mesh ready for closest points. Faces that are out of reach are left out; the others keep their order, and their numbers if
/// none is left out.
pub(crate) fn search(mesh: &MeshRef<'_>) -> Result<ClosestPoints, SimplifyError> {
    let is_fine = mesh.positions.par_iter().with_min_len(PART).all(|&p| is_in_reach(p));
    let mesh = if is_fine {
        TriangleMesh { positions: mesh.positions.into(), indices: mesh.faces.into() }
    } else {
        let moved = |&p: &[f32; 3]| if is_in_reach(p) { p } else { [0.0; 3] };
        let is_surface = |face: &&[u32; 3]| face.iter().all(|&v| is_in_reach(mesh.positions[v as usize]));
        TriangleMesh {
            positions: mesh.positions.iter().map(moved).collect(),
            indices: mesh.faces.iter().filter(is_surface).copied().collect(),
        }
    };
    Ok(ClosestPoints::build(&mesh, Isa::detect())?)
}

/// A point of a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sample {
    pub point: [f64; 3],
    pub face: u32,
}

/// The areas of a mesh, summed up face by face.
pub(crate) struct Areas<'a> {
    mesh: MeshRef<'a>,
    /// Twice the area up to and with each face.
    ends: Vec<f64>,
}

impl<'a> Areas<'a> {
    /// Of a mesh whose indices have been checked.
    pub fn of(mesh: &MeshRef<'a>) -> Self {
        let area = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|v| mesh.positions[v as usize]);
            if ![a, b, c].into_iter().all(is_in_reach) {
                return 0.0;
            }
            length(normal([a, b, c]))
        };
        let mut ends: Vec<f64> = mesh.faces.par_iter().with_min_len(PART).map(area).collect();
        let mut sum = 0.0;
        for end in &mut ends {
            sum += *end;
            *end = sum;
        }
        Self { mesh: *mesh, ends }
    }

    /// The area of all.
    pub fn total(&self) -> f64 {
        0.5 * self.ends.last().copied().unwrap_or(0.0)
    }

    /// Points `first..first + samples.len()` of `count`: each is uniform in its share of the area, in the order of faces. They
    /// depend on nothing but mesh, count and seed. The surface has an area.
    pub fn sample(&self, first: usize, count: usize, seed: u64, samples: &mut [Sample]) {
        samples.par_chunks_mut(PART).enumerate().for_each(|(chunk, samples)| {
            let first = first + chunk * PART;
            // In order, so that a face is found by going on from the one before.
            let mut face = self.face_at(first as f64 / count as f64);
            for (i, sample) in samples.iter_mut().enumerate() {
                let index = first + i;
                let [along, u, v] = random(seed, index as u64);
                let area = (index as f64 + along) / count as f64 * self.ends[self.ends.len() - 1];
                while face + 1 < self.ends.len() && self.ends[face] <= area {
                    face += 1;
                }
                *sample = Sample { point: self.point(face, u, v), face: face as u32 };
            }
        });
    }

    fn face_at(&self, share: f64) -> usize {
        let area = share * self.ends[self.ends.len() - 1];
        self.ends.partition_point(|&end| end <= area).min(self.ends.len() - 1)
    }

    /// A point of a face, uniform in two random numbers.
    fn point(&self, face: usize, u: f64, v: f64) -> [f64; 3] {
        let root = u.sqrt();
        let (second, third) = (root * (1.0 - v), root * v);
        let [a, b, c] = self.mesh.faces[face].map(|v| self.mesh.positions[v as usize].map(f64::from));
        std::array::from_fn(|i| a[i] + second * (b[i] - a[i]) + third * (c[i] - a[i]))
    }
}

/// Three numbers in \[0, 1), a pure function of seed and index: a hash (after Steele, Lea and Flood 2014), and for the place in a face,
/// a shifted sequence of low discrepancy (Roberts, "The unreasonable effectiveness of quasirandom sequences", 2018), so
/// that large faces are covered evenly.
fn random(seed: u64, index: u64) -> [f64; 3] {
    let seed = mixed(seed ^ 0x5851_F42D_4C95_7F2D);
    let words = [
        mixed(seed.wrapping_add(index.wrapping_mul(STEP))),
        mixed(seed.wrapping_add(1)).wrapping_add(index.wrapping_mul(PLASTIC[0])),
        mixed(seed.wrapping_add(2)).wrapping_add(index.wrapping_mul(PLASTIC[1])),
    ];
    words.map(|word| (word >> 11) as f64 / (1_u64 << 53) as f64)
}

/// 1/g and 1/g^2 of the plastic number g, times 2^64.
const PLASTIC: [u64; 2] = [0xC13F_A9A9_02A6_328F, 0x91E1_0DA5_C79E_7B1D];

const STEP: u64 = 0x9E37_79B9_7F4A_7C15;

fn mixed(word: u64) -> u64 {
    let word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ (word >> 31)
}

/// Normal of a triangle, as long as twice its area.
pub(crate) fn normal(corners: [[f32; 3]; 3]) -> [f64; 3] {
    let [a, b, c] = corners.map(|corner| corner.map(f64::from));
    cross(sub(b, a), sub(c, a))
}

pub(crate) fn sub(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub(crate) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn length(a: [f64; 3]) -> f64 {
    dot(a, a).sqrt()
}
