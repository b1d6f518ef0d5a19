//! Handwriting: letters as curves of a pen, never twice quite the same.

use super::{canvas::Canvas, curve::through, random::Random};
use glam::DVec2;

/// Units of a small letter's height.
const X_HEIGHT: f64 = 10.0;

/// A letter: its character, how far the pen moves on, and its strokes, each a list of points that a smooth curve goes through.
/// The baseline is at 0, small letters reach up to 10, tall ones to 22, tails to -10.
const LETTERS: &[(char, f64, &str)] = &[
    ('a', 12.0, "9,8 6,10 2,8 1,4 3,0 6,1 9,8 9,3 10,0 13,2"),
    ('b', 11.0, "0,5 5,15 4,22 2,17 2,3 5,0 9,3 8,9 4,8"),
    ('c', 10.0, "9,8 6,10 2,7 1,3 4,0 8,1 11,3"),
    ('d', 12.0, "9,8 5,10 1,6 1,2 4,0 7,2 10,12 11,22 9,8 9,2 12,1"),
    ('e', 10.0, "0,3 6,5 8,8 5,10 2,7 1,3 4,0 8,1 11,4"),
    ('f', 10.0, "12,19 9,22 6,18 5,6 3,-6 0,-9 -2,-6;0,10 10,11"),
    ('g', 12.0, "9,8 5,10 1,6 2,2 5,1 9,9 8,-3 4,-10 0,-8 4,-3 13,4"),
    ('h', 12.0, "0,5 5,16 4,22 2,18 2,0 4,7 8,10 9,6 9,1 12,1"),
    ('i', 6.0, "0,6 2,10 2,3 3,0 6,2;3,15 3.6,15.8"),
    ('j', 7.0, "2,10 3,8 2,-5 -1,-9 -3,-6;4,15 4.6,15.8"),
    ('k', 11.0, "1,5 5,18 3,22 2,14 2,0;9,10 3,5 6,5 11,0"),
    ('l', 7.0, "0,4 5,14 5,21 3,22 2,16 2,4 4,0 8,4"),
    ('m', 17.0, "0,8 2,10 2,0 3,6 6,10 8,7 8,0 9,6 12,10 14,7 14,1 17,1"),
    ('n', 12.0, "0,8 2,10 2,0 3,6 7,10 9,7 9,1 12,1"),
    ('o', 11.0, "6,10 2,8 1,4 4,0 8,2 9,7 6,10 7,8 12,9"),
    ('p', 11.0, "0,7 3,10 2,-10;2,5 5,10 9,8 9,3 5,0 2,2"),
    ('q', 11.0, "9,8 5,10 1,6 2,1 6,1 9,9 8,-8 9,-10 13,-5"),
    ('r', 10.0, "0,7 2,10 2,0 3,6 6,10 9,9"),
    ('s', 9.0, "9,9 5,10 3,7 7,4 7,1 3,0 0,2"),
    ('t', 9.0, "4,18 3,4 5,0 9,2;0,11 8,12"),
    ('u', 12.0, "0,8 2,10 2,3 5,0 8,4 9,10 9,2 12,1"),
    ('v', 10.0, "0,9 2,9 4,0 6,3 9,10 10,9"),
    ('w', 14.0, "0,9 2,9 3,1 7,7 8,1 12,5 13,10"),
    ('x', 11.0, "0,8 3,10 6,2 10,0;10,10 5,5 0,0"),
    ('y', 11.0, "0,9 2,10 2,4 5,2 8,9 9,10 7,-5 3,-10 0,-7"),
    ('z', 10.0, "0,9 4,10 9,9 9,9 0,0 0,0 5,1 10,0"),
    ('D', 15.0, "4,21 3,0 3,0;0,20 8,21 13,15 12,5 6,0 1,1"),
    ('E', 13.0, "12,19 6,21 3,17 6,12 9,12 4,11 1,6 3,1 8,0 13,3"),
    ('F', 12.0, "4,20 3,0;1,20 8,21 14,20;4,11 11,11"),
    ('L', 13.0, "10,20 7,22 5,18 4,6 2,1 0,2 3,3 8,0 14,2"),
    ('M', 18.0, "0,0 3,20 3,20 8,6 8,6 14,21 14,21 16,0"),
    ('N', 15.0, "1,0 3,20 3,20 11,1 11,1 13,22"),
    ('P', 12.0, "4,20 3,0;0,18 6,22 12,18 9,12 4,10"),
    ('V', 14.0, "0,20 2,20 6,0 6,0 13,22"),
    ('∫', 9.0, "11,24 8,27 6,22 4,4 2,-8 -1,-10 -2,-7"),
    ('Σ', 17.0, "14,18 14,21 14,21 1,21 1,21 8,10 8,10 0,-1 0,-1 15,-1 15,-1 16,3"),
    ('Ω', 16.0, "0,0 5,0 5,0 1,9 3,18 8,21 13,18 14,9 10,0 10,0 15,0"),
    ('ω', 15.0, "3,10 0,5 2,0 6,2 7,7 7,2 11,0 14,5 12,10"),
    ('θ', 10.0, "5,21 1,14 1,4 4,0 8,6 8,16 5,21;1,11 8,11"),
    ('π', 13.0, "0,7 3,10 13,10;4,10 3,0;9,10 9,2 12,0"),
    ('σ', 12.0, "13,10 6,10 1,6 2,1 6,0 9,4 7,9"),
    ('λ', 11.0, "0,19 3,20 6,11 10,0;6,11 0,0"),
    ('φ', 12.0, "4,9 1,6 2,1 7,0 11,5 9,10 6,8 5,-9"),
    ('∂', 11.0, "2,17 6,21 9,15 8,4 4,0 1,4 4,9 9,8"),
    ('0', 10.0, "5,19 1,12 2,2 6,0 9,8 8,17 4,19"),
    ('1', 7.0, "1,15 5,20 4,0"),
    ('2', 11.0, "1,15 5,20 9,16 5,7 0,0 0,0 5,1 11,0"),
    ('4', 11.0, "5,20 0,7 0,7 10,8;7,13 6,0"),
    ('=', 14.0, "1,7 11,8;1,3 11,4"),
    ('+', 14.0, "1,5 11,6;6,11 6,0"),
    ('-', 13.0, "1,5 10,6"),
    ('≈', 14.0, "0,7 3,9 7,6 11,9;0,2 3,4 7,1 11,4"),
    ('/', 9.0, "9,23 0,-5"),
    ('|', 6.0, "3,23 2,-6"),
    ('(', 8.0, "7,25 3,16 3,4 7,-6"),
    (')', 8.0, "1,25 5,17 5,4 0,-6"),
    ('[', 8.0, "7,25 2,25 2,25 2,-6 2,-6 7,-5"),
    (']', 8.0, "1,25 6,25 6,25 5,-6 5,-6 0,-6"),
    ('.', 5.0, "1,0.4 1.8,0"),
    (',', 5.0, "2,1 2,-1 0,-4"),
    ('!', 6.0, "3,22 2,6;2,0.5 2.5,0"),
    ('?', 10.0, "0,17 4,22 8,18 5,11 4,6;4,0.5 4.5,0"),
    (' ', 8.0, ""),
];

/// A sheet that is written on: metres, y up; the canvas has 1 where the paper is bare.
pub struct Sheet {
    pub canvas: Canvas<1>,
    /// World coordinates of the canvas's lower left corner.
    corner: DVec2,
    /// Pixels in a metre.
    scale: f64,
    random: Random,
}

/// Where and how a line is written.
#[derive(Clone, Copy)]
pub struct Pen {
    /// Start of the baseline, metres.
    pub at: DVec2,
    /// Direction of the baseline, degrees.
    pub angle: f64,
    /// Height of a small letter, metres.
    pub size: f64,
}

impl Pen {
    fn on(self, along: f64, up: f64) -> DVec2 {
        let (sin, cos) = libm::sincos(self.angle.to_radians());
        self.at + DVec2::new(along * cos - up * sin, along * sin + up * cos) * (self.size / X_HEIGHT)
    }
}

impl Sheet {
    /// A bare sheet from `low` to `high`, metres.
    pub fn new(low: DVec2, high: DVec2, scale: f64, seed: u64) -> Self {
        let size = (high - low) * scale;
        let canvas = Canvas::new(size.x as usize, size.y as usize, [1.0]);
        Self { canvas, corner: low, scale, random: Random::new(seed) }
    }

    /// Writes a line and returns the pen at its end. `_` and `^` set the next character, or the next `{group}`, lower or higher
    /// and smaller.
    pub fn write(&mut self, pen: Pen, text: &str) -> Pen {
        let mut pen = pen;
        let mut rest = text.chars();
        while let Some(c) = rest.next() {
            if c != '_' && c != '^' {
                pen = self.letter(pen, c);
                continue;
            }
            let (lift, size) = if c == '_' { (-4.0, 0.66) } else { (11.0, 0.62) };
            let group: String = match rest.next() {
                Some('{') => rest.by_ref().take_while(|&c| c != '}').collect(),
                first => first.into_iter().collect(),
            };
            let end = self.write(Pen { at: pen.on(0.0, lift), size: pen.size * size, ..pen }, &group);
            // Back down to the baseline.
            pen.at = Pen { at: end.at, ..pen }.on(0.0, -lift);
        }
        pen
    }

    /// Writes a fraction and returns the pen behind it.
    pub fn fraction(&mut self, pen: Pen, over: &str, under: &str) -> Pen {
        let small = Pen { size: pen.size * 0.85, ..pen };
        let high = self.write(Pen { at: pen.on(2.0, 11.0), ..small }, over);
        let low = self.write(Pen { at: pen.on(1.0, -16.0), ..small }, under);
        let width = high.at.distance(pen.on(0.0, 11.0)).max(low.at.distance(pen.on(0.0, -16.0))) * X_HEIGHT / pen.size;
        self.stroke(&[pen.on(0.0, 5.0), pen.on(0.6 * width, 5.8), pen.on(width, 5.4)]);
        Pen { at: pen.on(width + 4.0, 0.0), ..pen }
    }

    fn letter(&mut self, pen: Pen, c: char) -> Pen {
        let Some((_, advance, strokes)) = LETTERS.iter().find(|(letter, ..)| *letter == c) else {
            panic!("the hand has no letter {c:?}");
        };
        let size = 1.0 + 0.07 * self.random.signed();
        let slant = 0.2 + 0.07 * self.random.signed();
        let shift = DVec2::new(0.6 * self.random.signed(), 0.7 * self.random.signed());
        for stroke in strokes.split(';').filter(|s| !s.is_empty()) {
            let points: Vec<DVec2> = stroke
                .split(' ')
                .map(|pair| {
                    let (x, y) = pair.split_once(',').expect("points of letters are pairs");
                    let number = |s: &str| s.parse::<f64>().expect("points of letters are numbers");
                    let wobble = DVec2::new(self.random.signed(), self.random.signed()) * 0.35;
                    let p = DVec2::new(number(x), number(y)) * size + shift + wobble;
                    pen.on(p.x + slant * p.y, p.y)
                })
                .collect();
            self.stroke(&points);
        }
        Pen { at: pen.on(advance * size + 1.2 + 0.6 * self.random.signed(), 0.0), ..pen }
    }

    /// One movement of the pen through `points`, metres, with a pressure that comes and goes.
    pub fn stroke(&mut self, points: &[DVec2]) {
        const RADIUS: f64 = 0.0135;
        let phase = 6.3 * self.random.unit();
        let dark = 0.88 + 0.1 * self.random.unit();
        let curve = through(points);
        let mut length = 0.0;
        let total: f64 = curve.windows(2).map(|w| w[0].distance(w[1])).sum();
        let mut line = Vec::with_capacity(curve.len());
        for (i, &p) in curve.iter().enumerate() {
            if i > 0 {
                length += p.distance(curve[i - 1]);
            }
            let ends = (length.min(total - length) / 0.03).clamp(0.0, 1.0);
            let pressure = 0.85 + 0.22 * libm::sin(phase + 9.0 * length) + 0.08 * libm::sin(31.0 * length);
            let radius = RADIUS * pressure * (0.65 + 0.35 * ends);
            let q = (p - self.corner) * self.scale;
            line.push((DVec2::new(q.x, self.canvas.height as f64 - q.y), radius * self.scale));
        }
        self.canvas.line(&line, 1.0, |[bare], cover| [bare.min(1.0 - dark * cover)]);
    }
}
