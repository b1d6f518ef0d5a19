//! What each pixel keeps for its layers: only what was asked for.

use super::{
    Aov, PathSample,
    sums::{LENGTH, LIGHT, is_storable, mean, to_fixed},
};
use std::collections::TryReserveError;

/// Numbers that are summed for a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Quantity {
    Albedo,
    Normal,
    Direct,
    Alpha,
    Depth,
    Position,
    Uv,
}

impl Quantity {
    const ALL: [Self; 7] =
        [Self::Albedo, Self::Normal, Self::Direct, Self::Alpha, Self::Depth, Self::Position, Self::Uv];

    /// What the layer needs summed, if anything. Indirect light is the colour without direct light.
    pub fn of(aov: Aov) -> Option<Self> {
        match aov {
            Aov::Albedo => Some(Self::Albedo),
            Aov::Normal => Some(Self::Normal),
            Aov::Depth => Some(Self::Depth),
            Aov::Position => Some(Self::Position),
            Aov::Uv => Some(Self::Uv),
            Aov::Direct | Aov::Indirect => Some(Self::Direct),
            Aov::Alpha => Some(Self::Alpha),
            Aov::Ids | Aov::Samples | Aov::Variance => None,
        }
    }

    fn width(self) -> usize {
        match self {
            Self::Albedo | Self::Normal | Self::Direct | Self::Position => 3,
            Self::Uv => 2,
            Self::Alpha | Self::Depth => 1,
        }
    }

    /// True for what has no value where nothing is: averaged over the samples that met a surface, all with one weight, so
    /// that it stays between the values that were seen.
    fn is_of_hits(self) -> bool {
        matches!(self, Self::Depth | Self::Position | Self::Uv)
    }

    fn fraction(self) -> i32 {
        if self.is_of_hits() { LENGTH } else { LIGHT }
    }

    /// Up to three numbers of a sample.
    fn values(self, sample: &PathSample) -> [f32; 3] {
        let PathSample { weight, first, .. } = sample;
        match self {
            Self::Albedo => (first.albedo * *weight).0,
            Self::Normal => (first.normal * *weight).to_array(),
            Self::Direct => (sample.direct * *weight).0,
            Self::Alpha => [if sample.met_surface { *weight } else { 0.0 }; 3],
            Self::Depth => [first.depth; 3],
            Self::Position => first.position.to_array(),
            Self::Uv => [first.uv.x, first.uv.y, 0.0],
        }
    }
}

/// What the pixels of a film keep for layers, and where.
#[derive(Clone, Debug)]
pub(super) struct Plan {
    /// Each with the place of its first number.
    quantities: Vec<(Quantity, usize)>,
    /// Sums a pixel.
    sums: usize,
    /// Whether samples that met a surface are counted.
    hits: bool,
    ids: bool,
}

impl Plan {
    pub fn new(aovs: &[Aov], transparent: bool) -> Self {
        let mut plan = Self { quantities: Vec::new(), sums: 0, hits: false, ids: aovs.contains(&Aov::Ids) };
        for quantity in Quantity::ALL {
            let asked = aovs.iter().any(|aov| Quantity::of(*aov) == Some(quantity));
            if asked || (transparent && quantity == Quantity::Alpha) {
                plan.quantities.push((quantity, plan.sums));
                plan.sums += quantity.width();
                plan.hits |= quantity.is_of_hits();
            }
        }
        plan
    }

    fn has(&self, quantity: Quantity) -> bool {
        self.quantities.iter().any(|(q, _)| *q == quantity)
    }

    /// True if direct light is told apart.
    pub fn has_direct(&self) -> bool {
        self.has(Quantity::Direct)
    }

    /// True if anything of the first surface is kept.
    pub fn has_first_hits(&self) -> bool {
        let needs_first = |q: &Quantity| !matches!(q, Quantity::Direct | Quantity::Alpha);
        self.ids || self.quantities.iter().any(|(q, _)| needs_first(q))
    }
}

/// The layers of a run of pixels.
#[derive(Clone, Debug)]
pub(super) struct Layers {
    sums: Vec<i128>,
    hits: Vec<u32>,
    ids: Vec<[u32; 2]>,
}

impl Layers {
    /// Zeros for `pixels` pixels, or the allocator's refusal.
    pub fn new(plan: &Plan, pixels: usize) -> Result<Self, TryReserveError> {
        let of = |asked: bool| if asked { pixels } else { 0 };
        Ok(Self { sums: zeros(plan.sums * pixels)?, hits: zeros(of(plan.hits))?, ids: zeros(of(plan.ids))? })
    }

    /// Zeros for the few pixels of a tile.
    pub fn zeros(plan: &Plan, pixels: usize) -> Self {
        let of = |asked: bool| if asked { pixels } else { 0 };
        Self { sums: vec![0; plan.sums * pixels], hits: vec![0; of(plan.hits)], ids: vec![[0; 2]; of(plan.ids)] }
    }

    /// Keeps the ids of a pixel's first sample.
    #[inline]
    pub fn identify(&mut self, at: usize, sample: &PathSample, index: u32) {
        if index == 0
            && sample.part == 0
            && let Some(ids) = self.ids.get_mut(at)
        {
            *ids = [sample.first.object, sample.first.material];
        }
    }

    /// Adds a sample to pixel `at`.
    #[inline]
    pub fn add(&mut self, plan: &Plan, at: usize, sample: &PathSample) {
        for (quantity, offset) in &plan.quantities {
            // A part only has light.
            if sample.part > 0 && *quantity != Quantity::Direct {
                continue;
            }
            let from = at * plan.sums + offset;
            let fraction = quantity.fraction();
            let sums = self.sums[from..from + quantity.width()].iter_mut();
            for (sum, value) in sums.zip(quantity.values(sample)) {
                // Numbers that no scene should give count as 0: the colour beside them is good.
                if is_storable(value, fraction) {
                    *sum += to_fixed(value, fraction);
                }
            }
        }
        if let Some(hits) = self.hits.get_mut(at) {
            // Where there is no surface, all its numbers are 0.
            *hits += u32::from(sample.first.object != 0 && sample.part == 0);
        }
    }

    /// Adds pixels `from..from + pixels` of `other` to those from `at` on.
    pub fn merge(&mut self, plan: &Plan, at: usize, other: &Self, from: usize, pixels: usize) {
        let n = plan.sums;
        for (sum, more) in self.sums[at * n..(at + pixels) * n].iter_mut().zip(&other.sums[from * n..]) {
            *sum += more;
        }
        if plan.hits {
            for (hits, more) in self.hits[at..at + pixels].iter_mut().zip(&other.hits[from..]) {
                *hits += more;
            }
        }
        if plan.ids {
            for (ids, more) in self.ids[at..at + pixels].iter_mut().zip(&other.ids[from..]) {
                // Only the unit that holds sample 0 has ids.
                ids[0] |= more[0];
                ids[1] |= more[1];
            }
        }
    }

    /// Object and material of pixel `at`.
    pub fn ids(&self, at: usize) -> [u32; 2] {
        self.ids.get(at).copied().unwrap_or_default()
    }

    /// The sum of number `i` of a quantity; 0 if it is not kept.
    pub fn sum(&self, plan: &Plan, at: usize, quantity: Quantity, i: usize) -> i128 {
        let offset = plan.quantities.iter().find(|(q, _)| *q == quantity).map(|(_, offset)| offset);
        offset.map_or(0, |offset| self.sums[at * plan.sums + offset + i])
    }

    /// The mean of number `i` of a quantity over the pixel's `samples`, or over those that met a surface.
    pub fn mean(&self, plan: &Plan, at: usize, quantity: Quantity, i: usize, samples: u32) -> f32 {
        let samples = if quantity.is_of_hits() { self.hits.get(at).copied().unwrap_or(0) } else { samples };
        mean(self.sum(plan, at, quantity, i), samples, quantity.fraction())
    }
}

/// Zeros, or the allocator's refusal.
pub(super) fn zeros<T: Clone + Default>(count: usize) -> Result<Vec<T>, TryReserveError> {
    let mut values = Vec::new();
    values.try_reserve_exact(count)?;
    values.resize(count, T::default());
    Ok(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A pixel keeps the numbers of the layers that were asked for, 16 bytes each, and no others.
    #[test]
    fn only_what_is_asked_for_costs_memory() {
        let cost = |aovs: &[Aov], transparent| {
            let plan = Plan::new(aovs, transparent);
            let layers = Layers::new(&plan, 10).expect("memory");
            (layers.sums.len() / 10, layers.hits.len() / 10, layers.ids.len() / 10)
        };
        assert_eq!(cost(&[], false), (0, 0, 0));
        assert_eq!(cost(&[Aov::Variance, Aov::Samples], false), (0, 0, 0));
        assert_eq!(cost(&[Aov::Ids], false), (0, 0, 1));
        assert_eq!(cost(&[Aov::Depth], false), (1, 1, 0));
        assert_eq!(cost(&[Aov::Direct, Aov::Indirect], false), (3, 0, 0));
        assert_eq!(cost(&[], true), (1, 0, 0));
        assert_eq!(cost(&[Aov::Alpha], true), (1, 0, 0));
        assert_eq!(cost(&Aov::ALL, false), (16, 1, 1));
    }
}
