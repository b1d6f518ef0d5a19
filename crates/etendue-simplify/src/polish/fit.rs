//! Least squares: where the nodes should be for what points and faces say.

use super::net::Net;

/// A symmetric 3x3 matrix: xx, yy, zz, xy, xz, yz.
type Symmetric = [f64; 6];

/// Sweeps over all nodes.
const SWEEPS: usize = 12;

/// Of a node's own share in the squares, what holds it back.
const DAMPING: f64 = 0.1;

/// How much a distance along the tangent plane counts, relative to one across.
const TANGENTIAL: f64 = 0.05;

/// The normal equations, by node and by edge.
pub(super) struct Fit<'a> {
    net: &'a Net,
    diagonal: Vec<Symmetric>,
    edges: Vec<Symmetric>,
    right: Vec<[f64; 3]>,
}

/// What a point asks for: that its place in a face moves by a residual.
pub(super) struct Wish {
    pub face: u32,
    /// Of the face's corners.
    pub weights: [f64; 3],
    pub residual: [f64; 3],
    /// Unit normal of the tangent plane.
    pub normal: [f64; 3],
    /// How much it counts.
    pub importance: f64,
}

impl<'a> Fit<'a> {
    pub fn new(net: &'a Net) -> Self {
        Self {
            net,
            diagonal: vec![[0.0; 6]; net.positions.len()],
            edges: vec![[0.0; 6]; net.edges.len()],
            right: vec![[0.0; 3]; net.positions.len()],
        }
    }

    pub fn add(&mut self, wish: &Wish) {
        let [x, y, z] = wish.normal;
        let (across, along) = (wish.importance * (1.0 - TANGENTIAL), wish.importance * TANGENTIAL);
        let metric = [
            across * x * x + along,
            across * y * y + along,
            across * z * z + along,
            across * x * y,
            across * x * z,
            across * y * z,
        ];
        let pull = times(&metric, wish.residual);
        let nodes = self.net.faces[wish.face as usize];
        let edges = self.net.face_edges[wish.face as usize];
        for i in 0..3 {
            let weight = wish.weights[i];
            let node = nodes[i] as usize;
            add(&mut self.diagonal[node], &metric, weight * weight);
            (0..3).for_each(|axis| self.right[node][axis] += weight * pull[axis]);
            add(&mut self.edges[edges[i] as usize], &metric, weight * wish.weights[(i + 1) % 3]);
        }
    }

    /// How far each node should move; those that may not have `false`.
    pub fn solve(mut self, may_move: &[bool]) -> Vec<[f64; 3]> {
        let mut moves = vec![[0.0; 3]; self.net.positions.len()];
        let neighbours = super::net::Grouped::new(self.net.positions.len(), &self.net.edges);
        let inverses: Vec<Symmetric> = self
            .diagonal
            .iter_mut()
            .map(|diagonal| {
                let held = DAMPING * (diagonal[0] + diagonal[1] + diagonal[2]) / 3.0;
                (0..3).for_each(|axis| diagonal[axis] += held);
                inverse(diagonal)
            })
            .collect();
        for _ in 0..SWEEPS {
            for node in (0..moves.len()).filter(|&node| may_move[node]) {
                let mut right = self.right[node];
                for &edge in neighbours.of(node as u32) {
                    let [a, b] = self.net.edges[edge as usize];
                    let other = moves[(a + b) as usize - node];
                    let pull = times(&self.edges[edge as usize], other);
                    (0..3).for_each(|axis| right[axis] -= pull[axis]);
                }
                moves[node] = times(&inverses[node], right);
            }
        }
        moves
    }
}

fn add(to: &mut Symmetric, matrix: &Symmetric, factor: f64) {
    (0..6).for_each(|i| to[i] += factor * matrix[i]);
}

fn times([xx, yy, zz, xy, xz, yz]: &Symmetric, [x, y, z]: [f64; 3]) -> [f64; 3] {
    [xx * x + xy * y + xz * z, xy * x + yy * y + yz * z, xz * x + yz * y + zz * z]
}

/// 0 if there is none.
fn inverse([xx, yy, zz, xy, xz, yz]: &Symmetric) -> Symmetric {
    let (a, b, c) = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    let determinant = xx * a + xy * b + xz * c;
    if !(determinant > 0.0 && determinant.is_finite()) {
        return [0.0; 6];
    }
    [a, xx * zz - xz * xz, xx * yy - xy * xy, b, c, xy * xz - xx * yz].map(|x| x / determinant)
}
