//! Wavefront OBJ (Alias|Wavefront, "Object files", 1990s): polygon meshes with materials.
//!
//! | statement | read as |
//! |---|---|
//! | `v x y z [w]`, `v x y z r g b [a]` | a position; weights and colours are ignored with a note |
//! | `vt u [v [w]]` | texture coordinates, v up as in the file; a missing v is 0, w is ignored |
//! | `vn x y z` | a normal, made unit length; one without length or not finite is replaced by the face's |
//! | `f v`, `v/vt`, `v//vn`, `v/vt/vn` | a polygon of three or more corners, cut into triangles; indices count from 1, or backwards from -1, and may run ahead of what they name; index 0 of vt or vn counts as none |
//! | `s N`, `s off` | faces that bring no normals: smooth within a group (normals of faces weighted by their angle), or flat |
//! | `o NAME`, `g NAMES` | named runs of faces |
//! | `usemtl NAME` | the material of the faces that follow; names may hold blanks |
//! | `mtllib NAMES` | material libraries (see [`crate::mtl`]); names may hold blanks if they end in `.mtl` |
//! | `sphere x y z r` | a sphere about (x, y, z), in the units of the file, with the current material: an extension |
//! | `l`, `p`, free-form curves and surfaces, display attributes | skipped with a note |
//!
//! Lines end with LF, CRLF or CR, a backslash at the end continues one, `#` begins a comment. A byte order mark is skipped.
//!
//! Corners with equal indices become one vertex, and vertices with the same position index have the same position by
//! bits. Vertices that no face uses are left out. Time is linear in the file (concave polygons aside, whose work is
//! bounded); memory is at most a small multiple of it.

mod assemble;
mod chunk;
mod corners;
mod materials;
mod skipped;
mod statements;
pub(crate) mod unifier;

use crate::{
    Diagnostic, Diagnostics, FileId, Span,
    content::Content,
    mesh_file::{Group, MeshFile, OpenLibrary, Sphere, fatal},
    text::{is_utf16, pieces::PIECE_BYTES},
};
use chunk::NameAt;
use statements::Statements;
use std::{io, sync::Arc};

pub(crate) use chunk::number_error;

/// Largest file: with two bytes or more to an index, fewer than 2^32 of anything.
const LARGEST_FILE: usize = 8 << 30;

/// Reads an OBJ file from its bytes; `open` finds the material libraries that it names.
///
/// # Errors
/// Malformed and infinite numbers, indices of nothing, and an empty or foreign file: all found (up to a bound), each with
/// its place. Errors in a material library count as well.
pub fn read(bytes: Arc<Vec<u8>>, file: FileId, open: OpenLibrary) -> Result<MeshFile, Diagnostics> {
    read_content(&Content::Bytes(bytes), PIECE_BYTES, file, open)
}

/// As [`read`], also from disk, in pieces of some size.
pub(crate) fn read_content(
    content: &Content,
    piece: usize,
    file: FileId,
    open: OpenLibrary,
) -> Result<MeshFile, Diagnostics> {
    if content.len() > LARGEST_FILE {
        return Err(fatal("OBJ files larger than 8 GiB are not read", file));
    }
    let failed = |error: io::Error| fatal(&format!("cannot read: {error}"), file);
    let mut buffer = Vec::new();
    if is_utf16(content.piece(0..content.len().min(4), &mut buffer).map_err(failed)?) {
        let error = Diagnostic::error("the file is UTF-16 text").at(Span::new(file, 0..0)).help("save it as UTF-8");
        let mut found = Diagnostics::new();
        found.push(error);
        return Err(found);
    }
    let statements = statements::parse(content, piece, file).map_err(failed)?;
    finish(statements, content, file, open)
}

fn finish(
    mut statements: Statements,
    content: &Content,
    file: FileId,
    open: OpenLibrary,
) -> Result<MeshFile, Diagnostics> {
    let mut found = std::mem::take(&mut statements.errors);
    let mut used = materials::resolve(&statements, file, open, &mut found);
    if !found.has_errors() && !statements.is_obj {
        found.push(Diagnostic::error("no OBJ statement in this file").at(Span::new(file, 0..0)));
    }
    if found.has_errors() {
        statements.skipped.report(&mut found);
        found.sort();
        return Err(found);
    }
    let index_of = |number| used.index_of(number);
    let several = used.of_faces > 1;
    let assembled = assemble::assemble(&mut statements, if several { Some(&index_of) } else { None });
    for (what, count, face) in assembled.repairs {
        let place = statements.face_place(content, face);
        statements.skipped.add_many(what, b"", count, file, place);
    }
    let groups = named_groups(&statements, &assembled.groups, assembled.mesh.indices.len());
    let keys = statements.skipped.uses().into_iter().chain(std::mem::take(&mut used.keys)).collect();
    statements.skipped.report(&mut found);
    let place = |&(center, radius, number): &_| Sphere { center, radius, material: used.index_of(number) };
    let spheres: Vec<Sphere> = statements.spheres.iter().map(place).collect();
    if assembled.mesh.indices.is_empty() && spheres.is_empty() {
        found.push(Diagnostic::warning("no faces in this file").at(Span::new(file, 0..0)));
    }
    found.sort();
    Ok(MeshFile { mesh: assembled.mesh, spheres, materials: used.materials, groups, keys, notes: found })
}

/// The runs of faces with an `o` or `g` name; `starts` are the first triangles of all runs.
fn named_groups(statements: &Statements, starts: &[usize], faces: usize) -> Vec<Group> {
    let text = |at: NameAt| String::from_utf8_lossy(statements.name(at)).into_owned();
    let ends = starts.iter().skip(1).copied().chain([faces]);
    let runs = statements.groups.runs.iter().zip(starts).zip(ends);
    runs.filter(|(((_, names), start), end)| (names.object.is_some() || names.group.is_some()) && *start < end)
        .map(|(((_, names), &start), end)| Group {
            object: names.object.map(text),
            group: names.group.map(text),
            faces: start..end,
        })
        .collect()
}
