//! Which edges may be collapsed.

use etendue_accel::prefetch;

use crate::block::{Block, Kept, Refusal};
use crate::faces::GONE;
use crate::prepare::from_corner;
use crate::surface::{length, normal};
use crate::vector::{Vec3, add, area_normal, dot, sub};
use crate::vertex::Kind;

/// The normal of a face may turn by the angle of this cosine at once.
const TURN: f32 = 0.25;
/// Of a face's twice area over the square of its longest edge: thinner ones are not made.
const THIN: f32 = 1e-3;
/// The cosine of the angle by which a face that turns further may differ from the original's normals at its corners.
const FACING: f32 = 0.5;

impl Block<'_> {
    /// The link condition (Dey, Edelsbrunner, Guha and Nekhayev 1999), and that borders stay borders. Sets `kept` and
    /// `shared`.
    pub(super) fn check_topology(&mut self, a: u32, b: u32) -> Result<(), Refusal> {
        let epoch = self.next_epoch();
        self.shared.clear();
        self.kept[0].clear();
        self.kept[1].clear();
        let [start, len] = self.spans[a as usize];
        for &face in &self.rings[start as usize..(start + len) as usize] {
            let corners = self.faces.corners[face as usize];
            if corners == GONE {
                continue;
            }
            let [_, next, last] = from_corner(corners, a);
            self.fetch(next);
            self.marks[next as usize] = epoch;
            self.marks[last as usize] = epoch;
            if next == b || last == b {
                self.shared.push([face, if next == b { last } else { next }]);
            } else {
                self.kept[0].push(Kept { next, last, face });
            }
        }
        for &[_, third] in &self.shared {
            self.marks[third as usize] = epoch - 1;
        }
        let mut joined = None;
        let [start, len] = self.spans[b as usize];
        for &face in &self.rings[start as usize..(start + len) as usize] {
            let corners = self.faces.corners[face as usize];
            if corners == GONE {
                continue;
            }
            let [_, next, last] = from_corner(corners, b);
            self.fetch(next);
            if next != a && last != a {
                joined = joined.or([next, last].into_iter().find(|&v| self.marks[v as usize] == epoch));
                self.kept[1].push(Kept { next, last, face });
            }
        }
        // A vertex that is next to both ends, but not by a face of the edge: two sheets would become one.
        if let Some(c) = joined {
            return Err(Refusal::Joins(c));
        }
        let has = |kept: &[Kept], v: u32| kept.iter().any(|face| face.next == v || face.last == v);
        match *self.shared {
            [[_, c]] => {
                // A triangle on its own would vanish.
                if !has(&self.kept[0], c) && !has(&self.kept[1], c) {
                    return Err(Refusal::Topology);
                }
            }
            [[f, c], [g, d]] => {
                let both = |kept: &[Kept]| {
                    kept.iter().any(|face| [face.next, face.last] == [c, d] || [face.next, face.last] == [d, c])
                };
                if c == d || (both(&self.kept[0]) && both(&self.kept[1])) {
                    return Err(Refusal::Topology);
                }
                let (first, second) = (self.vertices[a as usize].kind, self.vertices[b as usize].kind);
                if first != Kind::Free && second != Kind::Free && !self.is_border(f, g, a, b) {
                    return Err(Refusal::Border);
                }
            }
            _ => return Err(Refusal::Topology),
        }
        Ok(())
    }

    /// Asks memory for what faces at a vertex are judged by. Each neighbour is the next corner of a face, but for open fans.
    #[inline(always)]
    fn fetch(&self, v: u32) {
        prefetch(&self.vertices[v as usize]);
        prefetch(&self.facing[v as usize]);
    }

    /// Sets `pairs`. A wedge of one end that meets two of the other, where a seam closes, would become both of them, or they it: one
    /// side of the seam would have the texture of the other.
    pub(super) fn check_wedges(&mut self, a: u32, b: u32) -> Result<(), Refusal> {
        self.pairs = self.pairs_of(a, b);
        match *self.pairs {
            [[i, j], [k, l]] if i == k || j == l => Err(Refusal::Border),
            _ => Ok(()),
        }
    }

    /// True if a border runs between two faces at an edge.
    fn is_border(&self, f: u32, g: u32, a: u32, b: u32) -> bool {
        let materials = self.faces.materials.as_ref();
        materials.is_some_and(|materials| materials[f as usize] != materials[g as usize])
            || self.wedge(f, a) != self.wedge(g, a)
            || self.wedge(f, b) != self.wedge(g, b)
    }

    /// True if no face that stays turns too far or gets too thin when both ends go to `place`, which is what they will be at to the bit:
    /// rounding may put corners on a line.
    pub(super) fn turns_none(&self, a: u32, b: u32, place: Vec3) -> bool {
        let facing = add(self.facing[a as usize], self.facing[b as usize]);
        for (kept, v) in self.kept.iter().zip([a, b]) {
            let before = self.vertices[v as usize].position;
            for face in kept {
                let q = self.vertices[face.next as usize].position;
                let r = self.vertices[face.last as usize].position;
                let old = area_normal(before, q, r);
                let new = area_normal(place, q, r);
                let (old2, new2) = (dot(old, old), dot(new, new));
                let along = dot(old, new);
                let longest = longest2(place, q, r);
                // What is smaller than the error may lie as it likes, but have an area.
                if longest < self.worst && new2 > THIN * THIN * THIN * longest * longest {
                    continue;
                }
                // A little at a time adds up: none may come to lie against the original's faces at all its corners.
                let against = |n: Vec3| dot(n, new) < 0.0;
                if against(facing)
                    && against(self.facing[face.next as usize])
                    && against(self.facing[face.last as usize])
                {
                    return false;
                }
                if old2 > 0.0 && (along <= 0.0 || along * along < TURN * TURN * old2 * new2) {
                    // What was small and crooked may turn to where the original faces.
                    let corners = [facing, self.facing[face.next as usize], self.facing[face.last as usize]];
                    if corners.into_iter().any(|n| dot(n, new) < FACING * (dot(n, n) * new2).sqrt()) {
                        return false;
                    }
                }
                if new2 < THIN * THIN * longest * longest {
                    // One that is thin already may stay so, if what is left is not rounding alone.
                    let was = longest2(before, q, r);
                    if old2 * longest * longest >= new2 * was * was || length(normal([place, q, r])) == 0.0 {
                        return false;
                    }
                }
            }
        }
        true
    }
}

#[inline(always)]
fn longest2(a: Vec3, b: Vec3, c: Vec3) -> f32 {
    let length = |p: Vec3, q: Vec3| {
        let d = sub(p, q);
        dot(d, d)
    };
    length(a, b).max(length(b, c)).max(length(c, a))
}
