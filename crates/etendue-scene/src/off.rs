//! OFF, the format of Geomview ("Object File Format", Geometry Center 1992) as text: `OFF` with the letters `ST` (texture
//! coordinates), `C` (colours) and `N` (normals) before it, in that order.
//!
//! Faces may have any number of corners. Colours of vertices and faces are skipped with a note, vertices that no face uses are
//! left out. The header may lack its word or its third count, counts may follow the word on its line, and `#` begins a comment.
//! `4OFF`, `nOFF` (other dimensions) and `OFF BINARY` are errors that say so.

use crate::{
    Diagnostic, Diagnostics, FileId, Severity, Span,
    indexed::{Indexed, Repair},
    mesh_file::MeshFile,
    positions::{LARGEST, unit_normal, usable},
    text::{Cursor, NumberError, Tally, counted, shown, tally::Finding},
};
use glam::DVec3;
use std::ops::Range;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Skipped {
    Colours,
    BadUv,
    RestOfFile,
    Repaired(Repair),
}

impl Finding for Skipped {
    fn describe(self, _: &str, count: usize) -> Diagnostic {
        match self {
            Self::Colours => Diagnostic::note(format!("colours of {} are not read", counted(count, "line"))),
            Self::BadUv => {
                Diagnostic::warning(format!("{} not finite count as (0, 0)", counted(count, "texture coordinate")))
            }
            Self::RestOfFile => Diagnostic::warning(format!("{} after the faces ignored", counted(count, "byte"))),
            Self::Repaired(repair) => repair.describe(count),
        }
    }
}

/// What the header says.
#[derive(Clone, Copy, Debug, Default)]
struct Header {
    uvs: bool,
    colours: bool,
    normals: bool,
    vertices: u64,
    faces: u64,
}

/// Stops the reading; the error is among what was found.
struct Stop;

struct Reader<'a> {
    cursor: Cursor<'a>,
    file: FileId,
    mesh: Indexed,
    /// Where vertices that are not usable stand; the first ones.
    bad: Vec<(u32, Range<usize>)>,
    found: Diagnostics,
    skipped: Tally<Skipped>,
}

/// Reads an OFF file from its bytes.
///
/// # Errors
/// A header of another kind; counts that the bytes cannot hold; malformed numbers; indices of nothing; positions that are used
/// and not finite. Several are found, each with its place.
pub fn read(bytes: &[u8], file: FileId) -> Result<MeshFile, Diagnostics> {
    let mut reader = Reader {
        cursor: Cursor::new(bytes),
        file,
        mesh: Indexed::default(),
        bad: Vec::new(),
        found: Diagnostics::new(),
        skipped: Tally::new(),
    };
    let read = reader.read();
    let used = reader.mesh.used();
    reader.report_bad_positions(&used);
    let Reader { mesh, mut found, mut skipped, .. } = reader;
    if read.is_err() || found.has_errors() {
        found.sort();
        return Err(found);
    }
    let (mesh, numbering) = mesh.into_mesh(used, &mut |what, count| {
        skipped.add_many(Skipped::Repaired(what), b"", count, file, 0..0);
    });
    let keys = skipped.uses();
    skipped.report(&mut found);
    found.sort();
    if mesh.indices.is_empty() {
        found.push(Diagnostic::warning("no faces in this file").at(Span::new(file, 0..0)));
    }
    Ok(MeshFile { keys, numbering, ..MeshFile::of_mesh(mesh, found) })
}

impl Reader<'_> {
    fn read(&mut self) -> Result<(), Stop> {
        let header = self.header()?;
        self.vertices(header)?;
        self.faces(header)?;
        if self.next_line() {
            let rest = self.cursor.bytes.len() - self.cursor.at;
            self.skipped.add_many(Skipped::RestOfFile, b"", rest, self.file, self.cursor.here());
        }
        Ok(())
    }

    fn error(&mut self, message: String, place: Range<usize>, label: &str) -> Stop {
        let error = Diagnostic::error(message).at(Span::new(self.file, place));
        self.found.push(if label.is_empty() { error } else { error.label(label) });
        Stop
    }

    /// Moves to the next word, over ends of lines and comments; false at the end of the file.
    #[inline]
    fn next_line(&mut self) -> bool {
        loop {
            self.cursor.skip_blanks();
            if self.cursor.is_done() {
                return false;
            }
            if !self.cursor.at_line_end() {
                return true;
            }
            self.cursor.next_line();
        }
    }

    fn header(&mut self) -> Result<Header, Stop> {
        let mut header = Header::default();
        if !self.next_line() {
            return Err(self.error("an empty OFF file".to_owned(), 0..0, "expected OFF"));
        }
        if !self.cursor.peek().is_some_and(|b| b.is_ascii_digit()) || self.at_dimension() {
            self.keyword(&mut header)?;
        }
        header.vertices = self.count("vertices")?;
        header.faces = self.count("faces")?;
        // The number of edges is not used, and may be missing.
        self.cursor.next_line();
        let left = (self.cursor.bytes.len() - self.cursor.at) as u128;
        // Two bytes a number at least, but the last line may lack its end.
        let numbers = 3 + 2 * u128::from(header.uvs) + 3 * u128::from(header.normals);
        let needed = 2 * (u128::from(header.vertices) * numbers + u128::from(header.faces));
        if needed > left + 1 || header.vertices > u64::from(u32::MAX) - 1 {
            let Header { vertices, faces, .. } = header;
            let message =
                format!("{vertices} vertices and {faces} faces need at least {needed} bytes, but {left} are left");
            return Err(self.error(message, 0..0, "the file may be truncated"));
        }
        Ok(header)
    }

    /// `4OFF` begins with a digit too.
    fn at_dimension(&self) -> bool {
        self.cursor.bytes[self.cursor.here()].ends_with(b"OFF")
    }

    fn keyword(&mut self, header: &mut Header) -> Result<(), Stop> {
        let word = self.cursor.word();
        let text = &self.cursor.bytes[word.clone()];
        let expected = "expected OFF, with ST, C and N before it where vertices have those";
        let Some(letters) = text.strip_suffix(b"OFF") else {
            return Err(self.error(format!("`{}` begins no OFF file", shown(text)), word, expected));
        };
        let letters = strip(letters, b"ST", &mut header.uvs);
        let letters = strip(letters, b"C", &mut header.colours);
        let letters = strip(letters, b"N", &mut header.normals);
        match letters {
            b"" => {}
            b"4" | b"n" | b"4n" => {
                return Err(self.error("only OFF files of three dimensions are read".to_owned(), word, expected));
            }
            _ => return Err(self.error(format!("unknown header `{}`", shown(text)), word, expected)),
        }
        let mut ahead = self.cursor.clone();
        let next = ahead.word();
        if &self.cursor.bytes[next.clone()] == b"BINARY" {
            return Err(self.error("binary OFF is not read".to_owned(), next, "convert it to text, or to PLY"));
        }
        Ok(())
    }

    fn count(&mut self, what: &str) -> Result<u64, Stop> {
        self.next_line();
        let word = self.cursor.word();
        let text = &self.cursor.bytes[word.clone()];
        match str::from_utf8(text).ok().and_then(|text| text.parse().ok()) {
            Some(count) => Ok(count),
            None => {
                let message = format!("`{}` is no number of {what}", shown(text));
                Err(self.error(message, word, "expected the numbers of vertices, faces and edges"))
            }
        }
    }

    /// The next number of vertex or face `index`, on its line; NaN for what is not finite.
    #[inline]
    fn number(&mut self, kind: &str, index: u64) -> Result<f64, Stop> {
        match self.cursor.number() {
            Ok(number) => Ok(number),
            Err(NumberError::NotFinite) => {
                self.cursor.word();
                Ok(f64::NAN)
            }
            Err(error) => {
                let place = self.cursor.here();
                let message = match error {
                    NumberError::Missing if self.cursor.is_done() => format!("the file ends in {kind} {index}"),
                    NumberError::Missing => format!("a number of {kind} {index} is missing"),
                    _ => format!("`{}` is not a number ({kind} {index})", shown(&self.cursor.bytes[place.clone()])),
                };
                Err(self.error(message, place, ""))
            }
        }
    }

    /// After an error on a line, the next one may be right: more errors can be found. False if reading is to end.
    fn go_on(&mut self) -> bool {
        self.cursor.next_line();
        !self.cursor.is_done() && !self.found.is_full(Severity::Error)
    }

    /// Skips what is left of a line, which is a colour or a comment.
    #[inline]
    fn end_line(&mut self) {
        self.cursor.skip_blanks();
        if !self.cursor.at_line_end() {
            self.skipped.add(Skipped::Colours, b"", self.file, self.cursor.here());
        }
        self.cursor.next_line();
    }

    fn vertices(&mut self, header: Header) -> Result<(), Stop> {
        let count = header.vertices as usize;
        self.mesh.positions.reserve_exact(count);
        self.mesh.normals = header.normals.then(|| Vec::with_capacity(count));
        self.mesh.uvs = header.uvs.then(|| Vec::with_capacity(count));
        for index in 0..header.vertices {
            if !self.next_line() {
                let end = self.cursor.at;
                return Err(self.error(format!("{count} vertices, but the file ends after {index}"), end..end, ""));
            }
            if self.vertex(header, index).is_err() {
                // Indices of faces count this vertex too.
                self.mesh.positions.push(DVec3::ZERO);
                if !self.go_on() {
                    return Err(Stop);
                }
            }
        }
        Ok(())
    }

    /// Position, then what the letters of the header say, in the order N, C, ST of Geomview's manual.
    fn vertex(&mut self, header: Header, index: u64) -> Result<(), Stop> {
        let place = self.cursor.here();
        let mut triple = || -> Result<DVec3, Stop> {
            let mut number = || self.number("vertex", index);
            Ok(DVec3::new(number()?, number()?, number()?))
        };
        let position = triple()?;
        let normal = if header.normals { triple()? } else { DVec3::ZERO };
        let mut uv = [0.0; 2];
        if header.uvs {
            // A colour has three or four numbers: the last two of the line are texture coordinates.
            let mut numbers = vec![];
            while !self.at_end_of_line() && numbers.len() < 8 {
                numbers.push(self.number("vertex", index)? as f32);
            }
            let Some(last) = numbers.last_chunk::<2>() else {
                let end = self.cursor.here();
                return Err(self.error(format!("vertex {index} has no texture coordinates"), end, ""));
            };
            uv = *last;
            if !(uv[0].is_finite() && uv[1].is_finite()) {
                self.skipped.add(Skipped::BadUv, b"", self.file, place.clone());
                uv = [0.0; 2];
            }
            if numbers.len() > 2 {
                self.skipped.add(Skipped::Colours, b"", self.file, place.clone());
            }
        }
        if !usable(position) && self.bad.len() < Diagnostics::KEPT {
            self.bad.push((self.mesh.positions.len() as u32, place));
        }
        self.mesh.positions.push(position);
        self.mesh.normals.iter_mut().for_each(|normals| {
            normals.push(unit_normal(normal));
        });
        self.mesh.uvs.iter_mut().for_each(|uvs| uvs.push(uv));
        self.end_line();
        Ok(())
    }

    fn at_end_of_line(&mut self) -> bool {
        self.cursor.skip_blanks();
        self.cursor.at_line_end()
    }

    fn faces(&mut self, header: Header) -> Result<(), Stop> {
        for index in 0..header.faces {
            if !self.next_line() {
                let end = self.cursor.at;
                return Err(self.error(
                    format!("{} faces, but the file ends after {index}", header.faces),
                    end..end,
                    "",
                ));
            }
            if self.face(header, index).is_err() && !self.go_on() {
                return Err(Stop);
            }
        }
        Ok(())
    }

    fn face(&mut self, header: Header, index: u64) -> Result<(), Stop> {
        let place = self.cursor.here();
        let size = self.number("face", index)?;
        let left = (self.cursor.bytes.len() - self.cursor.at) as f64;
        if !(size >= 0.0 && size.fract() == 0.0 && size <= 0.5 * (left + 1.0)) {
            return Err(self.error(format!("face {index} has {size} corners"), place, "expected a whole number"));
        }
        let start = self.mesh.corners.len();
        for _ in 0..size as u32 {
            let here = self.cursor.at;
            let corner = self.number("face", index)?;
            if !(corner >= 0.0 && corner.fract() == 0.0 && corner < header.vertices as f64) {
                let place = here..self.cursor.at;
                let label = format!("expected a whole number from 0 to below {}", header.vertices);
                self.mesh.corners.truncate(start);
                return Err(self.error(format!("no vertex {corner} for face {index}"), place, &label));
            }
            self.mesh.corners.push(corner as u32);
        }
        self.mesh.end_polygon(size as u32);
        self.end_line();
        Ok(())
    }

    fn report_bad_positions(&mut self, used: &[bool]) {
        for (index, place) in std::mem::take(&mut self.bad) {
            if used[index as usize] {
                let [x, y, z] = self.mesh.positions[index as usize].to_array();
                let label = format!("expected finite coordinates of at most {LARGEST:e}");
                self.error(format!("vertex {index} is at ({x:?}, {y:?}, {z:?})"), place, &label);
            }
        }
        let positions = &self.mesh.positions;
        let bad = positions.iter().zip(used).position(|(position, &used)| used && !usable(*position));
        if let Some(index) = bad.filter(|_| !self.found.has_errors()) {
            self.error(format!("vertex {index} is not finite or too large"), 0..0, "");
        }
    }
}

/// Takes `prefix` off, and tells whether it was there.
fn strip<'a>(letters: &'a [u8], prefix: &[u8], there: &mut bool) -> &'a [u8] {
    let rest = letters.strip_prefix(prefix);
    *there = rest.is_some();
    rest.unwrap_or(letters)
}
