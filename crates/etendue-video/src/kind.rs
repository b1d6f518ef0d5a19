use std::fmt;

/// A format of films.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Kind {
    /// H.264 in MP4: small, with losses; browsers and players show it. Needs the feature `h264`.
    Mp4,
    /// GIF: 256 colours a frame, at most 50 frames a second; loops for ever.
    Gif,
    /// Animated PNG: lossless and large; loops for ever.
    Apng,
    /// YUV4MPEG2: uncompressed 4:2:0, for a pipe to another encoder.
    Y4m,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Mp4, Self::Gif, Self::Apng, Self::Y4m];

    /// By the extension of a file name, without the dot, in any case: `mp4`, `m4v`, `gif`, `apng`, `png`, `y4m`.
    pub fn from_extension(extension: &str) -> Option<Self> {
        match extension.to_ascii_lowercase().as_str() {
            "mp4" | "m4v" => Some(Self::Mp4),
            "gif" => Some(Self::Gif),
            "apng" | "png" => Some(Self::Apng),
            "y4m" => Some(Self::Y4m),
            _ => None,
        }
    }

    /// Whether this program was built with it.
    pub const fn is_available(self) -> bool {
        match self {
            Self::Mp4 => cfg!(feature = "h264"),
            Self::Gif | Self::Apng | Self::Y4m => true,
        }
    }

    /// Whether it is written from start to end, as to a pipe.
    pub const fn streams(self) -> bool {
        !matches!(self, Self::Mp4)
    }

    /// Its usual extension, without the dot.
    pub const fn extension(self) -> &'static str {
        match self {
            Self::Mp4 => "mp4",
            Self::Gif => "gif",
            Self::Apng => "apng",
            Self::Y4m => "y4m",
        }
    }

    /// The largest width and height, and whether the two may be swapped.
    pub(crate) const fn limits(self) -> ([u32; 2], bool) {
        match self {
            // Level 5.2 of H.264, as far as the encoder goes.
            Self::Mp4 => ([3840, 2160], true),
            Self::Gif => ([65_535, 65_535], false),
            Self::Apng | Self::Y4m => ([1 << 20, 1 << 20], false),
        }
    }
}

impl fmt::Display for Kind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Mp4 => "MP4",
            Self::Gif => "GIF",
            Self::Apng => "animated PNG",
            Self::Y4m => "Y4M",
        })
    }
}
