//! OpenEXR: every channel of a picture with its name, linear, and text attributes about how it was made.

use super::{EncodeError, Metadata, Window, check_shape};
use etendue::image::{ChannelData, Image};
use exr::{
    block::lines::LineRefMut,
    image::{
        AnyChannel, AnyChannels, Blocks, Encoding, Image as ExrImage, Layer,
        write::{
            WritableImage,
            samples::{SamplesWriter, WritableSamples},
        },
    },
    math::{RoundingMode, Vec2},
    meta::{
        attribute::{
            AttributeValue, Chromaticities, Compression, IntegerBounds, LevelMode, LineOrder, SampleType, Text,
        },
        header::{Header, ImageAttributes, LayerAttributes},
    },
};
use std::io::{BufWriter, Seek, Write};

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
