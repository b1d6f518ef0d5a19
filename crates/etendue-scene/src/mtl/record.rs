//! One material as it stands in the file.

use super::keys::Key;
use crate::description::{ImageRecord, TextureRecord};
use etendue::texture::{Mapping, Pattern, Texture, Transfer};
use std::{collections::BTreeMap, ops::Range, sync::Arc};

/// One `newmtl`.
#[derive(Clone, Debug, Default)]
pub struct Record {
    /// As in the file.
    pub name: String,
    /// The statement.
    pub place: Range<usize>,
    /// What it says, by key.
    pub entries: BTreeMap<Key, Entry>,
}

/// A key of a material.
#[derive(Clone, Debug)]
pub struct Entry {
    /// What the last statement that could be read says.
    pub value: Option<Value>,
    /// The first statement's key.
    pub place: Range<usize>,
    /// How often it was stated.
    pub count: usize,
    /// Something was said about it.
    pub noted: bool,
}

/// What follows a key.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    /// Red, green, blue.
    Colour([f32; 3]),
    /// A number.
    Number(f32),
    /// An illumination model, 0 to 10.
    Illum(u32),
    /// An image.
    Map(Box<Map>),
}

/// An image with its options.
#[derive(Clone, Debug, PartialEq)]
pub struct Map {
    /// The image.
    pub image: ImageRecord,
    /// Where it goes on the surface.
    pub mapping: Mapping,
    /// `-bm`: factor of bumps.
    pub bump: f32,
    /// The channel was asked for.
    pub channel_given: bool,
}

impl Map {
    /// The texture.
    pub fn texture(&self) -> TextureRecord {
        Arc::new(Texture { pattern: Pattern::Image(self.image.clone()), mapping: self.mapping })
    }

    /// The texture, its samples no colours.
    pub fn data(&self) -> TextureRecord {
        let image = ImageRecord { transfer: Some(Transfer::Linear), ..self.image.clone() };
        Arc::new(Texture { pattern: Pattern::Image(image), mapping: self.mapping })
    }
}

impl Record {
    /// True if the key was stated.
    pub fn has(&self, key: Key) -> bool {
        self.entries.contains_key(&key)
    }

    fn value(&self, key: Key) -> Option<&Value> {
        self.entries.get(&key)?.value.as_ref()
    }

    /// The colour of a key.
    pub fn colour(&self, key: Key) -> Option<[f32; 3]> {
        match self.value(key) {
            Some(Value::Colour(colour)) => Some(*colour),
            _ => None,
        }
    }

    /// The number of a key.
    pub fn number(&self, key: Key) -> Option<f32> {
        match self.value(key) {
            Some(Value::Number(number)) => Some(*number),
            _ => None,
        }
    }

    /// The illumination model.
    pub fn illum(&self) -> Option<u32> {
        match self.value(Key::Illum) {
            Some(Value::Illum(illum)) => Some(*illum),
            _ => None,
        }
    }

    /// The image of a key.
    pub fn map(&self, key: Key) -> Option<&Map> {
        match self.value(key) {
            Some(Value::Map(map)) => Some(map),
            _ => None,
        }
    }

    /// Counts a statement at `place`, and keeps the value that was there if there is no new one.
    pub fn set(&mut self, key: Key, place: Range<usize>, value: Option<Value>, noted: bool) {
        let entry = self.entries.entry(key).or_insert(Entry { value: None, place, count: 0, noted: false });
        entry.count += 1;
        entry.noted |= noted;
        if value.is_some() {
            entry.value = value;
        }
    }
}
