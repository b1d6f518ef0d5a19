//! Reading text formats by line and word, straight from bytes.

pub(crate) mod cursor;
pub(crate) mod number;
pub(crate) mod tally;

pub(crate) use cursor::{Cursor, NumberError};
pub(crate) use tally::Tally;

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
