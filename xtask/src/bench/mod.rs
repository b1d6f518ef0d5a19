//! `cargo xtask bench`: how fast, beside others.

mod inputs;
mod load;
mod ply;
mod scenes;

use crate::root;
use std::path::PathBuf;

const HELP: &str = "\
How fast Etendue is, beside others; docs/performance.md has the results.

  cargo xtask bench scenes         the scenes of the benchmark with their meshes, in target/bench/scenes
  cargo xtask bench load           reading meshes, and starting up; `cargo xtask bench load --help` tells more

The environment variable ETENDUE_BENCH_DIR names another folder than target/bench.
";

/// Runs a subcommand. An error is told.
pub fn run(arguments: &[&str]) -> bool {
    let done = match arguments {
        ["scenes"] => scenes::make(scenes::NAMES).map(|()| println!("{}", scenes::place().display())),
        ["load", rest @ ..] => load::run(rest),
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
