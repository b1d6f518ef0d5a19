//! Many rays at once: each is in a slot with a stack of its own. A round gives every ray whose next word is a node one node
//! step, then every ray that has come to a leaf one pack of triangles, then does what is rare. Rays are kept in lists by what
//! they do next, which are filled without branches: the loops run over independent rays and mispredict nothing but their
//! ends, so that the processor works on several rays at once; and what a step needs was asked for a round before.

use super::node::Child;
use super::packets::Rest;
use super::traverse::{END, LEAVE, Local, Places, Scene, Stacks};
use crate::ray::{Hit, Ray};
use crate::search::Search;
use crate::simd::Simd;

/// Rays in flight: a power of two.
pub(super) const SLOTS: usize = 32;

/// Slots that will do the same next.
type List = crate::in_flight::List<SLOTS>;

/// One ray in flight.
#[derive(Clone, Copy)]
#[repr(align(64))]
struct Slot {
    search: Search,
    local: Local,
    /// What is visited next; it is no longer on the stack.
    word: u32,
    /// Where the stack begins and ends.
    bottom: usize,
    top: usize,
    index: usize,
    /// The ray in the world, where `local` is inside an instance.
    outside: Local,
}

impl Slot {
    /// Without a ray.
    fn empty(bottom: usize) -> Self {
        let (search, local) = (Search::NONE, Local::NONE);
        Self { search, local, word: END, bottom, top: bottom, index: 0, outside: local }
    }

    /// Starts a ray. What only rays inside of instances need is left as it was.
    #[inline(always)]
    fn start(&mut self, scene: &Scene<'_>, ray: &Ray, index: usize) -> bool {
        let (Some((search, ray)), Some(word)) = (Search::start(ray), scene.root()) else { return false };
        self.search = search;
        self.local = Local::outside(ray, scene.bvh);
        (self.word, self.top, self.index) = (word, self.bottom + 1, index);
        true
    }

    /// Takes the next word off the stack.
    #[inline(always)]
    fn pop(&mut self, stacks: &Stacks) {
        self.top -= 1;
        self.word = stacks.word(self.top);
    }

    /// Enters an instance, or tests the spheres of a leaf.
    #[inline(always)]
    fn step_aside<S: Simd, const ANY: bool>(&mut self, simd: S, scene: &Scene<'_>, stacks: &mut Stacks) {
        match Child::of(self.word) {
            Child::Instance(index) => {
                if let Some((inside, root)) = scene.enter(index, &self.local.ray, &self.search) {
                    stacks.put(self.top, LEAVE);
                    self.top += 1;
                    self.outside = std::mem::replace(&mut self.local, inside);
                    self.word = root;
                    return;
                }
            }
            leaf => {
                if scene.leaf::<S, ANY>(simd, leaf, &self.local, &mut self.search) {
                    self.shorten::<S, ANY>(simd, stacks);
                }
            }
        }
        self.pop(stacks);
    }

    /// After a hit: nothing beyond it is visited; or nothing at all.
    #[inline(always)]
    fn shorten<S: Simd, const ANY: bool>(&mut self, simd: S, stacks: &mut Stacks) {
        self.top = if ANY { self.bottom + 1 } else { stacks.cull(simd, self.bottom, self.top, self.search.best.t) };
    }
}

/// Slots by what they do next.
#[derive(Clone, Copy)]
struct Lists {
    nodes: List,
    /// Packs of the next round but one: their memory takes longer than the nodes of this round.
    packs: List,
    ready: List,
    rest: List,
}

impl Lists {
    /// Puts a slot where it belongs, and asks for the memory of its next step.
    #[inline(always)]
    fn file<S: Simd>(&mut self, simd: S, places: &Places, slot: usize, word: u32) {
        let kind = word >> 30;
        self.nodes.add_if(slot, kind == 0);
        self.packs.add_if(slot, kind == 1);
        self.rest.add_if(slot, kind > 1);
        places.prefetch(simd, word);
    }
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
    rays: &'a [Ray],
    /// What is to be traced, and how many have started.
    rest: &'a Rest,
    next: usize,
    finish: F,
    slots: [Slot; SLOTS],
    stacks: &'a mut Stacks,
    places: Places,
}

impl<'a, F: FnMut(usize, Hit)> Rounds<'a, F> {
    /// Traces what is left; `finish` gets the index of each ray and what was found.
    #[inline(always)]
    pub fn run<S: Simd, const ANY: bool>(
        simd: S,
        scene: Scene<'a>,
        (rays, rest): (&'a [Ray], &'a Rest),
        stacks: &'a mut Stacks,
        finish: F,
    ) {
        let mut lists = Lists { nodes: List::EMPTY, packs: List::EMPTY, ready: List::EMPTY, rest: List::EMPTY };
        let slots = std::array::from_fn(|place| Slot::empty(place * scene.bvh.stack_len));
        let places = Places::new(&scene);
        let mut rounds = Self { scene, rays, rest, next: 0, finish, slots, stacks, places };
        for place in 0..SLOTS {
            rounds.stacks.put(rounds.slots[place].bottom, END);
            if rounds.start(place) {
                lists.file(simd, &places, place, rounds.slots[place].word);
            }
        }
        while lists.nodes.len() + lists.packs.len() + lists.ready.len() + lists.rest.len() > 0 {
            lists = rounds.nodes::<S, ANY>(simd, lists);
            lists = rounds.packs::<S, ANY>(simd, lists);
            lists = rounds.rest::<S, ANY>(simd, lists);
        }
    }

    /// Puts the next ray that can hit anything into a slot, if there is one; those before it miss.
    #[inline(always)]
    fn start(&mut self, place: usize) -> bool {
        while let Some(&index) = self.rest.others.get(self.next) {
            self.next += 1;
            if self.slots[place].start(&self.scene, &self.rays[index as usize], index as usize) {
                return true;
            }
            (self.finish)(index as usize, Hit::MISS);
        }
        while let Some(leaver) = self.rest.leavers.get(self.next - self.rest.others.len()) {
            self.next += 1;
            let slot = &mut self.slots[place];
            if slot.start(&self.scene, &self.rays[leaver.index], leaver.index) {
                slot.search = leaver.search;
                slot.top = slot.bottom + 1 + leaver.words.len();
                self.stacks.fill(slot.bottom + 1, leaver.entries, leaver.words);
                slot.pop(self.stacks);
                return true;
            }
            (self.finish)(leaver.index, leaver.search.hit());
        }
        false
    }

    #[inline(always)]
    fn nodes<S: Simd, const ANY: bool>(&mut self, simd: S, mut lists: Lists) -> Lists {
        let list = std::mem::replace(&mut lists.nodes, List::EMPTY);
        for i in 0..list.len() {
            let place = list.get(i);
            let (slot, stacks) = (&mut self.slots[place], &mut *self.stacks);
            let (word, top) = (slot.word, slot.top);
            slot.top += self.scene.children::<S, ANY>(simd, word, &slot.local.slab, &slot.search, top, stacks);
            slot.pop(stacks);
            lists.file(simd, &self.places, place, slot.word);
        }
        lists
    }

    #[inline(always)]
    fn packs<S: Simd, const ANY: bool>(&mut self, simd: S, mut lists: Lists) -> Lists {
        let list = lists.ready;
        (lists.ready, lists.packs) = (lists.packs, List::EMPTY);
        let mut pending = [Pending::default(); SLOTS];
        let mut count = 0;
        for i in 0..list.len() {
            let place = list.get(i);
            let slot = &self.slots[place];
            let index = Child::first(slot.word);
            let candidates = simd.candidates(&self.scene.bvh.arrays.packs[index], &slot.local.ray);
            pending[count % SLOTS] = Pending { slot: place, pack: index, candidates };
            count += usize::from(candidates != 0);
        }
        for &Pending { slot: place, pack, candidates } in &pending[..count.min(SLOTS)] {
            let (slot, stacks) = (&mut self.slots[place], &mut *self.stacks);
            let (index, pack) = (pack, &self.scene.bvh.arrays.packs[pack]);
            if self.scene.pack(index, pack, candidates, &slot.local, &mut slot.search) {
                slot.shorten::<S, ANY>(simd, stacks);
                if ANY {
                    slot.word = Child::last_pack(slot.word);
                }
            }
        }
        for i in 0..list.len() {
            let place = list.get(i);
            let (slot, stacks) = (&mut self.slots[place], &mut *self.stacks);
            let (is_last, rest) = Child::next_pack(slot.word);
            slot.top -= usize::from(is_last);
            let below = stacks.word(slot.top);
            slot.word = if is_last { below } else { rest };
            lists.file(simd, &self.places, place, slot.word);
        }
        lists
    }

    #[inline(always)]
    fn rest<S: Simd, const ANY: bool>(&mut self, simd: S, mut lists: Lists) -> Lists {
        let list = std::mem::replace(&mut lists.rest, List::EMPTY);
        for i in 0..list.len() {
            let place = list.get(i);
            let (slot, stacks) = (&mut self.slots[place], &mut *self.stacks);
            let word = slot.word;
            if word == END {
                (self.finish)(slot.index, slot.search.hit());
                if !self.start(place) {
                    continue;
                }
            } else if word == LEAVE {
                slot.local = slot.outside;
                slot.pop(stacks);
            } else {
                slot.step_aside::<S, ANY>(simd, &self.scene, stacks);
            }
            lists.file(simd, &self.places, place, self.slots[place].word);
        }
        lists
    }
}
