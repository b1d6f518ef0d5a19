//! From built levels to the arrays that rays go through, all levels in the same.

use std::collections::VecDeque;

use rayon::prelude::*;

use super::build::{Draft, Subtree, build};
use super::node::{LINE, Leaf, Line, Node};
use crate::accelerator::KdTreeSplit;
use crate::bounds::Bounds;
use crate::bvh::node::{LANES, Pack};
use crate::error::{BuildError, limited, room};
use crate::geometry::Sphere;
use crate::items::{self, Item, ItemKind};
use crate::memory::ask_for_huge_pages;
use crate::padding::Padding;
use crate::ray::PrimitiveId;
use crate::source::Source;

/// Packs that a thread fills in one go, at least.
const LEAST: usize = 1 << 10;

/// What is no triangle.
#[derive(Clone, Copy, Debug)]
pub(super) enum Other {
    /// In a bottom level the id's instance is 0.
    Sphere {
        sphere: Sphere,
        id: PrimitiveId,
    },
    Instance {
        instance: u32,
        geometry: u32,
    },
}

/// Where one level starts: the top, or a geometry that instances share.
#[derive(Clone, Copy, Debug)]
pub(super) struct Root {
    /// `None` if there is nothing.
    pub node: Option<u32>,
    pub bounds: Bounds,
    pub padding: Padding,
    /// Nodes on the longest way from here.
    pub depth: usize,
}

/// A level before it has its place in the arrays.
pub(super) struct Level<'a> {
    items: Vec<Item>,
    source: Source<'a>,
    bounds: Bounds,
    padding: Padding,
    tree: Subtree,
}

impl<'a> Level<'a> {
    pub fn new(items: Vec<Item>, source: Source<'a>, padding: Padding, split: KdTreeSplit) -> Result<Self, BuildError> {
        let bounds = items::bounds_of(&items);
        let tree = build(&items, source, &bounds, split)?;
        Ok(Self { items, source, bounds, padding, tree })
    }
}

/// The arrays of all levels.
#[derive(Debug, Default)]
pub(super) struct Arrays {
    lines: Vec<Line>,
    pub packs: Vec<Pack>,
    pub others: Vec<Other>,
    /// The instances that triangles of the level that was added last belong to, if there is more than one: by pack, less those that come
    /// before, and lane.
    owners: Vec<[u32; LANES]>,
    owners_start: usize,
}

/// The lengths of arrays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lengths {
    lines: usize,
    packs: usize,
    others: usize,
}

impl Arrays {
    /// The node of the bottom of every stack.
    pub const END: u32 = 0;
    /// The node below the stack of an instance that was entered.
    pub const LEAVE: u32 = 1;

    /// Without levels.
    pub fn new() -> Self {
        let mut line = Line::default();
        (line.0[Self::END as usize], line.0[Self::LEAVE as usize]) = (Node::leaf(Leaf::End), Node::leaf(Leaf::Leave));
        Self { lines: vec![line], ..Self::default() }
    }

    #[inline(always)]
    pub fn nodes(&self) -> &[Node] {
        bytemuck::cast_slice(&self.lines)
    }

    /// The instance of a triangle of the top.
    #[inline(always)]
    pub fn owner(&self, pack: usize, lane: usize) -> u32 {
        if self.owners.is_empty() { 0 } else { self.owners[pack - self.owners_start][lane] }
    }

    pub fn lengths(&self) -> Lengths {
        Lengths { lines: self.lines.len(), packs: self.packs.len(), others: self.others.len() }
    }

    /// Removes what was added since.
    pub fn truncate(&mut self, to: &Lengths) {
        self.lines.truncate(to.lines);
        self.packs.truncate(to.packs);
        self.others.truncate(to.others);
    }

    pub fn bytes(&self) -> usize {
        let [lines, packs] = [size_of_val(&self.lines[..]), size_of_val(&self.packs[..])];
        lines + packs + size_of_val(&self.others[..]) + size_of_val(&self.owners[..])
    }

    /// Appends a level; the top comes last.
    pub fn append(&mut self, level: Level<'_>) -> Result<Root, BuildError> {
        let Level { items, source, bounds, padding, tree } = level;
        let Subtree { nodes, mut references, .. } = tree;
        if references.is_empty() {
            (self.owners, self.owners_start) = (Vec::new(), self.packs.len());
            return Ok(Root { node: None, bounds, padding, depth: 0 });
        }
        let mut writer = Writer { arrays: self, items: &items, source, packs: Vec::new(), pair: 0, left: 0 };
        let (node, depth) = writer.tree(&nodes, &mut references)?;
        let packs = writer.packs;
        self.fill(&packs, &items, &references, source)?;
        Ok(Root { node: Some(node), bounds, padding, depth })
    }

    /// Appends packs of ranges of references.
    fn fill(
        &mut self,
        packs: &[(u32, u32)],
        items: &[Item],
        references: &[u32],
        source: Source<'_>,
    ) -> Result<(), BuildError> {
        (self.owners, self.owners_start) = (Vec::new(), self.packs.len());
        grow(&mut self.packs, packs.len(), "packs")?;
        let of = |&(first, count): &(u32, u32)| {
            references[first as usize..(first + count) as usize].iter().map(|&item| items[item as usize].id())
        };
        self.packs.par_extend(packs.par_iter().with_min_len(LEAST).map(|range| {
            let mut pack = Pack::EMPTY;
            for (lane, id) in of(range).enumerate() {
                if let Some(corners) = source.triangle(id) {
                    pack.set(lane, &corners, id.primitive);
                }
            }
            pack
        }));
        if let Source::Top(world) = source
            && world.instances.len() > 1
        {
            self.owners = room("owners of triangles", packs.len())?;
            self.owners.par_extend(packs.par_iter().with_min_len(LEAST).map(|range| {
                let mut owners = [0; LANES];
                of(range).zip(&mut owners).for_each(|(id, owner)| *owner = id.instance);
                owners
            }));
        }
        Ok(())
    }
}

/// Makes room, twice as much as there was or as much as is needed.
fn grow<T>(vector: &mut Vec<T>, more: usize, what: &'static str) -> Result<(), BuildError> {
    let count = vector.len().saturating_add(more);
    limited(what, count, Node::INDEX_LIMIT)?;
    let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
    vector.try_reserve(more).map_err(|_| BuildError::Memory { what, bytes })?;
    ask_for_huge_pages(vector);
    Ok(())
}

/// Writes the nodes of a level.
struct Writer<'a> {
    arrays: &'a mut Arrays,
    items: &'a [Item],
    source: Source<'a>,
    /// First reference and number of references of each pack.
    packs: Vec<(u32, u32)>,
    /// The next pair, and how many are left in its line.
    pair: usize,
    left: usize,
}

/// A draft, the node that it becomes, and how deep that is.
type Place = (u32, usize, usize);

impl Writer<'_> {
    /// The root and the depth. Nodes that follow each other are in one line as far as that goes: a pair, the pairs below, and so on.
    fn tree(&mut self, drafts: &[Draft], references: &mut [u32]) -> Result<(u32, usize), BuildError> {
        grow(&mut self.arrays.lines, drafts.len().div_ceil(LINE) + 1, "nodes")?;
        let root = 2 * self.take_pair()?;
        let mut pending: Vec<Place> = vec![(0, root, 1)];
        let mut near: VecDeque<Place> = VecDeque::new();
        let mut deepest = 1;
        while let Some(place) = pending.pop() {
            near.push_back(place);
            while let Some((index, node, depth)) = near.pop_front() {
                deepest = deepest.max(depth);
                match drafts[index as usize] {
                    Draft::Leaf { first, count } => {
                        let range = first as usize..(first + count) as usize;
                        let leaf = self.leaf(first, &mut references[range])?;
                        self.put(node, leaf);
                    }
                    Draft::Inner { axis, at, upper } => {
                        let (pair, lower) = (self.take_pair()?, index + 1);
                        let is_empty = |child: u32| matches!(drafts[child as usize], Draft::Leaf { count: 0, .. });
                        self.put(node, Node::inner(axis, at, pair as u32, [is_empty(lower), is_empty(upper)]));
                        near.push_back((lower, 2 * pair, depth + 1));
                        near.push_back((upper, 2 * pair + 1, depth + 1));
                        if self.left == 0 {
                            pending.extend(near.drain(..).rev());
                        }
                    }
                }
            }
        }
        Ok((root as u32, deepest))
    }

    fn put(&mut self, node: usize, what: Node) {
        self.arrays.lines[node / LINE].0[node % LINE] = what;
    }

    /// A pair of nodes, if possible of the line that was begun.
    fn take_pair(&mut self) -> Result<usize, BuildError> {
        if self.left == 0 {
            let lines = self.arrays.lines.len();
            limited("nodes", LINE / 2 * (lines + 1), Node::PAIR_LIMIT)?;
            let bytes = (lines * size_of::<Line>()) as u64;
            self.arrays.lines.try_reserve(1).map_err(|_| BuildError::Memory { what: "nodes", bytes })?;
            self.arrays.lines.push(Line::default());
            (self.pair, self.left) = (LINE / 2 * lines, LINE / 2);
        }
        self.left -= 1;
        self.pair += 1;
        Ok(self.pair - 1)
    }

    /// A leaf of references from a place on, which it sorts by kind.
    fn leaf(&mut self, first: u32, references: &mut [u32]) -> Result<Node, BuildError> {
        let kind = |item: u32| self.source.kind(self.items[item as usize].id());
        if self.source.sole_kind() != Some(ItemKind::Triangle) {
            references.sort_by_key(|&item| kind(item));
        }
        let triangles = references.partition_point(|&item| kind(item) == ItemKind::Triangle);
        let (pack, count) = (self.arrays.packs.len() + self.packs.len(), triangles.div_ceil(LANES));
        limited("packs", pack.saturating_add(count), Node::INDEX_LIMIT)?;
        let bytes = (self.packs.len().saturating_add(count) * size_of::<(u32, u32)>()) as u64;
        self.packs.try_reserve(count).map_err(|_| BuildError::Memory { what: "packs", bytes })?;
        let packs = (0..triangles).step_by(LANES).map(|start| {
            let count = (triangles - start).min(LANES);
            (first + start as u32, count as u32)
        });
        self.packs.extend(packs);
        let packs = Leaf::Packs { first: pack as u32, count: count as u32 };
        if triangles == references.len() {
            return Ok(Node::leaf(packs));
        }
        self.run(&references[triangles..], (count > 0).then_some(packs))
    }

    /// A leaf of others, and of packs behind them.
    fn run(&mut self, others: &[u32], packs: Option<Leaf>) -> Result<Node, BuildError> {
        let mut nodes: Vec<Node> = room("others of a leaf", others.len() + 1)?;
        let bytes = size_of_val(others) as u64;
        let reserved = self.arrays.others.try_reserve(others.len());
        reserved.map_err(|_| BuildError::Memory { what: "references to spheres and instances", bytes })?;
        for (place, &item) in others.iter().enumerate() {
            let id = self.items[item as usize].id();
            let other = match self.source.sphere(id) {
                Some(sphere) if self.source.kind(id) == ItemKind::Sphere => Other::Sphere { sphere, id },
                _ => Other::Instance { instance: id.instance, geometry: self.source.geometry_index(id) },
            };
            let index =
                limited("references to spheres and instances", self.arrays.others.len(), Node::INDEX_LIMIT - 1)?;
            self.arrays.others.push(other);
            let is_last = place + 1 == others.len() && packs.is_none();
            nodes.push(Node::leaf(Leaf::Other { index, is_last }));
        }
        nodes.extend(packs.map(Node::leaf));
        if let [node] = nodes[..] {
            return Ok(node);
        }
        // Lines of their own, behind which the one that was begun goes on.
        let first = LINE * self.arrays.lines.len();
        limited("nodes", (first + nodes.len()).div_ceil(LINE) * (LINE / 2), Node::PAIR_LIMIT)?;
        let lines = nodes.len().div_ceil(LINE);
        let bytes = (lines * size_of::<Line>()) as u64;
        self.arrays.lines.try_reserve(lines).map_err(|_| BuildError::Memory { what: "nodes", bytes })?;
        for part in nodes.chunks(LINE) {
            let mut line = Line::default();
            line.0[..part.len()].copy_from_slice(part);
            self.arrays.lines.push(line);
        }
        Ok(Node::leaf(Leaf::Run(first as u32)))
    }
}
