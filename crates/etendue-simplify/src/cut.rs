//! Handles and tunnels that are in the way.
//!
//! Where two ends of an edge share a neighbour but not its face, the three edges run round a handle or a tunnel, and the
//! collapse would pinch it into an edge of four faces. Instead the surface is cut along the three edges and both cuts are closed by a
//! triangle: the shape stays as it is and closed, and has one handle fewer. Scanned surfaces have many, smaller than
//! their noise.

use etendue_accel::prefetch;

use crate::block::{Block, MOVED};
use crate::faces::Faces;
use crate::prepare::from_corner;
use crate::vector::{add, area_normal, scale, sub};
use crate::vertex::Kind;

/// So many vertices are looked at to see that the sides of a cut are connected.
const LOOK: usize = 4096;
/// The sides of a cut are moved apart by this part of the way to their neighbours, so that they do not touch.
const APART: f32 = 0.01;

impl Block<'_> {
    /// Cuts the surface along three edges that are no face; false if they are not on a surface that allows it.
    pub(crate) fn cut(&mut self, cycle: [u32; 3]) -> bool {
        let free = cycle.iter().all(|&v| {
            let vertex = &self.vertices[v as usize];
            vertex.kind == Kind::Free && !vertex.held
        });
        if !free || self.metric.keep_topology || !self.wedges.is_empty() || self.graves.len() < 3 {
            return false;
        }
        let [a, b, c] = cycle;
        let mut sides = Vec::with_capacity(3);
        for [before, v, after] in [[c, a, b], [a, b, c], [b, c, a]] {
            match self.sides(before, v, after) {
                Some(side) => sides.push(side),
                None => return false,
            }
        }
        if !self.is_handle(cycle, &sides) {
            return false;
        }
        self.split(cycle, &sides);
        true
    }

    /// The faces at `v` left and right of the way from `before` to `after`.
    fn sides(&self, before: u32, v: u32, after: u32) -> Option<[Vec<u32>; 2]> {
        let leaves: Vec<[u32; 3]> = self
            .ring(v)
            .iter()
            .filter(|&&face| !self.faces.is_gone(face))
            .map(|&face| {
                let [_, next, last] = from_corner(self.faces.corners[face as usize], v);
                [next, last, face]
            })
            .collect();
        let (mut left, mut at) = (Vec::new(), after);
        while at != before {
            let leaf = leaves.iter().find(|leaf| leaf[0] == at)?;
            left.push(leaf[2]);
            at = leaf[1];
            if left.len() > leaves.len() {
                return None;
            }
        }
        let right: Vec<u32> = leaves.iter().map(|leaf| leaf[2]).filter(|face| !left.contains(face)).collect();
        (left.len() > 1 && right.len() > 1).then_some([left, right])
    }

    /// True if the sides of the cycle are seen to be connected other than through it: a neck that is cut would leave two
    /// pieces, of which the smaller would wither.
    fn is_handle(&mut self, cycle: [u32; 3], sides: &[[Vec<u32>; 2]]) -> bool {
        let goal = self.next_epoch();
        let seen = goal - 1;
        let size = |side: usize| sides.iter().map(|s| s[side].len()).sum::<usize>();
        // From the smaller side: if it is a piece, it ends soon.
        let from = usize::from(size(1) < size(0));
        for (side, mark) in [(1 - from, goal), (from, seen)] {
            for &face in sides.iter().flat_map(|s| &s[side]) {
                for v in self.faces.corners[face as usize] {
                    if !cycle.contains(&v) {
                        // A vertex next to both sides.
                        if mark == seen && self.marks[v as usize] == goal {
                            return true;
                        }
                        self.marks[v as usize] = mark;
                    }
                }
            }
        }
        for v in cycle {
            self.marks[v as usize] = seen;
        }
        let mut found: Vec<u32> = Vec::with_capacity(256);
        for &face in sides.iter().flat_map(|s| &s[from]) {
            found.extend(self.faces.corners[face as usize].iter().filter(|v| !cycle.contains(v)));
        }
        let mut next = 0;
        while next < found.len() && found.len() <= LOOK {
            let v = found[next] as usize;
            next += 1;
            // Each is one step of a chain of indices ahead of the one before.
            if let Some(first) = found.get(next + 8).and_then(|&far| self.ring(far).first()) {
                prefetch(first);
            }
            if let Some(&near) = found.get(next + 3) {
                self.ring(near).iter().for_each(|&face| prefetch(&self.faces.corners[face as usize]));
            }
            // What is held has faces elsewhere, too.
            let [start, len] = self.spans[v];
            for &face in &self.rings[start as usize..(start + len) as usize] {
                if self.faces.is_gone(face) {
                    continue;
                }
                for n in self.faces.corners[face as usize] {
                    if self.marks[n as usize] == goal {
                        return true;
                    }
                    if self.marks[n as usize] != seen {
                        self.marks[n as usize] = seen;
                        found.push(n);
                    }
                }
            }
        }
        false
    }

    fn split(&mut self, cycle: [u32; 3], sides: &[[Vec<u32>; 2]]) {
        let copies = cycle.map(|_| self.graves.pop().unwrap_or_default());
        let caps = [self.cap([cycle[0], cycle[2], cycle[1]], sides[0][0][0]), self.cap(copies, sides[0][1][0])];
        for ((&v, &copy), [left, right]) in cycle.iter().zip(&copies).zip(sides) {
            for &face in right {
                for corner in &mut self.faces.corners[face as usize] {
                    if *corner == v {
                        *corner = copy;
                    }
                }
            }
            let old = self.vertices[copy as usize].stamp;
            let vertex = &mut self.vertices[v as usize];
            // Each side answers for half of what was merged.
            let quadric = &mut vertex.quadric;
            quadric.a = quadric.a.map(|x| 0.5 * x);
            quadric.b = scale(quadric.b, 0.5);
            quadric.c *= 0.5;
            quadric.w *= 0.5;
            vertex.stamp = vertex.stamp.wrapping_add(1);
            let mut second = *vertex;
            second.stamp = old.wrapping_add(1);
            self.vertices[copy as usize] = second;
            for (vertex, faces) in [(v, left), (copy, right)] {
                self.facing[vertex as usize] = self.normal_of(faces);
            }
            for (vertex, faces, cap) in [(v, left, caps[0]), (copy, right, caps[1])] {
                let mut ring = faces.clone();
                ring.push(cap);
                self.set_ring(vertex, &ring);
            }
        }
        let ends = [cycle, copies];
        let moves = ends.map(|ends| ends.map(|v| self.inwards(v, &ends)));
        for (&v, by) in ends.as_flattened().iter().zip(moves.as_flattened()) {
            let vertex = &mut self.vertices[v as usize];
            vertex.position = add(vertex.position, *by);
            vertex.quadric = vertex.quadric.moved(*by);
            self.sources[v as usize] = MOVED;
        }
        self.cuts += 1;
        for v in ends.as_flattened() {
            self.requeue(*v);
        }
    }

    /// The sum of the normals of faces, as long as their areas.
    fn normal_of(&self, faces: &[u32]) -> [f32; 3] {
        faces.iter().fold([0.0; 3], |sum, &face| {
            let [a, b, c] = self.faces.corners[face as usize].map(|v| self.vertices[v as usize].position);
            add(sum, area_normal(a, b, c))
        })
    }

    /// A part of the way to the mean of a vertex's neighbours that are not at the cut.
    fn inwards(&mut self, v: u32, cut: &[u32; 3]) -> [f32; 3] {
        self.neighbours(v);
        let origin = self.vertices[v as usize].position;
        let mut sum = [0.0; 3];
        let mut count = 0.0;
        for &n in self.around.iter().filter(|n| !cut.contains(n)) {
            sum = add(sum, sub(self.vertices[n as usize].position, origin));
            count += 1.0;
        }
        scale(sum, if count > 0.0 { APART / count } else { 0.0 })
    }

    /// A new face with what belongs to `like`.
    fn cap(&mut self, corners: [u32; 3], like: u32) -> u32 {
        let Faces { corners: all, materials, .. } = &mut self.faces;
        all.push(corners);
        if let Some(materials) = materials {
            materials.push(materials[like as usize]);
        }
        self.live += 1;
        all.len() as u32 - 1
    }
}
