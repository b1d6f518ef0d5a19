//! Adaptive cubature on a rectangle, by tensor Gauss-Legendre rules.

/// Abscissae on [-1, 1] and weights (Abramowitz and Stegun 1964, table 25.4).
type Rule = [(f64, f64)];

const SEVEN: [(f64, f64); 7] = [
    (-0.949_107_912_342_758_5, 0.129_484_966_168_869_7),
    (-0.741_531_185_599_394_4, 0.279_705_391_489_276_7),
    (-0.405_845_151_377_397_2, 0.381_830_050_505_118_9),
    (0.0, 0.417_959_183_673_469_4),
    (0.405_845_151_377_397_2, 0.381_830_050_505_118_9),
    (0.741_531_185_599_394_4, 0.279_705_391_489_276_7),
    (0.949_107_912_342_758_5, 0.129_484_966_168_869_7),
];

const FOUR: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
];

/// How many times a side may be halved.
const MAX_DEPTH: u32 = 10;

/// An axis-aligned rectangle, or an interval if the second axis is [0, 1] and the integrand ignores it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Cell {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl Cell {
    /// The two halves across `axis`.
    pub fn halves(self, axis: usize) -> [Self; 2] {
        let middle = self.middle(axis);
        let (mut a, mut b) = (self, self);
        a.high[axis] = middle;
        b.low[axis] = middle;
        [a, b]
    }

    pub fn middle(self, axis: usize) -> f64 {
        0.5 * (self.low[axis] + self.high[axis])
    }
}

/// Integral of `f` over `cell` to an absolute error of about `tolerance`, integrating along the first `axes` axes.
fn integrate(f: &impl Fn([f64; 2]) -> f64, cell: Cell, axes: usize, tolerance: f64) -> f64 {
    refine(f, cell, axes, tolerance, apply(&SEVEN, f, cell, axes), MAX_DEPTH)
}

fn refine(f: &impl Fn([f64; 2]) -> f64, cell: Cell, axes: usize, tolerance: f64, coarse: f64, depth: u32) -> f64 {
    let [a, b] = cell.halves(0);
    let (parts, count) = if axes == 1 {
        ([a, b, a, b], 2)
    } else {
        let ([a0, a1], [b0, b1]) = (a.halves(1), b.halves(1));
        ([a0, a1, b0, b1], 4)
    };
    let parts = &parts[..count];
    let mut values = [0.0; 4];
    for (value, &part) in values.iter_mut().zip(parts) {
        *value = apply(&SEVEN, f, part, axes);
    }
    let fine: f64 = values[..count].iter().sum();
    let done = |other: f64| (fine - other).abs() <= tolerance;
    // Where the integrand jumps, the two levels may agree by chance; rules with other abscissae do not as well.
    if depth == 0
        || !fine.is_finite()
        || done(coarse) && done(parts.iter().map(|&part| apply(&FOUR, f, part, axes)).sum())
    {
        return fine;
    }
    // Errors of the parts have either sign: their sum grows as the root of their number.
    let share = tolerance / (count as f64).sqrt();
    parts.iter().zip(&values).map(|(&part, &value)| refine(f, part, axes, share, value, depth - 1)).sum()
}

fn apply(rule: &Rule, f: &impl Fn([f64; 2]) -> f64, cell: Cell, axes: usize) -> f64 {
    let half = [0, 1].map(|i| 0.5 * (cell.high[i] - cell.low[i]));
    let at = |axis: usize, x: f64| cell.middle(axis) + half[axis] * x;
    let mut sum = 0.0;
    for &(x, wx) in rule {
        if axes == 1 {
            sum += wx * f([at(0, x), 0.5]);
        } else {
            for &(y, wy) in rule {
                sum += wx * wy * f([at(0, x), at(1, y)]);
            }
        }
    }
    sum * half[..axes].iter().product::<f64>()
}

/// Integral of `f` over [low, high] to an absolute error of about `tolerance`, split evenly into `pieces` first so that
/// narrow peaks are not missed.
pub fn integrate_1d(f: impl Fn(f64) -> f64, [low, high]: [f64; 2], pieces: usize, tolerance: f64) -> f64 {
    let step = (high - low) / pieces as f64;
    let share = tolerance / (pieces as f64).sqrt();
    (0..pieces)
        .map(|i| {
            let cell = Cell { low: [low + step * i as f64, 0.0], high: [low + step * (i + 1) as f64, 1.0] };
            integrate(&|[x, _]: [f64; 2]| f(x), cell, 1, share)
        })
        .sum()
}

/// Integral of `f` over the rectangle [low, high] to an absolute error of about `tolerance`, split evenly into
/// `pieces` x `pieces` first so that narrow peaks are not missed.
pub fn integrate_2d(f: impl Fn([f64; 2]) -> f64, low: [f64; 2], high: [f64; 2], pieces: usize, tolerance: f64) -> f64 {
    let step = [0, 1].map(|i| (high[i] - low[i]) / pieces as f64);
    let corner = |i: usize, j: usize| [low[0] + step[0] * i as f64, low[1] + step[1] * j as f64];
    let share = tolerance / pieces as f64;
    (0..pieces * pieces)
        .map(|n| {
            let (i, j) = (n / pieces, n % pieces);
            integrate(&f, Cell { low: corner(i, j), high: corner(i + 1, j + 1) }, 2, share)
        })
        .sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_peaked_and_jumping() {
        let smooth = integrate_2d(|[x, y]| x.exp() * y * y, [0.0, 0.0], [1.0, 3.0], 1, 1e-12);
        assert!((smooth - (1.0f64.exp() - 1.0) * 9.0).abs() < 1e-11);
        let s = 1e-3;
        let peak = |x: f64| (-0.5 * (x / s).powi(2)).exp() / (s * std::f64::consts::TAU.sqrt());
        assert!((integrate_1d(peak, [-1.0, 1.0], 16, 1e-10) - 1.0).abs() < 1e-9);
        let disk = |[x, y]: [f64; 2]| if x * x + y * y < 1.0 { 1.0 } else { 0.0 };
        let area = integrate_2d(disk, [-1.0, -1.0], [1.0, 1.0], 4, 1e-5);
        assert!((area - std::f64::consts::PI).abs() < 1e-4, "{area}");
        for edge in [5.0 / 7.0, 0.3, 0.857, 0.1234] {
            let step = |[x, y]: [f64; 2]| if x < edge { 4.0 } else { 0.4 } * (1.0 + y);
            let exact = (4.0 * edge + 0.4 * (1.0 - edge)) * 1.5;
            let area = integrate_2d(step, [0.0, 0.0], [1.0, 1.0], 3, 1e-4);
            assert!((area - exact).abs() < 1e-3, "{edge}: {area}, {exact}");
        }
    }
}
