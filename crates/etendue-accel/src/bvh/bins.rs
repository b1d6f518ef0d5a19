//! Bins along the three axes, and the cheapest split between them.

use super::build::packs;
use crate::bounds::{Bounds, greatest};
use crate::items::Item;
use crate::simd::Simd;

/// Most bins of an axis.
pub(super) const BINS: usize = 32;

/// A box as an [`Item`] holds it: the smallest coordinates, negated, then the largest. The fourth lane of each half means
/// nothing. Joining two is one maximum of eight lanes.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug)]
pub(super) struct Box8([f32; 8]);

impl Box8 {
    pub const EMPTY: Self = Self([f32::NEG_INFINITY; 8]);

    #[inline(always)]
    pub fn of(item: &Item) -> Self {
        Self(item.lanes)
    }

    /// An item's doubled middle as a box.
    #[inline(always)]
    pub fn middle_of(item: &Item) -> Self {
        let [a, b, c, i, d, e, f, p] = item.lanes;
        let (mut these, others) = ([a, b, c, i, d, e, f, p], [d, e, f, p, a, b, c, i]);
        for lane in 0..8 {
            these[lane] -= others[lane];
        }
        Self(these)
    }

    #[inline(always)]
    pub fn join(&self, other: &Self) -> Self {
        let mut joined = *self;
        for i in 0..8 {
            joined.0[i] = greatest(self.0[i], other.0[i]);
        }
        joined
    }

    /// Joined with another in one of two cases: 0 for yes, 1 for no. Without a branch.
    #[inline(always)]
    pub fn join_unless(&self, other: &Self, no: usize) -> Self {
        const SHIFTS: [f32; 2] = [0.0, f32::NEG_INFINITY];
        let shift = SHIFTS[no];
        let mut moved = *other;
        for lane in &mut moved.0 {
            *lane += shift;
        }
        self.join(&moved)
    }

    /// Sides, of which the fourth means nothing.
    #[inline(always)]
    fn sides(&self) -> [f32; 4] {
        let [a, b, c, i, d, e, f, p] = self.0;
        let (mut sides, low) = ([d, e, f, p], [a, b, c, i]);
        for i in 0..4 {
            sides[i] += low[i];
        }
        sides
    }

    #[inline(always)]
    pub fn half_area(&self) -> f32 {
        let [x, y, z, _] = self.sides();
        x * y + y * z + z * x
    }

    pub fn bounds(&self) -> Bounds {
        let [a, b, c, _, d, e, f, _] = self.0;
        Bounds { min: [-a, -b, -c], max: [d, e, f] }
    }

    #[inline(always)]
    fn low(&self, axis: usize) -> f32 {
        -self.0[axis]
    }

    #[inline(always)]
    fn high(&self, axis: usize) -> f32 {
        self.0[4 + axis]
    }
}

/// Which bin a middle falls into: the nearest of points at equal distances.
#[derive(Clone, Copy, Debug)]
pub(super) struct Binning {
    start: [f32; 4],
    /// 0 on an axis where all middles are equal.
    scale: [f32; 4],
    bins: usize,
}

/// Added to a number of at most 22 bits, it leaves the nearest whole number in the lowest bits.
const TO_WHOLE: f32 = (1 << 23) as f32;

impl Binning {
    /// For so many items with these (doubled) middles.
    #[inline(always)]
    pub fn new(middles: &Box8, count: usize) -> Self {
        let bins = (8 + count / 16).min(BINS);
        let mut binning = Self { start: [0.0; 4], scale: [0.0; 4], bins };
        for axis in 0..3 {
            let scale = (bins - 1) as f32 / (middles.high(axis) - middles.low(axis));
            binning.start[axis] = middles.low(axis);
            binning.scale[axis] = if scale.is_finite() { scale } else { 0.0 };
        }
        binning
    }

    #[inline(always)]
    fn bins_of(&self, item: &Item) -> [usize; 3] {
        // Not the ids: multiplying what are tiny numbers then takes long.
        let middle = [item.middle(0), item.middle(1), item.middle(2), 0.0];
        let mut place = [0; 4];
        for a in 0..4 {
            place[a] = ((middle[a] - self.start[a]) * self.scale[a] + TO_WHOLE).to_bits();
        }
        [place[0] as usize % BINS, place[1] as usize % BINS, place[2] as usize % BINS]
    }

    /// Whether an item is on the first side of a split.
    #[inline(always)]
    pub fn is_first(&self, item: &Item, split: &Split) -> bool {
        let axis = split.axis % 4;
        let middle = item.lanes[4 + axis] - item.lanes[axis];
        let bin = ((middle - self.start[axis]) * self.scale[axis] + TO_WHOLE).to_bits() as usize % BINS;
        bin < split.bin
    }
}

#[derive(Clone, Copy, Debug)]
pub(super) struct Split {
    pub axis: usize,
    /// The first bin of the second set.
    pub bin: usize,
    /// Half areas times packs.
    pub cost: f32,
    /// Around both sets.
    pub bounds: [Box8; 2],
}

/// What is in the bins.
#[derive(Clone)]
pub(super) struct Bins {
    boxes: [[Box8; BINS]; 3],
    counts: [[u32; BINS]; 3],
}

impl Bins {
    pub const EMPTY: Self = Self { boxes: [[Box8::EMPTY; BINS]; 3], counts: [[0; BINS]; 3] };

    /// Empties as many bins as will be used.
    #[inline(always)]
    pub fn clear(&mut self, binning: &Binning) {
        for axis in 0..3 {
            for bin in 0..binning.bins.min(BINS) {
                self.boxes[axis][bin] = Box8::EMPTY;
                self.counts[axis][bin] = 0;
            }
        }
    }

    #[inline(always)]
    pub fn fill(&mut self, simd: impl Simd, items: &[Item], binning: &Binning) {
        for item in items {
            for (axis, bin) in binning.bins_of(item).into_iter().enumerate() {
                self.boxes[axis][bin].0 = simd.maxima(&self.boxes[axis][bin].0, &item.lanes);
                self.counts[axis][bin] += 1;
            }
        }
    }

    /// With what is in others; their order decides which of 0 and -0 is the smaller.
    pub fn merge(mut self, other: &Self) -> Self {
        for (a, b) in self.boxes.iter_mut().flatten().zip(other.boxes.iter().flatten()) {
            *a = a.join(b);
        }
        for (a, b) in self.counts.iter_mut().flatten().zip(other.counts.iter().flatten()) {
            *a += b;
        }
        self
    }

    /// The cheapest split between bins; `None` if all middles fall into one bin on every axis.
    #[inline(always)]
    pub fn cheapest(&self, binning: &Binning) -> Option<Split> {
        let used = binning.bins.min(BINS);
        // All axes at once, a lane each.
        let mut right_costs = [[f32::INFINITY; 4]; BINS];
        let mut sweep = Sweep::EMPTY;
        for i in (1..used).rev() {
            right_costs[i] = sweep.cost_with(self, i);
        }
        let mut sweep = Sweep::EMPTY;
        let (mut costs, mut bins) = ([f32::INFINITY; 4], [0_u32; 4]);
        for (i, right) in right_costs.iter().enumerate().take(used).skip(1) {
            let left = sweep.cost_with(self, i - 1);
            for lane in 0..4 {
                let cost = left[lane] + right[lane];
                let better = cost < costs[lane];
                costs[lane] = if better { cost } else { costs[lane] };
                bins[lane] = if better { i as u32 } else { bins[lane] };
            }
        }
        let mut best = (0, f32::INFINITY);
        for (axis, &cost) in costs.iter().enumerate().take(3) {
            if binning.scale[axis] != 0.0 && cost < best.1 {
                best = (axis, cost);
            }
        }
        let (axis, cost) = best;
        let bin = bins[axis] as usize;
        if cost == f32::INFINITY {
            return None;
        }
        let mut bounds = [Box8::EMPTY; 2];
        for (i, this) in self.boxes[axis][..used].iter().enumerate() {
            let side = usize::from(i >= bin);
            bounds[side] = bounds[side].join(this);
        }
        Some(Split { axis, bin, cost, bounds })
    }
}

/// Bins joined so far, by axis.
struct Sweep {
    boxes: [Box8; 3],
    counts: [u32; 4],
}

impl Sweep {
    const EMPTY: Self = Self { boxes: [Box8::EMPTY; 3], counts: [0; 4] };

    /// Joins a bin of each axis; half areas times packs, infinite where there is nothing.
    #[inline(always)]
    fn cost_with(&mut self, bins: &Bins, i: usize) -> [f32; 4] {
        let mut sides = [[0.0; 4]; 3];
        for (axis, joined) in self.boxes.iter_mut().enumerate() {
            *joined = joined.join(&bins.boxes[axis][i]);
            self.counts[axis] += bins.counts[axis][i];
            let [x, y, z, _] = joined.sides();
            (sides[0][axis], sides[1][axis], sides[2][axis]) = (x, y, z);
        }
        let [x, y, z] = sides;
        let mut costs = [0.0; 4];
        for lane in 0..4 {
            let count = self.counts[lane];
            let cost = (x[lane] * y[lane] + y[lane] * z[lane] + z[lane] * x[lane]) * packs(count);
            costs[lane] = if count == 0 { f32::INFINITY } else { cost };
        }
        costs
    }
}

/// The box around items and the box around their (doubled) middles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Measure {
    pub bounds: Box8,
    pub middles: Box8,
}

impl Measure {
    pub const EMPTY: Self = Self { bounds: Box8::EMPTY, middles: Box8::EMPTY };

    #[inline(always)]
    pub fn of(items: &[Item]) -> Self {
        let mut measure = Self::EMPTY;
        for item in items {
            measure = measure.join(&Self { bounds: Box8::of(item), middles: Box8::middle_of(item) });
        }
        measure
    }

    #[inline(always)]
    pub fn join(&self, other: &Self) -> Self {
        Self { bounds: self.bounds.join(&other.bounds), middles: self.middles.join(&other.middles) }
    }
}
