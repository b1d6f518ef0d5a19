//! The film: exact sums of samples, in two halves, and their development into an image.
//!
//! Sums are fixed point and wide enough to be exact, so adding is associative: the picture does not depend on the order in
//! which samples arrive. Samples with an even and an odd index form two halves that are scrambled independently; the
//! difference of their means is what the variance is estimated from.

mod aov;
mod develop;
mod layers;
mod sums;

use crate::{
    image::Image,
    integrator::MAX_PARTS,
    math::{Vec2, Vec3},
    spectrum::Spectrum,
};
pub use aov::{Aov, UnknownName};
use develop::Planes;
use layers::{Layers, Plan, zeros};
use std::sync::{
    Mutex, MutexGuard, PoisonError,
    atomic::{AtomicU64, Ordering},
};
use sums::{ColourSums, LIGHT, is_storable};

/// Pixels that a film may have; 80 bytes each.
const MAX_PIXELS: u64 = 1 << 28;

/// Size and layers of a film.
#[derive(Clone, Debug)]
pub struct FilmSettings {
    /// Width and height of the whole image, pixels.
    pub resolution: [u32; 2],
    /// The part that is rendered: x0, y0 inclusive, x1, y1 exclusive, absolute pixels; absent: all.
    pub crop: Option<[u32; 4]>,
    /// Layers beside the colour.
    pub aovs: Vec<Aov>,
    /// Where camera rays meet no surface, nothing is: the image has a channel `A`, the fraction of samples that met a
    /// surface, and its colour is multiplied by it.
    pub transparent: bool,
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
#[derive(Clone, Copy, Debug)]
pub struct PathSample {
    /// Radiance, without the weight.
    pub radiance: Spectrum,
    /// The part of it on paths of at most two edges.
    pub direct: Spectrum,
    /// The weight in the pixel: 1 but for filters with negative lobes.
    pub weight: f32,
    /// Whether there was a surface.
    pub met_surface: bool,
    /// The first surface, if there was one and layers want it.
    pub first: FirstHit,
    /// Which part of a sample this is. All but the first are more light of a sample that is counted already.
    pub part: u32,
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
    /// World space.
    pub position: Vec3,
    /// Texture coordinates.
    pub uv: Vec2,
    /// Object, counted from 1; 0 for none.
    pub object: u32,
    /// Material, counted from 1; 0 for none.
    pub material: u32,
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
pub struct TileSums<'a> {
    plan: &'a Plan,
    rect: PixelRect,
    colour: Vec<ColourSums>,
    layers: Layers,
    left_out: u64,
    first_left_out: Option<[u32; 2]>,
}

impl TileSums<'_> {
    /// Adds sample number `index` of an absolute pixel of this tile. One whose colour is not finite or too large is left out of
    /// the layers too, so that all have the same samples.
    #[inline]
    pub fn add(&mut self, pixel: [u32; 2], index: u32, sample: &PathSample) {
        let at = (pixel[1] - self.rect.y0) as usize * self.rect.width() as usize + (pixel[0] - self.rect.x0) as usize;
        let colour = sample.radiance * sample.weight;
        if sample.part > 0 && colour.is_black() {
            return;
        }
        self.layers.identify(at, sample, index);
        // All parts together have room for as much as one sample.
        let room = if sample.part > 0 { MAX_PARTS as f32 } else { 1.0 };
        if !colour.0.iter().all(|v| is_storable(*v * room, LIGHT)) {
            self.left_out += 1;
            let first = self.first_left_out.get_or_insert(pixel);
            *first = (*first).min_by_row(pixel);
            return;
        }
        self.colour[at].add(colour, (index & 1) as usize, sample.part == 0);
        self.layers.add(self.plan, at, sample);
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
    layers: Layers,
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
    transparent: bool,
    plan: Plan,
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
        aovs.sort();
        aovs.dedup();
        let plan = Plan::new(&aovs, settings.transparent);
        let out_of_memory = |_| FilmError::OutOfMemory(width, height);
        let pixels = area.width() as usize;
        let mut rows = Vec::new();
        rows.try_reserve_exact(area.height() as usize).map_err(out_of_memory)?;
        for _ in 0..area.height() {
            let colour = zeros(pixels).map_err(out_of_memory)?;
            let layers = Layers::new(&plan, pixels).map_err(out_of_memory)?;
            rows.push(Mutex::new(Row { colour, layers }));
        }
        Ok(Self {
            area,
            resolution: settings.resolution,
            aovs,
            transparent: settings.transparent,
            plan,
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
        self.plan.has_first_hits()
    }

    /// True if direct light is wanted apart.
    pub fn has_direct(&self) -> bool {
        self.plan.has_direct()
    }

    /// True if nothing is to be seen where camera rays meet no surface.
    pub fn is_transparent(&self) -> bool {
        self.transparent
    }

    /// Empty sums for a part of the film's area.
    pub(crate) fn tile(&self, rect: PixelRect) -> TileSums<'_> {
        let pixels = rect.pixels();
        TileSums {
            plan: &self.plan,
            rect,
            colour: vec![ColourSums::default(); pixels],
            layers: Layers::zeros(&self.plan, pixels),
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
            for (to, more) in row.colour[x..x + width].iter_mut().zip(&tile.colour[i * width..]) {
                to.merge(more);
            }
            row.layers.merge(&self.plan, x, &tile.layers, i * width, width);
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
        let mut planes = Planes::new(&self.plan, &self.aovs, self.transparent, self.area.pixels());
        for row in &self.rows {
            let row = lock(row);
            for (at, colour) in row.colour.iter().enumerate() {
                planes.push(colour, &row.layers, at);
            }
        }
        planes.into_image(self.area)
    }
}
