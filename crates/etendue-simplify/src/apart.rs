//! Different points stay at different places.
//!
//! What comes out is welded again by whoever reads it; two points that meet by chance, say the copies of a vertex where a handle was
//! cut, would make a surface that touches itself.

use std::collections::BTreeSet;

use crate::block::MOVED;
use crate::places::first_at_place;

/// Moves vertices that are at the place of another point to the next number in some direction. Vertices with the same owner are
/// one point; those whose source is known are in their own place, where no other was in the input.
pub(crate) fn keep_apart(positions: &mut [[f32; 3]], owners: &[u32], sources: &[u32]) {
    let first = first_at_place(positions);
    let meets = |&v: &usize| owners[first[v] as usize] != owners[v];
    let met: Vec<usize> = (0..positions.len()).filter(meets).collect();
    if met.is_empty() {
        return;
    }
    let mut taken: BTreeSet<[u32; 3]> = positions.iter().map(place).collect();
    for v in met {
        let there = first[v] as usize;
        let moves = if sources[v] == MOVED { v } else { there };
        let before = positions[moves];
        if sources[moves] != MOVED || positions[v] != positions[there] {
            continue;
        }
        let mut after = before;
        while taken.contains(&place(&after)) {
            after[0] = if after[0] < 0.5 * f32::MAX { after[0].next_up() } else { 0.0 };
        }
        taken.insert(place(&after));
        let owner = owners[moves];
        positions.iter_mut().zip(owners).filter(|(_, other)| **other == owner).for_each(|(p, _)| *p = after);
    }
}

fn place(position: &[f32; 3]) -> [u32; 3] {
    position.map(|x| (x + 0.0).to_bits())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_part_and_wedges_stay_together() {
        let (a, b) = ([1.0, 2.0, 3.0], [-0.0, 0.0, 0.0]);
        let mut positions = [a, b, a, a, [0.0, 0.0, 0.0], b];
        let sources = [3, MOVED, MOVED, 3, MOVED, MOVED];
        keep_apart(&mut positions, &[7, 1, 2, 7, 4, 5], &sources);
        assert_eq!([positions[0], positions[3]], [a; 2], "what has not moved stays");
        assert_eq!(positions[2], [1f32.next_up(), 2.0, 3.0]);
        let places: BTreeSet<[u32; 3]> = positions.iter().map(place).collect();
        assert_eq!(places.len(), 5, "{positions:?}");
        let before = positions;
        keep_apart(&mut positions, &[7, 1, 2, 7, 4, 5], &sources);
        assert_eq!(positions, before);
    }
}
