use super::{Deflection, Lobe};
use crate::math::PI;

/// p = 3 / (16 pi) (1 + c^2), c the cosine of the scattering angle.
pub(super) struct Rayleigh;

impl Lobe for Rayleigh {
    #[inline]
    fn density(&self, deflection: Deflection) -> f32 {
        let cosine = deflection.cosine();
        3.0 / (16.0 * PI) * (1.0 + cosine * cosine)
    }

    /// Inverts the distribution function: c^3 + 3 c = 8 u - 4, a cubic with one real root (Cardano).
    #[inline]
    fn sample(&self, u: f32) -> Deflection {
        let half = 4.0 * f64::from(u) - 2.0;
        // The root of the larger magnitude, so that nothing cancels.
        let a = libm::cbrt(half.abs() + (half * half + 1.0).sqrt());
        let cosine = (a - 1.0 / a).copysign(half);
        Deflection { ahead: (1.0 - cosine).max(0.0) as f32, behind: (1.0 + cosine).max(0.0) as f32 }
    }

    fn mean_cosine(&self) -> f32 {
        0.0
    }
}
