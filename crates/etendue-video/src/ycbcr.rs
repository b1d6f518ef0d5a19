//! From R'G'B' to Y'CbCr 4:2:0 as Rec. ITU-R BT.709-6 has it, limited range.
//!
//! Colour is halved in both directions by a filter that leaves it where MPEG-2 and H.264 expect it unless told otherwise:
//! horizontally on the even columns (weights 1 2 1), vertically between two rows (1 1).

/// Fixed point of the coefficients.
const BITS: u32 = 20;
/// Rounded, with the sum that makes white exactly 235: 219/255 of (0.2126, 0.7152, 0.0722).
const LUMA: [i32; 3] = [191_455, 644_068, 65_019];
/// 224/255 of (B' - Y') / 1.8556; sums to 0, so that greys are exactly 128.
const BLUE: [i32; 3] = [-105_533, -355_018, 460_551];
/// 224/255 of (R' - Y') / 1.5748.
const RED: [i32; 3] = [460_551, -418_321, -42_230];

/// Planes of one picture, which may be larger than the frame: edges are repeated to the right and below.
pub(crate) struct Planes {
    frame: [usize; 2],
    /// Width and height of `y`; those of `cb` and `cr` are half, rounded up.
    pub luma: [usize; 2],
    pub y: Vec<u8>,
    pub cb: Vec<u8>,
    pub cr: Vec<u8>,
    /// Of a pair of rows: per column the sums of both rows.
    sums: Vec<[i32; 3]>,
}

impl Planes {
    /// For frames of size `frame`, each side padded to a multiple of `block` (a power of two).
    pub fn new(frame: [u32; 2], block: usize) -> Self {
        let frame = frame.map(|n| n as usize);
        let luma = frame.map(|n| n.next_multiple_of(block));
        let chroma = luma[0].div_ceil(2) * luma[1].div_ceil(2);
        Self {
            frame,
            luma,
            y: vec![16; luma[0] * luma[1]],
            cb: vec![128; chroma],
            cr: vec![128; chroma],
            sums: vec![[0; 3]; frame[0]],
        }
    }

    /// Fills the planes from sRGB bytes, rows from the top.
    pub fn convert(&mut self, rgb: &[u8]) {
        let [width, height] = self.frame;
        for (row, out) in self.y.chunks_exact_mut(self.luma[0]).enumerate() {
            let row = row.min(height - 1);
            let pixels = rgb[row * width * 3..(row + 1) * width * 3].as_chunks::<3>().0;
            for (out, pixel) in out.iter_mut().zip(pixels) {
                *out = luma(*pixel);
            }
            let last = out[width - 1];
            out[width..].fill(last);
        }
        let columns = self.luma[0].div_ceil(2);
        for (pair, (cb, cr)) in self.cb.chunks_exact_mut(columns).zip(self.cr.chunks_exact_mut(columns)).enumerate() {
            let row = |n: usize| {
                let n = n.min(height - 1);
                rgb[n * width * 3..(n + 1) * width * 3].as_chunks::<3>().0
            };
            for ((sum, a), b) in self.sums.iter_mut().zip(row(pair * 2)).zip(row(pair * 2 + 1)) {
                *sum = [0, 1, 2].map(|c| i32::from(a[c]) + i32::from(b[c]));
            }
            for (column, (cb, cr)) in cb.iter_mut().zip(cr.iter_mut()).enumerate() {
                let at = |n: usize| self.sums[n.min(width - 1)];
                let middle = column * 2;
                let (left, here, right) = (at(middle.saturating_sub(1)), at(middle), at(middle + 1));
                let filtered = [0, 1, 2].map(|c| left[c] + 2 * here[c] + right[c]);
                *cb = chroma(BLUE, filtered);
                *cr = chroma(RED, filtered);
            }
        }
    }
}

fn dot(a: [i32; 3], b: [i32; 3]) -> i32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

fn luma(pixel: [u8; 3]) -> u8 {
    let y = 16 + ((dot(LUMA, pixel.map(i32::from)) + (1 << (BITS - 1))) >> BITS);
    y.clamp(16, 235) as u8
}

/// Of the sum of eight pixels; at most 8 * 255 * 460551 < 2^30.
fn chroma(coefficients: [i32; 3], sum: [i32; 3]) -> u8 {
    let c = 128 + ((dot(coefficients, sum) + (1 << (BITS + 2))) >> (BITS + 3));
    c.clamp(16, 240) as u8
}

#[cfg(test)]
mod tests {
    use super::*;

    /// BT.709-6, items 3.2 to 3.4 and 4.6, in f64 and before rounding.
    fn reference(rgb: [f64; 3]) -> [f64; 3] {
        let [r, g, b] = rgb.map(|c| c / 255.0);
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        [16.0 + 219.0 * y, 128.0 + 224.0 * (b - y) / 1.8556, 128.0 + 224.0 * (r - y) / 1.5748]
    }

    #[test]
    fn coefficients_leave_greys_grey() {
        assert_eq!(LUMA.iter().sum::<i32>(), (219.0f64 / 255.0 * f64::from(1 << BITS)).round() as i32);
        assert_eq!(BLUE.iter().sum::<i32>(), 0);
        assert_eq!(RED.iter().sum::<i32>(), 0);
        for grey in 0..=255u8 {
            let mut planes = Planes::new([2, 2], 1);
            planes.convert(&[grey; 12]);
            assert_eq!((planes.cb[0], planes.cr[0]), (128, 128));
            assert_eq!(planes.y[0], (16.0 + f64::from(grey) * 219.0 / 255.0).round() as u8);
        }
    }

    #[test]
    fn every_colour_is_rounded_to_the_nearest() {
        for r in (0..=255u8).step_by(5) {
            for g in (0..=255u8).step_by(3) {
                for b in 0..=255u8 {
                    let expected = reference([r, g, b].map(f64::from));
                    let eight = [r, g, b].map(|c| i32::from(c) * 8);
                    let got = [luma([r, g, b]), chroma(BLUE, eight), chroma(RED, eight)];
                    for c in 0..3 {
                        let off = (f64::from(got[c]) - expected[c]).abs();
                        assert!(off < 0.5005, "{r} {g} {b}: {got:?} for {expected:?}");
                    }
                }
            }
        }
    }

    #[test]
    fn odd_sizes_repeat_their_edges() {
        // 3 x 3, the right column and the bottom row of another colour.
        let (dark, bright) = ([10u8, 20, 30], [200u8, 90, 50]);
        let rgb: Vec<u8> = (0..9).flat_map(|i| if i % 3 == 2 || i / 3 == 2 { bright } else { dark }).collect();
        let mut planes = Planes::new([3, 3], 16);
        planes.convert(&rgb);
        assert_eq!(planes.luma, [16, 16]);
        let (y_dark, y_bright) = (luma(dark), luma(bright));
        for row in 0..16 {
            for column in 0..16 {
                let expected = if row >= 2 || column >= 2 { y_bright } else { y_dark };
                assert_eq!(planes.y[row * 16 + column], expected, "{row} {column}");
            }
        }
        let eight = bright.map(|c| i32::from(c) * 8);
        assert!(planes.cb[8..].iter().all(|&c| c == chroma(BLUE, eight)));
        // The colour of the first pixel lies on the first column.
        let eight = dark.map(|c| i32::from(c) * 8);
        assert_eq!(planes.cr[0], chroma(RED, eight));
    }

    #[test]
    fn colour_sits_on_even_columns() {
        // A ramp in red: at even columns the filter returns the value that stands there.
        let rgb: Vec<u8> = (0..2 * 32).flat_map(|i| [(i % 32) as u8 * 8, 0, 0]).collect();
        let mut planes = Planes::new([32, 2], 1);
        planes.convert(&rgb);
        for column in 1..16 {
            let expected = reference([column as f64 * 16.0, 0.0, 0.0])[2];
            assert!((f64::from(planes.cr[column]) - expected).abs() <= 0.51, "{column}");
        }
    }

    #[test]
    fn one_pixel_and_all_block_sizes() {
        for block in [1, 2, 16] {
            let mut planes = Planes::new([1, 1], block);
            planes.convert(&[255, 0, 0]);
            assert!(planes.y.iter().all(|&y| y == 63));
            assert!(planes.cr.iter().all(|&c| c == 240));
        }
    }
}
