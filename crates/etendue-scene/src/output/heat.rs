//! A picture of errors: dark is none, bright is much.

use super::metric::{Comparison, Metric};

/// Three sRGB bytes a pixel: the error of each on a scale whose bright end is [`scale`]; pixels without a finite error
/// are cyan, which the scale never shows.
pub fn heat_map(comparison: &Comparison, metric: Metric, scale: f64) -> Vec<u8> {
    let per_scale = if scale > 0.0 { 1.0 / scale } else { 0.0 };
    comparison
        .pixels
        .iter()
        .flat_map(|&e| if e.is_nan() { [0, 255, 255] } else { color(strength(metric, e) * per_scale) })
        .collect()
}

/// The bright end of a heat map: the 99th percentile of the pixels' errors (of their roots, where errors are squares).
pub fn scale(comparison: &Comparison, metric: Metric) -> f64 {
    let mut errors: Vec<f64> = comparison.pixels.iter().filter(|e| !e.is_nan()).map(|&e| strength(metric, e)).collect();
    if errors.is_empty() {
        return 0.0;
    }
    let at = (errors.len() - 1) * 99 / 100;
    let percentile = *errors.select_nth_unstable_by(at, f64::total_cmp).1;
    if percentile > 0.0 { percentile } else { comparison.max_strength(metric) }
}

impl Comparison {
    fn max_strength(&self, metric: Metric) -> f64 {
        self.pixels.iter().filter(|e| !e.is_nan()).map(|&e| strength(metric, e)).fold(0.0, f64::max)
    }
}

fn strength(metric: Metric, error: f64) -> f64 {
    if metric.is_squared() { error.sqrt() } else { error }
}

/// Black by violet, red and orange to pale yellow for `t` in [0, 1], clamped: in each sRGB channel the cubic through
/// four colours chosen so that CIE lightness rises nearly evenly, so the map reads the same in grey.
fn color(t: f64) -> [u8; 3] {
    const AT_THIRDS: [[f64; 3]; 4] = [[0.0, 0.0, 0.02], [0.42, 0.08, 0.50], [0.91, 0.42, 0.20], [1.0, 1.0, 0.78]];
    let t = t.clamp(0.0, 1.0);
    // Lagrange's polynomials on 0, 1/3, 2/3, 1.
    let (a, b, c) = (t - 1.0 / 3.0, t - 2.0 / 3.0, t - 1.0);
    let basis = [-4.5 * a * b * c, 13.5 * t * b * c, -13.5 * t * a * c, 4.5 * t * a * b];
    [0, 1, 2].map(|channel| {
        let value: f64 = (0..4).map(|k| basis[k] * AT_THIRDS[k][channel]).sum();
        (value.clamp(0.0, 1.0) * 255.0 + 0.5) as u8
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image_file::srgb::to_linear;

    fn lightness(t: f64) -> f64 {
        let [r, g, b] = color(t).map(|v| to_linear(f64::from(v) / 255.0));
        let y = 0.2126 * r + 0.7152 * g + 0.0722 * b;
        if y > 0.008_856 { 116.0 * libm::cbrt(y) - 16.0 } else { 903.3 * y }
    }

    #[test]
    fn lightness_rises_evenly() {
        let steps: Vec<f64> = (0..=20).map(|i| lightness(f64::from(i) / 20.0)).collect();
        assert!(steps[0] < 2.0 && steps[20] > 95.0, "{steps:?}");
        for pair in steps.windows(2) {
            let rise = pair[1] - pair[0];
            assert!((2.0..9.0).contains(&rise), "{rise} in {steps:?}");
        }
    }

    #[test]
    fn scale_ignores_a_few_fireflies_and_marks_nonfinite() {
        let mut pixels = vec![1.0; 999];
        pixels.push(1e6);
        let mut comparison = Comparison {
            mean: 0.0,
            max: 0.0,
            max_at: [0, 0],
            nonfinite: 0,
            first_nonfinite: None,
            channels: vec![],
            pixels,
        };
        assert_eq!(scale(&comparison, Metric::Mae), 1.0);
        comparison.pixels = vec![0.0, f64::NAN, 4.0];
        let map = heat_map(&comparison, Metric::Mse, 2.0);
        assert_eq!(map[..3], color(0.0));
        assert_eq!(map[3..6], [0, 255, 255]);
        assert_eq!(map[6..], color(1.0));
    }
}
