//! From binary trees to nodes of eight children and packs of four triangles, all levels in the same arrays.

use rayon::prelude::*;

use super::build::{self, BinaryNode};
use super::node::{Child, LANES, Node, Pack, WIDTH};
use super::pieces;
use crate::bounds::Bounds;
use crate::error::{BuildError, limited, room};
use crate::geometry::Sphere;
use crate::isa::{Isa, Kernel, run};
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

    /// The instance that all belong to, if it is one.
    #[inline(always)]
    pub fn sole(&self) -> Option<u32> {
        match self {
            Self::One(instance) => Some(*instance),
            Self::Each { .. } => None,
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
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

/// What is found on the way through a binary tree, or a part of one. Words count from the part's start.
#[derive(Default)]
struct Plan {
    drafts: Vec<Draft>,
    /// First item and number of items of each pack.
    packs: Vec<(u32, u32)>,
    spheres: Vec<SphereItem>,
    instances: Vec<u32>,
    depth: usize,
}

/// A binary tree with what it is built over.
struct Planner<'a> {
    tree: &'a [BinaryNode],
    items: &'a [Item],
    source: Source<'a>,
}

/// A part that is planned by itself: a child of a node at the top.
struct Part {
    /// The draft, and which of its children.
    parent: (usize, usize),
    /// In the binary tree.
    index: usize,
    depth: usize,
}

/// A level before it has its place in the arrays: its words count from 0.
pub(crate) struct Level<'a> {
    items: Vec<Item>,
    source: Source<'a>,
    padding: Padding,
    tree: Vec<BinaryNode>,
    /// `None` without items.
    whole: Option<Whole>,
}

impl<'a> Level<'a> {
    /// Over items, of which so many of the first, not all, are set apart. Others may be cut in pieces.
    pub fn new(
        mut items: Vec<Item>,
        source: Source<'a>,
        padding: Padding,
        apart: usize,
        isa: Isa,
    ) -> Result<Self, BuildError> {
        if items.is_empty() {
            return Ok(Self { items, source, padding, tree: Vec::new(), whole: None });
        }
        pieces::cut(&mut items, apart, source)?;
        let tree = build::build(&mut items, source, apart, isa)?;
        let whole = Planner { tree: &tree, items: &items, source }.whole(apart > 0)?;
        Ok(Self { items, source, padding, tree, whole: Some(whole) })
    }
}

impl Arrays {
    /// Puts a level behind the others. With `exact` it is given no more room than it needs: nothing is to follow.
    pub fn append(&mut self, level: Level<'_>, exact: bool, isa: Isa) -> Result<Root, BuildError> {
        let Level { items, source, padding, tree, whole } = level;
        self.owners = Owners::of_level(source, self.packs.len());
        let Some(whole) = whole else {
            return Ok(Root { word: None, bounds: Bounds::EMPTY, padding, depth: 0, others: None });
        };
        let Whole { word, others, plan } = whole.behind(&self.lengths())?;
        let Plan { drafts, packs, spheres, instances, depth } = plan;
        append(&mut self.spheres, spheres, "spheres")?;
        append(&mut self.instances, instances, "transformed instances")?;
        grow(&mut self.nodes, drafts.len(), exact, "nodes")?;
        grow(&mut self.packs, packs.len(), exact, "packs")?;
        let drafts = drafts.par_iter().with_min_len(LEAST);
        self.nodes.par_extend(drafts.map(|draft| run(isa, Written { draft, tree: &tree })));
        let written = packs.par_iter().with_min_len(LEAST);
        self.packs.par_extend(written.map(|&range| pack(items_of(&items, range), source)));
        if let Owners::Each { lanes, .. } = &mut self.owners {
            *lanes = room("owners of triangles", packs.len())?;
            lanes.par_extend(packs.par_iter().map(|&range| {
                let items = items_of(&items, range);
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

/// Moves everything to the end of an array.
fn append<T>(to: &mut Vec<T>, mut from: Vec<T>, what: &'static str) -> Result<(), BuildError> {
    let bytes = size_of_val(&from[..]) as u64;
    to.try_reserve(from.len()).map_err(|_| BuildError::Memory { what, bytes })?;
    to.append(&mut from);
    Ok(())
}

/// Makes room for more at the end of an array; if not exactly so much, then so much that the array is seldom moved.
fn grow<T>(array: &mut Vec<T>, more: usize, exact: bool, what: &'static str) -> Result<(), BuildError> {
    if array.capacity() - array.len() >= more {
        return Ok(());
    }
    let reserved = if exact { array.try_reserve_exact(more) } else { array.try_reserve(more) };
    let bytes = (more as u64).saturating_mul(size_of::<T>() as u64);
    reserved.map_err(|_| BuildError::Memory { what, bytes })?;
    ask_for_huge_pages(array);
    Ok(())
}

/// Nodes or packs that are no work for several threads.
const LEAST: usize = 64;

/// Subtrees of at most this many items are planned by one thread, if there are more in all.
const PART: usize = 1 << 14;

/// The plan of a whole tree.
struct Whole {
    word: u32,
    /// See [`Root::others`].
    others: Option<u32>,
    plan: Plan,
}

impl Whole {
    /// The same where the arrays have these lengths already.
    fn behind(mut self, lengths: &Lengths) -> Result<Self, BuildError> {
        self.plan.lengths().plus(lengths).check()?;
        self.plan.move_words(0, lengths);
        let (word, others) = (moved(self.word, lengths), self.others.map(|word| moved(word, lengths)));
        Ok(Self { word, others, ..self })
    }
}

impl Planner<'_> {
    /// Plans a tree. With `apart` the root's children are the halves of the tree.
    fn whole(&self, apart: bool) -> Result<Whole, BuildError> {
        let (mut plan, mut parts) = (Plan::default(), Vec::new());
        let mut later = (self.items.len() > PART).then_some(&mut parts);
        let word = match apart {
            true => self.node(&[1, self.tree[0].right as usize], 1, &mut plan, &mut later)?,
            false => self.child(0, 1, &mut plan, &mut later)?,
        };
        let plan_part = |part: &Part| {
            let mut plan = Plan::default();
            let word = self.child(part.index, part.depth, &mut plan, &mut None)?;
            Ok((word, plan))
        };
        let planned: Vec<Result<(u32, Plan), BuildError>> = parts.par_iter().map(plan_part).collect();
        for (part, planned) in parts.iter().zip(planned) {
            let (word, next) = planned?;
            let start = plan.lengths();
            start.plus(&next.lengths()).check()?;
            let (draft, child) = part.parent;
            plan.drafts[draft].words[child] = moved(word, &start);
            plan.add(next, &start)?;
        }
        plan.lengths().check()?;
        let others = apart.then(|| plan.drafts[0].words[1]);
        Ok(Whole { word, others, plan })
    }

    /// Plans a subtree; its child word.
    fn child(
        &self,
        index: usize,
        depth: usize,
        plan: &mut Plan,
        later: &mut Option<&mut Vec<Part>>,
    ) -> Result<u32, BuildError> {
        let binary = &self.tree[index];
        if binary.is_leaf() {
            return self.leaf(binary.first, binary.count, plan).map(Child::word);
        }
        let (children, count) = open(self.tree, index);
        self.node(&children[..count], depth, plan, later)
    }

    /// Plans a node with children of the binary tree; its word. Parts may be left for later.
    fn node(
        &self,
        children: &[usize],
        depth: usize,
        plan: &mut Plan,
        later: &mut Option<&mut Vec<Part>>,
    ) -> Result<u32, BuildError> {
        plan.depth = plan.depth.max(depth);
        let place = plan.drafts.len();
        if place == plan.drafts.capacity() {
            reserve(&mut plan.drafts, place.max(64), "nodes")?;
        }
        let mut draft = Draft { children: [0; WIDTH], words: [0; WIDTH], count: children.len() };
        draft.children.iter_mut().zip(children).for_each(|(to, &child)| *to = child as u32);
        plan.drafts.push(draft);
        for (i, &child) in children.iter().enumerate() {
            if let Some(parts) = later
                && self.tree[child].count as usize <= PART
            {
                parts.push(Part { parent: (place, i), index: child, depth: depth + 1 });
                continue;
            }
            plan.drafts[place].words[i] = self.child(child, depth + 1, plan, later)?;
        }
        Ok(Child::Node(place as u32).word())
    }

    fn leaf(&self, first_item: u32, count: u32, plan: &mut Plan) -> Result<Child, BuildError> {
        let items = items_of(self.items, (first_item, count));
        Ok(match self.source.kind(items[0].id()) {
            ItemKind::Triangle => {
                let first = plan.packs.len() as u32;
                let lanes = LANES as u32;
                let starts = (0..count).step_by(LANES);
                reserve(&mut plan.packs, starts.len(), "packs")?;
                plan.packs.extend(starts.map(|i| (first_item + i, lanes.min(count - i))));
                Child::Packs { first, count: count.div_ceil(lanes) }
            }
            ItemKind::Sphere => {
                let first = plan.spheres.len() as u32;
                reserve(&mut plan.spheres, items.len(), "spheres")?;
                for item in items {
                    let id = item.id();
                    plan.spheres.extend(self.source.sphere(id).map(|sphere| SphereItem { sphere, id }));
                }
                Child::Spheres { first, count }
            }
            ItemKind::Instance => {
                reserve(&mut plan.instances, 1, "transformed instances")?;
                plan.instances.push(items[0].id().instance);
                Child::Instance(plan.instances.len() as u32 - 1)
            }
        })
    }
}

fn reserve<T>(array: &mut Vec<T>, more: usize, what: &'static str) -> Result<(), BuildError> {
    let bytes = (more * size_of::<T>()) as u64;
    array.try_reserve(more).map_err(|_| BuildError::Memory { what, bytes })
}

impl Plan {
    fn lengths(&self) -> Lengths {
        let [nodes, packs] = [self.drafts.len(), self.packs.len()];
        Lengths { nodes, packs, spheres: self.spheres.len(), instances: self.instances.len() }
    }

    /// Adds a part that starts there.
    fn add(&mut self, part: Self, start: &Lengths) -> Result<(), BuildError> {
        let drafts = self.drafts.len();
        append(&mut self.drafts, part.drafts, "nodes")?;
        append(&mut self.packs, part.packs, "packs")?;
        append(&mut self.spheres, part.spheres, "spheres")?;
        append(&mut self.instances, part.instances, "transformed instances")?;
        self.move_words(drafts, start);
        self.depth = self.depth.max(part.depth);
        Ok(())
    }

    /// Lets the words of drafts, from one on, count from elsewhere.
    fn move_words(&mut self, first: usize, start: &Lengths) {
        if *start == Lengths::default() {
            return;
        }
        for draft in &mut self.drafts[first..] {
            let count = draft.count;
            draft.words[..count].iter_mut().for_each(|word| *word = moved(*word, start));
        }
    }
}

/// A word that counts from elsewhere.
fn moved(word: u32, start: &Lengths) -> u32 {
    match Child::of(word) {
        Child::Node(index) => Child::Node(index + start.nodes as u32),
        Child::Packs { first, count } => Child::Packs { first: first + start.packs as u32, count },
        Child::Spheres { first, count } => Child::Spheres { first: first + start.spheres as u32, count },
        Child::Instance(index) => Child::Instance(index + start.instances as u32),
    }
    .word()
}

impl Lengths {
    fn plus(&self, other: &Self) -> Self {
        Self {
            nodes: self.nodes + other.nodes,
            packs: self.packs + other.packs,
            spheres: self.spheres + other.spheres,
            instances: self.instances + other.instances,
        }
    }

    /// Whether words can tell all places.
    fn check(&self) -> Result<(), BuildError> {
        limited("nodes", self.nodes, Child::LIMIT)?;
        limited("packs", self.packs, Child::LIMIT)?;
        limited("spheres", self.spheres, Child::LIMIT)?;
        limited("transformed instances", self.instances, Child::LIMIT)?;
        Ok(())
    }
}

/// Makes a node of a draft.
struct Written<'a> {
    draft: &'a Draft,
    tree: &'a [BinaryNode],
}

impl Kernel for Written<'_> {
    type Output = Node;

    #[inline(always)]
    fn run(self) -> Node {
        let Self { draft, tree } = self;
        let mut children = [(Bounds::EMPTY, 0); WIDTH];
        for (i, child) in children.iter_mut().enumerate().take(draft.count) {
            *child = (tree[draft.children[i] as usize].bounds, draft.words[i]);
        }
        let children = &mut children[..draft.count];
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
        pack.set(lane, &corners, id.primitive);
    }
    pack
}
