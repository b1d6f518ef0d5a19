//! `cargo xtask bench`: how fast, beside others.

mod rays;

use crate::root;
use std::path::PathBuf;

const HELP: &str = "\
How fast Etendue is, beside others; docs/performance.md has the results.

  cargo xtask bench rays           sets of rays through a dragon and a small mesh, beside Embree
  cargo xtask bench build          building and memory of the same meshes, beside Embree
  cargo xtask bench scaling        the cost of a ray from ten thousand to ten million faces, beside Embree
                                   Options of these three: `cargo xtask bench rays --help`

The environment variable ETENDUE_BENCH_DIR names another folder than target/bench.
";

/// Runs a subcommand. An error is told.
pub fn run(arguments: &[&str]) -> bool {
    let done = match arguments {
        [what @ ("rays" | "build" | "scaling"), options @ ..] => rays::run(what, options),
        [] | ["--help" | "-h" | "help"] => {
            print!("{HELP}");
            Ok(())
        }
        [other, ..] => Err(format!("`{other}` is no benchmark\n\n{HELP}")),
    };
    if let Err(message) = &done {
        eprintln!("{message}");
    }
    done.is_ok()
}

/// Where rivals are installed, scenes are made and results are kept.
fn folder() -> PathBuf {
    std::env::var_os("ETENDUE_BENCH_DIR").map_or_else(|| root().join("target/bench"), PathBuf::from)
}
