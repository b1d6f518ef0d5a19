//! How much memory `etendue simplify` takes for each triangle of a large mesh: of a million, and at full size of 30 million.
#![allow(clippy::disallowed_methods, reason = "tests are not compared bit by bit")]
#![cfg(target_os = "linux")]

mod common;

use common::Folder;
use serde_json::Value;
use std::{
    f32::consts::TAU,
    fs::File,
    io::{BufWriter, Write},
    path::Path,
};

/// Bytes for each triangle of the input, of all that the program holds: itself, the mesh as it was, topology, quadrics, queues.
const WITHOUT_POLISH: f64 = 190.0;
const WITH_POLISH: f64 = 220.0;
/// What 30 million triangles may take without polish.
const MOST: u64 = 8 << 30;

/// Writes a bumpy torus of `2 * around * across` triangles as a binary PLY file.
fn write_torus(path: &Path, around: u32, across: u32) -> std::io::Result<()> {
    let mut file = BufWriter::with_capacity(1 << 20, File::create(path)?);
    let (vertices, faces) = (around * across, 2 * around * across);
    write!(
        file,
        "ply\nformat binary_little_endian 1.0\nelement vertex {vertices}\nproperty float x\nproperty float y\n\
         property float z\nelement face {faces}\nproperty list uchar int vertex_indices\nend_header\n"
    )?;
    for i in 0..around {
        let a = TAU * i as f32 / around as f32;
        for k in 0..across {
            let b = TAU * k as f32 / across as f32;
            let r = 0.4 + 0.03 * (9.0 * a).sin() * (5.0 * b).cos();
            let out = 1.0 + r * b.cos();
            for x in [out * a.cos(), out * a.sin(), r * b.sin()] {
                file.write_all(&x.to_le_bytes())?;
            }
        }
    }
    for i in 0..around {
        for k in 0..across {
            let at = |i: u32, k: u32| i % around * across + k % across;
            let [p, q, r, s] = [at(i, k), at(i + 1, k), at(i + 1, k + 1), at(i, k + 1)];
            for face in [[p, q, r], [p, r, s]] {
                file.write_all(&[3])?;
                for v in face {
                    file.write_all(&v.to_le_bytes())?;
                }
            }
        }
    }
    file.flush()
}

/// Simplifies a torus to a hundredth; what the program says of it, and the most bytes it had in memory.
fn simplified(folder: &Folder, [around, across]: [u32; 2], options: &str) -> (Value, u64) {
    let path = folder.path("torus.ply");
    if !path.exists() {
        write_torus(&path, around, across).unwrap();
    }
    let words = format!("simplify torus.ply -o small.ply --ratio 0.01 --require-target --json --quiet {options}");
    let json = folder.run(&words).with_code(0).json();
    let faces = u64::from(2 * around * across);
    assert_eq!((json["faces_in"].as_u64(), json["faces_out"].as_u64()), (Some(faces), Some(faces / 100)));
    let peak = json["peak_memory"].as_u64().unwrap();
    let seconds = ["load", "simplify", "polish", "write"].map(|part| json["seconds"][part].as_f64().unwrap());
    println!(
        "{faces} triangles {options}: {:.3} GiB, {:.1} bytes a triangle; load, simplify, polish, write: {seconds:.2?} s",
        peak as f64 / (1u64 << 30) as f64,
        peak as f64 / faces as f64
    );
    (json, peak)
}

#[test]
fn bytes_a_triangle() {
    let folder = Folder::new();
    for (options, most) in [("--no-polish", WITHOUT_POLISH), ("", WITH_POLISH)] {
        let (json, peak) = simplified(&folder, [1000, 500], options);
        let used = peak as f64 / json["faces_in"].as_f64().unwrap();
        assert!(used < most && used > 50.0, "{options}: {used} bytes a triangle");
    }
}

#[test]
fn thirty_million_triangles() {
    if std::env::var_os("ETENDUE_PROVE").is_none() {
        return;
    }
    let available = std::fs::read_to_string("/proc/meminfo").ok().and_then(|text| {
        let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
        line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()
    });
    assert!(available.is_none_or(|kib| kib << 10 > MOST + (1 << 30)), "too little memory is free: {available:?} KiB");
    let folder = Folder::new();
    let size = [6000, 2500];
    let (_, peak) = simplified(&folder, size, "--no-polish");
    assert!(peak < MOST, "{peak} bytes");
    let (_, polished) = simplified(&folder, size, "");
    assert!(polished < MOST * 3 / 2, "{polished} bytes with polish");
}
