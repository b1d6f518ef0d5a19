//! From statements to one mesh.

use super::{
    corners::{Corners, Place},
    skipped::Skipped,
    statements::{PieceFaces, Statements},
    unifier::{NONE, PositionNumbers, Triples, Unifier},
};
use crate::{
    mesh_file::Numbering,
    parallel,
    polygon::{Cut, Triangulator, angle_at, newell},
    positions::localise,
    vertex_colors::{self, WHITE},
};
use etendue::scene::Mesh;
use etendue_accel::zeroed_shared;
use glam::DVec3;
use std::sync::Arc;

/// How a vertex gets its normal, as the shading of a triple: a tag, and an index in the lower half.
const FLAT_MESH: u64 = 0;
/// Into the normals of the file.
const FILE_NORMAL: u64 = 1 << 32;
/// Into the sums of smoothing groups.
const SMOOTH: u64 = 2 << 32;
/// Into the normals of flat faces.
const FLAT: u64 = 3 << 32;

/// The mesh of a file.
pub(super) struct Assembled {
    pub mesh: Mesh,
    pub numbering: Numbering,
    /// First triangle of each run of [`Statements::groups`].
    pub groups: Vec<usize>,
    /// What was repaired: how often, and the first face.
    pub repairs: Vec<(Skipped, usize, u32)>,
}

/// Unifies corners, makes missing normals, and cuts polygons. `material_of` maps material numbers of the file, [`NONE`]
/// included, to those of the mesh; absent: one material. Positions, attributes and faces are taken out of the statements, and
/// each is given back as soon as it has been used, so that file and mesh are never both in memory.
pub(super) fn assemble(statements: &mut Statements, material_of: Option<&dyn Fn(u32) -> u32>) -> Assembled {
    let mut assembly = Assembly::new(statements);
    let mut groups = Vec::with_capacity(statements.groups.runs.len());
    // First triangle and material.
    let mut materials: Vec<(usize, u32)> = Vec::new();
    let (mut smoothing_run, mut face) = (0, 0);
    for piece in std::mem::take(&mut statements.faces) {
        let mut place = Place::default();
        assembly.begin_piece(&piece);
        for number in 0..piece.faces.count() {
            let triangles = assembly.triangles();
            if statements.groups.runs.get(groups.len()).is_some_and(|(start, _)| *start == face) {
                groups.push(triangles);
            }
            if let Some(&(start, material)) = statements.materials.runs.get(materials.len())
                && start == face
            {
                materials.push((triangles, material));
            }
            let size = piece.faces.size(number) as usize;
            if size != 3 || !assembly.add_alike(&piece, &mut place) {
                assembly.take(&piece, &mut place, size, face);
                assembly.add(statements, face, *statements.smoothing.at(face, &mut smoothing_run));
            }
            face += 1;
        }
        assembly.end_piece();
    }
    let (mut mesh, numbering, repairs) = assembly.finish(statements);
    mesh.face_materials = material_of.map(|material_of| {
        let mut run = 0;
        let materials: Vec<_> = materials.into_iter().map(|(start, number)| (start, material_of(number))).collect();
        let material = |triangle| {
            while materials.get(run + 1).is_some_and(|(start, _)| *start <= triangle) {
                run += 1;
            }
            materials[run].1
        };
        (0..mesh.indices.len()).map(material).collect()
    });
    Assembled { mesh, numbering, groups, repairs }
}

/// Numbers of vertices.
enum Vertices {
    /// Of corners whose position, texture coordinates and normal have the same index.
    Alike(PositionNumbers),
    Any(Unifier),
}

struct Assembly {
    vertices_seen: Vertices,
    /// Triangles of the pieces that are done, and of the one at hand.
    done: Vec<Vec<[u32; 3]>>,
    done_count: usize,
    indices: Vec<[u32; 3]>,
    has_uvs: bool,
    has_normals: bool,
    /// Numbers (position, smoothing group) pairs.
    smooth: Unifier,
    /// Of each such pair, normals of faces weighted by their angle there.
    sums: Vec<DVec3>,
    /// Of flat faces among others.
    flats: Vec<[f32; 3]>,
    triangulator: Triangulator,
    repairs: Vec<(Skipped, usize, u32)>,
    // Of the face at hand: corners as indices of position, texture coordinates and normal; those of them that count, their
    // vertices and positions; its triangles.
    corners: Vec<[u32; 3]>,
    ring: Vec<[u32; 3]>,
    vertices: Vec<u32>,
    points: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Assembly {
    fn new(statements: &Statements) -> Self {
        let positions = statements.positions.len();
        let smooths = statements.smoothing.runs.iter().any(|(_, group)| *group != 0);
        Self {
            vertices_seen: if corners_are_alike(statements, smooths) {
                Vertices::Alike(PositionNumbers::new(positions))
            } else {
                Vertices::Any(Unifier::new(positions))
            },
            done: Vec::with_capacity(statements.faces.len()),
            done_count: 0,
            indices: vec![],
            has_uvs: statements.has_uvs,
            has_normals: smooths || statements.has_normals,
            smooth: Unifier::new(if smooths { positions } else { 0 }),
            sums: vec![],
            flats: vec![],
            triangulator: Triangulator::new(),
            repairs: vec![],
            corners: vec![],
            ring: vec![],
            vertices: vec![],
            points: vec![],
            triangles: vec![],
        }
    }

    fn triangles(&self) -> usize {
        self.done_count + self.indices.len()
    }

    #[cold]
    fn repaired(&mut self, what: Skipped, face: u32) {
        match self.repairs.iter_mut().find(|(kind, ..)| *kind == what) {
            Some((_, count, _)) => *count += 1,
            None => self.repairs.push((what, 1, face)),
        }
    }

    fn begin_piece(&mut self, piece: &PieceFaces) {
        self.indices.reserve_exact(piece.corners.len() - 2 * piece.faces.count() as usize);
    }

    /// Adds the next face of a piece, a triangle, if nothing has to be found out about its corners.
    #[inline(always)]
    fn add_alike(&mut self, piece: &PieceFaces, place: &mut Place) -> bool {
        let Vertices::Alike(numbers) = &mut self.vertices_seen else { return false };
        let Some(corners) = piece.corners.triangle(place) else { return false };
        self.indices.push(corners.map(|position| numbers.number(position)));
        true
    }

    /// Takes the next face of a piece.
    fn take(&mut self, piece: &PieceFaces, place: &mut Place, size: usize, face: u32) {
        self.corners.clear();
        Corners::resolve(&piece.corners, place, size, piece.base, &mut self.corners);
        self.ring.clear();
        for i in 0..self.corners.len() {
            match self.ring.last() {
                Some(last) if last[0] == self.corners[i][0] => self.repaired(Skipped::RepeatedCorner, face),
                _ => self.ring.push(self.corners[i]),
            }
        }
        while let [first, .., last] = self.ring[..]
            && first[0] == last[0]
        {
            self.ring.pop();
            self.repaired(Skipped::RepeatedCorner, face);
        }
    }

    fn end_piece(&mut self) {
        self.indices.shrink_to_fit();
        self.done_count += self.indices.len();
        self.done.push(std::mem::take(&mut self.indices));
    }

    fn add(&mut self, statements: &Statements, face: u32, smoothing: u32) {
        if self.ring.len() < 3 {
            return self.repaired(Skipped::Flattened, face);
        }
        self.points.clear();
        if self.ring.len() > 3 || self.has_normals {
            self.points.extend(self.ring.iter().map(|corner| statements.positions[corner[0] as usize]));
        }
        self.number_vertices(statements, face, smoothing);
        self.cut(face);
    }

    /// The vertices of the ring.
    fn number_vertices(&mut self, statements: &Statements, face: u32, smoothing: u32) {
        self.vertices.clear();
        if let Vertices::Alike(numbers) = &mut self.vertices_seen {
            return self.vertices.extend(self.ring.iter().map(|corner| numbers.number(corner[0])));
        }
        let mut flat = None;
        for i in 0..self.ring.len() {
            let [position, uv, normal] = self.ring[i];
            if uv == NONE && self.has_uvs {
                self.repaired(Skipped::MissingUv, face);
            }
            let shading = if self.has_normals {
                self.shading(statements, i, normal, face, smoothing, &mut flat)
            } else {
                FLAT_MESH
            };
            if let Vertices::Any(unifier) = &mut self.vertices_seen {
                self.vertices.push(unifier.number(position, uv, shading).0);
            }
        }
    }

    /// Where the normal of the ring's corner `i` comes from. `flat` is the face's own normal and its shading, once they were
    /// needed.
    fn shading(
        &mut self,
        statements: &Statements,
        i: usize,
        index: u32,
        face: u32,
        smoothing: u32,
        flat: &mut Option<(DVec3, u64)>,
    ) -> u64 {
        if index != NONE {
            if statements.normals[index as usize] != [0.0; 3] {
                return FILE_NORMAL | u64::from(index);
            }
            self.repaired(Skipped::ZeroNormal, face);
        }
        let (normal, shading) = *flat.get_or_insert_with(|| {
            let normal = newell(&self.points).normalize_or_zero();
            if smoothing == 0 {
                self.flats.push(or_up(normal));
            }
            (normal, FLAT | (self.flats.len() as u64).saturating_sub(1))
        });
        if smoothing == 0 {
            return shading;
        }
        let (sum, new) = self.smooth.number(self.ring[i][0], NONE, u64::from(smoothing));
        if new {
            self.sums.push(DVec3::ZERO);
        }
        let weighted = self.angle(i) * normal;
        self.sums[sum as usize] += weighted;
        SMOOTH | u64::from(sum)
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
            let [a, b, c] = triangle.map(|i| self.ring[i as usize][0]);
            if a != b && b != c && c != a {
                self.indices.push(triangle.map(|i| self.vertices[i as usize]));
            }
        }
    }

    fn finish(self, statements: &mut Statements) -> (Mesh, Numbering, Vec<(Skipped, usize, u32)>) {
        let Self { vertices_seen, done, done_count, has_uvs, has_normals, smooth, sums, flats, repairs, .. } = self;
        drop(smooth);
        let uvs = std::mem::take(&mut statements.uvs);
        let normals = std::mem::take(&mut statements.normals);
        let of_triples = || match vertices_seen {
            Vertices::Alike(numbers) => {
                let used = numbers.into_used();
                let uvs = has_uvs.then(|| gathered(&used, &uvs));
                let normals = has_normals.then(|| gathered(&used, &normals));
                (used, uvs, normals)
            }
            Vertices::Any(unifier) => {
                let mut triples = unifier.into_triples();
                let uv = |index| if index == NONE { [0.0; 2] } else { uvs[index as usize] };
                let uvs = has_uvs.then(|| triples.uvs().map(uv).collect());
                triples.drop_uvs();
                let normal = |shading: u64| {
                    let index = shading as u32 as usize;
                    match shading & !u64::from(u32::MAX) {
                        FILE_NORMAL => normals[index],
                        SMOOTH => or_up(sums[index].normalize_or_zero()),
                        _ => flats[index],
                    }
                };
                let normals = has_normals.then(|| triples.shadings().map(normal).collect());
                let Triples { positions: used, .. } = triples;
                (used, uvs, normals)
            }
        };
        let ((used, mesh_uvs, mesh_normals), indices) = parallel::both(of_triples, || joined(done, done_count));
        drop((uvs, normals));
        let positions = std::mem::take(&mut statements.positions);
        let (origin, local) = localise(used.iter().map(|&position| positions[position as usize]));
        let count = positions.len();
        drop(positions);
        let colors = mesh_colors(std::mem::take(&mut statements.colors), &used);
        let (normals, uvs) = (mesh_normals, mesh_uvs);
        let mesh = Mesh { origin, positions: local, indices, normals, uvs, colors, face_materials: None };
        (mesh, Numbering::new(count, used), repairs)
    }
}

fn gathered<T: Copy>(used: &[u32], values: &[T]) -> Arc<[T]> {
    used.iter().map(|&index| values[index as usize]).collect()
}

/// Corners with the same position have the same of everything, and no normal has to be made.
fn corners_are_alike(statements: &Statements, smooths: bool) -> bool {
    let Statements { has_uvs, has_normals, .. } = *statements;
    let settled = if has_normals { !statements.normals.contains(&[0.0; 3]) } else { !smooths };
    settled && statements.faces.iter().all(|piece| piece.corners.are_alike(has_uvs, has_normals))
}

/// The colours of the positions that are used, if there are any.
fn mesh_colors(mut colors: Vec<[f32; 4]>, used: &[u32]) -> Option<Arc<[[f32; 4]]>> {
    if colors.is_empty() {
        return None;
    }
    vertex_colors::decode(&mut colors);
    Some(used.iter().map(|&position| colors.get(position as usize).copied().unwrap_or(WHITE)).collect())
}

/// The triangles of all pieces, each of which is given back once it is copied.
fn joined(pieces: Vec<Vec<[u32; 3]>>, count: usize) -> Arc<[[u32; 3]]> {
    let mut all: Arc<[[u32; 3]]> = zeroed_shared(count);
    let mut at = 0;
    if let Some(all) = Arc::get_mut(&mut all) {
        for piece in pieces {
            all[at..at + piece.len()].copy_from_slice(&piece);
            at += piece.len();
        }
    }
    all
}

/// The normal of a face, of a face without area some unit vector.
fn or_up(normal: DVec3) -> [f32; 3] {
    if normal == DVec3::ZERO { [0.0, 0.0, 1.0] } else { normal.as_vec3().to_array() }
}
