//! Traversal of the wide BVH. Slices of rays go in rounds, see `rounds.rs`, and those of very few rays one by one, see `alone.rs`.

use std::cell::Cell;

use super::Bvh;
use super::collapse::Root;
use super::large::Remains;
use super::node::{Child, LANES, Node, Pack, WIDTH};
use super::packets::{BeamStack, Rest, beams};
use super::rounds::{self, SLOTS};
use crate::geometry::World;
use crate::isa::SimdKernel;
use crate::local_ray::LocalRay;
use crate::padding::SlabRay;
use crate::ray::{PrimitiveId, Ray};
use crate::search::{Found, Search};
use crate::simd::{STACK_ROOM, Simd};
use crate::triangle::{Crossings, decide};

/// The word at the bottom of a stack. Of the kind of instances, beyond all of them.
pub(super) const END: u32 = u32::MAX;

/// The word below the stack of an instance that was entered.
pub(super) const LEAVE: u32 = u32::MAX - 1;

/// The entry distance of these words, which are never culled.
pub(super) const KEPT: f32 = f32::NEG_INFINITY;

/// Structures of more bytes than this are waited for: the size of a second-level cache.
pub(super) const CACHED_BYTES: usize = 1 << 20;

/// Rays that are sorted into beams together.
const CHUNK: usize = 1 << 13;

thread_local! {
    /// The stacks of a thread's rays, kept from call to call.
    static STACKS: Cell<Option<Box<Rooms>>> = const { Cell::new(None) };
}

/// What a thread needs to trace rays.
#[derive(Debug, Default)]
struct Rooms {
    stacks: Stacks,
    beams: BeamStack,
    rest: Rest,
    remains: Remains,
}

/// What rays have still to visit: child words with the entry distances of their boxes. The stacks of several rays are close to
/// one another, so that they share pages of memory; positions count from the bottom of the first.
#[derive(Debug, Default)]
pub(super) struct Stacks {
    entries: Vec<f32>,
    words: Vec<u32>,
}

impl Stacks {
    /// Makes room for so many stacks of so many words.
    fn grow(&mut self, count: usize, room: usize) {
        let len = count * room + STACK_ROOM;
        if self.entries.len() < len {
            self.entries.resize(len, KEPT);
            self.words.resize(len, END);
        }
    }

    /// Both arrays as slices, which loops hold with one length.
    #[inline(always)]
    pub fn open(&mut self) -> Open<'_> {
        Open::new(&mut self.entries, &mut self.words)
    }
}

/// The stacks while they are worked on.
#[derive(Debug)]
pub(super) struct Open<'a> {
    entries: &'a mut [f32],
    words: &'a mut [u32],
    /// The last place with room for the children of a node.
    last_room: usize,
}

impl<'a> Open<'a> {
    #[inline(always)]
    pub fn new(entries: &'a mut [f32], words: &'a mut [u32]) -> Self {
        let len = words.len().min(entries.len());
        assert!(len >= WIDTH, "stacks have been grown");
        Open { entries: &mut entries[..len], words: &mut words[..len], last_room: len - WIDTH }
    }

    #[inline(always)]
    pub fn word(&self, place: usize) -> u32 {
        self.words[place]
    }

    /// A word that is never culled.
    #[inline(always)]
    pub fn put(&mut self, place: usize, word: u32) {
        (self.entries[place], self.words[place]) = (KEPT, word);
    }

    /// Copies entries to a place; what has no room is left out.
    #[inline(always)]
    pub fn fill(&mut self, place: usize, entries: &[f32], words: &[u32]) {
        self.entries[place..].iter_mut().zip(entries).for_each(|(to, &from)| *to = from);
        self.words[place..].iter_mut().zip(words).for_each(|(to, &from)| *to = from);
    }

    /// Where a node's children go. Without a branch: what could not be is moved back into the stacks.
    #[inline(always)]
    pub fn rooms(&mut self, place: usize) -> (&mut [f32; WIDTH], &mut [u32; WIDTH]) {
        let place = place.min(self.last_room);
        let (entries, words) =
            (self.entries.as_mut_ptr().wrapping_add(place), self.words.as_mut_ptr().wrapping_add(place));
        // SAFETY: both slices hold at least `last_room + WIDTH` elements, and are borrowed for as long as the rooms are.
        unsafe { (&mut *entries.cast(), &mut *words.cast()) }
    }

    /// Takes off what is beyond `t` of the stack between two places; the new upper one.
    #[inline(always)]
    pub fn cull<S: Simd>(&mut self, simd: S, bottom: usize, top: usize, t: f32) -> usize {
        bottom + simd.cull(&mut self.entries[bottom..], &mut self.words[bottom..], top - bottom, t)
    }
}

/// Searches for a slice of rays; `finish` gets the index of each ray and what was found.
pub(crate) struct Trace<'a, F, const ANY: bool> {
    pub world: &'a World,
    pub bvh: &'a Bvh,
    pub rays: &'a [Ray],
    pub finish: F,
}

impl<F: FnMut(usize, Found), const ANY: bool> SimdKernel for Trace<'_, F, ANY> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        let mut rooms = STACKS.take().unwrap_or_default();
        let Rooms { stacks, beams: beam_stack, rest, remains } = &mut *rooms;
        let scene = Scene { world: self.world, bvh: self.bvh };
        stacks.grow(SLOTS, self.bvh.stack_len);
        for (number, rays) in self.rays.chunks(CHUNK).enumerate() {
            let mut finish = |index, found| (self.finish)(number * CHUNK + index, found);
            let rays = match &self.bvh.large {
                Some(large) => {
                    remains.fill::<S, ANY>(simd, (&scene, large), rays, &mut finish);
                    &remains.rays[..]
                }
                None => rays,
            };
            let mut finish = |place, found| {
                let (index, found) = if self.bvh.large.is_some() { remains.best(place, found) } else { (place, found) };
                finish(index, found);
            };
            beams::<S, ANY>(simd, &scene, rays, beam_stack, rest, &mut finish);
            if !(rest.others.is_empty() && rest.leavers.is_empty()) {
                rounds::run::<S, ANY>(simd, &scene, (rays, rest), stacks.open(), finish);
            }
        }
        STACKS.set(Some(rooms));
    }
}

/// Where the memory is that words lead to, by their kind.
#[derive(Clone, Copy)]
pub(super) struct Places {
    starts: [*const u8; 4],
    sizes: [usize; 4],
    /// Where the last cache line begins.
    ends: [usize; 4],
    /// All of it is in a cache.
    cached: bool,
}

impl Places {
    #[inline(always)]
    pub fn new(scene: &Scene<'_>) -> Self {
        let arrays = &scene.bvh.arrays;
        let (nodes, packs) = (arrays.nodes.as_ptr().cast(), arrays.packs.as_ptr().cast());
        Self {
            starts: [nodes, packs, nodes, nodes],
            sizes: [size_of::<Node>(), size_of::<Pack>(), 0, 0],
            ends: [192, 128, 0, 0],
            cached: scene.bvh.cached,
        }
    }

    /// Asks for what a word leads to, unless all is in a cache, without a branch on the word: those of other kinds than nodes and
    /// packs ask for the first node.
    #[inline(always)]
    pub fn prefetch<S: Simd>(&self, simd: S, word: u32) {
        if self.cached {
            return;
        }
        let kind = word as usize >> 30;
        let start = self.starts[kind & 3].wrapping_add(Child::first(word) * self.sizes[kind & 3]);
        simd.prefetch_lines::<3>(start);
        simd.prefetch_lines::<1>(start.wrapping_add(self.ends[kind & 3]));
    }
}

/// What rays meet.
#[derive(Clone, Copy)]
pub(super) struct Scene<'a> {
    pub world: &'a World,
    pub bvh: &'a Bvh,
}

impl Scene<'_> {
    /// Where rays of slices begin: what is apart has been tested before.
    #[inline(always)]
    pub fn root(&self) -> Option<u32> {
        self.bvh.top.others.or(self.bvh.top.word)
    }
}

/// A ray in the space of a level.
#[derive(Clone, Copy)]
pub(super) struct Local {
    pub ray: LocalRay,
    pub slab: SlabRay,
    /// The instance that was entered, [`NO_INSTANCE`] at the top.
    pub instance: u32,
}

pub(super) const NO_INSTANCE: u32 = u32::MAX;

impl Local {
    /// No ray.
    pub const NONE: Self = Self { ray: LocalRay::NONE, slab: SlabRay::NONE, instance: NO_INSTANCE };

    #[inline(always)]
    pub fn new(ray: LocalRay, root: &Root, instance: u32) -> Self {
        Self { ray, slab: SlabRay::new(&ray, &root.padding), instance }
    }
}

impl Scene<'_> {
    /// Tests what is in a leaf other than an instance, for a ray at the top or within an instance. True if anything better is hit.
    #[inline(always)]
    pub fn leaf<S: Simd, const ANY: bool>(
        &self,
        simd: S,
        leaf: Child,
        (ray, within): (&LocalRay, u32),
        search: &mut Search,
    ) -> bool {
        let mut found = false;
        match leaf {
            Child::Packs { first, count } => {
                for index in first as usize..(first + count) as usize {
                    let pack = &self.bvh.arrays.packs[index];
                    let candidates = simd.candidates(pack, ray);
                    if candidates != 0 {
                        found |= self.pack(index, pack, candidates, (ray, within), search);
                        if found && ANY {
                            break;
                        }
                    }
                }
            }
            Child::Spheres { first, count } => {
                for item in &self.bvh.arrays.spheres[first as usize..(first + count) as usize] {
                    let inside = within != NO_INSTANCE;
                    let instance = if inside { within } else { item.id.instance };
                    let id = PrimitiveId { instance, ..item.id };
                    if inside || self.is_seen(instance, search) {
                        found |= search.sphere(ray, &item.sphere, id);
                    }
                }
            }
            Child::Node(_) | Child::Instance(_) => {}
        }
        found
    }

    /// Decides the candidates of a pack. True if anything better is hit.
    #[inline(always)]
    pub fn pack(
        &self,
        index: usize,
        pack: &Pack,
        candidates: u32,
        (ray, within): (&LocalRay, u32),
        search: &mut Search,
    ) -> bool {
        self.decided(index, pack, (candidates, &decide(pack.sheared(ray))), within, search)
    }

    /// Takes candidates of a pack that are decided. True if anything better is hit.
    #[inline(always)]
    pub fn decided(
        &self,
        index: usize,
        pack: &Pack,
        candidates: (u32, &Crossings<LANES>),
        within: u32,
        search: &mut Search,
    ) -> bool {
        search.pack((index, pack), candidates, |search, lane| {
            if within != NO_INSTANCE {
                return Some(within);
            }
            let owner = self.bvh.arrays.owners.of(index, lane);
            self.is_seen(owner, search).then_some(owner)
        })
    }

    #[inline(always)]
    pub fn is_seen(&self, instance: u32, search: &Search) -> bool {
        self.world.instances[instance as usize].mask & search.mask != 0
    }

    /// The ray in an instance's space and where to start there.
    pub fn enter(&self, index: u32, ray: &LocalRay, search: &Search) -> Option<(Local, u32)> {
        let instance_index = *self.bvh.arrays.instances.get(index as usize)?;
        let instance = &self.world.instances[instance_index as usize];
        if instance.mask & search.mask == 0 {
            return None;
        }
        let root = self.bvh.objects[instance.geometry as usize].as_ref()?;
        let inside = ray.inside(&instance.place, search.time)?;
        Some((Local::new(inside, root, instance_index), root.word?))
    }
}
