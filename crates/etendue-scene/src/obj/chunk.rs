//! The statements in a piece of an OBJ file, as arrays.

use super::{
    corners::{Corners, Counts, Index},
    runs::{Faces, Runs},
    skipped::Skipped,
};
use crate::{
    Diagnostic, Diagnostics, FileId, Severity, Span,
    positions::{LARGEST, unit_normal},
    text::{Cursor, NumberError, Tally, joined, number::digits, pieces::Piece, shown},
    vertex_colors::{NONE, WHITE},
};
use glam::DVec3;
use std::{borrow::Cow, collections::BTreeMap, ops::Range};

/// What a piece of an OBJ file says. Materials, smoothing groups and names are runs of faces; `None` at the start of the piece
/// stands for what holds where the piece before ends.
pub(super) struct Chunk {
    /// Where it stands in the file.
    pub place: Range<usize>,
    pub positions: Vec<DVec3>,
    /// As in the file, up to the last position that has one.
    pub colors: Vec<[f32; 4]>,
    pub uvs: Vec<[f32; 2]>,
    /// Unit vectors, or zero.
    pub normals: Vec<[f32; 3]>,
    pub corners: Corners,
    pub faces: Faces,
    /// Some corner has them.
    pub has_uvs: bool,
    /// Some corner has one.
    pub has_normals: bool,
    /// Index into `material_names`.
    pub materials: Runs<Option<u32>>,
    /// Smoothing groups; 0 is none.
    pub smoothing: Runs<Option<u32>>,
    pub groups: Runs<Names>,
    /// The bytes of the names in `groups`.
    pub names: Vec<u8>,
    pub spheres: Vec<SphereAt>,
    /// Names that `usemtl` uses, with the place of the first use.
    pub material_names: Vec<Named>,
    /// Names that `mtllib` gives.
    pub libraries: Vec<Named>,
    /// Where every 1024th face stands, from the start of the piece.
    pub face_places: Vec<usize>,
    /// Of each kind, the largest index as written, and the least one that counts backwards, from the first in this piece.
    pub highest: [i64; 3],
    pub lowest: [i64; 3],
    pub errors: Diagnostics,
    pub skipped: Tally<Skipped>,
    /// A statement of the format was seen.
    pub is_obj: bool,
}

/// A sphere, with an index into [`Chunk::material_names`].
#[derive(Clone, Copy)]
pub(super) struct SphereAt {
    pub center: DVec3,
    pub radius: f64,
    pub material: Option<u32>,
}

/// A name and the line that gives it.
#[derive(Clone)]
pub(super) struct Named {
    pub name: Vec<u8>,
    pub place: Range<usize>,
}

impl Chunk {
    /// Numbers of positions, texture coordinates and normals.
    pub fn counts(&self) -> Counts {
        [self.positions.len(), self.uvs.len(), self.normals.len()]
    }
}

/// Names of object and group: bytes of [`Chunk::names`]; `Some(None)` is none, `None` as before the piece.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct Names {
    pub object: Option<Option<NameAt>>,
    pub group: Option<Option<NameAt>>,
}

/// Bytes of [`Chunk::names`]. Each name has a place of its own, also if it is empty or was there before.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) struct NameAt {
    pub start: usize,
    pub length: usize,
}

const KINDS: [&str; 3] = ["vertex", "texture vertex", "normal"];

/// Faces from one remembered place to the next.
pub(super) const FACES_A_PLACE: u32 = 1024;

/// The numbers of each kind before a piece and in the whole file: known on a second reading.
#[derive(Clone, Copy)]
pub(super) struct Known {
    pub base: Counts,
    pub totals: Counts,
}

/// Reads the statements of a piece. Indices of nothing are only found if it is `known` what there is.
pub(super) fn parse(piece: Piece, file: FileId, known: Option<Known>) -> Chunk {
    let mut parser = Parser::new(piece, file, known);
    while !parser.cursor.is_done() {
        parser.statement();
        parser.cursor.next_line();
    }
    parser.finish()
}

struct Parser<'a> {
    cursor: Cursor<'a>,
    start: usize,
    file: FileId,
    out: Chunk,
    material_ids: BTreeMap<Cow<'a, [u8]>, u32>,
    known: Option<Known>,
    /// Largest indices that are allowed.
    largest: [i64; 3],
}

impl<'a> Parser<'a> {
    fn new(piece: Piece<'a>, file: FileId, known: Option<Known>) -> Self {
        let Piece { start, bytes, .. } = piece;
        let out = Chunk {
            place: start..start + bytes.len(),
            positions: vec![],
            colors: vec![],
            uvs: vec![],
            normals: vec![],
            corners: Corners::default(),
            faces: Faces::Triangles(0),
            has_uvs: false,
            has_normals: false,
            materials: Runs::new(None),
            smoothing: Runs::new(None),
            groups: Runs::new(Names { object: None, group: None }),
            names: vec![],
            spheres: vec![],
            material_names: vec![],
            libraries: vec![],
            face_places: vec![],
            highest: [0; 3],
            lowest: [0; 3],
            errors: Diagnostics::new(),
            skipped: Tally::new(),
            is_obj: false,
        };
        // Only the first piece can begin with a byte order mark.
        let cursor = if start == 0 { Cursor::new(bytes) } else { Cursor { bytes, at: 0 } };
        let largest = known.map_or([i64::MAX; 3], |known| known.totals.map(|total| total as i64));
        Self { cursor, start, file, out, material_ids: BTreeMap::new(), known, largest }
    }

    fn finish(self) -> Chunk {
        let mut out = self.out;
        out.positions.shrink_to_fit();
        out.colors.shrink_to_fit();
        out.uvs.shrink_to_fit();
        out.normals.shrink_to_fit();
        out.corners.shrink();
        out.is_obj |= out.counts() != [0; 3] || out.faces.count() > 0;
        out
    }

    #[inline(always)]
    fn statement(&mut self) {
        self.cursor.skip_blanks();
        match &self.cursor.bytes[self.cursor.at..] {
            [b'v', b' ' | b'\t', ..] => {
                self.cursor.at += 1;
                self.vertex();
            }
            [b'f', b' ' | b'\t', ..] => {
                self.cursor.at += 1;
                self.face();
            }
            [b'v', b't', b' ' | b'\t', ..] => {
                self.cursor.at += 2;
                self.texture_vertex();
            }
            [b'v', b'n', b' ' | b'\t', ..] => {
                self.cursor.at += 2;
                self.normal();
            }
            _ => self.rare_statement(),
        }
    }

    fn rare_statement(&mut self) {
        let key = self.cursor.word();
        match &self.cursor.bytes[key.clone()] {
            b"" => return,
            b"v" => self.vertex(),
            b"f" => self.face(),
            b"vt" => self.texture_vertex(),
            b"vn" => self.normal(),
            b"usemtl" => self.use_material(),
            b"mtllib" => {
                let named = self.named();
                self.out.libraries.push(named);
            }
            b"o" => self.out.groups.current = Names { object: Some(Some(self.keep_name())), group: Some(None) },
            b"g" => self.out.groups.current.group = Some(Some(self.keep_name()).filter(|name| name.length > 0)),
            b"s" => self.smoothing(),
            b"sphere" => self.sphere(),
            b"l" | b"p" => self.skip(Skipped::LinesAndPoints, key),
            b"vp" | b"cstype" | b"deg" | b"bmat" | b"step" | b"curv" | b"curv2" | b"surf" | b"parm" | b"trim"
            | b"hole" | b"scrv" | b"sp" | b"end" | b"con" | b"ctech" | b"stech" => self.skip(Skipped::FreeForm, key),
            b"mg" | b"bevel" | b"c_interp" | b"d_interp" | b"lod" | b"shadow_obj" | b"trace_obj" | b"maplib"
            | b"usemap" => self.skip(Skipped::Attribute, key),
            _ => return self.skip(Skipped::Unknown, key),
        }
        self.out.is_obj = true;
    }

    #[cold]
    fn skip(&mut self, kind: Skipped, word: Range<usize>) {
        let key = if kind.names_the_word() { &self.cursor.bytes[word.clone()] } else { b"" };
        self.out.skipped.add(kind, key, self.file, self.start + word.start..self.start + word.end);
    }

    /// `v x y z [w]` or `v x y z r g b [a]`
    #[inline(always)]
    fn vertex(&mut self) {
        // A bad one keeps its place, so that the indices of others stay right.
        let (position, good) = self.point("x y z of a vertex");
        self.out.positions.push(position);
        if !good {
            return;
        }
        self.cursor.skip_blanks();
        if !self.cursor.at_line_end() {
            self.rest_of_vertex();
        }
    }

    /// Three coordinates, and whether they could be read; if not, that is reported.
    #[inline(always)]
    fn point(&mut self, what: &str) -> (DVec3, bool) {
        let mut point = DVec3::ZERO;
        for axis in 0..3 {
            match self.coordinate(what) {
                Some(value) => point[axis] = value,
                None => return (DVec3::ZERO, false),
            }
        }
        (point, true)
    }

    /// A number that is not too large, or `None` after a report.
    #[inline(always)]
    fn coordinate(&mut self, what: &str) -> Option<f64> {
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        match self.cursor.number() {
            Ok(value) if value.abs() <= LARGEST => Some(value),
            Ok(_) => {
                self.error(start, |_, word| {
                    Diagnostic::error(format!("coordinate {word} is too large"))
                        .label(format!("expected at most {LARGEST:e}"))
                });
                None
            }
            Err(error) => {
                self.bad_number(error, what);
                None
            }
        }
    }

    /// `sphere x y z r`
    fn sphere(&mut self) {
        const WHAT: &str = "x y z and the radius of a sphere";
        let (center, good) = self.point(WHAT);
        if !good {
            return;
        }
        self.cursor.skip_blanks();
        let start = self.cursor.at;
        let Some(radius) = self.coordinate(WHAT) else { return };
        if radius <= 0.0 {
            return self.error(start, |_, _| {
                Diagnostic::error("the radius of a sphere is not above 0").label("expected a number above 0")
            });
        }
        self.out.spheres.push(SphereAt { center, radius, material: self.out.materials.current });
        self.cursor.skip_blanks();
        if !self.cursor.at_line_end() {
            self.skip(Skipped::MoreNumbers, self.cursor.here());
        }
    }

    fn rest_of_vertex(&mut self) {
        let first = self.cursor.here();
        let start = self.cursor.at;
        let count = std::iter::from_fn(|| Some(self.cursor.word()).filter(|word| !word.is_empty())).take(5).count();
        let end = std::mem::replace(&mut self.cursor.at, start);
        match count {
            1 if self.cursor.clone().number() == Ok(1.0) => {}
            1 => self.skip(Skipped::Weight, first),
            3 | 4 => match self.color(count) {
                Some(color) => {
                    let position = self.out.positions.len() - 1;
                    self.out.colors.resize(position, NONE);
                    self.out.colors.push(color);
                }
                None => self.skip(Skipped::BadColour, first),
            },
            _ => self.skip(Skipped::MoreNumbers, first),
        }
        self.cursor.at = end;
    }

    /// `r g b` or `r g b a`
    fn color(&mut self, count: usize) -> Option<[f32; 4]> {
        let mut color = WHITE;
        for channel in &mut color[..count] {
            self.cursor.skip_blanks();
            *channel = self.cursor.number().ok()? as f32;
        }
        color.iter().all(|c| c.is_finite()).then_some(color)
    }

    /// Reports an error at a word; its text is only made if it is kept.
    #[cold]
    fn error(&mut self, at: usize, make: impl FnOnce(&Self, &str) -> Diagnostic) {
        self.cursor.at = at;
        let error = if self.out.errors.is_full(Severity::Error) {
            Diagnostic::error("")
        } else {
            let here = self.cursor.here();
            let word = shown(&self.cursor.bytes[here.clone()]);
            make(self, &word).at(self.place(here))
        };
        self.out.errors.push(error);
    }

    fn place(&self, range: Range<usize>) -> Span {
        Span::new(self.file, self.start + range.start..self.start + range.end)
    }

    /// `vt u [v [w]]`
    #[inline(always)]
    fn texture_vertex(&mut self) {
        let mut uv = [0.0; 2];
        for (i, value) in uv.iter_mut().enumerate() {
            match self.cursor.number() {
                Ok(number) => *value = number as f32,
                Err(NumberError::Missing) if i == 1 => break,
                Err(NumberError::NotFinite) => *value = f32::INFINITY,
                Err(error) => {
                    self.bad_number(error, "u v of a texture vertex");
                    break;
                }
            }
            if !value.is_finite() {
                self.skip(Skipped::BadUv, self.cursor.here());
                uv = [0.0; 2];
                break;
            }
        }
        self.out.uvs.push(uv);
    }

    /// `vn x y z`
    #[inline(always)]
    fn normal(&mut self) {
        let mut normal = [0.0; 3];
        for value in &mut normal {
            match self.cursor.number() {
                Ok(number) => *value = number as f32,
                Err(NumberError::NotFinite) => *value = f32::INFINITY,
                Err(error) => {
                    self.bad_number(error, "x y z of a normal");
                    break;
                }
            }
            if !value.is_finite() {
                self.skip(Skipped::BadNormal, self.cursor.here());
                normal = [0.0; 3];
                break;
            }
        }
        self.out.normals.push(unit_normal(DVec3::from(normal.map(f64::from))));
    }

    fn bad_number(&mut self, error: NumberError, what: &str) {
        self.error(self.cursor.at, |_, word| number_error(error, word, what));
    }

    /// `f v[/[vt][/vn]] ...`
    #[inline(always)]
    fn face(&mut self) {
        self.cursor.skip_blanks();
        let first = self.out.corners.len();
        let start = self.cursor.at;
        let (mut has_uvs, mut has_normals) = (false, false);
        loop {
            self.cursor.skip_blanks();
            if self.cursor.at_line_end() {
                break;
            }
            match self.corner() {
                Some(corner) => {
                    has_uvs |= corner[1] != Index::ABSENT;
                    has_normals |= corner[2] != Index::ABSENT;
                    self.out.corners.push(corner);
                }
                None => return self.out.corners.truncate(first),
            }
        }
        let size = self.out.corners.len() - first;
        if size < 3 {
            self.out.corners.truncate(first);
            return self.skip(Skipped::FewCorners, start..self.cursor.at);
        }
        self.out.has_uvs |= has_uvs;
        self.out.has_normals |= has_normals;
        let face = self.out.faces.count();
        if face.is_multiple_of(FACES_A_PLACE) {
            self.out.face_places.push(start);
        }
        self.out.faces.push(size as u32);
        self.out.materials.face(face);
        self.out.smoothing.face(face);
        self.out.groups.face(face);
    }

    /// One corner, or `None` after a report.
    #[inline(always)]
    fn corner(&mut self) -> Option<[Index; 3]> {
        let start = self.cursor.at;
        let mut corner = [Index::ABSENT; 3];
        for (kind, slot) in corner.iter_mut().enumerate() {
            if kind > 0 {
                if self.cursor.peek() != Some(b'/') {
                    break;
                }
                self.cursor.at += 1;
            }
            match self.index() {
                // Not in the format, but some programs write it for "none".
                Some(0) if kind > 0 => self.skip(Skipped::IndexZero, start..self.cursor.at),
                Some(index) => *slot = self.resolve(index, kind, start)?,
                None if kind == 0 => return self.bad_corner(start),
                None => {}
            }
        }
        match self.cursor.peek() {
            None | Some(b' ' | b'\t' | b'\n' | b'\r' | b'\\' | b'\x0b' | b'\x0c') => Some(corner),
            _ => self.bad_corner(start),
        }
    }

    /// A whole number, saturating.
    #[inline(always)]
    fn index(&mut self) -> Option<i64> {
        let negative = self.cursor.peek() == Some(b'-');
        let start = self.cursor.at + usize::from(negative);
        let mut value = 0;
        let end = digits(self.cursor.bytes, start, &mut value);
        if end == start {
            return None;
        }
        // Longer ones could wrap, or begin with zeros.
        let value = if end - start <= 9 { value as i64 } else { self.long_index(start..end) };
        self.cursor.at = end;
        Some(if negative { -value } else { value })
    }

    #[cold]
    fn long_index(&self, digits: Range<usize>) -> i64 {
        let add = |value: i64, digit: &u8| (value * 10 + i64::from(digit - b'0')).min(i64::from(u32::MAX));
        self.cursor.bytes[digits].iter().fold(0, add)
    }

    /// From the file's count from 1, or back from the latest, to a count from 0.
    #[inline(always)]
    fn resolve(&mut self, index: i64, kind: usize, start: usize) -> Option<Index> {
        if index > 0 && index <= self.largest[kind] {
            self.out.highest[kind] = self.out.highest[kind].max(index);
            return Some(Index { value: (index - 1).min(i64::from(u32::MAX) - 1) as u32, relative: false });
        }
        if index < 0 {
            let from_start = self.out.counts()[kind] as i64 + index;
            if self.known.is_none_or(|known| known.base[kind] as i64 + from_start >= 0) {
                self.out.lowest[kind] = self.out.lowest[kind].min(from_start);
                return Some(Index { value: from_start as u32, relative: true });
            }
        }
        self.bad_index(index, kind, start)
    }

    #[cold]
    fn bad_index(&mut self, index: i64, kind: usize, start: usize) -> Option<Index> {
        let name = KINDS[kind];
        self.error(start, |parser, _| {
            let error = if index >= i64::from(u32::MAX) {
                Diagnostic::error(format!("{name} index is too large"))
            } else {
                Diagnostic::error(format!("no {name} {index} in this file"))
            };
            let known = parser.known.unwrap_or(Known { base: [0; 3], totals: [0; 3] });
            match index {
                0 => error.label("indices count from 1, or backwards from -1"),
                1.. => error.label(format!("there are {}", known.totals[kind])),
                _ => {
                    error.label(format!("there are {} before this line", known.base[kind] + parser.out.counts()[kind]))
                }
            }
        });
        None
    }

    #[cold]
    fn bad_corner(&mut self, start: usize) -> Option<[Index; 3]> {
        self.error(start, |_, word| {
            Diagnostic::error(format!("`{word}` is not a corner of a face"))
                .label("expected v, v/vt, v//vn or v/vt/vn with whole numbers")
        });
        None
    }

    fn use_material(&mut self) {
        let range = self.cursor.name();
        let name = joined(&self.cursor.bytes[range.clone()]);
        let next = self.out.material_names.len() as u32;
        let id = match self.material_ids.get(&name) {
            Some(id) => *id,
            None => {
                let place = self.start + range.start..self.start + range.end;
                self.out.material_names.push(Named { name: name.to_vec(), place });
                self.material_ids.insert(name, next);
                next
            }
        };
        self.out.materials.current = Some(id);
    }

    fn named(&mut self) -> Named {
        let range = self.cursor.name();
        let name = joined(&self.cursor.bytes[range.clone()]).into_owned();
        Named { name, place: self.start + range.start..self.start + range.end }
    }

    fn keep_name(&mut self) -> NameAt {
        let range = self.cursor.name();
        let name = joined(&self.cursor.bytes[range]);
        let start = self.out.names.len();
        self.out.names.extend_from_slice(&name);
        // So that no two names have the same place.
        self.out.names.push(b'\n');
        NameAt { start, length: name.len() }
    }

    /// `s off`, `s 0` or `s N`
    fn smoothing(&mut self) {
        let word = self.cursor.word();
        let group = match &self.cursor.bytes[word.clone()] {
            b"" | b"off" => 0,
            b"on" => 1,
            digits => match str::from_utf8(digits).ok().and_then(|text| text.parse().ok()) {
                Some(group) => group,
                None => {
                    self.skip(Skipped::BadSmoothing, word);
                    0
                }
            },
        };
        self.out.smoothing.current = Some(group);
    }
}

/// The error for a word that is not the number that was expected.
pub(crate) fn number_error(error: NumberError, word: &str, what: &str) -> Diagnostic {
    let expected = format!("expected {what}");
    match error {
        NumberError::Missing => Diagnostic::error("a number is missing").label(expected),
        NumberError::NotFinite => Diagnostic::error(format!("`{word}` is not a finite number")).label(expected),
        NumberError::Malformed => {
            let error = Diagnostic::error(format!("`{word}` is not a number")).label(expected);
            if word.contains(',') { error.help("decimals are written with a point") } else { error }
        }
    }
}
