//! The corners of faces as they stand in a piece of a file, packed.

use super::unifier::NONE;

/// Numbers of positions, texture coordinates and normals.
pub(super) type Counts = [usize; 3];

/// An index as written: from 0; or back from the place where it stands, then counted from the first of its kind in the
/// piece, modulo 2^32.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Index {
    pub value: u32,
    pub relative: bool,
}

impl Index {
    /// No texture coordinates or normal.
    pub const ABSENT: Self = Self { value: NONE, relative: false };
}

/// Indices of texture coordinates or normals.
#[derive(Debug, Default)]
enum Attribute {
    /// No corner so far has one.
    #[default]
    Absent,
    /// The same as those of the positions.
    AsPositions,
    /// Of each corner.
    Own(Vec<u32>),
}

impl Attribute {
    #[inline(always)]
    fn push(&mut self, index: Index, positions: &[u32]) {
        let [before @ .., position] = positions else { return };
        match self {
            Attribute::Own(values) => values.push(index.value),
            Attribute::AsPositions if index.value == *position && index != Index::ABSENT => {}
            Attribute::Absent if index == Index::ABSENT => {}
            _ => self.diverge(index, *position, before),
        }
    }

    #[cold]
    fn diverge(&mut self, index: Index, position: u32, before: &[u32]) {
        let absent = matches!(self, Attribute::Absent);
        *self = if absent && before.is_empty() && index.value == position {
            Attribute::AsPositions
        } else {
            let mut values = if absent { vec![NONE; before.len()] } else { before.to_vec() };
            values.push(index.value);
            Attribute::Own(values)
        };
    }

    fn truncate(&mut self, count: usize) {
        if let Attribute::Own(values) = self {
            values.truncate(count);
        }
    }

    fn value(&self, corner: usize, position: u32) -> u32 {
        match self {
            Attribute::Absent => NONE,
            Attribute::AsPositions => position,
            Attribute::Own(values) => values[corner],
        }
    }
}

/// Corners of faces, one after the other.
#[derive(Debug, Default)]
pub(super) struct Corners {
    positions: Vec<u32>,
    uvs: Attribute,
    normals: Attribute,
    /// Which of a corner's indices are relative, by bits, from a corner on until the next entry; at first none.
    relative: Vec<(u32, u8)>,
}

impl Corners {
    pub fn len(&self) -> usize {
        self.positions.len()
    }

    #[inline(always)]
    pub fn push(&mut self, [position, uv, normal]: [Index; 3]) {
        let relative = u8::from(position.relative) | u8::from(uv.relative) << 1 | u8::from(normal.relative) << 2;
        if relative != self.relative.last().map_or(0, |(_, last)| *last) {
            self.relative.push((self.positions.len() as u32, relative));
        }
        self.positions.push(position.value);
        self.uvs.push(uv, &self.positions);
        self.normals.push(normal, &self.positions);
    }

    /// Forgets the corners from `count` on.
    pub fn truncate(&mut self, count: usize) {
        self.positions.truncate(count);
        self.uvs.truncate(count);
        self.normals.truncate(count);
        while self.relative.last().is_some_and(|(first, _)| *first as usize >= count) {
            self.relative.pop();
        }
    }

    pub fn shrink(&mut self) {
        self.positions.shrink_to_fit();
        for attribute in [&mut self.uvs, &mut self.normals] {
            if let Attribute::Own(values) = attribute {
                values.shrink_to_fit();
            }
        }
        self.relative.shrink_to_fit();
    }

    /// All indices count from the start of the file, and those of texture coordinates and normals are absent or, where the
    /// mesh has any, the same as those of the positions.
    pub fn are_alike(&self, has_uvs: bool, has_normals: bool) -> bool {
        let alike = |attribute: &Attribute, has: bool| match attribute {
            Attribute::Absent => !has,
            Attribute::AsPositions => has,
            Attribute::Own(_) => false,
        };
        let same = alike(&self.uvs, has_uvs) && alike(&self.normals, has_normals) && self.relative.is_empty();
        same || self.positions.is_empty()
    }

    /// The positions of the next three corners if these are [alike](Corners::are_alike) and no two are equal.
    #[inline(always)]
    pub fn triangle(&self, from: &mut Place) -> Option<[u32; 3]> {
        let [a, b, c] = *self.positions.get(from.corner..)?.first_chunk()?;
        let whole = a != b && b != c && c != a;
        from.corner += if whole { 3 } else { 0 };
        whole.then_some([a, b, c])
    }

    /// Appends the next `count` corners after `from` to `out`: indices of position, texture coordinates and normal in the file,
    /// [`NONE`] for none. `base` are the numbers of each kind before the piece.
    #[inline]
    pub fn resolve(&self, from: &mut Place, count: usize, base: Counts, out: &mut Vec<[u32; 3]>) {
        for corner in from.corner..from.corner + count {
            while let Some(&(first, flags)) = self.relative.get(from.run)
                && first as usize <= corner
            {
                from.relative = flags;
                from.run += 1;
            }
            let position = self.positions[corner];
            let mut indices = [position, self.uvs.value(corner, position), self.normals.value(corner, position)];
            if from.relative != 0 {
                for (kind, index) in indices.iter_mut().enumerate() {
                    if from.relative & 1 << kind != 0 {
                        *index = index.wrapping_add(base[kind] as u32);
                    }
                }
            }
            out.push(indices);
        }
        from.corner += count;
    }
}

/// How far [`Corners::resolve`] went.
#[derive(Debug, Default)]
pub(super) struct Place {
    corner: usize,
    run: usize,
    relative: u8,
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::{prelude::*, test_runner::RngSeed};

    fn index(most: u32) -> impl Strategy<Value = Index> {
        (prop_oneof![0..most, Just(NONE), Just(NONE - 1)], any::<bool>())
            .prop_map(|(value, relative)| Index { value, relative })
    }

    fn corner() -> impl Strategy<Value = [Index; 3]> {
        let same = (index(4), any::<bool>()).prop_map(|(i, own)| [i, i, if own { i } else { Index::ABSENT }]);
        prop_oneof![3 => same, 1 => [index(4), index(4), index(4)]]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2000, rng_seed: RngSeed::Fixed(6), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn what_was_pushed_comes_back(
            corners in prop::collection::vec(corner(), 0..40),
            wrong in prop::collection::vec(corner(), 0..5),
            at in 0usize..40,
        ) {
            let mut packed = Corners::default();
            for (i, &corner) in corners.iter().enumerate() {
                if i == at {
                    wrong.iter().for_each(|&corner| packed.push(corner));
                    packed.truncate(i);
                }
                packed.push(corner);
            }
            packed.shrink();
            prop_assert_eq!(packed.len(), corners.len());
            let base = [10, 200, 3000];
            let mut out = vec![];
            let mut place = Place::default();
            while out.len() < corners.len() {
                let count = (corners.len() - out.len()).min(3);
                packed.resolve(&mut place, count, base, &mut out);
            }
            for (corner, resolved) in corners.iter().zip(out) {
                for kind in 0..3 {
                    let Index { value, relative } = corner[kind];
                    let expected = if relative { value.wrapping_add(base[kind] as u32) } else { value };
                    prop_assert_eq!(resolved[kind], expected);
                }
            }
        }
    }
}
