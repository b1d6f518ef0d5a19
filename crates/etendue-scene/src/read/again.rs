//! Parts of a scene file read again, as they are at other times.

use super::{
    Part,
    fields::{Context, Fields},
    keyed, keys, texture,
};
use crate::{
    Diagnostics, Origin,
    animation::Varying,
    description::{CameraRecord, EnvironmentRecord, Located, MaterialRecord},
    value::{Data, Entry, Value},
};
use etendue::scene::DeltaLight;

/// What has to be read again at other times.
pub(super) fn varying(cx: &Context, entries: &[Entry], origin: &Origin) -> Varying {
    let kept = keyed::kept(cx, entries);
    let mut parts = cx.varying.take();
    for times in parts.values_mut() {
        times.sort_by(f64::total_cmp);
        times.dedup();
    }
    Varying { parts, entries: kept.into(), origin: Some(origin.clone()) }
}

impl Varying {
    /// The camera at a time, seconds.
    ///
    /// # Errors
    /// What is wrong with it then; so for the others.
    pub fn camera(&self, time: f64) -> Result<CameraRecord, Diagnostics> {
        self.read(time, super::camera)
    }

    /// The environment at a time; it is only asked for if there is one.
    pub fn environment(&self, time: f64) -> Result<EnvironmentRecord, Diagnostics> {
        self.read(time, super::environment)
    }

    /// The materials at a time, in their order.
    pub fn materials(&self, time: f64) -> Result<Vec<MaterialRecord>, Diagnostics> {
        self.read(time, |fields| {
            fields.read("textures", texture::textures);
            super::materials(fields)
        })
    }

    /// The lights at a time, in their order.
    pub fn lights(&self, time: f64) -> Result<Vec<Located<DeltaLight>>, Diagnostics> {
        self.read(time, super::lights)
    }

    fn read<T>(&self, time: f64, read: impl FnOnce(&Fields) -> Option<T>) -> Result<T, Diagnostics> {
        let cx = Context::new(Diagnostics::new(), false);
        cx.time.set(time);
        let value = match &self.origin {
            Some(origin) => read(&Fields::new(&cx, &keys::FILE, &self.entries, origin)),
            None => None,
        };
        let mut found = cx.diagnostics.into_inner();
        found.sort();
        match value {
            Some(value) if !found.has_errors() => Ok(value),
            _ => Err(found),
        }
    }

    /// True if a part has keys.
    pub fn has(&self, part: Part) -> bool {
        self.parts.contains_key(&part)
    }

    /// Times of the keys of a part, ascending; empty if it has none.
    pub fn times(&self, part: Part) -> &[f64] {
        self.parts.get(&part).map_or(&[], |times| times)
    }

    /// Which records of a part have keys, by their indices.
    pub fn keyed(&self, part: Part) -> Vec<usize> {
        let Some(entry) = self.entries.iter().find(|entry| entry.key == part.key()) else { return Vec::new() };
        let records: Vec<&Value> = match &entry.value.data {
            Data::Table(entries) => entries.iter().map(|entry| &entry.value).collect(),
            Data::Array(values) => values.iter().collect(),
            _ => Vec::new(),
        };
        (0..).zip(records).filter(|(_, record)| keyed::has_keys(record)).map(|(index, _)| index).collect()
    }

    /// True if nothing has keys.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }
}
