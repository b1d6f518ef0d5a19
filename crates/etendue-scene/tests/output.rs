//! Pictures written and read back, damaged files, and files that are whole or not there.

use etendue::{
    image::{Channel, ChannelData, Image},
    tonemap::{DisplayTransform, Encoding},
};
use etendue_scene::{
    image_file::{self, Limits, ReadError, decode_image, read_image},
    output::{EncodeError, Format, Metadata, Window, WriteError, atomic, exr, hdr, pfm, png, write_image},
};
use proptest::prelude::*;
use std::{
    fs,
    io::{Cursor, Write},
    path::Path,
    sync::OnceLock,
};

fn picture() -> Image {
    let (width, height) = (37_u32, 21_u32);
    let pixels = (width * height) as usize;
    let ramp = |scale: f32| ChannelData::F32((0..pixels).map(|i| scale * i as f32 / pixels as f32).collect());
    let mut depth: Vec<f32> = (0..pixels).map(|i| i as f32).collect();
    depth[3] = f32::INFINITY;
    let channel = |name: &str, data| Channel { name: name.to_owned(), data };
    Image {
        width,
        height,
        channels: vec![
            channel("R", ramp(1.0)),
            channel("G", ramp(0.5)),
            channel("B", ramp(30.0)),
            channel("A", ramp(0.9)),
            channel("Albedo.R", ramp(0.1)),
            channel("Depth.Z", ChannelData::F32(depth)),
            channel("Id.Object", ChannelData::U32((0..pixels as u32).map(|i| i.wrapping_mul(0x9e37_79b9)).collect())),
        ],
    }
}

fn opaque() -> Image {
    let mut image = picture();
    image.channels.retain(|channel| channel.name != "A");
    image
}

fn metadata() -> Metadata {
    Metadata { software: "Etendue test".to_owned(), ..Metadata::default() }
        .with("seed", u64::MAX)
        .with("commandLine", "etendue render \"Étendue.toml\"")
}

fn linear_to_byte(rgb: [f32; 3]) -> [u8; 3] {
    rgb.map(|v| {
        let v = f64::from(v.clamp(0.0, 1.0));
        let encoded = if v <= 0.003_130_8 { 12.92 * v } else { 1.055 * libm::pow(v, 1.0 / 2.4) - 0.055 };
        (encoded * 255.0 + 0.5) as u8
    })
}

fn exr_bytes() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let mut bytes = Cursor::new(Vec::new());
        exr::write(&mut bytes, &picture(), &metadata()).unwrap();
        bytes.into_inner()
    })
}

fn png_bytes() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let mut bytes = Vec::new();
        png::write(&mut bytes, &opaque(), &metadata(), &linear_to_byte).unwrap();
        bytes
    })
}

fn pfm_bytes() -> &'static [u8] {
    static BYTES: OnceLock<Vec<u8>> = OnceLock::new();
    BYTES.get_or_init(|| {
        let mut bytes = Vec::new();
        pfm::write(&mut bytes, &picture()).unwrap();
        bytes
    })
}

#[test]
fn exr_keeps_every_channel_to_the_bit() {
    let (image, metadata) = image_file::exr::read(Path::new("x.exr"), exr_bytes(), &Limits::default()).unwrap();
    assert_eq!(image, picture());
    assert_eq!(metadata.software, "Etendue test");
    assert_eq!(metadata.get("seed"), Some("18446744073709551615"));
    assert_eq!(metadata.get("commandLine"), Some("etendue render \"Étendue.toml\""));
    assert_eq!(metadata.window, None);
}

#[test]
fn exr_keeps_where_a_crop_lies() {
    let window = Some(Window { origin: [10, 20], whole: [640, 480] });
    let mut bytes = Cursor::new(Vec::new());
    exr::write(&mut bytes, &picture(), &Metadata { window, ..metadata() }).unwrap();
    let (image, metadata) = image_file::exr::read(Path::new("x.exr"), bytes.get_ref(), &Limits::default()).unwrap();
    assert_eq!((image, metadata.window), (picture(), window));
}

#[test]
fn png_decodes_to_within_half_a_step_and_names_its_colour_space() {
    let bytes = png_bytes();
    for chunk in [&b"sRGB"[..], b"gAMA", b"iTXt", b"Etendue test"] {
        assert!(bytes.windows(chunk.len()).any(|w| w == chunk));
    }
    let image = decode_image(Path::new("x.png"), bytes, &Limits::default()).unwrap();
    let names: Vec<&str> = image.channels.iter().map(|c| &c.name[..]).collect();
    assert_eq!((image.width, image.height, names), (37, 21, vec!["R", "G", "B"]));
    let (written, read) = (opaque(), image);
    for name in ["R", "G", "B"] {
        for (&w, &r) in written.f32_channel(name).unwrap().iter().zip(read.f32_channel(name).unwrap()) {
            // Half an 8 bit step is largest at white: 1.055 * 2.4 ... / 255 / 2 < 0.0047.
            assert!((w.min(1.0) - r).abs() < 0.0047, "{name}: {w} {r}");
            assert_eq!(linear_to_byte([w; 3]), linear_to_byte([r; 3]));
        }
    }
}

/// A picture in proportion to the light says so, and is read back as what it was.
#[test]
fn png_may_be_linear() {
    let display = DisplayTransform { encoding: Encoding::Linear, ..DisplayTransform::default() };
    let mut bytes = Vec::new();
    let metadata = Metadata { encoding: display.encoding, ..metadata() };
    png::write(&mut bytes, &opaque(), &metadata, &display.encoder()).unwrap();
    let holds = |chunk: &[u8]| bytes.windows(chunk.len()).any(|w| w == chunk);
    assert!(!holds(b"sRGB") && holds(b"gAMA\x00\x01\x86\xa0"));
    let read = decode_image(Path::new("x.png"), &bytes, &Limits::default()).unwrap();
    for name in ["R", "G", "B"] {
        for (&w, &r) in opaque().f32_channel(name).unwrap().iter().zip(read.f32_channel(name).unwrap()) {
            assert!((w.clamp(0.0, 1.0) - r).abs() < 0.5 / 255.0 + 1e-6, "{name}: {w} {r}");
        }
    }
}

#[test]
fn png_has_straight_alpha_where_the_picture_has_alpha() {
    let channel = |name: &str, data: [f32; 6]| Channel { name: name.to_owned(), data: ChannelData::F32(data.to_vec()) };
    let (red, alpha) = ([0.5, 0.25, 3.0, 1.0, 0.1, 0.1], [1.0, 0.5, 0.5, 0.0, f32::NAN, 1.5]);
    let channels = vec![channel("R", red), channel("G", red), channel("B", [0.0; 6]), channel("A", alpha)];
    let mut bytes = Vec::new();
    png::write(&mut bytes, &Image { width: 3, height: 2, channels }, &metadata(), &linear_to_byte).unwrap();
    let stored = image_file::decode_texture(Path::new("x"), &bytes, &Limits::default()).unwrap();
    let half = linear_to_byte([0.5; 3])[0];
    let tenth = linear_to_byte([0.1 / 1.5; 3])[0];
    let image_file::Samples::U8(samples) = stored.samples else { panic!() };
    let expected = [(half, 255), (half, 128), (255, 128), (0, 0), (0, 0), (tenth, 255)];
    assert_eq!(samples, expected.map(|(c, a)| [c, c, 0, a]).concat());
}

#[test]
fn hdr_keeps_colour_to_an_eighth_of_a_bit() {
    for width in [37, 7, 3] {
        let mut written = picture();
        // Too narrow for run lengths, too.
        (written.width, written.height) = (width, 777 / width);
        for channel in &mut written.channels {
            match &mut channel.data {
                ChannelData::F32(data) => data.truncate((width * written.height) as usize),
                ChannelData::U32(data) => data.truncate((width * written.height) as usize),
            }
        }
        let mut bytes = Vec::new();
        let metadata = metadata().with("note", "one\n\ntwo");
        hdr::write(&mut bytes, &written, &metadata).unwrap();
        let read = decode_image(Path::new("x"), &bytes, &Limits::default()).unwrap();
        assert_eq!((read.width, read.height, read.channels.len()), (width, written.height, 3));
        let planes = |image: &Image| ["R", "G", "B"].map(|name| image.f32_channel(name).unwrap().to_vec());
        let (w, r) = (planes(&written), planes(&read));
        for i in 0..w[0].len() {
            let largest = w[0][i].max(w[1][i]).max(w[2][i]);
            for c in 0..3 {
                assert!((w[c][i] - r[c][i]).abs() <= largest / 255.0, "{width} {i} {c}");
            }
        }
        // What has been written once is kept to the bit.
        let mut again = Vec::new();
        hdr::write(&mut again, &read, &metadata).unwrap();
        assert_eq!(again, bytes);
    }
}

#[test]
fn hdr_run_lengths_are_used_and_come_back() {
    // Runs of every length up to 300, and differing bytes between them.
    let mut grey = vec![];
    for length in 1..300u32 {
        grey.extend((0..length).map(|_| 1.0 + (length % 100) as f32 / 128.0));
        grey.extend((0..length % 7).map(|i| 1.0 + i as f32 / 128.0));
    }
    let channels = ["R", "G", "B"].map(|name| Channel { name: name.to_owned(), data: ChannelData::F32(grey.clone()) });
    for height in [1, 2] {
        let (width, channels) = (grey.len() as u32 / height, channels.to_vec());
        let mut image = Image { width: width.min(32_767), height, channels };
        for channel in &mut image.channels {
            let ChannelData::F32(data) = &mut channel.data else { panic!() };
            data.truncate((image.width * height) as usize);
        }
        let mut bytes = Vec::new();
        hdr::write(&mut bytes, &image, &Metadata::default()).unwrap();
        assert!(bytes.len() < image.channels.len() * grey.len() / 4, "{}", bytes.len());
        assert_eq!(decode_image(Path::new("x"), &bytes, &Limits::default()).unwrap(), image);
    }
}

#[test]
fn png_of_16_bits_and_of_other_kinds() {
    let encode = |color, depth, gamma: Option<f32>, data: &[u8]| {
        let mut bytes = Vec::new();
        let mut encoder = ::png::Encoder::new(&mut bytes, 2, 1);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if let Some(gamma) = gamma {
            encoder.set_source_gamma(::png::ScaledFloat::new(gamma));
        }
        if color == ::png::ColorType::Indexed {
            encoder.set_palette(vec![0, 0, 0, 255, 0, 255]);
        }
        encoder.write_header().unwrap().write_image_data(data).unwrap();
        decode_image(Path::new("x.png"), &bytes, &Limits::default()).unwrap()
    };
    let grey16 = encode(::png::ColorType::Grayscale, ::png::BitDepth::Sixteen, None, &[0x80, 0x00, 0xff, 0xff]);
    let expected = libm::pow((32_768.0 / 65_535.0 + 0.055) / 1.055, 2.4) as f32;
    for name in ["R", "G", "B"] {
        assert_eq!(grey16.f32_channel(name).unwrap(), [expected, 1.0]);
    }
    let linear = encode(::png::ColorType::Rgba, ::png::BitDepth::Eight, Some(1.0), &[51, 0, 0, 51, 255, 255, 255, 255]);
    // Colour comes premultiplied.
    assert_eq!(linear.f32_channel("R").unwrap(), [0.2 * 0.2, 1.0]);
    assert_eq!(linear.f32_channel("A").unwrap(), [0.2, 1.0]);
    let palette = encode(::png::ColorType::Indexed, ::png::BitDepth::One, None, &[0b0100_0000]);
    assert_eq!(palette.f32_channel("R").unwrap(), [0.0, 1.0]);
    assert_eq!(palette.f32_channel("G").unwrap(), [0.0, 0.0]);
}

#[test]
fn pfm_keeps_colour_to_the_bit() {
    let image = decode_image(Path::new("x.pfm"), pfm_bytes(), &Limits::default()).unwrap();
    assert_eq!(image.channels[..], picture().channels[..3]);
    let grey = decode_image(Path::new("x.pfm"), b"Pf\n1 2\n1.0\n\x3f\x80\0\0\x40\0\0\0", &Limits::default()).unwrap();
    assert_eq!(grey.f32_channel("G").unwrap(), [2.0, 1.0]);
}

#[test]
fn malformed_pictures_are_not_written() {
    let mut image = picture();
    image.channels[4].data = ChannelData::F32(vec![0.0]);
    for result in [
        png::write(Vec::new(), &image, &metadata(), &linear_to_byte),
        exr::write(Cursor::new(Vec::new()), &image, &metadata()),
        pfm::write(Vec::new(), &image),
    ] {
        assert!(matches!(result, Err(EncodeError::Malformed(_))));
    }
    let mut no_color = picture();
    no_color.channels.remove(1);
    assert!(matches!(png::write(Vec::new(), &no_color, &metadata(), &linear_to_byte), Err(EncodeError::NoColor)));
}

#[test]
fn formats_go_by_the_ending() {
    assert_eq!(Format::of_path(Path::new("a/b.c.EXR")), Ok(Format::Exr));
    for bad in ["a.jpg", "png", "a.", ".png", "a"] {
        let message = Format::of_path(Path::new(bad)).unwrap_err().to_string();
        assert!(message.contains(".png, .exr, .hdr, .pfm") && message.contains(bad), "{message}");
    }
}

/// Reads `bytes` as whichever format they claim to be.
fn read_bytes(bytes: &[u8]) -> Result<Image, ReadError> {
    decode_image(Path::new("x"), bytes, &Limits::default())
}

#[test]
fn declared_sizes_are_checked_before_memory_is_taken() {
    // 100,000 x 100,000 pixels: by the limit.
    let mut huge_png = png_bytes().to_vec();
    huge_png[16..20].copy_from_slice(&100_000_u32.to_be_bytes());
    huge_png[20..24].copy_from_slice(&100_000_u32.to_be_bytes());
    let crc = crc32(&huge_png[12..29]);
    huge_png[29..33].copy_from_slice(&crc.to_be_bytes());
    assert!(matches!(read_bytes(&huge_png), Err(ReadError::TooLarge { .. })));
    // 10,000 x 10,000: within the limit, but not in so few bytes.
    huge_png[16..20].copy_from_slice(&10_000_u32.to_be_bytes());
    huge_png[20..24].copy_from_slice(&10_000_u32.to_be_bytes());
    let crc = crc32(&huge_png[12..29]);
    huge_png[29..33].copy_from_slice(&crc.to_be_bytes());
    assert!(matches!(read_bytes(&huge_png), Err(ReadError::Damaged { .. })));

    let window = exr_bytes().windows(10).position(|w| w == b"dataWindow").unwrap() + 11 + 6 + 4;
    let mut huge_exr = exr_bytes().to_vec();
    huge_exr[window + 8..window + 12].copy_from_slice(&99_999_i32.to_le_bytes());
    huge_exr[window + 12..window + 16].copy_from_slice(&99_999_i32.to_le_bytes());
    assert!(matches!(read_bytes(&huge_exr), Err(ReadError::TooLarge { .. })), "{:?}", read_bytes(&huge_exr));
    huge_exr[window + 8..window + 12].copy_from_slice(&9_i32.to_le_bytes());
    huge_exr[window + 12..window + 16].copy_from_slice(&9_999_999_i32.to_le_bytes());
    assert!(matches!(read_bytes(&huge_exr), Err(ReadError::Damaged { .. })));

    assert!(matches!(read_bytes(b"PF 100000 100000 -1.0 \0\0\0\0"), Err(ReadError::TooLarge { .. })));
    assert!(matches!(read_bytes(b"PF 4000000000 1 -1.0 \0\0\0\0"), Err(ReadError::TooLarge { .. })));
    assert!(matches!(read_bytes(b"PF 1000 1000 -1.0 \0\0\0\0"), Err(ReadError::Damaged { .. })));
}

fn crc32(bytes: &[u8]) -> u32 {
    let mut crc = flate2::Crc::new();
    crc.update(bytes);
    crc.sum()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1500, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_end_in_errors_or_pictures(
        format in 0..3_usize,
        cut in 0..=1000_usize,
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        in_header in any::<bool>(),
    ) {
        let whole = [exr_bytes(), png_bytes(), pfm_bytes()][format];
        let mut bytes = whole[..whole.len() * cut.max(1) / 1000].to_vec();
        for (at, value) in flips {
            let length = if in_header { bytes.len().min(600) } else { bytes.len() };
            if length > 0 {
                bytes[at.index(length)] = value;
            }
        }
        if let Ok(image) = read_bytes(&bytes) {
            for channel in &image.channels {
                let samples = match &channel.data {
                    ChannelData::F32(data) => data.len(),
                    ChannelData::U32(data) => data.len(),
                };
                prop_assert_eq!(samples, image.width as usize * image.height as usize);
            }
        }
    }
}

#[test]
fn write_and_read_through_the_file_system() {
    let folder = tempfile::tempdir().unwrap();
    for format in Format::ALL {
        let path = folder.path().join("picture").with_extension(format.ending());
        write_image(&path, format, &picture(), &metadata(), &linear_to_byte).unwrap();
        let image = read_image(&path, &Limits::default()).unwrap();
        assert_eq!((image.width, image.height), (37, 21));
    }
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 4, "nothing else is left behind");
    let text = folder.path().join("text.png");
    fs::write(&text, "no picture").unwrap();
    assert!(matches!(read_image(&text, &Limits::default()), Err(ReadError::UnknownFormat { .. })));
    assert!(matches!(read_image(&folder.path().join("none"), &Limits::default()), Err(ReadError::Io { .. })));
    assert!(matches!(read_image(folder.path(), &Limits::default()), Err(ReadError::Io { .. })));
    let small = Limits { file: 4, ..Limits::default() };
    assert!(matches!(read_image(&text, &small), Err(ReadError::TooLarge { .. })));
}

#[test]
fn a_failed_write_leaves_the_old_file_alone() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    fs::write(&path, "old").unwrap();
    let result = atomic::write(&path, |file| {
        file.write_all(b"half of the new")?;
        Err(EncodeError::NoColor)
    });
    assert!(matches!(result, Err(WriteError::Encode { .. })));
    let full = atomic::write(&path, |_| Err(std::io::Error::from(std::io::ErrorKind::StorageFull).into()));
    assert!(matches!(full, Err(WriteError::DiskFull { .. })));
    assert_eq!(fs::read(&path).unwrap(), b"old");
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn targets_that_cannot_be_written_are_told_beforehand() {
    let folder = tempfile::tempdir().unwrap();
    let missing = folder.path().join("no/such/a.png");
    assert!(matches!(atomic::check_writable(&missing), Err(WriteError::NoFolder { .. })));
    assert!(matches!(atomic::check_writable(folder.path()), Err(WriteError::NotRegular { .. })));
    let file = folder.path().join("file");
    fs::write(&file, "").unwrap();
    assert!(matches!(atomic::check_writable(&file.join("a.png")), Err(WriteError::NoFolder { .. })));
    let message = atomic::check_writable(&missing).unwrap_err().to_string();
    assert!(message.contains(&missing.display().to_string()), "{message}");
    let read_only = folder.path().join("read-only.png");
    fs::write(&read_only, "kept").unwrap();
    let mut permissions = fs::metadata(&read_only).unwrap().permissions();
    permissions.set_readonly(true);
    fs::set_permissions(&read_only, permissions).unwrap();
    assert!(matches!(atomic::check_writable(&read_only), Err(WriteError::NotWritable { .. })));
    atomic::check_writable(&folder.path().join("new.png")).unwrap();
    assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 2, "checks leave no trace");
}

#[cfg(unix)]
#[test]
fn links_and_permissions_are_kept() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let folder = tempfile::tempdir().unwrap();
    let write = |path: &Path| atomic::write(path, |file| Ok(file.write_all(b"new")?));
    let mode = |path: &Path| fs::metadata(path).unwrap().permissions().mode() & 0o777;

    let plain = folder.path().join("plain");
    fs::File::create(&plain).unwrap();
    let new = folder.path().join("new");
    write(&new).unwrap();
    assert_eq!(mode(&new), mode(&plain), "a new file has the mode of any new file");

    fs::set_permissions(&plain, fs::Permissions::from_mode(0o640)).unwrap();
    fs::create_dir(folder.path().join("links")).unwrap();
    let link = folder.path().join("links/a");
    symlink("../plain", &link).unwrap();
    write(&link).unwrap();
    assert!(fs::symlink_metadata(&link).unwrap().is_symlink());
    assert_eq!((fs::read(&plain).unwrap(), mode(&plain)), (b"new".to_vec(), 0o640));

    let dangling = folder.path().join("dangling");
    symlink("target", &dangling).unwrap();
    write(&dangling).unwrap();
    assert_eq!(fs::read(folder.path().join("target")).unwrap(), b"new");

    let round = folder.path().join("round");
    symlink("round", &round).unwrap();
    assert!(matches!(write(&round), Err(WriteError::Io { .. })));
    assert!(matches!(atomic::check_writable(Path::new("/dev/null")), Err(WriteError::NotRegular { .. })));
}

#[test]
fn whoever_reads_while_files_are_replaced_sees_whole_files() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.exr");
    let write = || write_image(&path, Format::Exr, &picture(), &metadata(), &linear_to_byte).unwrap();
    write();
    let done = std::sync::atomic::AtomicBool::new(false);
    std::thread::scope(|scope| {
        let reader = scope.spawn(|| {
            let mut reads = 0;
            while reads < 50 || !done.load(std::sync::atomic::Ordering::SeqCst) {
                assert_eq!(read_image(&path, &Limits::default()).unwrap(), picture());
                reads += 1;
            }
        });
        for _ in 0..30 {
            write();
        }
        done.store(true, std::sync::atomic::Ordering::SeqCst);
        reader.join().unwrap();
    });
}
