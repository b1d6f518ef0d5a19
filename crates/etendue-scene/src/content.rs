//! The bytes of a file, in memory or on disk, in pieces.

use crate::parallel;
use sha2::{Digest, Sha256};
use std::{
    borrow::Cow,
    convert::Infallible,
    fs::File,
    io,
    ops::Range,
    sync::{Arc, OnceLock},
};

/// Bytes that are hashed, and read from disk, as one.
pub(crate) const BLOCK_BYTES: usize = 4 << 20;

/// What a file holds: in memory, or on disk to be read in pieces.
#[derive(Clone, Debug)]
pub(crate) enum Content {
    /// In memory.
    Bytes(Arc<Vec<u8>>),
    /// On disk.
    Disk(Arc<DiskFile>),
}

/// A regular file that stays open, with the length that it had when it was opened.
#[derive(Debug)]
pub(crate) struct DiskFile {
    file: File,
    length: usize,
    digest: OnceLock<[u8; 32]>,
}

impl DiskFile {
    /// `file`, open for reading, of `length` bytes.
    pub fn new(file: File, length: usize) -> Self {
        Self { file, length, digest: OnceLock::new() }
    }

    /// Keeps the digest that a reader of the whole file has found on its way.
    pub fn set_digest(&self, digest: [u8; 32]) {
        self.digest.get_or_init(|| digest);
    }
}

/// The bytes of a file, borrowed from where they are.
#[derive(Clone, Copy, Debug)]
pub(crate) enum View<'a> {
    /// In memory.
    Bytes(&'a [u8]),
    /// On disk.
    Disk(&'a DiskFile),
}

impl<'a> View<'a> {
    /// Bytes.
    pub fn len(self) -> usize {
        match self {
            View::Bytes(bytes) => bytes.len(),
            View::Disk(disk) => disk.length,
        }
    }

    /// The bytes of a range inside the file, which may use `buffer`.
    ///
    /// # Errors
    /// The disk, or a file that became shorter.
    pub fn piece<'b>(self, range: Range<usize>, buffer: &'b mut Vec<u8>) -> io::Result<&'b [u8]>
    where
        'a: 'b,
    {
        match self {
            View::Bytes(bytes) => Ok(&bytes[range]),
            View::Disk(disk) => {
                buffer.resize(range.len(), 0);
                read_exact_at(&disk.file, buffer, range.start as u64)?;
                Ok(buffer)
            }
        }
    }
}

#[cfg(unix)]
fn read_exact_at(file: &File, buffer: &mut [u8], offset: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, buffer, offset)
}

#[cfg(windows)]
fn read_exact_at(file: &File, mut buffer: &mut [u8], mut offset: u64) -> io::Result<()> {
    while !buffer.is_empty() {
        match std::os::windows::fs::FileExt::seek_read(file, buffer, offset) {
            Ok(0) => return Err(io::ErrorKind::UnexpectedEof.into()),
            Ok(count) => {
                buffer = &mut buffer[count..];
                offset += count as u64;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok(())
}

impl Content {
    /// Bytes.
    pub fn len(&self) -> usize {
        match self {
            Content::Bytes(bytes) => bytes.len(),
            Content::Disk(disk) => disk.length,
        }
    }

    /// The bytes of a range inside the file, which may use `buffer`.
    ///
    /// # Errors
    /// The disk, or a file that became shorter.
    pub fn piece<'b>(&'b self, range: Range<usize>, buffer: &'b mut Vec<u8>) -> io::Result<&'b [u8]> {
        self.view().piece(range, buffer)
    }

    /// The same bytes, borrowed.
    pub fn view(&self) -> View<'_> {
        match self {
            Content::Bytes(bytes) => View::Bytes(bytes),
            Content::Disk(disk) => View::Disk(disk),
        }
    }

    /// What [`Content::piece`] gave last for the same range and buffer.
    pub fn again<'b>(&'b self, range: Range<usize>, buffer: &'b [u8]) -> &'b [u8] {
        match self {
            Content::Bytes(bytes) => &bytes[range],
            Content::Disk(_) => buffer,
        }
    }

    /// As [`Content::piece`], with zeros for what cannot be read: for messages.
    pub fn shown(&self, range: Range<usize>) -> Cow<'_, [u8]> {
        match self {
            Content::Bytes(bytes) => Cow::Borrowed(&bytes[range]),
            Content::Disk(disk) => {
                let mut buffer = vec![0; range.len()];
                if read_exact_at(&disk.file, &mut buffer, range.start as u64).is_err() {
                    buffer.fill(0);
                }
                Cow::Owned(buffer)
            }
        }
    }

    /// Every block, in order; what cannot be read is zeros.
    pub fn blocks(&self, size: usize) -> impl Iterator<Item = Cow<'_, [u8]>> {
        let length = self.len();
        (0..length).step_by(size).map(move |start| self.shown(start..(start + size).min(length)))
    }

    /// See [`SourceMap::digest`].
    pub fn digest(&self) -> [u8; 32] {
        let compute = || {
            let length = self.len();
            let mut digests = vec![[0; 32]; length.div_ceil(BLOCK_BYTES)];
            let threads = parallel::threads(digests.len());
            let blocks = digests.iter_mut().enumerate();
            let Ok(_) = parallel::run(
                threads,
                blocks,
                || (),
                |(), (block, digest)| {
                    let start = block * BLOCK_BYTES;
                    *digest = digest_of_block(&self.shown(start..(start + BLOCK_BYTES).min(length)));
                    Ok::<_, Infallible>(())
                },
            );
            digest_of_blocks(digests.into_iter())
        };
        match self {
            Content::Bytes(_) => compute(),
            Content::Disk(disk) => *disk.digest.get_or_init(compute),
        }
    }
}

/// SHA-256.
pub(crate) fn digest_of_block(block: &[u8]) -> [u8; 32] {
    Sha256::digest(block).into()
}

/// The digest of a file from those of its blocks of [`BLOCK_BYTES`].
pub(crate) fn digest_of_blocks(blocks: impl Iterator<Item = [u8; 32]>) -> [u8; 32] {
    let mut all = Sha256::new();
    blocks.for_each(|digest| all.update(digest));
    all.finalize().into()
}
