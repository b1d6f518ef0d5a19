//! Coarser copies of an image, for lookups that stand for more than a texel (Williams, "Pyramidal Parametrics", 1983).

use super::image::{Samples, TextureImage, colour};
use std::sync::Arc;

/// A copy of an image with fewer texels, linear: 16 bits a sample of what has 8 or 16, else floats.
#[derive(Clone, Debug, PartialEq)]
pub struct Level {
    size: [u32; 2],
    channels: usize,
    samples: Samples,
}

/// What 1 is stored as.
const ONE: f32 = 65535.0;

impl Level {
    /// Width and height, texels.
    #[inline]
    pub fn size(&self) -> [u32; 2] {
        self.size
    }

    /// Red, green, blue, opacity of a texel, linear; `x < width` from the left, `y < height` from the top.
    #[inline]
    pub fn texel(&self, x: u32, y: u32) -> [f32; 4] {
        let first = (y as usize * self.size[0] as usize + x as usize) * self.channels;
        let texel = first..first + self.channels;
        let stored = |v: u16| f32::from(v) * (1.0 / ONE);
        match &self.samples {
            Samples::U16(samples) => colour(&samples[texel], stored, stored),
            Samples::F32(samples) => colour(&samples[texel], |v| v, |v| v),
            Samples::U8(_) => [0.0; 4],
        }
    }

    /// Bytes of the samples.
    pub fn bytes(&self) -> usize {
        self.samples.bytes()
    }
}

/// Halves an image until one texel is left.
pub(super) fn pyramid(image: &TextureImage) -> Arc<[Level]> {
    let (channels, floats) = (image.channels(), image.is_float());
    let mut levels: Vec<Level> = Vec::new();
    loop {
        let level = match levels.last() {
            None if image.size() == [1, 1] => break,
            None => halved(image.size(), channels, floats, |x, y| image.texel(x, y)),
            Some(finer) if finer.size == [1, 1] => break,
            Some(finer) => halved(finer.size, channels, floats, |x, y| finer.texel(x, y)),
        };
        levels.push(level);
    }
    levels.into()
}

/// The texels along an axis that a coarser one is the mean of, with their weights: of the `count` texels, the stretch from
/// `index / half` to `(index + 1) / half` of the axis. Odd counts share texels, so that every one counts alike.
fn taps(index: u32, half: u32, count: u32) -> ([f32; 3], u32) {
    let (index, half, count) = (u64::from(index), u64::from(half), u64::from(count));
    // In units of 1 / half of a texel.
    let (from, to) = (index * count, (index + 1) * count);
    let first = from / half;
    let weight = |texel: u64| {
        let overlap = to.min((texel + 1) * half).saturating_sub(from.max(texel * half));
        overlap as f32 / count as f32
    };
    ([first, first + 1, first + 2].map(weight), first as u32)
}

fn halved(size: [u32; 2], channels: usize, floats: bool, texel: impl Fn(u32, u32) -> [f32; 4]) -> Level {
    let half = size.map(|n| (n / 2).max(1));
    let count = half[0] as usize * half[1] as usize * channels;
    let mut means = Means { stored: Vec::new(), floats: Vec::new(), is_float: floats, channels };
    means.reserve(count);
    for y in 0..half[1] {
        let (rows, top) = taps(y, half[1], size[1]);
        for x in 0..half[0] {
            let (columns, left) = taps(x, half[0], size[0]);
            let mut sum = [0.0; 4];
            for (row, wy) in (top..).zip(rows).filter(|(_, weight)| *weight > 0.0) {
                for (column, wx) in (left..).zip(columns).filter(|(_, weight)| *weight > 0.0) {
                    let value = texel(column, row);
                    (0..4).for_each(|c| sum[c] += wx * wy * value[c]);
                }
            }
            means.push(sum);
        }
    }
    let samples = if floats { Samples::F32(means.floats.into()) } else { Samples::U16(means.stored.into()) };
    Level { size: half, channels, samples }
}

/// Texels on their way into a level.
struct Means {
    stored: Vec<u16>,
    floats: Vec<f32>,
    is_float: bool,
    channels: usize,
}

impl Means {
    fn reserve(&mut self, count: usize) {
        match self.is_float {
            true => self.floats.reserve_exact(count),
            false => self.stored.reserve_exact(count),
        }
    }

    fn push(&mut self, [r, g, b, a]: [f32; 4]) {
        let all = [r, g, b, a];
        let of: &[usize] = match self.channels {
            1 => &[0],
            2 => &[0, 3],
            3 => &[0, 1, 2],
            _ => &[0, 1, 2, 3],
        };
        match self.is_float {
            true => self.floats.extend(of.iter().map(|c| all[*c])),
            // The cast saturates.
            false => self.stored.extend(of.iter().map(|c| (all[*c] * ONE + 0.5) as u16)),
        }
    }
}
