//! Triangle meshes and the compressed PLY files they are kept in.

use flate2::{Compression, GzBuilder};
use glam::DVec3;
use std::{collections::BTreeMap, io::Write};

/// Triangles that go round counter-clockwise seen from outside.
#[derive(Default)]
pub struct Mesh {
    pub positions: Vec<DVec3>,
    pub triangles: Vec<[u32; 3]>,
}

impl Mesh {
    /// What keeps the mesh from being the boundary of solids: edges that do not belong to exactly two faces, one each way.
    pub fn open_edges(&self) -> usize {
        let mut uses: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
        for t in &self.triangles {
            for (a, b) in [(t[0], t[1]), (t[1], t[2]), (t[2], t[0])] {
                uses.entry([a.min(b), a.max(b)]).or_default()[usize::from(a > b)] += 1;
            }
        }
        uses.values().filter(|uses| **uses != [1, 1]).count()
    }

    /// For each vertex the lowest one that it hangs together with.
    fn roots(&self) -> Vec<u32> {
        fn find(root: &mut [u32], mut i: u32) -> u32 {
            while root[i as usize] != i {
                root[i as usize] = root[root[i as usize] as usize];
                i = root[i as usize];
            }
            i
        }
        let mut root: Vec<u32> = (0..self.positions.len() as u32).collect();
        for t in &self.triangles {
            for i in 1..3 {
                let (a, b) = (find(&mut root, t[0]), find(&mut root, t[i]));
                root[a.max(b) as usize] = a.min(b);
            }
        }
        (0..root.len() as u32).map(|i| find(&mut root, i)).collect()
    }

    /// Volumes of the pieces that hang together, by their lowest vertex; negative for one that is inside out.
    pub fn solids(&self) -> BTreeMap<u32, f64> {
        let roots = self.roots();
        let mut volumes = BTreeMap::new();
        for t in &self.triangles {
            let [a, b, c] = t.map(|i| self.positions[i as usize]);
            *volumes.entry(roots[t[0] as usize]).or_default() += a.dot(b.cross(c)) / 6.0;
        }
        volumes
    }

    /// Leaves out all faces but those of the largest piece: crumbs that are thinner than what made the mesh can see.
    pub fn keep_largest(&mut self) {
        let roots = self.roots();
        let largest = self.solids().into_iter().max_by(|a, b| a.1.total_cmp(&b.1)).map(|(root, _)| root);
        self.triangles.retain(|t| Some(roots[t[0] as usize]) == largest);
        let mut number = vec![u32::MAX; self.positions.len()];
        let mut kept = Vec::new();
        for i in self.triangles.iter_mut().flatten() {
            if number[*i as usize] == u32::MAX {
                number[*i as usize] = kept.len() as u32;
                kept.push(self.positions[*i as usize]);
            }
            *i = number[*i as usize];
        }
        self.positions = kept;
    }

    /// Lowest and highest corner.
    pub fn bounds(&self) -> [DVec3; 2] {
        let start = [DVec3::INFINITY, DVec3::NEG_INFINITY];
        self.positions.iter().fold(start, |[low, high], &p| [low.min(p), high.max(p)])
    }

    /// Binary PLY in gzip, positions in whole multiples of `quantum`: the scene scales them back. Vertices are numbered in the
    /// order in which faces name them, which makes the file small.
    pub fn ply_gz(&self, quantum: f64) -> Vec<u8> {
        assert_eq!(self.open_edges(), 0, "glass needs closed surfaces");
        let mut number = vec![u32::MAX; self.positions.len()];
        let mut order = Vec::new();
        for &i in self.triangles.iter().flatten() {
            if number[i as usize] == u32::MAX {
                number[i as usize] = order.len() as u32;
                order.push(i);
            }
        }
        let wide = order.len() > 1 << 16;
        let index = if wide { "uint" } else { "ushort" };
        let mut bytes = format!(
            "ply\nformat binary_little_endian 1.0\ncomment Etendue, cargo xtask gallery inputs; unit {quantum}\nelement vertex {}\n\
             property short x\nproperty short y\nproperty short z\nelement face {}\nproperty list uchar {index} vertex_indices\n\
             end_header\n",
            order.len(),
            self.triangles.len()
        )
        .into_bytes();
        for i in order {
            for v in (self.positions[i as usize] / quantum).round().to_array() {
                assert!(v.abs() < 32768.0, "the mesh is larger than its file can say");
                bytes.extend((v as i16).to_le_bytes());
            }
        }
        for t in &self.triangles {
            bytes.push(3);
            for i in t {
                let i = number[*i as usize];
                if wide { bytes.extend(i.to_le_bytes()) } else { bytes.extend((i as u16).to_le_bytes()) }
            }
        }
        let mut out = GzBuilder::new().mtime(0).write(Vec::new(), Compression::best());
        out.write_all(&bytes).expect("memory takes all of a mesh");
        out.finish().expect("memory takes the end of a mesh")
    }
}
