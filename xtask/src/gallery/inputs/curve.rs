//! Smooth curves through given points (Catmull and Rom, "A class of local interpolating splines", 1974).

use glam::DVec2;

/// Points from each of four neighbours' middle pair to the next.
const STEPS: u32 = 8;

/// An open curve from the first point to the last.
pub fn through(points: &[DVec2]) -> Vec<DVec2> {
    let last = points.len() as isize - 1;
    let mut curve = vec![points[0]];
    curve.extend((0..last).flat_map(|i| piece([-1, 0, 1, 2].map(|k| points[(i + k).clamp(0, last) as usize]))));
    curve
}

/// A closed curve; its first point is not repeated.
pub fn closed(points: &[DVec2]) -> Vec<DVec2> {
    let count = points.len() as isize;
    (0..count).flat_map(|i| piece([-1, 0, 1, 2].map(|k| points[(i + k).rem_euclid(count) as usize]))).collect()
}

/// Points after `b` up to `c`.
fn piece([a, b, c, d]: [DVec2; 4]) -> impl Iterator<Item = DVec2> {
    (1..=STEPS).map(move |step| {
        let t = f64::from(step) / f64::from(STEPS);
        let p =
            2.0 * b + (c - a) * t + (2.0 * a - 5.0 * b + 4.0 * c - d) * (t * t) + (3.0 * (b - c) + d - a) * (t * t * t);
        0.5 * p
    })
}
