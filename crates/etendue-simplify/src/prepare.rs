//! From a mesh as it came to clean faces on welded points, with a kind and a quadric for each point.

use rayon::prelude::*;

use crate::engine::Work;
use crate::faces::Faces;
use crate::metric::Metric;
use crate::quadric::Quadric;
use crate::report::Dropped;
use crate::rings::Rings;
use crate::vector::{Vec3, add, cross, dot, scale, sub};
use crate::vertex::{Kind, Vertex};
use crate::wedges::{Layout, Wedges};
use crate::weld::{NONE, Welded, weld};
use crate::{MeshRef, Options, SimplifyError};

/// Weight of the planes that stand on open edges and on borders, over that of faces.
const BORDER_WEIGHT: f32 = 20.0;
/// The same of creases, whose faces already hold them.
const CREASE_WEIGHT: f32 = 0.1;

/// Refuses lengths and indices that are wrong, and more than the engine counts.
pub(crate) fn validate(mesh: &MeshRef<'_>) -> Result<(), SimplifyError> {
    let (vertices, faces) = (mesh.positions.len(), mesh.faces.len());
    let lengths = [
        ("normals", mesh.normals.map(<[_]>::len), vertices),
        ("texture coordinates", mesh.uvs.map(<[_]>::len), vertices),
        ("colours", mesh.colors.map(<[_]>::len), vertices),
        ("materials", mesh.materials.map(<[_]>::len), faces),
    ];
    for (what, found, expected) in lengths {
        if let Some(found) = found.filter(|&found| found != expected) {
            return Err(SimplifyError::BadLength { what, found, expected });
        }
    }
    // Corners are counted in 32 bits.
    for (what, found, most) in
        [("vertices", vertices, u32::MAX as usize - 1), ("faces", faces, (u32::MAX / 3) as usize)]
    {
        if found > most {
            return Err(SimplifyError::TooLarge { what, found });
        }
    }
    let bad = mesh.faces.par_iter().position_first(|face| face.iter().any(|&v| v as usize >= vertices));
    if let Some(face) = bad {
        let vertex = mesh.faces[face].into_iter().find(|&v| v as usize >= vertices).unwrap_or_default();
        return Err(SimplifyError::BadIndex { face, vertex, vertices });
    }
    Ok(())
}

/// Cleans, welds and measures a valid mesh.
pub(crate) fn prepare(mesh: &MeshRef<'_>, options: &Options, metric: &Metric) -> (Work, Dropped) {
    let welded = weld(mesh.positions, mesh.faces);
    let mut dropped = Dropped::default();
    let mut faces = Vec::with_capacity(mesh.faces.len());
    let mut materials = mesh.materials.filter(|_| options.keep.materials).map(|_| Vec::with_capacity(mesh.faces.len()));
    // Which faces were kept, if that matters.
    let has_wedges = Layout::of(mesh, options.keep).len() > 0;
    let mut kept = Vec::new();
    for (i, face) in mesh.faces.iter().enumerate() {
        let [a, b, c] = face.map(|v| welded.point_of[v as usize]);
        if a == NONE || b == NONE || c == NONE {
            dropped.non_finite += 1;
        } else if a == b || b == c || c == a {
            dropped.degenerate += 1;
        } else {
            faces.push([a, b, c]);
            if has_wedges {
                kept.push(i as u32);
            }
            if let (Some(to), Some(from)) = (&mut materials, mesh.materials) {
                to.push(from[i]);
            }
        }
    }
    let Welded { order, point_of, vertex_of, extent } = welded;
    // A power of two changes no digit; the engine works near 1, where no product overflows or vanishes.
    let unit = power_of_two_above(extent);
    let layout = Layout::of(mesh, options.keep);
    let crease_cosine = libm::cos(options.crease_angle) as f32;
    let mut wedges = (layout.len() > 0).then(|| Wedges::group(mesh, layout, &order, &point_of, unit, crease_cosine));
    drop(order);
    let mut locked = vec![false; vertex_of.len()];
    for &v in &options.locked {
        if let Some(&point) = point_of.get(v as usize).filter(|&&point| point != NONE) {
            locked[point as usize] = true;
        }
    }
    drop(point_of);
    let mut corners = wedges.as_mut().map(|(_, wedge_of)| {
        let wedge_of = std::mem::take(wedge_of);
        kept.iter().map(|&face| mesh.faces[face as usize].map(|v| wedge_of[v as usize])).collect::<Vec<_>>()
    });
    drop(kept);
    let mut rings = Rings::new(vertex_of.len(), &faces);
    let duplicates = duplicates(&rings, &faces);
    if !duplicates.is_empty() {
        dropped.duplicate = duplicates.len();
        remove(&mut faces, &duplicates);
        if let Some(materials) = &mut materials {
            remove(materials, &duplicates);
        }
        if let Some(corners) = &mut corners {
            remove(corners, &duplicates);
        }
        rings = Rings::new(vertex_of.len(), &faces);
    }
    let positions: Vec<Vec3> =
        vertex_of.par_iter().map(|&v| mesh.positions[v as usize].map(|x| (f64::from(x) / unit) as f32 + 0.0)).collect();
    let surface = Surface {
        positions: &positions,
        faces: &faces,
        rings: &rings,
        materials: materials.as_deref(),
        corners: corners.as_deref(),
        locked: &locked,
        keep_boundary: options.keep_boundary,
        crease_cosine,
        metric,
    };
    let (mut vertices, facing): (Vec<Vertex>, Vec<Vec3>) = (0..positions.len())
        .into_par_iter()
        .with_min_len(1024)
        .map_init(Fan::default, |fan, v| surface.vertex(v, fan))
        .unzip();
    let curves = surface.curves(&vertices, &vertex_of);
    let wedges = wedges.map(|(mut wedges, _)| {
        if let Some(corners) = &corners {
            wedges.measure(&positions, &faces, corners, |v| rings.at(v), &mut vertices);
        }
        wedges
    });
    let faces = Faces { corners: faces, wedges: corners, materials };
    let keep_stand_in = options.polish && !options.fast;
    (Work { vertices, facing, sources: vertex_of, faces, wedges, unit, curves, stand_in: None, keep_stand_in }, dropped)
}

/// A surface that is all curves has none to follow: one that is rough, or triangles on their own. At most so many edges, and one for so
/// many faces more.
const CURVES: usize = 20_000;
const CURVE_OF: usize = 8;

/// The least power of two that is not below `x`; 1 for 0.
fn power_of_two_above(x: f32) -> f64 {
    let mut unit = 1.0;
    let x = f64::from(x);
    while x > unit {
        unit *= 2.0;
    }
    while x > 0.0 && x <= 0.5 * unit {
        unit *= 0.5;
    }
    unit
}

/// Faces that repeat an earlier one, ascending.
fn duplicates(rings: &Rings, faces: &[[u32; 3]]) -> Vec<u32> {
    let mut found: Vec<u32> = (0..rings.len() as u32)
        .into_par_iter()
        .with_min_len(1024)
        .map_init(Vec::new, |own, v| {
            own.clear();
            for &face in rings.at(v as usize) {
                let [_, next, last] = from_corner(faces[face as usize], v);
                if v < next && v < last {
                    own.push((next, last, face));
                }
            }
            own.sort_unstable();
            own.windows(2)
                .filter(|pair| pair[0].0 == pair[1].0 && pair[0].1 == pair[1].1)
                .map(|pair| pair[1].2)
                .collect::<Vec<_>>()
        })
        .flatten_iter()
        .collect();
    found.sort_unstable();
    found
}

/// Without the entries at `indices`, which ascend.
fn remove<T: Copy>(list: &mut Vec<T>, indices: &[u32]) {
    let mut next = indices.iter().peekable();
    let mut i = 0;
    list.retain(|_| {
        let gone = next.peek() == Some(&&i);
        if gone {
            next.next();
        }
        i += 1;
        !gone
    });
}

/// The corners in their order, beginning with `v`, which is one of them.
#[inline(always)]
pub(crate) fn from_corner(face: [u32; 3], v: u32) -> [u32; 3] {
    let [a, b, c] = face;
    if a == v {
        [a, b, c]
    } else if b == v {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// The faces at one vertex.
#[derive(Default)]
struct Fan {
    /// Per face: the corner after the vertex, the one before it, the face.
    leaves: Vec<[u32; 3]>,
    /// The corner after, and the index of the leaf; sorted if there are many.
    after: Vec<(u32, u32)>,
    /// Per leaf: the leaf on the other side of the edge to the corner before.
    next: Vec<Option<u32>>,
    /// Per leaf: the unit normal of its face, and twice its area.
    normals: Vec<(Vec3, f32)>,
    /// Per leaf: how many others have it as their next.
    entered: Vec<u32>,
}

/// How many leaves are searched one by one.
const FEW: usize = 24;

impl Fan {
    fn set(&mut self, v: u32, ring: &[u32], faces: &[[u32; 3]]) {
        self.leaves.clear();
        self.leaves.extend(ring.iter().map(|&face| {
            let [_, after, before] = from_corner(faces[face as usize], v);
            [after, before, face]
        }));
        self.next.clear();
        if self.leaves.len() <= FEW {
            for leaf in &self.leaves {
                self.next.push(self.leaves.iter().position(|other| other[0] == leaf[1]).map(|j| j as u32));
            }
        } else {
            self.after.clear();
            self.after.extend(self.leaves.iter().zip(0..).map(|(leaf, j)| (leaf[0], j)));
            self.after.sort_unstable();
            for leaf in &self.leaves {
                let j = self.after.partition_point(|&(after, _)| after < leaf[1]);
                self.next.push(self.after.get(j).filter(|entry| entry.0 == leaf[1]).map(|entry| entry.1));
            }
        }
        self.entered.clear();
        self.entered.resize(self.leaves.len(), 0);
        for next in self.next.iter().flatten() {
            self.entered[*next as usize] += 1;
        }
    }

    /// True if all leaves are one disc, or one half disc, with the vertex at its middle.
    fn is_manifold(&self) -> bool {
        let n = self.leaves.len();
        if n == 0 {
            return true;
        }
        if self.entered.iter().any(|&count| count > 1) {
            return false;
        }
        let mut firsts = (0..n).filter(|&j| self.entered[j] == 0);
        let first = firsts.next();
        if firsts.next().is_some() {
            return false;
        }
        let start = first.unwrap_or(0);
        let (mut at, mut steps) = (start, 0);
        loop {
            steps += 1;
            match self.next[at] {
                Some(next) if next as usize != start && steps <= n => at = next as usize,
                _ => break,
            }
        }
        if steps != n {
            return false;
        }
        // An open fan whose ends are one vertex: two faces in different senses at an edge.
        first.is_none_or(|first| self.leaves[first][0] != self.leaves[at][1])
    }
}

struct Surface<'a> {
    positions: &'a [Vec3],
    faces: &'a [[u32; 3]],
    rings: &'a Rings,
    materials: Option<&'a [u32]>,
    corners: Option<&'a [[u32; 3]]>,
    locked: &'a [bool],
    keep_boundary: bool,
    crease_cosine: f32,
    metric: &'a Metric,
}

impl Surface<'_> {
    /// The edges of curves, by vertices of the input; none if there are too many.
    fn curves(&self, vertices: &[Vertex], vertex_of: &[u32]) -> Vec<[u32; 2]> {
        let most = CURVES + self.faces.len() / CURVE_OF;
        let on_curves: Vec<usize> = (0..vertices.len()).filter(|&v| vertices[v].has_curve).collect();
        // Each edge has two ends.
        if on_curves.len() > 2 * most {
            return Vec::new();
        }
        let edges: Vec<[u32; 2]> =
            on_curves.into_par_iter().map_init(Fan::default, |fan, v| self.curves_at(v, fan)).flatten_iter().collect();
        if edges.len() > most {
            return Vec::new();
        }
        edges.into_iter().map(|ends| ends.map(|v| vertex_of[v as usize])).collect()
    }

    fn vertex(&self, v: usize, fan: &mut Fan) -> (Vertex, Vec3) {
        fan.set(v as u32, self.rings.at(v), self.faces);
        let origin = self.positions[v];
        fan.normals.clear();
        fan.normals.extend(fan.leaves.iter().map(|leaf| {
            let [p, q] = [leaf[0], leaf[1]].map(|n| sub(self.positions[n as usize], origin));
            let normal = cross(p, q);
            let length = dot(normal, normal).sqrt();
            (if length > 0.0 { scale(normal, 1.0 / length) } else { [0.0; 3] }, length)
        }));
        let facing = fan.normals.iter().fold([0.0; 3], |sum, (normal, length)| add(sum, scale(*normal, *length)));
        let mut quadric = Quadric::default();
        for leaf in &fan.leaves {
            quadric = quadric.plus(&self.metric.face(self.faces[leaf[2] as usize], self.positions, origin));
        }
        let mut features = 0;
        let mut open = 0;
        let mut creases = 0;
        for ((leaf, next), &(normal, _)) in fan.leaves.iter().zip(&fan.next).zip(&fan.normals) {
            let Some(next) = next else {
                open += 1;
                self.stand(&mut quadric, origin, leaf[1], normal, BORDER_WEIGHT);
                continue;
            };
            let other = fan.leaves[*next as usize];
            let other_normal = fan.normals[*next as usize].0;
            if self.is_border(v as u32, leaf, &other) {
                features += 1;
                self.stand(&mut quadric, origin, leaf[1], normal, BORDER_WEIGHT);
            } else if dot(normal, other_normal) < self.crease_cosine {
                creases += 1;
                self.stand(&mut quadric, origin, leaf[1], normal, CREASE_WEIGHT);
                self.stand(&mut quadric, origin, leaf[1], other_normal, CREASE_WEIGHT);
            }
        }
        if open > 0 {
            for ((leaf, entered), &(normal, _)) in fan.leaves.iter().zip(&fan.entered).zip(&fan.normals) {
                if *entered == 0 {
                    open += 1;
                    self.stand(&mut quadric, origin, leaf[0], normal, BORDER_WEIGHT);
                }
            }
        }
        let kept = self.locked[v] || (self.keep_boundary && open > 0);
        let kind = if kept || !fan.is_manifold() {
            Kind::Fixed
        } else {
            match features + open {
                0 => Kind::Free,
                2 => Kind::Curve,
                _ => Kind::Fixed,
            }
        };
        let has_curve = features + open + creases > 0;
        (Vertex { position: origin, quadric, kind, dead: false, held: false, has_curve, stamp: 0 }, facing)
    }

    /// The edges of curves from a vertex to those after it: open ones, borders, seams and creases.
    fn curves_at(&self, v: usize, fan: &mut Fan) -> Vec<[u32; 2]> {
        fan.set(v as u32, self.rings.at(v), self.faces);
        let normal = |face: u32| {
            let [a, b, c] = self.faces[face as usize].map(|v| self.positions[v as usize]);
            let normal = cross(sub(b, a), sub(c, a));
            let length = dot(normal, normal).sqrt();
            if length > 0.0 { scale(normal, 1.0 / length) } else { [0.0; 3] }
        };
        let is_curve = |leaf: &[u32; 3], next: Option<u32>| {
            next.is_none_or(|next| {
                let other = fan.leaves[next as usize];
                self.is_border(v as u32, leaf, &other) || dot(normal(leaf[2]), normal(other[2])) < self.crease_cosine
            })
        };
        let closed =
            fan.leaves.iter().zip(&fan.next).filter(|(leaf, next)| is_curve(leaf, **next)).map(|(leaf, _)| leaf[1]);
        let opened = fan.leaves.iter().zip(&fan.entered).filter(|(_, entered)| **entered == 0).map(|(leaf, _)| leaf[0]);
        closed.chain(opened).filter(|&n| n > v as u32).map(|n| [v as u32, n]).collect()
    }

    /// True if materials or attributes differ on both sides of the edge from `v` to the last corner of a leaf.
    fn is_border(&self, v: u32, leaf: &[u32; 3], other: &[u32; 3]) -> bool {
        self.materials.is_some_and(|m| m[leaf[2] as usize] != m[other[2] as usize])
            || self.corners.is_some()
                && (self.wedge(leaf[2], v) != self.wedge(other[2], v)
                    || self.wedge(leaf[2], leaf[1]) != self.wedge(other[2], leaf[1]))
    }

    /// The wedge of a face at one of its corners.
    fn wedge(&self, face: u32, v: u32) -> u32 {
        let corner = self.faces[face as usize].iter().position(|&corner| corner == v).unwrap_or(0);
        self.corners.map_or(0, |corners| corners[face as usize][corner])
    }

    /// Adds the plane that stands on the edge to `end`.
    fn stand(&self, quadric: &mut Quadric, origin: Vec3, end: u32, normal: Vec3, weight: f32) {
        let edge = sub(self.positions[end as usize], origin);
        *quadric = quadric.plus(&Quadric::edge(edge, normal, weight));
    }
}
