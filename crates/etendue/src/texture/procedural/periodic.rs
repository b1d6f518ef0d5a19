//! Means of periodic functions over intervals, in closed form.

/// Narrower intervals count as points: differences of integrals would lose their digits.
const NARROW: f32 = 1e-4;

/// The mean of a function of period 1 over an interval of `width` about `x`. `value` is the function on [0, 1), `integral`
/// its integral from 0 on [0, 1].
#[inline]
pub(super) fn mean(x: f32, width: f32, value: impl Fn(f32) -> f32, integral: impl Fn(f32) -> f32) -> f32 {
    let x = x - x.floor();
    if width.is_nan() || width <= NARROW {
        return value(x);
    }
    let period = integral(1.0);
    let up_to = |x: f32| {
        let whole = x.floor();
        whole * period + integral(x - whole)
    };
    let mean = (up_to(x + 0.5 * width) - up_to(x - 0.5 * width)) / width;
    // Over a great many periods the sums have no digits left for the rest.
    if mean.is_finite() && width < 1e4 { mean } else { period }
}
