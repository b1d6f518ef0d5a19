//! Vertices of equal position become one point. Points are numbered along a curve that keeps neighbours together, so that
//! ranges of points are pieces of the surface and memory is read in order.

use rayon::prelude::*;

use crate::vector::Vec3;

/// No point: an index of a vertex that no face uses or that is not finite.
pub(crate) const NONE: u32 = u32::MAX;

/// Vertices and their points.
pub(crate) struct Welded {
    /// The point of each vertex, or [`NONE`].
    pub point_of: Vec<u32>,
    /// The first vertex, by index, at each point.
    pub vertex_of: Vec<u32>,
    /// Vertices that have a point, in the order of points.
    pub order: Vec<u32>,
    /// The largest extent of the points.
    pub extent: f32,
}

/// Ten bits apart by two zeros.
fn spread(v: u32) -> u64 {
    let mut v = u64::from(v & 0x3ff);
    v = (v | v << 16) & 0x0300_00ff;
    v = (v | v << 8) & 0x0300_f00f;
    v = (v | v << 4) & 0x030c_30c3;
    (v | v << 2) & 0x0924_9249
}

/// The bits of a coordinate, the same for both zeros.
fn bits(p: Vec3) -> [u32; 3] {
    p.map(|v| (v + 0.0).to_bits())
}

pub(crate) fn weld(positions: &[Vec3], faces: &[[u32; 3]]) -> Welded {
    let mut used = vec![false; positions.len()];
    for &i in faces.as_flattened() {
        used[i as usize] = true;
    }
    let finite = |p: &Vec3| p.iter().all(|v| v.is_finite());
    let (low, high) =
        positions.par_iter().zip(&used).filter(|(p, used)| **used && finite(p)).map(|(p, _)| (*p, *p)).reduce(
            || ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]),
            |a, b| {
                let [x, y, z] = [0, 1, 2].map(|i| (a.0[i].min(b.0[i]), a.1[i].max(b.1[i])));
                ([x.0, y.0, z.0], [x.1, y.1, z.1])
            },
        );
    // In f64: the difference of two large floats may overflow.
    let extent = (0..3).map(|i| f64::from(high[i]) - f64::from(low[i])).fold(0.0, f64::max);
    let to_cell = if extent > 0.0 { 1023.0 / extent } else { 0.0 };
    let mut keys: Vec<u64> = positions
        .par_iter()
        .zip(&used)
        .enumerate()
        .filter(|(_, (p, used))| **used && finite(p))
        .map(|(i, (p, _))| {
            let [x, y, z] = [0, 1, 2].map(|k| spread(((f64::from(p[k]) - f64::from(low[k])) * to_cell) as u32));
            (x | y << 1 | z << 2) << 32 | i as u64
        })
        .collect();
    drop(used);
    keys.par_sort_unstable();
    let vertex = |key: u64| key as u32 as usize;
    keys.par_chunk_by_mut(|a, b| a >> 32 == b >> 32).for_each(|cell| {
        if cell.len() > 1 {
            cell.sort_unstable_by_key(|&key| (bits(positions[vertex(key)]), key));
        }
    });
    let mut point_of = vec![NONE; positions.len()];
    let mut vertex_of: Vec<u32> = Vec::with_capacity(keys.len());
    let mut last = None;
    for &key in &keys {
        let i = vertex(key);
        let here = bits(positions[i]);
        if last != Some(here) {
            vertex_of.push(i as u32);
            last = Some(here);
        }
        point_of[i] = vertex_of.len() as u32 - 1;
    }
    let order = keys.par_iter().map(|&key| key as u32).collect();
    Welded { order, point_of, vertex_of, extent: extent.min(f64::from(f32::MAX)) as f32 }
}
