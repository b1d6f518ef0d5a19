//! Building the tree of lights, from the top: clusters are split in two by the surface-area-orientation heuristic until a node has
//! eight children.

use super::{INDEX, IS_LIGHT, LightTree, MAX_LEVELS, NO_TRAIL, Node, WIDE};
use crate::{light::extent::Extent, math::Vec3};
use rayon::prelude::*;
use std::f32::consts::{FRAC_PI_2, PI};

/// Bins along an axis in which a cut is looked for.
const BINS: usize = 16;
/// Lights of a part that a cut is looked for by, at least, if it has so many.
const SAMPLED: usize = 1 << 12;
/// Levels from which lights are dealt out in equal numbers, so that the depth has a bound.
const BALANCED_FROM: usize = 11;
/// Lights from which the two sides of a cut are built side by side.
const PARALLEL_FROM: usize = 1 << 13;

/// A light for the tree.
#[derive(Clone, Copy, Debug)]
pub(in crate::light) struct Source {
    /// Its index in the table.
    pub index: u32,
    /// Over that of all lights, above 0.
    pub power: f32,
    pub extent: Extent,
}

/// What a node knows of a child.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cluster {
    low: Vec3,
    high: Vec3,
    pub center: Vec3,
    pub radius: f32,
    pub axis: Vec3,
    /// Radians, as in [`Extent`].
    pub spread: f32,
    pub beyond: f32,
    pub two_sided: bool,
    pub power: f32,
}

impl Cluster {
    fn of(source: &Source) -> Self {
        let Extent { low, high, axis, spread, beyond, two_sided } = source.extent;
        Self::boxed(low, high, axis, spread, beyond, two_sided, source.power)
    }

    fn boxed(low: Vec3, high: Vec3, axis: Vec3, spread: f32, beyond: f32, two_sided: bool, power: f32) -> Self {
        let center = low * 0.5 + high * 0.5;
        let extent = (high - center).abs().max((center - low).abs());
        // A little more, for the rounding of lights and points.
        let radius = extent.length() * (1.0 + 1e-5) + 1e-6 * center.abs().max_element();
        Self { low, high, center, radius, axis, spread, beyond, two_sided, power }
    }

    /// About all of `parts`, which are at least one.
    fn about(parts: &[Self]) -> Self {
        let two_sided = parts.iter().any(|part| part.two_sided);
        let low = parts.iter().fold(Vec3::INFINITY, |low, part| low.min(part.low));
        let high = parts.iter().fold(Vec3::NEG_INFINITY, |high, part| high.max(part.high));
        let beyond = parts.iter().fold(0.0f32, |most, part| most.max(part.beyond));
        let power = parts.iter().fold(0.0f32, |sum, part| sum + part.power);
        let (axis, spread) = cone(parts, two_sided);
        Self::boxed(low, high, axis, spread, beyond, two_sided, power)
    }
}

/// A cone about the cones of `parts`; if `two_sided`, about one of each two opposite directions.
fn cone(parts: &[Cluster], two_sided: bool) -> (Vec3, f32) {
    if let [only] = parts {
        return (only.axis, only.spread);
    }
    let first = parts.iter().find(|part| part.spread < PI).map_or(Vec3::Z, |part| part.axis);
    let turned = |part: &Cluster| if two_sided && part.axis.dot(first) < 0.0 { -part.axis } else { part.axis };
    let sum = parts.iter().fold(Vec3::ZERO, |sum, part| sum + turned(part) * part.power);
    let Some(axis) = sum.try_normalize() else { return (Vec3::Z, PI) };
    let spread = |part: &Cluster| libm::acosf(turned(part).dot(axis).clamp(-1.0, 1.0)) + part.spread;
    let most = parts.iter().fold(0.0f32, |most, part| most.max(spread(part)));
    // Beyond a right angle the two cones of opposite directions are all there is.
    if most >= if two_sided { FRAC_PI_2 } else { PI } { (axis, PI) } else { (axis, most) }
}

/// What the cost of a cut needs to know of lights: bounds, power, and how their normals spread.
#[derive(Clone, Copy)]
struct Sum {
    low: Vec3,
    high: Vec3,
    axes: Vec3,
    power: f32,
    count: usize,
}

impl Sum {
    const NONE: Self = Self { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, axes: Vec3::ZERO, power: 0.0, count: 0 };

    fn add(&mut self, source: &Source) {
        let Extent { low, high, axis, spread, .. } = source.extent;
        self.low = self.low.min(low);
        self.high = self.high.max(high);
        self.axes += axis * (if spread < FRAC_PI_2 { source.power } else { 0.0 });
        self.power += source.power;
        self.count += 1;
    }

    fn join(&self, other: &Self) -> Self {
        Self {
            low: self.low.min(other.low),
            high: self.high.max(other.high),
            axes: self.axes + other.axes,
            power: self.power + other.power,
            count: self.count + other.count,
        }
    }

    /// Power times area times a measure of the normals' spread, from 1 for a plane to 3.
    fn cost(&self) -> f32 {
        if self.count == 0 {
            return 0.0;
        }
        let d = self.high - self.low;
        let area = d.x * d.y + d.y * d.z + d.z * d.x + 1e-4 * d.length_squared();
        let even = (self.axes.length() / self.power.max(f32::MIN_POSITIVE)).min(1.0);
        self.power * area * (3.0 - 2.0 * even)
    }
}

/// The two sides of the best cut of at least two lights: the number of those on the first side, to which `sources` are put in
/// order. `balanced` asks for halves.
fn cut(sources: &mut [Source], balanced: bool) -> usize {
    let (low, high) = sources.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), source| {
        (low.min(source.extent.middle()), high.max(source.extent.middle()))
    });
    let size = high - low;
    let middle = sources.len() / 2;
    let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
    if balanced || !(size[axis] > 0.0 && size[axis].is_finite()) {
        if size[axis] > 0.0 {
            let key = |source: &Source| (source.extent.middle()[axis], source.index);
            sources.select_nth_unstable_by(middle, |a, b| key(a).0.total_cmp(&key(b).0).then(key(a).1.cmp(&key(b).1)));
        }
        return middle;
    }
    let Some((axis, edge)) = best_cut(sources, low, size) else { return middle };
    let bin = |source: &Source| bin_of(source, axis, low, size);
    partition(sources, |source| bin(source) < edge)
}

fn bin_of(source: &Source, axis: usize, low: Vec3, size: Vec3) -> usize {
    (((source.extent.middle()[axis] - low[axis]) / size[axis] * BINS as f32) as usize).min(BINS - 1)
}

/// The axis and the first bin of the second side.
fn best_cut(sources: &[Source], low: Vec3, size: Vec3) -> Option<(usize, usize)> {
    let mut bins = [[Sum::NONE; BINS]; 3];
    let longest = size.max_element();
    // Along short axes a cut leaves clusters as long as they were.
    let tried = [0, 1, 2].map(|axis| size[axis] > 0.02 * longest);
    // Of very many lights some tell where to cut.
    for source in sources.iter().step_by((sources.len() / SAMPLED).max(1)) {
        for axis in (0..3).filter(|axis| tried[*axis]) {
            bins[axis][bin_of(source, axis, low, size)].add(source);
        }
    }
    let mut best: Option<(f32, usize, usize)> = None;
    for axis in (0..3).filter(|axis| tried[*axis]) {
        let mut above = [Sum::NONE; BINS];
        let mut sum = Sum::NONE;
        for i in (1..BINS).rev() {
            sum = sum.join(&bins[axis][i]);
            above[i] = sum;
        }
        let mut below = Sum::NONE;
        for edge in 1..BINS {
            below = below.join(&bins[axis][edge - 1]);
            if below.count == 0 || above[edge].count == 0 {
                continue;
            }
            let cost = (below.cost() + above[edge].cost()) * (longest / size[axis]);
            if best.is_none_or(|(least, ..)| cost < least) {
                best = Some((cost, axis, edge));
            }
        }
    }
    best.map(|(_, axis, edge)| (axis, edge))
}

/// Puts what `is_first` to the front, in an order that depends on `sources` alone; the number of them.
fn partition(sources: &mut [Source], is_first: impl Fn(&Source) -> bool) -> usize {
    let (mut from, mut to) = (0, sources.len());
    loop {
        while from < to && is_first(&sources[from]) {
            from += 1;
        }
        while from < to && !is_first(&sources[to - 1]) {
            to -= 1;
        }
        if from >= to {
            return from;
        }
        sources.swap(from, to - 1);
    }
}

/// Ranges of `sources`, at most [`WIDE`], not empty, for the children of a node.
fn children(sources: &mut [Source], level: usize) -> Vec<&mut [Source]> {
    let balanced = level >= BALANCED_FROM;
    let mut parts = vec![sources];
    while parts.len() < WIDE {
        // The part with the most lights: levels stay few.
        let Some(most) = (0..parts.len()).filter(|i| parts[*i].len() > 1).max_by_key(|i| parts[*i].len()) else {
            break;
        };
        let part = parts.swap_remove(most);
        let at = cut(part, balanced);
        let (first, second) = part.split_at_mut(at);
        parts.extend([first, second]);
    }
    parts
}

/// A subtree: its nodes, numbered from 0, the first the root; and what is below.
struct Built {
    nodes: Vec<Node>,
    cluster: Cluster,
}

fn build(sources: &mut [Source], level: usize, trail: u64) -> (Built, Vec<(u32, u64)>) {
    let parallel = sources.len() >= PARALLEL_FROM;
    let parts = children(sources, level);
    let below = |(lane, part): (usize, &mut [Source])| {
        let trail = trail | (lane as u64) << (3 * level);
        match part {
            [only] => (Built { nodes: Vec::new(), cluster: Cluster::of(only) }, vec![(only.index, trail)]),
            many => build(many, level + 1, trail),
        }
    };
    let parts: Vec<(usize, &mut [Source])> = parts.into_iter().enumerate().collect();
    let built: Vec<_> = if parallel { in_parallel(parts, &below) } else { parts.into_iter().map(below).collect() };
    let mut node = Node::EMPTY;
    let mut nodes = vec![Node::EMPTY];
    let mut trails = Vec::new();
    let mut clusters = Vec::with_capacity(WIDE);
    for (lane, (child, mut own)) in built.into_iter().enumerate() {
        let word = match own[..] {
            [(index, _)] if child.nodes.is_empty() => index | IS_LIGHT,
            _ => nodes.len() as u32,
        };
        node.set(lane, &child.cluster, word);
        clusters.push(child.cluster);
        let offset = nodes.len() as u32;
        nodes.extend(child.nodes.into_iter().map(|node| node.moved(offset)));
        trails.append(&mut own);
    }
    nodes[0] = node;
    (Built { nodes, cluster: Cluster::about(&clusters) }, trails)
}

fn in_parallel<'a, T: Send>(
    parts: Vec<(usize, &'a mut [Source])>,
    below: &(impl Fn((usize, &'a mut [Source])) -> T + Sync),
) -> Vec<T> {
    parts.into_par_iter().map(below).collect()
}

impl Node {
    /// Where nodes before it are `offset` more.
    fn moved(mut self, offset: u32) -> Self {
        for (child, power) in self.child.iter_mut().zip(self.power) {
            if *child & IS_LIGHT == 0 && power > 0.0 {
                *child += offset;
            }
        }
        self
    }
}

impl LightTree {
    /// A tree of `sources`, at most [`MAX_SOURCES`](super::MAX_SOURCES), out of a table of `count` lights. The same on any number of threads.
    pub fn new(mut sources: Vec<Source>, count: usize) -> Self {
        debug_assert!(sources.iter().all(|source| source.power > 0.0 && source.index <= INDEX));
        if sources.is_empty() {
            return Self::default();
        }
        let only = if let [only] = sources[..] { Some(only.index) } else { None };
        let (built, own) = build(&mut sources, 0, 0);
        let mut trails = vec![NO_TRAIL; count].into_boxed_slice();
        for (index, trail) in own {
            trails[index as usize] = trail;
        }
        Self { nodes: built.nodes, trails, only }
    }
}

/// Lights below level 11 are dealt out evenly: 2^30 of them take 10 levels.
const _: () = assert!(BALANCED_FROM + 10 <= MAX_LEVELS);
