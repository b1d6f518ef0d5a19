//! Beams of rays that go the same way: sixteen rays walk the tree together, each node's boxes and each triangle tested for
//! all of them at once. Rays that come to a node almost alone leave the beam with their stacks and go on in rounds. It pays
//! if most of them stay together; whether they do is found by trying.

use super::beam::{BEAM, Beam, HEADINGS, Lanes, heading, in_order};
use super::node::{Child, LANES, Pack, WIDTH};
use super::traverse::{Places, Scene};
use crate::ray::{PrimitiveId, Ray};
use crate::search::{Found, Search};
use crate::simd::Simd;
use crate::triangle::decide;

/// When rays leave a beam, as measured.
#[derive(Clone, Copy)]
struct Limits {
    /// Where fewer rays than this come to a node together, they leave.
    fewest: u32,
    /// A beam pays if at most this many of its rays leave.
    most_leave: u32,
}

/// For structures that fit a cache.
const CACHED: Limits = Limits { fewest: 3, most_leave: 8 };

/// For others: many rays alone wait for memory at once, a beam waits for each node.
const LARGE: Limits = Limits { fewest: 5, most_leave: 6 };

/// Rays that have left their beams: what each has found and has still to visit.
#[derive(Debug, Default)]
pub(super) struct Leavers {
    /// The index of the ray, where its part of the stacks ends, and its search.
    rays: Vec<(u32, usize, Search)>,
    entries: Vec<f32>,
    words: Vec<u32>,
}

/// A ray that has left its beam, with its stack from the bottom: entry distances and words.
pub(super) struct Leaver<'a> {
    pub search: Search,
    pub entries: &'a [f32],
    pub words: &'a [u32],
}

impl Leavers {
    fn clear(&mut self) {
        self.rays.clear();
        self.entries.clear();
        self.words.clear();
    }

    pub fn is_empty(&self) -> bool {
        self.rays.is_empty()
    }

    /// One of those who have left, in the order in which they did.
    #[inline(always)]
    fn get(&self, place: usize) -> Option<Leaver<'_>> {
        let &(_, end, search) = self.rays.get(place)?;
        let range = place.checked_sub(1).map_or(0, |before| self.rays[before].1)..end;
        Some(Leaver { search, entries: &self.entries[range.clone()], words: &self.words[range] })
    }

    /// Takes a ray out of a beam that has so many entries on its stack.
    #[inline(always)]
    fn add(&mut self, index: u32, search: &Search, stack: &BeamStack, len: usize, (lane, bound): (usize, f32)) {
        for (enters, &word) in stack.enters.iter().zip(&stack.words).take(len) {
            let enter = enters.0[lane];
            if enter <= bound {
                self.entries.push(enter);
                self.words.push(word);
            }
        }
        self.rays.push((index, self.words.len(), *search));
    }
}

/// What is left for rays alone.
#[derive(Debug, Default)]
pub(super) struct Rest {
    /// Rays that no beam has begun with, by index.
    pub others: Vec<u32>,
    pub leavers: Leavers,
}

impl Rest {
    /// The index of a ray by its number: first the others, then those that left.
    #[inline(always)]
    pub fn index(&self, number: usize) -> Option<usize> {
        match self.others.get(number) {
            Some(&index) => Some(index as usize),
            None => self.leavers.rays.get(number - self.others.len()).map(|&(index, ..)| index as usize),
        }
    }

    /// What a ray of a number brings from its beam, if it was in one.
    #[inline(always)]
    pub fn leaver(&self, number: usize) -> Option<Leaver<'_>> {
        self.leavers.get(number.checked_sub(self.others.len())?)
    }
}

/// What beams have still to visit: where their rays enter, NaN for those that do not, and child words.
#[derive(Debug, Default)]
pub(super) struct BeamStack {
    enters: Vec<Lanes>,
    words: Vec<u32>,
}

impl BeamStack {
    fn grow(&mut self, len: usize) {
        if self.words.len() < len {
            self.enters.resize(len, Lanes::NONE);
            self.words.resize(len, 0);
        }
    }
}

/// Rays that are not looked at after some that were far apart.
const LEFT_OUT: u32 = 4 * BEAM as u32;

/// Rays that are not tried, more with each failure.
#[derive(Default)]
struct Trials {
    failures: u32,
    left_out: u32,
}

impl Trials {
    /// True for a ray that is not tried.
    #[inline(always)]
    fn passes_over(&mut self) -> bool {
        let passes = self.left_out > 0;
        self.left_out -= u32::from(passes);
        passes
    }

    #[inline(always)]
    fn failed(&mut self) {
        self.left_out = (BEAM as u32) << self.failures;
        self.failures = (self.failures + 1).min(6);
    }
}

/// Traces what goes the same way, in beams, and lists the rays for which something is left to do: all of them where there are
/// transformed instances, inside of which rays would go other ways.
#[inline(always)]
pub(super) fn beams<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    rays: &[Ray],
    stack: &mut BeamStack,
    rest: &mut Rest,
    finish: &mut impl FnMut(usize, Found),
) {
    let Rest { others, leavers } = rest;
    others.clear();
    leavers.clear();
    if !scene.bvh.arrays.instances.is_empty() {
        others.extend(0..rays.len() as u32);
        return;
    }
    stack.grow(scene.bvh.stack_len);
    let mut groups = [([0_u32; BEAM], 0); HEADINGS];
    let mut trials = Trials::default();
    for (index, ray) in rays.iter().enumerate() {
        if trials.passes_over() {
            others.push(index as u32);
            continue;
        }
        let Some(heading) = heading(ray) else {
            finish(index, Found::MISS);
            continue;
        };
        let (group, len) = &mut groups[heading % HEADINGS];
        group[*len % BEAM] = index as u32;
        *len += 1;
        if *len < BEAM {
            continue;
        }
        *len = 0;
        let mut beam = Beam::new(rays, group, heading, &scene.bvh.top.padding);
        if beam.spread(&scene.bvh.top.bounds) > S::BEAM_SPREAD {
            others.extend_from_slice(&group[..]);
            trials.left_out = LEFT_OUT;
            continue;
        }
        let mut searches = [Search::NONE; BEAM];
        searches.iter_mut().zip(&*group).for_each(|(search, &index)| *search = Search::new(&rays[index as usize]));
        let (left, pays) = trace::<S, ANY>(simd, scene, &mut beam, (group, &mut searches), stack, leavers);
        for (lane, (&index, search)) in group.iter().zip(&searches).enumerate() {
            if left >> lane & 1 == 0 {
                finish(index as usize, search.found());
            }
        }
        if pays {
            trials = Trials::default();
        } else {
            trials.failed();
        }
    }
    groups.iter().for_each(|(group, len)| others.extend_from_slice(&group[..*len]));
}

/// Searches for the rays of a beam, for as long as they stay together: a bit for each that has left, and whether it paid.
#[inline(always)]
fn trace<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    beam: &mut Beam,
    (indices, searches): (&[u32; BEAM], &mut [Search; BEAM]),
    stack: &mut BeamStack,
    leavers: &mut Leavers,
) -> (u32, bool) {
    let places = Places::new(scene);
    let limits = if scene.bvh.cached { CACHED } else { LARGE };
    let mut left = 0_u32;
    let mut sheared = [[[0.0; BEAM]; 3]; 3];
    let Some(root) = scene.root() else { return (0, true) };
    (stack.enters[0], stack.words[0]) = (beam.t_min, root);
    let mut top = 1;
    while top > 0 {
        top -= 1;
        let waiting = simd.waiting(&stack.enters[top], &beam.bound);
        if waiting == 0 {
            continue;
        }
        let word = stack.words[top];
        if !Child::is_node(word) {
            leaf::<S, ANY>(simd, scene, Child::of(word), (beam, &mut sheared), searches);
            continue;
        }
        if waiting.count_ones() < limits.fewest {
            let mut leaving = waiting;
            while leaving != 0 {
                let lane = leaving.trailing_zeros() as usize % BEAM;
                leaving &= leaving - 1;
                leavers.add(indices[lane], &searches[lane], stack, top + 1, (lane, beam.bound.0[lane]));
                beam.bound.0[lane] = f32::NEG_INFINITY;
            }
            left |= waiting;
            continue;
        }
        let rooms = (stack.enters[top..].first_chunk_mut(), stack.words[top..].first_chunk_mut());
        let (Some(enters), Some(words)) = rooms else { continue };
        let _: (&[Lanes; WIDTH], &[u32; WIDTH]) = (enters, words);
        let node = &scene.bvh.arrays.nodes[word as usize];
        let (children, count) = in_order(node.order_of::<ANY>(beam.octant), simd.beam_outline(node, beam));
        let count = simd.beam_children(node, beam, &children[..count], enters, words);
        words.iter().take(count).for_each(|&word| places.prefetch(simd, word));
        top += count;
    }
    (left, left.count_ones() <= limits.most_leave)
}

/// The corners of a triangle as sheared for each ray, by corner and axis.
type Corners = [[[f32; BEAM]; 3]; 3];

/// Tests what is in a leaf.
#[inline(always)]
fn leaf<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    leaf: Child,
    (beam, sheared): (&mut Beam, &mut Corners),
    searches: &mut [Search; BEAM],
) {
    match leaf {
        Child::Packs { first, count } => {
            for index in first as usize..(first + count) as usize {
                pack::<S, ANY>(simd, scene, index, (beam, sheared), searches);
            }
        }
        Child::Spheres { first, count } => {
            for item in &scene.bvh.arrays.spheres[first as usize..(first + count) as usize] {
                for (lane, search) in searches.iter_mut().enumerate() {
                    if scene.is_seen(item.id.instance, search) && beam.bound.0[lane] > f32::NEG_INFINITY {
                        let found = beam.ray(lane).is_some_and(|ray| search.sphere(&ray, &item.sphere, item.id));
                        beam.take::<ANY>(lane, search, found);
                    }
                }
            }
        }
        Child::Node(_) | Child::Instance(_) => {}
    }
}

/// Tests the triangles of a pack.
#[inline(always)]
fn pack<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    index: usize,
    (beam, sheared): (&mut Beam, &mut Corners),
    searches: &mut [Search; BEAM],
) {
    let pack: &Pack = &scene.bvh.arrays.packs[index];
    for place in 0..LANES {
        if pack.corners[0][0][place].is_nan() {
            break;
        }
        let candidates = simd.beam_triangle(pack, place, beam, sheared);
        if candidates == 0 {
            continue;
        }
        let instance = scene.bvh.arrays.owners.of(index, place);
        let id = PrimitiveId { instance, primitive: pack.primitive[place] };
        let at = (index * LANES + place) as u32;
        for half in 0..2 {
            let mut candidates = candidates >> (8 * half) & 255;
            if candidates == 0 {
                continue;
            }
            let mut corners = [[[0.0; 8]; 3]; 3];
            for (corners, sheared) in corners.iter_mut().flatten().zip(sheared.iter().flatten()) {
                corners.copy_from_slice(&sheared[8 * half..8 * half + 8]);
            }
            let crossings = decide(corners);
            while candidates != 0 {
                let i = candidates.trailing_zeros() as usize % 8;
                candidates &= candidates - 1;
                let lane = 8 * half + i;
                let search = &mut searches[lane];
                if scene.is_seen(instance, search) {
                    let [v, w, det] = &crossings.edges;
                    let found = search.crossing(crossings.t[i], [v[i], w[i], det[i]], id, at);
                    beam.take::<ANY>(lane, search, found);
                }
            }
        }
    }
}

impl Beam {
    /// Takes note of what a search has found.
    #[inline(always)]
    fn take<const ANY: bool>(&mut self, lane: usize, search: &Search, found: bool) {
        if found {
            self.bound.0[lane] = if ANY { f32::NEG_INFINITY } else { search.best.t };
        }
    }
}
