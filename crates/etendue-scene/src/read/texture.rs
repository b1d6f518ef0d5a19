//! `[textures.NAME]`, and parameters that name one.

use super::{
    fields::{Fields, Item},
    keys, named, pattern,
    values::Bounds,
};
use crate::{
    Diagnostic,
    description::{ImageRecord, Located, TextureRecord},
    diagnostic::nearest,
    value::Data,
};
use etendue::{
    material::{Color, Number, Parameter},
    spectrum::Spectrum,
    texture::{Channel, Filtering, Mapping, Pattern, Texture, Transfer, UvTransform, Wrap},
};
use std::{collections::BTreeMap, path::PathBuf, sync::Arc};

/// Offsets and scales of texture coordinates, gains.
pub const FAR: Bounds = Bounds::within(-1e6, 1e6);

/// Reads `[textures.NAME]` into the context, those first that others name.
pub fn textures(item: Item) -> Option<()> {
    let entries: Vec<_> = named(item, "textures")?.collect();
    let unread = entries.iter().map(|(entry, _)| (entry.key.clone(), None)).collect();
    item.cx.textures.replace(unread);
    for index in pattern::order(item.cx, &entries) {
        let (entry, item) = entries[index];
        let record = texture(item);
        item.cx.textures.borrow_mut().insert(entry.key.clone(), record);
    }
    Some(())
}

/// The textures by name; `None` for those that could not be read.
pub type Textures = BTreeMap<String, Option<TextureRecord>>;

fn texture(item: Item) -> Option<TextureRecord> {
    let mut fields = item.table(&keys::TEXTURE, "[textures.NAME]")?;
    let kind = fields.variant("type", &pattern::KINDS, Some("image"));
    let default = Mapping::default();
    let number = |fields: &Fields, key, default| fields.read(key, |i| i.number_f32(FAR)).unwrap_or(default);
    let mut mapping = Mapping {
        gain: number(&fields, "gain", default.gain),
        base: number(&fields, "base", default.base),
        channel: fields.read("channel", |i| i.choice(&Channel::ALL.map(|c| (c.name(), c)))).unwrap_or_default(),
        ..default
    };
    let pattern = match kind {
        None => None,
        Some(pattern::Kind::Image) => image(&fields, &mut mapping),
        Some(kind) => pattern::pattern(&fields, kind, &mut mapping.transform),
    };
    fields.finish();
    Some(Arc::new(Texture { pattern: pattern?, mapping }))
}

fn image(fields: &Fields, mapping: &mut Mapping) -> Option<Pattern<ImageRecord>> {
    let file = fields.need("file", file);
    let transfer = fields.read("encoding", |i| i.choice(&[("srgb", Transfer::Srgb), ("linear", Transfer::Linear)]));
    mapping.wrap = fields.read("wrap", wrap).unwrap_or(mapping.wrap);
    mapping.filtering =
        fields.read("filter", |i| i.choice(&Filtering::ALL.map(|f| (f.name(), f)))).unwrap_or(mapping.filtering);
    mapping.transform = uv_transform(fields);
    Some(Pattern::Image(ImageRecord { file: file?, transfer }))
}

/// `scale`, `rotate`, `offset` of texture coordinates.
pub fn uv_transform(fields: &Fields) -> UvTransform {
    let of = |key, one: f64| fields.read(key, pair).unwrap_or([one; 2]);
    let angle = fields.read("rotate", |i| i.number(FAR)).unwrap_or(0.0);
    UvTransform::new(of("scale", 1.0), angle, of("offset", 0.0))
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
        (None, Some(path)) => {
            Some(Arc::new(Texture::of(Pattern::Image(ImageRecord { file: file(path)?, transfer: None }))))
        }
        (None, None) => {
            fields.lacks("`texture` or `file`");
            None
        }
    }
}

fn by_name(item: Item) -> Option<TextureRecord> {
    let name = item.name_text()?;
    let textures = item.cx.textures.borrow();
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
    if !matches!(item.value.data, Data::Table(_)) || item.is_keyed() {
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
