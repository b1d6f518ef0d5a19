//! Every format, decoded by FFmpeg: the program that `ETENDUE_FFMPEG` names. `cargo xtask test` brings one.

use etendue_video::{Encoder, FrameRate, Kind, Settings};
use std::{io::BufWriter, path::Path, process::Command};

/// What FFmpeg says of a file, and its frames as 8-bit RGB.
struct Decoded {
    said: String,
    frames: Vec<Vec<u8>>,
}

fn ffmpeg(arguments: &[&str]) -> (String, Vec<u8>) {
    let program = std::env::var_os("ETENDUE_FFMPEG").expect("ETENDUE_FFMPEG names no program: run `cargo xtask test`");
    let output = Command::new(program).args(["-hide_banner", "-nostdin"]).args(arguments).output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success(), "{arguments:?}: {said}");
    (said, output.stdout)
}

fn decode(path: &Path, [width, height]: [u32; 2]) -> Decoded {
    let path = path.to_str().unwrap();
    // Every frame once, colours as the file says; a Y4M says nothing and means BT.709.
    let matrix = if path.ends_with(".y4m") { "in_color_matrix=bt709:" } else { "" };
    let filter = format!("scale={matrix}flags=bilinear+accurate_rnd+full_chroma_int,format=rgb24");
    let out = ["-vf", &filter, "-fps_mode", "passthrough"];
    let arguments = [&["-v", "info", "-i", path], &out[..], &["-f", "rawvideo", "-"]].concat();
    let (said, bytes) = ffmpeg(&arguments);
    let frames = bytes.chunks(width as usize * height as usize * 3).map(<[u8]>::to_vec).collect();
    Decoded { said, frames }
}

fn write(path: &Path, kind: Kind, settings: Settings, frame: impl Fn(u64) -> Vec<u8>) {
    let file = BufWriter::new(std::fs::File::create(path).unwrap());
    let mut encoder = Encoder::new(file, kind, settings).unwrap();
    (0..settings.frames).for_each(|k| encoder.push_rgb8(&frame(k)).unwrap());
    encoder.finish_with("what a film is made of").unwrap();
}

/// A ramp, a moving bar and a corner, in colours that drift from frame to frame.
fn picture([width, height]: [u32; 2], frame: u64) -> Vec<u8> {
    let frame = frame as u32;
    let mut rgb = Vec::new();
    for y in 0..height {
        for x in 0..width {
            rgb.extend(if x / 8 == frame % width.div_ceil(8) {
                [200, 140, 130]
            } else if y > height / 2 && x > width / 2 {
                [70, 90, 130]
            } else {
                [40 + 100 * x / width, 60 + 100 * y / height, 40 + frame % 64].map(|c| c as u8)
            });
        }
    }
    rgb
}

/// With the last column and row twice where their number is odd.
fn even([width, height]: [u32; 2], rgb: &[u8]) -> Vec<u8> {
    let [wide, high] = [width, height].map(|n| n.next_multiple_of(2));
    let at = |x: u32, y: u32| ((y.min(height - 1) * width + x.min(width - 1)) * 3) as usize;
    (0..high).flat_map(|y| (0..wide).flat_map(move |x| rgb[at(x, y)..][..3].to_vec())).collect()
}

fn mean(rgb: &[u8]) -> [f64; 3] {
    let mut sums = [0.0; 3];
    rgb.iter().enumerate().for_each(|(i, &v)| sums[i % 3] += f64::from(v));
    sums.map(|s| s / (rgb.len() / 3) as f64)
}

fn rms(a: &[u8], b: &[u8]) -> f64 {
    assert_eq!(a.len(), b.len());
    let sum: f64 = a.iter().zip(b).map(|(&a, &b)| (f64::from(a) - f64::from(b)) * (f64::from(a) - f64::from(b))).sum();
    (sum / a.len() as f64).sqrt()
}

/// Mean colours within `mean_off` and pixels within `rms_off` (root mean square), of 255.
fn compare(kind: Kind, settings: Settings, mean_off: f64, rms_off: f64) -> String {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film").with_extension(kind.extension());
    let size = settings.size;
    write(&path, kind, settings, |k| picture(size, k));
    let shown = if kind == Kind::Mp4 { size.map(|n| n.next_multiple_of(2)) } else { size };
    let decoded = decode(&path, shown);
    assert_eq!(decoded.frames.len() as u64, settings.frames, "{kind}: {}", decoded.said);
    for (k, got) in decoded.frames.iter().enumerate() {
        let expected = if kind == Kind::Mp4 { even(size, &picture(size, k as u64)) } else { picture(size, k as u64) };
        assert_eq!(got.len(), expected.len(), "{kind}: {}", decoded.said);
        let (a, b) = (mean(got), mean(&expected));
        for c in 0..3 {
            assert!((a[c] - b[c]).abs() < mean_off, "{kind} {size:?} frame {k}: mean {a:?} for {b:?}");
        }
        let off = rms(got, &expected);
        assert!(off < rms_off, "{kind} {size:?} frame {k}: {off}");
    }
    decoded.said
}

fn settings(size: [u32; 2], rate: (u64, u64), frames: u64) -> Settings {
    Settings { size, rate: FrameRate::new(rate.0, rate.1).unwrap(), frames, quality: 90 }
}

#[test]
fn mp4_is_h264_with_its_colours_tagged() {
    let said = compare(Kind::Mp4, settings([96, 64], (25, 1), 120), 1.5, 8.0);
    for part in ["Video: h264 (Constrained Baseline)", "yuv420p(tv, bt709", "96x64", "25 fps", "00:00:04.80"] {
        assert!(said.contains(part), "no `{part}`: {said}");
    }
    // Not a word of warning.
    assert!(!said.to_lowercase().contains("error") && !said.contains("deprecated"), "{said}");
}

#[test]
fn mp4_rates_are_exact() {
    for (rate, shown, duration) in [
        ((30_000, 1001), "29.97 fps", "00:00:02.00"),
        ((24, 1), "24 fps", "00:00:02.50"),
        ((1, 2), "0.50 fps", "00:02:00.00"),
    ] {
        let said = compare(Kind::Mp4, settings([32, 32], rate, 60), 3.0, 12.0);
        assert!(said.contains(shown) && said.contains(duration), "{rate:?}: {said}");
    }
}

#[test]
fn mp4_of_odd_and_tiny_sizes_is_cropped() {
    for size in [[1, 1], [2, 2], [17, 33], [37, 21], [16, 16], [101, 3]] {
        compare(Kind::Mp4, settings(size, (25, 1), 5), 4.0, 12.0);
    }
}

#[test]
fn mp4_starts_anywhere_at_its_key_frames() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.mp4");
    let settings = settings([64, 48], (10, 1), 100);
    write(&path, Kind::Mp4, settings, |k| picture(settings.size, k));
    // From 6.0 s on: frame 60, a key frame, decoded without what was before it.
    let file = path.to_str().unwrap();
    let (said, bytes) = ffmpeg(&["-ss", "6", "-i", file, "-frames:v", "1", "-pix_fmt", "rgb24", "-f", "rawvideo", "-"]);
    assert!(rms(&bytes, &picture(settings.size, 60)) < 8.0, "{said}");
    let (said, _) = ffmpeg(&["-skip_frame", "nokey", "-i", file, "-fps_mode", "passthrough", "-f", "null", "-"]);
    assert!(said.contains("frame=    5"), "{said}");
    // The index stands before the frames.
    let bytes = std::fs::read(&path).unwrap();
    let place = |name: &[u8]| bytes.windows(4).position(|w| w == name).unwrap();
    assert!(place(b"moov") < place(b"mdat"));
}

#[test]
fn quality_trades_size_for_likeness() {
    let folder = tempfile::tempdir().unwrap();
    let mut last = (0, f64::INFINITY);
    for quality in [0, 50, 100] {
        let path = folder.path().join(format!("{quality}.mp4"));
        let settings = Settings { quality, ..settings([96, 64], (25, 1), 10) };
        write(&path, Kind::Mp4, settings, |k| picture(settings.size, k));
        let length = std::fs::metadata(&path).unwrap().len();
        let off = rms(&decode(&path, settings.size).frames[9], &picture(settings.size, 9));
        assert!(length > last.0 && off < last.1, "quality {quality}: {length} bytes, {off} off after {last:?}");
        last = (length, off);
    }
}

#[test]
fn gif_keeps_mean_colours_and_time() {
    let said = compare(Kind::Gif, settings([96, 64], (25, 1), 50), 1.0, 8.0);
    assert!(said.contains("Video: gif") && said.contains("25 fps") && said.contains("00:00:02.00"), "{said}");
    let said = compare(Kind::Gif, settings([33, 17], (30, 1), 60), 1.0, 8.0);
    assert!(said.contains("00:00:02.00"), "{said}");
}

#[test]
fn animated_png_is_exact() {
    for size in [[1, 1], [41, 23]] {
        let said = compare(Kind::Apng, settings(size, (25, 1), 10), 0.001, 0.001);
        assert!(said.contains("Video: apng") && said.contains("25 fps"), "{said}");
    }
}

#[test]
fn y4m_is_as_a_pipe_wants_it() {
    for size in [[96, 64], [37, 21], [1, 1]] {
        let said = compare(Kind::Y4m, settings(size, (30_000, 1001), 10), 1.5, 14.0);
        assert!(said.contains("rawvideo") && said.contains("yuv420p(tv") && said.contains("29.97 fps"), "{said}");
    }
}

#[test]
fn a_large_film() {
    let settings = settings([3840, 2160], (25, 1), 2);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("film.mp4");
    write(&path, Kind::Mp4, settings, |k| picture(settings.size, k));
    let decoded = decode(&path, settings.size);
    assert_eq!(decoded.frames.len(), 2);
    assert!(rms(&decoded.frames[1], &picture(settings.size, 1)) < 3.0);
}
