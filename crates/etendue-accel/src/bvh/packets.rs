//! Beams of rays that go the same way: sixteen rays walk the tree together, each node's boxes and each triangle tested for
//! all of them at once. It pays if several of them visit the same nodes; whether they do is found by trying.

use super::beam::{BEAM, Beam, HEADINGS, Lanes, heading};
use super::node::{Child, LANES, Pack, WIDTH};
use super::traverse::{Places, Scene};
use crate::ray::{Hit, PrimitiveId, Ray};
use crate::search::Search;
use crate::simd::Simd;
use crate::triangle::decide;

/// Nodes after which it is asked, again and again, whether a beam pays.
const TRIAL: u32 = 8;

/// Rays that must be at a node, on average, for a beam to pay.
const FEWEST: u32 = 6;

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

/// Traces what goes the same way, in beams, and lists the other rays by their indices: all of them where there are
/// transformed instances, inside of which rays would go other ways.
#[inline(always)]
pub(super) fn beams<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    rays: &[Ray],
    stack: &mut BeamStack,
    others: &mut Vec<u32>,
    finish: &mut impl FnMut(usize, Hit),
) {
    others.clear();
    if !scene.bvh.arrays.instances.is_empty() {
        others.extend(0..rays.len() as u32);
        return;
    }
    stack.grow(scene.bvh.stack_len);
    let mut groups = [([0_u32; BEAM], 0); HEADINGS];
    // Rays that are not tried, more with each failure.
    let (mut failures, mut passed_over) = (0_u32, 0_u32);
    for (index, ray) in rays.iter().enumerate() {
        if passed_over > 0 {
            passed_over -= 1;
            others.push(index as u32);
            continue;
        }
        let Some(heading) = heading(ray) else {
            finish(index, Hit::MISS);
            continue;
        };
        let (group, len) = &mut groups[heading % HEADINGS];
        group[*len % BEAM] = index as u32;
        *len += 1;
        if *len < BEAM {
            continue;
        }
        *len = 0;
        let members = group.map(|index| &rays[index as usize]);
        let mut beam = Beam::new(&members, heading, &scene.bvh.top.padding);
        let mut searches = members.map(Search::new);
        if trace::<S, ANY>(simd, scene, &mut beam, &mut searches, stack) {
            group.iter().zip(&searches).for_each(|(&index, search)| finish(index as usize, search.hit()));
            failures = 0;
        } else {
            others.extend_from_slice(group);
            passed_over = (BEAM as u32) << failures;
            failures = (failures + 1).min(6);
        }
    }
    groups.iter().for_each(|(group, len)| others.extend_from_slice(&group[..*len]));
}

/// Searches for all rays of a beam; false if they part too soon, when nothing has come of it.
#[inline(always)]
fn trace<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    beam: &mut Beam,
    searches: &mut [Search; BEAM],
    stack: &mut BeamStack,
) -> bool {
    let Some(mut word) = scene.bvh.top.word else { return true };
    let places = Places::new(scene);
    let (mut top, mut steps, mut visits) = (0, 0, 0);
    loop {
        if Child::is_node(word) {
            steps += 1;
            if steps == TRIAL {
                if visits < TRIAL * FEWEST {
                    return false;
                }
                (steps, visits) = (0, 0);
            }
            let rooms = (stack.enters[top..].first_chunk_mut(), stack.words[top..].first_chunk_mut());
            let (Some(enters), Some(words)) = rooms else { return false };
            let _: (&[Lanes; WIDTH], &[u32; WIDTH]) = (enters, words);
            let count = simd.beam_children(&scene.bvh.arrays.nodes[word as usize], beam, enters, words);
            if !scene.bvh.cached {
                words.iter().take(count).for_each(|&word| places.prefetch(simd, word));
            }
            top += count;
        } else {
            leaf::<S, ANY>(simd, scene, Child::of(word), beam, searches);
        }
        loop {
            if top == 0 {
                return true;
            }
            top -= 1;
            let waiting = simd.waiting(&stack.enters[top], &beam.bound);
            if waiting != 0 {
                visits += waiting.count_ones();
                break;
            }
        }
        word = stack.words[top];
    }
}

/// Tests what is in a leaf.
#[inline(always)]
fn leaf<S: Simd, const ANY: bool>(
    simd: S,
    scene: &Scene<'_>,
    leaf: Child,
    beam: &mut Beam,
    searches: &mut [Search; BEAM],
) {
    match leaf {
        Child::Packs { first, count } => {
            for index in first as usize..(first + count) as usize {
                pack::<S, ANY>(simd, scene, index, beam, searches);
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
    beam: &mut Beam,
    searches: &mut [Search; BEAM],
) {
    let pack: &Pack = &scene.bvh.arrays.packs[index];
    for place in 0..LANES {
        if pack.corners[0][0][place].is_nan() {
            break;
        }
        let mut sheared = [[[0.0; BEAM]; 3]; 3];
        let candidates = simd.beam_triangle(pack, place, beam, &mut sheared);
        if candidates == 0 {
            continue;
        }
        let instance = scene.bvh.arrays.owners.of(index, place);
        let id = PrimitiveId { instance, primitive: pack.primitive[place] };
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
                    let found = search.crossing(crossings.t[i], [v[i], w[i], det[i]], id);
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
