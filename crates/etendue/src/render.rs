//! The render loop: units of work, workers, progress and cancellation.
//!
//! A unit is a (tile, block): a tile of pixels and a fixed run of consecutive sample indices. Units are done block by block, so
//! that the whole image gets better evenly. Which worker does which unit, and when, does not change a bit of the picture.

use crate::{
    camera::{Camera, CameraError, CameraMotion, CameraSettings},
    film::{Film, PixelRect},
    integrator::{
        Integrator, MAX_PARTS, Splitting, Worthwhile, bodies_about,
        wave::{Context, Counters, Wave},
        worthwhile,
    },
    motion::Shutter,
    sampling::{Filter, FilterSampler, Sampler},
    scene::Scene,
};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// Samples of a pixel in one block.
const BLOCK: u32 = 16;
/// Samples a pixel that a film can sum.
pub const MAX_SPP: u32 = 1 << 24;
/// Largest tile, pixels on a side.
pub const MAX_TILE: u32 = 4096;
/// Largest wave, paths.
pub const MAX_WAVE: u32 = 1 << 16;
/// Most threads.
pub const MAX_THREADS: usize = 1024;

/// How a picture is rendered. All but `threads`, `tile` and `wave` change it.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderSettings {
    /// Samples a pixel, 1 to [`MAX_SPP`].
    pub spp: u32,
    /// Picks the random numbers.
    pub seed: u64,
    /// Worker threads, 1 to [`MAX_THREADS`].
    pub threads: usize,
    /// Longest path in edges, the camera segment included, at least 1; absent: no limit.
    pub max_depth: Option<u32>,
    /// Parts in which the path of a sample goes on from its first vertex that scatters into more than single directions, 1 to
    /// [`MAX_PARTS`]; absent: as many as some samples all over the picture say are worth their time.
    pub splitting: Option<u32>,
    /// True if light samples where the camera looks, by mirrors and glass too, are each one of two candidates, by what they would
    /// bring if nothing were in between; absent: if some samples all over the picture say that it is worth its time.
    pub resampling: Option<bool>,
    /// Where random numbers come from.
    pub sampler: Sampler,
    /// What is estimated, and how.
    pub integrator: Integrator,
    /// Reconstruction filter.
    pub filter: Filter,
    /// Side of a tile in pixels, 1 to [`MAX_TILE`].
    pub tile: u32,
    /// Paths that move through the stages together, 1 to [`MAX_WAVE`].
    pub wave: u32,
    /// How far the shutter is open while it is; matters only where something moves.
    pub shutter: Shutter,
    /// The camera while the shutter is open; absent: it rests.
    pub camera_motion: Option<CameraMotion>,
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            spp: 64,
            seed: 0,
            threads: 1,
            max_depth: None,
            splitting: Some(1),
            resampling: None,
            sampler: Sampler::Sobol,
            integrator: Integrator::Path,
            filter: Filter::default(),
            tile: 32,
            wave: 256,
            shutter: Shutter::Box,
            camera_motion: None,
        }
    }
}

/// Settings that cannot be rendered with.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RenderError {
    /// A number out of its range.
    #[error("{name} is {value}; it must be from {low} to {high}")]
    Range {
        /// Which setting.
        name: &'static str,
        /// What it was.
        value: u64,
        /// Smallest allowed.
        low: u64,
        /// Largest allowed.
        high: u64,
    },
    /// The shutter opens and closes in more time than there is, or less than none.
    #[error("the shutter must open and close within the time that it is open")]
    Shutter,
    /// The camera.
    #[error(transparent)]
    Camera(#[from] CameraError),
}

/// How far a render is, in samples of pixels.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Progress {
    /// Samples done.
    pub done: u64,
    /// Samples in all; 0 before the start.
    pub total: u64,
}

/// The link between a render and whoever watches it from another thread.
#[derive(Debug, Default)]
pub struct RenderControl {
    cancelled: AtomicBool,
    done: AtomicU64,
    total: AtomicU64,
    rays: AtomicU64,
    paths: AtomicU64,
    overflowed: AtomicU64,
}

impl RenderControl {
    /// Asks the render to stop when the tiles in work are done.
    pub fn cancel(&self) {
        self.cancelled.store(true, Ordering::Relaxed);
    }

    /// True once [`Self::cancel`] was called.
    pub fn is_cancelled(&self) -> bool {
        self.cancelled.load(Ordering::Relaxed)
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        Progress { done: self.done.load(Ordering::Relaxed), total: self.total.load(Ordering::Relaxed) }
    }

    /// Rays traced so far: camera, continued and shadow rays.
    pub fn rays(&self) -> u64 {
        self.rays.load(Ordering::Relaxed)
    }

    /// Camera paths started so far.
    pub fn paths(&self) -> u64 {
        self.paths.load(Ordering::Relaxed)
    }

    /// Paths so far that lay in more than [`MAX_NESTED`](crate::scene::MAX_NESTED) bodies at once: what the others hold was
    /// left out there.
    pub fn overflowed(&self) -> u64 {
        self.overflowed.load(Ordering::Relaxed)
    }

    fn finish_unit(&self, samples: u64, counters: Counters) {
        self.rays.fetch_add(counters.rays, Ordering::Relaxed);
        self.paths.fetch_add(counters.paths, Ordering::Relaxed);
        self.overflowed.fetch_add(counters.overflowed, Ordering::Relaxed);
        self.done.fetch_add(samples, Ordering::Relaxed);
    }
}

/// Renders `settings.spp` samples of each pixel of the film's area, and adds them to the film. Returns when they are done, or
/// soon after `control` was cancelled: then every pixel still has whole samples only, and the film knows how many.
///
/// # Errors
/// When a setting is out of range, or the camera cannot be; nothing is rendered then.
pub fn render(
    scene: &Scene,
    camera: &CameraSettings,
    settings: &RenderSettings,
    film: &Film,
    control: &RenderControl,
) -> Result<(), RenderError> {
    check(settings)?;
    let camera = match &settings.camera_motion {
        None => Camera::new(camera, film.resolution(), scene.center())?,
        Some(motion) => Camera::moving(motion, film.resolution(), scene.center())?,
    };
    let is_moving = scene.is_moving() || camera.is_moving();
    let filter = FilterSampler::new(settings.filter);
    let mut context = Context {
        scene,
        camera: &camera,
        camera_bodies: bodies_about(scene, camera.start(), 0.0),
        shutter: is_moving.then_some(settings.shutter),
        filter: &filter,
        sampler: settings.sampler,
        seed: settings.seed,
        integrator: settings.integrator,
        max_depth: settings.max_depth.unwrap_or(u32::MAX),
        wants_layers: film.has_layers(),
        wants_direct: film.has_direct(),
        transparent: film.is_transparent(),
        resamples: false,
        splitting: Splitting { parts: 1, apart: false },
    };
    let Worthwhile { parts, resamples } = worthwhile(&context, film.resolution(), settings, || control.is_cancelled());
    context.splitting.parts = parts;
    context.resamples = resamples;
    let units = Units::new(film.area(), settings);
    control.total.fetch_add(film.area().pixels() as u64 * u64::from(settings.spp), Ordering::Relaxed);
    let next = AtomicU64::new(0);
    let work = || {
        let mut wave = Wave::new(settings.wave as usize);
        while !control.is_cancelled()
            && let Some(unit) = units.get(next.fetch_add(1, Ordering::Relaxed))
        {
            let mut tile = film.tile(unit.rect);
            let counters =
                wave.run(&context, &mut unit.samples(), &mut |pixel, index, sample| tile.add(pixel, index, sample));
            film.merge(&tile);
            control.finish_unit(unit.len(), counters);
        }
    };
    std::thread::scope(|scope| {
        for _ in 1..settings.threads {
            scope.spawn(work);
        }
        work();
    });
    Ok(())
}

fn check(settings: &RenderSettings) -> Result<(), RenderError> {
    let ranges = [
        ("spp", u64::from(settings.spp), u64::from(MAX_SPP)),
        ("threads", settings.threads as u64, MAX_THREADS as u64),
        ("tile", u64::from(settings.tile), u64::from(MAX_TILE)),
        ("wave", u64::from(settings.wave), u64::from(MAX_WAVE)),
        ("depth", u64::from(settings.max_depth.unwrap_or(1)), u64::from(u32::MAX)),
        ("splitting", u64::from(settings.splitting.unwrap_or(1)), u64::from(MAX_PARTS)),
    ];
    for (name, value, high) in ranges {
        if !(1..=high).contains(&value) {
            return Err(RenderError::Range { name, value, low: 1, high });
        }
    }
    if !settings.shutter.is_possible() {
        return Err(RenderError::Shutter);
    }
    Ok(())
}

/// A tile of pixels and a run of sample indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Unit {
    rect: PixelRect,
    first: u32,
    end: u32,
}

impl Unit {
    /// Every (pixel, sample index) of the unit, pixel by pixel.
    fn samples(self) -> impl Iterator<Item = ([u32; 2], u32)> {
        let Self { rect, first, end } = self;
        (rect.y0..rect.y1)
            .flat_map(move |y| (rect.x0..rect.x1).flat_map(move |x| (first..end).map(move |index| ([x, y], index))))
    }

    fn len(&self) -> u64 {
        self.rect.pixels() as u64 * u64::from(self.end - self.first)
    }
}

/// All units of a render, numbered block by block.
struct Units {
    area: PixelRect,
    tile: u32,
    across: u64,
    tiles: u64,
    spp: u32,
}

impl Units {
    fn new(area: PixelRect, settings: &RenderSettings) -> Self {
        let across = u64::from(area.width().div_ceil(settings.tile));
        let down = u64::from(area.height().div_ceil(settings.tile));
        Self { area, tile: settings.tile, across, tiles: across * down, spp: settings.spp }
    }

    fn get(&self, number: u64) -> Option<Unit> {
        let (block, tile) = (number / self.tiles, number % self.tiles);
        let first = u32::try_from(block).ok()?.checked_mul(BLOCK).filter(|first| *first < self.spp)?;
        let x0 = self.area.x0 + (tile % self.across) as u32 * self.tile;
        let y0 = self.area.y0 + (tile / self.across) as u32 * self.tile;
        let rect = PixelRect {
            x0,
            y0,
            x1: self.area.x1.min(x0.saturating_add(self.tile)),
            y1: self.area.y1.min(y0.saturating_add(self.tile)),
        };
        Some(Unit { rect, first, end: self.spp.min(first + BLOCK) })
    }
}
