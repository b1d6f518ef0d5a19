//! Radiance pictures, RGBE (Ward, "Real Pixels", Graphics Gems II, 1991).

use super::{File, Limits, RawImage, ReadError, Samples};

/// Most bytes of the header.
const HEADER: usize = 1 << 16;

/// Shortest and longest rows that the newer run-length coding can have.
const RLE: std::ops::RangeInclusive<usize> = 8..=0x7fff;

/// `EXPOSURE` and `COLORCORR` lines are not applied, as by most programs.
pub(super) fn read(file: File<'_>, limits: &Limits) -> Result<RawImage, ReadError> {
    let mut lines = Lines { file, at: 0 };
    loop {
        let line = lines.next()?;
        if line.is_empty() {
            break;
        }
        if let Some(format) = line.strip_prefix("FORMAT=")
            && format.trim() != "32-bit_rle_rgbe"
        {
            return Err(file.damaged(format!("pixels of format `{}` are not read", format.trim())));
        }
    }
    let layout = Layout::parse(lines.next()?)
        .ok_or_else(|| file.damaged("the line with the size is not like `-Y HEIGHT +X WIDTH`"))?;
    limits.check_pixels(file, layout.width as u64, layout.height as u64, 3)?;
    let mut rest = &file.bytes[lines.at..];
    let (rows, length) = if layout.by_rows { (layout.height, layout.width) } else { (layout.width, layout.height) };
    let powers = powers();
    let mut samples = vec![0.0; layout.width * layout.height * 3];
    let mut row = vec![[0; 4]; length];
    for number in 0..rows {
        read_row(&mut rest, &mut row).map_err(|what| file.damaged(format!("{what} in row {number} of {rows}")))?;
        for (i, &[r, g, b, exponent]) in row.iter().enumerate() {
            let power = powers[usize::from(exponent)];
            let at = 3 * layout.pixel(number, i);
            samples[at..at + 3].copy_from_slice(&[r, g, b].map(|m| f32::from(m) * power));
        }
    }
    let (width, height) = (layout.width as u32, layout.height as u32);
    Ok(RawImage { width, height, channels: 3, samples: Samples::F32(samples), encoded_srgb: false })
}

/// What a mantissa counts for with each exponent, exactly: 0, then 2^(e - 136).
fn powers() -> [f32; 256] {
    std::array::from_fn(|e| match e {
        0 => 0.0,
        e => f64::from_bits((e as u64 + 1023 - 136) << 52) as f32,
    })
}

/// Lines of the header.
struct Lines<'a> {
    file: File<'a>,
    at: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Result<&'a str, ReadError> {
        let rest = &self.file.bytes[self.at..self.file.bytes.len().min(HEADER)];
        let length =
            rest.iter().position(|&b| b == b'\n').ok_or_else(|| self.file.damaged("its header does not end"))?;
        self.at += length + 1;
        let line = rest[..length].trim_ascii_end();
        // Only what is not read may be in another encoding.
        Ok(str::from_utf8(line).unwrap_or("?"))
    }
}

/// Where pixels go.
struct Layout {
    width: usize,
    height: usize,
    /// A run of pixels in the file is a row, not a column.
    by_rows: bool,
    from_right: bool,
    from_bottom: bool,
}

impl Layout {
    fn parse(line: &str) -> Option<Self> {
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        let [first, rows, second, columns] = words[..] else { return None };
        let size = |text: &str| text.parse::<u32>().ok().filter(|&v| v > 0).map(|v| v as usize);
        let (rows, columns) = (size(rows)?, size(columns)?);
        let by_rows = first.ends_with('Y');
        let (y, x) = if by_rows { (first, second) } else { (second, first) };
        let (height, width) = if by_rows { (rows, columns) } else { (columns, rows) };
        // -Y goes from the top down.
        let from_bottom = match y {
            "-Y" => false,
            "+Y" => true,
            _ => return None,
        };
        let from_right = match x {
            "+X" => false,
            "-X" => true,
            _ => return None,
        };
        Some(Self { width, height, by_rows, from_right, from_bottom })
    }

    /// Index of pixel `i` of run `number`.
    fn pixel(&self, number: usize, i: usize) -> usize {
        let (y, x) = if self.by_rows { (number, i) } else { (i, number) };
        let y = if self.from_bottom { self.height - 1 - y } else { y };
        let x = if self.from_right { self.width - 1 - x } else { x };
        y * self.width + x
    }
}

const ENDS: &str = "the pixels end";

fn read_row(rest: &mut &[u8], row: &mut [[u8; 4]]) -> Result<(), &'static str> {
    match *rest {
        [2, 2, high @ 0..0x80, low, after @ ..] if RLE.contains(&row.len()) => {
            if usize::from(*high) << 8 | usize::from(*low) != row.len() {
                return Err("another length is written");
            }
            *rest = after;
            (0..4).try_for_each(|channel| read_channel(rest, row, channel))
        }
        _ => read_old_row(rest, row),
    }
}

/// The newer run-length coding: one channel of a row, in runs of equal and of different bytes.
fn read_channel(rest: &mut &[u8], row: &mut [[u8; 4]], channel: usize) -> Result<(), &'static str> {
    let mut at = 0;
    while at < row.len() {
        let (&code, after) = rest.split_first().ok_or(ENDS)?;
        let (count, equal) = if code > 128 { (usize::from(code) - 128, true) } else { (usize::from(code), false) };
        let values = after.get(..if equal { 1 } else { count }).ok_or(ENDS)?;
        *rest = &after[values.len()..];
        let run = row.get_mut(at..at + count).filter(|_| count > 0).ok_or("a run does not fit")?;
        for (i, pixel) in run.iter_mut().enumerate() {
            pixel[channel] = values[if equal { 0 } else { i }];
        }
        at += count;
    }
    Ok(())
}

/// Pixels as they are, or the older run-length coding: mantissas 1, 1, 1 repeat the pixel before, and such counts in a row
/// are digits to the base 256, the least first.
fn read_old_row(rest: &mut &[u8], row: &mut [[u8; 4]]) -> Result<(), &'static str> {
    let (mut at, mut shift) = (0, 0);
    while at < row.len() {
        let (&pixel, after) = rest.split_first_chunk::<4>().ok_or(ENDS)?;
        *rest = after;
        if let [1, 1, 1, count] = pixel {
            let count = usize::from(count) << shift;
            let before = *row[..at].last().ok_or("a run repeats nothing")?;
            row.get_mut(at..at + count).ok_or("a run does not fit")?.fill(before);
            at += count;
            shift += 8;
            if shift > 16 && at < row.len() {
                return Err("a run does not fit");
            }
        } else {
            row[at] = pixel;
            at += 1;
            shift = 0;
        }
    }
    Ok(())
}
