//! Reads mesh files and prints, for each, one JSON object: seconds, bytes of the file, bytes of the mesh in memory, the most
//! memory that the program has taken so far (where /proc tells), and how many of what is in it; or what is wrong, in one line each.
//!
//!     cargo run --release -p etendue-scene --example read_mesh -- FILE...

use etendue_scene::{
    SourceMap,
    mesh_file::{self, MeshFile, MeshLimits},
};
use std::{path::Path, process::ExitCode, time::Instant};

/// Bytes of the mesh's arrays.
fn memory(file: &MeshFile) -> usize {
    let mesh = &file.mesh;
    let normals = mesh.normals.as_deref().map_or(0, size_of_val);
    let uvs = mesh.uvs.as_deref().map_or(0, size_of_val);
    let colors = mesh.colors.as_deref().map_or(0, size_of_val);
    let materials = mesh.face_materials.as_deref().map_or(0, size_of_val);
    size_of_val(&*mesh.positions) + size_of_val(&*mesh.indices) + normals + uvs + colors + materials
}

/// The most memory of this process, bytes.
fn peak_memory() -> Option<u64> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"))?;
    line.trim().strip_suffix(" kB")?.trim().parse::<u64>().ok().map(|kilobytes| kilobytes * 1024)
}

fn read(path: &Path) -> bool {
    let start = Instant::now();
    let limits = MeshLimits::default();
    let mut sources = SourceMap::new();
    let id = match mesh_file::open(&mut sources, path, &limits) {
        Ok(id) => id,
        Err(error) => {
            eprintln!("error: {error}");
            return false;
        }
    };
    let result = mesh_file::read(&mut sources, id, &limits);
    let seconds = start.elapsed().as_secs_f64();
    let found = match &result {
        Ok(file) => &file.notes,
        Err(found) => found,
    };
    for diagnostic in found {
        eprintln!("{}", diagnostic.one_line(&sources));
    }
    let Ok(file) = result else { return false };
    println!(
        "{{\"seconds\": {seconds:.6}, \"file_bytes\": {}, \"mesh_bytes\": {}, \"vertices\": {}, \"triangles\": {}, \
         \"spheres\": {}, \"materials\": {}, \"peak_bytes\": {}}}",
        sources.length(id),
        memory(&file),
        file.mesh.positions.len(),
        file.mesh.indices.len(),
        file.spheres.len(),
        file.materials.len(),
        peak_memory().map_or("null".to_owned(), |bytes| bytes.to_string()),
    );
    true
}

fn main() -> ExitCode {
    let paths: Vec<_> = std::env::args_os().skip(1).collect();
    if paths.is_empty() {
        eprintln!("which mesh files?");
        return ExitCode::from(2);
    }
    let bad = paths.iter().filter(|path| !read(Path::new(path))).count();
    if bad == 0 { ExitCode::SUCCESS } else { ExitCode::from(2) }
}
