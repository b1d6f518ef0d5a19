//! Heights of a laid jigsaw puzzle: pieces that bulge a little, and the smooth grooves between them.

use super::{canvas::Canvas, curve::through, random::Random};
use glam::{DVec2, dvec2};

/// Pieces across and down.
const PIECES: [usize; 2] = [9, 11];
/// Pixels across a piece.
const SIDE: f64 = 72.0;
/// Outline of a tab on an edge from (0, 0) to (1, 0).
const TAB: [(f64, f64); 13] = [
    (0.0, 0.0),
    (0.2, -0.03),
    (0.36, -0.015),
    (0.425, 0.03),
    (0.415, 0.09),
    (0.375, 0.16),
    (0.42, 0.235),
    (0.5, 0.26),
    (0.58, 0.235),
    (0.625, 0.16),
    (0.585, 0.09),
    (0.575, 0.03),
    (0.64, -0.015),
];

/// The PNG file: white is the top of a piece, black the bottom of a groove.
pub fn png() -> Vec<u8> {
    let size = PIECES.map(|n| n as f64 * SIDE);
    let mut canvas = Canvas::new(size[0] as usize, size[1] as usize, [1.0]);
    for edge in edges() {
        let line: Vec<(DVec2, f64)> = edge.iter().map(|p| (*p * SIDE, 1.2)).collect();
        canvas.line(&line, 7.0, |[height], cover| {
            let rounded = cover * cover * (3.0 - 2.0 * cover);
            [height.min(1.0 - rounded)]
        });
    }
    canvas.png()
}

/// Every edge between two pieces, in units of a piece.
fn edges() -> Vec<Vec<DVec2>> {
    let mut random = Random::new(4);
    let [across, down] = PIECES;
    // Corners on the rim stay there.
    let mut corner = |x: usize, y: usize| {
        let shift = |i: usize, n: usize, r: f64| if i == 0 || i == n { 0.0 } else { 0.07 * r };
        dvec2(x as f64 + shift(x, across, random.signed()), y as f64 + shift(y, down, random.signed()))
    };
    let corners: Vec<Vec<DVec2>> = (0..=down).map(|y| (0..=across).map(|x| corner(x, y)).collect()).collect();
    let mut edges = Vec::new();
    for y in 0..=down {
        for x in 0..=across {
            if x < across && y > 0 && y < down {
                edges.push(edge(corners[y][x], corners[y][x + 1], &mut random));
            }
            if y < down && x > 0 && x < across {
                edges.push(edge(corners[y][x], corners[y + 1][x], &mut random));
            }
        }
    }
    edges
}

fn edge(from: DVec2, to: DVec2, random: &mut Random) -> Vec<DVec2> {
    let along = to - from;
    let side = along.perp() * if random.unit() < 0.5 { -1.0 } else { 1.0 };
    let (shift, size) = (0.05 * random.signed(), 1.0 + 0.12 * random.signed());
    let lean = 0.12 * random.signed();
    let at = |(x, y): (f64, f64)| {
        let middle = 0.5 + (x - 0.5) * 1.15 * size + shift + lean * y;
        // The ends of the edge stay.
        let x = if x < 0.3 { x } else { middle };
        from + along * x + side * (1.15 * y * size)
    };
    let mut points: Vec<DVec2> = TAB.iter().map(|p| at(*p)).collect();
    points.extend([from + along * 0.82 - side * 0.03, to]);
    through(&points)
}
