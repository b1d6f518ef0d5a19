//! How far a picture is from a reference.

use etendue::image::Image;
use std::fmt;

/// How a difference is measured; `b` is the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Metric {
    /// Mean of (a - b)^2 / (b^2 + 0.01).
    RelMse,
    /// Mean of (a - b)^2.
    Mse,
    /// Mean of |a - b|.
    Mae,
}

impl Metric {
    /// Every metric.
    pub const ALL: [Self; 3] = [Self::RelMse, Self::Mse, Self::Mae];

    /// As on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::RelMse => "relmse",
            Self::Mse => "mse",
            Self::Mae => "mae",
        }
    }

    /// The error of one sample.
    pub fn error(self, a: f32, b: f32) -> f64 {
        let (a, b) = (f64::from(a), f64::from(b));
        let d = a - b;
        match self {
            Self::RelMse => d * d / (b * b + 0.01),
            Self::Mse => d * d,
            Self::Mae => d.abs(),
        }
    }

    /// True if errors are squares, whose roots are what the eye wants to compare.
    pub const fn is_squared(self) -> bool {
        matches!(self, Self::RelMse | Self::Mse)
    }
}

impl fmt::Display for Metric {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// Why two pictures cannot be compared.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CompareError {
    /// The sizes differ.
    #[error("the sizes differ: {}x{} and {}x{}", a[0], a[1], b[0], b[1])]
    Size {
        /// Width and height of the first.
        a: [u32; 2],
        /// Width and height of the reference.
        b: [u32; 2],
    },
    /// No channel is in both.
    #[error("the pictures have no channel of floats in common")]
    Channels,
}

/// The outcome of a comparison.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Mean of the error over all pixels and channels where both pictures are finite; 0 if there are none.
    pub mean: f64,
    /// Largest error of a sample.
    pub max: f64,
    /// Pixel of the largest error.
    pub max_at: [u32; 2],
    /// Pixels where either picture is not finite in a compared channel; left out of the mean.
    pub nonfinite: u64,
    /// The first of those, row by row.
    pub first_nonfinite: Option<[u32; 2]>,
    /// Names of the channels compared.
    pub channels: Vec<String>,
    /// Mean error over channels, a pixel; NaN where not finite. Row by row from the top left.
    pub pixels: Vec<f64>,
}

/// Compares `a` with the reference `b`: `R`, `G` and `B` where both have them, otherwise all float channels that both
/// have.
pub fn compare(a: &Image, b: &Image, metric: Metric) -> Result<Comparison, CompareError> {
    if (a.width, a.height) != (b.width, b.height) {
        return Err(CompareError::Size { a: [a.width, a.height], b: [b.width, b.height] });
    }
    let channels = common_channels(a, b);
    let pairs: Vec<(&[f32], &[f32])> =
        channels.iter().filter_map(|name| a.f32_channel(name).zip(b.f32_channel(name))).collect();
    if pairs.is_empty() {
        return Err(CompareError::Channels);
    }
    let place = |pixel: usize| [(pixel % a.width as usize) as u32, (pixel / a.width as usize) as u32];
    let mut result = Comparison {
        mean: 0.0,
        max: 0.0,
        max_at: [0, 0],
        nonfinite: 0,
        first_nonfinite: None,
        channels,
        pixels: Vec::with_capacity(pairs[0].0.len()),
    };
    let mut sum = 0.0;
    for pixel in 0..pairs[0].0.len() {
        if pairs.iter().any(|(a, b)| !a[pixel].is_finite() || !b[pixel].is_finite()) {
            result.nonfinite += 1;
            result.first_nonfinite.get_or_insert(place(pixel));
            result.pixels.push(f64::NAN);
            continue;
        }
        let mut pixel_sum = 0.0;
        for (a, b) in &pairs {
            let error = metric.error(a[pixel], b[pixel]);
            pixel_sum += error;
            if error > result.max {
                (result.max, result.max_at) = (error, place(pixel));
            }
        }
        sum += pixel_sum;
        result.pixels.push(pixel_sum / pairs.len() as f64);
    }
    let finite = result.pixels.len() as u64 - result.nonfinite;
    if finite > 0 {
        result.mean = sum / (finite * pairs.len() as u64) as f64;
    }
    Ok(result)
}

fn common_channels(a: &Image, b: &Image) -> Vec<String> {
    let both = |name: &str| a.f32_channel(name).is_some() && b.f32_channel(name).is_some();
    let color = ["R", "G", "B"];
    if color.iter().all(|name| both(name)) {
        return color.iter().map(|name| (*name).to_owned()).collect();
    }
    a.channels.iter().map(|c| c.name.clone()).filter(|name| both(name)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue::image::{Channel, ChannelData};

    fn image(width: u32, channels: &[(&str, &[f32])]) -> Image {
        let height = (channels[0].1.len() as u32) / width;
        let channels = channels
            .iter()
            .map(|(name, data)| Channel { name: (*name).to_owned(), data: ChannelData::F32(data.to_vec()) })
            .collect();
        Image { width, height, channels }
    }

    #[test]
    fn closed_forms() {
        let a = image(2, &[("Y", &[1.0, 3.0])]);
        let b = image(2, &[("Y", &[1.0, 2.0])]);
        assert!((compare(&a, &b, Metric::RelMse).unwrap().mean - 0.5 / 4.01).abs() < 1e-15);
        assert_eq!(compare(&a, &b, Metric::Mse).unwrap().mean, 0.5);
        let mae = compare(&a, &b, Metric::Mae).unwrap();
        assert_eq!((mae.mean, mae.max, mae.max_at), (0.5, 1.0, [1, 0]));
        // The reference is the second: dividing by the other would give another number.
        assert!((compare(&b, &a, Metric::RelMse).unwrap().mean - 0.5 / 9.01).abs() < 1e-15);
    }

    #[test]
    fn colour_counts_before_other_channels_and_alpha_does_not() {
        let a = image(1, &[("R", &[1.0]), ("G", &[1.0]), ("B", &[1.0]), ("A", &[0.0]), ("Depth.Z", &[5.0])]);
        let b = image(1, &[("R", &[1.0]), ("G", &[1.0]), ("B", &[4.0]), ("A", &[1.0]), ("Depth.Z", &[9.0])]);
        let c = compare(&a, &b, Metric::Mae).unwrap();
        assert_eq!((c.mean, c.channels.len()), (1.0, 3));
    }

    #[test]
    fn pixels_that_are_not_finite_are_counted_and_left_out() {
        let a = image(2, &[("Y", &[f32::NAN, 1.0, 2.0, 1.0])]);
        let b = image(2, &[("Y", &[1.0, 1.0, 1.0, f32::INFINITY])]);
        let c = compare(&a, &b, Metric::Mse).unwrap();
        assert_eq!((c.nonfinite, c.first_nonfinite, c.mean), (2, Some([0, 0]), 0.5));
    }

    #[test]
    fn what_cannot_be_compared() {
        let a = image(2, &[("Y", &[1.0, 1.0])]);
        assert_eq!(
            compare(&a, &image(1, &[("Y", &[1.0, 1.0])]), Metric::Mse).unwrap_err(),
            CompareError::Size { a: [2, 1], b: [1, 2] }
        );
        assert_eq!(compare(&a, &image(2, &[("Z", &[1.0, 1.0])]), Metric::Mse).unwrap_err(), CompareError::Channels);
    }
}
