//! Makes gallery/inputs/cloud.npy: a small heap of cloud, 64 x 40 x 48 bytes of density, indexed `a[x, y, z]`, y up.
//!
//!     cargo run -p etendue-scene --example make_cloud -- gallery/inputs/cloud.npy

use glam::{DVec3, dvec3};
use std::{fs, path::PathBuf, process::ExitCode};

const SIZE: [u32; 3] = [64, 40, 48];
/// Puffs: middles and radii, in a box of 1.6 x 1 x 1.2.
const PUFFS: [([f64; 3], f64); 8] = [
    ([0.45, 0.34, 0.60], 0.28),
    ([0.80, 0.42, 0.55], 0.36),
    ([1.15, 0.34, 0.62], 0.27),
    ([0.62, 0.60, 0.66], 0.24),
    ([0.92, 0.66, 0.52], 0.24),
    ([0.70, 0.30, 0.40], 0.25),
    ([1.00, 0.30, 0.80], 0.24),
    ([1.32, 0.28, 0.55], 0.16),
];

/// A number in [0, 1) for a corner of the lattice.
fn hash(x: i64, y: i64, z: i64) -> f64 {
    let mut h = (x as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15)
        ^ (y as u64).wrapping_mul(0xc2b2_ae3d_27d4_eb4f)
        ^ (z as u64).wrapping_mul(0x1656_67b1_9e37_79f9);
    h = (h ^ (h >> 29)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    h = (h ^ (h >> 32)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (h >> 11) as f64 / (1u64 << 53) as f64
}

/// Smooth noise in [0, 1).
fn noise(p: DVec3) -> f64 {
    let cell = p.floor();
    let f = p - cell;
    let s = f * f * (DVec3::splat(3.0) - 2.0 * f);
    let [x, y, z] = cell.to_array().map(|c| c as i64);
    let mix = |a: f64, b: f64, t: f64| a + (b - a) * t;
    let row = |y, z| mix(hash(x, y, z), hash(x + 1, y, z), s.x);
    let slice = |z| mix(row(y, z), row(y + 1, z), s.y);
    mix(slice(z), slice(z + 1), s.z)
}

/// Noise of several sizes, in [0, 1).
fn billows(p: DVec3) -> f64 {
    let octave = |k: i32| noise(p * f64::from(1 << k) + DVec3::splat(7.3 * f64::from(k))) / f64::from(1 << k);
    (0..5).map(octave).sum::<f64>() / 1.9375
}

fn density(p: DVec3) -> f64 {
    // How deep inside of a puff, in its radius; the underside is flat.
    let depth = |(middle, radius): ([f64; 3], f64)| 1.0 - (p - DVec3::from_array(middle)).length() / radius;
    let inside = PUFFS.into_iter().map(depth).fold(-1.0, f64::max).min((p.y - 0.14) * 6.0);
    let eroded = inside + 1.1 * (billows(p * 5.0) - 0.5);
    (eroded * 3.0).clamp(0.0, 1.0)
}

fn npy() -> Vec<u8> {
    let [nx, ny, nz] = SIZE;
    let dictionary = format!("{{'descr': '|u1', 'fortran_order': False, 'shape': ({nx}, {ny}, {nz}), }}");
    // The samples begin at a multiple of 64.
    let header = format!("{dictionary:<117}\n");
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((header.len() as u16).to_le_bytes());
    bytes.extend(header.as_bytes());
    for x in 0..nx {
        for y in 0..ny {
            for z in 0..nz {
                let p = dvec3(f64::from(x), f64::from(y), f64::from(z)) + 0.5;
                bytes.push((density(p / 40.0) * 255.0 + 0.5) as u8);
            }
        }
    }
    bytes
}

fn main() -> ExitCode {
    let Some(path) = std::env::args_os().nth(1).map(PathBuf::from) else {
        eprintln!("usage: make_cloud FILE.npy");
        return ExitCode::from(2);
    };
    match fs::write(&path, npy()) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("cannot write {}: {error}", path.display());
            ExitCode::FAILURE
        }
    }
}
