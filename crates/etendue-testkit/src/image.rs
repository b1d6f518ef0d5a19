//! Distances between pictures, as flat slices of numbers of any layout. The reference is always `b`.
//!
//! All are means over the numbers (pixels and channels alike), NaN if the slices are empty, and NaN or infinite if a
//! number is.

#[track_caller]
fn mean(a: &[f32], b: &[f32], distance: impl Fn(f64, f64) -> f64) -> f64 {
    assert_eq!(a.len(), b.len(), "pictures of unequal size");
    a.iter().zip(b).map(|(&a, &b)| distance(f64::from(a), f64::from(b))).sum::<f64>() / a.len() as f64
}

fn relative_square(a: f64, b: f64) -> f64 {
    (a - b).powi(2) / (b * b + 0.01)
}

/// Mean squared error.
///
/// # Panics
/// If the slices differ in length, as all here.
#[track_caller]
pub fn mse(a: &[f32], b: &[f32]) -> f64 {
    mean(a, b, |a, b| (a - b).powi(2))
}

/// Mean absolute error.
#[track_caller]
pub fn mae(a: &[f32], b: &[f32]) -> f64 {
    mean(a, b, |a, b| (a - b).abs())
}

/// Mean of (a - b)^2 / (b^2 + 0.01) (Rousselle, Knaus and Zwicker, "Adaptive Sampling and Reconstruction using Greedy
/// Error Minimization", 2011).
#[track_caller]
pub fn rel_mse(a: &[f32], b: &[f32]) -> f64 {
    mean(a, b, relative_square)
}

/// [`rel_mse`] without the worst `fraction` (0 to 1) of the numbers, so that a few fireflies do not hide the rest. NaN
/// counts as worst.
#[track_caller]
pub fn rel_mse_trimmed(a: &[f32], b: &[f32], fraction: f64) -> f64 {
    assert_eq!(a.len(), b.len(), "pictures of unequal size");
    let mut errors: Vec<f64> =
        a.iter().zip(b).map(|(&a, &b)| relative_square(f64::from(a), f64::from(b)).abs()).collect();
    errors.sort_by(f64::total_cmp);
    let keep = errors.len() - (errors.len() as f64 * fraction.clamp(0.0, 1.0)) as usize;
    errors[..keep].iter().sum::<f64>() / keep as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        let (a, b) = ([1.0, 2.0, 0.0, 4.0], [1.0, 1.0, 0.0, 2.0]);
        assert_eq!(mse(&a, &b), 1.25);
        assert_eq!(mae(&a, &b), 0.75);
        let expected = (1.0 / 1.01 + 4.0 / 4.01) / 4.0;
        assert!((rel_mse(&a, &b) - expected).abs() < 1e-15);
        assert!((rel_mse_trimmed(&a, &b, 0.25) - 1.0 / 1.01 / 3.0).abs() < 1e-15);
        assert_eq!(rel_mse_trimmed(&a, &b, 0.0), rel_mse(&a, &b));
    }

    #[test]
    fn not_finite() {
        assert!(mse(&[f32::NAN, 1.0], &[1.0, 1.0]).is_nan());
        assert_eq!(rel_mse_trimmed(&[f32::NAN, 1.0], &[1.0, 1.0], 0.5), 0.0);
        assert!(mse(&[], &[]).is_nan());
    }
}
