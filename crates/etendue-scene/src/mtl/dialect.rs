//! Materials of the old renderer's dialect: `Kd Ks Ns Td Ts Nst n`.

use super::{
    findings::Ignored,
    keys::Key,
    mapping::{DEFAULT_EXPONENT, MIRROR, Note, Surface, color, ior, masked},
    record::Record,
};
use crate::description::TextureRecord;
use etendue::{
    bsdf::PhongLobes,
    material::{Number, Scattering},
    spectrum::Spectrum,
};

/// Exponents beyond are all mirrors.
const MOST: f32 = 1e9;

/// The scattering, and the opacity: `d` alone, since `Tr` is a switch here.
pub fn material(record: &Record, note: Note) -> (Surface, Number<TextureRecord>) {
    let black = Spectrum::BLACK;
    let mut through = [
        color(record, Key::DiffuseTransmission, Key::MapDiffuseTransmission, black, note),
        color(record, Key::Transmission, Key::MapTransmission, black, note),
    ];
    if record.number(Key::Transparency) == Some(0.0) {
        for (lobe, key) in through.iter_mut().zip([Key::DiffuseTransmission, Key::Transmission]) {
            if !lobe.factor.is_black() {
                note(Ignored::OpaqueDialect, key);
                *lobe = black.into();
            }
        }
    }
    let [diffuse_transmission, transmission] = through;
    let exponent = |key, default: f32| record.number(key).unwrap_or(default).min(MOST);
    let lobes = PhongLobes {
        diffuse: color(record, Key::Diffuse, Key::MapDiffuse, black, note),
        specular: color(record, Key::Specular, Key::MapSpecular, black, note),
        exponent: Number {
            factor: exponent(Key::Exponent, DEFAULT_EXPONENT),
            texture: record.map(Key::MapExponent).map(|map| map.texture()),
        },
        diffuse_transmission,
        transmission,
        transmission_exponent: exponent(Key::TransmissionExponent, MIRROR).into(),
        ior: ior(record, Key::DialectIndex, 1.0, note).into(),
    };
    (Scattering::Phong(lobes), masked(record, record.number(Key::Opacity).unwrap_or(1.0)))
}
