//! How far a picture is from a reference.

use super::flip;
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
    /// FLIP of colours as displayed, clamped to [0, 1]; see [`flip`].
    Flip,
    /// FLIP of colours of any range, the largest over exposures; see [`flip`].
    HdrFlip,
}

impl Metric {
    /// Every metric.
    pub const ALL: [Self; 5] = [Self::RelMse, Self::Mse, Self::Mae, Self::Flip, Self::HdrFlip];

    /// As on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::RelMse => "relmse",
            Self::Mse => "mse",
            Self::Mae => "mae",
            Self::Flip => "flip",
            Self::HdrFlip => "hdr-flip",
        }
    }

    /// The error of one sample, where it depends on nothing else.
    fn of_samples(self) -> Option<fn(f64, f64) -> f64> {
        match self {
            Self::RelMse => Some(|a, b| (a - b) * (a - b) / (b * b + 0.01)),
            Self::Mse => Some(|a, b| (a - b) * (a - b)),
            Self::Mae => Some(|a, b| (a - b).abs()),
            Self::Flip | Self::HdrFlip => None,
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
    /// FLIP compares colours.
    #[error("FLIP compares colours: both pictures must have the channels R, G and B")]
    NoColor,
}

/// The outcome of a comparison.
#[derive(Clone, Debug)]
pub struct Comparison {
    /// Mean of the error over all pixels, and channels unless the metric is of colours, where both pictures are finite; 0 if
    /// there are none.
    pub mean: f64,
    /// Largest error of a sample, or a pixel.
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
    let errors = Errors::new(pairs, metric, a.width as usize)?;
    let place = |pixel: usize| [(pixel % a.width as usize) as u32, (pixel / a.width as usize) as u32];
    let pixels = a.width as usize * a.height as usize;
    let mut result = Comparison {
        mean: 0.0,
        max: 0.0,
        max_at: [0, 0],
        nonfinite: 0,
        first_nonfinite: None,
        channels,
        pixels: Vec::with_capacity(pixels),
    };
    let mut sum = 0.0;
    for pixel in 0..pixels {
        if !errors.are_finite(pixel) {
            result.nonfinite += 1;
            result.first_nonfinite.get_or_insert(place(pixel));
            result.pixels.push(f64::NAN);
            continue;
        }
        let mut pixel_sum = 0.0;
        for i in 0..errors.a_pixel() {
            let error = errors.of(pixel, i);
            pixel_sum += error;
            if error > result.max {
                (result.max, result.max_at) = (error, place(pixel));
            }
        }
        sum += pixel_sum;
        result.pixels.push(pixel_sum / errors.a_pixel() as f64);
    }
    let finite = pixels as u64 - result.nonfinite;
    if finite > 0 {
        result.mean = sum / (finite * errors.a_pixel() as u64) as f64;
    }
    Ok(result)
}

/// A channel of the picture and of the reference.
type Pair<'a> = (&'a [f32], &'a [f32]);

/// Errors of a comparison, one or several a pixel.
struct Errors<'a> {
    pairs: Vec<Pair<'a>>,
    kind: Kind,
}

enum Kind {
    OfSamples(fn(f64, f64) -> f64),
    OfPixels(Vec<f32>),
}

impl<'a> Errors<'a> {
    fn new(pairs: Vec<Pair<'a>>, metric: Metric, width: usize) -> Result<Self, CompareError> {
        if let Some(error) = metric.of_samples() {
            return Ok(Self { pairs, kind: Kind::OfSamples(error) });
        }
        let [red, green, blue] = pairs[..] else { return Err(CompareError::NoColor) };
        // Filters would spread what is not finite.
        let finite = |values: [f32; 3]| if values.iter().all(|v| v.is_finite()) { values } else { [0.0; 3] };
        let pixels = |of: fn(Pair<'a>) -> &'a [f32]| -> Vec<[f32; 3]> {
            let (r, g, b) = (of(red), of(green), of(blue));
            (0..r.len()).map(|i| finite([r[i], g[i], b[i]])).collect()
        };
        let (a, b) = (pixels(|pair| pair.0), pixels(|pair| pair.1));
        let errors = match metric {
            Metric::HdrFlip => flip::of_any_range(&a, &b, width),
            _ => flip::of_displayed(&a, &b, width),
        };
        Ok(Self { pairs, kind: Kind::OfPixels(errors) })
    }

    fn are_finite(&self, pixel: usize) -> bool {
        self.pairs.iter().all(|(a, b)| a[pixel].is_finite() && b[pixel].is_finite())
    }

    /// How many errors a pixel has.
    fn a_pixel(&self) -> usize {
        match self.kind {
            Kind::OfSamples(_) => self.pairs.len(),
            Kind::OfPixels(_) => 1,
        }
    }

    fn of(&self, pixel: usize, i: usize) -> f64 {
        match &self.kind {
            Kind::OfSamples(error) => error(f64::from(self.pairs[i].0[pixel]), f64::from(self.pairs[i].1[pixel])),
            Kind::OfPixels(errors) => f64::from(errors[pixel]),
        }
    }
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
