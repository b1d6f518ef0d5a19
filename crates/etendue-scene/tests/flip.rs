//! FLIP agrees with the program of its authors (flip-evaluator 1.7, PyPI, on the processor) on pictures made here.

use etendue::image::{Channel, ChannelData, Image};
use etendue_scene::output::metric::{CompareError, Metric, compare};

const SIZE: (u32, u32) = (96, 64);

fn hash(x: u32) -> u32 {
    let mix = |x: u32| (x ^ (x >> 16)).wrapping_mul(0x045d_9f3b);
    let x = mix(mix(x));
    x ^ (x >> 16)
}

/// Ramps in a checkerboard; the second picture has noise, a red spot and a darker side.
fn level(x: u32, y: u32, c: u32, second: bool) -> u8 {
    let mut v = ((x * (c + 1) + y * (3 - c)) % 192 + 32) as i32;
    if (x / 12 + y / 16) % 2 == 1 {
        v = 255 - v;
    }
    if second {
        v += (hash((y * SIZE.0 + x) * 3 + c) % 41) as i32 - 20;
        if (40..44).contains(&x) && (20..24).contains(&y) {
            v = if c == 0 { 255 } else { 0 };
        }
        if x >= 72 {
            v = (v * 3).div_euclid(4);
        }
    }
    v.clamp(0, 255) as u8
}

fn linear(v: u8) -> f32 {
    let v = f64::from(v) / 255.0;
    (if v <= 0.04045 { v / 12.92 } else { libm::pow((v + 0.055) / 1.055, 2.4) }) as f32
}

/// The second picture, with lights, as linear values.
fn bright(x: u32, y: u32, c: u32, second: bool) -> f32 {
    let light = (10..13).contains(&x) && (30..33).contains(&y);
    let green = second && c == 1 && (80..82).contains(&x) && (50..52).contains(&y);
    let v = f32::from(level(x, y, c, second)) / 255.0;
    match (green, light) {
        (true, _) => 900.0,
        (_, true) => 200.0,
        _ => v * v * 4.0,
    }
}

fn image(value: impl Fn(u32, u32, u32) -> f32) -> Image {
    let plane =
        |c: u32| (0..SIZE.1).flat_map(|y| (0..SIZE.0).map(move |x| (x, y))).map(|(x, y)| value(x, y, c)).collect();
    let channels = ["R", "G", "B"].into_iter().zip(0..);
    let channels = channels.map(|(name, c)| Channel { name: name.to_owned(), data: ChannelData::F32(plane(c)) });
    Image { width: SIZE.0, height: SIZE.1, channels: channels.collect() }
}

fn displayed(second: bool) -> Image {
    image(|x, y, c| linear(level(x, y, c, second)))
}

fn of_any_range(second: bool) -> Image {
    image(|x, y, c| bright(x, y, c, second))
}

const PLACES: [(u32, u32); 8] = [(0, 0), (5, 5), (41, 21), (47, 31), (80, 10), (95, 63), (81, 51), (11, 31)];

fn check(metric: Metric, test: &Image, reference: &Image, mean: f64, pixels: [f64; 8]) {
    let found = compare(test, reference, metric).unwrap();
    // The other program works in 32 bits.
    assert!((found.mean - mean).abs() < 2e-5, "{metric}: {} where {mean} was expected", found.mean);
    for ((x, y), expected) in PLACES.into_iter().zip(pixels) {
        let error = found.pixels[(y * SIZE.0 + x) as usize];
        assert!((error - expected).abs() < 2e-4, "{metric} at {x}, {y}: {error} where {expected} was expected");
    }
}

#[test]
fn displayed_pictures() {
    let pixels = [
        0.096_848_56,
        0.077_714_79,
        0.864_550_41,
        0.112_042_87,
        0.789_590_78,
        0.521_362_84,
        0.534_020_66,
        0.181_301_01,
    ];
    check(Metric::Flip, &displayed(true), &displayed(false), 0.231_517_73, pixels);
}

#[test]
fn pictures_of_high_dynamic_range() {
    let pixels = [
        0.208_861_13,
        0.162_038_53,
        0.978_052_02,
        0.127_113_83,
        0.633_494_68,
        0.507_740_91,
        0.974_702_60,
        0.042_060_95,
    ];
    check(Metric::HdrFlip, &of_any_range(true), &of_any_range(false), 0.246_924_06, pixels);
}

#[test]
fn ends_of_the_scale() {
    let (a, b) = (displayed(false), displayed(true));
    for metric in [Metric::Flip, Metric::HdrFlip] {
        let same = compare(&a, &a, metric).unwrap();
        assert_eq!((same.mean, same.max), (0.0, 0.0));
        let found = compare(&a, &b, metric).unwrap();
        assert!(found.pixels.iter().all(|e| (0.0..=1.0).contains(e)) && found.max <= 1.0);
        assert_eq!(found.pixels[(found.max_at[1] * SIZE.0 + found.max_at[0]) as usize], found.max);
    }
    // The same the other way round; and a picture smaller than the filters.
    assert_eq!(compare(&a, &b, Metric::Flip).unwrap().mean, compare(&b, &a, Metric::Flip).unwrap().mean);
    let one = |v: f32| Image {
        width: 1,
        height: 1,
        channels: ["R", "G", "B"].map(|n| Channel { name: n.to_owned(), data: ChannelData::F32(vec![v]) }).to_vec(),
    };
    let black_and_white = compare(&one(0.0), &one(1.0), Metric::Flip).unwrap().mean;
    assert!((black_and_white - 0.967_388).abs() < 1e-5, "{black_and_white}");
    // No light at all has no exposure.
    assert_eq!(compare(&one(0.0), &one(0.0), Metric::HdrFlip).unwrap().mean, 0.0);
}

#[test]
fn pixels_that_are_not_finite_are_left_out_and_spread_nothing() {
    let (mut a, mut b) = (displayed(false), displayed(false));
    let ChannelData::F32(red) = &mut a.channels[0].data else { panic!() };
    red[3000] = f32::NAN;
    let found = compare(&a, &b, Metric::Flip).unwrap();
    assert_eq!((found.nonfinite, found.pixels.iter().filter(|e| e.is_nan()).count()), (1, 1));
    // Only what the eye blurs with that pixel differs.
    let reached = found.pixels.iter().enumerate().filter(|(i, e)| **e > 1e-3 && i.abs_diff(3000) > 96 * 21);
    assert_eq!(reached.count(), 0);
    b.channels.truncate(2);
    a.channels.truncate(2);
    assert_eq!(compare(&a, &b, Metric::HdrFlip).unwrap_err(), CompareError::NoColor);
}
