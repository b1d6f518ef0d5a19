//! Physically based materials: `Pr Pm Ps Pc Pcr aniso anisor` (Houston, "Extending Wavefront MTL for Physically-Based
//! Rendering", 2015).

use super::{
    findings::Ignored,
    keys::Key,
    mapping::{DEFAULT_IOR, Note, Surface, color, constant_opacity, ior, masked, number, refracts},
    record::{Map, Record},
};
use crate::description::TextureRecord;
use etendue::{
    bsdf::PrincipledParameters,
    material::{Color, Number, Parameter, Scattering},
    spectrum::Spectrum,
};
use std::f32::consts::TAU;

/// `Kd` where none is given.
const DEFAULT_COLOUR: f32 = 0.8;
/// Roughness where neither `Pr` nor `Ns` is given.
const DEFAULT_ROUGHNESS: f32 = 0.5;
const SHEEN_ROUGHNESS: f32 = 0.5;

/// The scattering, and the opacity.
pub fn material(record: &Record, note: Note) -> (Surface, Number<TextureRecord>) {
    say_what_others_replace(record, note);
    let opacity = constant_opacity(record, note);
    let (transmission, opacity) = if refracts(record, opacity, note) {
        let tint = record.colour(Key::Filter).map_or(1.0, |tint| Spectrum(tint).mean());
        (if opacity < 1.0 { tint * (1.0 - opacity) } else { tint }, 1.0)
    } else {
        if record.colour(Key::Filter).is_some_and(|tint| tint != [0.0; 3] && tint != [1.0; 3]) {
            note(Ignored::TintUnused, Key::Filter);
        }
        (0.0, opacity)
    };
    let parameters = PrincipledParameters {
        base_color: color(record, Key::Diffuse, Key::MapDiffuse, Spectrum::splat(DEFAULT_COLOUR), note),
        metallic: number(record, Key::Metallic, Key::MapMetallic, 0.0),
        roughness: roughness(record),
        anisotropic: record.number(Key::Anisotropy).unwrap_or(0.0).into(),
        rotation: (record.number(Key::Rotation).unwrap_or(0.0) * TAU).into(),
        ior: index(record, note).into(),
        specular: 1.0.into(),
        transmission: transmission.into(),
        coat: number(record, Key::Coat, Key::MapCoat, 0.0),
        coat_roughness: number(record, Key::CoatRoughness, Key::MapCoatRoughness, 0.0),
        sheen: sheen(record),
        sheen_roughness: SHEEN_ROUGHNESS.into(),
    };
    (Scattering::Principled(parameters), masked(record, opacity))
}

fn say_what_others_replace(record: &Record, note: Note) {
    let has_roughness = record.has(Key::Roughness) || record.has(Key::MapRoughness);
    if record.colour(Key::Specular).is_some_and(|colour| colour != [0.0; 3]) {
        note(Ignored::SpecularOfPbr, Key::Specular);
    }
    if record.has(Key::MapSpecular) {
        note(Ignored::SpecularOfPbr, Key::MapSpecular);
    }
    if has_roughness && record.has(Key::Exponent) {
        note(Ignored::ExponentUnused, Key::Exponent);
    }
    if record.has(Key::MapExponent) {
        note(Ignored::ExponentUnused, Key::MapExponent);
    }
}

/// `Pr`, or the root of the width that the lobe of `Ns` has.
fn roughness(record: &Record) -> Number<TextureRecord> {
    let by_exponent = record.number(Key::Exponent).map(|exponent| (2.0 / (exponent + 2.0)).sqrt().sqrt());
    number(record, Key::Roughness, Key::MapRoughness, by_exponent.unwrap_or(DEFAULT_ROUGHNESS))
}

/// Programs that know of no index write 1, which would not reflect at all.
fn index(record: &Record, note: Note) -> f32 {
    match ior(record, Key::Index, DEFAULT_IOR, note) {
        1.0 => {
            note(Ignored::UnitIndex, Key::Index);
            DEFAULT_IOR
        }
        ior => ior,
    }
}

fn sheen(record: &Record) -> Color<TextureRecord> {
    let Number { factor, .. } = number(record, Key::Sheen, Key::MapSheen, 0.0);
    // A weight, though it is held by a colour.
    let texture = record.map(Key::MapSheen).map(Map::data);
    Parameter { factor: Spectrum::splat(factor), texture }
}
