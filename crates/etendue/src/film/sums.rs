//! Exact sums: fixed point, so wide that adding is associative.

use crate::spectrum::Spectrum;

/// Fractional bits of sums of light.
pub(super) const LIGHT: i32 = 64;
/// Fractional bits of sums of lengths, which may be larger.
pub(super) const LENGTH: i32 = 48;
/// Fractional bits of the difference of the two halves.
const DIFFERENCE: i32 = 24;
/// Differences are kept modulo 2^64; while the sum stays below this they cannot have wrapped.
const DIFFERENCE_LIMIT: f64 = 549_755_813_888.0; // 2^(63 - DIFFERENCE)

/// True for what a sum with `fraction` bits can take: finite, and so small that 2^25 of them still fit.
#[inline]
pub(super) fn is_storable(value: f32, fraction: i32) -> bool {
    // 2^(102 - fraction), by its exponent.
    value.abs() < f32::from_bits(((102 - fraction + 127) as u32) << 23)
}

/// `value` as fixed point with `fraction` bits; exact for all but tiny values, which are rounded towards zero.
#[inline]
pub(super) fn to_fixed(value: f32, fraction: i32) -> i128 {
    let bits = value.to_bits();
    let exponent = (bits >> 23 & 0xff) as i32;
    let mantissa = i128::from(bits & 0x7f_ffff | if exponent > 0 { 0x80_0000 } else { 0 });
    let shift = exponent.max(1) - 150 + fraction;
    let magnitude = if shift >= 0 {
        mantissa << shift
    } else if shift > -24 {
        mantissa >> -shift
    } else {
        0
    };
    if value.is_sign_negative() { -magnitude } else { magnitude }
}

/// The value of a sum.
#[inline]
pub(super) fn from_fixed(sum: i128, fraction: i32) -> f64 {
    // 2^-fraction, by its exponent.
    sum as f64 * f64::from_bits(((1023 - fraction) as u64) << 52)
}

/// The sums of one pixel's colour: 80 bytes.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ColourSums {
    /// Both halves.
    pub sum: [i128; 3],
    /// Even minus odd half, modulo 2^64.
    difference: [i64; 3],
    /// Samples in the even and the odd half.
    count: [u32; 2],
}

impl ColourSums {
    /// Adds light of a half; `counts` if it is a sample, not more light of one.
    pub fn add(&mut self, radiance: Spectrum, half: usize, counts: bool) {
        for (channel, value) in radiance.0.into_iter().enumerate() {
            let fixed = to_fixed(value, LIGHT);
            let coarse = (fixed >> (LIGHT - DIFFERENCE)) as i64;
            self.sum[channel] += fixed;
            self.difference[channel] = self.difference[channel].wrapping_add(if half == 0 { coarse } else { -coarse });
        }
        self.count[half] += u32::from(counts);
    }

    pub fn merge(&mut self, other: &Self) {
        for channel in 0..3 {
            self.sum[channel] += other.sum[channel];
            self.difference[channel] = self.difference[channel].wrapping_add(other.difference[channel]);
        }
        self.count[0] += other.count[0];
        self.count[1] += other.count[1];
    }

    pub fn samples(&self) -> u32 {
        self.count[0] + self.count[1]
    }

    pub fn mean(&self, channel: usize) -> f32 {
        mean(self.sum[channel], self.samples(), LIGHT)
    }

    /// Estimated variance of the mean, from the two halves' means; infinite where a half is empty.
    pub fn variance_of_mean(&self, channel: usize) -> f32 {
        let [even, odd] = self.count.map(f64::from);
        let sum = from_fixed(self.sum[channel], LIGHT);
        if even == 0.0 || odd == 0.0 || sum.abs() >= DIFFERENCE_LIMIT {
            return f32::INFINITY;
        }
        let difference = self.difference[channel] as f64 * (1.0 / f64::from(1u32 << DIFFERENCE));
        let (a, b) = ((sum + difference) / (2.0 * even), (sum - difference) / (2.0 * odd));
        // Each half mean has variance s / n_half; E (a - b)^2 = s (1/even + 1/odd), and the mean's variance is s / n.
        ((a - b) * (a - b) / ((1.0 / even + 1.0 / odd) * (even + odd))) as f32
    }
}

/// A sum over its number of samples; 0 of none.
pub(super) fn mean(sum: i128, samples: u32, fraction: i32) -> f32 {
    match samples {
        0 => 0.0,
        n => (from_fixed(sum, fraction) / f64::from(n)) as f32,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fixed_point_is_exact_down_to_its_last_bit() {
        let exact = [0.0, 1.0, -1.0, 0.1, 3.402e7, -5.3e10, 1e-6, 549_755_781_120.0, 2f32.recip(), 1.0 + f32::EPSILON];
        for value in exact {
            assert_eq!(from_fixed(to_fixed(value, LIGHT), LIGHT), f64::from(value), "{value}");
        }
        let last_bit = 1.0 / 18_446_744_073_709_551_616.0;
        for tiny in [1e-15, -1e-15, 3.3e-18, 1e-25, f32::MIN_POSITIVE, 1e-45] {
            let error = from_fixed(to_fixed(tiny, LIGHT), LIGHT) - f64::from(tiny);
            assert!(error.abs() < last_bit && error * f64::from(tiny) <= 0.0, "{tiny}: {error}");
        }
        for value in [1e15, -1.8e16, 0.1, 1e-6] {
            assert_eq!(from_fixed(to_fixed(value, LENGTH), LENGTH), f64::from(value), "{value}");
        }
    }

    /// The largest value that is taken fits 2^25 times: as many samples, each with as much again in its parts.
    #[test]
    fn what_is_storable_fits() {
        for (fraction, limit) in [(LIGHT, 274_877_906_944.0f32), (LENGTH, 18_014_398_509_481_984.0)] {
            let largest = f32::from_bits(limit.to_bits() - 1);
            assert!(is_storable(largest, fraction) && is_storable(-largest, fraction) && !is_storable(limit, fraction));
            assert!(![f32::NAN, f32::INFINITY].iter().any(|v| is_storable(*v, fraction)));
            let most = to_fixed(largest, fraction).checked_mul(1 << 25).expect("fits");
            assert_eq!(from_fixed(most, fraction) / 33_554_432.0, f64::from(largest));
        }
    }

    #[test]
    fn sums_do_not_depend_on_order_or_grouping() {
        let values: Vec<f32> = (0..1000).map(|i| (i % 37) as f32 * 0.1 * if i % 5 == 0 { 1e9 } else { 1e-7 }).collect();
        let sums = |order: &mut dyn Iterator<Item = usize>, chunk: usize| {
            let order: Vec<usize> = order.collect();
            let mut total = ColourSums::default();
            for part in order.chunks(chunk) {
                let mut sums = ColourSums::default();
                part.iter().for_each(|&i| sums.add(Spectrum([values[i], -values[i], 0.5]), i & 1, true));
                total.merge(&sums);
            }
            (total.sum, total.difference, total.count)
        };
        let reference = sums(&mut (0..1000), 1000);
        assert_eq!(reference, sums(&mut (0..1000).rev(), 7));
        assert_eq!(reference, sums(&mut (0..1000).map(|i| i * 387 % 1000), 64));
    }

    #[test]
    fn a_pixel_is_80_bytes() {
        assert_eq!(size_of::<ColourSums>(), 80);
    }
}
