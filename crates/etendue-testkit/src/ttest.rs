//! Tests of means, from running moments.

use crate::special::{normal_two_sided, student_two_sided};

/// Count, mean and variance of a stream of numbers (Welford 1962; merging after Chan, Golub and LeVeque 1979).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Moments {
    count: u64,
    mean: f64,
    /// Sum of squared differences from the mean.
    squares: f64,
}

impl Moments {
    /// No numbers yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one number.
    pub fn push(&mut self, x: f64) {
        self.count += 1;
        let delta = x - self.mean;
        self.mean += delta / self.count as f64;
        self.squares += delta * (x - self.mean);
    }

    /// Adds all numbers that `other` has seen.
    pub fn merge(&mut self, other: &Self) {
        if other.count == 0 {
            return;
        }
        let (a, b) = (self.count as f64, other.count as f64);
        let delta = other.mean - self.mean;
        self.count += other.count;
        self.mean += delta * b / (a + b);
        self.squares += other.squares + delta * delta * a * b / (a + b);
    }

    /// How many numbers.
    pub fn count(&self) -> u64 {
        self.count
    }

    /// Their mean; 0 if there are none.
    pub fn mean(&self) -> f64 {
        self.mean
    }

    /// Unbiased variance of one number; 0 below two numbers.
    pub fn variance(&self) -> f64 {
        if self.count < 2 { 0.0 } else { (self.squares / (self.count - 1) as f64).max(0.0) }
    }

    /// Standard error of the mean.
    pub fn standard_error(&self) -> f64 {
        (self.variance() / self.count.max(1) as f64).sqrt()
    }
}

impl Extend<f64> for Moments {
    fn extend<I: IntoIterator<Item = f64>>(&mut self, numbers: I) {
        numbers.into_iter().for_each(|x| self.push(x));
    }
}

impl FromIterator<f64> for Moments {
    fn from_iter<I: IntoIterator<Item = f64>>(numbers: I) -> Self {
        let mut moments = Self::new();
        moments.extend(numbers);
        moments
    }
}

/// Result of a two-sided test that a mean, or a difference of means, is what it should be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeanTest {
    /// Observed minus expected.
    pub difference: f64,
    /// Standard error of the difference.
    pub standard_error: f64,
    /// Difference over its standard error.
    pub statistic: f64,
    /// Degrees of freedom; infinite for a z-test.
    pub dof: f64,
    /// Probability of a statistic as far from zero if the means are equal; NaN if the data are not finite.
    pub p_value: f64,
}

impl MeanTest {
    fn new(difference: f64, standard_error: f64, dof: f64) -> Self {
        // Equal means without scatter agree; unequal ones do not, however few.
        let statistic = if difference == 0.0 { 0.0 } else { difference / standard_error };
        let p_value = if dof.is_finite() && statistic.is_finite() {
            student_two_sided(statistic, dof)
        } else {
            normal_two_sided(statistic)
        };
        Self { difference, standard_error, statistic, dof, p_value }
    }

    /// Does the test pass at `level` (each test's own, see [`sidak`](crate::sidak))? NaN does not.
    pub fn passes(&self, level: f64) -> bool {
        self.p_value >= level
    }

    /// Panics with the numbers if the test fails at `level`.
    #[track_caller]
    pub fn assert(&self, level: f64, what: &str) {
        assert!(self.passes(level), "{what}: p = {:.3e} below the level {level:.3e}: {self:?}", self.p_value);
    }
}

/// One-sample t-test of the mean against `reference`. Needs two numbers at least, or it fails with NaN.
pub fn t_test(sample: &Moments, reference: f64) -> MeanTest {
    if sample.count() < 2 {
        return MeanTest::new(f64::NAN, f64::NAN, f64::NAN);
    }
    MeanTest::new(sample.mean() - reference, sample.standard_error(), (sample.count() - 1) as f64)
}

/// Two-sample t-test without the assumption of equal variances
/// (Welch, "The Generalization of Student's Problem when Several Different Population Variances are Involved", 1947).
/// Needs two numbers at least in each, or it fails with NaN.
pub fn welch(a: &Moments, b: &Moments) -> MeanTest {
    if a.count() < 2 || b.count() < 2 {
        return MeanTest::new(f64::NAN, f64::NAN, f64::NAN);
    }
    let part = |m: &Moments| m.variance() / m.count() as f64;
    let (va, vb) = (part(a), part(b));
    let (na, nb) = ((a.count() - 1) as f64, (b.count() - 1) as f64);
    let dof = if va + vb > 0.0 { (va + vb).powi(2) / (va * va / na + vb * vb / nb) } else { na + nb };
    MeanTest::new(a.mean() - b.mean(), (va + vb).sqrt(), dof)
}

/// Z-test of a value whose standard error is known.
pub fn z_test(value: f64, standard_error: f64, reference: f64) -> MeanTest {
    MeanTest::new(value - reference, standard_error, f64::INFINITY)
}

/// Statistics of `replicates` values of `estimate(seed)`, seeds counting from `first_seed`.
pub fn replicate(replicates: u64, first_seed: u64, mut estimate: impl FnMut(u64) -> f64) -> Moments {
    (0..replicates).map(|i| estimate(first_seed + i)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Rng, special::kolmogorov_uniform};

    #[test]
    fn moments_merge_as_one_stream() {
        let mut rng = Rng::new(1);
        let numbers: Vec<f64> = (0..1000).map(|_| 1e6 + rng.normal()).collect();
        let whole: Moments = numbers.iter().copied().collect();
        let mut merged = Moments::new();
        for part in numbers.chunks(77) {
            merged.merge(&part.iter().copied().collect());
        }
        assert_eq!(whole.count(), merged.count());
        assert!((whole.mean() - merged.mean()).abs() < 1e-8);
        assert!((whole.variance() - merged.variance()).abs() < 1e-8);
        let mean = numbers.iter().sum::<f64>() / 1000.0;
        let variance = numbers.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / 999.0;
        assert!((whole.variance() - variance).abs() < 1e-8);
    }

    /// P-values of tests whose hypothesis holds are uniform.
    #[test]
    fn p_values_are_uniform_under_the_hypothesis() {
        let (mut one, mut two) = (Vec::new(), Vec::new());
        for seed in 0..2000 {
            let mut rng = Rng::new(seed);
            let a: Moments = (0..8).map(|_| 3.0 + rng.normal()).collect();
            let b: Moments = (0..12).map(|_| 3.0 + 0.3 * rng.normal()).collect();
            one.push(t_test(&a, 3.0).p_value);
            two.push(welch(&a, &b).p_value);
        }
        assert!(kolmogorov_uniform(&one) > 0.01);
        assert!(kolmogorov_uniform(&two) > 0.01);
    }

    #[test]
    fn shifted_means_fail() {
        let mut rng = Rng::new(2);
        let a: Moments = (0..64).map(|_| 1.01 + 0.01 * rng.normal()).collect();
        let b: Moments = (0..64).map(|_| 1.0 + 0.01 * rng.normal()).collect();
        assert!(!t_test(&a, 1.0).passes(0.01) && t_test(&b, 1.0).passes(0.01));
        assert!(!welch(&a, &b).passes(0.01));
        assert!(!z_test(1.01, 0.003, 1.0).passes(0.01) && z_test(1.005, 0.003, 1.0).passes(0.01));
    }

    #[test]
    fn degenerate_data() {
        let constant: Moments = [2.0; 4].into_iter().collect();
        assert!(t_test(&constant, 2.0).passes(0.5));
        assert!(!t_test(&constant, 2.5).passes(1e-12));
        assert!(!t_test(&Moments::new(), 0.0).passes(0.01));
        let poisoned: Moments = [1.0, f64::NAN].into_iter().collect();
        assert!(!t_test(&poisoned, 1.0).passes(1e-12));
    }
}
