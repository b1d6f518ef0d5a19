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
        let bounds = |i: &u32| &self.items[*i as usize].bounds;
        let below = references.iter().filter(|i| cut.sides(bounds(i)).0).count();
        let above = references.iter().filter(|i| cut.sides(bounds(i)).1).count();
        if below + above > budget || (below == count && above == count) {
            return Ok(leaf(references));
        }
        let mut lower = room("references", below)?;
        lower.extend(references.iter().filter(|i| cut.sides(bounds(i)).0));
        let mut upper = room("references", above)?;
        upper.extend(references.iter().filter(|i| cut.sides(bounds(i)).1));
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
        let count = references.len();
        let whole = cell.half_area();
        let mut best_cost = count as f32 * whole;
        let mut best = None;
        for axis in 0..3 {
            let clip = |x: f32| greatest(least(x, cell.max[axis]), cell.min[axis]);
            let spans = references.iter().map(|&i| &self.items[i as usize].bounds);
            let spans = spans.map(|b| (clip(b.min[axis]), clip(b.max[axis])));
            let ends = |(low, high): (f32, f32), (a, b): (f32, f32)| (least(low, a), greatest(high, b));
            let (low, high) = spans.clone().fold((f32::INFINITY, f32::NEG_INFINITY), ends);
            let scale = BINS as f32 / (high - low);
            if scale.is_finite() {
                let bin = |x: f32| (((x - low) * scale) as usize).min(BINS - 1);
                let (mut starts, mut stops) = ([0_usize; BINS], [0_usize; BINS]);
                for (a, b) in spans {
                    starts[bin(a)] += 1;
                    stops[bin(b)] += 1;
                }
                let (mut below, mut above) = (0, count);
                for i in 1..BINS {
                    below += starts[i - 1];
                    above -= stops[i - 1];
                    consider(cell, Cut { axis, at: low + i as f32 / scale }, below, above, &mut best, &mut best_cost);
                }
            }
            // The ends of what is there cut off empty space.
            consider(cell, Cut { axis, at: low.next_down() }, 0, count, &mut best, &mut best_cost);
            consider(cell, Cut { axis, at: high }, count, 0, &mut best, &mut best_cost);
        }
        best
    }
}

fn consider(cell: &Bounds, cut: Cut, below: usize, above: usize, best: &mut Option<Cut>, best_cost: &mut f32) {
    let Cut { axis, at } = cut;
    if !(cell.min[axis] < at && at < cell.max[axis]) {
        return;
    }
    let (mut lower, mut upper) = (*cell, *cell);
    (lower.max[axis], upper.min[axis]) = (at, at);
    let tests = lower.half_area() * below as f32 + upper.half_area() * above as f32;
    let factor = if below == 0 || above == 0 { EMPTY_FACTOR } else { 1.0 };
    let cost = factor * (STEP_COST * cell.half_area() + tests);
    if cost < *best_cost {
        (*best, *best_cost) = (Some(cut), cost);
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
