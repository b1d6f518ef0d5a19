//! Reading pictures of any known format under limits that are checked before memory is taken.

use super::{exr, pfm, png};
use etendue::image::Image;
use std::{
    fs,
    io::{self, Read},
    path::{Path, PathBuf},
};

/// What reading a picture may cost.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Limits {
    /// Largest file, bytes.
    pub file: u64,
    /// Most bytes of decoded samples.
    pub decoded: u64,
    /// Most bytes for rows in flight, texts and colour profiles.
    pub texts: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { file: 4 << 30, decoded: 4 << 30, texts: 64 << 20 }
    }
}

impl Limits {
    /// Refuses pictures whose samples, four bytes each in `channels` channels, would exceed the limit.
    pub(super) fn check_pixels(&self, path: &Path, width: u64, height: u64, channels: u64) -> Result<(), ReadError> {
        let bytes = width.checked_mul(height).and_then(|p| p.checked_mul(channels)).and_then(|s| s.checked_mul(4));
        match bytes {
            Some(bytes) if bytes <= self.decoded => Ok(()),
            _ => {
                let what =
                    format!("{width}x{height} pixels in {channels} channels; the limit is {} bytes", self.decoded);
                Err(ReadError::TooLarge { path: path.to_owned(), what })
            }
        }
    }
}

/// Why a picture could not be read. Every variant names the path as it was given.
#[derive(Debug, thiserror::Error)]
pub enum ReadError {
    /// The file system refused.
    #[error("cannot read `{}`: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: io::Error,
    },
    /// The first bytes are of no picture format that can be read.
    #[error("`{}` is no PNG, OpenEXR or PFM file", path.display())]
    UnknownFormat {
        /// The file.
        path: PathBuf,
    },
    /// The file is or declares more than the limits allow.
    #[error("`{}` is too large: {what}", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What is too large.
        what: String,
    },
    /// The content contradicts its format.
    #[error("`{}` is a damaged or unsupported {format} file: {what}", path.display())]
    Damaged {
        /// The file.
        path: PathBuf,
        /// Name of the format.
        format: &'static str,
        /// What is wrong.
        what: String,
    },
}

impl ReadError {
    pub(super) fn damaged(path: &Path, format: &'static str, what: impl Into<String>) -> Self {
        Self::Damaged { path: path.to_owned(), format, what: what.into() }
    }

    pub(super) fn too_large(path: &Path, what: impl Into<String>) -> Self {
        Self::TooLarge { path: path.to_owned(), what: what.into() }
    }
}

/// Reads a PNG (decoded to linear), OpenEXR or PFM file; the format is told from the first bytes, whatever the ending.
/// Channels: `R G B A` first where they are, then the others by name.
pub fn read_image(path: &Path, limits: &Limits) -> Result<Image, ReadError> {
    let bytes = read_bounded(path, limits.file)?;
    if bytes.starts_with(b"\x89PNG\r\n\x1a\n") {
        png::read(path, &bytes, limits)
    } else if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
        exr::read(path, &bytes, limits).map(|(image, _)| image)
    } else if bytes.starts_with(b"PF") || bytes.starts_with(b"Pf") {
        pfm::read(path, &bytes, limits)
    } else {
        Err(ReadError::UnknownFormat { path: path.to_owned() })
    }
}

/// The bytes of a file of at most `limit` bytes. Pipes are read up to the limit too, so the declared length is not
/// trusted.
fn read_bounded(path: &Path, limit: u64) -> Result<Vec<u8>, ReadError> {
    let io = |source| ReadError::Io { path: path.to_owned(), source };
    let file = fs::File::open(path).map_err(io)?;
    let length = file.metadata().map_err(io)?.len();
    let too_large = || ReadError::too_large(path, format!("the file exceeds {limit} bytes"));
    if length > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize).map_err(|_| too_large())?;
    file.take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(io)?;
    if bytes.len() as u64 > limit { Err(too_large()) } else { Ok(bytes) }
}
