//! Small patches over a flat original that faces up; some of their faces do not.

use super::*;
use crate::block::MOVED;
use crate::surface::search;
use crate::vertex::Kind;
use crate::{Mesh, Progress};

/// A square of small faces from -1 to 1, at height 0.
fn flat() -> Mesh {
    let n = 40;
    let at = |i: u32| i as f32 / n as f32 * 2.0 - 1.0;
    let positions = (0..=n).flat_map(|y| (0..=n).map(move |x| [at(x), at(y), 0.0])).collect();
    let faces = (0..n).flat_map(|y| (0..n).map(move |x| y * (n + 1) + x));
    let faces = faces.flat_map(|p| [[p, p + 1, p + n + 2], [p, p + n + 2, p + n + 1]]).collect();
    Mesh { positions, faces, ..Mesh::default() }
}

fn draft(places: &[[f32; 2]], faces: &[[u32; 3]], kind: Kind) -> Draft {
    let count = places.len();
    Draft {
        mesh: Mesh {
            positions: places.iter().map(|&[x, y]| [x, y, 0.0]).collect(),
            faces: faces.to_vec(),
            ..Mesh::default()
        },
        kinds: vec![kind; count],
        owners: (0..count as u32).collect(),
        sources: vec![MOVED; count],
        facing: vec![[0.0, 0.0, 1.0]; count],
        rounding: 1e-7,
    }
}

/// How many stay turned over.
fn mended(draft: &mut Draft, may_move: bool) -> usize {
    set_upright(&flat().as_ref(), None, None, may_move, draft, &mut |_: Progress| ControlFlow::Continue(())).unwrap()
}

/// Two faces at an edge along x, the second of which is turned over: its third corner is `low` above the edge, that of the first
/// `high`.
fn folded(low: f32, high: f32) -> Draft {
    draft(&[[-0.5, 0.0], [0.5, 0.0], [0.0, high], [0.0, low]], &[[0, 1, 2], [1, 0, 3]], Kind::Fixed)
}

#[test]
fn an_edge_is_turned() {
    let mut fold = folded(0.04, 0.8);
    let before = fold.mesh.clone();
    assert_eq!(mended(&mut fold, true), 0);
    assert_eq!(fold.mesh.positions, before.positions);
    assert_eq!(fold.mesh.faces, [[2, 0, 3], [1, 2, 3]]);
}

#[test]
fn what_stands_for_the_original_is_asked() {
    // What was merged into the corners looks the way that the turned face does.
    let mut fold = folded(0.04, 0.8);
    fold.facing = vec![[0.0, 0.0, -1.0]; 4];
    fold.facing[2] = [0.0, 0.0, 1.0];
    fold.mesh.faces.swap(0, 1);
    let original = flat();
    let stand_in = search(&original.as_ref()).unwrap();
    let mut alone = folded(0.04, 0.8);
    alone.mesh.faces.remove(0);
    alone.facing = vec![[0.0, 0.0, -1.0]; 4];
    assert_eq!(mended(&mut alone, true), 0, "nothing was suspected");
    let tell = &mut |_: Progress| ControlFlow::Continue(());
    assert_eq!(set_upright(&original.as_ref(), Some(&stand_in), None, true, &mut alone, tell).unwrap(), 1);
    assert_eq!(set_upright(&original.as_ref(), Some(&stand_in), None, true, &mut fold, tell).unwrap(), 0);
}

#[test]
fn edges_of_creases_materials_and_seams_are_not_turned() {
    let stays = |fold: &mut Draft, curves: Option<&Curves>| {
        let before = fold.mesh.clone();
        let tell = &mut |_: Progress| ControlFlow::Continue(());
        let count = set_upright(&flat().as_ref(), None, curves, true, fold, tell).unwrap();
        count == 1 && fold.mesh == before
    };
    let crease = Curves::of(&[[-0.6, 0.0, 0.0], [0.1, 0.0, 0.0], [0.7, 0.0, 0.0]], &[[0, 1], [1, 2]]).unwrap();
    assert!(stays(&mut folded(0.04, 0.8), crease.as_ref()));
    let beside = Curves::of(&[[-0.6, 0.2, 0.0], [0.7, 0.2, 0.0]], &[[0, 1]]).unwrap();
    assert!(!stays(&mut folded(0.04, 0.8), beside.as_ref()));
    let mut border = folded(0.04, 0.8);
    border.mesh.materials = Some(vec![3, 4]);
    assert!(stays(&mut border, None));
    border.mesh.materials = Some(vec![3, 3]);
    assert!(!stays(&mut border, None));
    let places = [[-0.5, 0.0], [-0.5, 0.0], [0.5, 0.0], [0.5, 0.0], [0.0, 0.8], [0.0, 0.04]];
    let mut seam = draft(&places, &[[0, 2, 4], [3, 1, 5]], Kind::Fixed);
    seam.owners = vec![0, 0, 1, 1, 2, 3];
    assert!(stays(&mut seam, None));
}

#[test]
fn what_would_go_too_far_or_be_too_thin_is_not_done() {
    for (low, high, counted) in [(0.2, 0.8, 1), (0.04, 0.0402, 1), (0.04, 0.06, 0)] {
        let mut fold = folded(low, high);
        let before = fold.mesh.clone();
        assert_eq!(mended(&mut fold, true), counted, "{low} {high}");
        assert_eq!(fold.mesh == before, counted > 0, "{low} {high}");
    }
}

#[test]
fn what_is_narrower_than_rounding_is_left() {
    let mut fold = folded(0.04, 0.8);
    fold.rounding = 0.05;
    let before = fold.mesh.clone();
    assert_eq!(mended(&mut fold, true), 0);
    assert!(fold.mesh == before);
}

/// A fan whose middle is beside it, so that one face is turned over.
fn fan(corners: u32) -> Draft {
    let angle = |i: u32| f64::from(2 * i + 1) / f64::from(corners) * std::f64::consts::PI;
    let rim = |i: u32| [0.5 * libm::cos(angle(i)), 0.5 * libm::sin(angle(i))].map(|x| x as f32);
    let half = std::f64::consts::PI / f64::from(corners);
    let beside = (0.5 * libm::cos(half) + 0.04 * libm::sin(half)) as f32;
    let places: Vec<[f32; 2]> = std::iter::once([beside, 0.0]).chain((0..corners).map(rim)).collect();
    let faces: Vec<[u32; 3]> = (0..corners).map(|i| [0, i + 1, (i + 1) % corners + 1]).collect();
    let mut fan = draft(&places, &faces, Kind::Fixed);
    fan.kinds[0] = Kind::Free;
    // No edge can be turned.
    fan.mesh.materials = Some((0..corners).map(|i| i % 2).collect());
    fan
}

#[test]
fn a_vertex_is_moved_or_taken_out() {
    let mut moved = fan(6);
    let before = moved.mesh.clone();
    assert_eq!(mended(&mut moved, true), 0);
    assert_eq!(moved.mesh.faces, before.faces);
    assert!(moved.mesh.positions[0] != before.positions[0] && moved.mesh.positions[1..] == before.positions[1..]);
    let mut taken = fan(6);
    assert_eq!(mended(&mut taken, false), 0);
    assert_eq!((taken.mesh.faces.len(), taken.mesh.positions.len()), (4, 6));
    for (corners, kind) in [(6, Kind::Fixed), (6, Kind::Curve), (MANY, Kind::Free)] {
        let mut stays = fan(corners);
        stays.kinds[0] = kind;
        let before = stays.mesh.clone();
        assert!(mended(&mut stays, true) > 0 && stays.mesh == before, "{corners} {kind:?}");
    }
}

/// More corners than are looked at.
const MANY: u32 = 70;

#[test]
fn no_edge_gets_more_faces_by_taking_a_vertex_out() {
    let node: Vec<u32> = (0..5).collect();
    // Two tetrahedra on one another: along the triangle between them, whose face is not there, no edge may vanish.
    let places = [[0.0, 0.0], [0.4, 0.0], [0.0, 0.4], [0.1, 0.1], [0.1, 0.1]];
    let faces = [[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 4], [2, 1, 4], [0, 2, 4]];
    let mut both = draft(&places, &faces, Kind::Free);
    both.mesh.positions[3][2] = 0.3;
    both.mesh.positions[4][2] = -0.3;
    let field = Field::of(&mut both, &node, None, true);
    let may = |from: u32, to: u32| field.collapse(from, to).is_some();
    assert!(!may(0, 1) && !may(1, 2) && !may(2, 0));
    assert!(may(3, 0) && may(4, 2));
    let mut one = draft(&places[..4], &[[0, 1, 3], [1, 2, 3], [2, 0, 3], [1, 0, 2]], Kind::Free);
    let field = Field::of(&mut one, &node[..4], None, true);
    assert!((0..4).all(|from| (0..4).filter(|&to| to != from).all(|to| field.collapse(from, to).is_none())));
}
