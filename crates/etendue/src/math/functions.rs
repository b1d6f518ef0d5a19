//! Transcendental functions as own polynomials: the platform's differ between machines.

/// Pi.
pub const PI: f32 = std::f32::consts::PI;

/// Rounds to the nearest integer, ties to even, for |x| < 2^22.
#[inline]
fn round_small(x: f32) -> f32 {
    const MAGIC: f32 = 12_582_912.0; // 1.5 * 2^23
    (x + MAGIC) - MAGIC
}

/// Sine and cosine of `2 pi turns`, for |turns| < 2^20; absolute error below 1e-7 within one turn.
#[inline]
pub fn sin_cos_turns(turns: f32) -> (f32, f32) {
    let x = turns - round_small(turns);
    let quarter = round_small(x * 4.0);
    let a = (x - quarter * 0.25) * (2.0 * PI);
    let a2 = a * a;
    // Minimax polynomials on [-pi/4, pi/4] (Cephes, Moshier 1992).
    let sin = a + a * a2 * (-1.666_665_5e-1 + a2 * (8.332_161e-3 + a2 * -1.951_529_6e-4));
    let cos = 1.0 - 0.5 * a2 + a2 * a2 * (4.166_664_6e-2 + a2 * (-1.388_731_6e-3 + a2 * 2.443_315_7e-5));
    match quarter as i32 & 3 {
        0 => (sin, cos),
        1 => (cos, -sin),
        2 => (-sin, -cos),
        _ => (-cos, sin),
    }
}
