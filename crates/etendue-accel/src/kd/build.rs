//! Builds kd-trees by the surface-area heuristic on 32 candidate planes an axis, or by midpoints.

use super::{DEPTH_LIMIT, Node};
use crate::accelerator::KdTreeSplit;
use crate::bounds::{Bounds, greatest, least};
use crate::error::{BuildError, limited, room};
use crate::items::Item;

const BINS: usize = 32;

/// Cost of a step down relative to a primitive test.
const STEP_COST: f32 = 1.0;

/// Cutting off empty space is worth this factor.
const EMPTY_FACTOR: f32 = 0.8;

/// Midpoint splits stop at this many primitives.
const MIDPOINT_LEAF: usize = 4;

/// References per item, at most.
const COPIES: usize = 6;

/// Above this many items the halves are built in parallel.
const PARALLEL_ITEMS: usize = 4096;

/// A part of a tree with indices relative to its own vectors.
pub(super) struct Subtree {
    pub nodes: Vec<Node>,
    pub references: Vec<u32>,
    /// Nodes on the longest way down.
    pub depth: usize,
}

/// Builds the nodes and references over items.
pub(super) fn build(items: &[Item], bounds: &Bounds, split: KdTreeSplit) -> Result<Subtree, BuildError> {
    let mut all = room("references", items.len())?;
    all.extend(0..items.len() as u32);
    limited("references", items.len().saturating_mul(COPIES), u64::from(u32::MAX))?;
    let depth = (8 + items.len().max(1).ilog2() as usize * 13 / 10).min(DEPTH_LIMIT - 1);
    let builder = Builder { items, split };
    builder.subdivide(all, bounds, depth, items.len() * COPIES)
}

struct Builder<'a> {
    items: &'a [Item],
    split: KdTreeSplit,
}

/// A plane.
#[derive(Clone, Copy)]
struct Cut {
    axis: usize,
    at: f32,
}

impl Cut {
    /// A box lies below, above, or on both sides; what lies in the plane counts as below.
    fn sides(&self, bounds: &Bounds) -> (bool, bool) {
        let (low, high) = (bounds.min[self.axis], bounds.max[self.axis]);
        (low < self.at || high <= self.at, high > self.at)
    }
}

impl Builder<'_> {
    /// `depth` more levels are allowed, and `budget` references below.
    fn subdivide(
        &self,
        references: Vec<u32>,
        cell: &Bounds,
        depth: usize,
        budget: usize,
    ) -> Result<Subtree, BuildError> {
        let count = references.len();
        let cut = if depth == 0 || count <= 1 { None } else { self.choose(&references, cell) };
        let Some(cut) = cut else { return Ok(leaf(references)) };
        let bounds = |i: &u32| self.items[*i as usize].bounds();
        let below = references.iter().filter(|i| cut.sides(&bounds(i)).0).count();
        let above = references.iter().filter(|i| cut.sides(&bounds(i)).1).count();
        if below + above > budget || (below == count && above == count) {
            return Ok(leaf(references));
        }
        let mut lower = room("references", below)?;
        lower.extend(references.iter().filter(|i| cut.sides(&bounds(i)).0));
        let mut upper = room("references", above)?;
        upper.extend(references.iter().filter(|i| cut.sides(&bounds(i)).1));
        drop(references);
        let (mut lower_cell, mut upper_cell) = (*cell, *cell);
        lower_cell.max[cut.axis] = cut.at;
        upper_cell.min[cut.axis] = cut.at;
        let lower_budget =
            below + ((budget - below - above) as u128 * below as u128 / (below + above) as u128) as usize;
        let build_lower = || self.subdivide(lower, &lower_cell, depth - 1, lower_budget);
        let build_upper = || self.subdivide(upper, &upper_cell, depth - 1, budget - lower_budget);
        let (lower, upper) =
            if count > PARALLEL_ITEMS { rayon::join(build_lower, build_upper) } else { (build_lower(), build_upper()) };
        join(cut, lower?, upper?)
    }

    fn choose(&self, references: &[u32], cell: &Bounds) -> Option<Cut> {
        match self.split {
            KdTreeSplit::SurfaceArea => self.cheapest(references, cell),
            KdTreeSplit::Midpoint => {
                let axis = cell.longest_axis();
                let at = cell.min[axis] * 0.5 + cell.max[axis] * 0.5;
                let splits = references.len() > MIDPOINT_LEAF && cell.min[axis] < at && at < cell.max[axis];
                splits.then_some(Cut { axis, at })
            }
        }
    }

    fn cheapest(&self, references: &[u32], cell: &Bounds) -> Option<Cut> {
        let clipped = |&i: &u32| {
            let bounds = self.items[i as usize].bounds();
            let clip = |p: [f32; 3]| [0, 1, 2].map(|a| greatest(least(p[a], cell.max[a]), cell.min[a]));
            Bounds { min: clip(bounds.min), max: clip(bounds.max) }
        };
        let used = references.iter().map(clipped).fold(Bounds::EMPTY, |used, bounds| used.join(&bounds));
        // Infinite where everything lies in one plane.
        let scale = [0, 1, 2].map(|a| BINS as f32 / (used.max[a] - used.min[a]));
        let bin = |x: f32, axis: usize| (((x - used.min[axis]) * scale[axis]) as usize).min(BINS - 1);
        let (mut starts, mut stops) = ([[0_usize; BINS]; 3], [[0_usize; BINS]; 3]);
        for bounds in references.iter().map(clipped) {
            for axis in 0..3 {
                starts[axis][bin(bounds.min[axis], axis)] += 1;
                stops[axis][bin(bounds.max[axis], axis)] += 1;
            }
        }
        let count = references.len();
        let mut best = Best { cell, cut: None, cost: count as f32 * cell.half_area() };
        for axis in 0..3 {
            if scale[axis].is_finite() {
                let (mut below, mut above) = (0, count);
                for i in 1..BINS {
                    below += starts[axis][i - 1];
                    above -= stops[axis][i - 1];
                    best.consider(Cut { axis, at: used.min[axis] + i as f32 / scale[axis] }, below, above);
                }
            }
            // The ends of what is there cut off empty space.
            best.consider(Cut { axis, at: used.min[axis].next_down() }, 0, count);
            best.consider(Cut { axis, at: used.max[axis] }, count, 0);
        }
        best.cut
    }
}

/// The cheapest cut of a cell so far.
struct Best<'a> {
    cell: &'a Bounds,
    cut: Option<Cut>,
    cost: f32,
}

impl Best<'_> {
    fn consider(&mut self, cut: Cut, below: usize, above: usize) {
        let Cut { axis, at } = cut;
        if !(self.cell.min[axis] < at && at < self.cell.max[axis]) {
            return;
        }
        let (mut lower, mut upper) = (*self.cell, *self.cell);
        (lower.max[axis], upper.min[axis]) = (at, at);
        let tests = lower.half_area() * below as f32 + upper.half_area() * above as f32;
        let factor = if below == 0 || above == 0 { EMPTY_FACTOR } else { 1.0 };
        let cost = factor * (STEP_COST * self.cell.half_area() + tests);
        if cost < self.cost {
            (self.cut, self.cost) = (Some(cut), cost);
        }
    }
}

fn leaf(references: Vec<u32>) -> Subtree {
    let nodes = vec![Node::Leaf { first: 0, count: references.len() as u32 }];
    Subtree { nodes, references, depth: 1 }
}

fn join(cut: Cut, mut lower: Subtree, upper: Subtree) -> Result<Subtree, BuildError> {
    let (lower_nodes, lower_references) = (lower.nodes.len() as u32, lower.references.len() as u32);
    limited("nodes", 1 + lower.nodes.len() + upper.nodes.len(), u64::from(u32::MAX))?;
    let mut nodes = room("nodes", 1 + lower.nodes.len() + upper.nodes.len())?;
    nodes.push(Node::Inner { axis: cut.axis as u8, at: cut.at, upper: 1 + lower_nodes });
    nodes.extend(lower.nodes.iter().map(|node| shifted(*node, 1, 0)));
    nodes.extend(upper.nodes.iter().map(|node| shifted(*node, 1 + lower_nodes, lower_references)));
    let bytes = size_of_val(&upper.references[..]) as u64;
    lower
        .references
        .try_reserve(upper.references.len())
        .map_err(|_| BuildError::Memory { what: "references", bytes })?;
    lower.references.extend_from_slice(&upper.references);
    Ok(Subtree { nodes, references: lower.references, depth: 1 + lower.depth.max(upper.depth) })
}

fn shifted(node: Node, by_nodes: u32, by_references: u32) -> Node {
    match node {
        Node::Inner { axis, at, upper } => Node::Inner { axis, at, upper: upper + by_nodes },
        Node::Leaf { first, count } => Node::Leaf { first: first + by_references, count },
    }
}
