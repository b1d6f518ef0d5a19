//! Flat lamps that are cut into triangles: those that together are a parallelogram, or nearly a disk, are one light, which is drawn
//! from as a whole and evenly, however finely it is cut.
//!
//! Faces belong together if they share edges, lie in one plane to rounding with the same side up, and emit alike. They cover a
//! parallelogram or a polygon just once if the edges that no face runs along the other way are one closed line round it: since all
//! faces turn the same way, a point is covered as often as that line goes round it. An edge with more faces one way than the other
//! leaves the line open.

use crate::{
    light::RoundOutline,
    math::{DVec3, Vec3},
    spectrum::Spectrum,
};

/// By how much corners may be off a plane or a line, over the largest coordinate: a rounding of each of a few coordinates, and of a
/// placement. It is within what light samples are lifted by.
const SLACK: f64 = 6.0 / 16_777_216.0;
/// The same of two faces, whose own planes tell less where they are small; what they are part of is looked at again.
const PAIR_SLACK: f64 = 4.0 * SLACK;

/// A triangle that emits the same light everywhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct PanelFace {
    /// Vertices of the mesh, counter-clockwise as seen from the front of the light.
    pub corners: [u32; 3],
    /// See [`crate::light::TriangleLight`].
    pub radiance: Spectrum,
    /// See [`crate::light::TriangleLight`].
    pub two_sided: bool,
}

/// Faces that are one light together.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Panel {
    /// Indices of the faces, ascending.
    pub faces: Vec<u32>,
    pub form: Form,
}

/// What faces are together.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Form {
    Parallelogram {
        corner: Vec3,
        /// From there; the front is along u x v.
        edges: [Vec3; 2],
    },
    /// The front is along its normal.
    Disk(RoundOutline),
}

/// All panels of two faces or more. `faces` has an entry for each face of a mesh, `None` for those that are left as they are;
/// `place` tells where a vertex is in the world.
pub(super) fn find(faces: &[Option<PanelFace>], place: impl Fn(u32) -> Vec3) -> Vec<Panel> {
    let faces: Vec<(u32, PanelFace)> =
        faces.iter().enumerate().filter_map(|(index, face)| Some((index as u32, (*face)?))).collect();
    if faces.len() < 2 {
        return Vec::new();
    }
    let welded = Welded::new(&faces, place);
    welded.groups(&faces).iter().filter_map(|group| welded.panel(&faces, group)).collect()
}

/// Faces by corners that are the same where they are at the same place.
struct Welded {
    points: Vec<DVec3>,
    /// Of each face.
    corners: Vec<[u32; 3]>,
}

impl Welded {
    fn new(faces: &[(u32, PanelFace)], place: impl Fn(u32) -> Vec3) -> Self {
        let mut vertices: Vec<u32> = faces.iter().flat_map(|(_, face)| face.corners).collect();
        vertices.sort_unstable();
        vertices.dedup();
        // Adding zero makes both zeros one.
        let mut places: Vec<([u32; 3], u32)> =
            vertices.iter().map(|&vertex| ((place(vertex) + 0.0).to_array().map(f32::to_bits), vertex)).collect();
        places.sort_unstable();
        let mut points = Vec::new();
        let mut point_of = vec![0; vertices.len()];
        let mut last = None;
        for (bits, vertex) in places {
            if last != Some(bits) {
                points.push(Vec3::from_array(bits.map(f32::from_bits)).as_dvec3());
                last = Some(bits);
            }
            if let Ok(at) = vertices.binary_search(&vertex) {
                point_of[at] = points.len() as u32 - 1;
            }
        }
        let point = |vertex: u32| vertices.binary_search(&vertex).map_or(0, |at| point_of[at]);
        let corners = faces.iter().map(|(_, face)| face.corners.map(point)).collect();
        Self { points, corners }
    }

    fn point(&self, index: u32) -> DVec3 {
        self.points[index as usize]
    }

    fn places(&self, face: u32) -> [DVec3; 3] {
        self.corners[face as usize].map(|corner| self.point(corner))
    }

    /// Faces that may be panels: joined by edges, flat there and alike. Each has two or more, in ascending order.
    fn groups(&self, faces: &[(u32, PanelFace)]) -> Vec<Vec<u32>> {
        let normals: Vec<DVec3> = (0..faces.len() as u32).map(|face| normal(self.places(face))).collect();
        let mut edges: Vec<(u64, u32)> = Vec::with_capacity(3 * faces.len());
        for (face, corners) in self.corners.iter().enumerate() {
            let sides = directed(*corners).map(|[from, to]| undirected(from, to));
            edges.extend(sides.map(|edge| (edge, face as u32)));
        }
        edges.sort_unstable();
        let mut roots = Roots((0..faces.len() as u32).collect());
        for pair in edges.chunk_by(|a, b| a.0 == b.0) {
            if let [(_, first), (_, second)] = *pair
                && self.go_on(&normals, first, second)
                && is_alike(&faces[first as usize].1, &faces[second as usize].1)
            {
                roots.join(first, second);
            }
        }
        let mut members: Vec<(u32, u32)> = (0..faces.len() as u32).map(|face| (roots.of(face), face)).collect();
        members.sort_unstable();
        let groups = members.chunk_by(|a, b| a.0 == b.0).filter(|group| group.len() > 1);
        groups.map(|group| group.iter().map(|(_, face)| *face).collect()).collect()
    }

    /// True if two faces with an edge in common are in one plane, the same side up.
    fn go_on(&self, normals: &[DVec3], first: u32, second: u32) -> bool {
        let [a, b] = [first, second].map(|face| self.places(face));
        let [m, n] = [first, second].map(|face| normals[face as usize]);
        let slack = PAIR_SLACK * largest(&a).max(largest(&b));
        let is_off = |normal: DVec3, from: DVec3, points: [DVec3; 3]| {
            points.iter().any(|point| (*point - from).dot(normal).abs() > slack)
        };
        m.dot(n) > 0.0 && !is_off(m, a[0], b) && !is_off(n, b[0], a)
    }

    fn panel(&self, faces: &[(u32, PanelFace)], group: &[u32]) -> Option<Panel> {
        let rim = self.rim(group)?;
        let slack = SLACK * group.iter().map(|face| largest(&self.places(*face))).fold(0.0, f64::max);
        let is_flat = |from: DVec3, normal: DVec3| {
            let points = group.iter().flat_map(|face| self.places(*face));
            points.into_iter().all(|point| (point - from).dot(normal).abs() <= slack)
        };
        let form = parallelogram(&rim, slack, is_flat).or_else(|| disk(&rim, is_flat))?;
        Some(Panel { faces: group.iter().map(|face| faces[*face as usize].0).collect(), form })
    }

    /// The closed line round a group of faces, the faces on its left; `None` if there are several, or if it
    /// comes to a point twice.
    fn rim(&self, group: &[u32]) -> Option<Vec<DVec3>> {
        let mut edges: Vec<[u32; 2]> = group.iter().flat_map(|face| directed(self.corners[*face as usize])).collect();
        edges.sort_unstable();
        let is_open = |&[from, to]: &[u32; 2]| edges.binary_search(&[to, from]).is_err();
        let open: Vec<[u32; 2]> = edges.iter().copied().filter(is_open).collect();
        let start = open.first()?[0];
        let mut rim = Vec::with_capacity(open.len());
        let mut at = start;
        loop {
            rim.push(self.point(at));
            at = open[open.binary_search_by_key(&at, |edge| edge[0]).ok()?][1];
            if at == start || rim.len() == open.len() {
                break;
            }
        }
        (at == start && rim.len() == open.len()).then_some(rim)
    }
}

/// Sets of faces, each known by its lowest.
struct Roots(Vec<u32>);

impl Roots {
    fn of(&mut self, mut face: u32) -> u32 {
        while self.0[face as usize] != face {
            let above = self.0[face as usize];
            self.0[face as usize] = self.0[above as usize];
            face = above;
        }
        face
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.of(a), self.of(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

/// `is_flat` tells if all is in the plane through a point across a normal.
fn parallelogram(rim: &[DVec3], slack: f64, is_flat: impl Fn(DVec3, DVec3) -> bool) -> Option<Form> {
    let [a, b, c, d] = corners_of(rim)?;
    let at = [a, b, c, d].map(|corner| rim[corner]);
    let [u, v] = [at[1] - at[0], at[3] - at[0]];
    let is_closed = largest(&[at[0] + u + v - at[2]]) <= slack;
    let sides = [(a, b), (b, c), (c, d), (d, a)];
    let normal = u.cross(v).try_normalize()?;
    let is_one =
        is_closed && sides.iter().all(|&(from, to)| is_straight(rim, from, to, slack)) && is_flat(at[0], normal);
    is_one.then(|| Form::Parallelogram { corner: at[0].as_vec3(), edges: [u.as_vec3(), v.as_vec3()] })
}

/// As [`parallelogram`].
fn disk(rim: &[DVec3], is_flat: impl Fn(DVec3, DVec3) -> bool) -> Option<Form> {
    let outline = RoundOutline::new(rim)?;
    is_flat(outline.center(), outline.normal()).then_some(Form::Disk(outline))
}

fn is_alike(a: &PanelFace, b: &PanelFace) -> bool {
    a.radiance == b.radiance && a.two_sided == b.two_sided
}

fn directed([a, b, c]: [u32; 3]) -> [[u32; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

fn undirected(a: u32, b: u32) -> u64 {
    u64::from(a.min(b)) << 32 | u64::from(a.max(b))
}

/// Unit, or zero for a face without area.
fn normal([a, b, c]: [DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a).normalize_or_zero()
}

/// The largest magnitude of a coordinate; infinite if some are no numbers.
fn largest(points: &[DVec3]) -> f64 {
    let magnitude = |point: &DVec3| if point.is_finite() { point.abs().max_element() } else { f64::INFINITY };
    points.iter().map(magnitude).fold(0.0, f64::max)
}

/// Where on the rim the corners are, in its order, if it is a parallelogram: the ends of the longer diagonal, and what is farthest
/// from it on each side.
fn corners_of(rim: &[DVec3]) -> Option<[usize; 4]> {
    let farthest = |from: usize| best(rim, |point| point.distance_squared(rim[from]));
    // Each step makes the distance longer, or it is that of the diagonal.
    let mut a = farthest(0);
    let mut c = farthest(a);
    for _ in 0..3 {
        (a, c) = (c, farthest(c));
    }
    let diagonal = rim[c] - rim[a];
    let aside = best(rim, |point| (point - rim[a]).cross(diagonal).length_squared());
    let side = (rim[aside] - rim[a]).cross(diagonal);
    let other = best(rim, |point| -(point - rim[a]).cross(diagonal).dot(side));
    let order = |corner: usize| (corner + rim.len() - a) % rim.len();
    let [b, d] = if order(aside) < order(other) { [aside, other] } else { [other, aside] };
    (0 < order(b) && order(b) < order(c) && order(c) < order(d)).then_some([a, b, c, d])
}

/// The first point with the greatest value.
fn best(rim: &[DVec3], value: impl Fn(DVec3) -> f64) -> usize {
    let mut best = (0, f64::NEG_INFINITY);
    for (index, &point) in rim.iter().enumerate() {
        let value = value(point);
        if value > best.1 {
            best = (index, value);
        }
    }
    best.0
}

/// True if the rim goes straight on from one of its points to another.
fn is_straight(rim: &[DVec3], from: usize, to: usize, slack: f64) -> bool {
    let (start, way) = (rim[from], rim[to] - rim[from]);
    let length = way.length();
    let mut reached = 0.0;
    let mut index = from;
    while index != to {
        index = (index + 1) % rim.len();
        let offset = rim[index] - start;
        let along = offset.dot(way) / length;
        let is_off = offset.cross(way).length() > slack * length;
        if is_off || along.is_nan() || along <= reached {
            return false;
        }
        reached = along;
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::vec3;

    const RADIANCE: Spectrum = Spectrum([3.0, 2.0, 1.0]);

    /// Squares between these points of a grid, cut along diagonals that take turns.
    fn grid(columns: u32, rows: u32, place: impl Fn(f32, f32) -> Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let at = |x: u32, y: u32| y * (columns + 1) + x;
        let points = (0..=rows).flat_map(|y| (0..=columns).map(move |x| (x as f32, y as f32)));
        let points = points.map(|(x, y)| place(x / columns as f32, y / rows as f32)).collect();
        let squares = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        let faces = squares.flat_map(|(x, y)| {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            if (x + y) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] }
        });
        (points, faces.collect())
    }

    fn shining(faces: &[[u32; 3]]) -> Vec<Option<PanelFace>> {
        let face = |&corners: &[u32; 3]| Some(PanelFace { corners, radiance: RADIANCE, two_sided: false });
        faces.iter().map(face).collect()
    }

    fn found(points: &[Vec3], faces: &[[u32; 3]]) -> Vec<Panel> {
        find(&shining(faces), |vertex| points[vertex as usize])
    }

    fn edges(panel: &Panel) -> [Vec3; 2] {
        let Form::Parallelogram { edges, .. } = panel.form else { panic!("{panel:?}") };
        edges
    }

    /// A number in [-1, 1] for each place.
    fn noise(x: f32, y: f32) -> f32 {
        (libm::sinf(x * 91.7 + y * 47.3) * 1e3).fract()
    }

    /// Inner vertices are moved about, those on the sides along them.
    fn uneven(columns: u32, rows: u32, u: Vec3, v: Vec3) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let inside = |t: f32| t > 0.0 && t < 1.0;
        grid(columns, rows, |x, y| {
            let dx = if inside(x) { 0.3 * noise(x, y) / columns as f32 } else { 0.0 };
            let dy = if inside(y) { 0.3 * noise(y, x) / rows as f32 } else { 0.0 };
            let [u, v] = [(u, x + dx), (v, y + dy)].map(|(edge, t)| edge.as_dvec3() * f64::from(t));
            (vec3(1.0, 2.0, -3.0).as_dvec3() + u + v).as_vec3()
        })
    }

    #[test]
    fn cut_parallelograms_are_found_whole() {
        let skew = [vec3(0.9, 0.2, 0.1), vec3(0.7, 0.4, -0.2)];
        let shapes = [[Vec3::X, Vec3::Z * 0.8], skew, [vec3(5.0, 0.0, 0.0), vec3(-4.9, 0.1, 0.0)]];
        for [u, v] in shapes {
            for (columns, rows) in [(1, 1), (5, 1), (7, 9), (40, 30)] {
                let (points, faces) = uneven(columns, rows, u, v);
                let panels = found(&points, &faces);
                assert_eq!(panels.len(), 1, "{u} {v} {columns} {rows}");
                let Panel { faces: covered, form: Form::Parallelogram { corner, edges: [a, b] } } = &panels[0] else {
                    panic!("{panels:?}")
                };
                assert!(covered.iter().copied().eq(0..faces.len() as u32));
                let near = |p: Vec3, q: Vec3| (p - q).length() < 4e-6;
                let ways = [[u, v], [v, -u], [-u, -v], [-v, u]];
                let origin = vec3(1.0, 2.0, -3.0);
                let origins = [origin, origin + u, origin + u + v, origin + v];
                let is_it = |(o, [s, t]): (Vec3, [Vec3; 2])| near(*corner, o) && near(*a, s) && near(*b, t);
                assert!(origins.into_iter().zip(ways).any(is_it), "{panels:?} of {u} {v}");
            }
        }
    }

    #[test]
    fn vertices_at_the_same_place_are_one() {
        let (points, faces) = uneven(3, 2, Vec3::X, Vec3::Y);
        let apart: Vec<Vec3> = faces.iter().flatten().map(|corner| points[*corner as usize]).collect();
        let apart_faces: Vec<[u32; 3]> = (0..faces.len() as u32).map(|face| [0, 1, 2].map(|i| 3 * face + i)).collect();
        assert_eq!(found(&apart, &apart_faces), found(&points, &faces));
    }

    /// Zero has two signs.
    #[test]
    fn zeros_are_one() {
        let points =
            [[-1.0, 0.0], [0.0, 0.0], [0.0, 1.0], [-1.0, 1.0], [-0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [-0.0, 1.0]];
        let points = points.map(|[x, y]| vec3(x, y, 0.0));
        assert_eq!(found(&points, &[[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]).len(), 1);
    }

    #[test]
    fn both_sides_of_a_sheet_are_panels() {
        let points = [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y];
        let panels = found(&points, &[[0, 1, 2], [0, 2, 3], [1, 0, 3], [1, 3, 2]]);
        let normals: Vec<Vec3> = panels.iter().map(|panel| edges(panel)[0].cross(edges(panel)[1])).collect();
        assert!(normals.len() == 2 && normals[0].dot(normals[1]) < 0.0, "{panels:?}");
    }

    #[test]
    fn a_side_goes_on_ahead() {
        let line = |places: [f64; 4]| places.map(|x| DVec3::X * x);
        assert!(is_straight(&line([0.0, 1.0, 2.0, 3.0]), 0, 3, 1e-6));
        assert!(!is_straight(&line([0.0, 2.0, 1.0, 3.0]), 0, 3, 1e-6));
        assert!(!is_straight(&line([0.0; 4]), 0, 3, 1e-6));
    }

    #[test]
    fn a_box_has_six_panels() {
        let corner = |i: u32| vec3((i & 1) as f32, (i >> 1 & 1) as f32, (i >> 2) as f32);
        let sides = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let faces: Vec<[u32; 3]> = sides.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
        let points: Vec<Vec3> = (0..8).map(corner).collect();
        let panels = found(&points, &faces);
        assert_eq!(panels.len(), 6);
        for panel in panels {
            let Form::Parallelogram { corner, edges: [u, v] } = panel.form else { panic!("{panel:?}") };
            let middle = corner + 0.5 * (u + v);
            assert!(u.cross(v).dot(middle - Vec3::splat(0.5)) > 0.0, "{panel:?} faces inwards");
        }
    }

    /// Corners of a regular polygon about (1, 2, -3), with faces about its middle.
    fn fan(count: u32, radius: f32) -> (Vec<Vec3>, Vec<[u32; 3]>) {
        let corner = |i: u32| {
            let (sin, cos) = libm::sincosf(std::f32::consts::TAU * i as f32 / count as f32);
            vec3(1.0, 2.0, -3.0) + vec3(radius * cos, 0.6 * radius * sin, 0.8 * radius * sin)
        };
        let points = std::iter::once(vec3(1.0, 2.0, -3.0)).chain((0..count).map(corner)).collect();
        (points, (0..count).map(|i| [0, 1 + i, 1 + (i + 1) % count]).collect())
    }

    #[test]
    fn disks_are_found_however_they_are_cut() {
        for count in [8, 9, 64, 500] {
            let (points, faces) = fan(count, 0.5);
            // About one of the rim's corners, in place of the middle.
            let corner: Vec<[u32; 3]> = (2..count).map(|i| [1, i, i + 1]).collect();
            for faces in [faces, corner] {
                let panels = found(&points, &faces);
                let [Panel { faces: covered, form: Form::Disk(outline) }] = &panels[..] else { panic!("{panels:?}") };
                assert!(covered.iter().copied().eq(0..faces.len() as u32));
                assert!((outline.center().as_vec3() - points[0]).length() < 1e-6, "{count}");
                assert!((outline.radius() - 0.5).abs() < 1e-6);
                assert!((outline.normal().as_vec3() - vec3(0.0, -0.8, 0.6)).length() < 1e-5);
            }
        }
    }

    /// Whatever is neither parallelogram nor disk stays as it is.
    #[test]
    fn other_shapes_are_left() {
        let (points, faces) = uneven(6, 6, Vec3::X, Vec3::Y);
        assert_eq!(found(&points, &faces).len(), 1);
        let without = |left_out: &[usize]| -> Vec<[u32; 3]> {
            faces.iter().enumerate().filter(|(i, _)| !left_out.contains(i)).map(|(_, face)| *face).collect()
        };
        // A hole, a corner cut off, an L, a face twice, a face that is turned over.
        assert_eq!(found(&points, &without(&[30, 31])).len(), 0, "hole");
        assert_eq!(found(&points, &without(&[0])).len(), 0, "corner");
        let quarter: Vec<usize> = (0..72).filter(|i| i / 12 < 3 && i % 12 < 6).collect();
        assert_eq!(found(&points, &without(&quarter)).len(), 0, "L");
        assert_eq!(found(&points, &[&faces[..], &faces[20..21]].concat()).len(), 0, "twice");
        let mut turned = faces.clone();
        turned[20].swap(0, 1);
        assert_eq!(found(&points, &turned).len(), 0, "turned over");
        // A quadrilateral with two sides at a slant, a triangle, a bent sheet.
        let (slanted, _) = grid(6, 6, |x, y| vec3(x * (1.0 - 0.1 * y), y, 0.0));
        assert_eq!(found(&slanted, &faces).len(), 0, "trapezium");
        let corner = [vec3(0.0, 0.0, 0.0), vec3(1.0, 0.0, 0.0), vec3(0.5, 0.5, 0.0), vec3(0.0, 1.0, 0.0)];
        assert_eq!(found(&corner, &[[0, 1, 2], [0, 2, 3]]).len(), 0, "triangle");
        let (bent, bent_faces) = grid(100, 100, |x, y| vec3(x, y, 1e-5 * x * x));
        assert_eq!(found(&bent, &bent_faces).len(), 0, "bent");
        let (bulged, _) = grid(100, 100, |x, y| vec3(x, y, 1e-4 * (x - x * x) * (y - y * y)));
        assert_eq!(found(&bulged, &bent_faces).len(), 0, "bulged");
        let (slanting, _) = grid(1, 1, |x, y| vec3(x * (1.0 + 0.5 * y), y, 0.0));
        assert_eq!(found(&slanting, &[[0, 1, 3], [0, 3, 2]]).len(), 0, "one side longer");
    }

    #[test]
    fn what_is_not_quite_a_disk_is_left() {
        let (points, faces) = fan(64, 0.5);
        assert_eq!(found(&points, &faces).len(), 1);
        assert_eq!(found(&points, &faces[..52]).len(), 0, "a slice is gone");
        // A face that is there twice is on its own, what is left is round enough.
        let twice = found(&points, &[&faces[..], &faces[20..21]].concat());
        assert!(twice.len() == 1 && twice[0].faces.iter().copied().eq((0..64).filter(|face| *face != 20)));
        let mut cone = points.clone();
        cone[0].y += 1e-4;
        assert_eq!(found(&cone, &faces).len(), 0, "a flat cone");
        let ellipse: Vec<Vec3> = points.iter().map(|p| vec3(1.2 * p.x, p.y, p.z)).collect();
        assert_eq!(found(&ellipse, &faces).len(), 0, "an ellipse");
        let (points, faces) = fan(6, 0.5);
        assert_eq!(found(&points, &faces).len(), 0, "a hexagon");
    }

    /// Faces of other radiance, or that do not shine, part what lies on either side of them.
    #[test]
    fn what_shines_otherwise_is_apart() {
        let (points, faces) = grid(3, 1, |x, y| vec3(3.0 * x, y, 0.0));
        let mut lights = shining(&faces);
        lights[2] = None;
        lights[3] = None;
        let panels = find(&lights, |vertex| points[vertex as usize]);
        assert_eq!(panels.iter().map(|p| &p.faces[..]).collect::<Vec<_>>(), [&[0, 1][..], &[4, 5]]);
        let changes: [fn(&mut PanelFace); 2] =
            [|face| face.radiance = Spectrum([1.0; 3]), |face| face.two_sided = true];
        for change in changes {
            let mut lights = shining(&faces);
            lights[2..4].iter_mut().flatten().for_each(change);
            let panels = find(&lights, |vertex| points[vertex as usize]);
            assert_eq!(panels.iter().map(|p| &p.faces[..]).collect::<Vec<_>>(), [&[0, 1][..], &[2, 3], &[4, 5]]);
        }
    }

    #[test]
    fn what_has_no_area_or_no_place_is_left() {
        let line = [Vec3::ZERO, Vec3::X, 2.0 * Vec3::X, 3.0 * Vec3::X];
        assert!(found(&line, &[[0, 1, 2], [0, 2, 3]]).is_empty());
        let lost = [Vec3::ZERO, Vec3::X, Vec3::splat(f32::NAN), Vec3::Y];
        assert!(found(&lost, &[[0, 1, 2], [0, 2, 3]]).is_empty());
        let far = [Vec3::ZERO, Vec3::X * f32::MAX, Vec3::splat(f32::MAX), Vec3::Y * f32::MAX];
        let _ = found(&far, &[[0, 1, 2], [0, 2, 3]]);
        assert!(found(&[Vec3::ZERO; 3], &[[0, 1, 2]]).is_empty());
    }
}
