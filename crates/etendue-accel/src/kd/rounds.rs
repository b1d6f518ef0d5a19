//! Many rays at once: each is in a slot with a stack of its own. A round takes rays that are at a node down in pairs, until one of the two
//! is at a leaf; gives every ray that has come to a leaf one pack of triangles; and does what is rare. Rays are kept in lists by what they
//! do next. A step down has no branches, and the two of a pair wait for each other's results in no way, so the processor works on both;
//! packs were asked for a round before.

use super::DEPTH_LIMIT;
use super::arrays::{Arrays, Other};
use super::list::List;
use super::node::{Leaf, Node};
use super::traverse::{Cell, Local, Scene};
use crate::bounds::{greatest, least};
use crate::bvh::node::Pack;
use crate::prefetch::prefetch;
use crate::ray::{PrimitiveId, Ray};
use crate::search::{Found, Search};
use crate::simd::Simd;
use crate::triangle::decide;
use std::hint::select_unpredictable;

/// Rays in flight: a power of two.
pub(super) const SLOTS: usize = 32;

/// Rays that go down together.
const TOGETHER: usize = 2;

/// Cells of a stack: a power of two.
const ROOM: usize = 128;

// The end; a cell for each node on the way down, what is left of a run of others, and the way back out of an instance; the same inside
// of it, where there are no instances; and one beyond that a step may write.
const _: () = assert!(1 + (DEPTH_LIMIT + 2) + (DEPTH_LIMIT + 1) < ROOM);

/// One ray in flight.
#[repr(align(64))]
pub(super) struct Slot {
    stack: [Cell; ROOM],
    /// In the space of what was entered.
    local: Local,
    search: Search,
    /// The cell that is visited next; it is no longer on the stack.
    here: Cell,
    top: usize,
    /// Where it is a leaf: the next pack, and how many there are.
    pack: u32,
    packs: u32,
    index: usize,
    /// The ray in the world, where `local` is inside an instance.
    outside: Local,
}

impl Slot {
    /// Without a ray.
    pub const EMPTY: Self = Self {
        stack: [Cell::kept(Arrays::END); ROOM],
        local: Local::NONE,
        search: Search::NONE,
        here: Cell::kept(Arrays::END),
        top: 0,
        pack: 0,
        packs: 0,
        index: 0,
        outside: Local::NONE,
    };

    #[inline(always)]
    fn cell(&self, place: usize) -> Cell {
        self.stack[place % ROOM]
    }

    #[inline(always)]
    fn put(&mut self, place: usize, cell: Cell) {
        self.stack[place % ROOM] = cell;
    }

    /// Takes the next cell off the stack.
    #[inline(always)]
    fn pop(&mut self) {
        self.top -= 1;
        self.here = self.cell(self.top);
    }

    /// One step down from a cell that is no leaf, without branches.
    #[inline(always)]
    fn step(&mut self, from: &mut Cell, top: &mut usize, Node { at, word }: Node) {
        let Cell { enter, exit, .. } = *from;
        let crossing = &self.local.crossings[(word & 3) as usize];
        let far_enter = greatest(at * crossing.rate - crossing.near, enter);
        let near_exit = least(at * crossing.rate - crossing.far, exit);
        let first = crossing.first;
        let near = (word >> 4) * 2 + first;
        let enters_near = (enter <= near_exit) & (word >> (2 + first) & 1 == 0);
        let enters_far = (far_enter <= exit) & (word >> (3 - first) & 1 == 0);
        let below = self.cell(top.wrapping_sub(1));
        self.put(*top, Cell { node: near ^ 1, enter: far_enter, exit });
        *top = *top + usize::from(enters_near) + usize::from(enters_far) - 1;
        let node = select_unpredictable(enters_far, near ^ 1, below.node);
        let other_enter = select_unpredictable(enters_far, far_enter, below.enter);
        let other_exit = select_unpredictable(enters_far, exit, below.exit);
        *from = Cell {
            node: select_unpredictable(enters_near, near, node),
            enter: select_unpredictable(enters_near, enter, other_enter),
            exit: select_unpredictable(enters_near, near_exit, other_exit),
        };
    }

    /// After a hit: no cell beyond it is visited; or none at all.
    #[inline(always)]
    fn shorten<const ANY: bool>(&mut self) {
        let mut kept = 1;
        if !ANY {
            let t = self.search.best.t;
            for place in 1..self.top {
                let cell = self.cell(place);
                self.put(kept, Cell { exit: least(cell.exit, t), ..cell });
                kept += usize::from(cell.enter <= t);
            }
        }
        self.top = kept;
    }
}

/// Takes several rays down step by step, until one of them is at a leaf. Gives what the nodes are that they are at then.
#[inline(always)]
fn descend<const N: usize>(slots: [&mut Slot; N], nodes: &[Node]) -> [Node; N] {
    let mut cells: [Cell; N] = [Cell::kept(0); N];
    let mut tops = [0; N];
    for i in 0..N {
        (cells[i], tops[i]) = (slots[i].here, slots[i].top);
    }
    let mut reached = [Node::default(); N];
    loop {
        let mut is_leaf = false;
        for i in 0..N {
            reached[i] = nodes[cells[i].node as usize];
            is_leaf |= reached[i].word & 3 == Node::LEAF;
        }
        if is_leaf {
            break;
        }
        for i in 0..N {
            slots[i].step(&mut cells[i], &mut tops[i], reached[i]);
        }
    }
    for i in 0..N {
        (slots[i].here, slots[i].top) = (cells[i], tops[i]);
        (slots[i].pack, slots[i].packs) = (reached[i].word >> 2, reached[i].at.to_bits());
    }
    reached
}

/// Slots by what they do next.
#[derive(Clone, Copy)]
struct Lists {
    nodes: List<SLOTS>,
    /// Packs of the next round but one: their memory takes longer than the nodes of this round.
    packs: List<SLOTS>,
    ready: List<SLOTS>,
    rest: List<SLOTS>,
}

/// A pack with triangles that may be hit.
#[derive(Clone, Copy, Default)]
struct Pending {
    slot: usize,
    pack: usize,
    candidates: u32,
}

/// Searches for a slice of rays.
pub(super) struct Rounds<'a, F> {
    scene: Scene<'a>,
    nodes: &'a [Node],
    packs: &'a [Pack],
    rays: &'a [Ray],
    /// How many rays have started.
    next: usize,
    finish: F,
    slots: &'a mut [Slot; SLOTS],
}

impl<'a, F: FnMut(usize, Found)> Rounds<'a, F> {
    /// Traces all rays; `finish` gets the index of each and what was found.
    #[inline(always)]
    pub fn run<S: Simd, const ANY: bool>(
        simd: S,
        scene: Scene<'a>,
        rays: &'a [Ray],
        slots: &'a mut [Slot; SLOTS],
        finish: F,
    ) {
        let mut lists = Lists { nodes: List::EMPTY, packs: List::EMPTY, ready: List::EMPTY, rest: List::EMPTY };
        let arrays = &scene.tree.arrays;
        let mut rounds = Self { scene, nodes: arrays.nodes(), packs: &arrays.packs, rays, next: 0, finish, slots };
        for place in 0..SLOTS {
            let starts = rounds.start(place);
            lists.nodes.add_if(place, starts);
        }
        while lists.nodes.len() + lists.packs.len() + lists.ready.len() + lists.rest.len() > 0 {
            lists = rounds.step_down(simd, lists);
            lists = rounds.test_packs::<S, ANY>(simd, lists);
            lists = rounds.step_aside::<ANY>(lists);
        }
    }

    /// Puts the next ray that may hit anything into a slot, if there is one; those before it miss.
    #[inline(always)]
    fn start(&mut self, place: usize) -> bool {
        while let Some(ray) = self.rays.get(self.next) {
            let (index, slot) = (self.next, &mut self.slots[place % SLOTS]);
            self.next += 1;
            if let Some((search, local, cell)) = self.scene.start(ray) {
                (slot.search, slot.local, slot.index, slot.top) = (search, local, index, 1);
                slot.here = cell;
                slot.put(0, Cell::kept(Arrays::END));
                return true;
            }
            (self.finish)(index, Found::MISS);
        }
        false
    }

    /// Asks for the node that a slot visits next.
    #[inline(always)]
    fn ask_for_node(&self, place: usize) {
        let slot = &self.slots[place % SLOTS];
        if let Some(node) = self.nodes.get(slot.here.node as usize) {
            prefetch(node);
        }
    }

    /// Takes the slots of a list from a place on down, and files them.
    #[inline(always)]
    fn go_down<const N: usize>(&mut self, list: &List<SLOTS>, start: usize, lists: &mut Lists) {
        let mut places = [0; N];
        for (i, place) in places.iter_mut().enumerate() {
            *place = list.get(start + i);
        }
        let Ok(slots) = self.slots.get_disjoint_mut(places) else { return };
        let reached = descend(slots, self.nodes);
        for (place, Node { at, word }) in places.into_iter().zip(reached) {
            let (is_leaf, is_packs) = (word & 3 == Node::LEAF, at.to_bits() < Node::COUNT_LIMIT);
            lists.nodes.add_if(place, !is_leaf);
            lists.packs.add_if(place, is_leaf & is_packs);
            lists.rest.add_if(place, is_leaf & !is_packs);
        }
    }

    #[inline(always)]
    fn step_down<S: Simd>(&mut self, simd: S, mut lists: Lists) -> Lists {
        let list = std::mem::replace(&mut lists.nodes, List::EMPTY);
        let even = list.len() - list.len() % TOGETHER;
        for start in (0..even).step_by(TOGETHER) {
            self.go_down::<TOGETHER>(&list, start, &mut lists);
        }
        for start in even..list.len() {
            self.go_down::<1>(&list, start, &mut lists);
        }
        for i in 0..lists.packs.len() {
            let pack = self.slots[lists.packs.get(i)].pack as usize;
            simd.prefetch_lines::<3>(self.packs.as_ptr().wrapping_add(pack).cast());
        }
        lists
    }

    #[inline(always)]
    fn test_packs<S: Simd, const ANY: bool>(&mut self, simd: S, mut lists: Lists) -> Lists {
        let list = lists.ready;
        (lists.ready, lists.packs) = (lists.packs, List::EMPTY);
        let mut pending = [Pending::default(); SLOTS];
        let mut count = 0;
        for i in 0..list.len() {
            let place = list.get(i);
            let slot = &self.slots[place % SLOTS];
            let pack = slot.pack as usize;
            let candidates = simd.candidates(&self.packs[pack], &slot.local.ray);
            pending[count % SLOTS] = Pending { slot: place, pack, candidates };
            count += usize::from(candidates != 0);
        }
        for &Pending { slot: place, pack, candidates } in &pending[..count.min(SLOTS)] {
            let slot = &mut self.slots[place % SLOTS];
            if self.scene.pack(pack, &self.packs[pack], candidates, &slot.local, &mut slot.search) {
                slot.shorten::<ANY>();
                if ANY {
                    slot.packs = 1;
                }
            }
        }
        for i in 0..list.len() {
            let place = list.get(i);
            let slot = &mut self.slots[place % SLOTS];
            slot.packs -= 1;
            slot.pack += 1;
            let is_last = slot.packs == 0;
            slot.top -= usize::from(is_last);
            slot.here = select_unpredictable(is_last, slot.cell(slot.top), slot.here);
            lists.nodes.add_if(place, is_last);
            lists.packs.add_if(place, !is_last);
            self.ask_for_node(place);
        }
        lists
    }

    /// What is no node of the tree and no pack.
    #[inline(always)]
    fn step_aside<const ANY: bool>(&mut self, mut lists: Lists) -> Lists {
        let list = std::mem::replace(&mut lists.rest, List::EMPTY);
        for i in 0..list.len() {
            let place = list.get(i);
            let slot = &mut self.slots[place % SLOTS];
            let here = slot.here;
            match self.nodes[here.node as usize].as_leaf() {
                Leaf::End => {
                    (self.finish)(slot.index, slot.search.found());
                    if !self.start(place) {
                        continue;
                    }
                }
                Leaf::Leave => {
                    slot.local = slot.outside;
                    slot.pop();
                }
                Leaf::Run(first) => slot.here.node = first,
                Leaf::Other { index, is_last } => {
                    if !is_last {
                        slot.put(slot.top, Cell { node: here.node + 1, ..here });
                        slot.top += 1;
                    }
                    self.scene.other::<ANY>(index, slot);
                }
                Leaf::Packs { .. } => {}
            }
            lists.nodes.add_if(place, true);
            self.ask_for_node(place);
        }
        lists
    }
}

impl Scene<'_> {
    /// Decides the candidates of a pack. True if anything better is hit.
    #[inline(always)]
    fn pack(&self, index: usize, pack: &Pack, candidates: u32, local: &Local, search: &mut Search) -> bool {
        search.pack((index, pack), (candidates, &decide(pack.sheared(&local.ray))), |search, lane| {
            if local.is_inside() {
                return Some(local.instance);
            }
            let owner = self.tree.arrays.owner(index, lane);
            self.is_seen(owner, search).then_some(owner)
        })
    }

    /// Tests a sphere or enters an instance.
    #[inline(always)]
    fn other<const ANY: bool>(&self, index: u32, slot: &mut Slot) {
        match self.tree.arrays.others[index as usize] {
            Other::Sphere { ref sphere, id } => {
                let inside = slot.local.is_inside();
                let instance = if inside { slot.local.instance } else { id.instance };
                let id = PrimitiveId { instance, ..id };
                if (inside || self.is_seen(instance, &slot.search)) && slot.search.sphere(&slot.local.ray, sphere, id) {
                    slot.shorten::<ANY>();
                }
                slot.pop();
            }
            Other::Instance { instance, geometry } => {
                let entered = self.enter(instance, geometry, &slot.local.ray, &slot.search);
                let Some((inside, cell)) = entered else { return slot.pop() };
                slot.outside = std::mem::replace(&mut slot.local, inside);
                slot.put(slot.top, Cell::kept(Arrays::LEAVE));
                slot.top += 1;
                slot.here = cell;
            }
        }
    }
}
