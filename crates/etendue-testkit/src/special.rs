//! Distribution functions of the normal, chi-square, Student and Kolmogorov laws.

/// The level of each of `tests` independent tests so that the family errs with probability `level`
/// (Sidak, "Rectangular Confidence Regions for the Means of Multivariate Normal Distributions", 1967).
pub fn sidak(level: f64, tests: usize) -> f64 {
    -((-level).ln_1p() / tests.max(1) as f64).exp_m1()
}

/// P(|Z| >= |z|) for a standard normal Z.
pub fn normal_two_sided(z: f64) -> f64 {
    libm::erfc(z.abs() / std::f64::consts::SQRT_2)
}

/// P(X >= x) for X chi-square with `dof` degrees of freedom.
pub fn chi2_upper(x: f64, dof: f64) -> f64 {
    gamma_q(0.5 * dof, 0.5 * x)
}

/// P(|T| >= |t|) for T of Student's law with `dof` degrees of freedom.
pub fn student_two_sided(t: f64, dof: f64) -> f64 {
    beta_i(0.5 * dof, 0.5, dof / (dof + t * t))
}

/// Regularised upper incomplete gamma function Q(a, x), a > 0, x >= 0: series below a + 1, continued fraction above.
pub fn gamma_q(a: f64, x: f64) -> f64 {
    if x.is_nan() || a.is_nan() || a <= 0.0 {
        return f64::NAN;
    }
    if x <= 0.0 {
        return 1.0;
    }
    if x.is_infinite() {
        return 0.0;
    }
    let front = (a * x.ln() - x - libm::lgamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > sum * 1e-16 {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        1.0 - front * sum
    } else {
        front * continued_fraction(x + 1.0 - a, |i| (-i * (i - a), x + 1.0 - a + 2.0 * i))
    }
}

/// Regularised incomplete beta function I_x(a, b), a, b > 0, 0 <= x <= 1.
pub fn beta_i(a: f64, b: f64, x: f64) -> f64 {
    if x.is_nan() || x <= 0.0 {
        return if x.is_nan() { f64::NAN } else { 0.0 };
    }
    if x >= 1.0 {
        return 1.0;
    }
    if x > (a + 1.0) / (a + b + 2.0) {
        return 1.0 - beta_i(b, a, 1.0 - x);
    }
    let front = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b) + a * x.ln() + b * (-x).ln_1p();
    let fraction = continued_fraction(1.0, |i| {
        let m = (i * 0.5).floor();
        let numerator = if i % 2.0 == 0.0 {
            m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m))
        } else {
            -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0))
        };
        (numerator, 1.0)
    });
    front.exp() / a * fraction
}

/// 1 / (b0 + a1 / (b1 + a2 / (b2 + ..))) with `terms(i) = (a_i, b_i)`, by the modified method of Lentz (1976).
fn continued_fraction(b0: f64, terms: impl Fn(f64) -> (f64, f64)) -> f64 {
    const TINY: f64 = 1e-300;
    let guard = |x: f64| if x.abs() < TINY { TINY } else { x };
    let mut c = 1.0 / TINY;
    let mut d = 1.0 / guard(b0);
    let mut value = d;
    for i in 1..100_000 {
        let (a, b) = terms(f64::from(i));
        d = 1.0 / guard(a * d + b);
        c = guard(b + a / c);
        value *= c * d;
        if (c * d - 1.0).abs() < 1e-15 {
            break;
        }
    }
    value
}

/// P-value of the Kolmogorov-Smirnov test that `values` are uniform on [0, 1]
/// (asymptotic law with the small-sample correction of Stephens, 1970). Values outside count as at the border.
pub fn kolmogorov_uniform(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    let n = sorted.len() as f64;
    let distance = sorted.iter().enumerate().fold(0.0f64, |worst, (i, &x)| {
        let x = x.clamp(0.0, 1.0);
        worst.max(x - i as f64 / n).max((i + 1) as f64 / n - x)
    });
    let lambda = (n.sqrt() + 0.12 + 0.11 / n.sqrt()) * distance;
    if lambda < 0.2 {
        return 1.0;
    }
    let mut sum = 0.0;
    for k in 1..101 {
        let k = f64::from(k);
        let sign = if k % 2.0 == 1.0 { 2.0 } else { -2.0 };
        sum += sign * (-2.0 * k * k * lambda * lambda).exp();
    }
    sum.clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(a: f64, b: f64) {
        assert!((a - b).abs() <= 1e-9 * b.abs().max(1e-3), "{a} is not {b}");
    }

    #[test]
    fn known_quantiles() {
        // Closed forms.
        close(chi2_upper(3.0, 2.0), (-1.5f64).exp());
        close(chi2_upper(8.0, 4.0), 5.0 * (-4.0f64).exp());
        close(student_two_sided(1.0, 1.0), 0.5);
        // Two degrees of freedom: 1 - t / sqrt(t^2 + 2).
        close(student_two_sided(2.0, 2.0), 1.0 - 2.0 / 6.0f64.sqrt());
        close(normal_two_sided(0.0), 1.0);
        // One degree of freedom is a squared normal.
        for z in [0.1, 0.7, 1.5, 2.5, 5.0] {
            close(chi2_upper(z * z, 1.0), normal_two_sided(z));
        }
        // Student's law tends to the normal.
        assert!((student_two_sided(2.5, 1e7) - normal_two_sided(2.5)).abs() < 1e-7);
        // Median of chi-square with many degrees of freedom.
        assert!((chi2_upper(2000.0 - 2.0 / 3.0, 2000.0) - 0.5).abs() < 1e-4);
    }

    #[test]
    fn sidak_levels() {
        close(sidak(0.01, 1), 0.01);
        let each = sidak(0.01, 1000);
        close(1.0 - (1.0 - each).powi(1000), 0.01);
    }
}
