//! Choice among a finite number of things in proportion to weights.

/// A number in [0, 1) has 24 bits: probabilities are whole multiples of 2^-24, so that the probability that is stated and
/// the one that is drawn are equal, not only nearly so.
const QUANTA: u32 = 1 << 24;

/// Weights that cannot be made into a [`Distribution1D`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DistributionError {
    /// More weights than [`Distribution1D::MAX_LEN`].
    #[error("{0} weights; at most {max} can be told apart", max = Distribution1D::MAX_LEN)]
    TooMany(usize),
    /// The weight at this index is negative, infinite or NaN.
    #[error("weight {0} is negative or not finite")]
    Invalid(usize),
}

/// What a [`Distribution1D`] chose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Choice {
    /// Index of the weight.
    pub index: usize,
    /// Its probability, above 0.
    pub probability: f32,
    /// The number that is left, uniform in [0, 1) with as many of the 24 bits as the choice has not used.
    pub remapped: f32,
}

/// A piecewise-constant distribution: of indices, or of numbers in [0, 1) with equal intervals. Immutable. A weight above 0
/// has a probability of at least 2^-24 and a weight of 0 has none, whatever the others.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Distribution1D {
    /// Weight i has the quanta `first[i]..first[i + 1]`; empty if all weights are 0.
    first: Vec<u32>,
    /// The weight that has the first quantum of each of equally long, 2^k many runs of quanta, and at the end the last
    /// weight (an index table: Chen and Asau, "On Generating Random Variates from an Empirical Distribution", 1974).
    guide: Vec<u32>,
    /// log2 of a run's length.
    run: u32,
}

impl Distribution1D {
    /// Most weights that a distribution takes: at least half of the quanta are left to be dealt in proportion.
    pub const MAX_LEN: usize = (QUANTA / 2) as usize;

    /// A distribution in proportion to the weights. If there are none above 0, nothing will be chosen.
    ///
    /// # Errors
    /// [`DistributionError`] above [`Self::MAX_LEN`], or if a weight is negative or not finite.
    pub fn new(weights: &[f64]) -> Result<Self, DistributionError> {
        if weights.len() > Self::MAX_LEN {
            return Err(DistributionError::TooMany(weights.len()));
        }
        if let Some(invalid) = weights.iter().position(|w| !w.is_finite() || *w < 0.0) {
            return Err(DistributionError::Invalid(invalid));
        }
        // Scaled, so that no sum overflows.
        let largest = weights.iter().copied().fold(0.0, f64::max);
        if largest <= 0.0 {
            return Ok(Self::default());
        }
        let total: f64 = weights.iter().map(|w| w / largest).sum();
        let positive = weights.iter().filter(|w| **w > 0.0).count() as u32;
        let shared = f64::from(QUANTA - positive);
        let (mut sum, mut own) = (0.0, 0);
        let mut first = vec![0];
        first.extend(weights.iter().map(|&w| {
            sum += w / largest;
            own += u32::from(w > 0.0);
            // Summed in the order of `total`, so that the last quotient is 1.
            (sum / total * shared + 0.5) as u32 + own
        }));
        let (guide, run) = index_table(&first);
        Ok(Self { first, guide, run })
    }

    /// True if nothing can be chosen.
    #[inline]
    pub fn is_empty(&self) -> bool {
        self.first.is_empty()
    }

    /// Probability of an index; 0 beyond the last.
    #[inline]
    pub fn probability(&self, index: usize) -> f32 {
        match self.first.get(index..index.saturating_add(2)) {
            Some(&[from, to]) => (to - from) as f32 * (1.0 / QUANTA as f32),
            _ => 0.0,
        }
    }

    /// The index for `u` in [0, 1); `None` if the distribution is empty.
    #[inline]
    pub fn choose(&self, u: f32) -> Option<Choice> {
        let quantum = ((u * QUANTA as f32) as u32).min(QUANTA - 1);
        let run = (quantum >> self.run) as usize;
        let (from, to) = (*self.guide.get(run)? as usize, *self.guide.get(run + 1)? as usize);
        // The last that begins at or before the quantum: those without quanta begin where the next does.
        let index = from + self.first.get(from + 1..=to)?.partition_point(|&begin| begin <= quantum);
        let &[from, to] = self.first.get(index..index + 2)? else { return None };
        let count = (to - from) as f32;
        Some(Choice { index, probability: count * (1.0 / QUANTA as f32), remapped: (quantum - from) as f32 / count })
    }

    /// A number in [0, 1) and its density, constant on each of the equal intervals that the weights stand for.
    #[inline]
    pub fn sample(&self, u: f32) -> Option<(f32, f32)> {
        let choice = self.choose(u)?;
        let count = (self.first.len() - 1) as f32;
        let x = (choice.index as f32 + choice.remapped) / count;
        Some((x.min(1.0 - f32::EPSILON / 2.0), choice.probability * count))
    }

    /// Density of [`Self::sample`] at `x`; 0 outside of [0, 1).
    #[inline]
    pub fn pdf(&self, x: f32) -> f32 {
        if self.is_empty() || !(0.0..1.0).contains(&x) {
            return 0.0;
        }
        let count = self.first.len() - 1;
        let index = ((x * count as f32) as usize).min(count - 1);
        self.probability(index) * count as f32
    }
}
/// For runs of quanta, at least one run a weight: the weight with a run's first quantum, and at the end the last weight.
fn index_table(first: &[u32]) -> (Vec<u32>, u32) {
    let Some(weights) = first.len().checked_sub(1) else { return (Vec::new(), 0) };
    let runs = (weights as u32).next_power_of_two().min(QUANTA);
    let run = QUANTA.trailing_zeros() - runs.trailing_zeros();
    let mut guide = Vec::with_capacity(runs as usize + 1);
    let mut weight = 0;
    for quantum in (0..runs).map(|r| r << run) {
        while first[weight + 1] <= quantum {
            weight += 1;
        }
        guide.push(weight as u32);
    }
    guide.push(weights as u32 - 1);
    (guide, run)
}
