//! Radiometric quantities over wavelength: linear RGB with Rec. 709 primaries today.

use std::ops::{Add, AddAssign, Div, Index, Mul, MulAssign, Sub};

/// A spectral quantity (radiance, reflectance, throughput), linear RGB.
#[repr(transparent)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Spectrum(pub [f32; 3]);

impl Spectrum {
    /// Zero in every channel.
    pub const BLACK: Self = Self([0.0; 3]);
    /// One in every channel.
    pub const ONE: Self = Self([1.0; 3]);

    /// The same value in every channel.
    #[inline]
    pub const fn splat(value: f32) -> Self {
        Self([value; 3])
    }

    /// Applies `f` to each channel.
    #[inline(always)]
    pub fn map(self, f: impl Fn(f32) -> f32) -> Self {
        let [r, g, b] = self.0;
        Self([f(r), f(g), f(b)])
    }

    /// Largest channel.
    #[inline(always)]
    pub fn max_component(self) -> f32 {
        let [r, g, b] = self.0;
        r.max(g).max(b)
    }

    /// Smallest channel.
    #[inline]
    pub fn min_component(self) -> f32 {
        let [r, g, b] = self.0;
        r.min(g).min(b)
    }

    /// Mean of the channels.
    #[inline(always)]
    pub fn mean(self) -> f32 {
        let [r, g, b] = self.0;
        (r + g + b) * (1.0 / 3.0)
    }

    /// Rec. 709 luminance.
    #[inline]
    pub fn luminance(self) -> f32 {
        let [r, g, b] = self.0;
        0.212_639 * r + 0.715_169 * g + 0.072_192 * b
    }

    /// True if every channel is zero.
    #[inline(always)]
    pub fn is_black(self) -> bool {
        let [r, g, b] = self.0;
        (r == 0.0) & (g == 0.0) & (b == 0.0)
    }

    /// True if every channel is finite.
    #[inline]
    pub fn is_finite(self) -> bool {
        self.0.iter().all(|c| c.is_finite())
    }
}

macro_rules! channelwise {
    ($($trait:ident $method:ident $op:tt),*) => {$(
        impl $trait for Spectrum {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                let ([a, b, c], [x, y, z]) = (self.0, other.0);
                Self([a $op x, b $op y, c $op z])
            }
        }
    )*};
}
channelwise!(Add add +, Sub sub -, Mul mul *, Div div /);

impl Mul<f32> for Spectrum {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: f32) -> Self {
        let [r, g, b] = self.0;
        Self([r * factor, g * factor, b * factor])
    }
}

impl Mul<Spectrum> for f32 {
    type Output = Spectrum;
    #[inline(always)]
    fn mul(self, spectrum: Spectrum) -> Spectrum {
        spectrum * self
    }
}

impl Div<f32> for Spectrum {
    type Output = Self;
    #[inline(always)]
    fn div(self, divisor: f32) -> Self {
        self.map(|c| c / divisor)
    }
}

impl AddAssign for Spectrum {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl MulAssign for Spectrum {
    #[inline]
    fn mul_assign(&mut self, other: Self) {
        *self = *self * other;
    }
}

impl MulAssign<f32> for Spectrum {
    #[inline]
    fn mul_assign(&mut self, factor: f32) {
        *self = *self * factor;
    }
}

impl Index<usize> for Spectrum {
    type Output = f32;
    #[inline]
    fn index(&self, channel: usize) -> &f32 {
        &self.0[channel]
    }
}
