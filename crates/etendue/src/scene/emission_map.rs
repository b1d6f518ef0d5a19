//! How much an emission texture emits over any part of it, in constant time.

use crate::{
    material::Color,
    math::Vec2,
    texture::{Mapping, Pattern, Wrap},
};

/// Blocks along a side: a texel each where the image has no more.
const MAX_BLOCKS: u32 = 1024;
/// Sums count in units of the brightest texel over this, rounded up: whole, so that differences are exact.
const UNITS: f64 = (1 << 20) as f64;
/// Further than this from the image, in texels, single precision does not tell where a lookup goes.
const FAR: f64 = (1 << 22) as f64;

/// Sums over an emission texture's blocks of texels (a summed-area table: Crow 1984).
#[derive(Debug)]
pub(super) struct EmissionMap {
    mapping: Mapping,
    size: [u32; 2],
    blocks: [u32; 2],
    /// Units in the blocks left of and above each corner.
    sums: Vec<u64>,
    /// Radiance of a unit, mean of the channels.
    unit: f64,
    /// Radiance beyond the edges of a black-bordered image.
    outside: f64,
}

/// Parts of an axis, in blocks, `from..to`; two where a repeated image's edge is crossed, else the second is empty.
struct Parts {
    blocks: [[u32; 2]; 2],
    leaves: bool,
}

impl EmissionMap {
    /// `None` if the colour has no texture, or none that is an image.
    pub fn new(color: &Color) -> Option<Self> {
        let texture = color.texture.as_ref()?;
        let Pattern::Image(image) = &texture.pattern else { return None };
        let (size, mapping) = (image.size(), texture.mapping);
        let radiance = |texel: [f32; 4]| -> f64 {
            let channel = |c: usize| f64::from(color.factor[c] * (mapping.base + mapping.gain * texel[c])).max(0.0);
            (channel(0) + channel(1) + channel(2)) / 3.0
        };
        let all = || (0..size[1]).flat_map(move |y| (0..size[0]).map(move |x| (x, y)));
        let brightest = all().map(|(x, y)| radiance(image.texel(x, y))).fold(0.0, f64::max).min(f64::MAX);
        let unit = brightest / UNITS;
        let blocks = size.map(|texels| texels.min(MAX_BLOCKS));
        let stride = blocks[0] as usize + 1;
        let mut sums = vec![0u64; stride * (blocks[1] as usize + 1)];
        if unit > 0.0 {
            for (x, y) in all() {
                let [column, row] = [block_of(x, 0, size, blocks), block_of(y, 1, size, blocks)];
                let units = (radiance(image.texel(x, y)) / unit).min(UNITS);
                sums[(row + 1) * stride + column + 1] += units.ceil() as u64;
            }
        }
        for row in 1..=blocks[1] as usize {
            let mut line = 0;
            for column in 1..stride {
                line += sums[row * stride + column];
                sums[row * stride + column] = line + sums[(row - 1) * stride + column];
            }
        }
        let outside = if mapping.wrap.contains(&Wrap::Black) { radiance([0.0; 4]) } else { 0.0 };
        Some(Self { mapping, size, blocks, sums, unit, outside })
    }

    /// Texture coordinates in texels from the top left, before they are wrapped.
    fn texels(&self, uv: Vec2) -> [f64; 2] {
        let uv = self.mapping.transform.apply(uv);
        [f64::from(uv.x) * f64::from(self.size[0]), (1.0 - f64::from(uv.y)) * f64::from(self.size[1])]
    }

    /// The larger side of the box about an edge from `a` to `b`, texels.
    pub fn length(&self, a: Vec2, b: Vec2) -> f64 {
        let ([ax, ay], [bx, by]) = (self.texels(a), self.texels(b));
        (ax - bx).abs().max((ay - by).abs())
    }

    /// Mean radiance, W sr^-1 m^-2, over the box about some texture coordinates, in which lookups inside it end; 0 only if
    /// all of them are black.
    pub fn mean(&self, corners: &[Vec2]) -> f64 {
        let texels = |axis: usize| corners.iter().map(move |uv| self.texels(*uv)[axis]);
        let [x, y] = [0, 1].map(|axis| {
            let low = texels(axis).fold(f64::INFINITY, f64::min);
            let high = texels(axis).fold(f64::NEG_INFINITY, f64::max);
            let finite = texels(axis).all(f64::is_finite);
            // Half a texel by the filter, the rest for rounding.
            self.parts(axis, if finite { low - 1.0 } else { f64::NEG_INFINITY }, high + 1.0)
        });
        let (mut units, mut area) = (0, 0.0);
        for [left, right] in x.blocks {
            for [top, bottom] in y.blocks {
                units += self.sum([left, right], [top, bottom]);
                area += self.width(0, left, right) * self.width(1, top, bottom);
            }
        }
        let inside = if area > 0.0 { units as f64 * self.unit / area } else { 0.0 };
        if x.leaves || y.leaves { inside.max(self.outside) } else { inside }
    }

    /// Units in a box of blocks.
    fn sum(&self, [left, right]: [u32; 2], [top, bottom]: [u32; 2]) -> u64 {
        let stride = self.blocks[0] as usize + 1;
        let at = |x: u32, y: u32| self.sums[y as usize * stride + x as usize];
        (at(right, bottom) + at(left, top)) - (at(left, bottom) + at(right, top))
    }

    /// Texels in blocks `from..to`.
    fn width(&self, axis: usize, from: u32, to: u32) -> f64 {
        let start = |block: u32| (u64::from(block) * u64::from(self.size[axis])).div_ceil(u64::from(self.blocks[axis]));
        (start(to) - start(from)) as f64
    }

    /// The blocks that the texels from `low` to `high` fall on.
    fn parts(&self, axis: usize, low: f64, high: f64) -> Parts {
        let count = f64::from(self.size[axis]);
        let per_texel = f64::from(self.blocks[axis]) / count;
        let span = |from: f64, to: f64| {
            let last = self.blocks[axis] - 1;
            let first = ((from * per_texel) as u32).min(last);
            [first, ((to * per_texel).ceil() as u32).clamp(first + 1, last + 1)]
        };
        let one = |from: f64, to: f64| Parts { blocks: [span(from, to), [0, 0]], leaves: false };
        let whole = Parts { blocks: [[0, self.blocks[axis]], [0, 0]], leaves: true };
        if !(low > -FAR && high < FAR) {
            return whole;
        }
        let turns = (low / count).floor();
        match self.mapping.wrap[axis] {
            Wrap::Clamp => one(low.clamp(0.0, count), high.clamp(0.0, count)),
            Wrap::Black => {
                Parts { leaves: low < 0.0 || high > count, ..one(low.clamp(0.0, count), high.clamp(0.0, count)) }
            }
            _ if high - low >= count => whole,
            Wrap::Repeat => {
                let (from, to) = (low - turns * count, high - turns * count);
                match to <= count {
                    true => one(from, to),
                    // Less than the whole, so the parts overlap in one block at most.
                    false => {
                        let [rest, tail] = [span(0.0, to - count), span(from, count)];
                        Parts { blocks: [rest, [tail[0].max(rest[1]), tail[1].max(rest[1])]], leaves: false }
                    }
                }
            }
            Wrap::Mirror if high > (turns + 1.0) * count => whole,
            Wrap::Mirror if turns.rem_euclid(2.0) == 0.0 => one(low - turns * count, high - turns * count),
            Wrap::Mirror => one((turns + 1.0) * count - high, (turns + 1.0) * count - low),
        }
    }
}

/// The block that a texel is in.
fn block_of(texel: u32, axis: usize, size: [u32; 2], blocks: [u32; 2]) -> usize {
    (u64::from(texel) * u64::from(blocks[axis]) / u64::from(size[axis])) as usize
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{
        spectrum::Spectrum,
        texture::{Samples, Texture, TextureImage, Transfer, UvTransform},
    };
    use std::sync::Arc;

    fn image(size: [u32; 2], lit: &[[u32; 2]]) -> Arc<TextureImage> {
        let at = |i: u32| f32::from(lit.contains(&[i % size[0], i / size[0]]));
        let samples: Vec<f32> = (0..size[0] * size[1]).map(at).collect();
        Arc::new(TextureImage::new(size[0], size[1], 1, Samples::F32(samples.into()), Transfer::Linear).unwrap())
    }

    /// Numbers from 0 to 1 that look random.
    fn numbers() -> impl FnMut() -> f32 {
        let mut state = 1u32;
        move || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (state >> 8) as f32 / (1 << 24) as f32
        }
    }

    #[test]
    fn no_lookup_of_a_box_without_light_is_lit() {
        let mut next = numbers();
        for wrap in Wrap::ALL {
            let mut light = 0;
            for size in [[1, 1], [5, 3], [64, 48], [1500, 2]] {
                let lit = [[size[0] / 3, size[1] - 1]];
                let transform = UvTransform::new([1.3, -0.7], 20.0, [0.4, 0.3]);
                let mapping = Mapping { wrap: [wrap; 2], transform, ..Mapping::default() };
                let texture = Texture { pattern: Pattern::Image(image(size, &lit)), mapping };
                let color = Color { factor: Spectrum::splat(2.0), texture: Some(Arc::new(texture)) };
                let map = EmissionMap::new(&color).unwrap();
                let mut dark = 0;
                for _ in 0..3000 {
                    let corner = Vec2::new(next() * 6.0 - 3.0, next() * 6.0 - 3.0);
                    let extent = Vec2::new(next(), next()) * 0.3;
                    let mixed = [Vec2::new(extent.x, 0.0), Vec2::new(0.0, extent.y)].map(|e| corner + e);
                    let mean = map.mean(&[corner, corner + extent, mixed[0], mixed[1]]);
                    let inside = (0..10).map(|_| corner + extent * Vec2::new(next(), next()));
                    let brightest = inside.map(|uv| color.at(&uv.into())[0]).fold(0.0, f32::max);
                    assert!(mean > 0.0 || brightest == 0.0, "{wrap} {size:?} {corner} {extent}: {brightest}");
                    dark += u32::from(mean == 0.0);
                    light += u32::from(brightest > 0.0);
                }
                assert!(dark > 30 || size[0] < 64, "{wrap} {size:?}: {dark} dark");
            }
            assert!(light > 100, "{wrap}: {light} lit");
        }
    }

    #[test]
    fn the_mean_of_the_whole_image_is_exact() {
        let texture = Texture::new(image([40, 20], &[[3, 4], [39, 0], [0, 19]]));
        let color = Color { factor: Spectrum([1.0, 2.0, 3.0]), texture: Some(Arc::new(texture)) };
        let map = EmissionMap::new(&color).unwrap();
        let mean = map.mean(&[Vec2::ZERO, Vec2::ONE]);
        assert!((mean - 2.0 * 3.0 / 800.0).abs() < 1e-12, "{mean}");
        assert!((map.length(Vec2::ZERO, Vec2::new(0.5, 0.25)) - 20.0).abs() < 1e-9);
        assert_eq!(map.mean(&[Vec2::new(f32::NAN, 0.0), Vec2::ONE]), mean);
    }
}
