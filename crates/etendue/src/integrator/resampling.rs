//! Light samples out of several candidates: the one that is kept is drawn in proportion to what each would bring if nothing were in
//! between.
//!
//! Resampled importance sampling (Talbot, Cline and Egbert, "Importance Resampling for Global Illumination", 2005), one
//! candidate after another (Chao, "A General Purpose Unequal Probability Sampling Plan", 1982). With f_i what candidate i of n would
//! bring over its density, multiple importance sampling's weight included, the one that is kept brings f_i (sum |f|) / (n |f_i|), whose
//! mean is that of the candidates; so the weights against BSDF samples stay those of the candidates' density.

use super::{paths::Paths, wave::Context};
use crate::{bsdf::Density, spectrum::Spectrum};

/// Candidates of a light sample that is resampled.
pub(super) const CANDIDATES: u32 = 2;

/// True if path `path` resamples light at its vertex, where it gathers light from below too if it `transmits`: at the end of a way that
/// no BSDF has drawn from a continuous lobe, so first of all where the camera looks.
#[inline]
pub(super) fn is_resampled(context: &Context, paths: &Paths, path: usize, transmits: bool) -> bool {
    let comes_straight = matches!(paths.previous[path].density, Density::Discrete(_));
    context.resamples && comes_straight && context.scene.lights().sole(transmits).is_none()
}

/// What a choice goes by.
#[inline(always)]
pub(super) fn magnitude(contribution: Spectrum) -> f32 {
    let [r, g, b] = contribution.0;
    r + g + b
}

/// A choice among candidates that come one after another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reservoir {
    /// Of the magnitudes so far.
    pub total: f32,
    /// A number in [0, 1), uniform whatever was chosen so far.
    pub u: f32,
}

impl Reservoir {
    /// True if the next candidate, of this magnitude, takes the place of the one that was kept. One of magnitude 0 never does.
    #[inline(always)]
    pub fn takes(&mut self, magnitude: f32) -> bool {
        self.total += magnitude;
        let share = if magnitude > 0.0 { magnitude / self.total } else { 0.0 };
        let is_taken = self.u < share;
        let left = if is_taken { self.u / share } else { (self.u - share) / (1.0 - share) };
        self.u = if left < BELOW_ONE { left } else { BELOW_ONE };
        is_taken
    }

    /// What the candidate that was kept brings for all of `count`.
    #[inline(always)]
    pub fn whole(&self, kept: Spectrum, count: u32) -> Spectrum {
        let magnitude = magnitude(kept);
        let scale = self.total / (magnitude * count as f32);
        kept * if magnitude > 0.0 { scale } else { 0.0 }
    }
}

/// Largest number below 1.
const BELOW_ONE: f32 = 1.0 - f32::EPSILON / 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::{Sampler, Slot};
    use etendue_testkit::chi2::ChiSquare;

    /// Each is kept in proportion to its magnitude, and what is left of the number is uniform.
    #[test]
    fn candidates_are_kept_by_their_magnitudes() {
        let magnitudes = [0.0, 2.0, 0.5, 0.0, 4.5, 1.0];
        let mut index = 0;
        let outcome = ChiSquare::new(200_000).seed(1).indices(&magnitudes.map(|m| f64::from(m) / 8.0), |_| {
            index += 1;
            let key = Sampler::Independent.key(1, [index, 0], 0);
            let u = Sampler::Independent.one_d(key, 1, Slot::LightResampling);
            let mut reservoir = Reservoir { total: 0.0, u };
            let mut kept = None;
            for (i, magnitude) in magnitudes.into_iter().enumerate() {
                if reservoir.takes(magnitude) {
                    kept = Some(i);
                }
            }
            assert!((0.0..1.0).contains(&reservoir.u));
            kept
        });
        outcome.assert(1e-3, 1, "kept");
    }

    /// Over the choice, what is kept brings on average what the candidates do.
    #[test]
    fn the_mean_stays() {
        let contributions = [Spectrum([1.0, 0.0, 3.0]), Spectrum::BLACK, Spectrum([0.5, 2.0, 0.0])];
        let (mut sum, trials) = ([0.0f64; 3], 4096);
        for trial in 0..trials {
            let mut reservoir = Reservoir { total: 0.0, u: (trial as f32 + 0.5) / trials as f32 };
            let mut kept = Spectrum::BLACK;
            for contribution in contributions {
                if reservoir.takes(magnitude(contribution)) {
                    kept = contribution;
                }
            }
            let whole = reservoir.whole(kept, 3);
            (0..3).for_each(|c| sum[c] += f64::from(whole.0[c]) / f64::from(trials));
        }
        for (sum, mean) in sum.into_iter().zip([0.5, 2.0 / 3.0, 1.0]) {
            assert!((sum - mean).abs() < 2e-3, "{sum}, not {mean}");
        }
        let none = Reservoir { total: 0.0, u: 0.5 }.whole(Spectrum::BLACK, 2);
        assert!(none.is_black());
    }
}
