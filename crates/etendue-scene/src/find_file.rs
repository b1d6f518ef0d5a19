//! Files that a mesh file or material library names, as other systems and other machines write such names.

use crate::SourceError;
use std::path::{Component, Path, PathBuf};

/// Entries of a folder that are looked at.
const MOST_ENTRIES: usize = 100_000;

/// Finds the file that a file in `folder` calls `name`, and says what had to be forgiven: backslashes, differences of case in
/// any part of the path, folders that do not exist here (then the file may lie in `folder` itself).
///
/// # Errors
/// Nothing there, or a folder. Pipes and devices count as nothing: reading them could wait for ever.
pub(crate) fn find_file(folder: &Path, name: &str) -> Result<(PathBuf, Option<String>), SourceError> {
    let direct = folder.join(name);
    let slashed = name.replace('\\', "/");
    let beside = Path::new(&slashed).file_name().map(Path::new);
    let candidates = [Some(Path::new(name)), Some(Path::new(&slashed)), beside];
    let there = candidates.iter().flatten().map(|name| folder.join(name)).find(|path| path.is_file());
    let found = there.or_else(|| candidates[1..].iter().flatten().find_map(|name| ignoring_case(folder, name)));
    match found {
        Some(path) => {
            let note = (path != direct).then(|| format!("`{name}` read from {}", path.display()));
            Ok((path, note))
        }
        None if direct.is_dir() => Err(SourceError::IsDirectory(direct)),
        None => Err(SourceError::NotFound(direct)),
    }
}

/// A file whose path differs only in case; of several in one folder the first by name.
pub(crate) fn ignoring_case(folder: &Path, name: &Path) -> Option<PathBuf> {
    let mut components = name.components().peekable();
    let mut path = if name.has_root() { PathBuf::new() } else { folder.to_owned() };
    while let Some(component) = components.next() {
        let Component::Normal(part) = component else {
            path.push(component);
            continue;
        };
        let last = components.peek().is_none();
        let fits = |path: &Path| if last { path.is_file() } else { path.is_dir() };
        let exact = path.join(part);
        path = if fits(&exact) { exact } else { same_but_case(&path, &part.to_string_lossy(), fits)? };
    }
    path.is_file().then_some(path)
}

fn same_but_case(folder: &Path, name: &str, fits: impl Fn(&Path) -> bool) -> Option<PathBuf> {
    let wanted = name.to_lowercase();
    let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(listed).ok()?.take(MOST_ENTRIES).flatten();
    let names = entries.map(|entry| entry.file_name()).filter(|name| name.to_string_lossy().to_lowercase() == wanted);
    names.map(|name| folder.join(name)).filter(|path| fits(path)).min()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn names_of_other_systems() {
        let folder = tempfile::tempdir().unwrap();
        let root = folder.path();
        fs::create_dir_all(root.join("Textures/Wood")).unwrap();
        for name in ["a.mtl", "Textures/Wood/Oak.PNG", "B.png"] {
            fs::write(root.join(name), "").unwrap();
        }
        let find = |name: &str| find_file(root, name);
        let plain = |name: &str| find(name).unwrap();
        assert_eq!(plain("a.mtl"), (root.join("a.mtl"), None));
        for (name, file) in [
            ("A.MTL", "a.mtl"),
            (".\\a.mtl", "a.mtl"),
            ("C:\\stuff\\A.mtl", "a.mtl"),
            ("/no/such/folder/b.PNG", "B.png"),
            ("textures\\wood\\oak.png", "Textures/Wood/Oak.PNG"),
            ("textures/../TEXTURES/wood/oak.png", "Textures/Wood/Oak.PNG"),
        ] {
            let (path, note) = plain(name);
            assert_eq!(path.canonicalize().unwrap(), root.join(file).canonicalize().unwrap(), "{name}");
            assert!(note.is_some_and(|note| note.contains(name)), "{name}");
        }
        assert!(matches!(find("Textures"), Err(SourceError::IsDirectory(_))));
        for name in ["c.png", "", "..", "x\0y", "a.mtl/b"] {
            assert!(find(name).is_err(), "{name}");
        }
    }
}
