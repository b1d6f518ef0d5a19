//! The files that a scene was read from, and places in them.

use crate::{
    content::{Content, DiskFile},
    parallel,
};
use std::{
    collections::HashMap,
    convert::Infallible,
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
    content: Content,
    /// For each block of `BLOCK` bytes, made when a place is first asked for.
    lines: OnceLock<Vec<LinesBefore>>,
    /// See [`SourceMap::digest`].
    digest: OnceLock<[u8; 32]>,
}

/// What lies before a block.
#[derive(Clone, Copy, Debug, Default)]
struct LinesBefore {
    /// Line feeds.
    count: usize,
    /// Where the line begins that the block begins in.
    start: usize,
}

fn line_feeds(bytes: &[u8]) -> usize {
    bytes.iter().filter(|&&b| b == b'\n').count()
}

/// Bytes that are not worth a thread to hash them.
const FEW: usize = 1 << 18;

/// Bytes before a place in which characters are counted; farther from the start of a line a byte counts as a column.
const COUNTED: usize = 1 << 20;

impl SourceFile {
    fn new(path: PathBuf, content: Content) -> Self {
        Self { path, content, lines: OnceLock::new(), digest: OnceLock::new() }
    }

    fn lines_before(&self, block: usize) -> LinesBefore {
        let table = self.lines.get_or_init(|| {
            let mut before = LinesBefore::default();
            let mut table = vec![before];
            let mut offset = 0;
            for bytes in self.content.blocks(BLOCK) {
                before.count += line_feeds(&bytes);
                if let Some(last) = bytes.iter().rposition(|&b| b == b'\n') {
                    before.start = offset + last + 1;
                }
                offset += bytes.len();
                table.push(before);
            }
            table
        });
        table[block]
    }

    /// After a byte order mark.
    fn text_start(&self) -> usize {
        let first = self.content.shown(0..self.content.len().min(3));
        if *first == *b"\xef\xbb\xbf" { 3 } else { 0 }
    }

    /// Where the line of `offset` begins, a byte order mark left out, and its number.
    fn line_start(&self, offset: usize) -> (usize, usize) {
        let block = offset / BLOCK;
        let before = self.lines_before(block);
        let bytes = self.content.shown(block * BLOCK..offset);
        let start = bytes.iter().rposition(|&b| b == b'\n').map_or(before.start, |i| block * BLOCK + i + 1);
        (start.max(self.text_start()), before.count + line_feeds(&bytes) + 1)
    }

    fn position(&self, offset: usize) -> Position {
        let (start, line) = self.line_start(offset);
        let offset = offset.max(start);
        let counted = start.max(offset.saturating_sub(COUNTED));
        let characters = String::from_utf8_lossy(&self.content.shown(counted..offset)).chars().count();
        Position { line, column: counted - start + characters + 1 }
    }

    /// What an excerpt about `offset` can show: the bytes from `start` to the end of the line, at most `EXCERPT_BEFORE` before
    /// `offset` and `EXCERPT_AFTER` from it on, on borders of characters.
    fn window(&self, offset: usize) -> Window {
        let (line_start, _) = self.line_start(offset);
        let offset = offset.max(line_start);
        let start = offset.saturating_sub(EXCERPT_BEFORE).max(line_start);
        // Beyond the excerpt: a byte to see whether it is cut, and the rest of a character and of a line's end.
        let length = self.content.len();
        let mut bytes = self.content.shown(start..(offset + EXCERPT_AFTER + 2).min(length)).into_owned();
        let line_end = bytes[offset - start..].iter().position(|&b| b == b'\n').map(|i| offset - start + i);
        let cut_after = line_end.is_none() && start + bytes.len() < length;
        if let Some(end) = line_end {
            bytes.truncate(end);
            if bytes.last() == Some(&b'\r') {
                bytes.pop();
            }
        }
        let limit = offset - start + EXCERPT_AFTER;
        let mut cut = cut_after;
        if bytes.len() > limit {
            bytes.truncate(character_start(&bytes, limit));
            cut = true;
        }
        let first = if start > line_start { leading_continuation(&bytes) } else { 0 };
        bytes.drain(..first);
        Window { start: start + first, bytes, cut_before: start > line_start, cut_after: cut }
    }
}

/// Bytes about a place, within one line.
struct Window {
    start: usize,
    bytes: Vec<u8>,
    cut_before: bool,
    cut_after: bool,
}

/// Moves `at` back to the start of a UTF-8 character, at most three bytes.
fn character_start(bytes: &[u8], at: usize) -> usize {
    let is_start = |i: usize| bytes.get(i).is_none_or(|b| b & 0xc0 != 0x80);
    (at.saturating_sub(3)..=at).rev().find(|&i| is_start(i)).unwrap_or(at)
}

/// Bytes at the start that continue a UTF-8 character which began before, at most three.
fn leading_continuation(bytes: &[u8]) -> usize {
    let count = bytes.iter().take_while(|b| **b & 0xc0 == 0x80).count();
    if count > 3 { 0 } else { count }
}

/// All files that were read, by id, in the order of reading.
#[derive(Debug, Default)]
pub struct SourceMap {
    files: Vec<SourceFile>,
    /// The first file of each path.
    by_path: HashMap<PathBuf, FileId>,
}

impl SourceMap {
    /// No files.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds bytes that were read elsewhere (standard input, an archive, a test) under a name.
    pub fn insert(&mut self, path: impl Into<PathBuf>, bytes: Vec<u8>) -> Result<FileId, SourceError> {
        self.add(path.into(), Content::Bytes(Arc::new(bytes)))
    }

    fn add(&mut self, path: PathBuf, content: Content) -> Result<FileId, SourceError> {
        let id = u32::try_from(self.files.len()).map_err(|_| SourceError::TooManyFiles)?;
        self.by_path.entry(path.clone()).or_insert(FileId(id));
        self.files.push(SourceFile::new(path, content));
        Ok(FileId(id))
    }

    /// Reads a file of at most `limit` bytes. A path that is already here is not read again.
    pub fn read(&mut self, path: &Path, limit: u64) -> Result<FileId, SourceError> {
        match self.find(path) {
            Some(id) => Ok(id),
            None => self.insert(path, read_bytes(path, limit)?),
        }
    }

    /// As [`SourceMap::read`], but a regular file of `disk_from` bytes or more stays on disk, open, for a reader that goes
    /// through it in pieces. Messages about it read the lines that they show; it must not be changed meanwhile.
    pub fn open(&mut self, path: &Path, limit: u64, disk_from: u64) -> Result<FileId, SourceError> {
        if let Some(id) = self.find(path) {
            return Ok(id);
        }
        let metadata = std::fs::metadata(path).map_err(|error| SourceError::from_io(path, error))?;
        if !cfg!(any(unix, windows)) || !metadata.is_file() || metadata.len() < disk_from {
            return self.read(path, limit);
        }
        let file = File::open(path).map_err(|error| SourceError::from_io(path, error))?;
        let length = file.metadata().map_err(|error| SourceError::from_io(path, error))?.len();
        match usize::try_from(length) {
            Ok(length) if length as u64 <= limit => {
                self.add(path.to_owned(), Content::Disk(Arc::new(DiskFile::new(file, length))))
            }
            _ => Err(SourceError::TooLarge { path: path.to_owned(), limit }),
        }
    }

    /// The file with this path, spelt the same way.
    pub fn find(&self, path: &Path) -> Option<FileId> {
        self.by_path.get(path).copied()
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

    /// The bytes, shared if they are in memory. Those of a file that was left on disk are read, and what cannot be read is
    /// zeros.
    pub fn bytes(&self, id: FileId) -> Arc<Vec<u8>> {
        match self.content(id) {
            Content::Bytes(bytes) => bytes,
            disk => Arc::new(disk.shown(0..disk.len()).into_owned()),
        }
    }

    pub(crate) fn content(&self, id: FileId) -> Content {
        self.file(id).content.clone()
    }

    /// Length of a file in bytes.
    pub fn length(&self, id: FileId) -> usize {
        self.file(id).content.len()
    }

    /// SHA-256 over the SHA-256 digests of a file's blocks of 4 MiB (the last is shorter), so that blocks can be hashed as
    /// they are read, in any order.
    pub fn digest(&self, id: FileId) -> [u8; 32] {
        let file = self.file(id);
        *file.digest.get_or_init(|| file.content.digest())
    }

    /// All digests in the order of the files; those that are not known yet are found several at a time.
    pub(crate) fn digests(&self) -> Vec<[u8; 32]> {
        let unknown: Vec<FileId> = self.ids().filter(|id| self.file(*id).digest.get().is_none()).collect();
        let bytes: usize = unknown.iter().map(|id| self.length(*id)).sum();
        // Few bytes are hashed before another thread has begun.
        let threads = parallel::threads(unknown.len().min(bytes.div_ceil(FEW)));
        let Ok(_) = parallel::run(
            threads,
            unknown.into_iter(),
            || (),
            |(), id| {
                self.digest(id);
                Ok::<_, Infallible>(())
            },
        );
        self.ids().map(|id| self.digest(id)).collect()
    }

    /// Line and column of a span's start; an offset beyond the file counts as its end.
    pub fn position(&self, span: Span) -> Position {
        let file = self.file(span.file);
        file.position(span.start.min(file.content.len()))
    }

    /// The source line of a span's start, for display.
    pub fn excerpt(&self, span: Span) -> Excerpt {
        let file = self.file(span.file);
        let offset = span.start.min(file.content.len());
        let Window { start, bytes, cut_before, cut_after } = file.window(offset);
        // An offset inside the byte order mark or the line's end is shown at the line's nearest byte.
        let focus = offset.saturating_sub(start).min(bytes.len());
        let marked_end = span.end.saturating_sub(start).clamp(focus, bytes.len());
        let lossy = |range: Range<usize>| String::from_utf8_lossy(&bytes[range]).into_owned();
        let (before, marked) = (lossy(0..focus), lossy(focus..marked_end));
        let highlight = before.len()..before.len() + marked.len();
        Excerpt {
            position: file.position(offset),
            text: before + &marked + &lossy(marked_end..bytes.len()),
            highlight,
            cut_before,
            cut_after,
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

    /// Places in a file on disk are those in the same bytes in memory.
    #[test]
    fn files_on_disk_tell_the_same() {
        let mut text = "\u{feff}ünïcode\r\n".repeat(3).into_bytes();
        text.extend(b"one long line ".repeat(20_000));
        text.extend("\nlast é\n".as_bytes());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        std::fs::write(&path, &text).unwrap();
        let (mut disk, mut memory) = (SourceMap::new(), SourceMap::new());
        let on_disk = disk.open(&path, 1 << 20, 1).unwrap();
        assert!(matches!(disk.content(on_disk), Content::Disk(_)));
        assert!(matches!(SourceMap::new().open(&path, 1000, 1), Err(SourceError::TooLarge { limit: 1000, .. })));
        let in_memory = memory.open(&path, 1 << 20, 1 << 20).unwrap();
        assert!(matches!(memory.content(in_memory), Content::Bytes(_)));
        assert_eq!(*disk.bytes(on_disk), text);
        assert_eq!((disk.length(on_disk), disk.digest(on_disk)), (text.len(), memory.digest(in_memory)));
        for start in (0..text.len() + 2).step_by(997).chain(0..60).chain(text.len() - 20..text.len() + 2) {
            let span = |file| Span::new(file, start..start + 5);
            assert_eq!(disk.excerpt(span(on_disk)), memory.excerpt(span(in_memory)), "{start}");
        }
        // A file that was cut short meanwhile ends in an excerpt of something, not in a panic.
        std::fs::write(&path, b"short").unwrap();
        disk.excerpt(Span::new(on_disk, text.len() - 5..text.len()));
    }
}
