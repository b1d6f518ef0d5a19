//! Programs of others, from PyPI, each in a virtual environment of its own.

use crate::{disk, root};
use std::{
    path::{Path, PathBuf},
    process::{Command, Stdio},
};

/// Makes the virtual environment `home` and fetches `packages` from PyPI, unless it holds just these. `pythons` are the
/// versions of Python that will do, the best first; `3` for any.
pub fn install(home: &Path, pythons: &[&str], packages: &[&str]) -> Result<(), String> {
    let done = home.join("installed");
    let wanted = packages.join(" ");
    if std::fs::read_to_string(&done).is_ok_and(|text| text == wanted) {
        return Ok(());
    }
    println!("installing {wanted} in {}", home.display());
    let answers = |python: &PathBuf| {
        let test = Command::new(python).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
        test.is_ok_and(|status| status.success())
    };
    let python = candidates(pythons).into_iter().find(answers).ok_or_else(|| {
        format!("{wanted} needs Python {}, as python3 or python3.N on the path", pythons.join(" or "))
    })?;
    run(&python, &["-m", "venv", &home.to_string_lossy()])?;
    let mut arguments = vec!["-m", "pip", "install", "--quiet", "--disable-pip-version-check"];
    arguments.extend(packages);
    run(&python_of(home), &arguments)?;
    disk::write(&done, wanted.as_bytes())
}

/// The interpreter of a virtual environment.
pub fn python_of(home: &Path) -> PathBuf {
    home.join("bin/python")
}

fn run(program: &Path, arguments: &[&str]) -> Result<(), String> {
    let status = Command::new(program).args(arguments).current_dir(root()).stdin(Stdio::null()).status();
    match status {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(format!("{} {}: {status}", program.display(), arguments.join(" "))),
        Err(e) => Err(format!("cannot run {}: {e}", program.display())),
    }
}

/// Interpreters of these versions: on the path, and where pyenv keeps them.
fn candidates(versions: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let pyenv = std::env::var_os("HOME").map(|home| PathBuf::from(home).join(".pyenv/versions"));
    let kept: Vec<PathBuf> = pyenv
        .and_then(|folder| std::fs::read_dir(folder).ok())
        .map(|entries| entries.flatten().map(|entry| entry.path()).collect())
        .unwrap_or_default();
    for version in versions {
        found.push(PathBuf::from(format!("python{version}")));
        let prefix = format!("{version}.");
        let of_version = |path: &&PathBuf| path.file_name().is_some_and(|n| n.to_string_lossy().starts_with(&prefix));
        found.extend(kept.iter().filter(of_version).map(|path| path.join("bin/python")));
    }
    found
}
