//! From the keys of a material to what its surface does.

use super::{Ignored, Record};
use crate::description::TextureRecord;
use etendue::{
    material::{Emission, Material, Scattering},
    spectrum::Spectrum,
};

/// `Ns` from which on the specular lobe is a mirror.
const MIRROR: f32 = 1000.0;
/// `Ns` where none is given.
const DEFAULT_EXPONENT: f32 = 10.0;
const DEFAULT_IOR: f32 = 1.5;
/// `Kd` where nothing else is given.
const DEFAULT_DIFFUSE: f32 = 0.5;

/// The material; `note` is told what was approximated.
pub(super) fn material(record: &Record, note: &mut dyn FnMut(Ignored)) -> Material<TextureRecord> {
    let emission = emission(record, note);
    let opacity = opacity(record, note);
    let illum = record.illum.unwrap_or(2);
    let glass = matches!(illum, 4 | 6 | 7 | 9) && refracts(record, opacity, note);
    let (scattering, opacity) = if glass {
        (refracting(record, illum, opacity, note), 1.0)
    } else {
        if record.transmission.is_some_and(|tint| tint != [0.0; 3] && tint != [1.0; 3]) {
            note(Ignored::TintUnused);
        }
        (opaque(record, illum, emission.is_some(), note), opacity)
    };
    Material { emission, opacity: opacity.into(), ..Material::new(record.name.as_str(), scattering) }
}

fn emission(record: &Record, note: &mut dyn FnMut(Ignored)) -> Option<Emission<TextureRecord>> {
    let ambient = Spectrum(record.ambient.unwrap_or_default());
    let emitted = Spectrum(record.emission.unwrap_or_default());
    let radiance = if record.emission.is_none() && ambient.max_component() > 1.0 {
        note(Ignored::AmbientEmits);
        ambient
    } else {
        if !ambient.is_black() {
            note(Ignored::Ambient);
        }
        emitted
    };
    (!radiance.is_black()).then_some(Emission { radiance: radiance.into(), two_sided: true })
}

fn opacity(record: &Record, note: &mut dyn FnMut(Ignored)) -> f32 {
    let from_transparency = record.transparency.map(|tr| 1.0 - tr);
    if let (Some(d), Some(other)) = (record.opacity, from_transparency)
        && (d - other).abs() > 1e-3
    {
        note(Ignored::Conflict);
    }
    record.opacity.or(from_transparency).unwrap_or(1.0)
}

/// Whether an `illum` that asks for glass means it.
fn refracts(record: &Record, opacity: f32, note: &mut dyn FnMut(Ignored)) -> bool {
    let transparent = opacity < 1.0 || record.transmission.is_some_and(|tint| tint != [0.0; 3] && tint != [1.0; 3]);
    let meant = transparent || record.ior != Some(1.0);
    if !meant {
        note(Ignored::OpaqueGlass);
    }
    meant && record.transmission != Some([0.0; 3])
}

fn ior(record: &Record, note: &mut dyn FnMut(Ignored)) -> f32 {
    match record.ior {
        Some(ior) if (0.1..=10.0).contains(&ior) => ior,
        Some(_) => {
            note(Ignored::BadIor);
            DEFAULT_IOR
        }
        None => DEFAULT_IOR,
    }
}

fn refracting(record: &Record, illum: u32, opacity: f32, note: &mut dyn FnMut(Ignored)) -> Scattering {
    if illum == 6 {
        note(Ignored::ForcedFresnel);
    }
    let ior = ior(record, note);
    let (solid, clear) = if opacity < 1.0 { (opacity, 1.0 - opacity) } else { (1.0, 1.0) };
    let diffuse = Spectrum(record.diffuse.unwrap_or_default()) * solid;
    let transmission = Spectrum(record.transmission.unwrap_or([1.0; 3])) * clear;
    let specular = Spectrum(record.specular.unwrap_or_default());
    if diffuse.is_black() {
        if !specular.is_black() && specular != Spectrum::ONE {
            note(Ignored::GlassSpecular);
        }
        return Scattering::Glass { ior, reflection_tint: Spectrum::ONE, transmission_tint: transmission, thin: false };
    }
    Scattering::Mtl { diffuse, specular, alpha: alpha(record, illum), transmission, ior }
}

/// Width of the specular lobe.
fn alpha(record: &Record, illum: u32) -> f32 {
    let exponent = match record.exponent {
        Some(exponent) => exponent,
        None if matches!(illum, 3..=9) => MIRROR,
        None => DEFAULT_EXPONENT,
    };
    if exponent >= MIRROR { 0.0 } else { (2.0 / (exponent + 2.0)).sqrt() }
}

fn opaque(record: &Record, illum: u32, emits: bool, note: &mut dyn FnMut(Ignored)) -> Scattering {
    let mut specular = Spectrum(record.specular.unwrap_or_default());
    match illum {
        0 | 1 if !specular.is_black() => {
            note(Ignored::SpecularUnused);
            specular = Spectrum::BLACK;
        }
        5 if !specular.is_black() => note(Ignored::ConstantFresnel),
        _ => {}
    }
    let absent = if emits || !specular.is_black() { 0.0 } else { DEFAULT_DIFFUSE };
    let diffuse = record.diffuse.map_or(Spectrum::splat(absent), Spectrum);
    let alpha = alpha(record, illum);
    match (diffuse.is_black(), specular.is_black()) {
        (true, true) => Scattering::Black,
        (false, true) => Scattering::Diffuse { reflectance: diffuse, transmittance: Spectrum::BLACK },
        (true, false) if alpha == 0.0 => Scattering::Mirror { reflectance: specular },
        _ => Scattering::Mtl { diffuse, specular, alpha, transmission: Spectrum::BLACK, ior: DEFAULT_IOR },
    }
}
