//! Textures that are computed, and textures made of others.

use super::{
    fields::{Context, Fields, Item},
    keys,
    texture::{FAR, color, number, uv_transform},
    values::Bounds,
};
use crate::{
    Diagnostic,
    description::{ImageRecord, TextureRecord},
    value::{Data, Entry, Value},
};
use etendue::{
    math::{DVec3, Vec3},
    spectrum::Spectrum,
    texture::{
        Checker, Color, Coordinates, Gradient, Grid, MAX_OCTAVES, Marble, Noise, Pattern, Procedure, Stop, UvTransform,
        Wood,
    },
};
use std::collections::BTreeMap;

/// Textures within textures, the outermost counted.
pub const MAX_NESTING: u32 = 8;
/// Textures that one texture may be made of, each counted as often as it is used.
const MAX_PARTS: u64 = 256;
/// Colours of a gradient.
pub const MAX_STOPS: usize = 64;

/// What `type` says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Image,
    Checker,
    Grid,
    Noise,
    Wood,
    Marble,
    Gradient,
    Mix,
    Multiply,
    VertexColor,
}

pub const KINDS: [(&str, Kind); 10] = [
    ("image", Kind::Image),
    ("checker", Kind::Checker),
    ("grid", Kind::Grid),
    ("noise", Kind::Noise),
    ("wood", Kind::Wood),
    ("marble", Kind::Marble),
    ("gradient", Kind::Gradient),
    ("mix", Kind::Mix),
    ("multiply", Kind::Multiply),
    ("vertex-color", Kind::VertexColor),
];

/// Where light wood turns dark, and stone its veins.
const WOOD: [Spectrum; 2] = [Spectrum([0.52, 0.31, 0.15]), Spectrum([0.20, 0.085, 0.03])];
const MARBLE: [Spectrum; 2] = [Spectrum([0.82, 0.80, 0.76]), Spectrum([0.14, 0.15, 0.17])];

/// The pattern of a texture that is no image; `transform` becomes that of its texture coordinates.
pub fn pattern(fields: &Fields, kind: Kind, transform: &mut UvTransform) -> Option<Pattern<ImageRecord>> {
    let (white, black) = (Spectrum::ONE, Spectrum::BLACK);
    let (coordinates, procedure, default) = match kind {
        Kind::Image => return None,
        Kind::Checker => (coordinates(fields, transform, false), Procedure::Checker(Checker), [white, black]),
        Kind::Grid => {
            let width = fields.read("width", |i| i.number_f32(Bounds::UNIT)).unwrap_or(Grid::DEFAULT.width);
            (coordinates(fields, transform, false), Procedure::Grid(Grid { width }), [white, black])
        }
        Kind::Noise => (coordinates(fields, transform, true), Procedure::Noise(noise(fields)), [black, white]),
        Kind::Wood => {
            let Wood { axis, distortion, .. } = Wood::DEFAULT;
            let (axis, distortion, seed) = (axis_of(fields, axis), distorted(fields, distortion), seed(fields));
            (coordinates(fields, transform, true), Procedure::Wood(Wood { axis, distortion, seed }), WOOD)
        }
        Kind::Marble => {
            let Marble { axis, distortion, .. } = Marble::DEFAULT;
            let (axis, distortion, seed) = (axis_of(fields, axis), distorted(fields, distortion), seed(fields));
            (coordinates(fields, transform, true), Procedure::Marble(Marble { axis, distortion, seed }), MARBLE)
        }
        Kind::Gradient => return gradient(fields, transform).map(Pattern::Gradient),
        Kind::Mix => {
            let weight = fields.need("weight", |i| number(i, Bounds::UNIT));
            let colors = colors(fields, [black, white]);
            return Some(Pattern::Mix { colors: colors?, weight: weight? });
        }
        Kind::Multiply => return Some(Pattern::Multiply(colors(fields, [white, white])?)),
        Kind::VertexColor => return Some(Pattern::VertexColor),
    };
    // All keys are read, whatever is wrong with one of them.
    let colors = colors(fields, default);
    Some(Pattern::Procedure { procedure, coordinates: coordinates?, colors: colors? })
}

/// `color1` and `color2`. `None` after an error in one of them.
fn colors(fields: &Fields, default: [Spectrum; 2]) -> Option<[Color<TextureRecord>; 2]> {
    let read = |key, default: Spectrum| match fields.get(key) {
        None => Some(default.into()),
        Some(item) => color(item, Bounds::LIGHT),
    };
    let [first, second] = [read("color1", default[0]), read("color2", default[1])];
    Some([first?, second?])
}

fn noise(fields: &Fields) -> Noise {
    let Noise { octaves, roughness, turbulence, .. } = Noise::DEFAULT;
    Noise {
        octaves: fields.read("octaves", |i| i.integer_u32(1, MAX_OCTAVES)).unwrap_or(octaves),
        roughness: fields.read("roughness", |i| i.number_f32(Bounds::UNIT)).unwrap_or(roughness),
        turbulence: fields.read("turbulence", |i| i.boolean()).unwrap_or(turbulence),
        seed: seed(fields),
    }
}

fn seed(fields: &Fields) -> u32 {
    fields.read("seed", |i| i.integer_u32(0, u32::MAX)).unwrap_or(0)
}

fn distorted(fields: &Fields, default: f32) -> f32 {
    fields.read("distortion", |i| i.number_f32(Bounds::within(0.0, 100.0))).unwrap_or(default)
}

fn axis_of(fields: &Fields, default: Vec3) -> Vec3 {
    fields.read("axis", |i| i.axis()).map_or(default, DVec3::as_vec3)
}

/// `coordinates` with the keys that place a pattern in them.
fn coordinates(fields: &Fields, transform: &mut UvTransform, is_solid: bool) -> Option<Coordinates> {
    let choices = [("uv", false), ("object", true)];
    if !fields.read("coordinates", |i| i.choice(&choices)).unwrap_or(is_solid) {
        *transform = uv_transform(fields);
        return Some(Coordinates::Uv);
    }
    let rotate = fields.get("rotate");
    if let Some(item) = rotate {
        let error = Diagnostic::error("`rotate` turns texture coordinates alone");
        item.cx.push(error.at(item.value.origin.clone()).help("turn the object, or write `coordinates = \"uv\"`"));
    }
    let read = |key, default: f64| match fields.get(key) {
        None => Some(DVec3::splat(default)),
        Some(item) => item.per_axis(FAR),
    };
    let (scale, offset) = (read("scale", 1.0), read("offset", 0.0));
    let (scale, offset) = (scale?.as_vec3(), offset?.as_vec3());
    rotate.is_none().then_some(Coordinates::Object { scale, offset })
}

fn gradient(fields: &Fields, transform: &mut UvTransform) -> Option<Gradient> {
    let coordinates = coordinates(fields, transform, false);
    let radial = fields.read("radial", |i| i.boolean()).unwrap_or(false);
    let is_uv = coordinates == Some(Coordinates::Uv);
    let (from, to) = match (is_uv, radial) {
        (true, false) => (Vec3::ZERO, Vec3::X),
        (true, true) => (Vec3::new(0.5, 0.5, 0.0), Vec3::new(1.0, 0.5, 0.0)),
        (false, false) => (Vec3::ZERO, Vec3::Y),
        (false, true) => (Vec3::ZERO, Vec3::X),
    };
    let point = |item: Item| match is_uv {
        true => item.numbers::<2>(FAR).map(|[u, v]| Vec3::new(u as f32, v as f32, 0.0)),
        false => item.numbers::<3>(FAR).map(|p| DVec3::from_array(p).as_vec3()),
    };
    let end = |key, default| match fields.get(key) {
        None => Some(default),
        Some(item) => point(item),
    };
    let (from, to, stops) = (end("from", from), end("to", to), fields.need("stops", stops));
    let (coordinates, from, to, stops) = (coordinates?, from?, to?, stops?);
    let length = (to - from).length();
    if !(length > 0.0 && length.is_finite()) {
        let origin = fields.key_origin("to").or(fields.key_origin("from")).unwrap_or(fields.origin);
        let error = Diagnostic::error("`from` and `to` of a gradient are the same point").at(origin.clone());
        fields.push(error);
        return None;
    }
    Some(Gradient { coordinates, from, to, radial, stops })
}

/// `[{ at = 0, color = 1 }, ..]` in ascending order, or colours at equal distances.
fn stops(item: Item) -> Option<Box<[Stop]>> {
    let items = item.array_help("an array of colours", "[{ at = 0, color = \"#000000\" }, { at = 1, color = 1 }]")?;
    let count = items.len();
    if !(1..=MAX_STOPS).contains(&count) {
        let message = format!("`stops` has {count} colours");
        return item.error(message, format!("expected from 1 to {MAX_STOPS}"));
    }
    let even = |index: usize| index as f32 / (count - 1).max(1) as f32;
    let read: Vec<Option<Stop>> = items.enumerate().map(|(index, item)| stop(item, even(index))).collect();
    let stops: Vec<Stop> = read.into_iter().collect::<Option<_>>()?;
    if !stops.is_sorted_by(|a, b| a.at <= b.at) {
        return item.error("`stops` are not in ascending order", "each `at` must be at least that of the stop before");
    }
    Some(stops.into())
}

fn stop(item: Item, even: f32) -> Option<Stop> {
    let Data::Table(_) = item.value.data else {
        return Some(Stop { at: even, color: item.colour(Bounds::LIGHT)? });
    };
    let fields = item.table(&keys::STOP, "{ at = 0, color = 1 }")?;
    let at = fields.need("at", |i| i.number_f32(Bounds::UNIT));
    let color = fields.need("color", |i| i.colour(Bounds::LIGHT));
    fields.finish();
    Some(Stop { at: at?, color: color? })
}

/// An order in which every texture comes after those that it names. Those that name themselves, at however many removes, and
/// those that are nested too deep are reported and left out, as are those that name them.
pub fn order(cx: &Context, entries: &[(&Entry, Item)]) -> Vec<usize> {
    let numbers: BTreeMap<&str, usize> = entries.iter().enumerate().map(|(i, (e, _))| (e.key.as_str(), i)).collect();
    let of = |(entry, _): &(&Entry, Item)| -> Vec<usize> {
        let mut names = Vec::new();
        named_by(&entry.value, &mut names);
        names.iter().filter_map(|name| numbers.get(name).copied()).collect()
    };
    let parts: Vec<Vec<usize>> = entries.iter().map(of).collect();
    let mut users = vec![Vec::new(); entries.len()];
    for (user, parts) in parts.iter().enumerate() {
        parts.iter().for_each(|part| users[*part].push(user));
    }
    let mut waiting: Vec<usize> = parts.iter().map(Vec::len).collect();
    let mut order: Vec<usize> = (0..entries.len()).filter(|i| waiting[*i] == 0).collect();
    // How deep each is nested, and of how many textures it is made; 0 is an error that has been reported.
    let mut sizes = vec![(1u32, 1u64); entries.len()];
    let mut next = 0;
    while let Some(&index) = order.get(next) {
        next += 1;
        sizes[index] = size(cx, entries[index].0, parts[index].iter().map(|part| sizes[*part]));
        for &user in &users[index] {
            waiting[user] -= 1;
            if waiting[user] == 0 {
                order.push(user);
            }
        }
    }
    report_circles(cx, entries, &parts, &waiting);
    order.retain(|index| sizes[*index].0 > 0);
    order
}

/// Nesting and number of parts of a texture that is made of textures of those sizes.
fn size(cx: &Context, entry: &Entry, mut parts: impl Iterator<Item = (u32, u64)>) -> (u32, u64) {
    let sum = parts.try_fold((1, 1u64), |(depth, count), part| match part {
        (0, _) => None,
        (of_part, parts) => Some((depth.max(of_part + 1), count.saturating_add(parts))),
    });
    let Some((depth, count)) = sum else { return (0, 0) };
    let error = |message: String, help: &str| {
        cx.push(Diagnostic::error(message).at(entry.origin.clone()).help(help));
        (0, 0)
    };
    if depth > MAX_NESTING {
        return error(format!("texture `{}` is nested more than {MAX_NESTING} deep", entry.key), "mix fewer textures");
    }
    if count > MAX_PARTS {
        let message = format!("texture `{}` is made of {count} textures; at most {MAX_PARTS} are looked up", entry.key);
        return error(message, "a texture counts as often as it is used");
    }
    (depth, count)
}

/// The names that `texture` gives in a table.
fn named_by<'a>(value: &'a Value, names: &mut Vec<&'a str>) {
    match &value.data {
        Data::Table(entries) => {
            for entry in entries {
                match &entry.value.data {
                    Data::String(name) if entry.key == "texture" => names.push(name),
                    _ => named_by(&entry.value, names),
                }
            }
        }
        Data::Array(values) => values.iter().for_each(|value| named_by(value, names)),
        _ => {}
    }
}

/// Says which textures go round in circles: those that still wait for others.
fn report_circles(cx: &Context, entries: &[(&Entry, Item)], parts: &[Vec<usize>], waiting: &[usize]) {
    let mut seen = vec![false; entries.len()];
    for start in (0..entries.len()).filter(|i| waiting[*i] > 0) {
        let (mut path, mut at) = (Vec::new(), start);
        while !seen[at] {
            seen[at] = true;
            path.push(at);
            // One that waits has a part that waits.
            let Some(&part) = parts[at].iter().find(|part| waiting[**part] > 0) else { break };
            at = part;
        }
        // Otherwise it leads to a circle that has been reported.
        let Some(first) = path.iter().position(|index| *index == at) else { continue };
        let circle: Vec<&str> = path[first..].iter().chain([&at]).map(|i| entries[*i].0.key.as_str()).collect();
        let shown =
            if circle.len() > 10 { [&circle[..5], &["..."], &circle[circle.len() - 4..]].concat() } else { circle };
        let error = Diagnostic::error(format!("textures are made of each other: {}", shown.join(" -> ")));
        cx.push(error.at(entries[at].0.origin.clone()).help("a texture cannot be a part of itself"));
    }
}
