//! Textures: images that give surface parameters.

mod image;
mod mapping;

pub use image::{Samples, TextureImage, TextureImageError, Transfer};
pub use mapping::{Channel, Filtering, Mapping, UvTransform, Wrap};

use crate::{math::Vec2, spectrum::Spectrum};
use std::sync::Arc;

/// An image on a surface. Texture coordinate v points up: (0, 0) is the lower left corner of the image, (1, 1) the upper
/// right one.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// The texels; shared between textures.
    pub image: Arc<TextureImage>,
    /// How texture coordinates become texels, and texels values.
    pub mapping: Mapping,
}

impl Texture {
    /// An image that is repeated, filtered and otherwise as it is.
    pub fn new(image: Arc<TextureImage>) -> Self {
        Self { image, mapping: Mapping::default() }
    }

    /// The colour at `uv`, linear; grey where the image has no colour.
    #[inline]
    pub fn color(&self, uv: Vec2) -> Spectrum {
        let [r, g, b, _] = self.lookup(uv);
        let Mapping { base, gain, .. } = self.mapping;
        Spectrum([r, g, b].map(|value| base + gain * value))
    }

    /// The channel of [`Mapping::channel`] at `uv`.
    #[inline]
    pub fn number(&self, uv: Vec2) -> f32 {
        let Mapping { base, gain, channel, .. } = self.mapping;
        base + gain * channel.of(self.lookup(uv))
    }

    /// Least and most that [`Self::number`] can be, or that a channel of [`Self::color`] can.
    pub fn range(&self) -> [f32; 2] {
        let Mapping { base, gain, channel, wrap, .. } = self.mapping;
        let [mut low, high] = match channel {
            Channel::Alpha if !self.image.is_translucent() => [1.0, 1.0],
            Channel::Alpha => [0.0, 1.0],
            _ => self.image.range(),
        };
        if wrap.contains(&Wrap::Black) {
            low = low.min(0.0);
        }
        let (a, b) = (base + gain * low, base + gain * high);
        [a.min(b), a.max(b)]
    }

    /// Red, green, blue, opacity.
    #[inline]
    fn lookup(&self, uv: Vec2) -> [f32; 4] {
        let Mapping { wrap, filtering, transform, .. } = &self.mapping;
        let uv = transform.apply(uv);
        match filtering {
            Filtering::Nearest => self.nearest(uv, *wrap),
            Filtering::Bilinear => self.bilinear(uv, *wrap),
        }
    }

    #[inline]
    fn nearest(&self, uv: Vec2, wrap: [Wrap; 2]) -> [f32; 4] {
        let [width, height] = self.image.size();
        let x = wrap[0].texel(wrap[0].fold(uv.x) * width as f32, width);
        let y = wrap[1].texel(wrap[1].fold(1.0 - uv.y) * height as f32, height);
        self.texel(x, y)
    }

    #[inline]
    fn bilinear(&self, uv: Vec2, wrap: [Wrap; 2]) -> [f32; 4] {
        let [width, height] = self.image.size();
        let x = wrap[0].fold(uv.x) * width as f32 - 0.5;
        let y = wrap[1].fold(1.0 - uv.y) * height as f32 - 0.5;
        let (left, top) = (x.floor(), y.floor());
        let (fx, fy) = (x - left, y - top);
        let columns = [wrap[0].texel(left, width), wrap[0].texel(left + 1.0, width)];
        let rows = [wrap[1].texel(top, height), wrap[1].texel(top + 1.0, height)];
        let mut sum = [0.0; 4];
        for (row, wy) in rows.into_iter().zip([1.0 - fy, fy]) {
            for (column, wx) in columns.into_iter().zip([1.0 - fx, fx]) {
                let weight = wx * wy;
                for (sum, value) in sum.iter_mut().zip(self.texel(column, row)) {
                    *sum += weight * value;
                }
            }
        }
        sum
    }

    /// A texel, or nothing where the image is not.
    #[inline]
    fn texel(&self, x: Option<u32>, y: Option<u32>) -> [f32; 4] {
        match (x, y) {
            (Some(x), Some(y)) => self.image.texel(x, y),
            _ => [0.0; 4],
        }
    }
}
