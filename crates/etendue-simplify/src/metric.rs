//! What is measured: the options that decide about costs.

use etendue_accel::Isa;

use crate::cost::Rule;
use crate::quadric::Quadric;
use crate::vector::{Vec3, add, area_normal, dot};
use crate::vertex::{Kind, Vertex};
use crate::{Method, Options, Placement};

/// Standard deviation of positions over the local edge length where the options do not say. Measured: see
/// docs/simplify.md.
pub const SIGMA: f64 = 0.0001;
/// By how much of the local edge length vertices are perturbed.
const PERTURBATION: f32 = 0.01;

/// How costs are computed.
#[derive(Clone, Debug)]
pub(crate) struct Metric {
    pub method: Method,
    /// Where the vertex of two free ends goes.
    pub rule: Rule,
    /// Of the uncertainty of normals.
    variance: f32,
    perturbed: Option<u64>,
    /// True if handles are not cut.
    pub keep_topology: bool,
    /// True if edges are ranked by the mean distance: larger in sum, without the polish smaller where it is largest.
    pub by_mean: bool,
    pub isa: Isa,
}

/// A number in \[-1, 1) from a seed and two counters.
fn noise(seed: u64, a: u32, b: u32) -> f32 {
    let mut z = seed ^ (u64::from(a) << 32 | u64::from(b));
    // SplitMix64's finaliser (Steele, Lea and Flood 2014).
    z = z.wrapping_add(0x9e37_79b9_7f4a_7c15);
    z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^= z >> 31;
    (z >> 40) as f32 * (1.0 / 8_388_608.0) - 1.0
}

impl Metric {
    pub fn new(options: &Options) -> Self {
        let shortest = options.method == Method::ShortestEdge;
        let (rule, sigma, perturbed) = match options.placement {
            Placement::Auto if shortest => (Rule::Middle, SIGMA, None),
            Placement::Auto => (Rule::Anywhere, SIGMA, None),
            Placement::Probabilistic { sigma } => (Rule::Anywhere, sigma, None),
            Placement::Perturbed => (Rule::Anywhere, 0.0, Some(options.seed)),
            Placement::Endpoint => (Rule::Ends, SIGMA, None),
            Placement::Midpoint => (Rule::Middle, SIGMA, None),
        };
        Self {
            method: options.method,
            rule,
            variance: (sigma * sigma) as f32,
            perturbed,
            keep_topology: options.keep_topology,
            by_mean: options.fast,
            isa: Isa::detect(),
        }
    }

    /// The quadric of a face relative to `origin`.
    #[inline(always)]
    pub fn face(&self, face: [u32; 3], positions: &[Vec3], origin: Vec3) -> Quadric {
        let corners = face.map(|v| positions[v as usize]);
        self.triangle(face, corners, origin)
    }

    /// The same from corners and their names.
    #[inline(always)]
    pub fn triangle(&self, names: [u32; 3], mut corners: [Vec3; 3], origin: Vec3) -> Quadric {
        if let Some(seed) = self.perturbed {
            let normal = area_normal(corners[0], corners[1], corners[2]);
            let size = dot(normal, normal).sqrt().sqrt() * PERTURBATION;
            for (corner, name) in corners.iter_mut().zip(names) {
                *corner = add(*corner, [0, 1, 2].map(|axis| noise(seed, name, axis) * size));
            }
        }
        Quadric::triangle(corners, origin, self.variance)
    }

    /// The rule for an edge between vertices, or none if it stays.
    #[inline(always)]
    pub fn rule(&self, first: &Vertex, second: &Vertex) -> Option<Rule> {
        match (first.kind, second.kind) {
            (Kind::Fixed, Kind::Fixed) => None,
            (Kind::Free, Kind::Free) | (Kind::Curve, Kind::Curve) => Some(self.rule),
            (a, b) if a < b => Some(Rule::Second),
            _ => Some(Rule::First),
        }
    }
}
