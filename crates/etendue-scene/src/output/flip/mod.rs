//! FLIP: what an observer sees who flips between two pictures (Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström,
//! Fairchild, "FLIP: A Difference Evaluator for Alternating Images", 2020), and its form for high dynamic range ("Visualizing
//! and Communicating Errors in Rendered Images", Ray Tracing Gems II, 2021).
//!
//! Both differences are of an observer at 0.7 m from a monitor 0.7 m and 3840 pixels wide, which makes 67 pixels a degree, and
//! are from 0 (none) to 1.

mod color;
mod exposure;
mod filter;

use color::{LARGEST_DIFFERENCE, hunt_lab, hyab, linear_rgb, opponent};
use exposure::exposures;
use filter::{Plane, blur_kernels, feature_kernels};
use std::thread;

/// 0.7 m times 3840 pixels over 0.7 m, times a degree.
const PIXELS_PER_DEGREE: f64 = 3840.0 * std::f64::consts::PI / 180.0;

/// Exponent of the colour difference, and where its steep part ends in both scales: differences up to 0.4 of the largest take
/// 0.95 of the range.
const COLOR_EXPONENT: f64 = 0.7;
const KNEE: [f64; 2] = [0.4, 0.95];
/// Exponent of the feature difference.
const FEATURE_EXPONENT: f64 = 0.5;

/// The FLIP error of every pixel for colours as displayed, linear, clamped to [0, 1]. `b` is the reference (which of the two
/// it is makes no difference here).
pub(super) fn of_displayed(a: &[[f32; 3]], b: &[[f32; 3]], width: usize) -> Vec<f32> {
    let seen = |pixels| Seen::new(pixels, width);
    // The other thread takes half of the work.
    let (a, b) = thread::scope(|scope| {
        let other = scope.spawn(|| seen(a));
        let own = seen(b);
        (other.join(), own)
    });
    let Ok(a) = a else { return vec![f32::NAN; b.lab.len()] };
    let pixels = a.lab.iter().zip(&b.lab).zip(a.features.iter().zip(&b.features));
    pixels.map(|((a, b), (f, g))| combine(hyab(a, b), f, g) as f32).collect()
}

/// The FLIP error of every pixel for linear colours of any range, the largest over exposures that the reference `b` sets.
pub(super) fn of_any_range(a: &[[f32; 3]], b: &[[f32; 3]], width: usize) -> Vec<f32> {
    let mut largest = vec![0.0f32; b.len()];
    for exposure in exposures(b) {
        let displayed = |pixels: &[[f32; 3]]| -> Vec<[f32; 3]> {
            pixels.iter().map(|pixel| exposure::displayed(*pixel, exposure)).collect()
        };
        let errors = of_displayed(&displayed(a), &displayed(b), width);
        for (largest, error) in largest.iter_mut().zip(errors) {
            *largest = largest.max(error);
        }
    }
    largest
}

/// What an observer sees of a picture.
struct Seen {
    /// Filtered by the eye's contrast sensitivity, in CIELAB with Hunt's adjustment.
    lab: Vec<[f32; 3]>,
    /// Strength of edges and points.
    features: Vec<[f32; 2]>,
}

impl Seen {
    fn new(pixels: &[[f32; 3]], width: usize) -> Self {
        let clamped = |pixel: &[f32; 3]| pixel.map(|c| f64::from(c).clamp(0.0, 1.0));
        let opponent: Vec<[f32; 3]> = pixels.iter().map(|pixel| opponent(clamped(pixel))).collect();
        let plane = |c: usize| Plane { width, samples: opponent.iter().map(|pixel| pixel[c]).collect() };
        let kernels = blur_kernels(PIXELS_PER_DEGREE);
        let [y, cx, cz] = [0, 1, 2].map(|c| plane(c).blurred(&kernels[c]).samples);
        let lab = (0..pixels.len()).map(|i| hunt_lab(linear_rgb([y[i], cx[i], cz[i]]))).collect();
        // Back to luminance in [0, 1].
        let luminance = Plane { width, samples: opponent.iter().map(|pixel| (pixel[0] + 16.0) / 116.0).collect() };
        Self { lab, features: features(&luminance) }
    }
}

/// Lengths of the gradients of first and second order, of each pixel.
fn features(luminance: &Plane) -> Vec<[f32; 2]> {
    let [smooth, edge, point] = feature_kernels(PIXELS_PER_DEGREE);
    let length = |kernel: &[f64]| -> Vec<f32> {
        let across = luminance.convolved(kernel, &smooth).samples;
        let along = luminance.convolved(&smooth, kernel).samples;
        across.iter().zip(along).map(|(x, y)| (x * x + y * y).sqrt()).collect()
    };
    length(&edge).into_iter().zip(length(&point)).map(|(edge, point)| [edge, point]).collect()
}

/// The error of a colour difference and two features.
fn combine(color: f64, a: &[f32; 2], b: &[f32; 2]) -> f64 {
    let color = libm::pow(color / LARGEST_DIFFERENCE, COLOR_EXPONENT);
    let color = if color < KNEE[0] {
        color * KNEE[1] / KNEE[0]
    } else {
        KNEE[1] + (color - KNEE[0]) / (1.0 - KNEE[0]) * (1.0 - KNEE[1])
    };
    let difference = |i: usize| f64::from((a[i] - b[i]).abs());
    let feature = libm::pow(difference(0).max(difference(1)) * std::f64::consts::FRAC_1_SQRT_2, FEATURE_EXPONENT);
    libm::pow(color, 1.0 - feature).clamp(0.0, 1.0)
}
