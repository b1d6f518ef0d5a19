//! `cargo xtask prove`: tests that read `ETENDUE_PROVE` and then run at full size.

use crate::{cargo, hygiene, root};
use std::{
    collections::BTreeMap,
    fs,
    path::{Component, Path},
};

/// The environment variable that asks for the full size.
const VARIABLE: &str = "ETENDUE_PROVE";

/// A test program that has a full size.
struct Proof {
    /// What cargo calls it: a package, and either `--lib` or `--test NAME`.
    arguments: Vec<String>,
    /// First line of its documentation.
    about: String,
}

/// Prints the names.
pub fn list() -> bool {
    println!("cargo xtask prove NAME, where NAME is one of:");
    for (name, proof) in proofs().iter().flat_map(|(name, proofs)| proofs.iter().map(move |proof| (name, proof))) {
        println!("  {name:24} {}", proof.about);
    }
    true
}

/// Runs one proof, or all.
pub fn run(name: &str) -> bool {
    let proofs = proofs();
    let chosen = proofs.iter().filter(|(n, _)| name == "all" || *n == name);
    let chosen: Vec<_> = chosen.flat_map(|(name, proofs)| proofs.iter().map(move |proof| (name, proof))).collect();
    if chosen.is_empty() {
        eprintln!("no proof is called `{name}`; there are: {}", proofs.into_keys().collect::<Vec<_>>().join(", "));
        return false;
    }
    chosen.into_iter().all(|(name, proof)| {
        println!("== {name}: {}", proof.about);
        let mut command = cargo(&["test", "--locked", "--release"]);
        command.args(&proof.arguments).args(["--", "--nocapture"]).env(VARIABLE, "1");
        command.status().is_ok_and(|status| status.success())
    })
}

/// All proofs by name: integration tests by theirs (packages may share one), unit tests by their package's. Found by looking
/// for the variable in the sources, or for a call of the package's shared function that reads it, so that the list cannot
/// grow stale.
fn proofs() -> BTreeMap<String, Vec<Proof>> {
    let root = root();
    let mut proofs: BTreeMap<String, Vec<Proof>> = BTreeMap::new();
    for file in hygiene::files(&root) {
        let Some((package, target)) = target_of(&file) else { continue };
        let Ok(text) = fs::read_to_string(root.join(&file)) else { continue };
        let tests = root.join("crates").join(&package).join("tests");
        let shared = fs::read_to_string(tests.join(SHARED).join("mod.rs")).unwrap_or_default();
        let shared_call = reading_function(&shared).map(|name| format!("{name}("));
        if !text.contains(VARIABLE) && !shared_call.is_some_and(|call| text.contains(&call)) {
            continue;
        }
        let (name, selector, main) = match target {
            Some(test) => {
                let main = [tests.join(format!("{test}.rs")), tests.join(&test).join("main.rs")];
                (test.clone(), vec!["--test".to_owned(), test], main.into_iter().find(|m| m.is_file()))
            }
            None => (package.clone(), vec!["--lib".to_owned()], None),
        };
        let about = main.and_then(|m| fs::read_to_string(m).ok()).map(|t| first_doc_line(&t)).unwrap_or_default();
        let mut arguments = vec!["--package".to_owned(), package];
        arguments.extend(selector);
        let same_name = proofs.entry(name).or_default();
        if same_name.iter().all(|proof| proof.arguments != arguments) {
            same_name.push(Proof { arguments, about });
        }
    }
    proofs
}

/// The folder of what a package's integration tests share.
const SHARED: &str = "common";

/// The name of the function in `text` whose body names the variable.
fn reading_function(text: &str) -> Option<&str> {
    let before = &text[..text.rfind(VARIABLE)?];
    let name = &before[before.rfind("fn ")? + 3..];
    name.split_once('(').map(|(name, _)| name)
}

/// The package that a source file belongs to, and its integration test if it is part of one.
fn target_of(file: &Path) -> Option<(String, Option<String>)> {
    let parts: Vec<&str> = file
        .components()
        .map(|c| if let Component::Normal(part) = c { part.to_str().unwrap_or("") } else { "" })
        .collect();
    match parts[..] {
        ["crates", package, "src", ..] if file.extension()? == "rs" => Some((package.to_owned(), None)),
        ["crates", _, "tests", SHARED, ..] => None,
        ["crates", package, "tests", test, ..] if file.extension()? == "rs" => {
            Some((package.to_owned(), Some(test.trim_end_matches(".rs").to_owned())))
        }
        _ => None,
    }
}

fn first_doc_line(text: &str) -> String {
    text.lines().find_map(|line| line.strip_prefix("//! ")).unwrap_or_default().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_belong_to_targets() {
        let of = |file: &str| target_of(Path::new(file));
        assert_eq!(of("crates/a/tests/agree.rs"), Some(("a".to_owned(), Some("agree".to_owned()))));
        assert_eq!(of("crates/a/tests/bsdf/warp.rs"), Some(("a".to_owned(), Some("bsdf".to_owned()))));
        assert_eq!(of("crates/a/src/b/c.rs"), Some(("a".to_owned(), None)));
        assert_eq!(of("crates/a/tests/data.toml"), None);
        assert_eq!(of("crates/a/tests/common/mod.rs"), None);
        assert_eq!(of("xtask/src/prove.rs"), None);
    }

    #[test]
    fn the_function_that_reads_the_variable_is_found() {
        let text = "fn a() {}\n/// ETENDUE_PROVE\npub fn rays() -> u64 { var(\"ETENDUE_PROVE\") }\nfn b() {}";
        assert_eq!(reading_function(text), Some("rays"));
        assert_eq!(reading_function("fn a() {}"), None);
    }
}
