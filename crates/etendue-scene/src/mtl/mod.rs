//! MTL material libraries (Alias|Wavefront; extensions by later programs).
//!
//! # What the keys mean here
//!
//! | key | meaning |
//! |---|---|
//! | `newmtl NAME` | begins a material; the name may hold blanks, or be empty |
//! | `Kd` | diffuse albedo; absent: 0 if anything else scatters or emits, otherwise 0.5 |
//! | `Ks` | albedo of the specular lobe; absent: 0 |
//! | `Ns` | Phong exponent: the lobe is GGX with alpha = sqrt(2 / (Ns + 2)); from 1000 on a mirror; absent: 10, with `illum` 3, 5 and 8 a mirror |
//! | `Ke` | radiance emitted, both ways: windings in such files are arbitrary, and a lamp that shines into the wall gives a black picture without a word |
//! | `Ka` | ignored, since ambient light is computed; but above 1, without `Ke`, it cannot be an albedo and counts as `Ke` |
//! | `Ni` | index of refraction, for `illum` 4, 6, 7, 9; absent: 1.5 |
//! | `d`, `Tr` | opacity d = 1 - Tr, a fraction of the surface that is not there; if both are given and disagree, `d` counts |
//! | `Tf` | tint of refracted light, for `illum` 4, 6, 7, 9 |
//! | `map_Kd`, `map_Ks`, `map_Ke` | images that multiply these colours; absent or 0, the colour counts as 1 |
//! | `map_Ns` | multiplies `Ns`: the lobe is Phong's then |
//! | `map_d` | multiplies `d`, by its brightness, or its alpha if it is the file of `map_Kd` or `-imfchan m` asks for it. The alpha of `map_Kd` alone is not opacity, as most programs have it |
//! | `bump`, `map_bump` | heights: white is 0.01 units above black, times `-bm`. A file whose name says that it holds normals is read as `norm` |
//! | `norm` | a map of normals; `-bm` multiplies their tilt |
//! | `map_Ka`, `refl`, `disp`, `decal`, `sharpness`, `map_aat` | ignored |
//!
//! | `illum` | means |
//! |---|---|
//! | 0, 1 | `Kd` alone, `Ks` is ignored |
//! | 2, 10, absent | `Kd` and `Ks` with the width of `Ns` |
//! | 3, 5, 8 | the same (`illum` 5 asks for Fresnel: approximated by a constant `Ks`) |
//! | 4, 6, 7, 9 | glass: what d and `Kd` leave is refracted, times `Tf`, with index `Ni` and Fresnel's equations; d is used up by that, and the surface is there in full. Without `Kd`: glass alone, its reflection is not scaled by `Ks`. With `Ni` 1 and nothing transparent in `d` or `Tf`: opaque, since some programs write 4 for every material |
//!
//! Images take `-s u v` and `-o u v` (texture coordinates times s plus o), `-clamp on`, `-mm base gain`, `-bm`, `-imfchan
//! r|g|b|m|l`, and `-blendu off -blendv off` together (no interpolation); `-t -boost -texres -type -cc` are ignored. Options
//! may stand after the name, which may hold blanks, and backslashes for slashes.
//!
//! Any of `Pr Pm Ps Pc Pcr aniso anisor` or their maps makes a material
//! [`Principled`](etendue::material::Scattering::Principled): base colour `Kd`, roughness `Pr` (absent: by `Ns`), metallic
//! `Pm`, white sheen `Ps`, coat `Pc` with roughness `Pcr`, `aniso`, and its rotation `anisor` in turns; `Ni` as index (1
//! counts as 1.5), and transmission where `illum` asks for glass. `Ks` is ignored then.
//!
//! # The dialect of an older renderer
//!
//! A file with one of `Td Ts Nst n texture scatter BRDF` is in that dialect, and its materials are
//! [`Phong`](etendue::material::Scattering::Phong): `Kd`, `Ks` with `Ns`, diffuse transmission `Td`, glossy transmission `Ts`
//! with `Nst`, index `n`; exponents from 1000 on are mirrors and clear refraction without Fresnel's equations. `Tr` says only
//! whether `Td` and `Ts` count. `texture FILE [Kd] [Ks] [Td] [Ts]` multiplies the colours named. In any file the material
//! `AreaLightSource` emits its `Kd`; `GlobalScatter` stands for a medium, which a [script](crate::script) fills the world with.
//!
//! Colours are linear Rec. 709; one number is grey. `Kd spectral ...` and `Kd xyz ...` are not read. Colours above 1 and
//! below 0 are clamped with a warning, as are other numbers out of their range. Lobes that add up to more than 1 are scaled
//! down together (see [`Scattering::Mtl`](etendue::material::Scattering::Mtl)).

mod classic;
mod dialect;
mod findings;
mod keys;
mod map;
mod mapping;
mod old;
mod principled;
mod record;

use crate::{
    Diagnostics, FileId, Severity, Span,
    mesh_file::{KeyStatus, KeyUse, NamedMaterial},
    obj::number_error,
    text::{Cursor, NumberError, Tally, joined, shown},
};
use findings::Ignored;
use keys::{Key, Kind};
pub(crate) use old::{OldMaterial, OldUse};
use record::{Record, Value};
use std::{collections::BTreeMap, ops::Range};

/// Most materials of one library.
const MOST_MATERIALS: usize = 1 << 14;

/// A material library that was read.
#[derive(Clone, Debug)]
pub struct MaterialLibrary {
    /// In the order of the file.
    pub materials: Vec<NamedMaterial>,
    /// What became of the keys.
    pub keys: Vec<KeyUse>,
    /// What was found wrong, approximated or ignored. Errors among it are malformed and infinite numbers; such a value counts
    /// as absent.
    pub findings: Diagnostics,
}

struct Parser<'a> {
    cursor: Cursor<'a>,
    file: FileId,
    records: Vec<Record>,
    /// Within a material beyond the most.
    is_beyond: bool,
    errors: Diagnostics,
    ignored: Tally<Ignored>,
}

/// Reads a material library.
pub fn read(bytes: &[u8], file: FileId) -> MaterialLibrary {
    parse(bytes, file).finish()
}

/// Reads a material library as the older renderer did, whatever its keys; what is wrong with it [`read`] tells.
pub(crate) fn read_old(bytes: &[u8], file: FileId) -> Vec<OldMaterial> {
    parse(bytes, file).records.iter().map(|record| OldMaterial::new(record, file)).collect()
}

fn parse(bytes: &[u8], file: FileId) -> Parser<'_> {
    let mut parser = Parser {
        cursor: Cursor::new(bytes),
        file,
        records: vec![],
        is_beyond: false,
        errors: Diagnostics::new(),
        ignored: Tally::new(),
    };
    while !parser.cursor.is_done() && !parser.errors.is_full(Severity::Error) {
        parser.statement();
        parser.cursor.next_line();
    }
    parser
}

impl Parser<'_> {
    fn statement(&mut self) {
        let word = self.cursor.word();
        let bytes = self.cursor.bytes;
        let key = &bytes[word.clone()];
        if key.is_empty() {
            return;
        }
        if key == b"newmtl" {
            return self.begin(word);
        }
        if self.is_beyond {
            return;
        }
        if self.records.is_empty() {
            return self.ignored.add(Ignored::BeforeFirst, key, self.file, word);
        }
        match Key::of(key) {
            None => self.ignored.add(Ignored::Unknown, key, self.file, word),
            Some((known, usual)) => {
                if !usual {
                    self.ignored.add(Ignored::Case, key, self.file, word.clone());
                }
                self.property(known, word, !usual);
            }
        }
    }

    fn begin(&mut self, word: Range<usize>) {
        let name = self.cursor.name();
        let place = word.start..name.end.max(word.end);
        if self.records.len() == MOST_MATERIALS {
            self.is_beyond = true;
            let most = MOST_MATERIALS.to_string();
            return self.ignored.add(Ignored::TooMany, most.as_bytes(), self.file, place);
        }
        let name = String::from_utf8_lossy(&joined(&self.cursor.bytes[name])).into_owned();
        self.records.push(Record { name, place, entries: BTreeMap::new() });
    }

    fn property(&mut self, key: Key, word: Range<usize>, noted: bool) {
        let found = self.ignored.total();
        let value = match key.kind() {
            Kind::Colour(most) => self.colour(key, most).map(Value::Colour),
            Kind::Number(least, most) => {
                if key == Key::Opacity {
                    self.skip_halo();
                }
                self.scalar(key, least, most).map(Value::Number)
            }
            Kind::Illum => self.illum().map(Value::Illum),
            Kind::Map => self.map(key, word.clone()),
            Kind::Texture => return self.texture(word),
            Kind::Rest => None,
        };
        let noted = noted || self.ignored.total() != found;
        self.set(key, word, value, noted);
    }

    fn set(&mut self, key: Key, word: Range<usize>, value: Option<Value>, noted: bool) {
        if let Some(record) = self.records.last_mut() {
            record.set(key, word, value, noted);
        }
    }

    fn skip_halo(&mut self) {
        let mut ahead = self.cursor.clone();
        let option = ahead.word();
        if &self.cursor.bytes[option.clone()] == b"-halo" {
            self.cursor = ahead;
            self.ignored.add(Ignored::Halo, b"d -halo", self.file, option);
        }
    }

    fn illum(&mut self) -> Option<u32> {
        let word = self.cursor.word();
        let text = &self.cursor.bytes[word.clone()];
        match str::from_utf8(text).ok().and_then(|text| text.parse().ok()) {
            Some(illum @ 0..=10) => Some(illum),
            _ => {
                self.ignored.add(Ignored::BadIllum, &[b"illum ", text].concat(), self.file, word);
                None
            }
        }
    }

    /// The rest of the line as an image and its options; what is ignored has been reported.
    fn image(&mut self, key: Key, word: Range<usize>) -> map::Statement {
        let rest = self.cursor.name();
        let statement = map::read(self.cursor.bytes, rest, key, self.file);
        for (option, place) in &statement.unused {
            let named = format!("{} {option}", key.name());
            self.ignored.add(Ignored::Option, named.as_bytes(), self.file, place.clone());
        }
        if statement.map.is_none() {
            self.ignored.add(Ignored::NoFile, key.name().as_bytes(), self.file, word);
        }
        statement
    }

    fn map(&mut self, key: Key, word: Range<usize>) -> Option<Value> {
        self.image(key, word).map.map(|map| Value::Map(Box::new(map)))
    }

    fn texture(&mut self, word: Range<usize>) {
        let statement = self.image(Key::Texture, word.clone());
        self.set(Key::Texture, word.clone(), None, statement.map.is_none());
        let Some((map, record)) = statement.map.zip(self.records.last_mut()) else { return };
        for key in statement.targets {
            // Not a statement of its own, so that it is not counted as one.
            let entry = record::Entry { value: None, place: word.clone(), count: 0, noted: false };
            record.entries.entry(key).or_insert(entry).value = Some(Value::Map(Box::new(map.clone())));
        }
    }

    /// `r [g b]`; `None` after a report.
    fn colour(&mut self, key: Key, most: f64) -> Option<[f32; 3]> {
        let mut ahead = self.cursor.clone();
        let first = ahead.word();
        let kind = &self.cursor.bytes[first.clone()];
        if kind == b"spectral" || kind == b"xyz" {
            let named = [key.name().as_bytes(), b" ", kind].concat();
            self.ignored.add(Ignored::Spectral, &named, self.file, first);
            return None;
        }
        let red = self.scalar(key, 0.0, most)?;
        self.cursor.skip_blanks();
        if self.cursor.at_line_end() {
            return Some([red; 3]);
        }
        Some([red, self.scalar(key, 0.0, most)?, self.scalar(key, 0.0, most)?])
    }

    /// A number, clamped to a range with a warning; `None` after an error.
    fn scalar(&mut self, key: Key, least: f64, most: f64) -> Option<f32> {
        let result = self.cursor.number();
        let here = self.cursor.here();
        let value = match result {
            Ok(value) => value,
            Err(error) => {
                self.bad_number(error, key, here);
                return None;
            }
        };
        if value < least || value > most {
            let end = self.cursor.at;
            self.ignored.add(Ignored::Clamped, key.name().as_bytes(), self.file, end.saturating_sub(1)..end);
        }
        let value = value.clamp(least, most) as f32;
        if !value.is_finite() {
            self.bad_number(NumberError::NotFinite, key, here);
            return None;
        }
        Some(value)
    }

    fn bad_number(&mut self, error: NumberError, key: Key, here: Range<usize>) {
        let word = shown(&self.cursor.bytes[here.clone()]);
        let expected = format!("a number for {}", key.name());
        self.errors.push(number_error(error, &word, &expected).at(Span::new(self.file, here)));
    }

    fn finish(mut self) -> MaterialLibrary {
        let is_dialect = self.records.iter().any(|record| record.entries.keys().any(|key| key.is_of_dialect()));
        let mut used: BTreeMap<Key, (usize, Range<usize>)> = BTreeMap::new();
        let mut materials = Vec::with_capacity(self.records.len());
        for mut record in self.records {
            let mut noted = vec![];
            let material = mapping::material(&record, is_dialect, &mut |what, key| {
                let entry = record.entries.get(&key);
                let place = entry.map_or(&record.place, |entry| &entry.place).clone();
                let count = entry.filter(|_| what.is_of_statements()).map_or(1, |entry| entry.count);
                self.ignored.add_many(what, key.name().as_bytes(), count, self.file, place);
                noted.push(key);
            });
            for key in noted {
                if let Some(entry) = record.entries.get_mut(&key) {
                    entry.noted = true;
                }
            }
            for (key, entry) in record.entries {
                if entry.count > 0 && !entry.noted {
                    used.entry(key).or_insert((0, entry.place)).0 += entry.count;
                }
            }
            let origin = Some(Span::new(self.file, record.place).into());
            materials.push(NamedMaterial { name: record.name, material: Box::new(material), origin });
        }
        let used = used.into_iter().map(|(key, (count, place))| KeyUse {
            key: key.name().to_owned(),
            status: KeyStatus::Used,
            count,
            first: Span::new(self.file, place).into(),
        });
        let keys = used.chain(self.ignored.uses()).collect();
        let mut findings = self.errors;
        self.ignored.report(&mut findings);
        findings.sort();
        MaterialLibrary { materials, keys, findings }
    }
}
