//! Where a cell is cut: the cheapest plane by the surface-area heuristic, or the middle.

use super::reference::Reference;
use crate::bounds::Bounds;
use crate::bvh::node::LANES;

/// Candidates of an axis where there are many references.
const BINS: usize = 32;

/// Up to so many references all planes in which their boxes end are candidates.
const FEW: usize = 32;

/// Cost of a step down relative to the test of a pack.
const STEP_COST: f32 = 1.0;

/// Cutting off empty space is worth this factor.
const EMPTY_FACTOR: f32 = 0.9;

/// Cuts through the middle stop at this many primitives.
const MIDPOINT_LEAF: usize = 4;

/// A plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut {
    pub axis: usize,
    pub at: f32,
}

impl Cut {
    /// Whether a box lies below and above; what lies in the plane counts as below.
    #[inline(always)]
    pub fn sides(&self, bounds: &Bounds) -> (bool, bool) {
        let (low, high) = (bounds.min[self.axis], bounds.max[self.axis]);
        (low < self.at || high <= self.at, high > self.at)
    }

    /// The parts of a cell below and above.
    #[inline(always)]
    pub fn halves(&self, cell: &Bounds) -> [Bounds; 2] {
        let mut halves = [*cell; 2];
        halves[0].max[self.axis] = self.at;
        halves[1].min[self.axis] = self.at;
        halves
    }
}

/// The middle of the longest axis, if there is anything to divide.
pub(super) fn middle(count: usize, cell: &Bounds) -> Option<Cut> {
    let axis = cell.longest_axis();
    let at = cell.min[axis] * 0.5 + cell.max[axis] * 0.5;
    let splits = count > MIDPOINT_LEAF && cell.min[axis] < at && at < cell.max[axis];
    splits.then_some(Cut { axis, at })
}

/// The cheapest plane (MacDonald and Booth, "Heuristics for ray tracing using space subdivision", 1990), if it is cheaper than a leaf.
pub(super) fn cheapest(references: &[Reference], cell: &Bounds) -> Option<Cut> {
    let count = references.len();
    let area = cell.half_area();
    let mut best = Best { cell, area, cut: None, cost: packs(count) * area };
    if count <= FEW {
        every_end(references, &mut best);
    } else {
        bins(references, &mut best);
    }
    best.cut
}

/// Considers the planes in which boxes begin or end.
fn every_end(references: &[Reference], best: &mut Best<'_>) {
    let count = references.len().min(FEW);
    for axis in 0..3 {
        let (mut lows, mut highs, mut flat, mut flats) = ([0.0; FEW], [0.0; FEW], [0.0; FEW], 0);
        for (i, Reference { bounds, .. }) in references.iter().take(FEW).enumerate() {
            (lows[i], highs[i]) = (bounds.min[axis], bounds.max[axis]);
            flat[flats % FEW] = lows[i];
            flats += usize::from(lows[i] == highs[i]);
        }
        let (lows, highs, flat) = (&mut lows[..count], &mut highs[..count], &flat[..flats.min(FEW)]);
        lows.sort_unstable_by(f32::total_cmp);
        highs.sort_unstable_by(f32::total_cmp);
        for ends in [&*lows, &*highs] {
            let (mut begun, mut ended) = (0, 0);
            for &at in ends {
                while begun < count && lows[begun] < at {
                    begun += 1;
                }
                while ended < count && highs[ended] <= at {
                    ended += 1;
                }
                let in_plane = flat.iter().filter(|&&x| x == at).count();
                best.consider(Cut { axis, at }, begun + in_plane, count - ended);
            }
        }
    }
}

/// Considers planes at even distances, and the ends of what is there, which cut off empty space.
fn bins(references: &[Reference], best: &mut Best<'_>) {
    let used = references.iter().fold(Bounds::EMPTY, |used, reference| used.join(&reference.bounds));
    // Infinite where everything lies in one plane.
    let scale = [0, 1, 2].map(|a| BINS as f32 / (used.max[a] - used.min[a]));
    let bin = |x: f32, axis: usize| (((x - used.min[axis]) * scale[axis]) as usize).min(BINS - 1);
    let (mut starts, mut stops) = ([[0_usize; BINS]; 3], [[0_usize; BINS]; 3]);
    for Reference { bounds, .. } in references {
        for axis in 0..3 {
            starts[axis][bin(bounds.min[axis], axis)] += 1;
            stops[axis][bin(bounds.max[axis], axis)] += 1;
        }
    }
    let count = references.len();
    for axis in 0..3 {
        if scale[axis].is_finite() {
            let (mut below, mut above) = (0, count);
            for i in 1..BINS {
                below += starts[axis][i - 1];
                above -= stops[axis][i - 1];
                best.consider(Cut { axis, at: used.min[axis] + i as f32 / scale[axis] }, below, above);
            }
        }
        best.consider(Cut { axis, at: used.min[axis].next_down() }, 0, count);
        best.consider(Cut { axis, at: used.max[axis] }, count, 0);
    }
}

/// The cheapest cut of a cell so far.
struct Best<'a> {
    cell: &'a Bounds,
    area: f32,
    cut: Option<Cut>,
    cost: f32,
}

impl Best<'_> {
    #[inline(always)]
    fn consider(&mut self, cut: Cut, below: usize, above: usize) {
        let Cut { axis, at } = cut;
        if !(self.cell.min[axis] < at && at < self.cell.max[axis]) {
            return;
        }
        // Half areas are linear in the third side.
        let side = |axis: usize| self.cell.max[axis % 3] - self.cell.min[axis % 3];
        let (one, other) = (side(axis + 1), side(axis + 2));
        let area = |third: f32| one * other + (one + other) * third;
        let tests = area(at - self.cell.min[axis]) * packs(below) + area(self.cell.max[axis] - at) * packs(above);
        let factor = if below == 0 || above == 0 { EMPTY_FACTOR } else { 1.0 };
        let cost = factor * (STEP_COST * self.area + tests);
        if cost < self.cost {
            (self.cut, self.cost) = (Some(cut), cost);
        }
    }
}

/// How many packs so many primitives fill.
fn packs(count: usize) -> f32 {
    count.div_ceil(LANES) as u32 as f32
}
