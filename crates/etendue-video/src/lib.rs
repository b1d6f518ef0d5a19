//! Films from frames: 8-bit sRGB pictures in, MP4 (H.264), GIF, animated PNG or Y4M out.
//!
//! Frames are encoded as they come and leave at once for the writer, so that an hour needs no more memory than a second
//! (MP4 keeps 4 bytes a frame). The bytes are a function of frames and [`Settings`] alone: no clock, no threads, no
//! random numbers.
//!
//! ```
//! use etendue_video::{Encoder, FrameRate, Kind, Settings};
//! # fn main() -> Result<(), etendue_video::VideoError> {
//! let settings = Settings { size: [4, 2], rate: FrameRate::new(25, 1)?, frames: 3, quality: 75 };
//! let mut film = std::io::Cursor::new(Vec::new());
//! let mut encoder = Encoder::new(&mut film, Kind::Gif, settings)?;
//! for grey in [0, 128, 255] {
//!     encoder.push_rgb8(&[grey; 4 * 2 * 3])?;
//! }
//! encoder.finish()?;
//! assert_eq!(&film.get_ref()[..6], b"GIF89a");
//! # Ok(())
//! # }
//! ```

#![forbid(unsafe_code)]

mod apng;
mod dither;
mod encoder;
mod error;
mod gif_film;
#[cfg(feature = "h264")]
mod h264;
mod kind;
#[cfg(feature = "h264")]
mod mp4;
mod note;
mod palette;
mod rate;
mod settings;
#[cfg(feature = "h264")]
mod sps;
mod y4m;
mod ycbcr;

pub use encoder::Encoder;
pub use error::VideoError;
pub use kind::Kind;
pub use rate::FrameRate;
pub use settings::{MAX_FRAMES, Settings};
