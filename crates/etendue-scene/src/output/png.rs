//! PNG: 8 bits a channel.

use super::{Encode, EncodeError, Metadata, check_shape, color_channels};
use etendue::{image::Image, tonemap::Encoding};
use std::io::{BufWriter, Write};

impl From<png::EncodingError> for EncodeError {
    fn from(error: png::EncodingError) -> Self {
        match error {
            png::EncodingError::IoError(e) => Self::Io(e),
            other => Self::Malformed(other.to_string()),
        }
    }
}

/// Writes the colour of `image` in 8 bits, with chunks that say how it is encoded, and the metadata as text. If it has a channel
/// `A`, by which colours are multiplied, PNG's straight alpha is made of it: `encode` gets the colour divided by it.
pub fn write(out: impl Write, image: &Image, metadata: &Metadata, encode: Encode<'_>) -> Result<(), EncodeError> {
    check_shape(image)?;
    let [r, g, b] = color_channels(image)?;
    let size = [image.width, image.height];
    let colours = r.iter().zip(g).zip(b).map(|((&r, &g), &b)| [r, g, b]);
    let Some(alpha) = image.f32_channel("A") else {
        let bytes: Vec<[u8; 3]> = colours.map(encode).collect();
        return write_bytes(out, size, png::ColorType::Rgb, bytes.as_flattened(), metadata);
    };
    let straight = |(colour, &alpha): ([f32; 3], &f32)| {
        // Not true for NaN. Light where nothing covers cannot be told in such a file.
        let covered = alpha > 0.0;
        let [r, g, b] = if covered { encode(colour.map(|c| c / alpha)) } else { [0; 3] };
        [r, g, b, if covered { (alpha.min(1.0) * 255.0 + 0.5) as u8 } else { 0 }]
    };
    let bytes: Vec<[u8; 4]> = colours.zip(alpha).map(straight).collect();
    write_bytes(out, size, png::ColorType::Rgba, bytes.as_flattened(), metadata)
}

/// Writes `width * height` pixels of three bytes.
pub fn write_rgb8(out: impl Write, size: [u32; 2], bytes: &[u8], metadata: &Metadata) -> Result<(), EncodeError> {
    write_bytes(out, size, png::ColorType::Rgb, bytes, metadata)
}

fn write_bytes(
    out: impl Write,
    size: [u32; 2],
    color: png::ColorType,
    bytes: &[u8],
    metadata: &Metadata,
) -> Result<(), EncodeError> {
    let mut buffered = BufWriter::new(out);
    let mut encoder = png::Encoder::new(&mut buffered, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    match metadata.encoding {
        Encoding::Srgb => {
            encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
            // The value that the PNG specification gives for readers that do not know the sRGB chunk.
            encoder.set_source_gamma(png::ScaledFloat::from_scaled(45_455));
        }
        Encoding::Linear => encoder.set_source_gamma(png::ScaledFloat::from_scaled(100_000)),
    }
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
