//! OpenEXR.

use super::{File, Kind, Limits, ReadError};
use crate::output::{Metadata, Window};
use etendue::image::{Channel, ChannelData, Image};
use exr::{
    image::{
        FlatSamples, Layer,
        read::{image::ReadLayers, layers::ReadChannels, read as read_exr},
    },
    math::Vec2,
    meta::{
        MetaData,
        attribute::{AttributeValue, Text},
        header::{ImageAttributes, LayerAttributes},
    },
};
use std::{
    io::Cursor,
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

/// Reads the first part of flat pixels of an EXR file from memory, at its largest level, half floats widened. Channels
/// come as `R G B A`, then the rest by name.
pub fn read(path: &Path, bytes: &[u8], limits: &Limits) -> Result<(Image, Metadata), ReadError> {
    let file = File { path, kind: Kind::Exr, bytes };
    // The decoder asserts some of what damaged files break.
    catch_unwind(AssertUnwindSafe(|| read_unguarded(file, limits)))
        .unwrap_or_else(|_| Err(file.damaged("its blocks contradict its header")))
}

fn read_unguarded(file: File<'_>, limits: &Limits) -> Result<(Image, Metadata), ReadError> {
    let damaged = |e: exr::error::Error| file.damaged(e);
    check_headers(file, limits)?;
    let image = read_exr()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(file.bytes))
        .map_err(damaged)?;
    let Layer { channel_data, attributes, size, .. } = image.layer_data;
    if let Some(channel) = channel_data.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
        let what = format!("channel {} is subsampled, which is not read", string(&channel.name));
        return Err(file.damaged(what));
    }
    let mut channels: Vec<Channel> =
        channel_data.list.into_iter().map(|c| Channel { name: string(&c.name), data: widen(c.sample_data) }).collect();
    channels.sort_by_key(|c| ["R", "G", "B", "A"].iter().position(|&n| n == c.name).unwrap_or(4));
    let dimension = |v: usize| u32::try_from(v).map_err(|_| ReadError::too_large(file.path, format!("{v} pixels")));
    let read = Image { width: dimension(size.0)?, height: dimension(size.1)?, channels };
    Ok((read, metadata_of(&attributes, &image.attributes, size)))
}

/// Compares what the headers declare with the limits and with the length of the file, before pixels are allocated.
fn check_headers(file: File<'_>, limits: &Limits) -> Result<(), ReadError> {
    let meta = MetaData::read_from_buffered(Cursor::new(file.bytes), false).map_err(|e| file.damaged(e))?;
    let mut chunks = 0_u64;
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        limits.check_pixels(file, width as u64, height as u64, header.channels.list.len() as u64)?;
        chunks = chunks.saturating_add(header.chunk_count as u64);
    }
    // Each chunk has an offset in a table and at least a coordinate and a length: 16 bytes.
    if chunks.saturating_mul(16) > file.bytes.len() as u64 {
        return Err(file.damaged(format!("{chunks} blocks cannot be in so small a file")));
    }
    Ok(())
}

fn widen(samples: FlatSamples) -> ChannelData {
    match samples {
        FlatSamples::F16(data) => ChannelData::F32(data.into_iter().map(f32::from).collect()),
        FlatSamples::F32(data) => ChannelData::F32(data),
        FlatSamples::U32(data) => ChannelData::U32(data),
    }
}

fn metadata_of(own: &LayerAttributes, shared: &ImageAttributes, size: Vec2<usize>) -> Metadata {
    let mut entries: Vec<(String, String)> = own
        .other
        .iter()
        .filter_map(|(name, value)| match value {
            AttributeValue::Text(value) => Some((string(name), string(value))),
            _ => None,
        })
        .collect();
    entries.sort();
    let Vec2(x, y) = own.layer_position;
    let whole = shared.display_window.size;
    let window = match (u32::try_from(x), u32::try_from(y), u32::try_from(whole.0), u32::try_from(whole.1)) {
        (Ok(x), Ok(y), Ok(w), Ok(h)) if (x, y) != (0, 0) || whole != size => {
            Some(Window { origin: [x, y], whole: [w, h] })
        }
        _ => None,
    };
    let software = own.software_name.as_ref().map(string).unwrap_or_default();
    Metadata { software, entries, window, ..Metadata::default() }
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}
