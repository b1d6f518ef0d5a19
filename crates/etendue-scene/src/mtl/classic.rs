//! Materials of the format as it was: `Kd Ks Ns Tf Ni d illum`.

use super::{
    findings::Ignored,
    keys::Key,
    mapping::{
        DEFAULT_EXPONENT, DEFAULT_IOR, MIRROR, Note, Surface, color, constant_opacity, ior, is_black, masked, refracts,
        scaled,
    },
    record::Record,
};
use crate::description::TextureRecord;
use etendue::{
    bsdf::PhongLobes,
    material::{Color, Number, Parameter, Scattering},
    spectrum::Spectrum,
};

/// `Kd` where nothing else is given.
const DEFAULT_DIFFUSE: f32 = 0.5;
/// `Ns` where only its map is given.
const MAPPED_EXPONENT: f32 = 100.0;

/// The scattering, and the opacity.
pub fn material(record: &Record, emits: bool, note: Note) -> (Surface, Number<TextureRecord>) {
    let opacity = constant_opacity(record, note);
    if refracts(record, opacity, note) {
        let there = masked(record, 1.0);
        if there.texture.is_some() {
            note(Ignored::GlassMap, Key::MapOpacity);
        }
        return (refracting(record, opacity, note), there);
    }
    if record.colour(Key::Filter).is_some_and(|tint| tint != [0.0; 3] && tint != [1.0; 3]) {
        note(Ignored::TintUnused, Key::Filter);
    }
    (opaque(record, emits, note), masked(record, opacity))
}

fn refracting(record: &Record, opacity: f32, note: Note) -> Surface {
    if record.illum() == Some(6) {
        note(Ignored::ForcedFresnel, Key::Illum);
    }
    let ior = ior(record, Key::Index, DEFAULT_IOR, note).into();
    let (solid, clear) = if opacity < 1.0 { (opacity, 1.0 - opacity) } else { (1.0, 1.0) };
    let diffuse = scaled(color(record, Key::Diffuse, Key::MapDiffuse, Spectrum::BLACK, note), solid);
    let transmission = Spectrum(record.colour(Key::Filter).unwrap_or([1.0; 3])) * clear;
    let specular = color(record, Key::Specular, Key::MapSpecular, Spectrum::BLACK, note);
    if is_black(&diffuse) {
        if !is_black(&specular) && specular != Spectrum::ONE.into() {
            note(Ignored::GlassSpecular, Key::Specular);
        }
        return Scattering::Glass {
            ior,
            reflection_tint: Spectrum::ONE.into(),
            transmission_tint: transmission.into(),
            thin: false,
        };
    }
    Scattering::Mtl { diffuse, specular, alpha: alpha(record).into(), transmission: transmission.into(), ior }
}

/// Exponent of the specular lobe.
fn exponent(record: &Record) -> f32 {
    match record.number(Key::Exponent) {
        Some(exponent) => exponent,
        None if matches!(record.illum(), Some(3..=9)) => MIRROR,
        None => DEFAULT_EXPONENT,
    }
}

/// Width of the specular lobe.
fn alpha(record: &Record) -> f32 {
    let exponent = exponent(record);
    if exponent >= MIRROR { 0.0 } else { (2.0 / (exponent + 2.0)).sqrt() }
}

fn opaque(record: &Record, emits: bool, note: Note) -> Surface {
    let mut specular = color(record, Key::Specular, Key::MapSpecular, Spectrum::BLACK, note);
    match record.illum() {
        Some(0 | 1) if !is_black(&specular) => {
            note(Ignored::SpecularUnused, Key::Specular);
            if record.has(Key::MapSpecular) {
                note(Ignored::SpecularUnused, Key::MapSpecular);
            }
            specular = Spectrum::BLACK.into();
        }
        Some(5) if !is_black(&specular) => note(Ignored::ConstantFresnel, Key::Illum),
        _ => {}
    }
    let absent = if emits || !is_black(&specular) { 0.0 } else { DEFAULT_DIFFUSE };
    let diffuse = color(record, Key::Diffuse, Key::MapDiffuse, Spectrum::splat(absent), note);
    if !is_black(&specular)
        && let Some(map) = record.map(Key::MapExponent)
    {
        note(Ignored::ExponentMap, Key::MapExponent);
        let factor = record.number(Key::Exponent).unwrap_or(MAPPED_EXPONENT);
        return phong(diffuse, specular, Parameter { factor, texture: Some(map.texture()) });
    }
    let alpha = alpha(record);
    match (is_black(&diffuse), is_black(&specular)) {
        (true, true) => Scattering::Black,
        (false, true) => Scattering::Diffuse { reflectance: diffuse, transmittance: Spectrum::BLACK.into() },
        (true, false) if alpha == 0.0 => Scattering::Mirror { reflectance: specular },
        _ => Scattering::Mtl {
            diffuse,
            specular,
            alpha: alpha.into(),
            transmission: Spectrum::BLACK.into(),
            ior: DEFAULT_IOR.into(),
        },
    }
}

fn phong(diffuse: Color<TextureRecord>, specular: Color<TextureRecord>, exponent: Number<TextureRecord>) -> Surface {
    Scattering::Phong(PhongLobes {
        diffuse,
        specular,
        exponent,
        diffuse_transmission: Spectrum::BLACK.into(),
        transmission: Spectrum::BLACK.into(),
        transmission_exponent: MIRROR.into(),
        ior: 1.0.into(),
    })
}
