//! Tilts of mirrors: angles distributed as a power of their cosine.

use crate::math::sin_cos_turns;
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_2, PI};

/// Beyond exp(-SATURATION) of the peak the rest of the distribution is below the rounding error of its sum.
const SATURATION: f64 = 40.0;
/// More terms than any series here needs.
const MAX_TERMS: u32 = 600;

/// The distribution of an angle d in (-pi/2, pi/2) with density in proportion to cos^k(d). Angles of reflection turn by twice
/// a mirror's tilt, so densities are per radian of 2 d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CosinePower {
    exponent: f64,
    /// Density at 0, per radian of 2 d.
    peak: f64,
}

impl Default for CosinePower {
    /// Any angle alike: an exponent of 0.
    fn default() -> Self {
        Self { exponent: 0.0, peak: 0.5 / PI }
    }
}

impl CosinePower {
    /// `exponent` k from 0 (any angle alike) to 1e9.
    pub fn new(exponent: f32) -> Self {
        let exponent = f64::from(exponent);
        Self { exponent, peak: gamma_ratio(0.5 * (exponent + 1.0)) / (2.0 * PI.sqrt()) }
    }

    /// k.
    #[inline]
    pub fn exponent(&self) -> f64 {
        self.exponent
    }

    /// Density per radian of 2 d at the angle with this squared sine.
    #[inline]
    pub fn density(&self, sin2: f64) -> f64 {
        if self.exponent == 0.0 { self.peak } else { self.peak * libm::exp(0.5 * self.exponent * libm::log1p(-sin2)) }
    }

    /// [`Self::density`] from the angle's sine and cosine, precise to the end of the range.
    #[inline]
    fn density_at(&self, sin: f64, cos: f64) -> f64 {
        if sin.abs() <= FRAC_1_SQRT_2 || self.exponent == 0.0 {
            return self.density(sin * sin);
        }
        self.peak * libm::exp(self.exponent * libm::log(cos.max(1e-300)))
    }

    /// Probability of angles between 0 and `angle` (radians, at most pi/2 in magnitude), with the sign of `angle`.
    ///
    /// The integral of cos^k from 0 to d is s c^(k+1) F(1, k/2 + 1; 3/2; s^2), that from d to pi/2 is
    /// s c^(k+1) / (k + 1) F(1, k/2 + 1; (k + 3)/2; c^2), with s and c the sine and cosine of d and F Gauss's series
    /// (incomplete beta functions: Abramowitz and Stegun 1964, 26.5 and 15.3). All terms are positive.
    pub fn mass(&self, angle: f64) -> f64 {
        let (sin, cos) = libm::sincos(angle.abs());
        let half_mass = if -self.exponent * libm::log(cos.max(1e-300)) > SATURATION {
            0.5
        } else {
            // Twice the density, for d instead of 2 d.
            let scale = 2.0 * self.density_at(sin, cos) * sin * cos;
            let top = 0.5 * self.exponent + 1.0;
            if sin <= FRAC_1_SQRT_2 {
                scale * series(top, 1.5, sin * sin)
            } else {
                0.5 - scale / (self.exponent + 1.0) * series(top, top + 0.5, cos * cos)
            }
        };
        half_mass.copysign(angle)
    }

    /// The angle for a mass in [-1/2, 1/2]: the inverse of [`Self::mass`], by Halley's method between bounds.
    pub fn angle(&self, mass: f64) -> f64 {
        let target = mass.abs();
        if target == 0.0 || target >= 0.5 {
            return if target == 0.0 { 0.0 } else { FRAC_PI_2.copysign(mass) };
        }
        let (mut low, mut high) = (0.0, FRAC_PI_2);
        let mut angle = self.first_guess(target);
        let width = 1.0 / (self.exponent + 1.0).sqrt();
        for _ in 0..100 {
            let (sin, cos) = libm::sincos(angle);
            let error = self.mass(angle) - target;
            if error > 0.0 {
                high = angle
            } else {
                low = angle
            }
            let newton = error / (2.0 * self.density_at(sin, cos));
            let step = newton / (1.0 + 0.5 * newton * self.exponent * sin / cos);
            let next = angle - step;
            if !(next > low && next < high) {
                angle = 0.5 * (low + high);
                if high - low <= 1e-15 * width {
                    break;
                }
                continue;
            }
            angle = next;
            // The error is of the third order in the step, over what the density's shape changes in.
            if step.abs() <= 1e-5 * width.min(FRAC_PI_2 - angle) {
                break;
            }
        }
        angle.copysign(mass)
    }

    /// With cos(d) = exp(-w^2 / 2) the density in w is that of a normal distribution of variance 1 / (k + 1/2), times
    /// sqrt(y / sinh(y)) of y = w^2 / 2, which is close to 1. Its quantile after Winitzki ("A Handy Approximation for the
    /// Error Function and its Inverse", 2008).
    fn first_guess(&self, mass: f64) -> f64 {
        const A: f64 = 0.147;
        let log = libm::log1p(-4.0 * mass * mass);
        let b = 2.0 / (PI * A) + 0.5 * log;
        let w2 = 2.0 * ((b * b - log / A).sqrt() - b) / (self.exponent + 0.5);
        libm::asin((-libm::expm1(-w2)).max(0.0).sqrt()).clamp(1e-12, FRAC_PI_2 - 1e-9)
    }

    /// Draws the sine of an angle. With r^2 = 1 - u0^(2/k) the point of radius r and azimuth 2 pi u1 has the density
    /// (1 - r^2)^(k/2 - 1) in the unit disk, and its x that of the sine, (1 - x^2)^((k - 1)/2).
    #[inline]
    pub fn sample_sine(&self, u: [f32; 2]) -> f64 {
        // A number of 0 stands for what is nearest to it.
        let log = libm::log(f64::from(u[0]).max(1e-9));
        let r2 = if self.exponent > 0.0 { -libm::expm1(2.0 * log / self.exponent) } else { 1.0 };
        r2.sqrt() * f64::from(sin_cos_turns(u[1]).1)
    }
}

/// Gauss's series F(1, a; b; x) for 0 <= x < 1.
#[inline]
fn series(a: f64, b: f64, x: f64) -> f64 {
    let (mut term, mut sum, mut j) = (1.0, 1.0, 0.0);
    for _ in 0..MAX_TERMS {
        let ratio = x * (a + j) / (b + j);
        term *= ratio;
        sum += term;
        j += 1.0;
        // What is left is at most a geometric series.
        if term <= 1e-16 * (1.0 - ratio) * sum {
            break;
        }
    }
    sum
}

/// Gamma(x + 1/2) / Gamma(x) for x >= 1/2.
fn gamma_ratio(x: f64) -> f64 {
    if x < 40.0 {
        return libm::exp(libm::lgamma(x + 0.5) - libm::lgamma(x));
    }
    // Its asymptotic series: log-gamma loses the digits of large arguments.
    let y = 1.0 / x;
    x.sqrt() * (1.0 + y * (-1.0 / 8.0 + y * (1.0 / 128.0 + y * (5.0 / 1024.0 - y * 21.0 / 32_768.0))))
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXPONENTS: [f32; 12] = [0.0, 1e-3, 0.5, 1.0, 2.0, 3.7, 20.0, 77.0, 80.0, 1e3, 1e6, 1e9];

    /// By Simpson's rule.
    fn integral(power: &CosinePower, angle: f64) -> f64 {
        const N: usize = 4000;
        let value = |i: usize| {
            let sin = libm::sin(angle * i as f64 / N as f64);
            2.0 * power.density(sin * sin)
        };
        let inner: f64 = (1..N).map(|i| value(i) * if i % 2 == 1 { 4.0 } else { 2.0 }).sum();
        (value(0) + inner + value(N)) * angle / (3.0 * N as f64)
    }

    #[test]
    fn masses_are_integrals() {
        for power in EXPONENTS.map(CosinePower::new) {
            let width = 1.0 / (power.exponent + 1.0).sqrt();
            for z in [1e-9, 1e-3, 0.3, 0.5, 0.8, 1.0, 1.3, 1.5, 2.0, 3.0, 5.0] {
                let angle = z * width;
                if angle < 1.5 {
                    let (mass, expected) = (power.mass(angle), integral(&power, angle));
                    assert!((mass - expected).abs() <= 1e-9 * expected, "{power:?} {angle}: {mass} {expected}");
                    assert_eq!(power.mass(-angle), -mass);
                }
            }
            assert!((power.mass(FRAC_PI_2) - 0.5).abs() < 1e-12);
        }
    }

    /// Both series and the saturated end meet.
    #[test]
    fn masses_are_continuous() {
        for power in EXPONENTS.map(CosinePower::new) {
            let edges = [FRAC_PI_2 / 2.0, libm::acos(libm::exp(-SATURATION / power.exponent.max(1e-9)))];
            for edge in edges {
                let (below, above) = (power.mass(edge * (1.0 - 1e-12)), power.mass(edge * (1.0 + 1e-12)));
                assert!((above - below).abs() < 1e-10, "{power:?} {edge}: {below} {above}");
            }
        }
    }

    #[test]
    fn any_angle_alike() {
        let (stated, computed) = (CosinePower::default(), CosinePower::new(0.0));
        assert!((stated.peak - computed.peak).abs() < 1e-15 && stated.exponent == computed.exponent);
    }

    #[test]
    fn angles_invert_masses() {
        for power in EXPONENTS.map(CosinePower::new) {
            for i in 0..=2000 {
                let mass = f64::from(i) / 2000.0 - 0.5;
                let angle = power.angle(mass);
                let error = power.mass(angle) - mass;
                assert!(error.abs() < 1e-11, "{power:?}: {mass} gives {angle}, off by {error}");
            }
            for tail in [1e-7, 1e-10, 1e-14] {
                let angle = power.angle(0.5 - tail);
                assert!((power.mass(angle) - 0.5 + tail).abs() < 1e-12, "{power:?} {tail}");
            }
            assert_eq!(power.angle(0.0), 0.0);
        }
    }
}
