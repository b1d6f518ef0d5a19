//! What values each key of a scene file takes.

use crate::{
    curve::Blend,
    physics::{BodyKind, CollisionShape, Combine, JointKind},
    read::{
        Bounds, COEFFICIENT, DURATION, DURATIONS, FACES, FORCES, FPS, FREE_PATH, FREQUENCIES, FRICTIONS, LATITUDES,
        LONGITUDES, MASSES, MAX_DEPTH, MAX_FRAMES, MAX_IGNORED, MAX_RECORDS, MAX_SIDE, MAX_STOPS, MEAN_COSINE, PARTS,
        PATTERNS, PRIORITY, RATIO, RATIOS, ROWS, SEGMENTS, SHUTTER, SIGMAS, SIZES, SPEED, SPEEDS, STEPS, SUN_SIZES,
        TIME, TIMES, TINT, TURBIDITIES, WEIGHT, ZONES,
        keys::{self, Section},
    },
    simplify::{METHODS, PLACEMENTS},
    track::Interpolation,
    volume_file::{Axes, ByteOrder, SampleType},
};
use etendue::{
    bsdf::{GrooveForm, metals},
    film::Aov,
    integrator::{Integrator, MAX_PARTS},
    medium::{DensityGrid, PhaseFunction, PhaseKind, presets},
    render::MAX_SPP,
    sampling::{Filter, Sampler},
    texture::{Channel, Filtering, MAX_OCTAVES, Wrap},
    tonemap::{Encoding, ToneCurve},
};

/// What a key takes.
#[derive(Clone, Debug)]
pub enum Kind {
    /// `true` or `false`.
    Boolean,
    /// Text that is not empty: a name of something, or of a file.
    Name,
    /// A whole number, both ends included.
    Integer(i64, i64),
    /// A number.
    Number(Bounds),
    /// A number (grey), three numbers, or `"#rrggbb"`.
    Colour(Bounds),
    /// One of some names.
    Choice(Vec<&'static str>),
    /// From the first to the second number of items.
    Array(Box<Kind>, usize, usize),
    /// A table.
    Table(&'static Section),
    /// A table of tables, by names.
    Named(&'static Section),
    /// A table of names, by names.
    Names,
    /// Any of several kinds.
    Any(Vec<Kind>),
}

use Kind::{Boolean, Colour, Integer, Name, Number, Table};

/// Angles, offsets and the like.
const FAR: Bounds = Bounds::within(-1e6, 1e6);
/// Indices of refraction.
const IOR: Bounds = Bounds::within(0.1, 10.0);
/// Filter radii, pixels.
const PIXELS: Bounds = Bounds::within(0.01, 16.0);

fn array(kind: Kind, count: usize) -> Kind {
    Kind::Array(Box::new(kind), count, count)
}

fn list(kind: Kind) -> Kind {
    Kind::Array(Box::new(kind), 0, usize::MAX)
}

fn point() -> Kind {
    array(Number(Bounds::COORDINATE), 3)
}

fn choice(names: &[&'static str]) -> Kind {
    Kind::Choice(names.to_vec())
}

fn all<T: Copy>(values: &[T], name: fn(T) -> &'static str) -> Kind {
    Kind::Choice(values.iter().map(|v| name(*v)).collect())
}

/// A value, or a texture times one.
fn parameter(value: Kind) -> Kind {
    Kind::Any(vec![value, Table(&keys::PARAMETER)])
}

fn colours(bounds: Bounds) -> Kind {
    parameter(Colour(bounds))
}

fn numbers(bounds: Bounds) -> Kind {
    parameter(Number(bounds))
}

/// One, or two of them.
fn pair(kind: Kind) -> Kind {
    Kind::Any(vec![kind.clone(), array(kind, 2)])
}

/// What `key` of `section` takes; `None` if nobody has said.
pub fn kind(section: &str, key: &str) -> Option<Kind> {
    let kind = constant(section, key)?;
    let varies = matches!(
        section,
        "[camera]"
            | "[environment]"
            | "[materials.NAME]"
            | "a textured parameter"
            | "emission"
            | "tangent"
            | "[[lights]]"
            | "rotate"
    );
    Some(if varies { with_keys(kind) } else { kind })
}

/// A value with keys in the place of each number, colour and point.
fn with_keys(kind: Kind) -> Kind {
    match kind {
        Number(_) | Colour(_) => Kind::Any(vec![kind, Table(&keys::KEYED)]),
        Kind::Array(item, 3, 3) if matches!(*item, Number(_)) => {
            Kind::Any(vec![Kind::Array(item, 3, 3), Table(&keys::KEYED)])
        }
        Kind::Array(item, low, high) if !matches!(*item, Number(_)) => {
            Kind::Array(Box::new(with_keys(*item)), low, high)
        }
        Kind::Any(kinds) => Kind::Any(kinds.into_iter().map(with_keys).collect()),
        other => other,
    }
}

fn constant(section: &str, key: &str) -> Option<Kind> {
    match section {
        "the scene file" => file(key),
        "[camera]" => camera(key),
        "[film]" => film(key),
        "film.filter" => filter(key),
        "[sampler]" => sampler(key),
        "[integrator]" => integrator(key),
        "[accelerator]" => accelerator(key),
        "[environment]" => environment(key),
        "[world]" => (key == "medium").then_some(Name),
        "[media.NAME]" => medium(key),
        "phase" => phase(key),
        "density" => density(key),
        "[textures.NAME]" => texture(key),
        "a stop" => stop(key),
        "[materials.NAME]" => material(key),
        "a textured parameter" => textured(key),
        "normal_map" => textured(key).filter(|_| key != "factor"),
        "emission" => emission(key),
        "tangent" => tangent(key),
        "[meshes.NAME]" => mesh(key),
        "simplify" => simplify(key),
        "[[objects]]" => object(key),
        "a step of transform" => step(key),
        "rotate" => rotate(key),
        "look_at" => look_at(key),
        "[[lights]]" => light(key),
        "[animation]" => animation(key),
        "keyframes" => keyframes(key),
        "motion" => motion(key),
        "a value with keys" => keyed(key),
        "body" => body(key),
        "[physics]" => physics(key),
        "[[joints]]" => joint(key),
        "motor" => motor(key),
        _ => None,
    }
}

fn file(key: &str) -> Option<Kind> {
    let tables = |section| Kind::Array(Box::new(Table(section)), 0, MAX_RECORDS);
    Some(match key {
        "camera" => Table(&keys::CAMERA),
        "film" => Table(&keys::FILM),
        "sampler" => Table(&keys::SAMPLER),
        "integrator" => Table(&keys::INTEGRATOR),
        "accelerator" => Table(&keys::ACCELERATOR),
        "environment" => Table(&keys::ENVIRONMENT),
        "media" => Kind::Named(&keys::MEDIUM),
        "world" => Table(&keys::WORLD),
        "textures" => Kind::Named(&keys::TEXTURE),
        "materials" => Kind::Named(&keys::MATERIAL),
        "meshes" => Kind::Named(&keys::MESH),
        "objects" => tables(&keys::OBJECT),
        "lights" => tables(&keys::LIGHT),
        "animation" => Table(&keys::ANIMATION),
        "physics" => Table(&keys::PHYSICS),
        "joints" => tables(&keys::JOINT),
        _ => return None,
    })
}

fn millimetres() -> Bounds {
    Bounds::within(0.0, 1e6).above()
}

fn camera(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => choice(&["perspective", "orthographic"]),
        "position" | "look_at" | "direction" | "up" | "focus_point" => point(),
        "fov" => Number(Bounds::within(0.0, 180.0).above().below()),
        "fov_axis" => choice(&["x", "y", "smaller", "larger"]),
        "focal_length" => Number(millimetres()),
        "sensor" => pair(Number(millimetres())),
        "lens_radius" | "near_clip" => Number(Bounds::LENGTH_OR_ZERO),
        "f_number" => Number(Bounds::within(0.01, 1e6)),
        "aperture" => choice(&["round", "square", "polygon"]),
        "blades" => Integer(3, 64),
        "roll" | "aperture_rotation" => Number(FAR),
        "focus_distance" | "height" => Number(Bounds::LENGTH),
        "focus_object" => Name,
        _ => return None,
    })
}

fn film(key: &str) -> Option<Kind> {
    Some(match key {
        "size" => array(Integer(1, MAX_SIDE.into()), 2),
        "filter" => Kind::Any(vec![all(&Filter::ALL, Filter::name), Table(&keys::FILTER)]),
        "crop" => array(Integer(0, MAX_SIDE.into()), 4),
        "exposure" => Number(Bounds::within(-64.0, 64.0)),
        "balance" => Colour(Bounds::LIGHT),
        "encoding" => all(&Encoding::ALL, Encoding::name),
        "tonemap" => all(&ToneCurve::ALL, ToneCurve::name),
        "aovs" => Kind::Array(Box::new(all(&Aov::ALL, Aov::name)), 0, Aov::ALL.len()),
        "transparent" => Boolean,
        _ => return None,
    })
}

fn filter(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => all(&Filter::ALL, Filter::name),
        "radius" | "sigma" => Number(PIXELS),
        "b" | "c" => Number(Bounds::UNIT),
        _ => return None,
    })
}

fn sampler(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => all(&Sampler::ALL, Sampler::name),
        "spp" => Integer(1, MAX_SPP.into()),
        "seed" => Integer(0, i64::MAX),
        _ => return None,
    })
}

fn integrator(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => all(&Integrator::ALL, Integrator::name),
        "depth" => Integer(1, MAX_DEPTH.into()),
        "splitting" => Kind::Any(vec![Integer(1, MAX_PARTS.into()), choice(&["auto"])]),
        "distance" => Number(Bounds::LENGTH),
        _ => return None,
    })
}

fn accelerator(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => choice(&["bvh", "kdtree", "brute"]),
        "split" => choice(&["sah", "midpoint"]),
        _ => return None,
    })
}

fn environment(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => choice(&["constant", "image", "gradient", "sky"]),
        "radiance" | "strength" | "top" | "horizon" | "bottom" => Colour(Bounds::LIGHT),
        "ground" => Colour(Bounds::UNIT),
        "sun" | "north" => point(),
        "elevation" | "latitude" => Number(LATITUDES),
        "azimuth" => Number(FAR),
        "longitude" => Number(LONGITUDES),
        "date" | "time" => Name,
        "utc_offset" => Number(ZONES),
        "turbidity" => Number(TURBIDITIES),
        "sun_size" => Number(SUN_SIZES),
        "sun_disk" => Boolean,
        "image" => Name,
        "rotation" => Number(FAR),
        "up" => choice(&["y", "z"]),
        _ => return None,
    })
}

fn medium(key: &str) -> Option<Kind> {
    Some(match key {
        "absorption" | "scattering" | "extinction" => Colour(COEFFICIENT),
        "mean_free_path" => Colour(FREE_PATH),
        "albedo" => Colour(Bounds::UNIT),
        "color" => Colour(TINT),
        "at_distance" => Number(Bounds::LENGTH),
        "preset" => Kind::Choice(presets::names().collect()),
        "emission" => Colour(Bounds::LIGHT),
        "phase" => {
            let mixture = Kind::Array(Box::new(Table(&keys::PHASE)), 1, PhaseFunction::MAX_COMPONENTS);
            Kind::Any(vec![all(&PhaseKind::ALL, PhaseKind::name), Table(&keys::PHASE), mixture])
        }
        "density" => Table(&keys::DENSITY),
        _ => return None,
    })
}

fn phase(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => all(&PhaseKind::ALL, PhaseKind::name),
        "g" => Number(MEAN_COSINE),
        "weight" => Number(WEIGHT),
        _ => return None,
    })
}

fn density(key: &str) -> Option<Kind> {
    Some(match key {
        "file" => Name,
        "min" | "max" => point(),
        "transform" => transform(),
        "scale" => Number(WEIGHT),
        "axes" => all(&Axes::ALL, Axes::name),
        "size" => array(Integer(1, DensityGrid::MAX_SIDE.into()), 3),
        "sample" => all(&SampleType::ALL, SampleType::name),
        "byte_order" => all(&ByteOrder::ALL, ByteOrder::name),
        _ => return None,
    })
}

fn transform() -> Kind {
    Kind::Any(vec![Table(&keys::STEP), Kind::Array(Box::new(Table(&keys::STEP)), 0, 1000)])
}

fn texture(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => Kind::Choice(PATTERNS.map(|(name, _)| name).to_vec()),
        "file" => Name,
        "encoding" => choice(&["srgb", "linear"]),
        "channel" => all(&Channel::ALL, Channel::name),
        "filter" => all(&Filtering::ALL, Filtering::name),
        "wrap" => pair(all(&Wrap::ALL, Wrap::name)),
        "coordinates" => choice(&["uv", "object"]),
        "scale" | "offset" => Kind::Any(vec![Number(FAR), Kind::Array(Box::new(Number(FAR)), 2, 3)]),
        "color1" | "color2" => colours(Bounds::LIGHT),
        "weight" => numbers(Bounds::UNIT),
        "width" | "roughness" => Number(Bounds::UNIT),
        "octaves" => Integer(1, MAX_OCTAVES.into()),
        "turbulence" | "radial" => Boolean,
        "distortion" => Number(Bounds::within(0.0, 100.0)),
        "axis" => Kind::Any(vec![choice(&["x", "y", "z"]), point()]),
        "seed" => Integer(0, u32::MAX.into()),
        "stops" => Kind::Array(Box::new(Kind::Any(vec![Colour(Bounds::LIGHT), Table(&keys::STOP)])), 1, MAX_STOPS),
        "from" | "to" => Kind::Array(Box::new(Number(FAR)), 2, 3),
        "rotate" | "gain" | "base" => Number(FAR),
        _ => return None,
    })
}

fn stop(key: &str) -> Option<Kind> {
    Some(match key {
        "at" => Number(Bounds::UNIT),
        "color" => Colour(Bounds::LIGHT),
        _ => return None,
    })
}

fn material(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => choice(&[
            "diffuse",
            "mirror",
            "glass",
            "rough-metal",
            "rough-glass",
            "brushed-metal",
            "mtl",
            "phong",
            "principled",
            "black",
            "boundary",
        ]),
        "interior" => Name,
        "priority" => Integer(-PRIORITY, PRIORITY),
        "emission" => Kind::Any(vec![Colour(Bounds::LIGHT), Table(&keys::EMISSION)]),
        "normal_map" => Table(&keys::TEXTURE_REFERENCE),
        "normal_scale" => Number(FAR),
        "normal_y" => choice(&["up", "down"]),
        "bump" => numbers(FAR),
        "thin" => Boolean,
        "form" => all(&GrooveForm::ALL, GrooveForm::name),
        "tangent" => Kind::Any(vec![choice(&["uv"]), Table(&keys::TANGENT)]),
        "metal" => Kind::Any(vec![Kind::Choice(metals::names().collect()), Name]),
        "ior" => numbers(IOR),
        "eta" | "k" => colours(Bounds::within(0.0, 100.0)),
        "alpha" => pair(numbers(Bounds::UNIT)),
        "exponent" | "transmission_exponent" => numbers(Bounds::within(0.0, 1e9)),
        "rotation" => numbers(Bounds::within(-3600.0, 3600.0)),
        "opacity" | "metallic" | "roughness" | "anisotropic" | "coat" | "coat_roughness" | "sheen_roughness" => {
            numbers(Bounds::UNIT)
        }
        "reflectance"
        | "transmittance"
        | "reflection_tint"
        | "transmission_tint"
        | "tint"
        | "diffuse"
        | "specular"
        | "diffuse_transmission"
        | "transmission"
        | "base_color"
        | "sheen" => colours(Bounds::UNIT),
        _ => return None,
    })
}

fn textured(key: &str) -> Option<Kind> {
    Some(match key {
        "texture" | "file" => Name,
        "factor" => Kind::Any(vec![Number(FAR), Colour(Bounds::LIGHT)]),
        _ => return None,
    })
}

fn emission(key: &str) -> Option<Kind> {
    Some(match key {
        "radiance" => colours(Bounds::LIGHT),
        "two_sided" => Boolean,
        _ => return None,
    })
}

fn tangent(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => choice(&["uv", "constant", "radial", "tangential"]),
        "direction" | "axis" => Kind::Any(vec![choice(&["x", "y", "z"]), point()]),
        "center" => point(),
        "rotation" => numbers(Bounds::within(-3600.0, 3600.0)),
        _ => return None,
    })
}

fn crease_angle() -> Kind {
    Number(Bounds::within(0.0, 180.0).above())
}

fn mesh(key: &str) -> Option<Kind> {
    Some(match key {
        "file" => Name,
        "positions" => list(point()),
        "indices" => list(Kind::Array(Box::new(Integer(0, u32::MAX.into())), 3, 4)),
        "normals" => list(array(Number(Bounds::within(-1e3, 1e3)), 3)),
        "uvs" => list(array(Number(FAR), 2)),
        "colors" => list(Colour(Bounds::UNIT)),
        "crease_angle" => crease_angle(),
        "simplify" => Table(&keys::SIMPLIFY),
        _ => return None,
    })
}

fn simplify(key: &str) -> Option<Kind> {
    Some(match key {
        "faces" => Integer(FACES.0, FACES.1),
        "ratio" => Number(RATIO),
        "max_error" => Kind::Any(vec![Number(Bounds::LENGTH), Name]),
        "method" => Kind::Choice(METHODS.map(|(name, _)| name).to_vec()),
        "placement" => Kind::Choice(PLACEMENTS.map(|(name, _)| name).to_vec()),
        "sigma" => Number(SIGMAS),
        "crease_angle" => crease_angle(),
        "keep_boundary" | "fast" | "polish" => Boolean,
        "seed" => Integer(0, i64::MAX),
        _ => return None,
    })
}

fn object(key: &str) -> Option<Kind> {
    Some(match key {
        "shape" => choice(&["mesh", "sphere", "rectangle", "box", "disk"]),
        "name" | "material" | "mesh" | "file" => Name,
        "materials" => Kind::Names,
        "transform" => transform(),
        "motion" => Table(&keys::MOTION),
        "body" => Kind::Any(vec![all(&BodyKind::ALL, BodyKind::name), Table(&keys::BODY)]),
        "crease_angle" => crease_angle(),
        "simplify" => Table(&keys::SIMPLIFY),
        "center" | "corner" | "u" | "v" | "min" | "max" => point(),
        "radius" => Number(Bounds::LENGTH),
        "size" => Kind::Any(vec![Number(Bounds::LENGTH), Kind::Array(Box::new(Number(Bounds::LENGTH)), 2, 3)]),
        "segments" => Integer(SEGMENTS.0.into(), SEGMENTS.1.into()),
        _ => return None,
    })
}

fn step(key: &str) -> Option<Kind> {
    let coordinate = || Number(Bounds::COORDINATE);
    Some(match key {
        "translate" | "relocate" => point(),
        "rotate" => Table(&keys::ROTATE),
        "look_at" => Table(&keys::LOOK_AT),
        "scale" => Kind::Any(vec![coordinate(), point()]),
        "matrix" => {
            let rows = Kind::Array(Box::new(array(coordinate(), 4)), 3, 4);
            Kind::Any(vec![array(coordinate(), 12), array(coordinate(), 16), rows])
        }
        _ => return None,
    })
}

fn animation(key: &str) -> Option<Kind> {
    Some(match key {
        "start" => Number(TIME),
        "speed" => Number(SPEED),
        "fps" => Kind::Any(vec![Number(FPS), Name]),
        "frames" => Integer(1, MAX_FRAMES.into()),
        "duration" => Number(DURATION),
        "shutter" => Kind::Any(vec![Number(Bounds::UNIT), array(Number(SHUTTER), 2)]),
        "shutter_curve" => Kind::Any(vec![choice(&["box", "triangle"]), array(Number(Bounds::UNIT), 2)]),
        "keyframes" => Kind::Any(vec![Name, Table(&keys::KEYFRAMES)]),
        _ => return None,
    })
}

fn keyframes(key: &str) -> Option<Kind> {
    Some(match key {
        "file" => Name,
        "objects" => list(Name),
        "times" => Kind::Array(Box::new(Number(TIME)), 1, usize::MAX),
        "start" => Number(TIME),
        "fps" => Number(ROWS),
        "interpolation" => all(&Interpolation::ALL, Interpolation::name),
        "relative" => Boolean,
        _ => return None,
    })
}

fn motion(key: &str) -> Option<Kind> {
    let keyed = Table(&keys::KEYED);
    Some(match key {
        "translate" => Kind::Any(vec![point(), keyed]),
        "rotate" => Kind::Any(vec![Table(&keys::ROTATE), keyed]),
        "pivot" => point(),
        _ => return None,
    })
}

/// What stands in keys belongs to the key that has them; here it is any of those.
fn keyed(key: &str) -> Option<Kind> {
    Some(match key {
        "keys" => {
            let value =
                Kind::Any(vec![Colour(Bounds::COORDINATE), array(Number(Bounds::COORDINATE), 4), Table(&keys::ROTATE)]);
            Kind::Array(Box::new(Kind::Array(Box::new(value), 2, 2)), 1, usize::MAX)
        }
        // Of values, or of rotations.
        "interpolation" => {
            Kind::Any(vec![all(&Blend::ALL, Blend::name), all(&Interpolation::ALL, Interpolation::name)])
        }
        _ => return None,
    })
}

fn rotate(key: &str) -> Option<Kind> {
    Some(match key {
        "axis" => Kind::Any(vec![choice(&["x", "y", "z"]), point()]),
        "angle" => Number(FAR),
        _ => return None,
    })
}

fn look_at(key: &str) -> Option<Kind> {
    matches!(key, "position" | "target" | "up").then(point)
}

fn light(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => choice(&["point", "spot", "directional"]),
        "position" | "target" | "direction" => point(),
        "intensity" | "irradiance" => Colour(Bounds::LIGHT),
        "angle" => Number(Bounds::within(0.0, 360.0).above()),
        "blend" => Number(Bounds::UNIT),
        _ => return None,
    })
}

fn velocity() -> Kind {
    array(Number(SPEEDS), 3)
}

fn body(key: &str) -> Option<Kind> {
    Some(match key {
        "kind" => all(&BodyKind::ALL, BodyKind::name),
        "shape" => all(&CollisionShape::ALL, CollisionShape::name),
        "friction" => Number(FRICTIONS),
        "restitution" => Number(Bounds::UNIT),
        "group" => Name,
        "mass" | "density" => Number(MASSES),
        "linear_velocity" | "angular_velocity" => velocity(),
        "linear_damping" | "angular_damping" => Number(FORCES),
        "gravity_scale" => Number(SPEEDS),
        _ => return None,
    })
}

fn physics(key: &str) -> Option<Kind> {
    Some(match key {
        "gravity" => velocity(),
        "step" => Number(STEPS),
        "substeps" | "iterations" => Integer(PARTS.0.into(), PARTS.1.into()),
        "start" => Number(TIMES),
        "duration" | "warm_up" => Number(DURATIONS),
        "friction_rule" | "restitution_rule" => all(&Combine::ALL, Combine::name),
        "length_unit" => Number(SIZES),
        "contact_frequency" => Number(FREQUENCIES),
        "contact_damping" => Number(RATIOS),
        "sleep" => Boolean,
        "ignore" => Kind::Array(Box::new(array(Name, 2)), 0, MAX_IGNORED),
        _ => return None,
    })
}

fn joint(key: &str) -> Option<Kind> {
    Some(match key {
        "type" => all(&JointKind::ALL, JointKind::name),
        "bodies" => Kind::Any(vec![Name, Kind::Array(Box::new(Name), 1, 2)]),
        "anchor" => point(),
        "axis" => Kind::Any(vec![choice(&["x", "y", "z"]), point()]),
        "limits" => array(Number(Bounds::COORDINATE), 2),
        "motor" => Table(&keys::MOTOR),
        "collide" => Boolean,
        _ => return None,
    })
}

fn motor(key: &str) -> Option<Kind> {
    Some(match key {
        "velocity" | "position" => Number(SPEEDS),
        "stiffness" | "damping" | "max_force" => Number(FORCES),
        _ => return None,
    })
}
