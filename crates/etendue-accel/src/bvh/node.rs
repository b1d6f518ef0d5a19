//! The memory layout of the 8-wide BVH: nodes of four cache lines, packs of four triangles of three.

use bytemuck::{Pod, Zeroable};

use crate::bounds::Bounds;
use crate::local_ray::{Axis, LocalRay};

/// Children of a node.
pub(crate) const WIDTH: usize = 8;

/// Triangles of a pack.
pub(crate) const LANES: usize = 4;

/// Eight boxes with what is in them. A missing child has an inverted infinite box, which no ray enters.
#[repr(C, align(64))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Node {
    /// Low x, high x, low y, high y, low z, high z of the children.
    pub rows: [[f32; WIDTH]; 6],
    /// [`Child`] words.
    pub children: [u32; WIDTH],
    /// For each octant of directions, the children from far to near, 3 bits each, the farthest lowest.
    pub order: [u32; 8],
}

/// Rows of a node by axis, near planes and then far ones (the fourth of each is not used).
type Rows = [[u8; 4]; 2];

/// For each octant, where the rows begin in [`Node::rows`], counted in numbers.
static ROWS: [Rows; 8] = {
    let mut rows = [[[0; 4]; 2]; 8];
    let mut i = 0;
    while i < 24 {
        let (octant, axis) = (i % 8, i / 8);
        let negative = octant >> axis & 1;
        rows[octant][0][axis] = (WIDTH * (2 * axis + negative)) as u8;
        rows[octant][1][axis] = (WIDTH * (2 * axis + 1 - negative)) as u8;
        i += 1;
    }
    rows
};

/// Where the rows of near and of far planes begin for rays of an octant.
#[inline(always)]
pub(crate) fn rows_of(octant: u32) -> &'static Rows {
    &ROWS[octant as usize & 7]
}

impl Node {
    /// The eight planes of a row that begins at a number; the last row for what is beyond.
    #[inline(always)]
    pub fn row(&self, start: u8) -> &[f32; WIDTH] {
        &self.rows[(usize::from(start) / WIDTH).min(5)]
    }

    /// In which order children are visited, see [`Self::order`]: where any hit will do, the last first.
    #[inline(always)]
    pub fn order_of<const ANY: bool>(&self, octant: u32) -> u32 {
        if ANY { 0o7654_3210 } else { self.order[octant as usize & 7] }
    }

    /// A node with these children in this order, at most eight: those last in which rays are most likely to hit something.
    #[inline(always)]
    pub fn new(children: &[(Bounds, u32)]) -> Self {
        let mut node = Self { rows: [[0.0; WIDTH]; 6], children: [0; WIDTH], order: [0; 8] };
        for i in 0..WIDTH {
            let (bounds, word) = children.get(i).copied().unwrap_or((Bounds::EMPTY, 0));
            for axis in 0..3 {
                node.rows[2 * axis][i] = bounds.min[axis];
                node.rows[2 * axis + 1][i] = bounds.max[axis];
            }
            node.children[i] = word;
        }
        let mut middles = [[0.0; WIDTH]; 3];
        for (i, (bounds, _)) in children.iter().enumerate().take(WIDTH) {
            let middle = bounds.middle();
            for axis in 0..3 {
                middles[axis][i] = middle[axis];
            }
        }
        node.order = orders(&middles);
        node
    }
}

/// Children from far to near for each octant, see [`Node::order`], from their (doubled) middles by axis.
#[inline(always)]
fn orders(middles: &[[f32; WIDTH]; 3]) -> [u32; 8] {
    let mut orders = [0; 8];
    for (octant, order) in orders.iter_mut().enumerate() {
        let mut signs = [1.0_f32; 3];
        for (axis, sign) in signs.iter_mut().enumerate() {
            *sign = if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
        }
        let (mut depths, mut places) = ([0.0; WIDTH], [0_u32; WIDTH]);
        for i in 0..WIDTH {
            depths[i] = (signs[0] * middles[0][i] + signs[1] * middles[1][i]) + signs[2] * middles[2][i];
        }
        for other in 0..WIDTH {
            for i in 0..WIDTH {
                let farther = depths[other] > depths[i];
                let equal_before = depths[other] == depths[i] && other < i;
                places[i] += u32::from(farther | equal_before);
            }
        }
        for (i, place) in places.into_iter().enumerate() {
            *order |= (i as u32) << (3 * place);
        }
    }
    orders
}

/// What a child word says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Child {
    /// An inner node.
    Node(u32),
    /// Packs of triangles.
    Packs { first: u32, count: u32 },
    /// Spheres.
    Spheres { first: u32, count: u32 },
    /// One transformed instance.
    Instance(u32),
}

impl Child {
    /// Indices are below this, those of nodes too.
    pub const LIMIT: u64 = 1 << 27;

    /// Most packs or spheres of a leaf.
    pub const COUNT_LIMIT: usize = 8;

    /// Two bits of kind, three of count less one, 27 of index.
    pub fn word(self) -> u32 {
        match self {
            Self::Node(index) => index,
            Self::Packs { first, count } => 1 << 30 | (count - 1) << 27 | first,
            Self::Spheres { first, count } => 2 << 30 | (count - 1) << 27 | first,
            Self::Instance(index) => 3 << 30 | index,
        }
    }

    /// True for the words of inner nodes, which are their indices.
    #[inline(always)]
    pub fn is_node(word: u32) -> bool {
        word < 1 << 30
    }

    /// True for the words of packs.
    #[inline(always)]
    pub fn is_packs(word: u32) -> bool {
        word >> 30 == 1
    }

    /// The index of what a word of any kind leads to.
    #[inline(always)]
    pub fn first(word: u32) -> usize {
        (word & ((1 << 27) - 1)) as usize
    }

    /// For a word of packs, whether there is but one, and the word without the first.
    #[inline(always)]
    pub fn next_pack(word: u32) -> (bool, u32) {
        (word & 7 << 27 == 0, word.wrapping_sub(1 << 27).wrapping_add(1))
    }

    #[inline(always)]
    pub fn of(word: u32) -> Self {
        let (first, count) = (word & ((1 << 27) - 1), ((word >> 27) & 7) + 1);
        match word >> 30 {
            0 => Self::Node(first),
            1 => Self::Packs { first, count },
            2 => Self::Spheres { first, count },
            _ => Self::Instance(first),
        }
    }
}

/// Four triangles. A lane without one has NaN corners, which the pack's filter rejects.
#[repr(C, align(32))]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(crate) struct Pack {
    /// By corner and axis.
    pub corners: [[[f32; LANES]; 3]; 3],
    pub primitive: [u32; LANES],
}

impl Pack {
    pub const EMPTY: Self = Self { corners: [[[f32::NAN; LANES]; 3]; 3], primitive: [0; LANES] };

    /// Puts a triangle into a lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, corners: &[[f32; 3]; 3], primitive: u32) {
        for (corner, point) in self.corners.iter_mut().zip(corners) {
            for (axis, &x) in corner.iter_mut().zip(point) {
                axis[lane] = x;
            }
        }
        self.primitive[lane] = primitive;
    }

    /// The corners of the triangle in a lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> [[f32; 3]; 3] {
        self.corners.map(|corner| corner.map(|axis| axis[lane]))
    }

    /// The sheared corners.
    #[inline(always)]
    pub fn sheared(&self, ray: &LocalRay) -> [[[f32; LANES]; 3]; 3] {
        let [ox, oy, oz] = Axis::of(ray.axes, &ray.origin);
        let mut sheared = [[[0.0; LANES]; 3]; 3];
        for (corner, [x, y, depth]) in self.corners.iter().zip(&mut sheared) {
            let [px, py, pz] = Axis::of(ray.axes, corner);
            for i in 0..LANES {
                let z = pz[i] - oz;
                x[i] = (px[i] - ox) - ray.shear[0] * z;
                y[i] = (py[i] - oy) - ray.shear[1] * z;
                depth[i] = ray.shear[2] * z;
            }
        }
        sheared
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_round_trip() {
        let last = (Child::LIMIT - 1) as u32;
        for child in [
            Child::Node(0),
            Child::Node(last),
            Child::Packs { first: last, count: 8 },
            Child::Packs { first: 0, count: 1 },
            Child::Spheres { first: 5, count: 3 },
            Child::Instance(last),
        ] {
            assert_eq!(Child::of(child.word()), child);
        }
    }

    #[test]
    fn orders_are_permutations_from_far_to_near() {
        let at = |x: f32| Bounds { min: [x, 0.0, 0.0], max: [x + 1.0, 1.0, 1.0] };
        let node = Node::new(&[(at(5.0), 1), (at(1.0), 2), (at(3.0), 3)]);
        for octant in 0..8 {
            let order: Vec<u32> = (0..8).map(|i| node.order[octant] >> (3 * i) & 7).collect();
            let mut sorted = order.clone();
            sorted.sort();
            assert_eq!(sorted, (0..8).collect::<Vec<_>>());
            let real: Vec<u32> = order.into_iter().filter(|&i| i < 3).collect();
            assert_eq!(real, if octant & 1 == 0 { [0, 2, 1] } else { [1, 2, 0] });
        }
        assert_eq!((size_of::<Node>(), size_of::<Pack>()), (256, 160));
    }
}
