//! GIF (GIF89a): a palette for each frame, kept while it serves, and only the rectangle that changed.

use crate::{
    FrameRate, Kind, Settings, VideoError,
    dither::Dither,
    encoder::Format,
    palette::{Histogram, Palette},
};
use std::{borrow::Cow, io::Write};

/// Ticks a second.
const TICKS: u32 = 100;
/// A palette is kept while its mean squared error is at most this much that of a new one, and this: a new palette makes
/// what stands still flicker.
const KEPT_FACTOR: f64 = 1.5;
const KEPT_SQUARE: f64 = 3.0;

pub(crate) struct GifFilm<'w> {
    /// Until the first frame brings the palette of the whole.
    waiting: Option<Box<dyn Write + 'w>>,
    encoder: Option<gif::Encoder<Box<dyn Write + 'w>>>,
    size: [u16; 2],
    rate: FrameRate,
    pushed: u64,
    /// The first frame's, which others may refer to.
    first: Palette,
    dither: Dither,
    /// What is shown: indices and their palette.
    shown: Vec<u8>,
    shown_palette: Palette,
    indices: Vec<u8>,
}

impl<'w> GifFilm<'w> {
    pub fn new(writer: Box<dyn Write + 'w>, settings: Settings) -> Result<Self, VideoError> {
        Ok(Self {
            waiting: Some(writer),
            encoder: None,
            size: settings.size.map(|n| n as u16),
            rate: settings.rate,
            pushed: 0,
            first: Vec::new(),
            dither: Dither::new(Vec::new()),
            shown: Vec::new(),
            shown_palette: Vec::new(),
            indices: Vec::new(),
        })
    }

    fn choose_palette(&mut self, rgb: &[u8]) {
        let histogram = Histogram::new(rgb);
        let fresh = histogram.palette();
        let serves = || {
            let bound = (histogram.error(&fresh) * KEPT_FACTOR).max(KEPT_SQUARE);
            histogram.error(self.dither.palette()) <= bound
        };
        if self.pushed == 0 || !serves() {
            self.dither = Dither::new(fresh);
        }
    }

    /// The smallest rectangle outside of which nothing changed: left, top, right, bottom. A frame that changes nothing
    /// keeps one pixel.
    fn changed(&self) -> [usize; 4] {
        let [width, height] = self.size.map(usize::from);
        if self.pushed == 0 {
            return [0, 0, width, height];
        }
        let mut changed = [width, height, 0, 0];
        let new = self.dither.palette();
        for (y, (old_row, new_row)) in self.shown.chunks_exact(width).zip(self.indices.chunks_exact(width)).enumerate()
        {
            for (x, (&a, &b)) in old_row.iter().zip(new_row).enumerate() {
                if self.shown_palette[usize::from(a)] != new[usize::from(b)] {
                    let [left, top, right, bottom] = changed;
                    changed = [left.min(x), top.min(y), right.max(x + 1), bottom.max(y + 1)];
                }
            }
        }
        if changed[2] == 0 { [0, 0, 1, 1] } else { changed }
    }
}

fn from_gif(error: gif::EncodingError) -> VideoError {
    match error {
        gif::EncodingError::Io(error) => VideoError::Io(error),
        error => VideoError::codec(Kind::Gif, error),
    }
}

impl Format for GifFilm<'_> {
    fn push(&mut self, rgb: &[u8]) -> Result<(), VideoError> {
        let [width, height] = self.size;
        self.choose_palette(rgb);
        self.dither.indices(rgb, usize::from(width), &mut self.indices);
        if let Some(writer) = self.waiting.take() {
            self.first = self.dither.palette().clone();
            let mut encoder = gif::Encoder::new(writer, width, height, self.first.as_flattened()).map_err(from_gif)?;
            encoder.set_repeat(gif::Repeat::Infinite).map_err(from_gif)?;
            self.encoder = Some(encoder);
        }
        let [left, top, right, bottom] = self.changed();
        let rows = self.indices.chunks_exact(usize::from(width)).skip(top).take(bottom - top);
        let buffer: Vec<u8> = rows.flat_map(|row| &row[left..right]).copied().collect();
        let own = (*self.dither.palette() != self.first).then(|| self.dither.palette().as_flattened().to_vec());
        let ticks = self.rate.tick(self.pushed + 1, TICKS) - self.rate.tick(self.pushed, TICKS);
        let frame = gif::Frame {
            delay: u16::try_from(ticks).unwrap_or(u16::MAX),
            dispose: gif::DisposalMethod::Keep,
            left: left as u16,
            top: top as u16,
            width: (right - left) as u16,
            height: (bottom - top) as u16,
            palette: own,
            buffer: Cow::Owned(buffer),
            ..gif::Frame::default()
        };
        if let Some(encoder) = &mut self.encoder {
            encoder.write_frame(&frame).map_err(from_gif)?;
        }
        std::mem::swap(&mut self.shown, &mut self.indices);
        self.shown_palette.clone_from(self.dither.palette());
        self.pushed += 1;
        Ok(())
    }

    fn finish(self, note: Option<&str>) -> Result<(), VideoError> {
        if let Some(mut encoder) = self.encoder {
            if let Some(note) = note.filter(|note| !note.is_empty()) {
                let comment = gif::AnyExtension::from(gif::Extension::Comment);
                encoder.write_raw_extension(comment, &[note.as_bytes()]).map_err(from_gif)?;
            }
            encoder.into_inner().map_err(from_gif)?.flush()?;
        }
        Ok(())
    }
}
