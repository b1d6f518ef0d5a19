//! Pictures drawn in floating point and stored as PNG.

use glam::DVec2;

/// A picture of values from 0 to 1 as a file stores them, rows from the top; coordinates are pixels, y down.
pub struct Canvas<const N: usize> {
    pub width: usize,
    pub height: usize,
    pub pixels: Vec<[f64; N]>,
}

impl<const N: usize> Canvas<N> {
    pub fn new(width: usize, height: usize, value: [f64; N]) -> Self {
        Self { width, height, pixels: vec![value; width * height] }
    }

    /// Replaces every pixel by what `shade` makes of its middle and its value.
    pub fn shade(&mut self, mut shade: impl FnMut(DVec2, [f64; N]) -> [f64; N]) {
        self.shade_within([0.0, 0.0, self.width as f64, self.height as f64], &mut shade);
    }

    /// The same for pixels that may touch a rectangle `[x0, y0, x1, y1]`.
    fn shade_within(&mut self, [x0, y0, x1, y1]: [f64; 4], shade: &mut impl FnMut(DVec2, [f64; N]) -> [f64; N]) {
        let cut = |v: f64, most: usize| (v.max(0.0) as usize).min(most);
        for y in cut(y0 - 1.0, self.height)..cut(y1 + 2.0, self.height) {
            for x in cut(x0 - 1.0, self.width)..cut(x1 + 2.0, self.width) {
                let pixel = &mut self.pixels[y * self.width + x];
                *pixel = shade(DVec2::new(x as f64 + 0.5, y as f64 + 0.5), *pixel);
            }
        }
    }

    /// Lays a line that has a radius at each of its points over the picture: `lay` gets a pixel's value and how much of the line
    /// is there, which falls from 1 to 0 over a rim of width `soft`. Each pixel is touched once for each segment, so `lay` should
    /// not darken where segments meet.
    pub fn line(&mut self, points: &[(DVec2, f64)], soft: f64, lay: impl Fn([f64; N], f64) -> [f64; N]) {
        for pair in points.windows(2) {
            let [(a, ra), (b, rb)] = [pair[0], pair[1]];
            let reach = ra.max(rb) + soft;
            let (low, high) = (a.min(b) - reach, a.max(b) + reach);
            let along = b - a;
            let length2 = along.length_squared().max(1e-12);
            self.shade_within([low.x, low.y, high.x, high.y], &mut |p, value| {
                let t = ((p - a).dot(along) / length2).clamp(0.0, 1.0);
                let inside = (ra + (rb - ra) * t - p.distance(a + along * t)) / soft;
                let cover = (inside + 0.5).clamp(0.0, 1.0);
                if cover > 0.0 { lay(value, cover) } else { value }
            });
        }
    }

    /// Fills a closed outline: `lay` gets a pixel's middle, its value and how much of the filling is there, which falls from 1 to 0
    /// over a rim of width `soft`.
    pub fn fill(&mut self, outline: &[DVec2], soft: f64, lay: impl Fn(DVec2, [f64; N], f64) -> [f64; N]) {
        let low = outline.iter().copied().fold(DVec2::INFINITY, DVec2::min) - soft;
        let high = outline.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max) + soft;
        self.shade_within([low.x, low.y, high.x, high.y], &mut |p, value| {
            let mut nearest = f64::INFINITY;
            let mut inside = false;
            for (i, &a) in outline.iter().enumerate() {
                let b = outline[(i + 1) % outline.len()];
                let along = b - a;
                let t = ((p - a).dot(along) / along.length_squared().max(1e-12)).clamp(0.0, 1.0);
                nearest = nearest.min(p.distance_squared(a + along * t));
                inside ^= (a.y > p.y) != (b.y > p.y) && p.x < a.x + (p.y - a.y) / (b.y - a.y) * along.x;
            }
            let distance = if inside { nearest.sqrt() } else { -nearest.sqrt() };
            let t = (distance / soft + 0.5).clamp(0.0, 1.0);
            let cover = t * t * (3.0 - 2.0 * t);
            if cover > 0.0 { lay(p, value, cover) } else { value }
        });
    }
}

impl Canvas<1> {
    /// PNG of 16 greys of a palette: 0 is `dark`, 1 is `light` (bytes as stored).
    pub fn png_of_two_inks(&self, dark: [u8; 3], light: [u8; 3]) -> Vec<u8> {
        const LEVELS: u8 = 15;
        let palette = (0..=LEVELS).flat_map(|i| {
            [0, 1, 2].map(|c| {
                let t = f64::from(i) / f64::from(LEVELS);
                (f64::from(dark[c]) + (f64::from(light[c]) - f64::from(dark[c])) * t + 0.5) as u8
            })
        });
        let level = |v: [f64; 1]| (v[0].clamp(0.0, 1.0) * f64::from(LEVELS) + 0.5) as u8;
        let rows = self.pixels.chunks(self.width);
        let pairs = |row: &[[f64; 1]]| -> Vec<u8> {
            row.chunks(2).map(|pair| (level(pair[0]) << 4) | pair.get(1).map_or(0, |v| level(*v))).collect()
        };
        let bytes: Vec<u8> = rows.flat_map(pairs).collect();
        let palette: Vec<u8> = palette.collect();
        self.encode(&bytes, |encoder| {
            encoder.set_color(png::ColorType::Indexed);
            encoder.set_depth(png::BitDepth::Four);
            encoder.set_palette(palette);
            encoder.set_filter(png::Filter::NoFilter);
        })
    }

    /// PNG of 8-bit greys.
    pub fn png(&self) -> Vec<u8> {
        self.encode(&self.bytes(), |encoder| encoder.set_color(png::ColorType::Grayscale))
    }
}

impl Canvas<3> {
    /// PNG of 8-bit colours.
    pub fn png(&self) -> Vec<u8> {
        self.encode(&self.bytes(), |encoder| encoder.set_color(png::ColorType::Rgb))
    }
}

impl<const N: usize> Canvas<N> {
    fn bytes(&self) -> Vec<u8> {
        self.pixels.iter().flatten().map(|v| (v.clamp(0.0, 1.0) * 255.0 + 0.5) as u8).collect()
    }

    fn encode(&self, bytes: &[u8], set: impl FnOnce(&mut png::Encoder<'_, &mut Vec<u8>>)) -> Vec<u8> {
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, self.width as u32, self.height as u32);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_compression(png::Compression::High);
        set(&mut encoder);
        let mut writer = encoder.write_header().expect("the header of a picture of the project's own");
        writer.write_image_data(bytes).expect("memory takes all of a picture");
        writer.finish().expect("memory takes the end of a picture");
        file
    }
}
