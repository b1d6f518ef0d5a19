//! From binary trees to nodes of eight children and packs of four triangles, all levels in the same arrays.

use rayon::prelude::*;

use super::build::{self, BinaryNode};
use super::node::{Child, LANES, Node, Pack, WIDTH};
use crate::bounds::Bounds;
use crate::error::{BuildError, limited, room};
use crate::geometry::Sphere;
use crate::isa::Isa;
use crate::items::{Item, ItemKind};
use crate::memory::ask_for_huge_pages;
use crate::padding::Padding;
use crate::ray::PrimitiveId;
use crate::source::Source;

/// A sphere in a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphereItem {
    pub sphere: Sphere,
    /// In a bottom level the instance is 0.
    pub id: PrimitiveId,
}

/// Where one level starts: the top, or a geometry that instances share.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Root {
    /// Child word; `None` if there is nothing.
    pub word: Option<u32>,
    pub bounds: Bounds,
    pub padding: Padding,
    /// Nodes on the longest way from here.
    pub depth: usize,
    /// The child word of everything but what was set apart, if anything was. Then the root's node has two children, and this
    /// is the second.
    pub others: Option<u32>,
}

/// Which instance the triangles of a level's packs belong to.
#[derive(Debug)]
pub(crate) enum Owners {
    /// All to one.
    One(u32),
    /// By pack, less the packs of other levels that come before, and lane.
    Each { start: usize, lanes: Vec<[u32; LANES]> },
}

impl Default for Owners {
    fn default() -> Self {
        Self::One(0)
    }
}

impl Owners {
    fn of_level(source: Source<'_>, start: usize) -> Self {
        match source {
            Source::Top(world) if world.instances.len() != 1 => Self::Each { start, lanes: Vec::new() },
            _ => Self::One(0),
        }
    }

    fn bytes(&self) -> usize {
        match self {
            Self::One(_) => 0,
            Self::Each { lanes, .. } => size_of_val(&lanes[..]),
        }
    }

    #[inline(always)]
    pub fn of(&self, pack: usize, lane: usize) -> u32 {
        match self {
            Self::One(instance) => *instance,
            Self::Each { start, lanes } => lanes[pack - start][lane],
        }
    }
}

/// The arrays of all levels.
#[derive(Debug, Default)]
pub(crate) struct Arrays {
    pub nodes: Vec<Node>,
    pub packs: Vec<Pack>,
    pub spheres: Vec<SphereItem>,
    /// Transformed instances.
    pub instances: Vec<u32>,
    /// Of the level that was added last: the top.
    pub owners: Owners,
}

/// The lengths of arrays.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Lengths {
    pub nodes: usize,
    pub packs: usize,
    pub spheres: usize,
    pub instances: usize,
}

/// A node of the wide tree before it is written.
struct Draft {
    /// Indices into the binary tree.
    children: [u32; WIDTH],
    words: [u32; WIDTH],
    count: usize,
}

/// What is found on the way through a binary tree.
struct Plan<'a> {
    tree: &'a [BinaryNode],
    items: &'a [Item],
    source: Source<'a>,
    arrays: &'a mut Arrays,
    drafts: Vec<Draft>,
    /// First item and number of items of each pack.
    packs: Vec<(u32, u32)>,
    depth: usize,
}

impl Arrays {
    /// Adds a level over items, which it reorders; so many of the first, not all, are set apart.
    pub fn add(
        &mut self,
        items: &mut [Item],
        (source, padding): (Source<'_>, Padding),
        apart: usize,
        isa: Isa,
    ) -> Result<Root, BuildError> {
        self.owners = Owners::of_level(source, self.packs.len());
        if items.is_empty() {
            return Ok(Root { word: None, bounds: Bounds::EMPTY, padding, depth: 0, others: None });
        }
        let tree = build::build(items, source, apart, isa)?;
        let mut plan =
            Plan { tree: &tree, items, source, arrays: self, drafts: Vec::new(), packs: Vec::new(), depth: 0 };
        let (word, others) = if apart == 0 { (plan.child(0, 1)?, None) } else { plan.halves()? };
        let Plan { drafts, packs, depth, .. } = plan;
        limited("nodes", self.nodes.len() + drafts.len(), Child::LIMIT)?;
        limited("packs", self.packs.len() + packs.len(), Child::LIMIT)?;
        let bytes = |count: usize, size: usize| (count as u64).saturating_mul(size as u64);
        self.nodes
            .try_reserve_exact(drafts.len())
            .map_err(|_| BuildError::Memory { what: "nodes", bytes: bytes(drafts.len(), size_of::<Node>()) })?;
        self.packs
            .try_reserve_exact(packs.len())
            .map_err(|_| BuildError::Memory { what: "packs", bytes: bytes(packs.len(), size_of::<Pack>()) })?;
        ask_for_huge_pages(&mut self.nodes);
        ask_for_huge_pages(&mut self.packs);
        self.nodes.par_extend(drafts.par_iter().map(|draft| draft.node(&tree)));
        let items = &*items;
        self.packs.par_extend(packs.par_iter().map(|&range| pack(items_of(items, range), source)));
        if let Owners::Each { lanes, .. } = &mut self.owners {
            *lanes = room("owners of triangles", packs.len())?;
            lanes.par_extend(packs.par_iter().map(|&range| {
                let items = items_of(items, range);
                std::array::from_fn(|lane| items.get(lane).map_or(0, |item| item.id().instance))
            }));
        }
        Ok(Root { word: Some(word), bounds: tree[0].bounds, padding, depth, others })
    }

    /// What there is so far.
    pub fn lengths(&self) -> Lengths {
        let [nodes, packs] = [self.nodes.len(), self.packs.len()];
        Lengths { nodes, packs, spheres: self.spheres.len(), instances: self.instances.len() }
    }

    /// Removes what was added since.
    pub fn truncate(&mut self, to: &Lengths) {
        self.nodes.truncate(to.nodes);
        self.packs.truncate(to.packs);
        self.spheres.truncate(to.spheres);
        self.instances.truncate(to.instances);
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.packs[..])
            + size_of_val(&self.spheres[..])
            + size_of_val(&self.instances[..])
            + self.owners.bytes()
    }
}

fn items_of(items: &[Item], (first, count): (u32, u32)) -> &[Item] {
    &items[first as usize..(first + count) as usize]
}

impl Plan<'_> {
    /// Plans a subtree; its child word.
    fn child(&mut self, index: usize, depth: usize) -> Result<u32, BuildError> {
        let binary = &self.tree[index];
        if binary.is_leaf() {
            return self.leaf(binary.first, binary.count).map(Child::word);
        }
        let (children, count) = open(self.tree, index);
        let (word, _) = self.node(&children[..count], depth)?;
        Ok(word)
    }

    /// Plans a root whose children are the halves of the binary tree: its word and that of the second.
    fn halves(&mut self) -> Result<(u32, Option<u32>), BuildError> {
        let (word, place) = self.node(&[1, self.tree[0].right as usize], 1)?;
        Ok((word, Some(self.drafts[place].words[1])))
    }

    /// Plans a node with children of the binary tree; its word and its draft's place.
    fn node(&mut self, children: &[usize], depth: usize) -> Result<(u32, usize), BuildError> {
        self.depth = self.depth.max(depth);
        let place = self.drafts.len();
        if place == self.drafts.capacity() {
            let more = place.max(64);
            let bytes = (more * size_of::<Draft>()) as u64;
            self.drafts.try_reserve_exact(more).map_err(|_| BuildError::Memory { what: "nodes", bytes })?;
        }
        let mut draft = Draft { children: [0; WIDTH], words: [0; WIDTH], count: children.len() };
        draft.children.iter_mut().zip(children).for_each(|(to, &child)| *to = child as u32);
        self.drafts.push(draft);
        for (i, &child) in children.iter().enumerate() {
            self.drafts[place].words[i] = self.child(child, depth + 1)?;
        }
        Ok((Child::Node((self.arrays.nodes.len() + place) as u32).word(), place))
    }

    fn leaf(&mut self, first_item: u32, count: u32) -> Result<Child, BuildError> {
        let items = items_of(self.items, (first_item, count));
        let memory = |what, count: usize| move |_| BuildError::Memory { what, bytes: count as u64 };
        Ok(match self.source.kind(items[0].id()) {
            ItemKind::Triangle => {
                let first = (self.arrays.packs.len() + self.packs.len()) as u32;
                let lanes = LANES as u32;
                let starts = (0..count).step_by(LANES);
                self.packs.try_reserve(starts.len()).map_err(memory("packs", 8 * starts.len()))?;
                self.packs.extend(starts.map(|i| (first_item + i, lanes.min(count - i))));
                Child::Packs { first, count: count.div_ceil(lanes) }
            }
            ItemKind::Sphere => {
                let spheres = &mut self.arrays.spheres;
                let first = limited("spheres", spheres.len() + items.len(), Child::LIMIT)? - items.len() as u32;
                let bytes = size_of_val(items);
                spheres.try_reserve(items.len()).map_err(memory("spheres", bytes))?;
                for item in items {
                    let id = item.id();
                    spheres.extend(self.source.sphere(id).map(|sphere| SphereItem { sphere, id }));
                }
                Child::Spheres { first, count }
            }
            ItemKind::Instance => {
                let instances = &mut self.arrays.instances;
                let place = limited("transformed instances", instances.len() + 1, Child::LIMIT)? - 1;
                instances.try_reserve(1).map_err(memory("transformed instances", 4))?;
                instances.push(items[0].id().instance);
                Child::Instance(place)
            }
        })
    }
}

impl Draft {
    fn node(&self, tree: &[BinaryNode]) -> Node {
        let mut children = [(Bounds::EMPTY, 0); WIDTH];
        for (i, child) in children.iter_mut().enumerate().take(self.count) {
            *child = (tree[self.children[i] as usize].bounds, self.words[i]);
        }
        let children = &mut children[..self.count];
        children.sort_by(|a, b| a.0.half_area().total_cmp(&b.0.half_area()));
        Node::new(children)
    }
}

/// The descendants, up to eight, that are the cheapest children of a wide node in place of this one.
fn open(tree: &[BinaryNode], index: usize) -> ([usize; WIDTH], usize) {
    let (mut children, mut count) = ([0; WIDTH], 0);
    let mut pending = [(0, 0); WIDTH];
    let mut waiting = 0;
    divide(tree, index, WIDTH, &mut pending, &mut waiting);
    while waiting > 0 {
        waiting -= 1;
        let (child, mut most) = pending[waiting];
        let costs = &tree[child].costs;
        while most > 1 && costs[most - 2] == costs[most - 1] {
            most -= 1;
        }
        if most == 1 || tree[child].is_leaf() {
            children[count] = child;
            count += 1;
        } else {
            divide(tree, child, most, &mut pending, &mut waiting);
        }
    }
    (children, count)
}

/// Puts the halves of an inner node with their shares of so many children on the list.
fn divide(
    tree: &[BinaryNode],
    index: usize,
    children: usize,
    pending: &mut [(usize, usize); WIDTH],
    waiting: &mut usize,
) {
    let (left, right) = (index + 1, index + tree[index].right as usize);
    let (share, _) = build::best_shares(&tree[left].costs, &tree[right].costs, children);
    for entry in [(right, children - share), (left, share)] {
        pending[*waiting] = entry;
        *waiting += 1;
    }
}

fn pack(items: &[Item], source: Source<'_>) -> Pack {
    let mut pack = Pack::EMPTY;
    for (lane, item) in items.iter().enumerate() {
        let id = item.id();
        let Some(corners) = source.triangle(id) else { continue };
        for (corner, point) in pack.corners.iter_mut().zip(corners) {
            for (axis, x) in corner.iter_mut().zip(point) {
                axis[lane] = x;
            }
        }
        pack.primitive[lane] = id.primitive;
    }
    pack
}
