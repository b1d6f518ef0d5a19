//! Numbers for tests: a linear congruence (Numerical Recipes, 1992), of which the upper bits are used.

pub(crate) struct Random(pub u32);

impl Random {
    /// In [0, 1).
    pub fn unit(&mut self) -> f32 {
        self.0 = self.0.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        (self.0 >> 8) as f32 / (1 << 24) as f32
    }

    /// In a cube about the origin with sides of twice a size.
    pub fn point(&mut self, size: f32) -> [f32; 3] {
        [self.unit(), self.unit(), self.unit()].map(|x| size * (2.0 * x - 1.0))
    }
}
