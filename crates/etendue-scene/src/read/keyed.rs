//! Values that change over time: a table of keys in the place of a number, a colour, a point or a direction.

use super::{
    fields::{Context, Item},
    keys,
    values::Bounds,
};
use crate::{
    curve::{Blend, Curve, Value},
    value::{self, Data, Entry},
};

/// Scene times, seconds.
pub const TIME: Bounds = Bounds::within(-1e9, 1e9);

/// Parts of a description that may change over time.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// `[camera]`.
    Camera,
    /// `[environment]`.
    Environment,
    /// `[materials]`.
    Materials,
    /// `[[lights]]`.
    Lights,
}

impl Part {
    /// The parts.
    pub const ALL: [Self; 4] = [Self::Camera, Self::Environment, Self::Materials, Self::Lights];

    /// The key of the file that holds it.
    pub fn key(self) -> &'static str {
        match self {
            Self::Camera => "camera",
            Self::Environment => "environment",
            Self::Materials => "materials",
            Self::Lights => "lights",
        }
    }
}

impl Context {
    /// What `read` makes of a part of the file, in which values may have keys.
    pub fn in_part<T>(&self, part: Part, read: impl FnOnce() -> T) -> T {
        let before = self.part.replace(Some(part));
        let value = read();
        self.part.set(before);
        value
    }
}

impl<'a> Item<'a> {
    /// True for a table of keys.
    pub fn is_keyed(&self) -> bool {
        let Data::Table(entries) = &self.value.data else { return false };
        entries.iter().any(|entry| keys::KEYED.key(&entry.key).is_some())
    }

    /// A value as `read` has it, or the one that keys make at the time of reading.
    pub fn keyed<T: Value>(&self, read: impl Fn(Item<'a>) -> Option<T>) -> Option<T> {
        if !self.is_keyed() {
            return read(*self);
        }
        let Some(part) = self.cx.part.get() else {
            let message = format!("`{}` cannot change over time", self.name);
            return self.error(message, "expected a value: only camera, lights, materials and environment take keys");
        };
        let curve = self.curve(read)?;
        let mut varying = self.cx.varying.borrow_mut();
        varying.entry(part).or_default().extend(curve.keys.iter().map(|(time, _)| *time));
        Some(curve.at(self.cx.time.get()))
    }

    /// A value at all times: one, or a table of keys.
    pub fn curve_or<T: Value>(&self, read: impl Fn(Item<'a>) -> Option<T>) -> Option<Curve<T>> {
        if self.is_keyed() { self.curve(read) } else { read(*self).map(Curve::constant) }
    }

    fn curve<T: Value>(&self, read: impl Fn(Item<'a>) -> Option<T>) -> Option<Curve<T>> {
        let blends = Blend::ALL.map(|blend| (blend.name(), blend));
        let (keys, blend) = self.keys(read, &blends)?;
        Some(Curve { keys, blend })
    }

    /// The keys of a table, in order of time, and what is between them.
    pub fn keys<T, B: Clone + Default>(
        &self,
        read: impl Fn(Item<'a>) -> Option<T>,
        blends: &[(&str, B)],
    ) -> Option<(Vec<(f64, T)>, B)> {
        let fields = self.table(&keys::KEYED, "{ keys = [[0, 1], [2, 5]] }")?;
        let named = |item: Item<'a>| Item { name: self.name, ..item };
        let keys = fields.need("keys", |item| times_and_values(item, |value| read(named(value))));
        let blend = fields.read("interpolation", |item| item.choice(blends)).unwrap_or_default();
        fields.finish();
        Some((keys?, blend))
    }
}

/// `[[time, value], ...]`.
fn times_and_values<'a, T>(item: Item<'a>, read: impl Fn(Item<'a>) -> Option<T>) -> Option<Vec<(f64, T)>> {
    const EXPECTED: &str = "an array of keys, [[time, value], ...]";
    let items = item.array(EXPECTED)?;
    if items.len() == 0 {
        return item.error("there are no keys", "expected one or more [time, value]");
    }
    let mut keys: Vec<(f64, T)> = Vec::with_capacity(items.len());
    let mut bad = 0;
    for key in items {
        match time_and_value(key, keys.last().map(|(time, _)| *time), &read) {
            Some(key) => keys.push(key),
            None => bad += 1,
        }
        if bad > 10 {
            break;
        }
    }
    (bad == 0).then_some(keys)
}

fn time_and_value<'a, T>(key: Item<'a>, after: Option<f64>, read: &impl Fn(Item<'a>) -> Option<T>) -> Option<(f64, T)> {
    let mut parts = key.array("a key, [time, value]")?;
    let (Some(time), Some(value), None) = (parts.next(), parts.next(), parts.next()) else {
        return key.error("a key is a time and a value", "expected [time, value]");
    };
    let seconds = time.plain_number(TIME);
    let value = read(value);
    if let (Some(seconds), Some(after)) = (seconds, after)
        && seconds <= after
    {
        return time.error("keys must be in order of time", format!("expected a time after {after}"));
    }
    Some((seconds?, value?))
}

/// The entries of the file that are read again at other times: parts with keys, and what materials refer to.
pub fn kept(cx: &Context, entries: &[Entry]) -> Vec<Entry> {
    let varying = cx.varying.borrow();
    let is_kept = |entry: &&Entry| {
        varying.keys().any(|part| part.key() == entry.key)
            || entry.key == "textures" && varying.contains_key(&Part::Materials)
    };
    entries.iter().filter(is_kept).cloned().collect()
}

/// True if there is a table of keys anywhere in a value.
pub fn has_keys(value: &value::Value) -> bool {
    match &value.data {
        Data::Table(entries) => entries.iter().any(|entry| entry.key == "keys" || has_keys(&entry.value)),
        Data::Array(values) => values.iter().any(has_keys),
        _ => false,
    }
}
