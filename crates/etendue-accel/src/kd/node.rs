//! The memory layout of the kd-tree: nodes of eight bytes, eight to a cache line, and packs of four triangles.

use bytemuck::{Pod, Zeroable};

/// A node. Children lie side by side.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
pub(super) struct Node {
    /// Where an inner node is cut; bits that say what a leaf holds: a number of packs, or one of the values below.
    pub at: f32,
    /// Two bits of kind: an axis, or [`Node::LEAF`]. An inner node has two bits for its lower and upper child, set if there is nothing in
    /// it, and the index of its pair of children; a leaf has an index.
    pub word: u32,
}

/// Nodes of a cache line.
pub(super) const LINE: usize = 8;

/// A cache line of nodes.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub(super) struct Line(pub [Node; LINE]);

impl Node {
    pub const LEAF: u32 = 3;

    /// Leaves have fewer packs than this.
    pub const COUNT_LIMIT: u32 = 1 << 31;

    /// The index is that of a node where a run of others begins.
    const RUN: u32 = Self::COUNT_LIMIT;
    /// The index is that of an [`super::arrays::Other`], and the next node follows.
    const OTHER: u32 = Self::COUNT_LIMIT + 1;
    /// The same, and nothing follows.
    const LAST_OTHER: u32 = Self::COUNT_LIMIT + 2;
    /// Below the stack of an instance that was entered.
    const LEAVE: u32 = Self::COUNT_LIMIT + 3;
    /// At the bottom of every stack.
    const END: u32 = Self::COUNT_LIMIT + 4;

    /// Indices of pairs are below this.
    pub const PAIR_LIMIT: u64 = 1 << 28;

    /// Indices of leaves are below this.
    pub const INDEX_LIMIT: u64 = 1 << 30;

    pub fn inner(axis: u8, at: f32, pair: u32, [lower_empty, upper_empty]: [bool; 2]) -> Self {
        let word = pair << 4 | u32::from(upper_empty) << 3 | u32::from(lower_empty) << 2 | u32::from(axis);
        Self { at, word }
    }

    pub fn leaf(leaf: Leaf) -> Self {
        let (what, index) = match leaf {
            Leaf::Packs { first, count } => (count, first),
            Leaf::Run(first) => (Self::RUN, first),
            Leaf::Other { index, is_last: false } => (Self::OTHER, index),
            Leaf::Other { index, is_last: true } => (Self::LAST_OTHER, index),
            Leaf::Leave => (Self::LEAVE, 0),
            Leaf::End => (Self::END, 0),
        };
        Self { at: f32::from_bits(what), word: index << 2 | Self::LEAF }
    }

    /// What a leaf holds.
    #[inline(always)]
    pub fn as_leaf(self) -> Leaf {
        let index = self.word >> 2;
        match self.at.to_bits() {
            Self::RUN => Leaf::Run(index),
            Self::OTHER => Leaf::Other { index, is_last: false },
            Self::LAST_OTHER => Leaf::Other { index, is_last: true },
            Self::LEAVE => Leaf::Leave,
            Self::END => Leaf::End,
            count => Leaf::Packs { first: index, count },
        }
    }
}

/// What a leaf says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Leaf {
    /// Packs of triangles.
    Packs { first: u32, count: u32 },
    /// Go on at another node.
    Run(u32),
    /// A sphere or an instance; the next node follows unless it is the last.
    Other { index: u32, is_last: bool },
    /// Back to the world.
    Leave,
    /// The search is over.
    End,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn leaves_round_trip() {
        let last = (Node::INDEX_LIMIT - 1) as u32;
        for leaf in [
            Leaf::Packs { first: last, count: 0 },
            Leaf::Packs { first: 0, count: Node::COUNT_LIMIT - 1 },
            Leaf::Run(last),
            Leaf::Other { index: 3, is_last: false },
            Leaf::Other { index: last, is_last: true },
            Leaf::Leave,
            Leaf::End,
        ] {
            let node = Node::leaf(leaf);
            assert_eq!((node.as_leaf(), node.word & 3), (leaf, Node::LEAF));
        }
        let inner = Node::inner(2, 1.5, (Node::PAIR_LIMIT - 1) as u32, [true, false]);
        assert_eq!((inner.at, inner.word), (1.5, 0xffff_fff6));
    }
}
