//! A portrait in the manner of the seventeenth century, for the jigsaw puzzle: a dark ground, a blue and yellow turban, a pearl. The
//! face is a field of heights that is lit; the rest is painted in soft shapes.

use super::{canvas::Canvas, curve::closed, random::fractal};
use glam::{DVec2, DVec3, dvec2};

const WIDTH: usize = 504;
const HEIGHT: usize = 616;

type Colour = [f64; 3];

/// The PNG file.
pub fn png() -> Vec<u8> {
    let mut picture = Picture(Canvas::new(WIDTH, HEIGHT, [0.0; 3]));
    picture.ground();
    picture.scarf();
    picture.jacket();
    picture.neck();
    picture.head();
    picture.turban();
    picture.pearl();
    picture.weave();
    picture.0.png()
}

fn mix(a: Colour, b: Colour, t: f64) -> Colour {
    let t = t.clamp(0.0, 1.0);
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t)
}

/// A colour between those of three tones, as light goes from 0 to 1.
fn tones([dark, middle, light]: [Colour; 3], t: f64) -> Colour {
    if t < 0.5 { mix(dark, middle, 2.0 * t) } else { mix(middle, light, 2.0 * t - 1.0) }
}

fn bell(p: DVec2, at: DVec2, size: DVec2) -> f64 {
    libm::exp(-((p - at) / size).length_squared())
}

fn smooth(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// Coordinates: the width is 1, y goes down.
struct Picture(Canvas<3>);

const SCALE: f64 = WIDTH as f64;

impl Picture {
    /// Fills a smooth outline with a colour at each point.
    fn paint(&mut self, outline: &[(f64, f64)], soft: f64, colour: impl Fn(DVec2) -> Colour) {
        let points: Vec<DVec2> = outline.iter().map(|&(x, y)| dvec2(x, y) * SCALE).collect();
        self.0.fill(&closed(&points), soft * SCALE, |p, under, cover| mix(under, colour(p / SCALE), cover));
    }

    fn ground(&mut self) {
        self.0.shade(|p, _| {
            let p = p / SCALE;
            let cloud = 0.5 + 0.5 * fractal([3.0 * p.x, 3.0 * p.y, 0.0], 4, 21);
            let glow = bell(p, dvec2(0.85, 0.45), dvec2(0.5, 0.6));
            mix([0.045, 0.05, 0.05], [0.13, 0.125, 0.10], 0.45 * cloud + 0.55 * glow)
        });
    }

    /// The yellow end of the turban, falling behind the shoulder.
    fn scarf(&mut self) {
        let outline = [
            (0.36, 0.2),
            (0.43, 0.27),
            (0.4, 0.42),
            (0.385, 0.58),
            (0.4, 0.74),
            (0.385, 0.9),
            (0.33, 1.0),
            (0.27, 1.02),
            (0.24, 0.93),
            (0.255, 0.78),
            (0.265, 0.6),
            (0.255, 0.42),
            (0.275, 0.27),
        ];
        self.paint(&outline, 0.012, |p| {
            let fold = libm::sin(62.0 * (p.x + 0.05 * libm::sin(7.0 * p.y)) + 3.0 * p.y)
                + 0.5 * libm::sin(25.0 * p.x - 9.0 * p.y);
            let light = 0.46 + 0.17 * fold + 0.9 * (p.x - 0.33) - 0.22 * smooth(0.7, 1.05, p.y);
            tones([[0.16, 0.10, 0.03], [0.60, 0.45, 0.14], [0.90, 0.79, 0.42]], light)
        });
        // A fringe of blue at its end.
        let fringe = [(0.24, 0.9), (0.3, 0.93), (0.39, 0.9), (0.37, 0.98), (0.33, 1.03), (0.27, 1.04), (0.235, 0.97)];
        self.paint(&fringe, 0.015, |p| {
            let strand = 0.5 + 0.5 * libm::sin(150.0 * p.x + 8.0 * p.y);
            tones([[0.05, 0.07, 0.14], [0.15, 0.24, 0.42], [0.45, 0.55, 0.68]], 0.2 + 0.5 * strand * (1.4 - p.y))
        });
    }

    fn jacket(&mut self) {
        let outline = [
            (0.0, 1.3),
            (0.05, 1.1),
            (0.14, 0.985),
            (0.27, 0.91),
            (0.4, 0.85),
            (0.52, 0.87),
            (0.63, 0.87),
            (0.72, 0.92),
            (0.81, 1.03),
            (0.87, 1.16),
            (0.9, 1.3),
        ];
        self.paint(&outline, 0.012, |p| {
            let sleeve = libm::sin(21.0 * (p.x - 0.6) + 11.0 * (p.y - 0.9) + 1.6 * libm::sin(9.0 * p.y));
            let wide = fractal([4.0 * p.x, 4.0 * p.y, 0.0], 3, 22);
            let light = 0.34 + 0.62 * smooth(0.15, 0.78, p.x) - 0.95 * (p.y - 0.9) + 0.13 * sleeve + 0.14 * wide;
            tones([[0.07, 0.05, 0.03], [0.38, 0.27, 0.13], [0.68, 0.54, 0.30]], light)
        });
        let collar = [
            (0.395, 0.835),
            (0.44, 0.8),
            (0.52, 0.845),
            (0.6, 0.845),
            (0.645, 0.815),
            (0.67, 0.86),
            (0.61, 0.905),
            (0.5, 0.905),
            (0.42, 0.875),
        ];
        self.paint(&collar, 0.01, |p| {
            let pleat = libm::sin(70.0 * p.x - 30.0 * p.y);
            tones([[0.28, 0.27, 0.26], [0.66, 0.64, 0.60], [0.95, 0.93, 0.88]], 0.25 + 1.9 * (p.x - 0.4) + 0.1 * pleat)
        });
    }

    fn neck(&mut self) {
        let outline = [
            (0.42, 0.6),
            (0.53, 0.64),
            (0.6, 0.66),
            (0.6, 0.75),
            (0.625, 0.83),
            (0.56, 0.865),
            (0.47, 0.85),
            (0.425, 0.79),
            (0.435, 0.7),
        ];
        self.paint(&outline, 0.012, |p| {
            let light = 0.12 + 2.6 * (p.x - 0.43) - 0.45 * bell(p, dvec2(0.58, 0.68), dvec2(0.09, 0.055));
            tones(SKIN, light.min(0.66))
        });
    }

    fn head(&mut self) {
        let outline = [
            (0.405, 0.4),
            (0.42, 0.3),
            (0.5, 0.245),
            (0.6, 0.24),
            (0.675, 0.28),
            (0.708, 0.35),
            (0.712, 0.42),
            (0.708, 0.475),
            (0.716, 0.53),
            (0.704, 0.585),
            (0.685, 0.64),
            (0.655, 0.695),
            (0.612, 0.722),
            (0.565, 0.708),
            (0.505, 0.66),
            (0.455, 0.6),
            (0.418, 0.51),
        ];
        self.paint(&outline, 0.008, |p| {
            let e = 0.002;
            let slope = |axis: DVec2| (relief(p + axis * e) - relief(p - axis * e)) / (2.0 * e);
            let normal = DVec3::new(-slope(DVec2::X), -slope(DVec2::Y), 1.0).normalize();
            let light = normal.dot(DVec3::new(0.52, -0.40, 0.76).normalize());
            let shadow = smooth(0.38, 0.56, p.x);
            let mut skin = tones(SKIN, (0.08 + 0.9 * light.max(0.0)) * (0.32 + 0.68 * shadow));
            // Warmth on cheek and nose.
            let warm = 0.35 * bell(p, dvec2(0.545, 0.55), dvec2(0.06, 0.05))
                + 0.25 * bell(p, dvec2(0.655, 0.54), dvec2(0.025, 0.025));
            skin = mix(skin, [0.85, 0.47, 0.36], 0.5 * warm);
            skin
        });
        self.eye(dvec2(0.555, 0.452), 1.0);
        self.eye(dvec2(0.664, 0.456), 0.8);
        // Lips, parted a little.
        let upper = [
            (0.568, 0.632),
            (0.6, 0.622),
            (0.622, 0.617),
            (0.636, 0.621),
            (0.65, 0.618),
            (0.674, 0.63),
            (0.648, 0.637),
            (0.62, 0.638),
        ];
        let lower = [
            (0.572, 0.636),
            (0.62, 0.642),
            (0.65, 0.641),
            (0.672, 0.634),
            (0.656, 0.655),
            (0.632, 0.664),
            (0.6, 0.657),
        ];
        self.paint(&upper, 0.007, |p| {
            tones([[0.28, 0.06, 0.05], [0.62, 0.19, 0.16], [0.78, 0.34, 0.28]], 0.35 + 3.2 * (p.x - 0.6))
        });
        self.paint(&lower, 0.008, |p| {
            let shine = bell(p, dvec2(0.632, 0.65), dvec2(0.018, 0.005));
            mix(
                tones([[0.32, 0.08, 0.07], [0.72, 0.27, 0.22], [0.86, 0.44, 0.37]], 0.45 + 3.0 * (p.x - 0.61)),
                [1.0, 0.86, 0.8],
                0.7 * shine,
            )
        });
        let gap = [(0.572, 0.634), (0.615, 0.637), (0.645, 0.637), (0.672, 0.632), (0.645, 0.6415), (0.615, 0.6425)];
        self.paint(&gap, 0.004, |_| [0.20, 0.05, 0.05]);
        // Nostrils and the shadow below the nose.
        self.paint(&[(0.632, 0.571), (0.644, 0.566), (0.652, 0.572), (0.642, 0.577)], 0.006, |_| [0.30, 0.14, 0.10]);
        self.paint(&[(0.672, 0.572), (0.679, 0.568), (0.684, 0.572), (0.677, 0.576)], 0.005, |_| [0.36, 0.18, 0.13]);
    }

    /// An eye that looks at the viewer; `wide` is 1 for the nearer one.
    fn eye(&mut self, at: DVec2, wide: f64) {
        let shape = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            points.iter().map(|(x, y)| (at.x + wide * x, at.y + y)).collect()
        };
        let almond = shape(&[
            (-0.037, 0.004),
            (-0.02, -0.009),
            (0.002, -0.0135),
            (0.022, -0.008),
            (0.034, 0.003),
            (0.016, 0.0105),
            (-0.01, 0.012),
        ]);
        self.paint(&almond, 0.005, |p| {
            tones(
                [[0.36, 0.28, 0.24], [0.80, 0.75, 0.70], [0.95, 0.93, 0.90]],
                0.55 + 9.0 * (p.x - at.x) + 14.0 * (p.y - at.y),
            )
        });
        let iris = at + dvec2(0.002 * wide, -0.001);
        let ring: Vec<(f64, f64)> = (0..10)
            .map(|k| {
                let (sin, cos) = libm::sincos(f64::from(k) * std::f64::consts::TAU / 10.0);
                (iris.x + 0.0125 * wide.sqrt() * cos, iris.y + (0.0122 * sin).max(-0.0105))
            })
            .collect();
        self.paint(&ring, 0.004, |p| {
            let off = (p - iris).length() / 0.0125;
            if off < 0.5 { [0.03, 0.03, 0.03] } else { mix([0.10, 0.10, 0.09], [0.36, 0.35, 0.28], (off - 0.5) * 1.4) }
        });
        let spark = iris + dvec2(0.005, -0.005);
        self.paint(
            &[
                (spark.x - 0.003, spark.y),
                (spark.x, spark.y - 0.003),
                (spark.x + 0.003, spark.y),
                (spark.x, spark.y + 0.003),
            ],
            0.003,
            |_| [0.97; 3],
        );
        // Lids and brow.
        let lid = shape(&[
            (-0.04, 0.005),
            (-0.022, -0.0125),
            (0.002, -0.0185),
            (0.024, -0.0125),
            (0.037, 0.002),
            (0.022, -0.0085),
            (0.001, -0.0135),
            (-0.02, -0.0085),
        ]);
        self.paint(&lid, 0.004, |_| [0.26, 0.13, 0.09]);
        let crease = shape(&[
            (-0.036, -0.012),
            (-0.01, -0.026),
            (0.02, -0.022),
            (0.034, -0.01),
            (0.018, -0.0195),
            (-0.01, -0.0225),
        ]);
        self.paint(&crease, 0.006, |_| [0.55, 0.33, 0.24]);
    }

    fn turban(&mut self) {
        let blue = [[0.04, 0.06, 0.13], [0.16, 0.27, 0.50], [0.58, 0.70, 0.86]];
        let band = [
            (0.36, 0.5),
            (0.335, 0.4),
            (0.355, 0.28),
            (0.43, 0.19),
            (0.53, 0.155),
            (0.63, 0.17),
            (0.7, 0.235),
            (0.722, 0.31),
            (0.725, 0.385),
            (0.69, 0.35),
            (0.63, 0.325),
            (0.56, 0.325),
            (0.5, 0.36),
            (0.465, 0.42),
            (0.45, 0.5),
            (0.43, 0.58),
            (0.395, 0.57),
        ];
        self.paint(&band, 0.01, |p| {
            // Folds run round the head.
            let q = p - dvec2(0.54, 0.46);
            let round = libm::atan2(q.y, q.x);
            let fold = libm::sin(95.0 * (q.length() + 0.03 * libm::sin(2.0 * round + 0.6)))
                + 0.6 * libm::sin(43.0 * q.length() + 4.0 * round);
            let light = 0.36
                + 0.13 * fold
                + 0.75 * (p.x - 0.5)
                + 0.5 * (0.3 - p.y)
                + 0.3 * bell(p, dvec2(0.62, 0.24), dvec2(0.12, 0.06));
            tones(blue, light)
        });
        // The yellow cloth on top, bound by the band.
        let knot = [
            (0.3, 0.3),
            (0.29, 0.2),
            (0.35, 0.1),
            (0.45, 0.065),
            (0.55, 0.085),
            (0.615, 0.14),
            (0.56, 0.165),
            (0.47, 0.175),
            (0.4, 0.22),
            (0.36, 0.29),
        ];
        self.paint(&knot, 0.01, |p| {
            let q = p - dvec2(0.43, 0.3);
            let fold =
                libm::sin(70.0 * q.x + 30.0 * q.y + 3.0 * libm::sin(14.0 * p.y)) + 0.5 * libm::sin(120.0 * q.length());
            let light = 0.46 + 0.14 * fold + 1.0 * (p.x - 0.42) + 1.2 * (0.16 - p.y);
            tones([[0.20, 0.13, 0.04], [0.66, 0.51, 0.18], [0.95, 0.87, 0.55]], light)
        });
    }

    fn pearl(&mut self) {
        let (at, radius) = (dvec2(0.452, 0.667), 0.03);
        // The ear's lobe, and the hook.
        self.paint(&[(0.425, 0.585), (0.448, 0.578), (0.463, 0.6), (0.455, 0.628), (0.438, 0.625)], 0.012, |p| {
            tones(SKIN, 0.32 + 3.0 * (p.x - 0.44))
        });
        let drop: Vec<(f64, f64)> = (0..16)
            .map(|k| {
                let (sin, cos) = libm::sincos(f64::from(k) * std::f64::consts::TAU / 16.0);
                // Drawn out upward.
                let pull = if sin < 0.0 { 1.0 + 0.28 * sin * sin } else { 1.0 };
                (at.x + radius * cos * (1.0 - 0.12 * (-sin).max(0.0)), at.y + radius * sin * pull)
            })
            .collect();
        self.paint(&drop, 0.005, |p| {
            let d = (p - at) / radius;
            let height = (1.0 - d.length_squared()).max(0.0).sqrt();
            let light = 0.25 + 0.35 * (0.5 * d.x - 0.5 * d.y + 0.5 * height);
            let base = tones([[0.10, 0.10, 0.11], [0.48, 0.48, 0.47], [0.86, 0.85, 0.82]], light);
            let spark = bell(d, dvec2(0.32, -0.45), dvec2(0.2, 0.24));
            // The collar mirrors in it from below.
            let below = 0.75 * smooth(0.25, 0.8, d.y) * (1.0 - 0.6 * d.x.abs());
            mix(mix(base, [0.80, 0.78, 0.72], below), [1.0, 1.0, 0.98], spark)
        });
    }

    /// Strokes of the brush and the cloth below.
    fn weave(&mut self) {
        self.0.shade(|p, colour| {
            let stroke = fractal([0.045 * (p.x + p.y), 0.16 * (p.x - p.y), 0.0], 3, 23);
            let cloth = 0.5 * (libm::sin(1.9 * p.x) + libm::sin(1.9 * p.y));
            colour.map(|c| (c * (1.0 + 0.055 * stroke + 0.012 * cloth)).clamp(0.0, 1.0))
        });
    }
}

const SKIN: [Colour; 3] = [[0.16, 0.085, 0.05], [0.72, 0.50, 0.37], [0.985, 0.875, 0.76]];

/// Heights of the face.
fn relief(p: DVec2) -> f64 {
    let q = p - dvec2(0.562, 0.475);
    let oval = 1.0 - (q / dvec2(0.19, 0.275)).length_squared();
    let at = |x: f64, y: f64, sx: f64, sy: f64| bell(p, dvec2(x, y), dvec2(sx, sy));
    let ridge: f64 = (0..8)
        .map(|k| {
            let t = f64::from(k) / 7.0;
            (0.011 + 0.012 * t) * at(0.628 + 0.034 * t, 0.44 + 0.1 * t, 0.017 + 0.004 * t, 0.02)
        })
        .sum();
    let eyes = -0.03 * at(0.557, 0.448, 0.045, 0.026) - 0.026 * at(0.667, 0.452, 0.036, 0.026);
    let balls = 0.012 * at(0.556, 0.452, 0.026, 0.016) + 0.011 * at(0.666, 0.456, 0.022, 0.016);
    let nose = 0.03 * at(0.662, 0.553, 0.02, 0.019)
        + 0.014 * at(0.633, 0.563, 0.014, 0.013)
        + 0.01 * at(0.682, 0.565, 0.01, 0.012);
    let mouth = 0.016 * at(0.628, 0.628, 0.04, 0.012) + 0.018 * at(0.628, 0.652, 0.032, 0.012)
        - 0.014 * at(0.628, 0.674, 0.035, 0.01);
    let rest =
        0.02 * at(0.54, 0.55, 0.06, 0.055) + 0.024 * at(0.618, 0.7, 0.035, 0.028) + 0.012 * at(0.6, 0.42, 0.09, 0.012);
    0.16 * oval.max(0.0).sqrt() + ridge + eyes + balls + nose + mouth + rest
}
