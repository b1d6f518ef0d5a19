//! `[materials.NAME]`.

use super::{
    fields::{Fields, Item},
    keys, tangent, texture,
    values::Bounds,
};
use crate::{Origin, description::TextureRecord, diagnostic::Diagnostic, value::Data};
use etendue::{
    bsdf::{GrooveForm, MIRROR_EXPONENT, PhongLobes, PrincipledParameters, metals},
    material::{Color, Emission, Material, Number, Relief, Scattering},
    spectrum::Spectrum,
};

/// Indices of refraction that make sense, relative.
const IOR: Bounds = Bounds::within(0.1, 10.0);
const DEFAULT_IOR: f32 = 1.5;
const DEFAULT_ALPHA: f32 = 0.1;
/// Components of a metal's complex index of refraction.
const METAL: Bounds = Bounds::within(0.0, 100.0);
/// Exponents of lobes that are powers of a cosine.
const EXPONENT: Bounds = Bounds::within(0.0, 1e9);
const DEFAULT_EXPONENT: f32 = 20.0;
/// Degrees.
const ANGLE: Bounds = Bounds::within(-3600.0, 3600.0);

/// Heights of bumps, metres, and factors of normals.
const RELIEF: Bounds = Bounds::within(-1e6, 1e6);

/// Largest magnitude of a priority.
pub const PRIORITY: i64 = 1_000_000;

/// Grey, for objects without a material.
pub fn default_material<T>() -> Material<T> {
    Material::new("", Scattering::Diffuse { reflectance: Spectrum::splat(0.5), transmittance: Spectrum::BLACK })
}

#[derive(Clone, Copy)]
enum Kind {
    Diffuse,
    Mirror,
    Glass,
    RoughMetal,
    RoughGlass,
    BrushedMetal,
    Mtl,
    Phong,
    Principled,
    Black,
    Boundary,
}

const KINDS: [(&str, Kind); 11] = [
    ("diffuse", Kind::Diffuse),
    ("mirror", Kind::Mirror),
    ("glass", Kind::Glass),
    ("rough-metal", Kind::RoughMetal),
    ("rough-glass", Kind::RoughGlass),
    ("brushed-metal", Kind::BrushedMetal),
    ("mtl", Kind::Mtl),
    ("phong", Kind::Phong),
    ("principled", Kind::Principled),
    ("black", Kind::Black),
    ("boundary", Kind::Boundary),
];

/// A material, and where the name of its interior is; what could not be read has been reported and is replaced by something.
pub fn material(item: Item, name: &str) -> (Material<TextureRecord>, Option<Origin>) {
    let mut material = default_material();
    material.name = name.to_owned();
    let Some(mut fields) = item.table(&keys::MATERIAL, "[materials.NAME]") else { return (material, None) };
    let kind = fields.variant("type", &KINDS, None);
    if let Some(kind) = kind {
        material.scattering = scattering(&fields, kind).unwrap_or(material.scattering);
    }
    material.interior = fields.read("interior", |i| i.name_text()).map(str::to_owned);
    material.priority = fields.read("priority", |i| i.integer(-PRIORITY, PRIORITY)).map(|priority| priority as i32);
    material.emission = fields.read("emission", emission);
    material.opacity = fields.read("opacity", |i| texture::number(i, Bounds::UNIT)).unwrap_or(1.0.into());
    if let Some(Kind::Boundary) = kind {
        material.opacity = 0.0.into();
        if material.interior.is_none() && material.priority.is_none() {
            fields.lacks("`interior`, the medium that it bounds");
        }
    }
    material.relief = relief(&fields);
    material.tangent = fields.read("tangent", tangent::tangent).unwrap_or_default();
    if let Err(error) = material.validate() {
        let origin = fields.key_origin(error.parameter()).unwrap_or(fields.origin);
        item.cx.push(Diagnostic::error(error.to_string()).at(origin.clone()));
    }
    let interior = fields.get("interior").map(|item| item.value.origin.clone());
    fields.finish();
    (material, interior)
}

fn relief(fields: &Fields) -> Option<Relief<TextureRecord>> {
    fields.exclusive("bump", "normal_map");
    let scale = fields.read("normal_scale", |i| i.number_f32(RELIEF));
    let sign = fields.read("normal_y", |i| i.choice(&[("up", 1.0), ("down", -1.0)])).unwrap_or(1.0);
    for key in ["normal_scale", "normal_y"] {
        if fields.get(key).is_some() && fields.get("normal_map").is_none() {
            fields.lacks(&format!("`normal_map` for its `{key}`"));
        }
    }
    let map = fields.read("normal_map", |item| {
        let fields = item.table(&keys::TEXTURE_REFERENCE, "{ texture = \"NAME\" } or { file = \"FILE\" }")?;
        let map = texture::reference(&fields);
        fields.finish();
        map
    });
    let bump = fields.read("bump", |i| texture::number(i, RELIEF));
    match (map, bump) {
        (Some(map), _) => {
            let scale = scale.unwrap_or(1.0);
            Some(Relief::Normals { map, scale: [scale, scale * sign] })
        }
        (None, Some(height)) => Some(Relief::Bump { height }),
        (None, None) => None,
    }
}

/// Colours and numbers as they are read: over a surface.
type Surface = Scattering<Color<TextureRecord>, Number<TextureRecord>>;

fn scattering(fields: &Fields, kind: Kind) -> Option<Surface> {
    let albedo =
        |key, default| fields.read(key, |i| texture::color(i, Bounds::UNIT)).unwrap_or(Spectrum::splat(default).into());
    let ior = || fields.read("ior", |i| texture::number(i, IOR)).unwrap_or(DEFAULT_IOR.into());
    let alpha = |bounds: Bounds| fields.read("alpha", |i| texture::number(i, bounds)).unwrap_or(DEFAULT_ALPHA.into());
    Some(match kind {
        Kind::Diffuse => {
            Scattering::Diffuse { reflectance: albedo("reflectance", 0.5), transmittance: albedo("transmittance", 0.0) }
        }
        Kind::Mirror => Scattering::Mirror { reflectance: albedo("reflectance", 1.0) },
        Kind::Glass => Scattering::Glass {
            ior: ior(),
            reflection_tint: albedo("reflection_tint", 1.0),
            transmission_tint: albedo("transmission_tint", 1.0),
            thin: fields.read("thin", |i| i.boolean()).unwrap_or(false),
        },
        Kind::RoughMetal => {
            let tint = albedo("tint", 1.0);
            let alpha = fields.read("alpha", widths).unwrap_or_else(|| [DEFAULT_ALPHA; 2].map(Number::from));
            let (eta, k) = metal(fields)?;
            Scattering::RoughMetal { eta, k, alpha, tint }
        }
        Kind::RoughGlass => Scattering::RoughGlass {
            ior: ior(),
            alpha: alpha(Bounds::UNIT.above()),
            reflection_tint: albedo("reflection_tint", 1.0),
            transmission_tint: albedo("transmission_tint", 1.0),
        },
        Kind::BrushedMetal => Scattering::BrushedMetal {
            reflectance: albedo("reflectance", 1.0),
            exponent: fields.read("exponent", |i| texture::number(i, EXPONENT)).unwrap_or(DEFAULT_EXPONENT.into()),
            form: fields.read("form", |i| i.choice(&GrooveForm::ALL.map(|f| (f.name(), f)))).unwrap_or_default(),
        },
        Kind::Mtl => Scattering::Mtl {
            diffuse: albedo("diffuse", 0.0),
            specular: albedo("specular", 0.0),
            alpha: alpha(Bounds::UNIT),
            transmission: albedo("transmission", 0.0),
            ior: ior(),
        },
        Kind::Phong => Scattering::Phong(phong(fields)),
        Kind::Principled => Scattering::Principled(principled(fields)),
        Kind::Black | Kind::Boundary => Scattering::Black,
    })
}

/// A width for all directions, or one along the tangent and one across.
fn widths(item: Item) -> Option<[Number<TextureRecord>; 2]> {
    let width = |item| texture::number(item, Bounds::UNIT.above());
    match item.value.data {
        Data::Array(_) => item.fixed("an array of 2 numbers", width),
        _ => width(item).map(|alpha| [alpha.clone(), alpha]),
    }
}

/// A number of [`Bounds::UNIT`], a colour of it, and an index of refraction: the parameters of mixtures.
struct Parameters<'a, 'b>(&'b Fields<'a>);

impl Parameters<'_, '_> {
    fn color(&self, key: &'static str, default: f32) -> Color<TextureRecord> {
        self.0.read(key, |i| texture::color(i, Bounds::UNIT)).unwrap_or(Spectrum::splat(default).into())
    }

    fn number(&self, key: &'static str, bounds: Bounds, default: f32) -> Number<TextureRecord> {
        self.0.read(key, |i| texture::number(i, bounds)).unwrap_or(default.into())
    }

    fn unit(&self, key: &'static str, default: f32) -> Number<TextureRecord> {
        self.number(key, Bounds::UNIT, default)
    }
}

fn phong(fields: &Fields) -> PhongLobes<Color<TextureRecord>, Number<TextureRecord>> {
    let p = Parameters(fields);
    PhongLobes {
        diffuse: p.color("diffuse", 0.0),
        specular: p.color("specular", 0.0),
        exponent: p.number("exponent", EXPONENT, DEFAULT_EXPONENT),
        diffuse_transmission: p.color("diffuse_transmission", 0.0),
        transmission: p.color("transmission", 0.0),
        transmission_exponent: p.number("transmission_exponent", EXPONENT, MIRROR_EXPONENT),
        ior: p.number("ior", IOR, 1.0),
    }
}

fn principled(fields: &Fields) -> PrincipledParameters<Color<TextureRecord>, Number<TextureRecord>> {
    let p = Parameters(fields);
    let mut rotation = p.number("rotation", ANGLE, 0.0);
    rotation.factor = rotation.factor.to_radians();
    PrincipledParameters {
        base_color: p.color("base_color", 0.8),
        metallic: p.unit("metallic", 0.0),
        roughness: p.unit("roughness", 0.5),
        anisotropic: p.unit("anisotropic", 0.0),
        rotation,
        ior: p.number("ior", IOR, DEFAULT_IOR),
        specular: p.unit("specular", 1.0),
        transmission: p.unit("transmission", 0.0),
        coat: p.unit("coat", 0.0),
        coat_roughness: p.unit("coat_roughness", 0.03),
        sheen: p.color("sheen", 0.0),
        sheen_roughness: p.unit("sheen_roughness", 0.5),
    }
}

/// `metal`, or `eta` and `k`.
fn metal(fields: &Fields) -> Option<(Color<TextureRecord>, Color<TextureRecord>)> {
    fields.exclusive("metal", "eta");
    fields.exclusive("metal", "k");
    let preset = fields.read("metal", |item| {
        let name = item.text()?;
        let found = metals::find(name);
        if found.is_none() {
            let error = Diagnostic::error(format!("no metal is called `{name}`")).at(item.value.origin.clone());
            let names: Vec<&str> = metals::names().collect();
            let label = format!("expected one of {}", super::fields::list(names.iter().copied()));
            item.cx.push(error.label(label).suggest(name, names));
        }
        found
    });
    let component = |key| fields.get(key).map(|item| texture::color(item, METAL));
    let (eta, k) = (component("eta"), component("k"));
    match (fields.get("metal"), eta, k) {
        (Some(_), ..) => preset.map(|m| (m.eta.into(), m.k.into())),
        (None, Some(eta), Some(k)) => Some((eta?, k?)),
        (None, None, None) => {
            fields.lacks("`metal`, or `eta` and `k`");
            None
        }
        (None, Some(_), None) => {
            fields.lacks("`k`");
            None
        }
        (None, None, Some(_)) => {
            fields.lacks("`eta`");
            None
        }
    }
}

fn emission(item: Item) -> Option<Emission<TextureRecord>> {
    if !matches!(item.value.data, Data::Table(_)) || item.is_keyed() {
        return Some(Emission { radiance: item.colour(Bounds::LIGHT)?.into(), two_sided: false });
    }
    let fields = item.table(&keys::EMISSION, "{ radiance = 1 }")?;
    let radiance = fields.need("radiance", |i| texture::color(i, Bounds::LIGHT));
    let two_sided = fields.read("two_sided", |i| i.boolean()).unwrap_or(false);
    fields.finish();
    Some(Emission { radiance: radiance?, two_sided })
}
