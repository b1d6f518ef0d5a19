//! Random numbers as a pure function of (seed, pixel, sample index, dimension), and warps from the unit square.

/// One random dimension's name inside a path vertex. A dimension is the pair (vertex, slot); vertex 0 is the camera.
#[repr(u32)]
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Slot {
    /// Offset inside the pixel's filter (2D, camera).
    Pixel = 0,
    /// Point on the lens (2D, camera).
    Lens,
    /// Shutter time (1D, camera).
    Time,
    /// Hero wavelength (1D, camera).
    Wavelength,
    /// Which light (1D).
    LightSelect,
    /// Point on the light (2D).
    LightPosition,
    /// Which lobe of the BSDF (1D).
    BsdfLobe,
    /// Direction inside the lobe (2D).
    BsdfDirection,
    /// Free flight in a medium (1D).
    FreeFlight,
    /// Stochastic opacity (1D).
    Opacity,
    /// Russian roulette (1D).
    Roulette,
    /// Phase function or other scattering in a medium (2D).
    Phase,
}

pub mod warp;

/// One sample of one pixel: all that random numbers may depend on, but for the dimension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleKey {
    /// Hash of (seed, pixel, half).
    pub stream: u64,
    /// Sample index inside the half.
    pub index: u32,
}

/// Where random numbers come from. Each is a pure function of (seed, absolute pixel, sample index, dimension), never of
/// the number of samples or the size of the image. Samples with an even and an odd index form two halves with
/// independent scrambling.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sampler {
    /// Hashed uniform numbers.
    Independent,
    /// Owen-scrambled Sobol points, padded per dimension pair.
    Sobol,
}

impl Sampler {
    /// The key of sample `index` of `pixel` (absolute coordinates, x to the right, y down).
    #[inline]
    pub fn key(self, seed: u64, pixel: [u32; 2], index: u32) -> SampleKey {
        let mut h = mix(seed ^ 0x9e37_79b9_7f4a_7c15);
        h = mix(h ^ (u64::from(pixel[0]) << 32 | u64::from(pixel[1])));
        SampleKey { stream: mix(h ^ u64::from(index & 1)), index: index >> 1 }
    }

    /// A number in [0, 1).
    #[inline]
    pub fn one_d(self, key: SampleKey, vertex: u32, slot: Slot) -> f32 {
        self.two_d(key, vertex, slot)[0]
    }

    /// A point in [0, 1)^2.
    #[inline]
    pub fn two_d(self, key: SampleKey, vertex: u32, slot: Slot) -> [f32; 2] {
        let h = mix(key.stream ^ mix((u64::from(vertex) << 32 | u64::from(slot as u32)) ^ (u64::from(key.index) << 8)));
        [to_unit((h >> 32) as u32), to_unit(h as u32)]
    }
}

/// Finaliser of SplitMix64 (Steele, Lea and Flood 2014; constants by Stafford).
#[inline]
fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// The top 24 bits as a number in [0, 1).
#[inline]
fn to_unit(bits: u32) -> f32 {
    (bits >> 8) as f32 * (1.0 / 16_777_216.0)
}
