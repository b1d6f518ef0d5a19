//! Many rays at once: each is in a slot with a stack of its own. A round gives every ray whose next word is a node one node
//! step, then every ray that has come to a leaf one pack of triangles, then does what is rare. Rays are kept in lists by what
//! they do next, which are filled without branches: the loops run over independent rays and mispredict nothing but their
//! ends, so that the processor works on several rays at once; and what a step needs was asked for a round before. Boxes are
//! tested in one loop and stacks popped in the next: so no iteration is longer than what a processor keeps in flight.

use super::node::Child;
use super::packets::Rest;
use super::ready::Queue;
use super::traverse::{END, LEAVE, Local, NO_INSTANCE, Open, Places, Scene};
use crate::local_ray::LocalRay;
use crate::padding::SlabRay;
use crate::ray::Ray;
use crate::search::{Found, Search};
use crate::simd::Simd;

/// Rays in flight: a power of two.
pub(super) const SLOTS: usize = 32;

/// A slot and the word that it visits next.
#[derive(Clone, Copy, Default)]
struct Visit {
    word: u32,
    slot: u32,
}

impl Visit {
    #[inline(always)]
    fn slot(self) -> usize {
        self.slot as usize % SLOTS
    }
}

/// The kinds of words, see [`Child::word`]: the lists of what is visited next.
const KINDS: usize = 4;
const NODES: usize = 0;
const PACKS: usize = 1;
const SPHERES: usize = 2;
/// Instances, and the words that are none.
const OTHERS: usize = 3;

/// Visits by kind, one list after the other.
struct Lists {
    visits: [Visit; KINDS * SLOTS],
    ends: [usize; KINDS],
}

impl Lists {
    const EMPTY: Self =
        Self { visits: [Visit { word: 0, slot: 0 }; KINDS * SLOTS], ends: [0, SLOTS, 2 * SLOTS, 3 * SLOTS] };

    /// Adds a slot where it belongs. A list may be read on while it is filled again from its start, by no more than was read.
    #[inline(always)]
    fn add(&mut self, slot: usize, word: u32) {
        let end = &mut self.ends[(word >> 30) as usize % KINDS];
        self.visits[*end % (KINDS * SLOTS)] = Visit { word, slot: slot as u32 };
        *end += 1;
    }

    #[inline(always)]
    fn visit(&self, kind: usize, place: usize) -> Visit {
        self.visits[(kind * SLOTS + place) % (KINDS * SLOTS)]
    }

    /// How many visits of a kind are listed, and begins it anew.
    #[inline(always)]
    fn restart(&mut self, kind: usize) -> usize {
        std::mem::replace(&mut self.ends[kind], kind * SLOTS) - kind * SLOTS
    }

    /// Those of packs.
    #[inline(always)]
    fn take_packs(&mut self) -> ([Visit; SLOTS], usize) {
        (std::array::from_fn(|i| self.visit(PACKS, i)), self.restart(PACKS).min(SLOTS))
    }

    #[inline(always)]
    fn is_empty(&self) -> bool {
        self.ends.iter().sum::<usize>() == 6 * SLOTS
    }
}

/// One ray in flight: first what a node step needs, in one cache line.
#[derive(Clone, Copy)]
#[repr(C, align(64))]
struct Slot {
    slab: SlabRay,
    /// That of the search.
    range: (f32, f32),
    /// Where the stack ends: the next word is the last.
    top: usize,
    /// Where it begins.
    bottom: usize,
    ray: LocalRay,
    /// The instance that was entered, or none.
    instance: u32,
    index: u32,
    search: Search,
    /// The ray in the world, where it is inside an instance.
    outside: Local,
}

impl Slot {
    /// Without a ray.
    fn empty(bottom: usize) -> Self {
        let Local { ray, slab, instance } = Local::NONE;
        let (range, search) = ((0.0, 0.0), Search::NONE);
        Self { slab, range, top: bottom, bottom, ray, instance, index: 0, search, outside: Local::NONE }
    }

    /// The word that is visited next, which is taken off the stack.
    #[inline(always)]
    fn pop(&mut self, stacks: &Open<'_>) -> u32 {
        self.top -= 1;
        stacks.word(self.top)
    }

    /// After a hit: nothing beyond it is visited; or nothing at all.
    #[inline(always)]
    fn shorten<S: Simd, const ANY: bool>(&mut self, simd: S, stacks: &mut Open<'_>) {
        self.range = self.search.range();
        self.top = if ANY { self.bottom + 1 } else { stacks.cull(simd, self.bottom, self.top, self.search.best.t) };
    }

    fn local(&self) -> Local {
        Local { ray: self.ray, slab: self.slab, instance: self.instance }
    }

    fn set_local(&mut self, local: Local) {
        Local { ray: self.ray, slab: self.slab, instance: self.instance } = local;
    }
}

/// A pack with triangles that may be hit.
#[derive(Clone, Copy, Default)]
struct Pending {
    visit: Visit,
    candidates: u32,
}

/// Puts the next ray that can hit anything into a slot, if there is one, and gives its first word; those before it miss.
#[inline(always)]
fn start(
    queue: &mut Queue<'_>,
    (rest, root): (&Rest, Option<u32>),
    slot: &mut Slot,
    stacks: &mut Open<'_>,
    finish: &mut impl FnMut(usize, Found),
) -> Option<u32> {
    while let Some(next) = queue.next() {
        let leaver = rest.leaver(next.number);
        let Some(root) = root.filter(|_| next.may_hit) else {
            finish(next.index, leaver.map_or(Found::MISS, |leaver| leaver.search.found()));
            continue;
        };
        // What only rays inside of instances need is left as it was.
        queue.put(&next, &mut slot.search, &mut slot.ray, &mut slot.slab);
        (slot.instance, slot.index) = (NO_INSTANCE, next.index as u32);
        let Some(leaver) = leaver else {
            slot.range = slot.search.range();
            slot.top = slot.bottom + 1;
            return Some(root);
        };
        slot.search = leaver.search;
        slot.range = slot.search.range();
        slot.top = slot.bottom + 1 + leaver.words.len();
        stacks.fill(slot.bottom + 1, leaver.entries, leaver.words);
        return Some(slot.pop(stacks));
    }
    None
}

/// Traces what is left of rays; `finish` gets the index of each and what was found.
#[inline(always)]
pub(super) fn run<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    (rays, rest): (&[Ray], &Rest),
    mut stacks: Open<'_>,
    mut finish: impl FnMut(usize, Found),
) {
    let places = Places::new(scene);
    let mut slots: [Slot; SLOTS] = std::array::from_fn(|place| Slot::empty(place * scene.bvh.stack_len));
    let (mut lists, mut ready) = (Lists::EMPTY, ([Visit::default(); SLOTS], 0));
    let mut queue = Queue::new(rays, rest, &scene.bvh.top.padding);
    let from = (rest, scene.root());
    for (place, slot) in slots.iter_mut().enumerate() {
        stacks.put(slot.bottom, END);
        if let Some(word) = start(&mut queue, from, slot, &mut stacks, &mut finish) {
            lists.add(place, word);
            places.prefetch(simd, word);
        }
    }
    while !lists.is_empty() || ready.1 > 0 {
        nodes::<S, ANY>(simd, scene, &places, &mut slots, &mut stacks, &mut lists);
        // Packs are those of the round before: their memory takes longer than the nodes of this round.
        let now = std::mem::replace(&mut ready, lists.take_packs());
        packs::<S, ANY>(simd, scene, &places, &now.0[..now.1], &mut slots, &mut stacks, &mut lists);
        for kind in [SPHERES, OTHERS] {
            for i in 0..lists.restart(kind) {
                let visit = lists.visit(kind, i);
                let (place, word) = (visit.slot(), visit.word);
                let slot = &mut slots[place];
                let next = if word == END {
                    finish(slot.index as usize, slot.search.found());
                    let Some(word) = start(&mut queue, from, slot, &mut stacks, &mut finish) else { continue };
                    word
                } else if word == LEAVE {
                    slot.set_local(slot.outside);
                    slot.pop(&stacks)
                } else {
                    aside::<S, ANY>(simd, scene, slot, word, &mut stacks)
                };
                lists.add(place, next);
                places.prefetch(simd, next);
            }
        }
    }
}

/// Gives every ray at a node a step.
#[inline(always)]
fn nodes<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    places: &Places,
    slots: &mut [Slot; SLOTS],
    stacks: &mut Open<'_>,
    lists: &mut Lists,
) {
    let nodes = &scene.bvh.arrays.nodes[..];
    let count = lists.restart(NODES);
    for i in 0..count {
        let visit = lists.visit(NODES, i);
        let slot = &mut slots[visit.slot()];
        let (entries, words) = stacks.rooms(slot.top);
        slot.top += simd.children::<ANY>(&nodes[visit.word as usize], &slot.slab, &slot.range, entries, words);
    }
    for i in 0..count {
        let place = lists.visit(NODES, i).slot();
        let word = slots[place].pop(stacks);
        lists.add(place, word);
        places.prefetch(simd, word);
    }
}

/// Tests a pack for every ray that has come to one.
#[inline(always)]
fn packs<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    places: &Places,
    visits: &[Visit],
    slots: &mut [Slot; SLOTS],
    stacks: &mut Open<'_>,
    lists: &mut Lists,
) {
    let packs = &scene.bvh.arrays.packs[..];
    let mut pending = [Pending::default(); SLOTS];
    let mut waiting = 0;
    for &visit in visits {
        let candidates = simd.candidates(&packs[Child::first(visit.word)], &slots[visit.slot()].ray);
        pending[waiting % SLOTS] = Pending { visit, candidates };
        waiting += usize::from(candidates != 0);
    }
    let mut done = 0_u32;
    for &Pending { visit, candidates } in &pending[..waiting.min(SLOTS)] {
        let (slot, index) = (&mut slots[visit.slot()], Child::first(visit.word));
        let within = (&slot.ray, slot.instance);
        if scene.pack(index, &packs[index], candidates, within, &mut slot.search) {
            slot.shorten::<S, ANY>(simd, stacks);
            done |= u32::from(ANY) << visit.slot();
        }
    }
    for &visit in visits {
        let (place, slot) = (visit.slot(), &mut slots[visit.slot()]);
        let (is_last, rest) = Child::next_pack(visit.word);
        let is_last = is_last | (done >> place & 1 == 1);
        slot.top -= usize::from(is_last);
        let below = stacks.word(slot.top);
        let word = if is_last { below } else { rest };
        lists.add(place, word);
        places.prefetch(simd, word);
    }
}

/// Enters an instance, or tests the spheres of a leaf; what is visited next.
#[inline(always)]
fn aside<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    slot: &mut Slot,
    word: u32,
    stacks: &mut Open<'_>,
) -> u32 {
    match Child::of(word) {
        Child::Instance(index) => {
            if let Some((inside, root)) = scene.enter(index, &slot.ray, &slot.search) {
                stacks.put(slot.top, LEAVE);
                slot.top += 1;
                slot.outside = slot.local();
                slot.set_local(inside);
                return root;
            }
        }
        leaf => {
            let within = (&slot.ray, slot.instance);
            if scene.leaf::<S, ANY>(simd, leaf, within, &mut slot.search) {
                slot.shorten::<S, ANY>(simd, stacks);
            }
        }
    }
    slot.pop(stacks)
}
