//! Scratch paper with handwritten formulas, for the figures of the dragon.

use super::hand::{Pen, Sheet};
use glam::{DVec2, dvec2};

/// The paper in the world, z = 0, metres: its far edges are seen in the figures.
const LOW: DVec2 = dvec2(-4.0, -5.0);
const HIGH: DVec2 = dvec2(16.0, 9.0);
/// Texels in a metre; a pixel of the figures is about a hundredth.
const SCALE: f64 = 100.0;

/// Bytes as the picture stores them, which the scenes take as linear: the paper's pictures are so.
const INK: [u8; 3] = [14, 44, 34];
const PAPER: [u8; 3] = [176, 176, 175];

/// The PNG file.
pub fn png() -> Vec<u8> {
    let mut sheet = Sheet::new(LOW, HIGH, SCALE, 1);
    crossed_out(&mut sheet);
    formulas(&mut sheet);
    sketch(&mut sheet);
    sheet.canvas.png_of_two_inks(INK, PAPER)
}

fn pen(x: f64, y: f64, angle: f64, size: f64) -> Pen {
    Pen { at: dvec2(x, y), angle, size }
}

/// Two letters, written over and struck out: the place that is in focus.
fn crossed_out(sheet: &mut Sheet) {
    for shift in [0.0, 0.02, 0.035] {
        sheet.write(pen(-1.72 + shift, -0.81 + 0.3 * shift, 4.0, 0.215), "Li");
    }
    sheet.stroke(&[dvec2(-2.37, -0.9), dvec2(-1.75, -0.875), dvec2(-1.45, -0.87), dvec2(-1.04, -0.93)]);
    sheet.stroke(&[dvec2(-2.36, -0.915), dvec2(-1.6, -0.88), dvec2(-1.2, -0.895)]);
    for x in [-1.54, -1.51] {
        sheet.stroke(&[dvec2(x, -0.31), dvec2(-1.46, -0.8), dvec2(-1.44, -0.98), dvec2(x + 0.05, -1.59)]);
    }
    sheet.stroke(&[dvec2(-1.56, -0.97), dvec2(-1.4, -0.8), dvec2(-1.3, -0.72)]);
    sheet.stroke(&[dvec2(-1.58, -0.8), dvec2(-1.42, -0.93), dvec2(-1.34, -1.02)]);
}

fn formulas(sheet: &mut Sheet) {
    // The line of the struck letters, which the dragon stands on.
    let end = sheet.write(pen(-1.03, -0.72, 2.5, 0.2), "+ log");
    let end = sheet.fraction(Pen { at: end.at + dvec2(0.06, 0.0), ..end }, "p(ω_i)", "q(ω_i)");
    sheet.write(end, "- f_r(ω_i) cos θ_i dω");

    let end = sheet.write(pen(-1.52, 0.78, 5.5, 0.205), "L_o = L_e + ∫ f_r L_i");
    let end = sheet.write(end, " cos θ dω  ");
    let end = sheet.fraction(end, "f(x_i)", "p(x_i)");
    sheet.write(end, "≈ E[f]");

    sheet.write(pen(-0.6, 2.12, 5.0, 0.2), "- Σ  - log p_i");
    sheet.write(pen(2.35, 2.55, 3.0, 0.2), "∂E / ∂λ");
    let end = sheet.write(pen(3.15, 3.42, -4.0, 0.2), "q_i  q_i  q_i (p_i + h_i) log ");
    sheet.fraction(end, "p_i", "q_i");
    sheet.write(pen(-2.1, 3.9, 6.0, 0.21), "L = Σ f(x_i) - q_i f(h_i)");
    let end = sheet.write(pen(4.2, 4.6, 1.0, 0.2), "= M_i log ");
    sheet.fraction(end, "M_i", "N_i");
    let end = sheet.write(pen(0.2, 5.9, 3.0, 0.21), "= Σ p_i log ");
    let end = sheet.fraction(end, "p_i", "q_i");
    sheet.write(end, " - Σ q_i f(h_i)");
    sheet.write(pen(0.9, 7.6, 2.0, 0.22), "ln E[e^{f(x)}] = E[f] + D(q|p)");
    sheet.write(pen(9.5, 6.2, -1.0, 0.2), "σ^2 = E[x^2] - E[x]^2");

    sheet.write(pen(6.4, 1.05, 2.0, 0.22), "p_i log p_i");
    sheet.write(pen(6.55, 0.12, 2.0, 0.22), "p_i f(x_i) .");
    sheet.stroke(&[dvec2(6.5, 0.0), dvec2(7.8, -0.02), dvec2(8.9, -0.1)]);
    let end = sheet.write(pen(6.5, -1.32, 4.5, 0.24), "p_i (log p_i + x h_i) - p_i (log q_i -");
    sheet.write(end, " log e^{h_i})");
    for y in [-1.2, -1.12] {
        sheet.stroke(&[dvec2(6.9, y - 0.35), dvec2(7.6, y), dvec2(8.3, y + 0.45)]);
    }
}

/// Small circles and lines of some idea.
fn sketch(sheet: &mut Sheet) {
    let circles =
        [(-0.48, -2.09, 0.15), (0.1, -2.6, 0.17), (0.8, -3.08, 0.13), (1.52, -3.82, 0.14), (1.85, -2.52, 0.13)];
    let small = [(2.75, -2.96, 0.1), (1.5, -2.01, 0.11), (-0.9, -4.4, 0.14), (3.4, -3.9, 0.12)];
    for (i, &(x, y, r)) in circles.iter().chain(&small).enumerate() {
        let turn = i as f64 * 0.9;
        let points: Vec<DVec2> = (0..=9)
            .map(|k| {
                let (sin, cos) = libm::sincos(turn + f64::from(k) * 0.74);
                dvec2(x, y) + r * dvec2(cos, (0.85 + 0.03 * f64::from(k)) * sin)
            })
            .collect();
        sheet.stroke(&points);
    }
    sheet.stroke(&[dvec2(1.7, -1.62), dvec2(1.73, -2.5), dvec2(1.69, -3.3), dvec2(1.67, -4.3)]);
    sheet.stroke(&[dvec2(1.88, -1.66), dvec2(1.73, -1.94)]);
    sheet.stroke(&[dvec2(0.95, -4.23), dvec2(0.4, -4.2), dvec2(-0.35, -4.2)]);
    sheet.write(pen(-2.9, -3.6, 3.0, 0.2), "p_i");
}
