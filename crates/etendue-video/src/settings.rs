use crate::{FrameRate, Kind, VideoError};

/// The most frames of a film: four days at 25 a second.
pub const MAX_FRAMES: u64 = 10_000_000;

/// What an encoder must know before the first frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Settings {
    /// Width and height, in pixels.
    pub size: [u32; 2],
    /// Frames a second.
    pub rate: FrameRate,
    /// How many frames will come; more or fewer is an error.
    pub frames: u64,
    /// From 0 (small) to 100 (good). MP4 alone looks at it: the quantisation parameter goes from 51 to 12. 75 hides the
    /// losses from most eyes.
    pub quality: u8,
}

impl Settings {
    /// Finds out whether a film of `kind` can be made with these settings, before anything is rendered for it.
    pub fn check(&self, kind: Kind) -> Result<(), VideoError> {
        if !kind.is_available() {
            return Err(VideoError::LeftOut { kind });
        }
        self.check_size(kind)?;
        if self.frames == 0 {
            return Err(VideoError::NoFrames);
        }
        if self.frames > MAX_FRAMES {
            return Err(VideoError::TooManyFrames { frames: self.frames });
        }
        if self.quality > 100 {
            return Err(VideoError::BadQuality { quality: self.quality });
        }
        self.check_rate(kind)
    }

    fn check_size(&self, kind: Kind) -> Result<(), VideoError> {
        let size = self.size;
        if size.contains(&0) {
            return Err(VideoError::NoPixels { size });
        }
        let (most, upright) = kind.limits();
        let fits = |[w, h]: [u32; 2]| w <= most[0] && h <= most[1];
        // The bytes of a frame are counted in i32 by more than one library.
        let bytes = u128::from(size[0]) * u128::from(size[1]) * 3;
        if (fits(size) || (upright && fits([size[1], size[0]]))) && bytes <= i32::MAX as u128 {
            Ok(())
        } else {
            Err(VideoError::TooLarge { kind, size, most, upright })
        }
    }

    fn check_rate(&self, kind: Kind) -> Result<(), VideoError> {
        let rate = self.rate;
        let (frames, seconds) = (u64::from(rate.frames()), u64::from(rate.seconds()));
        match kind {
            // Browsers show a frame of 0.01 s for 0.1 s.
            Kind::Gif if frames > 50 * seconds => Err(VideoError::TooFast { kind, rate, most: 50 }),
            // Delays are 16 bits of 0.01 s.
            Kind::Gif if seconds > 655 * frames => Err(VideoError::TooSlow { kind, rate, most: 655 }),
            Kind::Apng if seconds > 65_535 * frames => Err(VideoError::TooSlow { kind, rate, most: 65_535 }),
            _ => Ok(()),
        }
    }

    /// Bytes of a frame.
    pub(crate) fn frame_bytes(&self) -> usize {
        self.size[0] as usize * self.size[1] as usize * 3
    }
}
