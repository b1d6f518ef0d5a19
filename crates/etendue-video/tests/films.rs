//! Every format: what comes back from the crates' own decoders, limits, and errors.

use etendue_video::{Encoder, FrameRate, Kind, MAX_FRAMES, Settings, VideoError};
use std::io::{self, Cursor, Seek, SeekFrom, Write};

fn settings(size: [u32; 2], frames: u64) -> Settings {
    Settings { size, rate: FrameRate::new(25, 1).unwrap(), frames, quality: 90 }
}

fn kinds() -> impl Iterator<Item = Kind> {
    Kind::ALL.into_iter().filter(|kind| kind.is_available())
}

/// A picture with flat parts, ramps and edges that moves with `frame`.
fn picture([width, height]: [u32; 2], frame: u32) -> Vec<u8> {
    let mut rgb = Vec::new();
    for y in 0..height {
        for x in 0..width {
            let inside = (x + width / 2).abs_diff(width / 2 + frame * 3 % width.max(1)) < width / 4 && y > height / 3;
            let ramp = [x * 200 / width, y * 200 / height, (frame * 7) % 200].map(|c| c as u8 + 20);
            rgb.extend(if inside { [230, 60, 30] } else { ramp });
        }
    }
    rgb
}

fn film(kind: Kind, settings: Settings) -> Vec<u8> {
    let mut file = Cursor::new(Vec::new());
    let mut encoder = Encoder::new(&mut file, kind, settings).unwrap();
    for frame in 0..settings.frames {
        encoder.push_rgb8(&picture(settings.size, frame as u32)).unwrap();
    }
    encoder.finish().unwrap();
    file.into_inner()
}

fn rms(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let sum: f64 = a.iter().zip(b).map(|(&a, &b)| (f64::from(a) - f64::from(b)) * (f64::from(a) - f64::from(b))).sum();
    (sum / a.len() as f64).sqrt()
}

#[test]
fn the_same_frames_give_the_same_bytes() {
    for kind in kinds() {
        let settings = settings([50, 34], 6);
        let first = film(kind, settings);
        assert_eq!(first, film(kind, settings), "{kind}");
        // From a writer that does not stand at its start, and into a pipe.
        let mut file = Cursor::new(b"before".to_vec());
        file.seek(SeekFrom::End(0)).unwrap();
        let mut encoder = Encoder::new(&mut file, kind, settings).unwrap();
        (0..6).for_each(|frame| encoder.push_rgb8(&picture(settings.size, frame)).unwrap());
        encoder.finish().unwrap();
        if kind.streams() {
            assert_eq!(file.get_ref()[6..], first, "{kind}");
            let mut piped = Vec::new();
            let mut encoder = Encoder::stream(&mut piped, kind, settings).unwrap();
            (0..6).for_each(|frame| encoder.push_rgb8(&picture(settings.size, frame)).unwrap());
            encoder.finish().unwrap();
            assert_eq!(piped, first, "{kind}");
        } else {
            assert_eq!(file.get_ref().len(), first.len() + 6, "{kind}");
        }
    }
}

#[test]
fn animated_png_is_lossless() {
    for size in [[1, 1], [37, 5], [64, 48]] {
        let bytes = film(Kind::Apng, settings(size, 3));
        let mut decoder = png::Decoder::new(Cursor::new(bytes));
        decoder.set_transformations(png::Transformations::IDENTITY);
        let mut reader = decoder.read_info().unwrap();
        let control = reader.info().animation_control.unwrap();
        assert_eq!((control.num_frames, control.num_plays), (3, 0));
        assert!(reader.info().srgb.is_some());
        for frame in 0..3 {
            let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
            reader.next_frame(&mut pixels).unwrap();
            assert_eq!(pixels, picture(size, frame), "{size:?} {frame}");
            let control = reader.info().frame_control.unwrap();
            assert_eq!(u32::from(control.delay_den), 25 * u32::from(control.delay_num));
        }
    }
}

#[test]
fn gif_shows_every_frame_for_its_time() {
    let size = [61, 47];
    let mut settings = settings(size, 60);
    settings.rate = FrameRate::new(30_000, 1001).unwrap();
    let bytes = film(Kind::Gif, settings);
    let mut options = gif::DecodeOptions::new();
    options.set_color_output(gif::ColorOutput::Indexed);
    let mut decoder = options.read_info(Cursor::new(bytes)).unwrap();
    assert_eq!((u32::from(decoder.width()), u32::from(decoder.height())), (size[0], size[1]));
    assert_eq!(decoder.repeat(), gif::Repeat::Infinite);
    let global = decoder.global_palette().unwrap().to_vec();
    let mut shown = vec![0u8; (size[0] * size[1] * 3) as usize];
    let (mut frames, mut ticks) = (0, 0);
    while let Some(frame) = decoder.read_next_frame().unwrap() {
        let palette = frame.palette.as_ref().unwrap_or(&global);
        let width = usize::from(frame.width);
        for (i, &index) in frame.buffer.iter().enumerate() {
            let (x, y) = (usize::from(frame.left) + i % width, usize::from(frame.top) + i / width);
            let at = (y * size[0] as usize + x) * 3;
            shown[at..at + 3].copy_from_slice(&palette[usize::from(index) * 3..][..3]);
        }
        let off = rms(&shown, &picture(size, frames));
        assert!(off < 8.0, "frame {frames}: {off}");
        ticks += u32::from(frame.delay);
        assert!((3..=4).contains(&frame.delay));
        frames += 1;
    }
    assert_eq!((frames, ticks), (60, 200));
}

#[test]
fn y4m_has_planes_of_the_right_size() {
    for size in [[1u32, 1], [7, 5], [16, 8]] {
        let bytes = film(Kind::Y4m, settings(size, 2));
        let end = bytes.iter().position(|&b| b == b'\n').unwrap();
        let header = std::str::from_utf8(&bytes[..end]).unwrap();
        assert!(header.starts_with(&format!("YUV4MPEG2 W{} H{} F25:1 Ip A1:1 C420mpeg2", size[0], size[1])));
        assert!(header.contains("XCOLORRANGE=LIMITED"));
        let planes = (size[0] * size[1] + 2 * size[0].div_ceil(2) * size[1].div_ceil(2)) as usize;
        assert_eq!(bytes.len(), end + 1 + 2 * (6 + planes), "{size:?}");
        assert_eq!(&bytes[end + 1..end + 7], b"FRAME\n");
    }
}

#[test]
fn one_pixel_and_one_frame() {
    for kind in kinds() {
        for size in [[1, 1], [1, 40], [33, 1]] {
            assert!(film(kind, settings(size, 1)).len() > 50, "{kind}");
        }
    }
}

#[test]
fn large_pictures() {
    for kind in kinds() {
        let settings = settings([3840, 2160], 1);
        let mut encoder = Encoder::new(Cursor::new(Vec::new()), kind, settings).unwrap();
        encoder.push_rgb8(&vec![77; 3840 * 2160 * 3]).unwrap();
        encoder.finish().unwrap();
        // Far beyond any limit: refused before anything is allocated.
        let settings = Settings { size: [u32::MAX, u32::MAX], ..settings };
        let refused = Encoder::new(Cursor::new(Vec::new()), kind, settings);
        assert!(matches!(refused, Err(VideoError::TooLarge { .. })), "{kind}");
    }
}

#[test]
fn settings_that_cannot_be_are_refused() {
    let good = settings([8, 8], 2);
    let rate = |frames, seconds| FrameRate::new(frames, seconds).unwrap();
    for kind in kinds() {
        let check = |settings: Settings| settings.check(kind);
        assert!(check(good).is_ok());
        assert!(matches!(check(Settings { size: [0, 8], ..good }), Err(VideoError::NoPixels { .. })));
        assert!(matches!(check(Settings { frames: 0, ..good }), Err(VideoError::NoFrames)));
        assert!(matches!(check(Settings { frames: MAX_FRAMES + 1, ..good }), Err(VideoError::TooManyFrames { .. })));
        assert!(matches!(check(Settings { quality: 101, ..good }), Err(VideoError::BadQuality { .. })));
    }
    assert!(matches!(Settings { rate: rate(60, 1), ..good }.check(Kind::Gif), Err(VideoError::TooFast { .. })));
    assert!(matches!(Settings { rate: rate(1, 700), ..good }.check(Kind::Gif), Err(VideoError::TooSlow { .. })));
    assert!(matches!(Settings { rate: rate(1, 70_000), ..good }.check(Kind::Apng), Err(VideoError::TooSlow { .. })));
    assert!(matches!(Settings { size: [70_000, 1], ..good }.check(Kind::Gif), Err(VideoError::TooLarge { .. })));
    if Kind::Mp4.is_available() {
        assert!(Settings { size: [2160, 3840], ..good }.check(Kind::Mp4).is_ok());
        assert!(matches!(Settings { size: [2162, 3840], ..good }.check(Kind::Mp4), Err(VideoError::TooLarge { .. })));
        let piped = Encoder::stream(Vec::new(), Kind::Mp4, good);
        assert!(matches!(piped, Err(VideoError::NeedsSeek { .. })));
    } else {
        assert!(matches!(good.check(Kind::Mp4), Err(VideoError::LeftOut { .. })));
    }
}

#[test]
fn frames_that_do_not_fit_are_refused() {
    for kind in kinds() {
        let mut encoder = Encoder::new(Cursor::new(Vec::new()), kind, settings([4, 4], 2)).unwrap();
        for length in [0, 47, 49, 64] {
            let error = encoder.push_rgb8(&vec![0; length]).unwrap_err();
            assert!(matches!(error, VideoError::FrameLength { frame: 0, expected: 48, .. }), "{kind}");
        }
        encoder.push_rgb8(&[9; 48]).unwrap();
        encoder.push_rgb8(&[9; 48]).unwrap();
        let error = encoder.push_rgb8(&[9; 48]).unwrap_err();
        assert!(matches!(error, VideoError::FrameCount { got: 3, expected: 2 }), "{kind}");
        encoder.finish().unwrap();

        let mut encoder = Encoder::new(Cursor::new(Vec::new()), kind, settings([4, 4], 2)).unwrap();
        encoder.push_rgb8(&[9; 48]).unwrap();
        let error = encoder.finish().unwrap_err();
        assert!(matches!(error, VideoError::FrameCount { got: 1, expected: 2 }), "{kind}");
    }
}

/// A disk of so many bytes.
struct Disk {
    file: Cursor<Vec<u8>>,
    room: u64,
}

impl Write for Disk {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if self.file.position() + bytes.len() as u64 > self.room {
            return Err(io::ErrorKind::StorageFull.into());
        }
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for Disk {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

#[test]
fn a_full_disk_is_told() {
    for kind in kinds() {
        let settings = settings([32, 32], 4);
        let whole = film(kind, settings).len() as u64;
        for room in [0, 10, whole / 2, whole - 1] {
            let run = || -> Result<(), VideoError> {
                let mut encoder = Encoder::new(Disk { file: Cursor::default(), room }, kind, settings)?;
                for frame in 0..4 {
                    encoder.push_rgb8(&picture(settings.size, frame))?;
                }
                encoder.finish()
            };
            match run() {
                Err(VideoError::Io(error)) => assert_eq!(error.kind(), io::ErrorKind::StorageFull, "{kind} {room}"),
                other => panic!("{kind} with room for {room}: {other:?}"),
            }
        }
    }
}

/// Counts, and keeps nothing.
struct Counter(u64);

impl Write for Counter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.0 += bytes.len() as u64;
        Ok(bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

#[test]
fn frames_leave_at_once() {
    for kind in kinds().filter(|kind| kind.streams()) {
        let mut written = Counter(0);
        let mut encoder = Encoder::stream(written.by_ref(), kind, settings([64, 64], 40)).unwrap();
        (0..40).for_each(|frame| encoder.push_rgb8(&picture([64, 64], frame)).unwrap());
        drop(encoder);
        assert!(written.0 > 1000, "{kind}");
    }
}

/// A note comes back from a whole film, and from nothing else; the frames are the same with it.
#[test]
fn notes_come_back() {
    let long = "0123456789abcdef".repeat(5000);
    for kind in kinds() {
        let settings = settings([24, 18], 5);
        let plain = film(kind, settings);
        for note in ["made of this and that", &long] {
            let mut file = Cursor::new(Vec::new());
            let mut encoder = Encoder::new(&mut file, kind, settings).unwrap();
            (0..5).for_each(|frame| encoder.push_rgb8(&picture(settings.size, frame)).unwrap());
            encoder.finish_with(note).unwrap();
            let bytes = file.into_inner();
            let read = |bytes: &[u8]| kind.note(&mut Cursor::new(bytes)).unwrap();
            assert_eq!(read(&bytes), kind.keeps_note().then(|| note.to_owned()), "{kind}");
            assert_eq!(read(&plain), None, "{kind}");
            if !kind.keeps_note() {
                assert_eq!(bytes, plain);
                continue;
            }
            assert!(bytes.len() > plain.len() + note.len(), "{kind}");
            let common = bytes.iter().zip(&plain).take_while(|(a, b)| a == b).count();
            assert!(common + 12 >= plain.len(), "{kind}: {common} of {} bytes", plain.len());
            // Cut off anywhere it is no film; of another kind it has no note.
            for cut in [0, 1, 20, bytes.len() / 2, bytes.len() - note.len() - 3, bytes.len() - 1] {
                assert_eq!(read(&bytes[..cut]), None, "{kind} {cut}");
            }
            for other in Kind::ALL.into_iter().filter(|other| *other != kind) {
                assert_eq!(other.note(&mut Cursor::new(&bytes)).unwrap(), None, "{other} of {kind}");
            }
        }
    }
}

/// Bytes of any kind end in an answer.
#[test]
fn notes_of_damaged_films() {
    let mut state = 1u32;
    let mut random = move || {
        state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
        state >> 8
    };
    for kind in kinds() {
        let mut file = Cursor::new(Vec::new());
        let mut encoder = Encoder::new(&mut file, kind, settings([8, 6], 3)).unwrap();
        (0..3).for_each(|frame| encoder.push_rgb8(&picture([8, 6], frame)).unwrap());
        encoder.finish_with("a note").unwrap();
        let whole = file.into_inner();
        for _ in 0..2000 {
            let mut bytes = whole.clone();
            for _ in 0..1 + random() % 4 {
                let at = random() as usize % bytes.len();
                bytes[at] = random() as u8;
            }
            let _ = kind.note(&mut Cursor::new(bytes)).unwrap();
        }
    }
}
