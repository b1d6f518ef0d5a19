//! H.264 (ITU-T Rec. H.264) through OpenH264: constrained baseline profile, 4:2:0, one quantisation parameter throughout,
//! no frame left out, a key frame every two seconds.

use crate::{Kind, Settings, VideoError, sps, ycbcr::Planes};
use openh264::{
    OpenH264API,
    encoder::{
        BitRate, Complexity, Encoder, EncoderConfig, FrameRate, FrameType, QpRange, RateControlMode, UsageType,
        VuiConfig,
    },
    formats::YUVSlices,
};

/// Pictures are coded in blocks of this many pixels each way.
const BLOCK: usize = 16;
const SPS: u8 = 7;
const PPS: u8 = 8;

pub(crate) struct H264 {
    encoder: Encoder,
    planes: Planes,
    size: [u32; 2],
    key_every: u64,
    encoded: u64,
    sample: Vec<u8>,
    sets: Option<ParameterSets>,
}

/// What a decoder must know before the first picture, without start codes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct ParameterSets {
    pub sequence: Vec<u8>,
    pub picture: Vec<u8>,
}

impl H264 {
    pub fn new(settings: Settings) -> Result<Self, VideoError> {
        // In this mode the parameter moves within its range and nowhere else, and no frame is skipped; the range has one
        // value. Rate control goes down to 12.
        let parameter = 51 - (u32::from(settings.quality) * 39 + 50) / 100;
        let parameter = u8::try_from(parameter).unwrap_or(51).clamp(12, 51);
        let config = EncoderConfig::new()
            .usage_type(UsageType::CameraVideoRealTime)
            .rate_control_mode(RateControlMode::Bufferbased)
            .qp(QpRange::new(parameter, parameter))
            .bitrate(BitRate::from_bps(100_000_000))
            .max_frame_rate(FrameRate::from_hz(settings.rate.as_f64().clamp(1.0, 60.0) as f32))
            .skip_frames(false)
            .scene_change_detect(false)
            .adaptive_quantization(false)
            .background_detection(false)
            .complexity(Complexity::High)
            .num_threads(1)
            .vui(VuiConfig::bt709());
        let encoder = Encoder::with_api_config(OpenH264API::from_source(), config).map_err(codec)?;
        Ok(Self {
            encoder,
            planes: Planes::new(settings.size, BLOCK),
            size: settings.size,
            key_every: key_every(&settings),
            encoded: 0,
            sample: Vec::new(),
            sets: None,
        })
    }

    /// Makes the next frame the [sample](Self::sample).
    pub fn encode(&mut self, rgb: &[u8]) -> Result<(), VideoError> {
        self.planes.convert(rgb);
        let [width, height] = self.planes.luma;
        let planes = (&self.planes.y[..], &self.planes.cb[..], &self.planes.cr[..]);
        let source = YUVSlices::new(planes, (width, height), (width, width / 2, width / 2));
        let key = self.encoded.is_multiple_of(self.key_every);
        if key && self.encoded > 0 {
            self.encoder.force_intra_frame();
        }
        let coded = self.encoder.encode(&source).map_err(codec)?;
        let kind = coded.frame_type();
        if kind == FrameType::Skip || (key && kind != FrameType::IDR) {
            return Err(codec(format!("frame {} became {kind:?}", self.encoded)));
        }
        self.sample.clear();
        let (mut sequence, mut picture) = (None, None);
        for layer in (0..coded.num_layers()).filter_map(|i| coded.layer(i)) {
            for unit in (0..layer.nal_count()).filter_map(|i| layer.nal_unit(i)).map(without_start_code) {
                match unit.first().map(|header| header & 31) {
                    Some(SPS) => sequence = Some(unit.to_vec()),
                    Some(PPS) => picture = Some(unit.to_vec()),
                    Some(_) => {
                        let length = u32::try_from(unit.len()).map_err(codec)?;
                        self.sample.extend_from_slice(&length.to_be_bytes());
                        self.sample.extend_from_slice(unit);
                    }
                    None => (),
                }
            }
        }
        if let (Some(sequence), Some(picture)) = (sequence, picture) {
            let crop = [0, 1].map(|c| (self.planes.luma[c] - self.size[c] as usize) as u32 / 2);
            let sequence =
                sps::cropped(&sequence, crop).ok_or_else(|| codec("its sequence parameter set is not as expected"))?;
            let sets = ParameterSets { sequence, picture };
            if self.sets.get_or_insert_with(|| sets.clone()) != &sets {
                return Err(codec("its parameter sets changed"));
            }
        }
        if self.sample.is_empty() {
            return Err(codec(format!("frame {} gave no bytes", self.encoded)));
        }
        self.encoded += 1;
        Ok(())
    }

    /// The frame as MP4 wants it: units with their lengths (4 bytes, big endian) before them, without the parameter sets.
    pub fn sample(&self) -> &[u8] {
        &self.sample
    }

    /// There from the first frame on.
    pub fn parameter_sets(&self) -> Option<&ParameterSets> {
        self.sets.as_ref()
    }
}

/// A key frame every this many: two seconds' worth.
pub(crate) fn key_every(settings: &Settings) -> u64 {
    (settings.rate.as_f64() * 2.0).round().max(1.0) as u64
}

fn without_start_code(unit: &[u8]) -> &[u8] {
    unit.strip_prefix(&[0, 0, 0, 1]).or_else(|| unit.strip_prefix(&[0, 0, 1])).unwrap_or(unit)
}

fn codec(reason: impl std::fmt::Display) -> VideoError {
    VideoError::codec(Kind::Mp4, reason)
}

#[cfg(test)]
mod tests {
    use super::*;
    use openh264::{decoder::Decoder, formats::YUVSource};

    fn picture(frame: u32) -> Vec<u8> {
        let pixel = |i: u32| [(i % 40 * 4 + frame) as u8, (i / 40 * 5) as u8, (i * 7 % 31 + frame * 3) as u8];
        (0..40 * 24).flat_map(pixel).collect()
    }

    fn settings(quality: u8) -> Settings {
        let rate = crate::FrameRate::new(5, 1).unwrap();
        Settings { size: [40, 24], rate, frames: 25, quality }
    }

    /// With start codes, as a decoder that knows no MP4 wants it.
    fn stream(sample: &[u8]) -> Vec<u8> {
        let (mut out, mut rest) = (Vec::new(), sample);
        while let Some((length, after)) = rest.split_first_chunk::<4>() {
            let (unit, next) = after.split_at(u32::from_be_bytes(*length) as usize);
            out.extend_from_slice(&[0, 0, 0, 1]);
            out.extend_from_slice(unit);
            rest = next;
        }
        out
    }

    #[test]
    fn every_frame_comes_back_at_its_size() {
        let mut encoder = H264::new(settings(100)).unwrap();
        let mut decoder = Decoder::new().unwrap();
        let mut reference = Planes::new([40, 24], 1);
        for frame in 0..25 {
            encoder.encode(&picture(frame)).unwrap();
            let sets = encoder.parameter_sets().unwrap();
            let head = [&[0, 0, 0, 1], &sets.sequence[..], &[0, 0, 0, 1], &sets.picture[..]].concat();
            let bytes = [&head[..if frame == 0 { head.len() } else { 0 }], &stream(encoder.sample())].concat();
            // Unit 5 is a key frame: every ten, at five a second.
            let key = encoder.sample()[4] & 31 == 5;
            assert_eq!(key, frame % 10 == 0, "frame {frame}");
            let decoded = decoder.decode(&bytes).unwrap().expect("a picture");
            assert_eq!(decoded.dimensions(), (40, 24));
            reference.convert(&picture(frame));
            let stride = decoded.strides().0;
            for y in 0..24 {
                for x in 0..40 {
                    let (a, b) = (decoded.y()[y * stride + x], reference.y[y * 40 + x]);
                    assert!(a.abs_diff(b) <= 12, "frame {frame} at {x}, {y}: {a} for {b}");
                }
            }
        }
    }

    #[test]
    fn quality_is_constant() {
        // A still picture: what follows a key frame adds next to nothing, and nothing is spent on a bit rate.
        let mut encoder = H264::new(settings(60)).unwrap();
        let mut lengths = Vec::new();
        for _ in 0..12 {
            encoder.encode(&picture(0)).unwrap();
            lengths.push(encoder.sample().len());
        }
        assert_eq!(lengths[0], lengths[10], "{lengths:?}");
        assert!(lengths[1..10].iter().all(|&length| length * 5 < lengths[0]), "{lengths:?}");
    }
}
