//! `cargo xtask bench`: how fast, beside others.

// Numbers of reports, not of pictures.
#![allow(clippy::disallowed_methods)]

mod inputs;
mod load;
mod page;
mod peers;
mod picture;
mod plot;
mod ply;
mod ray_page;
mod rays;
mod render;
mod report;
mod scenes;
mod simplify;
mod statistics;

use crate::root;
use std::path::PathBuf;

const HELP: &str = "\
How fast Etendue is, beside others; docs/performance.md has the results.

  cargo xtask bench render         seconds to an error, all renderers in turns; `--help` tells more
  cargo xtask bench page           the tables and plots of docs/performance.md and docs/simplify.md from the kept results
  cargo xtask bench rays           sets of rays through a dragon and a small mesh, beside Embree
  cargo xtask bench build          building and memory of the same meshes, beside Embree
  cargo xtask bench scaling        the cost of a ray from ten thousand to ten million faces, beside Embree
                                   Options of these three: `cargo xtask bench rays --help`
  cargo xtask bench simplify       fewer triangles, and how far off they are; `--help` tells more
  cargo xtask bench load           reading meshes, and starting up; `cargo xtask bench load --help` tells more
  cargo xtask bench install        the rivals, from PyPI into target/bench
  cargo xtask bench scenes         the scenes of the benchmark with their meshes, in target/bench/scenes

The environment variable ETENDUE_BENCH_DIR names another folder than target/bench.
";

/// Runs a subcommand. An error is told.
pub fn run(arguments: &[&str]) -> bool {
    let done = match arguments {
        ["render", rest @ ..] => render::run(rest),
        ["page"] => write_pages(),
        [what @ ("rays" | "build" | "scaling"), options @ ..] => rays::run(what, options),
        ["load", rest @ ..] => load::run(rest),
        ["simplify", rest @ ..] => simplify::run(rest),
        ["install"] => peers::PEERS.iter().try_for_each(peers::Peer::install),
        ["scenes"] => scenes::make(scenes::NAMES).map(|()| println!("{}", scenes::place().display())),
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

/// Writes the tables and plots of docs/performance.md and docs/simplify.md from the kept results.
fn write_pages() -> Result<(), String> {
    let performance = root().join("docs/performance.md");
    let images = root().join("docs/images/performance");
    std::fs::create_dir_all(&images).map_err(|e| format!("{}: {e}", images.display()))?;
    let written = [
        ("pictures", report::write_page(&performance, &images)?),
        ("rays", ray_page::write_page(&performance, &images)?),
        ("simplification", simplify::write_page()?),
    ];
    let written: Vec<&str> = written.into_iter().filter_map(|(what, is_there)| is_there.then_some(what)).collect();
    if written.is_empty() {
        return Err("no results are kept: `cargo xtask bench render --peers`".to_owned());
    }
    println!("written: {}", written.join(", "));
    Ok(())
}

/// Where rivals are installed, scenes are made and results are kept.
fn folder() -> PathBuf {
    std::env::var_os("ETENDUE_BENCH_DIR").map_or_else(|| root().join("target/bench"), PathBuf::from)
}
