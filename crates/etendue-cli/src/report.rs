//! What people read: diagnostics with the source line and a caret, errors, notes and results.

use crate::exit::{Exit, Failure};
use annotate_snippets::{AnnotationKind, Group, Level, Origin, Renderer, Snippet};
use etendue_scene::{Diagnostic, Diagnostics, Severity, SourceMap};
use std::io::{self, IsTerminal, Write};

/// Writes a line to standard error; a closed standard error is nobody's mistake.
pub fn say(line: impl AsRef<str>) {
    let _ = writeln!(io::stderr(), "{}", line.as_ref());
}

/// Writes the result to standard output. A reader that went away early has had enough, which is no failure.
pub fn result(text: &str) -> Result<(), Failure> {
    let mut out = io::stdout().lock();
    match writeln!(out, "{text}").and_then(|()| out.flush()) {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => {
            let message = format!("cannot write to standard output: {e}");
            Err(Failure::new(Exit::CannotWrite, message).hint("see where it is directed to"))
        }
        _ => Ok(()),
    }
}

/// Says why the program ends.
pub fn failure(failure: &Failure) {
    if !failure.message.is_empty() {
        let group = Group::with_title(Level::ERROR.primary_title(&failure.message));
        let group = match &failure.hint {
            Some(hint) => group.element(Level::HELP.message(hint)),
            None => group,
        };
        say(renderer().render(&[group]));
    }
}

/// Says something that does not end the program.
pub fn warning(message: &str) {
    say(renderer().render(&[Group::with_title(Level::WARNING.primary_title(message))]));
}

/// Prints every finding, and how many of each severity there were if any were left out or wrong.
pub fn diagnostics(diagnostics: &Diagnostics, sources: &SourceMap) {
    let renderer = renderer();
    for diagnostic in diagnostics {
        say(render(diagnostic, sources, &renderer));
        say("");
    }
    for severity in Severity::ALL {
        let left_out = diagnostics.left_out(severity);
        if left_out > 0 {
            say(format!("... and {left_out} more of severity `{severity}`"));
        }
    }
    let errors = diagnostics.count(Severity::Error);
    if errors > 0 {
        let warnings = diagnostics.count(Severity::Warning);
        say(format!("{} and {}", count(errors, "error"), count(warnings, "warning")));
    }
}

fn count(number: usize, noun: &str) -> String {
    format!("{number} {noun}{}", if number == 1 { "" } else { "s" })
}

/// Colours only where somebody sees them and has not declined (no-color.org).
fn renderer() -> Renderer {
    if colors(io::stderr().is_terminal(), std::env::var_os("NO_COLOR").as_deref()) {
        Renderer::styled()
    } else {
        Renderer::plain()
    }
}

/// `NO_COLOR` counts if it is set and not empty.
fn colors(terminal: bool, no_color: Option<&std::ffi::OsStr>) -> bool {
    terminal && no_color.is_none_or(|value| value.is_empty())
}

/// One finding: title, `file:line:column`, the source line (of a long one the part about the place) with a caret, help.
fn render(diagnostic: &Diagnostic, sources: &SourceMap, renderer: &Renderer) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
        Severity::Note => Level::NOTE,
    };
    let mut group = Group::with_title(level.primary_title(&diagnostic.message));
    if let Some((path, excerpt)) = diagnostic.place(sources) {
        let position = excerpt.position;
        let (before, after) = (mark(excerpt.cut_before), mark(excerpt.cut_after));
        let text = format!("{before}{}{after}", excerpt.text);
        let span = excerpt.highlight.start + before.len()..excerpt.highlight.end + before.len();
        let annotation = AnnotationKind::Primary.span(span).label(diagnostic.label.as_deref());
        let path = path.display().to_string();
        let snippet = Snippet::source(text).line_start(position.line).fold(false).annotation(annotation);
        group = if excerpt.cut_before {
            // The column of a cut line cannot be counted from what is left of it.
            let origin = Origin::path(path).line(position.line).char_column(position.column);
            group.element(origin).element(snippet)
        } else {
            group.element(snippet.path(path))
        };
    } else if let Some(label) = &diagnostic.label {
        group = group.element(Level::NOTE.message(label));
    }
    if let Some(help) = &diagnostic.help {
        group = group.element(Level::HELP.message(help));
    }
    renderer.render(&[group])
}

/// Stands for what was cut from a long line.
fn mark(cut: bool) -> &'static str {
    if cut { "..." } else { "" }
}

#[cfg(test)]
mod tests {
    use super::*;
    use etendue_scene::Span;

    fn plain(text: &str, start: usize, end: usize) -> String {
        let mut sources = SourceMap::new();
        let file = sources.insert("scenes/a.toml", text.as_bytes().to_vec()).unwrap();
        let diagnostic = Diagnostic::error("unknown key `postion`")
            .at(Span::new(file, start..end))
            .label("not a key of [camera]")
            .help("did you mean `position`?");
        render(&diagnostic, &sources, &Renderer::plain())
    }

    #[test]
    fn file_line_column_caret_and_help() {
        let text = plain("[camera]\r\n  postion = 1\r\n", 12, 19);
        for part in
            ["error: unknown key `postion`", "scenes/a.toml:2:3", "2 |   postion = 1", "^^^^^^^ not a key", "help: did"]
        {
            assert!(text.contains(part), "{part} in\n{text}");
        }
    }

    #[test]
    fn long_lines_are_cut_and_keep_their_column() {
        let text = plain(&format!("{}postion{}", "a".repeat(5000), "b".repeat(5000)), 5000, 5007);
        assert!(text.contains("scenes/a.toml:1:5001") && text.contains("^^^^^^^"), "{text}");
        assert!(text.lines().all(|line| line.len() < 320), "{text}");
    }

    #[test]
    fn ends_of_files_and_bytes_of_any_kind_have_a_place() {
        assert!(plain("", 0, 0).contains(":1:1"));
        assert!(plain("a\n", 2, 2).contains(":2:1"));
        assert!(!plain("\u{1b}[31mred\u{7}", 0, 4).contains('\u{1b}'));
    }

    #[test]
    fn colours_want_a_terminal_and_no_refusal() {
        assert!(colors(true, None) && colors(true, Some("".as_ref())));
        assert!(!colors(false, None) && !colors(true, Some("1".as_ref())));
    }
}
