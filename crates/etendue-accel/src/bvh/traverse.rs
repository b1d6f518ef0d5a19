//! Traversal of the wide BVH. Where the structure fits into the cache, one ray at a time in a tight loop; else a state
//! machine that takes one node or leaf a step, so that one core can have several rays in flight and wait for the memory of
//! all of them at once.

use std::cell::Cell;

use super::Bvh;
use super::collapse::Root;
use super::node::{Child, LANES, Pack, WIDTH};
use crate::geometry::World;
use crate::isa::SimdKernel;
use crate::local_ray::LocalRay;
use crate::padding::SlabRay;
use crate::ray::{Hit, PrimitiveId, Ray};
use crate::search::Search;
use crate::simd::Simd;
use crate::triangle::decide;

/// Rays in flight where the structure does not fit into the cache.
const IN_FLIGHT: usize = 16;

/// Structures of more bytes than this are traversed with several rays in flight: the size of a second-level cache.
pub(super) const CACHED_BYTES: usize = 1 << 20;

/// Slices of fewer rays are traced one by one.
const FEW_RAYS: usize = 4;

thread_local! {
    /// The stacks of a thread's rays, kept from call to call.
    static STACKS: Cell<Stacks> = const { Cell::new(Stacks { entries: Vec::new(), words: Vec::new() }) };
}

/// What is still to be visited: child words with the entry distances of their boxes, for each ray in flight. Each stack
/// has room for [`WIDTH`] entries more than are used, because vectors are stored whole.
#[derive(Default)]
struct Stacks {
    entries: Vec<f32>,
    words: Vec<u32>,
}

impl Stacks {
    fn grow(&mut self, len: usize) {
        if self.entries.len() < len {
            self.entries.resize(len, 0.0);
            self.words.resize(len, 0);
        }
    }
}

/// Searches for a slice of rays; `finish` gets the index of each ray and what was found.
pub(crate) struct Trace<'a, F, const ANY: bool> {
    pub world: &'a World,
    pub bvh: &'a Bvh,
    pub rays: &'a [Ray],
    pub finish: F,
}

impl<F: FnMut(usize, Hit), const ANY: bool> SimdKernel for Trace<'_, F, ANY> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) {
        let mut stacks = STACKS.take();
        if self.bvh.cached || self.rays.len() < FEW_RAYS {
            self.one_by_one(simd, &mut stacks);
        } else {
            self.in_flight(simd, &mut stacks);
        }
        STACKS.set(stacks);
    }
}

impl<F: FnMut(usize, Hit), const ANY: bool> Trace<'_, F, ANY> {
    #[inline(always)]
    fn one_by_one<S: Simd>(mut self, simd: S, stacks: &mut Stacks) {
        stacks.grow(self.bvh.stack_len);
        let scene = Scene { world: self.world, bvh: self.bvh };
        for (index, ray) in self.rays.iter().enumerate() {
            let hit = scene.trace::<S, ANY>(simd, ray, &mut stacks.entries, &mut stacks.words);
            (self.finish)(index, hit);
        }
    }

    #[inline(always)]
    fn in_flight<S: Simd>(mut self, simd: S, stacks: &mut Stacks) {
        let len = self.bvh.stack_len;
        stacks.grow(len * IN_FLIGHT);
        let scene = Scene { world: self.world, bvh: self.bvh };
        let mut next = 0;
        let mut walks = [const { None::<Walk> }; IN_FLIGHT];
        let mut walking = 0;
        for (walk, (entries, words)) in
            walks.iter_mut().zip(stacks.entries.chunks_exact_mut(len).zip(stacks.words.chunks_exact_mut(len)))
        {
            *walk = self.next_walk(&mut next, entries, words);
            walking += usize::from(walk.is_some());
        }
        while walking > 0 {
            let places = stacks.entries.chunks_exact_mut(len).zip(stacks.words.chunks_exact_mut(len));
            for (place, (entries, words)) in walks.iter_mut().zip(places) {
                let Some(walk) = place else { continue };
                if walk.step::<S, ANY>(simd, &scene, entries, words) {
                    walk.prefetch(simd, &scene, words);
                    continue;
                }
                (self.finish)(walk.index, walk.search.hit());
                *place = self.next_walk(&mut next, entries, words);
                walking -= usize::from(place.is_none());
            }
        }
    }

    /// The next ray that can hit anything; those before it miss.
    #[inline(always)]
    fn next_walk(&mut self, next: &mut usize, entries: &mut [f32], words: &mut [u32]) -> Option<Walk> {
        while let Some(ray) = self.rays.get(*next) {
            let index = *next;
            *next += 1;
            match Walk::start(self.bvh, ray, index, entries, words) {
                Some(walk) => return Some(walk),
                None => (self.finish)(index, Hit::MISS),
            }
        }
        None
    }
}

/// What rays meet.
#[derive(Clone, Copy)]
struct Scene<'a> {
    world: &'a World,
    bvh: &'a Bvh,
}

/// A ray in the space of a level.
#[derive(Clone, Copy)]
struct Local {
    ray: LocalRay,
    slab: SlabRay,
    /// The instance that was entered, [`NO_INSTANCE`] at the top.
    instance: u32,
}

const NO_INSTANCE: u32 = u32::MAX;

impl Local {
    #[inline(always)]
    fn new(ray: LocalRay, root: &Root, instance: u32) -> Self {
        Self { ray, slab: SlabRay::new(&ray, &root.padding), instance }
    }
}

impl Scene<'_> {
    /// A whole search of one ray.
    #[inline(always)]
    fn trace<S: Simd, const ANY: bool>(&self, simd: S, ray: &Ray, entries: &mut [f32], words: &mut [u32]) -> Hit {
        let top = &self.bvh.top;
        let (Some((mut search, world_ray)), Some(root)) = (Search::start(ray), top.word) else { return Hit::MISS };
        let outside = Local::new(world_ray, top, NO_INSTANCE);
        let mut local = outside;
        // Where the entries of the current level start.
        let mut base = 0;
        let mut len = 1;
        (entries[0], words[0]) = (search.t_min, root);
        'levels: loop {
            let here = local;
            loop {
                if len == base {
                    break;
                }
                len -= 1;
                // Equal distances stay: a smaller id may be there.
                if entries[len] > search.best.t {
                    continue;
                }
                let mut word = words[len];
                while Child::is_node(word) {
                    let count = self.children(simd, word, &here.slab, &search, len, entries, words);
                    if count == 0 {
                        break;
                    }
                    len += count - 1;
                    word = words[len];
                    if !self.bvh.cached && count > 1 {
                        self.prefetch(simd, words[len - 1]);
                    }
                }
                if Child::is_node(word) {
                    continue;
                }
                match Child::of(word) {
                    Child::Instance(index) => {
                        if let Some((inside, root)) = self.enter(index, &here.ray, search.mask) {
                            (local, base) = (inside, len);
                            (entries[len], words[len]) = (search.t_min, root);
                            len += 1;
                            continue 'levels;
                        }
                    }
                    leaf => {
                        if self.leaf::<S, ANY>(simd, leaf, &here, &mut search) && ANY {
                            return search.hit();
                        }
                    }
                }
            }
            if here.instance == NO_INSTANCE {
                return search.hit();
            }
            (local, base) = (outside, 0);
        }
    }

    /// Tests a node's children and puts those that are entered at a place of the stack; how many.
    #[inline(always)]
    #[expect(clippy::too_many_arguments)]
    fn children<S: Simd>(
        &self,
        simd: S,
        word: u32,
        slab: &SlabRay,
        search: &Search,
        len: usize,
        entries: &mut [f32],
        words: &mut [u32],
    ) -> usize {
        let (Some(entries), Some(words)) = (entries[len..].first_chunk_mut(), words[len..].first_chunk_mut()) else {
            return 0;
        };
        let _: (&[f32; WIDTH], &[u32; WIDTH]) = (entries, words);
        simd.children(&self.bvh.arrays.nodes[word as usize], slab, (search.t_min, search.best.t), entries, words)
    }

    /// Tests what is in a leaf other than an instance. True if anything is hit.
    #[inline(always)]
    fn leaf<S: Simd, const ANY: bool>(&self, simd: S, leaf: Child, local: &Local, search: &mut Search) -> bool {
        match leaf {
            Child::Packs { first, count } => {
                let mut found = false;
                for index in first as usize..(first + count) as usize {
                    found |= self.pack(simd, index, local, search);
                    if found && ANY {
                        break;
                    }
                }
                found
            }
            Child::Spheres { first, count } => {
                let mut found = false;
                for item in &self.bvh.arrays.spheres[first as usize..(first + count) as usize] {
                    let inside = local.instance != NO_INSTANCE;
                    let instance = if inside { local.instance } else { item.id.instance };
                    let id = PrimitiveId { instance, ..item.id };
                    if inside || self.is_seen(instance, search) {
                        found |= search.sphere(&local.ray, &item.sphere, id);
                    }
                }
                found
            }
            Child::Node(_) | Child::Instance(_) => false,
        }
    }

    #[inline(always)]
    fn pack<S: Simd>(&self, simd: S, index: usize, local: &Local, search: &mut Search) -> bool {
        let pack: &Pack = &self.bvh.arrays.packs[index];
        let mut candidates = simd.candidates(pack, &local.ray);
        if candidates == 0 {
            return false;
        }
        let crossings = decide(pack.sheared(&local.ray));
        let mut found = false;
        while candidates != 0 {
            let lane = candidates.trailing_zeros() as usize % LANES;
            candidates &= candidates - 1;
            let inside = local.instance != NO_INSTANCE;
            let instance = if inside { local.instance } else { self.bvh.arrays.owners.of(index, lane) };
            if inside || self.is_seen(instance, search) {
                let id = PrimitiveId { instance, primitive: pack.primitive[lane] };
                let [v, w, det] = &crossings.edges;
                found |= search.crossing(crossings.t[lane], [v[lane], w[lane], det[lane]], id);
            }
        }
        found
    }

    /// Asks for the memory of what a child word leads to.
    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, word: u32) {
        match Child::of(word) {
            Child::Node(index) => simd.prefetch(&self.bvh.arrays.nodes[index as usize]),
            Child::Packs { first, .. } => simd.prefetch(&self.bvh.arrays.packs[first as usize]),
            Child::Spheres { .. } | Child::Instance(_) => {}
        }
    }

    #[inline(always)]
    fn is_seen(&self, instance: u32, search: &Search) -> bool {
        self.world.instances[instance as usize].mask & search.mask != 0
    }

    /// The ray in an instance's space and where to start there.
    fn enter(&self, index: u32, ray: &LocalRay, mask: u32) -> Option<(Local, u32)> {
        let instance_index = *self.bvh.arrays.instances.get(index as usize)?;
        let instance = &self.world.instances[instance_index as usize];
        if instance.mask & mask == 0 {
            return None;
        }
        let root = self.bvh.objects[instance.geometry as usize].as_ref()?;
        let inside = ray.in_object(instance.transform.as_ref()?)?;
        Some((Local::new(inside, root, instance_index), root.word?))
    }
}

/// One of several rays in flight.
struct Walk {
    index: usize,
    search: Search,
    local: Local,
    /// The ray in the world, where `local` is inside an instance.
    outside: (LocalRay, SlabRay),
    /// The stack's length, and where the entries of the current level start.
    len: usize,
    base: usize,
}

impl Walk {
    #[inline(always)]
    fn start(bvh: &Bvh, ray: &Ray, index: usize, entries: &mut [f32], words: &mut [u32]) -> Option<Self> {
        let (search, world_ray) = Search::start(ray)?;
        (entries[0], words[0]) = (search.t_min, bvh.top.word?);
        let local = Local::new(world_ray, &bvh.top, NO_INSTANCE);
        Some(Self { index, search, local, outside: (local.ray, local.slab), len: 1, base: 0 })
    }

    /// Takes the nearest entry of the stack. False when the search is over.
    #[inline(always)]
    fn step<S: Simd, const ANY: bool>(
        &mut self,
        simd: S,
        scene: &Scene<'_>,
        entries: &mut [f32],
        words: &mut [u32],
    ) -> bool {
        loop {
            if self.len == self.base {
                if self.local.instance == NO_INSTANCE {
                    return false;
                }
                let (ray, slab) = self.outside;
                (self.local, self.base) = (Local { ray, slab, instance: NO_INSTANCE }, 0);
                continue;
            }
            self.len -= 1;
            // Equal distances stay: a smaller id may be there.
            if entries[self.len] <= self.search.best.t {
                break;
            }
        }
        let word = words[self.len];
        if Child::is_node(word) {
            self.len += scene.children(simd, word, &self.local.slab, &self.search, self.len, entries, words);
            return true;
        }
        match Child::of(word) {
            Child::Instance(index) => {
                if let Some((inside, root)) = scene.enter(index, &self.local.ray, self.search.mask) {
                    (self.local, self.base) = (inside, self.len);
                    (entries[self.len], words[self.len]) = (self.search.t_min, root);
                    self.len += 1;
                }
                true
            }
            leaf => !(scene.leaf::<S, ANY>(simd, leaf, &self.local, &mut self.search) && ANY),
        }
    }

    /// Asks for the memory of the next step.
    #[inline(always)]
    fn prefetch<S: Simd>(&self, simd: S, scene: &Scene<'_>, words: &[u32]) {
        if self.len == self.base {
            return;
        }
        scene.prefetch(simd, words[self.len - 1]);
    }
}
