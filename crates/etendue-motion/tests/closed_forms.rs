//! Motion against closed forms, at the settings that a scene file has by default unless a test says otherwise.

#![allow(clippy::disallowed_methods)]

mod common;

use common::{path, run, velocities};
use etendue::math::DVec3;

const G: f64 = 9.81;

fn ball(extra: &str) -> String {
    format!("[[objects]]\nshape = \"sphere\"\nradius = 0.1\ncenter = [0, 0.1, 0]\n{extra}\n")
}

const FLOOR: &str =
    "[[objects]]\nshape = \"rectangle\"\ncorner = [-50, 0, -50]\nu = [100, 0, 0]\nv = [0, 0, 100]\nbody = \"fixed\"\n";

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
            for e in [1.0f64, 0.8, 0.5, 0.0] {
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
                    assert!(
                        (height / expected - 1.0).abs() < 0.02,
                        "{e} from {drop}: {height} for {expected}, {tops:?}"
                    );
                }
            }
        }
    }
}

/// Two balls that meet head-on, and off the middle, without gravity or friction.
#[test]
fn elastic_collisions_keep_momentum_and_energy() {
    for (masses, offset) in [([1.0, 1.0], 0.0), ([1.0, 3.0], 0.0), ([0.5, 1.0], 0.11), ([2.0, 2.0], 0.19)] {
        let [m, n] = masses;
        let text = format!(
            "[[objects]]\nshape = \"sphere\"\nradius = 0.1\ncenter = [-0.5, {offset}, 0]\n\
             body = {{ mass = {m}, restitution = 1, friction = 0, linear_velocity = [2, 0, 0] }}\n\
             [[objects]]\nshape = \"sphere\"\nradius = 0.1\ncenter = [0.5, 0, 0]\n\
             body = {{ mass = {n}, restitution = 1, friction = 0, linear_velocity = [-1, 0, 0] }}\n\
             [physics]\ngravity = [0, 0, 0]\nduration = 1\n"
        );
        let bake = run(&text);
        let starts = [DVec3::new(-0.5, offset, 0.0), DVec3::new(0.5, 0.0, 0.0)];
        let [a, b] = [0, 1].map(|body| velocities(&bake, &path(&bake, body, starts[body])));
        let momentum = |i: usize| a[i] * m + b[i] * n;
        let energy = |i: usize| 0.5 * (m * a[i].length_squared() + n * b[i].length_squared());
        let last = a.len() - 1;
        assert!((momentum(last) - momentum(0)).length() < 1e-5 * (2.0 * m + n), "{} {}", momentum(0), momentum(last));
        assert!((energy(last) / energy(0) - 1.0).abs() < 0.01, "{masses:?} {offset}: {} {}", energy(0), energy(last));
        assert!((a[last] - a[0]).length() > 0.5, "they have met");
        if offset == 0.0 {
            // The velocities of two that meet head-on, reflected in the frame of their centre of mass.
            let center = (2.0 * m - n) / (m + n);
            assert!((a[last].x - (2.0 * center - 2.0)).abs() < 1e-3, "{}", a[last]);
            assert!((b[last].x - (2.0 * center + 1.0)).abs() < 1e-3, "{}", b[last]);
        }
    }
}

#[test]
fn a_block_slides_to_a_stop() {
    for (friction, speed) in [(0.5, 3.0), (0.2, 2.0)] {
        let text = format!(
            "[[objects]]\nshape = \"box\"\nmin = [-0.2, 0, -0.2]\nmax = [0.2, 0.1, 0.2]\n\
             body = {{ friction = {friction}, linear_velocity = [{speed}, 0, 0] }}\n{FLOOR}\
             [physics]\nduration = 3\nfriction_rule = \"min\"\n"
        );
        let bake = run(&text.replace("body = \"fixed\"", "body = { kind = \"fixed\", friction = 1 }"));
        let at = path(&bake, 0, DVec3::ZERO);
        let expected = speed * speed / (2.0 * friction * G);
        let last = at[at.len() - 1];
        assert!((last.x / expected - 1.0).abs() < 0.01, "{last} for {expected}");
        assert!(last.y.abs() < 1e-3 && last.z.abs() < 1e-3, "{last}");
        assert!((at[at.len() - 100] - last).length() < 1e-4, "it has stopped");
    }
}

/// A ball that is damped rolls `v / damping` far; one that slides first ends rolling at 5/7 of its speed.
#[test]
fn a_ball_rolls_to_a_stop() {
    let text = format!(
        "{}{FLOOR}[physics]\nduration = 6\nsleep = false\n",
        ball(
            "body = { linear_velocity = [1, 0, 0], angular_velocity = [0, 0, -572.957795], linear_damping = 2, angular_damping = 2 }"
        )
    );
    let bake = run(&text);
    let at = path(&bake, 0, DVec3::new(0.0, 0.1, 0.0));
    let last = at[at.len() - 1];
    assert!((last.x / 0.5 - 1.0).abs() < 0.01, "{last}");
    let turned = bake.bodies[0].poses.windows(2).map(|pair| {
        let turn = pair[1].rotation * pair[0].rotation.conjugate();
        2.0 * turn.xyz().length().asin()
    });
    let turned: f64 = turned.sum();
    assert!((turned / (0.5 / 0.1) - 1.0).abs() < 0.01, "{turned}");

    let text =
        format!("{}{FLOOR}[physics]\nduration = 2\n", ball("body = { linear_velocity = [2, 0, 0], friction = 0.3 }"));
    let bake = run(&text.replace("body = \"fixed\"", "body = { kind = \"fixed\", friction = 0.3 }"));
    let at = path(&bake, 0, DVec3::new(0.0, 0.1, 0.0));
    let speed = velocities(&bake, &at)[at.len() - 2].x;
    assert!((speed / (5.0 / 7.0 * 2.0) - 1.0).abs() < 0.01, "{speed}");
    // Where sliding ends: x = 12 v² / (49 mu g) at t = 2 v / (7 mu g).
    let (x, t) = (12.0 * 4.0 / (49.0 * 0.3 * G), 2.0 * 2.0 / (7.0 * 0.3 * G));
    let last = at[at.len() - 1].x;
    let expected = x + (2.0 - t) * 5.0 / 7.0 * 2.0;
    assert!((last / expected - 1.0).abs() < 0.01, "{last} for {expected}");
}

/// A rod on a hinge swings with the period of a physical pendulum, and keeps its energy.
#[test]
fn a_pendulum_swings() {
    let text = "[[objects]]\nname = \"rod\"\nshape = \"box\"\nmin = [-0.02, -1, -0.02]\nmax = [0.02, 0, 0.02]\n\
                transform = { rotate = { axis = \"z\", angle = 5 } }\nbody = \"dynamic\"\n\
                [[joints]]\ntype = \"hinge\"\nbodies = \"rod\"\nanchor = [0, 0, 0]\naxis = \"z\"\n\
                [physics]\nduration = 10\n";
    let bake = run(text);
    let start = DVec3::new(0.0872, -0.9962, 0.0);
    let at = path(&bake, 0, start);
    let falling = |i: &usize| at[*i].x > 0.0 && at[*i + 1].x <= 0.0;
    let crossings: Vec<f64> = (0..at.len() - 1)
        .filter(falling)
        .map(|i| {
            let (a, b) = (at[i].x, at[i + 1].x);
            bake.times[i] + (bake.times[i + 1] - bake.times[i]) * a / (a - b)
        })
        .collect();
    let period = (crossings[crossings.len() - 1] - crossings[0]) / (crossings.len() - 1) as f64;
    // Inertia of the rod about its end over m g times the distance of its middle; the amplitude adds a²/16.
    let inertia = (1.0 + 0.04 * 0.04) / 3.0;
    let amplitude = 5f64.to_radians();
    let expected = std::f64::consts::TAU * (inertia / (0.5 * G)).sqrt() * (1.0 + amplitude * amplitude / 16.0);
    assert!((period / expected - 1.0).abs() < 0.003, "{period} for {expected}");
    let reach = at[at.len() - 2000..].iter().map(|p| p.x.abs()).fold(0.0, f64::max);
    assert!((reach / start.x - 1.0).abs() < 0.05, "{reach}");
    assert!(at.iter().all(|p| (p.length() - start.length()).abs() < 1e-3));
}
