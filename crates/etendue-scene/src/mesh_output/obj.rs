//! Wavefront OBJ.

use super::{is_single, mtl, position};
use crate::{
    mesh_file::{Group, MeshFile},
    output::EncodeError,
    vertex_colors::encode,
    weld::Welder,
};
use etendue::scene::Mesh;
use std::{io::Write, path::Path};

/// Vertices that differ in normal or texture coordinates alone share their position, so that other programs see a closed
/// surface closed. Numbers are the shortest that give the same number back.
pub(super) fn write(out: &mut impl Write, path: &Path, file: &MeshFile) -> Result<(), EncodeError> {
    writeln!(out, "# Etendue")?;
    if !file.materials.is_empty() {
        let library = path.with_extension("mtl");
        writeln!(out, "mtllib {}", library.file_name().unwrap_or_default().to_string_lossy())?;
    }
    let names = mtl::names(&file.materials);
    let numbers = vertices(out, &file.mesh)?;
    faces(out, file, &names, &numbers)?;
    for sphere in &file.spheres {
        if let Some(name) = names.get(sphere.material as usize) {
            writeln!(out, "usemtl {name}")?;
        }
        let [x, y, z] = sphere.center.to_array();
        writeln!(out, "sphere {x} {y} {z} {}", sphere.radius)?;
    }
    Ok(())
}

/// The number of each vertex's position.
fn position_numbers(mesh: &Mesh) -> Vec<u32> {
    let own = || (0..mesh.positions.len() as u32).collect();
    if mesh.normals.is_none() && mesh.uvs.is_none() && mesh.colors.is_none() {
        return own();
    }
    let mut welder = Welder::default();
    let numbers: Option<Vec<u32>> = (0..mesh.positions.len()).map(|i| welder.number(position(mesh, i))).collect();
    // A face that would have a corner twice is none to readers.
    let whole = |numbers: &Vec<u32>| {
        let mut faces = mesh.indices.iter().map(|face| face.map(|i| numbers[i as usize]));
        faces.all(|[a, b, c]| a != b && b != c && c != a)
    };
    // Colours go with positions.
    let colours_agree = |numbers: &Vec<u32>| {
        let Some(colors) = &mesh.colors else { return true };
        let mut first: Vec<Option<[f32; 4]>> = vec![None; numbers.len()];
        let mut pairs = numbers.iter().zip(colors.iter());
        pairs.all(|(number, color)| *first[*number as usize].get_or_insert(*color) == *color)
    };
    numbers.filter(whole).filter(colours_agree).unwrap_or_else(own)
}

/// Writes what vertices have; returns the number of each one's position.
fn vertices(out: &mut impl Write, mesh: &Mesh) -> Result<Vec<u32>, EncodeError> {
    let numbers = position_numbers(mesh);
    let mut written = 0;
    for (vertex, &number) in numbers.iter().enumerate() {
        if number < written {
            continue;
        }
        written += 1;
        if is_single(mesh) {
            let [x, y, z] = mesh.positions[vertex];
            write!(out, "v {x} {y} {z}")?;
        } else {
            let [x, y, z] = position(mesh, vertex).to_array();
            write!(out, "v {x} {y} {z}")?;
        }
        if let Some(colors) = &mesh.colors {
            let [r, g, b, a] = encode(colors[vertex]).map(|steps| (steps / 255.0) as f32);
            write!(out, " {r} {g} {b}")?;
            if a < 1.0 {
                write!(out, " {a}")?;
            }
        }
        writeln!(out)?;
    }
    for [u, v] in mesh.uvs.iter().flat_map(|uvs| uvs.iter()) {
        writeln!(out, "vt {u} {v}")?;
    }
    for [x, y, z] in mesh.normals.iter().flat_map(|normals| normals.iter()) {
        writeln!(out, "vn {x} {y} {z}")?;
    }
    Ok(numbers)
}

fn faces(out: &mut impl Write, file: &MeshFile, names: &[String], numbers: &[u32]) -> Result<(), EncodeError> {
    let mesh = &file.mesh;
    let mut groups = file.groups.iter().peekable();
    let (mut material, mut open): (_, Option<&Group>) = (None, None);
    for (face, corners) in mesh.indices.iter().enumerate() {
        if let Some(group) = groups.next_if(|group| group.faces.start <= face) {
            // An object ends the group before it.
            if group.object.is_some() || group.group.is_none() {
                writeln!(out, "o {}", one_line(group.object.as_deref().unwrap_or_default()))?;
            }
            if let Some(name) = &group.group {
                writeln!(out, "g {}", one_line(name))?;
            }
            open = Some(group);
        } else if let Some(group) = open.take_if(|group| group.faces.end <= face) {
            // Faces without a name; no statement takes the name of an object away.
            writeln!(out, "{}", if group.object.is_some() { "o unnamed" } else { "g" })?;
        }
        let used = mesh.face_materials.as_ref().and_then(|of_faces| of_faces.get(face)).copied().unwrap_or(0);
        if let Some(name) = names.get(used as usize)
            && material.replace(used) != Some(used)
        {
            writeln!(out, "usemtl {name}")?;
        }
        out.write_all(b"f")?;
        for &corner in corners {
            let (position, number) = (u64::from(numbers[corner as usize]) + 1, u64::from(corner) + 1);
            match (&mesh.uvs, &mesh.normals) {
                (None, None) => write!(out, " {position}")?,
                (Some(_), None) => write!(out, " {position}/{number}")?,
                (None, Some(_)) => write!(out, " {position}//{number}")?,
                (Some(_), Some(_)) => write!(out, " {position}/{number}/{number}")?,
            }
        }
        out.write_all(b"\n")?;
    }
    Ok(())
}

/// A name as a line can hold it.
pub(super) fn one_line(name: &str) -> String {
    let name: String = name.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    // A backslash would continue the line.
    name.trim().trim_end_matches('\\').to_owned()
}
