//! NumPy's array files (NEP 1), format 1.0: a magic word, a header that Python reads as a dictionary, the elements in C order,
//! little-endian.

use super::EncodeError;
use std::io::{BufWriter, Write};

/// Elements of an array; the inner arrays are its last dimension.
#[derive(Clone, Copy, Debug)]
pub enum Elements<'a> {
    /// `u1`.
    U8(&'a [u8]),
    /// `u4`.
    U32(&'a [u32]),
    /// `f4`.
    F32(&'a [f32]),
    /// `f4`, two of them.
    Pairs(&'a [[f32; 2]]),
    /// `f4`, three of them.
    Triples(&'a [[f32; 3]]),
}

impl Elements<'_> {
    /// How many, inner arrays counted as one.
    pub fn count(&self) -> usize {
        match self {
            Self::U8(list) => list.len(),
            Self::U32(list) => list.len(),
            Self::F32(list) => list.len(),
            Self::Pairs(list) => list.len(),
            Self::Triples(list) => list.len(),
        }
    }

    /// Type and last dimension.
    fn kind(&self) -> (&'static str, Option<usize>) {
        match self {
            Self::U8(_) => ("|u1", None),
            Self::U32(_) => ("<u4", None),
            Self::F32(_) => ("<f4", None),
            Self::Pairs(_) => ("<f4", Some(2)),
            Self::Triples(_) => ("<f4", Some(3)),
        }
    }
}

/// Writes an array of `shape`, which an inner array adds a dimension to.
///
/// # Errors
/// When the elements do not fill the shape, or the file system refuses.
pub fn write(out: impl Write, shape: &[usize], elements: Elements<'_>) -> Result<(), EncodeError> {
    if shape.iter().try_fold(1usize, |n, side| n.checked_mul(*side)) != Some(elements.count()) {
        return Err(EncodeError::Malformed(format!("{} elements in an array of shape {shape:?}", elements.count())));
    }
    let mut out = BufWriter::with_capacity(1 << 16, out);
    out.write_all(&header(shape, elements))?;
    match elements {
        Elements::U8(list) => out.write_all(list)?,
        Elements::U32(list) => list.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))?,
        Elements::F32(list) => floats(&mut out, list)?,
        Elements::Pairs(list) => floats(&mut out, list.as_flattened())?,
        Elements::Triples(list) => floats(&mut out, list.as_flattened())?,
    }
    out.flush()?;
    Ok(())
}

fn floats(out: &mut impl Write, list: &[f32]) -> std::io::Result<()> {
    list.iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
}

/// The elements begin at a multiple of 64 bytes.
fn header(shape: &[usize], elements: Elements<'_>) -> Vec<u8> {
    const MAGIC: &[u8] = b"\x93NUMPY\x01\x00";
    let (kind, last) = elements.kind();
    let sides: String = shape.iter().copied().chain(last).map(|side| format!("{side}, ")).collect();
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({}), }}", sides.trim_end_matches(' '));
    let start = MAGIC.len() + 2;
    let length = (start + text.len() + 1).next_multiple_of(64) - start;
    let mut header = MAGIC.to_vec();
    header.extend((length as u16).to_le_bytes());
    header.extend(text.bytes());
    header.resize(start + length - 1, b' ');
    header.push(b'\n');
    header
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(shape: &[usize], elements: Elements<'_>) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, shape, elements).expect("a vector takes all");
        bytes
    }

    #[test]
    fn headers_are_as_numpy_writes_them() {
        let bytes = written(&[2, 1], Elements::U32(&[1, 0x0102_0304]));
        assert_eq!(&bytes[..10], b"\x93NUMPY\x01\x00\x76\x00");
        let text = String::from_utf8_lossy(&bytes[10..128]).into_owned();
        assert_eq!(text.trim_end_matches(['\n', ' ']), "{'descr': '<u4', 'fortran_order': False, 'shape': (2, 1,), }");
        assert!(text.ends_with(" \n"));
        assert_eq!(bytes[128..], [1, 0, 0, 0, 4, 3, 2, 1]);
        let bytes = written(&[3], Elements::U8(&[7, 8, 9]));
        assert!(String::from_utf8_lossy(&bytes).contains("'|u1', 'fortran_order': False, 'shape': (3,), "));
        assert_eq!(bytes[bytes.len() - 3..], [7, 8, 9]);
        let bytes = written(&[1, 2], Elements::Pairs(&[[1.0, 2.0], [3.0, 4.0]]));
        assert!(String::from_utf8_lossy(&bytes).contains("'<f4', 'fortran_order': False, 'shape': (1, 2, 2,), "));
        assert_eq!(bytes[bytes.len() - 4..], 4f32.to_le_bytes());
        assert_eq!(bytes.len() % 64, 16);
    }

    #[test]
    fn elements_fill_the_shape() {
        let mut bytes = Vec::new();
        let short = write(&mut bytes, &[2, 2], Elements::F32(&[0.0; 3]));
        assert!(matches!(short, Err(EncodeError::Malformed(_))) && bytes.is_empty());
        assert!(write(&mut bytes, &[usize::MAX, 2], Elements::F32(&[])).is_err());
    }
}
