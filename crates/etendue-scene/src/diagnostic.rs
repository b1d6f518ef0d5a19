//! What readers have to say about a file: plain records, printed by whoever has a terminal.

use crate::source::{Excerpt, Origin, SourceMap};
use std::{fmt, path::Path};

/// How bad it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Severity {
    /// The input cannot be used.
    Error,
    /// It can be used, but probably is not what was meant.
    Warning,
    /// Something was skipped or approximated.
    Note,
}

impl fmt::Display for Severity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Severity::Error => "error",
            Severity::Warning => "warning",
            Severity::Note => "note",
        })
    }
}

/// One finding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Diagnostic {
    /// How bad it is.
    pub severity: Severity,
    /// What is wrong, in one sentence without a full stop.
    pub message: String,
    /// Where.
    pub origin: Option<Origin>,
    /// What was expected there, a few words beside the caret.
    pub label: Option<String>,
    /// What to do about it.
    pub help: Option<String>,
    /// An error that may be right input, but asks for what is not there yet.
    pub is_unsupported: bool,
}

impl Diagnostic {
    fn new(severity: Severity, message: impl Into<String>) -> Self {
        Self { severity, message: message.into(), origin: None, label: None, help: None, is_unsupported: false }
    }

    /// An error without a place yet.
    pub fn error(message: impl Into<String>) -> Self {
        Self::new(Severity::Error, message)
    }

    /// An error about what is not there yet, without a place.
    pub fn unsupported(message: impl Into<String>) -> Self {
        Self { is_unsupported: true, ..Self::error(message) }
    }

    /// A warning without a place yet.
    pub fn warning(message: impl Into<String>) -> Self {
        Self::new(Severity::Warning, message)
    }

    /// A note without a place yet.
    pub fn note(message: impl Into<String>) -> Self {
        Self::new(Severity::Note, message)
    }

    /// With its place.
    pub fn at(mut self, origin: impl Into<Origin>) -> Self {
        self.origin = Some(origin.into());
        self
    }

    /// With what was expected.
    pub fn label(mut self, label: impl Into<String>) -> Self {
        self.label = Some(label.into());
        self
    }

    /// With what to do.
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// With "did you mean" if a candidate is near `name`.
    pub fn suggest<'a>(self, name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Self {
        match nearest(name, candidates) {
            Some(candidate) => self.help(format!("did you mean `{candidate}`?")),
            None => self,
        }
    }

    /// The file, and the source line with what to underline, if it came from a file.
    pub fn place<'a>(&self, sources: &'a SourceMap) -> Option<(&'a Path, Excerpt)> {
        let span = self.origin.as_ref()?.span()?;
        Some((sources.path(span.file), sources.excerpt(span)))
    }

    /// One line: `file:line:column: error: message (label); help`.
    pub fn one_line(&self, sources: &SourceMap) -> String {
        let mut text = match self.place(sources) {
            Some((path, Excerpt { position, .. })) => {
                format!("{}:{}:{}: ", path.display(), position.line, position.column)
            }
            None => String::new(),
        };
        text += &format!("{}: {}", self.severity, self.message);
        if let Some(label) = &self.label {
            text += &format!(" ({label})");
        }
        if let Some(help) = &self.help {
            text += &format!("; {help}");
        }
        text
    }
}

/// Collects findings. Of each severity the first [`Diagnostics::KEPT`] are kept, the rest are counted.
#[derive(Clone, Debug, Default)]
pub struct Diagnostics {
    kept: Vec<Diagnostic>,
    counts: [usize; 3],
    /// Errors of right input that asks for what is not there yet.
    unsupported: usize,
}

impl Diagnostics {
    /// How many of each severity are kept.
    pub const KEPT: usize = 100;

    /// Nothing found yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// Adds one.
    pub fn push(&mut self, diagnostic: Diagnostic) {
        let count = &mut self.counts[diagnostic.severity as usize];
        *count += 1;
        self.unsupported += usize::from(diagnostic.is_unsupported);
        if *count <= Self::KEPT {
            self.kept.push(diagnostic);
        }
    }

    /// Adds all of another collection, with what it left out.
    pub fn append(&mut self, other: Diagnostics) {
        let mut left_out = Severity::ALL.map(|severity| other.left_out(severity));
        let unsupported = self.unsupported + other.unsupported;
        for diagnostic in other.kept {
            self.push(diagnostic);
        }
        for (count, rest) in self.counts.iter_mut().zip(&mut left_out) {
            *count += *rest;
        }
        self.unsupported = unsupported;
    }

    /// How many were found, kept or not.
    pub fn count(&self, severity: Severity) -> usize {
        self.counts[severity as usize]
    }

    /// How many were found but not kept.
    pub fn left_out(&self, severity: Severity) -> usize {
        self.count(severity).saturating_sub(Self::KEPT)
    }

    /// True once further findings of this severity are only counted: their text need not be made with care.
    pub fn is_full(&self, severity: Severity) -> bool {
        self.count(severity) >= Self::KEPT
    }

    /// True if something makes the input unusable.
    pub fn has_errors(&self) -> bool {
        self.count(Severity::Error) > 0
    }

    /// True if there are errors, and all are of input that may be right but asks for what is not there yet.
    pub fn only_unsupported(&self) -> bool {
        self.has_errors() && self.unsupported == self.count(Severity::Error)
    }

    /// True if nothing was found.
    pub fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// Those kept, in the order they were found.
    pub fn iter(&self) -> std::slice::Iter<'_, Diagnostic> {
        self.kept.iter()
    }

    /// Puts them in the order of their places: by file in the order of reading, then by byte; those without a place last.
    pub fn sort(&mut self) {
        self.kept.sort_by_key(|d| {
            let span = d.origin.as_ref().and_then(Origin::span);
            (span.is_none(), span)
        });
    }
}

impl Severity {
    /// Every severity, worst first.
    pub const ALL: [Severity; 3] = [Severity::Error, Severity::Warning, Severity::Note];
}

impl<'a> IntoIterator for &'a Diagnostics {
    type Item = &'a Diagnostic;
    type IntoIter = std::slice::Iter<'a, Diagnostic>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

impl Extend<Diagnostic> for Diagnostics {
    fn extend<T: IntoIterator<Item = Diagnostic>>(&mut self, diagnostics: T) {
        for diagnostic in diagnostics {
            self.push(diagnostic);
        }
    }
}

/// Longer names are not compared, nor more candidates, so that the search stays cheap on any input.
const MAX_NAME: usize = 64;
const MAX_CANDIDATES: usize = 4096;

/// The candidate most like `name`, ignoring case, `_` and `-`: within a third of its length in edits (insertions, deletions,
/// substitutions, swaps of neighbours), or one an abbreviation of the other. `None` if none is that near.
pub fn nearest<'a>(name: &str, candidates: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let fold = |s: &str| s.chars().map(|c| if c == '_' { '-' } else { c.to_ascii_lowercase() }).collect::<String>();
    if name.len() > MAX_NAME {
        return None;
    }
    let wanted = fold(name);
    let length = wanted.chars().count();
    let mut best: Option<(usize, &str)> = None;
    for candidate in candidates.into_iter().take(MAX_CANDIDATES).filter(|c| c.len() <= MAX_NAME) {
        let folded = fold(candidate);
        let longest = length.max(folded.chars().count());
        let mut edits = strsim::damerau_levenshtein(&wanted, &folded);
        let abbreviates = length >= 3 && (folded.starts_with(&wanted) || folded.ends_with(&wanted));
        let extends = folded.len() >= 3 && (wanted.starts_with(&folded) || wanted.ends_with(&folded));
        if abbreviates || extends {
            edits = edits.min(longest.div_ceil(3));
        }
        if edits <= longest.div_ceil(3) && edits < longest && best.is_none_or(|(b, _)| edits < b) {
            best = Some((edits, candidate));
        }
    }
    best.map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::source::Span;

    #[test]
    fn nearest_names() {
        let keys = ["position", "look_at", "direction", "fov", "fov_axis", "up"];
        assert_eq!(nearest("postion", keys), Some("position"));
        assert_eq!(nearest("lookat", keys), Some("look_at"));
        assert_eq!(nearest("LOOK-AT", keys), Some("look_at"));
        assert_eq!(nearest("fvo", keys), Some("fov"));
        assert_eq!(nearest("pos", keys), Some("position"));
        assert_eq!(nearest("axis", keys), Some("fov_axis"));
        assert_eq!(nearest("colour", keys), None);
        assert_eq!(nearest("x", keys), None);
        assert_eq!(nearest("", keys), None);
        assert_eq!(nearest("u", ["v"]), None);
        assert_eq!(nearest(&"p".repeat(1000), keys), None);
    }

    #[test]
    fn the_collection_is_bounded_and_counts_the_rest() {
        let mut all = Diagnostics::new();
        for i in 0..150 {
            all.push(Diagnostic::note(format!("{i}")));
        }
        all.push(Diagnostic::error("e"));
        assert_eq!(all.iter().count(), Diagnostics::KEPT + 1);
        assert_eq!(all.left_out(Severity::Note), 50);
        let mut sum = Diagnostics::new();
        sum.push(Diagnostic::note("first"));
        sum.append(all);
        assert_eq!((sum.count(Severity::Note), sum.count(Severity::Error)), (151, 1));
        assert_eq!(sum.iter().count(), Diagnostics::KEPT + 1);
        assert!(sum.has_errors() && sum.is_full(Severity::Note) && !sum.is_full(Severity::Error));
    }

    #[test]
    fn one_line_with_place() {
        let mut map = SourceMap::new();
        let file = map.insert("a.toml", b"[camera]\npostion = 1\n".to_vec()).unwrap();
        let at = |start, end| Origin::from(Span::new(file, start..end));
        let mut all = Diagnostics::new();
        all.push(Diagnostic::error("no such key").at(at(9, 16)).suggest("postion", ["position"]));
        all.push(Diagnostic::warning("no place"));
        all.push(Diagnostic::note("first").at(at(0, 1)).label("here"));
        all.sort();
        let lines: Vec<String> = all.iter().map(|d| d.one_line(&map)).collect();
        assert_eq!(
            lines,
            [
                "a.toml:1:1: note: first (here)",
                "a.toml:2:1: error: no such key; did you mean `position`?",
                "warning: no place"
            ]
        );
    }
}
