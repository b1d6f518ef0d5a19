//! Attributes of vertices that have moved.

use super::net::{Grouped, Net};
use super::rounds::Points;
use crate::Mesh;
use crate::surface::{cross, dot, length, sub};

/// Normals are replaced by those of the original only if these are within some 60 degrees.
const LEAST_COSINE: f64 = 0.5;

/// Moves the vertices of a mesh to the positions of their nodes. Texture coordinates and colours go on as the faces about the old
/// place continue; normals are those of the original, about the vertex.
pub(super) fn follow(mesh: &mut Mesh, net: &Net, positions: &[[f32; 3]], points: &Points) {
    let moved: Vec<bool> =
        net.node.iter().map(|&node| positions[node as usize] != net.positions[node as usize]).collect();
    if mesh.uvs.is_some() || mesh.colors.is_some() {
        continue_all(mesh, &moved, |vertex| positions[net.node[vertex] as usize].map(f64::from));
    }
    if mesh.normals.is_some() {
        renew_normals(mesh, &moved, points);
    }
    for (vertex, &node) in net.node.iter().enumerate() {
        mesh.positions[vertex] = positions[node as usize];
    }
}

/// Texture coordinates and colours of a vertex that goes to another place, from its faces about the old one.
pub(crate) fn continue_at(mesh: &mut Mesh, vertex: usize, faces: &[u32], there: [f64; 3]) {
    if mesh.uvs.is_none() && mesh.colors.is_none() {
        return;
    }
    let Some((corners, weights)) = place(mesh, faces, there) else { return };
    if let Some(uvs) = &mut mesh.uvs {
        uvs[vertex] = mixed(uvs, &corners, &weights);
    }
    if let Some(colors) = &mut mesh.colors {
        colors[vertex] = mixed(colors, &corners, &weights).map(|x: f32| x.clamp(0.0, 1.0));
    }
}

/// Texture coordinates and colours at new places.
fn continue_all(mesh: &mut Mesh, moved: &[bool], there: impl Fn(usize) -> [f64; 3]) {
    let incident = Grouped::new(mesh.positions.len(), &mesh.faces);
    let places: Vec<Option<([u32; 3], [f64; 3])>> = (0..mesh.positions.len())
        .map(|vertex| if moved[vertex] { place(mesh, incident.of(vertex as u32), there(vertex)) } else { None })
        .collect();
    if let Some(uvs) = &mut mesh.uvs {
        let old = uvs.clone();
        for (uv, place) in uvs.iter_mut().zip(&places) {
            if let Some((corners, weights)) = place {
                *uv = mixed(&old, corners, weights);
            }
        }
    }
    if let Some(colors) = &mut mesh.colors {
        let old = colors.clone();
        for (color, place) in colors.iter_mut().zip(&places) {
            if let Some((corners, weights)) = place {
                *color = mixed(&old, corners, weights).map(|x: f32| x.clamp(0.0, 1.0));
            }
        }
    }
}

fn mixed<const N: usize>(values: &[[f32; N]], corners: &[u32; 3], weights: &[f64; 3]) -> [f32; N] {
    std::array::from_fn(|i| {
        let terms = [0, 1, 2].map(|corner| weights[corner] * f64::from(values[corners[corner] as usize][i]));
        (terms[0] + terms[1] + terms[2]) as f32
    })
}

/// Of some faces the one that a point lies over or least far beside, and the weights of its corners.
fn place(mesh: &Mesh, faces: &[u32], point: [f64; 3]) -> Option<([u32; 3], [f64; 3])> {
    let mut best: Option<(f64, [u32; 3], [f64; 3])> = None;
    for &face in faces {
        let corners = mesh.faces[face as usize];
        let [a, b, c] = corners.map(|v| mesh.positions[v as usize].map(f64::from));
        let normal = cross(sub(b, a), sub(c, a));
        let scale = 1.0 / dot(normal, normal);
        let v = dot(cross(sub(point, a), sub(c, a)), normal) * scale;
        let w = dot(cross(sub(b, a), sub(point, a)), normal) * scale;
        let weights = [1.0 - v - w, v, w];
        let inside = weights.into_iter().fold(f64::INFINITY, f64::min);
        // A move is at most half an edge; what is far beyond that comes from a needle. A face without area has no weights.
        if weights.iter().all(|weight| weight.is_finite())
            && inside > -1.0
            && best.is_none_or(|(most, ..)| inside > most)
        {
            best = Some((inside, corners, weights));
        }
    }
    best.map(|(_, corners, weights)| (corners, weights))
}

/// Normals of vertices that have moved, from the points that their faces are closest to.
fn renew_normals(mesh: &mut Mesh, moved: &[bool], points: &Points) {
    let Some(normals) = &mut mesh.normals else { return };
    let mut sums = vec![[0.0; 3]; normals.len()];
    for (normal, found) in points.normals.iter().zip(&points.found).filter(|(_, found)| found.is_found()) {
        for (vertex, weight) in mesh.faces[found.face as usize].into_iter().zip(found.corner_weights()) {
            let sum = &mut sums[vertex as usize];
            (0..3).for_each(|axis| sum[axis] += weight * weight * f64::from(normal[axis]));
        }
    }
    for ((normal, sum), _) in normals.iter_mut().zip(sums).zip(moved).filter(|(_, moved)| **moved) {
        let far = length(sum);
        let before = normal.map(f64::from);
        if far > 0.0 && dot(sum, before) >= LEAST_COSINE * far * length(before) {
            *normal = sum.map(|x| (x / far) as f32);
        }
    }
}
