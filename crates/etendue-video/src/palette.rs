//! 256 colours for a picture: boxes of colours are cut where they are widest (after Heckbert's median cut, 1982, by
//! variance as in Wu's, 1991), then moved to the means of what is nearest to them (Lloyd, 1982).

/// Colours of a palette, in sRGB.
pub(crate) type Palette = Vec<[u8; 3]>;

/// How much a difference in red, green and blue counts.
const WEIGHT: [i32; 3] = [3, 6, 2];
const MOST: usize = 256;
/// How often colours are moved to their means.
const ROUNDS: usize = 2;

/// Colours that share the upper 5 bits of each channel.
#[derive(Debug, Clone, Copy)]
struct Cell {
    mean: [f64; 3],
    pixels: f64,
}

/// How often colours occur in a picture.
pub(crate) struct Histogram {
    cells: Vec<Cell>,
    pixels: f64,
}

impl Histogram {
    pub fn new(rgb: &[u8]) -> Self {
        let mut sums = vec![[0u64; 4]; 1 << 15];
        for &[r, g, b] in rgb.as_chunks::<3>().0 {
            let cell = (usize::from(r >> 3) << 10) | (usize::from(g >> 3) << 5) | usize::from(b >> 3);
            let sum = &mut sums[cell];
            *sum = [sum[0] + u64::from(r), sum[1] + u64::from(g), sum[2] + u64::from(b), sum[3] + 1];
        }
        let cells = sums.iter().filter(|sum| sum[3] > 0).map(|sum| {
            let pixels = sum[3] as f64;
            Cell { mean: [0, 1, 2].map(|c| sum[c] as f64 / pixels), pixels }
        });
        Self { cells: cells.collect(), pixels: (rgb.len() / 3) as f64 }
    }

    /// At most 256 colours for this picture.
    pub fn palette(&self) -> Palette {
        let mut cells = self.cells.clone();
        let mut boxes = vec![Part::new(&cells, 0, cells.len())];
        while boxes.len() < MOST {
            let worst = (0..boxes.len()).max_by(|&a, &b| boxes[a].spread.total_cmp(&boxes[b].spread).then(b.cmp(&a)));
            let Some(worst) = worst.filter(|&i| boxes[i].spread > 0.0) else { break };
            let Part { from, to, axis, middle, .. } = boxes[worst];
            let part = &mut cells[from..to];
            part.sort_by(|a, b| a.mean[axis].total_cmp(&b.mean[axis]));
            let cut = from + part.partition_point(|cell| cell.mean[axis] <= middle).clamp(1, to - from - 1);
            boxes[worst] = Part::new(&cells, from, cut);
            boxes.push(Part::new(&cells, cut, to));
        }
        let mut palette: Palette = boxes.iter().map(|part| rounded(part.mean)).collect();
        for _ in 0..ROUNDS {
            self.move_to_means(&mut palette);
        }
        palette.sort_unstable();
        palette.dedup();
        palette
    }

    fn move_to_means(&self, palette: &mut Palette) {
        let mut sums = vec![([0.0; 3], 0.0); palette.len()];
        for cell in &self.cells {
            let (sum, pixels) = &mut sums[nearest(palette, rounded(cell.mean).map(i32::from)).0];
            *sum = [0, 1, 2].map(|c| sum[c] + cell.mean[c] * cell.pixels);
            *pixels += cell.pixels;
        }
        for (color, (sum, pixels)) in palette.iter_mut().zip(sums) {
            if pixels > 0.0 {
                *color = rounded(sum.map(|s| s / pixels));
            }
        }
    }

    /// The mean over the pixels of the squared distance to the nearest colour.
    pub fn error(&self, palette: &Palette) -> f64 {
        let of = |cell: &Cell| f64::from(nearest(palette, rounded(cell.mean).map(i32::from)).1) * cell.pixels;
        self.cells.iter().map(of).sum::<f64>() / self.pixels.max(1.0)
    }
}

/// A box of cells `from..to`.
struct Part {
    from: usize,
    to: usize,
    mean: [f64; 3],
    /// The channel that spreads most, its mean, and its weighted sum of squared differences from it; 0 for one cell.
    axis: usize,
    middle: f64,
    spread: f64,
}

impl Part {
    fn new(cells: &[Cell], from: usize, to: usize) -> Self {
        let part = &cells[from..to];
        let pixels: f64 = part.iter().map(|cell| cell.pixels).sum();
        let mean = [0, 1, 2].map(|c| part.iter().map(|cell| cell.mean[c] * cell.pixels).sum::<f64>() / pixels.max(1.0));
        let spreads = [0, 1, 2].map(|c| {
            let square = |cell: &Cell| (cell.mean[c] - mean[c]) * (cell.mean[c] - mean[c]) * cell.pixels;
            f64::from(WEIGHT[c]) * part.iter().map(square).sum::<f64>()
        });
        let axis = (0..3).fold(0, |best, c| if spreads[c] > spreads[best] { c } else { best });
        let spread = if part.len() > 1 { spreads[axis] } else { 0.0 };
        Self { from, to, mean, axis, middle: mean[axis], spread }
    }
}

fn rounded(color: [f64; 3]) -> [u8; 3] {
    color.map(|c| (c + 0.5).clamp(0.0, 255.0) as u8)
}

/// The nearest colour (the first of equals) and its weighted squared distance.
pub(crate) fn nearest(palette: &[[u8; 3]], color: [i32; 3]) -> (usize, i32) {
    let mut best = (0, i32::MAX);
    for (index, candidate) in palette.iter().enumerate() {
        let d = [0, 1, 2].map(|c| color[c] - i32::from(candidate[c]));
        let distance = WEIGHT[0] * d[0] * d[0] + WEIGHT[1] * d[1] * d[1] + WEIGHT[2] * d[2] * d[2];
        if distance < best.1 {
            best = (index, distance);
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn few_colours_are_kept_exactly() {
        let colors = [[0u8, 0, 0], [255, 255, 255], [13, 130, 200], [200, 13, 7]];
        let rgb: Vec<u8> = (0..400).flat_map(|i| colors[i % 4]).collect();
        let histogram = Histogram::new(&rgb);
        let palette = histogram.palette();
        assert_eq!(palette.len(), 4);
        assert!(colors.iter().all(|color| palette.contains(color)));
        assert_eq!(histogram.error(&palette), 0.0);
        // A rare colour far from the others is not lost among many.
        let mut rgb: Vec<u8> = (0..100_000u32).flat_map(|i| [(i % 251) as u8, (i / 251 % 256) as u8, 40]).collect();
        rgb.extend([255, 0, 255].repeat(60));
        let palette = Histogram::new(&rgb).palette();
        assert_eq!(palette.len(), 256);
        assert!(nearest(&palette, [255, 0, 255]).1 < 300, "{:?}", nearest(&palette, [255, 0, 255]));
    }

    #[test]
    fn a_ramp_is_cut_evenly() {
        let rgb: Vec<u8> = (0..65_536u32).flat_map(|i| [(i % 256) as u8, (i / 256) as u8, 128]).collect();
        let histogram = Histogram::new(&rgb);
        let palette = histogram.palette();
        // 256 cells of 16 x 16: the weighted mean squared distance is 9 * (16 * 16 - 1) / 12, about 191.
        assert!(histogram.error(&palette) < 230.0, "{}", histogram.error(&palette));
    }
}
