//! Large texts in pieces that end with lines, on several threads.

use crate::content::{BLOCK_BYTES, Content, digest_of_block, digest_of_blocks};
use std::{
    io,
    num::NonZero,
    ops::Range,
    sync::{
        Mutex,
        atomic::{AtomicUsize, Ordering},
    },
    thread,
};

/// More threads would only wait for memory.
const MOST_THREADS: usize = 16;

/// Bytes beyond a block that are read at first to find the end of its last line.
const MARGIN: usize = 1 << 12;

/// Bytes before a block that tell whether a line begins with it: a backslash and the end of a line.
const BEFORE: usize = 3;

/// Part of a text: whole lines, continued ones included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece<'a> {
    /// Its number.
    pub number: usize,
    /// Where it begins in the text.
    pub start: usize,
    /// Its bytes; none where a line is longer than a piece.
    pub bytes: &'a [u8],
}

/// Bytes in a piece, but for what its last line needs. Fixed, so that nothing depends on the machine.
pub(crate) const PIECE_BYTES: usize = BLOCK_BYTES;

/// Calls `work` with every piece of about `size` bytes of a text, on threads of its own if there are several pieces; returns
/// what it returned, in the order of the text. Each byte is in one piece. If the text is on disk and `size` is
/// [`PIECE_BYTES`], its digest is found on the way.
///
/// # Errors
/// What the disk says.
pub(crate) fn map_pieces<T: Send>(
    content: &Content,
    size: usize,
    work: impl Fn(Piece) -> T + Sync,
) -> io::Result<Vec<T>> {
    let blocks = content.len().div_ceil(size);
    let threads = thread::available_parallelism().map_or(1, NonZero::get).min(MOST_THREADS).min(blocks);
    let hashed = matches!(content, Content::Disk(_)) && size == BLOCK_BYTES;
    let next = AtomicUsize::new(0);
    let done: Mutex<Vec<(usize, [u8; 32], T)>> = Mutex::new(Vec::with_capacity(blocks));
    let run = || -> io::Result<()> {
        let mut buffer = Vec::new();
        loop {
            let number = next.fetch_add(1, Ordering::Relaxed);
            if number >= blocks {
                return Ok(());
            }
            let block = number * size..((number + 1) * size).min(content.len());
            let (window, lines) = read_lines(content, block.clone(), &mut buffer)?;
            let piece = Piece { number, start: lines.start, bytes: window.of(lines) };
            let result = work(piece);
            let digest = if hashed { digest_of_block(window.of(block)) } else { [0; 32] };
            lock(&done).push((number, digest, result));
        }
    };
    thread::scope(|scope| {
        let others: Vec<_> = (1..threads).map(|_| scope.spawn(run)).collect();
        let first = run();
        others.into_iter().fold(first, |result, other| match other.join() {
            Ok(other) => result.and(other),
            Err(panic) => std::panic::resume_unwind(panic),
        })
    })?;
    let mut done = done.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner());
    done.sort_unstable_by_key(|(number, ..)| *number);
    if let (Content::Disk(disk), true) = (content, hashed) {
        disk.set_digest(digest_of_blocks(done.iter().map(|(_, digest, _)| *digest)));
    }
    Ok(done.into_iter().map(|(.., result)| result).collect())
}

/// Without a second panic if another thread had one, which the join passes on.
fn lock<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(|poisoned| poisoned.into_inner())
}

/// Bytes of a text from an offset on.
struct Window<'a> {
    start: usize,
    bytes: &'a [u8],
}

impl<'a> Window<'a> {
    fn of(&self, range: Range<usize>) -> &'a [u8] {
        &self.bytes[range.start - self.start..range.end - self.start]
    }

    /// The first place from `from` on where a line begins that does not continue another.
    fn line_start(&self, from: usize) -> Option<usize> {
        if from == 0 {
            return Some(0);
        }
        let first = from - self.start;
        let starts = (first..=self.bytes.len()).find(|&at| {
            let backslash = |before: usize| at.checked_sub(before).is_some_and(|i| self.bytes[i] == b'\\');
            match self.bytes[at - 1] {
                b'\n' if at >= 2 && self.bytes[at - 2] == b'\r' => !backslash(3),
                b'\n' | b'\r' => !backslash(2),
                _ => false,
            }
        });
        starts.map(|at| self.start + at)
    }
}

/// The lines that begin in `block`, and a window about both.
fn read_lines<'b>(
    content: &'b Content,
    block: Range<usize>,
    buffer: &'b mut Vec<u8>,
) -> io::Result<(Window<'b>, Range<usize>)> {
    let start = block.start.saturating_sub(BEFORE);
    let mut margin = MARGIN;
    loop {
        let end = block.end.saturating_add(margin).min(content.len());
        let window = Window { start, bytes: content.piece(start..end, buffer)? };
        let none = block.end..block.end;
        let lines = match window.line_start(block.start).filter(|&first| first < block.end) {
            None => Some(none),
            Some(first) if block.end == content.len() => Some(first..block.end),
            Some(first) => match window.line_start(block.end) {
                Some(last) => Some(first..last),
                None if end == content.len() => Some(first..end),
                None => None,
            },
        };
        if let Some(lines) = lines {
            // Borrowed anew, since a loop may not return what it borrowed before.
            return Ok((Window { start, bytes: content.again(start..end, buffer) }, lines));
        }
        margin = margin.saturating_mul(4);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Arc;

    fn pieces(text: &str, size: usize) -> Vec<(usize, String)> {
        let content = Content::Bytes(Arc::new(text.as_bytes().to_vec()));
        let own = |piece: Piece| (piece.number, piece.start, String::from_utf8(piece.bytes.to_vec()).unwrap());
        let all = map_pieces(&content, size, own).unwrap();
        assert!(all.iter().enumerate().all(|(i, (number, ..))| i == *number));
        all.into_iter().map(|(_, start, text)| (start, text)).collect()
    }

    #[test]
    fn pieces_are_whole_lines_and_cover_the_text() {
        let long = format!("x{}\ny", "1 \\\n".repeat(3000));
        for text in ["", "a", "a\n", "a\nb", "ab\r\ncd\r\n\r\n", "a \\\nb \\\r\nc\\\rd\ne", "\r\r\n\n", long.as_str()] {
            for size in [1, 2, 3, 4, 5, 7, 100, 1 << 20] {
                let pieces = pieces(text, size);
                let joined: String = pieces.iter().map(|(_, piece)| piece.as_str()).collect();
                assert!(joined == text, "{size}: {text:.40}");
                let mut at = 0;
                for (start, piece) in pieces.iter().filter(|(_, piece)| !piece.is_empty()) {
                    assert_eq!(*start, at);
                    at += piece.len();
                    let whole = at == text.len() || piece.ends_with(['\n', '\r']);
                    let continued = ["\\\n", "\\\r", "\\\r\n"].iter().any(|end| piece.ends_with(end));
                    assert!(whole && (!continued || at == text.len()), "{size}: {:.40}", piece);
                }
            }
        }
        assert_eq!(pieces("ab\ncd\nef\n", 3).len(), 3);
        assert_eq!(pieces("ab\ncd\nef\n", 3)[1], (3, "cd\n".to_owned()));
    }

    #[test]
    fn the_digest_is_found_on_the_way() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("x");
        let text = "0123456789\n".repeat(BLOCK_BYTES / 5);
        std::fs::write(&path, &text).unwrap();
        let mut sources = crate::SourceMap::new();
        let file = sources.open(&path, u64::MAX, 0).unwrap();
        let lines = map_pieces(&sources.content(file), PIECE_BYTES, |piece| piece.bytes.len() / 11).unwrap();
        assert_eq!((lines.len(), lines.iter().sum::<usize>()), (3, text.len() / 11));
        // Found, not made again from the file, which is no longer the same.
        std::fs::write(&path, "").unwrap();
        let memory = Content::Bytes(Arc::new(text.into_bytes()));
        assert_eq!(sources.digest(file), memory.digest());
    }
}
