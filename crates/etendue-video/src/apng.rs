//! Animated PNG (PNG Specification, Third Edition, 2025): every frame whole and lossless.

use crate::{FrameRate, Kind, Settings, VideoError, encoder::Format, note};
use png::text_metadata::TEXtChunk;
use std::io::Write;

/// Ticks a second, for rates that do not fit into the 16-bit fractions of the format.
const TICKS: u32 = 10_000;

pub(crate) struct Apng<'w> {
    writer: png::Writer<Box<dyn Write + 'w>>,
    rate: FrameRate,
    pushed: u64,
}

impl<'w> Apng<'w> {
    pub fn new(writer: Box<dyn Write + 'w>, settings: Settings) -> Result<Self, VideoError> {
        let [width, height] = settings.size;
        let frames = u32::try_from(settings.frames).map_err(|e| VideoError::codec(Kind::Apng, e))?;
        let mut encoder = png::Encoder::new(writer, width, height);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::Balanced);
        encoder.set_animated(frames, 0).map_err(from_png)?;
        let (numerator, denominator) = delay(settings.rate, 0);
        encoder.set_frame_delay(numerator, denominator).map_err(from_png)?;
        Ok(Self { writer: encoder.write_header().map_err(from_png)?, rate: settings.rate, pushed: 0 })
    }
}

/// How long frame `k` stands, as a fraction of seconds: exactly if it fits, else rounded without drift.
fn delay(rate: FrameRate, k: u64) -> (u16, u16) {
    if let (Ok(seconds), Ok(frames)) = (u16::try_from(rate.seconds()), u16::try_from(rate.frames())) {
        return (seconds, frames);
    }
    // With few frames a second ticks are longer, so that their number fits.
    let ticks = if u64::from(rate.seconds()) > 6 * u64::from(rate.frames()) { 1 } else { TICKS };
    let stands = rate.tick(k + 1, ticks) - rate.tick(k, ticks);
    (u16::try_from(stands).unwrap_or(u16::MAX), ticks as u16)
}

fn from_png(error: png::EncodingError) -> VideoError {
    match error {
        png::EncodingError::IoError(error) => VideoError::Io(error),
        error => VideoError::codec(Kind::Apng, error),
    }
}

impl Format for Apng<'_> {
    fn push(&mut self, rgb: &[u8]) -> Result<(), VideoError> {
        let (numerator, denominator) = delay(self.rate, self.pushed);
        if self.pushed > 0 {
            self.writer.set_frame_delay(numerator, denominator).map_err(from_png)?;
        }
        self.writer.write_image_data(rgb).map_err(from_png)?;
        self.pushed += 1;
        Ok(())
    }

    fn finish(mut self, note: Option<&str>) -> Result<(), VideoError> {
        if let Some(note) = note {
            let chunk = TEXtChunk::new(note::KEYWORD, note);
            self.writer.write_text_chunk(&chunk).map_err(from_png)?;
        }
        self.writer.finish().map_err(from_png)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delays_are_exact_where_they_fit_and_do_not_drift_elsewhere() {
        assert_eq!(delay(FrameRate::new(30000, 1001).unwrap(), 7), (1001, 30000));
        assert_eq!(delay(FrameRate::new(1, 60_000).unwrap(), 0), (60_000, 1));
        let rate = FrameRate::new(120_000, 1001).unwrap();
        let whole: u64 = (0..120_000).map(|k| u64::from(delay(rate, k).0)).sum();
        assert_eq!(whole, 1001 * u64::from(TICKS));
        let slow = FrameRate::new(7, 70_001).unwrap();
        let whole: u64 = (0..7).map(|k| u64::from(delay(slow, k).0)).sum();
        assert_eq!((whole, delay(slow, 3).1), (70_001, 1));
    }
}
