//! Choice among many lights by what each may bring to a point: a tree of clusters, eight children a node.
//!
//! After Conty Estevez and Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (2018). A cluster knows its
//! power, a sphere about it and a cone about the normals of its lights. With d the distance of the sphere's centre, t_c the angle
//! under which the sphere's radius r is seen, t_n the angle between the cone's axis and the direction to the point, less the
//! cone's and t_c, and t_i that between the point's normal and the direction to the centre, less t_c, its importance is
//!
//! `power cos(t_n) cos(t_i) / max(d^2, (r / 2)^2)`.
//!
//! Both cosines are upper bounds for all that the cluster holds, raised by [`SLACK`] for rounding: importance is 0 only where
//! nothing arrives. From the root down a child is chosen in proportion to its importance until it is a light. The children
//! of a node are eight lanes of the same arithmetic, and a million lights are seven levels deep.

mod build;

use super::{LightContext, between};
use crate::{math::Vec3, medium::Segment};
use build::Cluster;
pub(super) use build::Source;

/// Children of a node.
const WIDE: usize = 8;
/// What is added to cosines that bound others.
const SLACK: f32 = 1e-3;
/// Importance of what may bring anything at all is at least this.
const LEAST: f32 = 1e-36;
/// Square of the radius that distances are not taken to be below, over that of the cluster.
const NEAR: f32 = 0.25;

/// In a child's word: it is a light, and the rest is its index. Else the index of a node.
const IS_LIGHT: u32 = 1 << 31;
/// The index in a child's word.
const INDEX: u32 = IS_LIGHT - 1;

/// Most lights of a tree: so many are numbered by 31 bits.
pub(super) const MAX_SOURCES: usize = 1 << 30;
/// Three bits for each level in a word of 64.
const MAX_LEVELS: usize = 21;
/// The trail of what is not in the tree.
const NO_TRAIL: u64 = u64::MAX;

/// The clusters below a node: lane i of every array is child i; those that are not there have no power.
#[repr(C, align(32))]
#[derive(Clone, Debug)]
pub(in crate::light) struct Node {
    x: [f32; WIDE],
    y: [f32; WIDE],
    z: [f32; WIDE],
    radius: [f32; WIDE],
    axis_x: [f32; WIDE],
    axis_y: [f32; WIDE],
    axis_z: [f32; WIDE],
    /// Cosine and sine of the cone of normals.
    cos_spread: [f32; WIDE],
    sin_spread: [f32; WIDE],
    /// Cosines from a normal up to which light is sent.
    cos_beyond: [f32; WIDE],
    /// 1 where lights of the cluster shine from both sides, -1 where none does.
    fold: [f32; WIDE],
    /// Over that of all lights.
    power: [f32; WIDE],
    child: [u32; WIDE],
}

impl Node {
    const EMPTY: Self = Self {
        x: [0.0; WIDE],
        y: [0.0; WIDE],
        z: [0.0; WIDE],
        radius: [0.0; WIDE],
        axis_x: [0.0; WIDE],
        axis_y: [0.0; WIDE],
        axis_z: [0.0; WIDE],
        cos_spread: [0.0; WIDE],
        sin_spread: [0.0; WIDE],
        cos_beyond: [0.0; WIDE],
        fold: [0.0; WIDE],
        power: [0.0; WIDE],
        child: [0; WIDE],
    };

    fn set(&mut self, lane: usize, cluster: &Cluster, child: u32) {
        [self.x[lane], self.y[lane], self.z[lane]] = cluster.center.to_array();
        [self.axis_x[lane], self.axis_y[lane], self.axis_z[lane]] = cluster.axis.to_array();
        self.radius[lane] = cluster.radius;
        self.cos_spread[lane] = libm::cosf(cluster.spread);
        self.sin_spread[lane] = libm::sinf(cluster.spread).max(0.0);
        self.cos_beyond[lane] = libm::cosf(cluster.beyond) - SLACK;
        self.power[lane] = cluster.power;
        self.fold[lane] = fold(cluster.two_sided);
        self.child[lane] = child;
    }
}

/// What gathers light, and how much of a cluster may come to it.
pub(super) trait Gathers {
    /// Of each child, above 0 wherever it can bring anything.
    fn importance(&self, node: &Node) -> [f32; WIDE];
}

/// What the negative of a cosine is multiplied by before the larger of the two counts.
#[inline]
fn fold(both_sides: bool) -> f32 {
    if both_sides { 1.0 } else { -1.0 }
}

/// Cosine of a - b, two angles in [0, pi]; 1 if b is the larger.
#[inline(always)]
fn cos_less(cos_a: f32, cos_b: f32, sin_b: f32) -> f32 {
    let cos_a = cos_a.min(cos_b);
    cos_a * cos_b + (1.0 - cos_a * cos_a).max(0.0).sqrt() * sin_b
}

#[inline(always)]
fn one_if(holds: bool) -> f32 {
    if holds { 1.0 } else { 0.0 }
}

impl Gathers for LightContext {
    #[inline(always)]
    fn importance(&self, node: &Node) -> [f32; WIDE] {
        let (p, n, both_sides) = (self.point, self.normal, fold(self.transmits));
        // The least that the point's own cosine is taken to be.
        let least = one_if(n == Vec3::ZERO);
        let mut importance = [0.0; WIDE];
        // No branches, so that this becomes vector code.
        for (i, importance) in importance.iter_mut().enumerate() {
            let (x, y, z) = (node.x[i] - p.x, node.y[i] - p.y, node.z[i] - p.z);
            let squared = x * x + y * y + z * z;
            let reach = node.radius[i] * node.radius[i];
            let inverse = 1.0 / squared.max(1e-30).sqrt();
            let sin = (node.radius[i] * inverse).min(1.0);
            let cos = (1.0 - sin * sin).max(0.0).sqrt();
            let within = squared <= reach;
            let (cos_c, sin_c) = (if within { -1.0 } else { cos }, if within { 0.0 } else { sin });
            // The cone of normals and that of directions together.
            let (cos_s, sin_s) = (node.cos_spread[i], node.sin_spread[i]);
            let sin_b = cos_s * sin_c + sin_s * cos_c;
            let cos_b = if within | (sin_b < 0.0) { -1.0 } else { cos_s * cos_c - sin_s * sin_c };
            let along = -(node.axis_x[i] * x + node.axis_y[i] * y + node.axis_z[i] * z) * inverse;
            let sent = cos_less(along.max(-along * node.fold[i]).clamp(-1.0, 1.0), cos_b, sin_b.max(0.0));
            let up = (n.x * x + n.y * y + n.z * z) * inverse;
            let taken = cos_less(up.max(-up * both_sides).clamp(-1.0, 1.0), cos_c, sin_c) + SLACK;
            let taken = taken.max(least);
            let value = node.power[i] * (sent + SLACK) * taken / squared.max(reach * NEAR).max(1e-30);
            let counts = one_if(sent > node.cos_beyond[i]) * one_if(taken > 0.0) * one_if(node.power[i] > 0.0);
            *importance = value.max(LEAST) * counts;
        }
        importance
    }
}

/// A segment of a ray through a medium, for distances about a light: what comes to all of it goes with the inverse distance.
impl Gathers for Segment {
    #[inline(always)]
    fn importance(&self, node: &Node) -> [f32; WIDE] {
        let (p, d) = (self.origin, self.direction);
        let mut importance = [0.0; WIDE];
        for (i, importance) in importance.iter_mut().enumerate() {
            let (x, y, z) = (node.x[i] - p.x, node.y[i] - p.y, node.z[i] - p.z);
            let t = (x * d.x + y * d.y + z * d.z).max(0.0).min(self.length);
            let (x, y, z) = (x - d.x * t, y - d.y * t, z - d.z * t);
            let squared = x * x + y * y + z * z;
            let reach = node.radius[i] * node.radius[i];
            let value = node.power[i] / squared.max(reach * NEAR).max(1e-30).sqrt();
            *importance = value.max(LEAST) * one_if(node.power[i] > 0.0);
        }
        importance
    }
}

/// The sums of the first one, the first two, and so on, of all.
#[inline(always)]
fn sums(importance: &[f32; WIDE]) -> [f64; WIDE] {
    let (mut sums, mut sum) = ([0.0; WIDE], 0.0);
    for i in 0..WIDE {
        sum += f64::from(importance[i]);
        sums[i] = sum;
    }
    sums
}

/// A light that was chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Selected {
    /// The light's index.
    pub index: u32,
    /// Probability of the choice, above 0.
    pub probability: f32,
}

/// Lights at some place, with power.
#[derive(Clone, Debug, Default)]
pub(super) struct LightTree {
    nodes: Vec<Node>,
    /// Of each light of the table, the children that lead to it from the root, three bits each from the lowest;
    /// [`NO_TRAIL`] where it is not in the tree.
    trails: Box<[u64]>,
    /// The only light, which is chosen always.
    only: Option<u32>,
}

impl LightTree {
    /// True if there is nothing to choose.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// True if some children are not lights.
    pub fn has_clusters(&self) -> bool {
        self.nodes.len() > 1
    }

    /// True if light `index` is in the tree.
    #[inline]
    pub fn holds(&self, index: u32) -> bool {
        self.trails.get(index as usize).is_some_and(|trail| *trail != NO_TRAIL)
    }

    /// The light that is chosen whatever gathers, if there is no other.
    #[inline]
    pub fn only(&self) -> Option<u32> {
        self.only
    }

    /// The light for `u` in [0, 1); `None` where none can bring anything. Inlined, so that kernels have it for their instruction
    /// set.
    #[inline(always)]
    pub fn select(&self, gathers: &impl Gathers, u: f64) -> Option<Selected> {
        if let Some(index) = self.only {
            return Some(Selected { index, probability: 1.0 });
        }
        let mut node = self.nodes.first()?;
        let (mut u, mut probability) = (u, 1.0f32);
        loop {
            let importance = gathers.importance(node);
            let sums = sums(&importance);
            let total = sums[WIDE - 1];
            if !(total > 0.0 && total < f64::from(f32::MAX)) {
                return None;
            }
            // Below the total, so the child is one of those that are important.
            let target = u * total;
            let lane = sums.iter().map(|sum| usize::from(target >= *sum)).sum::<usize>().min(WIDE - 1);
            let before = if lane == 0 { 0.0 } else { sums[lane - 1] };
            u = between((target - before) / f64::from(importance[lane]), 0.0, BELOW_ONE);
            probability *= importance[lane] / total as f32;
            let word = node.child[lane];
            let index = word & INDEX;
            if word & IS_LIGHT != 0 {
                return (probability > 0.0).then_some(Selected { index, probability });
            }
            node = &self.nodes[index as usize];
        }
    }

    /// Probability that [`Self::select`] chooses light `index`.
    #[inline]
    pub fn probability(&self, gathers: &impl Gathers, index: u32) -> f32 {
        let Some(&(mut trail)) = self.trails.get(index as usize).filter(|trail| **trail != NO_TRAIL) else {
            return 0.0;
        };
        if self.only.is_some() {
            return 1.0;
        }
        let Some(mut node) = self.nodes.first() else { return 0.0 };
        let mut probability = 1.0;
        loop {
            let importance = gathers.importance(node);
            let total = sums(&importance)[WIDE - 1];
            let lane = (trail & 7) as usize;
            // Also where the sum is no number.
            if !(importance[lane] > 0.0 && total < f64::from(f32::MAX)) {
                return 0.0;
            }
            probability *= importance[lane] / total as f32;
            let word = node.child[lane];
            if word & IS_LIGHT != 0 {
                return probability;
            }
            trail >>= 3;
            node = &self.nodes[(word & INDEX) as usize];
        }
    }
}

/// Largest number below 1.
const BELOW_ONE: f64 = 1.0 - f64::EPSILON / 2.0;
