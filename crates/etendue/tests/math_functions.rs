//! Own transcendental functions against f64.
#![allow(clippy::disallowed_methods)]

use etendue::math::{acos, asin, atan2, exp, exp2, floor, ln, pow, sin_cos_turns};

/// Error of `value` in units of the last place of an f32 near `exact`.
fn ulps(value: f32, exact: f64) -> f64 {
    let rounded = exact as f32;
    if value == rounded {
        return 0.5;
    }
    if rounded.is_infinite() || value.is_nan() {
        return f64::INFINITY;
    }
    let unit = f64::from(f32::from_bits(rounded.abs().to_bits() + 1)) - f64::from(rounded.abs());
    (f64::from(value) - exact).abs() / unit
}

/// About `count` floats that are spread over the bit patterns from `low` to `high`, both positive.
fn floats(low: f32, high: f32, count: i32) -> impl Iterator<Item = f32> {
    let (a, b) = (low.to_bits(), high.to_bits());
    (a..=b).step_by(((b - a) / count as u32) as usize | 1).chain([b]).map(f32::from_bits)
}

fn worst<T: Copy>(inputs: impl Iterator<Item = T>, error: impl Fn(T) -> f64) -> f64 {
    inputs.map(error).fold(0.0, |a, b| if b.is_nan() { f64::INFINITY } else { a.max(b) })
}

const COUNT: i32 = 1_000_000;

#[test]
fn exponentials_and_logarithms() {
    let both = |low, high| floats(low, high, COUNT).flat_map(|x| [x, -x]);
    assert!(worst(both(1e-20, 110.0), |x| ulps(exp(x), f64::from(x).exp())) <= 0.51);
    assert!(worst(both(1e-20, 155.0), |x| ulps(exp2(x), f64::from(x).exp2())) <= 0.51);
    // Subnormals included.
    assert!(worst(floats(1e-45, f32::MAX, COUNT), |x| ulps(ln(x), f64::from(x).ln())) <= 0.51);
    for k in -149..128 {
        assert_eq!(f64::from(exp2(k as f32)), 2f64.powi(k));
    }
}

#[test]
fn powers() {
    for exponent in [0.5, 1.0 / 2.4, 2.4, 1.0, -1.0, 3.0, 17.3, 1e-3, -0.1, 1000.0] {
        let error = worst(floats(1e-45, f32::MAX, COUNT / 4), |x| {
            ulps(pow(x, exponent), f64::from(x).powf(f64::from(exponent)))
        });
        assert!(error <= 0.51, "{exponent}: {error}");
    }
}

#[test]
fn special_values() {
    let inf = f32::INFINITY;
    assert_eq!([exp(0.0), exp(-inf), exp(inf), exp2(0.0)], [1.0, 0.0, inf, 1.0]);
    assert_eq!([ln(1.0), ln(0.0), ln(inf)], [0.0, -inf, inf]);
    assert!(ln(-1.0).is_nan() && ln(f32::NAN).is_nan() && exp(f32::NAN).is_nan() && pow(-2.0, 2.0).is_nan());
    assert_eq!([pow(0.0, 2.0), pow(0.0, 0.0), pow(0.0, -1.0), pow(5.0, 0.0)], [0.0, 1.0, inf, 1.0]);
    assert_eq!([pow(1.0, 1e30), pow(2.0, 1e30), pow(0.5, 1e30), pow(inf, -1.0)], [1.0, inf, 0.0, 0.0]);
    assert_eq!([acos(1.0), asin(0.0), asin(-0.0)], [0.0, 0.0, -0.0]);
    assert!(acos(1.000_001).is_nan() && asin(-2.0).is_nan() && acos(f32::NAN).is_nan());
    for (y, x) in [(0.0, 0.0), (0.0, -0.0), (-0.0, -0.0), (0.0, -1.0), (-0.0, 1.0), (2.0, 0.0), (-3.0, -0.0)] {
        let (own, std) = (atan2(y, x), f32::atan2(y, x));
        assert!((own - std).abs() < 1e-6 && own.is_sign_positive() == std.is_sign_positive(), "{y} {x}: {own} {std}");
    }
    assert!((atan2(f32::MAX, f32::MAX) - std::f32::consts::FRAC_PI_4).abs() < 1e-6);
    assert!((atan2(1e-44, 1e-44) - std::f32::consts::FRAC_PI_4).abs() < 1e-6);
}

#[test]
fn inverse_circular() {
    let both = || floats(1e-10, 1.0, COUNT).flat_map(|x| [x, -x]);
    let acos_error = worst(both(), |x| (f64::from(acos(x)) - f64::from(x).acos()).abs());
    assert!(acos_error < 3.2e-7, "{acos_error}");
    // Towards 1, where the angle goes to 0.
    let near = worst(floats(0.5, 1.0 - 1e-7, COUNT), |x| {
        let exact = f64::from(x).acos();
        ((f64::from(acos(x)) - exact) / exact).abs()
    });
    assert!(near < 4e-7, "{near}");
    let asin_error = worst(both(), |x| {
        let exact = f64::from(x).asin();
        ((f64::from(asin(x)) - exact) / exact).abs()
    });
    assert!(asin_error < 4e-7, "{asin_error}");
    let angles = (0..COUNT).map(|i| f64::from(i) / f64::from(COUNT) * std::f64::consts::TAU);
    let atan_error = worst(angles, |a| {
        let scale = 10f64.powf((a * 1e4).sin() * 30.0);
        let (y, x) = ((a.sin() * scale) as f32, (a.cos() * scale) as f32);
        (f64::from(atan2(y, x)) - f64::from(y).atan2(f64::from(x))).abs()
    });
    assert!(atan_error < 4e-7, "{atan_error}");
}

#[test]
fn turns() {
    let error = worst((-1000..=COUNT).map(|i| f64::from(i) / f64::from(COUNT)), |t| {
        let t = t as f32;
        let (sin, cos) = sin_cos_turns(t);
        let (s, c) = (f64::from(t) * std::f64::consts::TAU).sin_cos();
        (f64::from(sin) - s).abs().max((f64::from(cos) - c).abs())
    });
    assert!(error < 1.2e-7, "{error}");
    for (quarter, exact) in [(0.0, (0.0, 1.0)), (0.25, (1.0, 0.0)), (0.5, (0.0, -1.0)), (0.75, (-1.0, 0.0))] {
        assert_eq!(sin_cos_turns(quarter), exact);
        assert_eq!(sin_cos_turns(quarter + 1024.0), exact);
    }
}

/// Bits, so that the sign of zeros counts too.
#[test]
fn floors_have_the_bits_of_the_platform() {
    let near_integers = (-1000..1000).map(|i| i as f32).flat_map(|x| [x.next_down(), x, x.next_up(), x + 0.5]);
    // Where halves and then fractions end.
    let ends = (20..25).map(|bits| (1 << bits) as f32).flat_map(|x| [x - 0.5, x.next_down(), x, x.next_up(), x + 0.5]);
    let large = floats(1e-45, f32::INFINITY, COUNT);
    for x in near_integers.chain(ends).chain(large).flat_map(|x| [x, -x]) {
        assert_eq!(floor(x).to_bits(), x.floor().to_bits(), "{x}");
    }
    assert!(floor(f32::NAN).is_nan());
}
