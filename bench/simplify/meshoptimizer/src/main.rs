//! Answers requests of one JSON object a line: `mesh` reads a binary PLY file of float positions and triangles; `tool`, `faces` and
//! `output` simplify it and write what comes out. The seconds are those of the library's call alone.

#![forbid(unsafe_code)]

use meshopt::{SimplifyOptions, VertexDataAdapter};
use serde_json::{Value, json};
use std::{
    fs,
    io::{self, BufRead, Write},
    time::Instant,
};

/// No error is too large: the number of faces alone decides.
const ANY_ERROR: f32 = 1e9;

#[derive(Default)]
struct Mesh {
    positions: Vec<[f32; 3]>,
    indices: Vec<u32>,
}

fn main() -> io::Result<()> {
    let mut mesh = Mesh::default();
    for line in io::stdin().lock().lines() {
        let answer = serde_json::from_str(&line?)
            .map_err(|e| e.to_string())
            .and_then(|request| answer(&request, &mut mesh))
            .unwrap_or_else(|error| json!({ "error": error }));
        let mut out = io::stdout().lock();
        writeln!(out, "{answer}")?;
        out.flush()?;
    }
    Ok(())
}

fn answer(request: &Value, mesh: &mut Mesh) -> Result<Value, String> {
    if let Some(path) = request["mesh"].as_str() {
        *mesh = read(path)?;
        return Ok(json!({ "faces": mesh.indices.len() / 3 }));
    }
    let wrong = || "expected mesh, or tool, faces and output".to_owned();
    let faces = request["faces"].as_u64().ok_or_else(wrong)? as usize;
    let output = request["output"].as_str().ok_or_else(wrong)?;
    let (seconds, simplified) = match request["tool"].as_str() {
        Some("meshoptimizer") => plain(mesh, faces)?,
        Some("meshoptimizer, positions updated") => updated(mesh, faces),
        _ => return Err(wrong()),
    };
    write(output, &simplified)?;
    Ok(json!({ "seconds": seconds, "faces": simplified.indices.len() / 3 }))
}

fn plain(mesh: &Mesh, faces: usize) -> Result<(f64, Mesh), String> {
    let bytes: Vec<u8> = mesh.positions.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    let adapter = VertexDataAdapter::new(&bytes, 12, 0).map_err(|e| e.to_string())?;
    let clock = Instant::now();
    let indices = meshopt::simplify(&mesh.indices, &adapter, 3 * faces, ANY_ERROR, SimplifyOptions::None, None);
    Ok((clock.elapsed().as_secs_f64(), Mesh { positions: mesh.positions.clone(), indices }))
}

fn updated(mesh: &Mesh, faces: usize) -> (f64, Mesh) {
    let (mut positions, mut indices) = (mesh.positions.clone(), mesh.indices.clone());
    let clock = Instant::now();
    let count = meshopt::simplify_with_update(
        &mut indices,
        &mut positions,
        &mut [],
        &[],
        0,
        None,
        3 * faces,
        ANY_ERROR,
        SimplifyOptions::None,
        None,
    );
    indices.truncate(count);
    (clock.elapsed().as_secs_f64(), Mesh { positions, indices })
}

fn read(path: &str) -> Result<Mesh, String> {
    let bytes = fs::read(path).map_err(|e| format!("{path}: {e}"))?;
    let end = b"end_header\n";
    let start = bytes.windows(end.len()).position(|w| w == end).ok_or("no PLY header")? + end.len();
    let header = String::from_utf8_lossy(&bytes[..start]);
    let count = |element: &str| {
        let line = header.lines().find_map(|line| line.strip_prefix(element)?.trim().parse::<usize>().ok());
        line.ok_or_else(|| format!("{path}: no {element}"))
    };
    let (vertices, faces) = (count("element vertex")?, count("element face")?);
    if bytes.len() != start + 12 * vertices + 13 * faces {
        return Err(format!("{path}: expected float positions and triangles alone"));
    }
    let (positions, triangles) = bytes[start..].split_at(12 * vertices);
    let word = |at: &[u8]| [at[0], at[1], at[2], at[3]];
    Ok(Mesh {
        positions: positions.chunks_exact(12).map(|p| [0, 4, 8].map(|i| f32::from_le_bytes(word(&p[i..])))).collect(),
        indices: triangles
            .chunks_exact(13)
            .flat_map(|t| [1, 5, 9].map(|i| u32::from_le_bytes(word(&t[i..]))))
            .collect(),
    })
}

/// Only the vertices that are used.
fn write(path: &str, mesh: &Mesh) -> Result<(), String> {
    let mut numbers = vec![u32::MAX; mesh.positions.len()];
    let mut used = Vec::new();
    for &i in &mesh.indices {
        if numbers[i as usize] == u32::MAX {
            numbers[i as usize] = used.len() as u32;
            used.push(i as usize);
        }
    }
    let mut bytes = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        used.len(),
        mesh.indices.len() / 3
    )
    .into_bytes();
    bytes.extend(used.iter().flat_map(|&i| mesh.positions[i]).flat_map(f32::to_le_bytes));
    for triangle in mesh.indices.chunks_exact(3) {
        bytes.push(3);
        bytes.extend(triangle.iter().flat_map(|&i| numbers[i as usize].to_le_bytes()));
    }
    fs::write(path, bytes).map_err(|e| format!("{path}: {e}"))
}
