//! Binary little-endian PLY.

use super::{is_single, position};
use crate::{output::EncodeError, vertex_colors::encode};
use etendue::scene::Mesh;
use std::io::Write;

pub(super) fn write(out: &mut impl Write, mesh: &Mesh) -> Result<(), EncodeError> {
    let single = is_single(mesh);
    let scalar = if single { "float" } else { "double" };
    writeln!(out, "ply\nformat binary_little_endian 1.0\ncomment Etendue")?;
    writeln!(out, "element vertex {}", mesh.positions.len())?;
    ["x", "y", "z"].iter().try_for_each(|axis| writeln!(out, "property {scalar} {axis}"))?;
    let names: &[&str] = match (&mesh.normals, &mesh.uvs) {
        (Some(_), Some(_)) => &["nx", "ny", "nz", "u", "v"],
        (Some(_), None) => &["nx", "ny", "nz"],
        (None, Some(_)) => &["u", "v"],
        (None, None) => &[],
    };
    names.iter().try_for_each(|name| writeln!(out, "property float {name}"))?;
    let colors: Option<Vec<[f64; 4]>> = mesh.colors.as_ref().map(|colors| colors.iter().map(|c| encode(*c)).collect());
    let are_bytes = colors.iter().flatten().flatten().all(|steps| steps.fract() == 0.0);
    if colors.is_some() {
        let scalar = if are_bytes { "uchar" } else { "float" };
        ["red", "green", "blue", "alpha"].iter().try_for_each(|name| writeln!(out, "property {scalar} {name}"))?;
    }
    writeln!(out, "element face {}\nproperty list uchar uint vertex_indices\nend_header", mesh.indices.len())?;
    for vertex in 0..mesh.positions.len() {
        if single {
            write_all(out, &mesh.positions[vertex])?;
        } else {
            for coordinate in position(mesh, vertex).to_array() {
                out.write_all(&coordinate.to_le_bytes())?;
            }
        }
        mesh.normals.iter().try_for_each(|normals| write_all(out, &normals[vertex]))?;
        mesh.uvs.iter().try_for_each(|uvs| write_all(out, &uvs[vertex]))?;
        match colors.as_ref().map(|colors| colors[vertex]) {
            Some(steps) if are_bytes => out.write_all(&steps.map(|steps| steps as u8))?,
            Some(steps) => write_all(out, &steps.map(|steps| (steps / 255.0) as f32))?,
            None => {}
        }
    }
    for face in mesh.indices.iter() {
        out.write_all(&[3])?;
        face.iter().try_for_each(|vertex| out.write_all(&vertex.to_le_bytes()))?;
    }
    Ok(())
}

fn write_all(out: &mut impl Write, numbers: &[f32]) -> std::io::Result<()> {
    numbers.iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))
}
