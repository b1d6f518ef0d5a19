//! `rays`: a set of rays through both libraries in every way they offer.

use etendue_accel::{Accelerator, Hit, Ray};
use std::cell::RefCell;

use crate::embree::{Found, Rays, Scene};
use crate::mesh::normal;
use crate::turns::{Clock, Contender, fill};

/// Rays of a slice where nothing else is said.
pub const SLICE: usize = 1024;

/// Slices that are tried besides.
const OTHER_SLICES: [usize; 8] = [2, 4, 8, 16, 64, 256, 4096, 16384];

/// The name of ours in slices of the standard size.
pub const OURS: &str = "etendue, slices of 1024";
/// The name of ours with a ray a call.
pub const OURS_SINGLE: &str = "etendue, one per call";
/// The names of Embree's calls.
pub const EMBREE: [&str; 3] = ["embree 1", "embree 8", "embree 16"];

/// A mesh in both libraries.
#[derive(Clone, Copy)]
pub struct Pair<'a> {
    pub ours: &'a Accelerator,
    pub embree: &'a Scene<'a>,
}

impl Pair<'_> {
    /// Closest hits with the face's normal.
    fn closest(&self, rays: &[Ray], found: &mut [Found], slice: usize) {
        if slice == 1 {
            for (ray, found) in rays.iter().zip(found) {
                let (mut hit, mut corners) = ([Hit::MISS], [NO_CORNERS]);
                self.ours.closest_facets(std::slice::from_ref(ray), &mut hit, &mut corners);
                *found = self::found(&hit[0], &corners[0]);
            }
            return;
        }
        let (mut hits, mut corners) = (vec![Hit::MISS; slice], vec![NO_CORNERS; slice]);
        for (rays, found) in rays.chunks(slice).zip(found.chunks_mut(slice)) {
            let (hits, corners) = (&mut hits[..rays.len()], &mut corners[..rays.len()]);
            self.ours.closest_facets(rays, hits, corners);
            for ((hit, corners), found) in hits.iter().zip(&*corners).zip(found) {
                *found = self::found(hit, corners);
            }
        }
    }

    fn any(&self, rays: &[Ray], occluded: &mut [bool], slice: usize) {
        for (rays, occluded) in rays.chunks(slice).zip(occluded.chunks_mut(slice)) {
            self.ours.any_hits(rays, occluded);
        }
    }
}

const NO_CORNERS: [[f32; 3]; 3] = [[0.0; 3]; 3];

#[inline(always)]
fn found(hit: &Hit, corners: &[[f32; 3]; 3]) -> Found {
    if !hit.is_hit() {
        return Found::MISS;
    }
    let Hit { t, u, v, id } = *hit;
    Found { t, u, v, geometry: id.instance, primitive: id.primitive, normal: normal(corners) }
}

fn packets<const N: usize>(rays: &[Ray]) -> Vec<Rays<N>> {
    rays.chunks(N).map(Rays::new).collect()
}

fn ways(all_slices: bool) -> Vec<(String, usize)> {
    let mut ways = vec![(OURS.to_owned(), SLICE), (OURS_SINGLE.to_owned(), 1)];
    if all_slices {
        ways.extend(OTHER_SLICES.map(|slice| (format!("etendue, slices of {slice}"), slice)));
    }
    ways
}

/// Everyone who can find closest hits. Embree's packets are transposed beforehand.
pub fn closest<'a>(
    pair: Pair<'a>,
    rays: &'a [Ray],
    coherent: bool,
    clock: Clock,
    threads: usize,
    all_slices: bool,
) -> Vec<Contender<'a>> {
    let out = || RefCell::new(vec![Found::MISS; rays.len()]);
    let mut contenders = Vec::new();
    for (name, slice) in ways(all_slices) {
        let out = out();
        contenders.push(Contender::new(name, move || {
            fill(clock, threads, &mut out.borrow_mut(), |range, found| pair.closest(&rays[range], found, slice))
        }));
    }
    let (single, eight, sixteen) = (out(), out(), out());
    let (packets8, packets16) = (packets::<8>(rays), packets::<16>(rays));
    contenders.push(Contender::new(EMBREE[0], move || {
        fill(clock, threads, &mut single.borrow_mut(), |range, found| pair.embree.closest1(&rays[range], found))
    }));
    contenders.push(Contender::new(EMBREE[1], move || {
        fill(clock, threads, &mut eight.borrow_mut(), |range, found| {
            pair.embree.closest8(&packets8[range.start / 8..range.end.div_ceil(8)], found, coherent);
        })
    }));
    contenders.push(Contender::new(EMBREE[2], move || {
        fill(clock, threads, &mut sixteen.borrow_mut(), |range, found| {
            pair.embree.closest16(&packets16[range.start / 16..range.end.div_ceil(16)], found, coherent);
        })
    }));
    contenders
}

/// Everyone who can say whether anything is hit.
pub fn any<'a>(pair: Pair<'a>, rays: &'a [Ray], clock: Clock, threads: usize, all_slices: bool) -> Vec<Contender<'a>> {
    let out = || RefCell::new(vec![false; rays.len()]);
    let mut contenders = Vec::new();
    for (name, slice) in ways(all_slices) {
        let out = out();
        contenders.push(Contender::new(name, move || {
            fill(clock, threads, &mut out.borrow_mut(), |range, occluded| pair.any(&rays[range], occluded, slice))
        }));
    }
    let (single, eight, sixteen) = (out(), out(), out());
    let (packets8, packets16) = (packets::<8>(rays), packets::<16>(rays));
    contenders.push(Contender::new(EMBREE[0], move || {
        fill(clock, threads, &mut single.borrow_mut(), |range, occluded| pair.embree.any1(&rays[range], occluded))
    }));
    contenders.push(Contender::new(EMBREE[1], move || {
        fill(clock, threads, &mut eight.borrow_mut(), |range, occluded| {
            pair.embree.any8(&packets8[range.start / 8..range.end.div_ceil(8)], occluded);
        })
    }));
    contenders.push(Contender::new(EMBREE[2], move || {
        fill(clock, threads, &mut sixteen.borrow_mut(), |range, occluded| {
            pair.embree.any16(&packets16[range.start / 16..range.end.div_ceil(16)], occluded);
        })
    }));
    contenders
}

/// How far two libraries agree about the same rays.
#[derive(Clone, Copy, Debug, Default)]
pub struct Agreement {
    /// Share of rays with another face, or hit by one alone.
    pub other: f64,
    /// Largest difference of t over t, where both hit the same face.
    pub largest: f64,
    /// Share of rays that hit (ours).
    pub hits: f64,
}

/// Compares closest hits.
pub fn agreement(pair: Pair<'_>, rays: &[Ray]) -> Agreement {
    let (mut ours, mut theirs) = (vec![Found::MISS; rays.len()], vec![Found::MISS; rays.len()]);
    pair.closest(rays, &mut ours, SLICE);
    pair.embree.closest1(rays, &mut theirs);
    let mut result = Agreement::default();
    let share = 1.0 / rays.len().max(1) as f64;
    for (a, b) in ours.iter().zip(&theirs) {
        result.hits += if a.is_hit() { share } else { 0.0 };
        if a.is_hit() != b.is_hit() || a.primitive != b.primitive {
            result.other += share;
        } else if a.is_hit() {
            result.largest = result.largest.max(f64::from((a.t - b.t).abs() / a.t));
        }
    }
    result
}

/// Compares any hits: the share of rays that differ, and of those that are occluded.
pub fn any_agreement(pair: Pair<'_>, rays: &[Ray]) -> Agreement {
    let (mut ours, mut theirs) = (vec![false; rays.len()], vec![false; rays.len()]);
    pair.any(rays, &mut ours, SLICE);
    pair.embree.any1(rays, &mut theirs);
    let share = |count: usize| count as f64 / rays.len().max(1) as f64;
    Agreement {
        other: share(ours.iter().zip(&theirs).filter(|(a, b)| a != b).count()),
        largest: 0.0,
        hits: share(ours.iter().filter(|&&a| a).count()),
    }
}
