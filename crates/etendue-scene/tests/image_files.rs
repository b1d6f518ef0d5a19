//! Pictures of every format that is read, whole and damaged.
//!
//! `tests/data/images` holds one picture many times: 16 x 12 pixels of [`texel`], grey ones its red, alpha in some.

use etendue::image::{Channel, ChannelData, Image};
use etendue_scene::{
    image_file::{Limits, RawImage, ReadError, Samples, decode_image, decode_texture, read_image, read_texture},
    output::{Metadata, exr},
};
use proptest::{prelude::*, test_runner::RngSeed};
use std::{io::Cursor, path::Path, sync::LazyLock};

const FOLDER: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/images");
const SIZE: (u32, u32) = (16, 12);

fn texel(x: u32, y: u32) -> [u8; 4] {
    [x * 17, y * 23, (x * 15 + y * 11) / 2, 255 - x * 16].map(|v| v as u8)
}

fn texture(name: &str) -> RawImage {
    let image = read_texture(&Path::new(FOLDER).join(name), &Limits::default()).unwrap();
    assert_eq!((image.width, image.height), SIZE, "{name}");
    assert_eq!(image.samples.len(), 192 * usize::from(image.channels), "{name}");
    image
}

/// The largest difference from the picture, in steps of 8 bits.
fn worst(image: &RawImage) -> f64 {
    let value = |i: usize| match &image.samples {
        Samples::U8(samples) => f64::from(samples[i]),
        Samples::U16(samples) => f64::from(samples[i]) / 257.0,
        Samples::F32(samples) => f64::from(samples[i]) * 255.0,
    };
    let channels = usize::from(image.channels);
    let mut worst = 0.0f64;
    for (pixel, (x, y)) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))).enumerate() {
        let expected = texel(x, y);
        for c in 0..channels {
            let wanted = if image.has_alpha() && c == channels - 1 { expected[3] } else { expected[c] };
            worst = worst.max((value(pixel * channels + c) - f64::from(wanted)).abs());
        }
    }
    worst
}

#[test]
fn every_format_gives_the_picture() {
    // Lossless formats give it exactly, the others nearly: a ramp is hard on halved chroma.
    for (name, channels, tolerance) in [
        ("colour.png", 3, 0.0),
        ("interlaced.png", 3, 0.0),
        ("alpha.png", 4, 0.0),
        ("grey.png", 1, 0.0),
        ("grey16.png", 1, 0.0),
        ("palette.png", 3, 0.0),
        ("colour.jpg", 3, 6.0),
        ("progressive-420.jpg", 3, 24.0),
        ("grey.jpg", 1, 4.0),
        ("cmyk.jpg", 3, 8.0),
        ("raw.tga", 3, 0.0),
        ("rle-alpha.tga", 4, 0.0),
        ("grey.tga", 1, 0.0),
        ("colour.bmp", 3, 0.0),
        ("palette.bmp", 3, 0.0),
        ("32-bit.bmp", 3, 0.0),
        ("lossless.webp", 3, 0.0),
        ("lossless-alpha.webp", 4, 0.0),
        ("lossy.webp", 3, 40.0),
    ] {
        let image = texture(name);
        assert_eq!(image.channels, channels, "{name}");
        assert!(image.encoded_srgb);
        let worst = worst(&image);
        assert!(worst <= tolerance, "{name}: {worst}");
    }
    assert!(matches!(texture("grey16.png").samples, Samples::U16(_)));
}

#[test]
fn formats_are_told_by_content() {
    for name in ["colour.png", "colour.jpg", "lossless.webp", "colour.bmp"] {
        let bytes = std::fs::read(Path::new(FOLDER).join(name)).unwrap();
        assert!(decode_texture(Path::new("x.tiff"), &bytes, &Limits::default()).is_ok(), "{name}");
    }
    let tga = std::fs::read(Path::new(FOLDER).join("raw.tga")).unwrap();
    let error = decode_texture(Path::new("x.png"), &tga, &Limits::default()).unwrap_err();
    assert!(matches!(error, ReadError::UnknownFormat { .. }) && error.to_string().contains("JPEG"), "{error}");
}

#[test]
fn textures_keep_samples_and_pictures_become_linear() {
    let path = Path::new(FOLDER).join("alpha.png");
    let (stored, image) = (texture("alpha.png"), read_image(&path, &Limits::default()).unwrap());
    let texture = stored.into_texture().unwrap();
    for (pixel, (x, y)) in (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))).enumerate() {
        let looked_up = texture.texel(x, y);
        let alpha = f32::from(texel(x, y)[3]) / 255.0;
        assert_eq!(looked_up[3], alpha);
        for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
            let v = f64::from(texel(x, y)[c]) / 255.0;
            let linear = if v <= 0.04045 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) };
            assert_eq!(looked_up[c], linear as f32);
            assert_eq!(image.f32_channel(name).unwrap()[pixel], linear as f32 * alpha);
        }
    }
}

fn hdr(header: &str, pixels: &[u8]) -> Result<RawImage, ReadError> {
    let bytes = [format!("#?RADIANCE\n{header}").as_bytes(), pixels].concat();
    decode_texture(Path::new("x"), &bytes, &Limits::default())
}

fn floats(image: &RawImage) -> &[f32] {
    let Samples::F32(samples) = &image.samples else { panic!("{image:?}") };
    samples
}

#[test]
fn radiance_pixels_by_hand() {
    // Mantissa times 2^(e - 136): 128 and 129 is 1, 255 and 255 the largest, exponent 0 nothing, 1 far below 1e-38.
    let pixels = [128, 64, 0, 129, 255, 0, 0, 255, 9, 9, 9, 0, 1, 2, 3, 1];
    let image = hdr("FORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 2\n", &pixels).unwrap();
    let two = |e: i32| libm::exp2(f64::from(e)) as f32;
    let tiny = [two(-135), 2.0 * two(-135), 3.0 * two(-135)];
    assert_eq!(floats(&image)[..9], [1.0, 0.5, 0.0, 255.0 * two(119), 0.0, 0.0, 0.0, 0.0, 0.0]);
    assert_eq!(floats(&image)[9..], tiny);
    assert!(!image.encoded_srgb && tiny[0] > 0.0);
}

#[test]
fn radiance_run_lengths() {
    let row = |bytes: &[u8]| hdr("\n-Y 1 +X 10\n", bytes).map(|image| floats(&image).to_vec());
    let expected: Vec<f32> = (0..10).flat_map(|x| [if x < 7 { 1.0 } else { 0.25 * x as f32 }, 0.5, 0.0]).collect();
    // The newer: channel by channel, a run of 7 and three bytes as they are.
    let newer = [2, 2, 0, 10, 135, 128, 3, 224, 0, 32, 138, 64, 138, 0, 137, 129, 1, 129];
    let mut wanted = expected.clone();
    for (x, red) in [(7, 224.0 / 128.0), (8, 0.0), (9, 0.25)] {
        wanted[3 * x] = red;
    }
    assert_eq!(row(&newer).unwrap(), wanted);
    // The older: a pixel, then the same again 1 + 5 times, then four as they are.
    let mut older = vec![128, 64, 0, 129, 1, 1, 1, 6];
    for red in [224, 0, 32] {
        older.extend([red, 64, 0, 129]);
    }
    assert_eq!(row(&older).unwrap(), wanted);
    // Long runs: the second count is times 256.
    let long = hdr("\n-Y 1 +X 600\n", &[128, 64, 0, 129, 1, 1, 1, 87, 1, 1, 1, 2]).unwrap();
    assert!(floats(&long).chunks_exact(3).all(|p| p == [1.0, 0.5, 0.0]));
    for (bytes, what) in [
        (&[2, 2, 0, 11, 0][..], "another length"),
        (&[2, 2, 0, 10, 139, 1], "does not fit"),
        (&[2, 2, 0, 10, 0, 1], "does not fit"),
        (&[2, 2, 0, 10, 4, 1], "the pixels end in row 0 of 1"),
        (&[1, 1, 1, 3], "repeats nothing"),
        (&[1, 2, 3, 4, 1, 1, 1, 10], "does not fit"),
        (&[1, 2, 3, 4], "the pixels end"),
    ] {
        let error = row(bytes).unwrap_err().to_string();
        assert!(error.contains(what) && error.contains("HDR"), "{bytes:?}: {error}");
    }
}

#[test]
fn radiance_headers_and_orientations() {
    // Two rows of three pixels, which are 1, 2, 4 and 8, 16, 32 in the file.
    let pixels: Vec<u8> = (0..6).flat_map(|i| [128, 128, 128, 129 + i]).collect();
    for (size, expected) in [
        ("-Y 2 +X 3", [1, 2, 4, 8, 16, 32]),
        ("+Y 2 +X 3", [8, 16, 32, 1, 2, 4]),
        ("-Y 2 -X 3", [4, 2, 1, 32, 16, 8]),
        ("+Y 2 -X 3", [32, 16, 8, 4, 2, 1]),
        ("+X 2 -Y 3", [1, 8, 2, 16, 4, 32]),
        ("+X 2 +Y 3", [4, 32, 2, 16, 1, 8]),
        ("-X 2 -Y 3", [8, 1, 16, 2, 32, 4]),
        ("-X 2 +Y 3", [32, 4, 16, 2, 8, 1]),
    ] {
        let image = hdr(&format!("# comment\nEXPOSURE=2\n\n{size}\n"), &pixels).unwrap();
        let found: Vec<f32> = floats(&image).chunks_exact(3).map(|p| p[0]).collect();
        assert_eq!(found, expected.map(|v: u8| f32::from(v)), "{size}");
        assert_eq!((image.width, image.height), if size.contains("Y 2") { (3, 2) } else { (2, 3) });
    }
    for (header, what) in [
        ("FORMAT=32-bit_rle_xyze\n\n-Y 2 +X 3\n", "xyze"),
        ("\n-Y 2 +Y 3\n", "size"),
        ("\n-Y 0 +X 3\n", "size"),
        ("\nsize 2 3\n", "size"),
        ("\n-Y 2", "header does not end"),
        ("FORMAT=32-bit_rle_rgbe\n", "header does not end"),
        ("\n-Y 15000 +X 15000\n", "cannot be in so small a file"),
        ("\n-Y 4000000000 +X 4000000000\n", "too large"),
    ] {
        let error = hdr(header, &pixels).unwrap_err().to_string();
        assert!(error.contains(what), "{header}: {error}");
    }
}

fn exr_of(channels: &[(&str, [f32; 2])]) -> Vec<u8> {
    let channels = channels
        .iter()
        .map(|(name, data)| Channel { name: (*name).to_owned(), data: ChannelData::F32(data.to_vec()) })
        .collect();
    let mut bytes = Cursor::new(Vec::new());
    exr::write(&mut bytes, &Image { width: 2, height: 1, channels }, &Metadata::default()).unwrap();
    bytes.into_inner()
}

#[test]
fn openexr_textures_take_the_colour() {
    let of = |channels: &[(&str, [f32; 2])]| decode_texture(Path::new("x"), &exr_of(channels), &Limits::default());
    let rgb = [("R", [1.0, 2.0]), ("G", [3.0, 4.0]), ("B", [5.0, 6.0]), ("Depth.Z", [7.0, 8.0])];
    assert_eq!(floats(&of(&rgb).unwrap()), [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
    // Premultiplied alpha is made straight; light without cover stays.
    let rgba = [("R", [1.0, 2.0]), ("G", [3.0, 4.0]), ("B", [5.0, 6.0]), ("A", [0.5, 0.0])];
    assert_eq!(floats(&of(&rgba).unwrap()), [2.0, 6.0, 10.0, 0.5, 2.0, 4.0, 6.0, 0.0]);
    let grey = of(&[("Y", [1.0, 2.0]), ("A", [1.0, 1.0])]).unwrap();
    assert_eq!((grey.channels, floats(&grey)), (2, &[1.0, 1.0, 2.0, 1.0][..]));
    let layer = [("a.Z", [0.0; 2]), ("b.view.R", [1.0, 2.0]), ("b.view.G", [3.0, 4.0]), ("b.view.B", [5.0, 6.0])];
    assert_eq!(floats(&of(&layer).unwrap()), [1.0, 3.0, 5.0, 2.0, 4.0, 6.0]);
    assert_eq!(floats(&of(&[("Height", [1.0, 2.0])]).unwrap()), [1.0, 2.0]);
    let error = of(&[("N.X", [1.0, 2.0]), ("N.Y", [1.0, 2.0])]).unwrap_err().to_string();
    assert!(error.contains("no channels R, G, B, nor Y"), "{error}");
    let infinite = of(&[("Y", [1.0, f32::INFINITY])]).unwrap().into_texture().unwrap_err();
    assert_eq!(infinite.to_string(), "texel 1, 0 is not finite");
}

/// A file of each kind, with its name.
static SEEDS: LazyLock<Vec<(String, Vec<u8>)>> = LazyLock::new(|| {
    let entries = std::fs::read_dir(FOLDER).unwrap().map(|entry| entry.unwrap().path());
    let name = |path: &Path| path.file_name().unwrap().to_string_lossy().into_owned();
    let mut seeds: Vec<_> = entries.map(|path| (name(&path), std::fs::read(&path).unwrap())).collect();
    seeds.sort();
    let pixels: Vec<u8> = (0..4u8).flat_map(|c| [2, 2, 0, 10, 135, c, 3, 1, 2, 3].repeat(4)).collect();
    seeds.push(("a.hdr".to_owned(), [b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 2 +X 10\n", &pixels[..]].concat()));
    seeds.push(("a.exr".to_owned(), exr_of(&[("R", [1.0, 2.0]), ("G", [3.0, 4.0]), ("B", [5.0, 6.0])])));
    seeds.push(("a.pfm".to_owned(), [b"PF\n2 2\n-1.0\n", &[0x3f; 48][..]].concat()));
    seeds
});

fn read(name: &str, bytes: &[u8]) {
    let limits = Limits { decoded: 16 << 20, ..Limits::default() };
    if let Ok(image) = decode_texture(Path::new(name), bytes, &limits) {
        let pixels = image.width as usize * image.height as usize;
        assert_eq!(image.samples.len(), pixels * usize::from(image.channels));
        assert!((1..=4).contains(&image.channels));
        let _ = image.into_texture();
    }
    if let Ok(image) = decode_image(Path::new(name), bytes, &limits) {
        let pixels = image.width as usize * image.height as usize;
        for channel in &image.channels {
            assert!(image.f32_channel(&channel.name).is_none_or(|data| data.len() == pixels));
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 4000, rng_seed: RngSeed::Fixed(6), failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_end_in_errors_or_pictures(
        seed in any::<prop::sample::Index>(),
        end in prop_oneof![Just(None), any::<prop::sample::Index>().prop_map(Some)],
        flips in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        in_header in any::<bool>(),
    ) {
        let (name, whole) = &SEEDS[seed.index(SEEDS.len())];
        let mut bytes = whole.clone();
        for (at, value) in flips {
            let at = at.index(if in_header { bytes.len().min(64) } else { bytes.len() });
            bytes[at] = value;
        }
        if let Some(end) = end {
            bytes.truncate(end.index(bytes.len() + 1));
        }
        read(name, &bytes);
    }
}

#[test]
fn every_truncation_is_an_error_or_a_picture() {
    for (name, whole) in SEEDS.iter() {
        for end in 0..whole.len().min(500) {
            read(name, &whole[..end]);
        }
        // A picture that stops in its middle is damaged, whatever the format.
        let half = decode_texture(Path::new(name), &whole[..whole.len() / 2], &Limits::default());
        assert!(half.is_err(), "{name}");
        let message = half.unwrap_err().to_string();
        assert!(message.contains(name.as_str()), "{message}");
    }
}
