//! STL (3D Systems, "StereoLithography Interface Specification", 1989): binary, and text.
//!
//! A file is binary if its size is the one that its count of facets asks for, also if it begins with `solid`; of other sizes,
//! text if it begins with that word and has no zero bytes near its start. In text, words may be in upper or lower case and
//! lines broken anywhere; each `solid` is a group of faces with its name; a loop of more than three vertices is cut.
//!
//! Equal positions become one vertex, so that a closed surface is closed here too. Shading is flat: normals are not read, as
//! the order of the corners says the same and is what programs agree on. Facets with two equal corners, and with corners that
//! are not finite, are skipped with a warning; colours in the attribute bytes are noted.

use crate::{
    Diagnostic, Diagnostics, FileId, Severity, Span,
    indexed::{Indexed, Repair},
    mesh_file::{Group, MeshFile},
    polygon::{Cut, Triangulator},
    positions::{LARGEST, usable},
    text::{Cursor, NumberError, Tally, counted, shown, tally::Finding},
    weld::Welder,
};
use glam::DVec3;
use std::ops::Range;

/// Bytes before the facets of a binary file: 80 of text and their count.
const HEADER: usize = 84;
/// Bytes of a facet: normal, three corners, two of attributes.
const FACET: usize = 50;

/// What is skipped or repaired.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Skipped {
    NotFinite,
    Degenerate,
    Attributes,
    TrailingBytes,
    Polygon,
    Repaired(Repair),
}

impl Finding for Skipped {
    fn describe(self, _: &str, count: usize) -> Diagnostic {
        let of = |thing: &str| counted(count, thing);
        match self {
            Self::NotFinite => Diagnostic::warning(format!("{} with a corner that is not finite skipped", of("facet")))
                .label(format!("expected finite coordinates of at most {LARGEST:e}")),
            Self::Degenerate => Diagnostic::warning(format!("{} with two equal corners skipped", of("facet"))),
            Self::Attributes => Diagnostic::note(format!("attributes (colours) of {} are not read", of("facet"))),
            Self::TrailingBytes => Diagnostic::warning(format!("{} after the facets ignored", of("byte"))),
            Self::Polygon => Diagnostic::note(format!("{} with more than three corners cut", of("facet"))),
            Self::Repaired(repair) => repair.describe(count),
        }
    }
}

/// Reads an STL file from its bytes.
///
/// # Errors
/// A count of facets that the bytes cannot hold; in text what is no facet, malformed numbers, and an end inside a facet;
/// several are found.
pub fn read(bytes: &[u8], file: FileId) -> Result<MeshFile, Diagnostics> {
    let mut builder = Builder {
        file,
        welder: Welder::default(),
        corners: Vec::new(),
        groups: Vec::new(),
        triangulator: Triangulator::new(),
        found: Diagnostics::new(),
        skipped: Tally::new(),
    };
    match is_text(bytes) {
        true => Text { cursor: Cursor::new(bytes), builder: &mut builder, corners: Vec::new() }.read(),
        false => binary(bytes, &mut builder),
    }
    builder.finish()
}

/// The facets that a binary file declares.
fn declared(bytes: &[u8]) -> Option<u64> {
    let count = bytes.get(HEADER - 4..HEADER)?;
    Some(u64::from(u32::from_le_bytes(count.try_into().ok()?)))
}

fn is_text(bytes: &[u8]) -> bool {
    if declared(bytes).is_some_and(|count| count * FACET as u64 + HEADER as u64 == bytes.len() as u64) {
        return false;
    }
    let start = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes).trim_ascii_start();
    let solid = start.len() >= 5 && start[..5].eq_ignore_ascii_case(b"solid");
    solid && !bytes[..bytes.len().min(1024)].contains(&0)
}

/// Collects triangles.
struct Builder {
    file: FileId,
    welder: Welder,
    /// Three a triangle.
    corners: Vec<u32>,
    groups: Vec<Group>,
    triangulator: Triangulator,
    found: Diagnostics,
    skipped: Tally<Skipped>,
}

impl Builder {
    fn error(&mut self, message: String, place: Range<usize>, label: &str) {
        let error = Diagnostic::error(message).at(Span::new(self.file, place));
        self.found.push(if label.is_empty() { error } else { error.label(label) });
    }

    fn skip(&mut self, what: Skipped, place: Range<usize>) {
        self.skipped.add(what, b"", self.file, place);
    }

    #[inline]
    fn facet(&mut self, corners: &[DVec3], place: Range<usize>) {
        if !corners.iter().all(|corner| usable(*corner)) {
            return self.skip(Skipped::NotFinite, place);
        }
        if let [a, b, c] = *corners {
            return self.triangle([a, b, c], place);
        }
        let mut triangles = vec![];
        match self.triangulator.cut(corners, &mut triangles) {
            Cut::Exact => {}
            Cut::Forced => self.skip(Skipped::Repaired(Repair::SelfIntersecting), place.clone()),
            Cut::TooComplex => self.skip(Skipped::Repaired(Repair::TooComplex), place.clone()),
        }
        self.skip(Skipped::Polygon, place.clone());
        for triangle in triangles {
            self.triangle(triangle.map(|i| corners[i as usize]), place.clone());
        }
    }

    #[inline]
    fn triangle(&mut self, [a, b, c]: [DVec3; 3], place: Range<usize>) {
        if a == b || b == c || c == a {
            return self.skip(Skipped::Degenerate, place);
        }
        let numbers = [a, b, c].map(|corner| self.welder.number(corner));
        match numbers {
            [Some(a), Some(b), Some(c)] => self.corners.extend([a, b, c]),
            _ if self.found.has_errors() => {}
            _ => self.error("more than 4,294,967,295 different corners".to_owned(), place, ""),
        }
    }

    fn faces(&self) -> usize {
        self.corners.len() / 3
    }

    fn finish(self) -> Result<MeshFile, Diagnostics> {
        let Self { file, welder, corners, groups, mut found, mut skipped, .. } = self;
        let indexed = Indexed { positions: welder.into_positions(), corners, ..Indexed::default() };
        let used = indexed.used();
        let (mesh, numbering) = indexed.into_mesh(used, &mut |what, count| {
            skipped.add_many(Skipped::Repaired(what), b"", count, file, 0..0);
        });
        skipped.report(&mut found);
        found.sort();
        if found.has_errors() {
            return Err(found);
        }
        if mesh.indices.is_empty() {
            found.push(Diagnostic::warning("no faces in this file").at(Span::new(file, 0..0)));
        }
        Ok(MeshFile { groups, numbering, ..MeshFile::of_mesh(mesh, found) })
    }
}

fn binary(bytes: &[u8], builder: &mut Builder) {
    let Some(count) = declared(bytes) else {
        let message = format!("{} bytes are too few for an STL file", bytes.len());
        return builder.error(message, 0..0, "expected `solid`, or 84 bytes of header");
    };
    let data = &bytes[HEADER..];
    let needed = count * FACET as u64;
    if needed > data.len() as u64 {
        let message = format!("{count} facets need {needed} bytes, but {} are left", data.len());
        return builder.error(message, 0..0, "the file may be truncated, or no STL file");
    }
    builder.corners.reserve(3 * count as usize);
    // A closed surface has half as many vertices as faces.
    builder.welder = Welder::for_about(count as usize / 2);
    let (facets, rest) = data.split_at(needed as usize);
    for some in facets.chunks(Welder::AHEAD / 3 * FACET) {
        builder.welder.expect(some.chunks_exact(FACET).flat_map(corners_of));
        for facet in some.chunks_exact(FACET) {
            builder.facet(&corners_of(facet), 0..0);
            if facet[48..] != [0, 0] {
                builder.skip(Skipped::Attributes, 0..0);
            }
        }
    }
    if !rest.is_empty() {
        builder.skipped.add_many(Skipped::TrailingBytes, b"", rest.len(), builder.file, 0..0);
    }
}

/// The corners of a facet of a binary file.
#[inline]
fn corners_of(facet: &[u8]) -> [DVec3; 3] {
    let number = |at: usize| f64::from(f32::from_le_bytes([facet[at], facet[at + 1], facet[at + 2], facet[at + 3]]));
    [12, 24, 36].map(|at| DVec3::new(number(at), number(at + 4), number(at + 8)))
}

/// Reads text word by word.
struct Text<'a> {
    cursor: Cursor<'a>,
    builder: &'a mut Builder,
    /// Of the loop that is being read.
    corners: Vec<DVec3>,
}

impl Text<'_> {
    fn read(mut self) {
        // Where the loop that is being read begins.
        let mut inside = None;
        while let Some(word) = self.word() {
            let key = self.cursor.bytes[word.clone()].to_ascii_lowercase();
            match &key[..] {
                b"solid" => self.solid(),
                b"endsolid" => {
                    self.cursor.name();
                }
                b"facet" | b"endfacet" | b"outer" => {}
                // The numbers of a normal are not even looked at: programs write NaN there.
                b"normal" => {
                    (0..3).for_each(|_| {
                        self.word();
                    });
                }
                b"loop" => {
                    self.corners.clear();
                    inside = Some(word);
                }
                b"vertex" => self.vertex(inside.is_some(), word),
                b"endloop" => self.end_loop(inside.take(), word),
                _ => {
                    let message = format!("`{}` in an STL file", shown(&self.cursor.bytes[word.clone()]));
                    self.builder.error(message, word, "expected facet, normal, outer loop, vertex, endloop, endfacet");
                    self.cursor.next_line();
                }
            }
            if self.builder.found.is_full(Severity::Error) {
                return;
            }
        }
        if let Some(place) = inside {
            self.builder.error("the file ends inside a facet".to_owned(), place, "begins here");
        }
        self.end_group();
    }

    /// The next word on this line or a later one.
    fn word(&mut self) -> Option<Range<usize>> {
        loop {
            let word = self.cursor.word();
            if !word.is_empty() {
                return Some(word);
            }
            if self.cursor.is_done() {
                return None;
            }
            self.cursor.next_line();
        }
    }

    fn solid(&mut self) {
        self.end_group();
        let name = self.cursor.name();
        let name = String::from_utf8_lossy(&self.cursor.bytes[name]).into_owned();
        let faces = self.builder.faces();
        let object = Some(name).filter(|name| !name.is_empty());
        self.builder.groups.push(Group { object, group: None, faces: faces..faces });
    }

    /// A group ends where the next begins; one without a name or faces is none.
    fn end_group(&mut self) {
        let faces = self.builder.faces();
        if let Some(group) = self.builder.groups.last_mut() {
            group.faces.end = faces;
            if group.faces.is_empty() || group.object.is_none() {
                self.builder.groups.pop();
            }
        }
    }

    fn vertex(&mut self, inside: bool, word: Range<usize>) {
        let mut position = [0.0; 3];
        for coordinate in &mut position {
            match self.number() {
                Ok(number) => *coordinate = number,
                Err((error, place)) => {
                    let word = shown(&self.cursor.bytes[place.clone()]);
                    let message = match error {
                        NumberError::Missing => "a coordinate of a vertex is missing".to_owned(),
                        _ => format!("`{word}` is not a number"),
                    };
                    self.builder.error(message, place, "expected vertex X Y Z");
                    return self.cursor.next_line();
                }
            }
        }
        match inside {
            true => self.corners.push(DVec3::from_array(position)),
            false => self.builder.error("a vertex outside of a loop".to_owned(), word, "expected outer loop before it"),
        }
    }

    /// The next number on this line or a later one; NaN for what is not finite.
    fn number(&mut self) -> Result<f64, (NumberError, Range<usize>)> {
        loop {
            match self.cursor.number() {
                Ok(number) => return Ok(number),
                Err(NumberError::NotFinite) => {
                    self.cursor.word();
                    return Ok(f64::NAN);
                }
                Err(NumberError::Missing) if !self.cursor.is_done() => self.cursor.next_line(),
                Err(error) => return Err((error, self.cursor.here())),
            }
        }
    }

    fn end_loop(&mut self, inside: Option<Range<usize>>, word: Range<usize>) {
        let corners = std::mem::take(&mut self.corners);
        match inside {
            None => self.builder.error("an endloop without its loop".to_owned(), word, ""),
            Some(place) if corners.len() < 3 => {
                self.builder.error(
                    format!("a facet with {}", counted(corners.len(), "corner")),
                    place,
                    "expected three",
                );
            }
            Some(place) => self.builder.facet(&corners, place),
        }
        self.corners = corners;
    }
}
