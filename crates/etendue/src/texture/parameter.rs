//! Parameters of materials and textures: a number or a colour, alone or times a texture.

use super::{Lookup, Texture};
use crate::spectrum::Spectrum;
use std::sync::Arc;

/// A parameter's value: `factor`, times the texture's value if there is one. `T` is what a texture is: in the renderer one
/// with images, while a scene is read one with the names of files.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Parameter<V, T = Arc<Texture>> {
    /// The value, or what the texture is multiplied by.
    pub factor: V,
    /// Varies the value over the surface.
    pub texture: Option<T>,
}

/// A colour over a surface.
pub type Color<T = Arc<Texture>> = Parameter<Spectrum, T>;
/// A number over a surface.
pub type Number<T = Arc<Texture>> = Parameter<f32, T>;

impl<V, T> Parameter<V, T> {
    /// The same everywhere.
    pub const fn constant(value: V) -> Self {
        Self { factor: value, texture: None }
    }
}

impl<T> From<Spectrum> for Color<T> {
    fn from(color: Spectrum) -> Self {
        Self::constant(color)
    }
}

impl<T> From<f32> for Number<T> {
    fn from(number: f32) -> Self {
        Self::constant(number)
    }
}

impl Color {
    /// The value at a point.
    #[inline]
    pub fn at(&self, at: &Lookup) -> Spectrum {
        match &self.texture {
            None => self.factor,
            Some(texture) => self.factor * texture.color(at),
        }
    }

    /// Least and most that a channel of [`Self::at`] can be.
    pub fn range(&self) -> [f32; 2] {
        let factor = [self.factor.min_component(), self.factor.max_component()];
        self.texture.as_ref().map_or(factor, |texture| product(factor, texture.range()))
    }
}

impl Number {
    /// The value at a point.
    #[inline]
    pub fn at(&self, at: &Lookup) -> f32 {
        match &self.texture {
            None => self.factor,
            Some(texture) => self.factor * texture.number(at),
        }
    }

    /// Least and most that [`Self::at`] can be.
    pub fn range(&self) -> [f32; 2] {
        self.texture.as_ref().map_or([self.factor; 2], |texture| product([self.factor; 2], texture.range()))
    }
}

/// Least and most of the products of two intervals' numbers.
pub(super) fn product([a, b]: [f32; 2], [c, d]: [f32; 2]) -> [f32; 2] {
    let products = [a * c, a * d, b * c, b * d];
    [products.into_iter().fold(f32::INFINITY, f32::min), products.into_iter().fold(f32::NEG_INFINITY, f32::max)]
}
