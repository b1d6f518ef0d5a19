//! Texels as they were stored, decoded when they are looked up: an 8-bit image stays a byte a sample.

use super::pyramid::{Level, pyramid};
use crate::math::Vec2;
use etendue_accel::prefetch;
use std::sync::{Arc, OnceLock};

/// Samples as stored, row by row from the top left, the channels of a texel side by side.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// 0 to 255 stand for 0 to 1.
    U8(Arc<[u8]>),
    /// 0 to 65535 stand for 0 to 1.
    U16(Arc<[u16]>),
    /// Values as they are.
    F32(Arc<[f32]>),
}

impl Samples {
    fn len(&self) -> usize {
        match self {
            Self::U8(samples) => samples.len(),
            Self::U16(samples) => samples.len(),
            Self::F32(samples) => samples.len(),
        }
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        match self {
            Self::U8(samples) => samples.len(),
            Self::U16(samples) => 2 * samples.len(),
            Self::F32(samples) => 4 * samples.len(),
        }
    }
}

/// Longest side, texels.
const MAX_SIDE: u32 = 1 << 24;

/// What stored colour means. Opacity is always linear.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfer {
    /// Proportional to light, or no colour at all: heights, normals, roughness.
    Linear,
    /// Encoded as IEC 61966-2-1 says.
    Srgb,
}

/// An image that cannot be.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum TextureImageError {
    /// No texels, or more than 2^24 along a side.
    #[error("a texture of {0} x {1} texels")]
    Size(u32, u32),
    /// Not 1 to 4 channels.
    #[error("a texture of {0} channels; 1 to 4 are known")]
    Channels(usize),
    /// The samples are not width x height x channels.
    #[error("{given} samples where {expected} were expected")]
    Samples {
        /// How many there are.
        given: usize,
        /// How many there must be.
        expected: u64,
    },
    /// A sample is NaN or infinite.
    #[error("texel {0}, {1} is not finite")]
    NotFinite(u32, u32),
}

/// An image of 1 (grey), 2 (grey, opacity), 3 (colour) or 4 (colour, opacity) channels.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureImage {
    width: u32,
    height: u32,
    channels: usize,
    samples: Samples,
    /// Decoded values of all stored ones, of colour and of opacity; empty for [`Samples::F32`].
    decoded: Arc<[f32]>,
    transfer: Transfer,
    range: [f32; 2],
    translucent: bool,
    /// Coarser copies, once asked for.
    coarser: OnceLock<Arc<[Level]>>,
}

impl TextureImage {
    /// Checks and prepares an image. [`Transfer::Srgb`] applies to 8-bit and 16-bit samples; floats are linear.
    ///
    /// # Errors
    /// When sizes do not fit together or a sample is not finite.
    pub fn new(
        width: u32,
        height: u32,
        channels: usize,
        samples: Samples,
        transfer: Transfer,
    ) -> Result<Self, TextureImageError> {
        if !(1..=MAX_SIDE).contains(&width) || !(1..=MAX_SIDE).contains(&height) {
            return Err(TextureImageError::Size(width, height));
        }
        if !(1..=4).contains(&channels) {
            return Err(TextureImageError::Channels(channels));
        }
        let expected = u64::from(width) * u64::from(height) * channels as u64;
        if samples.len() as u64 != expected {
            return Err(TextureImageError::Samples { given: samples.len(), expected });
        }
        if let Samples::F32(values) = &samples
            && let Some(bad) = values.iter().position(|v| !v.is_finite())
        {
            let texel = bad / channels;
            let width = width as usize;
            return Err(TextureImageError::NotFinite((texel % width) as u32, (texel / width) as u32));
        }
        let decoded = match samples {
            Samples::U8(_) => decode_all(255, transfer),
            Samples::U16(_) => decode_all(65535, transfer),
            Samples::F32(_) => Arc::new([]),
        };
        let mut image = Self {
            width,
            height,
            channels,
            samples,
            decoded,
            transfer,
            range: [0.0, 1.0],
            translucent: false,
            coarser: OnceLock::new(),
        };
        image.range = image.find_range();
        image.translucent = image.find_translucent();
        Ok(image)
    }

    /// The same samples with another meaning; nothing is copied.
    pub fn with_transfer(&self, transfer: Transfer) -> Self {
        let decoded = match self.samples {
            Samples::U8(_) => decode_all(255, transfer),
            Samples::U16(_) => decode_all(65535, transfer),
            Samples::F32(_) => Arc::new([]),
        };
        let mut image = Self { decoded, transfer, coarser: OnceLock::new(), ..self.clone() };
        image.range = image.find_range();
        image
    }

    /// Width and height, texels.
    #[inline]
    pub fn size(&self) -> [u32; 2] {
        [self.width, self.height]
    }

    /// Channels a texel, 1 to 4.
    pub fn channels(&self) -> usize {
        self.channels
    }

    /// What stored colour means.
    pub fn transfer(&self) -> Transfer {
        self.transfer
    }

    /// True if texels have an opacity.
    pub fn has_alpha(&self) -> bool {
        self.channels.is_multiple_of(2)
    }

    /// True if some texel's opacity is below 1.
    pub fn is_translucent(&self) -> bool {
        self.translucent
    }

    fn find_translucent(&self) -> bool {
        let alphas = |n: usize| (self.channels - 1..n).step_by(self.channels);
        self.has_alpha()
            && match &self.samples {
                Samples::U8(s) => alphas(s.len()).any(|i| s[i] < u8::MAX),
                Samples::U16(s) => alphas(s.len()).any(|i| s[i] < u16::MAX),
                Samples::F32(s) => alphas(s.len()).any(|i| s[i] < 1.0),
            }
    }

    /// Bytes of the samples.
    pub fn bytes(&self) -> usize {
        self.samples.bytes()
    }

    /// Makes the coarser copies that filtered lookups read, unless they are there: of half the width and height, and again,
    /// down to one texel. They take two thirds of the bytes of an 8-bit image, else one third.
    pub fn build_levels(&self) {
        self.coarser.get_or_init(|| pyramid(self));
    }

    /// The coarser copies, finest first; none before [`Self::build_levels`].
    #[inline]
    pub fn levels(&self) -> &[Level] {
        self.coarser.get().map_or(&[], |levels| levels)
    }

    /// True if samples are floats, of any size.
    pub(super) fn is_float(&self) -> bool {
        matches!(self.samples, Samples::F32(_))
    }

    /// Least and most decoded value of any channel.
    pub fn range(&self) -> [f32; 2] {
        self.range
    }

    /// Half of a texel in texture coordinates.
    pub fn half_texel(&self) -> Vec2 {
        Vec2::new(0.5 / self.width as f32, 0.5 / self.height as f32)
    }

    /// Red, green, blue, opacity of a texel, linear; `x < width` from the left, `y < height` from the top.
    #[inline]
    pub fn texel(&self, x: u32, y: u32) -> [f32; 4] {
        let first = (y as usize * self.width as usize + x as usize) * self.channels;
        let texel = first..first + self.channels;
        match &self.samples {
            Samples::U8(samples) => colour(&samples[texel], |v| self.decoded[usize::from(v)], |v| f32::from(v) / 255.0),
            Samples::U16(samples) => {
                colour(&samples[texel], |v| self.decoded[usize::from(v)], |v| f32::from(v) / 65535.0)
            }
            Samples::F32(samples) => colour(&samples[texel], |v| v, |v| v),
        }
    }

    /// Asks for a texel, which is read from memory soon.
    #[inline]
    pub(super) fn prefetch(&self, x: u32, y: u32) {
        let first = (y as usize * self.width as usize + x as usize) * self.channels;
        match &self.samples {
            Samples::U8(samples) => samples.get(first).into_iter().for_each(prefetch),
            Samples::U16(samples) => samples.get(first).into_iter().for_each(prefetch),
            Samples::F32(samples) => samples.get(first).into_iter().for_each(prefetch),
        }
    }

    fn find_range(&self) -> [f32; 2] {
        fn extremes<T: Copy + PartialOrd>(samples: &[T]) -> Option<(T, T)> {
            let first = *samples.first()?;
            let extend = |(low, high): (T, T), &v: &T| (if v < low { v } else { low }, if v > high { v } else { high });
            Some(samples.iter().fold((first, first), extend))
        }
        // Opacities are among the samples; they only make the range wider.
        let decode = |v: usize| self.decoded[v];
        let found = match &self.samples {
            Samples::U8(s) => extremes(s).map(|(a, b)| [decode(a.into()), decode(b.into())]),
            Samples::U16(s) => extremes(s).map(|(a, b)| [decode(a.into()), decode(b.into())]),
            Samples::F32(s) => extremes(s).map(|(a, b)| [a, b]),
        };
        let [low, high] = found.unwrap_or([0.0, 1.0]);
        if self.has_alpha() { [low.min(0.0), high.max(1.0)] } else { [low, high] }
    }
}

/// Red, green, blue, opacity of a texel of 1 to 4 channels.
#[inline]
pub(super) fn colour<T: Copy>(texel: &[T], decode: impl Fn(T) -> f32, alpha: impl Fn(T) -> f32) -> [f32; 4] {
    match *texel {
        [grey] => {
            let grey = decode(grey);
            [grey, grey, grey, 1.0]
        }
        [grey, a] => {
            let grey = decode(grey);
            [grey, grey, grey, alpha(a)]
        }
        [r, g, b] => [decode(r), decode(g), decode(b), 1.0],
        [r, g, b, a] => [decode(r), decode(g), decode(b), alpha(a)],
        _ => [0.0; 4],
    }
}

/// The values of the stored numbers 0 to `most`.
fn decode_all(most: u32, transfer: Transfer) -> Arc<[f32]> {
    let decode = |v: u32| {
        let v = f64::from(v) / f64::from(most);
        match transfer {
            Transfer::Linear => v as f32,
            Transfer::Srgb if v <= 0.04045 => (v / 12.92) as f32,
            Transfer::Srgb => libm::pow((v + 0.055) / 1.055, 2.4) as f32,
        }
    };
    (0..=most).map(decode).collect()
}
