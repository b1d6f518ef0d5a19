//! OpenEXR: every channel of a picture with its name, linear, and text attributes about how it was made.

use super::{EncodeError, Limits, Metadata, ReadError, Window, check_shape};
use etendue::image::{Channel, ChannelData, Image};
use exr::{
    block::lines::LineRefMut,
    image::{
        AnyChannel, AnyChannels, Blocks, Encoding, FlatSamples, Image as ExrImage, Layer,
        read::{image::ReadLayers, layers::ReadChannels, read as read_exr},
        write::{
            WritableImage,
            samples::{SamplesWriter, WritableSamples},
        },
    },
    math::{RoundingMode, Vec2},
    meta::{
        MetaData,
        attribute::{
            AttributeValue, Chromaticities, Compression, IntegerBounds, LevelMode, LineOrder, SampleType, Text,
        },
        header::{Header, ImageAttributes, LayerAttributes},
    },
};
use std::{
    io::{BufWriter, Cursor, Seek, Write},
    panic::{AssertUnwindSafe, catch_unwind},
    path::Path,
};

impl From<exr::error::Error> for EncodeError {
    fn from(error: exr::error::Error) -> Self {
        match error {
            exr::error::Error::Io(e) => Self::Io(e),
            other => Self::Malformed(other.to_string()),
        }
    }
}

/// Writes one part of scan lines, ZIP over 16 lines, with all channels of `image` in their own type. The chromaticities
/// are those of Rec. 709; the data window is [`Metadata::window`], if set, inside a display window of the whole.
pub fn write(out: impl Write + Seek, image: &Image, metadata: &Metadata) -> Result<(), EncodeError> {
    check_shape(image)?;
    let size = Vec2(image.width as usize, image.height as usize);
    let list = image
        .channels
        .iter()
        .map(|c| AnyChannel::new(text(&c.name), Samples { data: &c.data, width: size.0 }))
        .collect();
    let window = metadata.window.unwrap_or(Window { origin: [0; 2], whole: [image.width, image.height] });
    let mut own = LayerAttributes {
        layer_position: Vec2(signed(window.origin[0])?, signed(window.origin[1])?),
        software_name: Some(text(&metadata.software)),
        ..LayerAttributes::default()
    };
    own.other.extend(metadata.entries.iter().map(|(name, value)| (text(name), AttributeValue::Text(text(value)))));
    let mut shared =
        ImageAttributes::new(IntegerBounds::new((0, 0), (window.whole[0] as usize, window.whole[1] as usize)));
    shared.chromaticities = Some(Chromaticities {
        red: Vec2(0.64, 0.33),
        green: Vec2(0.3, 0.6),
        blue: Vec2(0.15, 0.06),
        white: Vec2(0.3127, 0.329),
    });
    let encoding =
        Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
    let layer = Layer { channel_data: AnyChannels::sort(list), attributes: own, size, encoding };
    let mut out = BufWriter::new(out);
    ExrImage { attributes: shared, layer_data: layer }.write().to_buffered(&mut out)?;
    out.flush()?;
    Ok(())
}

fn signed(value: u32) -> Result<i32, EncodeError> {
    i32::try_from(value).map_err(|_| EncodeError::Malformed(format!("crop offset {value}")))
}

/// UTF-8 bytes, as other programs write them.
fn text(text: &str) -> Text {
    Text::from_bytes_unchecked(text.bytes().collect())
}

fn string(text: &Text) -> String {
    String::from_utf8_lossy(text.bytes()).into_owned()
}

/// A channel's samples, borrowed.
#[derive(Clone, Copy)]
struct Samples<'a> {
    data: &'a ChannelData,
    width: usize,
}

impl<'a> WritableSamples<'a> for Samples<'_> {
    type Writer = Self;

    fn sample_type(&self) -> SampleType {
        match self.data {
            ChannelData::F32(_) => SampleType::F32,
            ChannelData::U32(_) => SampleType::U32,
        }
    }

    fn infer_level_modes(&self) -> (LevelMode, RoundingMode) {
        (LevelMode::Singular, RoundingMode::Down)
    }

    fn create_samples_writer(&'a self, _: &Header) -> Self::Writer {
        *self
    }
}

impl SamplesWriter for Samples<'_> {
    fn extract_line(&self, line: LineRefMut<'_>) {
        let start = line.location.position.1 * self.width + line.location.position.0;
        let range = start..start + line.location.sample_count;
        let written = match self.data {
            ChannelData::F32(data) => line.write_samples_from_slice(&data[range]),
            ChannelData::U32(data) => line.write_samples_from_slice(&data[range]),
        };
        written.expect("a line in memory has room for its samples");
    }
}

/// Reads the first part of flat pixels of an EXR file from memory, at its largest level, half floats widened. Channels
/// come as `R G B A`, then the rest by name.
pub fn read(path: &Path, file: &[u8], limits: &Limits) -> Result<(Image, Metadata), ReadError> {
    // The decoder asserts some of what damaged files break.
    catch_unwind(AssertUnwindSafe(|| read_unguarded(path, file, limits)))
        .unwrap_or_else(|_| Err(ReadError::damaged(path, "OpenEXR", "its blocks contradict its header")))
}

fn read_unguarded(path: &Path, file: &[u8], limits: &Limits) -> Result<(Image, Metadata), ReadError> {
    let damaged = |e: exr::error::Error| ReadError::damaged(path, "OpenEXR", e.to_string());
    check_headers(path, file, limits)?;
    let image = read_exr()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .from_buffered(Cursor::new(file))
        .map_err(damaged)?;
    let Layer { channel_data, attributes, size, .. } = image.layer_data;
    if let Some(channel) = channel_data.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
        let what = format!("channel {} is subsampled, which is not read", string(&channel.name));
        return Err(ReadError::damaged(path, "OpenEXR", what));
    }
    let mut channels: Vec<Channel> =
        channel_data.list.into_iter().map(|c| Channel { name: string(&c.name), data: widen(c.sample_data) }).collect();
    channels.sort_by_key(|c| ["R", "G", "B", "A"].iter().position(|&n| n == c.name).unwrap_or(4));
    let dimension = |v: usize| u32::try_from(v).map_err(|_| ReadError::too_large(path, format!("{v} pixels")));
    let read = Image { width: dimension(size.0)?, height: dimension(size.1)?, channels };
    Ok((read, metadata_of(&attributes, &image.attributes, size)))
}

/// Compares what the headers declare with the limits and with the length of the file, before pixels are allocated.
fn check_headers(path: &Path, file: &[u8], limits: &Limits) -> Result<(), ReadError> {
    let meta = MetaData::read_from_buffered(Cursor::new(file), false)
        .map_err(|e| ReadError::damaged(path, "OpenEXR", e.to_string()))?;
    let mut chunks = 0_u64;
    for header in &meta.headers {
        let Vec2(width, height) = header.layer_size;
        limits.check_pixels(path, width as u64, height as u64, header.channels.list.len() as u64)?;
        chunks = chunks.saturating_add(header.chunk_count as u64);
    }
    // Each chunk has an offset in a table and at least a coordinate and a length: 16 bytes.
    if chunks.saturating_mul(16) > file.len() as u64 {
        return Err(ReadError::damaged(path, "OpenEXR", format!("{chunks} blocks cannot be in so small a file")));
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
    Metadata { software: own.software_name.as_ref().map(string).unwrap_or_default(), entries, window }
}
