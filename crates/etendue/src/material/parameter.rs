//! Parameters of materials: a number or a colour, alone or times a texture.

use crate::{math::Vec2, spectrum::Spectrum, texture::Texture};
use std::sync::Arc;

/// A parameter's value: `factor`, times the texture's value if there is one. `T` is what a texture is: an image, or while
/// a scene is read, the name of one.
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
    /// The value at texture coordinates.
    #[inline]
    pub fn at(&self, uv: Vec2) -> Spectrum {
        match &self.texture {
            None => self.factor,
            Some(texture) => self.factor * texture.color(uv),
        }
    }
}

impl Number {
    /// The value at texture coordinates.
    #[inline]
    pub fn at(&self, uv: Vec2) -> f32 {
        match &self.texture {
            None => self.factor,
            Some(texture) => self.factor * texture.number(uv),
        }
    }

    /// Least and most that [`Self::at`] can be.
    pub fn range(&self) -> [f32; 2] {
        match &self.texture {
            None => [self.factor; 2],
            Some(texture) => {
                let [low, high] = texture.range().map(|value| self.factor * value);
                [low.min(high), low.max(high)]
            }
        }
    }
}
