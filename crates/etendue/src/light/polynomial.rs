//! Real roots of polynomials.

/// Most roots of a quartic.
const MOST: usize = 4;

/// Roots in ascending order.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Roots {
    count: usize,
    at: [f64; MOST],
}

impl Roots {
    pub fn iter(&self) -> std::slice::Iter<'_, f64> {
        self.at[..self.count].iter()
    }

    fn push(&mut self, root: f64) {
        if self.count < MOST {
            self.at[self.count] = root;
            self.count += 1;
        }
    }
}

/// Where the quartic with these coefficients, the constant first, changes its sign in [-1, 1]: between the roots of its derivative
/// it does so at most once.
pub(super) fn unit_roots(coefficients: [f64; MOST + 1]) -> Roots {
    let mut turns = Roots::default();
    for degree in 1..=MOST {
        // Of the derivative of this degree.
        let mut derivative = coefficients;
        for _ in degree..MOST {
            for power in 1..=MOST {
                derivative[power - 1] = derivative[power] * power as f64;
            }
            derivative[MOST] = 0.0;
        }
        turns = roots_between(&derivative[..=degree], &turns);
    }
    turns
}

/// Roots in [-1, 1], given those of the derivative.
fn roots_between(coefficients: &[f64], turns: &Roots) -> Roots {
    let mut roots = Roots::default();
    let mut low = -1.0;
    for &high in turns.iter().chain([&1.0]) {
        if let Some(root) = root_in(coefficients, low, high) {
            roots.push(root);
        }
        low = high;
    }
    roots
}

/// Value and slope.
fn evaluate(coefficients: &[f64], x: f64) -> [f64; 2] {
    coefficients.iter().rev().fold([0.0, 0.0], |[value, slope], c| [value * x + c, slope * x + value])
}

/// The root of what is monotonous, if its sign changes.
fn root_in(coefficients: &[f64], mut low: f64, mut high: f64) -> Option<f64> {
    let [at_low, at_high] = [low, high].map(|x| evaluate(coefficients, x)[0]);
    if (at_low < 0.0) == (at_high < 0.0) {
        return None;
    }
    let mut x = 0.5 * (low + high);
    // Newton's method, halving the interval where that leaves it: roots near 0 need more digits than those near 1.
    for _ in 0..1100 {
        let [value, slope] = evaluate(coefficients, x);
        if (value < 0.0) == (at_low < 0.0) {
            low = x
        } else {
            high = x
        }
        let next = x - value / slope;
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - x).abs() <= 1e-15 * next.abs() {
            return Some(next);
        }
        x = next;
    }
    Some(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn product(roots: [f64; 4]) -> [f64; 5] {
        let mut all = [1.0, 0.0, 0.0, 0.0, 0.0];
        for root in roots {
            let shifted: [f64; 5] = std::array::from_fn(|i| if i == 0 { 0.0 } else { all[i - 1] });
            all = std::array::from_fn(|i| shifted[i] - root * all[i]);
        }
        all
    }

    #[test]
    fn roots_in_the_interval_are_found_in_order() {
        let sets = [[-0.9, -0.1, 0.3, 0.8], [-3.0, 0.5, 0.6, 2.0], [-1e-7, 1e-7, 1e-4, 40.0], [2.0, 3.0, -4.0, -5.0]];
        for roots in sets {
            let found: Vec<f64> = unit_roots(product(roots)).iter().copied().collect();
            let expected: Vec<f64> = roots.into_iter().filter(|root| root.abs() <= 1.0).collect();
            assert_eq!(found.len(), expected.len(), "{roots:?} {found:?}");
            for (found, expected) in found.iter().zip(expected) {
                assert!((found - expected).abs() < 1e-9 * expected.abs().max(1e-4), "{found} {expected}");
            }
        }
    }

    #[test]
    fn without_roots_there_are_none() {
        assert_eq!(unit_roots([1.0, 0.0, 2.0, 0.0, 1.0]).iter().count(), 0);
        assert_eq!(unit_roots([0.0; 5]).iter().count(), 0);
        assert_eq!(unit_roots([f64::NAN; 5]).iter().count(), 0);
    }
}
