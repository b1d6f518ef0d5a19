//! Files that are whole or not there: written beside the target, synced, then renamed over it.

use super::EncodeError;
use std::{
    ffi::OsStr,
    fs, io,
    path::{Path, PathBuf},
};

/// Why a file could not be written. Every variant names the path as it was given.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The folder that should hold the file is not there.
    #[error("cannot write `{}`: the folder `{}` does not exist", path.display(), folder.display())]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// Its folder.
        folder: PathBuf,
    },
    /// The target is a folder, a device, a pipe or a socket.
    #[error("cannot write `{}`: it is {what}, not a regular file", path.display())]
    NotRegular {
        /// The file.
        path: PathBuf,
        /// What it is.
        what: &'static str,
    },
    /// The target is there and marked read-only, or its folder admits no new file.
    #[error("cannot write `{}`: {reason}", path.display())]
    NotWritable {
        /// The file.
        path: PathBuf,
        /// What stands in the way.
        reason: String,
    },
    /// No room left.
    #[error("cannot write `{}`: no space left on the device", path.display())]
    DiskFull {
        /// The file.
        path: PathBuf,
    },
    /// The format cannot hold the picture.
    #[error("cannot write `{}`: {source}", path.display())]
    Encode {
        /// The file.
        path: PathBuf,
        /// Why.
        source: EncodeError,
    },
    /// Any other refusal of the file system.
    #[error("cannot write `{}`: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the file system said.
        source: io::Error,
    },
}

impl WriteError {
    fn from_io(path: &Path, source: io::Error) -> Self {
        let path = path.to_owned();
        match source.kind() {
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                Self::NotWritable { path, reason: source.to_string() }
            }
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded => Self::DiskFull { path },
            _ => Self::Io { path, source },
        }
    }

    fn from_encode(path: &Path, source: EncodeError) -> Self {
        match source {
            EncodeError::Io(source) => Self::from_io(path, source),
            source => Self::Encode { path: path.to_owned(), source },
        }
    }
}

/// Writes what `fill` produces to `path`, whole or not at all: whoever reads `path` sees the old file or the new one,
/// and after an error or a crash the old one is untouched (a crash may leave a hidden `.NAME.*.part` beside it).
///
/// A symbolic link keeps pointing where it points; its target is replaced. A replaced file keeps its permission bits,
/// a new one gets those of any new file (0666 without the umask). Folders, devices, pipes and read-only files are
/// refused: they cannot be replaced whole, or somebody did not want them to be.
pub fn write(path: &Path, fill: impl FnOnce(&mut fs::File) -> Result<(), EncodeError>) -> Result<(), WriteError> {
    let target = Target::resolve(path)?;
    let mut beside = target.create_beside().map_err(|e| WriteError::from_io(path, e))?;
    fill(beside.as_file_mut()).map_err(|e| WriteError::from_encode(path, e))?;
    let finish = || -> io::Result<()> {
        if let Some(permissions) = target.permissions {
            beside.as_file().set_permissions(permissions)?;
        }
        beside.as_file().sync_all()?;
        beside.persist(&target.file).map_err(|e| e.error)?;
        Ok(())
    };
    finish().map_err(|e| WriteError::from_io(path, e))?;
    // The new name is durable only once the folder is; a file system that cannot sync folders has kept the file anyway.
    if let Ok(folder) = fs::File::open(&target.folder) {
        let _ = folder.sync_all();
    }
    Ok(())
}

/// Finds out, without leaving a trace, whether [`write()`] could start on `path`.
pub fn check_writable(path: &Path) -> Result<(), WriteError> {
    let target = Target::resolve(path)?;
    target.create_beside().map(drop).map_err(|e| WriteError::from_io(path, e))
}

/// Where a write ends up once links are followed.
struct Target {
    file: PathBuf,
    folder: PathBuf,
    /// Of the file to be replaced.
    permissions: Option<fs::Permissions>,
}

impl Target {
    fn resolve(path: &Path) -> Result<Self, WriteError> {
        let file = follow_links(path).map_err(|e| WriteError::from_io(path, e))?;
        let permissions = match fs::symlink_metadata(&file) {
            Ok(metadata) if !metadata.is_file() => {
                let what = if metadata.is_dir() { "a folder" } else { "a device, pipe or socket" };
                return Err(WriteError::NotRegular { path: path.to_owned(), what });
            }
            Ok(metadata) if metadata.permissions().readonly() => {
                let reason = "the file is read-only".to_owned();
                return Err(WriteError::NotWritable { path: path.to_owned(), reason });
            }
            Ok(metadata) => Some(metadata.permissions()),
            Err(e) if matches!(e.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => None,
            Err(e) => return Err(WriteError::from_io(path, e)),
        };
        let folder = match file.parent() {
            Some(parent) if parent != Path::new("") => parent.to_owned(),
            _ => PathBuf::from("."),
        };
        if !folder.is_dir() {
            return Err(WriteError::NoFolder { path: path.to_owned(), folder });
        }
        if file.file_name().is_none() {
            return Err(WriteError::NotRegular { path: path.to_owned(), what: "a folder" });
        }
        Ok(Self { file, folder, permissions })
    }

    fn create_beside(&self) -> io::Result<tempfile::NamedTempFile> {
        let name = self.file.file_name().map(OsStr::to_string_lossy).unwrap_or_default();
        // Names are at most 255 bytes on common file systems; leave room for what is added.
        let stem: String = name.chars().take(40).collect();
        let mut builder = tempfile::Builder::new();
        let prefix = format!(".{stem}.");
        builder.prefix(&prefix).suffix(".part");
        #[cfg(unix)]
        builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
        builder.tempfile_in(&self.folder)
    }
}

/// The file that `path` names after at most 40 symbolic links, there or not.
fn follow_links(path: &Path) -> io::Result<PathBuf> {
    let mut path = path.to_owned();
    for _ in 0..40 {
        match fs::read_link(&path) {
            Ok(target) => path = path.parent().unwrap_or(Path::new("")).join(target),
            // Not a link, or not there.
            Err(_) => return Ok(path),
        }
    }
    Err(io::Error::other("too many symbolic links"))
}
