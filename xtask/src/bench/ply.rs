//! Triangle meshes as binary PLY.

use glam::DVec3;
use std::io::BufRead;

/// Triangles that go round counter-clockwise seen from the side they face.
#[derive(Default)]
pub struct Mesh {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// A PLY file of single-precision positions and triangles.
    pub fn ply(&self) -> Vec<u8> {
        let mut bytes = format!(
            "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
             element face {}\nproperty list uchar int vertex_indices\nend_header\n",
            self.positions.len(),
            self.triangles.len()
        )
        .into_bytes();
        for p in &self.positions {
            bytes.extend(p.to_array().into_iter().flat_map(|x| (x as f32).to_le_bytes()));
        }
        for t in &self.triangles {
            bytes.push(3);
            bytes.extend(t.iter().flat_map(|i| i.to_le_bytes()));
        }
        bytes
    }

    /// Reads an ASCII PLY file of triangles such as the Stanford scans are.
    pub fn read_ascii(mut file: impl BufRead) -> Result<Self, String> {
        let mut header = String::new();
        let mut counts = [0usize; 2];
        loop {
            header.clear();
            if file.read_line(&mut header).map_err(|e| e.to_string())? == 0 {
                return Err("the header has no end".to_owned());
            }
            match header.split_whitespace().collect::<Vec<_>>()[..] {
                ["element", "vertex", n] => counts[0] = n.parse().map_err(|_| "a count is no number")?,
                ["element", "face", n] => counts[1] = n.parse().map_err(|_| "a count is no number")?,
                ["format", kind, _] if kind != "ascii" => return Err(format!("format {kind}, expected ascii")),
                ["end_header"] => break,
                _ => (),
            }
        }
        let mut text = String::new();
        file.read_to_string(&mut text).map_err(|e| e.to_string())?;
        let mut lines = text.lines();
        let mut mesh = Self::default();
        for _ in 0..counts[0] {
            let mut words = lines.next().ok_or("vertices are missing")?.split_whitespace();
            let mut next = || words.next()?.parse::<f64>().ok();
            match [next(), next(), next()] {
                [Some(x), Some(y), Some(z)] => mesh.positions.push(DVec3::new(x, y, z)),
                _ => return Err("a vertex is no three numbers".to_owned()),
            }
        }
        for _ in 0..counts[1] {
            let words = lines.next().ok_or("faces are missing")?.split_whitespace();
            let indices: Vec<u32> = words.map_while(|word| word.parse().ok()).collect();
            match indices[..] {
                [3, a, b, c] if [a, b, c].iter().all(|&i| (i as usize) < counts[0]) => mesh.triangles.push([a, b, c]),
                _ => return Err("a face is no triangle".to_owned()),
            }
        }
        Ok(mesh)
    }

    /// Leaves out triangles without area.
    pub fn drop_degenerate(&mut self) {
        let p = &self.positions;
        self.triangles.retain(|t| {
            let [a, b, c] = t.map(|i| p[i as usize]);
            (b - a).cross(c - a) != DVec3::ZERO
        });
    }

    /// Scales, and moves so that the mesh stands on the plane y = 0 with the origin under its middle.
    pub fn stand(&mut self, scale: f64) {
        let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        let [low, high] = self.positions.iter().fold(start, |[low, high], &p| [low.min(p), high.max(p)]);
        let middle = (low + high) / 2.0;
        let foot = DVec3::new(middle.x, low.y, middle.z);
        self.positions.iter_mut().for_each(|p| *p = scale * (*p - foot));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FILE: &str = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nelement face 2\nend_header\n\
                        1 2 3\n2 2 3 \n1 3 3\n1 2 5\n3 0 1 2\n3 0 0 1\n";

    #[test]
    fn scans_are_read_and_stand() {
        let mut mesh = Mesh::read_ascii(FILE.as_bytes()).unwrap();
        assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 2));
        mesh.drop_degenerate();
        assert_eq!(mesh.triangles, [[0, 1, 2]]);
        mesh.stand(2.0);
        assert_eq!(mesh.positions[0], DVec3::new(-1.0, 0.0, -2.0));
        assert_eq!(mesh.positions[3], DVec3::new(-1.0, 0.0, 2.0));
        assert!(mesh.ply().ends_with(&[3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]));
    }

    #[test]
    fn damaged_scans_are_told() {
        for (from, to) in [("3 0 1 2", "3 0 1 4"), ("3 0 1 2", "4 0 1 2 3"), ("2 2 3 ", "2 x 3"), ("end_header", "")] {
            assert!(Mesh::read_ascii(FILE.replace(from, to).as_bytes()).is_err(), "{from} -> {to}");
        }
    }
}
