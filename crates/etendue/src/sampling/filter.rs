//! Reconstruction filters by importance sampling (Ernst, Stamminger and Greiner, "Filter Importance Sampling", 2006): the
//! filter's magnitude is the density of the sample's place about the pixel's centre, so pixels stay independent of each other.
//! Every sample of a filter without negative lobes weighs one. Where there are such lobes, weights are of one size, above
//! one, with the lobe's sign, and one on average; pixels may then be slightly negative beside bright edges.

use std::f64::consts::PI;
use std::fmt;
use std::str::FromStr;

use super::filter_table::FilterTable;
use crate::film::UnknownName;
use crate::math::{Vec2, ln, vec2};

/// A reconstruction filter, a product of two equal one-dimensional filters. Lengths are in pixels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// Constant up to `radius` along each axis.
    Box {
        /// Half the width, above 0.
        radius: f32,
    },
    /// Linear from the centre down to 0 at `radius` along each axis.
    Tent {
        /// Half the width, above 0.
        radius: f32,
    },
    /// A normal distribution, cut off at `radius` along each axis.
    Gaussian {
        /// Standard deviation, above 0.
        sigma: f32,
        /// Half the width, above 0.
        radius: f32,
    },
    /// Piecewise cubic with small negative lobes (Mitchell and Netravali, "Reconstruction Filters in Computer Graphics",
    /// 1988).
    Mitchell {
        /// Blur, 0 to 1.
        b: f32,
        /// Ringing, 0 to 1.
        c: f32,
        /// Half the width, above 0; 2 is the filter as published.
        radius: f32,
    },
    /// A sinc windowed by the central lobe of a wider one (Duchon, "Lanczos Filtering in One and Two Dimensions", 1979).
    Lanczos {
        /// Half the width and number of lobes, above 0.
        radius: f32,
    },
}

impl Default for Filter {
    /// A Gaussian of standard deviation 0.5 and radius 1.5.
    fn default() -> Self {
        Self::Gaussian { sigma: 0.5, radius: 1.5 }
    }
}

impl Filter {
    /// Every filter, with default parameters; the box covers one pixel.
    pub const ALL: [Self; 5] = [
        Self::Gaussian { sigma: 0.5, radius: 1.5 },
        Self::Box { radius: 0.5 },
        Self::Tent { radius: 1.0 },
        Self::Mitchell { b: 1.0 / 3.0, c: 1.0 / 3.0, radius: 2.0 },
        Self::Lanczos { radius: 3.0 },
    ];

    /// The name it has in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Gaussian { .. } => "gaussian",
            Self::Box { .. } => "box",
            Self::Tent { .. } => "tent",
            Self::Mitchell { .. } => "mitchell",
            Self::Lanczos { .. } => "lanczos",
        }
    }
}

impl fmt::Display for Filter {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Filter {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL.into_iter().find(|f| f.name() == name).ok_or_else(|| UnknownName {
            kind: "filter",
            name: name.to_owned(),
            expected: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// A [`Filter`] made ready to be sampled.
#[derive(Clone, Debug, PartialEq)]
pub struct FilterSampler {
    radius: f32,
    axis: Axis,
}

/// How one coordinate is found.
#[derive(Clone, Debug, PartialEq)]
enum Axis {
    Box,
    Tent,
    /// `scale` is sqrt(2) sigma, `share` that of the untruncated distribution within the radius.
    Gaussian {
        scale: f32,
        share: f32,
    },
    Table(FilterTable),
}

impl FilterSampler {
    /// Prepares a filter. Parameters out of their range place every sample at the centre or inside of the radius somehow,
    /// but never fail.
    pub fn new(filter: Filter) -> Self {
        let tabulated = |radius: f32, kernel: &dyn Fn(f64) -> f64| {
            let table = FilterTable::new(f64::from(radius), kernel);
            (radius, table.map_or(Axis::Box, Axis::Table))
        };
        let (radius, axis) = match filter {
            Filter::Box { radius } => (radius, Axis::Box),
            Filter::Tent { radius } => (radius, Axis::Tent),
            Filter::Gaussian { sigma, radius } => {
                let scale = f64::from(sigma) * std::f64::consts::SQRT_2;
                let share = libm::erf(f64::from(radius) / scale);
                (radius, Axis::Gaussian { scale: scale as f32, share: share as f32 })
            }
            Filter::Mitchell { b, c, radius } => {
                let unit = 2.0 / f64::from(radius);
                tabulated(radius, &|x| mitchell(x * unit, b.into(), c.into()))
            }
            Filter::Lanczos { radius } => tabulated(radius, &|x| sinc(x) * sinc(x / f64::from(radius))),
        };
        Self { radius, axis }
    }

    /// Offset from the pixel's centre for `u` in [0, 1)^2, each coordinate by the inverse of its distribution function and at
    /// most the radius either way, and the sample's weight. The mean of weight times value is the filtered value: the
    /// weight is the filter, with unit integral, over the density of the offset.
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> (Vec2, f32) {
        if let Axis::Table(table) = &self.axis {
            let [(x, weight_x), (y, weight_y)] = u.map(|u| table.sample(u));
            return (self.bounded(x, y), weight_x * weight_y);
        }
        // The middles of the 2^24 values that u can have lie symmetrically about 0 and short of -1 and 1; all exact.
        let [x, y] = u.map(|u| {
            let v = 2.0 * u - (1.0 - 1.0 / 16_777_216.0);
            match &self.axis {
                Axis::Tent => (self.radius * (1.0 - (1.0 - v.abs()).sqrt())).copysign(v),
                Axis::Gaussian { scale, share } => scale * inverse_erf(v * share),
                Axis::Box | Axis::Table(_) => v * self.radius,
            }
        });
        (self.bounded(x, y), 1.0)
    }

    #[inline]
    fn bounded(&self, x: f32, y: f32) -> Vec2 {
        let bounded = |x: f32| x.max(-self.radius).min(self.radius);
        vec2(bounded(x), bounded(y))
    }
}

/// The family of piecewise cubics on [-2, 2] with unit integral.
fn mitchell(x: f64, b: f64, c: f64) -> f64 {
    let x = x.abs();
    let cubic = if x < 1.0 {
        ((12.0 - 9.0 * b - 6.0 * c) * x + (-18.0 + 12.0 * b + 6.0 * c)) * x * x + (6.0 - 2.0 * b)
    } else {
        (((-b - 6.0 * c) * x + (6.0 * b + 30.0 * c)) * x + (-12.0 * b - 48.0 * c)) * x + (8.0 * b + 24.0 * c)
    };
    cubic / 6.0
}

fn sinc(x: f64) -> f64 {
    if x.abs() < 1e-9 { 1.0 } else { libm::sin(PI * x) / (PI * x) }
}

/// Inverse of the error function on (-1, 1); relative error below 1e-6
/// (Giles, "Approximating the erfinv Function", GPU Computing Gems 2, 2011).
#[inline]
fn inverse_erf(x: f32) -> f32 {
    const CENTRE: [f32; 9] = [
        2.810_226_4e-8,
        3.432_739_4e-7,
        -3.523_387_7e-6,
        -4.391_506_5e-6,
        2.185_808_7e-4,
        -1.253_725e-3,
        -4.177_681_6e-3,
        2.466_407_3e-1,
        1.501_409_4,
    ];
    const TAIL: [f32; 9] = [
        -2.002_142_6e-4,
        1.009_505_6e-4,
        1.349_343_2e-3,
        -3.673_428_4e-3,
        5.739_507_7e-3,
        -7.622_461_3e-3,
        9.438_870_5e-3,
        1.001_674,
        2.832_976_8,
    ];
    let w = -ln((1.0 - x) * (1.0 + x));
    let (t, coefficients) = if w < 5.0 { (w - 2.5, CENTRE) } else { (w.sqrt() - 3.0, TAIL) };
    x * coefficients[1..].iter().fold(coefficients[0], |p, c| p * t + c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_of_erf() {
        let mut worst = 0.0f64;
        for i in 1..=1_000_000u32 {
            let x = (i as f32 - 0.5) / 1_000_000.0;
            let y = f64::from(inverse_erf(x));
            // One Newton step from the result estimates its error.
            let slope = std::f64::consts::FRAC_2_SQRT_PI * libm::exp(-y * y);
            worst = worst.max(((libm::erf(y) - f64::from(x)) / slope / y).abs());
            assert_eq!(inverse_erf(-x), -inverse_erf(x));
        }
        assert!(worst < 1e-6, "{worst}");
        assert_eq!(inverse_erf(0.0), 0.0);
    }

    #[test]
    fn names() {
        for filter in Filter::ALL {
            assert_eq!(filter.to_string().parse(), Ok(filter));
        }
        assert!("gausian".parse::<Filter>().is_err_and(|e| e.to_string().contains("gaussian, box")));
    }

    #[test]
    fn degenerate_parameters_never_fail() {
        for (sigma, radius) in [(0.0, 1.0), (0.0, 0.0), (1.0, 0.0), (1e30, 1.0), (1e-30, 1.0), (1.0, 1e30)] {
            let sampler = FilterSampler::new(Filter::Gaussian { sigma, radius });
            for u in [0.0, 0.5, 1.0 - 1.0 / 16_777_216.0] {
                let (p, weight) = sampler.sample([u, u]);
                assert!(p.x.abs() <= radius && weight == 1.0, "{sigma} {radius} {u}: {p}");
            }
        }
        for radius in [0.0, 1e-30, 1e30, f32::NAN, f32::INFINITY] {
            let mitchell = |b, c| Filter::Mitchell { b, c, radius };
            for filter in
                [Filter::Lanczos { radius }, mitchell(0.5, 0.5), mitchell(1e30, -1e30), mitchell(f32::NAN, 0.0)]
            {
                let (p, weight) = FilterSampler::new(filter).sample([0.3, 0.9]);
                assert!((p.x.abs() <= radius || radius.is_nan()) && weight.is_finite(), "{filter:?}: {p} {weight}");
            }
        }
    }
}
