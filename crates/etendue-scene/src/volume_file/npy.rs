//! NumPy's array files (NEP 1; formats 1.0, 2.0 and 3.0): a magic word, the length of a header, the header, the samples. The header
//! is a dictionary as Python writes it.

use super::{Array, ByteOrder, File, SampleType, VolumeError};

/// The first bytes.
pub(crate) const MAGIC: &[u8] = b"\x93NUMPY";
/// Most bytes of a header; NumPy itself takes up to 10,000.
const MOST_HEADER: usize = 1 << 16;
const FORMAT: &str = "NPY";

pub(super) fn read<'a>(file: &File<'a>) -> Result<Array<'a>, VolumeError> {
    if !file.bytes.starts_with(MAGIC) {
        let what = "this is no NPY file, and nothing says what else it is";
        return Err(
            file.unsupported(what, "save an array with numpy.save, or describe a raw file by `size` and `sample`")
        );
    }
    let (header, start) = header(file.bytes).map_err(|Wrong { at, what }| file.damaged(FORMAT, at, what))?;
    array(file, header, start)
}

/// The header of a file that begins with [`MAGIC`], and where its samples start.
pub(crate) fn header(bytes: &[u8]) -> Result<(Header, usize), Wrong> {
    let cut = |what: &str| Wrong { at: bytes.len(), what: format!("the file ends inside of {what}") };
    let version = bytes.get(6..8).ok_or_else(|| cut("its version"))?;
    let (start, length) = match version[0] {
        1 => (10, bytes.get(8..10).map(|b| usize::from(u16::from_le_bytes([b[0], b[1]])))),
        2 | 3 => (12, bytes.get(8..12).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]) as usize)),
        major => {
            let what = format!("version {major}.{} of the format is not known, only 1 to 3 are", version[1]);
            return Err(Wrong { at: 6, what });
        }
    };
    let length = length.ok_or_else(|| cut("the length of its header"))?;
    if length > MOST_HEADER {
        let what = format!("a header of {length} bytes; at most {MOST_HEADER} are read");
        return Err(Wrong { at: 8, what });
    }
    let header = bytes.get(start..start + length).ok_or_else(|| cut("its header"))?;
    let header = Header::parse(header).map_err(|Wrong { at, what }| Wrong { at: start + at, what })?;
    Ok((header, start + length))
}

fn array<'a>(file: &File<'a>, header: Header, start: usize) -> Result<Array<'a>, VolumeError> {
    let (sample, byte_order, boolean) = sample_type(&header.descr).ok_or_else(|| {
        let what = format!("an array of type `{}` is no density", header.descr);
        file.unsupported(what, "expected bool, uint8, uint16, float16, float32 or float64: save a.astype(\"float32\")")
    })?;
    let shape = shape(&header.shape).ok_or_else(|| {
        let what = format!("an array of shape ({}) is no volume", header.shape.text());
        file.unsupported(what, "expected three dimensions, such as numpy.zeros((64, 32, 64), \"float32\")")
    })?;
    let expected = file.length_of(shape, sample)?;
    let rest = &file.bytes[start..];
    if rest.len() as u64 != expected {
        let what = format!("{} bytes of samples, but shape and type make {expected}", rest.len());
        return Err(file.damaged(FORMAT, start, what));
    }
    Ok(Array { shape, sample, byte_order, boolean, fortran: header.fortran, bytes: rest })
}

/// The type of samples, their byte order, and whether they are booleans.
fn sample_type(descr: &str) -> Option<(SampleType, ByteOrder, bool)> {
    let (order, kind) = descr.split_at_checked(1)?;
    let sample = match kind {
        "u1" | "b1" => SampleType::U8,
        "u2" => SampleType::U16,
        "f2" => SampleType::F16,
        "f4" => SampleType::F32,
        "f8" => SampleType::F64,
        _ => return None,
    };
    let order = match order {
        // `|`: of no meaning; `=`: as on the machine that wrote it, which NumPy does not write.
        "<" | "|" | "=" => ByteOrder::Little,
        ">" => ByteOrder::Big,
        _ => return None,
    };
    Some((sample, order, kind == "b1"))
}

/// Three dimensions; more if those behind have one element.
fn shape(shape: &Shape) -> Option<[u32; 3]> {
    let (first, more) = shape.0.split_at_checked(3)?;
    if more.iter().any(|n| *n != 1) {
        return None;
    }
    let counts: Vec<u32> = first.iter().map(|n| u32::try_from(*n).ok()).collect::<Option<_>>()?;
    counts.try_into().ok()
}

/// Counts of elements.
#[derive(Debug, PartialEq)]
pub(crate) struct Shape(pub Vec<u64>);

impl Shape {
    pub fn text(&self) -> String {
        self.0.iter().map(u64::to_string).collect::<Vec<_>>().join(", ")
    }
}

/// What is wrong with a header, and where in it.
#[derive(Debug, PartialEq)]
pub(crate) struct Wrong {
    pub at: usize,
    pub what: String,
}

/// What a file says of its array.
#[derive(Debug, PartialEq)]
pub(crate) struct Header {
    /// Type and byte order of the samples, as NumPy writes them.
    pub descr: String,
    /// True if the first index varies fastest.
    pub fortran: bool,
    /// How long each dimension is.
    pub shape: Shape,
}

impl Header {
    /// `{'descr': '<f4', 'fortran_order': False, 'shape': (3, 4, 5), }`, the keys in any order.
    fn parse(bytes: &[u8]) -> Result<Self, Wrong> {
        let mut text = Text { bytes, at: 0 };
        let (mut descr, mut fortran, mut shape) = (None, None, None);
        text.expect(b'{')?;
        while !text.take(b'}') {
            let at = text.at;
            let key = text.string()?;
            text.expect(b':')?;
            match &key[..] {
                "descr" => descr = Some(text.string()?),
                "fortran_order" => fortran = Some(text.boolean()?),
                "shape" => shape = Some(text.counts()?),
                _ => return Err(Wrong { at, what: format!("unknown key `{key}` in the header") }),
            }
            if !text.take(b',') {
                text.expect(b'}')?;
                break;
            }
        }
        text.blanks();
        if text.at < bytes.len() {
            return Err(text.wrong("the end of the header"));
        }
        let lacks = |key: &str| Wrong { at: 0, what: format!("the header has no `{key}`") };
        Ok(Self {
            descr: descr.ok_or_else(|| lacks("descr"))?,
            fortran: fortran.ok_or_else(|| lacks("fortran_order"))?,
            shape: shape.ok_or_else(|| lacks("shape"))?,
        })
    }
}

/// Text of a header, read from left to right.
struct Text<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl Text<'_> {
    fn blanks(&mut self) {
        while self.bytes.get(self.at).is_some_and(u8::is_ascii_whitespace) {
            self.at += 1;
        }
    }

    /// Steps over a character if it is there.
    fn take(&mut self, wanted: u8) -> bool {
        self.blanks();
        let found = self.bytes.get(self.at) == Some(&wanted);
        self.at += usize::from(found);
        found
    }

    fn expect(&mut self, wanted: u8) -> Result<(), Wrong> {
        if self.take(wanted) { Ok(()) } else { Err(self.wrong(&format!("`{}`", char::from(wanted)))) }
    }

    fn wrong(&self, expected: &str) -> Wrong {
        let found = match self.bytes.get(self.at) {
            Some(byte) => format!("`{}`", byte.escape_ascii()),
            None => "the end".to_owned(),
        };
        Wrong { at: self.at, what: format!("expected {expected} in the header, found {found}") }
    }

    /// Text in single or double quotes. NumPy writes no escapes in what is read here.
    fn string(&mut self) -> Result<String, Wrong> {
        self.blanks();
        let quote = match self.bytes.get(self.at) {
            Some(quote @ (b'\'' | b'"')) => *quote,
            _ => return Err(self.wrong("a string")),
        };
        let rest = &self.bytes[self.at + 1..];
        let Some(length) = rest.iter().position(|b| *b == quote) else { return Err(self.wrong("a string that ends")) };
        self.at += length + 2;
        Ok(String::from_utf8_lossy(&rest[..length]).into_owned())
    }

    fn boolean(&mut self) -> Result<bool, Wrong> {
        self.blanks();
        let rest = &self.bytes[self.at..];
        for (word, value) in [(&b"True"[..], true), (b"False", false)] {
            if rest.starts_with(word) {
                self.at += word.len();
                return Ok(value);
            }
        }
        Err(self.wrong("True or False"))
    }

    /// `(3, 4, 5)`, `(3,)` or `()`.
    fn counts(&mut self) -> Result<Shape, Wrong> {
        // NumPy has no more dimensions than that.
        const MOST: usize = 64;
        let mut counts = Vec::new();
        self.expect(b'(')?;
        while !self.take(b')') {
            if counts.len() == MOST {
                return Err(self.wrong(&format!("at most {MOST} dimensions")));
            }
            counts.push(self.count()?);
            if !self.take(b',') {
                self.expect(b')')?;
                break;
            }
        }
        Ok(Shape(counts))
    }

    fn count(&mut self) -> Result<u64, Wrong> {
        self.blanks();
        let digits = self.bytes[self.at..].iter().take_while(|b| b.is_ascii_digit()).count();
        let text = str::from_utf8(&self.bytes[self.at..self.at + digits]).unwrap_or_default();
        let Ok(count) = text.parse() else { return Err(self.wrong("a whole number of at most 64 bits")) };
        self.at += digits;
        // Python 2 wrote long integers as `3L`.
        self.at += usize::from(self.bytes.get(self.at) == Some(&b'L'));
        Ok(count)
    }
}
