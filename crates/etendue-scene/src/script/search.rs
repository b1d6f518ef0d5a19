//! Where the files of a script are.

use crate::{
    Diagnostic, SourceError,
    description::Located,
    find_file::{find_file, ignoring_case},
};
use std::{
    env::current_dir,
    path::{Path, PathBuf},
};

/// Folders above the script's that are looked into.
const FOLDERS_ABOVE: usize = 4;

/// Finds files by the names that a script gives them: relative to the folder that the old program was started in, which was
/// mostly the one above the script's.
#[derive(Clone, Debug)]
pub struct Search {
    /// The script's own folder first.
    folders: Vec<PathBuf>,
}

impl Search {
    /// For a script at `path`.
    pub fn new(path: &Path) -> Self {
        let own = path.parent().unwrap_or(Path::new("")).to_owned();
        let here = current_dir().unwrap_or_default();
        let full = here.join(&own);
        let above = full.ancestors().skip(1).take(FOLDERS_ABOVE).map(|folder| match folder.strip_prefix(&here) {
            Ok(relative) if own.is_relative() => relative.to_owned(),
            _ => folder.to_owned(),
        });
        let mut folders: Vec<PathBuf> = above.collect();
        folders.insert(0, own);
        Self { folders }
    }

    /// The file that the script calls `name`.
    pub fn find(&self, name: &str) -> Option<PathBuf> {
        let slashed = name.replace('\\', "/");
        if slashed.is_empty() || slashed.contains('\0') {
            return None;
        }
        let exact = self.folders.iter().map(|folder| folder.join(&slashed)).find(|path| path.is_file());
        let alike = || self.folders.iter().find_map(|folder| ignoring_case(folder, Path::new(&slashed)));
        // As a last resort the name alone, beside the script.
        exact.or_else(alike).or_else(|| find_file(&self.folders[0], name).ok().map(|(path, _)| path))
    }

    /// [`Search::find`], or the error to be told.
    pub fn need(&self, name: &Located<String>) -> Result<PathBuf, Diagnostic> {
        self.find(&name.value).ok_or_else(|| {
            let direct = PathBuf::from(&name.value);
            let is_folder = self.folders[0].join(&direct).is_dir();
            let error = if is_folder { SourceError::IsDirectory(direct) } else { SourceError::NotFound(direct) };
            Diagnostic::error(error.to_string()).at(name.origin.clone()).label("not there, nor in the folders above").help(
                "the old program looked from the folder that it was started in; put the file there, or begin the line with #",
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn beside_the_script_and_above_it() {
        let root = tempfile::tempdir().unwrap();
        let root = root.path();
        fs::create_dir_all(root.join("a/Config/deep")).unwrap();
        for name in ["a/Config/plane.obj", "a/top.obj", "a/Config/deep/own.obj", "a/Config/own.obj"] {
            fs::write(root.join(name), "").unwrap();
        }
        let find = |script: &str, name: &str| {
            let found = Search::new(&root.join(script)).find(name)?;
            Some(found.canonicalize().unwrap().strip_prefix(root.canonicalize().unwrap()).unwrap().to_owned())
        };
        for (script, name, file) in [
            ("a/Config/1.cfg", "Config/plane.obj", Some("a/Config/plane.obj")),
            ("a/Config/1.cfg", "config\\PLANE.obj", Some("a/Config/plane.obj")),
            ("a/Config/1.cfg", "plane.obj", Some("a/Config/plane.obj")),
            ("a/Config/1.cfg", "top.obj", Some("a/top.obj")),
            ("a/Config/deep/1.cfg", "own.obj", Some("a/Config/deep/own.obj")),
            ("a/Config/deep/1.cfg", "Config/own.obj", Some("a/Config/own.obj")),
            ("a/Config/1.cfg", "C:\\work\\plane.obj", Some("a/Config/plane.obj")),
            ("a/Config/1.cfg", "missing.obj", None),
            ("a/Config/1.cfg", "deep", None),
            ("a/Config/1.cfg", "", None),
        ] {
            assert_eq!(find(script, name).as_deref(), file.map(Path::new), "{script} {name}");
        }
    }
}
