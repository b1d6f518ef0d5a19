//! TOML text to a tree of values, going on after syntax errors.
//!
//! The parser stops making sense of a document at its first syntax error, so the statement with the error is blanked out
//! and the text read again, as often as a budget allows. Bytes stay in place, so that spans remain true.

use crate::{
    Diagnostic, Diagnostics, FileId, Severity, Span,
    value::{Data, Entry, Value},
};
use std::ops::Range;
use toml::{
    Spanned,
    de::{DeFloat, DeInteger, DeTable, DeValue},
};

/// Deeper nesting is refused; scenes need five levels.
const MAX_DEPTH: usize = 32;
/// Readings of a text with syntax errors, and bytes read in all of them.
const MAX_READINGS: usize = Diagnostics::KEPT;
const MAX_BYTES_READ: usize = 32 << 20;
/// Longest statement that is searched for more than one error.
const MAX_STATEMENT: usize = 64 << 10;

/// Reads `bytes` of `file`. The second value is true if there were syntax errors: then something may be missing that the
/// author did write.
pub fn read(file: FileId, bytes: &[u8], diagnostics: &mut Diagnostics) -> (Vec<Entry>, bool) {
    let (mut text, mut damaged) = decode(file, bytes, diagnostics);
    let readings = MAX_READINGS.min(MAX_BYTES_READ / text.len().max(1)).max(1);
    for _ in 0..readings {
        // Not the parser that recovers by itself: it keeps every error, some hundred bytes for each byte of a bad file.
        let error = match DeTable::parse(&text) {
            Ok(document) => return (Converter { file, diagnostics }.table(document.get_ref(), 0), damaged),
            Err(error) => error,
        };
        damaged = true;
        let at = place(&text, &error);
        let statement = statement_at(&text, at.start);
        let reported = line_end(&text, at.start);
        report(file, &text, at, &error, diagnostics);
        report_others(file, &text, &statement, reported, diagnostics);
        text = blank(text, statement);
    }
    diagnostics.push(Diagnostic::error("too many syntax errors to read on").at(Span::new(file, 0..0)));
    (Vec::new(), true)
}

/// The text, without a byte order mark; bytes that are not UTF-8 are reported and replaced one by one.
fn decode(file: FileId, bytes: &[u8], diagnostics: &mut Diagnostics) -> (String, bool) {
    let mut text = String::with_capacity(bytes.len());
    let mut damaged = false;
    for chunk in bytes.utf8_chunks() {
        text.push_str(chunk.valid());
        if !chunk.invalid().is_empty() {
            let at = Span::new(file, text.len()..text.len() + chunk.invalid().len());
            if !damaged || !diagnostics.is_full(Severity::Error) {
                diagnostics.push(Diagnostic::error("not UTF-8").at(at).help("save the file in the encoding UTF-8"));
            }
            text.extend(chunk.invalid().iter().map(|_| '?'));
            damaged = true;
        }
    }
    if text.starts_with('\u{feff}') {
        text.replace_range(..3, "   ");
    }
    (text, damaged)
}

/// Where an error is. What is missing after a line's end is said of that line.
fn place(text: &str, error: &toml::de::Error) -> Range<usize> {
    let range = error.span().unwrap_or(0..0);
    let (start, end) = (text.floor_char_boundary(range.start), text.floor_char_boundary(range.end));
    if start < end {
        return start..end;
    }
    let before = text[..start].trim_end_matches([' ', '\t', '\r', '\n']).len();
    if text[before..start].contains('\n') { before..before } else { start..start }
}

/// True if a line starts a statement, `[header]`, `[[header]]`, `key = value` or what is left of one, rather than going on
/// with an array.
fn starts_statement(line: &str) -> bool {
    is_header(line)
        || line.trim_start().starts_with(|c: char| c.is_alphabetic() || c == '_' || c == '=')
        || line.split_once('=').is_some_and(|(key, _)| is_key(key))
}

/// True for characters of bare, quoted and dotted keys.
fn is_key(text: &str) -> bool {
    let text = text.trim();
    let quoted = text.contains(['"', '\'']);
    !text.is_empty() && text.chars().all(|c| c.is_alphanumeric() || "_-. \t\"'".contains(c) || (quoted && c != ','))
}

fn is_header(line: &str) -> bool {
    let line = line.trim();
    let Some(inner) = line.strip_prefix('[') else { return false };
    let inner = inner.strip_prefix('[').unwrap_or(inner);
    let inner = inner.split_once(']').map_or(inner, |(inner, _)| inner);
    let inner = inner.split_once('#').map_or(inner, |(inner, _)| inner);
    is_key(inner) && inner.trim().starts_with(|c: char| c.is_alphabetic() || "_\"'".contains(c))
}

/// Where the line that holds `offset` ends, its line feed included.
fn line_end(text: &str, offset: usize) -> usize {
    text[offset..].find('\n').map_or(text.len(), |i| offset + i + 1)
}

/// The lines of the statement that holds `offset`; of a header, all lines up to the next header.
fn statement_at(text: &str, offset: usize) -> Range<usize> {
    let line_start = |offset: usize| text[..offset].rfind('\n').map_or(0, |i| i + 1);
    let line = |start: usize| &text[start..line_end(text, start)];
    let mut start = line_start(offset);
    while start > 0 && !starts_statement(line(start)) {
        start = line_start(start - 1);
    }
    let header = is_header(line(start));
    let mut end = line_end(text, start).max(line_end(text, offset));
    while end < text.len() {
        let next = line(end);
        if is_header(next) || (!header && starts_statement(next)) {
            break;
        }
        end = line_end(text, end);
    }
    start..end
}

/// Reports one error.
fn report(file: FileId, text: &str, at: Range<usize>, error: &toml::de::Error, diagnostics: &mut Diagnostics) {
    let message = match (error.message(), text.get(at.clone())) {
        ("duplicate key", Some(key)) => format!("`{key}` is defined twice"),
        (message, _) => message.to_owned(),
    };
    diagnostics.push(Diagnostic::error(message).at(Span::new(file, at)).label("TOML syntax"));
}

/// Reports what else is wrong inside a statement, read alone: one error a line, since others follow from it, and none on
/// the line that ends at `reported`. Of a header nothing: what stands below it is skipped as it is.
fn report_others(file: FileId, text: &str, statement: &Range<usize>, reported: usize, diagnostics: &mut Diagnostics) {
    let alone = &text[statement.clone()];
    if alone.len() > MAX_STATEMENT || is_header(alone.lines().next().unwrap_or_default()) {
        return;
    }
    let (_, errors) = DeTable::parse_recoverable(alone);
    let mut places: Vec<_> = errors.iter().map(|e| (place(alone, e), e)).collect();
    places.sort_by_key(|(range, _)| range.start);
    let mut last = reported;
    for (range, error) in places {
        let line = line_end(text, statement.start + range.start);
        if line != reported && line != last {
            last = line;
            report(file, text, statement.start + range.start..statement.start + range.end, error, diagnostics);
        }
    }
}

/// The text with the lines of `range` emptied; every other byte stays where it is.
fn blank(text: String, range: Range<usize>) -> String {
    let mut bytes = text.into_bytes();
    for byte in &mut bytes[range] {
        if *byte != b'\n' {
            *byte = b' ';
        }
    }
    // Whole lines were replaced by ASCII, so that this never replaces anything.
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Turns the parser's tree into ours.
struct Converter<'d> {
    file: FileId,
    diagnostics: &'d mut Diagnostics,
}

impl Converter<'_> {
    fn table(&mut self, table: &DeTable<'_>, depth: usize) -> Vec<Entry> {
        let mut entries: Vec<Entry> = table
            .iter()
            .map(|(key, value)| Entry {
                key: key.get_ref().to_string(),
                origin: Span::new(self.file, key.span()).into(),
                value: self.value(value, depth + 1),
            })
            .collect();
        entries.sort_by(|a, b| a.origin.cmp(&b.origin));
        entries
    }

    fn value(&mut self, value: &Spanned<DeValue<'_>>, depth: usize) -> Value {
        let span = Span::new(self.file, value.span());
        let data = match value.get_ref() {
            DeValue::Table(_) | DeValue::Array(_) if depth > MAX_DEPTH => {
                let message = format!("nested deeper than {MAX_DEPTH} levels");
                self.diagnostics.push(Diagnostic::error(message).at(span));
                Data::Broken
            }
            DeValue::Table(table) => Data::Table(self.table(table, depth)),
            DeValue::Array(array) => Data::Array(array.iter().map(|v| self.value(v, depth + 1)).collect()),
            DeValue::String(text) => Data::String(text.to_string()),
            DeValue::Integer(number) => self.integer(number, span),
            DeValue::Float(number) => self.float(number, span),
            DeValue::Boolean(value) => Data::Boolean(*value),
            DeValue::Datetime(moment) => Data::Moment(moment.to_string()),
        };
        Value { data, origin: span.into() }
    }

    fn integer(&mut self, number: &DeInteger<'_>, span: Span) -> Data {
        match i64::from_str_radix(number.as_str(), number.radix()) {
            Ok(number) => Data::Integer(number),
            Err(_) => self.broken("the integer does not fit in 64 bits", span),
        }
    }

    fn float(&mut self, number: &DeFloat<'_>, span: Span) -> Data {
        match number.as_str().parse::<f64>() {
            Ok(value) if value.is_infinite() && !number.as_str().contains("inf") => {
                self.broken("the number is too large for 64-bit floating point", span)
            }
            Ok(value) => Data::Float(value),
            Err(_) => self.broken("not a number", span),
        }
    }

    fn broken(&mut self, message: &str, span: Span) -> Data {
        self.diagnostics.push(Diagnostic::error(message).at(span));
        Data::Broken
    }
}
