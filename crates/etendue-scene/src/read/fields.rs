//! Walking tables by hand: every value is checked where it stands, and every key is accounted for.

use super::{
    keyed::Part,
    keys::{Key, Section},
    texture::Textures,
};
use crate::{
    Diagnostic, Diagnostics, Origin, Severity,
    diagnostic::nearest,
    value::{Data, Entry, Value},
};
use std::{
    cell::{Cell, RefCell},
    collections::BTreeMap,
};

/// What the reading of one file shares.
#[derive(Debug)]
pub struct Context {
    /// What was found.
    pub diagnostics: RefCell<Diagnostics>,
    /// Statements were skipped for their syntax: do not complain of what is missing.
    pub damaged: bool,
    /// `[textures.NAME]`, by name; `None` for those that could not be read. All are there before a material refers to one.
    pub textures: RefCell<Textures>,
    /// The time that values with keys are read at, seconds.
    pub time: Cell<f64>,
    /// The part that is being read, if it may have keys.
    pub part: Cell<Option<Part>>,
    /// Parts that have keys, with the times of those.
    pub varying: RefCell<BTreeMap<Part, Vec<f64>>>,
}

impl Context {
    /// A reading at time 0 that has found `diagnostics` so far.
    pub fn new(diagnostics: Diagnostics, damaged: bool) -> Self {
        Self {
            diagnostics: RefCell::new(diagnostics),
            damaged,
            textures: RefCell::default(),
            time: Cell::new(0.0),
            part: Cell::new(None),
            varying: RefCell::default(),
        }
    }

    /// Reports something.
    pub fn push(&self, diagnostic: Diagnostic) {
        self.diagnostics.borrow_mut().push(diagnostic);
    }

    /// Reports that something is missing, unless it may have been in a skipped statement.
    pub fn missing(&self, diagnostic: Diagnostic) {
        if !self.damaged {
            self.push(diagnostic);
        }
    }
}

/// A value with the name that messages call it by.
#[derive(Clone, Copy)]
pub struct Item<'a> {
    /// Where findings go.
    pub cx: &'a Context,
    /// The key.
    pub name: &'a str,
    /// The value.
    pub value: &'a Value,
}

impl<'a> Item<'a> {
    /// Reports that the value is of the wrong kind.
    pub fn wrong_kind<T>(&self, expected: &str) -> Option<T> {
        self.wrong_kind_help(expected, "")
    }

    /// Reports that the value is of the wrong kind, and how to write the right one.
    pub fn wrong_kind_help<T>(&self, expected: &str, how: &str) -> Option<T> {
        if self.value.data != Data::Broken {
            let error = Diagnostic::error(format!("`{}` must be {expected}", self.name))
                .at(self.value.origin.clone())
                .label(format!("this is {}", self.value.data.kind()));
            self.cx.push(if how.is_empty() { error } else { error.help(format!("write {how}")) });
        }
        None
    }

    /// Reports an error at the value.
    pub fn error<T>(&self, message: impl Into<String>, label: impl Into<String>) -> Option<T> {
        self.cx.push(Diagnostic::error(message).at(self.value.origin.clone()).label(label));
        None
    }

    /// The items of an array.
    pub fn array(&self, expected: &str) -> Option<impl ExactSizeIterator<Item = Item<'a>> + use<'a>> {
        self.array_help(expected, "")
    }

    /// The items of an array, and how to write one.
    pub fn array_help(&self, expected: &str, how: &str) -> Option<impl ExactSizeIterator<Item = Item<'a>> + use<'a>> {
        let (cx, name) = (self.cx, self.name);
        match &self.value.data {
            Data::Array(values) => Some(values.iter().map(move |value| Item { cx, name, value })),
            _ => self.wrong_kind_help(expected, how),
        }
    }

    /// Text.
    pub fn text(&self) -> Option<&'a str> {
        match &self.value.data {
            Data::String(text) => Some(text),
            _ => self.wrong_kind("a string"),
        }
    }

    /// A name that is not empty.
    pub fn name_text(&self) -> Option<&'a str> {
        match self.text()? {
            "" => self.error(format!("`{}` is empty", self.name), "expected a name"),
            text => Some(text),
        }
    }

    /// True or false.
    pub fn boolean(&self) -> Option<bool> {
        match self.value.data {
            Data::Boolean(value) => Some(value),
            _ => self.wrong_kind("true or false"),
        }
    }

    /// One of several names.
    pub fn choice<T: Clone>(&self, choices: &[(&str, T)]) -> Option<T> {
        let names = || choices.iter().map(|(name, _)| *name);
        let Data::String(text) = &self.value.data else {
            return self.wrong_kind(&format!("one of {}", list(names())));
        };
        match choices.iter().find(|(name, _)| name == text) {
            Some((_, value)) => Some(value.clone()),
            None => {
                let error = Diagnostic::error(format!("`{}` has no `{text}`", self.name))
                    .at(self.value.origin.clone())
                    .label(format!("expected one of {}", list(names())));
                self.cx.push(error.suggest(text, names()));
                None
            }
        }
    }

    /// The fields of a table, and how to write one.
    pub fn table(&self, section: &'static Section, how: &str) -> Option<Fields<'a>> {
        match &self.value.data {
            Data::Table(entries) => Some(Fields::new(self.cx, section, entries, &self.value.origin)),
            _ => self.wrong_kind_help("a table", how),
        }
    }
}

/// Names in backquotes, separated by commas.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    names.into_iter().map(|n| format!("`{n}`")).collect::<Vec<_>>().join(", ")
}

/// The keys of one table, read one by one; [`Fields::finish`] reports those that nothing read.
pub struct Fields<'a> {
    cx: &'a Context,
    section: &'static Section,
    entries: &'a [Entry],
    /// Where the table is.
    pub origin: &'a Origin,
    /// The key that picks the variant, and the variant.
    variant: Option<(&'static str, &'static str)>,
    /// Bit i: key i of the section was asked for.
    read: Cell<u64>,
}

impl<'a> Fields<'a> {
    /// The fields of `entries`.
    pub fn new(cx: &'a Context, section: &'static Section, entries: &'a [Entry], origin: &'a Origin) -> Self {
        Self { cx, section, entries, origin, variant: None, read: Cell::new(0) }
    }

    /// What the reading shares.
    pub fn cx(&self) -> &'a Context {
        self.cx
    }

    /// The variant of the table by its key `type` (or another one), and which one an absent key means; without that the key
    /// is required. After an error the other keys are not checked against any variant.
    pub fn variant<T: Copy>(
        &mut self,
        key: &'static str,
        choices: &[(&'static str, T)],
        default: Option<&'static str>,
    ) -> Option<T> {
        let names: Vec<(&str, (&'static str, T))> = choices.iter().map(|c| (c.0, *c)).collect();
        let chosen = match (self.get(key), default) {
            (None, Some(default)) => choices.iter().find(|c| c.0 == default).copied(),
            _ => self.need(key, |item| item.choice(&names)),
        };
        let (name, value) = chosen?;
        self.variant = Some((key, name));
        Some(value)
    }

    /// The value of a key.
    pub fn get(&self, key: &str) -> Option<Item<'a>> {
        let index = self.section.keys.iter().position(|k| k.name == key);
        debug_assert!(index.is_some(), "`{key}` is not in the list of keys of {}", self.section.name);
        self.read.set(self.read.get() | 1 << index.unwrap_or(63));
        let entry = self.entries.iter().find(|e| e.key == key)?;
        Some(Item { cx: self.cx, name: &entry.key, value: &entry.value })
    }

    /// The value of an optional key, as `parse` understands it.
    pub fn read<T>(&self, key: &str, parse: impl FnOnce(Item<'a>) -> Option<T>) -> Option<T> {
        self.get(key).and_then(parse)
    }

    /// The value of a required key; reports that it is missing.
    pub fn need<T>(&self, key: &str, parse: impl FnOnce(Item<'a>) -> Option<T>) -> Option<T> {
        match self.get(key) {
            Some(item) => parse(item),
            None => {
                self.lacks(&format!("`{key}`"));
                None
            }
        }
    }

    /// Reports that the table lacks something.
    pub fn lacks(&self, what: &str) {
        let said = self.variant.filter(|(key, _)| self.key_origin(key).is_some());
        let of = said.map(|(key, variant)| format!(" of {key} `{variant}`")).unwrap_or_default();
        let message = format!("{}{of} needs {what}", self.section.name);
        self.cx.missing(Diagnostic::error(message).at(self.origin.clone()));
    }

    /// Reports something.
    pub fn push(&self, diagnostic: Diagnostic) {
        self.cx.push(diagnostic);
    }

    /// Where a key is.
    pub fn key_origin(&self, key: &str) -> Option<&'a Origin> {
        self.entries.iter().find(|e| e.key == key).map(|e| &e.origin)
    }

    /// Reports that two keys exclude each other, if both are there.
    pub fn exclusive(&self, first: &str, second: &str) {
        if let (Some(_), Some(origin)) = (self.key_origin(first), self.key_origin(second)) {
            let message = format!("`{first}` and `{second}` exclude each other");
            self.cx.push(Diagnostic::error(message).at(origin.clone()).help("keep one of them"));
        }
    }

    fn applies(&self, key: &Key) -> bool {
        key.types.is_empty() || self.variant.is_none_or(|(_, v)| key.types.contains(&v))
    }

    /// Reports the keys that are not of this section or variant.
    pub fn finish(self) {
        for entry in self.entries {
            match self.section.keys.iter().position(|k| k.name == entry.key) {
                None => self.unknown(entry),
                Some(index) if !self.applies(&self.section.keys[index]) => {
                    let (key, variant) = self.variant.unwrap_or_default();
                    let message = format!("`{}` is not a key of {key} `{variant}`", entry.key);
                    let help = format!("it belongs to {}", list(self.section.keys[index].types.iter().copied()));
                    self.cx.push(Diagnostic::error(message).at(entry.origin.clone()).help(help));
                }
                Some(index) => {
                    let was_read = self.read.get() >> index & 1 == 1 || self.variant.is_none();
                    debug_assert!(was_read, "nothing reads `{}` of {}", entry.key, self.section.name);
                }
            }
        }
    }

    fn unknown(&self, entry: &Entry) {
        let known = || self.section.keys.iter().filter(|k| self.applies(k)).map(|k| k.name);
        let error = Diagnostic::error(format!("unknown key `{}` in {}", entry.key, self.section.name));
        let error = error.at(entry.origin.clone());
        if self.cx.diagnostics.borrow().is_full(Severity::Error) {
            return self.cx.push(error);
        }
        let help = match nearest(&entry.key, known()) {
            Some(name) => format!("did you mean `{name}`?"),
            None => format!("the keys here are {}", list(known())),
        };
        self.cx.push(error.help(help));
    }
}
