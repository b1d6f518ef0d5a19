//! Images: `map_Kd -s 2 2 -clamp on my file.png`.

use super::{keys::Key, record::Map};
use crate::{
    FileId, Span,
    description::{ImageRecord, Located},
    text::joined,
};
use etendue::texture::{Channel, Filtering, Mapping, UvTransform, Wrap};
use std::{borrow::Cow, ops::Range, path::PathBuf};

/// Words of a statement that are looked at; the rest belongs to the file's name.
const MOST_WORDS: usize = 64;
/// Numbers of options; beyond, texture coordinates lose all detail.
const MOST: f64 = 1e6;

/// What a statement says, and what of it is ignored.
#[derive(Debug, Default)]
pub struct Statement {
    /// Absent without a file name.
    pub map: Option<Map>,
    /// Options that are not used: the option, and where it is.
    pub unused: Vec<(String, Range<usize>)>,
    /// The colours that a `texture` statement multiplies.
    pub targets: Vec<Key>,
}

struct Reader<'a> {
    /// The statement after its key.
    text: &'a [u8],
    /// Where it begins in the file; absent where it goes over several lines.
    start: Option<usize>,
    /// Where it is.
    place: Range<usize>,
    /// Words of `text`.
    words: Vec<Range<usize>>,
    mapping: Mapping,
    scale: [f64; 2],
    offset: [f64; 2],
    blend: [bool; 2],
    bump: f32,
    channel_given: bool,
    unused: Vec<(String, Range<usize>)>,
}

/// Reads what follows the key `key`: the bytes `place` of a file, as [`Cursor::name`](crate::text::Cursor::name) has them.
pub fn read(bytes: &[u8], place: Range<usize>, key: Key, file: FileId) -> Statement {
    let joined = joined(&bytes[place.clone()]);
    let start = matches!(joined, Cow::Borrowed(_)).then_some(place.start);
    let text = without_comment(&joined);
    let mut reader = Reader {
        text,
        start,
        place,
        words: words(text),
        mapping: Mapping::default(),
        scale: [1.0; 2],
        offset: [0.0; 2],
        blend: [true; 2],
        bump: 1.0,
        channel_given: false,
        unused: vec![],
    };
    let first = reader.leading_options();
    let end = reader.trailing_options(first);
    let (targets, end) = reader.targets(first, end, key);
    let name = match (reader.words.get(first), reader.words.get(end.wrapping_sub(1))) {
        (Some(start), Some(last)) if first < end => {
            // What is beyond the words that are looked at belongs to the name.
            let stop = if end == MOST_WORDS { text.len() } else { last.end };
            unquoted(text, start.start..stop)
        }
        _ => 0..0,
    };
    let map = (!name.is_empty()).then(|| reader.map(name, file));
    Statement { map, unused: reader.unused, targets }
}

/// A comment after a file name begins with `#` at the start of a word after one that has an ending.
fn without_comment(text: &[u8]) -> &[u8] {
    let mut last_has_ending = false;
    for word in words(text) {
        if text[word.start] == b'#' && last_has_ending {
            return text[..word.start].trim_ascii_end();
        }
        last_has_ending = text[word].contains(&b'.');
    }
    text
}

fn words(text: &[u8]) -> Vec<Range<usize>> {
    let mut words = vec![];
    let mut at = 0;
    while at < text.len() && words.len() < MOST_WORDS {
        let start = at + text[at..].iter().take_while(|b| b.is_ascii_whitespace()).count();
        at = start + text[start..].iter().take_while(|b| !b.is_ascii_whitespace()).count();
        if start < at {
            words.push(start..at);
        }
    }
    words
}

fn unquoted(text: &[u8], name: Range<usize>) -> Range<usize> {
    match &text[name.clone()] {
        [b'"', inner @ .., b'"'] => name.start + 1..name.start + 1 + inner.len(),
        _ => name,
    }
}

impl Reader<'_> {
    fn word(&self, index: usize) -> &[u8] {
        self.words.get(index).map_or(&[], |word| &self.text[word.clone()])
    }

    fn number(&self, index: usize) -> Option<f64> {
        let text = str::from_utf8(self.word(index)).ok()?;
        let value: f64 = text.parse().ok()?;
        value.is_finite().then(|| value.clamp(-MOST, MOST))
    }

    /// Up to `N` numbers after the option at `index`, but never the statement's last word, which is the file's name.
    fn numbers<const N: usize>(&self, index: usize) -> Vec<f64> {
        let last = self.words.len().saturating_sub(1);
        (1..=N).map(|i| index + i).take_while(|i| *i < last).map_while(|i| self.number(i)).collect()
    }

    /// The numbers of an option at the end of a statement, which may be its last words.
    fn numbers_to_the_end<const N: usize>(&self, index: usize) -> Vec<f64> {
        (1..=N).map_while(|i| self.number(index + i)).collect()
    }

    /// Reads the option at `index`: how many words it has, or `None` if it is none.
    fn option(&mut self, index: usize, at_end: bool) -> Option<usize> {
        let numbers = |reader: &Self| {
            if at_end { reader.numbers_to_the_end::<3>(index) } else { reader.numbers::<3>(index) }
        };
        let option = self.word(index).to_ascii_lowercase();
        let argument = self.word(index + 1).to_ascii_lowercase();
        let is_off = argument == b"off";
        let switch = if is_off || argument == b"on" { 2 } else { 1 };
        Some(match &option[..] {
            b"-s" | b"-o" => {
                let given = numbers(self);
                let target = if option == b"-s" { &mut self.scale } else { &mut self.offset };
                for (slot, value) in target.iter_mut().zip(&given) {
                    *slot = *value;
                }
                if given.is_empty() {
                    self.unused(index);
                }
                1 + given.len()
            }
            b"-t" => {
                let given = numbers(self).len();
                self.unused(index);
                1 + given
            }
            b"-mm" => {
                let given = numbers(self);
                if let [base, gain, ..] = given[..] {
                    (self.mapping.base, self.mapping.gain) = (base as f32, gain as f32);
                } else {
                    self.unused(index);
                }
                1 + given.len().min(2)
            }
            b"-bm" => match self.number(index + 1) {
                Some(bump) => {
                    self.bump = bump as f32;
                    2
                }
                None => {
                    self.unused(index);
                    1
                }
            },
            b"-boost" | b"-texres" => {
                self.unused(index);
                1 + usize::from(self.number(index + 1).is_some())
            }
            b"-type" => {
                self.unused(index);
                2
            }
            b"-clamp" => {
                self.mapping.wrap = [if is_off { Wrap::Repeat } else { Wrap::Clamp }; 2];
                switch
            }
            b"-blendu" | b"-blendv" => {
                self.blend[usize::from(option == b"-blendv")] = !is_off;
                switch
            }
            b"-cc" => {
                self.unused(index);
                switch
            }
            b"-imfchan" => {
                self.mapping.channel = match &argument[..] {
                    b"r" => Channel::Red,
                    b"g" => Channel::Green,
                    b"b" => Channel::Blue,
                    b"m" => Channel::Alpha,
                    b"l" => Channel::Luminance,
                    _ => {
                        self.unused(index);
                        return Some(1 + usize::from(argument == b"z"));
                    }
                };
                self.channel_given = true;
                2
            }
            _ => return None,
        })
    }

    fn unused(&mut self, index: usize) {
        let option = String::from_utf8_lossy(self.word(index)).into_owned();
        let place = self.place(self.words[index].clone());
        self.unused.push((option, place));
    }

    /// Where a part of the text is in the file.
    fn place(&self, part: Range<usize>) -> Range<usize> {
        self.start.map_or(self.place.clone(), |start| start + part.start..start + part.end)
    }

    /// Reads the options before the file's name; the index of the first word after them.
    fn leading_options(&mut self) -> usize {
        let mut index = 0;
        while index < self.words.len() {
            let Some(length) = self.option(index, false) else { break };
            index += length;
        }
        index.min(self.words.len())
    }

    /// Reads the options after the file's name, which some programs write; the index of the first of them.
    fn trailing_options(&mut self, first: usize) -> usize {
        for start in first + 1..self.words.len() {
            if !self.word(start).starts_with(b"-") {
                continue;
            }
            let before = (self.mapping, self.scale, self.offset, self.blend, self.bump, self.channel_given);
            let unused = self.unused.len();
            let mut index = start;
            while let Some(length) = self.option(index, true) {
                index += length;
            }
            if index >= self.words.len() {
                return start;
            }
            // Part of the name after all.
            (self.mapping, self.scale, self.offset, self.blend, self.bump, self.channel_given) = before;
            self.unused.truncate(unused);
        }
        self.words.len()
    }

    /// The colours that stand after the file's name, `Kd` if none does, and the end of the name.
    fn targets(&self, first: usize, mut end: usize, key: Key) -> (Vec<Key>, usize) {
        let mut targets = vec![];
        if !matches!(key, Key::Texture | Key::Bump) {
            return (targets, end);
        }
        while end > first + 1 {
            let target = match self.word(end - 1) {
                b"Kd" => Key::MapDiffuse,
                b"Ks" => Key::MapSpecular,
                b"Td" => Key::MapDiffuseTransmission,
                b"Ts" => Key::MapTransmission,
                _ => break,
            };
            targets.push(target);
            end -= 1;
        }
        if targets.is_empty() {
            targets.push(Key::MapDiffuse);
        }
        (targets, end)
    }

    fn map(&self, name: Range<usize>, file: FileId) -> Map {
        let text = String::from_utf8_lossy(&self.text[name.clone()]).into_owned();
        let filtering = if self.blend == [false; 2] { Filtering::Nearest } else { Filtering::Trilinear };
        let transform = UvTransform::new(self.scale, 0.0, self.offset);
        Map {
            image: ImageRecord {
                file: Located { value: PathBuf::from(text), origin: Span::new(file, self.place(name)).into() },
                transfer: None,
            },
            mapping: Mapping { filtering, transform, ..self.mapping },
            bump: self.bump,
            channel_given: self.channel_given,
        }
    }
}
