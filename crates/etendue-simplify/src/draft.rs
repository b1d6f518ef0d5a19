//! A simplified mesh before it is handed out: what is known of its vertices besides.

use crate::Mesh;
use crate::apart::keep_apart;
use crate::block::MOVED;
use crate::engine::Work;
use crate::faces::GONE;
use crate::vector::Vec3;
use crate::vertex::Kind;

/// A mesh with what is known of each of its vertices.
pub(crate) struct Draft {
    pub mesh: Mesh,
    /// Where it may go.
    pub kinds: Vec<Kind>,
    /// The point that it belongs to: vertices of one point are at one place.
    pub owners: Vec<u32>,
    /// The vertex of the input whose place it has; [`MOVED`] if it has another.
    pub sources: Vec<u32>,
    /// The sum of the normals of all original faces that were merged into it.
    pub facing: Vec<Vec3>,
    /// What is narrower than this, in the unit of positions, is rounding.
    pub rounding: f64,
}

impl Draft {
    /// What is left of a mesh; `positions` are the input's.
    pub fn of(mut work: Work, positions: &[[f32; 3]]) -> Self {
        let mut mesh = Mesh { materials: work.faces.materials.take(), ..Mesh::default() };
        let corners = work.faces.wedges.as_ref().unwrap_or(&work.faces.corners);
        let mut new_index =
            vec![u32::MAX; work.wedges.as_ref().map_or(work.vertices.len(), |wedges| wedges.list.len())];
        for &v in corners.as_flattened() {
            new_index[v as usize] = 0;
        }
        let mut used = Vec::new();
        for (i, index) in new_index.iter_mut().enumerate().filter(|(_, index)| **index == 0) {
            *index = used.len() as u32;
            used.push(i);
        }
        let owner = |i: usize| work.wedges.as_ref().map_or(i as u32, |wedges| wedges.list[i].owner);
        let owners: Vec<u32> = used.iter().map(|&i| owner(i)).collect();
        mesh.positions = owners.iter().map(|&v| work.place(v)).collect();
        mesh.faces = corners.iter().map(|face| face.map(|v| new_index[v as usize])).collect();
        if let Some(wedges) = &work.wedges {
            wedges.write(&mut mesh, used.iter().copied());
        }
        let kinds = owners.iter().map(|&v| work.vertices[v as usize].kind).collect();
        let sources = owners.iter().map(|&v| work.sources[v as usize]).collect();
        let facing = owners.iter().map(|&v| work.facing[v as usize]).collect();
        let rounding = work.unit * f64::from(f32::EPSILON);
        let mut draft = Self { mesh, kinds, owners, sources, facing, rounding };
        draft.settle(positions);
        draft
    }

    /// Puts vertices that have not moved exactly where they are in the input, whose units the mesh has, and points that are at the
    /// place of others beside it.
    pub fn settle(&mut self, positions: &[[f32; 3]]) {
        for (position, &source) in self.mesh.positions.iter_mut().zip(&self.sources).filter(|(_, s)| **s != MOVED) {
            *position = positions[source as usize];
        }
        keep_apart(&mut self.mesh.positions, &self.owners, &self.sources);
    }

    /// Drops faces that are gone, and vertices that no face uses any more.
    pub fn clean(&mut self) {
        if !self.mesh.faces.contains(&GONE) {
            return;
        }
        let stays: Vec<bool> = self.mesh.faces.iter().map(|face| *face != GONE).collect();
        keep(&mut self.mesh.faces, &stays);
        self.mesh.materials.iter_mut().for_each(|list| keep(list, &stays));
        let mut is_used = vec![false; self.owners.len()];
        self.mesh.faces.as_flattened().iter().for_each(|&v| is_used[v as usize] = true);
        let mut count = 0;
        let new_index: Vec<u32> = is_used
            .iter()
            .map(|&is_used| {
                count += u32::from(is_used);
                count.wrapping_sub(1)
            })
            .collect();
        self.mesh.faces.as_flattened_mut().iter_mut().for_each(|v| *v = new_index[*v as usize]);
        keep(&mut self.mesh.positions, &is_used);
        self.mesh.normals.iter_mut().for_each(|list| keep(list, &is_used));
        self.mesh.uvs.iter_mut().for_each(|list| keep(list, &is_used));
        self.mesh.colors.iter_mut().for_each(|list| keep(list, &is_used));
        keep(&mut self.kinds, &is_used);
        keep(&mut self.owners, &is_used);
        keep(&mut self.sources, &is_used);
        keep(&mut self.facing, &is_used);
    }

    /// Notes which vertices have other places than these.
    pub fn note_moves(&mut self, before: &[[f32; 3]]) {
        for ((source, before), now) in self.sources.iter_mut().zip(before).zip(&self.mesh.positions) {
            if before != now {
                *source = MOVED;
            }
        }
    }
}

/// Keeps the entries that stay.
pub(crate) fn keep<T>(list: &mut Vec<T>, stays: &[bool]) {
    let mut stays = stays.iter();
    list.retain(|_| stays.next().is_some_and(|stays| *stays));
}
