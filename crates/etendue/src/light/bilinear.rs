//! What the points of a light bring, fitted by their values at four corners.
//!
//! A map of the unit square onto a light takes numbers that are not uniform but have a bilinear density (Hart et al., "Practical
//! Product Sampling by Fitting and Composing Warps", 2020). Where the map is uniform in solid angle and the corners have the cosine
//! at the context, directions come close to projected solid angle, at the cost of two square roots.

use super::{between, larger};

/// Least value at a corner, over the greatest: not all that scatters goes with the cosine.
const LEAST: f64 = 0.02;
/// Least cosine at a corner: below, a direction in f32 does not tell it well.
pub(super) const LEAST_COSINE: f64 = 0.01;

/// A density on the unit square: values at (0, 0), (1, 0), (0, 1) and (1, 1), all above 0, of any scale.
#[derive(Clone, Copy)]
pub(super) struct Bilinear([f64; 4]);

impl Bilinear {
    /// Values that are not negative, raised to what they must not be below; not all of them and `floor` are 0.
    #[inline(always)]
    pub fn new([w00, w10, w01, w11]: [f64; 4], floor: f64) -> Self {
        let least = larger(LEAST * larger(larger(w00, w10), larger(w01, w11)), floor);
        Self([larger(w00, least), larger(w10, least), larger(w01, least), larger(w11, least)])
    }

    /// The mean over the square.
    #[inline(always)]
    pub fn mean(&self) -> f64 {
        let [w00, w10, w01, w11] = self.0;
        0.25 * ((w00 + w10) + (w01 + w11))
    }

    /// A point with this density for uniform `u` in [0, 1)^2; `u` itself where all values are the same.
    #[inline(always)]
    pub fn sample(&self, [u, v]: [f64; 2]) -> [f64; 2] {
        let [w00, w10, w01, w11] = self.0;
        let b = linear(w00 + w10, w01 + w11, v);
        let mix = |from: f64, to: f64| from + (to - from) * b;
        [linear(mix(w00, w01), mix(w10, w11), u), b]
    }

    /// Its value at a point, not divided by the mean.
    #[inline(always)]
    pub fn value(&self, [a, b]: [f64; 2]) -> f64 {
        let [w00, w10, w01, w11] = self.0;
        (w00 * (1.0 - a) + w10 * a) * (1.0 - b) + (w01 * (1.0 - a) + w11 * a) * b
    }

    /// Density at a point.
    #[inline(always)]
    pub fn density(&self, at: [f64; 2]) -> f64 {
        self.value(at) / self.mean()
    }
}

/// A number in [0, 1] with a density that goes from `from` to `to`, not both 0.
#[inline(always)]
fn linear(from: f64, to: f64, u: f64) -> f64 {
    let root = larger(from * from + (to * to - from * from) * u, 0.0).sqrt();
    between(u * (from + to) / (from + root), 0.0, 1.0)
}
