//! Comparison of two renderers by replicates: independent renderings of one view, tile by tile.

use std::fmt;

use crate::special::sidak;
use crate::ttest::{MeanTest, Moments, welch};

/// Statistics of independent renderings of one view: the mean of each tile and of the whole picture.
#[derive(Clone, Debug)]
pub struct Replicates {
    size: [usize; 2],
    channels: usize,
    tile: usize,
    /// Per tile (row by row) and channel.
    tiles: Vec<Moments>,
    /// Per channel.
    channel_means: Vec<Moments>,
    /// Of all numbers.
    whole: Moments,
}

impl Replicates {
    /// For pictures of `size` = [width, height] pixels with `channels` interleaved numbers a pixel, rows from top to
    /// bottom, cut into square tiles of `tile` pixels (smaller at the right and bottom).
    ///
    /// # Panics
    /// If anything is zero.
    pub fn new(size: [usize; 2], channels: usize, tile: usize) -> Self {
        assert!(size[0] > 0 && size[1] > 0 && channels > 0 && tile > 0, "empty picture or tile");
        let count = size[0].div_ceil(tile) * size[1].div_ceil(tile) * channels;
        Self {
            size,
            channels,
            tile,
            tiles: vec![Moments::new(); count],
            channel_means: vec![Moments::new(); channels],
            whole: Moments::new(),
        }
    }

    /// Adds one rendering.
    ///
    /// # Panics
    /// If the length is not width x height x channels.
    pub fn push(&mut self, picture: &[f32]) {
        let [width, height] = self.size;
        assert_eq!(picture.len(), width * height * self.channels, "picture of another size");
        let columns = width.div_ceil(self.tile);
        let mut sums = vec![0.0f64; self.tiles.len()];
        for (pixel, values) in picture.chunks_exact(self.channels).enumerate() {
            let tile = pixel / width / self.tile * columns + pixel % width / self.tile;
            for (channel, &value) in values.iter().enumerate() {
                sums[tile * self.channels + channel] += f64::from(value);
            }
        }
        let mut totals = vec![0.0; self.channels];
        for (i, &sum) in sums.iter().enumerate() {
            totals[i % self.channels] += sum;
            let pixels = self.pixels_of(i / self.channels);
            self.tiles[i].push(sum / pixels);
        }
        let pixels = (width * height) as f64;
        for (moments, &total) in self.channel_means.iter_mut().zip(&totals) {
            moments.push(total / pixels);
        }
        self.whole.push(totals.iter().sum::<f64>() / (pixels * self.channels as f64));
    }

    /// How many renderings.
    pub fn count(&self) -> u64 {
        self.whole.count()
    }

    /// Mean over all numbers, one per rendering.
    pub fn whole(&self) -> &Moments {
        &self.whole
    }

    /// Mean of each channel, one per rendering.
    pub fn channel(&self, channel: usize) -> &Moments {
        &self.channel_means[channel]
    }

    /// Mean of one channel in tile [column, row], one per rendering.
    pub fn tile(&self, [column, row]: [usize; 2], channel: usize) -> &Moments {
        &self.tiles[(row * self.size[0].div_ceil(self.tile) + column) * self.channels + channel]
    }

    fn pixels_of(&self, tile: usize) -> f64 {
        let [column, row] = self.position(tile);
        let extent = |i: usize, size: usize| ((i + 1) * self.tile).min(size) - i * self.tile;
        (extent(column, self.size[0]) * extent(row, self.size[1])) as f64
    }

    fn position(&self, tile: usize) -> [usize; 2] {
        let columns = self.size[0].div_ceil(self.tile);
        [tile % columns, tile / columns]
    }
}

/// Tiles darker than this share of the picture's mean have their relative errors measured against the share.
const DARK: f64 = 0.05;

/// How two sets of renderings compare. `worst_*` are extremes over all tiles and channels.
#[derive(Clone, Debug)]
pub struct TileComparison {
    /// Test of the mean over all numbers.
    pub whole: MeanTest,
    /// Test of each channel's mean.
    pub channels: Vec<MeanTest>,
    /// The test with the least p-value (NaN counts as least).
    pub worst: MeanTest,
    /// Its tile [column, row] and channel.
    pub worst_place: ([usize; 2], usize),
    /// How many (tile, channel) pairs.
    pub tests: usize,
    /// Mean over all numbers, of each set.
    pub means: [f64; 2],
    /// Largest standard error of the two means, relative to the mean.
    pub standard_error: f64,
    /// Largest standard error of a tile in either set, relative to the tile's mean (of the channel), or to 5 % of the
    /// picture's mean in darker tiles.
    pub worst_tile_error: f64,
    replicates: u64,
}

/// How good the data must be so that agreement means something.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demands {
    /// Probability that the whole comparison errs.
    pub level: f64,
    /// Fewest renderings in each set.
    pub replicates: u64,
    /// Largest relative standard error of the picture's mean, see [`TileComparison::standard_error`].
    pub standard_error: f64,
    /// Largest relative standard error of a tile, see [`TileComparison::worst_tile_error`].
    pub tile_error: f64,
}

impl Default for Demands {
    /// 32 renderings, 1 %, standard errors of 0.3 % for the picture and 2 % for a tile.
    fn default() -> Self {
        Self { level: 0.01, replicates: 32, standard_error: 0.003, tile_error: 0.02 }
    }
}

/// Compares the means of `a` and `b` by Welch's test: whole, per channel, and per tile and channel.
///
/// # Panics
/// If sizes, channels or tiles differ.
pub fn compare(a: &Replicates, b: &Replicates) -> TileComparison {
    assert_eq!((a.size, a.channels, a.tile), (b.size, b.channels, b.tile), "pictures of unequal layout");
    let means = [a.whole.mean(), b.whole.mean()];
    let floor = DARK * means[0].abs().max(means[1].abs());
    let mut comparison = TileComparison {
        whole: welch(&a.whole, &b.whole),
        channels: a.channel_means.iter().zip(&b.channel_means).map(|(a, b)| welch(a, b)).collect(),
        worst: welch(&a.tiles[0], &b.tiles[0]),
        worst_place: ([0, 0], 0),
        tests: a.tiles.len(),
        means,
        standard_error: relative_error(&a.whole, 0.0).max(relative_error(&b.whole, 0.0)),
        worst_tile_error: 0.0,
        replicates: a.count().min(b.count()),
    };
    for (i, (x, y)) in a.tiles.iter().zip(&b.tiles).enumerate() {
        let test = welch(x, y);
        let worse = test.p_value.is_nan() && !comparison.worst.p_value.is_nan();
        if worse || test.p_value < comparison.worst.p_value {
            comparison.worst = test;
            comparison.worst_place = (a.position(i / a.channels), i % a.channels);
        }
        for error in [relative_error(x, floor), relative_error(y, floor)] {
            comparison.worst_tile_error = comparison.worst_tile_error.max(error);
        }
    }
    comparison
}

/// Standard error over the mean, or over `floor` if that is more; infinite if not a number.
fn relative_error(moments: &Moments, floor: f64) -> f64 {
    let error = moments.standard_error();
    let relative = error / moments.mean().abs().max(floor);
    match () {
        () if error == 0.0 => 0.0,
        () if relative.is_nan() => f64::INFINITY,
        () => relative,
    }
}

impl TileComparison {
    /// Do the two agree, and are the data good enough to say so? Says what is wrong if not. Half of the level goes to
    /// the mean of the whole picture, half to the tiles.
    pub fn check(&self, demands: Demands) -> Result<(), String> {
        let half = sidak(demands.level, 2);
        let mut faults = Vec::new();
        if self.replicates < demands.replicates {
            faults.push(format!("{} renderings, {} needed", self.replicates, demands.replicates));
        }
        if self.standard_error > demands.standard_error {
            faults
                .push(format!("standard error of the mean {:.3} %: more samples needed", 100.0 * self.standard_error));
        }
        if self.worst_tile_error > demands.tile_error {
            faults
                .push(format!("standard error of a tile {:.3} %: more samples needed", 100.0 * self.worst_tile_error));
        }
        if !self.whole.passes(half) {
            faults.push(format!("the means of the pictures differ: p {:.3e} below {half:.3e}", self.whole.p_value));
        }
        let each = sidak(half, self.tests);
        if !self.worst.passes(each) {
            faults.push(format!("a tile differs: p {:.3e} below {each:.3e}", self.worst.p_value));
        }
        if faults.is_empty() { Ok(()) } else { Err(format!("{}\n{self}", faults.join("\n"))) }
    }

    /// Panics with the report of [`TileComparison::check`].
    #[track_caller]
    pub fn assert(&self, demands: Demands, what: &str) {
        if let Err(report) = self.check(demands) {
            panic!("{what}: {report}");
        }
    }
}

impl fmt::Display for TileComparison {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [a, b] = self.means;
        let (place, channel) = self.worst_place;
        writeln!(
            f,
            "means {a:.6} and {b:.6} (ratio {:.5}), standard error {:.3} %, p {:.3e}",
            a / b,
            100.0 * self.standard_error,
            self.whole.p_value
        )?;
        writeln!(
            f,
            "worst of {} tiles and channels: tile {place:?} channel {channel}, difference {:+.3e} ({:+.2} sigma), p {:.3e}; \
             largest tile error {:.3} %",
            self.tests,
            self.worst.difference,
            self.worst.statistic,
            self.worst.p_value,
            100.0 * self.worst_tile_error
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rng;

    const SIZE: [usize; 2] = [20, 13];

    /// Renderings of a gradient with 4 % noise a number; `scale` of the rightmost eight columns differs.
    fn renderings(seed: u64, scale: f64, right: f64) -> Replicates {
        let mut rng = Rng::new(seed);
        let mut set = Replicates::new(SIZE, 3, 8);
        for _ in 0..32 {
            let picture: Vec<f32> = (0..SIZE[0] * SIZE[1] * 3)
                .map(|i| {
                    let x = i / 3 % SIZE[0];
                    let mean = (1.0 + x as f64) * scale * if x >= 12 { right } else { 1.0 };
                    (mean * (1.0 + 0.04 * rng.normal())) as f32
                })
                .collect();
            set.push(&picture);
        }
        set
    }

    #[test]
    fn equal_means_agree() {
        let passed = (0..100)
            .filter(|&seed| {
                let (a, b) = (renderings(2 * seed + 1, 1.0, 1.0), renderings(2 * seed + 2, 1.0, 1.0));
                compare(&a, &b).check(Demands { level: 0.1, ..Demands::default() }).is_ok()
            })
            .count();
        // Ten of a hundred are expected to fail at this level.
        assert!((80..=97).contains(&passed), "{passed}");
    }

    #[test]
    fn planted_biases_are_found() {
        let reference = renderings(1, 1.0, 1.0);
        let biased = compare(&renderings(2, 1.01, 1.0), &reference);
        assert!(biased.check(Demands::default()).is_err_and(|report| report.contains("means of the pictures")));
        // Local and cancelling in the mean of no tile but some.
        let local = compare(&renderings(2, 1.0, 1.02), &reference);
        assert!(local.check(Demands::default()).is_err_and(|report| report.contains("a tile differs")));
        assert!(local.worst_place.0[0] >= 1);
    }

    #[test]
    fn poor_data_do_not_pass() {
        let (mut a, mut b) = (Replicates::new(SIZE, 3, 8), Replicates::new(SIZE, 3, 8));
        let mut rng = Rng::new(5);
        for _ in 0..8 {
            for set in [&mut a, &mut b] {
                let picture: Vec<f32> = (0..SIZE[0] * SIZE[1] * 3).map(|_| rng.f32()).collect();
                set.push(&picture);
            }
        }
        let report = compare(&a, &b).check(Demands::default()).unwrap_err();
        assert!(report.contains("8 renderings") && report.contains("standard error"), "{report}");
        let mut nan = renderings(3, 1.0, 1.0);
        nan.push(&vec![f32::NAN; SIZE[0] * SIZE[1] * 3]);
        assert!(compare(&nan, &renderings(4, 1.0, 1.0)).check(Demands::default()).is_err());
    }

    #[test]
    fn tile_means() {
        let mut set = Replicates::new([3, 2], 1, 2);
        set.push(&[1.0, 2.0, 10.0, 3.0, 4.0, 20.0]);
        assert_eq!(set.tile([0, 0], 0).mean(), 2.5);
        assert_eq!(set.tile([1, 0], 0).mean(), 15.0);
        assert_eq!(set.whole().mean(), 40.0 / 6.0);
    }
}
