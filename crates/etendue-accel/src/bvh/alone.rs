//! Rays that come alone, each walked to its end before the next. What is visited next never waits for what is put on the
//! stack: the nearest child that is entered is found from bits and gone to at once, while all of them are still being sorted.

use std::cell::Cell;

use super::Bvh;
use super::node::Child;
use super::traverse::{END, KEPT, LEAVE, Local, NO_INSTANCE, Open, Places, Scene};
use crate::geometry::World;
use crate::isa::{Isa, SimdKernel, dispatch};
use crate::local_ray::LocalRay;
use crate::ray::Ray;
use crate::search::{Found, Search};
use crate::simd::Simd;
use crate::triangle::decide;

/// Slices of fewer rays are traced one by one, as measured: of structures that fit a cache, and of others, where many rays wait for
/// memory at once.
const FEW: [usize; 2] = [16, 8];

/// Words that the stack has room for: a way of 33 nodes.
const ROOM: usize = 256;

/// What a ray has still to visit.
struct Stack {
    entries: [f32; ROOM],
    words: [u32; ROOM],
}

thread_local! {
    /// Never cleared, and without a destructor: costs nothing to get at.
    static STACK: Cell<Stack> = const { Cell::new(Stack { entries: [KEPT; ROOM], words: [END; ROOM] }) };
}

impl Bvh {
    /// True if a slice of so many rays is for [`few`].
    #[inline(always)]
    pub fn is_few(&self, rays: usize) -> bool {
        rays < FEW[usize::from(!self.cached)] && self.stack_len <= ROOM
    }
}

/// Searches for a few rays; `finish` gets the index of each ray and what was found.
#[inline(always)]
pub(crate) fn few<const ANY: bool>(
    isa: Isa,
    (world, bvh): (&World, &Bvh),
    rays: &[Ray],
    finish: impl FnMut(usize, Found),
) {
    let scene = Scene { world, bvh };
    match bvh.cached {
        true => dispatch(isa, Alone::<_, ANY, true> { scene, rays, finish }),
        false => dispatch(isa, Alone::<_, ANY, false> { scene, rays, finish }),
    }
}

/// A few rays through what is in a cache, or is not and is asked for ahead.
struct Alone<'a, F, const ANY: bool, const CACHED: bool> {
    scene: Scene<'a>,
    rays: &'a [Ray],
    finish: F,
}

impl<F: FnMut(usize, Found), const ANY: bool, const CACHED: bool> SimdKernel for Alone<'_, F, ANY, CACHED> {
    type Output = ();

    #[inline(always)]
    fn run<S: Simd>(mut self, simd: S) {
        for (index, ray) in self.rays.iter().enumerate() {
            let stack = STACK.with(Cell::as_ptr);
            // SAFETY: the stack is this thread's, and nothing else has it while a ray is traced, which calls nothing that could.
            let stack = unsafe { &mut *stack };
            let open = Open::new(&mut stack.entries, &mut stack.words);
            let found = trace::<S, ANY, CACHED>(simd, &self.scene, ray, open);
            (self.finish)(index, found);
        }
    }
}

/// Where a ray is: in the world, or inside of an instance.
#[derive(Clone, Copy)]
struct Level {
    /// The instance, or none.
    instance: u32,
    /// The ray inside of it.
    inside: Option<Local>,
    /// The number of the primitive to be skipped, where all triangles are of one instance; else none is.
    skip: u32,
}

impl Level {
    #[inline(always)]
    fn world(bvh: &Bvh, search: &Search) -> Self {
        let skip = bvh.arrays.owners.sole().map_or(u32::MAX, |owner| search.skipped_of(owner));
        Self { instance: NO_INSTANCE, inside: None, skip }
    }
}

/// A whole search of one ray.
#[inline(always)]
fn trace<S: Simd, const ANY: bool, const CACHED: bool>(
    simd: S,
    scene: &Scene<'_>,
    ray: &Ray,
    mut stack: Open<'_>,
) -> Found {
    let mut search = Search::new(ray);
    let Some(root) = scene.bvh.top.word.filter(|_| search.t_min < ray.t_max) else { return Found::MISS };
    let nodes = &scene.bvh.arrays.nodes[..];
    let places = Places::new(scene);
    let mut level = Level::world(scene.bvh, &search);
    stack.put(0, END);
    let (mut len, mut word) = (1, root);
    loop {
        let aim = match &level.inside {
            None => simd.aim(ray, &scene.bvh.top.padding),
            Some(local) => Some(simd.aim_inside(&local.ray, &local.slab)),
        };
        let Some(aim) = aim else { return Found::MISS };
        loop {
            let slabs = simd.slabs(&aim);
            while Child::is_node(word) {
                let below = stack.word(len - 1);
                let (entries, words) = stack.rooms(len);
                let (count, nearest) = simd.visit::<ANY>(&nodes[word as usize], &slabs, search.range(), entries, words);
                len = len + count - 1;
                word = std::hint::select_unpredictable(count == 0, below, nearest);
                if !CACHED {
                    places.prefetch(simd, stack.word(len.saturating_sub(1)));
                }
            }
            if Child::is_packs(word) {
                if packs::<S, ANY>(simd, scene, word, (&aim, &level), &mut search) {
                    if ANY {
                        return search.found();
                    }
                    len = stack.cull(simd, 0, len, search.best.t);
                }
            } else if word == END {
                return search.found();
            } else if word == LEAVE {
                level = Level::world(scene.bvh, &search);
                len -= 1;
                word = stack.word(len);
                break;
            } else {
                match simd.apart(Aside::<ANY> { scene, word, ray, level, search }) {
                    Beside::Nothing => {}
                    Beside::Better(found) => {
                        search.take(found);
                        if ANY {
                            return found;
                        }
                        len = stack.cull(simd, 0, len, search.best.t);
                    }
                    Beside::Inside(inside, root) => {
                        stack.put(len, LEAVE);
                        len += 1;
                        (level, word) = (inside, root);
                        break;
                    }
                }
            }
            len -= 1;
            word = stack.word(len);
        }
    }
}

/// Tests the packs of a leaf. True if anything better is hit.
#[inline(always)]
fn packs<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    word: u32,
    (aim, level): (&S::Aim, &Level),
    search: &mut Search,
) -> bool {
    let (mut word, mut found) = (word, false);
    loop {
        let index = Child::first(word);
        let pack = &scene.bvh.arrays.packs[index];
        let candidates = simd.candidates_alone(pack, aim, level.skip);
        if candidates != 0 {
            let (candidates, corners) = simd.within(pack, aim, search.range(), candidates);
            if candidates != 0 {
                found |= scene.decided(index, pack, (candidates, &decide(corners)), level.instance, search);
                if found && ANY {
                    return true;
                }
            }
        }
        let (is_last, rest) = Child::next_pack(word);
        if is_last {
            return found;
        }
        word = rest;
    }
}

/// What else than packs a word may lead to.
struct Aside<'a, const ANY: bool> {
    scene: &'a Scene<'a>,
    word: u32,
    ray: &'a Ray,
    level: Level,
    search: Search,
}

/// What has come of it.
enum Beside {
    Nothing,
    /// A better hit.
    Better(Found),
    /// An instance was entered, where a word is the first.
    Inside(Level, u32),
}

impl<const ANY: bool> SimdKernel for Aside<'_, ANY> {
    type Output = Beside;

    #[inline(always)]
    fn run<S: Simd>(self, simd: S) -> Beside {
        let Self { scene, word, ray, level, mut search } = self;
        let local = level.inside.map(|local| local.ray).or_else(|| LocalRay::new(ray.origin, ray.direction));
        let Some(local) = local else { return Beside::Nothing };
        match Child::of(word) {
            Child::Instance(index) => scene.enter(index, &local, &search).map_or(Beside::Nothing, |(local, root)| {
                let skip = search.skipped_of(local.instance);
                Beside::Inside(Level { instance: local.instance, inside: Some(local), skip }, root)
            }),
            leaf => match scene.leaf::<S, ANY>(simd, leaf, (&local, level.instance), &mut search) {
                true => Beside::Better(search.found()),
                false => Beside::Nothing,
            },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Accelerator, AcceleratorKind, Geometry, Hit, Instance, Place, PrimitiveId, TriangleMesh};

    /// A way down that the stack has no room for is not one of ours.
    #[test]
    fn deep_trees_are_left_to_rounds() {
        let positions: Vec<[f32; 3]> = (0..900).map(|i| [0.1 * i as f32, (i % 3) as f32, (i % 2) as f32]).collect();
        let indices: Vec<[u32; 3]> = (0..300).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        let mesh = TriangleMesh { positions: positions.into(), indices: indices.into() };
        let instances = vec![Instance { geometry: 0, place: Place::World, mask: 1 }];
        let world = World { geometries: vec![Geometry::Triangles(mesh)], instances };
        let mut bvh = Bvh::build(&world, Isa::detect()).unwrap();
        assert!(bvh.is_few(1) && !bvh.is_few(16));
        bvh.stack_len = ROOM;
        assert!(bvh.is_few(1));
        bvh.stack_len = ROOM + 1;
        assert!(!bvh.is_few(1));
        let built = Accelerator::build(&world, AcceleratorKind::Bvh, Isa::detect(), 1).unwrap();
        let (mut deep, mut hits) = (Vec::new(), 0);
        for i in 0..200 {
            let origin = [0.45 * i as f32, 0.7, -3.0];
            let direction = [0.01 * (i % 7) as f32, 0.02, 1.0];
            let (t_min, t_max, skip) = (0.0, f32::INFINITY, PrimitiveId::NONE);
            let ray = [Ray { origin, direction, t_min, t_max, time: 0.0, mask: 1, skip }];
            let mut alone = [Hit::MISS];
            built.closest_hits(&ray, &mut alone);
            let finish = |_, found: Found| deep.push(found.hit);
            dispatch(Isa::detect(), crate::bvh::Trace::<_, false> { world: &world, bvh: &bvh, rays: &ray, finish });
            assert_eq!(deep.pop(), Some(alone[0]));
            hits += u32::from(alone[0].is_hit());
        }
        assert!(hits > 10, "{hits}");
    }
}
