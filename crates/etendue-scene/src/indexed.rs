//! Vertices and the polygons between them, as most mesh formats list them, to a mesh of triangles.

use crate::{
    Diagnostic,
    mesh_file::Numbering,
    polygon::{Cut, Triangulator, newell},
    positions::localise,
    text::counted,
};
use etendue::scene::Mesh;
use glam::DVec3;

/// What is repaired on the way to a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Repair {
    Unreferenced,
    BadNormal,
    FewCorners,
    RepeatedCorner,
    SelfIntersecting,
    TooComplex,
}

impl Repair {
    /// The message for `count` of them.
    pub fn describe(self, count: usize) -> Diagnostic {
        let of = |thing: &str| counted(count, thing);
        match self {
            Self::Unreferenced => {
                Diagnostic::note(format!("vertices that no face uses are left out ({count} of them)"))
            }
            Self::BadNormal => Diagnostic::note(format!(
                "{} without length, or not finite, replaced by those of the faces",
                of("normal")
            )),
            Self::FewCorners => {
                Diagnostic::warning(format!("{} with fewer than three different corners skipped", of("face")))
            }
            Self::RepeatedCorner => Diagnostic::note(format!("{} merged with the same corner beside it", of("corner"))),
            Self::SelfIntersecting => {
                Diagnostic::warning(format!("{} crossing itself or without area cut as well as may be", of("polygon")))
            }
            Self::TooComplex => {
                Diagnostic::warning(format!("{} with too many corners cut as if convex", of("polygon")))
            }
        }
    }
}

/// Vertices by column, and the corners of all faces in order.
#[derive(Default)]
pub(crate) struct Indexed {
    pub positions: Vec<DVec3>,
    /// Unit length, or zero where the file has none.
    pub normals: Option<Vec<[f32; 3]>>,
    pub uvs: Option<Vec<[f32; 2]>>,
    /// Linear, with opacity.
    pub colors: Option<Vec<[f32; 4]>>,
    /// Valid indices.
    pub corners: Vec<u32>,
    /// Number of corners of each face; `None`: all have three.
    pub sizes: Option<Vec<u32>>,
}

impl Indexed {
    /// Ends a polygon whose corners have been appended.
    #[inline(always)]
    pub fn end_polygon(&mut self, count: u32) {
        match &mut self.sizes {
            Some(sizes) => sizes.push(count),
            None if count == 3 => {}
            None => {
                let before = (self.corners.len() - count as usize) / 3;
                let mut sizes = vec![3; before];
                sizes.push(count);
                self.sizes = Some(sizes);
            }
        }
    }

    /// For each vertex whether a face uses it.
    pub fn used(&self) -> Vec<bool> {
        let mut used = vec![false; self.positions.len()];
        self.corners.iter().for_each(|&corner| used[corner as usize] = true);
        used
    }

    /// Leaves out what is not `used`, cuts polygons, repairs normals; tells `report` what was done how often. The positions
    /// that are used have to be usable.
    pub fn into_mesh(mut self, used: Vec<bool>, report: &mut dyn FnMut(Repair, usize)) -> (Mesh, Numbering) {
        let unused = used.iter().filter(|&&used| !used).count();
        let mut numbering = Numbering::same(used.len());
        if unused > 0 {
            report(Repair::Unreferenced, unused);
            self.compact(&used);
            numbering.of_vertices = Some((0..used.len() as u32).filter(|&vertex| used[vertex as usize]).collect());
        }
        drop(used);
        let corners = std::mem::take(&mut self.corners);
        let indices = match self.sizes.take() {
            None => {
                let triangles = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
                let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
                let broken = triangles.clone().filter(|t| !whole(t)).count();
                if broken > 0 {
                    report(Repair::FewCorners, broken);
                }
                triangles.filter(whole).collect()
            }
            Some(sizes) => {
                let (indices, repairs) = cut_polygons(&self.positions, &corners, &sizes);
                repairs.into_iter().for_each(|(what, count)| report(what, count));
                indices
            }
        };
        let positions = self.positions;
        let normals = self.normals.filter(|normals| normals.iter().any(|n| *n != [0.0; 3]));
        let normals = normals.map(|mut normals| {
            let replaced = replace_normals(&mut normals, &positions, &indices);
            if replaced > 0 {
                report(Repair::BadNormal, replaced);
            }
            normals
        });
        let (origin, local) = localise(positions.iter().copied());
        let mesh = Mesh {
            origin,
            positions: local,
            indices: indices.into(),
            normals: normals.map(Into::into),
            uvs: self.uvs.map(Into::into),
            colors: self.colors.map(Into::into),
            face_materials: None,
        };
        (mesh, numbering)
    }

    /// Drops vertices that are not used, keeping the order.
    fn compact(&mut self, used: &[bool]) {
        let mut next = 0;
        let renumbered: Vec<u32> = used
            .iter()
            .map(|&used| {
                let number = next;
                next += u32::from(used);
                number
            })
            .collect();
        fn keep<T>(values: &mut Vec<T>, used: &[bool]) {
            let mut flags = used.iter();
            values.retain(|_| flags.next().is_none_or(|&used| used));
        }
        keep(&mut self.positions, used);
        self.normals.iter_mut().for_each(|normals| keep(normals, used));
        self.uvs.iter_mut().for_each(|uvs| keep(uvs, used));
        self.colors.iter_mut().for_each(|colors| keep(colors, used));
        self.corners.iter_mut().for_each(|corner| *corner = renumbered[*corner as usize]);
    }
}

/// The triangles, and what was repaired how often.
fn cut_polygons(positions: &[DVec3], corners: &[u32], sizes: &[u32]) -> (Vec<[u32; 3]>, Vec<(Repair, usize)>) {
    let mut repairs: Vec<(Repair, usize)> = vec![];
    let mut repaired = |what| match repairs.iter_mut().find(|(kind, _)| *kind == what) {
        Some((_, count)) => *count += 1,
        None => repairs.push((what, 1)),
    };
    let mut indices = Vec::with_capacity(sizes.iter().map(|&size| (size as usize).saturating_sub(2)).sum());
    let mut triangulator = Triangulator::new();
    let (mut ring, mut points, mut triangles) = (vec![], vec![], vec![]);
    let mut rest = corners;
    for &size in sizes {
        let (face, after) = rest.split_at(size as usize);
        rest = after;
        ring.clear();
        ring.extend_from_slice(face);
        ring.dedup();
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        if ring.len() < 3 {
            repaired(Repair::FewCorners);
            continue;
        }
        (ring.len()..face.len()).for_each(|_| repaired(Repair::RepeatedCorner));
        points.clear();
        points.extend(ring.iter().map(|&corner| positions[corner as usize]));
        triangles.clear();
        match triangulator.cut(&points, &mut triangles) {
            Cut::Exact => {}
            Cut::Forced => repaired(Repair::SelfIntersecting),
            Cut::TooComplex => repaired(Repair::TooComplex),
        }
        let cut = triangles.iter().map(|triangle| triangle.map(|i| ring[i as usize]));
        // A corner that the polygon visits twice can meet itself.
        indices.extend(cut.filter(|[a, b, c]| a != b && b != c && c != a));
    }
    (indices, repairs)
}

/// Replaces normals that are zero by the sum of the vector areas of the faces about them; returns how many.
fn replace_normals(normals: &mut [[f32; 3]], positions: &[DVec3], indices: &[[u32; 3]]) -> usize {
    let zero: Vec<bool> = normals.iter().map(|normal| *normal == [0.0; 3]).collect();
    let replaced = zero.iter().filter(|&&zero| zero).count();
    if replaced == 0 {
        return 0;
    }
    let mut sums = vec![DVec3::ZERO; normals.len()];
    for triangle in indices {
        let area = newell(&triangle.map(|i| positions[i as usize]));
        triangle.iter().filter(|&&i| zero[i as usize]).for_each(|&i| sums[i as usize] += area);
    }
    for ((normal, sum), _) in normals.iter_mut().zip(sums).zip(&zero).filter(|(_, zero)| **zero) {
        *normal = sum.try_normalize().unwrap_or(DVec3::Z).as_vec3().to_array();
    }
    replaced
}
