//! PNG: 8 bit sRGB.

use super::{Encode, EncodeError, Metadata, check_shape, color_channels};
use etendue::image::Image;
use std::io::{BufWriter, Write};

impl From<png::EncodingError> for EncodeError {
    fn from(error: png::EncodingError) -> Self {
        match error {
            png::EncodingError::IoError(e) => Self::Io(e),
            other => Self::Malformed(other.to_string()),
        }
    }
}

/// Writes the colour of `image` as 8 bit sRGB, with `sRGB` and `gAMA` chunks and the metadata as text.
pub fn write(out: impl Write, image: &Image, metadata: &Metadata, encode: Encode<'_>) -> Result<(), EncodeError> {
    check_shape(image)?;
    let [r, g, b] = color_channels(image)?;
    let mut bytes = Vec::with_capacity(3 * r.len());
    for ((&r, &g), &b) in r.iter().zip(g).zip(b) {
        bytes.extend_from_slice(&encode([r, g, b]));
    }
    write_rgb8(out, [image.width, image.height], &bytes, metadata)
}

/// Writes `width * height` pixels of three sRGB bytes.
pub fn write_rgb8(out: impl Write, size: [u32; 2], bytes: &[u8], metadata: &Metadata) -> Result<(), EncodeError> {
    let mut buffered = BufWriter::new(out);
    let mut encoder = png::Encoder::new(&mut buffered, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    // The value that the PNG specification gives for readers that do not know the sRGB chunk.
    encoder.set_source_gamma(png::ScaledFloat::from_scaled(45_455));
    encoder.add_itxt_chunk("Software".to_owned(), metadata.software.clone())?;
    for (name, text) in &metadata.entries {
        encoder.add_itxt_chunk(name.clone(), text.clone())?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(bytes)?;
    writer.finish()?;
    buffered.flush()?;
    Ok(())
}
