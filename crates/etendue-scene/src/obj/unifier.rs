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
    /// Of each triple, the next one with its position.
    next: Vec<u32>,
    triples: Triples,
    overflow: Table,
}

/// Numbers positions in the order of their first use, where corners with the same position are all alike.
pub(crate) struct PositionNumbers {
    /// Of each position, [`NONE`] if it has not been used.
    numbers: Vec<u32>,
    /// By their numbers.
    used: Vec<u32>,
}

impl PositionNumbers {
    pub fn new(positions: usize) -> Self {
        Self { numbers: vec![NONE; positions], used: Vec::with_capacity(positions) }
    }

    /// The position's number.
    #[inline(always)]
    pub fn number(&mut self, position: u32) -> u32 {
        let number = &mut self.numbers[position as usize];
        if *number == NONE {
            *number = self.used.len() as u32;
            self.used.push(position);
        }
        *number
    }

    /// Every position that was used, by its number.
    pub fn into_used(self) -> Vec<u32> {
        self.used
    }
}

/// What was numbered, an array for each part. Texture coordinates and shadings are left out where none was ever given.
#[derive(Default)]
pub(crate) struct Triples {
    pub positions: Vec<u32>,
    uvs: Vec<u32>,
    shadings: Vec<u64>,
}

impl Triples {
    /// Of each triple, its texture coordinates, [`NONE`] for none.
    pub fn uvs(&self) -> impl Iterator<Item = u32> + '_ {
        (0..self.positions.len()).map(|triple| self.uv(triple))
    }

    /// Of each triple, its shading.
    pub fn shadings(&self) -> impl Iterator<Item = u64> + '_ {
        (0..self.positions.len()).map(|triple| self.shading(triple))
    }

    /// Forgets the texture coordinates, to save memory.
    pub fn drop_uvs(&mut self) {
        self.uvs = vec![];
    }

    #[inline(always)]
    fn uv(&self, triple: usize) -> u32 {
        self.uvs.get(triple).copied().unwrap_or(NONE)
    }

    #[inline(always)]
    fn shading(&self, triple: usize) -> u64 {
        self.shadings.get(triple).copied().unwrap_or(0)
    }

    fn push(&mut self, position: u32, uv: u32, shading: u64) {
        let before = self.positions.len();
        self.positions.push(position);
        push_sparse(&mut self.uvs, before, uv, NONE, self.positions.capacity());
        push_sparse(&mut self.shadings, before, shading, 0, self.positions.capacity());
    }
}

/// Appends to an array that stays empty until the first value that is not the `usual` one.
fn push_sparse<T: Copy + PartialEq>(values: &mut Vec<T>, count: usize, value: T, usual: T, capacity: usize) {
    if value != usual || !values.is_empty() {
        if values.len() < count || values.capacity() == 0 {
            values.reserve_exact(capacity.max(count + 1));
            values.resize(count, usual);
        }
        values.push(value);
    }
}

const LONGEST: usize = 12;

impl Unifier {
    pub fn new(positions: usize) -> Self {
        let triples = Triples { positions: Vec::with_capacity(positions), ..Triples::default() };
        let next = Vec::with_capacity(positions);
        Self { heads: vec![NONE; positions], next, triples, overflow: Table::default() }
    }

    /// The triple's number, and whether it is new.
    #[inline]
    pub fn number(&mut self, position: u32, uv: u32, shading: u64) -> (u32, bool) {
        let new = self.next.len() as u32;
        let mut last = NONE;
        let mut at = self.heads[position as usize];
        let mut steps = 0;
        while at != NONE {
            if (self.triples.uv(at as usize), self.triples.shading(at as usize)) == (uv, shading) {
                return (at, false);
            }
            (last, at) = (at, self.next[at as usize]);
            steps += 1;
            if steps == LONGEST {
                let found = self.overflow.find_or_insert((position, uv, shading), new, &self.triples);
                if found == new {
                    self.push(position, uv, shading);
                }
                return (found, found == new);
            }
        }
        match last {
            NONE => self.heads[position as usize] = new,
            last => self.next[last as usize] = new,
        }
        self.push(position, uv, shading);
        (new, true)
    }

    fn push(&mut self, position: u32, uv: u32, shading: u64) {
        self.next.push(NONE);
        self.triples.push(position, uv, shading);
    }

    /// Every triple, by its number.
    pub fn into_triples(self) -> Triples {
        self.triples
    }
}

/// Numbers of triples by hash, open addressing with linear probing.
#[derive(Default)]
struct Table {
    slots: Vec<u32>,
    used: usize,
}

fn hash((position, uv, shading): (u32, u32, u64)) -> u64 {
    // The finaliser of SplitMix64 (Steele, Lea, Flood 2014) over both words.
    let mix = |z: u64| {
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    mix(mix(u64::from(position) << 32 | u64::from(uv)) ^ shading)
}

fn of(triples: &Triples, number: u32) -> (u32, u32, u64) {
    let number = number as usize;
    (triples.positions[number], triples.uv(number), triples.shading(number))
}

impl Table {
    fn find_or_insert(&mut self, triple: (u32, u32, u64), new: u32, triples: &Triples) -> u32 {
        if (self.used + 1) * 2 > self.slots.len() {
            self.grow(triples);
        }
        let slot = self.probe(triple, triples);
        if self.slots[slot] == NONE {
            self.slots[slot] = new;
            self.used += 1;
        }
        self.slots[slot]
    }

    /// The slot that holds the triple, or the empty one where it belongs.
    fn probe(&self, wanted: (u32, u32, u64), triples: &Triples) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash(wanted) as usize & mask;
        while self.slots[slot] != NONE && of(triples, self.slots[slot]) != wanted {
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn grow(&mut self, triples: &Triples) {
        let larger = vec![NONE; (self.slots.len() * 2).max(64)];
        for number in std::mem::replace(&mut self.slots, larger).into_iter().filter(|&n| n != NONE) {
            let slot = self.probe(of(triples, number), triples);
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
        fn numbers_are_those_of_first_use(corners in prop::collection::vec((0u32..3, prop_oneof![Just(NONE), 0u32..4], 0u64..100), 0..2000), plain in 0usize..20) {
            let mut unifier = Unifier::new(3);
            let mut seen = HashMap::new();
            for (i, &(position, uv, shading)) in corners.iter().enumerate() {
                // At first without what later ones have.
                let (uv, shading) = if i < plain { (NONE, 0) } else { (uv, shading) };
                let next = seen.len() as u32;
                let expected = *seen.entry((position, uv, shading)).or_insert(next);
                prop_assert_eq!(unifier.number(position, uv, shading), (expected, expected == next));
            }
            let triples = unifier.into_triples();
            prop_assert_eq!(triples.positions.len(), seen.len());
            let all = triples.positions.iter().zip(triples.uvs()).zip(triples.shadings());
            prop_assert!(all.enumerate().all(|(i, ((&p, uv), shading))| seen[&(p, uv, shading)] == i as u32));
        }
    }
}
