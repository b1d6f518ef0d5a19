//! Medians and what is known about them.

/// A median with the interval between order statistics that holds the true one with at least 95 % probability (for fewer
/// than six values: the whole range).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Median {
    pub low: f64,
    pub value: f64,
    pub high: f64,
}

impl Median {
    /// Of at least one value.
    pub fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let n = sorted.len();
        let value = 0.5 * (sorted[(n - 1) / 2] + sorted[n / 2]);
        let outside = outside(n);
        Self { low: sorted[outside], value, high: sorted[n - 1 - outside] }
    }
}

/// How many values may be left out at each end: the number of values below the median is binomial.
fn outside(n: usize) -> usize {
    let mut probability = libm::exp2(-(n as f64));
    let mut below = probability;
    let mut count = 0;
    while below <= 0.025 && count < n / 2 {
        count += 1;
        probability *= (n - count + 1) as f64 / count as f64;
        below += probability;
    }
    count.saturating_sub(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_by_the_sign_test() {
        // From tables of the sign test at 5 %, two-sided.
        assert_eq!([5, 6, 8, 9, 11, 12, 15, 25].map(outside), [0, 0, 0, 1, 1, 2, 3, 7]);
        assert_eq!(Median::of(&[3.0, 1.0, 2.0]), Median { low: 1.0, value: 2.0, high: 3.0 });
        assert_eq!(Median::of(&[1.0, 2.0]).value, 1.5);
    }
}
