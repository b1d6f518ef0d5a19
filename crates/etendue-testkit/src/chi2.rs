//! Chi-square tests of samplers against their densities.
//!
//! ```
//! use etendue_testkit::chi2::ChiSquare;
//! // Cosine-distributed directions about +z.
//! let sample = |rng: &mut etendue_testkit::Rng| {
//!     let (u, turns) = (rng.f64(), rng.f64());
//!     let (sin, cos) = (std::f64::consts::TAU * turns).sin_cos();
//!     Some([u.sqrt() * cos, u.sqrt() * sin, (1.0 - u).sqrt()])
//! };
//! let pdf = |w: [f64; 3]| w[2].max(0.0) / std::f64::consts::PI;
//! ChiSquare::new(100_000).sphere(sample, pdf).assert(0.01, 1, "cosine");
//! ```
//!
//! Cells are halved where a pilot run of the sampler finds many samples, so a narrow lobe is resolved wherever it points;
//! the test itself uses fresh samples. The density is integrated over every cell by adaptive cubature. Cells that expect
//! fewer than five samples are pooled.

use std::f64::consts::{PI, TAU};
use std::fmt;

use crate::Rng;
use crate::quadrature::{Cell, integrate_1d, integrate_2d};
use crate::special::{chi2_upper, sidak};

/// What a sampler gave. Closures may return `Option<P>` instead, `None` meaning [`Drawn::Nothing`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Drawn<P> {
    /// A point that the density describes.
    Point(P),
    /// The outcome with this index of a discrete set (see [`ChiSquare::discrete`]).
    Discrete(usize),
    /// The sampler failed, as it may with the probability that the density leaves over.
    Nothing,
}

impl<P> From<Option<P>> for Drawn<P> {
    fn from(point: Option<P>) -> Self {
        point.map_or(Self::Nothing, Self::Point)
    }
}

/// Fewest samples a cell may expect (Cochran, "Some Methods for Strengthening the Common chi^2 Tests", 1954).
const MIN_EXPECTED: f64 = 5.0;
/// Error of a cell's integral, in standard deviations of its count.
const CUBATURE_ERROR: f64 = 0.03;
/// Most halvings of a cell along both axes together.
const MAX_SPLITS: u32 = 40;

/// A chi-square test to be run: how many samples, how many cells, which seed.
#[derive(Clone, Debug)]
pub struct ChiSquare {
    samples: u64,
    cells: usize,
    seed: u64,
    discrete: Vec<f64>,
    mass_tolerance: f64,
    stray_fraction: f64,
    pieces: usize,
}

impl ChiSquare {
    /// A test of `samples` samples with about 400 cells. A density that is wrong by a relative root mean square of `e`
    /// is found when samples * e^2 is well above 60.
    pub fn new(samples: u64) -> Self {
        Self {
            samples,
            cells: 400,
            seed: 1,
            discrete: Vec::new(),
            mass_tolerance: 1e-3,
            stray_fraction: 1e-5,
            pieces: 1,
        }
    }

    /// About how many cells of equal probability.
    pub fn cells(self, cells: usize) -> Self {
        Self { cells: cells.max(2), ..self }
    }

    /// Into how many pieces a side cells are cut before the density is integrated over them: more than 1 for a density that jumps, of
    /// which the cubature may miss a corner.
    pub fn pieces(self, pieces: usize) -> Self {
        Self { pieces: pieces.max(1), ..self }
    }

    /// Seed of the random numbers.
    pub fn seed(self, seed: u64) -> Self {
        Self { seed, ..self }
    }

    /// Probabilities of the discrete outcomes; those come on top of the density.
    pub fn discrete(self, probabilities: &[f64]) -> Self {
        Self { discrete: probabilities.to_vec(), ..self }
    }

    /// How far the density's integral, the discrete masses and the share of failures may be from 1 together, beyond
    /// the scatter of the failures. 0.001 unless set.
    pub fn mass_tolerance(self, mass_tolerance: f64) -> Self {
        Self { mass_tolerance, ..self }
    }

    /// The share of samples that may fall where the density is zero, because of rounding at borders. 1e-5 unless set
    /// (and two samples in any case).
    pub fn stray_fraction(self, stray_fraction: f64) -> Self {
        Self { stray_fraction, ..self }
    }

    /// Unit vectors over the whole sphere, `pdf` per solid angle.
    pub fn sphere<D: Into<Drawn<[f64; 3]>>>(
        &self,
        sample: impl FnMut(&mut Rng) -> D,
        pdf: impl Fn([f64; 3]) -> f64,
    ) -> Outcome {
        self.directions(PI, sample, pdf)
    }

    /// Unit vectors with z >= 0, `pdf` per solid angle; others count as outside.
    pub fn hemisphere<D: Into<Drawn<[f64; 3]>>>(
        &self,
        sample: impl FnMut(&mut Rng) -> D,
        pdf: impl Fn([f64; 3]) -> f64,
    ) -> Outcome {
        self.directions(0.5 * PI, sample, pdf)
    }

    /// Points of the unit square.
    pub fn square<D: Into<Drawn<[f64; 2]>>>(
        &self,
        sample: impl FnMut(&mut Rng) -> D,
        pdf: impl Fn([f64; 2]) -> f64,
    ) -> Outcome {
        self.rectangle([0.0, 1.0], [0.0, 1.0], sample, pdf)
    }

    /// Points with x and y in the given ranges, `pdf` per area.
    pub fn rectangle<D: Into<Drawn<[f64; 2]>>>(
        &self,
        x: [f64; 2],
        y: [f64; 2],
        mut sample: impl FnMut(&mut Rng) -> D,
        pdf: impl Fn([f64; 2]) -> f64,
    ) -> Outcome {
        let domain = Cell { low: [x[0], y[0]], high: [x[1], y[1]] };
        self.run(domain, 2, |rng| sample(rng).into(), pdf)
    }

    /// Numbers in `range`, `pdf` per length.
    pub fn interval<D: Into<Drawn<f64>>>(
        &self,
        range: [f64; 2],
        mut sample: impl FnMut(&mut Rng) -> D,
        pdf: impl Fn(f64) -> f64,
    ) -> Outcome {
        let domain = Cell { low: [range[0], 0.0], high: [range[1], 1.0] };
        let place = |x| [x, 0.5];
        self.run(domain, 1, |rng| map_point(sample(rng).into(), place), |[x, _]| pdf(x))
    }

    /// Indices, each with its probability; what is left to 1 is the probability of failure.
    pub fn indices<D: Into<Drawn<usize>>>(
        &self,
        probabilities: &[f64],
        mut sample: impl FnMut(&mut Rng) -> D,
    ) -> Outcome {
        let domain = Cell { low: [0.0; 2], high: [1.0; 2] };
        let discrete = |rng: &mut Rng| match sample(rng).into() {
            Drawn::Point(i) | Drawn::Discrete(i) => Drawn::Discrete(i),
            Drawn::Nothing => Drawn::Nothing,
        };
        self.clone().discrete(probabilities).run(domain, 0, discrete, |_| 0.0)
    }

    fn directions<D: Into<Drawn<[f64; 3]>>>(
        &self,
        max_theta: f64,
        mut sample: impl FnMut(&mut Rng) -> D,
        pdf: impl Fn([f64; 3]) -> f64,
    ) -> Outcome {
        let domain = Cell { low: [0.0, 0.0], high: [max_theta, TAU] };
        let density = |[theta, phi]: [f64; 2]| {
            let ((sin_theta, cos_theta), (sin_phi, cos_phi)) = (theta.sin_cos(), phi.sin_cos());
            pdf([sin_theta * cos_phi, sin_theta * sin_phi, cos_theta]) * sin_theta
        };
        self.run(domain, 2, |rng| map_point(sample(rng).into(), polar), density)
    }

    fn run(
        &self,
        domain: Cell,
        axes: usize,
        mut sample: impl FnMut(&mut Rng) -> Drawn<[f64; 2]>,
        density: impl Fn([f64; 2]) -> f64,
    ) -> Outcome {
        let mut rng = Rng::new(self.seed);
        let partition = if axes == 0 {
            Partition { domain, nodes: Vec::new(), leaves: Vec::new() }
        } else {
            let pilots: Vec<[f64; 2]> = (0..(32 * self.cells as u64).min(self.samples))
                .filter_map(|_| match sample(&mut rng) {
                    Drawn::Point(p) if within(p, domain) => Some(p),
                    _ => None,
                })
                .collect();
            Partition::new(domain, axes, pilots, self.cells)
        };
        let n = self.samples as f64;
        let mut bins: Vec<Bin> = partition
            .leaves
            .iter()
            .map(|&(cell, pilot_share)| {
                let tolerance = CUBATURE_ERROR * (pilot_share.max(1.0 / n) / n).sqrt();
                let mass = if axes == 1 {
                    integrate_1d(|x| density([x, 0.5]), [cell.low[0], cell.high[0]], self.pieces, tolerance)
                } else {
                    integrate_2d(&density, cell.low, cell.high, self.pieces, tolerance)
                };
                Bin { place: Place::Cell(cell), expected: mass * n, observed: 0 }
            })
            .collect();
        let first_discrete = bins.len();
        bins.extend(self.discrete.iter().enumerate().map(|(i, p)| Bin {
            place: Place::Discrete(i),
            expected: p * n,
            observed: 0,
        }));
        let mut tally = Tally::default();
        for _ in 0..self.samples {
            match sample(&mut rng) {
                Drawn::Nothing => tally.failed += 1,
                Drawn::Discrete(i) if i < self.discrete.len() => bins[first_discrete + i].observed += 1,
                Drawn::Point(p) if within(p, domain) => {
                    bins[partition.find(p)].observed += 1;
                    tally.stray += u64::from(density(p).is_nan() || density(p) <= 0.0);
                }
                _ => tally.outside += 1,
            }
        }
        Outcome::new(self, bins, tally)
    }
}

fn map_point<A, B>(drawn: Drawn<A>, map: impl Fn(A) -> B) -> Drawn<B> {
    match drawn {
        Drawn::Point(p) => Drawn::Point(map(p)),
        Drawn::Discrete(i) => Drawn::Discrete(i),
        Drawn::Nothing => Drawn::Nothing,
    }
}

/// (theta, phi) of a unit vector, precise at the poles; outside of any domain if the vector is not of unit length.
fn polar([x, y, z]: [f64; 3]) -> [f64; 2] {
    if ((x * x + y * y + z * z) - 1.0).abs() < 1e-3 {
        let phi = y.atan2(x);
        [x.hypot(y).atan2(z), if phi < 0.0 { phi + TAU } else { phi }]
    } else {
        [f64::NAN; 2]
    }
}

fn within(p: [f64; 2], domain: Cell) -> bool {
    (0..2).all(|i| p[i] >= domain.low[i] && p[i] <= domain.high[i])
}

/// A binary tree of cells.
struct Partition {
    domain: Cell,
    /// Splitting axis and the two children; a child of `!i` is leaf i.
    nodes: Vec<(usize, [isize; 2])>,
    /// Cells and their shares of the pilot samples.
    leaves: Vec<(Cell, f64)>,
}

impl Partition {
    fn new(domain: Cell, axes: usize, pilots: Vec<[f64; 2]>, cells: usize) -> Self {
        let mut partition = Self { domain, nodes: Vec::new(), leaves: Vec::new() };
        let total = pilots.len().max(1);
        // Halving at most 1.5 times the mean on average gives about the wished number.
        let most = (total * 3 / (2 * cells)).max(1);
        // The coarsest grid, so that density where no sample falls is found.
        let always = if axes == 1 { 4 } else { 6 };
        partition.split(domain, axes, pilots, 0, &|depth, pilots| depth < always || pilots > most, total);
        partition
    }

    fn split(
        &mut self,
        cell: Cell,
        axes: usize,
        pilots: Vec<[f64; 2]>,
        depth: u32,
        divide: &impl Fn(u32, usize) -> bool,
        total: usize,
    ) -> isize {
        if depth >= MAX_SPLITS || !divide(depth, pilots.len()) {
            self.leaves.push((cell, pilots.len() as f64 / total as f64));
            return !(self.leaves.len() as isize - 1);
        }
        // The last axis first: azimuth is twice as long as the polar angle.
        let axis = if axes == 1 { 0 } else { 1 - depth as usize % 2 };
        let middle = cell.middle(axis);
        let (below, above): (Vec<_>, Vec<_>) = pilots.into_iter().partition(|p| p[axis] < middle);
        let node = self.nodes.len();
        self.nodes.push((axis, [0; 2]));
        for (side, (half, part)) in cell.halves(axis).into_iter().zip([below, above]).enumerate() {
            let child = self.split(half, axes, part, depth + 1, divide, total);
            self.nodes[node].1[side] = child;
        }
        node as isize
    }

    fn find(&self, p: [f64; 2]) -> usize {
        let (mut node, mut cell) = (0, self.domain);
        while node >= 0 {
            let (axis, children) = self.nodes[node as usize];
            let side = usize::from(p[axis] >= cell.middle(axis));
            cell = cell.halves(axis)[side];
            node = children[side];
        }
        !node as usize
    }
}

/// What a bin of the histogram counts.
#[derive(Clone, Copy, Debug)]
enum Place {
    Cell(Cell),
    Discrete(usize),
    Failure,
    Pool(usize),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cell(Cell { low, high }) => {
                write!(f, "cell [{:.5}, {:.5}] x [{:.5}, {:.5}]", low[0], high[0], low[1], high[1])
            }
            Self::Discrete(i) => write!(f, "discrete outcome {i}"),
            Self::Failure => write!(f, "failures"),
            Self::Pool(n) => write!(f, "pool of {n} sparse cells"),
        }
    }
}

/// One bin of the histogram.
#[derive(Clone, Copy, Debug)]
struct Bin {
    place: Place,
    expected: f64,
    observed: u64,
}

impl Bin {
    fn term(&self) -> f64 {
        (self.observed as f64 - self.expected).powi(2) / self.expected
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Tally {
    failed: u64,
    outside: u64,
    stray: u64,
}

/// Result of a chi-square test. Print it to see the worst cells.
#[derive(Clone, Debug)]
pub struct Outcome {
    /// Probability of a statistic as large if the density is right; NaN if the density is not finite.
    pub p_value: f64,
    /// Sum of (observed - expected)^2 / expected over the bins.
    pub statistic: f64,
    /// Degrees of freedom: bins less one.
    pub dof: usize,
    /// Samples drawn.
    pub samples: u64,
    /// Samples that gave nothing.
    pub failed: u64,
    /// Samples outside of the domain, not finite, or not of unit length.
    pub outside: u64,
    /// Samples where the density is zero or NaN.
    pub stray: u64,
    /// Integral of the density plus the discrete masses.
    pub mass: f64,
    allowed_stray: u64,
    allowed_mass_error: f64,
    worst: Vec<Bin>,
}

impl Outcome {
    fn new(test: &ChiSquare, mut bins: Vec<Bin>, tally: Tally) -> Self {
        let n = test.samples as f64;
        let mass = bins.iter().map(|b| b.expected).sum::<f64>() / n;
        let failure = tally.failed as f64 / n;
        // Below the tolerance a missing mass is an error of the cubature.
        let missing = (1.0 - mass) * n;
        if tally.failed > 0 || missing > test.mass_tolerance * n {
            bins.push(Bin { place: Place::Failure, expected: missing.max(0.0), observed: tally.failed });
        }
        let finite = bins.iter().all(|b| b.expected.is_finite() && b.expected >= 0.0);
        let mut bins = if finite { pool(bins) } else { bins };
        let statistic = bins.iter().map(Bin::term).sum::<f64>();
        let dof = bins.len().saturating_sub(1);
        let p_value = match (finite, dof) {
            (false, _) => f64::NAN,
            (true, 0) => 1.0,
            (true, _) => chi2_upper(statistic, dof as f64),
        };
        bins.sort_by(|a, b| b.term().total_cmp(&a.term()));
        bins.truncate(5);
        Self {
            p_value,
            statistic,
            dof,
            samples: test.samples,
            failed: tally.failed,
            outside: tally.outside,
            stray: tally.stray,
            mass,
            allowed_stray: ((n * test.stray_fraction) as u64).max(2),
            allowed_mass_error: test.mass_tolerance + 5.0 * (failure * (1.0 - failure) / n).sqrt(),
            worst: bins,
        }
    }

    /// Is all well, in a family of `tests` that together may err with probability `level`? Says what is wrong if not.
    pub fn check(&self, level: f64, tests: usize) -> Result<(), String> {
        let each = sidak(level, tests);
        let mut faults = Vec::new();
        if self.outside > self.allowed_stray {
            faults.push(format!("{} samples outside of the domain, not finite or not of unit length", self.outside));
        }
        if self.stray > self.allowed_stray {
            faults.push(format!("{} samples where the density is zero or NaN", self.stray));
        }
        let failure = self.failed as f64 / self.samples as f64;
        let mass_error = (self.mass + failure - 1.0).abs();
        if mass_error.is_nan() || mass_error > self.allowed_mass_error {
            faults.push(format!(
                "the density integrates to {:.6}, with failures to {:.6}",
                self.mass,
                self.mass + failure
            ));
        }
        if self.p_value.is_nan() || self.p_value < each {
            faults.push(format!("p-value {:.3e} below {each:.3e}", self.p_value));
        }
        if faults.is_empty() { Ok(()) } else { Err(format!("{}\n{self}", faults.join("\n"))) }
    }

    /// Panics with the report of [`Outcome::check`].
    #[track_caller]
    pub fn assert(&self, level: f64, tests: usize, what: &str) {
        if let Err(report) = self.check(level, tests) {
            panic!("{what}: {report}");
        }
    }
}

impl fmt::Display for Outcome {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "chi-square {:.2}, {} degrees of freedom, p {:.3e}; {} samples, {} failed, {} outside, {} stray; mass {:.6}",
            self.statistic, self.dof, self.p_value, self.samples, self.failed, self.outside, self.stray, self.mass
        )?;
        writeln!(f, "worst bins:")?;
        for bin in &self.worst {
            let deviation = (bin.observed as f64 - bin.expected) / bin.expected.sqrt();
            writeln!(
                f,
                "  {}: observed {}, expected {:.2} ({deviation:+.2} sigma)",
                bin.place, bin.observed, bin.expected
            )?;
        }
        Ok(())
    }
}

/// Pools the sparse bins, sparsest first, into bins that expect enough; what remains joins the last pool or the sparsest
/// of the others.
fn pool(mut bins: Vec<Bin>) -> Vec<Bin> {
    bins.sort_by(|a, b| a.expected.total_cmp(&b.expected));
    let mut out: Vec<Bin> = Vec::with_capacity(bins.len());
    let mut open = Bin { place: Place::Pool(0), expected: 0.0, observed: 0 };
    let merge = |into: &mut Bin, bin: &Bin| {
        let size = |place| if let Place::Pool(n) = place { n } else { 1 };
        into.place = Place::Pool(size(into.place) + size(bin.place));
        into.expected += bin.expected;
        into.observed += bin.observed;
    };
    for bin in bins {
        if bin.expected >= MIN_EXPECTED {
            if matches!(open.place, Place::Pool(0)) {
                out.push(bin);
            } else {
                merge(&mut open, &bin);
                out.push(std::mem::replace(&mut open, Bin { place: Place::Pool(0), expected: 0.0, observed: 0 }));
            }
            continue;
        }
        merge(&mut open, &bin);
        if open.expected >= MIN_EXPECTED {
            out.push(std::mem::replace(&mut open, Bin { place: Place::Pool(0), expected: 0.0, observed: 0 }));
        }
    }
    if !matches!(open.place, Place::Pool(0)) {
        match out.last_mut() {
            Some(last) => merge(last, &open),
            None => out.push(open),
        }
    }
    out
}
