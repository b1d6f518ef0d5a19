//! The `etendue` program: arguments in, exit code out.

#![forbid(unsafe_code)]

mod animate;
mod args;
mod bodies;
mod convert;
mod diff;
mod exit;
mod info;
mod labels;
mod load;
mod manifest;
mod memory;
mod model;
mod model_output;
mod outputs;
mod progress;
mod render;
mod report;
mod scene_input;
mod signals;
mod simplify;
mod simulate;
mod stale;
mod summary;
mod tools;

use args::{Cli, Command};
use clap::Parser;
use exit::{Exit, Failure};
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
        None if cli.schema => tools::schema(),
        Some(_) if cli.schema => {
            Err(Failure::new(Exit::Usage, "--schema stands alone").hint("leave the subcommand out"))
        }
        None => Err(Failure::new(Exit::Usage, "nothing to do").hint("etendue --help tells what there is")),
        Some(Command::Render(args)) => render::run(args),
        Some(Command::Animate(args)) => animate::run(args),
        Some(Command::Scene(args)) => model::run(args),
        Some(Command::Info(args)) => info::run(args),
        Some(Command::Convert(args)) => convert::run(args),
        Some(Command::Simplify(args)) => simplify::run(args),
        Some(Command::Simulate(args)) => simulate::run(args),
        Some(Command::Completions(args)) => tools::completions(args),
        Some(Command::Man(args)) => tools::man(args),
        Some(Command::Diff(args)) => diff::run(args),
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
