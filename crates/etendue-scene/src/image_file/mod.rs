//! Reading pictures of every known format under limits that are checked before memory is taken.
//!
//! | format | what is read |
//! |---|---|
//! | PNG | 1 to 16 bit, grey, colour, palette, with and without alpha, interlaced; of an animation the first frame |
//! | JPEG | baseline and progressive; grey, colour, CMYK and YCCK, which become RGB as simply as browsers do |
//! | Radiance HDR | RGBE, with either run-length coding or none, in all eight orientations |
//! | OpenEXR | see [`exr`]: half, float and whole numbers; none, RLE, ZIP, PIZ, PXR24, B44, DWA; scan lines and tiles |
//! | PFM | grey and colour, both endiannesses |
//! | TGA, BMP, WebP | what the `image` crate reads |
//!
//! A format is told by the first bytes, whatever the ending; TGA, which has no mark of its own, by the ending.

pub mod entries;
pub mod exr;
mod hdr;
mod jpeg;
mod library;
mod pfm;
mod png;
mod raw;
pub(crate) mod srgb;

pub use raw::{RawImage, Samples};

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
    /// Most bytes of decoded samples, at four bytes each.
    pub decoded: u64,
    /// Most bytes for rows in flight, texts and colour profiles.
    pub texts: usize,
}

impl Default for Limits {
    fn default() -> Self {
        Self { file: 4 << 30, decoded: 4 << 30, texts: 64 << 20 }
    }
}

/// Decoded bytes that any file may make, however small.
const FREE: u64 = 64 << 20;
/// Beyond [`FREE`], most decoded bytes (four a sample) of one byte of a file. Deflate makes at most 1032 bytes of one.
const MOST_GROWTH: u64 = 4096;

impl Limits {
    /// Refuses pictures whose samples, four bytes each in `channels` channels, would exceed the limit, or are more than the
    /// bytes of the file could mean.
    fn check_pixels(&self, file: File<'_>, width: u64, height: u64, channels: u64) -> Result<(), ReadError> {
        let path = file.path;
        let decoded = width.checked_mul(height).and_then(|p| p.checked_mul(channels)).and_then(|s| s.checked_mul(4));
        let decoded = decoded.filter(|&bytes| bytes <= self.decoded).ok_or_else(|| {
            let size = format!("{width}x{height} pixels in {channels} channels");
            ReadError::too_large(path, format!("{size}; the limit is {} bytes", self.decoded))
        })?;
        if decoded > FREE.max((file.bytes.len() as u64).saturating_mul(MOST_GROWTH)) {
            let what = format!("{width}x{height} pixels cannot be in so small a file");
            return Err(ReadError::Damaged { path: path.to_owned(), format: file.kind.name(), what });
        }
        Ok(())
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
    #[error("`{}` is no PNG, JPEG, HDR, OpenEXR, PFM, TGA, BMP or WebP file", path.display())]
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
    fn too_large(path: &Path, what: impl Into<String>) -> Self {
        Self::TooLarge { path: path.to_owned(), what: what.into() }
    }
}

/// Formats that are read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Png,
    Jpeg,
    Hdr,
    Exr,
    Pfm,
    Tga,
    Bmp,
    WebP,
}

impl Kind {
    /// Told from the first bytes, then from the ending.
    fn of(path: &Path, bytes: &[u8]) -> Option<Self> {
        let begins = |mark: &[u8]| bytes.starts_with(mark);
        Some(match () {
            () if begins(b"\x89PNG\r\n\x1a\n") => Self::Png,
            () if begins(b"\xff\xd8\xff") => Self::Jpeg,
            () if begins(b"#?RADIANCE") || begins(b"#?RGBE") => Self::Hdr,
            () if begins(&[0x76, 0x2f, 0x31, 0x01]) => Self::Exr,
            () if begins(b"RIFF") && bytes.get(8..12) == Some(b"WEBP") => Self::WebP,
            () => {
                let ending = path.extension().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
                let tga = matches!(&ending[..], "tga" | "vda" | "icb" | "vst");
                // Two letters are few: a TGA file may begin with them.
                match bytes {
                    [b'P', b'F' | b'f', ..] if !tga => Self::Pfm,
                    [b'B', b'M', ..] if !tga => Self::Bmp,
                    [b'#', b'?', ..] if ending == "hdr" => Self::Hdr,
                    _ if tga => Self::Tga,
                    _ => return None,
                }
            }
        })
    }

    fn name(self) -> &'static str {
        match self {
            Self::Png => "PNG",
            Self::Jpeg => "JPEG",
            Self::Hdr => "HDR",
            Self::Exr => "OpenEXR",
            Self::Pfm => "PFM",
            Self::Tga => "TGA",
            Self::Bmp => "BMP",
            Self::WebP => "WebP",
        }
    }
}

/// A file in memory.
#[derive(Clone, Copy)]
struct File<'a> {
    path: &'a Path,
    kind: Kind,
    bytes: &'a [u8],
}

impl File<'_> {
    fn damaged(&self, what: impl ToString) -> ReadError {
        ReadError::Damaged { path: self.path.to_owned(), format: self.kind.name(), what: what.to_string() }
    }
}

/// Reads a picture as linear floats (and ids): 8 and 16 bit pictures are decoded. Channels: `R G B A` first where they are,
/// then the others by name; a grey picture has three equal ones, alpha is premultiplied (colour that is covered by nothing
/// is 0).
pub fn read_image(path: &Path, limits: &Limits) -> Result<Image, ReadError> {
    read_image_and_range(path, limits).map(|(image, _)| image)
}

/// What values a picture's format can hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Range {
    /// Integers for what a display shows, from 0 to 1.
    Display,
    /// Floats: light of any strength.
    Any,
}

/// [`read_image`], and what the format can hold.
pub fn read_image_and_range(path: &Path, limits: &Limits) -> Result<(Image, Range), ReadError> {
    let bytes = read_bounded(path, limits.file)?;
    let range = match recognise(path, &bytes)?.kind {
        Kind::Hdr | Kind::Exr | Kind::Pfm => Range::Any,
        Kind::Png | Kind::Jpeg | Kind::Tga | Kind::Bmp | Kind::WebP => Range::Display,
    };
    Ok((decode_image(path, &bytes, limits)?, range))
}

/// [`read_image`] of bytes in memory; `path` gives the ending, and its name in errors.
pub fn decode_image(path: &Path, bytes: &[u8], limits: &Limits) -> Result<Image, ReadError> {
    let file = recognise(path, bytes)?;
    match file.kind {
        Kind::Exr => exr::read(path, bytes, limits).map(|(image, _)| image),
        _ => Ok(decode_raw(file, limits)?.into_image()),
    }
}

/// Reads a picture for use as a texture: its samples as they are stored, in 1 (grey), 2 (grey, alpha), 3 (R, G, B) or 4
/// (R, G, B, alpha) channels; alpha is straight (colours are not multiplied by it).
pub fn read_texture(path: &Path, limits: &Limits) -> Result<RawImage, ReadError> {
    decode_texture(path, &read_bounded(path, limits.file)?, limits)
}

/// [`read_texture`] of bytes in memory; `path` gives the ending, and its name in errors.
pub fn decode_texture(path: &Path, bytes: &[u8], limits: &Limits) -> Result<RawImage, ReadError> {
    decode_raw(recognise(path, bytes)?, limits)
}

/// What the format of a picture is called, by its first bytes and its ending; `None` if it is none that is read.
pub fn format_name(path: &Path, bytes: &[u8]) -> Option<&'static str> {
    Kind::of(path, bytes).map(Kind::name)
}

fn recognise<'a>(path: &'a Path, bytes: &'a [u8]) -> Result<File<'a>, ReadError> {
    let kind = Kind::of(path, bytes).ok_or_else(|| ReadError::UnknownFormat { path: path.to_owned() })?;
    Ok(File { path, kind, bytes })
}

fn decode_raw(file: File<'_>, limits: &Limits) -> Result<RawImage, ReadError> {
    match file.kind {
        Kind::Png => png::read(file, limits),
        Kind::Jpeg => jpeg::read(file, limits),
        Kind::Hdr => hdr::read(file, limits),
        Kind::Pfm => pfm::read(file, limits),
        Kind::Tga | Kind::Bmp | Kind::WebP => library::read(file, limits),
        Kind::Exr => {
            let (image, _) = exr::read(file.path, file.bytes, limits)?;
            RawImage::of_image(&image).ok_or_else(|| file.damaged("it has no channels R, G, B, nor Y"))
        }
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
