//! One vertex for equal positions.

use etendue_accel::prefetch;
use glam::DVec3;

/// Numbers distinct positions in the order of their first use.
#[derive(Default)]
pub(crate) struct Welder {
    positions: Vec<DVec3>,
    /// Numbers by hash, open addressing with linear probing; a power of two of them, [`EMPTY`] where there is none.
    slots: Vec<u32>,
}

const EMPTY: u32 = u32::MAX;

fn hash(position: DVec3) -> u64 {
    // The finaliser of SplitMix64 (Steele, Lea, Flood 2014) over the three words.
    position.to_array().iter().fold(0, |state: u64, c| {
        let z = state ^ c.to_bits();
        let z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    })
}

impl Welder {
    /// For about so many distinct positions; more are fine.
    pub fn for_about(positions: usize) -> Self {
        let slots = positions.saturating_mul(2).next_power_of_two().max(64);
        Self { positions: Vec::with_capacity(positions), slots: vec![EMPTY; slots] }
    }

    /// The position's number: that of an equal one before, or a new one. `None` if there are 2^32 - 1 already.
    /// Coordinates must not be NaN; -0 equals 0.
    #[inline]
    pub fn number(&mut self, position: DVec3) -> Option<u32> {
        // Minus zero becomes zero.
        let position = position + 0.0;
        if (self.positions.len() + 1) * 2 > self.slots.len() {
            self.grow();
        }
        let slot = self.probe(position);
        if self.slots[slot] == EMPTY {
            if self.positions.len() >= EMPTY as usize {
                return None;
            }
            self.slots[slot] = self.positions.len() as u32;
            self.positions.push(position);
        }
        Some(self.slots[slot])
    }

    /// Asks memory for what [`Self::number`] will look at for these positions: in tables larger than the caches that is where
    /// the time goes, and many can be on their way at once. At most [`Self::AHEAD`] are asked for.
    pub fn expect(&self, positions: impl Iterator<Item = DVec3>) {
        if self.positions.len() < Self::SMALL {
            return;
        }
        let mask = self.slots.len() - 1;
        let mut expected = [0; Self::AHEAD];
        let mut count = 0;
        for (slot, position) in expected.iter_mut().zip(positions) {
            *slot = hash(position + 0.0) as usize & mask;
            prefetch(&self.slots[*slot]);
            count += 1;
        }
        for slot in &expected[..count] {
            if let Some(position) = self.positions.get(self.slots[*slot] as usize) {
                prefetch(position);
            }
        }
    }

    /// So many positions are as many as is good to wait for at once.
    pub const AHEAD: usize = 96;

    /// Tables of so few positions are in the caches.
    const SMALL: usize = 1 << 14;

    /// Every position, by its number.
    pub fn into_positions(self) -> Vec<DVec3> {
        self.positions
    }

    /// The slot that holds the position, or the empty one where it belongs.
    fn probe(&self, position: DVec3) -> usize {
        let mask = self.slots.len() - 1;
        let mut slot = hash(position) as usize & mask;
        while self.slots[slot] != EMPTY && self.positions[self.slots[slot] as usize] != position {
            slot = (slot + 1) & mask;
        }
        slot
    }

    fn grow(&mut self) {
        self.slots = vec![EMPTY; (self.slots.len() * 2).max(64)];
        for (number, position) in self.positions.iter().enumerate() {
            let slot = self.probe(*position);
            self.slots[slot] = number as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::dvec3;

    #[test]
    fn numbers_go_by_first_use() {
        let mut welder = Welder::default();
        let point = |i: u32| dvec3(f64::from(i % 17), f64::from(i % 13) - 6.0, 0.1 * f64::from(i % 5));
        // 17, 13 and 5 have no common divisor: 1105 points, which come round again.
        for i in 0..5000 {
            assert_eq!(welder.number(point(i)), Some(i % 1105));
        }
        assert_eq!(welder.number(dvec3(-0.0, -6.0, -0.0)), Some(0));
        assert_eq!(welder.number(dvec3(f64::MIN_POSITIVE, -6.0, 0.0)), Some(1105));
        assert_eq!(welder.into_positions().len(), 1106);
    }
}
