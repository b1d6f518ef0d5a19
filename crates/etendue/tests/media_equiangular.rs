//! Equiangular distances: drawn as their density says, wherever the point is that they are about.
#![allow(clippy::disallowed_methods)]

use etendue::{
    math::{Vec3, vec3},
    medium::{Equiangular, Segment},
};
use etendue_testkit::{Rng, chi2::ChiSquare, integrate_1d};

fn along_x(length: f32) -> Segment {
    Segment { origin: Vec3::ZERO, direction: Vec3::X, length }
}

/// Segments of 1 m and points about them: beside, before, behind, near the line, on it, far away.
const ANCHORS: [[f32; 3]; 8] = [
    [0.5, 0.3, 0.0],
    [0.3, 0.0, 0.01],
    [-0.2, 0.1, 0.1],
    [1.4, -0.3, 0.2],
    [0.7, 1e-3, 0.0],
    [2.0, 0.0, 0.0],
    [-1.0, 1e-5, 0.0],
    [30.0, 40.0, -50.0],
];

#[test]
fn distances_are_drawn_as_their_density_says() {
    for (length, stretch) in [(1.0, 1.0), (2e4, 2e4), (3e-3, 3e-3)] {
        for anchor in ANCHORS {
            let drawn = Equiangular::new(&along_x(length), Vec3::from(anchor) * stretch).expect("a usable anchor");
            let scale = f64::from(length);
            let chi2 = ChiSquare::new(100_000).interval(
                [0.0, 1.0],
                |rng: &mut Rng| drawn.sample(rng.f32()).map(|t| f64::from(t) / scale),
                |x| f64::from(drawn.pdf((x * scale) as f32)) * scale,
            );
            chi2.assert(0.01, 3 * ANCHORS.len(), &format!("length {length}, anchor {anchor:?}"));
        }
    }
}

/// Without an end, t = (1 + x) / (1 - x) - 1 maps [0, 1) to all distances.
#[test]
fn so_are_those_without_an_end() {
    for anchor in ANCHORS {
        if anchor == [2.0, 0.0, 0.0] {
            // On the way: all distances are within a millionth of one, which the histogram cannot resolve.
            continue;
        }
        let drawn = Equiangular::new(&along_x(f32::INFINITY), Vec3::from(anchor)).expect("a usable anchor");
        let chi2 = ChiSquare::new(100_000).interval(
            [0.0, 1.0],
            |rng: &mut Rng| drawn.sample(rng.f32()).map(|t| f64::from(t) / (f64::from(t) + 2.0)),
            |x| f64::from(drawn.pdf((2.0 * x / (1.0 - x)) as f32)) * 2.0 / ((1.0 - x) * (1.0 - x)),
        );
        chi2.assert(0.01, ANCHORS.len(), &format!("anchor {anchor:?}"));
    }
}

/// What is drawn is at the angle it should be, to single precision, however far away the point and the end.
#[test]
fn distances_keep_their_digits() {
    for (anchor, length) in [([1e4, 1.0, 0.0], 2e4), ([1e6, 1e3, 0.0], f32::INFINITY), ([-1e4, 10.0, 0.0], 1.0)] {
        let drawn = Equiangular::new(&along_x(length), vec3(anchor[0], anchor[1], anchor[2])).expect("usable");
        let (along, off) = (f64::from(anchor[0]), f64::from(anchor[1]));
        let angle = |t: f64| ((t - along) / off).atan();
        for i in 0..100 {
            let u = i as f32 / 100.0;
            let t = f64::from(drawn.sample(u).expect("finite"));
            let end = if length.is_finite() { angle(f64::from(length)) } else { std::f64::consts::FRAC_PI_2 };
            let expected = angle(0.0) + f64::from(u) * (end - angle(0.0));
            let exact = along + off * expected.tan();
            assert!((t - exact).abs() <= 1e-6 * (exact.abs() + along.abs()), "{anchor:?} at {u}: {t}, not {exact}");
            let density = off / ((end - angle(0.0)) * (off * off + (t - along).powi(2)));
            assert!((f64::from(drawn.pdf(t as f32)) / density - 1.0).abs() < 1e-4, "{anchor:?} at {u}: density");
        }
    }
}

#[test]
fn the_nearest_point_of_a_segment_is_found() {
    for (anchor, nearest) in [([0.5, 0.3, 0.4], 0.5), ([-3.0, 4.0, 0.0], 5.0), ([4.0, 0.0, 4.0], 5.0)] {
        let drawn = Equiangular::new(&along_x(1.0), Vec3::from(anchor)).expect("usable");
        assert!((drawn.nearest() - nearest).abs() < 1e-6, "{anchor:?}: {}", drawn.nearest());
    }
}

#[test]
fn what_has_no_angle_is_refused() {
    assert_eq!(Equiangular::new(&along_x(0.0), Vec3::Y), None);
    assert_eq!(Equiangular::new(&along_x(1.0), Vec3::ZERO), None);
    assert_eq!(Equiangular::new(&along_x(1.0), Vec3::NAN), None);
    assert_eq!(Equiangular::new(&along_x(f32::NAN), Vec3::Y), None);
    let whole = Equiangular::new(&along_x(1.0), vec3(0.5, 0.2, 0.0)).expect("usable");
    let sum = integrate_1d(|t| f64::from(whole.pdf(t as f32)), [0.0, 1.0], 64, 1e-9);
    assert!((sum - 1.0).abs() < 1e-5, "the density integrates to {sum}");
}
