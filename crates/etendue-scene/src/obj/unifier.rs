//! One vertex for equal corners.

/// No texture coordinates, normal or material.
pub(crate) const NONE: u32 = u32::MAX;

/// Numbers distinct (position, texture coordinates, shading) triples in the order of their first use.
///
/// Triples with the same position are chained, which finds them without a hash and near in memory; a chain stops at
/// `LONGEST`, and further triples go to a hash table, so that a position with very many of them costs no more.
pub(crate) struct Unifier {
    /// First triple of each position.
    heads: Vec<u32>,
    triples: Vec<Triple>,
    overflow: Table,
}

#[derive(Clone, Copy, PartialEq, Eq)]
pub(crate) struct Triple {
    pub position: u32,
    pub uv: u32,
    pub shading: u64,
    next: u32,
}

const LONGEST: usize = 12;

impl Unifier {
    pub fn new(positions: usize) -> Self {
        Self { heads: vec![NONE; positions], triples: Vec::new(), overflow: Table::default() }
    }

    /// The triple's number, and whether it is new.
    #[inline]
    pub fn number(&mut self, position: u32, uv: u32, shading: u64) -> (u32, bool) {
        let wanted = Triple { position, uv, shading, next: NONE };
        let new = self.triples.len() as u32;
        let mut last = NONE;
        let mut at = self.heads[position as usize];
        let mut steps = 0;
        while at != NONE {
            let triple = &self.triples[at as usize];
            if (triple.uv, triple.shading) == (uv, shading) {
                return (at, false);
            }
            (last, at) = (at, triple.next);
            steps += 1;
            if steps == LONGEST {
                let found = self.overflow.find_or_insert(&wanted, new, &self.triples);
                if found == new {
                    self.triples.push(wanted);
                }
                return (found, found == new);
            }
        }
        match last {
            NONE => self.heads[position as usize] = new,
            last => self.triples[last as usize].next = new,
        }
        self.triples.push(wanted);
        (new, true)
    }

    /// Every triple, by its number.
    pub fn into_triples(self) -> Vec<Triple> {
        self.triples
    }
}

/// Numbers of triples by hash, open addressing with linear probing.
#[derive(Default)]
struct Table {
    slots: Vec<u32>,
    used: usize,
}

fn hash(triple: &Triple) -> u64 {
    // The finaliser of SplitMix64 (Steele, Lea, Flood 2014) over both words.
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    mix(mix(u64::from(triple.position) << 32 | u64::from(triple.uv)) ^ triple.shading)
}

impl Table {
    fn find_or_insert(&mut self, wanted: &Triple, new: u32, triples: &[Triple]) -> u32 {
        if (self.used + 1) * 2 > self.slots.len() {
            self.grow(triples);
        }
        let slot = self.probe(wanted, triples);
        if self.slots[slot] == NONE {
            self.slots[slot] = new;
            self.used += 1;
        }
        self.slots[slot]
    }

    /// The slot that holds the triple, or the empty one where it belongs.
    fn probe(&self, wanted: &Triple, triples: &[Triple]) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash(wanted) as usize & mask;
        while self.slots[slot] != NONE {
            let triple = &triples[self.slots[slot] as usize];
            if (triple.position, triple.uv, triple.shading) == (wanted.position, wanted.uv, wanted.shading) {
                break;
            }
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn grow(&mut self, triples: &[Triple]) {
        let larger = vec![NONE; (self.slots.len() * 2).max(64)];
        for number in std::mem::replace(&mut self.slots, larger).into_iter().filter(|&n| n != NONE) {
            let slot = self.probe(&triples[number as usize], triples);
            self.slots[slot] = number;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{prelude::*, test_runner::RngSeed};
    use std::collections::HashMap;

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, rng_seed: RngSeed::Fixed(5), failure_persistence: None, ..ProptestConfig::default() })]

        /// Few positions and many shadings, so that the table grows.
        #[test]
        fn numbers_are_those_of_first_use(corners in prop::collection::vec((0u32..3, 0u32..4, 0u64..100), 0..2000)) {
            let mut unifier = Unifier::new(3);
            let mut seen = HashMap::new();
            for &(position, uv, shading) in &corners {
                let next = seen.len() as u32;
                let expected = *seen.entry((position, uv, shading)).or_insert(next);
                prop_assert_eq!(unifier.number(position, uv, shading), (expected, expected == next));
            }
            let triples = unifier.into_triples();
            prop_assert_eq!(triples.len(), seen.len());
            prop_assert!(triples.iter().enumerate().all(|(i, t)| seen[&(t.position, t.uv, t.shading)] == i as u32));
        }
    }
}
