//! Balloons before a blue sky with clouds: a picture that shines on figures 7 and 8.

use super::{canvas::Canvas, random::fractal};
use glam::{DVec2, dvec2};

const SIDE: usize = 400;

/// Middle from the upper left and radius, the side being 1, and colour as stored, from the back to the front. What the floor of
/// figure 7 smears to its left lies above on the left of (0.84, 0.34), and so on round that point.
const BALLOONS: [(f64, f64, f64, [f64; 3]); 15] = [
    (0.30, 0.08, 0.12, [0.50, 0.05, 0.62]),
    (0.08, 0.78, 0.13, [0.20, 0.52, 0.46]),
    (0.70, 0.95, 0.14, [0.20, 0.52, 0.46]),
    (0.47, 0.27, 0.12, [0.84, 0.16, 0.06]),
    (0.64, 0.14, 0.20, [0.98, 0.50, 0.07]),
    (0.84, 0.06, 0.13, [0.72, 0.76, 0.10]),
    (0.97, 0.10, 0.12, [0.97, 0.90, 0.12]),
    (0.98, 0.25, 0.09, [0.60, 0.72, 0.08]),
    (0.86, 0.80, 0.15, [0.33, 0.62, 0.10]),
    (0.99, 0.66, 0.11, [0.97, 0.90, 0.12]),
    (0.36, 0.92, 0.10, [0.97, 0.92, 0.18]),
    (0.03, 0.20, 0.10, [0.80, 0.09, 0.06]),
    (0.12, 0.28, 0.08, [0.97, 0.80, 0.10]),
    (0.51, 0.74, 0.08, [0.30, 0.58, 0.52]),
    (0.76, 0.40, 0.07, [0.97, 0.62, 0.10]),
];

/// The PNG file.
pub fn png() -> Vec<u8> {
    let mut canvas = Canvas::new(SIDE, SIDE, [0.0; 3]);
    let scale = 1.0 / SIDE as f64;
    canvas.shade(|p, _| {
        let p = p * scale;
        BALLOONS.iter().fold(sky(p), |under, balloon| over(under, p, balloon))
    });
    canvas.png()
}

fn mix(a: [f64; 3], b: [f64; 3], t: f64) -> [f64; 3] {
    [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t.clamp(0.0, 1.0))
}

/// Ragged white clouds on the left and right, blue below.
fn sky(p: DVec2) -> [f64; 3] {
    let wisps = fractal([3.6 * p.x, 5.2 * p.y, 0.0], 5, 11);
    let bank = |x: f64, y: f64, size: f64| libm::exp(-(p - dvec2(x, y)).length_squared() / (size * size));
    let cloud = 1.15 * bank(0.2, 0.5, 0.34)
        + 0.9 * bank(1.0, 0.42, 0.2)
        + 0.8 * bank(0.5, 0.55, 0.2)
        + 0.5 * bank(0.75, 0.62, 0.2)
        + 0.5 * wisps;
    let blue = mix([0.55, 0.74, 0.93], [0.16, 0.42, 0.80], 0.2 + 0.8 * p.y);
    mix(blue, [0.95, 0.95, 0.97], (cloud - 0.2) * 1.6)
}

/// A balloon of thin, clear rubber, lit from above on the left.
fn over(under: [f64; 3], p: DVec2, &(x, y, radius, colour): &(f64, f64, f64, [f64; 3])) -> [f64; 3] {
    let d = (p - dvec2(x, y)) / radius;
    // A little longer than wide, towards the knot below.
    let d = dvec2(d.x * (1.0 + 0.06 * d.y), d.y * 0.97);
    let off = d.length();
    let cover = ((1.0 - off) * radius * SIDE as f64 + 0.5).clamp(0.0, 1.0);
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
