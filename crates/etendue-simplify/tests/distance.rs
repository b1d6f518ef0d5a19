//! Measured distances against known ones.
#![allow(clippy::disallowed_methods)]

mod shapes;

use std::ops::ControlFlow;

use etendue_simplify::{Mesh, Options, SimplifyError, Target, distance, simplify};
use shapes::*;

#[test]
fn concentric_spheres_are_the_difference_of_radii_apart() {
    let (inner, outer) = (ball(120, |_| 1.0), ball(120, |_| 1.25));
    let found = measured(&inner, &outer, 20_000);
    // Faces sag by at most some 1e-4 of the radius.
    for way in [found.forth, found.back] {
        assert!((way.rms - 0.25).abs() < 2e-4 && (way.mean - 0.25).abs() < 2e-4, "{way:?}");
        assert!((way.largest - 0.25).abs() < 4e-4, "{way:?}");
    }
    assert!((found.diagonal - 12f64.sqrt()).abs() < 1e-6);
}

#[test]
fn a_slope_against_its_base() {
    // The height over the unit square runs from 0 to 0.1, and the way back is shorter by the cosine of the slope.
    let (flat, slope) = (grid(7, |_, _| 0.0), grid(3, |x, _| 0.1 * x));
    let found = measured(&slope, &flat, 40_000);
    assert!((found.forth.mean - 0.05).abs() < 2e-5, "{found:?}");
    assert!((found.forth.rms - 0.1 / 3f64.sqrt()).abs() < 2e-5, "{found:?}");
    assert!((found.forth.largest - 0.1).abs() < 1e-7 && (found.forth.farthest[0] - 1.0).abs() < 1e-6);
    let cosine = 1.0 / 1.01f64.sqrt();
    assert!(found.back.largest < 0.1 && found.back.largest >= 0.1 * cosine - 1e-7, "{found:?}");
    assert!(found.rms() == found.forth.rms && found.largest() == found.forth.largest);
}

#[test]
fn both_ways_count() {
    // A small square in a large one: nothing from the small one, much from the large one.
    let (large, small) = (grid(4, |_, _| 0.0), moved(&grid(2, |_, _| 0.0), |[x, y, z]| [0.5 * x, 0.5 * y, z]));
    let found = measured(&small, &large, 1000);
    assert!(found.forth.largest < 1e-15);
    assert!((found.back.largest - 0.5f64.sqrt()).abs() < 1e-7 && found.back.rms > 0.2);
}

#[test]
fn a_mesh_is_where_it_is_however_it_is_cut() {
    let (coarse, fine) = (grid(1, |_, _| 0.0), grid(30, |_, _| 0.0));
    assert!(measured(&coarse, &fine, 5000).largest() < 1e-7);
    let ball = ball(20, bumpy);
    assert!(measured(&ball, &ball, 5000).largest() < 1e-12);
}

#[test]
fn threads_leave_no_trace_and_seeds_do() {
    let (a, b) = (ball(40, |_| 1.0), ball(30, bumpy));
    let with = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| measured(&a, &b, 70_000))
    };
    let one = with(1);
    assert!(one == with(2) && one == with(5));
    let other = distance(&a.as_ref(), &b.as_ref(), 70_000, 8, &mut carry_on).unwrap();
    assert!(other.forth.rms != one.forth.rms && (other.forth.rms / one.forth.rms - 1.0).abs() < 0.01);
}

#[test]
fn what_cannot_be_measured_is_an_error() {
    let (square, empty) = (grid(1, |_, _| 0.0), Mesh::default());
    let nan = mesh_of(vec![[f32::NAN; 3]; 3], vec![[0, 1, 2]]);
    for bad in [&empty, &nan] {
        let result = distance(&square.as_ref(), &bad.as_ref(), 10, 0, &mut carry_on);
        assert_eq!(result, Err(SimplifyError::NoSurface));
    }
    let bad = mesh_of(square.positions.clone(), vec![[0, 1, 2], [0, 9, 1]]);
    let result = distance(&square.as_ref(), &bad.as_ref(), 10, 0, &mut carry_on);
    assert_eq!(result, Err(SimplifyError::BadIndex { face: 1, vertex: 9, vertices: 4 }));
    let result = distance(&square.as_ref(), &square.as_ref(), 10, 0, &mut |_| ControlFlow::Break(()));
    assert_eq!(result, Err(SimplifyError::Interrupted));
}

#[test]
fn faces_out_of_reach_are_left_out() {
    let square = grid(2, |_, _| 0.5);
    let mut marred = grid(2, |_, _| 0.0);
    marred.positions.extend([[f32::INFINITY, 0.0, 0.0], [0.0, f32::NAN, 5.0], [0.0, 0.0, 7.0]]);
    marred.faces.insert(0, [9, 0, 1]);
    marred.faces.push([3, 10, 4]);
    let found = measured(&square, &marred, 500);
    assert!((found.rms() - 0.5).abs() < 1e-7 && (found.largest() - 0.5).abs() < 1e-7);
    let needle = mesh_of(vec![[0.0; 3], [1.0, 0.0, 0.0]], vec![[0, 1, 1]]);
    assert!((measured(&needle, &square, 500).forth.rms - 0.5).abs() < 1e-7);
}

#[test]
fn any_size() {
    let (a, b) = (ball(30, |_| 1.0), ball(20, bumpy));
    let usual = measured(&a, &b, 5000);
    for exponent in [-100, -40, 45, 100] {
        let size = libm::exp2(f64::from(exponent));
        let sized = |mesh: &Mesh| moved(mesh, |p| p.map(|x| (f64::from(x) * size) as f32));
        let found = measured(&sized(&a), &sized(&b), 5000);
        for (found, usual) in [
            (found.diagonal, usual.diagonal),
            (found.forth.rms, usual.forth.rms),
            (found.forth.farthest[2], usual.forth.farthest[2]),
            (found.back.mean, usual.back.mean),
            (found.back.largest, usual.back.largest),
        ] {
            assert!((found / (usual * size) - 1.0).abs() < 1e-6, "2^{exponent}: {} {usual}", found / size);
        }
    }
}

/// A face with two corners at one place is a line that sticks out, and is left out of what is simplified.
#[test]
fn a_line_that_sticks_out_is_no_surface() {
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [9.0, 0.0, 5.0]];
    let plain = mesh_of(square[..4].to_vec(), vec![[0, 1, 2], [0, 2, 3]]);
    let spiked = mesh_of(square.to_vec(), vec![[0, 1, 2], [0, 2, 3], [1, 4, 1], [4, 4, 1]]);
    let found = distance(&spiked.as_ref(), &plain.as_ref(), 1000, 0, &mut carry_on).unwrap();
    assert!(found.largest() < 1e-12 && found.diagonal == 2f64.sqrt(), "{found:?}");
    let options = Options { polish: false, ..Options::new(Target::Error(0.01)) };
    let result = simplify(&spiked.as_ref(), &options, &mut carry_on).unwrap();
    assert!(result.report.distance.unwrap().largest() <= 0.01);
    // Where there is nothing else, it is what there is.
    let line = mesh_of(square.to_vec(), vec![[1, 4, 1]]);
    assert!(distance(&line.as_ref(), &plain.as_ref(), 10, 0, &mut carry_on).unwrap().largest() > 9.0);
}
