//! Portable float map: three (`PF`) or one (`Pf`) linear 32 bit floats a pixel, rows from the bottom up (Debevec 2001).

use super::{EncodeError, check_shape, color_channels};
use etendue::image::Image;
use std::io::{BufWriter, Write};

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
