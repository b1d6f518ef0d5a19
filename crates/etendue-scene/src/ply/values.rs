//! Numbers of PLY data, one after another, in the three encodings.

use super::header::Scalar;
use crate::text::{Cursor, NumberError};
use std::ops::Range;

/// Why there is no number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ValueError {
    /// The data end.
    Truncated,
    /// A line of text ends.
    Missing,
    /// A word of text is not a number of its type.
    Malformed,
}

/// A reader of numbers in order.
pub(super) trait Values {
    /// Before each element.
    fn begin(&mut self);

    /// The next number. Infinities and NaN are passed on.
    fn number(&mut self, kind: Scalar) -> Result<f64, ValueError>;

    /// After each element; true if something was left over on its line.
    fn end(&mut self) -> bool;

    /// Steps over whole elements of a fixed size in binary data; `None` if they have to be read.
    fn skip(&mut self, bytes: u64) -> Option<Result<(), ValueError>>;

    /// Where the next number stands, if that can be shown.
    fn place(&self) -> Option<Range<usize>>;

    /// Bytes left.
    fn left(&self) -> u64;

    /// The next word, for a message.
    fn word(&self) -> &[u8];
}

/// Binary data.
pub(super) struct Binary<'a, const BIG: bool> {
    pub rest: &'a [u8],
}

impl<const BIG: bool> Binary<'_, BIG> {
    #[inline(always)]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], ValueError> {
        let (bytes, rest) = self.rest.split_first_chunk::<N>().ok_or(ValueError::Truncated)?;
        self.rest = rest;
        let mut bytes = *bytes;
        if BIG {
            bytes.reverse();
        }
        Ok(bytes)
    }
}

impl<const BIG: bool> Values for Binary<'_, BIG> {
    #[inline(always)]
    fn begin(&mut self) {}

    #[inline(always)]
    fn number(&mut self, kind: Scalar) -> Result<f64, ValueError> {
        Ok(match kind {
            Scalar::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Scalar::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Scalar::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Scalar::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Scalar::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Scalar::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Scalar::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Scalar::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    #[inline(always)]
    fn end(&mut self) -> bool {
        false
    }

    fn skip(&mut self, bytes: u64) -> Option<Result<(), ValueError>> {
        let rest = usize::try_from(bytes).ok().and_then(|bytes| self.rest.get(bytes..));
        Some(match rest {
            Some(rest) => {
                self.rest = rest;
                Ok(())
            }
            None => Err(ValueError::Truncated),
        })
    }

    fn place(&self) -> Option<Range<usize>> {
        None
    }

    fn left(&self) -> u64 {
        self.rest.len() as u64
    }

    fn word(&self) -> &[u8] {
        &[]
    }
}

/// Text: one line an element.
pub(super) struct Text<'a> {
    pub cursor: Cursor<'a>,
}

impl Values for Text<'_> {
    fn begin(&mut self) {
        loop {
            self.cursor.skip_blanks();
            if self.cursor.is_done() || !matches!(self.cursor.peek(), Some(b'\n' | b'\r')) {
                return;
            }
            self.cursor.at += 1;
        }
    }

    #[inline]
    fn number(&mut self, kind: Scalar) -> Result<f64, ValueError> {
        let value = match self.cursor.number() {
            Ok(value) => value,
            Err(NumberError::Missing) if self.cursor.is_done() => return Err(ValueError::Truncated),
            Err(NumberError::Missing) => return Err(ValueError::Missing),
            Err(NumberError::Malformed) => return Err(ValueError::Malformed),
            Err(NumberError::NotFinite) => {
                self.cursor.word();
                f64::NAN
            }
        };
        // What a binary file of the same type would hold.
        Ok(if kind == Scalar::F32 { f64::from(value as f32) } else { value })
    }

    fn end(&mut self) -> bool {
        self.cursor.skip_blanks();
        let more = !matches!(self.cursor.peek(), None | Some(b'\n' | b'\r'));
        self.cursor.at = self.cursor.line_end();
        more
    }

    fn skip(&mut self, _: u64) -> Option<Result<(), ValueError>> {
        None
    }

    fn place(&self) -> Option<Range<usize>> {
        Some(self.cursor.here())
    }

    fn left(&self) -> u64 {
        (self.cursor.bytes.len() - self.cursor.at) as u64
    }

    fn word(&self) -> &[u8] {
        &self.cursor.bytes[self.cursor.here()]
    }
}
