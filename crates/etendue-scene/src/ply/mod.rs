//! Stanford PLY (Turk, "The PLY Polygon File Format", 1994): text, and binary of both endiannesses.
//!
//! | element | property | read as |
//! |---|---|---|
//! | `vertex` | `x y z` | position |
//! | | `nx ny nz` | normal, made unit length; one without length or not finite is replaced by that of the faces about it |
//! | | `u v`, `s t`, `texture_u texture_v` or `texture_s texture_t` | texture coordinates |
//! | | `red green blue`, with `alpha` | a colour, sRGB: of whole numbers without sign up to their largest; others from 0 to 1 or, if one of the file is above 1, to 255; the same with `diffuse_` before the names |
//! | `face` | list `vertex_indices` or `vertex_index` | a polygon, cut into triangles |
//! | `tristrips` | the same lists | triangle strips, -1 begins a new one |
//!
//! Properties may come in any order and have any type; other elements and properties are skipped with a note. In text each
//! element is a line. Vertices that no face uses are left out, so that they need not even be finite.
//!
//! What the header declares is checked against the bytes that follow before anything is allocated for it: memory is at most
//! a small multiple of the file, and time linear in it (concave polygons aside, whose work is bounded).

#[cfg(test)]
mod agree;
mod columns;
mod elements;
mod fixed;
mod header;
mod values;

use crate::{
    Diagnostic, Diagnostics, FileId, Severity, Span,
    content::View,
    indexed::Repair,
    mesh_file::{MeshFile, Numbering, fatal},
    positions::{LARGEST, usable},
    text::{Cursor, Tally},
};
use elements::{Content, Reader, Skipped, Stop};
use etendue::scene::Mesh;
use fixed::Fixed;
use glam::DVec3;
use header::{Encoding, Header};
use std::io;
use values::{Binary, Text, Values};

/// Reads a PLY file from its bytes.
///
/// # Errors
/// A broken header; counts and lists that the bytes cannot hold; malformed numbers; indices of nothing; positions that are
/// used and not finite. Several are found, each with its place; in binary data that is the element's line in the header, and
/// the message counts elements from 0.
pub fn read(bytes: &[u8], file: FileId) -> Result<MeshFile, Diagnostics> {
    read_view(View::Bytes(bytes), file)
}

/// As [`read`], also from disk.
pub(crate) fn read_view(view: View<'_>, file: FileId) -> Result<MeshFile, Diagnostics> {
    let failed = |error: io::Error| fatal(&format!("cannot read: {error}"), file);
    let mut buffer = Vec::new();
    let start = view.piece(0..view.len().min(LONGEST_HEADER), &mut buffer).map_err(failed)?;
    if let Ok(header) = header::parse(start, file)
        && let Some(Fixed { mesh, numbering, skipped }) = fixed::read(&header, view, file).map_err(failed)?
    {
        return finish(Some((mesh, numbering)), Diagnostics::new(), skipped, file);
    }
    read_in_order(view.piece(0..view.len(), &mut buffer).map_err(failed)?, file)
}

/// Bytes in which the header of a file ends that is not read one value after another.
const LONGEST_HEADER: usize = 1 << 16;

/// Reads one value after another.
fn read_in_order(bytes: &[u8], file: FileId) -> Result<MeshFile, Diagnostics> {
    let header = header::parse(bytes, file)?;
    let rest = &bytes[header.data..];
    match header.encoding {
        Encoding::Ascii => read_values(&header, file, Text { cursor: Cursor { bytes, at: header.data } }),
        Encoding::LittleEndian => read_values(&header, file, Binary::<false> { rest }),
        Encoding::BigEndian => read_values(&header, file, Binary::<true> { rest }),
    }
}

fn read_values<V: Values>(header: &Header, file: FileId, values: V) -> Result<MeshFile, Diagnostics> {
    let mut reader = Reader::new(header, file, values);
    let content = reader.read();
    let Reader { mut found, mut skipped, .. } = reader;
    let mesh = match content {
        Ok(content) if !found.has_errors() => assemble(content, header, file, &mut found, &mut skipped),
        Ok(_) | Err(Stop) => None,
    };
    finish(mesh, found, skipped, file)
}

/// Reports what was found.
fn finish(
    mesh: Option<(Mesh, Numbering)>,
    mut found: Diagnostics,
    skipped: Tally<Skipped>,
    file: FileId,
) -> Result<MeshFile, Diagnostics> {
    let keys = skipped.uses();
    skipped.report(&mut found);
    found.sort();
    match mesh {
        Some((mesh, numbering)) if !found.has_errors() => {
            if mesh.indices.is_empty() {
                found.push(Diagnostic::warning("no faces in this file").at(Span::new(file, 0..0)));
            }
            Ok(MeshFile { keys, numbering, ..MeshFile::of_mesh(mesh, found) })
        }
        _ => Err(found),
    }
}

/// `None` after an error.
fn assemble(
    content: Content,
    header: &Header,
    file: FileId,
    found: &mut Diagnostics,
    skipped: &mut Tally<Skipped>,
) -> Option<(Mesh, Numbering)> {
    let place = |name: &str| {
        let element = header.elements.iter().find(|element| element.name == name);
        element.map_or(0..0, |element| element.place.clone())
    };
    let used = content.mesh.used();
    if !positions_are_usable(&content, &used, file, place("vertex"), found) {
        return None;
    }
    Some(content.mesh.into_mesh(used, &mut |what, count| {
        let of_vertices = matches!(what, Repair::Unreferenced | Repair::BadNormal);
        let element = place(if of_vertices { "vertex" } else { "face" });
        skipped.add_many(Skipped::Repaired(what), b"", count, file, element);
    }))
}

fn positions_are_usable(
    content: &Content,
    used: &[bool],
    file: FileId,
    element: std::ops::Range<usize>,
    found: &mut Diagnostics,
) -> bool {
    let error = |index: usize, position: DVec3, place| {
        let [x, y, z] = position.to_array();
        Diagnostic::error(format!("vertex {index} is at ({x:?}, {y:?}, {z:?})"))
            .at(place)
            .label(format!("expected finite coordinates of at most {LARGEST:e}"))
    };
    let positions = &content.mesh.positions;
    for &(index, place) in &content.bad {
        let index = index as usize;
        if used[index] {
            found.push(error(index, positions[index], place));
        }
    }
    if !found.has_errors() && content.bad.len() == Diagnostics::KEPT {
        let bad = positions.iter().enumerate().find(|&(index, position)| used[index] && !usable(*position));
        found.extend(bad.map(|(index, position)| error(index, *position, Span::new(file, element))));
    }
    found.count(Severity::Error) == 0
}
