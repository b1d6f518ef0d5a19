//! Normals for meshes that come without: smooth but for creases.

use crate::{
    obj::unifier::{NONE, Unifier},
    polygon::{angle_at, newell},
    read::sin_cos_degrees,
};
use etendue::scene::Mesh;
use glam::DVec3;

/// Gives a mesh without normals some: at each vertex, faces that are joined there by edges whose faces' normals differ by
/// less than `angle` degrees, in (0, 180], share the sum of their normals weighted by their angles at the vertex (Thürmer and
/// Wüthrich 1998). An edge that other than two faces meet at is a crease, and so is the border of a face without area.
/// Vertices at the same place are one for this, whatever their texture coordinates; where a crease ends they are split,
/// and numbered in the order of their first use. A mesh that has normals stays as it is.
///
/// Time n log n; beside the mesh it takes some 40 bytes a face corner while it runs.
pub fn smooth(mesh: &mut Mesh, angle: f64) {
    if mesh.normals.is_some() || mesh.indices.is_empty() {
        return;
    }
    let (_, cosine) = sin_cos_degrees(angle);
    let mut joiner = Joiner::new(mesh, cosine);
    let fans = Fans::new(mesh);
    for fan in 0..fans.starts.len() - 1 {
        joiner.join(&fans.corners[fans.starts[fan]..fans.starts[fan + 1]]);
    }
    let Joiner { shared, normals, .. } = joiner;
    drop(fans);
    rebuild(mesh, &shared, &normals);
}

/// The corners of faces by place.
struct Fans {
    /// First corner of each place; one entry more than there are places.
    starts: Vec<usize>,
    /// Corner `3 face + k`, by place and then ascending.
    corners: Vec<u32>,
}

impl Fans {
    fn new(mesh: &Mesh) -> Self {
        let (places, count) = places(&mesh.positions);
        let mut starts = vec![0; count + 1];
        for vertex in mesh.indices.as_flattened() {
            starts[places[*vertex as usize] as usize + 1] += 1;
        }
        for place in 0..count {
            starts[place + 1] += starts[place];
        }
        let mut next = starts.clone();
        let mut corners = vec![0; mesh.indices.len() * 3];
        for (corner, vertex) in mesh.indices.as_flattened().iter().enumerate() {
            let slot = &mut next[places[*vertex as usize] as usize];
            corners[*slot] = corner as u32;
            *slot += 1;
        }
        Self { starts, corners }
    }
}

/// A number for the place of each vertex, equal for equal positions, and how many there are.
fn places(positions: &[[f32; 3]]) -> (Vec<u32>, usize) {
    // Adding 0 makes -0 and 0 one.
    let key = |vertex: u32| positions[vertex as usize].map(|c| (c + 0.0).to_bits());
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
    order.sort_unstable_by_key(|&vertex| key(vertex));
    let mut places = vec![0; positions.len()];
    let mut count = 0;
    for (i, &vertex) in order.iter().enumerate() {
        if i == 0 || key(order[i - 1]) != key(vertex) {
            count += 1;
        }
        places[vertex as usize] = count as u32 - 1;
    }
    (places, count)
}

struct Joiner<'a> {
    mesh: &'a Mesh,
    cosine: f64,
    /// Of each corner, the index of its normal.
    shared: Vec<u32>,
    normals: Vec<[f32; 3]>,
    // Of the place at hand: unit normals of its corners' faces; edges as the place at their other end with the corner;
    // corners as a forest of joined ones; sums of the trees.
    faces: Vec<DVec3>,
    edges: Vec<([u32; 3], u32)>,
    parents: Vec<u32>,
    sums: Vec<(DVec3, u32)>,
}

impl<'a> Joiner<'a> {
    fn new(mesh: &'a Mesh, cosine: f64) -> Self {
        Self {
            mesh,
            cosine,
            shared: vec![0; mesh.indices.len() * 3],
            normals: vec![],
            faces: vec![],
            edges: vec![],
            parents: vec![],
            sums: vec![],
        }
    }

    /// The positions of a corner, of the next and of the one before in its face.
    fn points(&self, corner: u32) -> [DVec3; 3] {
        let (face, k) = (self.mesh.indices[corner as usize / 3], corner as usize % 3);
        [0, 1, 2].map(|i| DVec3::from(self.mesh.positions[face[(k + i) % 3] as usize].map(f64::from)))
    }

    /// The corners of one place.
    fn join(&mut self, corners: &[u32]) {
        self.faces.clear();
        self.edges.clear();
        self.parents.clear();
        self.parents.extend(0..corners.len() as u32);
        for (i, &corner) in corners.iter().enumerate() {
            let points = self.points(corner);
            let normal = newell(&points).normalize_or_zero();
            self.faces.push(normal);
            if normal != DVec3::ZERO {
                let bits = |p: DVec3| (p + 0.0).as_vec3().to_array().map(f32::to_bits);
                self.edges.extend(points[1..].iter().map(|&p| (bits(p), i as u32)));
            }
        }
        self.edges.sort_unstable();
        let mut edges = std::mem::take(&mut self.edges);
        for edge in edges.chunk_by(|a, b| a.0 == b.0) {
            if let [(_, a), (_, b)] = *edge
                && self.faces[a as usize].dot(self.faces[b as usize]) > self.cosine
            {
                let (a, b) = (self.root(a), self.root(b));
                self.parents[a.max(b) as usize] = a.min(b);
            }
        }
        edges.clear();
        self.edges = edges;
        self.sum(corners);
    }

    fn root(&mut self, mut corner: u32) -> u32 {
        while self.parents[corner as usize] != corner {
            // Halves the way for the next time.
            let above = self.parents[self.parents[corner as usize] as usize];
            self.parents[corner as usize] = above;
            corner = above;
        }
        corner
    }

    fn sum(&mut self, corners: &[u32]) {
        let mut sums = std::mem::take(&mut self.sums);
        sums.clear();
        for (i, &corner) in corners.iter().enumerate() {
            let root = self.root(i as u32);
            // A root comes before the others of its tree.
            let number = if root == i as u32 {
                sums.push((DVec3::ZERO, root));
                (self.normals.len() + sums.len() - 1) as u32
            } else {
                self.shared[corners[root as usize] as usize]
            };
            self.shared[corner as usize] = number;
            let [here, after, before] = self.points(corner);
            sums[number as usize - self.normals.len()].0 += angle_at(before, here, after) * self.faces[i];
        }
        let unit = |(sum, root): &(DVec3, u32)| {
            // Faces that cancel out, or have no area: the first one's normal, or any.
            let normal = sum.try_normalize().unwrap_or(self.faces[*root as usize]);
            if normal == DVec3::ZERO { [0.0, 0.0, 1.0] } else { normal.as_vec3().to_array() }
        };
        self.normals.extend(sums.iter().map(unit));
        self.sums = sums;
    }
}

/// Splits vertices whose corners have different normals.
fn rebuild(mesh: &mut Mesh, shared: &[u32], normals: &[[f32; 3]]) {
    let mut unifier = Unifier::new(mesh.positions.len());
    let old = mesh.indices.as_flattened().iter().zip(shared);
    let new: Vec<u32> = old.map(|(&vertex, &normal)| unifier.number(vertex, NONE, normal.into()).0).collect();
    mesh.indices = new.as_chunks().0.iter().copied().collect();
    drop(new);
    let triples = unifier.into_triples();
    let vertices = || triples.positions.iter().map(|&vertex| vertex as usize);
    mesh.normals = Some(triples.shadings().map(|normal| normals[normal as usize]).collect());
    mesh.uvs = mesh.uvs.as_ref().map(|uvs| vertices().map(|vertex| uvs[vertex]).collect());
    mesh.colors = mesh.colors.as_ref().map(|colors| vertices().map(|vertex| colors[vertex]).collect());
    mesh.positions = vertices().map(|vertex| mesh.positions[vertex]).collect();
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::cuboid;

    fn flat(positions: &[[f32; 3]], indices: &[[u32; 3]]) -> Mesh {
        Mesh {
            origin: DVec3::ZERO,
            positions: positions.into(),
            indices: indices.into(),
            normals: None,
            uvs: None,
            colors: None,
            face_materials: None,
        }
    }

    fn smoothed(mesh: &Mesh, angle: f64) -> Mesh {
        let mut mesh = mesh.clone();
        smooth(&mut mesh, angle);
        mesh
    }

    fn normal_at(mesh: &Mesh, face: usize, corner: usize) -> [f32; 3] {
        mesh.normals.as_ref().unwrap()[mesh.indices[face][corner] as usize]
    }

    /// Two faces over an edge of 90 degrees, the second with vertices of its own.
    fn folded() -> Mesh {
        let edge = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let points = [edge[0], edge[1], [1.0, 0.0, 0.0], edge[0], edge[1], [-0.0, 0.0, 1.0]];
        flat(&points, &[[0, 2, 1], [3, 4, 5]])
    }

    #[test]
    fn edges_sharper_than_the_angle_stay() {
        let mesh = folded();
        for (angle, sharp) in [(45.0, true), (89.99, true), (90.0, true), (90.01, false), (180.0, false)] {
            let mesh = smoothed(&mesh, angle);
            let normals: Vec<_> = (0..3).map(|k| normal_at(&mesh, 0, k)).collect();
            // About the z of the first face and the x of the second.
            let half = std::f32::consts::FRAC_1_SQRT_2;
            let at_edge = if sharp { [0.0, 0.0, 1.0] } else { [half, 0.0, half] };
            for (k, expected) in [at_edge, [0.0, 0.0, 1.0], at_edge].into_iter().enumerate() {
                let error = (0..3).map(|i| (normals[k][i] - expected[i]).abs()).fold(0.0, f32::max);
                assert!(error < 1e-6, "{angle}: {normals:?}");
            }
        }
    }

    /// A cube's corners, by angles alone: 90 degrees for each side, however it is cut into triangles.
    #[test]
    fn the_corners_of_a_cube() {
        let mesh = cuboid(DVec3::splat(-1.0), DVec3::splat(1.0));
        let sharp = smoothed(&mesh, 60.0);
        assert_eq!(sharp.positions, mesh.positions);
        assert!(sharp.normals.unwrap().iter().all(|n| n.iter().map(|c| c.abs()).sum::<f32>() == 1.0));
        let round = smoothed(&mesh, 91.0);
        assert_eq!(round.uvs.as_ref().unwrap().len(), 24);
        for (normal, position) in round.normals.unwrap().iter().zip(round.positions.iter()) {
            let third = 1.0 / 3f32.sqrt();
            assert!((0..3).all(|i| (normal[i] - position[i] * third).abs() < 1e-6), "{normal:?} {position:?}");
        }
    }

    #[test]
    fn a_crease_that_ends_splits_one_of_its_vertices() {
        // A strip folded more and more: 20 degrees at the first fold, 40 at the second.
        let direction = |degrees: f64| {
            let (sin, cos) = sin_cos_degrees(degrees);
            [cos as f32, sin as f32]
        };
        let mut profile = vec![[0.0f32; 2]];
        for degrees in [0.0, 20.0, 60.0] {
            let (last, by) = (profile[profile.len() - 1], direction(degrees));
            profile.push([last[0] + by[0], last[1] + by[1]]);
        }
        let points: Vec<_> = profile.iter().flat_map(|p| [[p[0], p[1], 0.0], [p[0], p[1], -1.0]]).collect();
        let faces: Vec<_> = (0..3u32).map(|i| 2 * i).flat_map(|i| [[i, i + 2, i + 3], [i, i + 3, i + 1]]).collect();
        let mesh = smoothed(&flat(&points, &faces), 30.0);
        assert_eq!(mesh.positions.len(), 10);
        assert_eq!(normal_at(&mesh, 0, 1), normal_at(&mesh, 2, 0));
        assert_ne!(normal_at(&mesh, 2, 1), normal_at(&mesh, 4, 0));
    }

    #[test]
    fn faces_without_area_and_edges_of_three_faces() {
        let points = [[0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [1.0, 0.0, 0.1], [1.0, 0.0, -0.1]];
        let three = smoothed(&flat(&points, &[[0, 2, 1], [0, 3, 1], [0, 4, 1]]), 90.0);
        assert_eq!(three.positions.len(), 9);
        let needle = smoothed(&flat(&points, &[[0, 2, 1], [0, 1, 1], [0, 0, 0]]), 90.0);
        assert!(needle.normals.unwrap().iter().all(|n| *n == [0.0, 0.0, 1.0]));
        let mut empty = flat(&points, &[]);
        smooth(&mut empty, 90.0);
        assert!(empty.normals.is_none());
    }
}
