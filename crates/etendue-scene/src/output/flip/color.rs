//! Colour spaces of the difference: opponent colours YCxCz, CIELAB with Hunt's adjustment, the HyAB distance.

/// Linear Rec. 709 to CIE XYZ (D65), the rational numbers that define sRGB.
const TO_XYZ: [[f64; 3]; 3] = [
    [10_135_552.0 / 24_577_794.0, 8_788_810.0 / 24_577_794.0, 4_435_075.0 / 24_577_794.0],
    [2_613_072.0 / 12_288_897.0, 8_788_810.0 / 12_288_897.0, 887_015.0 / 12_288_897.0],
    [1_425_312.0 / 73_733_382.0, 8_788_810.0 / 73_733_382.0, 70_074_185.0 / 73_733_382.0],
];

/// The inverse of [`TO_XYZ`].
const FROM_XYZ: [[f64; 3]; 3] = inverse(TO_XYZ);

/// XYZ of white.
const WHITE: [f64; 3] = [row_sum(0), row_sum(1), row_sum(2)];

const fn row_sum(row: usize) -> f64 {
    TO_XYZ[row][0] + TO_XYZ[row][1] + TO_XYZ[row][2]
}

const fn inverse(m: [[f64; 3]; 3]) -> [[f64; 3]; 3] {
    let mut cofactors = [[0.0; 3]; 3];
    let mut i = 0;
    while i < 9 {
        let (r, c) = (i / 3, i % 3);
        let (r1, r2, c1, c2) = ((r + 1) % 3, (r + 2) % 3, (c + 1) % 3, (c + 2) % 3);
        // Transposed.
        cofactors[c][r] = m[r1][c1] * m[r2][c2] - m[r1][c2] * m[r2][c1];
        i += 1;
    }
    let determinant = m[0][0] * cofactors[0][0] + m[0][1] * cofactors[1][0] + m[0][2] * cofactors[2][0];
    let mut i = 0;
    while i < 9 {
        cofactors[i / 3][i % 3] /= determinant;
        i += 1;
    }
    cofactors
}

fn multiply(m: &[[f64; 3]; 3], v: [f64; 3]) -> [f64; 3] {
    m.map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// XYZ of a linear colour, white being 1, 1, 1.
fn relative_xyz(rgb: [f64; 3]) -> [f64; 3] {
    let xyz = multiply(&TO_XYZ, rgb);
    [0, 1, 2].map(|i| xyz[i] / WHITE[i])
}

/// YCxCz of a linear colour.
pub(super) fn opponent(rgb: [f64; 3]) -> [f32; 3] {
    let [x, y, z] = relative_xyz(rgb);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)].map(|v| v as f32)
}

/// The linear colour of YCxCz, clamped to what a monitor shows.
pub(super) fn linear_rgb(opponent: [f32; 3]) -> [f64; 3] {
    let [luminance, cx, cz] = opponent.map(f64::from);
    let y = (luminance + 16.0) / 116.0;
    let relative = [y + cx / 500.0, y, y - cz / 200.0];
    multiply(&FROM_XYZ, [0, 1, 2].map(|i| relative[i] * WHITE[i])).map(|c| c.clamp(0.0, 1.0))
}

/// CIELAB of a linear colour, its chroma in proportion to its lightness: dark colours look less colourful (Hunt 1952).
pub(super) fn hunt_lab(rgb: [f64; 3]) -> [f32; 3] {
    const DELTA: f64 = 6.0 / 29.0;
    let root = |t: f64| {
        if t > DELTA * DELTA * DELTA { libm::cbrt(t) } else { t / (3.0 * DELTA * DELTA) + 4.0 / 29.0 }
    };
    let [x, y, z] = relative_xyz(rgb).map(root);
    let lightness = 116.0 * y - 16.0;
    [lightness, 0.01 * lightness * 500.0 * (x - y), 0.01 * lightness * 200.0 * (y - z)].map(|v| v as f32)
}

/// Distance in lightness plus that in chroma (Abasi, Amani Tehran, Fairchild, "Distance metrics for very large color
/// differences", 2020).
pub(super) fn hyab(a: &[f32; 3], b: &[f32; 3]) -> f64 {
    let d = [0, 1, 2].map(|i| f64::from(a[i]) - f64::from(b[i]));
    d[0].abs() + (d[1] * d[1] + d[2] * d[2]).sqrt()
}

/// The distance of the colours that are furthest apart: pure green and pure blue.
pub(super) const LARGEST_DIFFERENCE: f64 = 203.301_66;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_difference_is_that_of_green_and_blue() {
        let found = hyab(&hunt_lab([0.0, 1.0, 0.0]), &hunt_lab([0.0, 0.0, 1.0]));
        assert!((found / LARGEST_DIFFERENCE - 1.0).abs() < 1e-6, "{found}");
    }

    #[test]
    fn opponent_colours_come_back_and_greys_have_no_chroma() {
        for rgb in [[0.25, 0.5, 0.75], [1.0, 0.0, 0.125], [0.0, 0.0, 0.0]] {
            let back = linear_rgb(opponent(rgb));
            assert!((0..3).all(|i| (back[i] - rgb[i]).abs() < 1e-6), "{back:?}");
        }
        let [l, a, b] = hunt_lab([1.0; 3]);
        assert!((l - 100.0).abs() < 1e-4 && a.abs() < 1e-4 && b.abs() < 1e-4);
    }
}
