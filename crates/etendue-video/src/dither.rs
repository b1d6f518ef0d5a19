//! Ordered dithering with any palette: a colour becomes a list of palette entries whose mean it is, and the pixel's place
//! in a fixed matrix picks one of them (Knoll's pattern dithering; Yliluoma 2011). What does not move keeps its pattern from
//! frame to frame, where error diffusion would crawl.

use crate::palette::{Palette, nearest};

/// Entries in a list: as many as halves of a threshold.
const MIX: usize = 8;
/// Levels of a channel that lists are made for; the levels between are dithered to these.
const LEVELS: u32 = 64;

/// Thresholds from 0 to 63 (Bayer 1973).
const MATRIX: [[u8; 8]; 8] = [
    [0, 32, 8, 40, 2, 34, 10, 42],
    [48, 16, 56, 24, 50, 18, 58, 26],
    [12, 44, 4, 36, 14, 46, 6, 38],
    [60, 28, 52, 20, 62, 30, 54, 22],
    [3, 35, 11, 43, 1, 33, 9, 41],
    [51, 19, 59, 27, 49, 17, 57, 25],
    [15, 47, 7, 39, 13, 45, 5, 37],
    [63, 31, 55, 23, 61, 29, 53, 21],
];

/// A palette with the lists that were needed so far.
pub(crate) struct Dither {
    palette: Palette,
    /// One more than the place in `lists`; 0 for none yet.
    known: Vec<u32>,
    lists: Vec<[u8; MIX]>,
}

impl Dither {
    /// The palette has from 1 to 256 colours.
    pub fn new(palette: Palette) -> Self {
        Self { palette, known: vec![0; LEVELS.pow(3) as usize], lists: Vec::new() }
    }

    pub fn palette(&self) -> &Palette {
        &self.palette
    }

    /// A palette index for every pixel.
    pub fn indices(&mut self, rgb: &[u8], width: usize, out: &mut Vec<u8>) {
        out.clear();
        for (y, row) in rgb.chunks_exact(width * 3).enumerate() {
            for (x, pixel) in row.as_chunks::<3>().0.iter().enumerate() {
                // The upper half of the threshold picks from the list, the lower rounds to a level: every pair of
                // halves occurs once, so that the two roundings have nothing to do with each other.
                let threshold = u32::from(MATRIX[y % 8][x % 8]);
                let (pick, fine) = (threshold / 8, threshold % 8);
                let level = |v: u8| (u32::from(v) * (LEVELS - 1) * 16 + (2 * fine + 1) * 255) / (255 * 16);
                let list = self.list(pixel.map(level));
                out.push(list[pick as usize]);
            }
        }
    }

    fn list(&mut self, levels: [u32; 3]) -> [u8; MIX] {
        let cell = ((levels[0] * LEVELS + levels[1]) * LEVELS + levels[2]) as usize;
        if let Some(list) = self.known[cell].checked_sub(1) {
            return self.lists[list as usize];
        }
        let list = mix(&self.palette, levels.map(|l| ((l * 255 + (LEVELS - 1) / 2) / (LEVELS - 1)) as i32));
        self.lists.push(list);
        self.known[cell] = self.lists.len() as u32;
        list
    }
}

/// Palette indices whose colours have `color` as their mean, as near as the palette allows; from dark to bright.
fn mix(palette: &Palette, color: [i32; 3]) -> [u8; MIX] {
    let mut left = [0; 3];
    let mut list = [0; MIX];
    for entry in &mut list {
        let wanted = [0, 1, 2].map(|c| (color[c] + left[c]).clamp(0, 255));
        let (index, _) = nearest(palette, wanted);
        *entry = index as u8;
        left = [0, 1, 2].map(|c| left[c] + color[c] - i32::from(palette[index][c]));
    }
    let luma = |&i: &u8| {
        let [r, g, b] = palette[usize::from(i)].map(u32::from);
        (r * 54 + g * 183 + b * 19, i)
    };
    list.sort_unstable_by_key(luma);
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_matrix_has_every_threshold() {
        let mut all: Vec<u8> = MATRIX.iter().flatten().copied().collect();
        all.sort_unstable();
        assert!(all.iter().enumerate().all(|(i, &t)| usize::from(t) == i));
    }

    #[test]
    fn the_mean_is_kept() {
        let palette: Palette = (0..64).map(|i| [i / 16, i / 4 % 4, i % 4].map(|c: u8| c * 85)).collect();
        let mut dither = Dither::new(palette.clone());
        for color in [[1u8, 2, 3], [200, 100, 50], [254, 254, 1], [127, 128, 129], [85, 85, 85]] {
            let mut indices = Vec::new();
            dither.indices(&color.repeat(64 * 64), 64, &mut indices);
            for c in 0..3 {
                let sum: f64 = indices.iter().map(|&i| f64::from(palette[usize::from(i)][c])).sum();
                let mean = sum / indices.len() as f64;
                // One entry of a list more or less.
                assert!((mean - f64::from(color[c])).abs() < 85.0 / MIX as f64, "{color:?} channel {c}: {mean}");
            }
        }
        assert!(dither.palette().len() == 64);
    }

    #[test]
    fn the_pattern_stands_still() {
        let mut dither = Dither::new(vec![[0, 0, 0], [255, 255, 255]]);
        let (mut a, mut b) = (Vec::new(), Vec::new());
        let grey = vec![90; 32 * 32 * 3];
        let mut half = grey.clone();
        half[..32 * 16 * 3].fill(200);
        dither.indices(&grey, 32, &mut a);
        dither.indices(&half, 32, &mut b);
        assert_eq!(a[32 * 16..], b[32 * 16..]);
        assert_ne!(a[..32 * 16], b[..32 * 16]);
    }
}
