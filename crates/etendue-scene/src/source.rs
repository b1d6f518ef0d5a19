//! The files that a scene was read from, and places in them.

use std::{
    fs::File,
    io::{self, Read},
    ops::Range,
    path::{Path, PathBuf},
    sync::{Arc, OnceLock},
};

/// Names one file of a [`SourceMap`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct FileId(u32);

/// A range of bytes in a file; `start <= end`, and empty at the end of the file for what is missing there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Span {
    /// The file.
    pub file: FileId,
    /// First byte.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl Span {
    /// Bytes `range` of `file`.
    pub fn new(file: FileId, range: Range<usize>) -> Self {
        Self { file, start: range.start, end: range.end.max(range.start) }
    }
}

/// Where a record came from.
#[non_exhaustive]
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Origin {
    /// Bytes of a file.
    File(Span),
}

impl Origin {
    /// The bytes, if it came from a file.
    pub fn span(&self) -> Option<Span> {
        match self {
            Origin::File(span) => Some(*span),
        }
    }
}

impl From<Span> for Origin {
    fn from(span: Span) -> Self {
        Origin::File(span)
    }
}

/// Why a file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum SourceError {
    /// Nothing there.
    #[error("no such file: {}", .0.display())]
    NotFound(PathBuf),
    /// A folder.
    #[error("is a folder, not a file: {}", .0.display())]
    IsDirectory(PathBuf),
    /// Not allowed to read it.
    #[error("no permission to read {}", .0.display())]
    PermissionDenied(PathBuf),
    /// Larger than the limit; checked before memory is taken.
    #[error("{} is larger than the limit of {limit} bytes", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// The limit that it passed.
        limit: u64,
    },
    /// Not enough memory for its bytes.
    #[error("not enough memory to read {}", .0.display())]
    OutOfMemory(PathBuf),
    /// More than 2^32 - 1 files.
    #[error("too many files")]
    TooManyFiles,
    /// Anything else.
    #[error("cannot read {}: {error}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        error: io::Error,
    },
}

impl SourceError {
    fn from_io(path: &Path, error: io::Error) -> Self {
        let path = path.to_owned();
        match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => Self::NotFound(path),
            io::ErrorKind::IsADirectory => Self::IsDirectory(path),
            io::ErrorKind::PermissionDenied => Self::PermissionDenied(path),
            io::ErrorKind::OutOfMemory => Self::OutOfMemory(path),
            _ => Self::Io { path, error },
        }
    }
}

/// Pipes and devices do not tell their size, so that they are read to at most this many bytes.
const UNSIZED_LIMIT: u64 = 256 << 20;

/// Reads a whole file of at most `limit` bytes. Nothing near the limit is allocated unless the file holds it.
pub fn read_bytes(path: &Path, limit: u64) -> Result<Vec<u8>, SourceError> {
    let fail = |error| SourceError::from_io(path, error);
    let mut file = File::open(path).map_err(fail)?;
    let metadata = file.metadata().map_err(fail)?;
    if metadata.is_dir() {
        return Err(SourceError::IsDirectory(path.to_owned()));
    }
    let limit = if metadata.is_file() { limit } else { limit.min(UNSIZED_LIMIT) };
    let too_large = || SourceError::TooLarge { path: path.to_owned(), limit };
    if metadata.is_file() && metadata.len() > limit {
        return Err(too_large());
    }
    let mut bytes = Vec::new();
    let expected = usize::try_from(metadata.len()).map_err(|_| too_large())?;
    bytes.try_reserve_exact(expected).map_err(|_| SourceError::OutOfMemory(path.to_owned()))?;
    file.by_ref().take(limit.saturating_add(1)).read_to_end(&mut bytes).map_err(fail)?;
    if bytes.len() as u64 > limit { Err(too_large()) } else { Ok(bytes) }
}

/// A place as people count it: lines and columns from 1, columns in characters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Position {
    /// Line, from 1.
    pub line: usize,
    /// Column, from 1, in characters; a byte that is not UTF-8 counts as one.
    pub column: usize,
}

/// The part of a source line that a message shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Excerpt {
    /// Where the span starts.
    pub position: Position,
    /// The line without its end; of a long line the part about the span. Bytes that are not UTF-8 are replaced.
    pub text: String,
    /// The bytes of `text` to underline, on character borders; cut at the line's end, may be empty.
    pub highlight: Range<usize>,
    /// `text` starts after the line's start.
    pub cut_before: bool,
    /// `text` ends before the line's end.
    pub cut_after: bool,
}

/// Bytes between entries of the table of line numbers.
const BLOCK: usize = 1 << 16;

/// Longest excerpt: bytes before, and from, the start of the span.
const EXCERPT_BEFORE: usize = 100;
const EXCERPT_AFTER: usize = 160;

/// One file.
#[derive(Debug)]
struct SourceFile {
    path: PathBuf,
    bytes: Arc<Vec<u8>>,
    /// Line feeds before each block of `BLOCK` bytes, made when a place is first asked for.
    lines_before: OnceLock<Vec<usize>>,
}

fn line_feeds(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&b| b == b'\n').count()
}

impl SourceFile {
    fn line_number(&self, offset: usize) -> usize {
        let blocks = self.lines_before.get_or_init(|| {
            let sums = self.bytes.chunks(BLOCK).scan(0, |sum, block| {
                *sum += line_feeds(block);
                Some(*sum)
            });
            std::iter::once(0).chain(sums).collect()
        });
        let block = offset / BLOCK;
        blocks[block] + line_feeds(&self.bytes[block * BLOCK..offset]) + 1
    }

    /// The bytes of the line that holds `offset`, without its end and without a byte order mark.
    fn line_range(&self, offset: usize) -> Range<usize> {
        let bytes = &self.bytes[..];
        let mut start = bytes[..offset].iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
        let mut end = bytes[offset..].iter().position(|&b| b == b'\n').map_or(bytes.len(), |i| offset + i);
        if end > start && bytes[end - 1] == b'\r' {
            end -= 1;
        }
        if start == 0 && bytes.starts_with(b"\xef\xbb\xbf") && end >= 3 {
            start = 3;
        }
        start..end
    }

    /// Moves `offset` back to the start of a UTF-8 character, at most three bytes.
    fn character_start(&self, offset: usize, lowest: usize) -> usize {
        let is_start = |i: usize| self.bytes.get(i).is_none_or(|b| b & 0xc0 != 0x80);
        (offset.saturating_sub(3).max(lowest)..=offset).rev().find(|&i| is_start(i)).unwrap_or(offset)
    }
}

/// All files that were read, by id, in the order of reading.
#[derive(Debug, Default)]
pub struct SourceMap {
    files: Vec<SourceFile>,
}

impl SourceMap {
    /// No files.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds bytes that were read elsewhere (standard input, an archive, a test) under a name.
    pub fn insert(&mut self, path: impl Into<PathBuf>, bytes: Vec<u8>) -> Result<FileId, SourceError> {
        let id = u32::try_from(self.files.len()).map_err(|_| SourceError::TooManyFiles)?;
        self.files.push(SourceFile { path: path.into(), bytes: Arc::new(bytes), lines_before: OnceLock::new() });
        Ok(FileId(id))
    }

    /// Reads a file of at most `limit` bytes. A path that is already here is not read again.
    pub fn read(&mut self, path: &Path, limit: u64) -> Result<FileId, SourceError> {
        match self.find(path) {
            Some(id) => Ok(id),
            None => self.insert(path, read_bytes(path, limit)?),
        }
    }

    /// The file with this path, spelt the same way.
    pub fn find(&self, path: &Path) -> Option<FileId> {
        self.ids().find(|&id| self.path(id) == path)
    }

    /// Every file, in the order of reading.
    pub fn ids(&self) -> impl Iterator<Item = FileId> + use<> {
        (0..self.files.len() as u32).map(FileId)
    }

    fn file(&self, id: FileId) -> &SourceFile {
        &self.files[id.0 as usize]
    }

    /// The path as it was given.
    pub fn path(&self, id: FileId) -> &Path {
        &self.file(id).path
    }

    /// The bytes, shared.
    pub fn bytes(&self, id: FileId) -> Arc<Vec<u8>> {
        self.file(id).bytes.clone()
    }

    /// Line and column of a span's start; an offset beyond the file counts as its end.
    pub fn position(&self, span: Span) -> Position {
        let file = self.file(span.file);
        let offset = span.start.min(file.bytes.len());
        let start = file.line_range(offset).start.min(offset);
        let column = String::from_utf8_lossy(&file.bytes[start..offset]).chars().count() + 1;
        Position { line: file.line_number(offset), column }
    }

    /// The source line of a span's start, for display.
    pub fn excerpt(&self, span: Span) -> Excerpt {
        let file = self.file(span.file);
        let offset = span.start.min(file.bytes.len());
        let line = file.line_range(offset);
        // An offset inside the byte order mark or the line's end is shown at the line's nearest byte.
        let focus = offset.clamp(line.start, line.end);
        let start = file.character_start(focus.saturating_sub(EXCERPT_BEFORE).max(line.start), line.start);
        let end = file.character_start(focus.saturating_add(EXCERPT_AFTER).min(line.end), focus);
        let lossy = |range: Range<usize>| String::from_utf8_lossy(&file.bytes[range]).into_owned();
        let marked_end = span.end.clamp(focus, end);
        let (before, marked) = (lossy(start..focus), lossy(focus..marked_end));
        let highlight = before.len()..before.len() + marked.len();
        Excerpt {
            position: self.position(span),
            text: before + &marked + &lossy(marked_end..end),
            highlight,
            cut_before: start > line.start,
            cut_after: end < line.end,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn place(text: &[u8], start: usize, end: usize) -> Excerpt {
        let mut map = SourceMap::new();
        let file = map.insert("a", text.to_vec()).unwrap();
        map.excerpt(Span::new(file, start..end))
    }

    #[test]
    fn lines_and_columns() {
        let text = "\u{feff}é = 1\r\nxy\n\nlast".as_bytes();
        let find = |s: &str| text.windows(s.len()).position(|w| w == s.as_bytes()).unwrap();
        let at = |s: &str| place(text, find(s), find(s) + s.len());
        assert_eq!(at("=").position, Position { line: 1, column: 3 });
        assert_eq!(at("=").text, "é = 1");
        assert_eq!(&at("=").text[at("=").highlight], "=");
        assert_eq!(at("y").position, Position { line: 2, column: 2 });
        let end = place(text, text.len(), text.len());
        assert_eq!((end.position, end.text.as_str()), (Position { line: 4, column: 5 }, "last"));
        assert_eq!(end.highlight, 4..4);
        assert_eq!(place(text, 1, 2).position, Position { line: 1, column: 1 });
        assert_eq!(place(text, 10_000, 10_001).position.line, 4);
        assert_eq!(place(b"", 0, 0).position, Position { line: 1, column: 1 });
    }

    #[test]
    fn bytes_that_are_not_utf8_count_as_one_column() {
        let e = place(b"\xff\xfe x", 3, 4);
        assert_eq!(e.position.column, 4);
        assert_eq!(&e.text[e.highlight.clone()], "x");
    }

    #[test]
    fn long_lines_are_cut_and_block_borders_do_not_matter() {
        let mut text = vec![b'a'; 3 * BLOCK];
        text[BLOCK - 1] = b'\n';
        text[2 * BLOCK] = b'\n';
        for offset in [0, BLOCK - 1, BLOCK, BLOCK + 1, 2 * BLOCK, 2 * BLOCK + 1, 3 * BLOCK] {
            let expected = text[..offset].iter().filter(|&&b| b == b'\n').count() + 1;
            let e = place(&text, offset, offset + 1);
            assert_eq!(e.position.line, expected, "{offset}");
            assert!(e.text.len() <= EXCERPT_BEFORE + EXCERPT_AFTER + 6);
        }
        let e = place(&text, BLOCK + 500, BLOCK + 600);
        assert!(e.cut_before && e.cut_after);
        assert_eq!(e.highlight.len(), 100);
    }

    #[test]
    fn every_offset_of_any_bytes_has_a_place() {
        let text = b"\xef\xbb\xbf\r\n\xe2\x82\xac\xe2\x82 \r\r\n\n\xf0\x9f\x98\x80x\r";
        for start in 0..=text.len() + 2 {
            for end in start..=text.len() + 2 {
                let e = place(text, start, end);
                assert!(e.text.get(e.highlight.clone()).is_some(), "{start}..{end}: {e:?}");
            }
        }
    }

    #[test]
    fn reading_is_bounded_and_errors_are_typed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        assert!(matches!(read_bytes(&path, 10), Err(SourceError::NotFound(_))));
        assert!(matches!(read_bytes(folder.path(), 10), Err(SourceError::IsDirectory(_))));
        std::fs::write(&path, b"0123456789").unwrap();
        assert_eq!(read_bytes(&path, 10).unwrap(), b"0123456789");
        assert!(matches!(read_bytes(&path, 9), Err(SourceError::TooLarge { limit: 9, .. })));
        assert!(matches!(read_bytes(&path.join("y"), 9), Err(SourceError::NotFound(_))));
        #[cfg(unix)]
        assert!(matches!(read_bytes(Path::new("/dev/zero"), 100), Err(SourceError::TooLarge { limit: 100, .. })));
        let mut map = SourceMap::new();
        let id = map.read(&path, 10).unwrap();
        std::fs::write(&path, b"changed").unwrap();
        assert_eq!(map.read(&path, 10).unwrap(), id);
        assert_eq!(*map.bytes(id), b"0123456789");
    }
}
