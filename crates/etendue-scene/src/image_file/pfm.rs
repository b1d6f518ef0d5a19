//! Portable float map: three (`PF`) or one (`Pf`) linear 32 bit floats a pixel, rows from the bottom up (Debevec 2001).

use super::{File, Limits, RawImage, ReadError, Samples};

/// The scale's size is not applied, only its sign: it tells the order of bytes.
pub(super) fn read(file: File<'_>, limits: &Limits) -> Result<RawImage, ReadError> {
    let mut rest = file.bytes;
    let channels = match word(&mut rest) {
        Some("PF") => 3,
        Some("Pf") => 1,
        _ => return Err(file.damaged("the first line is neither PF nor Pf")),
    };
    let mut dimension = || word(&mut rest).and_then(|w| w.parse::<u32>().ok()).filter(|&v| v > 0);
    let (width, height) =
        dimension().zip(dimension()).ok_or_else(|| file.damaged("the size is not two whole numbers"))?;
    let scale = word(&mut rest)
        .and_then(|w| w.parse::<f32>().ok())
        .filter(|s| s.is_finite() && *s != 0.0)
        .ok_or_else(|| file.damaged("the scale is not a number other than 0"))?;
    limits.check_pixels(file, width.into(), height.into(), channels as u64)?;
    let row = width as usize * channels * 4;
    let Some(data) = rest.get(..row * height as usize) else {
        return Err(file.damaged("pixels are missing"));
    };
    let from_bytes = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let rows = data.chunks_exact(row).rev();
    let samples = rows.flat_map(|row| row.chunks_exact(4).map(|b| from_bytes([b[0], b[1], b[2], b[3]]))).collect();
    Ok(RawImage { width, height, channels: channels as u8, samples: Samples::F32(samples), encoded_srgb: false })
}

/// The next word of the header, with the one white-space byte after it taken too.
fn word<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
    let length = rest[start..].iter().take(64).position(u8::is_ascii_whitespace)?;
    let word = std::str::from_utf8(&rest[start..start + length]).ok();
    *rest = &rest[start + length + 1..];
    word
}
