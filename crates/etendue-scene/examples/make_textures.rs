//! Makes the images of scenes/still-life.toml: glazed tiles with their heights, a leaf with a cut-out outline, and a sky with
//! a small sun.
//!
//!     cargo run -p etendue-scene --example make_textures -- scenes

use etendue::image::{Channel, ChannelData, Image};
use etendue_scene::output::{Format, Metadata, write_image};
use std::{path::PathBuf, process::ExitCode};

const SIDE: u32 = 128;
const SKY: [u32; 2] = [128, 64];
/// Tiles along a side of the image.
const TILES: f64 = 4.0;

/// Channels from a function of texture coordinates, v up.
fn image<const N: usize>(size: [u32; 2], names: [&str; N], at: impl Fn(f64, f64) -> [f64; N]) -> Image {
    let [width, height] = size.map(f64::from);
    let pixels = (0..size[1]).flat_map(|y| (0..size[0]).map(move |x| (f64::from(x) + 0.5, f64::from(y) + 0.5)));
    let values: Vec<[f64; N]> = pixels.map(|(x, y)| at(x / width, 1.0 - y / height)).collect();
    let plane = |i: usize| ChannelData::F32(values.iter().map(|v| v[i] as f32).collect());
    let channel = |(i, name): (usize, &&str)| Channel { name: (*name).to_owned(), data: plane(i) };
    Image { width: size[0], height: size[1], channels: names.iter().enumerate().map(channel).collect() }
}

/// How far a point is inside of its tile, 0 at the joint and 1 at the middle, and the tile's number.
fn tile(u: f64, v: f64) -> (f64, [i64; 2]) {
    let (x, y) = (u * TILES, v * TILES);
    let inside = |x: f64| 1.0 - 2.0 * (x - x.floor() - 0.5).abs();
    (inside(x).min(inside(y)), [x.floor() as i64, y.floor() as i64])
}

fn tile_colour(u: f64, v: f64) -> [f64; 3] {
    let (inside, [x, y]) = tile(u, v);
    if inside < 0.06 {
        return [0.32, 0.3, 0.27];
    }
    // A little different from tile to tile.
    let shade = 0.85 + 0.15 * libm::sin((x * 7 + y * 13) as f64);
    let glaze = if (x + y) % 2 == 0 { [0.75, 0.72, 0.62] } else { [0.05, 0.16, 0.34] };
    glaze.map(|c| c * shade)
}

/// Joints lie at 0, tiles are rounded towards them.
fn tile_height(u: f64, v: f64) -> [f64; 3] {
    let t = (tile(u, v).0 / 0.12).min(1.0);
    [t * t * (3.0 - 2.0 * t); 3]
}

/// A leaf with its stem at the bottom: colour multiplied by opacity, and opacity.
fn leaf(u: f64, v: f64) -> [f64; 4] {
    let x = (u - 0.5).abs();
    let width = 0.42 * libm::sin(std::f64::consts::PI * v.clamp(0.0, 1.0)) * (1.1 - 0.5 * v);
    let serrated = width * (0.93 + 0.07 * libm::cos(60.0 * v));
    if x > serrated && !(v < 0.12 && x < 0.012) {
        return [0.0; 4];
    }
    let vein = x < 0.010 || ((v - 0.55 * x) * 9.0).rem_euclid(1.0) < 0.08;
    let [r, g, b] = if vein { [0.35, 0.45, 0.12] } else { [0.10 + 0.12 * v, 0.30, 0.04] };
    [r, g, b, 1.0]
}

/// Linear radiance: blue above, hazy at the horizon, brown below, with a sun of about four degrees.
fn sky(u: f64, v: f64) -> [f64; 3] {
    let (longitude, latitude) = ((u - 0.5) * 360.0, (v - 0.5) * 180.0);
    let mix = |a: [f64; 3], b: [f64; 3], t: f64| [0, 1, 2].map(|i| a[i] + (b[i] - a[i]) * t);
    let height = (latitude / 90.0).abs();
    let base = if latitude < 0.0 {
        mix([0.5, 0.45, 0.4], [0.2, 0.17, 0.14], height)
    } else {
        mix([0.9, 0.92, 0.95], [0.16, 0.32, 0.75], libm::sqrt(height))
    };
    let off = libm::hypot((longitude + 40.0) * libm::cos(latitude.to_radians()), latitude - 42.0);
    if off < 2.5 { [900.0, 780.0, 600.0] } else { base }
}

fn main() -> ExitCode {
    let Some(folder) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: make_textures FOLDER");
        return ExitCode::from(1);
    };
    let side = [SIDE; 2];
    let encode = |rgb: [f32; 3]| rgb.map(etendue::tonemap::to_srgb8);
    // Heights are data: stored as they are.
    let keep = |rgb: [f32; 3]| rgb.map(|v| (v * 255.0 + 0.5) as u8);
    let files = [
        ("tiles.png", Format::Png, image(side, ["R", "G", "B"], tile_colour), &encode as &(dyn Fn(_) -> _ + Sync)),
        ("tiles-height.png", Format::Png, image(side, ["R", "G", "B"], tile_height), &keep),
        ("leaf.png", Format::Png, image(side, ["R", "G", "B", "A"], leaf), &encode),
        ("sky.hdr", Format::Hdr, image(SKY, ["R", "G", "B"], sky), &encode),
    ];
    let metadata = Metadata { software: "Etendue, examples/make_textures.rs".to_owned(), ..Metadata::default() };
    for (name, format, image, encode) in files {
        if let Err(error) = write_image(&folder.join(name), format, &image, &metadata, encode) {
            eprintln!("{error}");
            return ExitCode::from(4);
        }
    }
    ExitCode::SUCCESS
}
