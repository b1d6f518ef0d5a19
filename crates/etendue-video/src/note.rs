//! A line of text in a film, for programs: what the film was made of, say. Players do not show it.
//!
//! It stands behind the frames, in a place that each format has for such things, so that nothing has to wait for it: in MP4 a box
//! `uuid` of its own, in GIF a comment, in PNG a `tEXt` chunk.

use crate::Kind;
use std::io::{self, BufRead, Read, Seek, SeekFrom};

/// The name of the box in MP4 films (ISO/IEC 14496-12, 11.1).
#[cfg_attr(not(feature = "h264"), allow(dead_code))]
pub(crate) const BOX: [u8; 16] = *b"\x6b\x1e\xd3\x9f\x52\x0c\x4a\x7d\x8e\x11\x9b\x40\xe7\x2a\x05\xc6";
/// The keyword of the chunk in PNG films.
pub(crate) const KEYWORD: &str = "Comment";
/// Longest note that is read, bytes: that of a film of as many frames as there may be with 65 bytes for each.
const LONGEST: u64 = 66 * crate::MAX_FRAMES;

impl Kind {
    /// Whether a film of this kind can hold a note.
    pub const fn keeps_note(self) -> bool {
        !matches!(self, Self::Y4m)
    }

    /// The last note in a film of this kind, which the reader stands at the start of. `None` if there is none, or the film is damaged or of
    /// another kind.
    ///
    /// # Errors
    /// Those of the reader.
    pub fn note(self, reader: &mut (impl BufRead + Seek)) -> io::Result<Option<String>> {
        let found = match self {
            Self::Mp4 => of_mp4(reader),
            Self::Gif => of_gif(reader),
            Self::Apng => of_png(reader),
            Self::Y4m => Ok(None),
        };
        match found {
            Ok(note) => Ok(note.and_then(|bytes| String::from_utf8(bytes).ok())),
            // What ends too early is no film.
            Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(None),
            Err(error) => Err(error),
        }
    }
}

fn bytes<const N: usize>(reader: &mut impl Read) -> io::Result<[u8; N]> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// So many bytes, which are read as they come: a wrong number takes no memory.
fn text(reader: &mut impl Read, length: u64) -> io::Result<Option<Vec<u8>>> {
    if length > LONGEST {
        return Ok(None);
    }
    let mut text = Vec::new();
    reader.take(length).read_to_end(&mut text)?;
    Ok((text.len() as u64 == length).then_some(text))
}

fn skip(reader: &mut impl Seek, length: u64) -> io::Result<()> {
    let length = i64::try_from(length).map_err(|_| io::ErrorKind::UnexpectedEof)?;
    reader.seek_relative(length)
}

/// Boxes one after another: a length of 32 bits, a name, a length of 64 bits if the first is 1.
fn of_mp4(reader: &mut (impl BufRead + Seek)) -> io::Result<Option<Vec<u8>>> {
    let end = end_of(reader)?;
    let (mut found, mut at) = (None, reader.stream_position()?);
    while at < end {
        let length: [u8; 4] = bytes(reader)?;
        let name: [u8; 4] = bytes(reader)?;
        let (length, header) = match u32::from_be_bytes(length) {
            0 => (end - at, 8),
            1 => (u64::from_be_bytes(bytes(reader)?), 16),
            length => (length.into(), 8),
        };
        let Some(content) = length.checked_sub(header).filter(|_| length <= end - at) else { return Ok(None) };
        if name == *b"uuid" && content >= 16 {
            let is_ours = bytes::<16>(reader)? == BOX;
            if is_ours {
                found = text(reader, content - 16)?;
            } else {
                skip(reader, content - 16)?;
            }
        } else {
            skip(reader, content)?;
        }
        at += length;
    }
    Ok(found)
}

/// Blocks (GIF89a, 15 to 27): images and extensions, their bytes in pieces of up to 255.
fn of_gif(reader: &mut (impl BufRead + Seek)) -> io::Result<Option<Vec<u8>>> {
    const PALETTE: u8 = 0x80;
    let entries = |flags: u8| 3 * (2u64 << (flags & 7));
    let head: [u8; 13] = bytes(reader)?;
    if !head.starts_with(b"GIF8") {
        return Ok(None);
    }
    if head[10] & PALETTE != 0 {
        skip(reader, entries(head[10]))?;
    }
    let mut found = None;
    loop {
        match bytes::<1>(reader)? {
            [0x2c] => {
                let image: [u8; 9] = bytes(reader)?;
                if image[8] & PALETTE != 0 {
                    skip(reader, entries(image[8]))?;
                }
                skip(reader, 1)?;
                pieces(reader, None)?;
            }
            [0x21] => {
                let [label] = bytes(reader)?;
                let mut comment = (label == 0xfe).then(Vec::new);
                pieces(reader, comment.as_mut())?;
                found = comment.or(found);
            }
            [0x3b] => return Ok(found),
            _ => return Ok(None),
        }
    }
}

/// Pieces up to an empty one.
fn pieces(reader: &mut (impl BufRead + Seek), mut keep: Option<&mut Vec<u8>>) -> io::Result<()> {
    loop {
        match (bytes::<1>(reader)?, &mut keep) {
            ([0], _) => return Ok(()),
            ([length], Some(keep)) if keep.len() as u64 <= LONGEST => {
                reader.take(length.into()).read_to_end(keep)?;
            }
            ([length], _) => skip(reader, length.into())?,
        }
    }
}

/// Chunks: a length, a name, the bytes, a checksum.
fn of_png(reader: &mut (impl BufRead + Seek)) -> io::Result<Option<Vec<u8>>> {
    if bytes::<8>(reader)? != *b"\x89PNG\r\n\x1a\n" {
        return Ok(None);
    }
    let mut found = None;
    loop {
        let length: u64 = u32::from_be_bytes(bytes(reader)?).into();
        match &bytes::<4>(reader)? {
            b"IEND" => {
                let _: [u8; 4] = bytes(reader)?;
                return Ok(found);
            }
            b"tEXt" => {
                let Some(chunk) = text(reader, length)? else { return Ok(None) };
                let is_note = chunk.strip_prefix(KEYWORD.as_bytes()).and_then(|rest| rest.strip_prefix(&[0]));
                found = is_note.map(<[u8]>::to_vec).or(found);
            }
            _ => skip(reader, length)?,
        }
        skip(reader, 4)?;
    }
}

fn end_of(reader: &mut impl Seek) -> io::Result<u64> {
    let at = reader.stream_position()?;
    let end = reader.seek(SeekFrom::End(0))?;
    reader.seek(SeekFrom::Start(at))?;
    Ok(end)
}
