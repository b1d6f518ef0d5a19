//! Balloons before a blue sky with clouds: a picture that shines on figures 7 and 8.

use super::{canvas::Canvas, random::fractal};
use glam::{DVec2, dvec2};

const WIDTH: usize = 512;
const HEIGHT: usize = 330;

/// Middle and radius in units of the height, from the upper left, and colour as stored, from the back to the front.
const BALLOONS: [(f64, f64, f64, [f64; 3]); 13] = [
    (0.37, 0.08, 0.19, [0.50, 0.05, 0.62]),
    (0.50, -0.03, 0.2, [0.33, 0.62, 0.10]),
    (-0.03, 0.5, 0.22, [0.80, 0.09, 0.06]),
    (0.80, 0.53, 0.23, [0.20, 0.52, 0.46]),
    (0.89, 0.51, 0.13, [0.97, 0.90, 0.12]),
    (0.51, 0.53, 0.22, [0.98, 0.50, 0.07]),
    (1.31, 0.07, 0.17, [0.22, 0.55, 0.47]),
    (1.28, 0.0, 0.12, [0.42, 0.66, 0.08]),
    (1.55, 0.57, 0.2, [0.84, 0.12, 0.05]),
    (1.36, 0.45, 0.23, [0.98, 0.93, 0.10]),
    (1.04, 0.45, 0.2, [0.45, 0.68, 0.09]),
    (0.94, 0.92, 0.18, [0.97, 0.92, 0.18]),
    (0.06, 1.02, 0.13, [0.35, 0.63, 0.12]),
];

/// The PNG file.
pub fn png() -> Vec<u8> {
    let mut canvas = Canvas::new(WIDTH, HEIGHT, [0.0; 3]);
    let scale = 1.0 / HEIGHT as f64;
    canvas.shade(|p, _| {
        let p = p * scale;
        BALLOONS.iter().fold(sky(p), |under, balloon| over(under, p, balloon))
    });
    canvas.png()
}

fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t.clamp(0.0, 1.0))
}

/// White above on the left, deep blue below on the right, ragged between.
fn sky(p: DVec2) -> [f64; 3] {
    let wisps = fractal([2.2 * p.x, 3.6 * p.y, 0.0], 5, 11);
    let cloud = 1.25 - 0.42 * p.x - 0.75 * p.y + 0.55 * wisps;
    let blue = mix([0.55, 0.74, 0.93], [0.16, 0.42, 0.80], 0.2 + 0.8 * p.y);
    mix(blue, [0.95, 0.95, 0.97], (cloud - 0.2) * 1.6)
}

/// A balloon of thin, clear rubber, lit from above on the left.
fn over(under: [f64; 3], p: DVec2, &(x, y, radius, colour): &(f64, f64, f64, [f64; 3])) -> [f64; 3] {
    let d = (p - dvec2(x, y)) / radius;
    // A little longer than wide, towards the knot below.
    let d = dvec2(d.x * (1.0 + 0.06 * d.y), d.y * 0.97);
    let off = d.length();
    let cover = ((1.0 - off) * radius * HEIGHT as f64 + 0.5).clamp(0.0, 1.0);
    if cover <= 0.0 {
        return under;
    }
    let height = (1.0 - off * off).max(0.0).sqrt();
    // Rubber looks thicker towards the rim.
    let dense = 0.98 - 0.1 * height;
    let light = (0.62 + 0.42 * (-0.45 * d.x - 0.6 * d.y + 0.65 * height)).clamp(0.3, 1.15);
    let mottled = 1.0 + 0.09 * fractal([5.0 * d.x + 10.0 * x, 5.0 * d.y, 3.0 * x], 3, 12);
    let body = mix(under, colour.map(|c| (c * light * mottled).min(1.0)), dense);
    let glint = |at: DVec2, size: f64| libm::exp(-(d - at).length_squared() / (size * size));
    let shine = 0.85 * glint(dvec2(-0.38, -0.48), 0.12)
        + 0.25 * glint(dvec2(-0.3, -0.4), 0.34)
        + 0.16 * glint(dvec2(0.45, 0.6), 0.25);
    mix(under, mix(body, [1.0; 3], shine), cover)
}
