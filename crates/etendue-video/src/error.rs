use crate::{FrameRate, Kind, MAX_FRAMES};
use std::io;

/// Why a film could not be made.
#[derive(Debug, thiserror::Error)]
pub enum VideoError {
    /// The writer refused.
    #[error("{0}")]
    Io(#[from] io::Error),
    /// A side of the picture is zero.
    #[error("a film needs frames of at least 1 x 1 pixels, not {} x {}", size[0], size[1])]
    NoPixels {
        /// Width and height.
        size: [u32; 2],
    },
    /// The format cannot hold so large a picture.
    #[error(
        "{kind} holds frames of at most {} x {} pixels{}, not {} x {}", most[0], most[1],
        if *.upright { ", or these turned upright" } else { "" }, size[0], size[1]
    )]
    TooLarge {
        /// The format.
        kind: Kind,
        /// Width and height.
        size: [u32; 2],
        /// Its limits.
        most: [u32; 2],
        /// Whether the limits may be swapped.
        upright: bool,
    },
    /// No frame was announced.
    #[error("a film needs at least one frame")]
    NoFrames,
    /// More frames than [`MAX_FRAMES`].
    #[error("a film has at most {MAX_FRAMES} frames, not {frames}")]
    TooManyFrames {
        /// How many were announced.
        frames: u64,
    },
    /// Not a positive number or fraction, or one that does not fit.
    #[error(
        "`{given}` is no frame rate: a positive number such as `25` or `29.97`, or a fraction such as `30000/1001`"
    )]
    BadRate {
        /// What was given.
        given: String,
    },
    /// The format cannot show frames so fast.
    #[error("{kind} shows at most {most} frames a second, not {rate}")]
    TooFast {
        /// The format.
        kind: Kind,
        /// The rate asked for.
        rate: FrameRate,
        /// The most it can do.
        most: u32,
    },
    /// The format cannot show a frame for so long.
    #[error("{kind} shows a frame for at most {most} s: {rate} frames a second are too few")]
    TooSlow {
        /// The format.
        kind: Kind,
        /// The rate asked for.
        rate: FrameRate,
        /// The longest time of a frame, in seconds.
        most: u32,
    },
    /// The quality is above 100.
    #[error("quality goes from 0 to 100, not {quality}")]
    BadQuality {
        /// What was asked for.
        quality: u8,
    },
    /// A frame has not as many bytes as its pixels need.
    #[error("frame {frame} has {got} bytes where {expected} are needed")]
    FrameLength {
        /// The frame, from 0.
        frame: u64,
        /// Bytes given.
        got: usize,
        /// Bytes needed: width x height x 3.
        expected: usize,
    },
    /// More or fewer frames than announced.
    #[error("the film was to have {expected} frames and got {got}")]
    FrameCount {
        /// Frames pushed.
        got: u64,
        /// Frames announced.
        expected: u64,
    },
    /// This program was built without the encoder.
    #[error("{kind} was left out of this program: it was built without the feature `h264`, which needs a C++ compiler")]
    LeftOut {
        /// The format.
        kind: Kind,
    },
    /// The format goes back to its start at the end, which a pipe cannot do.
    #[error("{kind} cannot be written to a pipe; Y4M can")]
    NeedsSeek {
        /// The format.
        kind: Kind,
    },
    /// A library failed in a way that no input should lead to.
    #[error("the encoder of {kind} failed: {reason}")]
    Codec {
        /// The format.
        kind: Kind,
        /// What it said.
        reason: String,
    },
}

impl VideoError {
    pub(crate) fn codec(kind: Kind, reason: impl std::fmt::Display) -> Self {
        Self::Codec { kind, reason: reason.to_string() }
    }
}
