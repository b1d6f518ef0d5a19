//! PNG: 8 bit sRGB out; 8 and 16 bit in, decoded to linear.

use super::{Encode, EncodeError, Limits, Metadata, ReadError, check_shape, color_channels, srgb};
use etendue::image::{Channel, ChannelData, Image};
use std::{
    io::{BufWriter, Cursor, Write},
    path::Path,
};

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

/// Reads a PNG file of any kind from memory to linear `R G B` (and `A` if it has one): 8 and 16 bit sRGB, palettes,
/// greys; files that state another gamma are decoded with that. Only the first frame of an animation is read.
pub fn read(path: &Path, file: &[u8], limits: &Limits) -> Result<Image, ReadError> {
    let damaged = |e: png::DecodingError| match e {
        png::DecodingError::LimitsExceeded => ReadError::too_large(path, "its rows or texts exceed the memory limit"),
        e => ReadError::damaged(path, "PNG", e.to_string()),
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(file), png::Limits { bytes: limits.texts });
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let header = decoder.read_header_info().map_err(damaged)?;
    let (width, height) = header.size();
    limits.check_pixels(path, width.into(), height.into(), 4)?;
    // Deflate makes at most 1032 bytes from one.
    if header.raw_bytes() as u64 > (file.len() as u64).saturating_mul(1032) {
        return Err(ReadError::damaged(path, "PNG", format!("{width}x{height} pixels cannot be in so small a file")));
    }
    let mut reader = decoder.read_info().map_err(damaged)?;
    let size = reader.output_buffer_size().ok_or_else(|| ReadError::too_large(path, "its pixels"))?;
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(damaged)?;
    let decode = Decoding::of(reader.info());
    let wide = frame.bit_depth == png::BitDepth::Sixteen;
    let samples = frame.color_type.samples();
    let pixels = width as usize * height as usize;
    let levels = if wide { 65_536 } else { 256 };
    let linear: Vec<f32> = (0..levels).map(|v| decode.linear(f64::from(v) / f64::from(levels - 1)) as f32).collect();
    let value = |pixel: usize, sample: usize| {
        let at = pixel * samples + sample;
        if wide { usize::from(bytes[2 * at]) << 8 | usize::from(bytes[2 * at + 1]) } else { usize::from(bytes[at]) }
    };
    if bytes.len() < pixels * samples * (1 + usize::from(wide)) {
        return Err(ReadError::damaged(path, "PNG", "pixels are missing"));
    }
    let grey = samples < 3;
    let mut channels: Vec<Channel> = ["R", "G", "B"]
        .iter()
        .enumerate()
        .map(|(c, name)| Channel {
            name: (*name).to_owned(),
            data: ChannelData::F32((0..pixels).map(|p| linear[value(p, if grey { 0 } else { c })]).collect()),
        })
        .collect();
    if samples % 2 == 0 {
        let alpha = (0..pixels).map(|p| value(p, samples - 1) as f32 / (levels - 1) as f32).collect();
        channels.push(Channel { name: "A".to_owned(), data: ChannelData::F32(alpha) });
    }
    Ok(Image { width, height, channels })
}

/// How encoded values become linear.
enum Decoding {
    Srgb,
    Power(f64),
}

impl Decoding {
    /// sRGB unless a `gAMA` chunk alone says that it is something else; 0.45455 there is how sRGB is commonly labelled.
    fn of(info: &png::Info<'_>) -> Self {
        match info.gama_chunk.map(|g| f64::from(g.into_value())) {
            Some(gamma) if info.srgb.is_none() && gamma > 0.0 && (gamma - 0.454_55).abs() > 1e-3 => {
                Self::Power(1.0 / gamma)
            }
            _ => Self::Srgb,
        }
    }

    fn linear(&self, encoded: f64) -> f64 {
        match self {
            Self::Srgb => srgb::to_linear(encoded),
            Self::Power(exponent) => libm::pow(encoded, *exponent),
        }
    }
}
