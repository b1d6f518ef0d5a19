//! Transcendental functions as own polynomials: the platform's differ between machines.
//!
//! Exponentials and logarithms work in f64 inside, so their f32 results are off by little more than the final rounding.

/// Pi.
pub const PI: f32 = std::f32::consts::PI;

/// Rounds to the nearest integer, ties to even, for |x| < 2^22.
#[inline(always)]
fn round_small(x: f32) -> f32 {
    const MAGIC: f32 = 12_582_912.0; // 1.5 * 2^23
    (x + MAGIC) - MAGIC
}

/// The largest integer that is not above `x`, with the bits of [`f32::floor`], which is a call where the instruction set has none.
#[inline(always)]
pub fn floor(x: f32) -> f32 {
    if x.abs() < 4_194_304.0 {
        let nearest = round_small(x);
        // The sign for zeros.
        return (nearest - if nearest > x { 1.0 } else { 0.0 }).copysign(x);
    }
    x.floor()
}

/// Sine and cosine of `2 pi turns`, for |turns| < 2^20; absolute error below 1.2e-7 within one turn.
#[inline(always)]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    let x = turns - round_small(turns);
    let quarter = round_small(x * 4.0);
    let a = (x - quarter * 0.25) * (2.0 * PI);
    let a2 = a * a;
    // Minimax polynomials on [-pi/4, pi/4] (Cephes, Moshier 1992).
    let sin = a + a * a2 * (-1.666_665_5e-1 + a2 * (8.332_161e-3 + a2 * -1.951_529_6e-4));
    let cos = 1.0 - 0.5 * a2 + a2 * a2 * (4.166_664_6e-2 + a2 * (-1.388_731_6e-3 + a2 * 2.443_315_7e-5));
    let [swap, sin_negative, cos_negative] = quadrant(quarter as i32);
    let (sin, cos) = if swap { (cos, sin) } else { (sin, cos) };
    (if sin_negative { -sin } else { sin }, if cos_negative { -cos } else { cos })
}

/// In a quarter turn: whether sine and cosine are swapped, and which of them is negative then.
#[inline(always)]
fn quadrant(quarter: i32) -> [bool; 3] {
    [quarter & 1 != 0, quarter & 2 != 0, (quarter + 1) & 2 != 0]
}

/// Sine and cosine in f64 of an angle in radians, |angle| < 2^20; absolute error below 4e-16 within a few turns. Free of
/// branches.
#[inline(always)]
pub(crate) fn sin_cos_wide(angle: f64) -> (f64, f64) {
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: adding it rounds to an integer
    // Pi/2 in three parts, so that their products with a small integer are exact (Cody and Waite 1980).
    const PARTS: [f64; 3] = [1.570_796_251_296_997, 7.549_789_415_861_596e-8, 5.390_302_858_158_119e-15];
    let shifted = angle * std::f64::consts::FRAC_2_PI + MAGIC;
    let quarter = shifted - MAGIC;
    let a = ((angle - quarter * PARTS[0]) - quarter * PARTS[1]) - quarter * PARTS[2];
    let z = a * a;
    // Minimax polynomials on [-pi/4, pi/4] (Cephes, Moshier 1992).
    let s = 2.755_731_362_138_572_4e-6 + z * (-2.505_074_776_285_780_7e-8 + z * 1.589_623_015_765_465_7e-10);
    let s = -1.666_666_666_666_663e-1 + z * (8.333_333_333_322_118e-3 + z * (-1.984_126_982_958_954e-4 + z * s));
    let c = -2.755_731_417_929_674e-7 + z * (2.087_570_084_197_473e-9 + z * -1.135_853_652_138_768_2e-11);
    let c = 4.166_666_666_666_659_3e-2 + z * (-1.388_888_888_887_305_6e-3 + z * (2.480_158_728_885_171e-5 + z * c));
    let (sin, cos) = (a + a * z * s, 1.0 - 0.5 * z + z * z * c);
    // The last bits of a number that was shifted so are the integer's.
    let [swap, sin_negative, cos_negative] = quadrant(shifted.to_bits() as i32);
    let (sin, cos) = if swap { (cos, sin) } else { (sin, cos) };
    (if sin_negative { -sin } else { sin }, if cos_negative { -cos } else { cos })
}

/// Angle of the point (x, y) in f64 radians, [-pi, pi], for finite coordinates; relative error below 1e-15. (0, 0) gives 0.
/// Free of branches.
#[inline(always)]
pub(crate) fn atan2_wide(y: f64, x: f64) -> f64 {
    const TAN_EIGHTH: f64 = 0.414_213_562_373_095_03; // tan(pi / 8)
    use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    let (ay, ax) = (y.abs(), x.abs());
    let (low, high) = if ay < ax { (ay, ax) } else { (ax, ay) };
    // tan(a - pi/4) = (tan(a) - 1) / (tan(a) + 1).
    let steep = low > TAN_EIGHTH * high;
    let (top, bottom) = if steep { (low - high, low + high) } else { (low, high) };
    let t = if bottom == 0.0 { 0.0 } else { top / bottom };
    let z = t * t;
    // Rational minimax on [-0.66, 0.66] (Cephes, Moshier 1992).
    let p = -75.008_557_923_147_05 + z * (-16.157_537_187_333_65 + z * -0.875_060_860_003_190_4);
    let p = z * (-64.850_219_049_420_25 + z * (-122.886_668_449_013_62 + z * p));
    let q = 165.027_009_831_698_85 + z * (24.858_464_901_423_062 + z);
    let q = 194.550_657_148_261_4 + z * (485.390_399_635_913_7 + z * (432.881_060_491_290_27 + z * q));
    let octant = if steep { FRAC_PI_4 } else { 0.0 } + (t + t * (p / q));
    let quadrant = if ay > ax { FRAC_PI_2 - octant } else { octant };
    let half = if x.is_sign_negative() { PI - quadrant } else { quadrant };
    half.copysign(y)
}

/// e to the `x` in f64, for results in the range of f32: beyond, something larger than its largest number or smaller
/// than its least. Relative error below 1e-11. Free of branches.
#[inline(always)]
pub(crate) fn exp_wide(x: f64) -> f64 {
    const LN_2: f64 = std::f64::consts::LN_2;
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: adding it rounds to an integer
    let x = x.clamp(-120.0, 120.0);
    let shifted = x * std::f64::consts::LOG2_E + MAGIC;
    let r = x - (shifted - MAGIC) * LN_2;
    // Taylor's series to degree 10, |r| <= ln(2) / 2.
    let tail = 1.0 / 5040.0 + r * (1.0 / 40_320.0 + r * (1.0 / 362_880.0 + r * (1.0 / 3_628_800.0)));
    let p = 1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * tail)));
    // The last bits of a number that was shifted so are the integer's.
    let power = f64::from_bits(shifted.to_bits().wrapping_add(1023) << 52);
    (1.0 + r * (1.0 + r * (0.5 + r * p))) * power
}

/// e to the `x` within [-60, 60], and beyond as at these ends. Relative error below 3e-7. Free of branches.
#[inline(always)]
pub(crate) fn exp_short(x: f32) -> f32 {
    const MAGIC: f32 = 12_582_912.0; // 1.5 * 2^23: adding it rounds to an integer
    // ln(2) in two parts, of which the first times a small integer is exact.
    const LN_2: [f32; 2] = [0.693_359_4, -2.121_944_4e-4];
    let x = x.clamp(-60.0, 60.0);
    let shifted = x * std::f32::consts::LOG2_E + MAGIC;
    let whole = shifted - MAGIC;
    let r = (x - whole * LN_2[0]) - whole * LN_2[1];
    // Taylor's series to degree 7, |r| <= ln(2) / 2.
    let tail = 1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0)));
    let p = 1.0 + r * (1.0 + r * (0.5 + r * (1.0 / 6.0 + r * tail)));
    // The last bits of a number that was shifted so are the integer's.
    p * f32::from_bits(shifted.to_bits().wrapping_add(127) << 23)
}

/// Natural logarithm in f64 of a normal positive number; relative error below 1e-11. Infinity gives a finite number. Free of
/// branches.
#[inline(always)]
fn ln_normal(x: f64) -> f64 {
    // x = m 2^k with m in [sqrt(1/2), sqrt(2)).
    const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    const BIAS: u64 = 1023;
    let shifted = x.to_bits().wrapping_sub(SQRT_HALF).wrapping_add(BIAS << 52);
    let m = f64::from_bits((shifted & 0x000f_ffff_ffff_ffff).wrapping_add(SQRT_HALF));
    // An integer in the last bits of 2^52.
    const EXPONENT: u64 = (52 + BIAS) << 52;
    let k = f64::from_bits(EXPONENT | (shifted >> 52)) - (4_503_599_627_370_496.0 + BIAS as f64);
    // ln(m) = 2 atanh(s), by its series to s^17, |s| < 0.172.
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let tail = 1.0 / 11.0 + s2 * (1.0 / 13.0 + s2 * (1.0 / 15.0 + s2 * (1.0 / 17.0)));
    let p = 1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 * (1.0 / 7.0 + s2 * (1.0 / 9.0 + s2 * tail)));
    2.0 * s + 2.0 * s * s2 * p + k * std::f64::consts::LN_2
}

/// Natural logarithm in f64 of an f32: minus infinity at 0, NaN below. Free of branches.
#[inline(always)]
pub(crate) fn ln_wide(x: f32) -> f64 {
    let finite = ln_normal(f64::from(x));
    let above = if x < f32::INFINITY { finite } else { f64::INFINITY };
    let rest = if x == 0.0 { f64::NEG_INFINITY } else { f64::NAN };
    if x > 0.0 { above } else { rest }
}

/// e to the `x`; error at most 0.51 units in the last place.
#[inline]
pub fn exp(x: f32) -> f32 {
    exp_wide(f64::from(x)) as f32
}

/// 2 to the `x`; error at most 0.51 units in the last place, exact for whole x.
#[inline]
pub fn exp2(x: f32) -> f32 {
    exp_wide(f64::from(x) * std::f64::consts::LN_2) as f32
}

/// Natural logarithm; error at most 0.51 units in the last place. Minus infinity at 0, NaN below.
#[inline]
pub fn ln(x: f32) -> f32 {
    ln_wide(x) as f32
}

/// `base` to the `exponent`, for base >= 0 (NaN below); error at most 0.51 units in the last place. Anything to the 0 is 1.
#[inline]
pub fn pow(base: f32, exponent: f32) -> f32 {
    if exponent == 0.0 { 1.0 } else { exp_wide(ln_wide(base) * f64::from(exponent)) as f32 }
}

/// asin on [0, 1/2], and with it the rest (Cephes, Moshier 1992).
#[inline]
fn asin_half(x: f32) -> f32 {
    let z = x * x;
    let p = 4.547_002_6e-2 + z * (2.418_131e-2 + z * 4.216_32e-2);
    x + x * z * (1.666_675_2e-1 + z * (7.495_300_3e-2 + z * p))
}

/// Arc cosine in radians, [0, pi]; absolute error below 3.2e-7, relative error below 4e-7 towards 1. NaN outside of [-1, 1].
#[inline]
pub fn acos(x: f32) -> f32 {
    let a = x.abs();
    // The half-angle formula keeps the precision near 1, where 1 - a is exact.
    let near_one = 2.0 * asin_half((0.5 * (1.0 - a)).sqrt());
    let near_zero = 0.5 * PI - asin_half(a);
    let positive = if a > 0.5 { near_one } else { near_zero };
    if x < 0.0 { PI - positive } else { positive }
}

/// Arc sine in radians, [-pi/2, pi/2]; relative error below 4e-7. NaN outside of [-1, 1].
#[inline]
pub fn asin(x: f32) -> f32 {
    let a = x.abs();
    let near_one = 0.5 * PI - 2.0 * asin_half((0.5 * (1.0 - a)).sqrt());
    let positive = if a > 0.5 { near_one } else { asin_half(a) };
    positive.copysign(x)
}

/// Angle of the point (x, y) in radians, [-pi, pi], for finite coordinates; absolute error below 4e-7. Zeros as in IEEE
/// 754: (0, 0) gives 0, (-0, 0) pi, with the sign of y.
#[inline]
pub fn atan2(y: f32, x: f32) -> f32 {
    const TAN_EIGHTH: f32 = 0.414_213_57; // tan(pi / 8)
    let (ay, ax) = (y.abs(), x.abs());
    // Halving keeps the sum below finite.
    let (low, high) = (0.5 * ay.min(ax), 0.5 * ay.max(ax));
    // tan(a - pi/4) = (tan(a) - 1) / (tan(a) + 1).
    let steep = low > TAN_EIGHTH * high;
    let (top, bottom) = if steep { (low - high, low + high) } else { (low, high) };
    let t = if bottom > 0.0 { top / bottom } else { 0.0 };
    let z = t * t;
    // Minimax polynomial on [-tan(pi/8), tan(pi/8)] (Cephes, Moshier 1992).
    let p = -3.333_295e-1 + z * (1.997_771_1e-1 + z * (-1.387_768_6e-1 + z * 8.053_744_6e-2));
    let octant = if steep { 0.25 * PI } else { 0.0 } + (t + t * z * p);
    let quadrant = if ay > ax { 0.5 * PI - octant } else { octant };
    let half = if x.is_sign_negative() { PI - quadrant } else { quadrant };
    half.copysign(y)
}

#[cfg(test)]
#[expect(clippy::disallowed_methods, reason = "the platform's functions are the reference")]
mod tests {
    use super::*;

    #[test]
    fn sines_and_cosines_in_f64() {
        for i in -200_000..=200_000 {
            let angle = f64::from(i) * 1e-4 + f64::from(i % 7) * 1e-9;
            let (sin, cos) = sin_cos_wide(angle);
            assert!((sin - angle.sin()).abs() < 4e-16 && (cos - angle.cos()).abs() < 4e-16, "{angle}: {sin} {cos}");
        }
        for tiny in [1e-300, 1e-20, 1e-9] {
            assert_eq!(sin_cos_wide(tiny), (tiny, 1.0));
        }
    }

    #[test]
    fn short_powers_of_e() {
        for i in -620_000..=620_000 {
            let x = i as f32 * 1e-4;
            let (found, exact) = (f64::from(exp_short(x)), f64::from(x.clamp(-60.0, 60.0)).exp());
            assert!((found / exact - 1.0).abs() < 3e-7, "{x}: {found} for {exact}");
        }
        assert_eq!(exp_short(0.0), 1.0);
        assert_eq!([exp_short(f32::NEG_INFINITY), exp_short(1e30)], [exp_short(-60.0), exp_short(60.0)]);
    }

    #[test]
    fn arc_tangents_in_f64() {
        for i in 0..400_000 {
            let angle = (f64::from(i) + 0.37) * (std::f64::consts::PI / 200_000.0) - std::f64::consts::PI;
            let length = [1.0, 1e-150, 3e120, 1e-9][i as usize % 4];
            let (y, x) = (angle.sin() * length, angle.cos() * length);
            let (found, exact) = (atan2_wide(y, x), y.atan2(x));
            assert!((found - exact).abs() <= 1e-15 * exact.abs(), "{angle}: {found} for {exact}");
        }
        for (y, x) in [(0.0, 1.0), (0.0, 0.0), (-0.0, 1.0), (0.0, -1.0), (1.0, 0.0), (-2.0, -0.0), (1e-300, 1.0)] {
            assert_eq!(atan2_wide(y, x).to_bits(), f64::atan2(y, x).to_bits(), "{y} {x}");
        }
        assert!(atan2_wide(f64::NAN, 1.0).is_nan() && atan2_wide(1.0, f64::NAN).is_nan());
    }
}
