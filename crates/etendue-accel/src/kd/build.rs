//! Builds kd-trees: planes by the surface-area heuristic, or through the middle of cells.
//!
//! What a cell lists is what the parts of primitives inside of it meet, not what their boxes meet ("perfect splits": Wald and Havran,
//! "On building fast kd-trees for ray tracing, and on doing that in O(N log N)", 2006).

use super::DEPTH_LIMIT;
use super::plane::{Cut, cheapest, middle};
use super::reference::{Reference, Splitter};
use crate::accelerator::KdTreeSplit;
use crate::bounds::Bounds;
use crate::error::{BuildError, limited, room};
use crate::items::Item;
use crate::source::Source;

/// References per item, at most.
const COPIES: usize = 6;

/// Above this many references the halves are built in parallel.
const PARALLEL: usize = 4096;

/// A node in order of depth first: an inner node's lower child follows it.
#[derive(Clone, Copy, Debug)]
pub(super) enum Draft {
    /// Cut at a coordinate of an axis; the upper child is at an index.
    Inner { axis: u8, at: f32, upper: u32 },
    /// A range of the references.
    Leaf { first: u32, count: u32 },
}

/// A part of a tree with indices relative to its own vectors.
#[derive(Default)]
pub(super) struct Subtree {
    pub nodes: Vec<Draft>,
    /// Indices of items, by leaf.
    pub references: Vec<u32>,
}

/// Builds the nodes and references over items.
pub(super) fn build(
    items: &[Item],
    source: Source<'_>,
    bounds: &Bounds,
    split: KdTreeSplit,
) -> Result<Subtree, BuildError> {
    let budget = items.len().saturating_mul(COPIES);
    limited("references", budget, u64::from(u32::MAX))?;
    let mut all = room("references", items.len())?;
    all.extend(items.iter().enumerate().map(|(item, of)| Reference { bounds: of.bounds(), item: item as u32 }));
    let depth = (8 + items.len().max(1).ilog2() as usize * 13 / 10).min(DEPTH_LIMIT - 1);
    let builder = Builder { splitter: Splitter { items, source }, split };
    let mut tree = Subtree::default();
    builder.subdivide(all, bounds, depth, budget, &mut tree)?;
    Ok(tree)
}

struct Builder<'a> {
    splitter: Splitter<'a>,
    split: KdTreeSplit,
}

impl Builder<'_> {
    /// Appends a subtree; `depth` more levels are allowed, and `budget` references below.
    fn subdivide(
        &self,
        references: Vec<Reference>,
        cell: &Bounds,
        depth: usize,
        budget: usize,
        tree: &mut Subtree,
    ) -> Result<(), BuildError> {
        let count = references.len();
        let cut = if depth == 0 || count <= 1 { None } else { self.choose(&references, cell) };
        let Some(cut) = cut else { return tree.leaf(&references) };
        let cells = cut.halves(cell);
        let [lower, upper] = self.splitter.split(&references, cut, &cells)?;
        let (below, above) = (lower.len(), upper.len());
        if below + above > budget || (below >= count && above >= count) {
            return tree.leaf(&references);
        }
        drop(references);
        let spare = (budget - below - above) as u128 * below as u128 / (below + above).max(1) as u128;
        let lower_budget = below + spare as usize;
        let place = tree.inner(cut)?;
        if count <= PARALLEL {
            self.subdivide(lower, &cells[0], depth - 1, lower_budget, tree)?;
            tree.upper_follows(place);
            return self.subdivide(upper, &cells[1], depth - 1, budget - lower_budget, tree);
        }
        let half = |references, cell, budget| {
            let mut half = Subtree::default();
            self.subdivide(references, cell, depth - 1, budget, &mut half).map(|()| half)
        };
        let (lower, upper) =
            rayon::join(|| half(lower, &cells[0], lower_budget), || half(upper, &cells[1], budget - lower_budget));
        tree.append(lower?)?;
        tree.upper_follows(place);
        tree.append(upper?)
    }

    fn choose(&self, references: &[Reference], cell: &Bounds) -> Option<Cut> {
        match self.split {
            KdTreeSplit::SurfaceArea => cheapest(references, cell),
            KdTreeSplit::Midpoint => middle(references.len(), cell),
        }
    }
}

impl Subtree {
    /// Appends an inner node whose upper child is not known yet; its place.
    fn inner(&mut self, cut: Cut) -> Result<usize, BuildError> {
        let place = self.nodes.len();
        self.push(Draft::Inner { axis: cut.axis as u8, at: cut.at, upper: 0 })?;
        Ok(place)
    }

    /// What is appended next is the upper child of the node at a place.
    fn upper_follows(&mut self, place: usize) {
        let next = self.nodes.len() as u32;
        if let Draft::Inner { upper, .. } = &mut self.nodes[place] {
            *upper = next;
        }
    }

    fn leaf(&mut self, references: &[Reference]) -> Result<(), BuildError> {
        let first = self.references.len() as u32;
        grow(&mut self.references, references.len(), "references")?;
        self.references.extend(references.iter().map(|reference| reference.item));
        self.push(Draft::Leaf { first, count: references.len() as u32 })
    }

    fn push(&mut self, node: Draft) -> Result<(), BuildError> {
        grow(&mut self.nodes, 1, "nodes")?;
        self.nodes.push(node);
        Ok(())
    }

    fn append(&mut self, other: Self) -> Result<(), BuildError> {
        let (nodes, references) = (self.nodes.len() as u32, self.references.len() as u32);
        grow(&mut self.nodes, other.nodes.len(), "nodes")?;
        grow(&mut self.references, other.references.len(), "references")?;
        self.nodes.extend(other.nodes.into_iter().map(|node| match node {
            Draft::Inner { axis, at, upper } => Draft::Inner { axis, at, upper: upper + nodes },
            Draft::Leaf { first, count } => Draft::Leaf { first: first + references, count },
        }));
        self.references.extend_from_slice(&other.references);
        Ok(())
    }
}

/// Makes room for so many more, of which there may be 2^32 in all.
fn grow<T>(vector: &mut Vec<T>, more: usize, what: &'static str) -> Result<(), BuildError> {
    let count = vector.len().saturating_add(more);
    limited(what, count, u64::from(u32::MAX))?;
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    vector.try_reserve(more).map_err(|_| BuildError::Memory { what, bytes })
}
