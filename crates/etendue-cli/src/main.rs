//! The `etendue` program: arguments in, exit code out.

#![forbid(unsafe_code)]

mod args;
mod diff;
mod exit;
mod load;
mod manifest;
mod model;
mod outputs;
mod progress;
mod render;
mod report;
mod signals;
mod summary;

use args::{Cli, Command};
use clap::Parser;
use exit::Exit;
use std::process::ExitCode;

fn main() -> ExitCode {
    let cli = match Cli::try_parse() {
        Ok(cli) => cli,
        Err(error) => {
            // Help and version are answers, on standard output; all else is a mistake in usage.
            let exit = if error.use_stderr() { Exit::Usage } else { Exit::Done };
            let _ = error.print();
            return exit.into();
        }
    };
    let ended = match &cli.command {
        Command::Render(args) => render::run(args),
        Command::Scene(args) => model::run(args),
        Command::Diff(args) => diff::run(args),
    };
    ended
        .unwrap_or_else(|failure| {
            report::failure(&failure);
            failure.exit
        })
        .into()
}

/// Name and version, as files are signed with.
fn software() -> String {
    concat!("Etendue ", env!("CARGO_PKG_VERSION")).to_owned()
}
