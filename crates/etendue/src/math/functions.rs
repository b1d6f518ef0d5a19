//! Transcendental functions as own polynomials: the platform's differ between machines.
//!
//! Exponentials and logarithms work in f64 inside, so their f32 results are off by little more than the final rounding.

/// Pi.
pub const PI: f32 = std::f32::consts::PI;

/// Rounds to the nearest integer, ties to even, for |x| < 2^22.
#[inline]
fn round_small(x: f32) -> f32 {
    const MAGIC: f32 = 12_582_912.0; // 1.5 * 2^23
    (x + MAGIC) - MAGIC
}

/// Sine and cosine of `2 pi turns`, for |turns| < 2^20; absolute error below 1.2e-7 within one turn.
#[inline]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    let x = turns - round_small(turns);
    let quarter = round_small(x * 4.0);
    let a = (x - quarter * 0.25) * (2.0 * PI);
    let a2 = a * a;
    // Minimax polynomials on [-pi/4, pi/4] (Cephes, Moshier 1992).
    let sin = a + a * a2 * (-1.666_665_5e-1 + a2 * (8.332_161e-3 + a2 * -1.951_529_6e-4));
    let cos = 1.0 - 0.5 * a2 + a2 * a2 * (4.166_664_6e-2 + a2 * (-1.388_731_6e-3 + a2 * 2.443_315_7e-5));
    match quarter as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}

/// e to the `x` in f64, for results in the range of f32: beyond, something larger than its largest number or smaller
/// than its least. Relative error below 1e-11.
#[inline]
pub(crate) fn exp_wide(x: f64) -> f64 {
    const LN_2: f64 = std::f64::consts::LN_2;
    const MAGIC: f64 = 6_755_399_441_055_744.0; // 1.5 * 2^52: adding it rounds to an integer
    let x = x.clamp(-120.0, 120.0);
    let k = (x * std::f64::consts::LOG2_E + MAGIC) - MAGIC;
    let r = x - k * LN_2;
    // Taylor's series to degree 10, |r| <= ln(2) / 2.
    let tail = 1.0 / 5040.0 + r * (1.0 / 40_320.0 + r * (1.0 / 362_880.0 + r * (1.0 / 3_628_800.0)));
    let p = 1.0 / 6.0 + r * (1.0 / 24.0 + r * (1.0 / 120.0 + r * (1.0 / 720.0 + r * tail)));
    let power = f64::from_bits(((k as i64 + 1023) as u64) << 52);
    (1.0 + r * (1.0 + r * (0.5 + r * p))) * power
}

/// Natural logarithm in f64 of a normal positive number; relative error below 1e-11. Infinity gives a finite number.
#[inline]
fn ln_normal(x: f64) -> f64 {
    // x = m 2^k with m in [sqrt(1/2), sqrt(2)).
    const SQRT_HALF: u64 = 0x3fe6_a09e_667f_3bcd;
    let shifted = x.to_bits().wrapping_sub(SQRT_HALF) as i64;
    let k = shifted >> 52;
    let m = f64::from_bits((shifted & 0x000f_ffff_ffff_ffff) as u64 + SQRT_HALF);
    // ln(m) = 2 atanh(s), by its series to s^17, |s| < 0.172.
    let s = (m - 1.0) / (m + 1.0);
    let s2 = s * s;
    let tail = 1.0 / 11.0 + s2 * (1.0 / 13.0 + s2 * (1.0 / 15.0 + s2 * (1.0 / 17.0)));
    let p = 1.0 / 3.0 + s2 * (1.0 / 5.0 + s2 * (1.0 / 7.0 + s2 * (1.0 / 9.0 + s2 * tail)));
    2.0 * s + 2.0 * s * s2 * p + k as f64 * std::f64::consts::LN_2
}

/// Natural logarithm in f64 of an f32: minus infinity at 0, NaN below.
#[inline]
pub(crate) fn ln_wide(x: f32) -> f64 {
    let finite = ln_normal(f64::from(x));
    match x {
        _ if x > 0.0 && x < f32::INFINITY => finite,
        0.0 => f64::NEG_INFINITY,
        _ if x > 0.0 => f64::INFINITY,
        _ => f64::NAN,
    }
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
