//! Lists of rays in flight by what they do next, filled without branches.

/// Numbers of slots, at most `SLOTS` of them: a power of two, at most 128.
#[derive(Clone, Copy, Debug)]
pub(super) struct List<const SLOTS: usize> {
    slots: [u8; SLOTS],
    len: usize,
}

impl<const SLOTS: usize> List<SLOTS> {
    pub const EMPTY: Self = Self { slots: [0; SLOTS], len: 0 };

    /// Adds a slot if a condition holds.
    #[inline(always)]
    pub fn add_if(&mut self, slot: usize, condition: bool) {
        self.slots[self.len % SLOTS] = slot as u8;
        self.len += usize::from(condition);
    }

    #[inline(always)]
    pub fn get(&self, place: usize) -> usize {
        usize::from(self.slots[place % SLOTS]) % SLOTS
    }

    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }
}
