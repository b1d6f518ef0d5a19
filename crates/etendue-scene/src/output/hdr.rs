//! Radiance HDR: RGBE with the newer run-length coding (Ward, "Real Pixels", Graphics Gems II, 1991). Colour within 1/256 of
//! each pixel's largest channel.

use super::{EncodeError, Metadata, check_shape, color_channels};
use etendue::image::Image;
use std::io::{BufWriter, Write};

/// Rows of other lengths are written without run-length coding.
const RLE: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// Writes the colour of `image`. Negative values and NaN become 0, values above 1.7e38 that; what is below 1e-38, and what is
/// far below the largest channel of its pixel, becomes 0.
pub fn write(out: impl Write, image: &Image, metadata: &Metadata) -> Result<(), EncodeError> {
    check_shape(image)?;
    let [r, g, b] = color_channels(image)?;
    let mut out = BufWriter::new(out);
    writeln!(out, "#?RADIANCE")?;
    let software = ("SOFTWARE".to_owned(), metadata.software.clone());
    for (name, text) in std::iter::once(&software).chain(&metadata.entries) {
        // A line break would end the entry, or the header.
        writeln!(out, "{name}={}", text.replace(['\n', '\r'], " "))?;
    }
    write!(out, "FORMAT=32-bit_rle_rgbe\n\n-Y {} +X {}\n", image.height, image.width)?;
    let width = image.width as usize;
    let mut row = Vec::with_capacity(width);
    for start in (0..r.len()).step_by(width) {
        row.clear();
        row.extend((start..start + width).map(|i| rgbe([r[i], g[i], b[i]])));
        if RLE.contains(&width) {
            out.write_all(&[2, 2, (width >> 8) as u8, width as u8])?;
            (0..4).try_for_each(|channel| write_channel(&mut out, &row, channel))?;
        } else {
            out.write_all(row.as_flattened())?;
        }
    }
    out.flush()?;
    Ok(())
}

/// The three mantissas, rounded, and the exponent of a colour: mantissa times 2^(exponent - 136).
fn rgbe(rgb: [f32; 3]) -> [u8; 4] {
    // 255 * 2^119, the largest value there is.
    const LARGEST: f64 = 255.0 * (1u128 << 119) as f64;
    let rgb = rgb.map(|c| f64::from(c.max(0.0)).min(LARGEST));
    let largest = rgb[0].max(rgb[1]).max(rgb[2]);
    // 2^power <= largest < 2^(power + 1); of 0 it is very low.
    let power = (largest.to_bits() >> 52) as i32 - 1023;
    // The largest mantissa is in 128..=255 unless rounding lifts it.
    let lifted = largest * two_to(7 - power) >= 255.5;
    let exponent = power + 129 + i32::from(lifted);
    if exponent < 1 {
        return [0; 4];
    }
    let scale = two_to(136 - exponent);
    let [r, g, b] = rgb.map(|c| (c * scale + 0.5) as u8);
    [r, g, b, exponent as u8]
}

/// 2 to a power within the range of normal numbers; else the nearest.
fn two_to(power: i32) -> f64 {
    f64::from_bits(((power.clamp(-1022, 1023) + 1023) as u64) << 52)
}

/// One channel of a row in runs of at least four equal bytes and runs of different ones.
fn write_channel(out: &mut impl Write, row: &[[u8; 4]], channel: usize) -> std::io::Result<()> {
    let value = |i: usize| row[i][channel];
    let run = |from: usize| (from..row.len().min(from + 127)).take_while(|&i| value(i) == value(from)).count();
    let mut at = 0;
    while at < row.len() {
        let equal = run(at);
        if equal >= 4 {
            out.write_all(&[128 + equal as u8, value(at)])?;
            at += equal;
            continue;
        }
        let mut end = at + equal;
        while end < row.len() && end - at < 128 && run(end) < 4 {
            end += 1;
        }
        out.write_all(&[(end - at) as u8])?;
        for i in at..end {
            out.write_all(&[value(i)])?;
        }
        at = end;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mantissas_are_rounded_and_ends_are_kept() {
        assert_eq!(rgbe([1.0, 0.5, 0.0]), [128, 64, 0, 129]);
        assert_eq!(rgbe([0.999, 0.0, 0.0]), [128, 0, 0, 129]);
        assert_eq!(rgbe([0.0, 0.996, 0.0]), [0, 255, 0, 128]);
        assert_eq!(rgbe([f32::NAN, -1.0, 0.0]), [0; 4]);
        assert_eq!(rgbe([1e-45, 0.0, 0.0]), [0; 4]);
        assert_eq!(rgbe([f32::INFINITY, 1.0, 0.0]), [255, 0, 0, 255]);
        for i in 0..10_000 {
            let v = libm::exp2(f64::from(i) * 0.025 - 125.0) as f32;
            let [m, _, _, e] = rgbe([v, 0.0, 0.0]);
            let back = f64::from(m) * libm::exp2(f64::from(e) - 136.0);
            assert!((back / f64::from(v) - 1.0).abs() <= 1.0 / 255.0, "{v} {m} {e}");
        }
    }
}
