//! The film: exact sums of samples, in two halves, and their development into an image.
//!
//! Sums are fixed point and wide enough to be exact, so adding is associative: the picture does not depend on the order in
//! which samples arrive. Samples with an even and an odd index form two halves that are scrambled independently; the
//! difference of their means is what the variance is estimated from.

use crate::{
    image::{Channel, ChannelData, Image},
    math::Vec3,
    spectrum::Spectrum,
};
use std::{
    fmt,
    str::FromStr,
    sync::{
        Mutex, MutexGuard, PoisonError,
        atomic::{AtomicU64, Ordering},
    },
};

/// Fractional bits of a pixel's sum.
const SUM_FRACTION: i32 = 64;
/// Fractional bits of the difference of the two halves.
const DIFFERENCE_FRACTION: i32 = 24;
/// Samples of this size or more are left out: 2^24 of them still fit in a sum.
const SAMPLE_LIMIT: f32 = 549_755_813_888.0; // 2^39
/// Differences are kept modulo 2^64; while the sum stays below this they cannot have wrapped.
const DIFFERENCE_LIMIT: f64 = 549_755_813_888.0; // 2^(63 - DIFFERENCE_FRACTION)
/// Pixels that a film may have; 80 bytes each.
const MAX_PIXELS: u64 = 1 << 28;

/// An extra layer of the image, from the first surface that a camera ray meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Aov {
    /// Directional albedo of the material: `Albedo.R`, `.G`, `.B`.
    Albedo,
    /// Shading normal in world space: `N.X`, `.Y`, `.Z`.
    Normal,
    /// Distance along the camera's axis, metres, averaged over the samples that hit something: `Depth.Z`.
    Depth,
    /// Object and material of the pixel's first sample, counted from 1, 0 for none; never filtered: `Id.Object`,
    /// `Id.Material`.
    Ids,
    /// Estimated variance of the pixel's mean: `Variance.R`, `.G`, `.B`.
    Variance,
}

impl Aov {
    /// Every layer.
    pub const ALL: [Self; 5] = [Self::Albedo, Self::Normal, Self::Depth, Self::Ids, Self::Variance];

    /// The name it has in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Albedo => "albedo",
            Self::Normal => "normal",
            Self::Depth => "depth",
            Self::Ids => "ids",
            Self::Variance => "variance",
        }
    }
}

impl fmt::Display for Aov {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// A name that is none of the known ones.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown {kind} `{name}`; expected one of {expected}")]
pub struct UnknownName {
    /// What was looked for.
    pub kind: &'static str,
    /// What was given.
    pub name: String,
    /// The known names.
    pub expected: String,
}

impl FromStr for Aov {
    type Err = UnknownName;
    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL.into_iter().find(|a| a.name() == name).ok_or_else(|| UnknownName {
            kind: "layer",
            name: name.to_owned(),
            expected: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// Size and layers of a film.
#[derive(Clone, Debug)]
pub struct FilmSettings {
    /// Width and height of the whole image, pixels.
    pub resolution: [u32; 2],
    /// The part that is rendered: x0, y0 inclusive, x1, y1 exclusive, absolute pixels; absent: all.
    pub crop: Option<[u32; 4]>,
    /// Layers beside the colour.
    pub aovs: Vec<Aov>,
}

/// A film that cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum FilmError {
    /// No pixels.
    #[error("the image has no pixels: {0} x {1}")]
    Empty(u32, u32),
    /// Beyond the limit.
    #[error("the image is too large: {0} x {1} pixels, at most {MAX_PIXELS} in all")]
    TooLarge(u32, u32),
    /// Crop outside of the image.
    #[error("the crop {0:?} is empty or leaves the image of {1} x {2} pixels")]
    Crop([u32; 4], u32, u32),
    /// The allocator refused.
    #[error("not enough memory for an image of {0} x {1} pixels")]
    OutOfMemory(u32, u32),
}

/// What one camera path brought home.
#[derive(Clone, Copy, Debug, Default)]
pub struct PathSample {
    /// Radiance.
    pub radiance: Spectrum,
    /// The first surface, if there was one.
    pub first: FirstHit,
}

/// The first surface that a camera ray met, for the extra layers.
#[derive(Clone, Copy, Debug, Default)]
pub struct FirstHit {
    /// Directional albedo.
    pub albedo: Spectrum,
    /// Shading normal, world space.
    pub normal: Vec3,
    /// Distance along the camera's axis; 0 for none.
    pub depth: f32,
    /// Object, counted from 1; 0 for none.
    pub object: u32,
    /// Material, counted from 1; 0 for none.
    pub material: u32,
}

/// The sums of one pixel: 80 bytes.
#[derive(Clone, Copy, Debug, Default)]
struct ColourSums {
    /// Both halves.
    sum: [i128; 3],
    /// Even minus odd half, modulo 2^64.
    difference: [i64; 3],
    /// Samples in the even and the odd half.
    count: [u32; 2],
}

/// Where depth is in [`LayerSums::sum`].
const DEPTH: usize = 6;

/// The sums of a pixel's extra layers.
#[derive(Clone, Copy, Debug, Default)]
struct LayerSums {
    /// Albedo, normal, depth.
    sum: [i128; DEPTH + 1],
    /// Samples, and those of them that hit something.
    samples: u32,
    hits: u32,
    ids: [u32; 2],
}

/// `value` as fixed point with [`SUM_FRACTION`] bits; exact for all but tiny values, which are rounded towards zero.
#[inline]
fn to_fixed(value: f32) -> i128 {
    let bits = value.to_bits();
    let exponent = (bits >> 23 & 0xff) as i32;
    let mantissa = i128::from(bits & 0x7f_ffff | if exponent > 0 { 0x80_0000 } else { 0 });
    let shift = exponent.max(1) - 150 + SUM_FRACTION;
    let magnitude = if shift >= 0 {
        mantissa << shift
    } else if shift > -24 {
        mantissa >> -shift
    } else {
        0
    };
    if value.is_sign_negative() { -magnitude } else { magnitude }
}

/// The value of a sum.
#[inline]
fn from_fixed(sum: i128) -> f64 {
    sum as f64 * (1.0 / 18_446_744_073_709_551_616.0) // 2^-64
}

impl ColourSums {
    fn add(&mut self, radiance: Spectrum, half: usize) {
        for (channel, value) in radiance.0.into_iter().enumerate() {
            let fixed = to_fixed(value);
            let coarse = (fixed >> (SUM_FRACTION - DIFFERENCE_FRACTION)) as i64;
            self.sum[channel] += fixed;
            self.difference[channel] = self.difference[channel].wrapping_add(if half == 0 { coarse } else { -coarse });
        }
        self.count[half] += 1;
    }

    fn merge(&mut self, other: &Self) {
        for channel in 0..3 {
            self.sum[channel] += other.sum[channel];
            self.difference[channel] = self.difference[channel].wrapping_add(other.difference[channel]);
        }
        self.count[0] += other.count[0];
        self.count[1] += other.count[1];
    }

    fn samples(&self) -> u32 {
        self.count[0] + self.count[1]
    }

    fn mean(&self, channel: usize) -> f32 {
        match self.samples() {
            0 => 0.0,
            n => (from_fixed(self.sum[channel]) / f64::from(n)) as f32,
        }
    }

    /// Estimated variance of the mean, from the two halves' means; infinite where a half is empty.
    fn variance_of_mean(&self, channel: usize) -> f32 {
        let [even, odd] = self.count.map(f64::from);
        let sum = from_fixed(self.sum[channel]);
        if even == 0.0 || odd == 0.0 || sum.abs() >= DIFFERENCE_LIMIT {
            return f32::INFINITY;
        }
        let difference = self.difference[channel] as f64 * (1.0 / f64::from(1u32 << DIFFERENCE_FRACTION));
        let (a, b) = ((sum + difference) / (2.0 * even), (sum - difference) / (2.0 * odd));
        // Each half mean has variance s / n_half; E (a - b)^2 = s (1/even + 1/odd), and the mean's variance is s / n.
        ((a - b) * (a - b) / ((1.0 / even + 1.0 / odd) * (even + odd))) as f32
    }
}

impl LayerSums {
    fn add(&mut self, first: &FirstHit, sample_index: u32) {
        if sample_index == 0 {
            self.ids = [first.object, first.material];
        }
        self.samples += 1;
        if first.object == 0 {
            return;
        }
        let [r, g, b] = first.albedo.0;
        let values = [r, g, b, first.normal.x, first.normal.y, first.normal.z, first.depth];
        if values.iter().any(|v| !is_storable(*v)) {
            return;
        }
        for (sum, value) in self.sum.iter_mut().zip(values) {
            *sum += to_fixed(value);
        }
        self.hits += 1;
    }

    fn merge(&mut self, other: &Self) {
        for (sum, more) in self.sum.iter_mut().zip(other.sum) {
            *sum += more;
        }
        self.samples += other.samples;
        self.hits += other.hits;
        // Only the unit that holds sample 0 has ids.
        for (id, more) in self.ids.iter_mut().zip(other.ids) {
            *id |= more;
        }
    }
}

/// True for what a pixel can take: finite, and small enough for the sums.
#[inline]
fn is_storable(value: f32) -> bool {
    value.abs() < SAMPLE_LIMIT
}

/// A rectangle of pixels, absolute coordinates: `x0, y0` inclusive, `x1, y1` exclusive.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelRect {
    /// Left.
    pub x0: u32,
    /// Top.
    pub y0: u32,
    /// Right, exclusive.
    pub x1: u32,
    /// Bottom, exclusive.
    pub y1: u32,
}

impl PixelRect {
    /// Pixels across.
    pub fn width(&self) -> u32 {
        self.x1 - self.x0
    }

    /// Pixels down.
    pub fn height(&self) -> u32 {
        self.y1 - self.y0
    }

    /// Pixels in all.
    pub fn pixels(&self) -> usize {
        self.width() as usize * self.height() as usize
    }
}

/// Samples of a tile that are on their way to the film: owned by one worker.
pub struct TileSums {
    rect: PixelRect,
    colour: Vec<ColourSums>,
    layers: Vec<LayerSums>,
    left_out: u64,
    first_left_out: Option<[u32; 2]>,
}

impl TileSums {
    /// Adds sample number `index` of an absolute pixel of this tile.
    #[inline]
    pub fn add(&mut self, pixel: [u32; 2], index: u32, sample: &PathSample) {
        let at = (pixel[1] - self.rect.y0) as usize * self.rect.width() as usize + (pixel[0] - self.rect.x0) as usize;
        if sample.radiance.0.iter().all(|v| is_storable(*v)) {
            self.colour[at].add(sample.radiance, (index & 1) as usize);
        } else {
            self.left_out += 1;
            let first = self.first_left_out.get_or_insert(pixel);
            *first = (*first).min_by_row(pixel);
        }
        if let Some(layers) = self.layers.get_mut(at) {
            layers.add(&sample.first, index);
        }
    }
}

trait MinByRow {
    fn min_by_row(self, other: Self) -> Self;
}

impl MinByRow for [u32; 2] {
    /// The pixel that comes first in scan-line order.
    fn min_by_row(self, other: Self) -> Self {
        if (other[1], other[0]) < (self[1], self[0]) { other } else { self }
    }
}

struct Row {
    colour: Vec<ColourSums>,
    layers: Vec<LayerSums>,
}

/// How many samples the pixels have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SampleCounts {
    /// Fewest of any pixel.
    pub min: u32,
    /// Most of any pixel.
    pub max: u32,
    /// All pixels together.
    pub total: u64,
}

/// Samples that could not be added.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LeftOut {
    /// Samples that were not finite or too large.
    pub count: u64,
    /// The first pixel in scan-line order that had one, x and y.
    pub first: Option<[u32; 2]>,
}

/// The sums of all pixels. Shared by the workers: each row has its own lock, and order does not matter.
pub struct Film {
    area: PixelRect,
    resolution: [u32; 2],
    aovs: Vec<Aov>,
    rows: Vec<Mutex<Row>>,
    left_out: AtomicU64,
    first_left_out: Mutex<Option<[u32; 2]>>,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    // Sums are added without a point where a panic could leave them half written.
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Film {
    /// An empty film.
    ///
    /// # Errors
    /// When the size or the crop is out of range, or memory is short.
    pub fn new(settings: &FilmSettings) -> Result<Self, FilmError> {
        let [width, height] = settings.resolution;
        if width == 0 || height == 0 {
            return Err(FilmError::Empty(width, height));
        }
        if u64::from(width) * u64::from(height) > MAX_PIXELS {
            return Err(FilmError::TooLarge(width, height));
        }
        let crop = settings.crop.unwrap_or([0, 0, width, height]);
        let [x0, y0, x1, y1] = crop;
        if x0 >= x1 || y0 >= y1 || x1 > width || y1 > height {
            return Err(FilmError::Crop(crop, width, height));
        }
        let area = PixelRect { x0, y0, x1, y1 };
        let mut aovs = settings.aovs.clone();
        aovs.sort_by_key(|a| *a as u32);
        aovs.dedup();
        let has_layers = aovs.iter().any(|a| *a != Aov::Variance);
        let out_of_memory = |_| FilmError::OutOfMemory(width, height);
        let mut rows = Vec::new();
        rows.try_reserve_exact(area.height() as usize).map_err(out_of_memory)?;
        for _ in 0..area.height() {
            let pixels = area.width() as usize;
            let mut row = Row { colour: Vec::new(), layers: Vec::new() };
            row.colour.try_reserve_exact(pixels).map_err(out_of_memory)?;
            row.colour.resize(pixels, ColourSums::default());
            if has_layers {
                row.layers.try_reserve_exact(pixels).map_err(out_of_memory)?;
                row.layers.resize(pixels, LayerSums::default());
            }
            rows.push(Mutex::new(row));
        }
        Ok(Self {
            area,
            resolution: settings.resolution,
            aovs,
            rows,
            left_out: AtomicU64::new(0),
            first_left_out: Mutex::new(None),
        })
    }

    /// The part of the image that is rendered.
    pub fn area(&self) -> PixelRect {
        self.area
    }

    /// Size of the whole image, pixels.
    pub fn resolution(&self) -> [u32; 2] {
        self.resolution
    }

    /// True if first hits are wanted.
    pub fn has_layers(&self) -> bool {
        self.aovs.iter().any(|a| *a != Aov::Variance)
    }

    /// Empty sums for a part of the film's area.
    pub(crate) fn tile(&self, rect: PixelRect) -> TileSums {
        let layers = if self.has_layers() { rect.pixels() } else { 0 };
        TileSums {
            rect,
            colour: vec![ColourSums::default(); rect.pixels()],
            layers: vec![LayerSums::default(); layers],
            left_out: 0,
            first_left_out: None,
        }
    }

    /// Adds a finished tile.
    pub(crate) fn merge(&self, tile: &TileSums) {
        let rect = tile.rect;
        let width = rect.width() as usize;
        let x = (rect.x0 - self.area.x0) as usize;
        for (i, y) in (rect.y0 - self.area.y0..rect.y1 - self.area.y0).enumerate() {
            let mut row = lock(&self.rows[y as usize]);
            let from = i * width..(i + 1) * width;
            for (to, more) in row.colour[x..x + width].iter_mut().zip(&tile.colour[from.clone()]) {
                to.merge(more);
            }
            if !row.layers.is_empty() {
                for (to, more) in row.layers[x..x + width].iter_mut().zip(&tile.layers[from]) {
                    to.merge(more);
                }
            }
        }
        if let Some(pixel) = tile.first_left_out {
            self.left_out.fetch_add(tile.left_out, Ordering::Relaxed);
            let mut first = lock(&self.first_left_out);
            *first = Some(first.map_or(pixel, |f| f.min_by_row(pixel)));
        }
    }

    /// How many samples the pixels have now.
    pub fn sample_counts(&self) -> SampleCounts {
        let mut counts = SampleCounts { min: u32::MAX, max: 0, total: 0 };
        for row in &self.rows {
            for pixel in &lock(row).colour {
                let n = pixel.samples();
                counts.min = counts.min.min(n);
                counts.max = counts.max.max(n);
                counts.total += u64::from(n);
            }
        }
        counts
    }

    /// Samples that were not finite or too large, and where.
    pub fn left_out(&self) -> LeftOut {
        LeftOut { count: self.left_out.load(Ordering::Relaxed), first: *lock(&self.first_left_out) }
    }

    /// The image as it is now; rows that are being rendered may be at different sample counts.
    pub fn develop(&self) -> Image {
        let pixels = self.area.pixels();
        let mut planes = Planes::new(&self.aovs, pixels);
        for row in &self.rows {
            let row = lock(row);
            for (x, colour) in row.colour.iter().enumerate() {
                planes.push(colour, row.layers.get(x));
            }
        }
        Image { width: self.area.width(), height: self.area.height(), channels: planes.into_channels() }
    }
}

/// Channels while they are developed, pixel by pixel.
struct Planes<'a> {
    aovs: &'a [Aov],
    colour: [Vec<f32>; 3],
    floats: Vec<(&'static str, Vec<f32>)>,
    ids: Vec<(&'static str, Vec<u32>)>,
}

fn float_names(aov: Aov) -> &'static [&'static str] {
    match aov {
        Aov::Albedo => &["Albedo.R", "Albedo.G", "Albedo.B"],
        Aov::Normal => &["N.X", "N.Y", "N.Z"],
        Aov::Depth => &["Depth.Z"],
        Aov::Ids => &[],
        Aov::Variance => &["Variance.R", "Variance.G", "Variance.B"],
    }
}

impl<'a> Planes<'a> {
    fn new(aovs: &'a [Aov], pixels: usize) -> Self {
        let plane = || Vec::with_capacity(pixels);
        let floats = aovs.iter().flat_map(|a| float_names(*a)).map(|name| (*name, plane())).collect();
        let ids = if aovs.contains(&Aov::Ids) { &["Id.Object", "Id.Material"][..] } else { &[] };
        Self {
            aovs,
            colour: std::array::from_fn(|_| plane()),
            floats,
            ids: ids.iter().map(|name| (*name, Vec::with_capacity(pixels))).collect(),
        }
    }

    fn push(&mut self, colour: &ColourSums, layers: Option<&LayerSums>) {
        for (channel, plane) in self.colour.iter_mut().enumerate() {
            plane.push(colour.mean(channel));
        }
        let mean = |i: usize| match layers {
            Some(l) if l.hits > 0 => {
                // Depth has no value where nothing is; the others fade to 0 as the colour fades into the background.
                let samples = if i == DEPTH { l.hits } else { l.samples };
                (from_fixed(l.sum[i]) / f64::from(samples)) as f32
            }
            _ => 0.0,
        };
        let mut planes = self.floats.iter_mut().map(|(_, plane)| plane);
        for aov in self.aovs {
            let offset = match aov {
                Aov::Albedo => Some(0),
                Aov::Normal => Some(3),
                Aov::Depth => Some(DEPTH),
                Aov::Ids | Aov::Variance => None,
            };
            for (i, _) in float_names(*aov).iter().enumerate() {
                let value = offset.map_or_else(|| colour.variance_of_mean(i), |o| mean(o + i));
                if let Some(plane) = planes.next() {
                    plane.push(value);
                }
            }
        }
        for (i, (_, plane)) in self.ids.iter_mut().enumerate() {
            plane.push(layers.map_or(0, |l| l.ids[i]));
        }
    }

    fn into_channels(self) -> Vec<Channel> {
        let colour = ["R", "G", "B"].into_iter().zip(self.colour);
        let floats = colour.chain(self.floats).map(|(name, data)| (name, ChannelData::F32(data)));
        let ids = self.ids.into_iter().map(|(name, data)| (name, ChannelData::U32(data)));
        floats.chain(ids).map(|(name, data)| Channel { name: name.to_owned(), data }).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_point_is_exact_down_to_its_last_bit() {
        let exact = [0.0, 1.0, -1.0, 0.1, 3.402e7, -5.3e10, 1e-6, 549_755_781_120.0, 2f32.recip(), 1.0 + f32::EPSILON];
        for value in exact {
            assert_eq!(from_fixed(to_fixed(value)), f64::from(value), "{value}");
        }
        let last_bit = 1.0 / 18_446_744_073_709_551_616.0;
        for tiny in [1e-15, -1e-15, 3.3e-18, 1e-25, f32::MIN_POSITIVE, 1e-45] {
            let error = from_fixed(to_fixed(tiny)) - f64::from(tiny);
            assert!(error.abs() < last_bit && error * f64::from(tiny) <= 0.0, "{tiny}: {error}");
        }
    }

    #[test]
    fn sums_do_not_depend_on_order_or_grouping() {
        let values: Vec<f32> = (0..1000).map(|i| (i % 37) as f32 * 0.1 * if i % 5 == 0 { 1e9 } else { 1e-7 }).collect();
        let sums = |order: &mut dyn Iterator<Item = usize>, chunk: usize| {
            let order: Vec<usize> = order.collect();
            let mut total = ColourSums::default();
            for part in order.chunks(chunk) {
                let mut sums = ColourSums::default();
                part.iter().for_each(|&i| sums.add(Spectrum([values[i], -values[i], 0.5]), i & 1));
                total.merge(&sums);
            }
            (total.sum, total.difference, total.count)
        };
        let reference = sums(&mut (0..1000), 1000);
        assert_eq!(reference, sums(&mut (0..1000).rev(), 7));
        assert_eq!(reference, sums(&mut (0..1000).map(|i| i * 387 % 1000), 64));
    }

    #[test]
    fn a_pixel_is_80_bytes() {
        assert_eq!(size_of::<ColourSums>(), 80);
    }
}
