//! `[media.NAME]` and `[world]`.

use super::{
    fields::{Fields, Item, list},
    keys, object, settings,
    values::Bounds,
};
use crate::{
    Diagnostic,
    description::{DensityRecord, Located, MediumRecord},
    value::{Data, Entry},
    volume_file::{Axes, ByteOrder, RawLayout, SampleType},
};
use etendue::{
    medium::{DensityGrid, Medium, PhaseComponent, PhaseFunction, PhaseKind, presets},
    spectrum::Spectrum,
};

/// Coefficients, 1/m.
pub const COEFFICIENT: Bounds = Bounds::within(0.0, 1e15);
/// Mean free paths, metres.
pub const FREE_PATH: Bounds = Bounds::within(1e-15, 1e15);
/// Mean cosines of scattering angles.
pub const MEAN_COSINE: Bounds = Bounds::within(-1.0, 1.0).above().below();
/// Weights of phase functions and scales of densities.
pub const WEIGHT: Bounds = Bounds::within(0.0, 1e15);
/// Colours of what light passes.
pub const TINT: Bounds = Bounds::UNIT.above();

/// `[world]`: the name of the medium that fills it.
pub fn world(file: &Fields) -> Option<Located<String>> {
    let fields = settings::section(file, "world", &keys::WORLD)?;
    let medium = fields.need("medium", object::name);
    fields.finish();
    medium
}

/// A medium; what could not be read has been reported and is replaced by something.
pub fn medium(item: Item, entry: &Entry) -> MediumRecord {
    let mut medium = Medium { name: entry.key.clone(), ..Medium::default() };
    let origin = entry.origin.clone();
    let Some(fields) = item.table(&keys::MEDIUM, "[media.NAME]") else {
        return MediumRecord { medium, density: None, origin };
    };
    [medium.absorption, medium.scattering] = coefficients(&fields);
    medium.emission = fields.read("emission", |i| i.colour(Bounds::LIGHT)).unwrap_or_default();
    medium.phase = fields.read("phase", phase).unwrap_or_default();
    let density = fields.read("density", density);
    if let Err(error) = medium.validate() {
        item.cx.push(Diagnostic::error(format!("medium `{}`: {error}", medium.name)).at(origin.clone()));
    }
    fields.finish();
    MediumRecord { medium, density, origin }
}

/// Absorption and scattering, given in one of four ways.
fn coefficients(fields: &Fields) -> [Spectrum; 2] {
    exclude(fields);
    let coefficient = |key| fields.read(key, |i| i.colour(COEFFICIENT));
    let (absorption, scattering) = (coefficient("absorption"), coefficient("scattering"));
    let albedo = fields.read("albedo", |i| i.colour(Bounds::UNIT));
    let tint = tint(fields);
    let extinction = coefficient("extinction");
    let extinction = extinction.or(fields.read("mean_free_path", free_path).map(|path| Spectrum::ONE / path));
    let has = |key| fields.key_origin(key).is_some();
    if has("albedo") && !has("extinction") && !has("mean_free_path") {
        fields.lacks("`extinction` or `mean_free_path` for its `albedo`");
    }
    if let Some(preset) = fields.read("preset", preset) {
        return [preset.absorption, preset.scattering];
    }
    if let Some(extinction) = extinction {
        let albedo = albedo.unwrap_or(Spectrum::ONE);
        return [extinction * (Spectrum::ONE - albedo), extinction * albedo];
    }
    [absorption.or(tint).unwrap_or_default(), scattering.unwrap_or_default()]
}

/// Reports ways to give coefficients that exclude each other.
fn exclude(fields: &Fields) {
    fields.exclusive("extinction", "mean_free_path");
    for other in ["absorption", "scattering", "color"] {
        fields.exclusive("extinction", other);
        fields.exclusive("mean_free_path", other);
    }
    fields.exclusive("absorption", "color");
    for other in ["absorption", "scattering", "extinction", "mean_free_path", "albedo", "color"] {
        fields.exclusive("preset", other);
    }
}

/// A colour without a channel at the lower end of `bounds`, where hexadecimal colours can be as well.
fn positive(item: Item, bounds: Bounds) -> Option<Spectrum> {
    let colour = item.colour(bounds)?;
    if colour.min_component() <= 0.0 {
        let message = format!("`{}` has a channel that is 0", item.name);
        return item.error(message, format!("each channel must be {bounds}"));
    }
    Some(colour)
}

fn free_path(item: Item) -> Option<Spectrum> {
    positive(item, FREE_PATH)
}

/// Absorption by the colour of light that has gone a distance.
fn tint(fields: &Fields) -> Option<Spectrum> {
    let color = fields.read("color", |i| positive(i, TINT));
    let distance = fields.read("at_distance", |i| i.number(Bounds::LENGTH));
    let has = |key| fields.key_origin(key).is_some();
    match (has("color"), has("at_distance")) {
        (true, false) => fields.lacks("`at_distance` for its `color`"),
        (false, true) => fields.lacks("`color` for its `at_distance`"),
        _ => {}
    }
    let (color, distance) = (color?, distance?);
    Some(color.map(|c| (-libm::log(f64::from(c)) / distance) as f32))
}

fn preset(item: Item) -> Option<&'static presets::Preset> {
    let name = item.text()?;
    let found = presets::find(name);
    if found.is_none() {
        let error = Diagnostic::error(format!("no preset is called `{name}`")).at(item.value.origin.clone());
        let error = error.label(format!("expected one of {}", list(presets::names())));
        item.cx.push(error.suggest(name, presets::names()));
    }
    found
}

/// The name of a shape, a table, or an array of tables.
fn phase(item: Item) -> Option<PhaseFunction> {
    let components = match &item.value.data {
        Data::Array(_) => {
            let items = item.array("an array of tables")?;
            if items.len() == 0 || items.len() > PhaseFunction::MAX_COMPONENTS {
                let message =
                    format!("`phase` mixes 1 to {} shapes, not {}", PhaseFunction::MAX_COMPONENTS, items.len());
                return item.error(message, "expected fewer tables, and one at least");
            }
            let components: Vec<Option<PhaseComponent>> = items.map(component).collect();
            components.into_iter().collect::<Option<Vec<_>>>()?
        }
        Data::Table(_) => vec![component(item)?],
        _ => vec![PhaseComponent { kind: item.choice(&kinds())?, weight: 1.0 }],
    };
    match PhaseFunction::mixture(&components) {
        Ok(phase) => Some(phase),
        Err(error) => item.error(error.to_string(), "give one of them a weight above 0"),
    }
}

fn kinds() -> [(&'static str, PhaseKind); PhaseKind::ALL.len()] {
    PhaseKind::ALL.map(|kind| (kind.name(), kind))
}

fn component(item: Item) -> Option<PhaseComponent> {
    let mut fields = item.table(&keys::PHASE, "{ type = \"henyey-greenstein\", g = 0.7 }")?;
    let kind = fields.variant("type", &kinds(), Some(PhaseKind::Isotropic.name()));
    let weight = fields.read("weight", |i| i.number_f32(WEIGHT));
    let has_weight = fields.key_origin("weight").is_some();
    let kind = kind.and_then(|kind| match kind {
        PhaseKind::HenyeyGreenstein { .. } => fields.need("g", mean_cosine).map(|g| PhaseKind::HenyeyGreenstein { g }),
        other => Some(other),
    });
    fields.finish();
    Some(PhaseComponent { kind: kind?, weight: if has_weight { weight? } else { 1.0 } })
}

fn mean_cosine(item: Item) -> Option<f32> {
    const LARGEST: f32 = 1.0 - f32::EPSILON / 2.0;
    item.number_f32(MEAN_COSINE).map(|g| g.clamp(-LARGEST, LARGEST))
}

fn density(item: Item) -> Option<DensityRecord> {
    let fields = item.table(&keys::DENSITY, "{ file = \"cloud.npy\", min = [0, 0, 0], max = [1, 1, 1] }")?;
    let file = fields.need("file", object::path);
    let (min, max) = (fields.need("min", |i| i.point()), fields.need("max", |i| i.point()));
    if let (Some(min), Some(max)) = (min, max)
        && !min.cmplt(max).all()
    {
        fields.read("max", |i| i.error::<()>("`max` must be above `min` on every axis", "not above `min`"));
    }
    let transform = fields.read("transform", object::transform).unwrap_or_default();
    for step in &transform {
        if let crate::description::Step::Relocate(_) = step.value {
            let error = Diagnostic::error("a `density` cannot be relocated").at(step.origin.clone());
            item.cx.push(error.help("`min` is the lowest corner of its box: set that instead"));
        }
    }
    let scale = fields.read("scale", |i| i.number_f32(WEIGHT)).unwrap_or(1.0);
    let axes = fields.read("axes", |i| i.choice(&Axes::ALL.map(|axes| (axes.name(), axes))));
    let layout = layout(&fields);
    fields.finish();
    Some(DensityRecord { file: file?, min: min?, max: max?, transform, scale, layout, axes })
}

/// What a raw file holds, if something says that it is one.
fn layout(fields: &Fields) -> Option<RawLayout> {
    let most = DensityGrid::MAX_SIDE;
    let side = |i: Item| i.integer_u32(1, most);
    let size = fields.read("size", |i| i.fixed("an array of 3 whole numbers", side));
    let sample = fields.read("sample", |i| i.choice(&SampleType::ALL.map(|sample| (sample.name(), sample))));
    let byte_order = fields.read("byte_order", |i| i.choice(&ByteOrder::ALL.map(|order| (order.name(), order))));
    let has = |key| fields.key_origin(key).is_some();
    if !has("size") && !has("sample") && !has("byte_order") {
        return None;
    }
    for key in ["size", "sample"] {
        if !has(key) {
            fields.lacks(&format!("`{key}`, since it describes a raw file"));
        }
    }
    Some(RawLayout { size: size?, sample: sample?, byte_order: byte_order.unwrap_or_default() })
}
