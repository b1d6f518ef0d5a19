//! Rules on the files of the project that no compiler checks.

use crate::root;
use std::{
    fs,
    path::{Path, PathBuf},
    process::Command,
};

/// Largest file that may be tracked, bytes.
const LARGEST: u64 = 2 << 20;

/// Prints every breach; true if there is none.
pub fn check() -> bool {
    let root = root();
    let mut breaches = Vec::new();
    for file in files(&root) {
        let path = root.join(&file);
        let Ok(metadata) = fs::metadata(&path) else { continue };
        if metadata.len() > LARGEST {
            breaches.push(format!("{}: {} bytes, at most {LARGEST} are tracked", file.display(), metadata.len()));
        }
        if file.extension().is_some_and(|e| e == "rs") {
            let text = fs::read_to_string(&path).unwrap_or_default();
            breaches.extend(ignored_tests(&text).map(|line| {
                format!("{}:{line}: a test is left out; make it smaller, or full size by `prove`", file.display())
            }));
        }
    }
    for breach in &breaches {
        println!("{breach}");
    }
    breaches.is_empty()
}

/// Numbers of the lines with an attribute that leaves a test out.
fn ignored_tests(text: &str) -> impl Iterator<Item = usize> {
    let attribute = concat!("#[", "ignore");
    text.lines().enumerate().filter(move |(_, line)| line.trim_start().starts_with(attribute)).map(|(i, _)| i + 1)
}

/// Tracked files, relative to the root; without git, every file outside of `target` and hidden folders.
pub fn files(root: &Path) -> Vec<PathBuf> {
    let listed = Command::new("git").current_dir(root).args(["ls-files", "-z"]).output();
    match listed {
        Ok(output) if output.status.success() => String::from_utf8_lossy(&output.stdout)
            .split('\0')
            .filter(|name| !name.is_empty())
            .map(PathBuf::from)
            .collect(),
        _ => {
            let mut found = Vec::new();
            walk(root, Path::new(""), &mut found);
            found
        }
    }
}

fn walk(root: &Path, folder: &Path, found: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(root.join(folder)) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let path = folder.join(&name);
        match entry.file_type() {
            Ok(kind) if kind.is_file() => found.push(path),
            Ok(kind) if kind.is_dir() && name != "target" && !name.to_string_lossy().starts_with('.') => {
                walk(root, &path, found);
            }
            _ => (),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn left_out_tests_are_found() {
        let text = concat!("#[test]\n    #[", "ignore = \"slow\"]\nfn a() {}\n// #[", "ignore] in prose\n");
        assert_eq!(ignored_tests(text).collect::<Vec<_>>(), [2]);
    }

    #[test]
    fn walking_finds_what_git_lists() {
        let root = root();
        let mut walked = Vec::new();
        walk(&root, Path::new(""), &mut walked);
        assert!(walked.contains(&PathBuf::from("xtask/src/main.rs")));
        assert!(files(&root).contains(&PathBuf::from("xtask/src/main.rs")));
    }
}
