//! The faces at each vertex.

use rayon::prelude::*;

/// For each vertex the faces that have it as a corner, in the order of the faces.
pub(crate) struct Rings {
    starts: Vec<u32>,
    faces: Vec<u32>,
}

/// Each task has as many faces to itself, or there is one: blocks are small and made side by side.
const PART: usize = 1 << 15;

impl Rings {
    /// `faces` name vertices below `vertices`. There are fewer than 2^32 corners.
    pub fn new(vertices: usize, faces: &[[u32; 3]]) -> Self {
        let tasks = (faces.len() / PART).clamp(1, rayon::current_num_threads().clamp(1, 8));
        let step = vertices.div_ceil(tasks).max(1);
        let mut starts = vec![0u32; vertices + 1];
        // Each task reads all faces and keeps to its own range of vertices, so the result does not depend on their number.
        starts[..vertices].par_chunks_mut(step).enumerate().for_each(|(task, counts)| {
            let low = (task * step) as u32;
            for &v in faces.as_flattened() {
                if let Some(count) = counts.get_mut(v.wrapping_sub(low) as usize) {
                    *count += 1;
                }
            }
        });
        let mut sum = 0;
        for start in &mut starts {
            let count = *start;
            *start = sum;
            sum += count;
        }
        let mut list = vec![0u32; sum as usize];
        let mut rest = list.as_mut_slice();
        let mut parts = Vec::new();
        for low in (0..vertices).step_by(step) {
            let high = (low + step).min(vertices);
            let (part, tail) = rest.split_at_mut((starts[high] - starts[low]) as usize);
            rest = tail;
            parts.push((low, high, part));
        }
        parts.into_par_iter().for_each(|(low, high, part)| {
            let base = starts[low];
            let mut next: Vec<u32> = starts[low..high].iter().map(|start| start - base).collect();
            for (face, corners) in faces.iter().enumerate() {
                for &v in corners {
                    if let Some(place) = next.get_mut((v as usize).wrapping_sub(low)) {
                        part[*place as usize] = face as u32;
                        *place += 1;
                    }
                }
            }
        });
        Self { starts, faces: list }
    }

    /// The faces at `vertex`.
    #[inline]
    pub fn at(&self, vertex: usize) -> &[u32] {
        &self.faces[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// How many vertices.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Faces of all vertices one after another, and where each vertex's begin.
    pub fn into_parts(self) -> (Vec<u32>, Vec<u32>) {
        (self.starts, self.faces)
    }
}
