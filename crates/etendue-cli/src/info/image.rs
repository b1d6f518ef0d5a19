//! What is told of a picture.

use super::{
    Told,
    text::{self, Page},
};
use crate::exit::{Exit, Failure};
use etendue::image::{Channel, ChannelData};
use etendue_scene::{
    SourceMap,
    image_file::{Limits, Samples, decode_image, decode_texture, format_name},
};
use serde::Serialize;
use std::path::Path;

/// A picture.
#[derive(Debug, Serialize)]
pub struct ImageInfo {
    kind: &'static str,
    file: String,
    format: &'static str,
    file_bytes: u64,
    width: u32,
    height: u32,
    /// How samples are stored: `u8`, `u16`, `f32`, or `mixed`.
    samples: &'static str,
    /// `srgb` or `linear`.
    encoding: &'static str,
    /// As they are when read: linear.
    channels: Vec<ChannelEntry>,
    /// In memory, when read as linear floats.
    bytes: u64,
}

/// One channel.
#[derive(Debug, Serialize)]
struct ChannelEntry {
    name: String,
    /// Of what is finite; absent if nothing is.
    min: Option<f64>,
    max: Option<f64>,
    mean: Option<f64>,
    nonfinite: u64,
}

impl ChannelEntry {
    fn new(channel: &Channel) -> Self {
        let values: Box<dyn Iterator<Item = f64>> = match &channel.data {
            ChannelData::F32(data) => Box::new(data.iter().map(|v| f64::from(*v))),
            ChannelData::U32(data) => Box::new(data.iter().map(|v| f64::from(*v))),
        };
        let (mut min, mut max, mut sum, mut count, mut nonfinite) = (f64::INFINITY, f64::NEG_INFINITY, 0.0, 0u64, 0);
        for value in values {
            if value.is_finite() {
                (min, max, sum, count) = (min.min(value), max.max(value), sum + value, count + 1);
            } else {
                nonfinite += 1;
            }
        }
        let some = |value: f64| (count > 0).then_some(value);
        let name = channel.name.clone();
        Self { name, min: some(min), max: some(max), mean: some(sum / count as f64), nonfinite }
    }

    fn text(&self) -> String {
        let range = match (self.min, self.max, self.mean) {
            (Some(min), Some(max), Some(mean)) => {
                format!("{} to {}, mean {}", text::number(min), text::number(max), text::number(mean))
            }
            _ => "nothing finite".to_owned(),
        };
        let left = if self.nonfinite > 0 { format!(", {} not finite", self.nonfinite) } else { String::new() };
        format!("{}: {range}{left}", self.name)
    }
}

/// Reads a picture.
pub fn read(path: &Path) -> Result<ImageInfo, Failure> {
    let limits = Limits::default();
    let mut sources = SourceMap::new();
    let file = sources.read(path, limits.file)?;
    let bytes = sources.bytes(file);
    let format = format_name(path, &bytes).ok_or_else(|| {
        Failure::new(Exit::BadInput, format!("{} is nothing that is read", path.display())).hint(
            "info reads scenes (.toml), models (.obj, .ply, .stl, .off), volumes (.npy) and pictures (.png, .exr, .hdr, .jpg, ...)",
        )
    })?;
    let image = decode_image(path, &bytes, &limits)?;
    let (samples, encoding) = match decode_texture(path, &bytes, &limits) {
        Ok(raw) if format != "OpenEXR" => {
            let samples = match raw.samples {
                Samples::U8(_) => "u8",
                Samples::U16(_) => "u16",
                Samples::F32(_) => "f32",
            };
            (samples, if raw.encoded_srgb { "srgb" } else { "linear" })
        }
        _ => ("mixed", "linear"),
    };
    Ok(ImageInfo {
        kind: "image",
        file: path.display().to_string(),
        format,
        file_bytes: bytes.len() as u64,
        width: image.width,
        height: image.height,
        samples,
        encoding,
        bytes: u64::from(image.width) * u64::from(image.height) * 4 * image.channels.len() as u64,
        channels: image.channels.iter().map(ChannelEntry::new).collect(),
    })
}

impl Told for ImageInfo {
    fn text(&self) -> String {
        let mut page = Page::new(format!("{}: {} picture, {}", self.file, self.format, text::bytes(self.file_bytes)));
        page.row("size", format!("{} x {}", self.width, self.height));
        page.row("stored as", format!("{}, {}", self.samples, self.encoding));
        page.rows("channels", self.channels.iter().map(ChannelEntry::text));
        page.row("memory", text::bytes(self.bytes));
        page.text()
    }
}
