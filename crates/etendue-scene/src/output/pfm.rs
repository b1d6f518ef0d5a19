//! Portable float map: three (`PF`) or one (`Pf`) linear 32 bit floats a pixel, rows from the bottom up (Debevec 2001).

use super::{EncodeError, Limits, ReadError, check_shape, color_channels};
use etendue::image::{Channel, ChannelData, Image};
use std::{
    io::{BufWriter, Write},
    path::Path,
};

/// Writes the colour of `image`, little-endian.
pub fn write(out: impl Write, image: &Image) -> Result<(), EncodeError> {
    check_shape(image)?;
    let [r, g, b] = color_channels(image)?;
    let width = image.width as usize;
    let mut out = BufWriter::new(out);
    write!(out, "PF\n{} {}\n-1.0\n", image.width, image.height)?;
    for row in (0..image.height as usize).rev() {
        for pixel in row * width..(row + 1) * width {
            for channel in [r, g, b] {
                out.write_all(&channel[pixel].to_le_bytes())?;
            }
        }
    }
    out.flush()?;
    Ok(())
}

/// Reads a PFM file from memory; a grey one gives equal `R G B`.
pub fn read(path: &Path, file: &[u8], limits: &Limits) -> Result<Image, ReadError> {
    let damaged = |what: &str| ReadError::damaged(path, "PFM", what.to_owned());
    let mut rest = file;
    let samples = match word(&mut rest) {
        Some("PF") => 3,
        Some("Pf") => 1,
        _ => return Err(damaged("the first line is neither PF nor Pf")),
    };
    let mut dimension = || word(&mut rest).and_then(|w| w.parse::<u32>().ok()).filter(|&v| v > 0);
    let (width, height) = dimension().zip(dimension()).ok_or_else(|| damaged("the size is not two whole numbers"))?;
    let scale = word(&mut rest)
        .and_then(|w| w.parse::<f32>().ok())
        .filter(|s| s.is_finite() && *s != 0.0)
        .ok_or_else(|| damaged("the scale is not a number other than 0"))?;
    limits.check_pixels(path, width.into(), height.into(), 3)?;
    let pixels = width as usize * height as usize;
    if rest.len() < pixels * samples * 4 {
        return Err(damaged("pixels are missing"));
    }
    let from_bytes = if scale < 0.0 { f32::from_le_bytes } else { f32::from_be_bytes };
    let value = |x: usize, y: usize, sample: usize| {
        let at = 4 * (((height as usize - 1 - y) * width as usize + x) * samples + sample);
        from_bytes([rest[at], rest[at + 1], rest[at + 2], rest[at + 3]])
    };
    let channels = ["R", "G", "B"]
        .iter()
        .enumerate()
        .map(|(c, name)| {
            let data = (0..height as usize).flat_map(|y| (0..width as usize).map(move |x| (x, y)));
            let data = data.map(|(x, y)| value(x, y, c.min(samples - 1))).collect();
            Channel { name: (*name).to_owned(), data: ChannelData::F32(data) }
        })
        .collect();
    Ok(Image { width, height, channels })
}

/// The next word of the header, with the one white-space byte after it taken too.
fn word<'a>(rest: &mut &'a [u8]) -> Option<&'a str> {
    let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
    let length = rest[start..].iter().take(64).position(u8::is_ascii_whitespace)?;
    let word = std::str::from_utf8(&rest[start..start + length]).ok();
    *rest = &rest[start + length + 1..];
    word
}
