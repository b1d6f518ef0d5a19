//! A binary tree by binned surface-area heuristic, in parallel, the same for any number of threads.
//!
//! (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007.)

use rayon::prelude::*;

use super::node::{Child, LANES};
use crate::bounds::Bounds;
use crate::error::{BuildError, room};
use crate::items::{Item, ItemKind};

const BINS: usize = 32;

/// Cost of a binary split relative to a pack test: a third of an 8-wide node, as each absorbs three levels.
const SPLIT_COST: f32 = 0.35;

/// Below this many items a subtree is one thread's work.
const PARALLEL_ITEMS: usize = 4096;

/// From this many items on, bins are filled in parallel, in chunks of fixed size.
const PARALLEL_BINNING: usize = 1 << 16;

/// Splits are by cost only while a tree of halves below them stays within this depth.
const DEPTH_LIMIT: u32 = 60;

/// A node of the binary tree over a range of the reordered items. The left child follows its parent.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BinaryNode {
    pub bounds: Bounds,
    /// Distance to the right child; 0 for a leaf.
    pub right: u32,
    /// First item of a leaf.
    pub first: u32,
    /// Items below.
    pub count: u32,
}

impl BinaryNode {
    const UNUSED: Self = Self { bounds: Bounds::EMPTY, right: 0, first: 0, count: 0 };

    pub fn is_leaf(&self) -> bool {
        self.right == 0
    }
}

/// Builds the tree, reordering the items; at least one item. The root comes first. A subtree of n items has 2n - 1 places,
/// of which it may leave some unused, so that places do not depend on the order in which threads finish.
pub(crate) fn build(items: &mut [Item]) -> Result<Vec<BinaryNode>, BuildError> {
    let places = 2 * items.len() - 1;
    let mut nodes = room("tree nodes", places)?;
    nodes.resize(places, BinaryNode::UNUSED);
    subdivide(items, &mut nodes, 0, 0);
    Ok(nodes)
}

fn subdivide(items: &mut [Item], nodes: &mut [BinaryNode], first: u32, depth: u32) {
    let measure = Measure::of(items);
    let (node, below) = match nodes.split_first_mut() {
        Some(split) => split,
        None => return,
    };
    *node = BinaryNode { bounds: measure.bounds, right: 0, first, count: items.len() as u32 };
    let Some(middle) = partition(items, &measure, depth) else { return };
    let left_places = 2 * middle - 1;
    node.right = 1 + left_places as u32;
    let parallel = items.len() > PARALLEL_ITEMS;
    let (left_items, right_items) = items.split_at_mut(middle);
    let (left_nodes, right_nodes) = below.split_at_mut(left_places);
    let right_first = first + middle as u32;
    let mut left = || subdivide(left_items, left_nodes, first, depth + 1);
    let mut right = || subdivide(right_items, right_nodes, right_first, depth + 1);
    if parallel {
        rayon::join(left, right);
    } else {
        left();
        right();
    }
}

/// Reorders the items into two sets that are not empty and gives the size of the first; `None` for a leaf.
fn partition(items: &mut [Item], measure: &Measure, depth: u32) -> Option<usize> {
    let count = items.len();
    if count == 1 {
        return None;
    }
    let leaf_possible = is_leaf_possible(items);
    let halves_only = depth + count.ilog2() + 1 >= DEPTH_LIMIT;
    if halves_only && leaf_possible {
        return None;
    }
    if halves_only {
        return Some(halve(items, measure));
    }
    match best_split(items, measure) {
        Some(split) => {
            let leaf_cost = packs(count) * measure.bounds.half_area();
            if leaf_possible && leaf_cost <= split.cost + SPLIT_COST * measure.bounds.half_area() {
                return None;
            }
            let binning = Binning::new(&measure.middles);
            Some(split_in_place(items, |item| binning.bin(item, split.axis) < split.bin))
        }
        None if leaf_possible => None,
        None => Some(halve(items, measure)),
    }
}

/// A leaf holds one kind, and not too many.
fn is_leaf_possible(items: &[Item]) -> bool {
    let limit = match items[0].kind {
        ItemKind::Triangle => LANES * Child::COUNT_LIMIT,
        ItemKind::Sphere => Child::COUNT_LIMIT,
        ItemKind::Instance => 1,
    };
    items.len() <= limit && items.iter().all(|item| item.kind == items[0].kind)
}

fn packs(count: usize) -> f32 {
    count.div_ceil(LANES) as f32
}

/// Halves at the median of the longest axis; kinds are kept together where all else is equal.
fn halve(items: &mut [Item], measure: &Measure) -> usize {
    let (axis, middle) = (measure.middles.longest_axis(), items.len() / 2);
    let few = items.len() <= LANES * Child::COUNT_LIMIT;
    if few && let Some(first) = split_by_kind(items) {
        return first;
    }
    items.select_nth_unstable_by(middle, |a, b| {
        let (x, y) = (a.bounds.middle()[axis], b.bounds.middle()[axis]);
        x.total_cmp(&y).then(a.kind.cmp(&b.kind)).then(a.id.cmp(&b.id))
    });
    middle
}

fn split_by_kind(items: &mut [Item]) -> Option<usize> {
    let first_kind = items.iter().map(|item| item.kind).min()?;
    let size = split_in_place(items, |item| item.kind == first_kind);
    (size < items.len()).then_some(size)
}

/// Moves the items that satisfy a condition to the front; their number.
fn split_in_place(items: &mut [Item], is_first: impl Fn(&Item) -> bool) -> usize {
    let (mut low, mut high) = (0, items.len());
    while low < high {
        if is_first(&items[low]) {
            low += 1;
        } else {
            high -= 1;
            items.swap(low, high);
        }
    }
    low
}

/// The box around items and the box around their (doubled) middles.
#[derive(Clone, Copy)]
struct Measure {
    bounds: Bounds,
    middles: Bounds,
}

impl Measure {
    const EMPTY: Self = Self { bounds: Bounds::EMPTY, middles: Bounds::EMPTY };

    fn of(items: &[Item]) -> Self {
        if items.len() < PARALLEL_BINNING {
            return items.iter().fold(Self::EMPTY, Self::with);
        }
        let parts = items.par_chunks(PARALLEL_BINNING / 4).map(|part| part.iter().fold(Self::EMPTY, Self::with));
        parts.reduce(
            || Self::EMPTY,
            |a, b| Self { bounds: a.bounds.join(&b.bounds), middles: a.middles.join(&b.middles) },
        )
    }

    fn with(self, item: &Item) -> Self {
        let middle = item.bounds.middle();
        Self {
            bounds: self.bounds.join(&item.bounds),
            middles: self.middles.join(&Bounds { min: middle, max: middle }),
        }
    }
}

/// Which bin a middle falls into.
#[derive(Clone, Copy)]
struct Binning {
    start: [f32; 3],
    /// 0 on an axis where all middles are equal.
    scale: [f32; 3],
}

impl Binning {
    fn new(middles: &Bounds) -> Self {
        let scale = std::array::from_fn(|a| {
            let scale = BINS as f32 / (middles.max[a] - middles.min[a]);
            if scale.is_finite() { scale } else { 0.0 }
        });
        Self { start: middles.min, scale }
    }

    #[inline(always)]
    fn bin(&self, item: &Item, axis: usize) -> usize {
        let middle = item.bounds.min[axis] + item.bounds.max[axis];
        (((middle - self.start[axis]) * self.scale[axis]) as usize).min(BINS - 1)
    }
}

#[derive(Clone, Copy)]
struct Bin {
    bounds: Bounds,
    count: usize,
}

type Bins = [[Bin; BINS]; 3];

const EMPTY_BINS: Bins = [[Bin { bounds: Bounds::EMPTY, count: 0 }; BINS]; 3];

fn fill_bins(items: &[Item], binning: &Binning) -> Bins {
    let mut bins = EMPTY_BINS;
    for item in items {
        for (axis, bins) in bins.iter_mut().enumerate() {
            let bin = &mut bins[binning.bin(item, axis)];
            bin.bounds = bin.bounds.join(&item.bounds);
            bin.count += 1;
        }
    }
    bins
}

/// Minima, maxima and counts: the order of merging does not matter.
fn merge_bins(mut a: Bins, b: Bins) -> Bins {
    for (a, b) in a.iter_mut().flatten().zip(b.iter().flatten()) {
        a.bounds = a.bounds.join(&b.bounds);
        a.count += b.count;
    }
    a
}

struct Split {
    axis: usize,
    /// The first bin of the second set.
    bin: usize,
    /// Half areas times packs.
    cost: f32,
}

/// The cheapest split between bins; `None` if all middles fall into one bin on every axis.
fn best_split(items: &[Item], measure: &Measure) -> Option<Split> {
    let binning = Binning::new(&measure.middles);
    let bins = if items.len() < PARALLEL_BINNING {
        fill_bins(items, &binning)
    } else {
        let parts = items.par_chunks(PARALLEL_BINNING / 4).map(|part| fill_bins(part, &binning));
        parts.reduce(|| EMPTY_BINS, merge_bins)
    };
    let mut best: Option<Split> = None;
    for (axis, bins) in bins.iter().enumerate() {
        if binning.scale[axis] == 0.0 {
            continue;
        }
        let mut right_costs = [f32::INFINITY; BINS];
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for (i, bin) in bins.iter().enumerate().skip(1).rev() {
            (bounds, count) = (bounds.join(&bin.bounds), count + bin.count);
            if count > 0 {
                right_costs[i] = bounds.half_area() * packs(count);
            }
        }
        let (mut bounds, mut count) = (Bounds::EMPTY, 0);
        for i in 1..BINS {
            (bounds, count) = (bounds.join(&bins[i - 1].bounds), count + bins[i - 1].count);
            let cost = bounds.half_area() * packs(count) + right_costs[i];
            if count > 0 && cost < best.as_ref().map_or(f32::INFINITY, |best| best.cost) {
                best = Some(Split { axis, bin: i, cost });
            }
        }
    }
    best
}
