//! JPEG.

use super::{File, Limits, RawImage, ReadError, Samples};
use std::io::Cursor;
use zune_core::{colorspace::ColorSpace, options::DecoderOptions};
use zune_jpeg::JpegDecoder;

/// Largest side: the format has 16 bits for it.
const MOST: usize = 65_535;

pub(super) fn read(file: File<'_>, limits: &Limits) -> Result<RawImage, ReadError> {
    let options = DecoderOptions::default().set_max_width(MOST).set_max_height(MOST).set_use_unsafe(false);
    let mut decoder = JpegDecoder::new_with_options(Cursor::new(file.bytes), options);
    // Stray bytes between headers are common and harmless; in the pixels anything odd is damage.
    decoder.decode_headers().map_err(|e| file.damaged(format!("{e:?}")))?;
    let (width, height) = decoder.dimensions().ok_or_else(|| file.damaged("it has no size"))?;
    let channels = match decoder.input_colorspace() {
        Some(ColorSpace::Luma) => 1,
        _ => 3,
    };
    limits.check_pixels(file, width as u64, height as u64, channels as u64)?;
    let space = if channels == 1 { ColorSpace::Luma } else { ColorSpace::RGB };
    decoder.set_options(options.set_strict_mode(true).jpeg_set_out_colorspace(space));
    let samples = decoder.decode().map_err(|e| file.damaged(format!("{e:?}")))?;
    if samples.len() != width * height * channels {
        return Err(file.damaged("pixels are missing"));
    }
    Ok(RawImage {
        width: width as u32,
        height: height as u32,
        channels: channels as u8,
        samples: Samples::U8(samples),
        encoded_srgb: true,
    })
}
