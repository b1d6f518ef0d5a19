//! Gzipped files.

use flate2::bufread::MultiGzDecoder;
use std::io::{self, Read};

/// Why a gzipped file could not be read.
#[derive(Debug, thiserror::Error)]
pub enum GzipError {
    /// It would grow beyond the bound.
    #[error("decompresses to more than {limit} bytes, {}", if *ratio { "more than 256 times its size" } else { "the limit" })]
    TooLarge {
        /// The bound that it passed.
        limit: u64,
        /// The bound was the ratio.
        ratio: bool,
    },
    /// Broken or truncated.
    #[error("broken gzip data: {0}")]
    Broken(io::Error),
}

/// Most bytes made of one byte of gzip. Deflate can make 1032; meshes make 3 to 20.
const MOST_GROWTH: u64 = 256;

/// True if the bytes are gzipped.
pub fn is_gzip(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x1f, 0x8b])
}

/// Decompresses a gzip file of one or more members, to at most `limit` bytes and at most 256 times its size; more is an
/// error as soon as it is seen. No more memory is taken than twice what was decompressed so far.
pub fn decompress(bytes: &[u8], limit: u64) -> Result<Vec<u8>, GzipError> {
    let grown = (bytes.len() as u64).saturating_mul(MOST_GROWTH);
    let (limit, ratio) = (limit.min(grown), grown < limit);
    let mut out = Vec::new();
    let mut decoder = MultiGzDecoder::new(bytes).take(limit.saturating_add(1));
    decoder.read_to_end(&mut out).map_err(GzipError::Broken)?;
    if out.len() as u64 > limit { Err(GzipError::TooLarge { limit, ratio }) } else { Ok(out) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use flate2::{Compression, write::GzEncoder};
    use std::io::Write;

    fn gzip(bytes: &[u8]) -> Vec<u8> {
        let mut encoder = GzEncoder::new(vec![], Compression::best());
        encoder.write_all(bytes).unwrap();
        encoder.finish().unwrap()
    }

    #[test]
    fn members_are_joined_and_breaks_are_errors() {
        let text = b"one two three";
        let mut bytes = gzip(text);
        assert!(is_gzip(&bytes));
        assert_eq!(decompress(&bytes, 13).unwrap(), text);
        assert!(matches!(decompress(&bytes, 12), Err(GzipError::TooLarge { limit: 12, ratio: false })));
        for end in 0..bytes.len() {
            assert!(matches!(decompress(&bytes[..end], 100), Err(GzipError::Broken(_))) || end == 0);
        }
        bytes.extend(gzip(text));
        assert_eq!(decompress(&bytes, 100).unwrap().len(), 26);
    }

    #[test]
    fn bombs_are_refused() {
        let bytes = gzip(&vec![0; 4 << 20]);
        let error = decompress(&bytes, u64::MAX).unwrap_err();
        assert!(matches!(error, GzipError::TooLarge { ratio: true, .. }), "{error}");
    }
}
