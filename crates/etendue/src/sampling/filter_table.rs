//! Filters with negative lobes, as tables: drawn in proportion to their magnitude, weighted with their sign.

use super::distribution::Distribution1D;

/// Intervals of a table: a multiple of 2, 4, 6 and 8, so that lobes of a usual number of pixels end where intervals do.
const INTERVALS: usize = 768;

/// A one-dimensional filter on [-radius, radius] whose magnitude is linear on equal intervals, with one sign on each.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct FilterTable {
    choice: Distribution1D,
    intervals: Box<[Interval]>,
    low: f32,
    width: f32,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Interval {
    /// Magnitude at both ends.
    ends: [f32; 2],
    /// Share of the filter's integral over the probability that the interval is drawn with.
    weight: f32,
}

impl FilterTable {
    /// Tabulates `kernel`; `None` if it is not finite or has no integral above 0.
    pub fn new(radius: f64, kernel: &dyn Fn(f64) -> f64) -> Option<Self> {
        let width = 2.0 * radius / INTERVALS as f64;
        // Symmetric to the bit.
        let at = |node: usize| kernel((node as f64 - 0.5 * INTERVALS as f64).abs() * width);
        let middle = |interval: usize| kernel((interval as f64 + 0.5 - 0.5 * INTERVALS as f64).abs() * width);
        let ends: Vec<[f32; 2]> = (0..INTERVALS).map(|i| [i, i + 1].map(|node| at(node).abs() as f32)).collect();
        let masses: Vec<f64> = ends.iter().map(|[a, b]| f64::from(*a) + f64::from(*b)).collect();
        let choice = Distribution1D::new(&masses).ok().filter(|c| !c.is_empty())?;
        let signed = |interval: usize| masses[interval].copysign(middle(interval));
        let integral: f64 = (0..INTERVALS).map(signed).sum();
        if !(integral > 0.0 && (2.0 * radius).is_finite()) {
            return None;
        }
        let weight = |interval: usize| match choice.probability(interval) {
            0.0 => 0.0,
            p => (signed(interval) / integral / f64::from(p)) as f32,
        };
        let intervals = ends.iter().enumerate().map(|(i, ends)| Interval { ends: *ends, weight: weight(i) }).collect();
        Some(Self { choice, intervals, low: -radius as f32, width: width as f32 })
    }

    /// A place for `u` in [0, 1), and its weight.
    #[inline]
    pub fn sample(&self, u: f32) -> (f32, f32) {
        let Some(choice) = self.choice.choose(u) else { return (0.0, 0.0) };
        let Interval { ends: [a, b], weight } = self.intervals[choice.index];
        // The middle of what the numbers that are left stand for; the probability tells how many there are.
        let v = choice.remapped + 0.5 / (choice.probability * 16_777_216.0);
        // The inverse of the integral of the linear magnitude, without cancellation.
        let x = v * (a + b) / (a + (a * a + v * (b * b - a * a)).max(0.0).sqrt()).max(f32::MIN_POSITIVE);
        (self.low + (choice.index as f32 + x.min(1.0)) * self.width, weight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Where a filter is linear between nodes, places follow it exactly: here it rises in the two outermost intervals alone.
    #[test]
    fn places_follow_the_slope_inside_of_an_interval() {
        let width = 2.0 / INTERVALS as f64;
        let table = FilterTable::new(1.0, &|x| (x - (1.0 - width)).max(0.0)).expect("an integral");
        for i in 1..1000u32 {
            let u = (i as f32 + 0.5) / 2000.0;
            let (x, weight) = table.sample(0.5 + u);
            let inside = (f64::from(x) - (1.0 - width)) / width;
            let expected = (2.0 * f64::from(u)).sqrt();
            assert!((inside - expected).abs() < 1e-3, "{u}: {inside}, not {expected}");
            assert!((weight - 1.0).abs() < 1e-4, "{weight}");
            let (mirrored, _) = table.sample(0.5 - u);
            assert!((mirrored + x).abs() < 1e-6, "{mirrored} {x}");
        }
    }

    #[test]
    fn filters_without_a_positive_integral_are_refused() {
        let refused = |kernel: &dyn Fn(f64) -> f64| FilterTable::new(1.0, kernel).is_none();
        assert!(refused(&|_| 0.0) && refused(&|_| -1.0) && refused(&|_| f64::NAN) && refused(&|x| x - 2.0));
        assert!(FilterTable::new(f64::INFINITY, &|_| 1.0).is_none());
    }
}
