//! A vertex that is not moved has the bits that it has in the input, however far apart coordinates are.

// What is made is measured, never compared bit by bit with another machine's.
#![allow(clippy::disallowed_methods)]

mod shapes;

use std::collections::BTreeSet;

use etendue_simplify::{Mesh, Options, Placement, Target, check, simplify};
use shapes::*;

/// A field of the size of 1e-30 with a vertex at 3e8, or of 1 with one at 3e38: the small ones have few digits beside the large one,
/// or none.
fn fields() -> [Mesh; 2] {
    [(1e-30, 3.4e8), (1.0, 3.4e38)].map(|(size, far)| {
        let mut field = grid(12, |x, y| 0.1 * (7.0 * x).sin() * (5.0 * y).cos());
        field = moved(&field, |p| p.map(|x| x * size));
        field.positions[30][2] = far;
        // A zero of the other sign is one all the same.
        field.positions[0][0] = -0.0;
        field
    })
}

fn bits(mesh: &Mesh) -> BTreeSet<[u32; 3]> {
    mesh.positions.iter().map(|p| p.map(f32::to_bits)).collect()
}

#[test]
fn locked_vertices_and_open_edges_have_their_bits() {
    for field in fields() {
        for (polish, fast) in [(true, false), (false, false), (false, true)] {
            let locked = vec![0, 40, 77, 121];
            let mut options = Options { polish, fast, locked, ..Options::new(Target::Faces(20)) };
            let stays: Vec<u32> = options.locked.clone();
            let result = bits(&simplify(&field.as_ref(), &options, &mut carry_on).unwrap().mesh);
            assert!(stays.iter().all(|&v| result.contains(&field.positions[v as usize].map(f32::to_bits))));
            options.keep_boundary = true;
            let result = bits(&simplify(&field.as_ref(), &options, &mut carry_on).unwrap().mesh);
            for (i, place) in field.positions.iter().enumerate() {
                let is_open = i % 13 == 0 || i % 13 == 12 || i / 13 == 0 || i / 13 == 12;
                assert!(!is_open || result.contains(&place.map(f32::to_bits)), "vertex {i}");
            }
        }
    }
}

#[test]
fn ends_of_edges_have_their_bits() {
    for field in fields() {
        for fast in [false, true] {
            let options =
                Options { placement: Placement::Endpoint, polish: false, fast, ..Options::new(Target::Faces(60)) };
            let result = simplify(&field.as_ref(), &options, &mut carry_on).unwrap();
            assert!(result.report.collapses > 0);
            assert!(bits(&result.mesh).is_subset(&bits(&field)));
        }
    }
}

/// A place is rounded to the digits that its coordinates have: few, far from the origin.
#[test]
fn rounding_puts_no_three_corners_on_a_line() {
    for turn in 0..200 {
        let (sin, cos) = (0.1 * f64::from(turn)).sin_cos();
        // Two thousandths beside 4096, whose last binary digit is half a thousandth.
        let field = moved(&grid(10, |_, _| 0.0), |p| {
            let [x, y, _] = p.map(|x| f64::from(x) / 128.0);
            [(4096.0 + cos * x - sin * y) as f32, (sin * x + cos * y - 100.0) as f32, 0.0]
        });
        let before = check(&field.as_ref()).flat.count;
        for (faces, fast) in [(20, false), (20, true), (30, false), (30, true)] {
            let options =
                Options { polish: false, fast, locked: vec![35, 50, 77, 90], ..Options::new(Target::Faces(faces)) };
            let result = simplify(&field.as_ref(), &options, &mut carry_on).unwrap();
            assert!(check(&result.mesh.as_ref()).flat.count <= before, "turn {turn}, to {faces}");
        }
    }
}
