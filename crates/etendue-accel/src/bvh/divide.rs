//! Items divided in two in place, by one thread or several, the same way however many.

use rayon::prelude::*;

use super::bins::{Binning, Box8, Split};
use crate::isa::{Isa, Kernel, run};
use crate::items::Item;

/// Items that a thread divides, bins or measures in one go.
pub(super) const CHUNK: usize = 1 << 14;

/// Two sets of items.
#[derive(Clone, Copy, Debug)]
pub(super) struct Divided {
    /// The size of the first set.
    pub middle: usize,
    /// Around the (doubled) middles of both.
    pub middles: [Box8; 2],
}

impl Divided {
    fn join(&self, other: &Self) -> Self {
        let [a, b] = self.middles;
        let [c, d] = other.middles;
        Self { middle: self.middle + other.middle, middles: [a.join(&c), b.join(&d)] }
    }
}

/// Moves the items on the first side of a split to the front.
#[inline(always)]
pub(super) fn divide(items: &mut [Item], binning: &Binning, split: &Split) -> Divided {
    let mut middles = [Box8::EMPTY; 2];
    let mut middle = 0;
    for i in 0..items.len() {
        // Nobody can foretell which side it is, so there is no branch.
        let item = items[i];
        let (second, this) = (usize::from(!binning.is_first(&item, split)), Box8::middle_of(&item));
        middles[0] = middles[0].join_unless(&this, second);
        middles[1] = middles[1].join_unless(&this, 1 - second);
        items[i] = items[middle];
        items[middle] = item;
        middle += 1 - second;
    }
    Divided { middle, middles }
}

/// The same in parallel, in chunks whose wrong ends are exchanged then.
pub(super) fn divide_in_parallel(items: &mut [Item], binning: &Binning, split: &Split, isa: Isa) -> Divided {
    let parts: Vec<Divided> =
        items.par_chunks_mut(CHUNK).map(|items| run(isa, Chunk { items, binning, split })).collect();
    let nothing = Divided { middle: 0, middles: [Box8::EMPTY; 2] };
    let all = parts.iter().fold(nothing, |all, part| all.join(part));
    let (mut seconds_before, mut firsts_behind) = (Vec::new(), Vec::new());
    let mut start = 0;
    for (chunk, part) in items.chunks_mut(CHUNK).zip(&parts) {
        let (next, seconds_start) = (start + chunk.len(), start + part.middle);
        let (firsts, seconds) = chunk.split_at_mut(part.middle);
        let wrong = all.middle.saturating_sub(seconds_start).min(seconds.len());
        seconds_before.push(&mut seconds[..wrong]);
        let right = all.middle.saturating_sub(start).min(firsts.len());
        firsts_behind.push(&mut firsts[right..]);
        start = next;
    }
    pairs(seconds_before, firsts_behind).into_par_iter().for_each(|(a, b)| a.swap_with_slice(b));
    all
}

struct Chunk<'a> {
    items: &'a mut [Item],
    binning: &'a Binning,
    split: &'a Split,
}

impl Kernel for Chunk<'_> {
    type Output = Divided;

    #[inline(always)]
    fn run(self) -> Divided {
        divide(self.items, self.binning, self.split)
    }
}

/// Slices of two lists, which are of the same length together, cut into pairs of equal length.
fn pairs<'a, T>(firsts: Vec<&'a mut [T]>, seconds: Vec<&'a mut [T]>) -> Vec<(&'a mut [T], &'a mut [T])> {
    let mut pairs = Vec::new();
    let mut seconds = seconds.into_iter().filter(|slice| !slice.is_empty());
    let mut second: &mut [T] = &mut [];
    for mut first in firsts {
        while !first.is_empty() {
            if second.is_empty() {
                let Some(next) = seconds.next() else { return pairs };
                second = next;
            }
            let length = first.len().min(second.len());
            let ((a, rest_of_first), (b, rest_of_second)) = (first.split_at_mut(length), second.split_at_mut(length));
            pairs.push((a, b));
            (first, second) = (rest_of_first, rest_of_second);
        }
    }
    pairs
}
