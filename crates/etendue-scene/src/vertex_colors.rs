//! Colours of vertices as files have them, and as the renderer wants them.
//!
//! OBJ (`v x y z r g b`) and PLY (`red green blue alpha`) do not say what their numbers mean. The programs that write them
//! take them from the screen, so they are read as sRGB, as by Blender and three.js; opacity is linear. Bytes count to 255;
//! other numbers to 1, unless one of the file is above 1: then all count to 255.

/// The colour of a vertex without one, among others that have one.
pub(crate) const WHITE: [f32; 4] = [1.0; 4];
/// A vertex without colour before [`decode`], which makes it white whatever others count to.
pub(crate) const NONE: [f32; 4] = [f32::INFINITY; 4];

/// What a stored channel in [0, 1] stands for. A number that is but for its last digits one of 255 steps becomes exactly that,
/// so that colours of 8 bits stay the same in every file.
fn decoded(stored: f64, bytes: &[f32; 256]) -> f32 {
    let steps = stored * 255.0;
    let nearest = libm::round(steps);
    if (steps - nearest).abs() < 1e-3 { bytes[nearest as usize & 255] } else { linear(stored) }
}

fn linear(stored: f64) -> f32 {
    let linear = if stored <= 0.040_45 { stored / 12.92 } else { libm::pow((stored + 0.055) / 1.055, 2.4) };
    linear as f32
}

/// The inverse of [`decoded`], as steps of 255; whole where it is nearly.
fn encoded(linear: f32) -> f64 {
    let linear = f64::from(linear);
    let stored = if linear <= 0.003_130_8 { linear * 12.92 } else { 1.055 * libm::pow(linear, 1.0 / 2.4) - 0.055 };
    let steps = stored * 255.0;
    let nearest = libm::round(steps);
    if (steps - nearest).abs() < 1e-3 { nearest } else { steps }
}

/// Makes colours linear, in place. Numbers below 0 become 0.
pub(crate) fn decode(colors: &mut [[f32; 4]]) {
    let stored = colors.iter().filter(|c| **c != NONE).flat_map(|c| &c[..3]);
    let most = stored.fold(0.0f32, |most, c| most.max(*c));
    let scale = if most > 1.0 { 1.0 / 255.0 } else { 1.0 };
    let bytes = std::array::from_fn(|byte| linear(byte as f64 / 255.0));
    for color in colors {
        if *color == NONE {
            *color = WHITE;
            continue;
        }
        let alpha = color[3];
        *color = color.map(|c| decoded((f64::from(c) * scale).clamp(0.0, 1.0), &bytes));
        // Colours in bytes have their opacity in bytes as well, and 1 where there is none.
        color[3] = (if alpha > 1.0 { alpha / 255.0 } else { alpha }).clamp(0.0, 1.0);
    }
}

/// Colours on their way into a file, in steps of 255.
pub(crate) fn encode([r, g, b, a]: [f32; 4]) -> [f64; 4] {
    let opacity = f64::from(a) * 255.0;
    let nearest = libm::round(opacity);
    [encoded(r), encoded(g), encoded(b), if (opacity - nearest).abs() < 1e-3 { nearest } else { opacity }]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_come_back() {
        for byte in 0..=255u8 {
            let stored = f32::from(byte) / 255.0;
            let mut as_numbers = [[stored, 0.0, 1.0, stored], [1.0; 4]];
            let mut as_bytes = [[f32::from(byte), 0.0, 255.0, f32::from(byte)], [255.0, 255.0, 255.0, 255.0]];
            decode(&mut as_numbers);
            decode(&mut as_bytes);
            assert_eq!(as_numbers[0][..3], as_bytes[0][..3]);
            let back = encode(as_numbers[0]);
            assert_eq!(back, [f64::from(byte), 0.0, 255.0, f64::from(byte)]);
        }
        let mut some = [NONE, [255.0, 0.0, 0.0, 1.0]];
        decode(&mut some);
        assert_eq!(some, [WHITE, [1.0, 0.0, 0.0, 1.0]]);
        let mut odd = [[-3.0, 0.5001, 7e-5, f32::MIN_POSITIVE]];
        decode(&mut odd);
        assert!(odd[0][0] == 0.0 && (odd[0][1] - 0.214_133).abs() < 1e-5 && odd[0].iter().all(|c| c.is_finite()));
    }
}
