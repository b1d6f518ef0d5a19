use super::{Deflection, Lobe};
use crate::math::{PI, asin};
use std::{f64, sync::LazyLock};

/// p = 2 / (3 pi^2) (sin a + (pi - a) cos a), a the angle from the direction back.
///
/// It is the density of a cosine-distributed direction about a normal that is itself cosine-distributed about the direction
/// back: light hits a ball in proportion to the cosine, and leaves it so. That construction takes four numbers; the
/// distribution function of a is inverted instead, which takes one and keeps neighbours together.
pub(super) struct LambertSphere;

impl Lobe for LambertSphere {
    #[inline]
    fn density(&self, deflection: Deflection) -> f32 {
        // By b = pi - a, the scattering angle: sin b - b cos b. It comes from the nearer end, where the arc sine is precise.
        let [half_sine, half_cosine] = [deflection.ahead, deflection.behind].map(|x| (0.5 * x).sqrt());
        let b = if half_sine < half_cosine { 2.0 * asin(half_sine) } else { PI - 2.0 * asin(half_cosine) };
        let b2 = b * b;
        let bracket = if b < 0.7 {
            // The difference cancels; its series.
            b * b2 * (1.0 / 3.0 - b2 * (1.0 / 30.0 - b2 * (1.0 / 840.0 - b2 * (1.0 / 45_360.0))))
        } else {
            2.0 * half_sine * half_cosine - b * deflection.cosine()
        };
        2.0 / (3.0 * PI * PI) * bracket.max(0.0)
    }

    #[inline]
    fn sample(&self, u: f32) -> Deflection {
        let (sin, cos) = libm::sincos(angle(f64::from(u)));
        // 1 - cos a, by the sine where it cancels; `behind` is 1 minus the cosine of a.
        let behind = if cos > 0.0 { sin * sin / (1.0 + cos) } else { 1.0 - cos };
        let ahead = if cos < 0.0 { sin * sin / (1.0 - cos) } else { 1.0 + cos };
        Deflection { ahead: ahead as f32, behind: behind as f32 }
    }

    fn mean_cosine(&self) -> f32 {
        -4.0 / 9.0
    }
}

/// Equal steps of the angle between 0 and pi. The last step holds less than 2^-24 of the probability, and is never drawn.
const STEPS: usize = 64;
const STEP: f64 = f64::consts::PI / STEPS as f64;

/// The distribution function at every step.
static TABLE: LazyLock<[f64; STEPS + 1]> =
    LazyLock::new(|| std::array::from_fn(|i| distribution_and_density(i as f64 * STEP)[0]));

/// The probability of angles below `a` in [0, pi], and its derivative.
fn distribution_and_density(a: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(a);
    let rest = f64::consts::PI - a;
    let (sin_double, cos_double) = (2.0 * sin * cos, 1.0 - 2.0 * sin * sin);
    let integral = 0.5 * a - 0.375 * sin_double + 0.25 * (f64::consts::PI - rest * cos_double);
    [integral, sin * (sin + rest * cos)].map(|x| x * (4.0 / (3.0 * f64::consts::PI)))
}

/// The angle with the probability `u` in [0, 1) below it, by Newton's method from a table.
fn angle(u: f64) -> f64 {
    let above = TABLE.partition_point(|&probability| probability <= u).clamp(1, STEPS);
    let (low, high) = (TABLE[above - 1], TABLE[above]);
    let range = [(above - 1) as f64 * STEP, above as f64 * STEP];
    // In the first step the probability grows with the square of the angle.
    let within = ((u - low) / (high - low)).clamp(0.0, 1.0);
    let mut a = range[0] + STEP * if above == 1 { within.sqrt() } else { within };
    for _ in 0..3 {
        let [probability, density] = distribution_and_density(a);
        if density > 0.0 {
            a = (a - (probability - u) / density).clamp(range[0], range[1]);
        }
    }
    a
}
