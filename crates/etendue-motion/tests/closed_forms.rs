//! Motion against closed forms, at the settings that a scene file has by default unless a test says otherwise.

mod common;

use common::{path, run, velocities};
use etendue::math::DVec3;

const G: f64 = 9.81;

fn ball(extra: &str) -> String {
    format!("[[objects]]\nshape = \"sphere\"\nradius = 0.1\ncenter = [0, 0.1, 0]\n{extra}\n")
}

const FLOOR: &str = "[[objects]]\nshape = \"rectangle\"\ncorner = [-50, 0, -50]\nu = [100, 0, 0]\nv = [0, 0, 100]\nbody = \"fixed\"\n";

#[test]
fn free_fall() {
    let bake = run(&(ball("body = { linear_velocity = [1, 2, 3] }") + "[physics]\nduration = 1\n"));
    let at = path(&bake, 0, DVec3::ZERO);
    for (t, p) in bake.times.iter().zip(&at) {
        let expected = DVec3::new(*t, 2.0 * t - 0.5 * G * t * t, 3.0 * t);
        assert!((*p - expected).length() < 1e-3 * 0.5 * G * t * t + 1e-12, "{t}: {p} for {expected}");
        assert!((*p - expected).length() < 1e-9, "{t}: {p} for {expected}");
    }
    assert!((bake.times.last().unwrap() - 1.0).abs() < 1e-12);
}

/// Heights between bounces, metres above the floor.
fn heights(at: &[DVec3]) -> Vec<f64> {
    let tops = at.windows(3).filter(|w| w[1].y >= w[0].y && w[1].y > w[2].y).map(|w| w[1].y);
    tops.collect()
}

#[test]
fn bounces() {
    for floor in [FLOOR, "[[objects]]\nshape = \"box\"\nmin = [-5, -1, -5]\nmax = [5, 0, 5]\nbody = \"fixed\"\n"] {
        for drop in [1.0, 0.37, 3.0] {
            for e in [1.0, 0.8, 0.5, 0.0] {
                let text = format!(
                    "{}transform = [{{ translate = [0, {drop}, 0] }}]\n{floor}[physics]\nduration = 9\n",
                    ball(&format!("body = {{ restitution = {e} }}"))
                );
                let at = path(&run(&text), 0, DVec3::new(0.0, drop, 0.0));
                let tops = heights(&at);
                if e == 0.0 {
                    let rest = at.len() / 2;
                    assert!(tops.iter().all(|h| h.abs() < 0.02 * drop), "{tops:?}");
                    assert!(at[rest..].iter().all(|p| p.y.abs() < 1e-3 * drop), "{}", at[rest]);
                    continue;
                }
                assert!(tops.len() >= 5, "{e}: {tops:?}");
                for (bounce, height) in (1..).zip(&tops[..5]) {
                    let expected = drop * e.powi(2 * bounce);
                    assert!((height / expected - 1.0).abs() < 0.02, "{e} from {drop}: {height} for {expected}, {tops:?}");
                }
            }
        }
    }
}
