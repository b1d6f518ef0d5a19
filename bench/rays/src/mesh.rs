//! What is traced: a mesh from a PLY file, and a generated one of any number of faces.

use etendue_accel::{Geometry, Instance, Place, TriangleMesh, World};
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

/// A mesh whose array of vertices ends with one that no face uses, since Embree reads 16 bytes for the last one used.
pub struct Mesh {
    pub name: String,
    positions: Arc<[[f32; 3]]>,
    indices: Arc<[[u32; 3]]>,
}

impl Mesh {
    fn new(name: &str, mut positions: Vec<[f32; 3]>, indices: Vec<[u32; 3]>) -> Self {
        positions.push([0.0; 3]);
        Self { name: name.to_owned(), positions: positions.into(), indices: indices.into() }
    }

    /// Vertices, the last unused.
    pub fn positions(&self) -> &[[f32; 3]] {
        &self.positions
    }

    pub fn indices(&self) -> &[[u32; 3]] {
        &self.indices
    }

    /// The mesh as Etendue takes it.
    pub fn world(&self) -> World {
        let mesh = TriangleMesh { positions: self.positions.clone(), indices: self.indices.clone() };
        World {
            geometries: vec![Geometry::Triangles(mesh)],
            instances: vec![Instance { geometry: 0, place: Place::World, mask: u32::MAX }],
        }
    }

    /// The normal of a face, not of unit length.
    pub fn normal(&self, face: u32) -> [f32; 3] {
        normal(&self.indices[face as usize].map(|i| self.positions[i as usize]))
    }

    /// Lowest and highest coordinates.
    pub fn bounds(&self) -> [[f32; 3]; 2] {
        let used = &self.positions[..self.positions.len() - 1];
        used.iter().fold([[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]], |[low, high], p| {
            [std::array::from_fn(|a| low[a].min(p[a])), std::array::from_fn(|a| high[a].max(p[a]))]
        })
    }

    /// The ASCII PLY file of the Stanford dragon, perhaps gzipped: vertices start with x, y, z; faces are triangles. Faces
    /// without area are left out.
    pub fn read_ply(name: &str, path: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(path).map_err(|e| format!("{}: {e}", path.display()))?;
        let mut text = String::new();
        let read = if bytes.starts_with(&[0x1f, 0x8b]) {
            flate2::read::GzDecoder::new(&bytes[..]).read_to_string(&mut text)
        } else {
            (&bytes[..]).read_to_string(&mut text)
        };
        read.map_err(|e| format!("{}: {e}", path.display()))?;
        let parsed =
            parse_ply(&text).ok_or_else(|| format!("{}: not a mesh of triangles in ASCII PLY", path.display()))?;
        let (positions, mut indices) = parsed;
        let has_area = |face: &[u32; 3]| {
            let [a, b, c] = face.map(|i| positions[i as usize]);
            let (e, f) = (sub(b, a), sub(c, a));
            face[0] != face[1]
                && face[1] != face[2]
                && face[2] != face[0]
                && (0..3).any(|i| e[i] * f[(i + 1) % 3] != e[(i + 1) % 3] * f[i])
        };
        indices.retain(has_area);
        Ok(Self::new(name, positions, indices))
    }

    /// A bumpy tube along a trefoil knot, of `2 along around` faces.
    pub fn knot(along: u32, around: u32) -> Self {
        use std::f64::consts::TAU;
        let center = |t: f64| {
            let (r, z) = (2.0 + libm::cos(3.0 * t), libm::sin(3.0 * t));
            [r * libm::cos(2.0 * t), r * libm::sin(2.0 * t), z]
        };
        let mut positions = Vec::with_capacity((along * around) as usize);
        for i in 0..along {
            let t = TAU * f64::from(i) / f64::from(along);
            let (p, q) = (center(t), center(t + 1e-4));
            let forward = unit([q[0] - p[0], q[1] - p[1], q[2] - p[2]]);
            let side = unit([-p[1], p[0], 0.3]);
            let side = unit(across(forward, side));
            let up = across(forward, side);
            for j in 0..around {
                let s = TAU * f64::from(j) / f64::from(around);
                let bumps = 0.05 * libm::sin(40.0 * t + 3.0 * s) + 0.04 * libm::sin(90.0 * t - 7.0 * s);
                let fine = 0.004 * libm::sin(1700.0 * t + 60.0 * s) + 0.002 * libm::sin(6100.0 * t - 290.0 * s);
                let radius = 0.45 + bumps + fine;
                let (x, y) = (radius * libm::cos(s), radius * libm::sin(s));
                positions.push([0, 1, 2].map(|a| (p[a] + x * side[a] + y * up[a]) as f32));
            }
        }
        let mut indices = Vec::with_capacity(2 * (along * around) as usize);
        for i in 0..along {
            for j in 0..around {
                let at = |i: u32, j: u32| (i % along) * around + j % around;
                indices.push([at(i, j), at(i + 1, j), at(i, j + 1)]);
                indices.push([at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)]);
            }
        }
        Self::new(&format!("knot {}", indices.len()), positions, indices)
    }
}

type Arrays = (Vec<[f32; 3]>, Vec<[u32; 3]>);

fn parse_ply(text: &str) -> Option<Arrays> {
    let (header, body) = text.split_once("end_header\n")?;
    let count = |what: &str| header.lines().find_map(|line| line.strip_prefix(what)?.trim().parse::<usize>().ok());
    let (vertices, faces) = (count("element vertex")?, count("element face")?);
    let mut lines = body.lines();
    let numbers = |line: &str| {
        let mut words = line.split_ascii_whitespace();
        Some([words.next()?.parse().ok()?, words.next()?.parse().ok()?, words.next()?.parse().ok()?])
    };
    let positions = lines.by_ref().take(vertices).map(numbers).collect::<Option<Vec<[f32; 3]>>>()?;
    let face = |line: &str| {
        let line = line.trim_start().strip_prefix('3')?;
        let mut words = line.split_ascii_whitespace();
        let corners: [u32; 3] = [words.next()?.parse().ok()?, words.next()?.parse().ok()?, words.next()?.parse().ok()?];
        corners.iter().all(|&i| (i as usize) < vertices).then_some(corners)
    };
    let indices = lines.take(faces).map(face).collect::<Option<Vec<[u32; 3]>>>()?;
    (positions.len() == vertices && indices.len() == faces).then_some((positions, indices))
}

/// Of a face with these corners, not of unit length.
#[inline(always)]
pub fn normal(&[a, b, c]: &[[f32; 3]; 3]) -> [f32; 3] {
    let (e, f) = (sub(b, a), sub(c, a));
    [e[1] * f[2] - e[2] * f[1], e[2] * f[0] - e[0] * f[2], e[0] * f[1] - e[1] * f[0]]
}

fn sub(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    std::array::from_fn(|i| a[i] - b[i])
}

fn across(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn unit(v: [f64; 3]) -> [f64; 3] {
    let length = (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
    v.map(|x| x / length)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_small_file() {
        let text = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nelement face 2\nend_header\n\
                    0 0 0 7\n1 0 0 7\n0 1 0 7\n0 0 1 7\n3 0 1 2 \n3 1 2 3 \n";
        let (positions, indices) = parse_ply(text).unwrap();
        assert_eq!((positions[3], indices), ([0.0, 0.0, 1.0], vec![[0, 1, 2], [1, 2, 3]]));
        assert!(parse_ply(&text.replace("3 1 2 3", "3 1 2 4")).is_none());
    }

    #[test]
    fn the_knot_is_closed() {
        let mesh = Mesh::knot(140, 25);
        assert_eq!(mesh.indices().len(), 7000);
        let mut edges: Vec<[u32; 2]> = mesh.indices().iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        edges.sort();
        assert!(edges.iter().all(|&[a, b]| edges.binary_search(&[b, a]).is_ok()));
    }
}
