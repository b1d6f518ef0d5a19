//! The sRGB transfer function backwards, for reading.

/// sRGB value in [0, 1] to linear (IEC 61966-2-1).
pub(crate) fn to_linear(encoded: f64) -> f64 {
    if encoded <= 0.040_45 { encoded / 12.92 } else { libm::pow((encoded + 0.055) / 1.055, 2.4) }
}
