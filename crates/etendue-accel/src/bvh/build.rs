//! A binary tree by binned surface-area heuristic, in parallel, the same for any number of threads.
//!
//! (Wald, "On fast Construction of SAH-based Bounding Volume Hierarchies", 2007.) What wide nodes are best made of it is
//! found on the way back up (Ylitie, Karras and Laine, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide
//! BVHs", 2017).

use bytemuck::Zeroable;
use rayon::prelude::*;

use super::node::{Child, LANES, WIDTH};
use crate::bounds::{Bounds, greatest, least};
use crate::error::BuildError;
use crate::items::{Item, ItemKind};
use crate::source::Source;

/// Most bins of an axis.
const BINS: usize = 32;

/// Cost of a binary split relative to a pack test: a third of an 8-wide node, as each absorbs three levels.
const SPLIT_COST: f32 = 0.35;

/// Cost of a wide node relative to a pack test.
const NODE_COST: f32 = 1.0;

/// Below this many items a subtree is one thread's work.
const PARALLEL_ITEMS: usize = 4096;

/// From this many items on, bins are filled in parallel, in chunks of fixed size.
const PARALLEL_BINNING: usize = 1 << 16;

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
}

/// Builds the tree, reordering the items; at least one item. The root comes first. A subtree of n items has 2n - 1 places;
/// where threads may share the work, so many are set aside, so that places do not depend on who finishes first.
///
/// The first items can be set apart, some but not all of them: then the root's left half holds them and its right half the
/// others.
pub(crate) fn build(items: &mut [Item], source: Source<'_>, apart: usize) -> Result<Vec<BinaryNode>, BuildError> {
    let places = 2 * items.len() - 1;
    let bytes = (places * size_of::<BinaryNode>()) as u64;
    // Zeroed by the system: what is not used costs nothing.
    let mut nodes = bytemuck::try_zeroed_vec(places).map_err(|()| BuildError::Memory { what: "tree nodes", bytes })?;
    let builder = Builder { source, sole_kind: source.sole_kind() };
    let measure = Measure::of(items);
    let parts = (1..items.len()).contains(&apart).then(|| {
        let (first, others) = items.split_at(apart);
        Parts { middle: apart, measures: [Measure::of(first), Measure::of(others)] }
    });
    builder.subdivide(items, &mut nodes, &measure, (0, 0), parts);
    Ok(nodes)
}

struct Builder<'a> {
    source: Source<'a>,
    /// What all items are, if that is known.
    sole_kind: Option<ItemKind>,
}

impl Builder<'_> {
    /// Builds a subtree whose items have a measure, at a place in all items and a depth; how many places are used. Its halves may
    /// be given.
    fn subdivide(
        &self,
        items: &mut [Item],
        nodes: &mut [BinaryNode],
        measure: &Measure,
        (first, depth): (u32, u32),
        parts: Option<Parts>,
    ) -> usize {
        let Some((node, below)) = nodes.split_first_mut() else { return 0 };
        let area = measure.bounds.half_area();
        let costs = [area * packs(items.len()); WIDTH - 1];
        *node = BinaryNode { bounds: measure.bounds.bounds(), right: 0, first, count: items.len() as u32, costs };
        let parts = parts.or_else(|| self.partition(items, measure, depth));
        let Some(Parts { middle, measures: [left_measure, right_measure] }) = parts else { return 1 };
        let parallel = items.len() > PARALLEL_ITEMS;
        let (left_items, right_items) = items.split_at_mut(middle);
        let right_first = first + middle as u32;
        if !parallel {
            let left = self.subdivide(left_items, below, &left_measure, (first, depth + 1), None);
            node.right = 1 + left as u32;
            let right_place = (right_first, depth + 1);
            let right = self.subdivide(right_items, &mut below[left..], &right_measure, right_place, None);
            node.costs = forest_costs(area, &below[0].costs, &below[left].costs);
            return 1 + left + right;
        }
        let places = 2 * middle - 1;
        node.right = 1 + places as u32;
        let (left_nodes, right_nodes) = below.split_at_mut(places);
        let (_, right) = rayon::join(
            || self.subdivide(left_items, left_nodes, &left_measure, (first, depth + 1), None),
            || self.subdivide(right_items, right_nodes, &right_measure, (right_first, depth + 1), None),
        );
        node.costs = forest_costs(area, &below[0].costs, &below[places].costs);
        1 + places + right
    }

    /// Reorders the items into two sets that are not empty; `None` for a leaf.
    fn partition(&self, items: &mut [Item], measure: &Measure, depth: u32) -> Option<Parts> {
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
        match best_split(items, measure) {
            Some(split) => {
                let area = measure.bounds.half_area();
                if leaf_possible && packs(count) * area <= split.cost + SPLIT_COST * area {
                    return None;
                }
                let binning = Binning::new(&measure.middles, count);
                Some(split_in_place(items, |item| binning.bin_on(item, split.axis) < split.bin))
            }
            None if leaf_possible => None,
            None => Some(self.halve(items, measure)),
        }
    }

    fn kind(&self, item: &Item) -> ItemKind {
        self.sole_kind.unwrap_or_else(|| self.source.kind(item.id()))
    }

    /// A leaf holds one kind, and not too many.
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
    fn halve(&self, items: &mut [Item], measure: &Measure) -> Parts {
        let (axis, middle) = (measure.middles.bounds().longest_axis(), items.len() / 2);
        let few = items.len() <= LANES * Child::COUNT_LIMIT;
        if few && self.sole_kind.is_none() {
            let first_kind = items.iter().map(|item| self.kind(item)).min();
            let parts = split_in_place(items, |item| Some(self.kind(item)) == first_kind);
            if parts.middle < items.len() {
                return parts;
            }
        }
        items.select_nth_unstable_by(middle, |a, b| {
            let (x, y) = (a.middle()[axis], b.middle()[axis]);
            x.total_cmp(&y).then(self.kind(a).cmp(&self.kind(b))).then(a.id().cmp(&b.id()))
        });
        let (left, right) = items.split_at(middle);
        Parts { middle, measures: [Measure::of(left), Measure::of(right)] }
    }
}

/// The least costs of a subtree as at most 1, 2, ... 7 children of a wide node, from those of its halves: as one it is a wide
/// node of its own, as several it is divided among its halves.
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

fn packs(count: usize) -> f32 {
    count.div_ceil(LANES) as f32
}

/// How items were divided.
struct Parts {
    /// The size of the first set.
    middle: usize,
    measures: [Measure; 2],
}

/// Moves the items that satisfy a condition to the front, measuring both sets.
#[inline(always)]
fn split_in_place(items: &mut [Item], is_first: impl Fn(&Item) -> bool) -> Parts {
    let mut measures = [Measure::EMPTY; 2];
    let (mut low, mut high) = (0, items.len());
    while low < high {
        let item = items[low];
        if is_first(&item) {
            measures[0].add(&item);
            low += 1;
        } else {
            measures[1].add(&item);
            high -= 1;
            items.swap(low, high);
        }
    }
    Parts { middle: low, measures }
}

/// A box in vectors of four; the last lanes mean nothing.
#[derive(Clone, Copy)]
struct Box4 {
    low: [f32; 4],
    high: [f32; 4],
}

impl Box4 {
    const EMPTY: Self = Self { low: [f32::INFINITY; 4], high: [f32::NEG_INFINITY; 4] };

    #[inline(always)]
    fn join(&self, low: &[f32; 4], high: &[f32; 4]) -> Self {
        Self {
            low: std::array::from_fn(|i| least(self.low[i], low[i])),
            high: std::array::from_fn(|i| greatest(self.high[i], high[i])),
        }
    }

    #[inline(always)]
    fn half_area(&self) -> f32 {
        let side: [f32; 4] = std::array::from_fn(|i| self.high[i] - self.low[i]);
        side[0] * side[1] + side[1] * side[2] + side[2] * side[0]
    }

    fn bounds(&self) -> Bounds {
        let ([x, y, z, _], [u, v, w, _]) = (self.low, self.high);
        Bounds { min: [x, y, z], max: [u, v, w] }
    }
}

/// The box around items and the box around their (doubled) middles.
#[derive(Clone, Copy)]
struct Measure {
    bounds: Box4,
    middles: Box4,
}

impl Measure {
    const EMPTY: Self = Self { bounds: Box4::EMPTY, middles: Box4::EMPTY };

    fn of(items: &[Item]) -> Self {
        let of_part = |part: &[Item]| {
            let mut measure = Self::EMPTY;
            part.iter().for_each(|item| measure.add(item));
            measure
        };
        if items.len() < PARALLEL_BINNING {
            return of_part(items);
        }
        // In order: which of 0 and -0 is the smaller depends on it.
        let parts: Vec<Self> = items.par_chunks(PARALLEL_BINNING / 4).map(of_part).collect();
        parts.iter().fold(Self::EMPTY, |a, b| Self {
            bounds: a.bounds.join(&b.bounds.low, &b.bounds.high),
            middles: a.middles.join(&b.middles.low, &b.middles.high),
        })
    }

    #[inline(always)]
    fn add(&mut self, item: &Item) {
        self.bounds = self.bounds.join(&item.low, &item.high);
        let middle = item.middle();
        self.middles = self.middles.join(&middle, &middle);
    }
}

/// Which bin a middle falls into: the nearest of points at equal distances.
#[derive(Clone, Copy)]
struct Binning {
    start: [f32; 4],
    /// 0 on an axis where all middles are equal.
    scale: [f32; 4],
    bins: usize,
}

/// Added to a number of at most 22 bits, it leaves the nearest whole number in the lowest bits.
const TO_WHOLE: f32 = (1 << 23) as f32;

impl Binning {
    fn new(middles: &Box4, count: usize) -> Self {
        let bins = (8 + count / 16).min(BINS);
        let scale = std::array::from_fn(|a| {
            let scale = (bins - 1) as f32 / (middles.high[a] - middles.low[a]);
            if a < 3 && scale.is_finite() { scale } else { 0.0 }
        });
        let [x, y, z, _] = middles.low;
        Self { start: [x, y, z, 0.0], scale, bins }
    }

    #[inline(always)]
    fn bins_of(&self, item: &Item) -> [usize; 3] {
        let middle = item.middle();
        let place: [u32; 4] =
            std::array::from_fn(|a| ((middle[a] - self.start[a]) * self.scale[a] + TO_WHOLE).to_bits());
        [0, 1, 2].map(|a| place[a] as usize % BINS)
    }

    #[inline(always)]
    fn bin_on(&self, item: &Item, axis: usize) -> usize {
        let middle = item.low[axis] + item.high[axis];
        ((middle - self.start[axis]) * self.scale[axis] + TO_WHOLE).to_bits() as usize % BINS
    }
}

#[derive(Clone)]
struct Bins {
    boxes: [[Box4; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    const EMPTY: Self = Self { boxes: [[Box4::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    #[inline(always)]
    fn clear(&mut self, used: usize) {
        for axis in 0..3 {
            self.boxes[axis][..used].fill(Box4::EMPTY);
            self.counts[axis][..used].fill(0);
        }
    }

    #[inline(always)]
    fn fill(&mut self, items: &[Item], binning: &Binning) {
        for item in items {
            for (axis, bin) in binning.bins_of(item).into_iter().enumerate() {
                let place = &mut self.boxes[axis][bin];
                *place = place.join(&item.low, &item.high);
                self.counts[axis][bin] += 1;
            }
        }
    }

    /// Minima, maxima and counts: the order of merging does not matter.
    fn merge(mut self, other: &Self) -> Self {
        for (a, b) in self.boxes.iter_mut().flatten().zip(other.boxes.iter().flatten()) {
            *a = a.join(&b.low, &b.high);
        }
        for (a, b) in self.counts.iter_mut().flatten().zip(other.counts.iter().flatten()) {
            *a += b;
        }
        self
    }
}

#[derive(Clone, Copy)]
struct Split {
    axis: usize,
    /// The first bin of the second set.
    bin: usize,
    /// Half areas times packs.
    cost: f32,
}

/// The cheapest split between bins; `None` if all middles fall into one bin on every axis.
fn best_split(items: &[Item], measure: &Measure) -> Option<Split> {
    let binning = Binning::new(&measure.middles, items.len());
    if items.len() < PARALLEL_BINNING {
        thread_local! {
            static BINS_OF_THREAD: std::cell::RefCell<Bins> = const { std::cell::RefCell::new(Bins::EMPTY) };
        }
        return BINS_OF_THREAD.with_borrow_mut(|bins| {
            bins.clear(binning.bins);
            bins.fill(items, &binning);
            cheapest(bins, &binning)
        });
    }
    let parts = items.par_chunks(PARALLEL_BINNING / 4).map(|part| {
        let mut bins = Bins::EMPTY;
        bins.fill(part, &binning);
        bins
    });
    let bins = parts.reduce(|| Bins::EMPTY, |a, b| a.merge(&b));
    cheapest(&bins, &binning)
}

fn cheapest(bins: &Bins, binning: &Binning) -> Option<Split> {
    let mut best: Option<Split> = None;
    for axis in 0..3 {
        if binning.scale[axis] == 0.0 {
            continue;
        }
        let (boxes, counts) = (&bins.boxes[axis][..binning.bins], &bins.counts[axis][..binning.bins]);
        let mut right_costs = [f32::INFINITY; BINS];
        let (mut bounds, mut count) = (Box4::EMPTY, 0);
        for i in (1..binning.bins).rev() {
            (bounds, count) = (bounds.join(&boxes[i].low, &boxes[i].high), count + counts[i]);
            if count > 0 {
                right_costs[i] = bounds.half_area() * packs(count as usize);
            }
        }
        let (mut bounds, mut count) = (Box4::EMPTY, 0);
        for i in 1..binning.bins {
            (bounds, count) = (bounds.join(&boxes[i - 1].low, &boxes[i - 1].high), count + counts[i - 1]);
            if count == 0 {
                continue;
            }
            let cost = bounds.half_area() * packs(count as usize) + right_costs[i];
            if cost < best.map_or(f32::INFINITY, |best| best.cost) {
                best = Some(Split { axis, bin: i, cost });
            }
        }
    }
    best
}
