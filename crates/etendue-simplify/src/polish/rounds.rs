//! Rounds of measuring and moving, and which was the best.

use std::sync::Arc;

use etendue_accel::{ClosestPoint, ClosestPoints, Isa, TriangleMesh};

use super::Originals;
use super::fit::{Fit, Wish};
use super::net::Net;
use super::slide::{Slider, leashes, sliders, wished};
use crate::curves::Curves;
use crate::surface::{Areas, Sample, dot, is_in_reach, length, normal, sub};
use crate::vertex::Kind;
use crate::{Mesh, SimplifyError};

/// Points of the original: so many for each face, and so many more.
const SAMPLES_A_FACE: usize = 4;
const SAMPLES: usize = 80_000;

/// At most so many vertices of the original are watched besides.
const WATCHED: usize = 40_000;

/// Points of the original.
pub(super) struct Points {
    /// Unit normals of their faces.
    pub normals: Vec<[f32; 3]>,
    /// What is closest of the simplified mesh.
    pub found: Vec<ClosestPoint>,
}

/// What the points say of a set of positions.
#[derive(Clone, Copy)]
struct Score {
    /// Sum over the points that are uniform by area.
    squares: f64,
    /// The largest square.
    largest: f64,
    /// The largest square on the way back, from nodes and middles of faces.
    back: f64,
}

pub(super) struct Rounds<'a> {
    net: &'a Net,
    indices: Arc<[[u32; 3]]>,
    normals: Vec<[f32; 3]>,
    /// Points of the original: those with normals are uniform by area, the others are vertices, whose largest distance alone counts.
    points: Vec<[f64; 3]>,
    found: Vec<ClosestPoint>,
    /// To measure the way back.
    stand_in: &'a ClosestPoints,
    hints: Vec<u32>,
    /// Nodes and middles of faces, and what is closest of the original.
    back: (Vec<[f64; 3]>, Vec<ClosestPoint>),
    positions: Vec<[f32; 3]>,
    score: Score,
    /// Sum of squares and positions.
    best: Option<(f64, Vec<[f32; 3]>)>,
    first: Option<Score>,
    /// Squares of how far each node was from the nearest of its faces' points at the start, or of what is far for the spacing of
    /// points.
    alone: Vec<f64>,
    may_move: Vec<bool>,
    curves: Option<&'a Curves>,
    /// Nodes of curves, and which nodes may slide, if they are such.
    sliders: Vec<Slider>,
    may_slide: Vec<bool>,
    /// Nodes that slid last, where they were, and the squares about them.
    slid: Vec<(u32, [f32; 3], f64)>,
    /// How far each node may be from its curve.
    leashes: Vec<f64>,
}

impl<'a> Rounds<'a> {
    /// `None` if the original has no area.
    pub fn start(originals: &Originals<'a>, net: &'a Net, mesh: &Mesh, crease_cosine: f64) -> Option<Self> {
        let original = originals.mesh;
        let areas = Areas::of(original);
        if areas.total() == 0.0 {
            return None;
        }
        let count = SAMPLES + SAMPLES_A_FACE * net.faces.len();
        let mut samples = vec![Sample { point: [0.0; 3], face: 0 }; count];
        areas.sample(0, count, 0, &mut samples);
        let normals = samples
            .iter()
            .map(|sample| {
                let normal = normal(original.faces[sample.face as usize].map(|v| original.positions[v as usize]));
                let scale = 1.0 / length(normal);
                normal.map(|x| (x * scale) as f32)
            })
            .collect();
        let step = original.faces.len().div_ceil(WATCHED).max(1);
        let watched = original.faces.iter().step_by(step).flatten().map(|&v| original.positions[v as usize]);
        let mut points: Vec<[f64; 3]> = samples.iter().map(|sample| sample.point).collect();
        points.extend(watched.step_by(3).filter(|&p| is_in_reach(p)).map(|p| p.map(f64::from)));
        let all = points.len();
        let mut may_move: Vec<bool> = net.kinds.iter().map(|&kind| kind == Kind::Free).collect();
        let (sliders, stay) = sliders(mesh, net, originals.curves, crease_cosine);
        stay.into_iter().for_each(|node| may_move[node as usize] = false);
        let leashes = leashes(&sliders, net, originals.curves);
        let may_slide = vec![originals.curves.is_some(); net.positions.len()];
        Some(Self {
            net,
            indices: net.faces.as_slice().into(),
            normals,
            points,
            found: vec![ClosestPoint::NONE; all],
            stand_in: originals.stand_in,
            curves: originals.curves,
            sliders,
            may_slide,
            leashes,
            slid: vec![],
            hints: vec![u32::MAX; all],
            back: (Vec::new(), Vec::new()),
            positions: net.positions.clone(),
            score: Score { squares: 0.0, largest: 0.0, back: 0.0 },
            best: None,
            first: None,
            // Twice the spacing of points.
            alone: vec![4.0 * areas.total() / count as f64; net.positions.len()],
            may_move,
        })
    }

    /// Measures how far the points are from the positions.
    pub fn measure(&mut self) -> Result<(), SimplifyError> {
        let mesh = TriangleMesh { positions: self.positions.as_slice().into(), indices: Arc::clone(&self.indices) };
        let search = ClosestPoints::build(&mesh, Isa::detect())?;
        if self.first.is_none() {
            search.closest(&self.points, f64::INFINITY, &mut self.found);
        } else {
            search.closest_from(&self.points, &self.hints, f64::INFINITY, &mut self.found);
        }
        let mut score = Score { squares: 0.0, largest: 0.0, back: self.measure_back() };
        for (i, (found, hint)) in self.found.iter().zip(&mut self.hints).enumerate() {
            if i < self.normals.len() {
                score.squares += found.distance_squared;
            }
            score.largest = score.largest.max(found.distance_squared);
            *hint = found.face;
        }
        self.score = score;
        if self.first.is_none() {
            let nearest = self.nearest();
            for ((alone, now), may_move) in self.alone.iter_mut().zip(nearest).zip(&mut self.may_move) {
                *may_move &= now.is_finite();
                *alone = alone.max(1.5 * now);
            }
        }
        self.first.get_or_insert(score);
        let best = self.best.as_ref().map_or(f64::INFINITY, |(best, _)| *best);
        if score.squares < best && self.is_within() {
            self.best = Some((score.squares, self.positions.clone()));
        }
        Ok(())
    }

    /// The largest square of distances from the simplified mesh to the original.
    fn measure_back(&mut self) -> f64 {
        let (points, found) = &mut self.back;
        points.clear();
        points.extend(self.positions.iter().map(|p| p.map(f64::from)));
        points.extend(self.net.faces.iter().map(|face| {
            let [a, b, c] = face.map(|node| self.positions[node as usize].map(f64::from));
            [0, 1, 2].map(|axis| (a[axis] + b[axis] + c[axis]) / 3.0)
        }));
        found.resize(points.len(), ClosestPoint::NONE);
        self.stand_in.closest(points, f64::INFINITY, found);
        found.iter().filter(|found| found.is_found()).map(|found| found.distance_squared).fold(0.0, f64::max)
    }

    /// True if no distance that was measured last is larger than all were at the start.
    pub fn is_within(&self) -> bool {
        self.first.is_none_or(|first| self.score.largest <= first.largest && self.score.back <= first.back)
    }

    /// Moves the nodes; false if none moved.
    pub fn advance(&mut self) -> bool {
        self.take_back();
        self.undo_slides();
        let mut fit = Fit::new(self.net);
        let mean = self.score.squares / self.normals.len() as f64;
        for ((point, normal), found) in self.points.iter().zip(&self.normals).zip(&self.found) {
            if !found.is_found() {
                continue;
            }
            let face = found.face as usize;
            let corners = self.net.faces[face].map(|node| self.positions[node as usize].map(f64::from));
            let weights = found.corner_weights();
            let at = [0, 1, 2].map(|axis| {
                weights[0] * corners[0][axis] + weights[1] * corners[1][axis] + weights[2] * corners[2][axis]
            });
            let normal = normal.map(f64::from);
            // The other side of something thin.
            if dot(normal, self.net.normal(face, &self.positions)) <= 0.0 {
                continue;
            }
            let residual = sub(*point, at);
            let importance = 1.0 + (found.distance_squared / (9.0 * mean)).min(8.0);
            fit.add(&Wish { face: found.face, weights, residual, normal, importance });
        }
        let moves = fit.solve(&self.may_move);
        let mut any = false;
        for (node, wished) in moves.into_iter().enumerate() {
            if self.may_move[node] && wished != [0.0; 3] {
                any |= self.try_to_move(node as u32, wished);
            }
        }
        self.slide() | any
    }

    /// A place for a node, not farther from its curve than it may be.
    fn held(&self, node: u32, there: [f32; 3]) -> [f32; 3] {
        let leash = self.leashes[node as usize];
        let (true, Some(curves)) = (leash.is_finite(), self.curves) else { return there };
        let there_exact = there.map(f64::from);
        let [Some(foot)] = curves.feet([there_exact]) else { return there };
        if foot.distance_squared <= leash * leash {
            return there;
        }
        let part = leash / foot.distance_squared.sqrt();
        [0, 1, 2].map(|axis| (foot.place[axis] + part * (there_exact[axis] - foot.place[axis])) as f32)
    }

    /// Slides nodes along their curves; false if none moved.
    fn slide(&mut self) -> bool {
        let Some(curves) = self.curves else { return false };
        let squares = self.squares_at();
        let mut any = false;
        for i in 0..self.sliders.len() {
            let node = self.sliders[i].node;
            if self.may_slide[node as usize]
                && let Some(there) = wished(&self.sliders[i], curves, &self.positions)
            {
                let before = self.positions[node as usize];
                if self.try_place(node, there.map(|x| x as f32)) {
                    self.slid.push((node, before, squares[node as usize]));
                    any = true;
                }
            }
        }
        any
    }

    /// The sum of the squares of the points that the faces at each node are nearest to.
    fn squares_at(&self) -> Vec<f64> {
        let mut squares = vec![0.0; self.positions.len()];
        for found in self.found.iter().take(self.normals.len()).filter(|found| found.is_found()) {
            for node in self.net.faces[found.face as usize] {
                squares[node as usize] += found.distance_squared;
            }
        }
        squares
    }

    /// Puts nodes that slid to where the surface is farther off back to where they were, to stay there.
    fn undo_slides(&mut self) {
        let squares = self.squares_at();
        for (node, before, least) in std::mem::take(&mut self.slid) {
            if squares[node as usize] > least {
                self.may_slide[node as usize] = false;
                self.try_place(node, before);
            }
        }
    }

    /// Moves a node if its faces stay sound.
    fn try_place(&mut self, node: u32, there: [f32; 3]) -> bool {
        let before = std::mem::replace(&mut self.positions[node as usize], there);
        if there.iter().all(|x| x.is_finite()) && self.net.is_sound_at(node, &self.positions) {
            return there != before;
        }
        self.positions[node as usize] = before;
        false
    }

    /// For each node, the square of its distance to the nearest of the points that its faces are closest to.
    fn nearest(&self) -> Vec<f64> {
        let mut nearest = vec![f64::INFINITY; self.positions.len()];
        for (point, found) in self.points.iter().zip(&self.found).filter(|(_, found)| found.is_found()) {
            for node in self.net.faces[found.face as usize] {
                let away = sub(*point, self.positions[node as usize].map(f64::from));
                let nearest = &mut nearest[node as usize];
                *nearest = nearest.min(dot(away, away));
            }
        }
        nearest
    }

    /// Where something is farther than anything was at the start, the nodes about go back and stay; so do nodes that no points are
    /// near any more, and what would make unsound faces with them.
    pub fn take_back(&mut self) {
        let Some(first) = self.first else { return };
        let mut back: Vec<u32> = Vec::new();
        for (node, nearest) in self.nearest().into_iter().enumerate() {
            if nearest > self.alone[node] {
                back.push(node as u32);
            }
        }
        for found in self.found.iter().filter(|found| found.distance_squared > first.largest && found.is_found()) {
            back.extend(self.net.faces[found.face as usize]);
        }
        let nodes = self.positions.len();
        for (i, _) in self.back.1.iter().enumerate().filter(|(_, found)| found.distance_squared > first.back) {
            match i.checked_sub(nodes) {
                None => back.push(i as u32),
                Some(face) => back.extend(self.net.faces[face]),
            }
        }
        while let Some(node) = back.pop() {
            self.may_move[node as usize] = false;
            self.may_slide[node as usize] = false;
            if self.positions[node as usize] == self.net.positions[node as usize] {
                continue;
            }
            self.positions[node as usize] = self.net.positions[node as usize];
            if !self.net.is_sound_at(node, &self.positions) {
                back.extend(self.net.faces_at(node).iter().flat_map(|&face| self.net.faces[face as usize]));
            }
        }
    }

    /// Moves a node all the way or half of it, if its faces stay sound.
    fn try_to_move(&mut self, node: u32, wished: [f64; 3]) -> bool {
        let before = self.positions[node as usize];
        let limit = 0.5 * self.net.shortest_edge_squared(node, &self.positions).sqrt();
        let far = length(wished);
        let mut scale = if far > limit { limit / far } else { 1.0 };
        for _ in 0..2 {
            let there = [0, 1, 2].map(|axis| (f64::from(before[axis]) + scale * wished[axis]) as f32);
            let there = self.held(node, there);
            self.positions[node as usize] = there;
            if there.iter().all(|x| x.is_finite()) && self.net.is_sound_at(node, &self.positions) {
                return there != before;
            }
            scale *= 0.5;
        }
        self.positions[node as usize] = before;
        false
    }

    /// The best positions that were measured, and the points of the original.
    pub fn finish(self) -> (Vec<[f32; 3]>, Points) {
        let positions = self.best.map_or_else(|| self.net.positions.clone(), |(_, positions)| positions);
        (positions, Points { normals: self.normals, found: self.found })
    }
}
