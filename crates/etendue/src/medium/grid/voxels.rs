//! Densities as they are stored.

/// Densities of a grid, x fastest, then y, then z.
#[derive(Clone, Debug, PartialEq)]
pub enum Voxels {
    /// Whole numbers; 255 is density 1.
    U8(Vec<u8>),
    /// Whole numbers; 65535 is density 1.
    U16(Vec<u16>),
    /// Bits of IEEE 754 half precision.
    F16(Vec<u16>),
    /// Single precision.
    F32(Vec<f32>),
}

impl Voxels {
    /// How many.
    pub fn len(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) | Self::F16(values) => values.len(),
            Self::F32(values) => values.len(),
        }
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> usize {
        match self {
            Self::U8(values) => values.len(),
            Self::U16(values) | Self::F16(values) => 2 * values.len(),
            Self::F32(values) => 4 * values.len(),
        }
    }

    /// The density of a voxel.
    ///
    /// # Panics
    /// If there is no such voxel.
    #[inline]
    pub fn get(&self, index: usize) -> f32 {
        match self {
            Self::U8(values) => f32::from(values[index]) * (1.0 / 255.0),
            Self::U16(values) => f32::from(values[index]) * (1.0 / 65535.0),
            Self::F16(values) => half_to_single(values[index]),
            Self::F32(values) => values[index],
        }
    }

    /// Sets what is negative or not finite to 0, and tells how many those were.
    pub(super) fn repair(&mut self) -> u64 {
        let mut repaired = 0;
        let mut is_wrong = |value: f32| {
            let wrong = !(value >= 0.0 && value.is_finite());
            repaired += u64::from(wrong);
            wrong
        };
        match self {
            Self::U8(_) | Self::U16(_) => {}
            Self::F16(values) => {
                values.iter_mut().filter(|bits| is_wrong(half_to_single(**bits))).for_each(|bits| *bits = 0);
            }
            Self::F32(values) => values.iter_mut().filter(|v| is_wrong(**v)).for_each(|v| *v = 0.0),
        }
        repaired
    }
}

/// IEEE 754 binary16 to binary32, exact.
#[inline]
fn half_to_single(bits: u16) -> f32 {
    let sign = u32::from(bits & 0x8000) << 16;
    let magnitude = u32::from(bits & 0x7fff) << 13;
    let wide = if magnitude >= 0x7c00 << 13 {
        magnitude | 0x7f80_0000
    } else {
        // Rebiased by a product, which makes subnormal numbers normal.
        (f32::from_bits(magnitude) * f32::from_bits((254 - 15) << 23)).to_bits()
    };
    f32::from_bits(sign | wide)
}

#[cfg(test)]
mod tests {
    use super::half_to_single;

    #[test]
    fn halves() {
        for (bits, value) in [
            (0x0000, 0.0),
            (0x8000, -0.0),
            (0x0001, 5.960_464_5e-8),
            (0x03ff, 6.097_555e-5),
            (0x0400, 6.103_515_6e-5),
            (0x3555, 0.333_251_95),
            (0x3c00, 1.0),
            (0xc000, -2.0),
            (0x7bff, 65504.0),
            (0x7c00, f32::INFINITY),
            (0xfc00, f32::NEG_INFINITY),
        ] {
            assert_eq!(half_to_single(bits).to_bits(), f32::to_bits(value), "{bits:x}");
        }
        assert!(half_to_single(0x7e00).is_nan());
    }
}
