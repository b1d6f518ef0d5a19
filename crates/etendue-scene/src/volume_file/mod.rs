//! Reading volumes, grids of densities, under limits that are checked before memory is taken.
//!
//! | format | what is read |
//! |---|---|
//! | NPY | versions 1.0 to 3.0; arrays of three dimensions of bytes, booleans, 16-bit whole numbers, half, single and double precision; C and Fortran order, either endianness |
//! | raw | the same samples and nothing else; their type, order and number come from elsewhere |
//!
//! NPY files are told by their first bytes, whatever the ending.

pub(crate) mod npy;

use etendue::medium::{DensityGrid, GridError, Voxels};
use std::{
    fmt,
    path::{Path, PathBuf},
};

/// What reading a volume may cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest file, bytes.
    pub file: u64,
    /// Most voxels.
    pub voxels: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self { file: 16 << 30, voxels: 1 << 32 }
    }
}

/// What a sample is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SampleType {
    /// A byte, 255 being density 1.
    U8,
    /// A whole number of 16 bits, 65535 being density 1.
    U16,
    /// Half precision.
    F16,
    /// Single precision.
    F32,
    /// Double precision, kept as single.
    F64,
}

impl SampleType {
    /// All types.
    pub const ALL: [Self; 5] = [Self::U8, Self::U16, Self::F16, Self::F32, Self::F64];

    /// As in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::U8 => "u8",
            Self::U16 => "u16",
            Self::F16 => "f16",
            Self::F32 => "f32",
            Self::F64 => "f64",
        }
    }

    /// Bytes of one.
    pub fn bytes(self) -> usize {
        match self {
            Self::U8 => 1,
            Self::U16 | Self::F16 => 2,
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Which end of a number comes first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ByteOrder {
    /// The lowest byte.
    #[default]
    Little,
    /// The highest byte.
    Big,
}

impl ByteOrder {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Little, Self::Big];

    /// As in scene files.
    pub fn name(self) -> &'static str {
        match self {
            Self::Little => "little",
            Self::Big => "big",
        }
    }
}

/// What the indices of an array count: a permutation of 0, 1, 2 for x, y, z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Axes([u8; 3]);

impl Axes {
    /// All orders.
    pub const ALL: [Self; 6] =
        [Self([0, 1, 2]), Self([0, 2, 1]), Self([1, 0, 2]), Self([1, 2, 0]), Self([2, 0, 1]), Self([2, 1, 0])];
    /// `a[x, y, z]`, as one writes in NumPy.
    pub const XYZ: Self = Self([0, 1, 2]);
    /// `a[z][y][x]`: x runs fastest.
    pub const ZYX: Self = Self([2, 1, 0]);

    /// As in scene files.
    pub fn name(self) -> &'static str {
        match self.0 {
            [0, 1, 2] => "xyz",
            [0, 2, 1] => "xzy",
            [1, 0, 2] => "yxz",
            [1, 2, 0] => "yzx",
            [2, 0, 1] => "zxy",
            _ => "zyx",
        }
    }
}

/// What a raw file holds, which it does not say itself.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct RawLayout {
    /// Voxels along x, y and z.
    pub size: [u32; 3],
    /// What a sample is.
    pub sample: SampleType,
    /// Which end of it comes first.
    pub byte_order: ByteOrder,
}

/// Why a volume could not be read.
#[derive(Debug, thiserror::Error)]
pub enum VolumeError {
    /// The content contradicts its format.
    #[error("`{}` is a damaged {format} file: at byte {offset}: {what}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Name of the format.
        format: &'static str,
        /// Where.
        offset: u64,
        /// What is wrong, and what was expected.
        what: String,
    },
    /// A good file of something that is not read.
    #[error("`{}`: {what}", path.display())]
    Unsupported {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: String,
        /// What to do about it.
        help: String,
    },
    /// More than the limits allow.
    #[error("`{}` is too large: {what}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What is too large.
        what: String,
    },
    /// No grid can be made of it.
    #[error("`{}`: {error}", path.display())]
    Grid {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        error: GridError,
    },
}

impl VolumeError {
    /// What to do about it, if there is something to say.
    pub fn help(&self) -> Option<&str> {
        match self {
            Self::Unsupported { help, .. } => Some(help),
            _ => None,
        }
    }
}

/// An array of samples in a file.
#[derive(Clone, Copy, Debug)]
struct Array<'a> {
    /// In the order of its indices.
    shape: [u32; 3],
    sample: SampleType,
    byte_order: ByteOrder,
    /// Samples that are not 0 are 1.
    boolean: bool,
    /// The first index runs fastest.
    fortran: bool,
    /// As many as the shape says.
    bytes: &'a [u8],
}

/// True if the file says itself what it holds.
pub fn is_npy(bytes: &[u8]) -> bool {
    bytes.starts_with(npy::MAGIC)
}

/// Reads a volume. Without a `layout` it must be an NPY file. `axes` is what the indices of the array count; absent:
/// [`Axes::XYZ`] for NPY, [`Axes::ZYX`] for raw files.
///
/// # Errors
/// [`VolumeError`].
pub fn decode_volume(
    path: &Path,
    bytes: &[u8],
    layout: Option<&RawLayout>,
    axes: Option<Axes>,
    limits: &Limits,
) -> Result<DensityGrid, VolumeError> {
    let file = File { path, bytes, limits };
    let (array, axes) = match layout {
        None => (npy::read(&file)?, axes.unwrap_or(Axes::XYZ)),
        Some(layout) => {
            let axes = axes.unwrap_or(Axes::ZYX);
            (raw(&file, layout, axes)?, axes)
        }
    };
    let grid = |error| VolumeError::Grid { path: path.to_owned(), error };
    let mut size = [0; 3];
    for (count, axis) in array.shape.iter().zip(axes.0) {
        size[usize::from(axis)] = *count;
    }
    if size.iter().any(|n| *n == 0 || *n > DensityGrid::MAX_SIDE) {
        return Err(grid(GridError::Size(size)));
    }
    let voxels = file.voxels(&array, axes, size)?;
    DensityGrid::new(size, voxels).map_err(grid)
}

/// A file in memory.
struct File<'a> {
    path: &'a Path,
    bytes: &'a [u8],
    limits: &'a Limits,
}

impl<'a> File<'a> {
    fn damaged(&self, format: &'static str, offset: usize, what: impl fmt::Display) -> VolumeError {
        VolumeError::Damaged { path: self.path.to_owned(), format, offset: offset as u64, what: what.to_string() }
    }

    fn unsupported(&self, what: impl fmt::Display, help: impl fmt::Display) -> VolumeError {
        VolumeError::Unsupported { path: self.path.to_owned(), what: what.to_string(), help: help.to_string() }
    }

    /// Checks the number of samples against the limit; bytes of all.
    fn length_of(&self, shape: [u32; 3], sample: SampleType) -> Result<u64, VolumeError> {
        let count: u128 = shape.iter().map(|n| u128::from(*n)).product();
        if count > u128::from(self.limits.voxels) {
            let [a, b, c] = shape;
            let what = format!("{a} x {b} x {c} voxels; the limit is {}", self.limits.voxels);
            return Err(VolumeError::TooLarge { path: self.path.to_owned(), what });
        }
        Ok(count as u64 * sample.bytes() as u64)
    }

    /// The samples in the order of a grid, x fastest.
    fn voxels(&self, array: &Array, axes: Axes, size: [u32; 3]) -> Result<Voxels, VolumeError> {
        let swap = array.byte_order == ByteOrder::Big;
        Ok(match array.sample {
            SampleType::U8 if array.boolean => {
                Voxels::U8(self.gather(array, axes, size, |[b]| u8::from(b != 0) * 255)?)
            }
            SampleType::U8 => Voxels::U8(self.gather(array, axes, size, |[b]| b)?),
            SampleType::U16 => Voxels::U16(self.gather(array, axes, size, |b| order(b, swap, u16::from_le_bytes))?),
            SampleType::F16 => Voxels::F16(self.gather(array, axes, size, |b| order(b, swap, u16::from_le_bytes))?),
            SampleType::F32 => Voxels::F32(self.gather(array, axes, size, |b| order(b, swap, f32::from_le_bytes))?),
            SampleType::F64 => {
                Voxels::F32(self.gather(array, axes, size, |b| order(b, swap, f64::from_le_bytes) as f32)?)
            }
        })
    }

    fn gather<T, const N: usize>(
        &self,
        array: &Array,
        axes: Axes,
        size: [u32; 3],
        sample: impl Fn([u8; N]) -> T,
    ) -> Result<Vec<T>, VolumeError> {
        let [nx, ny, nz] = size.map(|n| n as usize);
        let mut values = Vec::new();
        if values.try_reserve_exact(nx * ny * nz).is_err() {
            let what = format!("not enough memory for {nx} x {ny} x {nz} voxels");
            return Err(VolumeError::TooLarge { path: self.path.to_owned(), what });
        }
        let strides = strides(array, axes);
        let (samples, _) = array.bytes.as_chunks::<N>();
        for z in 0..nz {
            for y in 0..ny {
                let row = z * strides[2] + y * strides[1];
                values.extend((0..nx).map(|x| sample(samples[row + x * strides[0]])));
            }
        }
        Ok(values)
    }
}

/// Samples from one voxel to the next along x, y and z.
fn strides(array: &Array, axes: Axes) -> [usize; 3] {
    let mut strides = [0; 3];
    let mut step = 1;
    for place in 0..3 {
        let index = if array.fortran { place } else { 2 - place };
        strides[usize::from(axes.0[index])] = step;
        step *= array.shape[index] as usize;
    }
    strides
}

fn order<T, const N: usize>(mut bytes: [u8; N], swap: bool, from: impl Fn([u8; N]) -> T) -> T {
    if swap {
        bytes.reverse();
    }
    from(bytes)
}

fn raw<'a>(file: &File<'a>, layout: &RawLayout, axes: Axes) -> Result<Array<'a>, VolumeError> {
    let RawLayout { size, sample, byte_order } = *layout;
    let expected = file.length_of(size, sample)?;
    let found = file.bytes.len() as u64;
    if found != expected {
        let [x, y, z] = size;
        let what =
            format!("the file has {found} bytes, not the {expected} of {x} x {y} x {z} samples of {}", sample.name());
        return Err(file.unsupported(what, "give the `size` and `sample` that the file was written with"));
    }
    let shape = axes.0.map(|axis| size[usize::from(axis)]);
    Ok(Array { shape, sample, byte_order, boolean: false, fortran: false, bytes: file.bytes })
}
