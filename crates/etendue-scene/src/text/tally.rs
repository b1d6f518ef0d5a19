//! Findings that repeat, summed up.

use super::shown;
use crate::{
    Diagnostic, Diagnostics, FileId, Span,
    mesh_file::{KeyStatus, KeyUse},
};
use std::ops::Range;

/// What a finding means for the key or statement that it is about.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Fate {
    /// It counts, but not as it is meant.
    Approximated,
    /// It does not count.
    Ignored,
}

/// A kind of finding that may repeat many times in a file.
pub(crate) trait Finding: Copy + PartialEq {
    /// The message for `count` of them; `key` is the word that they share.
    fn describe(self, key: &str, count: usize) -> Diagnostic;

    /// What became of what it is about.
    fn fate(self) -> Fate {
        Fate::Ignored
    }
}

/// Kinds and words beyond this number are only counted.
const MOST: usize = 64;

/// Counts findings by kind and word, and keeps the first place of each.
#[derive(Debug)]
pub(crate) struct Tally<K> {
    entries: Vec<Entry<K>>,
    /// Findings of further words.
    others: usize,
    total: usize,
}

#[derive(Debug)]
struct Entry<K> {
    kind: K,
    key: String,
    count: usize,
    first: Span,
}

impl<K: Finding> Tally<K> {
    pub fn new() -> Self {
        Self { entries: Vec::new(), others: 0, total: 0 }
    }

    /// How much was counted.
    pub fn total(&self) -> usize {
        self.total
    }

    /// Counts one.
    pub fn add(&mut self, kind: K, key: &[u8], file: FileId, place: Range<usize>) {
        self.add_many(kind, key, 1, file, place);
    }

    /// Counts what another counted in a later part of the same file.
    pub fn append(&mut self, other: Self) {
        for Entry { kind, key, count, first } in other.entries {
            self.add_shown(kind, key, count, first);
        }
        self.others += other.others;
    }

    /// Counts several, the first of them at `place`.
    pub fn add_many(&mut self, kind: K, key: &[u8], count: usize, file: FileId, place: Range<usize>) {
        self.add_shown(kind, shown(key), count, Span::new(file, place));
    }

    fn add_shown(&mut self, kind: K, key: String, count: usize, first: Span) {
        self.total += count;
        if let Some(entry) = self.entries.iter_mut().find(|entry| entry.kind == kind && entry.key == key) {
            entry.count += count;
        } else if self.entries.len() < MOST {
            self.entries.push(Entry { kind, key, count, first });
        } else {
            self.others += count;
        }
    }

    /// A record of each kind and word, its message being the reason.
    pub fn uses(&self) -> Vec<KeyUse> {
        let uses = self.entries.iter().map(|Entry { kind, key, count, first }| {
            let reason = kind.describe(key, *count).message;
            let status = match kind.fate() {
                Fate::Approximated => KeyStatus::Approximated(reason),
                Fate::Ignored => KeyStatus::Ignored(reason),
            };
            KeyUse { key: key.clone(), status, count: *count, first: (*first).into() }
        });
        uses.collect()
    }

    /// One diagnostic for each kind and word, at its first place.
    pub fn report(self, diagnostics: &mut Diagnostics) {
        for Entry { kind, key, count, first } in self.entries {
            diagnostics.push(kind.describe(&key, count).at(first));
        }
        if self.others > 0 {
            diagnostics.push(Diagnostic::note(format!("{} more of other kinds were ignored", self.others)));
        }
    }
}
