//! From the binary tree to nodes of eight children and packs of four triangles.

use super::build::{self, BinaryNode};
use super::node::{Child, LANES, Node, Pack, WIDTH};
use crate::bounds::Bounds;
use crate::error::{BuildError, limited, room};
use crate::geometry::Sphere;
use crate::items::{Item, ItemKind};
use crate::padding::Padding;
use crate::ray::PrimitiveId;
use crate::source::Source;

/// A sphere in a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SphereItem {
    pub sphere: Sphere,
    /// In a bottom level the instance is 0.
    pub id: PrimitiveId,
    pub mask: u32,
}

/// A transformed instance in a leaf.
#[derive(Clone, Copy, Debug)]
pub(crate) struct InstanceItem {
    pub instance: u32,
    pub geometry: u32,
    pub mask: u32,
}

/// One level: the top, or a geometry that instances share.
#[derive(Debug)]
pub(crate) struct Level {
    /// Where to start; `None` if there is nothing.
    pub root: Option<u32>,
    pub bounds: Bounds,
    pub padding: Padding,
    pub nodes: Vec<Node>,
    pub packs: Vec<Pack>,
    pub spheres: Vec<SphereItem>,
    pub instances: Vec<InstanceItem>,
    /// Nodes on the longest way from the root.
    pub depth: usize,
}

impl Level {
    /// Builds a level over items, which it reorders.
    pub fn build(items: &mut [Item], source: Source<'_>, padding: Padding) -> Result<Self, BuildError> {
        let mut level = Self {
            root: None,
            bounds: Bounds::EMPTY,
            padding,
            nodes: Vec::new(),
            packs: Vec::new(),
            spheres: Vec::new(),
            instances: Vec::new(),
            depth: 0,
        };
        if items.is_empty() {
            return Ok(level);
        }
        let tree = build::build(items)?;
        level.bounds = tree[0].bounds;
        level.reserve(&tree, items)?;
        level.root = Some(level.emit(&tree, 0, items, source, 1)?);
        Ok(level)
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.nodes[..])
            + size_of_val(&self.packs[..])
            + size_of_val(&self.spheres[..])
            + size_of_val(&self.instances[..])
    }

    fn reserve(&mut self, tree: &[BinaryNode], items: &[Item]) -> Result<(), BuildError> {
        let (mut leaves, mut packs, mut spheres, mut instances) = (0, 0, 0, 0);
        let mut pending = vec![0_usize];
        while let Some(index) = pending.pop() {
            let node = &tree[index];
            if !node.is_leaf() {
                pending.extend([index + 1, index + node.right as usize]);
                continue;
            }
            leaves += 1;
            match items[node.first as usize].kind {
                ItemKind::Triangle => packs += (node.count as usize).div_ceil(LANES),
                ItemKind::Sphere => spheres += node.count as usize,
                ItemKind::Instance => instances += node.count as usize,
            }
        }
        for (what, count) in [("packs", packs), ("spheres", spheres), ("transformed instances", instances)] {
            limited(what, count, Child::LIMIT)?;
        }
        limited("nodes", leaves, Child::LIMIT)?;
        self.packs = room("packs", packs)?;
        self.spheres = room("spheres", spheres)?;
        self.instances = room("instances", instances)?;
        Ok(())
    }

    /// Writes a subtree; its child word.
    fn emit(
        &mut self,
        tree: &[BinaryNode],
        index: usize,
        items: &[Item],
        source: Source<'_>,
        depth: usize,
    ) -> Result<u32, BuildError> {
        let binary = &tree[index];
        if binary.is_leaf() {
            let range = binary.first as usize..(binary.first + binary.count) as usize;
            return Ok(self.emit_leaf(&items[range], source).word());
        }
        self.depth = self.depth.max(depth);
        let (children, count) = open(tree, index);
        let place = self.nodes.len();
        if place == self.nodes.capacity() {
            let more = place.max(64);
            let bytes = (more * size_of::<Node>()) as u64;
            self.nodes.try_reserve_exact(more).map_err(|_| BuildError::Memory { what: "nodes", bytes })?;
        }
        self.nodes.push(Node::new(&[]));
        let mut words = [(Bounds::EMPTY, 0); WIDTH];
        for (word, &child) in words.iter_mut().zip(&children[..count]) {
            *word = (tree[child].bounds, self.emit(tree, child, items, source, depth + 1)?);
        }
        self.nodes[place] = Node::new(&words[..count]);
        Ok(Child::Node(place as u32).word())
    }

    fn emit_leaf(&mut self, items: &[Item], source: Source<'_>) -> Child {
        match items[0].kind {
            ItemKind::Triangle => {
                let first = self.packs.len() as u32;
                self.packs.extend(items.chunks(LANES).map(|lanes| pack(lanes, source)));
                Child::Packs { first, count: items.len().div_ceil(LANES) as u32 }
            }
            ItemKind::Sphere => {
                let first = self.spheres.len() as u32;
                self.spheres.extend(items.iter().filter_map(|item| {
                    let sphere = source.sphere(item.id)?;
                    Some(SphereItem { sphere, id: item.id, mask: source.mask(item.id) })
                }));
                Child::Spheres { first, count: items.len() as u32 }
            }
            ItemKind::Instance => {
                let id = items[0].id;
                let geometry = source.geometry_index(id);
                self.instances.push(InstanceItem { instance: id.instance, geometry, mask: source.mask(id) });
                Child::Instance(self.instances.len() as u32 - 1)
            }
        }
    }
}

/// Up to eight descendants that together hold the subtree: the largest is opened first.
fn open(tree: &[BinaryNode], index: usize) -> ([usize; WIDTH], usize) {
    let mut children = [0; WIDTH];
    children[0] = index;
    let mut count = 1;
    while count < WIDTH {
        let inner = (0..count).filter(|&i| !tree[children[i]].is_leaf());
        let area = |i: usize| tree[children[i]].bounds.half_area();
        let Some(largest) = inner.max_by(|&a, &b| area(a).total_cmp(&area(b)).then(b.cmp(&a))) else { break };
        let opened = children[largest];
        children[largest] = opened + 1;
        children[count] = opened + tree[opened].right as usize;
        count += 1;
    }
    (children, count)
}

fn pack(items: &[Item], source: Source<'_>) -> Pack {
    let mut pack = Pack::EMPTY;
    for (lane, item) in items.iter().enumerate() {
        let Some(corners) = source.triangle(item.id) else { continue };
        for (corner, point) in pack.corners.iter_mut().zip(corners) {
            for (axis, x) in corner.iter_mut().zip(point) {
                axis[lane] = x;
            }
        }
        pack.instance[lane] = item.id.instance;
        pack.primitive[lane] = item.id.primitive;
        pack.mask[lane] = source.mask(item.id);
    }
    pack
}
