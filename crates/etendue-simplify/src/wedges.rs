//! Attributes: texture coordinates, normals and colours, and what changing them costs.
//!
//! A point has a *wedge* for each set of attributes that faces give it; a seam is where wedges differ along an edge. Over each
//! face an attribute is linear, so for a wedge the sum over faces of weight times squared difference is a quadric in place and
//! value together (Garland and Heckbert 1998, Hoppe 1999). The best value for a place follows; with it put in, a quadric in
//! the place alone remains.

use rayon::prelude::*;

use crate::quadric::Quadric;
use crate::vector::{Vec3, add, area_normal, cross, dot, scale, sub};
use crate::{Keep, Mesh, MeshRef};

/// Numbers of all attributes together at most: two of texture coordinates, three of normals, four of colours.
pub(crate) const MOST: usize = 9;

/// A length that a difference of 1 in a normal, or in a colour, counts as, over the size of the mesh.
const NORMAL_LENGTH: f32 = 0.002;
const COLOR_LENGTH: f32 = 0.01;
/// How much a slide of the texture counts, over a shift of the surface by that length.
const SLIDE: f32 = 0.5;

/// Which attributes there are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Layout {
    pub uvs: bool,
    pub normals: bool,
    pub colors: bool,
}

impl Layout {
    pub fn of(mesh: &MeshRef<'_>, keep: Keep) -> Self {
        Self {
            uvs: keep.uvs && mesh.uvs.is_some(),
            normals: keep.normals && mesh.normals.is_some(),
            colors: keep.colors && mesh.colors.is_some(),
        }
    }

    /// How many numbers a wedge has.
    pub fn len(self) -> usize {
        2 * usize::from(self.uvs) + 3 * usize::from(self.normals) + 4 * usize::from(self.colors)
    }

    /// True if normals differ by less than an angle, and nothing else differs.
    fn alike(self, a: &[f32; MOST], b: &[f32; MOST], cosine: f32) -> bool {
        let first = 2 * usize::from(self.uvs);
        let end = first + 3 * usize::from(self.normals);
        if a[..first] != b[..first] || a[end..] != b[end..] {
            return false;
        }
        if !self.normals {
            return true;
        }
        let [p, q] = [a, b].map(|v| [v[first], v[first + 1], v[first + 2]]);
        dot(p, q) >= cosine * (dot(p, p) * dot(q, q)).sqrt()
    }

    /// The numbers of a vertex; what is not finite is 0.
    pub fn values(self, mesh: &MeshRef<'_>, vertex: usize) -> [f32; MOST] {
        let mut values = [0.0; MOST];
        let mut at = 0;
        let mut push = |list: &[f32]| {
            for &value in list {
                // Adding 0 makes both zeros one.
                values[at] = if value.is_finite() { value + 0.0 } else { 0.0 };
                at += 1;
            }
        };
        if let Some(uvs) = mesh.uvs.filter(|_| self.uvs) {
            push(&uvs[vertex]);
        }
        if let Some(normals) = mesh.normals.filter(|_| self.normals) {
            push(&normals[vertex]);
        }
        if let Some(colors) = mesh.colors.filter(|_| self.colors) {
            push(&colors[vertex]);
        }
        values
    }
}

/// One set of attributes of a point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Wedge {
    /// The point.
    pub owner: u32,
    /// Sum of weights.
    pub w: f32,
    pub values: [f32; MOST],
    /// Per number: weighted sum over faces of the difference from `values` at the point.
    d: [f32; MOST],
    /// Per number: weighted sum of gradients.
    g: [Vec3; MOST],
}

impl Wedge {
    /// Relative to a point `by` away.
    fn moved(mut self, by: Vec3) -> Self {
        for k in 0..MOST {
            self.d[k] += dot(self.g[k], by);
        }
        self
    }

    /// Two wedges at one point become one, whose values are those of the first; what the quadric of the second has to change
    /// by, since its differences are now from other values, is added to `quadric`.
    fn joined(mut self, other: &Self, quadric: &mut Quadric) -> Self {
        for k in 0..MOST {
            let shift = other.values[k] - self.values[k];
            quadric.c += shift * (2.0 * other.d[k] + shift * other.w);
            quadric.b = sub(quadric.b, scale(other.g[k], shift));
            self.d[k] += other.d[k] + shift * other.w;
            self.g[k] = add(self.g[k], other.g[k]);
        }
        self.w += other.w;
        self
    }

    /// Takes from a quadric in place and values what the best values save.
    fn eliminate(&self, quadric: &mut Quadric) {
        if self.w <= 0.0 {
            return;
        }
        let inverse = 1.0 / self.w;
        for k in 0..MOST {
            let [x, y, z] = self.g[k];
            for (a, product) in quadric.a.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
                *a -= product * inverse;
            }
            quadric.b = add(quadric.b, scale(self.g[k], self.d[k] * inverse));
            quadric.c -= self.d[k] * self.d[k] * inverse;
        }
    }

    /// Sets the best values at the point itself, and tells the quadric of it.
    fn settle(&mut self, quadric: &mut Quadric) {
        if self.w <= 0.0 {
            return;
        }
        for k in 0..MOST {
            let shift = self.d[k] / self.w;
            self.values[k] += shift;
            quadric.c += shift * (shift * self.w - 2.0 * self.d[k]);
            quadric.b = add(quadric.b, scale(self.g[k], shift));
            self.d[k] = 0.0;
        }
    }
}

/// The quadric of an edge relative to its first end, the values of joined wedges put in.
pub(crate) fn edge_quadric(
    first: &Quadric,
    second: &Quadric,
    d: Vec3,
    wedges: &[Wedge],
    pairs: &[[u32; 2]],
) -> Quadric {
    let back = scale(d, -1.0);
    let mut sum = second.moved(back).plus(first);
    for &[i, j] in pairs {
        let joined = wedges[i as usize].joined(&wedges[j as usize].moved(back), &mut sum);
        joined.eliminate(&mut sum);
    }
    sum
}

/// Joins the wedges of an edge whose vertex goes to `place` relative to its first end; gives the merged quadric relative to
/// that. Values of vertices that stay (`keeps`) stay.
pub(crate) fn merge(
    first: &Quadric,
    second: &Quadric,
    d: Vec3,
    place: Vec3,
    keeps: bool,
    wedges: &mut [Wedge],
    pairs: &[[u32; 2]],
) -> Quadric {
    let back = scale(d, -1.0);
    let mut sum = second.moved(back).plus(first);
    for &[i, j] in pairs {
        wedges[i as usize] = wedges[i as usize].joined(&wedges[j as usize].moved(back), &mut sum);
    }
    sum = sum.moved(place);
    for &[i, _] in pairs {
        let wedge = &mut wedges[i as usize];
        *wedge = wedge.moved(place);
        if !keeps {
            wedge.settle(&mut sum);
        }
    }
    sum
}

/// Lengths that differences of 1 count as, squared; see the constants.
fn weights(layout: Layout, mesh: &MeshRef<'_>, unit: f64) -> [f32; MOST] {
    let mut weights = [0.0; MOST];
    let mut at = 0;
    let mut push = |count: usize, length: f32| {
        weights[at..at + count].fill(length * length);
        at += count;
    };
    if let Some(uvs) = mesh.uvs.filter(|_| layout.uvs) {
        // The side of the surface over the side of the texture.
        let (surface, texture) = mesh
            .faces
            .iter()
            .map(|face| {
                let [a, b, c] = face.map(|v| mesh.positions[v as usize].map(|x| (f64::from(x) / unit) as f32));
                let normal = area_normal(a, b, c);
                let [p, q, r] = face.map(|v| uvs[v as usize].map(f64::from));
                let area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
                (f64::from(dot(normal, normal).sqrt()), area.abs())
            })
            .filter(|(surface, texture)| surface.is_finite() && texture.is_finite())
            .fold((0.0, 0.0), |sum, face| (sum.0 + face.0, sum.1 + face.1));
        let length = if texture > 0.0 { ((surface / texture).sqrt() as f32).min(1e6) } else { 0.0 };
        push(2, (length * SLIDE).max(1e-6));
    }
    if layout.normals {
        push(3, NORMAL_LENGTH);
    }
    if layout.colors {
        push(4, COLOR_LENGTH);
    }
    weights
}

/// A face's attribute quadrics at one of its corners: added to the wedge's sums and to the quadric. Numbers are scaled to
/// lengths.
fn add_face(corners: [Vec3; 3], values: [&[f32; MOST]; 3], count: usize, wedge: &mut Wedge, quadric: &mut Quadric) {
    let (e1, e2) = (sub(corners[1], corners[0]), sub(corners[2], corners[0]));
    let normal = cross(e1, e2);
    let n2 = dot(normal, normal);
    let longest = dot(e1, e1).max(dot(e2, e2));
    let weight = 0.5 * n2.sqrt();
    wedge.w += weight;
    // Of a needle, no gradient is known.
    if n2 <= 1e-6 * longest * longest {
        return;
    }
    let (u, v) = (scale(cross(e2, normal), 1.0 / n2), scale(cross(normal, e1), 1.0 / n2));
    let [first, second, third] = values;
    for (k, sum) in wedge.g.iter_mut().enumerate().take(count) {
        let g = add(scale(u, second[k] - first[k]), scale(v, third[k] - first[k]));
        *sum = add(*sum, scale(g, weight));
        let [x, y, z] = g;
        for (a, product) in quadric.a.iter_mut().zip([x * x, y * y, z * z, x * y, x * z, y * z]) {
            *a += product * weight;
        }
    }
}

/// The wedges of a mesh.
pub(crate) struct Wedges {
    pub layout: Layout,
    /// In the order of points.
    pub list: Vec<Wedge>,
    /// What a number was multiplied by.
    scales: [f32; MOST],
}

impl Wedges {
    /// Groups the vertices of each point (`order` is by point) by their attributes, and gives the wedge of each vertex.
    /// Normals that differ by less than the angle of `crease_cosine` are of one wedge: facets become smooth.
    pub fn group(
        mesh: &MeshRef<'_>,
        layout: Layout,
        order: &[u32],
        point_of: &[u32],
        unit: f64,
        crease_cosine: f32,
    ) -> (Self, Vec<u32>) {
        let scales = weights(layout, mesh, unit).map(f32::sqrt);
        let mut wedge_of = vec![u32::MAX; mesh.positions.len()];
        let mut list: Vec<Wedge> = Vec::new();
        let mut same = Vec::new();
        for run in order.chunk_by(|a, b| point_of[*a as usize] == point_of[*b as usize]) {
            same.clear();
            same.extend(run.iter().map(|&v| (layout.values(mesh, v as usize).map(f32::to_bits), v)));
            same.sort_unstable();
            let (first, mut last) = (list.len(), None);
            for &(bits, v) in &same {
                if last != Some(bits) {
                    last = Some(bits);
                    let mut values = bits.map(f32::from_bits);
                    for (value, scale) in values.iter_mut().zip(scales) {
                        *value *= scale;
                    }
                    // A point with very many wedges is not worth the search.
                    let known = &list[first..];
                    let alike =
                        known.iter().take(16).position(|wedge| layout.alike(&wedge.values, &values, crease_cosine));
                    match alike {
                        Some(i) => {
                            wedge_of[v as usize] = (first + i) as u32;
                            last = None;
                            continue;
                        }
                        None => {
                            let owner = point_of[v as usize];
                            list.push(Wedge { owner, w: 0.0, values, d: [0.0; MOST], g: [[0.0; 3]; MOST] });
                        }
                    }
                }
                wedge_of[v as usize] = list.len() as u32 - 1;
            }
        }
        (Self { layout, list, scales }, wedge_of)
    }

    /// Adds the attributes' quadrics of all faces: to the wedges, and to the quadrics of points.
    pub fn measure<'a>(
        &mut self,
        positions: &[Vec3],
        faces: &[[u32; 3]],
        corners: &[[u32; 3]],
        ring: impl Fn(usize) -> &'a [u32] + Sync,
        quadrics: &mut [crate::vertex::Vertex],
    ) {
        let count = self.layout.len();
        let values: Vec<[f32; MOST]> = self.list.par_iter().map(|wedge| wedge.values).collect();
        let mut rest = self.list.as_mut_slice();
        let mut parts = Vec::new();
        const STEP: usize = 4096;
        for (i, points) in quadrics.chunks_mut(STEP).enumerate() {
            let end = ((i + 1) * STEP) as u32;
            let (part, tail) = rest.split_at_mut(rest.partition_point(|wedge| wedge.owner < end));
            parts.push((i * STEP, points, values.len() - part.len() - tail.len(), part));
            rest = tail;
        }
        parts.into_par_iter().for_each(|(low, points, first, part)| {
            for (i, point) in points.iter_mut().enumerate() {
                for &face in ring(low + i) {
                    let (face, wedges) = (faces[face as usize], corners[face as usize]);
                    let Some(corner) = face.iter().position(|&v| v as usize == low + i) else { continue };
                    let wedge = &mut part[wedges[corner] as usize - first];
                    let places = face.map(|v| positions[v as usize]);
                    add_face(places, wedges.map(|w| &values[w as usize]), count, wedge, &mut point.quadric);
                }
            }
        });
    }

    /// Writes the values of the wedges that are used, in their order.
    pub fn write(&self, mesh: &mut Mesh, used: impl Iterator<Item = usize>) {
        let layout = self.layout;
        let (mut uvs, mut normals, mut colors) = (Vec::new(), Vec::new(), Vec::new());
        for wedge in used {
            let mut values = self.list[wedge].values;
            for (value, scale) in values.iter_mut().zip(self.scales) {
                *value /= if scale > 0.0 { scale } else { 1.0 };
                // Sums overflow where the size of faces is beyond all measure.
                *value = if value.is_finite() { *value } else { 0.0 };
            }
            let mut rest = values.as_slice();
            let mut take = |count: usize| {
                let (head, tail) = rest.split_at(count);
                rest = tail;
                head
            };
            if layout.uvs {
                uvs.push([0, 1].map(|_| take(1)[0]));
            }
            if layout.normals {
                let normal = [0, 1, 2].map(|_| take(1)[0]);
                let length = dot(normal, normal).sqrt();
                normals.push(if length > 0.0 { scale(normal, 1.0 / length) } else { normal });
            }
            if layout.colors {
                colors.push([0, 1, 2, 3].map(|_| take(1)[0].clamp(0.0, 1.0)));
            }
        }
        mesh.uvs = layout.uvs.then_some(uvs);
        mesh.normals = layout.normals.then_some(normals);
        mesh.colors = layout.colors.then_some(colors);
    }
}
