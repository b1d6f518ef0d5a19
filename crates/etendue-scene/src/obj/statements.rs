//! The statements of an OBJ file, as arrays.

use super::{skipped::Skipped, unifier::NONE};
use crate::{
    Diagnostic, Diagnostics, FileId, Severity, Span,
    positions::LARGEST,
    text::{Cursor, NumberError, Tally, shown},
};
use glam::DVec3;
use std::{collections::BTreeMap, ops::Range};

/// What an OBJ file says, indices resolved to count from 0. Materials and groups are runs of faces.
pub(super) struct Statements<'a> {
    pub positions: Vec<DVec3>,
    pub uvs: Vec<[f32; 2]>,
    /// As in the file, zero if not finite.
    pub normals: Vec<[f32; 3]>,
    pub corners: Corners,
    pub faces: Faces,
    pub materials: Runs<u32>,
    /// Smoothing groups; 0 is none.
    pub smoothing: Runs<u32>,
    pub groups: Runs<Names>,
    /// Centre, radius, material.
    pub spheres: Vec<(DVec3, f64, u32)>,
    /// Names that `usemtl` uses, with the place of the first use.
    pub material_names: Vec<(&'a [u8], Span)>,
    /// Names that `mtllib` gives.
    pub libraries: Vec<Range<usize>>,
    /// Where every 1024th face stands.
    face_places: Vec<usize>,
    pub errors: Diagnostics,
    pub skipped: Tally<Skipped>,
    /// A statement of the format was seen.
    pub is_obj: bool,
}

/// Face corners: index of the position, and of texture coordinates and normal where some corner so far had them.
#[derive(Default)]
pub(super) struct Corners {
    pub positions: Vec<u32>,
    uvs: Vec<u32>,
    normals: Vec<u32>,
}

impl Corners {
    #[inline(always)]
    fn push(&mut self, [position, uv, normal]: [u32; 3]) {
        let count = self.positions.len();
        self.positions.push(position);
        push_sparse(&mut self.uvs, count, uv);
        push_sparse(&mut self.normals, count, normal);
    }

    fn truncate(&mut self, count: usize) {
        self.positions.truncate(count);
        self.uvs.truncate(count);
        self.normals.truncate(count);
    }

    pub fn has_uvs(&self) -> bool {
        !self.uvs.is_empty()
    }

    pub fn has_normals(&self) -> bool {
        !self.normals.is_empty()
    }

    pub fn uv(&self, corner: usize) -> u32 {
        self.uvs.get(corner).copied().unwrap_or(NONE)
    }

    pub fn normal(&self, corner: usize) -> u32 {
        self.normals.get(corner).copied().unwrap_or(NONE)
    }
}

/// Appends to an array that stays empty until the first value that is not `NONE`.
#[inline(always)]
fn push_sparse(values: &mut Vec<u32>, count: usize, value: u32) {
    if value != NONE || !values.is_empty() {
        if values.len() < count {
            values.resize(count, NONE);
        }
        values.push(value);
    }
}

/// Corners of each face, in order.
pub(super) enum Faces {
    /// So many triangles.
    Triangles(u32),
    /// The numbers of corners.
    Mixed(Vec<u32>),
}

impl Faces {
    pub fn count(&self) -> u32 {
        match self {
            Faces::Triangles(count) => *count,
            Faces::Mixed(sizes) => sizes.len() as u32,
        }
    }

    pub fn size(&self, face: u32) -> u32 {
        match self {
            Faces::Triangles(_) => 3,
            Faces::Mixed(sizes) => sizes[face as usize],
        }
    }

    #[inline(always)]
    fn push(&mut self, size: u32) {
        match self {
            Faces::Triangles(count) if size == 3 => *count += 1,
            Faces::Triangles(count) => {
                let mut sizes = vec![3; *count as usize];
                sizes.push(size);
                *self = Faces::Mixed(sizes);
            }
            Faces::Mixed(sizes) => sizes.push(size),
        }
    }
}

/// A value for each face that changes rarely.
#[derive(Clone)]
pub(super) struct Runs<T> {
    current: T,
    pub runs: Vec<(u32, T)>,
}

impl<T: Clone + PartialEq> Runs<T> {
    fn new(first: T) -> Self {
        Self { current: first, runs: Vec::new() }
    }

    #[inline(always)]
    fn face(&mut self, face: u32) {
        if self.runs.last().is_none_or(|(_, last)| *last != self.current) {
            self.runs.push((face, self.current.clone()));
        }
    }

    /// The value of `face`, moving `run`, the number of the run of a face before it.
    pub fn at(&self, face: u32, run: &mut usize) -> &T {
        while self.runs.get(*run + 1).is_some_and(|(first, _)| *first <= face) {
            *run += 1;
        }
        &self.runs[*run].1
    }
}

/// Where the names of object and group stand.
#[derive(Clone, PartialEq, Eq)]
pub(super) struct Names {
    pub object: Option<Range<usize>>,
    pub group: Option<Range<usize>>,
}

/// Numbers of positions, texture coordinates and normals.
type Counts = [usize; 3];

const KINDS: [&str; 3] = ["vertex", "texture vertex", "normal"];

/// Faces from one remembered place to the next.
const FACES_A_PLACE: u32 = 1024;

impl Statements<'_> {
    /// Where a face stands, for a message.
    pub fn face_place(&self, bytes: &[u8], face: u32) -> Range<usize> {
        let mut cursor = Cursor { bytes, at: self.face_places[(face / FACES_A_PLACE) as usize] };
        let mut left = face % FACES_A_PLACE;
        loop {
            let words = std::iter::from_fn(|| Some(cursor.word()).filter(|word| !word.is_empty()));
            let (count, place) = words.fold((0, None), |(count, place): (u32, Option<Range<usize>>), word| {
                (count + 1, Some(place.map_or(word.start, |place| place.start)..word.end))
            });
            // Faces with fewer corners were skipped.
            if count >= 3 {
                match left.checked_sub(1) {
                    Some(rest) => left = rest,
                    None => return place.unwrap_or(0..0),
                }
            }
            loop {
                cursor.next_line();
                if cursor.is_done() {
                    return bytes.len()..bytes.len();
                }
                if &bytes[cursor.word()] == b"f" {
                    break;
                }
            }
        }
    }
}

struct Parser<'a> {
    cursor: Cursor<'a>,
    file: FileId,
    out: Statements<'a>,
    material_ids: BTreeMap<&'a [u8], u32>,
    /// The counts of the whole file, known on a second reading.
    totals: Option<Counts>,
    /// One more than the largest indices used ahead of their definition.
    ahead: Counts,
}

/// Reads the statements of a file. Positive indices may run ahead of what they name; if one of them names nothing in the
/// end, the file is read again to find all such places.
pub(super) fn parse(bytes: &[u8], file: FileId) -> Statements<'_> {
    let mut parser = Parser::new(bytes, file, None);
    parser.run();
    let totals = parser.counts();
    if (0..3).any(|kind| parser.ahead[kind] > totals[kind]) {
        drop(parser);
        parser = Parser::new(bytes, file, Some(totals));
        parser.run();
    }
    parser.out.is_obj |= parser.counts() != [0; 3] || parser.out.faces.count() > 0;
    parser.out
}

impl<'a> Parser<'a> {
    fn new(bytes: &'a [u8], file: FileId, totals: Option<Counts>) -> Self {
        let out = Statements {
            positions: vec![],
            uvs: vec![],
            normals: vec![],
            corners: Corners::default(),
            faces: Faces::Triangles(0),
            materials: Runs::new(NONE),
            smoothing: Runs::new(0),
            groups: Runs::new(Names { object: None, group: None }),
            spheres: vec![],
            material_names: vec![],
            libraries: vec![],
            face_places: vec![],
            errors: Diagnostics::new(),
            skipped: Tally::new(),
            is_obj: false,
        };
        Self { cursor: Cursor::new(bytes), file, out, material_ids: BTreeMap::new(), totals, ahead: [0; 3] }
    }

    fn run(&mut self) {
        while !self.cursor.is_done() && !self.out.errors.is_full(Severity::Error) {
            self.statement();
            self.cursor.next_line();
        }
    }

    fn counts(&self) -> Counts {
        [self.out.positions.len(), self.out.uvs.len(), self.out.normals.len()]
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
                let name = self.cursor.name();
                self.out.libraries.push(name);
            }
            b"o" => self.out.groups.current = Names { object: Some(self.cursor.name()), group: None },
            b"g" => self.out.groups.current.group = Some(self.cursor.name()).filter(|name| !name.is_empty()),
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
        let key = &self.cursor.bytes[word.clone()];
        self.out.skipped.add(kind, if kind.names_the_word() { key } else { b"" }, self.file, word);
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
                self.cursor.at = start;
                self.too_large();
                None
            }
            Err(_) => {
                self.bad_number(what);
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
            self.cursor.at = start;
            let place = self.place(self.cursor.here());
            let error = Diagnostic::error("the radius of a sphere is not above 0").at(place);
            return self.out.errors.push(error.label("expected a number above 0"));
        }
        self.out.spheres.push((center, radius, self.out.materials.current));
        self.cursor.skip_blanks();
        if !self.cursor.at_line_end() {
            self.skip(Skipped::MoreNumbers, self.cursor.here());
        }
    }

    #[cold]
    fn rest_of_vertex(&mut self) {
        let first = self.cursor.here();
        let is_one = self.cursor.clone().number() == Ok(1.0);
        let count = std::iter::from_fn(|| Some(self.cursor.word()).filter(|word| !word.is_empty())).take(5).count();
        match count {
            1 if is_one => {}
            1 => self.skip(Skipped::Weight, first),
            3 | 4 => self.skip(Skipped::VertexColours, first),
            _ => self.skip(Skipped::MoreNumbers, first),
        }
    }

    #[cold]
    fn too_large(&mut self) {
        let place = self.place(self.cursor.here());
        let word = shown(&self.cursor.bytes[self.cursor.here()]);
        let error = Diagnostic::error(format!("coordinate {word} is too large")).at(place);
        self.out.errors.push(error.label(format!("expected at most {LARGEST:e}")));
    }

    fn place(&self, range: Range<usize>) -> Span {
        Span::new(self.file, range)
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
                Err(NumberError::Malformed | NumberError::Missing) => {
                    self.bad_number("u v of a texture vertex");
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
                Err(NumberError::Malformed | NumberError::Missing) => {
                    self.bad_number("x y z of a normal");
                    break;
                }
            }
            if !value.is_finite() {
                self.skip(Skipped::BadNormal, self.cursor.here());
                normal = [0.0; 3];
                break;
            }
        }
        self.out.normals.push(normal);
    }

    #[cold]
    fn bad_number(&mut self, what: &str) {
        let error = self.cursor.number().err().unwrap_or(NumberError::Malformed);
        let here = self.cursor.here();
        let word = shown(&self.cursor.bytes[here.clone()]);
        self.out.errors.push(number_error(error, &word, what).at(self.place(here)));
    }

    /// `f v[/[vt][/vn]] ...`
    #[inline(always)]
    fn face(&mut self) {
        self.cursor.skip_blanks();
        let first = self.out.corners.positions.len();
        let start = self.cursor.at;
        loop {
            self.cursor.skip_blanks();
            if self.cursor.at_line_end() {
                break;
            }
            match self.corner() {
                Some(corner) => self.out.corners.push(corner),
                None => return self.out.corners.truncate(first),
            }
        }
        let size = self.out.corners.positions.len() - first;
        if size < 3 {
            self.out.corners.truncate(first);
            return self.skip(Skipped::FewCorners, start..self.cursor.at);
        }
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
    fn corner(&mut self) -> Option<[u32; 3]> {
        let start = self.cursor.at;
        let mut corner = [NONE; 3];
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
        let mut at = start;
        let mut value = 0i64;
        while let Some(digit) = self.cursor.bytes.get(at).map(|b| b.wrapping_sub(b'0')).filter(|&d| d < 10) {
            value = (value * 10 + i64::from(digit)).min(i64::from(u32::MAX));
            at += 1;
        }
        if at == start {
            return None;
        }
        self.cursor.at = at;
        Some(if negative { -value } else { value })
    }

    /// From the file's count from 1, or back from the latest, to a count from 0.
    #[inline(always)]
    fn resolve(&mut self, index: i64, kind: usize, start: usize) -> Option<u32> {
        let count = match kind {
            0 => self.out.positions.len(),
            1 => self.out.uvs.len(),
            _ => self.out.normals.len(),
        } as i64;
        let resolved = if index > 0 { index - 1 } else { count + index };
        if (0..count).contains(&resolved) && index != 0 {
            return Some(resolved as u32);
        }
        self.resolve_ahead(index, kind, start)
    }

    #[cold]
    fn resolve_ahead(&mut self, index: i64, kind: usize, start: usize) -> Option<u32> {
        let count = self.counts()[kind];
        if index > 0 && self.totals.is_none_or(|totals| index as usize <= totals[kind]) {
            self.ahead[kind] = self.ahead[kind].max(index as usize);
            return Some((index - 1).min(i64::from(u32::MAX - 1)) as u32);
        }
        self.cursor.at = start;
        let word = self.cursor.here();
        let name = KINDS[kind];
        let message = format!("no {name} {index} in this file");
        let message = if index >= i64::from(u32::MAX) { format!("{name} index is too large") } else { message };
        let error = Diagnostic::error(message).at(self.place(word));
        self.out.errors.push(if index == 0 {
            error.label("indices count from 1, or backwards from -1")
        } else if index < 0 {
            error.label(format!("there are {count} before this line"))
        } else {
            error.label(format!("there are {}", self.totals.map_or(count, |totals| totals[kind])))
        });
        None
    }

    #[cold]
    fn bad_corner(&mut self, start: usize) -> Option<[u32; 3]> {
        self.cursor.at = start;
        let place = self.place(self.cursor.here());
        let word = shown(&self.cursor.bytes[self.cursor.here()]);
        let error = Diagnostic::error(format!("`{word}` is not a corner of a face")).at(place);
        self.out.errors.push(error.label("expected v, v/vt, v//vn or v/vt/vn with whole numbers"));
        None
    }

    fn use_material(&mut self) {
        let name = self.cursor.name();
        let next = self.out.material_names.len() as u32;
        let id = *self.material_ids.entry(&self.cursor.bytes[name.clone()]).or_insert(next);
        if id == next {
            self.out.material_names.push((&self.cursor.bytes[name.clone()], self.place(name)));
        }
        self.out.materials.current = id;
    }

    /// `s off`, `s 0` or `s N`
    fn smoothing(&mut self) {
        let word = self.cursor.word();
        self.out.smoothing.current = match &self.cursor.bytes[word.clone()] {
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
