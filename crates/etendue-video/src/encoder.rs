use crate::{Kind, Settings, VideoError, apng::Apng, gif_film::GifFilm, y4m::Y4m};
use std::io::{Seek, Write};

#[cfg(feature = "h264")]
use crate::mp4::Mp4;

/// What every format does with frames of the right length and number.
pub(crate) trait Format {
    /// Takes the next frame.
    fn push(&mut self, rgb: &[u8]) -> Result<(), VideoError>;
    /// Writes what is left, with a note if the format keeps any, and flushes.
    fn finish(self, note: Option<&str>) -> Result<(), VideoError>;
}

enum Film<'w> {
    #[cfg(feature = "h264")]
    Mp4(Box<Mp4<'w>>),
    Gif(Box<GifFilm<'w>>),
    Apng(Box<Apng<'w>>),
    Y4m(Box<Y4m<'w>>),
}

macro_rules! dispatch {
    ($film:expr, $inner:ident => $call:expr) => {
        match $film {
            #[cfg(feature = "h264")]
            Film::Mp4($inner) => $call,
            Film::Gif($inner) => $call,
            Film::Apng($inner) => $call,
            Film::Y4m($inner) => $call,
        }
    };
}

/// Writes one film.
///
/// A file that was given up before [`finish`](Self::finish) is no film: write aside and rename.
pub struct Encoder<'w> {
    film: Film<'w>,
    settings: Settings,
    pushed: u64,
}

impl<'w> Encoder<'w> {
    /// A film of any kind, from where the writer stands. The writer should be buffered.
    ///
    /// # Errors
    ///
    /// What [`Settings::check`] finds, and what the writer says.
    pub fn new(writer: impl Write + Seek + 'w, kind: Kind, settings: Settings) -> Result<Self, VideoError> {
        settings.check(kind)?;
        match kind {
            #[cfg(feature = "h264")]
            Kind::Mp4 => {
                let film = Film::Mp4(Box::new(Mp4::new(Box::new(writer), settings)?));
                Ok(Self { film, settings, pushed: 0 })
            }
            _ => Self::stream(writer, kind, settings),
        }
    }

    /// A film into a pipe: any kind that [streams](Kind::streams).
    ///
    /// # Errors
    ///
    /// As [`new`](Self::new), and [`VideoError::NeedsSeek`].
    pub fn stream(writer: impl Write + 'w, kind: Kind, settings: Settings) -> Result<Self, VideoError> {
        settings.check(kind)?;
        let film = match kind {
            Kind::Mp4 => return Err(VideoError::NeedsSeek { kind }),
            Kind::Gif => Film::Gif(Box::new(GifFilm::new(Box::new(writer), settings)?)),
            Kind::Apng => Film::Apng(Box::new(Apng::new(Box::new(writer), settings)?)),
            Kind::Y4m => Film::Y4m(Box::new(Y4m::new(Box::new(writer), settings)?)),
        };
        Ok(Self { film, settings, pushed: 0 })
    }

    /// Adds a frame: width x height x 3 bytes of sRGB, rows from the top.
    ///
    /// # Errors
    ///
    /// [`VideoError::FrameLength`], [`VideoError::FrameCount`], and what the writer says; after the latter the film is lost.
    pub fn push_rgb8(&mut self, rgb: &[u8]) -> Result<(), VideoError> {
        let expected = self.settings.frame_bytes();
        if rgb.len() != expected {
            return Err(VideoError::FrameLength { frame: self.pushed, got: rgb.len(), expected });
        }
        if self.pushed == self.settings.frames {
            return Err(VideoError::FrameCount { got: self.pushed + 1, expected: self.settings.frames });
        }
        dispatch!(&mut self.film, film => film.push(rgb))?;
        self.pushed += 1;
        Ok(())
    }

    /// Completes the film and flushes the writer.
    ///
    /// # Errors
    ///
    /// [`VideoError::FrameCount`] if frames are missing, and what the writer says.
    pub fn finish(self) -> Result<(), VideoError> {
        self.end(None)
    }

    /// As [`finish`](Self::finish), with a note for programs, ASCII without control characters, which [`Kind::note`] reads again. Formats that
    /// do not [keep notes](Kind::keeps_note) leave it out.
    ///
    /// # Errors
    ///
    /// As [`finish`](Self::finish).
    pub fn finish_with(self, note: &str) -> Result<(), VideoError> {
        self.end(Some(note))
    }

    fn end(self, note: Option<&str>) -> Result<(), VideoError> {
        if self.pushed != self.settings.frames {
            return Err(VideoError::FrameCount { got: self.pushed, expected: self.settings.frames });
        }
        dispatch!(self.film, film => film.finish(note))
    }
}
