//! A binary tree by binned surface-area heuristic, in parallel, the same for any number of threads.
//!
//! (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007.) What wide nodes are best made of it is
//! found on the way back up (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
//! BVHs", 2017).

use bytemuck::Zeroable;
use rayon::prelude::*;

use super::bins::{Binning, Bins, Measure, Split};
use super::divide::{CHUNK, Divided, divide, divide_in_parallel};
use super::node::{Child, LANES, WIDTH};
use crate::bounds::{Bounds, least};
use crate::error::BuildError;
use crate::isa::{Isa, Kernel, SimdKernel, dispatch, run};
use crate::items::{Item, ItemKind};
use crate::simd::Simd;
use crate::source::Source;

/// Cost of a binary split relative to a pack test: a third of an 8-wide node, as each absorbs three levels.
const SPLIT_COST: f32 = 0.35;

/// Cost of a wide node relative to a pack test.
const NODE_COST: f32 = 1.0;

/// Up to this many items a subtree is one thread's work.
const SERIAL_ITEMS: usize = 4096;

/// Splits are by cost only while a tree of halves below them stays within this depth.
const DEPTH_LIMIT: u32 = 60;

/// A node of the binary tree over a range of the reordered items. The left child follows its parent.
#[derive(Clone, Copy, Debug, Zeroable)]
pub(crate) struct BinaryNode {
    pub bounds: Bounds,
    /// Distance to the right child; 0 for a leaf.
    pub right: u32,
    /// First item of a leaf.
    pub first: u32,
    /// Items below.
    pub count: u32,
    /// Least costs of this subtree as at most one, two, ... seven children of a wide node, see [`forest_costs`].
    pub costs: [f32; WIDTH - 1],
}

impl BinaryNode {
    pub fn is_leaf(&self) -> bool {
        self.right == 0
    }

    /// A leaf, for now.
    #[inline(always)]
    fn new(measure: &Measure, count: usize, first: u32) -> Self {
        let costs = [measure.bounds.half_area() * packs(count as u32); WIDTH - 1];
        Self { bounds: measure.bounds.bounds(), right: 0, first, count: count as u32, costs }
    }
}

/// Builds the tree, reordering the items; at least one item. The root comes first. A subtree of n items has 2n - 1 places;
/// where threads may share the work, so many are set aside, so that places do not depend on who finishes first.
///
/// The first items can be set apart, some but not all of them: then the root's left half holds them and its right half the
/// others.
pub(crate) fn build(
    items: &mut [Item],
    source: Source<'_>,
    apart: usize,
    isa: Isa,
) -> Result<Vec<BinaryNode>, BuildError> {
    let places = 2 * items.len() - 1;
    let bytes = (places * size_of::<BinaryNode>()) as u64;
    // Zeroed by the system: what is not used costs nothing.
    let mut nodes = bytemuck::try_zeroed_vec(places).map_err(|()| BuildError::Memory { what: "tree nodes", bytes })?;
    // With AVX-512 what is stored depends on masks, which the next load has to wait for: three times as slow.
    let isa = isa.min(Isa::Avx2);
    let builder = Builder { source, sole_kind: source.sole_kind(), isa };
    let measure = measure_in_parallel(items, isa);
    let parts = (1..items.len()).contains(&apart).then(|| {
        let (first, others) = items.split_at(apart);
        Parts { middle: apart, measures: [measure_in_parallel(first, isa), measure_in_parallel(others, isa)] }
    });
    builder.subdivide(items, &mut nodes, &measure, (0, 0), parts);
    Ok(nodes)
}

struct Builder<'a> {
    source: Source<'a>,
    /// What all items are, if that is known.
    sole_kind: Option<ItemKind>,
    isa: Isa,
}

impl Builder<'_> {
    /// Builds a subtree whose items have a measure, at a place in all items and a depth. Its halves may be given.
    fn subdivide(
        &self,
        items: &mut [Item],
        nodes: &mut [BinaryNode],
        measure: &Measure,
        (first, depth): (u32, u32),
        parts: Option<Parts>,
    ) {
        if items.len() <= SERIAL_ITEMS && parts.is_none() {
            return dispatch(self.isa, Subtree { builder: self, items, nodes, measure, first, depth });
        }
        let Some((node, below)) = nodes.split_first_mut() else { return };
        *node = BinaryNode::new(measure, items.len(), first);
        let parts = parts.or_else(|| self.partition(items, measure, depth, &mut Many { isa: self.isa }));
        let Some(Parts { middle, measures: [left_measure, right_measure] }) = parts else { return };
        let (left_items, right_items) = items.split_at_mut(middle);
        let right_first = first + middle as u32;
        let places = 2 * middle - 1;
        node.right = 1 + places as u32;
        let (left_nodes, right_nodes) = below.split_at_mut(places);
        rayon::join(
            || self.subdivide(left_items, left_nodes, &left_measure, (first, depth + 1), None),
            || self.subdivide(right_items, right_nodes, &right_measure, (right_first, depth + 1), None),
        );
        let area = measure.bounds.half_area();
        node.costs = forest_costs(area, &below[0].costs, &below[places].costs);
    }

    /// Reorders the items into two sets that are not empty; `None` for a leaf.
    #[inline(always)]
    fn partition(&self, items: &mut [Item], measure: &Measure, depth: u32, hands: &mut impl Hands) -> Option<Parts> {
        let count = items.len();
        if count == 1 {
            return None;
        }
        let leaf_possible = self.is_leaf_possible(items);
        let halves_only = depth + count.ilog2() + 1 >= DEPTH_LIMIT;
        if leaf_possible && (halves_only || count <= LANES) {
            return None;
        }
        if halves_only {
            return Some(self.halve(items, measure));
        }
        let binning = Binning::new(&measure.middles, count);
        match hands.best_split(items, &binning) {
            Some(split) => {
                let area = measure.bounds.half_area();
                if leaf_possible && packs(count as u32) * area <= split.cost + SPLIT_COST * area {
                    return None;
                }
                Some(Parts::new(&split, hands.divide(items, &binning, &split)))
            }
            None if leaf_possible => None,
            None => Some(self.halve(items, measure)),
        }
    }

    #[inline(always)]
    fn kind(&self, item: &Item) -> ItemKind {
        self.sole_kind.unwrap_or_else(|| self.source.kind(item.id()))
    }

    /// A leaf holds one kind, and not too many.
    #[inline(always)]
    fn is_leaf_possible(&self, items: &[Item]) -> bool {
        if items.len() > LANES * Child::COUNT_LIMIT {
            return false;
        }
        let kind = self.kind(&items[0]);
        let limit = match kind {
            ItemKind::Triangle => LANES * Child::COUNT_LIMIT,
            ItemKind::Sphere => Child::COUNT_LIMIT,
            ItemKind::Instance => 1,
        };
        items.len() <= limit && (self.sole_kind.is_some() || items.iter().all(|item| self.kind(item) == kind))
    }

    /// Halves at the median of the longest axis; kinds are kept together where all else is equal.
    #[cold]
    fn halve(&self, items: &mut [Item], measure: &Measure) -> Parts {
        let (axis, middle) = (measure.middles.bounds().longest_axis(), items.len() / 2);
        let few = items.len() <= LANES * Child::COUNT_LIMIT;
        if few && self.sole_kind.is_none() {
            items.sort_by_key(|item| self.kind(item));
            let first_kind = self.kind(&items[0]);
            let middle = items.partition_point(|item| self.kind(item) == first_kind);
            if middle < items.len() {
                return Parts::measured(items, middle);
            }
        }
        items.select_nth_unstable_by(middle, |a, b| {
            let (x, y) = (a.middle(axis), b.middle(axis));
            x.total_cmp(&y).then(self.kind(a).cmp(&self.kind(b))).then(a.id().cmp(&b.id()))
        });
        Parts::measured(items, middle)
    }
}

/// Who does the work on the items of one node.
trait Hands {
    fn best_split(&mut self, items: &[Item], binning: &Binning) -> Option<Split>;
    fn divide(&mut self, items: &mut [Item], binning: &Binning, split: &Split) -> Divided;
}

/// All threads.
struct Many {
    isa: Isa,
}

impl Hands for Many {
    fn best_split(&mut self, items: &[Item], binning: &Binning) -> Option<Split> {
        bin_in_parallel(items, binning, self.isa).cheapest(binning)
    }

    fn divide(&mut self, items: &mut [Item], binning: &Binning, split: &Split) -> Divided {
        divide_in_parallel(items, binning, split, self.isa)
    }
}

/// This thread.
struct One<S> {
    simd: S,
    bins: Bins,
}

impl<S: Simd> Hands for One<S> {
    #[inline(always)]
    fn best_split(&mut self, items: &[Item], binning: &Binning) -> Option<Split> {
        self.bins.clear(binning);
        self.bins.fill(self.simd, items, binning);
        self.bins.cheapest(binning)
    }

    #[inline(always)]
    fn divide(&mut self, items: &mut [Item], binning: &Binning, split: &Split) -> Divided {
        divide(items, binning, split)
    }
}

/// A subtree that one thread builds.
struct Subtree<'a> {
    builder: &'a Builder<'a>,
    items: &'a mut [Item],
    nodes: &'a mut [BinaryNode],
    measure: &'a Measure,
    first: u32,
    depth: u32,
}

/// A part of a subtree that is still to be built.
struct Task {
    /// Where its items start, and how many there are.
    range: (usize, usize),
    measure: Measure,
    depth: u32,
    /// The node whose right child it is, if it is one.
    parent: Option<usize>,
}

impl SimdKernel for Subtree<'_> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let Self { builder, items, nodes, measure, first, depth } = self;
        let mut one = One { simd, bins: Bins::EMPTY };
        let mut used = 0;
        let mut tasks = Vec::with_capacity(DEPTH_LIMIT as usize);
        tasks.push(Task { range: (0, items.len()), measure: *measure, depth, parent: None });
        while let Some(Task { range: (start, count), measure, depth, parent }) = tasks.pop() {
            let place = used;
            used += 1;
            if let Some(parent) = parent {
                nodes[parent].right = (place - parent) as u32;
            }
            nodes[place] = BinaryNode::new(&measure, count, first + start as u32);
            let items = &mut items[start..start + count];
            if let Some(parts) = builder.partition(items, &measure, depth, &mut one) {
                let Parts { middle, measures: [left, right] } = parts;
                let depth = depth + 1;
                let range = (start + middle, count - middle);
                tasks.push(Task { range, measure: right, depth, parent: Some(place) });
                tasks.push(Task { range: (start, middle), measure: left, depth, parent: None });
            }
        }
        for place in (0..used).rev() {
            let node = nodes[place];
            if node.is_leaf() {
                continue;
            }
            let (left, right) = (&nodes[place + 1].costs, &nodes[place + node.right as usize].costs);
            nodes[place].costs = forest_costs(node.bounds.half_area(), left, right);
        }
    }
}

/// The least costs of a subtree as at most 1, 2, ... 7 children of a wide node, from those of its halves: as one it is a wide
/// node of its own, as several it is divided among its halves.
#[inline(always)]
fn forest_costs(area: f32, left: &[f32; WIDTH - 1], right: &[f32; WIDTH - 1]) -> [f32; WIDTH - 1] {
    let mut costs = [area * NODE_COST + best_shares(left, right, WIDTH).1; WIDTH - 1];
    for children in 2..WIDTH {
        costs[children - 1] = least(costs[children - 2], best_shares(left, right, children).1);
    }
    costs
}

/// How many of so many children (2 to 8) the left half should get, and the cost.
#[inline(always)]
pub(super) fn best_shares(left: &[f32; WIDTH - 1], right: &[f32; WIDTH - 1], children: usize) -> (usize, f32) {
    let mut best = (1, f32::INFINITY);
    for share in 1..children.min(WIDTH) {
        let cost = left[share - 1] + right[children - share - 1];
        if cost < best.1 {
            best = (share, cost);
        }
    }
    best
}

/// How many packs hold so many items.
#[inline(always)]
pub(super) fn packs(count: u32) -> f32 {
    count.div_ceil(LANES as u32) as i32 as f32
}

/// How items were divided.
struct Parts {
    /// The size of the first set.
    middle: usize,
    measures: [Measure; 2],
}

impl Parts {
    #[inline(always)]
    fn new(split: &Split, divided: Divided) -> Self {
        let ([a, b], [c, d]) = (split.bounds, divided.middles);
        let measures = [Measure { bounds: a, middles: c }, Measure { bounds: b, middles: d }];
        Self { middle: divided.middle, measures }
    }

    fn measured(items: &[Item], middle: usize) -> Self {
        let (left, right) = items.split_at(middle);
        Self { middle, measures: [Measure::of(left), Measure::of(right)] }
    }
}

fn measure_in_parallel(items: &[Item], isa: Isa) -> Measure {
    struct Chunk<'a>(&'a [Item]);
    impl Kernel for Chunk<'_> {
        type Output = Measure;
        #[inline(always)]
        fn run(self) -> Measure {
            Measure::of(self.0)
        }
    }
    // In order: which of 0 and -0 is the smaller depends on it.
    let parts: Vec<Measure> = items.par_chunks(CHUNK).map(|items| run(isa, Chunk(items))).collect();
    parts.iter().fold(Measure::EMPTY, |all, part| all.join(part))
}

fn bin_in_parallel(items: &[Item], binning: &Binning, isa: Isa) -> Bins {
    struct Chunk<'a>(&'a [Item], &'a Binning);
    impl SimdKernel for Chunk<'_> {
        type Output = Bins;
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> Bins {
            let mut bins = Bins::EMPTY;
            bins.fill(simd, self.0, self.1);
            bins
        }
    }
    let parts: Vec<Bins> = items.par_chunks(CHUNK).map(|items| dispatch(isa, Chunk(items, binning))).collect();
    parts.iter().fold(Bins::EMPTY, Bins::merge)
}
