//! A block as from a workshop: a slot, a step, a hole from side to side, a pocket, and flanks that lean in towards the top. All its
//! faces are flat, and cut into small triangles.

use super::mesh::Mesh;
use glam::{DVec3, dvec3};
use std::collections::BTreeMap;

/// What positions are rounded to.
const QUANTUM: f64 = 1.0 / 1000.0;
/// Cells along x, y and z.
const CELLS: [i32; 3] = [14, 14, 26];
/// The box about the block.
const LOW: DVec3 = dvec3(-8.2, -10.0, -19.0);
const HIGH: DVec3 = dvec3(11.8, 10.0, 19.0);
/// Above this height the flanks lean, by so much of x for each unit of height.
const LEAN_FROM: f64 = 0.0;
const LEAN: f64 = 0.03;

/// The compressed PLY file.
pub fn ply_gz() -> Vec<u8> {
    mesh().ply_gz(QUANTUM)
}

/// Whether a cell is of the block.
fn is_solid([x, y, z]: [i32; 3]) -> bool {
    let inside = [x, y, z].iter().zip(CELLS).all(|(&c, n)| (0..n).contains(&c));
    let slot = (5..9).contains(&x) && y >= 10;
    let step = z >= 20 && y >= 7;
    let hole = (3..6).contains(&y) && (4..9).contains(&z);
    let pocket = x >= 11 && (2..5).contains(&y) && (13..18).contains(&z);
    inside && !slot && !step && !hole && !pocket
}

/// The surface between cells of the block and others, two triangles for each side.
pub fn mesh() -> Mesh {
    let mut mesh = Mesh::default();
    let mut numbers = BTreeMap::new();
    let cells = (0..CELLS[2]).flat_map(|z| (0..CELLS[1]).flat_map(move |y| (0..CELLS[0]).map(move |x| [x, y, z])));
    for cell in cells.filter(|cell| is_solid(*cell)) {
        for axis in 0..3 {
            for side in [0, 1] {
                let mut beside = cell;
                beside[axis] += 2 * side - 1;
                if !is_solid(beside) {
                    side_of_cell(&mut mesh, &mut numbers, cell, axis, side);
                }
            }
        }
    }
    mesh
}

fn side_of_cell(mesh: &mut Mesh, numbers: &mut BTreeMap<[i32; 3], u32>, cell: [i32; 3], axis: usize, side: i32) {
    let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
    let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(a, b)| {
        let mut corner = cell;
        corner[axis] += side;
        corner[u] += a;
        corner[v] += b;
        *numbers.entry(corner).or_insert_with(|| {
            mesh.positions.push(place(corner));
            mesh.positions.len() as u32 - 1
        })
    });
    let [a, b, c, d] = if side == 1 { corners } else { [corners[0], corners[3], corners[2], corners[1]] };
    // Diagonals go to and fro, as a mesher's do.
    if (cell[u] + cell[v]) % 2 == 0 {
        mesh.triangles.extend([[a, b, c], [a, c, d]]);
    } else {
        mesh.triangles.extend([[a, b, d], [b, c, d]]);
    }
}

/// Where a corner of cells is. Leaning keeps planes across one axis planes.
fn place(corner: [i32; 3]) -> DVec3 {
    let [x, y, z] = [0, 1, 2].map(|i| f64::from(corner[i]) / f64::from(CELLS[i]));
    let p = LOW + (HIGH - LOW) * dvec3(x, y, z);
    let middle = (LOW.x + HIGH.x) / 2.0;
    let shrink = 1.0 - LEAN * (p.y - LEAN_FROM).max(0.0);
    dvec3(middle + (p.x - middle) * shrink, p.y, p.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_block_is_one_closed_solid_of_the_paper_s_size() {
        let block = mesh();
        assert_eq!(block.triangles.len(), 4268);
        assert_eq!(block.open_edges(), 0);
        let solids: Vec<f64> = block.solids().into_values().collect();
        assert!(solids.len() == 1 && solids[0] > 9000.0, "{solids:?}");
        let [low, high] = block.bounds();
        assert!(low.distance(LOW) < 1e-9 && high.distance(HIGH) < 1e-9, "{low} {high}");
        // One hole: V - E + F = 0.
        let euler = block.positions.len() as i64 - block.triangles.len() as i64 / 2;
        assert_eq!(euler, 0);
    }
}
