//! `[textures.NAME]`, and parameters that name one.

use super::{
    fields::{Fields, Item},
    keys, named,
    values::Bounds,
};
use crate::{
    Diagnostic,
    description::{Located, TextureRecord},
    diagnostic::nearest,
    value::Data,
};
use etendue::{
    material::{Color, Number, Parameter},
    spectrum::Spectrum,
    texture::{Channel, Filtering, Mapping, Transfer, UvTransform, Wrap},
};
use std::{collections::BTreeMap, path::PathBuf};

/// Offsets and scales of texture coordinates, gains.
const FAR: Bounds = Bounds::within(-1e6, 1e6);

/// `[textures.NAME]`, by name.
pub fn textures(item: Item) -> Option<BTreeMap<String, Option<TextureRecord>>> {
    Some(named(item, "textures")?.map(|(entry, item)| (entry.key.clone(), texture(item))).collect())
}

fn texture(item: Item) -> Option<TextureRecord> {
    let fields = item.table(&keys::TEXTURE, "[textures.NAME]")?;
    let file = fields.need("file", file);
    let transfer = fields.read("encoding", |i| i.choice(&[("srgb", Transfer::Srgb), ("linear", Transfer::Linear)]));
    let default = Mapping::default();
    let pair = |key, one: f64| fields.read(key, pair).unwrap_or([one; 2]);
    let number = |key, default| fields.read(key, |i| i.number_f32(FAR)).unwrap_or(default);
    let angle = fields.read("rotate", |i| i.number(FAR)).unwrap_or(0.0);
    let mapping = Mapping {
        wrap: fields.read("wrap", wrap).unwrap_or(default.wrap),
        filtering: fields.read("filter", |i| i.choice(&Filtering::ALL.map(|f| (f.name(), f)))).unwrap_or_default(),
        transform: UvTransform::new(pair("scale", 1.0), angle, pair("offset", 0.0)),
        gain: number("gain", default.gain),
        base: number("base", default.base),
        channel: fields.read("channel", |i| i.choice(&Channel::ALL.map(|c| (c.name(), c)))).unwrap_or_default(),
    };
    fields.finish();
    Some(TextureRecord { file: file?, transfer, mapping })
}

fn file(item: Item) -> Option<Located<PathBuf>> {
    Some(Located { value: PathBuf::from(item.name_text()?), origin: item.value.origin.clone() })
}

/// A number for both directions, or one for each.
fn pair(item: Item) -> Option<[f64; 2]> {
    match item.value.data {
        Data::Array(_) => item.numbers(FAR),
        _ => item.number(FAR).map(|x| [x; 2]),
    }
}

fn wrap(item: Item) -> Option<[Wrap; 2]> {
    let mode = |i: Item| i.choice(&Wrap::ALL.map(|w| (w.name(), w)));
    match item.value.data {
        Data::Array(_) => item.fixed("an array of 2 wrap modes", mode),
        _ => mode(item).map(|wrap| [wrap; 2]),
    }
}

/// A texture by name or by file: a table with one key.
pub fn reference(fields: &Fields) -> Option<TextureRecord> {
    fields.exclusive("texture", "file");
    match (fields.get("texture"), fields.get("file")) {
        (Some(name), _) => by_name(name),
        (None, Some(path)) => Some(TextureRecord { file: file(path)?, transfer: None, mapping: Mapping::default() }),
        (None, None) => {
            fields.lacks("`texture` or `file`");
            None
        }
    }
}

fn by_name(item: Item) -> Option<TextureRecord> {
    let name = item.name_text()?;
    let textures = item.cx.textures.get()?;
    match textures.get(name) {
        Some(record) => record.clone(),
        None => {
            let error = Diagnostic::error(format!("no texture is called `{name}`")).at(item.value.origin.clone());
            item.cx.missing(match nearest(name, textures.keys().map(String::as_str)) {
                Some(near) => error.help(format!("did you mean `{near}`?")),
                None => error.help("define it in [textures.NAME]"),
            });
            None
        }
    }
}

/// A value, or a table with a texture and a factor.
fn parameter<'a, V>(
    item: Item<'a>,
    one: V,
    value: impl Fn(Item<'a>, bool) -> Option<V>,
) -> Option<Parameter<V, TextureRecord>> {
    if !matches!(item.value.data, Data::Table(_)) {
        return value(item, false).map(Parameter::constant);
    }
    let fields = item.table(&keys::PARAMETER, "")?;
    let texture = reference(&fields);
    let factor = match fields.get("factor") {
        Some(item) => value(item, true),
        None => Some(one),
    };
    fields.finish();
    Some(Parameter { factor: factor?, texture: Some(texture?) })
}

/// A colour, or a texture times a colour. `bounds` hold for the colour alone.
pub fn color(item: Item, bounds: Bounds) -> Option<Color<TextureRecord>> {
    parameter(item, Spectrum::ONE, |i, factor| i.colour(if factor { Bounds::LIGHT } else { bounds }))
}

/// A number, or a texture times a number. `bounds` hold for the number alone.
pub fn number(item: Item, bounds: Bounds) -> Option<Number<TextureRecord>> {
    parameter(item, 1.0, |i, factor| i.number_f32(if factor { FAR } else { bounds }))
}
