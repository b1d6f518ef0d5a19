//! Vertices of curves: open edges, borders, seams and creases. They slide along.

use super::net::Net;
use crate::Mesh;
use crate::curves::Curves;
use crate::surface::{dot, sub};
use crate::vertex::Kind;

/// A point.
type Point = [f64; 3];

/// Points of a stretch of curve that are asked for their distance.
const SAMPLES: usize = 48;
/// Places that are tried at first, and times that the best one is looked at more closely, in four times smaller steps.
const PLACES: usize = 16;
const CLOSER: usize = 2;
/// What squares are left of before is worth a move.
const WORTH: f64 = 0.99;
/// A stretch of curve is at most so many times as long as the edges that stand for it.
const LONGER: f64 = 2.0;

/// A node of a curve and those next to it there.
pub(super) struct Slider {
    pub node: u32,
    ends: [u32; 2],
}

/// How far the nodes of creases may be from their curves: as far as they are, or half as far as the edges that stand for the curve
/// are from it, where a polygon about a round edge is best; so that the crease as a whole comes no farther off. Infinite for other
/// nodes.
pub(super) fn leashes(sliders: &[Slider], net: &Net, curves: Option<&Curves>) -> Vec<f64> {
    let mut leashes = vec![f64::INFINITY; net.positions.len()];
    let creases = sliders.iter().filter(|slider| net.kinds[slider.node as usize] == Kind::Free);
    for (slider, curves) in creases.zip(std::iter::repeat(curves)) {
        let leash = curves.and_then(|curves| {
            let part = Part::of(slider, curves, &net.positions)?;
            Some(dot(part.offset, part.offset).sqrt().max(0.5 * part.farthest(part.now).sqrt()))
        });
        leashes[slider.node as usize] = leash.unwrap_or(0.0);
    }
    leashes
}

/// The nodes that lie on curves of the original: those that may slide, and those that stay, because curves end or meet there.
pub(super) fn sliders(mesh: &Mesh, net: &Net, curves: Option<&Curves>, crease_cosine: f64) -> (Vec<Slider>, Vec<u32>) {
    let mut beside: Vec<Vec<u32>> = vec![Vec::new(); net.positions.len()];
    for (edge, faces) in faces_of_edges(net).into_iter().enumerate() {
        let ends = net.edges[edge];
        if is_on_curve(mesh, net, curves, ends, &faces, crease_cosine) {
            beside[ends[0] as usize].push(ends[1]);
            beside[ends[1] as usize].push(ends[0]);
        }
    }
    let (mut sliders, mut stay) = (Vec::new(), Vec::new());
    for (node, beside) in (0..).zip(beside).filter(|(node, _)| net.kinds[*node as usize] != Kind::Fixed) {
        match beside[..] {
            [] => {}
            [one, other] => sliders.push(Slider { node, ends: [one, other] }),
            _ => stay.push(node),
        }
    }
    (sliders, stay)
}

/// The faces at each edge, the first three.
fn faces_of_edges(net: &Net) -> Vec<Vec<u32>> {
    let mut faces = vec![Vec::new(); net.edges.len()];
    for (face, edges) in (0..).zip(&net.face_edges) {
        edges.iter().for_each(|&edge| faces[edge as usize].push(face));
    }
    faces
}

fn is_on_curve(
    mesh: &Mesh,
    net: &Net,
    curves: Option<&Curves>,
    ends: [u32; 2],
    faces: &[u32],
    crease_cosine: f64,
) -> bool {
    let [one, other] = *faces else { return true };
    let is_border = mesh.materials.as_ref().is_some_and(|m| m[one as usize] != m[other as usize]);
    let vertex_at =
        |face: u32, node: u32| mesh.faces[face as usize].into_iter().find(|&v| net.node[v as usize] == node);
    if is_border || ends.into_iter().any(|node| vertex_at(one, node) != vertex_at(other, node)) {
        return true;
    }
    let [a, b] = [one, other].map(|face| net.normal(face as usize, &net.positions));
    let is_sharp = dot(a, b) < crease_cosine * (dot(a, a) * dot(b, b)).sqrt();
    is_sharp && curves.is_some_and(|curves| curves.join(ends.map(|node| net.positions[node as usize].map(f64::from))))
}

/// Where a node should go along its curve so that the edges to those next to it are nearest to the curve between them, in the sense
/// of least squares. It keeps its offset from the curve, so that it is never farther from it. `None` if it is best where it is, or if
/// the curve cannot be followed.
pub(super) fn wished(slider: &Slider, curves: &Curves, positions: &[[f32; 3]]) -> Option<Point> {
    let part = Part::of(slider, curves, positions)?;
    let least = part.squares(part.now);
    let mut best = (least, part.now);
    let length = part.path.length();
    let mut step = length / PLACES as f64;
    let mut tried: Vec<f64> = (1..PLACES).map(|i| i as f64 * step).collect();
    for _ in 0..=CLOSER {
        for along in tried.drain(..).filter(|&along| along > 0.0 && along < length) {
            let squares = part.squares(along);
            if squares < best.0 {
                best = (squares, along);
            }
        }
        tried.extend([-3.0, -2.0, -1.0, 1.0, 2.0, 3.0].map(|i| best.1 + 0.25 * i * step));
        step *= 0.25;
    }
    (best.0 < WORTH * least).then(|| part.place(best.1))
}

/// The part of a curve between the nodes next to one.
struct Part {
    path: Path,
    ends: [Point; 2],
    /// Where the node is along the path, and how far from it.
    now: f64,
    offset: Point,
    /// Points of the path, and how far along it they are.
    samples: Vec<(f64, Point)>,
}

impl Part {
    fn of(slider: &Slider, curves: &Curves, positions: &[[f32; 3]]) -> Option<Self> {
        let at = |node: u32| positions[node as usize].map(f64::from);
        let (here, ends) = (at(slider.node), slider.ends.map(at));
        let [Some(from), Some(over), Some(to)] = curves.feet([ends[0], here, ends[1]]) else { return None };
        let long = |end: Point| dot(sub(end, here), sub(end, here)).sqrt();
        let (stretch, middle) = curves.stretch(&from, &over, &to, LONGER * (long(ends[0]) + long(ends[1])))?;
        let path = Path::of(stretch);
        let sample = |i: usize| {
            let along = path.length() * (i as f64 + 0.5) / SAMPLES as f64;
            (along, path.at(along))
        };
        let samples = (0..SAMPLES).map(sample).collect();
        Some(Self { ends, now: path.starts[middle], offset: sub(here, over.place), samples, path })
    }

    /// Where the node is if it slides.
    fn place(&self, along: f64) -> Point {
        let there = self.path.at(along);
        [0, 1, 2].map(|axis| there[axis] + self.offset[axis])
    }

    /// The squares of the distances from the path to the edges there are then.
    fn distances(&self, along: f64) -> impl Iterator<Item = f64> {
        let place = self.place(along);
        self.samples.iter().map(move |&(of_sample, sample)| {
            let end = if of_sample <= along { self.ends[0] } else { self.ends[1] };
            to_segment_squared(sample, end, place)
        })
    }

    fn squares(&self, along: f64) -> f64 {
        self.distances(along).sum()
    }

    fn farthest(&self, along: f64) -> f64 {
        self.distances(along).fold(0.0, f64::max)
    }
}

/// A polyline by its length.
struct Path {
    points: Vec<Point>,
    /// Length up to each point.
    starts: Vec<f64>,
}

impl Path {
    fn of(points: Vec<Point>) -> Self {
        let mut starts = vec![0.0];
        for pair in points.windows(2) {
            let side = sub(pair[1], pair[0]);
            starts.push(starts[starts.len() - 1] + dot(side, side).sqrt());
        }
        Self { points, starts }
    }

    fn length(&self) -> f64 {
        self.starts[self.starts.len() - 1]
    }

    fn at(&self, along: f64) -> Point {
        let last = self.points.len() - 2;
        let i = self.starts.partition_point(|&start| start <= along).saturating_sub(1).min(last);
        let width = self.starts[i + 1] - self.starts[i];
        let t = if width > 0.0 { ((along - self.starts[i]) / width).clamp(0.0, 1.0) } else { 0.0 };
        let (a, b) = (self.points[i], self.points[i + 1]);
        [0, 1, 2].map(|axis| (1.0 - t) * a[axis] + t * b[axis])
    }
}

/// The square of the distance from a point to a segment.
fn to_segment_squared(point: Point, a: Point, b: Point) -> f64 {
    let (side, away) = (sub(b, a), sub(point, a));
    let squared = dot(side, side);
    let t = if squared > 0.0 { (dot(away, side) / squared).clamp(0.0, 1.0) } else { 0.0 };
    let left = [0, 1, 2].map(|axis| away[axis] - t * side[axis]);
    dot(left, left)
}
