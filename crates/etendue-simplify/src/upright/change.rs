//! Changes of the surface about a face that is turned over.

use etendue_accel::closest_on_triangle;

use super::nearby::Look;
use super::{Grouped, Nearby, Point, Triangle};
use crate::block::MOVED;
use crate::curves::Curves;
use crate::draft::Draft;
use crate::faces::GONE;
use crate::polish::continue_at;
use crate::surface::dot;
use crate::vertex::Kind;

/// Vertices with more faces are left as they are.
const MOST_FACES: usize = 64;

/// Of a face's twice area over the square of its longest edge: thinner ones are not made.
const THIN: f64 = 1e-3;

/// A change goes at most so far, over the longest edge of the face that it is for, or so many times as far as its faces were.
const OF_EDGE: f64 = 0.05;
const AS_FAR: f64 = 2.0;

/// A mesh with the faces at each of its points.
pub(super) struct Field<'a> {
    pub draft: &'a mut Draft,
    /// The first vertex at the point of each.
    node: &'a [u32],
    curves: Option<&'a Curves>,
    may_move: bool,
    /// Faces of nodes, when the field was made.
    incident: Grouped,
    /// Nodes whose faces are others by now.
    stale: Vec<bool>,
    /// Nodes of faces that were changed.
    stirred: Vec<bool>,
    /// Faces that were changed.
    pub changed: Vec<u32>,
}

/// What may be done.
pub(super) struct Change {
    /// Faces and what their corners become; [`GONE`] if they go.
    faces: Vec<(u32, [u32; 3])>,
    /// A node that moves, and where to.
    moved: Option<(u32, [f32; 3])>,
    /// Nodes whose faces change.
    stale: Vec<u32>,
    /// A point of the surface that was.
    witness: Point,
}

/// What faces were before a change, by their numbers.
struct Before {
    faces: Vec<u32>,
    looks: Vec<(Triangle, Look)>,
}

impl Before {
    /// Of a face and all that share a point with it.
    fn of(field: &Field<'_>, face: u32, nearby: &Nearby) -> Self {
        let faces = field.around(&[face]);
        let triangles = super::triangles(field.draft, &faces);
        let looks = nearby.look(&triangles);
        Self { faces, looks: triangles.into_iter().zip(looks).collect() }
    }

    /// The faces that a change is about.
    fn of_change<'a>(&'a self, change: &'a Change) -> impl Iterator<Item = &'a (Triangle, Look)> {
        change.faces.iter().filter_map(|(face, _)| Some(&self.looks[self.faces.binary_search(face).ok()?]))
    }
}

impl<'a> Field<'a> {
    pub fn of(draft: &'a mut Draft, node: &'a [u32], curves: Option<&'a Curves>, may_move: bool) -> Self {
        let name = |face: &[u32; 3]| if *face == GONE { [0; 3] } else { face.map(|v| node[v as usize]) };
        let names: Vec<[u32; 3]> = draft.mesh.faces.iter().map(name).collect();
        let incident = Grouped::new(node.len(), &names);
        let none = vec![false; node.len()];
        Self { draft, node, curves, may_move, incident, stale: none.clone(), stirred: none, changed: vec![] }
    }

    /// Some faces and those that share a point with them, ascending.
    pub fn around(&self, faces: &[u32]) -> Vec<u32> {
        let mut around: Vec<u32> =
            faces.iter().flat_map(|&face| self.nodes(face)).flat_map(|node| self.faces_at(node)).collect();
        around.sort_unstable();
        around.dedup();
        around
    }

    /// Changes the surface about a face so that fewer faces are turned over; false if nothing is found that does.
    pub fn mend(&mut self, face: u32, nearby: &Nearby) -> bool {
        if self.draft.mesh.faces[face as usize] == GONE || self.nodes(face).iter().any(|&n| self.is_busy(n)) {
            return false;
        }
        let limit = Triangle::of(self.draft, self.draft.mesh.faces[face as usize]).longest_squared * OF_EDGE * OF_EDGE;
        let before = Before::of(self, face, nearby);
        let mut gentle = self.turns(face);
        if self.may_move {
            gentle.extend(self.moves(face, nearby));
        }
        let change = self.best(gentle, &before, limit, nearby);
        let change = change.or_else(|| self.best(self.collapses(face), &before, limit, nearby));
        match change {
            Some(change) => {
                self.apply(change);
                true
            }
            None => false,
        }
    }

    /// True if something about a face was changed.
    pub fn is_stirred(&self, face: u32) -> bool {
        self.draft.mesh.faces[face as usize] != GONE && self.nodes(face).iter().any(|&node| self.stirred[node as usize])
    }

    fn nodes(&self, face: u32) -> [u32; 3] {
        self.draft.mesh.faces[face as usize].map(|v| self.node[v as usize])
    }

    fn faces_at(&self, node: u32) -> impl Iterator<Item = u32> {
        self.incident.of(node).iter().copied().filter(|&face| self.draft.mesh.faces[face as usize] != GONE)
    }

    /// True if what is about a node is not known, or too much.
    fn is_busy(&self, node: u32) -> bool {
        self.stale[node as usize] || self.incident.of(node).len() > MOST_FACES
    }

    fn place(&self, vertex: u32) -> Point {
        self.draft.mesh.positions[vertex as usize].map(f64::from)
    }

    /// The two faces at an edge, as the edge is passed from `a` to `b` and back; `None` if there are others, or only one.
    fn sides(&self, a: u32, b: u32) -> Option<[u32; 2]> {
        let at_both = || self.faces_at(a).filter(|&face| self.nodes(face).contains(&b));
        let passes = |face: &u32| (0..3).any(|i| self.nodes(*face)[i] == a && self.nodes(*face)[(i + 1) % 3] == b);
        let (forth, back) = (at_both().find(passes)?, at_both().find(|face| !passes(face))?);
        (at_both().count() == 2).then_some([forth, back])
    }

    /// The other diagonal for each of a face's edges.
    fn turns(&self, face: u32) -> Vec<Change> {
        (0..3).filter_map(|i| self.turn(face, i)).collect()
    }

    fn turn(&self, face: u32, i: usize) -> Option<Change> {
        let mesh = &self.draft.mesh;
        let [a, b, c] = [0, 1, 2].map(|k| mesh.faces[face as usize][(i + k) % 3]);
        let [p, q, r] = [a, b, c].map(|v| self.node[v as usize]);
        let [_, other] = self.sides(p, q).filter(|[forth, _]| *forth == face)?;
        let j = (0..3).find(|&j| self.nodes(other)[j] == q)?;
        let [b2, a2, d] = [0, 1, 2].map(|k| mesh.faces[other as usize][(j + k) % 3]);
        let s = self.node[d as usize];
        let is_seam =
            [a, b] != [a2, b2] || mesh.materials.as_ref().is_some_and(|m| m[face as usize] != m[other as usize]);
        let is_there = || self.faces_at(r).any(|face| self.nodes(face).contains(&s));
        if is_seam || r == s || self.is_busy(s) || is_there() {
            return None;
        }
        let (from, to) = (self.place(a), self.place(b));
        // A crease is kept.
        if self.curves.is_some_and(|curves| curves.join([from, to])) {
            return None;
        }
        Some(Change {
            faces: vec![(face, [a, d, c]), (other, [d, b, c])],
            moved: None,
            stale: vec![p, q, r, s],
            witness: [0, 1, 2].map(|axis| 0.5 * (from[axis] + to[axis])),
        })
    }

    /// Other places for each of a face's corners that may move: amid its neighbours, and where the original is nearest to that and to
    /// the corner.
    fn moves(&self, face: u32, nearby: &Nearby) -> Vec<Change> {
        let free = self.nodes(face).into_iter().filter(|&node| self.draft.kinds[node as usize] == Kind::Free);
        free.flat_map(|node| {
            let mut sum = [0.0; 3];
            let mut count = 0.0;
            for face in self.faces_at(node) {
                for other in self.nodes(face).into_iter().filter(|&other| other != node) {
                    let place = self.place(other);
                    sum = [0, 1, 2].map(|axis| sum[axis] + place[axis]);
                    count += 1.0;
                }
            }
            let (here, amid) = (self.place(node), sum.map(|x| x / count));
            let [near_amid, near_here] = nearby.places([amid, here]);
            let half = [0, 1, 2].map(|axis| 0.5 * (here[axis] + near_amid[axis]));
            let faces: Vec<_> = self.faces_at(node).map(|face| (face, self.draft.mesh.faces[face as usize])).collect();
            [near_amid, near_here, half, amid].map(|place| Change {
                faces: faces.clone(),
                moved: Some((node, place.map(|x| x as f32))),
                stale: vec![],
                witness: here,
            })
        })
        .collect()
    }

    /// Each of a face's corners into each other.
    fn collapses(&self, face: u32) -> Vec<Change> {
        let [a, b, c] = self.nodes(face);
        [[a, b], [b, a], [b, c], [c, b], [c, a], [a, c]]
            .into_iter()
            .filter_map(|[from, to]| self.collapse(from, to))
            .collect()
    }

    /// A free vertex into another.
    pub(super) fn collapse(&self, from: u32, to: u32) -> Option<Change> {
        let mesh = &self.draft.mesh;
        let is_alone = |vertex: u32| {
            let next = self.node.get(vertex as usize + 1);
            next.is_none_or(|&next| next != vertex)
        };
        if self.draft.kinds[from as usize] != Kind::Free || !is_alone(from) || self.is_busy(to) {
            return None;
        }
        let sides = self.sides(from, to)?;
        let vertex_of = |face: u32| mesh.faces[face as usize].into_iter().find(|&v| self.node[v as usize] == to);
        let becomes = vertex_of(sides[0])?;
        let beside = |node: u32| {
            let mut all: Vec<u32> = self.faces_at(node).flat_map(|face| self.nodes(face)).collect();
            all.sort_unstable();
            all.dedup();
            all
        };
        let (near_from, near_to) = (beside(from), beside(to));
        let shared = near_from.iter().filter(|n| near_to.binary_search(n).is_ok()).count();
        // The ends themselves, and the third corner of each side.
        if vertex_of(sides[1]) != Some(becomes) || shared != 4 {
            return None;
        }
        let faces: Vec<(u32, [u32; 3])> = self
            .faces_at(from)
            .map(|face| {
                let corners = mesh.faces[face as usize];
                (face, if sides.contains(&face) { GONE } else { corners.map(|v| if v == from { becomes } else { v }) })
            })
            .collect();
        let names = |corners: [u32; 3]| {
            let mut names = corners.map(|v| self.node[v as usize]);
            names.sort_unstable();
            names
        };
        let is_there =
            |corners: [u32; 3]| self.faces_at(to).any(|face| names(mesh.faces[face as usize]) == names(corners));
        if faces.len() < 4 && faces.iter().any(|(_, corners)| *corners != GONE && is_there(*corners)) {
            return None;
        }
        let mut stale = near_from;
        stale.extend(near_to);
        Some(Change { faces, moved: None, stale, witness: self.place(from) })
    }

    /// A changed face.
    fn changed(&self, change: &Change, corners: [u32; 3]) -> Triangle {
        Triangle::at(
            corners.map(|v| match change.moved {
                Some((node, place)) if self.node[v as usize] == node => place,
                _ => self.draft.mesh.positions[v as usize],
            }),
            self.draft.rounding,
        )
    }

    /// Of some changes the one that leaves the fewest faces turned over, and of these the one that goes the least far; `None` if all
    /// leave as many as there are, make faces that are hardly any, or go farther than a squared limit.
    fn best(&self, changes: Vec<Change>, before: &Before, limit: f64, nearby: &Nearby) -> Option<Change> {
        let mut faces: Vec<Triangle> = Vec::new();
        let mut fine: Vec<(Change, usize)> = Vec::new();
        for change in changes {
            let first = faces.len();
            let stays = change.faces.iter().filter(|(_, corners)| *corners != GONE);
            faces.extend(stays.map(|&(_, corners)| self.changed(&change, corners)));
            let worst = before.of_change(&change).map(|(face, _)| face.shape()).fold(THIN * THIN, f64::min);
            if faces[first..].iter().all(|face| face.is_surface && face.shape() >= worst) {
                fine.push((change, faces.len()));
            } else {
                faces.truncate(first);
            }
        }
        let looks = nearby.look(&faces);
        let mut first = 0;
        let mut best: Option<((usize, f64), Change)> = None;
        for (change, end) in fine {
            let (faces, are) = (&faces[first..end], &looks[first..end]);
            first = end;
            let away = faces.iter().map(|face| face.distance_squared(change.witness)).fold(f64::INFINITY, f64::min);
            let goes = are.iter().map(|look| look.far).fold(away, f64::max);
            let turned = are.iter().filter(|look| look.turned).count();
            let were = before.of_change(&change).filter(|(_, look)| look.turned).count();
            let went = before.of_change(&change).map(|(_, look)| look.far).fold(0.0, f64::max);
            let is_better = best.as_ref().is_none_or(|(least, _)| (turned, goes) < *least);
            if is_better && turned < were && goes <= limit.max(AS_FAR * AS_FAR * went) {
                best = Some(((turned, goes), change));
            }
        }
        best.map(|(_, change)| change)
    }

    fn apply(&mut self, change: Change) {
        if let Some((node, place)) = change.moved {
            let end = self.node[node as usize..].iter().position(|&first| first != node);
            let end = end.map_or(self.node.len(), |count| node as usize + count);
            for v in node as usize..end {
                let faces: Vec<u32> =
                    self.faces_at(node).filter(|&f| self.draft.mesh.faces[f as usize].contains(&(v as u32))).collect();
                continue_at(&mut self.draft.mesh, v, &faces, place.map(f64::from));
            }
            for v in node as usize..end {
                self.draft.mesh.positions[v] = place;
                self.draft.sources[v] = MOVED;
            }
        }
        for (face, corners) in change.faces {
            let before = self.nodes(face);
            before.iter().for_each(|&node| self.stirred[node as usize] = true);
            self.draft.mesh.faces[face as usize] = corners;
            self.changed.push(face);
        }
        for node in change.stale {
            self.stale[node as usize] = true;
        }
    }
}

impl Triangle {
    /// The square of twice its area over the square of its longest edge.
    fn shape(&self) -> f64 {
        dot(self.normal, self.normal) / (self.longest_squared * self.longest_squared)
    }

    /// The square of the distance to a point.
    fn distance_squared(&self, point: Point) -> f64 {
        // Corners come from single precision.
        closest_on_triangle(point, &self.corners.map(|corner| corner.map(|x| x as f32))).0
    }
}
