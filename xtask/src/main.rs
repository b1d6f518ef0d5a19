//! The project's own chores: `cargo xtask --help`.

#![forbid(unsafe_code)]

mod bench;
mod disk;
mod films;
mod gallery;
mod hygiene;
mod prove;
mod test;
mod venv;

use std::{
    path::PathBuf,
    process::{Command, ExitCode},
};

const HELP: &str = "\
The project's own chores.

  cargo xtask test          formatting, lints, every test, documentation, and rules on files; what CI runs.
                            Stops at the first failure; the last line is `N passed, N failed`.
  cargo xtask films         the tests among these that look at films with FFmpeg, which is fetched from PyPI once;
                            ETENDUE_FFMPEG names another
  cargo xtask prove NAME    one statistical or adversarial test at full size, optimised; minutes, not seconds
  cargo xtask prove         lists the names
  cargo xtask prove all     all of them
  cargo xtask gallery       the paper's figures; `cargo xtask gallery --help` tells more
  cargo xtask bench         how fast, beside others; `cargo xtask bench --help` tells more
";

fn main() -> ExitCode {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let args: Vec<&str> = args.iter().map(String::as_str).collect();
    let ok = match args[..] {
        ["test"] => test::run(),
        ["films"] => films::test(&mut test::Counts::default()),
        ["gallery", ref rest @ ..] => gallery::run(rest),
        ["bench", ref rest @ ..] => bench::run(rest),
        ["prove"] => prove::list(),
        ["prove", name] if !name.starts_with('-') => prove::run(name),
        ["--help" | "-h" | "help"] => {
            print!("{HELP}");
            true
        }
        _ => {
            eprint!("{HELP}");
            return ExitCode::from(2);
        }
    };
    if ok { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

/// The root of the workspace.
fn root() -> PathBuf {
    let mut folder = PathBuf::from(env!("CARGO_MANIFEST_DIR"));
    folder.pop();
    folder
}

/// The cargo that runs this program, in the root of the workspace.
fn cargo(args: &[&str]) -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root()).args(args);
    command
}
