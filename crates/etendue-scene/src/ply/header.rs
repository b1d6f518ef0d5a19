//! The header of a PLY file.

use crate::{Diagnostic, Diagnostics, FileId, Severity, Span, text::shown};
use std::ops::Range;

/// How the data are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// Types of numbers.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    fn named(name: &[u8]) -> Option<Self> {
        Some(match name {
            b"char" | b"int8" => Self::I8,
            b"uchar" | b"uint8" => Self::U8,
            b"short" | b"int16" => Self::I16,
            b"ushort" | b"uint16" => Self::U16,
            b"int" | b"int32" => Self::I32,
            b"uint" | b"uint32" => Self::U32,
            b"float" | b"float32" => Self::F32,
            b"double" | b"float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes in binary data.
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    fn is_float(self) -> bool {
        matches!(self, Self::F32 | Self::F64)
    }
}

const TYPES: [&str; 8] = ["char", "uchar", "short", "ushort", "int", "uint", "float", "double"];

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { length: Scalar, item: Scalar },
}

#[derive(Clone, Debug)]
pub(super) struct Property {
    pub name: String,
    pub kind: Kind,
    pub place: Range<usize>,
}

#[derive(Clone, Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
    pub place: Range<usize>,
}

impl Element {
    /// Bytes that one of these takes at least: in text two for each value, its end included.
    pub fn least_size(&self, encoding: Encoding) -> u64 {
        let size = |property: &Property| match (encoding, property.kind) {
            (Encoding::Ascii, _) => 2,
            (_, Kind::Scalar(scalar)) => scalar.size() as u64,
            (_, Kind::List { length, .. }) => length.size() as u64,
        };
        self.properties.iter().map(size).sum()
    }
}

#[derive(Clone, Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Where the data begin.
    pub data: usize,
}

/// Most elements and properties together; real files have some ten.
const MOST: usize = 1024;

struct Lines<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Lines end with CR LF, so that the LF after the header's last CR is not data.
    crlf: bool,
}

impl<'a> Lines<'a> {
    /// The words of the next line, and the line's end.
    fn next(&mut self) -> Option<(Vec<Range<usize>>, usize)> {
        if self.at >= self.bytes.len() {
            return None;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n' || b == b'\r').unwrap_or(rest.len());
        let (start, end) = (self.at, self.at + length);
        let mut words = vec![];
        let mut at = start;
        for word in self.bytes[start..end].split(|b| matches!(b, b' ' | b'\t')) {
            if !word.is_empty() && words.len() < 8 {
                words.push(at..at + word.len());
            }
            at += word.len() + 1;
        }
        self.at = (end + 1).min(self.bytes.len());
        if start == 0 {
            self.crlf = self.bytes[end..].starts_with(b"\r\n");
        }
        if self.crlf && self.bytes[end..].starts_with(b"\r\n") {
            self.at = end + 2;
        }
        Some((words, end))
    }
}

/// Reads the header.
///
/// # Errors
/// Whatever it should not hold, each with its place.
pub(super) fn parse(bytes: &[u8], file: FileId) -> Result<Header, Diagnostics> {
    let mut parser = Parser { bytes, file, errors: Diagnostics::new(), elements: vec![], encoding: None, size: 0 };
    let data = parser.run();
    let error = |message: &str, place| Diagnostic::error(message).at(Span::new(file, place));
    if data.is_none() && !parser.errors.has_errors() {
        parser.errors.push(error("the header does not end", bytes.len()..bytes.len()).label("expected `end_header`"));
    }
    if parser.encoding.is_none() && !parser.errors.has_errors() {
        let place = 0..bytes.len().min(3);
        parser
            .errors
            .push(error("the header has no format", place).label("expected a line `format ... 1.0` after this"));
    }
    match (parser.encoding, data, parser.errors.has_errors()) {
        (Some(encoding), Some(data), false) => Ok(Header { encoding, elements: parser.elements, data }),
        _ => Err(parser.errors),
    }
}

struct Parser<'a> {
    bytes: &'a [u8],
    file: FileId,
    errors: Diagnostics,
    elements: Vec<Element>,
    encoding: Option<Encoding>,
    size: usize,
}

impl Parser<'_> {
    fn error(&mut self, message: String, place: Range<usize>, label: &str) {
        self.errors.push(Diagnostic::error(message).at(Span::new(self.file, place)).label(label));
    }

    /// Reads up to the header's end, and returns where the data begin.
    fn run(&mut self) -> Option<usize> {
        let mut lines = Lines { bytes: self.bytes, at: 0, crlf: false };
        let magic = lines.next().and_then(|(words, _)| words.first().cloned());
        if magic.as_ref().is_none_or(|word| &self.bytes[word.clone()] != b"ply") {
            self.error("not a PLY file".into(), 0..0, "expected `ply` in the first line");
            return None;
        }
        while let Some((words, end)) = lines.next() {
            let key = words.first().map_or(&[][..], |word| &self.bytes[word.clone()]);
            match key {
                b"" | b"comment" | b"obj_info" => {}
                b"end_header" => return Some(lines.at),
                b"format" => self.format(&words, end),
                b"element" => self.element(&words, end),
                b"property" => self.property(&words, end),
                _ => {
                    let word = words[0].clone();
                    let message = format!("unknown header line `{}`", shown(key));
                    self.error(message, word, "expected format, element, property, comment or end_header");
                }
            }
            if self.errors.is_full(Severity::Error) || self.size > MOST {
                break;
            }
        }
        if self.size > MOST {
            self.error(format!("more than {MOST} elements and properties"), 0..0, "a real header has some ten");
        }
        None
    }

    /// Word `i` of a line, with its place; at the line's end if there are fewer.
    fn word<'b>(&'b self, words: &[Range<usize>], i: usize, end: usize) -> (&'b [u8], Range<usize>) {
        let place = words.get(i).cloned().unwrap_or(end..end);
        (&self.bytes[place.clone()], place)
    }

    fn format(&mut self, words: &[Range<usize>], end: usize) {
        let (name, place) = self.word(words, 1, end);
        let encoding = match name {
            b"ascii" => Encoding::Ascii,
            b"binary_little_endian" => Encoding::LittleEndian,
            b"binary_big_endian" => Encoding::BigEndian,
            _ => {
                let message = format!("unknown format `{}`", shown(name));
                return self.error(message, place, "expected ascii, binary_little_endian or binary_big_endian");
            }
        };
        let (version, place) = self.word(words, 2, end);
        if version != b"1.0" {
            let message = format!("unknown version `{}`", shown(version));
            return self.error(message, place, "expected 1.0");
        }
        self.encoding = Some(encoding);
    }

    fn element(&mut self, words: &[Range<usize>], end: usize) {
        self.size += 1;
        let (name, place) = self.word(words, 1, end);
        let name = String::from_utf8_lossy(name).into_owned();
        let (count, count_place) = self.word(words, 2, end);
        match str::from_utf8(count).ok().and_then(|text| text.parse().ok()) {
            Some(count) => {
                if self.elements.iter().any(|element| element.name == name) {
                    self.error(
                        format!("element `{}` is there twice", shown(name.as_bytes())),
                        place.clone(),
                        "the second",
                    );
                }
                self.elements.push(Element { name, count, properties: vec![], place: place.start..count_place.end });
            }
            None => {
                let message = format!("`{}` is not a number of elements", shown(count));
                self.error(message, count_place, "expected `element NAME COUNT`");
            }
        }
    }

    fn scalar(&mut self, words: &[Range<usize>], i: usize, end: usize) -> Option<Scalar> {
        let (name, place) = self.word(words, i, end);
        let found = Scalar::named(name);
        if found.is_none() {
            let text = shown(name);
            let error = Diagnostic::error(format!("unknown type `{text}`")).at(Span::new(self.file, place));
            self.errors.push(error.label(format!("expected one of {}", TYPES.join(", "))).suggest(&text, TYPES));
        }
        found
    }

    fn property(&mut self, words: &[Range<usize>], end: usize) {
        self.size += 1;
        let is_list = self.word(words, 1, end).0 == b"list";
        let (kind, name_at) = if is_list {
            let (Some(length), Some(item)) = (self.scalar(words, 2, end), self.scalar(words, 3, end)) else { return };
            if length.is_float() {
                let place = words[2].clone();
                return self.error(
                    "the length of a list cannot be a float".into(),
                    place,
                    "expected a whole-number type",
                );
            }
            (Kind::List { length, item }, 4)
        } else {
            let Some(scalar) = self.scalar(words, 1, end) else { return };
            (Kind::Scalar(scalar), 2)
        };
        let (name, place) = self.word(words, name_at, end);
        if name.is_empty() {
            return self.error("a property without a name".into(), place, "expected a name");
        }
        let property = Property { name: String::from_utf8_lossy(name).into_owned(), kind, place: place.clone() };
        match self.elements.last_mut() {
            Some(element) => element.properties.push(property),
            None => self.error("a property before the first element".into(), place, "expected an `element` line first"),
        }
    }
}
