use super::{Deflection, Lobe};
use crate::math::PI;

/// p = (1 - g^2) / (4 pi (1 + g^2 - 2 g c)^(3/2)), c the cosine of the scattering angle.
///
/// A lobe with g < 0 is that of -g turned round, so only g >= 0 is computed. With h = 1 - c the bracket is (1 - g)^2 + 2 g h,
/// in which nothing cancels however narrow the lobe is.
pub(super) struct HenyeyGreenstein {
    pub(super) g: f32,
}

impl Lobe for HenyeyGreenstein {
    #[inline]
    fn density(&self, deflection: Deflection) -> f32 {
        let g = self.g.abs();
        let height = if self.g < 0.0 { deflection.behind } else { deflection.ahead };
        let narrow = 1.0 - g;
        let bracket = narrow * narrow + 2.0 * g * height;
        narrow * (1.0 + g) / (4.0 * PI * bracket * bracket.sqrt())
    }

    /// The usual inversion, solved for h: h = (1 - g)^2 u (2 (1 + g) - 2 g u) / (1 + g - 2 g u)^2. It holds for g = 0 too.
    #[inline]
    fn sample(&self, u: f32) -> Deflection {
        let g = self.g.abs();
        let narrow = 1.0 - g;
        // 1 + g - 2 g u and 2 (1 + g) - 2 g u, by positive terms.
        let rest = 2.0 * g * (1.0 - u);
        let ratio = narrow / (narrow + rest);
        let height = (ratio * ratio * u * (2.0 + rest)).min(2.0);
        if self.g < 0.0 { Deflection::from_behind(height) } else { Deflection::from_ahead(height) }
    }

    fn mean_cosine(&self) -> f32 {
        self.g
    }
}
