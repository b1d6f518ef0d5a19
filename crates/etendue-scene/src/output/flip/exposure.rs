//! The exposures at which pictures of high dynamic range are compared.

/// The tone curve is ACES in the fit of Narkowicz (2015) without its exposure of 0.6: the coefficients of x^2, x, 1 above and
/// below the line.
const CURVE: [[f64; 3]; 2] = [[0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.0], [0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14]];

/// What counts as bright on the display.
const BRIGHT: f64 = 0.85;

/// Never more exposures than from the least to the largest number; pictures need some 5 to 20.
const MOST: f64 = 256.0;

/// The colour as displayed, in [0, 1].
pub(super) fn displayed(pixel: [f32; 3], stops: f64) -> [f32; 3] {
    let factor = libm::exp2(stops);
    pixel.map(|c| {
        // Far beyond white, and far from overflow.
        let x = (f64::from(c) * factor).clamp(-1e6, 1e6);
        let [above, below] = CURVE.map(|[a, b, c]| (a * x + b) * x + c);
        (above / below).clamp(0.0, 1.0) as f32
    })
}

/// Exposures in stops, about one stop apart: from where the reference's brightest pixel is bright on the display to where
/// its median is. One alone for a reference without light.
pub(super) fn exposures(reference: &[[f32; 3]]) -> Vec<f64> {
    let luminance = |p: &[f32; 3]| 0.2126 * f64::from(p[0]) + 0.7152 * f64::from(p[1]) + 0.0722 * f64::from(p[2]);
    let mut luminances: Vec<f64> = reference.iter().map(luminance).collect();
    if luminances.is_empty() {
        return vec![];
    }
    let middle = luminances.len() / 2;
    let median = *luminances.select_nth_unstable_by(middle, f64::total_cmp).1;
    let largest = luminances.iter().copied().fold(0.0, f64::max);
    if largest <= 0.0 {
        return vec![0.0];
    }
    let median = median.max(f64::from(f32::EPSILON)).min(largest);
    // The x at which the curve gives BRIGHT.
    let [a, b, c] = [0, 1, 2].map(|i| CURVE[0][i] - BRIGHT * CURVE[1][i]);
    let bright = (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a);
    let (start, stop) = (libm::log2(bright / largest), libm::log2(bright / median));
    let count = (stop - start).ceil().clamp(2.0, MOST);
    (0..count as u32).map(|i| start + (stop - start) * f64::from(i) / (count - 1.0)).collect()
}
