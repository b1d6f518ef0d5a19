//! What is told of a volume, and of media.

use super::{
    Told,
    text::{self, Page},
};
use crate::exit::{Exit, Failure};
use etendue::medium::{DensityGrid, Medium, Voxels};
use etendue_scene::{
    SourceMap,
    volume_file::{Limits, decode_volume},
};
use serde::Serialize;
use std::path::Path;

/// A file of densities.
#[derive(Debug, Serialize)]
pub struct VolumeInfo {
    kind: &'static str,
    file: String,
    format: &'static str,
    file_bytes: u64,
    #[serde(flatten)]
    grid: GridEntry,
}

/// A grid of densities.
#[derive(Debug, Serialize)]
pub struct GridEntry {
    /// Voxels along x, y and z.
    size: [u32; 3],
    /// How they are stored: `u8`, `u16`, `f16` or `f32`.
    samples: &'static str,
    min: f32,
    max: f32,
    mean: f64,
    /// Values that were negative or not finite, and count as 0.
    repaired: u64,
    /// In memory.
    bytes: usize,
}

impl GridEntry {
    fn new(grid: &DensityGrid) -> Self {
        let [min, max] = grid.range();
        let samples = match grid.voxels() {
            Voxels::U8(_) => "u8",
            Voxels::U16(_) => "u16",
            Voxels::F16(_) => "f16",
            Voxels::F32(_) => "f32",
        };
        let (size, mean, repaired, bytes) = (grid.size(), grid.mean(), grid.repaired(), grid.bytes());
        Self { size, samples, min, max, mean, repaired, bytes }
    }

    fn range(&self) -> String {
        let [min, max] = [self.min, self.max].map(|v| text::number(f64::from(v)));
        format!("{min} to {max}, mean {}", text::number(self.mean))
    }

    fn size(&self) -> String {
        self.size.map(|n| n.to_string()).join(" x ")
    }
}

/// A medium of a scene.
#[derive(Debug, Serialize)]
pub struct MediumEntry {
    name: String,
    /// Per metre, of density 1.
    absorption: [f32; 3],
    scattering: [f32; 3],
    emits: bool,
    /// Where density varies.
    grid: Option<GridEntry>,
}

impl MediumEntry {
    pub fn new(medium: &Medium) -> Self {
        Self {
            name: medium.name.clone(),
            absorption: medium.absorption.0,
            scattering: medium.scattering.0,
            emits: !medium.emission.is_black(),
            grid: medium.density.as_ref().map(|density| GridEntry::new(density.grid())),
        }
    }

    pub fn text(&self) -> String {
        let rgb = |values: [f32; 3]| values.map(|v| text::number(f64::from(v))).join(" ");
        let emits = if self.emits { ", emits" } else { "" };
        let grid = self.grid.as_ref().map(|grid| format!(", times {} voxels of {}", grid.size(), grid.range()));
        let (absorption, scattering) = (rgb(self.absorption), rgb(self.scattering));
        format!("{}: absorption {absorption}, scattering {scattering}{emits}{}", self.name, grid.unwrap_or_default())
    }
}

/// Reads a volume that says itself what it holds.
pub fn read(path: &Path) -> Result<VolumeInfo, Failure> {
    let limits = Limits::default();
    let mut sources = SourceMap::new();
    let file = sources.read(path, limits.file)?;
    let bytes = sources.bytes(file);
    let grid = decode_volume(path, &bytes, None, None, &limits).map_err(|error| {
        let failure = Failure::new(Exit::BadInput, error.to_string());
        match error.help() {
            Some(help) => failure.hint(help),
            None => failure,
        }
    })?;
    Ok(VolumeInfo {
        kind: "volume",
        file: path.display().to_string(),
        format: "NPY",
        file_bytes: bytes.len() as u64,
        grid: GridEntry::new(&grid),
    })
}

impl Told for VolumeInfo {
    fn text(&self) -> String {
        let mut page = Page::new(format!("{}: {} volume, {}", self.file, self.format, text::bytes(self.file_bytes)));
        page.row("size", format!("{} voxels of `a[x, y, z]`", self.grid.size()));
        page.row("stored as", self.grid.samples);
        page.row("densities", self.grid.range());
        if self.grid.repaired > 0 {
            page.row("counted as 0", format!("{} negative or not finite", self.grid.repaired));
        }
        page.row("memory", text::bytes(self.grid.bytes as u64));
        page.text()
    }
}
