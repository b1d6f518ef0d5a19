//! Wavefront OBJ (Alias|Wavefront, "Object files", 1990s): polygon meshes with materials.
//!
//! | statement | read as |
//! |---|---|
//! | `v x y z [w]`, `v x y z r g b [a]` | a position, weights are ignored with a note; a colour, sRGB, from 0 to 1 or, if one of the file is above 1, to 255; white where others have one |
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
//! Lines end with LF, CRLF or CR, a backslash at the end of one continues it as a blank would (so it also ends a word or number),
//! `#` begins a comment. A byte order mark is skipped; UTF-16 is an error that says so. Names are bytes: what is not UTF-8 in
//! them is replaced where they are shown and looked up.
//!
//! Corners with equal indices become one vertex, and vertices with the same position index have the same position by
//! bits. Vertices that no face uses are left out.
//!
//! A file is read in pieces of 4 MiB that end with lines, each parsed by itself on any thread: indices that count backwards
//! stay relative to the piece, and materials, groups and smoothing to what holds where the piece before ends. Then the pieces
//! are put together in the order of the file, so that the result is the same, bit for bit, on any number of threads. Time
//! is linear in the file (concave polygons aside, whose work is bounded). Large files stay on disk: memory is about twice
//! that of the mesh, and at most a small multiple of the file.

mod assemble;
mod chunk;
mod corners;
mod materials;
mod runs;
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
    Ok(MeshFile {
        mesh: assembled.mesh,
        spheres,
        materials: used.materials,
        groups,
        numbering: assembled.numbering,
        keys,
        notes: found,
    })
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{SourceError, SourceMap};
    use proptest::{prelude::*, test_runner::RngSeed};

    /// All that is read from a text in pieces of some size.
    fn read_all(text: &[u8], size: usize) -> String {
        let mut sources = SourceMap::new();
        let file = sources.insert("m.obj", text.to_vec()).unwrap();
        let content = sources.content(file);
        let result = read_content(&content, size, file, &mut |name| Err(SourceError::NotFound(name.into())));
        let found = match &result {
            Ok(mesh) => &mesh.notes,
            Err(found) => found,
        };
        let lines: Vec<String> = found.iter().map(|diagnostic| diagnostic.one_line(&sources)).collect();
        format!("{:?}\n{}", result.as_ref().ok(), lines.join("\n"))
    }

    fn check(text: &[u8], sizes: &[usize]) {
        let whole = read_all(text, PIECE_BYTES);
        for &size in sizes {
            let pieces = read_all(text, size);
            let first = pieces.lines().zip(whole.lines()).find(|(a, b)| a != b);
            assert!(pieces == whole, "pieces of {size} bytes: {first:.400?}");
        }
    }

    #[test]
    fn pieces_of_any_size_give_the_same() {
        let mut count = 0;
        for folder in ["meshes", "obj"] {
            let folder = format!("{}/tests/data/{folder}", env!("CARGO_MANIFEST_DIR"));
            for entry in std::fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                if path.extension().is_some_and(|ending| ending == "obj") {
                    check(&std::fs::read(&path).unwrap(), &[1, 2, 3, 5, 10, 17, 40, 100]);
                    count += 1;
                }
            }
        }
        assert!(count > 60, "{count}");
    }

    /// Errors in file order, with the right numbers of lines, the first hundred kept, whatever the pieces.
    #[test]
    fn places_of_errors_do_not_depend_on_the_pieces() {
        let mut text = String::new();
        for i in 0..400 {
            text += &format!("v {i} 0 0\nv 1 x 0\nf 1 2 {}\nf -1 -2 -{}\n", 3 * i, 5 * i);
        }
        check(text.as_bytes(), &[16, 64, 1000]);
        let all = read_all(text.as_bytes(), 64);
        let lines: Vec<usize> =
            all.lines().skip(1).map(|line| line.split(':').nth(1).unwrap().parse().unwrap()).collect();
        assert_eq!(lines.len(), Diagnostics::KEPT);
        assert!(lines.is_sorted() && lines[0] == 2, "{lines:?}");
    }

    fn statement() -> impl Strategy<Value = String> {
        let index = prop_oneof![6 => 1i32..6, 4 => -6i32..0, 1 => Just(0), 1 => Just(99)];
        let corner = (index.clone(), prop::option::of(index.clone()), prop::option::of(index)).prop_map(|(v, t, n)| {
            let text = |i: Option<i32>| i.map_or(String::new(), |i| i.to_string());
            match (t, n) {
                (None, None) => v.to_string(),
                (t, None) => format!("{v}/{}", text(t)),
                (t, n) => format!("{v}/{}/{}", text(t), text(n)),
            }
        });
        let words =
            ["usemtl a", "usemtl b", "g x", "g", "o y", "o", "s 1", "s off", "s 2", "mtllib q", "# \\", "foo", ""];
        prop_oneof![
            4 => prop::collection::vec(corner, 2..6).prop_map(|corners| format!("f {}", corners.join(" "))),
            3 => [-2i8..3, -2i8..3, -2i8..3].prop_map(|[x, y, z]| format!("v {x} {y} \\\n{z}")),
            1 => [-2i8..3, -2i8..3].prop_map(|[u, v]| format!("vt {u} {v}")),
            1 => [-2i8..3, -2i8..3, -2i8..3].prop_map(|[x, y, z]| format!("vn {x} {y} {z}")),
            1 => [-2i8..3, -2i8..3, -2i8..3, 1i8..3].prop_map(|[x, y, z, r]| format!("sphere {x} {y} {z} {r}")),
            3 => prop::sample::select(words.to_vec()).prop_map(str::to_owned),
        ]
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 3000, rng_seed: RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() })]

        #[test]
        fn any_statements_in_pieces(
            statements in prop::collection::vec((statement(), prop::sample::select(vec!["\n", "\r\n", "\r", " \\\n\n"])), 0..40),
            size in 1usize..60,
        ) {
            let start = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 1\nv 2 2 0\nvt 0 1\nvn 0 0 1\n";
            let text: String = statements.into_iter().map(|(text, end)| text + end).collect();
            check(format!("{start}{text}").as_bytes(), &[size]);
        }
    }
}
