//! Filters of the eye: contrast sensitivity of the opponent colours, and detectors of edges and points.

use std::f64::consts::PI;

/// One number a pixel, row by row.
pub(super) struct Plane {
    pub width: usize,
    pub samples: Vec<f32>,
}

/// A kernel of a weighted sum of round Gaussians: the weight, and one axis of each.
pub(super) type Blur = Vec<(f64, Vec<f64>)>;

/// Contrast sensitivity in the plane: of Y, Cx, Cz the sums of a sqrt(pi / b) exp(-pi^2 d^2 / b), d in degrees, given as
/// (a, b); table 1 of the paper.
const SENSITIVITY: [&[(f64, f64)]; 3] = [&[(1.0, 0.0047)], &[(1.0, 0.0053)], &[(34.1, 0.04), (13.5, 0.025)]];
const WIDEST: f64 = 0.04;

/// Width of the feature detectors, degrees.
const FEATURE_WIDTH: f64 = 0.082;

/// The kernels of Y, Cx and Cz, whose whole weight is 1.
pub(super) fn blur_kernels(pixels_per_degree: f64) -> [Blur; 3] {
    let radius = (3.0 * (WIDEST / (2.0 * PI * PI)).sqrt() * pixels_per_degree).ceil() as i32;
    SENSITIVITY.map(|terms| {
        let term = |&(a, b): &(f64, f64)| {
            let axis = sampled(radius, |k| {
                let degrees = k / pixels_per_degree;
                libm::exp(-PI * PI * degrees * degrees / b)
            });
            (a * (PI / b).sqrt(), axis)
        };
        let mut kernel: Blur = terms.iter().map(term).collect();
        let weight_of = |(weight, axis): &(f64, Vec<f64>)| {
            let sum: f64 = axis.iter().sum();
            weight * sum * sum
        };
        let whole: f64 = kernel.iter().map(weight_of).sum();
        kernel.iter_mut().for_each(|(weight, _)| *weight /= whole);
        kernel
    })
}

/// A Gaussian and its first and second derivatives; their positive weights sum to 1, the negative ones to -1.
pub(super) fn feature_kernels(pixels_per_degree: f64) -> [Vec<f64>; 3] {
    let sigma = 0.5 * FEATURE_WIDTH * pixels_per_degree;
    let radius = (3.0 * sigma).ceil() as i32;
    let gaussian = |k: f64| libm::exp(-k * k / (2.0 * sigma * sigma));
    let kernels = [
        sampled(radius, gaussian),
        sampled(radius, |k| -k * gaussian(k)),
        sampled(radius, |k| (k * k / (sigma * sigma) - 1.0) * gaussian(k)),
    ];
    kernels.map(|kernel| {
        let sum = |sign: f64| kernel.iter().map(|w| (sign * w).max(0.0)).sum::<f64>();
        let (positive, negative) = (sum(1.0), sum(-1.0));
        kernel.iter().map(|&w| if w > 0.0 { w / positive } else { w / negative.max(f64::MIN_POSITIVE) }).collect()
    })
}

fn sampled(radius: i32, value: impl Fn(f64) -> f64) -> Vec<f64> {
    (-radius..=radius).map(|k| value(f64::from(k))).collect()
}

impl Plane {
    pub fn blurred(&self, kernel: &Blur) -> Plane {
        let mut sum = vec![0.0; self.samples.len()];
        for (weight, axis) in kernel {
            let one = self.convolved(axis, axis);
            sum.iter_mut().zip(&one.samples).for_each(|(sum, v)| *sum += *weight as f32 * v);
        }
        Plane { width: self.width, samples: sum }
    }

    /// The product of two kernels, `across` along rows and `down` along columns; beyond its borders a picture goes on as it
    /// ends.
    pub fn convolved(&self, across: &[f64], down: &[f64]) -> Plane {
        let width = self.width;
        let rows: Vec<&[f32]> = self.samples.chunks_exact(width).collect();
        let mut wide = Vec::with_capacity(self.samples.len());
        let reach = across.len() / 2;
        let mut padded = Vec::with_capacity(width + 2 * reach);
        for row in &rows {
            padded.clear();
            padded.resize(reach, row[0]);
            padded.extend_from_slice(row);
            padded.resize(width + 2 * reach, row[width - 1]);
            let start = wide.len();
            wide.resize(start + width, 0.0f32);
            accumulate(&mut wide[start..], across, |k| &padded[k..k + width]);
        }
        let wide: Vec<&[f32]> = wide.chunks_exact(width).collect();
        let mut samples = vec![0.0; self.samples.len()];
        let reach = down.len() / 2;
        for (y, out) in samples.chunks_exact_mut(width).enumerate() {
            accumulate(out, down, |k| wide[(y + k).saturating_sub(reach).min(wide.len() - 1)]);
        }
        Plane { width, samples }
    }
}

/// Adds weighted slices.
fn accumulate<'a>(out: &mut [f32], kernel: &[f64], of: impl Fn(usize) -> &'a [f32]) {
    for (k, &weight) in kernel.iter().enumerate() {
        let weight = weight as f32;
        out.iter_mut().zip(of(k)).for_each(|(out, v)| *out += weight * v);
    }
}
