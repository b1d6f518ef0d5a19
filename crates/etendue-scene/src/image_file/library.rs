//! TGA, BMP and WebP by the `image` crate.

use super::{File, Kind, Limits, RawImage, ReadError, Samples};
use image::{
    ColorType, ImageDecoder, ImageError,
    codecs::{bmp::BmpDecoder, tga::TgaDecoder, webp::WebPDecoder},
};
use std::io::Cursor;

pub(super) fn read(file: File<'_>, limits: &Limits) -> Result<RawImage, ReadError> {
    let bytes = Cursor::new(file.bytes);
    let failed = |e: ImageError| error(file, &e);
    match file.kind {
        Kind::Tga => decode(file, limits, TgaDecoder::new(bytes).map_err(failed)?),
        Kind::Bmp => decode(file, limits, BmpDecoder::new(bytes).map_err(failed)?),
        _ => decode(file, limits, WebPDecoder::new(bytes).map_err(failed)?),
    }
}

fn error(file: File<'_>, error: &ImageError) -> ReadError {
    match error {
        ImageError::Limits(_) => ReadError::too_large(file.path, "its pixels exceed the memory limit"),
        other => file.damaged(other),
    }
}

fn decode(file: File<'_>, limits: &Limits, mut decoder: impl ImageDecoder) -> Result<RawImage, ReadError> {
    let (width, height) = decoder.dimensions();
    let color = decoder.color_type();
    if width == 0 || height == 0 {
        return Err(file.damaged("it has no pixels"));
    }
    limits.check_pixels(file, width.into(), height.into(), u64::from(color.channel_count()))?;
    let mut bounds = image::Limits::default();
    // The decoder's own buffers count too.
    bounds.max_alloc = Some(limits.decoded.saturating_mul(2));
    decoder.set_limits(bounds).map_err(|e| error(file, &e))?;
    if !matches!(color, ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8) {
        return Err(file.damaged(format!("samples of kind {color:?} are not read")));
    }
    let mut samples = vec![0; width as usize * height as usize * usize::from(color.channel_count())];
    if decoder.total_bytes() != samples.len() as u64 {
        return Err(file.damaged("pixels are missing"));
    }
    decoder.read_image(&mut samples).map_err(|e| error(file, &e))?;
    Ok(RawImage { width, height, channels: color.channel_count(), samples: Samples::U8(samples), encoded_srgb: true })
}
