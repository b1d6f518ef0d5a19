//! `cargo xtask test`.

use crate::{cargo, films, hygiene};
use std::{
    io::{BufRead, BufReader, Write},
    process::{Command, Stdio},
    time::Instant,
};

/// Runs every step until one fails.
pub fn run() -> bool {
    let start = Instant::now();
    let mut counts = Counts::default();
    let mut doc = once(&["doc", "--locked", "--workspace", "--no-deps"]);
    doc.env("RUSTDOCFLAGS", "-D warnings");
    let clippy = ["clippy", "--locked", "--workspace", "--all-targets", "--", "-D", "warnings"];
    let without_mp4 =
        ["clippy", "--locked", "-p", "etendue-video", "-p", "etendue-cli", "--no-default-features", "--all-targets"];
    let without_mp4 = [&without_mp4[..], &["--", "-D", "warnings"]].concat();
    let ok = step("rules on files", hygiene::check)
        && step("formatting", || succeeds(&mut cargo(&["fmt", "--all", "--check"])))
        && step("lints", || succeeds(&mut once(&clippy)))
        && step("lints without MP4", || succeeds(&mut once(&without_mp4)))
        && step("tests", || counts.run(&mut once(&["test", "--locked", "--workspace"])))
        && step("films by FFmpeg", || films::test(&mut counts))
        && step("documentation", || succeeds(&mut doc));
    println!("{} in {:.0} s", if ok { "all is well" } else { "stopped" }, start.elapsed().as_secs_f64());
    println!("{} passed, {} failed", counts.passed, counts.failed);
    ok
}

/// A cargo that keeps nothing for compiling parts again, about half of what it would write to the disk.
fn once(args: &[&str]) -> Command {
    let mut command = cargo(args);
    command.env("CARGO_INCREMENTAL", "0");
    command
}

fn step(name: &str, run: impl FnOnce() -> bool) -> bool {
    println!("== {name}");
    let start = Instant::now();
    let ok = run();
    println!("== {name}: {} ({:.1} s)", if ok { "ok" } else { "FAILED" }, start.elapsed().as_secs_f64());
    ok
}

pub fn succeeds(command: &mut Command) -> bool {
    command.status().inspect_err(|e| eprintln!("cannot run {command:?}: {e}")).is_ok_and(|status| status.success())
}

/// Tests passed and failed, summed over test programs.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Counts {
    passed: u64,
    failed: u64,
}

impl Counts {
    /// Runs `cargo test`, shows what it prints and adds up its summaries.
    pub fn run(&mut self, command: &mut Command) -> bool {
        let mut child = match command.stdout(Stdio::piped()).spawn() {
            Ok(child) => child,
            Err(e) => {
                eprintln!("cannot run {command:?}: {e}");
                return false;
            }
        };
        let mut line = Vec::new();
        if let Some(stdout) = child.stdout.take() {
            let mut reader = BufReader::new(stdout);
            while reader.read_until(b'\n', &mut line).is_ok_and(|n| n > 0) {
                let _ = std::io::stdout().write_all(&line);
                self.add(&String::from_utf8_lossy(&line));
                line.clear();
            }
        }
        child.wait().is_ok_and(|status| status.success())
    }

    /// Adds a line such as `test result: ok. 3 passed; 0 failed; 0 ignored; ...`.
    fn add(&mut self, line: &str) {
        let Some((_, summary)) = line.strip_prefix("test result: ").and_then(|rest| rest.split_once(". ")) else {
            return;
        };
        for part in summary.split("; ") {
            match part.split_once(' ') {
                Some((number, "passed")) => self.passed += number.parse().unwrap_or(0),
                Some((number, "failed")) => self.failed += number.parse().unwrap_or(0),
                _ => (),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Counts;

    #[test]
    fn summaries_add_up() {
        let mut counts = Counts::default();
        counts.add("test result: ok. 7 passed; 0 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.01s\n");
        counts.add("test result: FAILED. 2 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 1s\n");
        counts.add("test result of something else: 5 passed\n");
        assert_eq!(counts, Counts { passed: 9, failed: 3 });
    }
}
