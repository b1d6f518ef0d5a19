//! The materials that an OBJ file's faces use.

use super::{chunk::Named, statements::Statements, unifier::NONE};
use crate::{
    Diagnostic, Diagnostics, FileId, Origin, Severity, Span,
    mesh_file::{KeyUse, MeshFile, NamedMaterial, OpenLibrary},
    mtl,
    text::shown,
};
use std::{
    collections::{BTreeMap, BTreeSet},
    ops::Range,
};

/// Most libraries that one file may open.
const MOST_LIBRARIES: usize = 64;

/// Most materials that the faces and spheres of one file may use: each takes more than a kilobyte.
const MOST_MATERIALS: usize = 1 << 16;

/// Names of `mtllib` that stand in one line are joined if this many or fewer words would have to be.
const MOST_WORDS: usize = 64;

struct Libraries<'a> {
    file: FileId,
    open: OpenLibrary<'a>,
    tried: BTreeSet<String>,
    /// By name; the first definition counts.
    materials: BTreeMap<String, NamedMaterial>,
    missing: bool,
    keys: Vec<KeyUse>,
    found: Diagnostics,
}

/// The materials that faces use, in the order of first use, and the index of each of the file's numbers among them.
pub(super) struct Used {
    pub materials: Vec<NamedMaterial>,
    /// What became of the libraries' keys.
    pub keys: Vec<KeyUse>,
    /// How many of them faces use; the others are of spheres.
    pub of_faces: usize,
    index: BTreeMap<u32, u32>,
}

impl Used {
    pub fn index_of(&self, number: u32) -> u32 {
        self.index[&number]
    }
}

/// Reads the libraries and looks up what the faces use. Findings go to `found`, those of the libraries included.
pub(super) fn resolve(statements: &Statements, file: FileId, open: OpenLibrary, found: &mut Diagnostics) -> Used {
    let mut libraries = Libraries {
        file,
        open,
        tried: BTreeSet::new(),
        materials: BTreeMap::new(),
        missing: false,
        keys: vec![],
        found: Diagnostics::new(),
    };
    for named in &statements.libraries {
        libraries.add_line(named);
    }
    let mut used = libraries.look_up(statements);
    used.keys = libraries.keys;
    found.append(libraries.found);
    used
}

impl Libraries<'_> {
    /// One `mtllib` line: the name of one library that may hold blanks, or several names.
    fn add_line(&mut self, Named { name: line, place }: &Named) {
        let whole = Span::new(self.file, place.clone());
        if line.is_empty() {
            self.found.push(Diagnostic::warning("`mtllib` without a name").at(whole));
            return;
        }
        let several = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty()).nth(1).is_some();
        if self.add(line, whole, several) || !several {
            return;
        }
        for name in split_names(line) {
            let at = place.start + name.start..place.start + name.end;
            // Names over several lines have other places.
            let span = if line.len() == place.len() { Span::new(self.file, at) } else { whole };
            self.add(&line[name], span, false);
        }
    }

    /// Opens a library; true if that succeeded, now or before.
    fn add(&mut self, name: &[u8], place: Span, may_fail: bool) -> bool {
        let name = String::from_utf8_lossy(name).into_owned();
        if self.tried.contains(&name) {
            return true;
        }
        if self.tried.len() == MOST_LIBRARIES {
            if !std::mem::replace(&mut self.missing, true) {
                let message = format!("more than {MOST_LIBRARIES} material libraries: the rest is not read");
                self.found.push(Diagnostic::warning(message).at(place));
            }
            return true;
        }
        match (self.open)(&name) {
            Ok(library) => {
                let mtl::MaterialLibrary { materials, keys, findings } = mtl::read(&library.bytes, library.file);
                self.keys.extend(keys);
                self.found.extend(library.note.map(|note| Diagnostic::note(note).at(place)));
                self.found.append(findings);
                for material in materials {
                    self.define(material);
                }
                self.tried.insert(name);
                true
            }
            Err(_) if may_fail => false,
            Err(error) => {
                self.missing = true;
                self.found.push(
                    Diagnostic::warning(error.to_string()).at(place).label("its materials are replaced by grey ones"),
                );
                self.tried.insert(name);
                false
            }
        }
    }

    fn define(&mut self, material: NamedMaterial) {
        match self.materials.entry(material.name.clone()) {
            std::collections::btree_map::Entry::Vacant(entry) => {
                entry.insert(material);
            }
            std::collections::btree_map::Entry::Occupied(_) => {
                let warning = Diagnostic::warning(format!("material `{}` is defined again", material.name));
                let warning = warning.label("the first definition counts");
                self.found.push(match material.origin {
                    Some(origin) => warning.at(origin),
                    None => warning,
                });
            }
        }
    }

    fn look_up(&mut self, statements: &Statements) -> Used {
        if let Some(first) = statements.material_names.get(MOST_MATERIALS) {
            let error = Diagnostic::error(format!("more than {MOST_MATERIALS} materials"));
            self.found.push(error.at(Span::new(self.file, first.place.clone())));
            return Used { materials: vec![], keys: vec![], of_faces: 0, index: BTreeMap::new() };
        }
        let mut used = Used {
            materials: Vec::with_capacity(statements.material_names.len() + 1),
            keys: vec![],
            of_faces: 0,
            index: BTreeMap::new(),
        };
        for &(_, number) in &statements.materials.runs {
            self.add_used(number, statements, &mut used);
        }
        used.of_faces = used.materials.len();
        for &(.., number) in &statements.spheres {
            self.add_used(number, statements, &mut used);
        }
        if used.index.keys().all(|number| *number == NONE) {
            used.materials.clear();
        }
        used
    }

    fn add_used(&mut self, number: u32, statements: &Statements, used: &mut Used) {
        if used.index.contains_key(&number) {
            return;
        }
        used.index.insert(number, used.materials.len() as u32);
        used.materials.push(match statements.material_names.get(number as usize) {
            Some(named) => self.material(named),
            None => grey("", None),
        });
    }

    fn material(&mut self, Named { name, place }: &Named) -> NamedMaterial {
        let place = Span::new(self.file, place.clone());
        let text = String::from_utf8_lossy(name).into_owned();
        if let Some(material) = self.materials.get(&text) {
            return material.clone();
        }
        // With the only library missing that was said already; its materials need not be said one by one.
        let said = self.missing && self.materials.is_empty();
        if !said && !self.found.is_full(Severity::Warning) {
            let warning = Diagnostic::warning(format!("material `{}` is not defined", shown(name)));
            let warning = warning.at(place).label("a grey one is used");
            let names = self.materials.keys().map(String::as_str);
            self.found.push(if self.materials.is_empty() {
                warning.help("the file needs a line `mtllib FILE.mtl` that names its material library")
            } else {
                warning.suggest(&text, names)
            });
        }
        grey(&text, Some(place.into()))
    }
}

fn grey(name: &str, origin: Option<Origin>) -> NamedMaterial {
    NamedMaterial { name: name.to_owned(), material: Box::new(MeshFile::default_material(name)), origin }
}

/// Cuts a line into names that end in `.mtl`, so that names may hold blanks; what is left at the end is a name as well.
fn split_names(line: &[u8]) -> Vec<Range<usize>> {
    let mut names = vec![];
    let mut start = None;
    let mut at = 0;
    for word in line.split(u8::is_ascii_whitespace).take(MOST_WORDS) {
        let range = at..at + word.len();
        at = range.end + 1;
        if word.is_empty() {
            continue;
        }
        let first = *start.get_or_insert(range.start);
        if word.len() >= 4 && word[word.len() - 4..].eq_ignore_ascii_case(b".mtl") {
            names.push(first..range.end);
            start = None;
        }
    }
    if let Some(first) = start {
        names.push(first..line.len().min(at));
    }
    names
}

#[cfg(test)]
mod tests {
    use super::split_names;

    #[test]
    fn names_end_in_mtl() {
        let split =
            |line: &str| split_names(line.as_bytes()).into_iter().map(|r| line[r].to_owned()).collect::<Vec<_>>();
        assert_eq!(split("a.mtl  my own.MTL b c"), ["a.mtl", "my own.MTL", "b c"]);
        assert_eq!(split("one"), ["one"]);
    }
}
