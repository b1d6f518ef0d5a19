//! A simplified mesh before it is handed out: what is known of its vertices besides.

use crate::Mesh;
use crate::apart::keep_apart;
use crate::block::MOVED;
use crate::engine::Work;
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
}

impl Draft {
    /// What is left of a mesh; `positions` are the input's.
    pub fn of(mut work: Work, positions: &[[f32; 3]]) -> Self {
        let mut mesh = Mesh { materials: work.faces.materials.take(), ..Mesh::default() };
        let corners = work.faces.wedges.as_ref().unwrap_or(&work.faces.corners);
        let mut new_index = vec![u32::MAX; work.wedges.as_ref().map_or(work.vertices.len(), |wedges| wedges.list.len())];
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
        let mut draft = Self { mesh, kinds, owners, sources };
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

    /// Notes which vertices have other places than these.
    pub fn note_moves(&mut self, before: &[[f32; 3]]) {
        for ((source, before), now) in self.sources.iter_mut().zip(before).zip(&self.mesh.positions) {
            if before != now {
                *source = MOVED;
            }
        }
    }
}
