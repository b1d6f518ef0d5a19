//! What the program tells of itself: the schema of its scene files, completions for shells, manual pages.

use crate::{
    args::{Cli, CompletionsArgs, ManArgs},
    exit::{Exit, Failure},
    report,
};
use clap::{Command, CommandFactory};
use clap_mangen::Man;
use etendue_scene::schema::json_schema;
use std::io;

/// `etendue --schema`.
pub fn schema() -> Result<Exit, Failure> {
    report::result(&format!("{:#}", json_schema()))?;
    Ok(Exit::Done)
}

/// `etendue completions`.
pub fn completions(args: &CompletionsArgs) -> Result<Exit, Failure> {
    let mut script = Vec::new();
    clap_complete::generate(args.shell, &mut Cli::command(), "etendue", &mut script);
    report::result(String::from_utf8_lossy(&script).trim_end())?;
    Ok(Exit::Done)
}

/// `etendue man`.
pub fn man(args: &ManArgs) -> Result<Exit, Failure> {
    let mut program = Cli::command();
    program.build();
    let page = match &args.subcommand {
        None => page(program),
        Some(name) => match program.find_subcommand(name) {
            Some(found) => page(found.clone()),
            None => {
                let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
                let message = format!("there is no subcommand `{name}`");
                return Err(Failure::new(Exit::Usage, message).hint(format!("there are {}", names.join(", "))));
            }
        },
    };
    let page = page.map_err(|e| Failure::new(Exit::CannotWrite, e))?;
    report::result(String::from_utf8_lossy(&page).trim_end())?;
    Ok(Exit::Done)
}

/// A page in roff: what clap knows, the examples, and how the program ends.
fn page(command: Command) -> io::Result<Vec<u8>> {
    let examples = command.get_before_help().map(ToString::to_string).unwrap_or_default();
    let has_subcommands = command.has_subcommands();
    let man = Man::new(command).manual("Etendue Manual").source(crate::software());
    let mut out = Vec::new();
    man.render_title(&mut out)?;
    man.render_name_section(&mut out)?;
    man.render_synopsis_section(&mut out)?;
    man.render_description_section(&mut out)?;
    out.extend(section("EXAMPLES"));
    out.extend(b".nf\n");
    for line in examples.lines().filter(|line| *line != "Examples:") {
        out.extend(escaped(line).bytes());
        out.push(b'\n');
    }
    out.extend(b".fi\n");
    man.render_options_section(&mut out)?;
    if has_subcommands {
        man.render_subcommands_section(&mut out)?;
    }
    out.extend(section("EXIT STATUS"));
    for exit in Exit::ALL {
        out.extend(format!(".TP\n{}\n{}\n", exit as u8, escaped(exit.words())).bytes());
    }
    out.extend(section("ENVIRONMENT"));
    out.extend(b".TP\nNO_COLOR\nIf set and not empty, messages have no colours.\n");
    Ok(without_repeats(&String::from_utf8_lossy(&out)).into_bytes())
}

/// Each part begins with the same definition of an apostrophe, which once is enough for.
fn without_repeats(page: &str) -> String {
    const PREAMBLE: [&str; 2] = [".ie \\n(.g .ds Aq \\(aq\n", ".el .ds Aq '\n"];
    let body: String = page.split_inclusive('\n').filter(|line| !PREAMBLE.contains(line)).collect();
    PREAMBLE.concat() + &body
}

fn section(name: &str) -> Vec<u8> {
    format!(".SH \"{name}\"\n").into_bytes()
}

/// Text for roff: nothing in it is a command.
fn escaped(line: &str) -> String {
    let text = line.replace('\\', "\\e").replace('-', "\\-");
    if text.starts_with(['.', '\'']) { format!("\\&{text}") } else { text }
}
