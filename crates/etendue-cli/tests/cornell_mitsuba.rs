//! The Cornell box against Mitsuba's picture of the same box: box filter, the same limit of path length, means over tiles.
//!
//! The reference means and their standard errors are in `bench/data/cornell-box-mitsuba.json`; `bench/README.md` says how
//! they are made. With a box filter the mean of a tile does not depend on the resolution, so the picture here may be
//! smaller than the reference's.

#![allow(clippy::disallowed_methods)]

use etendue_scene::image_file::{Limits, read_image};
use etendue_testkit::tiles::Replicates;
use serde::Deserialize;
use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// Relative difference that is allowed besides noise.
const TOLERANCE: f64 = 0.01;
/// Tiles darker than this share of the image's mean are judged as if they were as bright.
const DARK: f64 = 0.05;
/// Relative difference of the whole image's mean that is allowed besides noise.
const IMAGE_TOLERANCE: f64 = 0.001;

/// The reference file.
#[derive(Deserialize)]
struct Reference {
    grid: [usize; 2],
    max_depth: u32,
    mean: Vec<f64>,
    standard_error: Vec<f64>,
}

impl Reference {
    fn read() -> Self {
        let text = std::fs::read_to_string(project("bench/data/cornell-box-mitsuba.json")).expect("the reference file");
        let reference: Self = serde_json::from_str(&text).expect("JSON as bench/tiles.py writes it");
        let numbers = reference.grid[0] * reference.grid[1] * 3;
        assert_eq!([reference.mean.len(), reference.standard_error.len()], [numbers; 2]);
        reference
    }

    /// `factor` x `factor` tiles made one. The noise of Mitsuba's tiles is independent.
    fn merged(&self, factor: usize) -> Tiles {
        let columns = self.grid[0] / factor;
        let area = (factor * factor) as f64;
        let empty = || vec![[0.0; 3]; columns * (self.grid[1] / factor)];
        let (mut mean, mut error) = (empty(), empty());
        for (index, (m, e)) in self.mean.iter().zip(&self.standard_error).enumerate() {
            let (tile, channel) = (index / 3, index % 3);
            let to = tile / self.grid[0] / factor * columns + tile % self.grid[0] / factor;
            mean[to][channel] += m / area;
            error[to][channel] += (e / area).powi(2);
        }
        error.iter_mut().flatten().for_each(|e| *e = e.sqrt());
        Tiles { columns, mean, error }
    }

    /// Of the whole image.
    fn image(&self) -> Image {
        let whole = self.merged(self.grid[0]);
        Image { mean: whole.mean[0], error: whole.error[0] }
    }
}

/// R G B of tiles, row by row from the top left, with standard errors.
#[derive(Clone)]
struct Tiles {
    columns: usize,
    mean: Vec<[f64; 3]>,
    error: Vec<[f64; 3]>,
}

/// R G B of the whole, with standard errors.
#[derive(Clone)]
struct Image {
    mean: [f64; 3],
    error: [f64; 3],
}

/// Our pictures: tiles with the errors that the variance layers tell, the whole image with the error that the spread of
/// the pictures tells, and the variance of tiles by spread over that by layers, averaged.
struct Ours {
    tiles: Tiles,
    image: Image,
    spread: f64,
}

/// Renders the box with the program itself, once for each seed, in pictures of `side` x `side` pixels.
fn render(side: usize, spp: u32, seeds: u32, depth: u32, columns: usize) -> Ours {
    let folder = tempfile::tempdir().expect("a temporary directory");
    let output = folder.path().join("cornell-box.exr");
    let replicates = || Replicates::new([side, side], 3, side / columns);
    let (mut colours, mut variances) = (replicates(), replicates());
    for seed in 0..seeds {
        let status = Command::new(env!("CARGO_BIN_EXE_etendue"))
            .arg("render")
            .arg(project("scenes/cornell-box.toml"))
            .arg("-o")
            .arg(&output)
            .args(["--quiet", "--filter", "box", "--aov", "variance"])
            .args(["--size", &format!("{side}x{side}"), "--spp", &spp.to_string()])
            .args(["--depth", &depth.to_string(), "--seed", &seed.to_string()])
            .status()
            .expect("the program starts");
        assert!(status.success(), "{status}");
        let picture = read_image(&output, &Limits::default()).expect("the picture it wrote");
        let interleaved = |names: [&str; 3]| -> Vec<f32> {
            let [r, g, b] = names.map(|name| picture.f32_channel(name).expect("a layer"));
            r.iter().zip(g).zip(b).flat_map(|((&r, &g), &b)| [r, g, b]).collect()
        };
        colours.push(&interleaved(["R", "G", "B"]));
        variances.push(&interleaved(["Variance.R", "Variance.G", "Variance.B"]));
    }
    let pixels = (side / columns).pow(2) as f64;
    let (mut tiles, mut ratios) = (Tiles { columns, mean: Vec::new(), error: Vec::new() }, Vec::new());
    for index in 0..columns * columns {
        let place = [index % columns, index / columns];
        let variance = [0, 1, 2].map(|c| variances.tile(place, c).mean() / pixels);
        tiles.mean.push([0, 1, 2].map(|c| colours.tile(place, c).mean()));
        tiles.error.push(variance.map(|v| (v / f64::from(seeds)).sqrt()));
        ratios.extend((0..3).map(|c| colours.tile(place, c).variance() / variance[c]));
    }
    let image = Image {
        mean: [0, 1, 2].map(|c| colours.channel(c).mean()),
        error: [0, 1, 2].map(|c| colours.channel(c).standard_error()),
    };
    Ours { tiles, image, spread: ratios.iter().sum::<f64>() / ratios.len() as f64 }
}

/// The tiles that differ by more than the tolerance and three sigma of both.
fn differing_tiles(ours: &Tiles, reference: &Tiles, image: &Image) -> Vec<String> {
    let mut found = Vec::new();
    for (index, (a, b)) in ours.mean.iter().zip(&reference.mean).enumerate() {
        for c in 0..3 {
            let sigma = ours.error[index][c].hypot(reference.error[index][c]);
            let allowed = TOLERANCE * b[c].max(DARK * image.mean[c]) + 3.0 * sigma;
            let agree = (a[c] - b[c]).abs() <= allowed; // not so for NaN
            if !agree {
                let place = [index % ours.columns, index / ours.columns];
                found.push(format!("tile {place:?} channel {c}: {} for {}, sigma {sigma}", a[c], b[c]));
            }
        }
    }
    found
}

/// The channels in which the whole images differ by more than the tolerance and three sigma of both.
fn differing_channels(ours: &Image, reference: &Image) -> Vec<String> {
    let channel = |c: usize| {
        let sigma = ours.error[c].hypot(reference.error[c]);
        let (a, b) = (ours.mean[c], reference.mean[c]);
        let agree = (a - b).abs() <= IMAGE_TOLERANCE * b + 3.0 * sigma;
        (!agree).then(|| format!("image channel {c}: {a} for {b}, sigma {sigma}"))
    };
    (0..3).filter_map(channel).collect()
}

fn project(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..").join(path)
}

#[test]
fn cornell_box_agrees_with_mitsuba() {
    // Side of the picture, samples, seeds, and how many of the reference's tiles on a side make one.
    let prove = std::env::var_os("ETENDUE_PROVE").is_some_and(|v| v == "1");
    let (side, spp, seeds, factor) = if prove { (512, 64, 16, 1) } else { (128, 64, 8, 2) };
    let reference = Reference::read();
    let (tiles, image) = (reference.merged(factor), reference.image());
    let Ours { tiles: our_tiles, image: our_image, spread } =
        render(side, spp, seeds, reference.max_depth, tiles.columns);

    let mut found = differing_tiles(&our_tiles, &tiles, &image);
    found.extend(differing_channels(&our_image, &image));
    assert!(found.is_empty(), "{} disagreements:\n{}", found.len(), found.join("\n"));

    // The variance layer is right: what two halves of each pixel tell is what independent pictures show.
    assert!((spread - 1.0).abs() < 0.15, "variance of tiles over what the layer says: {spread}");

    // Agreement means something: the noise is small, and errors that are small but not noise are noticed.
    let mut noise: Vec<f64> = Vec::new();
    for (error, mean) in our_tiles.error.iter().zip(&tiles.mean) {
        noise.extend((0..3).map(|c| error[c] / mean[c].max(DARK * image.mean[c])));
    }
    noise.sort_by(f64::total_cmp);
    let median = noise[noise.len() / 2];
    assert!(median < 0.004, "median noise of a tile {median}");
    let brighter = Image { mean: our_image.mean.map(|m| 1.005 * m), ..our_image };
    assert!(!differing_channels(&brighter, &image).is_empty(), "half a per cent too bright");
    let mut spot = our_tiles.clone();
    let middle = tiles.columns * tiles.columns / 2 + tiles.columns / 2;
    spot.mean[middle] = tiles.mean[middle].map(|m| 1.04 * m);
    assert_eq!(differing_tiles(&spot, &tiles, &image).len(), 3, "one tile 4 % too bright");
}
