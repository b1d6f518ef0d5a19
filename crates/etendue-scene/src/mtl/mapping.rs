//! From the keys of a material to what its surface does: what all kinds share.

use super::{
    classic, dialect,
    findings::Ignored,
    keys::Key,
    principled,
    record::{Map, Record},
};
use crate::description::TextureRecord;
use etendue::{
    material::{Color, Emission, Material, Number, Parameter, Relief, Scattering, TangentField},
    spectrum::Spectrum,
    texture::Channel,
};
use std::sync::Arc;

/// Colours and numbers over a surface.
pub type Surface = Scattering<Color<TextureRecord>, Number<TextureRecord>>;
/// Is told what is approximated or ignored, and the key that it is about.
pub type Note<'a> = &'a mut dyn FnMut(Ignored, Key);

/// `Ns` from which on the specular lobe is a mirror.
pub const MIRROR: f32 = 1000.0;
/// `Ns` where none is given.
pub const DEFAULT_EXPONENT: f32 = 10.0;
pub const DEFAULT_IOR: f32 = 1.5;
/// Height of white in bump maps, in the units of the file.
pub const BUMP_HEIGHT: f32 = 0.01;

/// Names that the old renderer knows.
pub const LAMP: &str = "AreaLightSource";
const MEDIA: [&str; 2] = ["GlobalScatter", "global_scatter"];

/// The material; `note` is told what was approximated.
pub fn material(record: &Record, is_dialect: bool, note: Note) -> Material<TextureRecord> {
    say_what_has_no_use(record, note);
    let is_lamp = record.name == LAMP && record.colour(Key::Emission).unwrap_or_default() == [0.0; 3];
    let emission = if is_lamp { lamp(record, note) } else { emission(record, note) };
    let (scattering, opacity) = if is_lamp {
        (Scattering::Black, opacity(record, note))
    } else if record.entries.keys().any(|key| key.is_of_pbr()) {
        principled::material(record, note)
    } else if is_dialect {
        dialect::material(record, note)
    } else {
        classic::material(record, emission.is_some(), note)
    };
    let relief = relief(record, note);
    Material {
        emission,
        opacity,
        relief,
        scattering,
        name: record.name.clone(),
        tangent: TangentField::default(),
        interior: None,
        priority: None,
    }
}

fn say_what_has_no_use(record: &Record, note: Note) {
    if MEDIA.contains(&record.name.as_str()) {
        note(Ignored::MediumByName, Key::Scatter);
    }
    for (key, why) in [
        (Key::MapAmbient, Ignored::AmbientMap),
        (Key::Reflection, Ignored::Reflection),
        (Key::Displacement, Ignored::Displacement),
        (Key::Decal, Ignored::Decal),
        (Key::Sharpness, Ignored::Antialiasing),
        (Key::Antialiasing, Ignored::Antialiasing),
        (Key::Brdf, Ignored::Brdf),
        (Key::Scatter, Ignored::Medium),
    ] {
        if record.has(key) {
            note(why, key);
        }
    }
}

/// A colour and the image that multiplies it. With an image, a colour that is absent or black counts as white.
pub fn color(record: &Record, key: Key, map: Key, default: Spectrum, note: Note) -> Color<TextureRecord> {
    let stated = record.colour(key);
    let Some(map) = record.map(map) else { return stated.map_or(default, Spectrum).into() };
    let factor = match stated {
        Some([0.0, 0.0, 0.0]) => {
            note(Ignored::BlackFactor, key);
            Spectrum::ONE
        }
        Some(colour) => Spectrum(colour),
        None => Spectrum::ONE,
    };
    Parameter { factor, texture: Some(map.texture()) }
}

/// A number and the image that multiplies it; with an image, an absent number counts as 1.
pub fn number(record: &Record, key: Key, map: Key, default: f32) -> Number<TextureRecord> {
    let texture = record.map(map).map(|map| map.texture());
    let default = if texture.is_some() { 1.0 } else { default };
    Parameter { factor: record.number(key).unwrap_or(default), texture }
}

/// True if it is black everywhere.
pub fn is_black(color: &Color<TextureRecord>) -> bool {
    color.factor.is_black()
}

/// The same color in proportion.
pub fn scaled(color: Color<TextureRecord>, factor: f32) -> Color<TextureRecord> {
    Parameter { factor: color.factor * factor, ..color }
}

fn emission(record: &Record, note: Note) -> Option<Emission<TextureRecord>> {
    let ambient = Spectrum(record.colour(Key::Ambient).unwrap_or_default());
    let emitted = color(record, Key::Emission, Key::MapEmission, Spectrum::BLACK, note);
    let stated = record.colour(Key::Emission).is_some() || emitted.texture.is_some();
    let radiance = if !stated && ambient.max_component() > 1.0 {
        note(Ignored::AmbientEmits, Key::Ambient);
        ambient.into()
    } else {
        if !ambient.is_black() {
            note(Ignored::Ambient, Key::Ambient);
        }
        emitted
    };
    (!is_black(&radiance)).then_some(Emission { radiance, two_sided: true })
}

/// What a light source of the old renderer emits.
pub fn lamp(record: &Record, note: Note) -> Option<Emission<TextureRecord>> {
    note(Ignored::LampByName, Key::Diffuse);
    let textured = record.map(Key::MapDiffuse).is_some();
    let radiance = Parameter {
        // A lamp that is switched off stays so, whatever its image.
        factor: Spectrum(record.colour(Key::Diffuse).unwrap_or(if textured { [1.0; 3] } else { [0.0; 3] })),
        texture: record.map(Key::MapDiffuse).map(|map| map.texture()),
    };
    (!is_black(&radiance)).then_some(Emission { radiance, two_sided: true })
}

/// What `d` and `Tr` say, without `map_d`.
pub fn constant_opacity(record: &Record, note: Note) -> f32 {
    let from_transparency = record.number(Key::Transparency).map(|tr| 1.0 - tr);
    let opacity = record.number(Key::Opacity);
    if let (Some(d), Some(other)) = (opacity, from_transparency)
        && (d - other).abs() > 1e-3
    {
        note(Ignored::Conflict, Key::Transparency);
    }
    opacity.or(from_transparency).unwrap_or(1.0)
}

/// The share of the surface that is there.
pub fn opacity(record: &Record, note: Note) -> Number<TextureRecord> {
    let factor = constant_opacity(record, note);
    masked(record, factor)
}

/// An opacity with `map_d`.
pub fn masked(record: &Record, factor: f32) -> Number<TextureRecord> {
    let Some(map) = record.map(Key::MapOpacity) else { return factor.into() };
    let mut texture = map.texture();
    let colour_file = record.map(Key::MapDiffuse).map(|colour| &colour.image.file.value);
    if !map.channel_given && colour_file == Some(&map.image.file.value) {
        Arc::make_mut(&mut texture).mapping.channel = Channel::Alpha;
    }
    // `d 0` with a map would make all of it invisible.
    let factor = if factor == 0.0 { 1.0 } else { factor };
    Parameter { factor, texture: Some(texture) }
}

fn relief(record: &Record, note: Note) -> Option<Relief<TextureRecord>> {
    if let Some(map) = record.map(Key::Normals) {
        return Some(normals(map));
    }
    let map = record.map(Key::Bump)?;
    if is_named_for_normals(map) {
        note(Ignored::NormalsByName, Key::Bump);
        return Some(normals(map));
    }
    note(Ignored::BumpHeight, Key::Bump);
    let height = Parameter { factor: BUMP_HEIGHT * map.bump, texture: Some(map.texture()) };
    Some(Relief::Bump { height })
}

fn normals(map: &Map) -> Relief<TextureRecord> {
    Relief::Normals { map: map.data(), scale: [map.bump; 2] }
}

/// Some programs write maps of normals as `map_Bump`.
fn is_named_for_normals(map: &Map) -> bool {
    let name = map.image.file.value.to_string_lossy().to_lowercase();
    let file = name.rsplit(['/', '\\']).next().unwrap_or(&name);
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    stem.contains("normal") || ["_n", "-n", "_nrm", "_nor", "_norm", "_ddn"].iter().any(|end| stem.ends_with(end))
}

/// `Ni` or `n`, if it makes sense.
pub fn ior(record: &Record, key: Key, default: f32, note: Note) -> f32 {
    match record.number(key) {
        Some(ior) if (0.1..=10.0).contains(&ior) => ior,
        Some(_) => {
            note(Ignored::BadIor, key);
            DEFAULT_IOR
        }
        None => default,
    }
}

/// Whether `illum` asks for glass and means it; `opacity` as in [`constant_opacity`].
pub fn refracts(record: &Record, opacity: f32, note: Note) -> bool {
    if !matches!(record.illum(), Some(4 | 6 | 7 | 9)) {
        return false;
    }
    let filter = record.colour(Key::Filter);
    let transparent = opacity < 1.0 || filter.is_some_and(|tint| tint != [0.0; 3] && tint != [1.0; 3]);
    let meant = transparent || record.number(Key::Index) != Some(1.0);
    if !meant {
        note(Ignored::OpaqueGlass, Key::Illum);
    }
    meant && filter != Some([0.0; 3])
}
