//! Reading text formats by line and word, straight from bytes.

pub(crate) mod cursor;
pub(crate) mod number;
pub(crate) mod pieces;
pub(crate) mod tally;

pub(crate) use cursor::{Cursor, NumberError};
pub(crate) use tally::Tally;

use std::borrow::Cow;

/// True if a file looks like UTF-16, with a byte order mark or two ASCII characters at its start: no text format here allows it.
pub(crate) fn is_utf16(start: &[u8]) -> bool {
    let plain = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    match *start {
        [0xff, 0xfe, ..] | [0xfe, 0xff, ..] => true,
        [a, 0, b, 0, ..] | [0, a, 0, b, ..] => plain(a) && plain(b),
        _ => false,
    }
}

/// A name that the lines of [`Cursor::name`] hold: a continued line's end, with the blanks about it, becomes one blank.
pub(crate) fn joined(name: &[u8]) -> Cow<'_, [u8]> {
    let mut cuts = continued_ends(name).peekable();
    if cuts.peek().is_none() {
        return Cow::Borrowed(name);
    }
    let mut text: Vec<u8> = Vec::with_capacity(name.len());
    let mut start = 0;
    for (end, next) in cuts.chain([(name.len(), name.len())]) {
        let part = name[start..end].trim_ascii();
        if !part.is_empty() && !text.is_empty() {
            text.push(b' ');
        }
        text.extend_from_slice(part);
        start = next;
    }
    Cow::Owned(text)
}

/// Where backslashes at the ends of lines stand, and where the lines after them begin.
fn continued_ends(bytes: &[u8]) -> impl Iterator<Item = (usize, usize)> {
    let backslashes = bytes.iter().enumerate().filter(|(_, byte)| **byte == b'\\');
    backslashes.filter_map(|(at, _)| match bytes[at + 1..] {
        [b'\r', b'\n', ..] => Some((at, at + 3)),
        [b'\r' | b'\n', ..] => Some((at, at + 2)),
        _ => None,
    })
}

/// Bytes of a word that a message shows.
const SHOWN: usize = 40;

/// A word of a file, for a message: cut if it is long, bytes that are not UTF-8 and control characters replaced.
pub(crate) fn shown(word: &[u8]) -> String {
    let lossy = String::from_utf8_lossy(&word[..word.len().min(SHOWN)]);
    let mut text: String = lossy.chars().map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if word.len() > SHOWN {
        text.push('…');
    }
    text
}

/// "1 face", "3 faces".
pub(crate) fn counted(count: usize, thing: &str) -> String {
    if count == 1 { format!("1 {thing}") } else { format!("{count} {thing}s") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_over_several_lines() {
        for (name, text) in [
            ("a b", "a b"),
            ("a \\\n b", "a b"),
            ("a\\\r\nb  c\\\rd", "a b  c d"),
            ("a\\b", "a\\b"),
            ("\\\n\\\na", "a"),
        ] {
            assert_eq!(joined(name.as_bytes()), text.as_bytes(), "{name:?}");
        }
    }

    #[test]
    fn utf16_is_seen() {
        for (start, is) in [
            (&b"\xff\xfev\0"[..], true),
            (b"\xfe\xff\0v", true),
            (b"v\0 \0", true),
            (b"\0#\0 ", true),
            (b"v 0 0", false),
            (b"\0\0\0\0", false),
            (b"\xef\xbb\xbfv", false),
            (b"v", false),
        ] {
            assert_eq!(is_utf16(start), is, "{start:?}");
        }
    }
}
