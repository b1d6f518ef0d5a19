//! Pictures and labels out: PNG, OpenEXR, Radiance HDR, PFM and NPY files, written whole or not at all, and what is computed on
//! them.

pub mod atomic;
pub mod exr;
pub mod flip;
pub mod hash;
pub mod hdr;
pub mod heat;
pub mod labels;
pub mod metric;
pub mod npy;
pub mod pfm;
pub mod png;

pub use atomic::WriteError;

use etendue::{image::Image, tonemap::Encoding};
use std::{fmt, path::Path};

/// The picture formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Format {
    /// 8 bits after exposure, balance and tone curve; `R G B`, and `A` where there is one.
    Png,
    /// Linear 32 bit floats and ids, every channel, with metadata.
    Exr,
    /// Radiance RGBE: linear, 8 bits and a shared exponent, `R G B` only.
    Hdr,
    /// Linear 32 bit floats, `R G B` only, no metadata.
    Pfm,
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 4] = [Self::Png, Self::Exr, Self::Hdr, Self::Pfm];

    /// The ending of its files, without the dot.
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Png => "png",
            Self::Exr => "exr",
            Self::Hdr => "hdr",
            Self::Pfm => "pfm",
        }
    }

    /// The format that the ending of `path` names; upper and lower case count the same.
    pub fn of_path(path: &Path) -> Result<Self, UnknownEnding> {
        let ending = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
        Self::ALL
            .into_iter()
            .find(|f| ending.as_deref() == Some(f.ending()))
            .ok_or_else(|| UnknownEnding { path: path.display().to_string() })
    }
}

/// A file name whose ending is no picture format.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{path}`: the ending names no picture format that can be written (known: {})", Endings)]
pub struct UnknownEnding {
    /// The name as given.
    pub path: String,
}

struct Endings;

impl fmt::Display for Endings {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (i, format) in Format::ALL.iter().enumerate() {
            write!(f, "{}.{}", if i == 0 { "" } else { ", " }, format.ending())?;
        }
        Ok(())
    }
}

/// Where a cropped picture lies in the whole.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Top left pixel of the crop, x to the right, y down.
    pub origin: [u32; 2],
    /// Pixels of the whole picture.
    pub whole: [u32; 2],
}

/// What a file says about how its picture was made.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Metadata {
    /// Name and version of the program, `Etendue 0.1.0`.
    pub software: String,
    /// Further entries, in order: name (letters and digits) and text.
    pub entries: Vec<(String, String)>,
    /// How files of 8 bits are encoded, which they say.
    pub encoding: Encoding,
    /// Set if the picture is a crop.
    pub window: Option<Window>,
}

impl Metadata {
    /// Adds an entry.
    pub fn with(mut self, name: &str, text: impl fmt::Display) -> Self {
        self.entries.push((name.to_owned(), text.to_string()));
        self
    }

    /// The text of the first entry with this name.
    pub fn get(&self, name: &str) -> Option<&str> {
        self.entries.iter().find_map(|(n, text)| (n == name).then_some(&text[..]))
    }
}

/// Linear `R G B` to the three bytes of a pixel, see [`DisplayTransform`](etendue::tonemap::DisplayTransform); in the
/// encoding that [`Metadata::encoding`] states.
pub type Encode<'a> = &'a (dyn Fn([f32; 3]) -> [u8; 3] + Sync);

/// Writes `image` to `path` in `format`, whole or not at all (see [`atomic::write`]). `encode` is used by 8 bit formats.
pub fn write_image(
    path: &Path,
    format: Format,
    image: &Image,
    metadata: &Metadata,
    encode: Encode<'_>,
) -> Result<(), WriteError> {
    atomic::write(path, |file| match format {
        Format::Png => png::write(file, image, metadata, encode),
        Format::Exr => exr::write(file, image, metadata),
        Format::Hdr => hdr::write(file, image, metadata),
        Format::Pfm => pfm::write(file, image),
    })
}

/// The three colour channels of a picture.
fn color_channels(image: &Image) -> Result<[&[f32]; 3], EncodeError> {
    let channel = |name| image.f32_channel(name).ok_or(EncodeError::NoColor);
    Ok([channel("R")?, channel("G")?, channel("B")?])
}

/// Why a picture cannot be encoded.
#[derive(Debug, thiserror::Error)]
pub enum EncodeError {
    /// The format holds colour alone and the picture has none.
    #[error("the picture has no channels R, G, B")]
    NoColor,
    /// A channel does not hold width x height samples, or there are no pixels or no channels.
    #[error("the picture is malformed: {0}")]
    Malformed(String),
    /// The file system refused.
    #[error(transparent)]
    Io(#[from] std::io::Error),
}

/// Checks that every channel has a sample for each of at least one pixel.
fn check_shape(image: &Image) -> Result<(), EncodeError> {
    let pixels = u64::from(image.width) * u64::from(image.height);
    if pixels == 0 || image.channels.is_empty() {
        return Err(EncodeError::Malformed(format!(
            "{}x{} pixels, {} channels",
            image.width,
            image.height,
            image.channels.len()
        )));
    }
    for channel in &image.channels {
        let samples = match &channel.data {
            etendue::image::ChannelData::F32(data) => data.len(),
            etendue::image::ChannelData::U32(data) => data.len(),
        };
        if samples as u64 != pixels {
            return Err(EncodeError::Malformed(format!(
                "channel {} has {samples} samples for {pixels} pixels",
                channel.name
            )));
        }
    }
    Ok(())
}
