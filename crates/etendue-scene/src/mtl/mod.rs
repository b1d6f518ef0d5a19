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
//!
//! | `illum` | means |
//! |---|---|
//! | 0, 1 | `Kd` alone, `Ks` is ignored |
//! | 2, 10, absent | `Kd` and `Ks` with the width of `Ns` |
//! | 3, 5, 8 | the same (`illum` 5 asks for Fresnel: approximated by a constant `Ks`) |
//! | 4, 6, 7, 9 | glass: what d and `Kd` leave is refracted, times `Tf`, with index `Ni` and Fresnel's equations; d is used up by that, and the surface is there in full. Without `Kd`: glass alone, its reflection is not scaled by `Ks`. With `Ni` 1 and nothing transparent in `d` or `Tf`: opaque, since some programs write 4 for every material |
//!
//! Colours are linear Rec. 709; one number is grey. `Kd spectral ...` and `Kd xyz ...` are not read. Colours above 1 and
//! below 0 are clamped with a warning, as are `d`, `Tr` (0 to 1) and `Ns` (at least 0). Lobes that add up to more than 1 are scaled down together
//! (see [`Scattering::Mtl`](etendue::material::Scattering::Mtl)). Textures and other keys are noted and ignored.

mod mapping;

use crate::{
    Diagnostic, Diagnostics, FileId, Severity, Span,
    mesh_file::{MOST_MATERIALS, NamedMaterial},
    obj::number_error,
    text::{Cursor, NumberError, Tally, counted, joined, shown, tally::Finding},
};
use std::ops::Range;

/// One `newmtl`, as it stands in the file.
#[derive(Clone, Debug, Default)]
struct Record {
    name: String,
    place: Range<usize>,
    ambient: Option<[f32; 3]>,
    diffuse: Option<[f32; 3]>,
    specular: Option<[f32; 3]>,
    emission: Option<[f32; 3]>,
    transmission: Option<[f32; 3]>,
    exponent: Option<f32>,
    ior: Option<f32>,
    opacity: Option<f32>,
    transparency: Option<f32>,
    illum: Option<u32>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ignored {
    Unknown,
    NotYet,
    Ambient,
    AmbientEmits,
    Spectral,
    Halo,
    BeforeFirst,
    Clamped,
    BadIllum,
    BadIor,
    Conflict,
    SpecularUnused,
    ConstantFresnel,
    ForcedFresnel,
    GlassSpecular,
    OpaqueGlass,
    TintUnused,
}

impl Finding for Ignored {
    fn describe(self, key: &str, count: usize) -> Diagnostic {
        let times = if count == 1 { String::new() } else { format!(" ({count} times)") };
        let materials = counted(count, "material");
        match self {
            Self::Unknown => Diagnostic::warning(format!("unknown key `{key}` ignored{times}")),
            Self::NotYet => Diagnostic::warning(format!("`{key}` is not read yet and ignored{times}")),
            Self::Ambient => Diagnostic::note(format!("`Ka` ignored: ambient light is computed{times}")),
            Self::AmbientEmits => Diagnostic::note(format!("`Ka` above 1 counts as emission `Ke`{times}")),
            Self::Spectral => Diagnostic::warning(format!("`{key}` is not read: only red, green and blue are{times}")),
            Self::Halo => Diagnostic::note(format!("`d -halo` counts as `d`{times}")),
            Self::BeforeFirst => Diagnostic::warning(format!("`{key}` before the first `newmtl` ignored{times}")),
            Self::Clamped => Diagnostic::warning(format!("`{key}` out of range, clamped{times}")),
            Self::BadIllum => {
                Diagnostic::warning(format!("`illum {key}` counts as 2{times}")).label("expected 0 to 10")
            }
            Self::BadIor => Diagnostic::warning(format!("`Ni` out of range: {materials} with 1.5 instead"))
                .label("expected 0.1 to 10"),
            Self::Conflict => Diagnostic::warning(format!("`Tr` is not 1 - `d`: `d` counts ({materials})")),
            Self::SpecularUnused => Diagnostic::note(format!("`Ks` ignored, as illum 0 and 1 ask ({materials})")),
            Self::ConstantFresnel => {
                Diagnostic::note(format!("illum 5: the same reflection at every angle ({materials})"))
            }
            Self::ForcedFresnel => {
                Diagnostic::note(format!("illum 6: Fresnel's equations are used all the same ({materials})"))
            }
            Self::GlassSpecular => {
                Diagnostic::note(format!("glass reflects by Fresnel's equations, not by `Ks` ({materials})"))
            }
            Self::OpaqueGlass => Diagnostic::note(format!(
                "illum 4, 6, 7 or 9 with `Ni` 1 and nothing transparent counts as opaque ({materials})"
            )),
            Self::TintUnused => Diagnostic::note(format!("`Tf` ignored: illum asks for no refraction ({materials})")),
        }
    }
}

struct Parser<'a> {
    cursor: Cursor<'a>,
    file: FileId,
    materials: Vec<NamedMaterial>,
    record: Option<Record>,
    errors: Diagnostics,
    ignored: Tally<Ignored>,
}

/// Reads a material library: its materials in the order of the file, and what was found wrong, approximated or ignored
/// (errors among it: malformed and infinite numbers; such a value counts as absent).
pub fn read(bytes: &[u8], file: FileId) -> (Vec<NamedMaterial>, Diagnostics) {
    let mut parser = Parser {
        cursor: Cursor::new(bytes),
        file,
        materials: vec![],
        record: None,
        errors: Diagnostics::new(),
        ignored: Tally::new(),
    };
    while !parser.cursor.is_done() && !parser.errors.is_full(Severity::Error) {
        parser.statement();
        parser.cursor.next_line();
    }
    parser.finish_record();
    let mut found = parser.errors;
    parser.ignored.report(&mut found);
    found.sort();
    (parser.materials, found)
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
            let name = self.cursor.name();
            self.finish_record();
            let text = String::from_utf8_lossy(&joined(&bytes[name.clone()])).into_owned();
            self.record = Some(Record { name: text, place: word.start..name.end, ..Record::default() });
            return;
        }
        let Some(mut record) = self.record.take() else {
            return self.ignored.add(Ignored::BeforeFirst, key, self.file, word);
        };
        self.property(key, word, &mut record);
        self.record = Some(record);
    }

    fn property(&mut self, key: &[u8], word: Range<usize>, record: &mut Record) {
        match key {
            b"Ka" => set(&mut record.ambient, self.colour(key, f64::INFINITY)),
            b"Kd" => set(&mut record.diffuse, self.colour(key, 1.0)),
            b"Ks" => set(&mut record.specular, self.colour(key, 1.0)),
            b"Ke" => set(&mut record.emission, self.colour(key, f64::INFINITY)),
            b"Tf" => set(&mut record.transmission, self.colour(key, 1.0)),
            b"Ns" => set(&mut record.exponent, self.scalar(key, 0.0, f64::INFINITY)),
            b"Ni" => set(&mut record.ior, self.scalar(key, f64::NEG_INFINITY, f64::INFINITY)),
            b"Tr" => set(&mut record.transparency, self.scalar(key, 0.0, 1.0)),
            b"d" => {
                let mut ahead = self.cursor.clone();
                let option = ahead.word();
                if &self.cursor.bytes[option.clone()] == b"-halo" {
                    self.cursor = ahead;
                    self.ignored.add(Ignored::Halo, b"", self.file, option);
                }
                set(&mut record.opacity, self.scalar(key, 0.0, 1.0));
            }
            b"illum" => self.illum(record),
            _ => {
                let kind = if is_known(key) { Ignored::NotYet } else { Ignored::Unknown };
                self.ignored.add(kind, key, self.file, word);
            }
        }
    }

    fn illum(&mut self, record: &mut Record) {
        let word = self.cursor.word();
        let text = &self.cursor.bytes[word.clone()];
        match str::from_utf8(text).ok().and_then(|text| text.parse().ok()) {
            Some(illum @ 0..=10) => record.illum = Some(illum),
            _ => self.ignored.add(Ignored::BadIllum, text, self.file, word),
        }
    }

    /// `r [g b]`; `None` after a report.
    fn colour(&mut self, key: &[u8], most: f64) -> Option<[f32; 3]> {
        let mut ahead = self.cursor.clone();
        let first = ahead.word();
        let kind = &self.cursor.bytes[first.clone()];
        if kind == b"spectral" || kind == b"xyz" {
            let named = [key, b" ", kind].concat();
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
    fn scalar(&mut self, key: &[u8], least: f64, most: f64) -> Option<f32> {
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
            self.ignored.add(Ignored::Clamped, key, self.file, end.saturating_sub(1)..end);
        }
        let value = value.clamp(least, most) as f32;
        if !value.is_finite() {
            self.bad_number(NumberError::NotFinite, key, here);
            return None;
        }
        Some(value)
    }

    fn bad_number(&mut self, error: NumberError, key: &[u8], here: Range<usize>) {
        let word = shown(&self.cursor.bytes[here.clone()]);
        let expected = format!("a number for {}", shown(key));
        self.errors.push(number_error(error, &word, &expected).at(Span::new(self.file, here)));
    }

    fn finish_record(&mut self) {
        if let Some(record) = self.record.take() {
            let place = record.place.clone();
            if self.materials.len() == MOST_MATERIALS {
                let error = Diagnostic::error(format!("more than {MOST_MATERIALS} materials"));
                return self.errors.push(error.at(Span::new(self.file, place)));
            }
            let material = mapping::material(&record, &mut |what| {
                self.ignored.add(what, b"", self.file, place.clone());
            });
            let origin = Some(Span::new(self.file, place).into());
            self.materials.push(NamedMaterial { name: record.name, material: Box::new(material), origin });
        }
    }
}

/// Keeps the old value where there is no new one.
fn set<T>(slot: &mut Option<T>, value: Option<T>) {
    if value.is_some() {
        *slot = value;
    }
}

/// Keys of MTL and its usual extensions that later versions will read.
fn is_known(key: &[u8]) -> bool {
    let key = key.to_ascii_lowercase();
    matches!(
        &key[..],
        b"bump"
            | b"norm"
            | b"disp"
            | b"decal"
            | b"refl"
            | b"sharpness"
            | b"pr"
            | b"pm"
            | b"ps"
            | b"pc"
            | b"pcr"
            | b"aniso"
            | b"anisor"
    ) || key.starts_with(b"map_")
}
