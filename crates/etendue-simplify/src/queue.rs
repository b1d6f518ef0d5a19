//! Edges in the order of their cost.

use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// An edge that may be collapsed. The order is that of cost; equal costs are told apart by the vertices, so that nothing
/// depends on the order of arrival.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Entry(u128);

impl Entry {
    /// `cost` is not negative and a number; the bits of such numbers are in the order of the numbers.
    pub fn new(cost: f32, ends: [u32; 2], stamp: u32) -> Self {
        Self(
            u128::from(cost.to_bits()) << 96
                | u128::from(ends[0]) << 64
                | u128::from(ends[1]) << 32
                | u128::from(stamp),
        )
    }

    pub fn cost(self) -> f32 {
        f32::from_bits((self.0 >> 96) as u32)
    }

    pub fn ends(self) -> [u32; 2] {
        [(self.0 >> 64) as u32, (self.0 >> 32) as u32]
    }

    pub fn stamp(self) -> u32 {
        self.0 as u32
    }
}

/// Costs of one bucket have the exponent and the first two bits of the fraction in common: a quarter of an octave.
const SHIFT: u32 = 21;

#[inline(always)]
fn bucket_of(cost: f32) -> usize {
    (cost.to_bits() >> SHIFT) as usize
}

/// More than the bucket of any cost.
pub(crate) const ALL: usize = 1 << (32 - SHIFT);

/// A heap of what is in buckets below a limit, and the rest by bucket, so that a higher limit touches what it adds alone.
#[derive(Debug, Default)]
pub(crate) struct Queue {
    heap: BinaryHeap<Reverse<Entry>>,
    /// Bucket `first` and what follows.
    rest: Vec<Vec<Entry>>,
    first: usize,
    limit: usize,
}

impl Queue {
    /// With limit 0.
    pub fn new(entries: &[Entry]) -> Self {
        let first = entries.iter().map(|entry| bucket_of(entry.cost())).min().unwrap_or(0);
        let mut counts = Vec::new();
        for entry in entries {
            let bucket = bucket_of(entry.cost()) - first;
            if bucket >= counts.len() {
                counts.resize(bucket + 1, 0);
            }
            counts[bucket] += 1;
        }
        let mut rest: Vec<Vec<Entry>> = counts.into_iter().map(Vec::with_capacity).collect();
        for &entry in entries {
            rest[bucket_of(entry.cost()) - first].push(entry);
        }
        Self { heap: BinaryHeap::new(), rest, first, limit: 0 }
    }

    pub fn push(&mut self, entry: Entry) {
        let bucket = bucket_of(entry.cost());
        if bucket < self.limit {
            self.heap.push(Reverse(entry));
            return;
        }
        // What is cheaper than all that was there at first waits with the cheapest.
        let place = bucket.saturating_sub(self.first);
        if place >= self.rest.len() {
            self.rest.resize_with(place + 1, Vec::new);
        }
        self.rest[place].push(entry);
    }

    /// The cheapest within the limit.
    pub fn pop(&mut self) -> Option<Entry> {
        self.heap.pop().map(|entry| entry.0)
    }

    /// What is likely to be popped soon: first the next, then two that come before most others, and so on.
    pub fn soon(&self) -> &[Reverse<Entry>] {
        self.heap.as_slice()
    }

    /// Raises the limit to the bucket that is not within any more; what is not `alive` is forgotten.
    pub fn raise(&mut self, limit: usize, alive: impl Fn(Entry) -> bool) {
        self.limit = self.limit.max(limit);
        let mut within = std::mem::take(&mut self.heap).into_vec();
        for bucket in self.rest.iter_mut().take(limit.saturating_sub(self.first)) {
            within.extend(std::mem::take(bucket).into_iter().filter(|&entry| alive(entry)).map(Reverse));
        }
        self.heap = within.into();
    }

    /// Adds how much waits in each bucket, what is outdated included.
    pub fn count(&self, counts: &mut [usize]) {
        for (count, bucket) in counts.iter_mut().skip(self.first).zip(&self.rest) {
            *count += bucket.len();
        }
    }
}
