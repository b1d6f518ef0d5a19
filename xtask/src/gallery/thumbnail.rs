//! Small pictures for the documents.

use super::inputs::Canvas;
use std::io::Cursor;

/// Width of a small picture, pixels.
const WIDTH: usize = 400;
/// Most bytes of its file; the picture gets smaller until it fits.
const MOST: usize = 300 << 10;

/// A small PNG of a PNG's stored values, which viewers are to show as they are: what the file says of its encoding is left out,
/// since the paper's pictures say nothing either.
pub fn of(file: &[u8]) -> Result<Vec<u8>, String> {
    let picture = decode(file).map_err(|e| e.to_string())?;
    let mut width = picture.width.min(WIDTH);
    loop {
        let bytes = shrunk(&picture, width).png();
        if bytes.len() <= MOST || width < 16 {
            return Ok(bytes);
        }
        width = width * 9 / 10;
    }
}

/// Frames of a film side by side, so many in a row, all of one size.
pub fn sheet(files: &[Vec<u8>], columns: usize) -> Result<Vec<u8>, String> {
    let frames: Vec<Canvas<3>> =
        files.iter().map(|file| decode(file)).collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    let mut width = 2 * WIDTH / columns;
    loop {
        let cells: Vec<Canvas<3>> = frames.iter().map(|frame| shrunk(frame, width.min(frame.width))).collect();
        let [w, h] = cells.first().map_or([1, 1], |cell| [cell.width, cell.height]);
        if cells.iter().any(|cell| [cell.width, cell.height] != [w, h]) {
            return Err("frames of different sizes".to_owned());
        }
        let rows = cells.len().div_ceil(columns);
        let mut sheet = Canvas::new(w * columns, h * rows, [1.0; 3]);
        for (i, cell) in cells.iter().enumerate() {
            let (left, top) = (i % columns * w, i / columns * h);
            for (y, row) in cell.pixels.chunks_exact(w).enumerate() {
                let at = (top + y) * sheet.width + left;
                sheet.pixels[at..at + w].copy_from_slice(row);
            }
        }
        let bytes = sheet.png();
        if bytes.len() <= MOST || width < 16 {
            return Ok(bytes);
        }
        width = width * 9 / 10;
    }
}

fn decode(file: &[u8]) -> Result<Canvas<3>, png::DecodingError> {
    let mut decoder = png::Decoder::new(Cursor::new(file));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    let mut reader = decoder.read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or(png::DecodingError::LimitsExceeded)?];
    let info = reader.next_frame(&mut bytes)?;
    let samples = info.color_type.samples();
    let value = |pixel: &[u8], i: usize| f64::from(pixel[if samples < 3 { 0 } else { i }]) / 255.0;
    let pixels = bytes[..info.buffer_size()].chunks_exact(samples).map(|p| [0, 1, 2].map(|i| value(p, i))).collect();
    Ok(Canvas { width: info.width as usize, height: info.height as usize, pixels })
}

/// Each pixel is the mean of what it covers.
fn shrunk(picture: &Canvas<3>, width: usize) -> Canvas<3> {
    let height = (picture.height * width / picture.width).max(1);
    let across = spans(picture.width, width);
    let down = spans(picture.height, height);
    let mut small = Canvas::new(width, height, [0.0; 3]);
    for (pixel, i) in small.pixels.iter_mut().zip(0..) {
        for &(y, wy) in &down[i / width] {
            for &(x, wx) in &across[i % width] {
                let value = picture.pixels[y * picture.width + x];
                *pixel = [0, 1, 2].map(|c| pixel[c] + wx * wy * value[c]);
            }
        }
    }
    small
}

/// For each of `to` equal spans of `from` cells the cells in it and their shares.
fn spans(from: usize, to: usize) -> Vec<Vec<(usize, f64)>> {
    let step = from as f64 / to as f64;
    let share = |cell: usize, low: f64, high: f64| (high.min(cell as f64 + 1.0) - low.max(cell as f64)).max(0.0) / step;
    (0..to)
        .map(|i| {
            let (low, high) = (i as f64 * step, (i + 1) as f64 * step);
            (low as usize..(high.ceil() as usize).min(from)).map(|cell| (cell, share(cell, low, high))).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_kept() {
        let mut picture = Canvas::new(810, 405, [0.0; 3]);
        picture.shade(|p, _| [if p.x < 405.0 { 0.8 } else { 0.2 }, p.y / 405.0, 0.4]);
        let small = decode(&of(&picture.png()).unwrap()).unwrap();
        assert_eq!((small.width, small.height), (400, 200));
        let mean = |c: usize| small.pixels.iter().map(|p| p[c]).sum::<f64>() / small.pixels.len() as f64;
        assert!((mean(0) - 0.5).abs() < 0.003 && (mean(1) - 0.5).abs() < 0.003 && (mean(2) - 0.4).abs() < 1e-9);
        assert!((small.pixels[0][0] - 0.8).abs() < 0.003);
    }

    #[test]
    fn what_does_not_shrink_well_gets_smaller() {
        let mut noise = Canvas::new(700, 700, [0.0; 3]);
        let mut state = 1u32;
        noise.shade(|_, _| {
            [0.0; 3].map(|_| {
                state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                f64::from(state >> 24) / 255.0
            })
        });
        assert!(of(&noise.png()).unwrap().len() <= MOST);
    }

    #[test]
    fn frames_stand_in_rows() {
        let frame = |grey: f64| Canvas::new(8, 6, [grey; 3]).png();
        let files: Vec<Vec<u8>> = [0.0, 0.2, 0.4, 0.6].map(frame).into();
        let together = decode(&sheet(&files, 3).unwrap()).unwrap();
        assert_eq!((together.width, together.height), (24, 12));
        let at = |x: usize, y: usize| together.pixels[y * 24 + x][0];
        assert_eq!([at(0, 0), at(8, 5), at(23, 0), at(7, 6), at(8, 6)], [0.0, 0.2, 0.4, 0.6, 1.0]);
        assert!(sheet(&[frame(0.5), Canvas::new(9, 6, [0.0; 3]).png()], 2).is_err());
    }

    #[test]
    fn other_files_are_refused() {
        assert!(of(b"no picture").is_err());
    }
}
