//! Faces with what belongs to them.

/// A face that was collapsed away.
pub(crate) const GONE: [u32; 3] = [u32::MAX; 3];

/// The faces of a block with what belongs to them.
#[derive(Default)]
pub(crate) struct Faces {
    /// Corners relative to the block's first vertex.
    pub corners: Vec<[u32; 3]>,
    /// Wedges of the corners relative to the block's first, if attributes are kept.
    pub wedges: Option<Vec<[u32; 3]>>,
    /// Materials, if they are kept.
    pub materials: Option<Vec<u32>>,
}

impl Faces {
    /// No faces, with the same that belongs to them.
    pub fn none_like(&self) -> Self {
        Self {
            corners: Vec::new(),
            wedges: self.wedges.as_ref().map(|_| Vec::new()),
            materials: self.materials.as_ref().map(|_| Vec::new()),
        }
    }

    /// Some of the faces, with their vertices and wedges as they are called there.
    pub fn gathered(&self, list: &[u32], vertex: impl Fn(u32) -> u32, wedge: impl Fn(u32) -> u32) -> Self {
        Self {
            corners: list.iter().map(|&face| self.corners[face as usize].map(&vertex)).collect(),
            wedges: self.wedges.as_ref().map(|all| list.iter().map(|&face| all[face as usize].map(&wedge)).collect()),
            materials: self.materials.as_ref().map(|all| list.iter().map(|&face| all[face as usize]).collect()),
        }
    }

    /// Other names for vertices and wedges.
    pub fn rename(&mut self, vertex: impl Fn(u32) -> u32, wedge: impl Fn(u32) -> u32) {
        for v in self.corners.as_flattened_mut() {
            *v = vertex(*v);
        }
        for w in self.wedges.iter_mut().flat_map(|wedges| wedges.as_flattened_mut()) {
            *w = wedge(*w);
        }
    }

    /// Adds the faces of another list.
    pub fn append(&mut self, mut other: Self) {
        self.corners.append(&mut other.corners);
        if let (Some(to), Some(from)) = (&mut self.wedges, &mut other.wedges) {
            to.append(from);
        }
        if let (Some(to), Some(from)) = (&mut self.materials, &mut other.materials) {
            to.append(from);
        }
    }

    /// True if a face was collapsed.
    #[inline(always)]
    pub fn is_gone(&self, face: u32) -> bool {
        self.corners[face as usize] == GONE
    }

    /// Drops what was collapsed.
    pub fn clean(&mut self) {
        let corners = &self.corners;
        let mut i = 0;
        let mut stays = || {
            i += 1;
            corners[i - 1] != GONE
        };
        if let Some(materials) = &mut self.materials {
            materials.retain(|_| stays());
        }
        let mut i = 0;
        let mut stays = || {
            i += 1;
            corners[i - 1] != GONE
        };
        if let Some(wedges) = &mut self.wedges {
            wedges.retain(|_| stays());
        }
        self.corners.retain(|face| *face != GONE);
    }
}
