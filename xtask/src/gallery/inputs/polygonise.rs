//! The surface where a function is 0, as a closed mesh: marching cubes whose faces are traced round each cell, so that no table is
//! needed and every edge has two faces, then relaxed to even triangles.

use super::mesh::Mesh;
use glam::DVec3;

/// A function that is negative inside, positive outside, and grows at most by `STEEPEST` a metre.
pub trait Field: Sync {
    fn at(&self, p: DVec3) -> f64;
}

const STEEPEST: f64 = 1.6;
/// Cells along a block's side. Blocks that the surface is far from are not looked into.
const BLOCK: usize = 8;

/// Corners of a cell: bit 0 is x, bit 1 is y, bit 2 is z.
/// Sides of a cell, each with its corners counter-clockwise seen from outside.
const SIDES: [[usize; 4]; 6] = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];

struct Grid {
    low: DVec3,
    cell: f64,
    /// Nodes along each axis.
    nodes: [usize; 3],
    values: Vec<f64>,
}

impl Grid {
    fn new(field: &impl Field, low: DVec3, high: DVec3, cell: f64) -> Self {
        let nodes = ((high - low) / cell).ceil().to_array().map(|n| (n as usize).next_multiple_of(BLOCK) + 1);
        let mut grid = Self { low, cell, nodes, values: vec![f64::NAN; nodes.iter().product()] };
        let slab = nodes[0] * nodes[1] * BLOCK;
        let threads = std::thread::available_parallelism().map_or(1, usize::from);
        let shape = (low, cell, nodes);
        let mut slabs: Vec<(usize, &mut [f64])> = grid.values.chunks_mut(slab).enumerate().collect();
        let each = slabs.len().div_ceil(threads);
        std::thread::scope(|scope| {
            while !slabs.is_empty() {
                let some: Vec<_> = slabs.drain(..each.min(slabs.len())).collect();
                scope.spawn(move || some.into_iter().for_each(|(i, values)| fill(field, shape, i * BLOCK, values)));
            }
        });
        grid
    }

    fn node(&self, [x, y, z]: [usize; 3]) -> usize {
        (z * self.nodes[1] + y) * self.nodes[0] + x
    }

    fn place(&self, [x, y, z]: [usize; 3]) -> DVec3 {
        self.low + DVec3::new(x as f64, y as f64, z as f64) * self.cell
    }
}

/// Values at the nodes of a slab of blocks whose first layer is `z0`.
fn fill(field: &impl Field, (low, cell, nodes): (DVec3, f64, [usize; 3]), z0: usize, values: &mut [f64]) {
    let layers = values.len() / (nodes[0] * nodes[1]);
    for y0 in (0..nodes[1]).step_by(BLOCK) {
        for x0 in (0..nodes[0]).step_by(BLOCK) {
            let half = BLOCK as f64 / 2.0;
            let middle = low + (DVec3::new(x0 as f64, y0 as f64, z0 as f64) + half) * cell;
            let value = field.at(middle);
            let far = value.abs() > STEEPEST * half * cell * 1.75;
            for z in 0..layers {
                for y in y0..(y0 + BLOCK).min(nodes[1]) {
                    for x in x0..(x0 + BLOCK).min(nodes[0]) {
                        let p = low + DVec3::new(x as f64, y as f64, (z0 + z) as f64) * cell;
                        values[(z * nodes[1] + y) * nodes[0] + x] = if far { value } else { field.at(p) };
                    }
                }
            }
        }
    }
}

/// The surface of `field` inside of the box from `low` to `high`, which it must not touch, from cells of that size.
pub fn polygonise(field: &impl Field, low: DVec3, high: DVec3, cell: f64) -> Mesh {
    let grid = Grid::new(field, low, high, cell);
    let mut mesh = Mesh::default();
    let mut crossings = vec![u32::MAX; 3 * grid.values.len()];
    let [nx, ny, nz] = grid.nodes.map(|n| n - 1);
    for z in 0..nz {
        for y in 0..ny {
            for x in 0..nx {
                cell_faces(&grid, [x, y, z], &mut crossings, &mut mesh);
            }
        }
    }
    mesh
}

fn cell_faces(grid: &Grid, [x, y, z]: [usize; 3], crossings: &mut [u32], mesh: &mut Mesh) {
    let corner = |c: usize| [x + (c & 1), y + (c >> 1 & 1), z + (c >> 2)];
    let values: [f64; 8] = std::array::from_fn(|c| grid.values[grid.node(corner(c))]);
    let inside = values.map(|v| v < 0.0);
    if inside == [true; 8] || inside == [false; 8] {
        return;
    }
    // An edge of the cell is named by its lower corner and its axis.
    let edge = |a: usize, b: usize| 3 * a.min(b) + (a ^ b).trailing_zeros() as usize;
    let mut next = [usize::MAX; 24];
    for side in SIDES {
        let crossing = |i: usize| (side[i % 4], side[(i + 1) % 4]);
        for i in 0..4 {
            let (a, b) = crossing(i);
            if inside[a] || !inside[b] {
                continue;
            }
            // From where the outline enters to where it leaves: corners inside that lie across from each other stay apart, the
            // same way as seen from the other side.
            let leaving = (i + 1..i + 4).map(crossing).find(|&(a, b)| inside[a] && !inside[b]);
            let (c, d) = leaving.expect("an outline that enters leaves");
            next[edge(a, b)] = edge(c, d);
        }
    }
    for start in 0..24 {
        let mut ring = Vec::new();
        let mut on_sides = Vec::new();
        let mut e = start;
        while next[e] != usize::MAX {
            let (a, axis) = (e / 3, e % 3);
            let b = a | 1 << axis;
            let slot = &mut crossings[3 * grid.node(corner(a)) + axis];
            if *slot == u32::MAX {
                *slot = mesh.positions.len() as u32;
                let t = (values[a] / (values[a] - values[b])).clamp(0.05, 0.95);
                mesh.positions.push(grid.place(corner(a)).lerp(grid.place(corner(b)), t));
            }
            ring.push(*slot);
            on_sides.push(SIDES.map(|side| side.contains(&a) && side.contains(&b)));
            e = std::mem::replace(&mut next[e], usize::MAX);
        }
        fan(&ring, &on_sides, mesh);
    }
}

/// Cuts a ring into triangles. A diagonal within a side of the cell could be the neighbour's diagonal too, and then have four
/// faces; a vertex in the middle avoids it.
fn fan(ring: &[u32], on_sides: &[[bool; 6]], mesh: &mut Mesh) {
    let apart = |i: usize, j: usize| (0..6).all(|s| !(on_sides[i][s] && on_sides[j][s]));
    match *ring {
        [] => (),
        [a, b, c] => mesh.triangles.push([a, b, c]),
        [a, b, c, d] if apart(0, 2) || apart(1, 3) => {
            let length = |i: u32, j: u32| mesh.positions[i as usize].distance_squared(mesh.positions[j as usize]);
            let first = apart(0, 2) && (!apart(1, 3) || length(a, c) <= length(b, d));
            mesh.triangles.extend(if first { [[a, b, c], [a, c, d]] } else { [[b, c, d], [b, d, a]] });
        }
        _ => {
            let middle = ring.iter().map(|&i| mesh.positions[i as usize]).sum::<DVec3>() / ring.len() as f64;
            let m = mesh.positions.len() as u32;
            mesh.positions.push(middle);
            mesh.triangles.extend((0..ring.len()).map(|i| [ring[i], ring[(i + 1) % ring.len()], m]));
        }
    }
}

/// Moves vertices towards the middles of their neighbours and back to the surface, for more even triangles.
pub fn relax(field: &impl Field, mesh: &mut Mesh, cell: f64) {
    const ROUNDS: usize = 6;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    for _ in 0..ROUNDS {
        let mut sums = vec![(DVec3::ZERO, 0u32); mesh.positions.len()];
        for t in &mesh.triangles {
            for i in 0..3 {
                let sum = &mut sums[t[i] as usize];
                sum.0 += mesh.positions[t[(i + 1) % 3] as usize];
                sum.1 += 1;
            }
        }
        let each = sums.len().div_ceil(threads).max(1);
        std::thread::scope(|scope| {
            for (positions, sums) in mesh.positions.chunks_mut(each).zip(sums.chunks(each)) {
                scope.spawn(move || {
                    for (p, (sum, count)) in positions.iter_mut().zip(sums) {
                        *p = relaxed(field, *p, *sum / f64::from((*count).max(1)), cell);
                    }
                });
            }
        });
    }
}

/// Half of the way from `p` to `goal`, along the surface, then a Newton step onto it of at most half a cell.
fn relaxed(field: &impl Field, p: DVec3, goal: DVec3, cell: f64) -> DVec3 {
    let e = 0.1 * cell;
    let slope = |axis: DVec3| (field.at(p + axis * e) - field.at(p - axis * e)) / (2.0 * e);
    let gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
    let normal = gradient.normalize_or_zero();
    let step = goal - p;
    let moved = p + 0.5 * (step - normal * normal.dot(step));
    let back = gradient * (field.at(moved) / gradient.length_squared().max(0.1));
    moved - back.clamp_length_max(0.5 * cell)
}
