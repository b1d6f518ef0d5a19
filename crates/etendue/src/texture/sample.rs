//! Values between and beyond the texels of an image.

use super::{Filtering, Lookup, Mapping, image::TextureImage, mapping::Wrap, pyramid::Level};
use crate::math::{Vec2, floor, ln, vec2};

/// Most lookups along the longer axis of a footprint; a longer one is blurred.
const MOST_PROBES: f32 = 8.0;

/// Red, green, blue, opacity at a point.
#[inline]
pub(super) fn lookup(image: &TextureImage, mapping: &Mapping, at: &Lookup) -> [f32; 4] {
    let uv = mapping.transform.apply(at.uv);
    let finest = Grid { size: image.size(), wrap: mapping.wrap, texel: |x, y| image.texel(x, y) };
    match mapping.filtering {
        Filtering::Nearest => finest.nearest(uv),
        Filtering::Bilinear => finest.bilinear(uv),
        Filtering::Trilinear => match footprint(image, mapping, at) {
            None => finest.bilinear(uv),
            Some(footprint) => filtered(image, mapping, uv, footprint),
        },
    }
}

/// Asks for the texels around a point of the finest image, which are looked up soon.
#[inline]
pub(super) fn prefetch(image: &TextureImage, mapping: &Mapping, uv: Vec2) {
    let (uv, [width, height], wrap) = (mapping.transform.apply(uv), image.size(), mapping.wrap);
    let x = wrap[0].fold(uv.x) * width as f32 - 0.5;
    let y = wrap[1].fold(1.0 - uv.y) * height as f32 - 0.5;
    for y in [y, y + 1.0] {
        if let (Some(x), Some(y)) = (wrap[0].texel(x, width), wrap[1].texel(y, height)) {
            image.prefetch(x, y);
        }
    }
}

/// An ellipse in transformed texture coordinates.
struct Spread {
    /// Its longer axis.
    along: Vec2,
    /// Points along that.
    probes: u32,
    /// Of the coarser copies, 0 being the image itself.
    level: f32,
}

/// `None` where the image itself is coarse enough.
#[inline]
fn footprint(image: &TextureImage, mapping: &Mapping, at: &Lookup) -> Option<Spread> {
    let size = image.size().map(|n| n as f32);
    let axes = at.footprint.uv.map(|axis| mapping.transform.linear(axis));
    let squares = axes.map(|a| vec2(a.x * size[0], a.y * size[1]).length_squared());
    let (along, long, short) = match squares[0] >= squares[1] {
        true => (axes[0], squares[0], squares[1]),
        false => (axes[1], squares[1], squares[0]),
    };
    // The shorter axis picks the level, so that surfaces seen at a grazing angle stay sharp across; several points are
    // taken along the longer one (Heckbert 1989 gives the exact mean; this is what graphics hardware does in its place).
    let (long, short) = (long.sqrt(), short.sqrt().max(long.sqrt() * (1.0 / MOST_PROBES)));
    // Also where something is not a number, or there are no coarser copies.
    if long.is_nan() || long <= 1.0 || image.levels().is_empty() {
        return None;
    }
    let ratio = long / short.max(1.0);
    // Where both are infinite, one.
    let probes = if ratio > 1.0 { (-floor(-ratio)).min(MOST_PROBES) as u32 } else { 1 };
    let level = if short > 1.0 { ln(short) * std::f32::consts::LOG2_E } else { 0.0 };
    Some(Spread { along, probes, level })
}

fn filtered(image: &TextureImage, mapping: &Mapping, uv: Vec2, spread: Spread) -> [f32; 4] {
    let Spread { along, probes, level } = spread;
    let mut sum = [0.0; 4];
    for probe in 0..probes {
        let place = (probe as f32 + 0.5) / probes as f32 - 0.5;
        let value = trilinear(image, mapping.wrap, uv + along * place, level);
        (0..4).for_each(|c| sum[c] += value[c]);
    }
    sum.map(|sum| sum / probes as f32)
}

fn trilinear(image: &TextureImage, wrap: [Wrap; 2], uv: Vec2, level: f32) -> [f32; 4] {
    let levels = image.levels();
    let level = level.min(levels.len() as f32);
    let (finer, part) = (floor(level), level - floor(level));
    // Level 0 is the image, level n the n-th copy.
    let of = |number: usize| match number.checked_sub(1).and_then(|copy| levels.get(copy)) {
        None => Grid { size: image.size(), wrap, texel: |x, y| image.texel(x, y) }.bilinear(uv),
        Some(copy) => grid(copy, wrap).bilinear(uv),
    };
    let fine = of(finer as usize);
    if part == 0.0 {
        return fine;
    }
    let coarse = of(finer as usize + 1);
    [0, 1, 2, 3].map(|c| fine[c] + part * (coarse[c] - fine[c]))
}

fn grid(level: &Level, wrap: [Wrap; 2]) -> Grid<impl Fn(u32, u32) -> [f32; 4] + '_> {
    Grid { size: level.size(), wrap, texel: |x, y| level.texel(x, y) }
}

/// Texels, and what lies beyond them.
struct Grid<T> {
    size: [u32; 2],
    wrap: [Wrap; 2],
    texel: T,
}

impl<T: Fn(u32, u32) -> [f32; 4]> Grid<T> {
    #[inline]
    fn nearest(&self, uv: Vec2) -> [f32; 4] {
        let ([width, height], wrap) = (self.size, self.wrap);
        let x = wrap[0].texel(wrap[0].fold(uv.x) * width as f32, width);
        let y = wrap[1].texel(wrap[1].fold(1.0 - uv.y) * height as f32, height);
        self.texel(x, y)
    }

    #[inline]
    fn bilinear(&self, uv: Vec2) -> [f32; 4] {
        let ([width, height], wrap) = (self.size, self.wrap);
        let x = wrap[0].fold(uv.x) * width as f32 - 0.5;
        let y = wrap[1].fold(1.0 - uv.y) * height as f32 - 0.5;
        let (left, top) = (floor(x), floor(y));
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
            (Some(x), Some(y)) => (self.texel)(x, y),
            _ => [0.0; 4],
        }
    }
}
