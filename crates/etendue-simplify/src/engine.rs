//! Collapses in blocks of the surface, side by side, and at the end over all of it.
//!
//! Points are numbered along a curve that fills space, so a range of them is a piece of the surface. Each piece is collapsed on
//! its own, cheapest edge first, up to a cost that is the same for all pieces; what touches other pieces waits for the
//! next round, whose pieces lie elsewhere. What is cut how depends on the mesh alone, never on the number of threads.

use std::ops::ControlFlow;

use etendue_accel::TriangleMesh;
use rayon::prelude::*;

use crate::block::{Block, Piece};
use crate::draft::keep;
use crate::faces::Faces;
use crate::metric::Metric;
use crate::queue::ALL;
use crate::report::Stopped;
use crate::vector::Vec3;
use crate::vertex::Vertex;
use crate::wedges::Wedges;
use crate::{Progress, SimplifyError, Stage};

/// A clean mesh on its way.
pub(crate) struct Work {
    pub vertices: Vec<Vertex>,
    /// See `Piece`.
    pub facing: Vec<Vec3>,
    /// See `Piece`.
    pub sources: Vec<u32>,
    pub faces: Faces,
    pub wedges: Option<Wedges>,
    /// Positions are in this unit of the input's.
    pub unit: f64,
    /// Edges of curves of the input, by its vertices: open edges, borders, seams, creases.
    pub curves: Vec<[u32; 2]>,
    /// What the surface was when it had few enough faces, if that is kept: see [`Work::keep_for`].
    pub stand_in: Option<TriangleMesh>,
    pub keep_stand_in: bool,
}

impl Work {
    /// Where a vertex is, in the input's unit.
    pub fn place(&self, v: u32) -> Vec3 {
        self.vertices[v as usize].position.map(|x| (f64::from(x) * self.unit) as f32)
    }

    /// Keeps what there is to stand for the original when distances to it are measured: with several times the faces of the
    /// target it is nearer to it by much than the result will be, and found in less time.
    fn keep_for(&mut self, target: usize) {
        let most = (STAND_IN * target).clamp(FEW, MANY).max(2 * target);
        if self.keep_stand_in && self.stand_in.is_none() && self.faces.corners.len() <= most {
            let positions: Vec<Vec3> = (0..self.vertices.len() as u32).map(|v| self.place(v)).collect();
            let indices = self.faces.corners.as_slice().into();
            self.stand_in = Some(TriangleMesh { positions: positions.into(), indices });
        }
    }
}

/// What collapsing came to.
#[derive(Default)]
pub(crate) struct Outcome {
    pub collapses: usize,
    pub refused: usize,
    pub cuts: usize,
    pub worst: f32,
    pub stopped: Option<Stopped>,
}

/// Vertices of a block: what is known of them fits into a core's cache.
const BLOCK: usize = 6144;
/// So many faces are collapsed in one piece.
const SMALL: usize = 24_000;
/// A round of blocks may leave this part of the faces.
const ROUND: f64 = 0.25;
/// A limit of costs lets so much of what is too many go, over this.
const STEPS: usize = 3;

/// Times the faces of the target that stand for the original, and the fewest and most that do; more only if the target has half of
/// them.
const STAND_IN: usize = 12;
const FEW: usize = 60_000;
const MANY: usize = 160_000;

/// Collapses until at most `target` faces are left or nothing more can be.
pub(crate) fn reduce(
    work: &mut Work,
    metric: &Metric,
    target: usize,
    progress: &mut dyn FnMut(Progress) -> ControlFlow<()>,
) -> Result<Outcome, SimplifyError> {
    let mut outcome = Outcome::default();
    let start = work.faces.corners.len();
    let target = target.min(start);
    let mut tell = |live: usize| {
        let done = (start - live) as f64 / (start.saturating_sub(target)).max(1) as f64;
        match progress(Progress { stage: Stage::Collapse, done: done.min(1.0) as f32 }) {
            ControlFlow::Continue(()) => Ok(()),
            ControlFlow::Break(()) => Err(SimplifyError::Interrupted),
        }
    };
    let enough = (target + target / 2).max(SMALL);
    let mut turn = 0;
    work.keep_for(target);
    while work.faces.corners.len() > enough + enough / 4 && turn < 64 {
        let before = work.faces.corners.len();
        round(work, metric, [enough, target], turn, &mut outcome, &mut tell)?;
        turn += 1;
        work.keep_for(target);
        if work.faces.corners.len() as f64 > 0.98 * before as f64 {
            break;
        }
    }
    work.keep_for(work.faces.corners.len());
    // An edge that is refused is asked again when all else is done: its surroundings may have changed.
    while work.faces.corners.len() > target {
        let before = work.faces.corners.len();
        let wedges = work.wedges.as_mut().map_or(&mut [][..], |wedges| &mut wedges.list);
        let mut block = Block::new(
            metric,
            Piece {
                vertices: &mut work.vertices,
                facing: &mut work.facing,
                sources: &mut work.sources,
                wedges,
                faces: std::mem::take(&mut work.faces),
            },
        );
        block.run(ALL, target, &mut tell)?;
        outcome.add(&block);
        let stuck = block.live == before;
        if stuck {
            outcome.stopped = Some(block.reasons());
        }
        work.faces = block.into_faces();
        if stuck {
            break;
        }
    }
    Ok(outcome)
}

impl Outcome {
    fn add(&mut self, block: &Block<'_>) {
        self.collapses += block.collapses;
        self.refused += block.refused;
        self.cuts += block.cuts;
        self.worst = self.worst.max(block.worst);
    }
}

/// One round of blocks.
fn round(
    work: &mut Work,
    metric: &Metric,
    [enough, target]: [usize; 2],
    turn: usize,
    outcome: &mut Outcome,
    tell: &mut dyn FnMut(usize) -> Result<(), SimplifyError>,
) -> Result<(), SimplifyError> {
    let total = work.faces.corners.len();
    // Every other round begins with half a block, so that what was at the side of one is inside of another.
    let shift = if turn.is_multiple_of(2) { 0 } else { BLOCK / 2 };
    let block_of = |v: u32| (v as usize + shift) / BLOCK;
    let blocks = work.vertices.len().saturating_sub(1).wrapping_add(shift) / BLOCK + 1;
    let first_of = |block: usize| (block * BLOCK).saturating_sub(shift);
    let faces = std::mem::take(&mut work.faces);
    let wedges = work.wedges.as_mut().map_or(&mut [][..], |wedges| &mut wedges.list);
    let first_wedges: Vec<u32> = (0..=blocks)
        .map(|block| wedges.partition_point(|wedge| (wedge.owner as usize) < first_of(block)) as u32)
        .collect();
    let [inside, outside] = sorted(&faces.corners, blocks, block_of);
    for &v in outside[0].iter().flat_map(|&face| &faces.corners[face as usize]) {
        work.vertices[v as usize].held = true;
    }
    let parts: Vec<Faces> = inside
        .into_par_iter()
        .enumerate()
        .map(|(block, list)| {
            let (first, first_wedge) = (first_of(block) as u32, first_wedges[block]);
            faces.gathered(&list, |v| v - first, |w| w - first_wedge)
        })
        .collect();
    let across = faces.gathered(&outside[0], |v| v, |w| w);
    drop(faces);
    let mut rest = work.vertices.as_mut_slice();
    let mut rest_facing = work.facing.as_mut_slice();
    let mut rest_sources = work.sources.as_mut_slice();
    let mut rest_wedges = wedges;
    let mut pieces = Vec::with_capacity(blocks);
    for (block, faces) in parts.into_iter().enumerate() {
        let len = (first_of(block + 1) - first_of(block)).min(rest.len());
        let (vertices, tail) = rest.split_at_mut(len);
        rest = tail;
        let (wedges, tail) = rest_wedges.split_at_mut((first_wedges[block + 1] - first_wedges[block]) as usize);
        rest_wedges = tail;
        let (facing, tail) = rest_facing.split_at_mut(len);
        rest_facing = tail;
        let (sources, tail) = rest_sources.split_at_mut(len);
        rest_sources = tail;
        pieces.push(Piece { vertices, facing, sources, wedges, faces });
    }
    let mut blocks: Vec<Block<'_>> = pieces.into_par_iter().map(|piece| Block::new(metric, piece)).collect();
    // What lies across and what is next to it stays in this round; the rest of the blocks should not pay for it.
    let free: usize = blocks.par_iter().map(Block::free_faces).sum();
    let goal = enough.max(total - ((1.0 - ROUND) * free as f64) as usize);
    // A limit that is too high must not take a block below what the whole may come to.
    let least = (0.4 * ROUND).max(target as f64 / total as f64);
    let floors: Vec<usize> = blocks.iter().map(|block| (block.live as f64 * least).ceil() as usize).collect();
    let live = |blocks: &[Block<'_>]| across.corners.len() + blocks.iter().map(|block| block.live).sum::<usize>();
    let mut limit = 0;
    let mut left = live(&blocks);
    while left > goal + goal / 16 {
        limit = next_limit(&blocks, &floors, limit, (left - goal) / STEPS);
        if limit == ALL {
            break;
        }
        blocks
            .par_iter_mut()
            .zip(&floors)
            .with_max_len(1)
            .try_for_each(|(block, &floor)| block.run(limit, floor, |_| Ok(())))?;
        left = live(&blocks);
        tell(left)?;
    }
    for block in &blocks {
        outcome.add(block);
    }
    let parts: Vec<Faces> = blocks.into_par_iter().map(Block::into_faces).collect();
    join(work, parts, across, first_of, &first_wedges);
    Ok(())
}

/// The faces of each block, and those whose corners are in several.
fn sorted(corners: &[[u32; 3]], blocks: usize, block_of: impl Fn(u32) -> usize + Sync) -> [Vec<Vec<u32>>; 2] {
    let places: Vec<u32> = corners
        .par_iter()
        .with_min_len(1 << 14)
        .map(|face| {
            let [a, b, c] = face.map(&block_of);
            if a == b && a == c { a as u32 } else { blocks as u32 }
        })
        .collect();
    let mut counts = vec![0usize; blocks + 1];
    for &place in &places {
        counts[place as usize] += 1;
    }
    let mut lists: Vec<Vec<u32>> = counts.into_iter().map(Vec::with_capacity).collect();
    for (face, &place) in places.iter().enumerate() {
        lists[place as usize].push(face as u32);
    }
    let across = lists.split_off(blocks);
    [lists, across]
}

/// The next limit: with the buckets of costs that hold `wanted` of the edges that wait, in blocks that may go on; [`ALL`] if
/// none wait. Small steps, because new edges that are as cheap follow.
fn next_limit(blocks: &[Block<'_>], floors: &[usize], limit: usize, wanted: usize) -> usize {
    let mut counts = vec![0usize; ALL];
    for (block, _) in blocks.iter().zip(floors).filter(|(block, floor)| block.live > **floor) {
        block.count(&mut counts);
    }
    let all: usize = counts.iter().sum();
    if all == 0 {
        return ALL;
    }
    let wanted = wanted.clamp(all.div_ceil(100), all);
    let mut sum = 0;
    let bucket = counts.iter().position(|count| {
        sum += count;
        sum >= wanted
    });
    bucket.map_or(ALL, |bucket| (bucket + 1).max(limit + 1).min(ALL))
}

/// Puts blocks together again and numbers the vertices and wedges that are left.
fn join(
    work: &mut Work,
    mut parts: Vec<Faces>,
    mut across: Faces,
    first_of: impl Fn(usize) -> usize + Sync,
    first_wedges: &[u32],
) {
    let Work { vertices, facing, sources, .. } = work;
    let is_left = |vertex: &mut Vertex| {
        vertex.held = false;
        !vertex.dead
    };
    let stays: Vec<bool> = vertices.par_iter_mut().with_min_len(1 << 12).map(is_left).collect();
    let mut count = 0;
    let new_index: Vec<u32> = stays
        .iter()
        .map(|&stays| {
            count += u32::from(stays);
            count - u32::from(stays)
        })
        .collect();
    rayon::join(
        || keep(vertices, &stays),
        || {
            keep(facing, &stays);
            keep(sources, &stays);
        },
    );
    let mut new_wedge = Vec::new();
    if let Some(wedges) = &mut work.wedges {
        let mut used = vec![false; wedges.list.len()];
        let pieces = parts.iter().zip(first_wedges.iter().copied()).chain(std::iter::once((&across, 0)));
        for (part, first) in pieces {
            for &w in part.wedges.iter().flatten().flatten() {
                used[(w + first) as usize] = true;
            }
        }
        let mut count = 0;
        new_wedge.extend(used.iter().map(|&used| {
            count += u32::from(used);
            count.wrapping_sub(1)
        }));
        let mut next = 0;
        wedges.list.retain_mut(|wedge| {
            wedge.owner = new_index[wedge.owner as usize];
            next += 1;
            used[next - 1]
        });
    }
    let mut faces = across.none_like();
    faces.corners.reserve_exact(parts.iter().map(|part| part.corners.len()).sum::<usize>() + across.corners.len());
    let named = |part: &mut Faces, vertex: u32, wedge: u32| {
        part.rename(|v| new_index[(v + vertex) as usize], |w| new_wedge[(w + wedge) as usize]);
    };
    parts.par_iter_mut().enumerate().for_each(|(block, part)| {
        named(part, first_of(block) as u32, first_wedges[block]);
    });
    named(&mut across, 0, 0);
    for part in parts.into_iter().chain(std::iter::once(across)) {
        faces.append(part);
    }
    work.faces = faces;
}
