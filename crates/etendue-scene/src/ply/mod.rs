//! Stanford PLY (Turk, "The PLY Polygon File Format", 1994): text, and binary of both endiannesses.
//!
//! | element | property | read as |
//! |---|---|---|
//! | `vertex` | `x y z` | position |
//! | | `nx ny nz` | normal, made unit length; one without length or not finite is replaced by that of the faces about it |
//! | | `u v`, `s t`, `texture_u texture_v` or `texture_s texture_t` | texture coordinates |
//! | | `red green blue alpha` | skipped with a note |
//! | `face` | list `vertex_indices` or `vertex_index` | a polygon, cut into triangles |
//! | `tristrips` | the same lists | triangle strips, -1 begins a new one |
//!
//! Properties may come in any order and have any type; other elements and properties are skipped with a note. In text each
//! element is a line. Vertices that no face uses are left out, so that they need not even be finite.
//!
//! What the header declares is checked against the bytes that follow before anything is allocated for it: memory is at most
//! a small multiple of the file, and time linear in it (concave polygons aside, whose work is bounded).

mod elements;
mod header;
mod values;

use crate::{
    Diagnostic, Diagnostics, FileId, Severity, Span,
    mesh_file::MeshFile,
    polygon::{Cut, Triangulator, newell},
    positions::{LARGEST, localise},
    text::{Cursor, Tally},
};
use elements::{Content, Reader, Skipped, Stop};
use etendue::scene::Mesh;
use glam::DVec3;
use header::{Encoding, Header};
use values::{Binary, Text, Values};

/// Reads a PLY file from its bytes.
///
/// # Errors
/// A broken header; counts and lists that the bytes cannot hold; malformed numbers; indices of nothing; positions that are
/// used and not finite. Several are found, each with its place; in binary data that is the element's line in the header, and
/// the message counts elements from 0.
pub fn read(bytes: &[u8], file: FileId) -> Result<MeshFile, Diagnostics> {
    let header = header::parse(bytes, file)?;
    let rest = &bytes[header.data..];
    match header.encoding {
        Encoding::Ascii => read_values(&header, file, Text { cursor: Cursor { bytes, at: header.data } }),
        Encoding::LittleEndian => read_values(&header, file, Binary::<false> { rest }),
        Encoding::BigEndian => read_values(&header, file, Binary::<true> { rest }),
    }
}

fn read_values<V: Values>(header: &Header, file: FileId, values: V) -> Result<MeshFile, Diagnostics> {
    let mut reader = Reader { header, file, values, found: Diagnostics::new(), skipped: Tally::new() };
    let content = reader.read();
    let Reader { mut found, mut skipped, .. } = reader;
    let mesh = match content {
        Ok(content) if !found.has_errors() => assemble(content, header, file, &mut found, &mut skipped),
        Ok(_) | Err(Stop) => None,
    };
    let keys = skipped.uses();
    skipped.report(&mut found);
    found.sort();
    match mesh {
        Some(mesh) if !found.has_errors() => {
            if mesh.indices.is_empty() {
                found.push(Diagnostic::warning("no faces in this file").at(Span::new(file, 0..0)));
            }
            Ok(MeshFile { mesh, materials: vec![], groups: vec![], keys, notes: found })
        }
        _ => Err(found),
    }
}

/// Finite, and not too large to work with.
fn usable(position: DVec3) -> bool {
    // Not true for NaN.
    position.abs().cmple(DVec3::splat(LARGEST)).all()
}

/// Cuts polygons, leaves out unused vertices, repairs normals. `None` after an error.
fn assemble(
    mut content: Content,
    header: &Header,
    file: FileId,
    found: &mut Diagnostics,
    skipped: &mut Tally<Skipped>,
) -> Option<Mesh> {
    let place = |name: &str| {
        let element = header.elements.iter().find(|element| element.name == name);
        element.map_or(0..0, |element| element.place.clone())
    };
    let mut used = vec![false; content.vertices.positions.len()];
    content.corners.iter().for_each(|&corner| used[corner as usize] = true);
    if !positions_are_usable(&content, &used, file, place("vertex"), found) {
        return None;
    }
    let unused = used.iter().filter(|&&used| !used).count();
    if unused > 0 {
        skipped.add_many(Skipped::Unreferenced, b"", unused, file, place("vertex"));
        compact(&mut content, &used);
    }
    drop(used);
    let corners = std::mem::take(&mut content.corners);
    let indices = match content.sizes.take() {
        None => {
            let triangles = corners.chunks_exact(3).map(|t| [t[0], t[1], t[2]]);
            let whole = |t: &[u32; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
            let broken = triangles.clone().filter(|t| !whole(t)).count();
            if broken > 0 {
                skipped.add_many(Skipped::FewCorners, b"", broken, file, place("face"));
            }
            triangles.filter(whole).collect()
        }
        Some(sizes) => {
            let (indices, repairs) = cut_polygons(&content.vertices.positions, &corners, &sizes);
            for (what, count) in repairs {
                skipped.add_many(what, b"", count, file, place("face"));
            }
            indices
        }
    };
    let positions = content.vertices.positions;
    let normals = content.vertices.normals.filter(|normals| normals.iter().any(|n| *n != [0.0; 3]));
    let normals = normals.map(|mut normals| {
        let replaced = replace_normals(&mut normals, &positions, &indices);
        if replaced > 0 {
            skipped.add_many(Skipped::BadNormal, b"", replaced, file, place("vertex"));
        }
        normals
    });
    let (origin, local) = localise(positions.iter().copied());
    Some(Mesh {
        origin,
        positions: local,
        indices: indices.into(),
        normals: normals.map(Into::into),
        uvs: content.vertices.uvs.map(Into::into),
        face_materials: None,
    })
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
    let positions = &content.vertices.positions;
    for &(index, place) in &content.vertices.bad {
        let index = index as usize;
        if used[index] {
            found.push(error(index, positions[index], place));
        }
    }
    if !found.has_errors() && content.vertices.bad.len() == Diagnostics::KEPT {
        let bad = positions.iter().enumerate().find(|&(index, position)| used[index] && !usable(*position));
        found.extend(bad.map(|(index, position)| error(index, *position, Span::new(file, element))));
    }
    found.count(Severity::Error) == 0
}

/// Drops vertices that are not used, keeping the order.
fn compact(content: &mut Content, used: &[bool]) {
    let mut next = 0;
    let renumbered: Vec<u32> = used
        .iter()
        .map(|&used| {
            let number = next;
            next += u32::from(used);
            number
        })
        .collect();
    fn keep<T>(values: &mut Vec<T>, used: &[bool]) {
        let mut flags = used.iter();
        values.retain(|_| flags.next().is_none_or(|&used| used));
    }
    keep(&mut content.vertices.positions, used);
    content.vertices.normals.iter_mut().for_each(|normals| keep(normals, used));
    content.vertices.uvs.iter_mut().for_each(|uvs| keep(uvs, used));
    content.corners.iter_mut().for_each(|corner| *corner = renumbered[*corner as usize]);
}

/// The triangles, and what was repaired how often.
fn cut_polygons(positions: &[DVec3], corners: &[u32], sizes: &[u32]) -> (Vec<[u32; 3]>, Vec<(Skipped, usize)>) {
    let mut repairs: Vec<(Skipped, usize)> = vec![];
    let mut repaired = |what| match repairs.iter_mut().find(|(kind, _)| *kind == what) {
        Some((_, count)) => *count += 1,
        None => repairs.push((what, 1)),
    };
    let mut indices = Vec::with_capacity(sizes.iter().map(|&size| (size as usize).saturating_sub(2)).sum());
    let mut triangulator = Triangulator::new();
    let (mut ring, mut points, mut triangles) = (vec![], vec![], vec![]);
    let mut rest = corners;
    for &size in sizes {
        let (face, after) = rest.split_at(size as usize);
        rest = after;
        ring.clear();
        ring.extend_from_slice(face);
        ring.dedup();
        while ring.len() > 1 && ring.first() == ring.last() {
            ring.pop();
        }
        if ring.len() < 3 {
            repaired(Skipped::FewCorners);
            continue;
        }
        (ring.len()..face.len()).for_each(|_| repaired(Skipped::RepeatedCorner));
        points.clear();
        points.extend(ring.iter().map(|&corner| positions[corner as usize]));
        triangles.clear();
        match triangulator.cut(&points, &mut triangles) {
            Cut::Exact => {}
            Cut::Forced => repaired(Skipped::SelfIntersecting),
            Cut::TooComplex => repaired(Skipped::TooComplex),
        }
        let cut = triangles.iter().map(|triangle| triangle.map(|i| ring[i as usize]));
        // A corner that the polygon visits twice can meet itself.
        indices.extend(cut.filter(|[a, b, c]| a != b && b != c && c != a));
    }
    (indices, repairs)
}

/// Replaces normals that are zero by the sum of the vector areas of the faces about them; returns how many.
fn replace_normals(normals: &mut [[f32; 3]], positions: &[DVec3], indices: &[[u32; 3]]) -> usize {
    let zero: Vec<bool> = normals.iter().map(|normal| *normal == [0.0; 3]).collect();
    let replaced = zero.iter().filter(|&&zero| zero).count();
    if replaced == 0 {
        return 0;
    }
    let mut sums = vec![DVec3::ZERO; normals.len()];
    for triangle in indices {
        let area = newell(&triangle.map(|i| positions[i as usize]));
        triangle.iter().filter(|&&i| zero[i as usize]).for_each(|&i| sums[i as usize] += area);
    }
    for ((normal, sum), _) in normals.iter_mut().zip(sums).zip(&zero).filter(|(_, zero)| **zero) {
        *normal = sum.try_normalize().unwrap_or(DVec3::Z).as_vec3().to_array();
    }
    replaced
}
