//! PNG of every kind.

use super::{File, Limits, RawImage, ReadError, Samples};
use std::io::Cursor;

/// Palettes and small depths become 8 bit. Samples are as stored, except in files that state another gamma than that of sRGB:
/// these become linear floats.
pub(super) fn read(file: File<'_>, limits: &Limits) -> Result<RawImage, ReadError> {
    let damaged = |e: png::DecodingError| match e {
        png::DecodingError::LimitsExceeded => {
            ReadError::too_large(file.path, "its rows or texts exceed the memory limit")
        }
        e => file.damaged(e),
    };
    let mut decoder = png::Decoder::new_with_limits(Cursor::new(file.bytes), png::Limits { bytes: limits.texts });
    decoder.set_transformations(png::Transformations::EXPAND);
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let header = decoder.read_header_info().map_err(damaged)?;
    let (width, height) = header.size();
    limits.check_pixels(file, width.into(), height.into(), 4)?;
    // Deflate makes at most 1032 bytes from one.
    if header.raw_bytes() as u64 > (file.bytes.len() as u64).saturating_mul(1032) {
        return Err(file.damaged(format!("{width}x{height} pixels cannot be in so small a file")));
    }
    let mut reader = decoder.read_info().map_err(damaged)?;
    let size = reader.output_buffer_size().ok_or_else(|| ReadError::too_large(file.path, "its pixels"))?;
    let mut bytes = vec![0; size];
    let frame = reader.next_frame(&mut bytes).map_err(damaged)?;
    let channels = frame.color_type.samples();
    let wide = frame.bit_depth == png::BitDepth::Sixteen;
    let count = width as usize * height as usize * channels;
    if bytes.len() < count * (1 + usize::from(wide)) {
        return Err(file.damaged("pixels are missing"));
    }
    let samples = if wide {
        Samples::U16(bytes.chunks_exact(2).take(count).map(|b| u16::from_be_bytes([b[0], b[1]])).collect())
    } else {
        bytes.truncate(count);
        Samples::U8(bytes)
    };
    let stored = RawImage { width, height, channels: channels as u8, samples, encoded_srgb: true };
    Ok(match other_gamma(reader.info()) {
        None => stored,
        Some(1.0) => RawImage { encoded_srgb: false, ..stored },
        Some(exponent) => decoded(stored, exponent),
    })
}

/// The exponent that makes values linear, where a `gAMA` chunk alone says that they are not sRGB; 0.45455 there is how sRGB
/// is commonly labelled.
fn other_gamma(info: &png::Info<'_>) -> Option<f64> {
    let gamma = info.gama_chunk.map(|g| f64::from(g.into_value())).filter(|g| *g > 0.0 && info.srgb.is_none())?;
    let exponent = if (gamma - 1.0).abs() < 1e-4 { 1.0 } else { 1.0 / gamma };
    ((gamma - 0.454_55).abs() > 1e-3).then_some(exponent)
}

fn decoded(image: RawImage, exponent: f64) -> RawImage {
    let channels = usize::from(image.channels);
    let alpha = image.has_alpha().then_some(channels - 1);
    let value = |i: usize, v: f64| if Some(i % channels) == alpha { v as f32 } else { libm::pow(v, exponent) as f32 };
    let samples = match &image.samples {
        Samples::U8(samples) => samples.iter().enumerate().map(|(i, &v)| value(i, f64::from(v) / 255.0)).collect(),
        Samples::U16(samples) => samples.iter().enumerate().map(|(i, &v)| value(i, f64::from(v) / 65_535.0)).collect(),
        Samples::F32(samples) => samples.clone(),
    };
    RawImage { samples: Samples::F32(samples), encoded_srgb: false, ..image }
}
