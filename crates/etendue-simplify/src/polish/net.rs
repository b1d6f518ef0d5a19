//! The simplified mesh with its vertices welded: nodes, their faces and edges.

use crate::Mesh;
use crate::places::first_at_place;
use crate::surface::{cross, dot, is_in_reach, sub};
use crate::vertex::Kind;

/// Welded vertices and faces over them. Faces have the numbers that they have in the mesh.
pub(super) struct Net {
    /// Node of each vertex.
    pub node: Vec<u32>,
    pub positions: Vec<[f32; 3]>,
    pub faces: Vec<[u32; 3]>,
    pub kinds: Vec<Kind>,
    /// The faces of each node.
    incident: Grouped,
    /// Edges, smaller node first.
    pub edges: Vec<[u32; 2]>,
    /// For each face, the edges from its first, second and third corner to the next.
    pub face_edges: Vec<[u32; 3]>,
    /// Normal of each face at the start, as long as twice its area.
    normals: Vec<[f64; 3]>,
}

/// Lists of numbers, one after the other.
pub(crate) struct Grouped {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Grouped {
    /// Lists item i with each of its groups.
    pub fn new<const N: usize>(groups: usize, keys: &[[u32; N]]) -> Self {
        let mut starts = vec![0_u32; groups + 1];
        keys.iter().flatten().for_each(|&key| starts[key as usize + 1] += 1);
        for group in 0..groups {
            starts[group + 1] += starts[group];
        }
        let mut next = starts.clone();
        let mut items = vec![0; N * keys.len()];
        for (item, keys) in keys.iter().enumerate() {
            for &key in keys {
                items[next[key as usize] as usize] = item as u32;
                next[key as usize] += 1;
            }
        }
        Self { starts, items }
    }

    pub fn of(&self, group: u32) -> &[u32] {
        let group = group as usize;
        &self.items[self.starts[group] as usize..self.starts[group + 1] as usize]
    }
}

impl Net {
    pub fn of(mesh: &Mesh, pinned: &[Kind]) -> Self {
        let welded = first_at_place(&mesh.positions);
        let mut node = vec![0; welded.len()];
        let (mut positions, mut kinds) = (Vec::new(), Vec::new());
        for (vertex, &first) in welded.iter().enumerate() {
            let kind = pinned.get(vertex).copied().unwrap_or(Kind::Fixed);
            if first as usize == vertex {
                node[vertex] = positions.len() as u32;
                positions.push(mesh.positions[vertex]);
                kinds.push(if is_in_reach(mesh.positions[vertex]) { kind } else { Kind::Fixed });
            } else {
                node[vertex] = node[first as usize];
                let of_node = &mut kinds[node[vertex] as usize];
                *of_node = kind.max(*of_node);
            }
        }
        let faces: Vec<[u32; 3]> = mesh.faces.iter().map(|face| face.map(|v| node[v as usize])).collect();
        let (edges, face_edges) = edges(&faces);
        let incident = Grouped::new(positions.len(), &faces);
        let mut net = Self { node, positions, faces, kinds, incident, edges, face_edges, normals: Vec::new() };
        net.normals = (0..net.faces.len()).map(|face| net.normal(face, &net.positions)).collect();
        net
    }

    /// True if any node may move.
    pub fn can_move(&self) -> bool {
        self.kinds.iter().any(|&kind| kind != Kind::Fixed)
    }

    fn corners(&self, face: usize, positions: &[[f32; 3]]) -> [[f64; 3]; 3] {
        self.faces[face].map(|node| positions[node as usize].map(f64::from))
    }

    /// Normal of a face, as long as twice its area.
    pub fn normal(&self, face: usize, positions: &[[f32; 3]]) -> [f64; 3] {
        let [a, b, c] = self.corners(face, positions);
        cross(sub(b, a), sub(c, a))
    }

    /// True if the faces at a node look the way they did at the start and are triangles yet.
    pub fn is_sound_at(&self, node: u32, positions: &[[f32; 3]]) -> bool {
        self.incident.of(node).iter().all(|&face| {
            let (before, now) = (self.normals[face as usize], self.normal(face as usize, positions));
            let (before_squared, now_squared) = (dot(before, before), dot(now, now));
            let along = dot(before, now);
            // Within 60 degrees, and a height above base of a twentieth, or half of what it was.
            let turned = along <= 0.0 || along * along < 0.25 * before_squared * now_squared;
            let shape = |squared: f64, positions: &[[f32; 3]]| {
                let [a, b, c] = self.corners(face as usize, positions);
                let longest =
                    [sub(b, a), sub(c, b), sub(a, c)].map(|side| dot(side, side)).into_iter().fold(0.0, f64::max);
                squared / (longest * longest)
            };
            let shape_now = shape(now_squared, positions);
            let shape_before = || shape(before_squared, &self.positions);
            !turned && (shape_now > 0.0025 || shape_now > 0.25 * shape_before())
        })
    }

    /// The square of the shortest edge at a node.
    pub fn shortest_edge_squared(&self, node: u32, positions: &[[f32; 3]]) -> f64 {
        let at = |node: u32| positions[node as usize].map(f64::from);
        let here = at(node);
        let others = self.incident.of(node).iter().flat_map(|&face| self.faces[face as usize]);
        others
            .filter(|&other| other != node)
            .map(|other| {
                let along = sub(at(other), here);
                dot(along, along)
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// The faces at a node.
    pub fn faces_at(&self, node: u32) -> &[u32] {
        self.incident.of(node)
    }
}

/// All edges, and those of each face.
fn edges(faces: &[[u32; 3]]) -> (Vec<[u32; 2]>, Vec<[u32; 3]>) {
    let mut sides: Vec<([u32; 2], u32)> = Vec::with_capacity(3 * faces.len());
    for (face, corners) in faces.iter().enumerate() {
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            sides.push(([a.min(b), a.max(b)], (3 * face + i) as u32));
        }
    }
    sides.sort_unstable();
    let mut edges: Vec<[u32; 2]> = Vec::new();
    let mut face_edges = vec![[0; 3]; faces.len()];
    for (edge, side) in sides {
        if edges.last() != Some(&edge) {
            edges.push(edge);
        }
        face_edges[side as usize / 3][side as usize % 3] = edges.len() as u32 - 1;
    }
    (edges, face_edges)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faces_that_turn_over_or_lose_their_shape_are_unsound() {
        // A square fan about the origin.
        let positions = vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]];
        let faces = vec![[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 1]];
        let mesh = Mesh { positions, faces, ..Mesh::default() };
        let net = Net::of(&mesh, &[Kind::Free; 5]);
        for (place, is_sound) in [
            ([0.0, 0.0, 0.0], true),
            ([0.3, 0.2, 0.0], true),
            ([0.1, 0.0, 0.5], true),
            // Across an edge, onto it, steep, and so near to it that little is left.
            ([0.7, 0.7, 0.0], false),
            ([0.5, 0.5, 0.0], false),
            ([0.0, 0.0, 2.0], false),
            ([0.495, 0.495, 0.0], false),
        ] {
            let mut positions = net.positions.clone();
            positions[0] = place;
            assert_eq!(net.is_sound_at(0, &positions), is_sound, "{place:?}");
        }
    }

    #[test]
    fn vertices_at_one_place_are_one_node_of_the_strictest_kind() {
        let positions =
            vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-0.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]];
        let mesh = Mesh { positions, faces: vec![[0, 1, 2], [3, 4, 5]], ..Mesh::default() };
        let net = Net::of(&mesh, &[Kind::Free, Kind::Free, Kind::Curve, Kind::Fixed, Kind::Free, Kind::Free]);
        assert_eq!(net.node, [0, 1, 2, 0, 2, 3]);
        assert_eq!(net.kinds, [Kind::Fixed, Kind::Free, Kind::Curve, Kind::Free]);
        assert_eq!((net.edges.len(), net.faces_at(0)), (5, &[0, 1][..]));
    }
}
