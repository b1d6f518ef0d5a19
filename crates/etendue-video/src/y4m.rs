//! YUV4MPEG2: a line of text, then raw planes. The format of pipes between encoders (mjpegtools, `yuv4mpeg(5)`).

use crate::{Settings, VideoError, encoder::Format, ycbcr::Planes};
use std::io::Write;

pub(crate) struct Y4m<'w> {
    writer: Box<dyn Write + 'w>,
    planes: Planes,
}

impl<'w> Y4m<'w> {
    pub fn new(mut writer: Box<dyn Write + 'w>, settings: Settings) -> Result<Self, VideoError> {
        let Settings { size: [width, height], rate, .. } = settings;
        let (frames, seconds) = (rate.frames(), rate.seconds());
        writeln!(
            writer,
            "YUV4MPEG2 W{width} H{height} F{frames}:{seconds} Ip A1:1 C420mpeg2 XYSCSS=420MPEG2 XCOLORRANGE=LIMITED"
        )?;
        Ok(Self { writer, planes: Planes::new(settings.size, 1) })
    }
}

impl Format for Y4m<'_> {
    fn push(&mut self, rgb: &[u8]) -> Result<(), VideoError> {
        self.planes.convert(rgb);
        self.writer.write_all(b"FRAME\n")?;
        for plane in [&self.planes.y, &self.planes.cb, &self.planes.cr] {
            self.writer.write_all(plane)?;
        }
        Ok(())
    }

    fn finish(mut self, _: Option<&str>) -> Result<(), VideoError> {
        Ok(self.writer.flush()?)
    }
}
