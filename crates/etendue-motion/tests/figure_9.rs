//! Two balls in a box, as in the paper's film: when they meet the floor, each other, and the walls.

mod common;

use common::{path, run, velocities};
use etendue::math::DVec3;

/// The box's walls, and two balls of radius 0.2 that just touch; frames show 0.02 s each.
fn scene(physics: &str) -> String {
    let wall = |corner: [i32; 3], u: [i32; 3], v: [i32; 3]| {
        format!(
            "[[objects]]\nshape = \"rectangle\"\ncorner = {corner:?}\nu = {u:?}\nv = {v:?}\n\
             body = {{ kind = \"fixed\", restitution = 1, friction = 0 }}\n"
        )
    };
    let ball = |center: [f64; 3]| {
        format!(
            "[[objects]]\nshape = \"sphere\"\nradius = 0.2\ncenter = {center:?}\n\
             body = {{ mass = 1, restitution = 1, friction = 0 }}\n"
        )
    };
    let walls = [
        wall([-1, -1, -1], [2, 0, 0], [0, 2, 0]),
        wall([-1, -1, 1], [2, 0, 0], [0, 2, 0]),
        wall([-1, -1, -1], [0, 2, 0], [0, 0, 2]),
        wall([-1, -1, -1], [2, 0, 0], [0, 0, 2]),
        wall([-1, 1, -1], [2, 0, 0], [0, 0, 2]),
    ];
    let balls = [ball([0.0, 0.0, 0.0]), ball([0.0, 0.1, 0.4])].concat();
    format!("{balls}{}[physics]\ngravity = [0, 0, -2]\nduration = 3.4\n{physics}\n", walls.concat())
}

/// Frames at which a coordinate of the velocity jumps, with the ball and the axis.
fn jumps(physics: &str) -> Vec<(f64, usize, usize)> {
    let bake = run(&scene(physics));
    let mut found = Vec::new();
    for (ball, start) in [DVec3::ZERO, DVec3::new(0.0, 0.1, 0.4)].into_iter().enumerate() {
        let speeds = velocities(&bake, &path(&bake, ball, start));
        for (pair, time) in speeds.windows(2).zip(&bake.times[1..]) {
            let change = (pair[1] - pair[0]).abs().to_array();
            found.extend((0..3).filter(|&axis| change[axis] > 0.1).map(|axis| (time / 0.02, ball, axis)));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    found
}

#[test]
fn balls_meet_floor_each_other_and_walls_when_they_do_in_the_film() {
    for physics in ["step = 0.0005", "step = 0.0002", ""] {
        let found = jumps(physics);
        let first = |ball: usize, axis: usize, after: f64| {
            found.iter().find(|f| f.1 == ball && f.2 == axis && f.0 > after).map_or(f64::NAN, |f| f.0)
        };
        // The lower ball is thrown back by the floor; then the upper one meets it; both fly apart along y.
        let floor = first(0, 2, 0.0);
        let balls = first(1, 2, 0.0);
        assert!((floor - 44.7).abs() <= 1.0, "{physics}: floor at {floor}: {found:?}");
        assert!((balls - 44.9).abs() <= 1.0, "{physics}: balls at {balls}: {found:?}");
        let apart = first(0, 1, 0.0);
        let walls = [first(0, 1, apart + 5.0), first(1, 1, apart + 5.0)];
        let (early, late) = (walls[0].min(walls[1]), walls[0].max(walls[1]));
        assert!((early - 85.3).abs() <= 2.0, "{physics}: walls at {walls:?}: {found:?}");
        assert!((late - 91.1).abs() <= 2.0, "{physics}: walls at {walls:?}: {found:?}");
    }
}
