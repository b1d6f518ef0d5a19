//! Prints how far two models are from each other, as one JSON object: `mesh_distance A B SAMPLES`.

use etendue_scene::{
    SourceMap,
    mesh_file::{self, MeshLimits},
    simplify::borrowed,
};
use etendue_simplify::distance;
use std::{error::Error, ops::ControlFlow, path::Path};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [a, b, samples] = &arguments[..] else { return Err("usage: mesh_distance A B SAMPLES".into()) };
    let (a, b) = (read(a)?, read(b)?);
    if a.origin != b.origin {
        return Err("the models are too far from their files' origin, and from each other".into());
    }
    let measured = distance(&borrowed(&a), &borrowed(&b), samples.parse()?, 0, &mut |_| ControlFlow::Continue(()))?;
    let way = |way: &etendue_simplify::OneWay| serde_json::json!({ "rms": way.rms, "largest": way.largest });
    println!(
        "{}",
        serde_json::json!({
            "diagonal": measured.diagonal,
            "rms": measured.rms(),
            "largest": measured.largest(),
            "forth": way(&measured.forth),
            "back": way(&measured.back),
            "faces": [a.indices.len(), b.indices.len()],
        })
    );
    Ok(())
}

fn read(path: &str) -> Result<etendue::scene::Mesh, Box<dyn Error>> {
    let mut sources = SourceMap::new();
    let limits = MeshLimits::default();
    let file = mesh_file::open(&mut sources, Path::new(path), &limits)?;
    let read = mesh_file::read(&mut sources, file, &limits);
    read.map(|file| file.mesh).map_err(|found| {
        let lines: Vec<String> = found.iter().map(|d| d.one_line(&sources)).collect();
        lines.join("\n").into()
    })
}
