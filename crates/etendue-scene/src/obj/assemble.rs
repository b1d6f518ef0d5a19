//! From statements to one mesh.

use super::{
    skipped::Skipped,
    statements::Statements,
    unifier::{NONE, Triple, Unifier},
};
use crate::{
    polygon::{Cut, Triangulator, angle_at, newell},
    positions::{localise, unit_normal},
};
use etendue::scene::Mesh;
use glam::DVec3;
use std::ops::Range;

/// How a vertex gets its normal, as the `shading` of a [`Triple`]: a tag, and a value in the lower half.
const FLAT_MESH: u64 = 0;
const FILE_NORMAL: u64 = 1 << 32;
const SMOOTH: u64 = 2 << 32;
const FLAT: u64 = 3 << 32;

/// The mesh of a file.
pub(super) struct Assembled {
    pub mesh: Mesh,
    /// First triangle of each run of [`Statements::groups`].
    pub groups: Vec<usize>,
    /// What was repaired: how often, and the first face.
    pub repairs: Vec<(Skipped, usize, u32)>,
}

/// Unifies corners, makes missing normals, and cuts polygons. `material_of` maps material numbers of the file, [`NONE`]
/// included, to those of the mesh; absent: one material.
pub(super) fn assemble(statements: &mut Statements, material_of: Option<&dyn Fn(u32) -> u32>) -> Assembled {
    normalise(&mut statements.normals);
    let mut assembly = Assembly::new(statements);
    let mut groups = Vec::with_capacity(statements.groups.runs.len());
    let mut face_materials = Vec::new();
    let (mut material_run, mut smoothing_run, mut first) = (0, 0, 0);
    if material_of.is_some() {
        face_materials.reserve_exact(assembly.indices.capacity());
    }
    for face in 0..statements.faces.count() {
        let corners = first..first + statements.faces.size(face) as usize;
        first = corners.end;
        if statements.groups.runs.get(groups.len()).is_some_and(|(start, _)| *start == face) {
            groups.push(assembly.indices.len());
        }
        assembly.add(face, corners, *statements.smoothing.at(face, &mut smoothing_run));
        if let Some(material_of) = material_of {
            let material = material_of(*statements.materials.at(face, &mut material_run));
            face_materials.resize(assembly.indices.len(), material);
        }
    }
    let (mut mesh, repairs) = assembly.finish();
    mesh.face_materials = material_of.map(|_| face_materials.into());
    Assembled { mesh, groups, repairs }
}

/// Unit length, or zero.
fn normalise(normals: &mut [[f32; 3]]) {
    for normal in normals {
        *normal = unit_normal(DVec3::from(normal.map(f64::from)));
    }
}

struct Assembly<'a> {
    statements: &'a Statements<'a>,
    unifier: Unifier,
    indices: Vec<[u32; 3]>,
    /// One a vertex if the mesh has normals; those of smoothing groups are filled in at the end.
    normals: Option<Vec<[f32; 3]>>,
    /// Numbers (position, smoothing group) pairs.
    smooth: Unifier,
    /// Of each such pair, normals of faces weighted by their angle there.
    sums: Vec<DVec3>,
    triangulator: Triangulator,
    repairs: Vec<(Skipped, usize, u32)>,
    // Of the face at hand: corners, their vertices and positions, its triangles.
    ring: Vec<usize>,
    vertices: Vec<u32>,
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl<'a> Assembly<'a> {
    fn new(statements: &'a Statements<'a>) -> Self {
        let positions = statements.positions.len();
        let corners = &statements.corners;
        let smooths = statements.smoothing.runs.iter().any(|(_, group)| *group != 0);
        let has_normals = smooths || (corners.has_normals() && statements.normals.iter().any(|n| *n != [0.0; 3]));
        let triangles = corners.positions.len() - 2 * statements.faces.count() as usize;
        Self {
            statements,
            unifier: Unifier::new(positions),
            indices: Vec::with_capacity(triangles),
            normals: has_normals.then(Vec::new),
            smooth: Unifier::new(if smooths { positions } else { 0 }),
            sums: vec![],
            triangulator: Triangulator::new(),
            repairs: vec![],
            ring: vec![],
            vertices: vec![],
            points: vec![],
            triangles: vec![],
        }
    }

    fn position(&self, corner: usize) -> u32 {
        self.statements.corners.positions[corner]
    }

    #[cold]
    fn repaired(&mut self, what: Skipped, face: u32) {
        match self.repairs.iter_mut().find(|(kind, ..)| *kind == what) {
            Some((_, count, _)) => *count += 1,
            None => self.repairs.push((what, 1, face)),
        }
    }

    fn add(&mut self, face: u32, corners: Range<usize>, smoothing: u32) {
        self.ring.clear();
        for corner in corners {
            match self.ring.last() {
                Some(&last) if self.position(last) == self.position(corner) => {
                    self.repaired(Skipped::RepeatedCorner, face);
                }
                _ => self.ring.push(corner),
            }
        }
        while let [first, .., last] = self.ring[..]
            && self.position(first) == self.position(last)
        {
            self.ring.pop();
            self.repaired(Skipped::RepeatedCorner, face);
        }
        if self.ring.len() < 3 {
            return self.repaired(Skipped::Flattened, face);
        }
        self.points.clear();
        if self.normals.is_some() || self.ring.len() > 3 {
            let positions = &self.statements.positions;
            self.points.extend(self.ring.iter().map(|&c| positions[self.statements.corners.positions[c] as usize]));
        }
        self.number_vertices(face, smoothing);
        self.cut(face);
    }

    /// The vertices of the ring.
    fn number_vertices(&mut self, face: u32, smoothing: u32) {
        let corners = &self.statements.corners;
        let mut normal = None;
        self.vertices.clear();
        for i in 0..self.ring.len() {
            let corner = self.ring[i];
            let uv = corners.uv(corner);
            if uv == NONE && corners.has_uvs() {
                self.repaired(Skipped::MissingUv, face);
            }
            let (shading, value) = if self.normals.is_none() {
                (FLAT_MESH, [0.0; 3])
            } else {
                self.shading(i, face, smoothing, &mut normal)
            };
            let (vertex, new) = self.unifier.number(corners.positions[corner], uv, shading);
            if new && let Some(normals) = &mut self.normals {
                normals.push(value);
            }
            self.vertices.push(vertex);
        }
    }

    /// Where the normal of the ring's corner `i` comes from, and its value if it is known.
    fn shading(&mut self, i: usize, face: u32, smoothing: u32, normal: &mut Option<DVec3>) -> (u64, [f32; 3]) {
        let corner = self.ring[i];
        let index = self.statements.corners.normal(corner);
        if index != NONE {
            let value = self.statements.normals[index as usize];
            if value != [0.0; 3] {
                return (FILE_NORMAL | u64::from(index), value);
            }
            self.repaired(Skipped::ZeroNormal, face);
        }
        let normal = *normal.get_or_insert_with(|| newell(&self.points).normalize_or_zero());
        if smoothing == 0 {
            return (FLAT | u64::from(face), or_up(normal));
        }
        let (sum, new) = self.smooth.number(self.position(corner), NONE, u64::from(smoothing));
        if new {
            self.sums.push(DVec3::ZERO);
        }
        let weighted = self.angle(i) * normal;
        self.sums[sum as usize] += weighted;
        (SMOOTH | u64::from(sum), [0.0; 3])
    }

    /// The ring's inner angle at corner `i`, radians.
    fn angle(&self, i: usize) -> f64 {
        let count = self.points.len();
        angle_at(self.points[(i + count - 1) % count], self.points[i], self.points[(i + 1) % count])
    }

    fn cut(&mut self, face: u32) {
        if let [a, b, c] = self.vertices[..] {
            self.indices.push([a, b, c]);
            return;
        }
        self.triangles.clear();
        match self.triangulator.cut(&self.points, &mut self.triangles) {
            Cut::Exact => {}
            Cut::Forced => self.repaired(Skipped::SelfIntersecting, face),
            Cut::TooComplex => self.repaired(Skipped::TooComplex, face),
        }
        for &triangle in &self.triangles {
            // A corner that the polygon visits twice can meet itself.
            let [a, b, c] = triangle.map(|i| self.position(self.ring[i as usize]));
            if a != b && b != c && c != a {
                self.indices.push(triangle.map(|i| self.vertices[i as usize]));
            }
        }
    }

    fn finish(self) -> (Mesh, Vec<(Skipped, usize, u32)>) {
        let Statements { positions, uvs, corners, .. } = self.statements;
        let triples = self.unifier.into_triples();
        let normals = self.normals.map(|mut normals| {
            for (normal, triple) in normals.iter_mut().zip(&triples) {
                if triple.shading & !u64::from(u32::MAX) == SMOOTH {
                    *normal = or_up(self.sums[triple.shading as u32 as usize].normalize_or_zero());
                }
            }
            normals.into()
        });
        let uv = |triple: &Triple| if triple.uv == NONE { [0.0; 2] } else { uvs[triple.uv as usize] };
        let (origin, local) = localise(triples.iter().map(|triple| positions[triple.position as usize]));
        let mesh = Mesh {
            origin,
            positions: local,
            indices: self.indices.into(),
            normals,
            uvs: corners.has_uvs().then(|| triples.iter().map(uv).collect()),
            face_materials: None,
        };
        (mesh, self.repairs)
    }
}

/// The normal of a face, of a face without area some unit vector.
fn or_up(normal: DVec3) -> [f32; 3] {
    if normal == DVec3::ZERO { [0.0, 0.0, 1.0] } else { normal.as_vec3().to_array() }
}
