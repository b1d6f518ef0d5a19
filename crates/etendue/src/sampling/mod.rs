//! Random numbers as a pure function of (seed, absolute pixel, sample index, dimension), and what turns them into points,
//! directions and choices.
//!
//! No number depends on the count of samples, on the size or crop of the image, or on what was drawn before: samples can be
//! added later, a crop equals the crop of the whole, and one sample can be traced again alone. Neighbouring pixels may share out their
//! points, so that their errors cancel under a small blur; each pixel alone is as if they did not. Samples with an even and
//! with an odd index are two halves with independent scrambling, from whose difference the error is known.

mod cosine_power;
mod distribution;
mod filter;
mod filter_table;
mod grid;
mod hash;
mod independent;
mod latin_hypercube;
mod sobol;
mod strata;
mod stratified;
pub mod warp;

use std::fmt;
use std::str::FromStr;

use crate::film::UnknownName;
pub use cosine_power::CosinePower;
pub use distribution::{Choice, Distribution1D, DistributionError};
pub use filter::{Filter, FilterSampler};
pub use grid::{Cell, Distribution2D};
use hash::{GOLDEN, join, mix, mix_words, to_unit, words};
use independent::Independent;
use latin_hypercube::LatinHypercube;
use sobol::Sobol;
use stratified::Stratified;

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
    /// What is in the way of a light sample (a stream).
    LightPath,
    /// Which light an equiangular distance is about (1D).
    EquiangularLight,
    /// Equiangular distance in a medium (1D).
    EquiangularDistance,
    /// Point on the light for an equiangular distance (2D).
    EquiangularPosition,
    /// What is in the way to an equiangular distance, and from there to the light (a stream).
    EquiangularPath,
    /// Which of several candidates for a light sample (1D).
    LightResampling,
}

/// One sample of one pixel: all that random numbers may depend on, but for the dimension.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct SampleKey {
    /// Hash of (seed, pixel, half), or of the pixels' block in place of the pixel where its pixels share a scrambling.
    pub stream: u64,
    /// Sample index inside the half.
    pub index: u32,
    /// Which pixel of the block; 0 where pixels share nothing.
    pub cell: u32,
}

impl SampleKey {
    /// The key of the sample from where it is split: apart from those of samples that never are.
    #[inline]
    pub(crate) fn split_off(self) -> Self {
        Self { stream: mix(self.stream ^ GOLDEN), ..self }
    }

    /// The key of part `part` of a sample, independent of its other parts.
    #[inline]
    pub(crate) fn apart(self, part: u32) -> Self {
        Self { stream: mix(self.stream ^ u64::from(part)), ..self }
    }

    /// The key of part `part` of `parts`, the same number for all samples: together the parts of consecutive samples are as many
    /// consecutive samples.
    #[inline]
    pub(crate) fn part(self, part: u32, parts: u32) -> Self {
        Self { index: self.index.wrapping_mul(parts).wrapping_add(part), ..self }
    }
}

/// What the keys of a pixel's samples are made of.
#[derive(Clone, Copy)]
pub(crate) struct PixelKeys {
    /// Of both halves.
    streams: [u64; 2],
    cell: u32,
}

impl PixelKeys {
    #[inline]
    pub fn key(&self, index: u32) -> SampleKey {
        SampleKey { stream: self.streams[(index & 1) as usize], index: index >> 1, cell: self.cell }
    }
}

/// The sample keys of many paths with the vertex that each is at: a structure of arrays, for loops that become vector code.
#[derive(Clone)]
pub(crate) struct KeyLanes<const N: usize> {
    /// The words of the streams.
    streams: [[u32; N]; 2],
    indices: [u32; N],
    cells: [u32; N],
    vertices: [u32; N],
}

impl<const N: usize> Default for KeyLanes<N> {
    fn default() -> Self {
        Self { streams: [[0; N]; 2], indices: [0; N], cells: [0; N], vertices: [0; N] }
    }
}

impl<const N: usize> KeyLanes<N> {
    #[inline(always)]
    pub fn set(&mut self, i: usize, key: SampleKey, vertex: u32) {
        [self.streams[0][i], self.streams[1][i]] = words(key.stream);
        self.indices[i] = key.index;
        self.cells[i] = key.cell;
        self.vertices[i] = vertex;
    }

    /// Makes the first `n` lanes part `part` of `parts` of those of `whole`: see [`SampleKey::part`]. A loop without branches.
    #[inline(always)]
    pub fn set_parts(&mut self, n: usize, whole: &Self, part: u32, parts: u32) {
        for i in 0..n.min(N) {
            self.streams[0][i] = whole.streams[0][i];
            self.streams[1][i] = whole.streams[1][i];
            self.indices[i] = whole.indices[i].wrapping_mul(parts).wrapping_add(part);
            self.cells[i] = whole.cells[i];
            self.vertices[i] = whole.vertices[i];
        }
    }

    #[inline(always)]
    fn dimension(&self, i: usize, slot: Slot) -> (SampleKey, [u32; 2]) {
        let stream = [self.streams[0][i], self.streams[1][i]];
        let key = SampleKey { stream: join(stream), index: self.indices[i], cell: self.cells[i] };
        (key, dimension(stream, self.vertices[i], slot))
    }
}

/// Where random numbers come from. Each is a pure function of (seed, absolute pixel, sample index, dimension), never of
/// the number of samples or the size of the image. Samples with an even and an odd index form two halves with
/// independent scrambling.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Sampler {
    /// Hashed uniform numbers.
    Independent,
    /// Owen-scrambled Sobol points, padded per dimension pair, in an order of the pixels of a block that spreads the error.
    #[default]
    Sobol,
    /// Jittered points in nested grids of cells, padded: the classical stratified sampling.
    Stratified,
    /// Jittered points in nested columns and rows, padded: the classical Latin hypercube.
    LatinHypercube,
}

/// What a kind of sampler computes. `dimension` is the hash of (stream, vertex, slot).
trait Points {
    fn one_d(key: SampleKey, dimension: [u32; 2]) -> f32;
    fn two_d(key: SampleKey, dimension: [u32; 2]) -> [f32; 2];
}

/// Runs `$body` with `$Points` the type behind `$sampler`.
macro_rules! dispatch {
    ($sampler:expr, $Points:ident => $body:expr) => {
        match $sampler {
            Sampler::Independent => {
                type $Points = Independent;
                $body
            }
            Sampler::Sobol => {
                type $Points = Sobol;
                $body
            }
            Sampler::Stratified => {
                type $Points = Stratified;
                $body
            }
            Sampler::LatinHypercube => {
                type $Points = LatinHypercube;
                $body
            }
        }
    };
}

/// The hash of (stream, vertex, slot): different ones for the vertices and slots of a stream.
#[inline(always)]
fn dimension([a, b]: [u32; 2], vertex: u32, slot: Slot) -> [u32; 2] {
    mix_words([a ^ vertex, b ^ slot as u32])
}

impl Sampler {
    /// All samplers.
    pub const ALL: [Self; 4] = [Self::Sobol, Self::Independent, Self::Stratified, Self::LatinHypercube];

    /// The name it has in files and on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Self::Sobol => "sobol",
            Self::Independent => "independent",
            Self::Stratified => "stratified",
            Self::LatinHypercube => "latin-hypercube",
        }
    }

    /// The key of sample `index` of `pixel` (absolute coordinates, x to the right, y down).
    #[inline]
    pub fn key(self, seed: u64, pixel: [u32; 2], index: u32) -> SampleKey {
        self.keys(seed, pixel).key(index)
    }

    /// The keys of all samples of `pixel`: see [`Self::key`].
    #[inline]
    pub(crate) fn keys(self, seed: u64, pixel: [u32; 2]) -> PixelKeys {
        let (place, cell) = match self {
            Self::Sobol => sobol::block_of(pixel),
            Self::Independent | Self::Stratified | Self::LatinHypercube => (pixel, 0),
        };
        let stream = mix(mix(seed ^ GOLDEN) ^ (u64::from(place[0]) << 32 | u64::from(place[1])));
        PixelKeys { streams: [mix(stream), mix(stream ^ 1)], cell }
    }

    /// A number in [0, 1).
    #[inline]
    pub fn one_d(self, key: SampleKey, vertex: u32, slot: Slot) -> f32 {
        let dimension = dimension(words(key.stream), vertex, slot);
        dispatch!(self, P => P::one_d(key, dimension))
    }

    /// A point in [0, 1)^2. It depends on what [`Sampler::one_d`] gives for the same arguments: take one or the other.
    #[inline]
    pub fn two_d(self, key: SampleKey, vertex: u32, slot: Slot) -> [f32; 2] {
        let dimension = dimension(words(key.stream), vertex, slot);
        dispatch!(self, P => P::two_d(key, dimension))
    }

    /// [`Sampler::one_d`] for many keys at one vertex, as far as the shorter slice reaches. A loop without branches.
    #[inline]
    pub fn one_d_slice(self, keys: &[SampleKey], vertex: u32, slot: Slot, out: &mut [f32]) {
        dispatch!(self, P => for (out, &key) in out.iter_mut().zip(keys) {
            *out = P::one_d(key, dimension(words(key.stream), vertex, slot));
        });
    }

    /// [`Sampler::two_d`] for many keys at one vertex, as far as the shorter slice reaches. A loop without branches.
    #[inline]
    pub fn two_d_slice(self, keys: &[SampleKey], vertex: u32, slot: Slot, out: &mut [[f32; 2]]) {
        dispatch!(self, P => for (out, &key) in out.iter_mut().zip(keys) {
            *out = P::two_d(key, dimension(words(key.stream), vertex, slot));
        });
    }

    /// [`Sampler::one_d`] for the first `n` lanes. A loop without branches.
    #[expect(clippy::needless_range_loop, reason = "an index is the lane")]
    #[inline(always)]
    pub(crate) fn one_d_lanes<const N: usize>(self, keys: &KeyLanes<N>, n: usize, slot: Slot, out: &mut [f32; N]) {
        dispatch!(self, P => for i in 0..n.min(N) {
            let (key, dimension) = keys.dimension(i, slot);
            out[i] = P::one_d(key, dimension);
        });
    }

    /// [`Sampler::two_d`] for the first `n` lanes. A loop without branches.
    #[expect(clippy::needless_range_loop, reason = "an index is the lane")]
    #[inline(always)]
    pub(crate) fn two_d_lanes<const N: usize>(self, keys: &KeyLanes<N>, n: usize, slot: Slot, out: &mut [[f32; N]; 2]) {
        dispatch!(self, P => for i in 0..n.min(N) {
            let (key, dimension) = keys.dimension(i, slot);
            [out[0][i], out[1][i]] = P::two_d(key, dimension);
        });
    }

    /// A number in [0, 1) with 48 bits, for choices among very many things: [`Sampler::one_d`], and hashed bits below it.
    #[inline]
    pub fn fine(self, key: SampleKey, vertex: u32, slot: Slot) -> f64 {
        let below = f64::from(self.stream(key, vertex, slot).next_f32()) / f64::from(1 << 24);
        f64::from(self.one_d(key, vertex, slot)) + below
    }

    /// [`Sampler::fine`] for the first `n` lanes. A loop without branches.
    #[expect(clippy::needless_range_loop, reason = "an index is the lane")]
    #[inline(always)]
    pub(crate) fn fine_lanes<const N: usize>(self, keys: &KeyLanes<N>, n: usize, slot: Slot, out: &mut [f64; N]) {
        dispatch!(self, P => for i in 0..n.min(N) {
            let (key, dimension) = keys.dimension(i, slot);
            let below = f64::from(Stream::new(dimension, key).next_f32()) / f64::from(1 << 24);
            out[i] = f64::from(P::one_d(key, dimension)) + below;
        });
    }

    /// As many numbers as a loop without bound may need at one (vertex, slot), independent of everything else. They are
    /// hashed whatever the sampler.
    #[inline]
    pub fn stream(self, key: SampleKey, vertex: u32, slot: Slot) -> Stream {
        Stream::new(dimension(words(key.stream), vertex, slot), key)
    }
}

impl fmt::Display for Sampler {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for Sampler {
    type Err = UnknownName;

    fn from_str(name: &str) -> Result<Self, UnknownName> {
        Self::ALL.into_iter().find(|s| s.name() == name).ok_or_else(|| UnknownName {
            kind: "sampler",
            name: name.to_owned(),
            expected: Self::ALL.map(Self::name).join(", "),
        })
    }
}

/// A sequence of independent uniform numbers, see [`Sampler::stream`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Stream {
    state: u64,
}

impl Stream {
    #[inline(always)]
    fn new(dimension: [u32; 2], key: SampleKey) -> Self {
        // Apart from the numbers of the independent sampler at this slot, which start from the same hash.
        Self { state: mix(!join(dimension) ^ mix((u64::from(key.cell) << 32 | u64::from(key.index)) ^ GOLDEN)) }
    }

    /// The next number in [0, 1).
    #[inline(always)]
    pub fn next_f32(&mut self) -> f32 {
        self.state = self.state.wrapping_add(GOLDEN);
        to_unit((mix(self.state) >> 32) as u32)
    }
}
