//! `[meshes.NAME]` and `[[objects]]` with their transforms.

use super::{
    animation,
    fields::{Fields, Item},
    keys, physics, simplify,
    values::Bounds,
};
use crate::{
    Diagnostic,
    description::{Located, MeshSource, ObjectRecord, ShapeRecord, Step},
    positions::localise,
    simplify::SimplifyRecord,
    value::{Data, Entry},
};
use etendue::{math::DVec3, scene::Mesh, spectrum::Spectrum};
use std::{path::PathBuf, sync::Arc};

/// Corners that a disk's polygon may have.
pub const SEGMENTS: (u32, u32) = (3, 4096);

fn located<T>(item: Item, value: T) -> Located<T> {
    Located { value, origin: item.value.origin.clone() }
}

/// A file name.
pub fn path(item: Item) -> Option<Located<PathBuf>> {
    let text = item.name_text()?;
    if text.contains('\0') {
        return item.error("a file name cannot hold a NUL character", "expected a file name");
    }
    Some(located(item, PathBuf::from(text)))
}

/// A name of something.
pub fn name(item: Item) -> Option<Located<String>> {
    item.name_text().map(|text| located(item, text.to_owned()))
}

/// What stands in for a mesh that could not be read; an error has been reported.
fn empty_mesh() -> Mesh {
    Mesh {
        origin: DVec3::ZERO,
        positions: Arc::from([]),
        indices: Arc::from([]),
        normals: None,
        uvs: None,
        colors: None,
        face_materials: None,
    }
}

/// Degrees.
fn crease_angle(fields: &Fields) -> Option<f64> {
    fields.read("crease_angle", |i: Item| i.number(Bounds::within(0.0, 180.0).above()))
}

/// The geometry of `[meshes.NAME]`, its crease angle, and how it is simplified.
pub fn mesh_source(item: Item) -> (MeshSource, Option<f64>, Option<SimplifyRecord>) {
    let empty = || MeshSource::Inline(empty_mesh());
    let Some(fields) = item.table(&keys::MESH, "[meshes.NAME]") else { return (empty(), None, None) };
    let crease_angle = crease_angle(&fields);
    let simplify = fields.read("simplify", simplify::simplify);
    fields.exclusive("normals", "crease_angle");
    for key in ["positions", "indices", "normals", "uvs", "colors"] {
        fields.exclusive("file", key);
    }
    let file = fields.read("file", path);
    let source = if fields.get("file").is_some() {
        for key in ["positions", "indices", "normals", "uvs", "colors"] {
            fields.get(key);
        }
        file.map(MeshSource::File)
    } else if fields.get("positions").is_none() && fields.get("indices").is_none() {
        fields.lacks("`file`, or `positions` and `indices`");
        for key in ["normals", "uvs", "colors"] {
            fields.get(key);
        }
        None
    } else {
        inline_mesh(&fields).map(MeshSource::Inline)
    };
    fields.finish();
    (source.unwrap_or_else(empty), crease_angle, simplify)
}

fn inline_mesh(fields: &Fields) -> Option<Mesh> {
    let positions: Option<Vec<[f64; 3]>> = fields.need("positions", |i| rows(i, Bounds::COORDINATE));
    let indices = fields.need("indices", |i| faces(i, positions.as_ref().map(Vec::len)));
    let count = positions.as_ref().map(Vec::len);
    let normals: Option<Vec<[f64; 3]>> =
        fields.read("normals", |i| per_vertex(i, rows(i, Bounds::within(-1e3, 1e3))?, count));
    let uvs: Option<Vec<[f64; 2]>> = fields.read("uvs", |i| per_vertex(i, rows(i, Bounds::within(-1e6, 1e6))?, count));
    let colors = fields.read("colors", |i| per_vertex(i, vertex_colors(i)?, count));
    let (origin, positions) = localise(positions?.iter().map(|p| DVec3::from_array(*p)));
    let unit = |n: [f64; 3]| DVec3::from_array(n).normalize_or_zero().as_vec3().to_array();
    let normals: Option<Arc<[_]>> = normals.map(|n| n.into_iter().map(unit).collect());
    if let Some(at) = normals.as_ref().and_then(|n| n.iter().position(|n| *n == [0.0; 3])) {
        fields.read("normals", |i| i.error::<()>(format!("normal {at} is zero"), "expected directions"));
    }
    Some(Mesh {
        origin,
        positions,
        indices: indices?.into(),
        normals,
        uvs: uvs.map(|uvs| uvs.into_iter().map(|uv| uv.map(|c| c as f32)).collect()),
        colors: colors.map(Into::into),
        face_materials: None,
    })
}

/// An array of colours, opaque.
fn vertex_colors(item: Item) -> Option<Vec<[f32; 4]>> {
    let items = item.array("an array of colours")?;
    items.map(|item| item.colour(Bounds::UNIT).map(|Spectrum([r, g, b])| [r, g, b, 1.0])).collect()
}

/// An array of rows of `N` numbers. Reports the first few bad rows.
fn rows<const N: usize>(item: Item, bounds: Bounds) -> Option<Vec<[f64; N]>> {
    let expected = format!("an array of arrays of {N} numbers");
    let items = item.array(&expected)?;
    let mut rows = Vec::with_capacity(items.len());
    let mut bad = 0;
    for row in items {
        match row.numbers(bounds) {
            Some(row) => rows.push(row),
            None => bad += 1,
        }
        if bad > 10 {
            break;
        }
    }
    (bad == 0).then_some(rows)
}

fn per_vertex<T>(item: Item, rows: Vec<T>, vertices: Option<usize>) -> Option<Vec<T>> {
    match vertices {
        Some(count) if count != rows.len() => {
            let message = format!("`{}` has {} entries, `positions` has {count}", item.name, rows.len());
            item.error(message, "expected one for each vertex")
        }
        _ => Some(rows),
    }
}

/// Triangles and quadrilaterals; the latter are cut from their first corner to the third.
fn faces(item: Item, vertices: Option<usize>) -> Option<Vec<[u32; 3]>> {
    const EXPECTED: &str = "an array of arrays of 3 or 4 vertex indices";
    let highest = vertices.map_or(i64::from(u32::MAX), |count| count as i64 - 1);
    let items = item.array(EXPECTED)?;
    let mut triangles = Vec::with_capacity(items.len());
    let mut bad = 0;
    for face in items {
        match corners(face, EXPECTED, highest).as_deref() {
            Some(&[a, b, c]) => triangles.push([a, b, c]),
            Some(&[a, b, c, d]) => triangles.extend([[a, b, c], [a, c, d]]),
            _ => bad += 1,
        }
        if bad > 10 {
            break;
        }
    }
    (bad == 0).then_some(triangles)
}

fn corners(face: Item, expected: &str, highest: i64) -> Option<Vec<u32>> {
    let corners = face.array(expected)?;
    if !matches!(corners.len(), 3 | 4) {
        return face.error(format!("a face has {} corners", corners.len()), "expected 3 or 4 vertex indices");
    }
    corners
        .map(|corner| match corner.value.data {
            Data::Integer(i) if i > highest && (0..=i64::from(u32::MAX)).contains(&i) => {
                corner.error(format!("no vertex {i}"), format!("`positions` has vertices 0 to {highest}"))
            }
            _ => corner.integer(0, u32::MAX.into()).map(|i| i as u32),
        })
        .collect::<Vec<_>>()
        .into_iter()
        .collect()
}

#[derive(Clone, Copy)]
enum Kind {
    Mesh,
    Sphere,
    Rectangle,
    Box,
    Disk,
}

const KINDS: [(&str, Kind); 5] = [
    ("mesh", Kind::Mesh),
    ("sphere", Kind::Sphere),
    ("rectangle", Kind::Rectangle),
    ("box", Kind::Box),
    ("disk", Kind::Disk),
];

/// One of `[[objects]]`.
pub fn object(item: Item) -> Option<ObjectRecord> {
    let mut fields = item.table(&keys::OBJECT, "[[objects]]")?;
    let is_mesh = fields.key_origin("mesh").is_some() || fields.key_origin("file").is_some();
    let kind = fields.variant("shape", &KINDS, is_mesh.then_some("mesh"));
    let shape = kind.and_then(|kind| shape(&fields, kind));
    fields.exclusive("material", "materials");
    let record = ObjectRecord {
        name: fields.read("name", name),
        shape: shape.unwrap_or(ShapeRecord::Sphere { center: DVec3::ZERO, radius: 1.0 }),
        material: fields.read("material", name),
        materials: match kind {
            Some(Kind::Mesh) => fields.read("materials", materials).unwrap_or_default(),
            _ => Vec::new(),
        },
        transform: fields.read("transform", transform).unwrap_or_default(),
        motion: fields.read("motion", animation::motion),
        body: fields.read("body", physics::body),
        origin: fields.origin.clone(),
    };
    fields.finish();
    Some(record)
}

/// Names of a file's materials, and what stands in their places.
fn materials(item: Item) -> Option<Vec<[Located<String>; 2]>> {
    let Data::Table(entries) = &item.value.data else {
        return item.wrong_kind_help("a table of names", "{ \"of the file\" = \"of this scene\" }");
    };
    let pair = |entry: &Entry| {
        let by = Item { cx: item.cx, name: &entry.key, value: &entry.value };
        Some([Located { value: entry.key.clone(), origin: entry.origin.clone() }, name(by)?])
    };
    Some(entries.iter().filter_map(pair).collect())
}

fn shape(fields: &Fields, kind: Kind) -> Option<ShapeRecord> {
    let length = |key| fields.read(key, |i: Item| i.number(Bounds::LENGTH));
    match kind {
        Kind::Mesh => {
            fields.exclusive("mesh", "file");
            let (mesh, file) = (fields.read("mesh", name), fields.read("file", path));
            if fields.get("mesh").is_none() && fields.get("file").is_none() {
                fields.lacks("`mesh` or `file`");
            }
            let crease_angle = crease_angle(fields);
            let simplify = fields.read("simplify", simplify::simplify);
            if fields.get("file").is_none() {
                fields.exclusive("mesh", "crease_angle");
                fields.exclusive("mesh", "simplify");
            }
            mesh.map(ShapeRecord::Mesh).or(file.map(|path| ShapeRecord::File { path, crease_angle, simplify }))
        }
        Kind::Sphere => Some(ShapeRecord::Sphere {
            center: fields.read("center", |i| i.point()).unwrap_or(DVec3::ZERO),
            radius: length("radius").unwrap_or(1.0),
        }),
        Kind::Rectangle => rectangle(fields),
        Kind::Box => cuboid(fields),
        Kind::Disk => Some(ShapeRecord::Disk {
            radius: length("radius").unwrap_or(1.0),
            segments: fields.read("segments", |i| i.integer_u32(SEGMENTS.0, SEGMENTS.1)).unwrap_or(64),
        }),
    }
}

fn rectangle(fields: &Fields) -> Option<ShapeRecord> {
    for key in ["corner", "u", "v"] {
        fields.exclusive("size", key);
    }
    let size: Option<[f64; 2]> = fields.read("size", |i| i.numbers(Bounds::LENGTH));
    let edges = ["corner", "u", "v"].map(|key| fields.get(key));
    if edges.iter().all(Option::is_none) {
        let [w, h] = if fields.get("size").is_some() { size? } else { [1.0, 1.0] };
        let (u, v) = (DVec3::X * w, DVec3::Y * h);
        return Some(ShapeRecord::Rectangle { corner: (u + v) * -0.5, u, v });
    }
    let corner = fields.need("corner", |i| i.point());
    let (u, v) = (fields.need("u", |i| i.direction()), fields.need("v", |i| i.direction()));
    let (corner, u, v) = (corner?, u?, v?);
    if u.normalize().cross(v.normalize()).length() < 1e-9 {
        fields.read("v", |i| i.error::<()>("`v` is parallel to `u`", "expected an edge across `u`"));
    }
    Some(ShapeRecord::Rectangle { corner, u, v })
}

fn cuboid(fields: &Fields) -> Option<ShapeRecord> {
    fields.exclusive("size", "min");
    fields.exclusive("size", "max");
    let size = fields.read("size", |i| i.per_axis(Bounds::LENGTH));
    if fields.get("min").is_none() && fields.get("max").is_none() {
        let size = if fields.get("size").is_some() { size? } else { DVec3::ONE };
        return Some(ShapeRecord::Box { min: size * -0.5, max: size * 0.5 });
    }
    let (min, max) = (fields.need("min", |i| i.point()), fields.need("max", |i| i.point()));
    let (min, max) = (min?, max?);
    if !min.cmplt(max).all() {
        fields.read("max", |i| i.error::<()>("`max` must be above `min` on every axis", "not above `min`"));
    }
    Some(ShapeRecord::Box { min, max })
}

/// Steps in order: an array of tables, or one table.
pub fn transform(item: Item) -> Option<Vec<Located<Step>>> {
    const HOW: &str = "[{ scale = 2 }, { translate = [1, 2, 3] }]";
    const MAX_STEPS: usize = 1000;
    if matches!(item.value.data, Data::Table(_)) {
        return step(item).map(|s| vec![s]);
    }
    let steps = item.array_help("an array of steps", HOW)?;
    if steps.len() > MAX_STEPS {
        return item.error(format!("more than {MAX_STEPS} steps"), "too many");
    }
    Some(steps.filter_map(step).collect())
}

fn step(item: Item) -> Option<Located<Step>> {
    let fields = item.table(&keys::STEP, "{ translate = [1, 2, 3] }")?;
    let steps = [
        fields.read("translate", |i| i.point()).map(Step::Translate),
        fields.read("rotate", rotate),
        fields.read("scale", scale).map(Step::Scale),
        fields.read("matrix", matrix),
        fields.read("look_at", look_at),
        fields.read("relocate", |i| i.point()).map(Step::Relocate),
    ];
    fields.finish();
    if let Data::Table(entries) = &item.value.data
        && entries.len() != 1
    {
        let message = format!("a step of `transform` has {} keys", entries.len());
        let error = Diagnostic::error(message).at(item.value.origin.clone());
        item.cx.push(error.help("write each step as a table of its own: their order matters"));
        return None;
    }
    steps.into_iter().flatten().next().map(|step| located(item, step))
}

fn scale(item: Item) -> Option<DVec3> {
    let factors = item.per_axis(Bounds::COORDINATE)?;
    if factors.abs().min_element() < 1e-12 {
        return item.error("a scale of 0 flattens the object", "expected factors other than 0");
    }
    Some(factors)
}

fn rotate(item: Item) -> Option<Step> {
    let fields = item.table(&keys::ROTATE, "{ axis = \"y\", angle = 30 }")?;
    let axis = fields.need("axis", |i| i.axis());
    let angle = fields.need("angle", |i| i.number(Bounds::within(-1e6, 1e6)));
    fields.finish();
    Some(Step::Rotate { axis: axis?, angle: angle? })
}

fn matrix(item: Item) -> Option<Step> {
    let m = item.matrix()?;
    let columns = [0, 1, 2].map(|c| DVec3::new(m[c], m[4 + c], m[8 + c]));
    let unit = columns.map(DVec3::normalize_or_zero);
    if unit[0].cross(unit[1]).dot(unit[2]).abs() < 1e-9 {
        return item.error("the matrix cannot be inverted", "it flattens the object");
    }
    Some(Step::Matrix(m))
}

fn look_at(item: Item) -> Option<Step> {
    let fields = item.table(&keys::LOOK_AT, "{ position = [1, 2, 3], target = [0, 0, 0] }")?;
    let position = fields.need("position", |i| i.point());
    let target = fields.need("target", |i| i.point());
    let up = fields.read("up", |i| i.direction()).unwrap_or(DVec3::Y);
    fields.finish();
    let (position, target) = (position?, target?);
    if (target - position).normalize_or_zero().cross(up.normalize()).length() < 1e-9 {
        return item
            .error("`target` is at `position`, or the view is parallel to `up`", "give another `up` or `target`");
    }
    Some(Step::LookAt { position, target, up })
}
