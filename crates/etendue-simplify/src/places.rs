//! Vertices at the same position.

/// No vertex.
const NONE: u32 = u32::MAX;

/// For each vertex, the smallest index of those at exactly its position; zeros of both signs are equal, and each NaN only to itself,
/// bit by bit. At most 2^32 - 1 positions.
pub(crate) fn first_at_place(positions: &[[f32; 3]]) -> Vec<u32> {
    let places = (2 * positions.len()).next_power_of_two().max(2);
    let shift = 64 - places.trailing_zeros();
    let mut table = vec![NONE; places];
    let mut first = Vec::with_capacity(positions.len());
    for (vertex, &position) in positions.iter().enumerate() {
        let key = bits(position);
        let mut place = (hash(key) >> shift) as usize;
        first.push(loop {
            let there = table[place];
            if there == NONE {
                table[place] = vertex as u32;
                break vertex as u32;
            }
            if bits(positions[there as usize]) == key {
                break there;
            }
            place = (place + 1) & (places - 1);
        });
    }
    first
}

/// Equal for equal positions.
fn bits(position: [f32; 3]) -> [u32; 3] {
    // Adding zero makes -0 a 0.
    position.map(|x| (x + 0.0).to_bits())
}

fn hash([x, y, z]: [u32; 3]) -> u64 {
    let word = (u64::from(x) | u64::from(y) << 32).wrapping_mul(0x9E37_79B9_7F4A_7C15);
    let word = ((word ^ (word >> 32)) ^ u64::from(z)).wrapping_mul(0xD6E8_FEB8_6659_FD93);
    (word ^ (word >> 32)).wrapping_mul(0x9E37_79B9_7F4A_7C15)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_positions_are_one_vertex() {
        let nan = f32::NAN;
        let positions =
            [[1.0, 2.0, 3.0], [0.0, 0.0, 1.0], [1.0, 2.0, 3.0], [-0.0, 0.0, 1.0], [nan; 3], [3.0, 2.0, 1.0], [nan; 3]];
        assert_eq!(first_at_place(&positions), [0, 1, 0, 1, 4, 5, 4]);
        assert!(first_at_place(&[]).is_empty());
        let grid: Vec<[f32; 3]> =
            (0..40_000).map(|i| [(i % 200) as f32, (i / 200) as f32 * 0.5, 0.0]).cycle().take(80_000).collect();
        let expected: Vec<u32> = (0..40_000).chain(0..40_000).collect();
        assert_eq!(first_at_place(&grid), expected);
    }
}
