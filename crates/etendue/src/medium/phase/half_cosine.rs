use super::{Deflection, Lobe};
use crate::math::PI;

/// p = 3 / (8 pi) cos(a / 2), a the angle from the direction back.
pub(super) struct HalfCosine;

impl Lobe for HalfCosine {
    #[inline]
    fn density(&self, deflection: Deflection) -> f32 {
        // cos^2(a / 2) = (1 + cos a) / 2, and cos a is minus the cosine of the scattering angle.
        3.0 / (8.0 * PI) * (0.5 * deflection.ahead).sqrt()
    }

    /// From the distribution function 1 - cos^3(a / 2).
    #[inline]
    fn sample(&self, u: f32) -> Deflection {
        let cosine = libm::cbrt(1.0 - f64::from(u));
        Deflection::from_behind((2.0 * (1.0 - cosine * cosine)) as f32)
    }

    fn mean_cosine(&self) -> f32 {
        -0.2
    }
}
